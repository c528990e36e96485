/* SPDX-License-Identifier: Apache-2.0 */
/* What a run does about depth that cannot be meant as it is. */
#include "common/report.h"
#include "filter/filter_private.h"

bool filter_needs_depth(const struct run *run)
{
    return run->tool->depth_repair != DEPTH_REPAIR_OFF &&
           rf_method_find(run->params.method)->needs_depth;
}

int filter_judge_depth(const struct run *run, const struct rf_depth_stats *stats,
                       struct depth_findings *found)
{
    const char *path = image_path(run->source.depth);
    char text[700];
    depth_judge(found, &run->source, run->settings, rf_filter_lens(run->filter), stats,
                &run->numbers);
    if (depth_is_refused(found, text, sizeof(text)))
        return app_fail(run->error, APP_FAILED, "%s: the depth %s", path, text);
    if (source_explains_depth(&run->source, text, sizeof(text)) &&
        app_warn(run->tool->host, run->error, "%s: the depth %s", path, text) !=
            APP_DONE)
        return APP_FAILED;
    if (depth_is_doubtful(found, text, sizeof(text)) &&
        app_warn(run->tool->host, run->error, "%s: the depth %s", path, text) !=
            APP_DONE)
        return APP_FAILED;
    if (found->half_step_px > 0.5)
        return app_warn(run->tool->host, run->error,
                        "%s: the depth is 16 bit, radii come in steps of up to %.1f "
                        "px; write it as float",
                        path, found->half_step_px);
    return APP_DONE;
}

int filter_say_repaired(const struct run *run, const struct depth_findings *found,
                        const struct depth_repaired *repaired)
{
    const char *path = image_path(run->source.depth);
    const struct app_host *host = run->tool->host;
    int code = APP_DONE;
    if (!repaired && depth_fault(found))
        return app_warn(host, run->error,
                        "%s: the depth was %s; that is undone (--depth-repair off "
                        "takes it as it is)",
                        path, depth_fault(found));
    if (found->is_premultiplied)
        code = app_warn(host, run->error,
                        "%s: the depth was multiplied by alpha; %zu pixels were "
                        "divided by it (--depth-repair off takes it as it is)",
                        path, repaired->n_divided);
    if (found->is_speckled && code == APP_DONE)
        code =
            app_warn(host, run->error,
                     "%s: %.0f %% of the depth of surfaces was missing, scattered as "
                     "fog and other volumes do it; %zu pixels were given the depth "
                     "of the surface around them (--depth-repair off takes it as it "
                     "is)",
                     path, 100 * found->stats.hole_share, repaired->n_filled);
    if (found->is_mixed && code == APP_DONE)
        code = app_warn(host, run->error,
                        "%s: the depth was anti-aliased; %zu pixels between two sides "
                        "were given the depth of one (--depth-repair off takes it as "
                        "it is)",
                        path, repaired->n_snapped);
    if (found->is_widened && code == APP_DONE)
        code = app_warn(host, run->error,
                        "%s: the depth was wider than what is seen, as the nearest of "
                        "all that a pixel filter covers is; %zu pixels beside near "
                        "things were given the depth behind these (--depth-repair off "
                        "takes it as it is)",
                        path, repaired->n_narrowed);
    return code;
}

static float *depth_of(const struct run *run, int view)
{
    return run->has_views ? run->views.views[view].depth.data : run->depth;
}

/* What was found in the first view's depth, in all of them. False without memory. */
static bool undo(const struct run *run, const struct depth_findings *found,
                 struct depth_repaired *repaired)
{
    const struct source *source = &run->source;
    const struct rf_view alone = {
        .colour = rf_image_packed(run->colour, source->width, source->height,
                                  source->n_channels),
        .depth = rf_image_packed(run->depth, source->width, source->height, 1)};
    return depth_undo(found, run->params.depth_infinity,
                      run->has_views ? run->views.views : &alone, filter_n_views(run),
                      repaired);
}

int filter_repair_depth(struct run *run)
{
    const struct source *source = &run->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    struct rf_depth_stats stats;
    const struct rf_depth_channel channel = {
        run->depth,
        rf_image_packed(run->colour, source->width, source->height, source->n_channels),
        source->width, source->height, run->settings->params.depth_infinity};
    struct depth_findings found;
    struct depth_repaired repaired = {0};
    for (int i = 0; i < filter_n_views(run); i++)
        rf_depth_undo_mist(depth_of(run, i), n, (enum rf_mist)run->tool->mist_falloff);
    depth_numbers_add(&run->numbers, &run->settings->params, run->depth, n);
    if (!filter_needs_depth(run))
        return APP_DONE;
    if (!depth_measure(&run->settings->params, &channel, &stats))
        return app_fail(run->error, APP_NO_MEMORY, "%s: out of memory",
                        image_path(source->depth));
    const int code = filter_judge_depth(run, &stats, &found);
    if (code != APP_DONE)
        return code;
    if (!undo(run, &found, &repaired))
        return app_fail(run->error, APP_NO_MEMORY, "%s: out of memory",
                        image_path(source->depth));
    return filter_say_repaired(run, &found, &repaired);
}
