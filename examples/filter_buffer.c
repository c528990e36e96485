/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Filters a picture in memory with one call.
 *
 *     filter_buffer OUT.pfm
 */
#include <math.h>
#include <rackfocus/rackfocus.h>
#include <stdio.h>
#include <stdlib.h>

#include "pfm.h"

enum { WIDTH = 320, HEIGHT = 200 };

/* A bright disc, 2 units away, before a checkered wall at 10 units. */
static void render(float *rgb, float *depth)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            int i = y * WIDTH + x;
            bool is_disc = hypot(x - WIDTH / 2, y - HEIGHT / 2) < 40;
            float wall = (x / 10 + y / 10) % 2 ? 0.8f : 0.1f;
            rgb[3 * i] = is_disc ? 0.9f : wall;
            rgb[3 * i + 1] = is_disc ? 0.5f : wall;
            rgb[3 * i + 2] = is_disc ? 0.2f : wall;
            depth[i] = is_disc ? 2 : 10;
        }
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: filter_buffer OUT.pfm\n");
        return 2;
    }
    float *rgb = malloc(3 * WIDTH * HEIGHT * sizeof *rgb);
    float *depth = malloc(WIDTH * HEIGHT * sizeof *depth);
    if (!rgb || !depth) {
        fprintf(stderr, "out of memory\n");
        return 1;
    }
    render(rgb, depth);

    struct rf_params params;
    rf_params_init(&params);
    params.focus_distance = 2; /* scene units: metres, unless unit_scale says else */
    params.f_stop = 1.4;
    params.focal_length = 50; /* mm */
    params.blades = 6;

    struct rf_image colour = rf_image_packed(rgb, WIDTH, HEIGHT, 3);
    struct rf_image z = rf_image_packed(depth, WIDTH, HEIGHT, 1);
    struct rf_error error;
    /* The result may go where the picture was. */
    if (rf_apply(&params, &colour, &z, &colour, &error) != RF_OK) {
        fprintf(stderr, "%s: %s\n", error.field, error.message);
        return 1;
    }
    bool is_written = write_pfm(argv[1], rgb, WIDTH, HEIGHT);
    if (!is_written)
        perror(argv[1]);
    free(depth);
    free(rgb);
    return is_written ? 0 : 1;
}
