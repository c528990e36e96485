/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The surface in focus. Its inverse distance depends on the place,
 *
 *   1/s(q) = 1/s + (x sin A + y sin B) / (f f_px)    tilt, the lens turned by A and B
 *                + b |q|^2                           curvature of field
 *
 *   x, y   px from the optical axis, y up;  q  the place in halves of the diagonal
 *   f      focal length, scene units;  f_px  the same in px
 *
 * and beyond the line of a split diopter 1/s is that of its own distance (diopter.c).
 * All of it shifts the radius, r = K (1/s(q) - 1/z), by a number that depends on the
 * place alone.
 *
 * Tilt: the surface is a plane that meets the plane of the lens in the line f / sin A
 * from the axis (Scheimpflug; Merklinger 1996).
 */
#include "input/field.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/math.h"
#include "base/parallel.h"
#include "input/diopter.h"
#include "input/frame.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

bool rf_field_is_on(const struct rf_params *p)
{
    return p->projection == RF_PROJECTION_PERSPECTIVE &&
           (p->tilt_x != 0 || p->tilt_y != 0 || p->field_curvature != 0 ||
            p->split_diopter > 0);
}

const char *rf_field_param(const struct rf_params *p)
{
    return p->tilt_x != 0            ? "tilt_x"
           : p->tilt_y != 0          ? "tilt_y"
           : p->field_curvature != 0 ? "field_curvature"
                                     : "split_diopter";
}

bool rf_field_is_used(const struct rf_frame *frame)
{
    return rf_field_is_on(&frame->params) || frame->radius_shift != 0;
}

/* What the place adds to a radius anywhere in the picture is at most this, px. */
static double most_shift(const struct rf_frame *frame)
{
    const struct rf_field *f = frame->apart;
    double right = frame->place.whole_width - f->principal[0];
    double below = frame->place.whole_height - f->principal[1];
    double x = fmax(fabs(f->principal[0]), fabs(right));
    double y = fmax(fabs(f->principal[1]), fabs(below));
    return fabs(f->k) * (x * fabs(f->tilt[0]) + y * fabs(f->tilt[1]) +
                         fabs(f->curvature)) + /* |q| is at most 1 */
           fabs(f->diopter.px) +
           fabs(f->shift);
}

struct rf_lens rf_field_lens(const struct rf_frame *frame)
{
    struct rf_lens lens = frame->lens;
    if (rf_field_is_used(frame))
        lens.max_radius_px =
            frame->apart ? frame->apart->most + most_shift(frame) : INFINITY;
    return lens;
}

struct rf_field rf_field_of(const struct rf_frame *f)
{
    const struct rf_params *p = &f->params;
    const double degree = RF_PI / 180;
    double per_px = 1 / (f->lens.focal_length * f->lens.focal_length_px);
    return (struct rf_field){
        .k = rf_field_is_on(p) ? -f->lens.scale : 0,
        .shift = f->radius_shift,
        .most = f->lens.max_radius_px,
        .principal = {f->lens.principal_px[0], f->lens.principal_px[1]},
        .tilt = {sin(p->tilt_x * degree) * per_px,
                 sin(p->tilt_y * degree) * per_px / p->pixel_aspect},
        .curvature = p->field_curvature,
        .diopter = rf_diopter_of(f),
        .places = rf_look_make(p, f->place.whole_width, f->place.whole_height),
        .x = f->place.x,
        .y = f->place.y,
    };
}

/* The shift but for a split diopter's is a sum of one of the column and one of the
 * row. `axis`: 0 for a column, 1 for a row; i: px of the frame. */
static float shift_along(const struct rf_field *f, double i, int axis)
{
    double q[2], at = (axis ? f->y : f->x) + i;
    rf_look_place(&f->places, at, at, q);
    double beside = axis ? f->principal[1] - at : at - f->principal[0];
    double sum = beside * f->tilt[axis] + f->curvature * q[axis] * q[axis];
    double everywhere = axis ? f->shift : 0;
    return (float)(f->k != 0 ? f->k * sum + everywhere : everywhere);
}

/* Columns of a frame that are worked on together. */
enum { N_COLUMNS = 256 };
struct columns {
    int from, n;
    float shift[N_COLUMNS];
};

/* Adds what a split diopter makes of row y. */
static void split_row(const struct rf_field *f, const struct columns *c, int y,
                      float *radius)
{
    for (int i = 0; i < c->n && f->diopter.px != 0; i++) {
        double share = rf_diopter_share(&f->diopter, c->from + i, y);
        if (share > 0)
            radius[i] += (float)(f->diopter.px * share);
    }
}

/* Radii that the field is added to. */
struct applying {
    struct rf_field field;
    const float *from;
    float *to; /* NULL: only their largest magnitude is asked for */
    int width;
    uint32_t most_found; /* bits of a float; atomic */
};

/* Returns the largest magnitude of a row's radii. */
static float apply_row(const struct applying *a, const struct columns *c, int y)
{
    const struct rf_field *f = &a->field;
    int64_t first = (int64_t)y * a->width + c->from;
    float most = 0, limit = (float)f->most, of_row = shift_along(f, y + 0.5, 1);
    float room[N_COLUMNS], *radius = a->to ? a->to + first : room;
    for (int i = 0; i < c->n; i++)
        radius[i] = a->from[first + i] + (c->shift[i] + of_row);
    split_row(f, c, y, radius);
    for (int i = 0; i < c->n; i++) {
        radius[i] = rf_min_float(rf_max_float(radius[i], -limit), limit);
        most = rf_max_float(fabsf(radius[i]), most);
    }
    return most;
}

static void apply_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct applying *a = data;
    float most = 0;
    (void)thread;
    for (int from = 0; from < a->width; from += N_COLUMNS) {
        struct columns c = {from, rf_min_int(a->width - from, N_COLUMNS), {0}};
        for (int i = 0; i < c.n; i++)
            c.shift[i] = shift_along(&a->field, from + i + 0.5, 0);
        for (int y = (int)begin; y < (int)end; y++)
            most = rf_max_float(apply_row(a, &c, y), most);
    }
    /* The largest of all parts, whichever comes first; floats above 0 sort as bits. */
    uint32_t bits, seen = __atomic_load_n(&a->most_found, __ATOMIC_RELAXED);
    memcpy(&bits, &most, sizeof bits);
    while (bits > seen &&
           !__atomic_compare_exchange_n(&a->most_found, &seen, bits, false,
                                        __ATOMIC_RELAXED, __ATOMIC_RELAXED))
        ;
}

struct rf_look rf_field_look(const struct rf_frame *frame)
{
    /* Of the radius per px: a third of a px of the rim at 32 px. Lamps of 20 px at 0.03
     * are 2 dB worse without it (tests/quality/test_looks.py). */
    static const double LEAST_SLOPE = 0.01;
    const struct rf_look plain = rf_frame_look(frame);
    if (!rf_field_is_on(&frame->params))
        return plain;
    const struct rf_field f = rf_field_of(frame);
    struct rf_look look = f.places;
    look.slope[0] = f.k * f.tilt[0] * look.half_px;
    look.slope[1] = f.k * f.tilt[1] * look.half_px * look.pixel_aspect;
    look.bend = f.k * f.curvature;
    look.most_px = f.most;
    double most =
        rf_length(look.slope[0], look.slope[1]) + 2 * fabs(look.bend); /* per q */
    return most / look.half_px >= LEAST_SLOPE ? look : plain;
}

static float apply(const struct rf_frame *frame, const float *from, float *to)
{
    struct applying a = {rf_field_of(frame), from, to, frame->width, 0};
    float largest;
    rf_parallel(frame->context, frame->height, RF_EQUAL_PARTS, apply_rows, &a);
    memcpy(&largest, &a.most_found, sizeof largest);
    return largest;
}

void rf_field_row(const struct rf_frame *frame, int y, float *shift)
{
    struct rf_field field = rf_field_of(frame);
    field.shift = 0; /* no colour moves */
    float of_row = shift_along(&field, y + 0.5, 1);
    for (int from = 0; from < frame->width; from += N_COLUMNS) {
        struct columns c = {from, rf_min_int(frame->width - from, N_COLUMNS), {0}};
        for (int i = 0; i < c.n; i++)
            shift[from + i] = shift_along(&field, from + i + 0.5, 0) + of_row;
        split_row(&field, &c, y, shift + from);
    }
}

void rf_field_apply(const struct rf_frame *frame, float *radius, float *largest)
{
    if (rf_field_is_used(frame) && !frame->apart)
        *largest = apply(frame, radius, radius);
}

float rf_field_largest(const struct rf_frame *frame, const float *radius)
{
    return apply(frame, radius, NULL);
}

float rf_field_seen(const struct rf_frame *frame, int x, int y, float r)
{
    return frame->apart
               ? rf_field_radius(frame->apart, (float)x + 0.5f, (float)y + 0.5f, r)
               : r;
}

float rf_field_radius(const struct rf_field *f, float x, float y, float r)
{
    float limit = (float)f->most;
    r += shift_along(f, (double)x, 0) + shift_along(f, (double)y, 1);
    if (f->diopter.px != 0)
        r += (float)(f->diopter.px *
                     rf_diopter_share(&f->diopter, (int)floorf(x), (int)floorf(y)));
    return rf_min_float(rf_max_float(r, -limit), limit);
}
