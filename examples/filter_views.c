/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Filters several views from points of the lens: what is hidden from the middle of the
 * lens is seen from its rim.
 *
 *     filter_views OUT.pfm [VIEWS]
 */
#include <math.h>
#include <rackfocus/rackfocus.h>
#include <stdio.h>
#include <stdlib.h>

#include "pfm.h"

enum { WIDTH = 320, HEIGHT = 200, MOST_VIEWS = 16 };

static const double NEAR = 1, FAR = 4; /* scene units; the wall is in focus */

struct views {
    int n;
    struct rf_view at[MOST_VIEWS];
    float *memory;
};

/*
 * Renders the view from point (u, v) of the lens, in lens radii right and up, sheared
 * so that the plane in focus stays where it is: what is blurred by r px then lies u r
 * to the right and v r up of where the middle of the lens sees it.
 */
static void render(const struct rf_lens *lens, double u, double v, float *rgb,
                   float *depth)
{
    double r = rf_lens_radius_px(lens, NEAR);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            int i = y * WIDTH + x;
            double dx = x - WIDTH / 2 - u * r, dy = y - HEIGHT / 2 + v * r;
            bool is_disc = hypot(dx, dy) < 30;
            for (int c = 0; c < 3; c++)
                rgb[3 * i + c] = is_disc                    ? 0.4f * (float)c
                                 : (x / 5 + y / 5) % 2 == 0 ? 0.8f
                                                            : 0.1f;
            depth[i] = (float)(is_disc ? NEAR : FAR);
        }
}

static bool render_views(struct views *views, const struct rf_params *params,
                         const struct rf_lens *lens, struct rf_error *error)
{
    struct rf_lens_point points[MOST_VIEWS];
    size_t n_pixels = WIDTH * HEIGHT;
    views->memory = malloc((size_t)views->n * n_pixels * 4 * sizeof(float));
    if (!views->memory || rf_lens_points(params, views->n, 0, points, error) != RF_OK)
        return false;
    for (int i = 0; i < views->n; i++) {
        float *rgb = views->memory + (size_t)i * n_pixels * 4;
        float *depth = rgb + 3 * n_pixels;
        render(lens, points[i].u, points[i].v, rgb, depth);
        views->at[i] =
            (struct rf_view){.size = sizeof *views->at,
                             .colour = rf_image_packed(rgb, WIDTH, HEIGHT, 3),
                             .depth = rf_image_packed(depth, WIDTH, HEIGHT, 1),
                             .lens_offset = {points[i].u * lens->lens_radius,
                                             points[i].v * lens->lens_radius},
                             .shear_distance = lens->focus_distance};
    }
    return true;
}

/* Returning false would cancel. */
static bool report(void *user, double fraction)
{
    fprintf(user, "\r%3.0f %%", 100 * fraction);
    return true;
}

/* Merges the views into the first one's pixels. */
static bool merge(const struct rf_params *params, struct views *views,
                  struct rf_error *error)
{
    struct rf_context *context = NULL;
    struct rf_filter *filter = NULL;
    struct rf_progress progress = {report, stderr};
    bool is_good =
        rf_context_create(&context, NULL, error) == RF_OK &&
        rf_filter_create(&filter, context, params, WIDTH, HEIGHT, error) == RF_OK &&
        render_views(views, params, rf_filter_lens(filter), error) &&
        rf_filter_process(filter, views->at, views->n, &views->at[0].colour, &progress,
                          error) == RF_OK;
    fprintf(stderr, "\n");
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return is_good;
}

int main(int argc, char **argv)
{
    struct views views = {.n = argc > 2 ? atoi(argv[2]) : 8};
    if (argc < 2 || views.n < 2 || views.n > MOST_VIEWS) {
        fprintf(stderr, "usage: filter_views OUT.pfm [VIEWS, 2 to %d]\n", MOST_VIEWS);
        return 2;
    }
    struct rf_params params;
    rf_params_init(&params);
    params.method = RF_METHOD_VIEWS;
    params.focus_distance = FAR;
    params.lens_radius = 0.04;
    params.focal_length_px = 400;

    struct rf_error error = {.message = "out of memory"};
    bool is_good = merge(&params, &views, &error);
    if (!is_good)
        fprintf(stderr, "%s: %s\n", error.field, error.message);
    else if (!(is_good = write_pfm(argv[1], views.memory, WIDTH, HEIGHT)))
        perror(argv[1]);
    free(views.memory);
    return is_good ? 0 : 1;
}
