/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The split diopter. Beyond the line n . q = o the inverse distance of the surface in
 * focus is that of a second distance,
 *
 *   1/s(q) = 1/s + (1/s2 - 1/s) S((n . q - o) / w + 1/2),   S(t) = 3 t^2 - 2 t^3
 *
 *   q   the place in halves of the diagonal, y up;  n  the split angle's direction
 *   o   the offset;  w  the softness;  S  the share of the diopter, 0 below t = 0 and
 *       1 above t = 1
 */
#include "input/diopter.h"

#include <math.h>
#include <stdbool.h>

#include "base/math.h"
#include "input/frame.h"
#include "lens/look.h"

struct rf_diopter rf_diopter_of(const struct rf_frame *f)
{
    const struct rf_params *p = &f->params;
    const double angle = p->split_angle * (RF_PI / 180);
    struct rf_diopter diopter = {
        .is_even = f->has_even_share,
        .even_share = f->even_share,
        .side = {cos(angle), sin(angle)},
        .offset = p->split_offset,
        .softness = p->split_softness,
        .places = rf_look_make(p, f->place.whole_width, f->place.whole_height),
        .x = f->place.x,
        .y = f->place.y,
    };
    if (p->split_diopter > 0 && p->projection == RF_PROJECTION_PERSPECTIVE)
        diopter.px =
            -f->lens.scale * (1 / p->split_diopter - 1 / f->lens.focus_distance);
    return diopter;
}

static double share_beyond(const struct rf_diopter *d, double beyond)
{
    if (d->softness <= 0)
        return beyond > 0;
    double t = fmin(fmax(beyond / d->softness + 0.5, 0), 1);
    return t * t * (3 - 2 * t);
}

double rf_diopter_share(const struct rf_diopter *d, int x, int y)
{
    double q[2];
    if (d->is_even)
        return d->even_share;
    rf_look_place(&d->places, d->x + x + 0.5, d->y + y + 0.5, q);
    return share_beyond(d, d->side[0] * q[0] + d->side[1] * q[1] - d->offset);
}

double rf_diopter_beyond(const struct rf_diopter *d, double share)
{
    enum { HALVINGS = 30 }; /* a picture's diagonal has fewer than 2^18 px */
    if (share < 0 || share > 1)
        return share < 0 ? -INFINITY : INFINITY;
    double from = -d->softness / 2, to = d->softness / 2;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = (from + to) / 2;
        if (share_beyond(d, middle) < share)
            from = middle;
        else
            to = middle;
    }
    return (from + to) / 2;
}

void rf_diopter_span(const struct rf_diopter *d, double from, double to, int y,
                     int width, int span[2])
{
    static const double LEAST_SLOPE = 1e-9; /* per px: the line is level */
    double q[2], slope = d->side[0] / d->places.half_px;
    rf_look_place(&d->places, d->x + 0.5, d->y + y + 0.5, q);
    double first = d->side[0] * q[0] + d->side[1] * q[1] - d->offset;
    double a = 0, b = width - 1;
    if (fabs(slope) >= LEAST_SLOPE) {
        a = ((slope > 0 ? from : to) - first) / slope;
        b = ((slope > 0 ? to : from) - first) / slope;
    } else if (first < from - 2 * LEAST_SLOPE * width ||
               first > to + 2 * LEAST_SLOPE * width) {
        b = -1;
    }
    span[0] = (int)floor(fmin(fmax(a - 1, 0), width));
    span[1] = (int)ceil(fmin(fmax(b + 2, span[0]), width));
}
