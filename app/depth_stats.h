/* SPDX-License-Identifier: Apache-2.0 */
/* What a depth channel looks like, for people who do not know its convention. */
#ifndef APP_DEPTH_STATS_H
#define APP_DEPTH_STATS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A step: two flat sides whose depths differ by this factor, and at most so many pixels
 * between them. Pixel filters of renderers are up to 4 px wide. */
#define DEPTH_STEP_RATIO 1.3
enum { DEPTH_STEP_PIXELS = 6 };

struct depth_step {
    double low, high; /* depths of the sides */
    int32_t n, n_low; /* px from the one to the other, and from the pixel to `low` */
};

/* Do `a` and `b` end the sides of a step, with `beyond_a` and `beyond_b` the next
 * pixels of these sides? Fills `low` and `high`. */
bool depth_find_step(double a, double beyond_a, double b, double beyond_b,
                     double infinity, struct depth_step *step);

struct depth_stats {
    size_t n_pixels;
    size_t n_nan, n_negative;
    size_t n_no_hit;         /* infinite, or from depth_infinity on */
    size_t n_zero, n_one;    /* exactly 0 and exactly 1 */
    double min, max, median; /* of what is finite, not negative and below infinity */
    double inner_median;     /* the same without exact 0 and 1 */
    double mixed_share; /* of the pixels at depth steps, those between both sides */
    double premultiplied_share; /* of the part-covered pixels, those scaled by alpha */
};

/* `alpha` has `alpha_stride` floats from pixel to pixel; may be NULL. False without
 * memory. */
bool depth_stats_measure(const float *depth, const float *alpha, size_t alpha_stride,
                         int32_t width, int32_t height, double depth_infinity,
                         struct depth_stats *stats);

/* The same of a picture that comes in strips from the top; only the beginning can fail.
 */
struct depth_tally {
    struct depth_stats stats;
    int32_t width;
    double infinity;
    size_t step, n_seen; /* of the pixels, those that the medians are taken of */
    float *hits;
    size_t n_hits, n_steps, n_mixed, n_part, n_scaled;
};

bool depth_tally_begin(struct depth_tally *tally, int32_t width, int32_t height,
                       double depth_infinity);
void depth_tally_add(struct depth_tally *tally, const float *depth, const float *alpha,
                     size_t alpha_stride, int32_t n_rows);
/* Frees the tally's memory. */
void depth_tally_end(struct depth_tally *tally, struct depth_stats *stats);

/* Name of --depth that fits best, and the reason as half a sentence. */
const char *depth_stats_guess(const struct depth_stats *stats, const char **reason);

bool depth_stats_is_mixed(const struct depth_stats *stats);
bool depth_stats_is_premultiplied(const struct depth_stats *stats);

#endif
