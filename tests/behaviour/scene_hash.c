/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prints one line per picture: what it is and a hash of its bits. Builds that print the
 * same lines made the same pictures. Arguments: number of threads, CPU level.
 */
#include <stdio.h>

#include "physics/frames.h"

struct picture {
    int width, height, channels;
    double r_px;
    const char *settings[4][2];
};

static const struct picture pictures[] = {
    {96, 64, 3, 3, {{NULL}}},
    {96, 64, 4, 9, {{"blades", "6"}, {"blade-rotation", "15"}}},
    {64, 96, 3, 14, {{"sub-apertures", "1"}, {"aperture-ratio", "1.5"}}},
    {50, 50, 1, 6, {{"blend-gamma", "2.2"}, {"split-edges", "0"}}},
    {80, 60, 3, 7, {{"fill-hidden", "0"}, {"exact-highlights", "0"}}},
    {70, 45, 3, 0.8, {{"optics", "lens"}, {"pixel-aspect", "1.5"}}},
    {64, 48, 3, 5, {{"depth", "radial"}, {"blades", "5"}}},
    {96, 64, 3, 9, {{"cat-eye", "0.8"}, {"swirl", "0.3"}, {"barn-top", "1"}}},
};

static int print_hash(const struct picture *picture, int method,
                      const struct rf_context_params *run)
{
    struct frame f = frame_make(picture->width, picture->height, picture->channels);
    struct rf_params params;
    struct rf_error error = {0};
    scene_params(&params, method);
    for (int i = 0; i < 4 && picture->settings[i][0]; i++)
        rf_params_set(&params, picture->settings[i][0], picture->settings[i][1],
                      &error);
    frame_fill_scene(&f, picture->r_px);
    if (error.code == RF_OK)
        frame_filter_by(&f, &params, run, &error);
    if (error.code != RF_OK)
        fprintf(stderr, "%s: %s\n", error.field, error.message);
    printf("method %d picture %dx%dx%d radius %g: %016llx\n", method, f.width, f.height,
           f.channels, picture->r_px,
           (unsigned long long)hash_bytes(0, f.out, frame_bytes(&f)));
    frame_free(&f);
    return error.code != RF_OK;
}

int main(int argc, char **argv)
{
    struct rf_context_params run = {.size = sizeof run,
                                    .n_threads = argc > 1 ? atoi(argv[1]) : 2,
                                    .cpu = argc > 2 ? argv[2] : NULL};
    int n_failed = 0;
    size_t n_methods;
    rf_method_list(&n_methods);
    for (size_t m = 0; m < n_methods; m++)
        for (size_t i = 0; i < sizeof pictures / sizeof pictures[0]; i++)
            n_failed += print_hash(&pictures[i], (int)m, &run);
    return n_failed != 0;
}
