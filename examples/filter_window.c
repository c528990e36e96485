/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Filters a window of a picture that need not fit into memory: only what the window
 * depends on is ever loaded, and the pixels have the same bits as in the whole picture.
 *
 *     filter_window OUT.pfm WIDTH HEIGHT X Y W H
 *
 * The picture of WIDTH x HEIGHT px is made up where it is asked for; a program would
 * read it from a file. W x H px of it from (X, Y) on are filtered.
 */
#include <rackfocus/rackfocus.h>
#include <stdio.h>
#include <stdlib.h>

#include "pfm.h"

enum { STRIP = 256 }; /* rows that are surveyed at a time */

struct picture {
    int width, height;
};

/* A part of a picture in memory. */
struct part {
    struct rf_window window;
    float *rgb, *depth;
    struct rf_view view;
};

/* Loads a window: bars before a striped wall. False: out of memory. */
static bool load(struct part *part, struct rf_window window)
{
    size_t n = (size_t)window.width * (size_t)window.height;
    *part = (struct part){.window = window,
                          .rgb = malloc(3 * n * sizeof(float)),
                          .depth = malloc(n * sizeof(float))};
    if (!part->rgb || !part->depth)
        return false;
    for (size_t i = 0; i < n; i++) {
        int x = window.x + (int)(i % (size_t)window.width);
        int y = window.y + (int)(i / (size_t)window.width);
        bool is_bar = x % 96 < 8;
        part->depth[i] = is_bar ? 2 : 10;
        for (int c = 0; c < 3; c++)
            part->rgb[3 * i + (size_t)c] = is_bar      ? 0.3f * (float)c
                                           : y / 7 % 2 ? 0.7f
                                                       : 0.1f;
    }
    part->view = (struct rf_view){
        .size = sizeof part->view,
        .colour = rf_image_packed(part->rgb, window.width, window.height, 3),
        .depth = rf_image_packed(part->depth, window.width, window.height, 1)};
    return true;
}

static void drop(struct part *part)
{
    free(part->depth);
    free(part->rgb);
}

/* Where a strip's rows and `margin` more lie within the picture. */
static struct rf_window rows(const struct picture *p, int from, int to, int margin)
{
    from = from - margin < 0 ? 0 : from - margin;
    to = to + margin > p->height ? p->height : to + margin;
    return (struct rf_window){0, from, p->width, to - from};
}

/* Counts every pixel of the picture once: what windows must know of the whole. */
static bool survey_all(const struct rf_filter *filter, const struct picture *p,
                       struct rf_survey *survey, struct rf_error *error)
{
    *survey = (struct rf_survey){.size = sizeof *survey};
    for (int y = 0; y < p->height; y += STRIP) {
        int end = y + STRIP < p->height ? y + STRIP : p->height;
        struct rf_window counted = rows(p, y, end, 0);
        struct part part;
        bool is_good = load(&part, rows(p, y, end, RF_SURVEY_MARGIN)) &&
                       rf_filter_survey(filter, &part.view, &part.window, &counted,
                                        survey, error) == RF_OK;
        drop(&part);
        if (!is_good)
            return false;
    }
    return true;
}

/* Filters `kept` into `out`. */
static bool filter_window(const struct rf_filter *filter, const struct picture *p,
                          const struct rf_window *kept, float *out,
                          struct rf_error *error)
{
    struct rf_survey survey;
    struct rf_window given;
    struct part part = {.rgb = NULL};
    if (!survey_all(filter, p, &survey, error) ||
        rf_filter_window(filter, &survey, 1, kept, &given, error) != RF_OK)
        return false;
    printf("%d x %d px of %d x %d are loaded, %zu MiB are worked with\n", given.width,
           given.height, p->width, p->height,
           rf_window_bytes(filter, &survey, 1, &given) >> 20);
    struct rf_image to = rf_image_packed(out, kept->width, kept->height, 3);
    bool is_good = load(&part, given) &&
                   rf_filter_process_window(filter, &survey, &part.view, 1, &given,
                                            kept, &to, NULL, error) == RF_OK;
    drop(&part);
    return is_good;
}

int main(int argc, char **argv)
{
    if (argc != 8) {
        fprintf(stderr, "usage: filter_window OUT.pfm WIDTH HEIGHT X Y W H\n");
        return 2;
    }
    struct picture picture = {atoi(argv[2]), atoi(argv[3])};
    struct rf_window kept = {atoi(argv[4]), atoi(argv[5]), atoi(argv[6]),
                             atoi(argv[7])};
    struct rf_params params;
    rf_params_init(&params);
    params.focus_distance = 4;
    params.lens_radius = 0.01; /* scene units */
    params.focal_length_px = 3000;

    struct rf_context *context = NULL;
    struct rf_filter *filter = NULL;
    struct rf_error error = {.message = "out of memory"};
    float *out = calloc((size_t)kept.width * (size_t)kept.height, 3 * sizeof *out);
    bool is_good = out && rf_context_create(&context, NULL, &error) == RF_OK &&
                   rf_filter_create(&filter, context, &params, picture.width,
                                    picture.height, &error) == RF_OK &&
                   filter_window(filter, &picture, &kept, out, &error);
    if (!is_good)
        fprintf(stderr, "%s: %s\n", error.field, error.message);
    else if (!(is_good = write_pfm(argv[1], out, kept.width, kept.height)))
        perror(argv[1]);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    free(out);
    return is_good ? 0 : 1;
}
