/* SPDX-License-Identifier: Apache-2.0 */
/* The grain of several views of one frame, taken out of all of them together. */
#ifndef APP_DENOISE_VIEWS_H
#define APP_DENOISE_VIEWS_H

#include <stdbool.h>

#include "denoise/denoise_share.h"
#include "rackfocus/rackfocus.h"

struct image_error;

struct denoise_views {
    struct share share;                            /* after share_open() */
    const char *const *names;                      /* of each view, for errors */
    bool (*progress)(void *user, double fraction); /* false: stop; may be NULL */
    void *user;
    double n_shared;    /* result: views that show a pixel the same, on average */
    bool have_one_seed; /* result: denoise_have_one_seed() */
};

/*
 * Px that points at the depths of a view of the filter move as the eye does, as of
 * struct share_view. Where that is not known, NaN, false and the core's error, which may
 * be NULL.
 */
bool denoise_find_shifts(const struct rf_filter *filter, const struct rf_view *view,
                         float *shift, struct rf_error *error);

/*
 * Writes the views without grain to `made`, packed. Where all have an albedo, the views
 * share albedo and normals (denoise_share.c), which are cleaned, and each is denoised by
 * them. What the denoiser left of each view's light, grain and its own mistakes, is then
 * shared too: less the grain the more views show a pixel, it is added and denoised
 * again (Tukey's twicing, 1977, over views). Without albedos each view is
 * denoised twice: its own samples, which keep what other views do not show, and those
 * that the views share, which have the grain of all of them. An enum app_code.
 */
int denoise_views(struct denoiser *denoiser, struct denoise_views *views,
                  float *const *made, struct image_error *error);

#endif
