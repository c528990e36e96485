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

bool depth_undo(const struct depth_findings *found, double infinity,
                const struct rf_view *views, int n, struct depth_repaired *repaired)
{
    for (int i = 0; i < n; i++) {
        const struct rf_image *colour = &views[i].colour, *depth = &views[i].depth;
        struct rf_depth_channel channel = {
            .depth = depth->data,
            .alpha = colour->channels == 4 ? (const float *)colour->data + 3 : NULL,
            .alpha_step = 4,
            .width = depth->width,
            .height = depth->height,
            .infinity = infinity};
        if (found->is_premultiplied)
            repaired->n_divided += rf_depth_divide_by_alpha(&channel);
        if (found->is_mixed &&
            rf_depth_snap(NULL, &channel, &repaired->n_snapped, NULL) != RF_OK)
            return false;
    }
    return true;
}

bool depth_mend(const struct depth_picture *picture, char *remark, size_t n_bytes,
                struct image_error *error)
{
    const struct source *source = picture->source;
    const struct rf_image *colour = &picture->views->colour;
    const float *alpha = colour->channels == 4 ? (const float *)colour->data + 3 : NULL;
    struct depth_findings found;
    struct depth_repaired repaired = {0};
    struct rf_lens lens;
    struct rf_error core_error;
    char text[400];
    remark[0] = 0;
    if (!rf_method_find(picture->params->method)->needs_depth)
        return true;
    if (rf_lens_init(&lens, picture->params, source->width, source->height,
                     &core_error) != RF_OK)
        return set_error(error, "%s: %s", image_path(source->colour),
                         core_error.message);
    if (!depth_find(&found, source, picture->settings, &lens,
                    picture->views->depth.data, alpha, 4))
        return set_error(error, "%s: out of memory", image_path(source->depth));
    if (depth_is_refused(&found, text, sizeof(text)))
        return set_error(error, "%s: the depth %s", image_path(source->depth), text);
    if (!depth_undo(&found, picture->params->depth_infinity, picture->views,
                    picture->n_views, &repaired))
        return set_error(error, "%s: out of memory", image_path(source->depth));
    if (repaired.n_divided + repaired.n_snapped > 0)
        snprintf(remark, n_bytes, "the depth was %s; %zu pixels were mended",
                 found.is_premultiplied ? "multiplied by alpha" : "anti-aliased",
                 repaired.n_divided + repaired.n_snapped);
    return true;
}
