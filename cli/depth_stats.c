/* SPDX-License-Identifier: Apache-2.0 */
#include "depth_stats.h"

#include <math.h>
#include <stdlib.h>

#include "cli.h"

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

/* Median of the hits, from at most about a hundred thousand of them; `is_inner` leaves
 * out 0 and 1, which buffers have where nothing was hit. NAN where there are none. */
static double median_of(const struct map *map, size_t n_pixels, bool is_inner)
{
    const size_t step = n_pixels / 100000 + 1;
    float *hits = need_memory(n_pixels / step + 1, sizeof(*hits));
    size_t n = 0;
    for (size_t i = 0; i < n_pixels; i += step)
        if (is_hit(map, map->depth[i]) &&
            !(is_inner && (map->depth[i] == 0 || map->depth[i] == 1)))
            hits[n++] = map->depth[i];
    qsort(hits, n, sizeof(*hits), compare_floats);
    const double median = n ? hits[n / 2] : NAN;
    free(hits);
    return median;
}

static void count_values(const struct map *map, struct depth_stats *stats)
{
    stats->min = INFINITY;
    stats->max = -INFINITY;
    for (size_t i = 0; i < stats->n_pixels; i++) {
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

/*
 * A pixel between two that lie on different surfaces has one of their depths, unless
 * depths were averaged, as anti-aliasing does.
 */
static double mixed_share(const struct map *map)
{
    size_t n_steps = 0, n_mixed = 0;
    for (int32_t y = 0; y < map->height; y++) {
        const float *row = map->depth + (size_t)y * (size_t)map->width;
        for (int32_t x = 2; x + 2 < map->width; x++) {
            /* Both sides must be flat, or a slope would look like a mixture. */
            const double near = fmin(row[x - 1], row[x + 1]);
            const double far = fmax(row[x - 1], row[x + 1]);
            const double flat =
                fmax(fabs(row[x - 1] - row[x - 2]), fabs(row[x + 1] - row[x + 2]));
            if (!is_hit(map, row[x - 1]) || !is_hit(map, row[x + 1]) ||
                !is_hit(map, row[x]) || far < DEPTH_STEP_RATIO * near ||
                !(flat < 0.05 * (far - near)))
                continue;
            const double place = (row[x] - near) / (far - near);
            n_steps++;
            n_mixed += place > 0.1 && place < 0.9;
        }
    }
    return n_steps >= 20 ? (double)n_mixed / (double)n_steps : 0;
}

/* Next to a fully covered pixel, depth times alpha is alpha times that pixel's depth.
 */
static double premultiplied_share(const struct map *map, const float *alpha,
                                  size_t stride)
{
    size_t n_part = 0, n_scaled = 0;
    for (int32_t y = 0; y < map->height; y++) {
        for (int32_t x = 1; x + 1 < map->width; x++) {
            const size_t i = (size_t)y * (size_t)map->width + (size_t)x;
            const double a = alpha[i * stride];
            const size_t solid = alpha[(i - 1) * stride] >= 0.999f ? i - 1 : i + 1;
            const double z = map->depth[i], near = map->depth[solid];
            if (a < 0.1 || a > 0.9 || alpha[solid * stride] < 0.999f ||
                !is_hit(map, map->depth[solid]) || near <= 0)
                continue;
            n_part++;
            n_scaled += fabs(z - a * near) < 0.05 * near;
        }
    }
    return n_part >= 20 ? (double)n_scaled / (double)n_part : 0;
}

void depth_stats_measure(const float *depth, const float *alpha, size_t alpha_stride,
                         int32_t width, int32_t height, double depth_infinity,
                         struct depth_stats *stats)
{
    const struct map map = {depth, width, height, depth_infinity};
    *stats = (struct depth_stats){.n_pixels = (size_t)width * (size_t)height};
    count_values(&map, stats);
    stats->median = median_of(&map, stats->n_pixels, false);
    stats->inner_median = median_of(&map, stats->n_pixels, true);
    stats->mixed_share = mixed_share(&map);
    if (alpha)
        stats->premultiplied_share = premultiplied_share(&map, alpha, alpha_stride);
}

const char *depth_stats_guess(const struct depth_stats *stats, const char **reason)
{
    const size_t n_bad = stats->n_nan + stats->n_negative + stats->n_no_hit;
    if (n_bad >= stats->n_pixels) {
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
