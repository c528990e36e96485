/* SPDX-License-Identifier: Apache-2.0 */
#include "depth_repair.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "report.h"

/* Half floats have 11 bits: neighbours differ by up to 2^-10 of their value. */
#define HALF_STEP (1.0 / 1024)

static bool names_mist(const struct source *source)
{
    int n;
    const char *name = image_channels(source->depth, &n)[source->z].name;
    return strcasestr(name, "mist") != NULL;
}

/* Distances only: of other kinds 16 bit are coarse in their own way. */
static double half_step_px(const struct rf_lens *lens, const struct depth_stats *stats)
{
    double most = 0;
    const double ends[2] = {stats->min, stats->max};
    for (int i = 0; i < 2; i++)
        if (ends[i] > 0 && isfinite(ends[i]))
            most = fmax(most, fabs(rf_lens_radius_px(lens, ends[i] * (1 + HALF_STEP)) -
                                   rf_lens_radius_px(lens, ends[i])));
    return most;
}

void depth_judge(struct depth_findings *found, const struct source *source,
                 const struct settings *settings, const struct rf_lens *lens,
                 const struct depth_stats *stats)
{
    int n;
    const struct rf_params *params = &settings->params;
    *found = (struct depth_findings){
        .stats = *stats,
        .is_mixed = depth_stats_is_mixed(stats),
        .is_premultiplied = depth_stats_is_premultiplied(stats),
        .is_mist = names_mist(source),
        .is_kind_open = settings_origin(settings, "depth") == ORIGIN_DEFAULT,
        .is_half =
            image_channels(source->depth, &n)[source->z].type == IMAGE_SAMPLE_HALF,
    };
    const bool is_distance =
        params->depth == RF_DEPTH_PLANAR || params->depth == RF_DEPTH_RADIAL;
    if (found->is_half && is_distance && lens)
        found->half_step_px = half_step_px(lens, stats);
}

bool depth_find(struct depth_findings *found, const struct source *source,
                const struct settings *settings, const struct rf_lens *lens,
                const float *depth, const float *alpha, size_t stride)
{
    struct depth_stats stats;
    if (!depth_stats_measure(depth, alpha, stride, source->width, source->height,
                             settings->params.depth_infinity, &stats))
        return false;
    depth_judge(found, source, settings, lens, &stats);
    return true;
}

bool depth_is_refused(const struct depth_findings *found, char *text, size_t n_bytes)
{
    const char *reason, *guess = depth_stats_guess(&found->stats, &reason);
    if (!found->is_kind_open)
        return false;
    if (found->is_mist) {
        snprintf(text, n_bytes,
                 "is Blender's Mist pass, which holds no distances; say --depth "
                 "normalised --depth-near START --depth-far END (start, and start + "
                 "depth of the world's Mist) and --mist-falloff quadratic, linear or "
                 "inverse-quadratic, or render the Depth pass");
        return true;
    }
    if (strcmp(guess, "normalised") != 0 && strncmp(guess, "buffer", 6) != 0)
        return false;
    snprintf(text, n_bytes,
             "does not look like distances but %s (%s); say --depth %s with "
             "--depth-near and --depth-far, or --depth planar if they are",
             strncmp(guess, "buffer", 6) == 0 ? "like a depth buffer"
                                              : "like normalised depth",
             reason, guess);
    return true;
}

void depth_undo_mist(float *depth, size_t n, enum mist_falloff falloff)
{
    for (size_t i = 0; i < n; i++) {
        if (falloff == MIST_QUADRATIC)
            depth[i] = sqrtf(depth[i]);
        else if (falloff == MIST_INVERSE)
            depth[i] *= depth[i];
    }
}

size_t depth_divide_by_alpha(float *depth, const float *alpha, size_t stride, size_t n)
{
    size_t n_changed = 0;
    for (size_t i = 0; i < n; i++) {
        const float a = alpha[i * stride];
        if (a >= 1 || isinf(depth[i]))
            continue;
        depth[i] = a > 0 ? depth[i] / a : 0;
        n_changed++;
    }
    return n_changed;
}

/* Pixels before and behind the one in question, along a row or a column. */
struct line {
    const float *at;
    ptrdiff_t step; /* floats from pixel to pixel */
    int32_t n_before, n_behind;
};

/* The two sides of the step that the pixel lies on, the nearest ones; of two as near
 * the ones of the higher step. `best` has what was found along another line. */
static void find_sides(const struct line *line, double infinity,
                       struct depth_step *best)
{
    for (int32_t n = 2; n <= DEPTH_STEP_PIXELS + 1 && n <= best->n; n++)
        for (int32_t k = 1; k < n; k++) {
            if (k >= line->n_before || n - k >= line->n_behind)
                continue;
            const float *a = line->at - k * line->step;
            const float *b = line->at + (n - k) * line->step;
            struct depth_step found = {.n = n, .n_low = *a < *b ? k : n - k};
            if (depth_find_step(*a, a[-line->step], *b, b[line->step], infinity,
                                &found) &&
                (n < best->n || found.high - found.low > best->high - best->low))
                *best = found;
        }
}

/* The depth of the side that a pixel is nearer to; its own where it lies on no step, is
 * one of a side, or is something else. Averages with negative weights lie a little
 * beyond the sides, or below 0. */
static float snapped(float z, const struct depth_step *step)
{
    if (step->n > DEPTH_STEP_PIXELS + 1)
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

bool depth_snap(float *depth, int32_t width, int32_t height, double infinity,
                size_t *n_changed)
{
    const size_t n = (size_t)width * (size_t)height;
    float *from = app_memory(n, sizeof(*from), NULL);
    if (!from)
        return false;
    memcpy(from, depth, n * sizeof(*from));
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            const struct line row = {from + i, 1, x, width - 1 - x};
            const struct line column = {from + i, width, y, height - 1 - y};
            struct depth_step step = {.n = DEPTH_STEP_PIXELS + 2};
            if (is_flat(&row) && is_flat(&column))
                continue;
            find_sides(&row, infinity, &step);
            find_sides(&column, infinity, &step);
            depth[i] = snapped(from[i], &step);
            if (depth[i] < 0)
                depth[i] = least_around(&row, &column, depth[i]);
            *n_changed += depth[i] != from[i];
        }
    free(from);
    return n_changed;
}
