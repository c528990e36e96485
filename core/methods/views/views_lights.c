/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lights in several views. Few samples find a lamp's edge, and its depth there may be
 * that of what stands before it: so the views are held against each other.
 */
#include "methods/views/views_lights.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "compose/highlights_find.h"
#include "compose/scene.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "methods/views/merge.h"
#include "methods/views/views_place.h"
#include "surfaces/picture.h"
#include "surfaces/split.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

enum { FREE_PX = 3 };

/*
 * Ours. Behind each: tPSNR in dB of eight views of tests/quality with half of it and
 * with twice (docs/notebook/thresholds.md).
 */
/* What is nearer by this much may be in front. Portrait -0.13; portrait -0.04. */
static const float FREE_DEPTH_PX = 1.6f;
static const float SAME_PX = 0.25f; /* of radius: lights of one depth. 0; 0 */
/* Of a light's luminance: the same light. Portrait -0.02; 0. */
static const float LIT = 0.2f;
static const float FAR_PX = 1e8f; /* no disc reaches the picture from there */

/*
 * Is the place free in view k: rendered, with nothing nearer within `reach` px? Shares
 * at the edge of a light are no measure of how much of it is seen.
 */
static bool is_free(const struct rf_views *v, int k, struct rf_view_place p, int reach)
{
    const struct rf_picture *picture = &v->pictures[k];
    const struct rf_surfaces *s = &picture->surfaces;
    int px, py;
    if (!rf_view_pixel_at(v, k, p, &px, &py))
        return false;
    for (int y = py - reach; y <= py + reach; y++)
        for (int x = px - reach; x <= px + reach; x++) {
            if (!rf_view_is_rendered(picture, x, y))
                return false;
            size_t i = (size_t)y * (size_t)s->width + (size_t)x;
            if (s->share[i] > 0.02f && s->near[i].r < p.r - FREE_DEPTH_PX)
                return false;
        }
    return true;
}

/* Does view k show a light like this near the place? */
static bool shows_light(const struct rf_views *v, int k, struct rf_view_place p,
                        float luminance)
{
    const struct rf_picture *picture = &v->pictures[k];
    int px, py;
    if (!rf_view_pixel_at(v, k, p, &px, &py))
        return false;
    for (int y = rf_max_int(py - 1, 0); y <= rf_min_int(py + 1, picture->height - 1);
         y++)
        for (int x = rf_max_int(px - 1, 0); x <= rf_min_int(px + 1, picture->width - 1);
             x++)
            if (rf_plane_row(&picture->pixels, picture->pixels.luminance, y)[x] >
                luminance)
                return true;
    return false;
}

/* Of the other views to which the place is free, how many show the light? */
struct support {
    int n_free, n_lit;
};

/*
 * How far the surroundings of a place are to be free, tried in turn: in fur and leaves
 * nothing is free within FREE_PX (soft: 37.8 dB without the smaller ones, 38.4 with).
 */
static const int REACHES_PX[] = {FREE_PX, 1, 0};

static struct support support_of(const struct rf_views *v, int j,
                                 struct rf_view_place p, float luminance)
{
    struct support s = {0, 0};
    for (size_t i = 0; i < sizeof REACHES_PX / sizeof *REACHES_PX && s.n_free == 0; i++)
        for (int k = 0; k < v->work->n_views; k++) {
            if (k == j || !is_free(v, k, p, REACHES_PX[i]))
                continue;
            s.n_free++;
            s.n_lit += shows_light(v, k, p, luminance);
        }
    return s;
}

/*
 * Of a place that is free to no view: more than of one that is, and where none of them
 * shows the light (soft: 38.4 dB without, 38.6 with).
 */
static const float UNKNOWN = 0.2f;

static float lit_share_of(struct support s)
{
    return s.n_free ? (float)s.n_lit / (float)s.n_free : UNKNOWN;
}

/* A search for the depth of a light, and the best so far. */
struct depth_search {
    const struct rf_views *v;
    int view;
    float x, y; /* px of the view */
    float luminance;
    float r, lit_share; /* of the views to which it is free */
};

static bool is_settled(const struct depth_search *d)
{
    return d->lit_share >= 0.5f;
}

/* Takes the depth of what pixel (x, y) of a view shows where more views agree on it. */
static void try_depth(struct depth_search *d, const struct rf_pixels *p, int x, int y)
{
    if (rf_plane_row(p, p->luminance, y)[x] < d->luminance)
        return;
    float r = rf_split_radius_at(p, x, y);
    if (fabsf(r - d->r) < RF_OCCLUDED_PX)
        return;
    struct rf_view_place place = rf_view_place_of(d->v, d->view, d->x, d->y, r);
    struct support s = support_of(d->v, d->view, place, d->luminance);
    float share = lit_share_of(s);
    if (share > d->lit_share && (share >= 0.5f || s.n_free == 0)) {
        d->lit_share = share;
        d->r = r;
    }
}

/* The depths of the lights around it in its own view. */
static void try_neighbours(struct depth_search *d)
{
    const struct rf_picture *picture = &d->v->pictures[d->view];
    int cx = (int)d->x, cy = (int)d->y;
    for (int y = rf_max_int(cy - 2, 0); y <= rf_min_int(cy + 2, picture->height - 1);
         y++)
        for (int x = rf_max_int(cx - 2, 0); x <= rf_min_int(cx + 2, picture->width - 1);
             x++)
            try_depth(d, &picture->pixels, x, y);
}

/* The lights that view k shows on the line on which this one must lie there. */
static void try_line(struct depth_search *d, int k)
{
    const struct rf_work_view *own = &d->v->work->views[d->view],
                              *other = &d->v->work->views[k];
    const struct rf_picture *picture = &d->v->pictures[k];
    float pace = rf_max_float(fabsf(other->lens[0] - own->lens[0]),
                              fabsf(other->lens[1] - own->lens[1])) *
                 fabsf(own->shift_scale);
    float most = d->v->work->largest_radius;
    const struct rf_place *whole = &picture->frame->place;
    int n = (int)fminf(
        ceilf(most * pace),
        (float)(whole->whole_width + whole->whole_height + 4 * picture->border));
    for (int i = -n; i <= n && !is_settled(d); i++) {
        float r = most * (float)i / (float)rf_max_int(n, 1);
        int px, py;
        if (!rf_view_pixel_at(d->v, k, rf_view_place_of(d->v, d->view, d->x, d->y, r),
                              &px, &py))
            continue;
        float shown = rf_split_radius_at(&picture->pixels, px, py);
        if (fabsf(shown - r) <= rf_max_float(most / (float)rf_max_int(n, 1), 1))
            try_depth(d, &picture->pixels, px, py);
    }
}

/*
 * The depth of a pixel that a light only touches may be that of its neighbour. Where
 * the other views do not show the light at its place, the depths of the lights around
 * it are tried, then those that the other views show where it could be.
 */
static void find_depth(const struct rf_views *v, int j, struct rf_sample *p)
{
    float luminance = LIT * rf_luminance(p->c[0], p->c[1], p->c[2]);
    struct support own =
        support_of(v, j, rf_view_place_of(v, j, p->x, p->y, p->r), luminance);
    if (lit_share_of(own) >= 0.5f)
        return;
    struct depth_search d = {.v = v,
                             .view = j,
                             .x = p->x,
                             .y = p->y,
                             .luminance = luminance,
                             .r = p->r,
                             .lit_share = lit_share_of(own)};
    try_neighbours(&d);
    for (int k = 0; k < v->work->n_views && !is_settled(&d); k++)
        if (k != j)
            try_line(&d, k);
    p->r = d.r;
}

/*
 * The weight of a moved light: the mean over the views to which its place is free, else
 * as for other samples.
 */
static float light_weight(const struct rf_views *v, int j, const struct rf_sample *p,
                          bool is_rendered)
{
    struct rf_view_place place = {p->x, p->y, p->r};
    int n_free = 0;
    for (int k = 0; k < v->work->n_views; k++)
        n_free += is_free(v, k, place, FREE_PX);
    if (n_free > 0)
        return is_free(v, j, place, FREE_PX) ? p->w / (float)n_free : 0;
    return rf_view_weight(v, RF_ALL_VIEWS, j, place, p->w, true, is_rendered);
}

/* ---- one light per place ------------------------------------------------------- */

/* The place's half pixel along an axis. */
static int half_px(float at)
{
    return rf_view_floor(2 * at);
}

/* By rows of half pixels, then by radius; a total order, whatever sorts. */
static int compare_places(const void *left, const void *right)
{
    const struct rf_sample *a = left, *b = right;
    int rows = half_px(a->y) - half_px(b->y), columns = half_px(a->x) - half_px(b->x);
    if (rows || columns)
        return rows ? rows : columns;
    const float of_a[] = {a->r, a->x, a->y, a->w, a->c[0], a->c[1], a->c[2]};
    const float of_b[] = {b->r, b->x, b->y, b->w, b->c[0], b->c[1], b->c[2]};
    for (size_t i = 0; i < sizeof of_a / sizeof of_a[0]; i++)
        if (of_a[i] != of_b[i])
            return of_a[i] < of_b[i] ? -1 : 1;
    return 0;
}

/*
 * Makes one light of those that lie in one half pixel at about one depth: the views
 * show the same piece of a lamp, and each light costs its mask and its disc. The colour
 * is the sum, place and radius are the means by light. Returns how many are left.
 */
static size_t merge_lights(struct rf_sample *at, size_t n)
{
    size_t n_out = 0;
    for (size_t i = 0; i < n;) {
        struct rf_sample sum = at[i];
        const float x0 = (float)half_px(sum.x) / 2, y0 = (float)half_px(sum.y) / 2;
        double x = 0, y = 0, r = 0, total = 0;
        memset(sum.c, 0, sizeof sum.c);
        for (size_t first = i; i < n; i++) {
            const struct rf_sample *p = &at[i];
            if (half_px(p->x) != half_px(sum.x) || half_px(p->y) != half_px(sum.y) ||
                p->r - at[first].r > SAME_PX)
                break;
            double light = p->w * rf_luminance(p->c[0], p->c[1], p->c[2]);
            for (int k = 0; k < 4; k++)
                sum.c[k] += p->w * p->c[k];
            x += light * (p->x - x0);
            y += light * (p->y - y0);
            r += light * p->r;
            total += light;
        }
        sum.x = x0 + rf_snap_px((float)(x / total));
        sum.y = y0 + rf_snap_px((float)(y / total));
        sum.r = (float)(r / total);
        sum.w = 1;
        at[n_out++] = sum;
    }
    return n_out;
}

/* ---- masks that lights share ---------------------------------------------------- */

/*
 * A lamp of one pixel becomes a light for each half pixel in which some view shows it.
 * What stands before one of them hardly differs from what stands before the others: to
 * discs of so many px that masks cost more than it matters. Of wider lamps it does
 * matter (-0.06 to -0.36 dB on macro).
 */
static const float LAMP_PX = 1, LEAST_SHARED_R_PX = 16;

/* The first light from a half pixel on, in the order of compare_places(). */
static size_t first_from(const struct rf_samples *lights, int row, int column)
{
    size_t from = 0, end = lights->n;
    while (from < end) {
        size_t middle = from + (end - from) / 2;
        const struct rf_sample *p = &lights->at[middle];
        int y = half_px(p->y);
        if (y < row || (y == row && half_px(p->x) < column))
            from = middle + 1;
        else
            end = middle;
    }
    return from;
}

static float brightness(const struct rf_sample *p)
{
    return rf_luminance(p->c[0], p->c[1], p->c[2]);
}

/*
 * Of light i and light k, which lies beside it: the brighter one where both are of a
 * lamp of one pixel, n where the lamp is wider, else `best`.
 */
static size_t brighter_of_lamp(const struct rf_samples *lights, size_t i, size_t k,
                               size_t best)
{
    const struct rf_sample *at = lights->at, *own = &at[i], *p = &at[k];
    float away = rf_max_float(fabsf(p->x - own->x), fabsf(p->y - own->y));
    if (away >= LAMP_PX || fabsf(p->r - own->r) > SAME_PX)
        return away < RF_BESIDE_LAMP_PX ? lights->n : best;
    float light = brightness(p), most = brightness(&at[best]);
    return light > most || (light == most && k < best) ? k : best;
}

/* The brightest light of the lamp of one pixel that light i is of; is it wider, n. */
static size_t brightest_of_lamp(const struct rf_samples *lights, size_t i)
{
    static const int REACH = 2 * RF_BESIDE_LAMP_PX; /* half pixels */
    const struct rf_sample *at = lights->at;
    int row = half_px(at[i].y), column = half_px(at[i].x);
    size_t best = i;
    for (int y = row - REACH; y <= row + REACH; y++)
        for (size_t k = first_from(lights, y, column - REACH);
             k < lights->n && best < lights->n && half_px(at[k].y) == y &&
             half_px(at[k].x) <= column + REACH;
             k++)
            best = brighter_of_lamp(lights, i, k, best);
    return best;
}

/*
 * Finds whose mask each light takes: that of the brightest one of its lamp, if both
 * find the lamp to be of one pixel. Only what is within RF_LAMP_REACH_PX decides, for
 * windows must come to the same.
 */
static void find_leads(const struct rf_samples *lights, uint32_t *lead,
                       uint32_t *brightest)
{
    size_t n = lights->n;
    for (size_t i = 0; i < n; i++)
        brightest[i] = (uint32_t)brightest_of_lamp(lights, i);
    for (size_t i = 0; i < n; i++) {
        uint32_t k = brightest[i];
        bool is_shared =
            k < n && brightest[k] == k && fabsf(lights->at[k].r) >= LEAST_SHARED_R_PX;
        lead[i] = is_shared ? k : (uint32_t)i;
    }
}

/* Puts lights after the ones whose masks they take: `start` has room for n + 1. */
static void sort_by_leads(const struct rf_samples *lights, const uint32_t *lead,
                          uint32_t *start, struct rf_sample *sorted, uint32_t *leads)
{
    size_t n = lights->n;
    memset(start, 0, (n + 1) * sizeof *start);
    for (size_t i = 0; i < n; i++)
        start[lead[i] + 1]++;
    for (size_t i = 0; i < n; i++)
        start[i + 1] += start[i];
    for (size_t i = 0; i < n; i++)
        if (lead[i] == i) {
            for (uint32_t k = start[i]; k < start[i + 1]; k++)
                leads[k] = start[i];
            sorted[start[i]++] = lights->at[i];
        }
    for (size_t i = 0; i < n; i++)
        if (lead[i] != i)
            sorted[start[lead[i]]++] = lights->at[i];
}

static rf_result share_masks(struct rf_views *v, struct rf_error *error)
{
    const struct rf_context *context = v->work->frame->context;
    size_t n = v->lights.n;
    struct rf_sample *sorted = rf_alloc(context, n, sizeof *sorted);
    uint32_t *room = rf_calloc(context, 2 * n + 1, sizeof *room);
    v->light_leads = rf_alloc(context, n, sizeof *v->light_leads);
    bool is_complete = sorted && room && v->light_leads;
    if (is_complete) {
        uint32_t *lead = room, *other = room + n;
        find_leads(&v->lights, lead, other);
        sort_by_leads(&v->lights, lead, other, sorted, v->light_leads);
        rf_free(context, v->lights.at);
        v->lights.at = sorted;
    } else {
        rf_free(context, sorted);
    }
    rf_free(context, room);
    return is_complete ? RF_OK : rf_fail_memory(error, n, sizeof *sorted);
}

rf_result rf_views_take_lights(struct rf_views *v, struct rf_error *error)
{
    const struct rf_context *context = v->work->frame->context;
    size_t n = 0;
    for (int j = 0; j < v->work->n_views; j++) {
        rf_result result = rf_picture_take_highlights(
            &v->pictures[j], &v->work->views[j], v->work->n_planes, error);
        if (result != RF_OK)
            return result;
        n += v->pictures[j].n_highlights;
    }
    v->lights.at = rf_alloc(context, n, sizeof *v->lights.at);
    if (!v->lights.at)
        return rf_fail_memory(error, n, sizeof *v->lights.at);
    for (int j = 0; j < v->work->n_views; j++) {
        const struct rf_picture *picture = &v->pictures[j];
        for (size_t i = 0; i < picture->n_highlights; i++) {
            struct rf_sample p = picture->highlights[i];
            bool is_true = rf_view_is_rendered(picture, (int)p.x, (int)p.y);
            find_depth(v, j, &p);
            struct rf_view_place place = rf_view_place_of(v, j, p.x, p.y, p.r);
            p.x = place.x;
            p.y = place.y;
            p.w = light_weight(v, j, &p, is_true);
            if (p.w > 0 && fmaxf(fabsf(p.x), fabsf(p.y)) < FAR_PX)
                v->lights.at[v->lights.n++] = p;
        }
    }
    qsort(v->lights.at, v->lights.n, sizeof *v->lights.at, compare_places);
    v->lights.n = merge_lights(v->lights.at, v->lights.n);
    return share_masks(v, error);
}
