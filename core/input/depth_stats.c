/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a depth channel looks like: its kind, and what was done to it that can be undone.
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/pool.h"
#include "input/depth_edges.h"
#include "input/depth_holes.h"
#include "input/depth_steps.h"
#include "input/image.h"
#include "rackfocus/rackfocus.h"

/* Shares from which it is no chance: of steps with averages, of pixels times alpha. */
static const double MIXED_SHARE = 0.25, PREMULTIPLIED_SHARE = 0.5;

enum { MOST_HITS = 100000 }; /* pixels that the medians are taken of */

struct rf_depth_tally {
    const struct rf_context *context;
    struct rf_depth_stats stats;
    double infinity;
    size_t step, n_seen; /* of the pixels, those that the medians are taken of */
    float *hits;
    size_t n_hits, n_steps, n_mixed, n_part, n_scaled;
    struct rf_edge_sums edges;
    struct rf_hole_count *holes;
};

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
static void keep_hits(const struct map *map, struct rf_depth_tally *tally)
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

/* Rows one by one, whose counts fit into 32 bits: loops that compilers vectorise. */
static void count_row(const float *row, int32_t width, float infinity,
                      struct rf_depth_stats *stats)
{
    uint32_t n_nan = 0, n_negative = 0, n_no_hit = 0, n_zero = 0, n_one = 0;
    float least = INFINITY, most = -INFINITY;
    for (int32_t x = 0; x < width; x++) {
        const float z = row[x];
        n_nan += z != z;
        n_negative += z < 0;
        n_no_hit += z >= infinity;
        n_zero += z == 0;
        n_one += z == 1;
        const bool is_hit = z >= 0 && z < infinity && z < INFINITY;
        const float low = is_hit ? z : INFINITY, high = is_hit ? z : -INFINITY;
        least = low < least ? low : least;
        most = high > most ? high : most;
    }
    stats->n_nan += n_nan;
    stats->n_negative += n_negative;
    stats->n_no_hit += n_no_hit;
    stats->n_zero += n_zero;
    stats->n_one += n_one;
    stats->min = fmin(stats->min, (double)least);
    stats->max = fmax(stats->max, (double)most);
}

/* The float z is at or beyond `infinity` if it is so of the least float that is. */
static float round_up(double infinity)
{
    const float rounded = (float)infinity;
    return rounded < infinity ? nextafterf(rounded, INFINITY) : rounded;
}

static void count_values(const struct map *map, struct rf_depth_stats *stats)
{
    const float infinity = round_up(map->infinity);
    for (int32_t y = 0; y < map->height; y++)
        count_row(map->depth + (size_t)y * (size_t)map->width, map->width, infinity,
                  stats);
}

/* Does a pixel from `first` to before `end` lie well between both sides? */
static bool is_mixed_between(const float *row, int32_t first, int32_t end,
                             const struct rf_depth_step *step)
{
    for (int32_t x = first; x < end; x++) {
        const double place = (row[x] - step->low) / (step->high - step->low);
        if (place > 0.1 && place < 0.9)
            return true;
    }
    return false;
}

/* Of the depth, a little less than 0.05 (1 - 1 / RF_DEPTH_STEP_RATIO): see below. */
static const float LEAST_BEGIN = (float)(0.0499 * (1 - 1 / RF_DEPTH_STEP_RATIO));

/* Counts the step that begins at the end of a flat side, if there is one. */
static void count_step(const struct map *map, const float *row, int32_t x,
                       struct rf_depth_tally *tally)
{
    const int32_t most = x + RF_DEPTH_STEP_PIXELS + 1;
    /* A step is a 20th of its height from here to the next pixel at least, and its
     * height (1 - 1 / ratio) of what is high: nearly all pixels end here. */
    if (!(fabsf(row[x + 1] - row[x]) >= LEAST_BEGIN * row[x]))
        return;
    for (int32_t end = x + 1; end <= most && end + 1 < map->width; end++) {
        struct rf_depth_step step;
        if (!rf_depth_find_step(row[x], row[x - 1], row[end], row[end + 1],
                                map->infinity, &step) ||
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
static void count_mixed(const struct map *map, struct rf_depth_tally *tally)
{
    for (int32_t y = 0; y < map->height; y++)
        for (int32_t x = 1; x + 2 < map->width; x++)
            count_step(map, map->depth + (size_t)y * (size_t)map->width, x, tally);
}

/* Next to a fully covered pixel, depth times alpha is alpha times that pixel's depth.
 */
static void count_premultiplied(const struct map *map, const struct rf_image *colour,
                                struct rf_depth_tally *tally)
{
    for (int32_t y = 0; y < map->height; y++) {
        for (int32_t x = 1; x + 1 < map->width; x++) {
            const size_t i = (size_t)y * (size_t)map->width + (size_t)x;
            const double a = *rf_image_at(colour, x, y, 3);
            if (a < 0.1 || a > 0.9)
                continue;
            const int side =
                *rf_image_at(colour, x - 1, y, 3) >= RF_OPAQUE_ALPHA ? -1 : 1;
            const size_t solid = side < 0 ? i - 1 : i + 1;
            const double z = map->depth[i], near = map->depth[solid];
            if (*rf_image_at(colour, x + side, y, 3) < RF_OPAQUE_ALPHA ||
                !is_hit(map, map->depth[solid]) || near <= 0)
                continue;
            tally->n_part++;
            tally->n_scaled += fabs(z - a * near) < 0.05 * near;
        }
    }
}

static double share_of(size_t n_part, size_t n)
{
    return n >= RF_DEPTH_FEWEST ? (double)n_part / (double)n : 0;
}

/* Of depth that is above 1 somewhere. Inverse depth is so only of what is nearer than 1,
 * planar depth mostly: `hit_median` is that of what is not 0. */
static enum rf_depth guess_large(const struct rf_depth_stats *stats, double hit_median,
                                 const char **reason)
{
    *reason = "values above 1 are distances in scene units; radial looks alike";
    if (stats->n_zero == 0 || stats->n_no_hit > 0)
        return RF_DEPTH_PLANAR;
    if (hit_median > 1) {
        *reason = "distances in scene units, and 0 where nothing was hit; radial looks "
                  "alike";
        return RF_DEPTH_PLANAR;
    }
    *reason = "most of it below 1 and 0 where nothing was hit, as inverse depth has it";
    return RF_DEPTH_INVERSE;
}

/* The kind of depth that fits best, and why. */
static enum rf_depth guess_kind(const struct rf_depth_stats *stats, double hit_median,
                                const char **reason)
{
    const size_t n_without =
        stats->n_nan + stats->n_negative + stats->n_no_hit + stats->n_zero;
    if (n_without >= stats->n_pixels) {
        *reason = "no pixel has a distance";
        return RF_DEPTH_PLANAR;
    }
    if (stats->max > 1)
        return guess_large(stats, hit_median, reason);
    if (stats->n_no_hit > 0) {
        *reason = "all below 1, but infinity where nothing was hit: a small scene";
        return RF_DEPTH_PLANAR;
    }
    if (stats->inner_median > 0.9) {
        *reason = "within 0 to 1 and crowded near 1, as a depth buffer is";
        return RF_DEPTH_BUFFER;
    }
    if (stats->inner_median < 0.1 && stats->n_zero > 0) {
        *reason = "within 0 to 1 and crowded near 0, as a reversed depth buffer is";
        return RF_DEPTH_BUFFER_REVERSED;
    }
    if (stats->n_zero > 0 || stats->n_one > 0) {
        *reason = "within 0 to 1 and reaching an end of it";
        return RF_DEPTH_NORMALISED;
    }
    *reason = "all below 1, but not reaching 0 or 1: a small scene; normalised is "
              "possible";
    return RF_DEPTH_PLANAR;
}

rf_result rf_depth_tally_create(struct rf_depth_tally **tally,
                                const struct rf_context *context,
                                const struct rf_depth_channel *channel,
                                struct rf_error *error)
{
    if (!tally || !channel || channel->width < 1 || channel->height < 1)
        return rf_fail(error, RF_ERROR_ARGUMENT, tally ? "channel" : "tally",
                       "a pointer is NULL or the depth has no pixels");
    const size_t n = (size_t)channel->width * (size_t)channel->height;
    const size_t step = n / MOST_HITS + 1, n_hits = n / step + 1;
    struct rf_depth_tally *t = rf_depth_take(context, 1, sizeof *t);
    float *hits = rf_depth_take(context, n_hits, sizeof *hits);
    struct rf_hole_count *holes =
        rf_hole_count_create(context, channel->width, channel->infinity);
    if (!t || !hits || !holes) {
        rf_depth_give_back(context, holes);
        rf_depth_give_back(context, t);
        rf_depth_give_back(context, hits);
        return rf_fail_memory(error, n_hits, sizeof *hits);
    }
    *t = (struct rf_depth_tally){
        .context = context,
        .stats = {.n_pixels = n, .min = INFINITY, .max = -INFINITY},
        .infinity = channel->infinity,
        .step = step,
        .hits = hits,
        .holes = holes,
    };
    *tally = t;
    return RF_OK;
}

void rf_depth_tally_add(struct rf_depth_tally *tally,
                        const struct rf_depth_channel *given)
{
    struct rf_depth_channel checked = *given, *strip = &checked;
    const struct map map = {strip->depth, strip->width, strip->height, tally->infinity};
    if (strip->colour.height > strip->height) /* the rows below it, too */
        strip->colour.height = strip->height;
    if (rf_depth_check(strip, NULL) != RF_OK)
        strip->colour.data = NULL; /* of other pixels */
    count_values(&map, &tally->stats);
    keep_hits(&map, tally);
    count_mixed(&map, tally);
    rf_hole_count_add(tally->holes, strip);
    if (strip->colour.data && strip->colour.channels == 4)
        count_premultiplied(&map, &strip->colour, tally);
    if (strip->colour.data)
        rf_depth_count_edges(strip, &tally->edges);
}

void rf_depth_tally_finish(struct rf_depth_tally *tally, struct rf_depth_stats *stats)
{
    const struct rf_context *context = tally->context;
    struct rf_depth_stats found = tally->stats;
    qsort(tally->hits, tally->n_hits, sizeof *tally->hits, compare_floats);
    found.median = median_of(tally->hits, tally->n_hits, false);
    found.inner_median = median_of(tally->hits, tally->n_hits, true);
    found.mixed_share = share_of(tally->n_mixed, tally->n_steps);
    found.premultiplied_share = share_of(tally->n_scaled, tally->n_part);
    found.is_mixed = found.mixed_share > MIXED_SHARE;
    found.is_premultiplied = found.premultiplied_share > PREMULTIPLIED_SHARE;
    rf_depth_judge_edges(&tally->edges, &found);
    rf_hole_count_judge(tally->holes, &found);
    size_t n_zero = 0;
    while (n_zero < tally->n_hits && tally->hits[n_zero] == 0)
        n_zero++;
    const double hit_median =
        median_of(tally->hits + n_zero, tally->n_hits - n_zero, false);
    found.kind = (int32_t)guess_kind(&found, hit_median, &found.kind_reason);
    found.size = stats->size;
    memcpy(stats, &found, stats->size < sizeof found ? stats->size : sizeof found);
    rf_depth_give_back(context, tally->hits);
    rf_depth_give_back(context, tally);
}

rf_result rf_depth_measure(const struct rf_context *context,
                           const struct rf_depth_channel *channel,
                           struct rf_depth_stats *stats, struct rf_error *error)
{
    struct rf_depth_tally *tally = NULL;
    if (!stats || stats->size == 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "stats",
                       "stats is NULL, or its size is not set");
    rf_result result = rf_depth_check(channel, error);
    if (result == RF_OK)
        result = rf_depth_tally_create(&tally, context, channel, error);
    if (result != RF_OK)
        return result;
    rf_depth_tally_add(tally, channel);
    rf_depth_tally_finish(tally, stats);
    return RF_OK;
}
