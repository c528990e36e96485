/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How much of a lens' light its looks leave. Of an even lens that is an area, which is
 * known (lens/look.c); else light is summed over lines v = const, each cut by the second
 * disc and by the doors: exact but for slanted edges, of which a line ends in the middle.
 */
#include "compose/lens_light.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "compose/lens_cells.h"
#include "compose/zones.h"
#include "input/bokeh.h"
#include "lens/aperture.h"
#include "lens/look.h"

/* What the second disc leaves of a line at the height v of the whole lens. */
static void cut_by_eye(const struct rf_look_opening *open, double v,
                       struct rf_interval *line)
{
    double along[2], rest[2];
    for (int k = 0; k < 2; k++) {
        along[k] = open->eye[k][0];
        rest[k] = open->eye[k][1] * v - open->middle[k];
    }
    /* |along u + rest| <= 1 */
    double square = along[0] * along[0] + along[1] * along[1];
    double middle = -(along[0] * rest[0] + along[1] * rest[1]) / square;
    double beside = (along[0] * rest[1] - along[1] * rest[0]) / sqrt(square);
    double half = sqrt(fmax(1 - beside * beside, 0) / square);
    line->from = fmax(line->from, middle - half);
    line->to = fmin(line->to, middle + half);
}

/* What a door leaves of a piece of the whole lens. */
static void cut_by_door(const double normal[2], double limit, struct rf_piece *piece)
{
    static const double UPRIGHT = 1e-9;
    double middle = (piece->from[1] + piece->to[1]) / 2;
    bool is_level = fabs(normal[0]) <= UPRIGHT * fabs(normal[1]);
    int axis = is_level;
    double rest = is_level ? limit : limit - normal[1] * middle;
    double at = rest / normal[axis];
    if (normal[axis] > 0)
        piece->to[axis] = fmin(piece->to[axis], at);
    else if (normal[axis] < 0)
        piece->from[axis] = fmax(piece->from[axis], at);
    else if (limit < 0)
        piece->to[0] = piece->from[0];
}

/* The light that an opening leaves. */
static double light_through(const struct rf_lens_light *light,
                            const struct rf_look_opening *open)
{
    const double *origin = light->shape->origin;
    const struct rf_zone zone = {.shape = light->shape};
    double half = (light->range.to - light->range.from) / RF_LIGHT_LINES / 2, sum = 0;
    for (int i = 0; i < RF_LIGHT_LINES; i++) {
        double v = rf_line_at(light->range, i, RF_LIGHT_LINES) + origin[1];
        struct rf_interval line = {light->line[i].from + origin[0],
                                   light->line[i].to + origin[0]};
        if (open->has_eye)
            cut_by_eye(open, v, &line);
        struct rf_piece piece = {{line.from, v - half}, {line.to, v + half}};
        for (int k = 0; k < open->n_doors; k++)
            cut_by_door(open->normal[k], open->limit[k], &piece);
        for (int k = 0; k < 2; k++) {
            piece.from[k] -= origin[k];
            piece.to[k] -= origin[k];
        }
        if (piece.to[0] > piece.from[0] && piece.to[1] > piece.from[1])
            sum += rf_zone_light(&zone, light->bokeh, light->plane, &piece);
    }
    return sum;
}

void rf_lens_light_init(struct rf_lens_light *light, const struct rf_look *look,
                        const struct rf_shape *shape, const struct rf_bokeh *bokeh,
                        int plane)
{
    static const struct rf_look_opening all = {.has_eye = false};
    light->look = *look;
    light->shape = shape;
    light->bokeh = bokeh;
    light->plane = plane;
    if (!bokeh)
        return;
    light->range = rf_shape_v_range(shape);
    rf_shape_lines(shape, light->range, RF_LIGHT_LINES, light->line);
    light->whole = light_through(light, &all);
}

double rf_lens_light_open(const struct rf_lens_light *light, const double q[2],
                          double r)
{
    if (!light->bokeh)
        return rf_look_open_near(&light->look, light->shape, q, r);
    const struct rf_look_opening open = rf_look_opening_at(&light->look, q, r);
    return light->whole > 0 ? fmin(light_through(light, &open) / light->whole, 1) : 0;
}

/* All light of a zone: the area of its shape, or what rf_zone_weigh() finds. */
static double light_of(struct rf_zone *zone, const struct rf_bokeh *bokeh, int plane)
{
    double middle[2];
    return bokeh ? rf_zone_weigh(zone, bokeh, plane)
                 : rf_shape_area(zone->shape, middle);
}

double rf_zone_make_lit(struct rf_zone *zone, struct rf_shape *shape,
                        const struct rf_shape *whole, const struct rf_look *look,
                        const double q[2], double r, const struct rf_bokeh *bokeh,
                        int plane)
{
    static const double LEAST = 1e-4; /* of the light: less is none */
    struct rf_zone all;
    struct rf_shape all_shape;
    double share = rf_zone_make(zone, shape, whole, look, q, r);
    double left = light_of(zone, bokeh, plane);
    if (share == 0 || !rf_look_is_dark(look))
        return share;
    if (rf_look_is_scaled(look)) {
        struct rf_lens_light light;
        rf_lens_light_init(&light, look, whole, bokeh, plane);
        share = rf_lens_light_open(&light, q, r);
    } else {
        const struct rf_look bright = rf_look_bright(look);
        rf_zone_make(&all, &all_shape, whole, &bright, q, r);
        double most = light_of(&all, bokeh, plane);
        share = most > 0 ? fmin(left / most, 1) : 0;
    }
    return share > LEAST ? share : 0;
}
