/* SPDX-License-Identifier: Apache-2.0 */
#include "depth_repair.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "cli.h"

/* Half floats have 11 bits: neighbours differ by up to 2^-10 of their value. */
#define HALF_STEP (1.0 / 1024)

static bool names_mist(const struct source *source)
{
    int n;
    const char *name = exr_channels(source->depth, &n)[source->z].name;
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
        .is_half = exr_channels(source->depth, &n)[source->z].type == EXR_SAMPLE_HALF,
    };
    const bool is_distance =
        params->depth == RF_DEPTH_PLANAR || params->depth == RF_DEPTH_RADIAL;
    if (found->is_half && is_distance && lens)
        found->half_step_px = half_step_px(lens, stats);
}

void depth_find(struct depth_findings *found, const struct source *source,
                const struct settings *settings, const struct rf_lens *lens,
                const float *depth, const float *alpha, size_t stride)
{
    struct depth_stats stats;
    depth_stats_measure(depth, alpha, stride, source->width, source->height,
                        settings->params.depth_infinity, &stats);
    depth_judge(found, source, settings, lens, &stats);
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

/* The depth of the side that the pixel at `at` is nearer to, where it lies between two
 * flat sides `step` floats away; else its own. */
static float snapped(const float *at, ptrdiff_t step, double infinity, double *contrast)
{
    const double a = at[-step], b = at[step], z = *at;
    const double near = fmin(a, b), far = fmax(a, b);
    const double flat = fmax(fabs(a - at[-2 * step]), fabs(b - at[2 * step]));
    if (!(near >= 0 && far < infinity && far >= DEPTH_STEP_RATIO * near &&
          flat < 0.05 * (far - near)))
        return *at;
    const double place = (z - near) / (far - near);
    if (!(place > 0.02 && place < 0.98) || far - near <= *contrast)
        return *at;
    *contrast = far - near;
    return (float)(place < 0.5 ? near : far);
}

size_t depth_snap(float *depth, int32_t width, int32_t height, double infinity)
{
    const size_t n = (size_t)width * (size_t)height;
    float *from = need_memory(n, sizeof(*from));
    size_t n_changed = 0;
    memcpy(from, depth, n * sizeof(*from));
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            double contrast = 0;
            if (x >= 2 && x + 2 < width)
                depth[i] = snapped(from + i, 1, infinity, &contrast);
            if (y >= 2 && y + 2 < height) {
                const float z = snapped(from + i, width, infinity, &contrast);
                depth[i] = z != from[i] ? z : depth[i];
            }
            n_changed += depth[i] != from[i];
        }
    free(from);
    return n_changed;
}
