/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Several views of a lens whose surface in focus is no plane. A view from (u, v) of the
 * unit lens was sheared to a plane; a point of radius r, by that plane, lies in it at
 *
 *   X = x + u (a r + b),  Y = y - v (a r + b)        see struct rf_work_view
 *
 * The surface in focus adds g(P) to the radius of what is seen at the pixel P (field.c).
 * The ray of the lens point (u, v) that belongs to P meets that surface where the view
 * shows P - a g(P) (u, -v), so
 *
 *   V'(P) = V(P - a g(P) (u, -v))
 *
 * is the view sheared to the surface itself, and all that holds for planes holds for it
 * with the radius r + g. Ours; exact but for the interpolation.
 *
 * Colours are interpolated by Catmull and Rom's kernel, and linearly where it could
 * ring: beside what is CONTRAST times brighter. Linear weights also keep the light of a
 * lamp. Depths are those of the nearest pixel. Cost: 16 reads per pixel and channel.
 */
#include "input/field_views.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/field.h"
#include "input/image.h"
#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

/* What the negative weights, 1/16 and less, leave below a tenth of the darker side. */
static const float CONTRAST = 4;

enum { N_TAPS = 4 };

bool rf_field_moves_views(const struct rf_frame *frame, int n_views)
{
    return n_views > 1 && rf_field_is_on(&frame->params);
}

/* The places that a pixel of the new picture takes its value from. */
struct taps {
    int x[N_TAPS], y[N_TAPS]; /* within the picture */
    float wx[N_TAPS], wy[N_TAPS];
    float tx, ty; /* between the two in the middle */
    int nearest[2];
};

static void weigh(float t, float w[N_TAPS])
{
    w[0] = ((-0.5f * t + 1) * t - 0.5f) * t;
    w[1] = (1.5f * t - 2.5f) * t * t + 1;
    w[2] = ((-1.5f * t + 2) * t + 0.5f) * t;
    w[3] = (0.5f * t - 0.5f) * t * t;
}

static int within(int i, int n)
{
    return rf_min_int(rf_max_int(i, 0), n - 1);
}

static struct taps taps_at(float x, float y, const struct rf_frame *f)
{
    struct taps taps;
    /* So far outside all has the value of the edge. */
    x = rf_min_float(rf_max_float(x, -3), (float)f->width + 2);
    y = rf_min_float(rf_max_float(y, -3), (float)f->height + 2);
    float fx = floorf(x), fy = floorf(y);
    taps.tx = x - fx;
    taps.ty = y - fy;
    weigh(taps.tx, taps.wx);
    weigh(taps.ty, taps.wy);
    for (int k = 0; k < N_TAPS; k++) {
        taps.x[k] = within((int)fx - 1 + k, f->width);
        taps.y[k] = within((int)fy - 1 + k, f->height);
    }
    taps.nearest[0] = taps.x[taps.tx < 0.5f ? 1 : 2];
    taps.nearest[1] = taps.y[taps.ty < 0.5f ? 1 : 2];
    return taps;
}

static float interpolate(const struct rf_image *image, const struct taps *taps, int c)
{
    float v[N_TAPS][N_TAPS], least = INFINITY, most = 0, sum = 0;
    for (int j = 0; j < N_TAPS; j++)
        for (int i = 0; i < N_TAPS; i++) {
            float at = v[j][i] = *rf_image_at(image, taps->x[i], taps->y[j], c);
            least = rf_min_float(at, least);
            most = rf_max_float(at, most);
            sum += taps->wy[j] * taps->wx[i] * at;
        }
    if (most <= CONTRAST * least)
        return sum;
    float above = v[1][1] + taps->tx * (v[1][2] - v[1][1]);
    float below = v[2][1] + taps->tx * (v[2][2] - v[2][1]);
    return above + taps->ty * (below - above);
}

struct moving {
    const struct rf_frame *frame;
    const struct rf_image *from, *to;
    float shift[2]; /* px of the view per px of g, right and down */
    bool is_nearest;
    float *row; /* of the threads, a row of g each */
};

static void move_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct moving *m = data;
    const struct rf_image *to = m->to;
    float *g = m->row + (size_t)m->frame->width * (size_t)thread;
    for (int y = (int)begin; y < (int)end; y++) {
        rf_field_row(m->frame, y, g);
        for (int x = 0; x < to->width; x++) {
            struct taps taps = taps_at((float)x - m->shift[0] * g[x],
                                       (float)y - m->shift[1] * g[x], m->frame);
            for (int c = 0; c < to->channels; c++) {
                float *out = (float *)rf_image_at(to, x, y, c);
                *out = m->is_nearest
                           ? *rf_image_at(m->from, taps.nearest[0], taps.nearest[1], c)
                           : interpolate(m->from, &taps, c);
            }
        }
    }
}

/* Moves a picture of a view to *at, which goes on behind it. */
static void move_image(struct moving *m, struct rf_image *image, bool is_nearest,
                       float **at)
{
    if (!image->data)
        return;
    int n_channels = image->channels;
    struct rf_image to =
        rf_image_packed(*at, m->frame->width, m->frame->height, n_channels);
    const struct rf_image from = *image;
    m->from = &from;
    m->to = &to;
    m->is_nearest = is_nearest;
    rf_parallel(m->frame->context, m->frame->height, RF_EQUAL_PARTS, move_rows, m);
    *image = to;
    *at += (size_t)to.width * (size_t)to.height * (size_t)n_channels;
}

static size_t n_values(const struct rf_view *view)
{
    const struct rf_image *all[] = {&view->colour, &view->depth, &view->behind_colour,
                                    &view->behind_depth};
    size_t n = 0;
    for (int i = 0; i < 4; i++)
        n += all[i]->data ? (size_t)all[i]->channels : 0;
    return n;
}

rf_result rf_field_move_views(const struct rf_frame *frame, struct rf_view *views,
                              int n_views, float **memory, struct rf_error *error)
{
    size_t n = (size_t)frame->width * (size_t)frame->height, n_all = 0;
    size_t n_rows = (size_t)frame->width * (size_t)frame->context->n_threads;
    for (int j = 0; j < n_views; j++)
        n_all += n * n_values(&views[j]);
    *memory = rf_alloc(frame->context, n_all + n_rows, sizeof **memory);
    if (!*memory)
        return rf_fail_memory(error, n_all + n_rows, sizeof **memory);
    float *at = *memory + n_rows;
    for (int j = 0; j < n_views; j++) {
        struct rf_work_view w;
        struct rf_view *view = &views[j];
        rf_work_view_place(&w, view->lens_offset, view->shear_distance, &frame->lens);
        struct moving m = {
            .frame = frame,
            .shift = {w.lens[0] * w.shift_scale, -w.lens[1] * w.shift_scale},
            .row = *memory,
        };
        move_image(&m, &view->colour, false, &at);
        move_image(&m, &view->depth, true, &at);
        move_image(&m, &view->behind_colour, true, &at);
        move_image(&m, &view->behind_depth, true, &at);
    }
    return RF_OK;
}
