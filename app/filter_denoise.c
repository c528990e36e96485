/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the grain goes out. One view: before the lens, where pixels still have the
 * albedo and the normals that guide the denoiser (docs/notebook/rivals.md: after it is
 * as good within 0.1 dB without guides, and 3 dB worse with few samples and glass).
 *
 * Several views: before and after. Where all have an albedo, the views share albedo and
 * normals (denoise_share.c), which are cleaned; the grain that they explain is taken out
 * of each view's colours (denoise_variate.c), and what is left is denoised, to be mixed
 * with the view denoised by itself. The picture is half of the merge of these, a quarter
 * of the merge of what was left, denoised, and a quarter of the merge with all the
 * grain, denoised.
 *
 * Without albedos each view is denoised twice: its own samples, which keep what other
 * views do not show, and those that the views share, which have the grain of all of
 * them. The picture is half of their merge and half of the merge with all the grain,
 * denoised. Errors of all these differ, and a mean is better than each.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "denoise.h"
#include "denoise_share.h"
#include "denoise_variate.h"
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

/* ---- several views ------------------------------------------------------------------
 */

/* Px that points at the depths of a view move as the eye does; false: not known. */
static bool find_shifts(const struct run *run, const struct rf_view *view, float *shift)
{
    const struct rf_lens *lens = rf_filter_lens(run->filter);
    const struct rf_image out =
        rf_image_packed(shift, run->source.width, run->source.height, 1);
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    const double per_plane = view->shear_distance > 0 ? 1 / view->shear_distance : 0;
    if (rf_filter_planar_depth(run->filter, &view->depth, &out, NULL) != RF_OK)
        return false;
    const bool is_perspective = lens->projection == RF_PROJECTION_PERSPECTIVE;
    for (size_t i = 0; i < n; i++)
        shift[i] =
            (float)(is_perspective ? lens->focal_length_px * (per_plane - 1 / shift[i])
                                   : lens->px_per_unit * (shift[i] * per_plane - 1));
    return true;
}

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
                            .n_threads = run->n_threads};
    share->views = app_memory((size_t)run->views.n, sizeof(*share->views), run->error);
    for (int j = 0; j < run->views.n && share->views; j++) {
        const struct rf_view *view = &run->views.views[j];
        struct share_view *to = &share->views[j];
        float *shift = app_memory(n, sizeof(float), run->error);
        to->samples = view->colour.data;
        to->shift_px = shift;
        memcpy(to->offset, view->lens_offset, sizeof(to->offset));
        if (!shift || !denoise_read_guides(&run->views.sources[j], run->n_threads,
                                           &to->guides, run->error))
            return app_code_of(run->error);
        if (!find_shifts(run, view, shift))
            for (size_t i = 0; i < n; i++)
                shift[i] = NAN;
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

/* Room for albedo and normals where a view has them. */
static bool make_guides(const struct share *share, const struct denoise_guides *like,
                        struct denoise_guides *guides, struct image_error *error)
{
    const size_t n = (size_t)share->width * (size_t)share->height;
    *guides = (struct denoise_guides){0};
    if (like->albedo)
        guides->albedo = app_memory(n, 3 * sizeof(float), error);
    if (like->normal && guides->albedo)
        guides->normal = app_memory(n, 3 * sizeof(float), error);
    return !like->albedo == !guides->albedo && !like->normal == !guides->normal;
}

/* Room for one view: pixels, and how many views share each. */
struct denoise_room {
    float *own, *left, *n_shared;
    struct denoise_guides guides;
};

static bool make_room(const struct share *share, int j, struct denoise_room *room,
                      struct image_error *error)
{
    const size_t n = (size_t)share->width * (size_t)share->height;
    *room = (struct denoise_room){
        .own = app_memory(n, (size_t)share->n_channels * sizeof(float), error),
        .left = app_memory(n, (size_t)share->n_channels * sizeof(float), error),
        .n_shared = app_memory(n, sizeof(float), error)};
    return room->own && room->left && room->n_shared &&
           make_guides(share, &share->views[j].guides, &room->guides, error);
}

static void free_room(struct denoise_room *room)
{
    denoise_free_guides(&room->guides);
    free(room->own);
    free(room->left);
    free(room->n_shared);
}

/* Do all views have an albedo? */
static bool has_albedos(const struct share *share)
{
    for (int j = 0; j < share->n; j++)
        if (!share->views[j].guides.albedo)
            return false;
    return true;
}

/*
 * How far n views that share a pixel tell what is clean: (1 - 1/n)^2, 1 from eight on.
 * Two views of 32 samples each would lose 0.6 dB on plane by 1; eight of 2 samples gain
 * 0.5 dB there against 49/64, 0 to 0.1 on others (docs/notebook/rivals.md).
 */
static float share_weight(float n)
{
    const float gain = (1 - 1 / n) / (1 - 1.0f / 8);
    return fminf(gain * gain, 1);
}

/* to + w (from - to), w = share_weight() of the views that share a pixel. */
static void mix_by_shared(const struct share *share, const float *n_shared,
                          const float *from, float *to)
{
    const size_t n_channels = (size_t)share->n_channels;
    const size_t n = (size_t)share->width * (size_t)share->height;
    for (size_t i = 0; i < n; i++) {
        const float w = share_weight(n_shared[i]);
        for (size_t k = n_channels * i; k < n_channels * (i + 1); k++)
            to[k] += w * (from[k] - to[k]);
    }
}

/*
 * View j without grain, in `made`, and in place of its samples these without the grain
 * that albedo and normals explain: nobody shares them afterwards. Both as far as other
 * views tell what is clean.
 */
static bool denoise_by_guides(struct run *run, struct denoiser *denoiser,
                              const struct share *share, int j,
                              const struct denoise_room *room, float *made)
{
    const size_t n_bytes = (size_t)share->width * (size_t)share->height *
                           (size_t)share->n_channels * sizeof(float);
    float *samples = run->views.views[j].colour.data;
    const struct denoise_picture to = {made, share->width, share->height,
                                       share->n_channels,
                                       image_path(run->views.sources[j].colour)};
    struct denoise_picture own = to;
    struct denoise_guides clean = room->guides;
    struct variates variates = {.picture = to,
                                .denoised = made,
                                .sampled = &share->views[j].guides,
                                .clean = &clean,
                                .n_threads = run->n_threads};
    variates.picture.samples = samples;
    memcpy(made, samples, n_bytes);
    if (!denoise_clean_guides(denoiser, &to, &clean, run->error) ||
        !denoise_picture(denoiser, &to, &clean, run->error) ||
        !variates_remove(&variates, room->left, run->error))
        return false;
    own.samples = room->own;
    memcpy(room->own, samples, n_bytes);
    mix_by_shared(share, room->n_shared, room->left, samples);
    if (!denoise_picture(denoiser, &own, &share->views[j].guides, run->error))
        return false;
    own.samples = room->left;
    if (!denoise_picture(denoiser, &own, &clean, run->error))
        return false;
    memcpy(made, room->own, n_bytes);
    mix_by_shared(share, room->n_shared, room->left, made);
    return true;
}

/*
 * View j without grain, in `made`, of colours alone: its own samples and those that n
 * views share, each denoised by its own guides and weighted by 1 - w and
 * w = (1 - 1/n)^2 / 2: shared ones are as good or better where n is large; two views of
 * plane lose 0.5 dB by halves.
 */
static bool denoise_by_colours(struct run *run, struct denoiser *denoiser,
                               const struct share *share, int j,
                               const struct denoise_room *room, float *made)
{
    const size_t n_channels = (size_t)share->n_channels;
    const size_t n = (size_t)share->width * (size_t)share->height * n_channels;
    const struct denoise_picture shared = {made, share->width, share->height,
                                           share->n_channels,
                                           image_path(run->views.sources[j].colour)};
    struct denoise_picture own = shared;
    own.samples = room->own;
    memcpy(own.samples, share->views[j].samples, n * sizeof(float));
    if (!denoise_picture(denoiser, &own, &share->views[j].guides, run->error) ||
        !denoise_picture(denoiser, &shared, &room->guides, run->error))
        return false;
    for (size_t i = 0; i < n; i++) {
        const float gain = 1 - 1 / room->n_shared[i / n_channels];
        made[i] = room->own[i] + gain * gain / 2 * (made[i] - room->own[i]);
    }
    return true;
}

static int denoise_view(struct run *run, struct denoiser *denoiser,
                        const struct share *share, int j, float *made)
{
    struct denoise_room room;
    bool is_done = make_room(share, j, &room, run->error);
    if (is_done) {
        run->shared_views +=
            share_collect(share, j, made, room.n_shared, &room.guides) / share->n;
        is_done = has_albedos(share)
                      ? denoise_by_guides(run, denoiser, share, j, &room, made)
                      : denoise_by_colours(run, denoiser, share, j, &room, made);
    }
    free_room(&room);
    return code_of(run, is_done);
}

/* All views without grain, into `made`, one after the other. */
static int denoise_shared(struct run *run, struct denoiser *denoiser,
                          const struct share *share, float *made)
{
    const size_t n =
        (size_t)share->width * (size_t)share->height * (size_t)share->n_channels;
    int code = APP_DONE;
    for (int j = 0; j < share->n && code == APP_DONE; j++) {
        code = denoise_view(run, denoiser, share, j, made + n * (size_t)j);
        app_progress((void *)run->tool->host, (j + 1.0) / share->n);
    }
    return code;
}

/* The same; *has_left: the views have become what albedos and normals do not explain. */
static int denoise_views(struct run *run, struct denoiser *denoiser, float *made,
                         bool *has_left)
{
    struct share share;
    app_begin(run->tool->host, "denoising");
    int code = open_share(run, &share);
    if (code == APP_DONE) {
        *has_left = has_albedos(&share);
        code = denoise_shared(run, denoiser, &share, made);
    }
    close_share(&share);
    app_end(run->tool->host);
    return code;
}

/* Merges the views as they are into `merged`, and denoises that. */
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

static void take_mean(float *to, const float *from, size_t n)
{
    for (size_t i = 0; i < n; i++)
        to[i] = (to[i] + from[i]) / 2;
}

/* With room for a picture in `merged` and for one of each view in `made`. */
static int run_views(struct run *run, struct denoiser *denoiser,
                     int (*make_picture)(struct run *run, float *samples),
                     float *merged, float *made)
{
    const size_t n = (size_t)run->source.width * (size_t)run->source.height *
                     (size_t)run->source.n_channels;
    bool has_left = false;
    int code = merge_and_denoise(run, denoiser, make_picture, merged);
    if (code == APP_DONE)
        code = denoise_views(run, denoiser, made, &has_left);
    if (code == APP_DONE && has_left) {
        code = merge_and_denoise(run, denoiser, make_picture, run->colour);
        take_mean(merged, run->colour, n);
    }
    if (code != APP_DONE)
        return code;
    for (int j = 0; j < run->views.n; j++)
        memcpy(run->views.views[j].colour.data, made + n * (size_t)j,
               n * sizeof(float));
    code = make_picture(run, run->colour);
    take_mean(run->colour, merged, n);
    return code;
}

static int denoise_and_merge(struct run *run, struct denoiser *denoiser,
                             int (*make_picture)(struct run *run, float *samples))
{
    const size_t n = (size_t)run->source.width * (size_t)run->source.height *
                     (size_t)run->source.n_channels;
    float *merged = app_memory(n, sizeof(*merged), run->error);
    float *made =
        merged ? app_memory((size_t)run->views.n, n * sizeof(float), run->error) : NULL;
    const int code =
        made ? run_views(run, denoiser, make_picture, merged, made) : APP_NO_MEMORY;
    free(merged);
    free(made);
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
        code = denoise_and_merge(run, denoiser, make_picture);
    } else {
        code = denoise_source(run, denoiser, &run->source, run->colour);
        if (code == APP_DONE)
            code = make_picture(run, run->colour);
    }
    denoiser_close(denoiser);
    return code;
}
