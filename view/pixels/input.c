/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/input.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "parallel.h"
#include "pixels/relief.h"
#include "sources/deep.h"
#include "thread.h"

struct input *input_create(int32_t width, int32_t height, int n_channels, int n_views)
{
    struct input *input = app_memory(1, sizeof(*input), NULL);
    struct rf_view *views = app_memory((size_t)n_views, sizeof(*views), NULL);
    float **rays = app_memory((size_t)n_views, sizeof(*rays), NULL);
    if (!input || !views || !rays) {
        free(input);
        free(views);
        free(rays);
        return NULL;
    }
    *input = (struct input){.n_holders = 1,
                            .width = width,
                            .height = height,
                            .n_channels = n_channels,
                            .n_views = n_views};
    input->views = views;
    input->rays = rays;
    return input;
}

struct input *input_hold(struct input *input)
{
    __atomic_add_fetch(&input->n_holders, 1, __ATOMIC_RELAXED);
    return input;
}

void input_drop(struct input *input)
{
    if (!input || __atomic_sub_fetch(&input->n_holders, 1, __ATOMIC_ACQ_REL) > 0)
        return;
    for (int i = 0; i < input->n_views; i++) {
        free(input->views[i].colour.data);
        free(input->views[i].depth.data);
        free(input->rays[i]);
        if (input->view_planar)
            free(input->view_planar[i]);
    }
    free(input->view_planar);
    free(input->views);
    free(input->rays);
    for (int i = 0; i < input->n_others; i++)
        input_drop(input->others[i]);
    if (input->deep)
        deep_free(input->deep);
    free(input->deep);
    free(input->frame_rgba);
    free(input->frame_depth);
    free(input->planar);
    free(input->middle);
    free(input);
}

/* ---- frame buffers -------------------------------------------------------------- */

void input_fill_decoder(float decoder[256])
{
    for (int i = 0; i < 256; i++) {
        const double v = i / 255.0;
        decoder[i] = (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
    }
}

/* What the threads share that unpack a frame. */
struct unpacking {
    const struct input *input;
    float decoder[256];
    float *colour, *depth;
};

static void unpack_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct unpacking *u = data;
    const size_t w = (size_t)u->input->width, h = (size_t)u->input->height;
    for (size_t y = (size_t)begin; y < (size_t)end; y++) {
        const size_t from = (h - 1 - y) * w, to = y * w;
        for (size_t x = 0; x < w; x++)
            for (size_t c = 0; c < 3; c++)
                u->colour[3 * (to + x) + c] =
                    u->decoder[u->input->frame_rgba[4 * (from + x) + c]];
        memcpy(u->depth + to, u->input->frame_depth + from, w * sizeof(float));
    }
}

/* Turns what OpenGL gave upside down, and its colour into linear light. */
static bool unpack_frame(struct input *input)
{
    const int32_t w = input->width, h = input->height;
    const size_t n = (size_t)w * (size_t)h;
    float *colour = app_memory(n * 3, sizeof(float), NULL);
    float *depth = app_memory(n, sizeof(float), NULL);
    struct unpacking u = {.input = input, .colour = colour, .depth = depth};
    if (!colour || !depth) {
        free(colour);
        free(depth);
        return false;
    }
    input_fill_decoder(u.decoder);
    os_parallel(0, h, 0, unpack_rows, &u);
    input->views[0] = (struct rf_view){.colour = rf_image_packed(colour, w, h, 3),
                                       .depth = rf_image_packed(depth, w, h, 1)};
    free(input->frame_rgba);
    free(input->frame_depth);
    input->frame_rgba = NULL;
    input->frame_depth = NULL;
    return true;
}

static bool fail_memory(struct rf_error *error)
{
    *error = (struct rf_error){.code = RF_ERROR_MEMORY};
    snprintf(error->message, sizeof(error->message), "out of memory");
    return false;
}

/* ---- preparation ---------------------------------------------------------------- */

/* The range of depths, which threads look for together. */
struct range {
    const float *planar;
    float near, far; /* of what is finite; INFINITY and 0: nothing is */
    struct os_lock lock;
};

static void extend_range(void *data, int64_t begin, int64_t end, int thread)
{
    struct range *range = data;
    float near = INFINITY, far = 0;
    for (int64_t i = begin; i < end; i++) {
        const float z = range->planar[i];
        if (isfinite(z) && z > 0) {
            near = fminf(near, z);
            far = fmaxf(far, z);
        }
    }
    os_lock_take(&range->lock);
    range->near = fminf(range->near, near);
    range->far = fmaxf(range->far, far);
    os_lock_release(&range->lock);
}

static struct range range_of(const float *planar, size_t n)
{
    struct range range = {.planar = planar, .near = INFINITY};
    os_lock_init(&range.lock);
    os_parallel(0, (int64_t)n, 0, extend_range, &range);
    os_lock_destroy(&range.lock);
    return range;
}

static void find_range(struct input *input)
{
    const size_t n = (size_t)input->width * (size_t)input->height;
    const struct range range = range_of(input->planar, n);
    const bool is_empty = !isfinite(range.near);
    input->nearest = is_empty ? 1 : range.near;
    input->farthest = is_empty ? 1 : range.far;
}

/* What the threads share that make disparities. */
struct disparities {
    const float *planar;
    bool is_ortho;
    float far;
    float *at;
};

static void fill_disparities(void *data, int64_t begin, int64_t end, int thread)
{
    const struct disparities *d = data;
    for (int64_t i = begin; i < end; i++)
        d->at[i] = d->is_ortho ? fminf(d->planar[i], d->far) : -1 / d->planar[i];
}

/* What grows with the distance and moves px linearly: -1/z; z for orthographic cameras.
 */
static float *make_disparity(const struct input *input, const struct rf_lens *lens,
                             const float *planar)
{
    const size_t n = (size_t)input->width * (size_t)input->height;
    struct disparities d = {.planar = planar,
                            .is_ortho = lens->projection == RF_PROJECTION_ORTHOGRAPHIC,
                            .at = app_memory(n, sizeof(float), NULL)};
    if (!d.at)
        return NULL;
    d.far = range_of(planar, n).far;
    os_parallel(0, (int64_t)n, 0, fill_disparities, &d);
    return d.at;
}

/*
 * How px move from a view to where an eye at `to` on the lens (scene units) would see
 * them, the plane at distance `fixed` (0: none) staying where the middle of the lens
 * sees it. A place o on the lens sees depth z moved by o f_px (1/D - 1/z), D the plane
 * that its shear fixes (1/D = 0: none); with orthographic cameras by o p (z/D - 1).
 */
static struct relief find_relief(const struct rf_lens *lens, const struct rf_view *from,
                                 const double to[2], double fixed)
{
    struct relief relief = {0};
    const double by_new = fixed > 0 ? 1 / fixed : 0;
    const double by_old = from->shear_distance > 0 ? 1 / from->shear_distance : 0;
    for (int i = 0; i < 2; i++) {
        const double sign = i == 0 ? 1 : -1; /* up is towards smaller y */
        const double old = from->lens_offset[i];
        const double px = sign * (lens->projection == RF_PROJECTION_ORTHOGRAPHIC
                                      ? lens->px_per_unit
                                      : lens->focal_length_px);
        const double turned = px * (to[i] * by_new - old * by_old);
        const double moved = px * (to[i] - old);
        const bool is_ortho = lens->projection == RF_PROJECTION_ORTHOGRAPHIC;
        relief.slope[i] = is_ortho ? turned : moved;
        relief.base[i] = is_ortho ? -moved : turned;
    }
    return relief;
}

static int nearest_view(const struct input *input, const double place[2])
{
    int best = 0;
    double best_distance = INFINITY;
    for (int i = 0; i < input->n_views; i++) {
        const double *offset = input->views[i].lens_offset;
        const double distance = hypot(offset[0] - place[0], offset[1] - place[1]);
        if (distance < best_distance) {
            best_distance = distance;
            best = i;
        }
    }
    return best;
}

static bool find_planar(const struct input *input, const struct rf_filter *filter,
                        int view, float *planar, struct rf_error *error)
{
    const struct rf_image out = rf_image_packed(planar, input->width, input->height, 1);
    return rf_filter_planar_depth(filter, &input->views[view].depth, &out, error) ==
           RF_OK;
}

/* One that an earlier try without memory made stays. */
static bool make_plane(float **plane, size_t n)
{
    if (!*plane)
        *plane = app_memory(n, sizeof(float), NULL);
    return *plane != NULL;
}

/* The picture from the middle of the lens out of the view nearest to it. */
static bool find_middle(struct input *input, const struct rf_filter *filter,
                        struct rf_error *error)
{
    static const double centre[2] = {0, 0};
    const size_t n = (size_t)input->width * (size_t)input->height;
    if (!input->view_planar)
        input->view_planar =
            app_memory((size_t)input->n_views, sizeof(*input->view_planar), NULL);
    for (int i = 0; i < input->n_views; i++) {
        if (!input->view_planar || !make_plane(&input->view_planar[i], n))
            return fail_memory(error);
        if (!find_planar(input, filter, i, input->view_planar[i], error))
            return false;
    }
    const struct rf_lens *lens = rf_filter_lens(filter);
    const int nearest = nearest_view(input, centre);
    const struct rf_view *view = &input->views[nearest];
    const float *planar = input->view_planar[nearest];
    float *disparity = make_disparity(input, lens, planar);
    const struct relief relief = find_relief(lens, view, centre, 0);
    if (!disparity || !make_plane(&input->middle, n * (size_t)input->n_channels)) {
        free(disparity);
        return fail_memory(error);
    }
    relief_warp(&relief, input->width, input->height, input->n_channels, disparity,
                view->colour.data, planar, input->middle, input->planar);
    input->colour = input->middle;
    free(disparity);
    return true;
}

static bool prepare(struct input *input, const struct rf_filter *filter,
                    struct rf_error *error)
{
    const size_t n = (size_t)input->width * (size_t)input->height;
    if (!make_plane(&input->planar, n))
        return fail_memory(error);
    if (input->n_views > 1) {
        if (!find_middle(input, filter, error))
            return false;
    } else {
        if (!find_planar(input, filter, 0, input->planar, error))
            return false;
        input->colour = input->views[0].colour.data;
        input->raw = input->views[0].depth.data;
    }
    find_range(input);
    return true;
}

bool input_prepare(struct input *input, const struct rf_context *context,
                   const struct rf_params *params, struct rf_error *error)
{
    struct rf_filter *filter;
    if (input->is_prepared)
        return true;
    if (input->frame_rgba && !unpack_frame(input))
        return fail_memory(error);
    if (rf_filter_create(&filter, context, params, input->width, input->height,
                         error) != RF_OK)
        return false;
    input->is_prepared = prepare(input, filter, error);
    rf_filter_destroy(filter);
    return input->is_prepared;
}

bool input_see(const struct input *input, const struct rf_lens *lens,
               const double eye[2], float *out, int *view)
{
    static const struct rf_view middle;
    const double place[2] = {eye[0] * lens->lens_radius, eye[1] * lens->lens_radius};
    const bool is_single = input->n_views == 1;
    *view = is_single ? 0 : nearest_view(input, place);
    const struct rf_view *from = is_single ? &middle : &input->views[*view];
    const float *colour = is_single ? input->colour : from->colour.data;
    const float *planar = is_single ? input->planar : input->view_planar[*view];
    float *disparity = make_disparity(input, lens, planar);
    if (!disparity)
        return false;
    const struct relief relief = find_relief(lens, from, place, lens->focus_distance);
    relief_warp(&relief, input->width, input->height, input->n_channels, disparity,
                colour, NULL, out, NULL);
    free(disparity);
    return true;
}
