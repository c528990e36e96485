/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reflections, and what is seen through glass (docs/algorithm.md, Reflections). Light
 * adds up, so the picture is the sum of pictures:
 *
 *   out = B(c - sum of l_k, z) + sum of B(l_k, d_k)
 *
 *   B(c, z)  the lens' picture of the colours c at the depths z
 *   l_k      light that is mirrored or let through, where its depth s_k is known
 *   d_k      s_k there; beside it min(z, depth of the surface of the nearest such pixel)
 *
 * A mirror shows a room behind a hole in the wall. What is not the mirror is dark in
 * l_k: what stands before it hides the room as it hides the mirror, and all else is the
 * wall, which must stand where the mirror is and no farther: then it cuts the room off
 * where the lens does. Exact for flat mirrors; of curved ones where the light has one
 * distance. An image before its surface would spill over the wall: the light keeps the
 * depth of the surface. Several views are merged so: what the frame of a mirror hides
 * from one of them another sees.
 * Ours. Cost: a picture for the rest and one for each light that is there.
 */
#include "api/seen.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "input/depth.h"
#include "input/image.h"
#include "rackfocus/rackfocus.h"

/* Neighbours of the median: 5 x 5. */
enum { MEDIAN_PX = 2 };

/* A view, and what of it goes into a picture. */
struct seen_view {
    const struct rf_view *view;
    float *surface; /* planar distances */
    float *mirror;  /* of each light: as mirror_at() has it */
    float *depth;   /* of the light's picture */
    float *colour;  /* of the rest, then of the light */
};

/* The pictures of views, and room for them. */
struct seen_pictures {
    const struct rf_frame *frame;
    const struct rf_image *out;
    int width, height, n_channels, n_seen, n_views;
    size_t n_pixels;
    bool is_used[RF_MAX_SEEN];
    int k;         /* the light whose picture is made */
    float *memory; /* of all views */
    float *made;   /* a light's picture */
    int32_t *wall; /* the nearest pixel where the light has a depth, or -1 */
    struct seen_view views[RF_MAX_VIEWS];
    struct rf_view parts[RF_MAX_VIEWS]; /* of the views, for one picture */
};

/* ---- checks -------------------------------------------------------------------- */

rf_result rf_seen_check_light(const struct rf_frame *f, const struct rf_view *view,
                              const struct rf_seen_light *light, struct rf_error *error)
{
    int n = view->colour.channels == 1 ? 1 : 3;
    rf_result result =
        rf_image_check(&light->colour, "seen", f->width, f->height, error);
    if (result == RF_OK)
        result = rf_image_check_one(&light->depth, "seen", f->width, f->height, error);
    if (result == RF_OK && light->colour.channels != n)
        return rf_fail(error, RF_ERROR_ARGUMENT, "seen",
                       "a seen light has %d channels; beside %d of the colour it must "
                       "have %d",
                       light->colour.channels, view->colour.channels, n);
    for (int y = 0; y < f->height && result == RF_OK; y++)
        for (int x = 0; x < f->width; x++)
            for (int c = 0; c < n; c++)
                if (!isfinite(*rf_image_at(&light->colour, x, y, c)))
                    return rf_fail(error, RF_ERROR_PIXEL, "seen",
                                   "a seen light is not finite at pixel (%d, %d)", x,
                                   y);
    return result;
}

static rf_result check_view(const struct rf_frame *frame, const struct rf_view *view,
                            struct rf_error *error)
{
    if (view->n_seen == 0)
        return RF_OK;
    if (view->n_seen < 0 || view->n_seen > RF_MAX_SEEN || !view->seen)
        return rf_fail(error, RF_ERROR_ARGUMENT, "seen",
                       "%d seen lights are %s; give 0 to %d", view->n_seen,
                       view->seen ? "too many" : "said to be at NULL", RF_MAX_SEEN);
    rf_result result = RF_OK;
    for (int k = 0; k < view->n_seen && result == RF_OK; k++)
        result = rf_seen_check_light(frame, view, &view->seen[k], error);
    return result;
}

rf_result rf_seen_check(const struct rf_frame *frame, const struct rf_view *views,
                        int n_views, struct rf_error *error)
{
    rf_result result = RF_OK;
    for (int j = 0; j < n_views && result == RF_OK; j++) {
        if (views[j].n_seen != views[0].n_seen)
            return rf_fail(
                error, RF_ERROR_ARGUMENT, "seen",
                "view %d has %d seen lights and view 0 has %d; give each the "
                "same lights",
                j, views[j].n_seen, views[0].n_seen);
        result = check_view(frame, &views[j], error);
    }
    return result;
}

/* ---- colours ------------------------------------------------------------------- */

/*
 * The depth of the mirror at a pixel of it: the median of those around it, since pixels
 * on its edge may have the depth of what is beside them; INFINITY beside a mirror.
 */
static float mirror_at(const struct seen_pictures *s, const struct seen_view *v, int k,
                       int x, int y)
{
    const struct rf_image *depth = &v->view->seen[k].depth;
    float sorted[(2 * MEDIAN_PX + 1) * (2 * MEDIAN_PX + 1)];
    int n = 0;
    if (!(*rf_image_at(depth, x, y, 0) > 0))
        return INFINITY;
    for (int b = rf_max_int(y - MEDIAN_PX, 0);
         b <= rf_min_int(y + MEDIAN_PX, s->height - 1); b++)
        for (int a = rf_max_int(x - MEDIAN_PX, 0);
             a <= rf_min_int(x + MEDIAN_PX, s->width - 1); a++) {
            if (!(*rf_image_at(depth, a, b, 0) > 0))
                continue;
            float z = v->surface[(size_t)b * (size_t)s->width + (size_t)a];
            int at = n++;
            for (; at > 0 && sorted[at - 1] > z; at--)
                sorted[at] = sorted[at - 1];
            sorted[at] = z;
        }
    return sorted[n / 2];
}

static void find_mirrors(void *data, int64_t begin, int64_t end, int thread)
{
    const struct seen_pictures *s = data;
    (void)thread;
    for (int64_t row = begin; row < end; row++) {
        const struct seen_view *v = &s->views[row / s->height];
        int y = (int)(row % s->height);
        for (int k = 0; k < s->n_seen; k++)
            for (int x = 0; x < s->width; x++)
                v->mirror[s->n_pixels * (size_t)k + (size_t)y * (size_t)s->width +
                          (size_t)x] = mirror_at(s, v, k, x, y);
    }
}

/* Of light k at a pixel, where it has a depth of its own; else 0. */
static inline float depth_at(const struct seen_pictures *s, const struct seen_view *v,
                             int k, int x, int y)
{
    float z = *rf_image_at(&v->view->seen[k].depth, x, y, 0);
    size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    return z > v->mirror[s->n_pixels * (size_t)k + i] ? z : 0;
}

/* The rest: the colours without the lights that have a depth. */
static void take_rest(struct seen_pictures *s, const struct seen_view *v)
{
    int n_light = s->n_channels == 1 ? 1 : 3;
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            size_t i = (size_t)y * (size_t)s->width + (size_t)x;
            float *to = v->colour + i * (size_t)s->n_channels;
            for (int c = 0; c < s->n_channels; c++)
                to[c] = *rf_image_at(&v->view->colour, x, y, c);
            for (int k = 0; k < s->n_seen; k++) {
                if (depth_at(s, v, k, x, y) <= 0)
                    continue;
                s->is_used[k] = true;
                for (int c = 0; c < n_light; c++)
                    to[c] -= *rf_image_at(&v->view->seen[k].colour, x, y, c);
            }
        }
}

/* The light alone, opaque, and dark where it has no depth. */
static void take_light(struct seen_pictures *s, const struct seen_view *v)
{
    const struct rf_image *light = &v->view->seen[s->k].colour;
    int n_light = s->n_channels == 1 ? 1 : 3;
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            size_t i = (size_t)y * (size_t)s->width + (size_t)x;
            float *to = v->colour + i * (size_t)s->n_channels;
            float z = depth_at(s, v, s->k, x, y);
            for (int c = 0; c < s->n_channels; c++)
                to[c] = c >= n_light ? 1 : z > 0 ? *rf_image_at(light, x, y, c) : 0;
            v->depth[i] = z;
            s->wall[i] = z > 0 ? (int32_t)i : -1;
        }
}

/* ---- the wall ------------------------------------------------------------------ */

static int64_t squared_distance(int width, int x, int y, int32_t to)
{
    int64_t dx = to % width - x, dy = to / width - y;
    return dx * dx + dy * dy;
}

/* Takes the wall of the pixel at (x + dx, y + dy) where that is nearer. */
static void take_nearer(struct seen_pictures *s, int x, int y, int dx, int dy)
{
    int width = s->width, a = x + dx, b = y + dy;
    if (a < 0 || b < 0 || a >= width || b >= s->height)
        return;
    int32_t *own = &s->wall[(ptrdiff_t)y * width + x];
    int32_t other = s->wall[(ptrdiff_t)b * width + a];
    if (other >= 0 && (*own < 0 || squared_distance(width, x, y, other) <
                                       squared_distance(width, x, y, *own)))
        *own = other;
}

/* The nearest pixel of the light, handed from neighbour to neighbour (Danielsson 1980:
 * a pixel may get one that is farther by a fraction of a pixel). */
static void find_walls(struct seen_pictures *s)
{
    int width = s->width, height = s->height;
    for (int sign = 1; sign >= -1; sign -= 2)
        for (int t = 0; t < height; t++) {
            int y = sign > 0 ? t : height - 1 - t;
            for (int u = 0; u < width; u++) {
                int x = sign > 0 ? u : width - 1 - u;
                take_nearer(s, x, y, -sign, 0);
                for (int dx = -1; dx <= 1; dx++)
                    take_nearer(s, x, y, dx, -sign);
            }
            for (int u = width - 1; u >= 0; u--)
                take_nearer(s, sign > 0 ? u : width - 1 - u, y, sign, 0);
        }
}

/* Puts what is not the light where it hides the light as the mirror's frame does. */
static void set_walls(const struct seen_pictures *s, const struct seen_view *v)
{
    const float *mirror = v->mirror + s->n_pixels * (size_t)s->k;
    for (size_t i = 0; i < s->n_pixels; i++)
        if (v->depth[i] <= 0)
            v->depth[i] = s->wall[i] >= 0
                              ? rf_min_float(v->surface[i], mirror[s->wall[i]])
                              : v->surface[i];
}

/* ---- pictures ------------------------------------------------------------------ */

static void add_picture(const struct seen_pictures *s)
{
    int n_light = s->n_channels == 1 ? 1 : 3;
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            const float *from = s->made + ((size_t)y * (size_t)s->width + (size_t)x) *
                                              (size_t)s->n_channels;
            for (int c = 0; c < n_light; c++)
                *(float *)rf_image_at(s->out, x, y, c) += from[c];
        }
}

/* Makes the picture of a light, and adds it. */
static rf_result add_light(struct seen_pictures *s, const struct rf_progress *progress,
                           rf_process_fn process, struct rf_error *error)
{
    struct rf_frame f = *s->frame;
    f.params.depth = RF_DEPTH_PLANAR;
    f.params.depth_scale = 1;
    f.params.depth_offset = 0;
    f.params.optics = RF_OPTICS_CAMERA; /* the lens is resolved */
    for (int j = 0; j < s->n_views; j++) {
        const struct seen_view *v = &s->views[j];
        take_light(s, v);
        find_walls(s);
        set_walls(s, v);
        s->parts[j] = (struct rf_view){
            .size = sizeof s->parts[j],
            .colour = rf_image_packed(v->colour, s->width, s->height, s->n_channels),
            .depth = rf_image_packed(v->depth, s->width, s->height, 1),
            .lens_offset = {v->view->lens_offset[0], v->view->lens_offset[1]},
            .shear_distance = v->view->shear_distance};
    }
    const struct rf_image made =
        rf_image_packed(s->made, s->width, s->height, s->n_channels);
    rf_result result = process(&f, s->parts, s->n_views, &made, progress, error);
    if (result == RF_OK)
        add_picture(s);
    return result;
}

static rf_result make_pictures(struct seen_pictures *s,
                               const struct rf_progress *progress,
                               rf_process_fn process, struct rf_error *error)
{
    const struct rf_frame *f = s->frame;
    struct rf_progress_part part = {progress, 0, 1};
    const struct rf_progress own = {rf_progress_report_part, &part};
    rf_parallel(f->context, (int64_t)s->n_views * s->height, RF_EQUAL_PARTS,
                find_mirrors, s);
    for (int j = 0; j < s->n_views; j++) {
        take_rest(s, &s->views[j]);
        s->parts[j] = *s->views[j].view;
        s->parts[j].colour =
            rf_image_packed(s->views[j].colour, s->width, s->height, s->n_channels);
        s->parts[j].n_seen = 0;
    }
    for (int k = 0; k < s->n_seen; k++)
        part.n += s->is_used[k];
    rf_result result =
        process(f, s->parts, s->n_views, s->out, progress ? &own : NULL, error);
    for (int k = 0; k < s->n_seen && result == RF_OK; k++) {
        if (!s->is_used[k])
            continue;
        part.i++;
        s->k = k;
        result = add_light(s, progress ? &own : NULL, process, error);
    }
    return result;
}

/* Gives the views their room, and finds their surfaces. */
static rf_result begin(struct seen_pictures *s, const struct rf_view *views,
                       struct rf_error *error)
{
    size_t n = s->n_pixels, n_colour = n * (size_t)s->n_channels;
    size_t n_view = (2 + (size_t)s->n_seen) * n + n_colour;
    size_t n_floats = n_view * (size_t)s->n_views + n + n_colour;
    float *at = s->memory = rf_alloc(s->frame->context, n_floats, sizeof *at);
    if (!at)
        return rf_fail_memory(error, n_floats, sizeof *at);
    s->wall = (int32_t *)at;
    s->made = at + n;
    at += n + n_colour;
    rf_result result = RF_OK;
    for (int j = 0; j < s->n_views && result == RF_OK; j++, at += n_view) {
        s->views[j] = (struct seen_view){.view = &views[j],
                                         .surface = at,
                                         .depth = at + n,
                                         .mirror = at + 2 * n,
                                         .colour = at + n_view - n_colour};
        /* `made` has room for the radii, which nobody needs. */
        result = rf_depth_to_radius(s->frame, &views[j].depth, s->made, at, NULL, NULL,
                                    error);
    }
    return result;
}

rf_result rf_seen_process(const struct rf_frame *frame, const struct rf_view *views,
                          int n_views, const struct rf_image *out,
                          const struct rf_progress *progress, rf_process_fn process,
                          struct rf_error *error)
{
    struct seen_pictures s = {.frame = frame,
                              .out = out,
                              .width = frame->width,
                              .height = frame->height,
                              .n_channels = views->colour.channels,
                              .n_seen = views->n_seen,
                              .n_views = n_views,
                              .n_pixels = (size_t)frame->width * (size_t)frame->height};
    rf_result result = begin(&s, views, error);
    if (result == RF_OK)
        result = make_pictures(&s, progress, process, error);
    rf_free(frame->context, s.memory);
    return result;
}
