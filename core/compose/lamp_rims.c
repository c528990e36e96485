/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pixels at a lamp's rim show light that the renderer's pixel filter has spread: it
 * comes from farther inside the lamp, about
 *
 *   d = sum_i l_i k(x_i - x) (x_i - x) / sum_i l_i k(x_i - x)
 *
 * away, over the lights l_i of one lamp around the pixel x, which is the slope of the
 * lamp's light times a variance, over that light: what is expected of a light that a
 * Gaussian has spread (Robbins, Proc. 3rd Berkeley Symp., 1956). What stands before the
 * lamp hides the place x + d, and of a lamp of a hundred times white each rim is seen
 * (kernels/shadows_tmpl.h says how). Portrait + 0.30, its 8 views + 0.78 dB, macro + 0.20
 * and 0.25, posts + 0.13 and 0.13, foliage + 0.06 and 0.05 (docs/notebook/rivals.md).
 */
#include "compose/lamp_rims.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "compose/scene.h"
#include "rackfocus/rackfocus.h"

/*
 * Reach of k(d) = (1 - d^2 / REACH_PX^2)^2, px: a variance of 0.36 px^2, of which Blender's
 * filter of 1.5 px has 0.18 and a pixel 0.08. With 1.4 portrait's 8 views -0.18 dB, its 4
 * -0.21, foliage's + 0.08; with 2 portrait's + 0.14 and -0.15; all others within 0.06.
 */
static const float REACH_PX = 1.7f;
enum { REACH = 2 }; /* pixels */
/* Radii of one lamp differ by less, as in views_lights.c. */
static const float SAME_PX = 1;

/* A light in the order of its places: rows of pixels, then columns; a total order. */
struct placed {
    int row, column;
    float x, y, r, light;
    size_t at; /* of the highlights */
};

static int compare_places(const void *left, const void *right)
{
    const struct placed *a = left, *b = right;
    if (a->row != b->row || a->column != b->column)
        return a->row != b->row ? (a->row < b->row ? -1 : 1)
                                : (a->column < b->column ? -1 : 1);
    const float of_a[] = {a->y, a->x, a->r, a->light};
    const float of_b[] = {b->y, b->x, b->r, b->light};
    for (size_t i = 0; i < sizeof of_a / sizeof of_a[0]; i++)
        if (of_a[i] != of_b[i])
            return of_a[i] < of_b[i] ? -1 : 1;
    return (a->at > b->at) - (a->at < b->at);
}

struct finding {
    const struct placed *at;
    size_t n;
    float (*inward)[2];
};

/* The first light from a pixel on. */
static size_t first_from(const struct finding *f, int row, int column)
{
    size_t from = 0, end = f->n;
    while (from < end) {
        size_t middle = from + (end - from) / 2;
        const struct placed *p = &f->at[middle];
        if (p->row < row || (p->row == row && p->column < column))
            from = middle + 1;
        else
            end = middle;
    }
    return from;
}

/* Adds what the light p says of the one at `own`: places and light, weighed. */
static void add_light(const struct placed *own, const struct placed *p, double sum[3])
{
    double dx = (double)p->x - (double)own->x, dy = (double)p->y - (double)own->y;
    double far = 1 - (dx * dx + dy * dy) / ((double)REACH_PX * (double)REACH_PX);
    if (far <= 0 || fabsf(p->r - own->r) >= SAME_PX)
        return;
    double weight = far * far * (double)p->light;
    sum[0] += weight * dx;
    sum[1] += weight * dy;
    sum[2] += weight;
}

static void find_inward(void *data, int64_t begin, int64_t end, int thread)
{
    const struct finding *f = data;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const struct placed *own = &f->at[i];
        double sum[3] = {0};
        for (int row = own->row - REACH; row <= own->row + REACH; row++)
            for (size_t k = first_from(f, row, own->column - REACH);
                 k < f->n && f->at[k].row == row &&
                 f->at[k].column <= own->column + REACH;
                 k++)
                add_light(own, &f->at[k], sum);
        for (int k = 0; k < 2; k++)
            f->inward[own->at][k] = sum[2] > 0 ? (float)(sum[k] / sum[2]) : 0;
    }
}

rf_result rf_lamp_rims_find(struct rf_lamp_rims *rims, const struct rf_scene *scene,
                            struct rf_error *error)
{
    const struct rf_context *context = scene->frame->context;
    const struct rf_samples *samples = &scene->highlights;
    const size_t n = samples->n;
    struct placed *placed = rf_alloc(context, n, sizeof *placed);
    rims->inward = rf_alloc(context, n, sizeof *rims->inward);
    if (!placed || !rims->inward) {
        rf_free(context, placed);
        return rf_fail_memory(error, n, sizeof *placed);
    }
    for (size_t i = 0; i < n; i++) {
        const struct rf_sample *s = &samples->at[i];
        float light = s->w * rf_luminance(s->c[0], s->c[1], s->c[2]);
        placed[i] = (struct placed){.row = (int)floorf(s->y),
                                    .column = (int)floorf(s->x),
                                    .x = s->x,
                                    .y = s->y,
                                    .r = s->r,
                                    .light = rf_max_float(light, 0),
                                    .at = i};
    }
    qsort(placed, n, sizeof *placed, compare_places);
    struct finding f = {placed, n, rims->inward};
    rf_parallel(context, (int64_t)n, RF_EQUAL_PARTS, find_inward, &f);
    rf_free(context, placed);
    return RF_OK;
}

void rf_lamp_rims_free(struct rf_lamp_rims *rims, const struct rf_context *context)
{
    rf_free(context, rims->inward);
    rims->inward = NULL;
}
