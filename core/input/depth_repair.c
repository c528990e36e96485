/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depth as renderers write it, made fit for use.
 *
 * Averages. A pixel filter that averages depth leaves numbers between two surfaces,
 * where nothing is. Along the row and the column of a pixel the nearest two flat sides
 * are looked for, at most RF_DEPTH_STEP_PIXELS px apart, whose depths differ by
 * RF_DEPTH_STEP_RATIO: what lies between them gets the nearer of the two depths. Lamps
 * and what is flat for 2 px between both are no averages and keep theirs: lamps of a
 * portrait of 2 x 2 averaged depths are worth 6.5 dB. Thin
 * things have no flat side; where 0 is behind them, they are 240 px of blur before it.
 *
 * Depth times alpha, as compositing writes it, is divided by alpha.
 *
 * Depth that is wider than colours are: depth_edges.c. With holes in it: depth_holes.c.
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "input/depth_steps.h"
#include "input/image.h"
#include "rackfocus/rackfocus.h"

_Static_assert((int)RF_DEPTH_SNAP_REACH == (int)RF_DEPTH_STEP_PIXELS + 1,
               "sides end where a step does");

/* Half of the widest pixel filter, and a pixel: how far averages of a thin thing reach. */
enum { THIN_PX = 3 };

/* A gap that is narrower than the filter has no pixel of 0: so little of a depth is one. */
static const float NOTHING = 0.05f;

_Static_assert(2 * (int)THIN_PX <= (int)RF_DEPTH_SNAP_REACH, "what a pixel looks at");

void rf_depth_undo_mist(float *depth, size_t n, enum rf_mist falloff)
{
    for (size_t i = 0; i < n; i++) {
        if (falloff == RF_MIST_QUADRATIC)
            depth[i] = sqrtf(depth[i]);
        else if (falloff == RF_MIST_INVERSE)
            depth[i] *= depth[i];
    }
}

/* Of a row of pixels; returns how many changed. */
static size_t divide_row(const struct rf_image *colour, float *depth, int32_t width,
                         int32_t y)
{
    size_t n_changed = 0;
    for (int32_t x = 0; x < width; x++) {
        const float a = *rf_image_at(colour, x, y, 3);
        if (a >= 1 || isinf(depth[x]))
            continue;
        depth[x] = a > 0 ? depth[x] / a : 0;
        n_changed++;
    }
    return n_changed;
}

size_t rf_depth_divide_by_alpha(struct rf_depth_channel *channel)
{
    const struct rf_image *colour = &channel->colour;
    size_t n_changed = 0;
    if (!colour->data || colour->channels != 4 ||
        rf_depth_check(channel, NULL) != RF_OK)
        return 0;
    for (int32_t y = 0; y < channel->height; y++)
        n_changed +=
            divide_row(colour, channel->depth + (size_t)y * (size_t)channel->width,
                       channel->width, y);
    return n_changed;
}

/* Pixels before and behind the one in question, along a row or a column. */
struct line {
    const float *at;
    ptrdiff_t step; /* floats from pixel to pixel */
    int32_t n_before, n_behind;
};

/* Is the end of a side, at `at`, like a pixel across the line, too? Averages with nothing
 * behind, along a horizon or the border, are flat in one direction only. */
static bool is_surface(const float *at, const struct line *across)
{
    const float z = *at, most = (float)RF_DEPTH_STEP_RATIO;
    const float before = across->n_before > 0 ? at[-across->step] : NAN;
    const float behind = across->n_behind > 0 ? at[across->step] : NAN;
    return (before <= most * z && z <= most * before) ||
           (behind <= most * z && z <= most * behind) ||
           (isnan(before) && isnan(behind));
}

/* The step that a pixel lies on, and where its sides end on a line. */
struct sides {
    struct rf_depth_step step;
    const float *before, *behind;
    ptrdiff_t pitch; /* floats from pixel to pixel of the line */
};

/* The two sides of the step that the pixel lies on, the nearest ones; of two as near
 * the ones of the higher step. `sides` has what was found along another line. */
static void find_sides(const struct line *line, const struct line *across,
                       double infinity, struct sides *sides)
{
    struct rf_depth_step *best = &sides->step;
    for (int32_t n = 2; n <= RF_DEPTH_STEP_PIXELS + 1 && n <= best->n; n++)
        for (int32_t k = 1; k < n; k++) {
            if (k >= line->n_before || n - k >= line->n_behind)
                continue;
            const float *a = line->at - k * line->step;
            const float *b = line->at + (n - k) * line->step;
            struct rf_depth_step found = {.n = n, .n_low = *a < *b ? k : n - k};
            if (rf_depth_find_step(*a, a[-line->step], *b, b[line->step], infinity,
                                   &found) &&
                (n < best->n || found.high - found.low > best->high - best->low) &&
                is_surface(*a < *b ? a : b, across) &&
                (found.low > 0 || is_surface(*a < *b ? b : a, across)))
                *sides = (struct sides){found, a, b, line->step};
        }
}

/* Are two pixels beside each other as deep, between the sides? No filter makes that of
 * two flat sides. */
static bool is_plateau(const struct sides *sides, const float *at)
{
    static const double ALIKE = 0.003, LEAST = 0.1; /* of the depth, of the step */
    const struct rf_depth_step *step = &sides->step;
    const double z = *at, away = LEAST * (step->high - step->low);
    if (z < step->low + away || z > step->high - away)
        return false;
    for (int k = -1; k <= 1; k += 2) {
        const float *beside = at + k * sides->pitch;
        if (beside != sides->before && beside != sides->behind &&
            fabs((double)*beside - z) <= ALIKE * z)
            return true;
    }
    return false;
}

/* The largest channel of the pixel whose depth is at `at`. */
static double light_of(const struct rf_depth_channel *from, const float *at)
{
    const ptrdiff_t i = at - from->depth;
    double most = 0;
    for (int c = 0; c < from->colour.channels && c < 3; c++)
        most = fmax(most, *rf_image_at(&from->colour, (int32_t)(i % from->width),
                                       (int32_t)(i / from->width), c));
    return most;
}

/* Is it much brighter than both sides and white? A mean of them is not. The last pixel of
 * a side may have some of its light. */
static bool is_lamp(const struct rf_depth_channel *from, const struct sides *sides,
                    const float *at)
{
    static const double TIMES = 8;
    if (!from->colour.data)
        return false;
    const double before = fmin(light_of(from, sides->before),
                               light_of(from, sides->before - sides->pitch));
    const double behind = fmin(light_of(from, sides->behind),
                               light_of(from, sides->behind + sides->pitch));
    const double side = fmax(before, behind);
    return light_of(from, at) > TIMES * fmax(side, 1);
}

/* The depth of the side that a pixel is nearer to; its own where it lies on no step, is
 * one of a side, or is something else. Averages with negative weights lie a little
 * beyond the sides, or below 0. */
static float snapped(float z, const struct rf_depth_step *step)
{
    if (step->n > RF_DEPTH_STEP_PIXELS + 1)
        return z;
    const double height = step->high - step->low, beyond = 0.15 * height;
    const double side = z < (step->low + step->high) / 2 ? step->low : step->high;
    const double alike = 0.02 * fmin(height, step->low);
    /* Further from the low side it may be a thin thing before both. */
    const double least =
        fmax(step->low - beyond, step->n_low > 1 ? 0.75 * step->low : 0);
    const bool is_mixture = z >= least && z <= step->high + beyond;
    return (is_mixture && fabs(z - side) > alike) || z < 0 ? (float)side : z;
}

/* For what is below 0 and on no step: the least depth of the neighbours; `z` where none
 * of them is a depth. */
static float least_around(const struct line *row, const struct line *column, float z)
{
    float least = INFINITY;
    for (int k = -1; k <= 1; k++)
        for (int l = -1; l <= 1; l++) {
            const bool is_inside =
                (k < 0 ? column->n_before : column->n_behind) >= abs(k) &&
                (l < 0 ? row->n_before : row->n_behind) >= abs(l);
            const float v = is_inside ? row->at[k * column->step + l] : z;
            least = v >= 0 ? fminf(least, v) : least;
        }
    return isfinite(least) ? least : z;
}

/* Is the pixel like those on both sides of it? */
static bool is_flat(const struct line *line)
{
    const float z = *line->at, alike = 1e-3f * z;
    return line->n_before > 0 && line->n_behind > 0 &&
           fabsf(line->at[-line->step] - z) <= alike &&
           fabsf(line->at[line->step] - z) <= alike;
}

/* Is a pixel beside it as deep, or both in one plane with it, whose 1 / depth is even?
 * So are those of one surface. */
static bool has_like(const struct line *line)
{
    static const float LIKE = 0.02f, EVEN = 0.1f;
    const float z = *line->at, alike = LIKE * z;
    const float before = line->n_before > 0 ? line->at[-line->step] : NAN;
    const float behind = line->n_behind > 0 ? line->at[line->step] : NAN;
    return fabsf(before - z) <= alike || fabsf(behind - z) <= alike ||
           (before > 0 && behind > 0 && fabsf(z / before + z / behind - 2) <= 2 * EVEN);
}

/* The greatest depth of the 3 x 3 pixels around (x, y), which moves there. */
static float climb(const struct rf_depth_channel *from, int32_t *x, int32_t *y)
{
    const int32_t at_x = *x, at_y = *y;
    float most = 0;
    for (int32_t k = at_y - 1; k <= at_y + 1; k++)
        for (int32_t l = at_x - 1; l <= at_x + 1; l++) {
            const bool is_inside =
                k >= 0 && k < from->height && l >= 0 && l < from->width;
            const float v =
                is_inside ? from->depth[(size_t)k * (size_t)from->width + (size_t)l]
                          : 0;
            if (v > most && (double)v < from->infinity) {
                most = v;
                *x = l;
                *y = k;
            }
        }
    return most;
}

/* Has the pixel one like it in its row, and one in its column? Averages of a thin thing
 * and nothing have such along the thing alone. */
static bool is_on_surface(const struct rf_depth_channel *from, int32_t x, int32_t y)
{
    const float *at = from->depth + (size_t)y * (size_t)from->width + (size_t)x;
    const struct line row = {at, 1, x, from->width - 1 - x};
    const struct line column = {at, from->width, y, from->height - 1 - y};
    return has_like(&row) && has_like(&column);
}

/* The least depth around, 0 where nothing was hit; INFINITY where that is a surface, as
 * beside what is much farther. */
static float least_near(const struct rf_depth_channel *from, int32_t x, int32_t y)
{
    float least = INFINITY;
    int32_t least_x = x, least_y = y;
    for (int32_t k = y - THIN_PX; k <= y + THIN_PX; k++)
        for (int32_t l = x - THIN_PX; l <= x + THIN_PX; l++) {
            const bool is_inside =
                k >= 0 && k < from->height && l >= 0 && l < from->width;
            const float v =
                is_inside ? from->depth[(size_t)k * (size_t)from->width + (size_t)l]
                          : INFINITY;
            if (v >= 0 && v < least) {
                least = v;
                least_x = l;
                least_y = k;
            }
        }
    return least > 0 && is_on_surface(from, least_x, least_y) ? INFINITY : least;
}

/* For what lies on no step, or before both sides of one, and is near pixels where nothing
 * was hit: it may be a thin thing, whose averages with nothing are too near, or a gap
 * between two things. So it gets the greatest depth that can be climbed to, or 0 where it
 * has less than half of that. */
static float crest_of(const struct rf_depth_channel *from, int32_t x, int32_t y,
                      float z)
{
    const float least = least_near(from, x, y);
    float crest = z;
    if (is_on_surface(from, x, y))
        return z;
    for (int32_t i = 0; i < THIN_PX; i++)
        crest = climb(from, &x, &y);
    if (!(least < NOTHING * crest) || !(crest > (float)RF_DEPTH_STEP_RATIO * z))
        return z;
    return z > crest / 2 ? crest : 0;
}

/* The depth that a pixel gets. */
static float snap_pixel(const struct rf_depth_channel *from, int32_t x, int32_t y,
                        const void *data)
{
    const float *at = from->depth + (size_t)y * (size_t)from->width + (size_t)x;
    const struct line row = {at, 1, x, from->width - 1 - x};
    const struct line column = {at, from->width, y, from->height - 1 - y};
    (void)data;
    struct sides sides = {.step.n = RF_DEPTH_STEP_PIXELS + 2};
    if (is_flat(&row) && is_flat(&column))
        return *at;
    find_sides(&row, &column, from->infinity, &sides);
    find_sides(&column, &row, from->infinity, &sides);
    const bool is_on_step = sides.step.n <= RF_DEPTH_STEP_PIXELS + 1;
    if (is_on_step && *at > 0 && sides.step.low > 0 &&
        (is_plateau(&sides, at) || is_lamp(from, &sides, at)))
        return *at;
    const float z = snapped(*at, &sides.step);
    if (z > 0 && (double)z < from->infinity &&
        (!is_on_step || (double)z < 0.75 * sides.step.low))
        return crest_of(from, x, y, z);
    return z < 0 ? least_around(&row, &column, z) : z;
}

rf_result rf_depth_snap(const struct rf_context *context,
                        struct rf_depth_channel *channel, size_t *n_changed,
                        struct rf_error *error)
{
    return rf_depth_change_all(context, channel, snap_pixel, NULL, n_changed, error);
}

rf_result rf_depth_repair(const struct rf_context *context,
                          struct rf_depth_channel *channel,
                          struct rf_depth_stats *stats, struct rf_error *error)
{
    struct rf_depth_stats found = {.size = sizeof found};
    if (!stats || stats->size == 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "stats",
                       "stats is NULL, or its size is not set");
    rf_result result = rf_depth_measure(context, channel, &found, error);
    if (result != RF_OK)
        return result;
    if (found.is_premultiplied)
        found.n_divided = rf_depth_divide_by_alpha(channel);
    if (found.is_speckled)
        result = rf_depth_fill(context, channel, &found.n_filled, error);
    if (result == RF_OK && found.is_mixed)
        result = rf_depth_snap(context, channel, &found.n_snapped, error);
    else if (result == RF_OK && found.is_widened)
        result = rf_depth_narrow(context, channel, &found, &found.n_narrowed, error);
    found.size = stats->size;
    memcpy(stats, &found, stats->size < sizeof found ? stats->size : sizeof found);
    return result;
}
