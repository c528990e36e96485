/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the grain goes out. One view: before the lens, where pixels still have the
 * albedo and the normals that guide the denoiser (docs/notebook/rivals.md: after it is
 * as good within 0.1 dB without guides, and 3 dB worse with few samples and glass).
 *
 * Several views: both. Each view denoised by itself keeps what the lens sees but loses
 * what few samples do not tell; the merged picture denoised has the samples of all but
 * no guides. Their errors differ, and their mean is better than either (soft: 40.2 and
 * 40.3, 41.1 dB; plant 39.7 and 39.5, 39.9; never more than 0.1 below the better one).
 */
#include <stdlib.h>

#include "denoise.h"
#include "filter_private.h"
#include "interrupt.h"
#include "report.h"

static int code_of(const struct run *run, bool is_done)
{
    if (!is_done)
        return app_code_of(run->error);
    return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
}

/* Takes the grain out of the pixels of a source. */
static int denoise_source(struct run *run, struct denoiser *denoiser,
                          const struct source *source, float *samples)
{
    struct denoise_guides guides;
    const struct denoise_picture picture = {samples, source->width, source->height,
                                            source->n_channels,
                                            image_path(source->colour)};
    bool is_done = denoise_read_guides(source, run->n_threads, &guides, run->error) &&
                   denoise_picture(denoiser, &picture, &guides, run->error);
    denoise_free_guides(&guides);
    return code_of(run, is_done);
}

/* The same of all views. */
static int denoise_views(struct run *run, struct denoiser *denoiser)
{
    int code = APP_DONE;
    app_begin(run->tool->host, "denoising");
    for (int j = 0; j < run->views.n && code == APP_DONE; j++) {
        code = denoise_source(run, denoiser, &run->views.sources[j],
                              run->views.views[j].colour.data);
        app_progress((void *)run->tool->host, (j + 1.0) / run->views.n);
    }
    app_end(run->tool->host);
    return code;
}

/* Merges the views with their grain into `merged`, and denoises that. */
static int merge_and_denoise(struct run *run, struct denoiser *denoiser,
                             int (*make_picture)(struct run *run, float *samples),
                             float *merged)
{
    const struct source *source = &run->source;
    const struct denoise_picture picture = {merged, source->width, source->height,
                                            source->n_channels,
                                            image_path(source->colour)};
    const int code = make_picture(run, merged);
    if (code != APP_DONE)
        return code;
    return code_of(run, denoise_picture(denoiser, &picture, NULL, run->error));
}

static int run_views(struct run *run, struct denoiser *denoiser,
                     int (*make_picture)(struct run *run, float *samples))
{
    const size_t n = (size_t)run->source.width * (size_t)run->source.height *
                     (size_t)run->source.n_channels;
    float *merged = app_memory(n, sizeof(*merged), run->error);
    if (!merged)
        return APP_NO_MEMORY;
    int code = merge_and_denoise(run, denoiser, make_picture, merged);
    if (code == APP_DONE)
        code = denoise_views(run, denoiser);
    if (code == APP_DONE)
        code = make_picture(run, run->colour);
    for (size_t i = 0; i < n && code == APP_DONE; i++)
        run->colour[i] = (run->colour[i] + merged[i]) / 2;
    free(merged);
    return code;
}

int denoise_and_filter(struct run *run,
                       int (*make_picture)(struct run *run, float *samples))
{
    struct denoiser *denoiser = denoiser_open(NULL, run->n_threads, run->error);
    if (!denoiser)
        return app_code_of(run->error);
    int code;
    if (run->has_views) {
        code = run_views(run, denoiser, make_picture);
    } else {
        code = denoise_source(run, denoiser, &run->source, run->colour);
        if (code == APP_DONE)
            code = make_picture(run, run->colour);
    }
    denoiser_close(denoiser);
    return code;
}
