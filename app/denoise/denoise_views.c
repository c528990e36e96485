/* SPDX-License-Identifier: Apache-2.0 */
#include "denoise/denoise_views.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "denoise/denoise_background.h"
#include "denoise/denoise_seeds.h"

/*
 * What is added of all views' light has one error in all of them, and what each view has
 * by itself an error of its own, which merging averages out: 1 is as good on renders, and
 * up to 0.6 dB worse on patterns with the grain of a normal distribution.
 */
static const float MOST_LEFT = 0.75f;

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

/* Room for one view: pixels, how many views share each, and their albedo and normals. */
struct room {
    float *shared, *n_shared;
    struct denoise_guides guides;
};

static bool make_room(const struct share *share, int j, struct room *room,
                      struct image_error *error)
{
    const size_t n = (size_t)share->width * (size_t)share->height;
    *room = (struct room){
        .shared = app_memory(n, (size_t)share->n_channels * sizeof(float), error),
        .n_shared = app_memory(n, sizeof(float), error)};
    return room->shared && room->n_shared &&
           make_guides(share, &share->views[j].guides, &room->guides, error);
}

static void free_room(struct room *room)
{
    denoise_free_guides(&room->guides);
    free(room->shared);
    free(room->n_shared);
}

static bool have_albedos(const struct share *share)
{
    for (int j = 0; j < share->n; j++)
        if (!share->views[j].guides.albedo)
            return false;
    return true;
}

/* A view, with its samples or with others. */
static struct denoise_picture picture_of(const struct denoise_views *views, int j,
                                         float *samples)
{
    const struct share *share = &views->share;
    return (struct denoise_picture){samples,           share->width,    share->height,
                                    share->n_channels, views->names[j], share->white};
}

/* Of all samples of a view. */
static size_t n_samples(const struct share *share)
{
    return (size_t)share->width * (size_t)share->height * (size_t)share->n_channels;
}

/* Goes on after `done` of all steps; false: the caller wants to stop. */
static bool go_on(const struct denoise_views *views, int done, int all)
{
    return !views->progress || views->progress(views->user, done / (double)all);
}

/* ---- of colours, albedo and normals --------------------------------------------- */

/*
 * View j without grain, in `made`: denoised by the albedo and the normals that the views
 * share, which are cleaned and come back in `guides`.
 */
static bool denoise_alone(struct denoiser *denoiser, struct denoise_views *views, int j,
                          struct denoise_guides *guides, float *made,
                          struct image_error *error)
{
    const struct share *share = &views->share;
    const struct denoise_picture to = picture_of(views, j, made);
    if (!make_guides(share, &share->views[j].guides, guides, error))
        return false;
    views->n_shared += share_collect(share, j, made, NULL, guides) / share->n;
    memcpy(made, share->views[j].samples, n_samples(share) * sizeof(float));
    return denoise_clean_guides(denoiser, &to, guides, error) &&
           denoise_picture(denoiser, &to, guides, error);
}

/*
 * Gives `made` what the denoiser left of the light, from all views: the mean of what is
 * `left` of those that share a pixel is added to view j, and denoised with it. It counts
 * by the square of how many share it, (n - 1) / (all - 1), and MOST_LEFT.
 */
static bool add_left(struct denoiser *denoiser, const struct denoise_views *views,
                     const struct share *left, int j,
                     const struct denoise_guides *guides, float *made,
                     struct image_error *error)
{
    const size_t n = n_samples(left), n_channels = (size_t)left->n_channels;
    struct room room;
    bool is_done = make_room(left, j, &room, error);
    if (is_done) {
        const struct denoise_picture to = picture_of(views, j, room.shared);
        share_collect(left, j, room.shared, room.n_shared, &room.guides);
        for (size_t i = 0; i < n; i++)
            room.shared[i] += made[i];
        is_done = denoise_picture(denoiser, &to, guides, error);
        for (size_t i = 0; i < n && is_done; i++) {
            const float share =
                (room.n_shared[i / n_channels] - 1) / (float)(left->n - 1);
            const float w = MOST_LEFT * share * share;
            made[i] += w * (room.shared[i] - made[i]);
        }
    }
    free_room(&room);
    return is_done;
}

/* What the clean views lack of the samples, as views that share pixels as those do. */
static bool find_left(const struct share *share, float *const *made, struct share *left,
                      struct image_error *error)
{
    const size_t n = n_samples(share);
    *left = *share;
    left->views = app_memory((size_t)share->n, sizeof *left->views, error);
    bool is_complete = left->views;
    for (int j = 0; j < share->n && is_complete; j++) {
        float *samples = app_memory(n, sizeof *samples, error);
        for (size_t i = 0; i < n && samples; i++)
            samples[i] = share->views[j].samples[i] - made[j][i];
        left->views[j] = share->views[j];
        left->views[j].samples = samples;
        left->views[j].guides = (struct denoise_guides){0};
        is_complete = samples;
        if (!is_complete)
            left->n = j;
    }
    return is_complete;
}

static void free_left(struct share *left)
{
    for (int j = 0; j < left->n && left->views; j++)
        free((float *)left->views[j].samples);
    free(left->views);
}

static int add_all_left(struct denoiser *denoiser, const struct denoise_views *views,
                        const struct denoise_guides *guides, float *const *made,
                        struct image_error *error)
{
    const int n = views->share.n;
    struct share left;
    int code =
        find_left(&views->share, made, &left, error) ? APP_DONE : app_code_of(error);
    for (int j = 0; j < n && code == APP_DONE; j++) {
        if (!add_left(denoiser, views, &left, j, &guides[j], made[j], error))
            code = app_code_of(error);
        else if (!go_on(views, n + j + 1, 2 * n))
            code = APP_INTERRUPTED;
    }
    free_left(&left);
    return code;
}

static int denoise_by_guides(struct denoiser *denoiser, struct denoise_views *views,
                             float *const *made, struct image_error *error)
{
    const int n = views->share.n;
    struct denoise_guides *guides = app_memory((size_t)n, sizeof *guides, error);
    int code = guides ? APP_DONE : app_code_of(error);
    for (int j = 0; guides && j < n; j++)
        guides[j] = (struct denoise_guides){0};
    for (int j = 0; j < n && code == APP_DONE; j++) {
        if (!denoise_alone(denoiser, views, j, &guides[j], made[j], error))
            code = app_code_of(error);
        else if (!go_on(views, j + 1, n > 1 ? 2 * n : n))
            code = APP_INTERRUPTED;
    }
    if (code == APP_DONE)
        views->have_one_seed = denoise_have_one_seed(&views->share, made);
    if (code == APP_DONE && n > 1)
        code = add_all_left(denoiser, views, guides, made, error);
    for (int j = 0; guides && j < n; j++)
        denoise_free_guides(&guides[j]);
    free(guides);
    return code;
}

/* ---- of colours alone ----------------------------------------------------------- */

/*
 * View j without grain, in `made`: its own samples and those that n views share, each
 * denoised by its own guides and weighted by 1 - w and w = (1 - 1/n)^2 / 2: shared ones
 * are as good or better where n is large; two views of plane lose 0.5 dB by halves.
 */
static bool denoise_by_colours(struct denoiser *denoiser, struct denoise_views *views,
                               int j, float *made, struct image_error *error)
{
    const struct share *share = &views->share;
    const size_t n = n_samples(share), n_channels = (size_t)share->n_channels;
    struct room room;
    bool is_done = make_room(share, j, &room, error);
    if (is_done) {
        const struct denoise_picture own = picture_of(views, j, made),
                                     shared = picture_of(views, j, room.shared);
        views->n_shared +=
            share_collect(share, j, room.shared, room.n_shared, &room.guides) /
            share->n;
        memcpy(made, share->views[j].samples, n * sizeof(float));
        is_done = denoise_picture(denoiser, &own, &share->views[j].guides, error) &&
                  denoise_picture(denoiser, &shared, &room.guides, error);
        for (size_t i = 0; i < n && is_done; i++) {
            const float gain = 1 - 1 / room.n_shared[i / n_channels];
            made[i] += gain * gain / 2 * (room.shared[i] - made[i]);
        }
    }
    free_room(&room);
    return is_done;
}

static int denoise_by(struct denoiser *denoiser, struct denoise_views *views,
                      float *const *made, struct image_error *error)
{
    const int n = views->share.n;
    if (have_albedos(&views->share)) {
        const struct denoise_picture first =
            picture_of(views, 0, (float *)views->share.views[0].samples);
        denoise_judge_grain(denoiser, &first, &views->share.views[0].guides);
        return denoise_by_guides(denoiser, views, made, error);
    }
    for (int j = 0; j < n; j++) {
        if (!denoise_by_colours(denoiser, views, j, made[j], error))
            return app_code_of(error);
        if (!go_on(views, j + 1, n))
            return APP_INTERRUPTED;
    }
    views->have_one_seed = denoise_have_one_seed(&views->share, made);
    return APP_DONE;
}

int denoise_views(struct denoiser *denoiser, struct denoise_views *views,
                  float *const *made, struct image_error *error)
{
    const struct share *share = &views->share;
    views->n_shared = 0;
    views->have_one_seed = false;
    const int code = denoise_by(denoiser, views, made, error);
    for (int j = 0; j < share->n && code == APP_DONE; j++) {
        const struct denoise_picture grainy =
            picture_of(views, j, (float *)share->views[j].samples);
        denoise_keep_background(&grainy, &share->views[j].guides, made[j],
                                share->n_threads);
    }
    return code;
}
