/* SPDX-License-Identifier: Apache-2.0 */
#include "depth_stats.h"

#include <math.h>
#include <stdlib.h>

#include "report.h"

struct map {
    const float *depth;
    int32_t width, height;
    double infinity;
};

static bool is_hit(const struct map *map, float z)
{
    return isfinite(z) && z >= 0 && z < map->infinity;
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Keeps every step-th pixel that was hit. */
static void keep_hits(const struct map *map, struct depth_tally *tally)
{
    const size_t n = (size_t)map->width * (size_t)map->height;
    size_t i = (tally->step - tally->n_seen % tally->step) % tally->step;
    for (; i < n; i += tally->step)
        if (is_hit(map, map->depth[i]))
            tally->hits[tally->n_hits++] = map->depth[i];
    tally->n_seen += n;
}

/* Median of the hits; `is_inner` leaves out 0 and 1, which buffers have where nothing
 * was hit. NAN where there are none. */
static double median_of(const float *sorted, size_t n, bool is_inner)
{
    size_t first = 0;
    for (size_t i = 0; is_inner && i < n && sorted[i] <= 0; i++)
        first = i + 1;
    size_t n_one = 0, end = n;
    while (is_inner && end > first && sorted[end - 1] > 1)
        end--;
    for (size_t i = end; is_inner && i > first && sorted[i - 1] == 1; i--)
        n_one++;
    const size_t n_left = n - first - n_one;
    if (!n_left)
        return NAN;
    size_t at = first + n_left / 2;
    at += at >= end - n_one ? n_one : 0;
    return sorted[at];
}

static void count_values(const struct map *map, struct depth_stats *stats)
{
    const size_t n = (size_t)map->width * (size_t)map->height;
    for (size_t i = 0; i < n; i++) {
        const float z = map->depth[i];
        stats->n_nan += isnan(z);
        stats->n_negative += z < 0;
        stats->n_no_hit += z >= map->infinity;
        stats->n_zero += z == 0;
        stats->n_one += z == 1;
        if (!is_hit(map, z))
            continue;
        stats->min = fmin(stats->min, z);
        stats->max = fmax(stats->max, z);
    }
}

bool depth_find_step(double a, double beyond_a, double b, double beyond_b,
                     double infinity, struct depth_step *step)
{
    const bool is_a_low = a < b;
    const double slope_a = fabs(a - beyond_a);
    const double slope_b = fabs(b - beyond_b);
    const double slope_low = is_a_low ? slope_a : slope_b;
    const double slope_high = is_a_low ? slope_b : slope_a;
    step->low = is_a_low ? a : b;
    step->high = is_a_low ? b : a;
    const double height = step->high - step->low;
    /* A height of 1e10 makes all else look flat. */
    return step->low >= 0 && step->low < infinity && isfinite(step->high) &&
           step->high >= DEPTH_STEP_RATIO * step->low && height > 0 &&
           slope_high < 0.05 * height &&
           slope_low < fmin(0.05 * height, 0.1 * step->low + 1e-30);
}

/* Does a pixel from `first` to before `end` lie well between both sides? */
static bool is_mixed_between(const float *row, int32_t first, int32_t end,
                             const struct depth_step *step)
{
    for (int32_t x = first; x < end; x++) {
        const double place = (row[x] - step->low) / (step->high - step->low);
        if (place > 0.1 && place < 0.9)
            return true;
    }
    return false;
}

/* Counts the step that begins at the end of a flat side, if there is one. */
static void count_step(const struct map *map, const float *row, int32_t x,
                       struct depth_tally *tally)
{
    const int32_t most = x + DEPTH_STEP_PIXELS + 1;
    for (int32_t end = x + 1; end <= most && end + 1 < map->width; end++) {
        struct depth_step step;
        if (!depth_find_step(row[x], row[x - 1], row[end], row[end + 1], map->infinity,
                             &step) ||
            !(fabs(row[x + 1] - row[x]) >= 0.05 * (step.high - step.low)))
            continue;
        tally->n_steps++;
        tally->n_mixed += is_mixed_between(row, x + 1, end, &step);
        return;
    }
}

/*
 * Pixels between two flat sides have one of their depths, unless depths were averaged,
 * as anti-aliasing does.
 */
static void count_mixed(const struct map *map, struct depth_tally *tally)
{
    for (int32_t y = 0; y < map->height; y++)
        for (int32_t x = 1; x + 2 < map->width; x++)
            count_step(map, map->depth + (size_t)y * (size_t)map->width, x, tally);
}

/* Next to a fully covered pixel, depth times alpha is alpha times that pixel's depth.
 */
static void count_premultiplied(const struct map *map, const float *alpha,
                                size_t stride, struct depth_tally *tally)
{
    for (int32_t y = 0; y < map->height; y++) {
        for (int32_t x = 1; x + 1 < map->width; x++) {
            const size_t i = (size_t)y * (size_t)map->width + (size_t)x;
            const double a = alpha[i * stride];
            const size_t solid = alpha[(i - 1) * stride] >= 0.999f ? i - 1 : i + 1;
            const double z = map->depth[i], near = map->depth[solid];
            if (a < 0.1 || a > 0.9 || alpha[solid * stride] < 0.999f ||
                !is_hit(map, map->depth[solid]) || near <= 0)
                continue;
            tally->n_part++;
            tally->n_scaled += fabs(z - a * near) < 0.05 * near;
        }
    }
}

/* Of at least 20, so that chance does not decide. */
static double share_of(size_t n_part, size_t n)
{
    return n >= 20 ? (double)n_part / (double)n : 0;
}

bool depth_tally_begin(struct depth_tally *tally, int32_t width, int32_t height,
                       double depth_infinity)
{
    const size_t n = (size_t)width * (size_t)height;
    *tally = (struct depth_tally){
        .stats = {.n_pixels = n, .min = INFINITY, .max = -INFINITY},
        .width = width,
        .infinity = depth_infinity,
        .step = n / 100000 + 1,
    };
    tally->hits = app_memory(n / tally->step + 1, sizeof(*tally->hits), NULL);
    return tally->hits != NULL;
}

void depth_tally_add(struct depth_tally *tally, const float *depth, const float *alpha,
                     size_t alpha_stride, int32_t n_rows)
{
    const struct map map = {depth, tally->width, n_rows, tally->infinity};
    count_values(&map, &tally->stats);
    keep_hits(&map, tally);
    count_mixed(&map, tally);
    if (alpha)
        count_premultiplied(&map, alpha, alpha_stride, tally);
}

void depth_tally_end(struct depth_tally *tally, struct depth_stats *stats)
{
    qsort(tally->hits, tally->n_hits, sizeof(*tally->hits), compare_floats);
    *stats = tally->stats;
    stats->median = median_of(tally->hits, tally->n_hits, false);
    stats->inner_median = median_of(tally->hits, tally->n_hits, true);
    stats->mixed_share = share_of(tally->n_mixed, tally->n_steps);
    stats->premultiplied_share = share_of(tally->n_scaled, tally->n_part);
    free(tally->hits);
    tally->hits = NULL;
}

bool depth_stats_measure(const float *depth, const float *alpha, size_t alpha_stride,
                         int32_t width, int32_t height, double depth_infinity,
                         struct depth_stats *stats)
{
    struct depth_tally tally;
    if (!depth_tally_begin(&tally, width, height, depth_infinity))
        return false;
    depth_tally_add(&tally, depth, alpha, alpha_stride, height);
    depth_tally_end(&tally, stats);
    return true;
}

const char *depth_stats_guess(const struct depth_stats *stats, const char **reason)
{
    const size_t n_without =
        stats->n_nan + stats->n_negative + stats->n_no_hit + stats->n_zero;
    if (n_without >= stats->n_pixels) {
        *reason = "no pixel has a distance";
        return "planar";
    }
    if (stats->max > 1) {
        if (stats->n_zero > 0 && stats->n_no_hit == 0) {
            *reason = "0 where nothing was hit, as inverse depth has it";
            return "inverse";
        }
        *reason = "values above 1 are distances in scene units; radial looks alike";
        return "planar";
    }
    if (stats->n_no_hit > 0) {
        *reason = "all below 1, but infinity where nothing was hit: a small scene";
        return "planar";
    }
    if (stats->inner_median > 0.9) {
        *reason = "within 0 to 1 and crowded near 1, as a depth buffer is";
        return "buffer";
    }
    if (stats->inner_median < 0.1 && stats->n_zero > 0) {
        *reason = "within 0 to 1 and crowded near 0, as a reversed depth buffer is";
        return "buffer-reversed";
    }
    if (stats->n_zero > 0 || stats->n_one > 0) {
        *reason = "within 0 to 1 and reaching an end of it";
        return "normalised";
    }
    *reason = "all below 1, but not reaching 0 or 1: a small scene; normalised is "
              "possible";
    return "planar";
}

bool depth_stats_is_mixed(const struct depth_stats *stats)
{
    return stats->mixed_share > 0.25;
}

bool depth_stats_is_premultiplied(const struct depth_stats *stats)
{
    return stats->premultiplied_share > 0.5;
}
