/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The two sides of an edge. Each surface has the mean colour of the pixels within it,
 * all of whose neighbours are on its side; a side without any is thin.
 * split.c says what splitting is for.
 */
#include "surfaces/split_sides.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "surfaces/split_around.h"
#include "surfaces/split_means.h"
#include "surfaces/split_pixels.h"
#include "surfaces/splitter.h"
#include "surfaces/surfaces.h"

/* Ours; behind each what split.c says. */
static const float SAME_PX = 1; /* radii of one of several surfaces on a side. 0; 0 */

/* Pixels around (x, y), a bit for each as in struct rf_sides, that lie in the picture.
 */
static uint32_t bits_inside(const struct rf_pixels *p, int x, int y)
{
    struct rf_split_window w = rf_split_window_at(p, x, y, RF_SPLIT_WINDOW);
    uint32_t row = (2u << (w.x1 - x + RF_SPLIT_WINDOW)) -
                   (1u << (w.x0 - x + RF_SPLIT_WINDOW)),
             bits = 0;
    for (int j = w.y0; j <= w.y1; j++)
        bits |= row << RF_SIDES_AROUND * (j - y + RF_SPLIT_WINDOW);
    return bits;
}

/* A side without interior is thin: its pixel that differs most from the other side. */
static void take_most_unlike(const struct rf_split_around *around, uint32_t bits,
                             const struct rf_surface *other, struct rf_surface *out)
{
#define LESS(d2) 1 + 0.3f * (d2)
    static const float LESSER[RF_SPLIT_STEPS] = RF_OF_DISTANCES(LESS);
#undef LESS
    const rf_truths magnitude = {INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX};
    const rf_quad c = *(const rf_quad *)other->c;
    const struct rf_surface *found = NULL;
    float best = -1;
    for (; bits; bits &= bits - 1) {
        int bit = __builtin_ctz(bits);
        const struct rf_surface *q = around->middle + around->steps[bit];
        rf_quad e = (rf_quad)((rf_truths)(*(const rf_quad *)q->c - c) & magnitude);
        float d = (e[0] + e[1] + e[2] + e[3]) / LESSER[bit];
        found = d > best ? q : found;
        best = d > best ? d : best;
    }
    if (found)
        memcpy(out->c, found->c, sizeof out->c);
}

/* The pixels of a set that show the surface of the middle one; all where none does. */
static uint32_t keep_alike(const struct rf_split_around *around, uint32_t bits)
{
    uint32_t alike = 0;
    for (uint32_t left = bits; left; left &= left - 1) {
        int bit = __builtin_ctz(left);
        float r = (around->middle + around->steps[bit])->r;
        if (fabsf(r - around->middle->r) < SAME_PX)
            alike |= 1u << bit;
    }
    return alike ? alike : bits;
}

/* Are two pixels of a set, next to the middle, 135 or 180 degrees apart? */
static bool is_between(uint32_t bits)
{
    enum { NW = 1 << 6, N = 1 << 7, NE = 1 << 8, W = 1 << 11 };
    enum { E = 1 << 13, SW = 1 << 16, S = 1 << 17, SE = 1 << 18 };
    return (bits & N && bits & (SW | S | SE)) || (bits & S && bits & (NW | NE)) ||
           (bits & W && bits & (NE | E | SE)) || (bits & E && bits & (NW | SW)) ||
           (bits & NW && bits & SE) || (bits & NE && bits & SW);
}

/*
 * Adds the pixels that show the far surface alone to those within it: between twigs no
 * pixel has all its neighbours on its side. Far from the focus blur hides more than their
 * colours tell.
 */
static uint32_t with_pure(const struct rf_splitter *s,
                          const struct rf_split_around *around,
                          const struct rf_split_edge *e, uint32_t inner, uint32_t far,
                          int x, int y)
{
    if (!s->mean_depth || e->lowest > RF_SPLIT_SHARP_PX ||
        e->highest < -RF_SPLIT_SHARP_PX)
        return inner;
    const uint32_t others = ~(uint32_t)RF_SPLIT_MIDDLE;
    return inner | rf_split_find_pure(s, around, far & others, e->lowest, x, y);
}

bool rf_split_find_sides(const struct rf_splitter *s, int x, int y,
                         const struct rf_split_edge *e, bool has_lamp,
                         struct rf_meeting *m)
{
    const struct rf_pixels *p = s->pixels;
    const struct rf_split_around around = {rf_split_pixel(p, x, y), s->steps};
    const float *rows[RF_SIDES_AROUND + 2];
    struct rf_sides sides;
    rf_plane_rows(p, p->radius, y, RF_SPLIT_WINDOW + 1, rows);
    s->frame->context->kernels->find_sides(rows, x, e->threshold, e->lowest - e->gap,
                                           e->highest + e->gap, &sides);
    uint32_t inside = bits_inside(p, x, y);
    uint32_t near = ~sides.far & inside, far = sides.far & inside;
    uint32_t near_usual = near & sides.usual, far_usual = far & sides.usual;
    if (!near_usual || !far_usual)
        return false;
    uint32_t near_inner = near_usual & sides.interior;
    uint32_t far_inner = far_usual & sides.interior;
    if (!has_lamp)
        far_inner = with_pure(s, &around, e, far_inner, far_usual, x, y);
    m->is_near = around.middle->r <= e->threshold;
    if (m->is_near && !s->is_alone)
        near_inner = keep_alike(&around, near_inner);
    else if (!s->is_alone)
        far_inner = keep_alike(&around, far_inner);
    m->near = near_usual;
    m->far = far_usual;
    m->f = rf_split_mean_of(&around, near_inner ? near_inner : near_usual);
    m->b = rf_split_mean_of(&around, far_inner ? far_inner : far_usual);
    m->own = m->is_near ? near_inner : far_inner;
    m->other = m->is_near ? far_inner : near_inner;
    m->is_within = !near_inner && is_between(near);
    if (!near_inner)
        take_most_unlike(&around, near, &m->b, &m->f);
    else if (!far_inner)
        take_most_unlike(&around, far, &m->f, &m->b);
    return true;
}
