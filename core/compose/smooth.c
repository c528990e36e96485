/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A smooth surface near the focus has no holes. Where it slants or folds its pixels
 * have different radii and cover each other to 85 or 95 % only, and what lies far
 * behind would shine through in specks and contour lines. No lens sees past an edge
 * that is farther than the radius: a pixel is closed that is whole, as are those around
 * it, if their radii are small, and what is left of it shows its own colour or, where it
 * stands before them, theirs.
 */
#include "compose/smooth.h"

#include <stdbool.h>
#include <stddef.h>

#include "base/math.h"
#include "compose/composer.h"
#include "compose/levels.h"
#include "compose/scene.h"
#include "kernels/data.h"

/*
 * Ours. Behind each: tPSNR in dB of scenes of tests/quality with half of it and with
 * twice (docs/notebook/thresholds.md).
 */
/* Of the radii: the nearest edge is as far. 0; ortho -4.63, plane -1.26. */
static const float MOST_PX = 1.5f;
/* Between the least and the largest of 3 x 3 radii: across more lies an edge, which is not
 * to be closed (tests/physics/test_edges.c). Three times: 0. */
static const float MOST_RANGE_PX = 0.5f;
/* Nearer by more than the mean of two pixels to both sides it stands before them, and
 * what is left of it shows theirs. 0; 0: few of these scenes have things as thin. */
static const float MOST_OWN_PX = 0.15f;
/* By more than that it is a thing of its own, behind which anything may lie. At 0.15, as
 * it was once, a surface in focus whose depth is rough by 0.1 px lets a sky through in 1 %
 * of its pixels. */
static const float MOST_BEFORE_PX = 1;

enum { N_AROUND = RF_TILE_W + 2 }; /* pixels of a tile's row, and those beside it */

/* Rows of radii and shares, the middle one that of the pixels that are asked. */
struct rows {
    const float *radius[3], *share[3];
};

/* Of three pixels, one above the other, in the columns of a tile. */
struct columns {
    float least[N_AROUND], most[N_AROUND], share[N_AROUND];
};

static float least_of(float a, float b, float c)
{
    return rf_min_float(rf_min_float(a, b), c);
}

static float most_of(float a, float b, float c)
{
    return rf_max_float(rf_max_float(a, b), c);
}

static void find_extremes(const struct rows *v, int n, struct columns *out)
{
    for (int x = 0; x < n; x++) {
        out->least[x] = least_of(v->radius[0][x], v->radius[1][x], v->radius[2][x]);
        out->most[x] = most_of(v->radius[0][x], v->radius[1][x], v->radius[2][x]);
        out->share[x] = least_of(v->share[0][x], v->share[1][x], v->share[2][x]);
    }
}

/* The larger sum of two radii to opposite sides of pixel x + 1. */
static float most_opposite(const float *const r[3], int x)
{
    float straight = rf_max_float(r[1][x] + r[1][x + 2], r[0][x + 1] + r[2][x + 1]);
    return most_of(straight, r[0][x] + r[2][x + 2], r[0][x + 2] + r[2][x]);
}

enum { OPEN, OWN, BESIDE }; /* what the rest of a pixel shows */

/* What each of n pixels is closed with; rows and columns begin one before the first,
 * and all radii are more by `shift`. */
static bool find_closed(const struct rows *rows, const struct columns *v, float shift,
                        int n, unsigned char *closed)
{
    int any = 0;
    for (int x = 0; x < n; x++) {
        float least = least_of(v->least[x], v->least[x + 1], v->least[x + 2]);
        float most = most_of(v->most[x], v->most[x + 1], v->most[x + 2]);
        float share = least_of(v->share[x], v->share[x + 1], v->share[x + 2]);
        float before = most_opposite(rows->radius, x) / 2 - rows->radius[1][x + 1];
        bool is_closed = (least >= -MOST_PX - shift) & (most <= MOST_PX - shift) &
                         (share >= 1) & (most - least <= MOST_RANGE_PX) &
                         (before <= MOST_BEFORE_PX);
        closed[x] = !is_closed ? OPEN : before > MOST_OWN_PX ? BESIDE : OWN;
        any |= is_closed;
    }
    return any;
}

/* A colour of a pixel, or the mean of the four beside it. */
static float colour_at(const struct rf_surface *own, size_t width, int p, int shown)
{
    return shown == OWN ? own->c[p]
                        : 0.25f * (own[-1].c[p] + own[1].c[p] + (own - width)->c[p] +
                                   own[width].c[p]);
}

/* Gives what is left of the closed pixels of a row its colour. */
static void close_row(const struct rf_scene *scene, const struct rf_surface *own,
                      const unsigned char *closed, int n, float *t, float *sum,
                      size_t plane)
{
    const size_t width = (size_t)scene->occluders->surfaces->width;
    for (int x = 0; x < n; x++) {
        if (closed[x] == OPEN || !(t[x] > 0))
            continue;
        for (int p = 0; p < scene->n_colours; p++)
            sum[plane * (size_t)p + (size_t)x] +=
                t[x] * colour_at(&own[x], width, scene->first_colour + p, closed[x]);
        sum[plane * (size_t)scene->n_colours + (size_t)x] += t[x];
        t[x] = 0;
    }
}

void rf_close_smooth(const struct rf_composer *c, int tx, int ty,
                     const struct rf_tile_state *state)
{
    const struct rf_scene *scene = c->scene;
    if (!scene->whole_radius)
        return;
    const struct rf_surfaces *surfaces = scene->occluders->surfaces;
    const int *at = scene->whole_at, *from = scene->whole_from, *to = scene->whole_to;
    int x0 = rf_max_int(tx * RF_TILE_W, from[0]),
        y0 = rf_max_int(ty * RF_TILE_H, from[1]);
    int x1 = rf_min_int((tx + 1) * RF_TILE_W, to[0]);
    int y1 = rf_min_int((ty + 1) * RF_TILE_H, to[1]), n = x1 - x0;
    for (int y = y0; y < y1 && n > 0; y++) {
        size_t line = state->t_row * (size_t)(y - ty * RF_TILE_H);
        struct rows rows;
        unsigned char closed[RF_TILE_W];
        struct columns columns;
        bool is_open = false;
        for (int cell = 0; cell < c->canvas.n_cells; cell++)
            is_open |= rf_is_row_open(state->t + state->t_plane * (size_t)cell + line);
        if (!is_open)
            continue;
        for (int k = 0; k < 3; k++) {
            size_t row = (size_t)(y - at[1] + k - 1), x = (size_t)(x0 - at[0] - 1);
            rows.radius[k] = scene->whole_radius + scene->whole_stride * row + x;
            rows.share[k] = surfaces->share + (size_t)surfaces->width * row + x;
        }
        find_extremes(&rows, n + 2, &columns);
        if (!find_closed(&rows, &columns, scene->radius_shift, n, closed))
            continue;
        size_t first = (size_t)(x0 - tx * RF_TILE_W);
        const struct rf_surface *own = surfaces->near +
                                       (size_t)surfaces->width * (size_t)(y - at[1]) +
                                       (size_t)(x0 - at[0]);
        float *sum = state->sum + state->row * (size_t)(y - ty * RF_TILE_H) + first;
        for (int cell = 0; cell < c->canvas.n_cells; cell++)
            close_row(scene, own, closed, n,
                      state->t + state->t_plane * (size_t)cell + line + first, sum,
                      state->plane);
    }
}
