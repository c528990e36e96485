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
static double half_step_px(const struct rf_lens *lens,
                           const struct rf_depth_stats *stats)
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
                 const struct rf_depth_stats *stats)
{
    int n;
    const struct rf_params *params = &settings->params;
    *found = (struct depth_findings){
        .stats = *stats,
        .is_mixed = stats->is_mixed,
        .is_premultiplied = stats->is_premultiplied,
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
    struct rf_depth_stats stats = {.size = sizeof(stats)};
    const struct rf_depth_channel channel = {
        (float *)depth, alpha,          stride,
        source->width,  source->height, settings->params.depth_infinity};
    if (rf_depth_measure(NULL, &channel, &stats, NULL) != RF_OK)
        return false;
    depth_judge(found, source, settings, lens, &stats);
    return true;
}

bool depth_is_refused(const struct depth_findings *found, char *text, size_t n_bytes)
{
    const char *guess = rf_param_find("depth")->choices[found->stats.kind].name;
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
             found->stats.kind_reason, guess);
    return true;
}
