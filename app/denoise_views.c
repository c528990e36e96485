/* SPDX-License-Identifier: Apache-2.0 */
#include "denoise_views.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "denoise_variate.h"
#include "report.h"

bool denoise_find_shifts(const struct rf_filter *filter, const struct rf_view *view,
                         float *shift, struct rf_error *error)
{
    const struct rf_lens *lens = rf_filter_lens(filter);
    const int32_t width = view->colour.width, height = view->colour.height;
    const struct rf_image out = rf_image_packed(shift, width, height, 1);
    const size_t n = (size_t)width * (size_t)height;
    const double per_plane = view->shear_distance > 0 ? 1 / view->shear_distance : 0;
    const bool is_known =
        rf_filter_planar_depth(filter, &view->depth, &out, error) == RF_OK;
    const bool is_perspective = lens->projection == RF_PROJECTION_PERSPECTIVE;
    for (size_t i = 0; i < n; i++)
        if (!is_known)
            shift[i] = NAN;
        else if (is_perspective)
            shift[i] = (float)(lens->focal_length_px * (per_plane - 1 / shift[i]));
        else
            shift[i] = (float)(lens->px_per_unit * (shift[i] * per_plane - 1));
    return is_known;
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

static bool have_albedos(const struct share *share)
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

/* A view, with its samples or with others. */
static struct denoise_picture picture_of(const struct denoise_views *views, int j,
                                         float *samples)
{
    const struct share *share = &views->share;
    return (struct denoise_picture){samples, share->width, share->height,
                                    share->n_channels, views->names[j]};
}

/* Of all samples of a view. */
static size_t n_samples(const struct share *share)
{
    return (size_t)share->width * (size_t)share->height * (size_t)share->n_channels;
}

/* The grain that guides explain, out of view j into room->left, which is denoised in
 * `made`. */
static bool remove_variates(const struct denoise_views *views, int j,
                            const struct denoise_room *room, const float *made,
                            struct image_error *error)
{
    /* The samples are read alone. */
    const struct variates variates = {
        .picture = picture_of(views, j, (float *)views->share.views[j].samples),
        .denoised = made,
        .sampled = &views->share.views[j].guides,
        .clean = &room->guides,
        .n_threads = views->share.n_threads};
    return variates_remove(&variates, room->left, error);
}

/*
 * View j without grain, in `made`: denoised by itself, and without the grain that albedo
 * and normals explain, as far as other views tell what is clean.
 */
static bool denoise_by_guides(struct denoiser *denoiser,
                              const struct denoise_views *views, int j,
                              struct denoise_room *room, float *made,
                              struct image_error *error)
{
    const struct share *share = &views->share;
    const size_t n_bytes = n_samples(share) * sizeof(float);
    const struct denoise_picture to = picture_of(views, j, made),
                                 own = picture_of(views, j, room->own),
                                 left = picture_of(views, j, room->left);
    memcpy(made, share->views[j].samples, n_bytes);
    memcpy(room->own, share->views[j].samples, n_bytes);
    if (!denoise_clean_guides(denoiser, &to, &room->guides, error) ||
        !denoise_picture(denoiser, &to, &room->guides, error) ||
        !remove_variates(views, j, room, made, error) ||
        !denoise_picture(denoiser, &own, &share->views[j].guides, error) ||
        !denoise_picture(denoiser, &left, &room->guides, error))
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
static bool denoise_by_colours(struct denoiser *denoiser,
                               const struct denoise_views *views, int j,
                               const struct denoise_room *room, float *made,
                               struct image_error *error)
{
    const struct share *share = &views->share;
    const size_t n = n_samples(share), n_channels = (size_t)share->n_channels;
    const struct denoise_picture shared = picture_of(views, j, made),
                                 own = picture_of(views, j, room->own);
    memcpy(room->own, share->views[j].samples, n * sizeof(float));
    if (!denoise_picture(denoiser, &own, &share->views[j].guides, error) ||
        !denoise_picture(denoiser, &shared, &room->guides, error))
        return false;
    for (size_t i = 0; i < n; i++) {
        const float gain = 1 - 1 / room->n_shared[i / n_channels];
        made[i] = room->own[i] + gain * gain / 2 * (made[i] - room->own[i]);
    }
    return true;
}

static bool denoise_view(struct denoiser *denoiser, struct denoise_views *views, int j,
                         float *made, struct image_error *error)
{
    const struct share *share = &views->share;
    struct denoise_room room;
    bool is_done = make_room(share, j, &room, error);
    if (is_done) {
        views->n_shared +=
            share_collect(share, j, made, room.n_shared, &room.guides) / share->n;
        is_done = have_albedos(share)
                      ? denoise_by_guides(denoiser, views, j, &room, made, error)
                      : denoise_by_colours(denoiser, views, j, &room, made, error);
    }
    free_room(&room);
    return is_done;
}

int denoise_views(struct denoiser *denoiser, struct denoise_views *views,
                  float *const *made, struct image_error *error)
{
    const int n = views->share.n;
    views->n_shared = 0;
    for (int j = 0; j < n; j++) {
        if (!denoise_view(denoiser, views, j, made[j], error))
            return app_code_of(error);
        if (views->progress && !views->progress(views->user, (j + 1.0) / n))
            return APP_INTERRUPTED;
    }
    return APP_DONE;
}
