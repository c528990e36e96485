/* SPDX-License-Identifier: Apache-2.0 */
/* What a run does about deep samples. */
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "filter/filter_private.h"
#include "interrupt.h"

int filter_check_deep(struct run *run)
{
    const char *path = image_path(run->source.colour);
    run->is_deep = run->source.info.is_deep;
    if (!run->is_deep && (run->tool->holdout || run->tool->flattened)) {
        return app_fail(run->error, APP_USAGE,
                        "--%s: %s holds no deep samples; leave it out",
                        run->tool->holdout ? "holdout" : "flattened", path);
    }
    if (run->is_deep && run->has_views) {
        return app_fail(run->error, APP_FAILED,
                        "%s: holds deep samples; views are merged from flat files",
                        path);
    }
    if (run->is_deep && run->tool->denoise) {
        return app_fail(run->error, APP_USAGE,
                        "--denoise: %s holds deep samples, which the denoiser does not "
                        "know; leave it out, or denoise the result",
                        path);
    }
    if (run->is_deep && run->tool->pass_through) {
        return app_fail(
            run->error, APP_USAGE,
            "--pass-through: the deep samples of %s cannot be kept beside the flat "
            "picture made of them; leave it out",
            path);
    }
    return APP_DONE;
}

/* ---- doubts ----------------------------------------------------------------------- */

/* Without alpha the first sample of a pixel hides the others. */
static int warn_hidden(const struct run *run)
{
    const struct rf_deep *deep = &run->deep.frame;
    const size_t n_pixels = (size_t)deep->width * (size_t)deep->height;
    size_t n_several = 0;
    for (size_t i = 0; run->source.layer.a < 0 && i < n_pixels; i++)
        n_several += deep->first[i + 1] > deep->first[i] + 1;
    if (n_several == 0)
        return APP_DONE;
    return app_warn(run->tool->host, run->error,
                    "%s: its deep samples have no alpha, so that the nearest of a "
                    "pixel hides the others, in %zu pixels; write the channel A beside "
                    "the colours (AR, AG, AB and RA, GA, BA are not read)",
                    image_path(run->source.colour), n_several);
}

/* The first sample of a pixel that shows something, which most programs sort to be the
 * nearest; all zeros where there is none. */
static void take_first(const struct rf_deep *deep, size_t pixel, float colour[4])
{
    memset(colour, 0, 4 * sizeof(*colour));
    for (size_t i = deep->first[pixel]; i < deep->first[pixel + 1]; i++)
        if (deep->samples[i].colour[3] > 0) {
            memcpy(colour, deep->samples[i].colour, 4 * sizeof(*colour));
            return;
        }
}

static int warn_straight_samples(struct run *run)
{
    const struct rf_deep *deep = &run->deep.frame;
    const size_t width = (size_t)deep->width;
    float *row = app_memory(width, 4 * sizeof(*row), run->error);
    if (!row)
        return APP_NO_MEMORY;
    struct alpha_tally tally = {0};
    for (size_t y = 0; y < (size_t)deep->height; y++) {
        for (size_t x = 0; x < width; x++)
            take_first(deep, y * width + x, row + 4 * x);
        alpha_tally_add(&tally, row, width);
    }
    free(row);
    if (!alpha_is_straight(&tally))
        return APP_DONE;
    return app_warn(run->tool->host, run->error, "%s: %s",
                    image_path(run->source.colour), alpha_straight_words);
}

/* The depth by its numbers, as that of flat files is looked at. */
static int judge_flattened(struct run *run)
{
    const struct source *source = &run->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    struct rf_depth_stats stats = {.size = sizeof(stats)};
    struct depth_findings found;
    const struct rf_depth_channel channel = {.depth = run->depth,
                                             .width = source->width,
                                             .height = source->height,
                                             .infinity =
                                                 run->settings->params.depth_infinity};
    depth_numbers_add(&run->numbers, &run->settings->params, run->depth, n);
    if (!filter_needs_depth(run))
        return APP_DONE;
    if (rf_depth_measure(NULL, &channel, &stats, NULL) != RF_OK)
        return app_fail(run->error, APP_NO_MEMORY, "%s: out of memory",
                        image_path(source->depth));
    return filter_judge_depth(run, &stats, &found);
}

static int judge(struct run *run)
{
    int code = warn_hidden(run);
    if (code == APP_DONE)
        code = warn_straight_samples(run);
    return code == APP_DONE ? judge_flattened(run) : code;
}

/* Cameras that look along -z: the core would call each sample bad, without a way out. */
static int refuse_negative(const struct run *run)
{
    const struct rf_deep *deep = &run->deep.frame;
    const size_t n = deep->first[(size_t)deep->width * (size_t)deep->height];
    const struct rf_params *params = &run->settings->params;
    const bool is_distance =
        params->depth == RF_DEPTH_PLANAR || params->depth == RF_DEPTH_RADIAL;
    bool is_negative = n > 0 && is_distance && params->depth_scale > 0;
    for (size_t i = 0; is_negative && i < n; i++)
        is_negative = deep->samples[i].depth < 0;
    return is_negative ? app_fail(run->error, APP_FAILED,
                                  "%s: the depth of all its samples is negative, as "
                                  "the z of a camera that looks along -z is; say "
                                  "--depth-scale -1",
                                  image_path(run->source.colour))
                       : APP_DONE;
}

/* ---- reading ---------------------------------------------------------------------- */

int filter_read_deep(struct run *run)
{
    struct rf_error core_error;
    const struct source *source = &run->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    if (!deep_read(&run->deep, source, run->tool->holdout, run->n_threads, run->error))
        return app_code_of(run->error);
    if (refuse_negative(run) != APP_DONE)
        return APP_FAILED;
    run->colour = app_memory(n, (size_t)source->n_channels * sizeof(float), run->error);
    run->depth = run->colour ? app_memory(n, sizeof(float), run->error) : NULL;
    if (!run->depth)
        return APP_NO_MEMORY;
    if (deep_flatten(&run->deep, run->filter, source, run->colour, run->depth,
                     &core_error) != RF_OK)
        return filter_fail_core(run, &core_error);
    if (os_is_interrupted())
        return APP_INTERRUPTED;
    const int code = judge(run);
    if (code != APP_DONE)
        return code;
    if (run->tool->flattened && !filter_write_flattened(run, run->error))
        return app_code_of(run->error);
    return APP_DONE;
}
