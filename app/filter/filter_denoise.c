/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the grain goes out. One view: before the lens, where pixels still have the
 * albedo and the normals that guide the denoiser (docs/notebook/rivals.md: after it is
 * as good within 0.1 dB without guides, and 3 dB worse with few samples and glass).
 *
 * Several views: before, together (denoise_views.c). The picture is the merge of these,
 * mixed with that of the views with their grain where the grain is the smaller error
 * (denoise_mix.c).
 */
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "denoise/denoise.h"
#include "denoise/denoise_background.h"
#include "denoise/denoise_mix.h"
#include "denoise/denoise_seeds.h"
#include "denoise/denoise_views.h"
#include "filter/filter_private.h"
#include "interrupt.h"

static int code_of(const struct run *run, bool is_done)
{
    if (!is_done)
        return app_code_of(run->error);
    return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
}

static float white_of_run(const struct run *run)
{
    return (float)white_round(run->params.white);
}

/* Takes the grain out of the pixels of a source. */
static int denoise_source(struct run *run, struct denoiser *denoiser,
                          const struct source *source, float *samples)
{
    struct denoise_guides guides;
    const struct denoise_picture picture = {samples,
                                            source->width,
                                            source->height,
                                            source->n_channels,
                                            image_path(source->colour),
                                            white_of_run(run)};
    const struct denoise_files files = {run->tool->albedo_file, run->tool->normal_file};
    const size_t n =
        (size_t)source->width * (size_t)source->height * (size_t)source->n_channels;
    struct denoise_picture grainy = picture;
    bool is_done =
        denoise_read_guides(source, &files, run->n_threads, &guides, run->error);
    grainy.samples = is_done ? app_memory(n, sizeof(float), run->error) : NULL;
    is_done = grainy.samples;
    if (is_done) {
        memcpy(grainy.samples, samples, n * sizeof(float));
        denoise_judge_grain(denoiser, &picture, &guides);
        is_done = denoise_picture(denoiser, &picture, &guides, run->error);
    }
    if (is_done)
        denoise_keep_background(&grainy, &guides, samples, run->n_threads);
    denoise_free_guides(&guides);
    free(grainy.samples);
    return code_of(run, is_done);
}

/* ---- several views ------------------------------------------------------------------
 */

/* Everything that is shared; the memory of shifts and guides belongs to it. */
static int open_share(struct run *run, struct share *share)
{
    const struct source *source = &run->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    *share = (struct share){.n = run->views.n,
                            .width = source->width,
                            .height = source->height,
                            .n_channels = source->n_channels,
                            .lens_radius = rf_filter_lens(run->filter)->lens_radius,
                            .white = white_of_run(run),
                            .n_threads = run->n_threads};
    share->views = app_memory((size_t)run->views.n, sizeof(*share->views), run->error);
    for (int j = 0; j < run->views.n && share->views; j++) {
        const struct rf_view *view = &run->views.views[j];
        struct share_view *to = &share->views[j];
        float *shift = app_memory(n, sizeof(float), run->error);
        to->samples = view->colour.data;
        to->shift_px = shift;
        memcpy(to->offset, view->lens_offset, sizeof(to->offset));
        if (!shift || !denoise_read_guides(&run->views.sources[j], NULL, run->n_threads,
                                           &to->guides, run->error))
            return app_code_of(run->error);
        denoise_find_shifts(run->filter, view, shift, NULL);
    }
    if (!share->views || !share_open(share, run->error))
        return app_code_of(run->error);
    return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
}

static void close_share(struct share *share)
{
    for (int j = 0; j < share->n && share->views; j++) {
        denoise_free_guides(&share->views[j].guides);
        free((float *)share->views[j].shift_px);
    }
    free(share->views);
    share_close(share);
}

static bool go_on(void *user, double fraction)
{
    const struct run *run = user;
    app_progress((void *)run->tool->host, fraction);
    return !os_is_interrupted();
}

/* All views without grain, into made[j]. */
static int denoise_opened(struct run *run, struct denoiser *denoiser,
                          struct denoise_views *views, float *const *made)
{
    const char *names[RF_MAX_VIEWS];
    for (int j = 0; j < run->views.n; j++)
        names[j] = image_path(run->views.sources[j].colour);
    views->names = names;
    views->progress = go_on;
    views->user = run;
    const int code = denoise_views(denoiser, views, made, run->error);
    run->shared_views += views->n_shared;
    return code;
}

static int denoise_shared(struct run *run, struct denoiser *denoiser,
                          float *const *made)
{
    struct denoise_views views = {0};
    app_begin(run->tool->host, "denoising");
    int code = open_share(run, &views.share);
    if (code == APP_DONE)
        code = denoise_opened(run, denoiser, &views, made);
    close_share(&views.share);
    app_end(run->tool->host);
    if (code == APP_DONE && views.have_one_seed)
        code = app_warn(run->tool->host, run->error, "%s: " DENOISE_ONE_SEED,
                        image_path(run->source.colour));
    return code;
}

/* Gives the grain of the views random signs; made[j]: view j without it. */
static void flip_views(struct run *run, float *const *made)
{
    const struct source *source = &run->source;
    for (int j = 0; j < run->views.n; j++) {
        const struct denoise_picture grainy = {run->views.views[j].colour.data,
                                               source->width,
                                               source->height,
                                               source->n_channels,
                                               image_path(source->colour),
                                               white_of_run(run)};
        denoise_flip(&grainy, made[j], j);
    }
}

/* With room for pictures in `grainy` and `flipped`, and for view j in made[j]. */
static int run_views(struct run *run, struct denoiser *denoiser,
                     int (*make_picture)(struct run *run, float *samples),
                     float *grainy, float *flipped, float *const *made)
{
    const struct source *source = &run->source;
    const size_t n =
        (size_t)source->width * (size_t)source->height * (size_t)source->n_channels;
    const struct denoise_merges merges = {run->colour,       grainy,
                                          flipped,           source->width,
                                          source->height,    source->n_channels,
                                          white_of_run(run), run->n_threads};
    int code = make_picture(run, grainy);
    if (code == APP_DONE)
        code = denoise_shared(run, denoiser, made);
    if (code == APP_DONE) {
        flip_views(run, made);
        code = make_picture(run, flipped);
    }
    if (code != APP_DONE)
        return code;
    for (int j = 0; j < run->views.n; j++)
        memcpy(run->views.views[j].colour.data, made[j], n * sizeof(float));
    code = make_picture(run, run->colour);
    if (code != APP_DONE)
        return code;
    return code_of(run, denoise_mix(&merges, run->error));
}

static int denoise_and_merge(struct run *run, struct denoiser *denoiser,
                             int (*make_picture)(struct run *run, float *samples))
{
    const size_t n = (size_t)run->source.width * (size_t)run->source.height *
                     (size_t)run->source.n_channels;
    float *all = app_memory((size_t)run->views.n + 2, n * sizeof(float), run->error);
    float *made[RF_MAX_VIEWS];
    if (!all)
        return APP_NO_MEMORY;
    for (int j = 0; j < run->views.n; j++)
        made[j] = all + n * (size_t)(j + 2);
    const int code = run_views(run, denoiser, make_picture, all, all + n, made);
    free(all);
    return code;
}

int denoise_and_filter(struct run *run,
                       int (*make_picture)(struct run *run, float *samples))
{
    struct denoiser *denoiser =
        denoiser_open(NULL, (enum denoise_quality)run->tool->denoise_quality,
                      run->n_threads, run->error);
    if (!denoiser)
        return app_code_of(run->error);
    int code;
    if (run->has_views) {
        code = denoise_and_merge(run, denoiser, make_picture);
    } else {
        code = denoise_source(run, denoiser, &run->source, run->colour);
        if (code == APP_DONE)
            code = make_picture(run, run->colour);
    }
    denoiser_close(denoiser);
    return code;
}
