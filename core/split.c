/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Splitting mixed pixels (recipe step 1).
 *
 * The renderer's colour is anti-aliased, its depth is one jittered sample: an edge
 * pixel shows two surfaces but has one depth. With c its colour, f and b the colours of
 * the near and the far surface around it, e = f - b,
 *
 *   A = clamp((c - b) . e / |e|^2)      share of the near surface
 *
 * and c - (A f + (1 - A) b), the residual, goes to both parts. Two cases:
 *
 *   fringe   a small bright thing bleeds into a pixel whose depth sample missed it;
 *            first, since its share is told by luminance alone
 *   edge     the radii of the 3 x 3 pixels around fall into two groups with a gap, and
 *            do not lie on one slanted plane (worth 0.03 to 0.11 dB)
 *
 * Worth 0.9 to 1.3 dB with one view. Cost: a few comparisons per pixel, 5 x 5 pixels
 * where there is an edge.
 */
#include "kernels/kernels.h"
#include "surfaces.h"

static const float EDGE_GAP_PX = 0.1f;     /* smallest jump of the radius at an edge */
static const float PLANE_TOLERANCE = 0.3f; /* of the range of radii */
static const float ALIKE = 0.02f;          /* colours closer than this stay whole */
static const float HIGHLIGHT_RATIO = 8;    /* highlight over its surroundings */
static const float FRINGE_RATIO = 2;       /* fringe over the surroundings */
static const float HIGHLIGHT_OVER_FRINGE = 1.3f;
static const float SAME_SURFACE_PX = 0.3f; /* radii of one surface */

static const float EMPTY = 0.02f; /* alpha behind an edge, of that before it */

enum { WINDOW = 2, BASE_WINDOW = 3 };

struct window {
    int x0, x1, y0, y1; /* inclusive, clipped to the picture */
};

static struct window window_at(const struct rf_pixels *p, int x, int y, int reach)
{
    return (struct window){
        rf_max_int(x - reach, 0), rf_min_int(x + reach, p->width - 1),
        rf_max_int(y - reach, 0), rf_min_int(y + reach, p->height - 1)};
}

static const struct rf_surface *pixel(const struct rf_pixels *p, int x, int y)
{
    return p->at + (size_t)y * (size_t)p->width + (size_t)x;
}

static float luminance(const struct rf_surface *s)
{
    return rf_luminance(s->c[0], s->c[1], s->c[2]);
}

static float distance_weight(int dx, int dy)
{
    return 1.0f / (0.5f + (float)(dx * dx + dy * dy));
}

static void insert_sorted(float *sorted, int n, float v)
{
    for (; n > 0 && sorted[n - 1] > v; n--)
        sorted[n] = sorted[n - 1];
    sorted[n] = v;
}

static float clamp01(float v)
{
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

/* ---- fringes of highlights ----------------------------------------------------- */

struct highlight {
    struct rf_surface brightest;
    float peak;   /* luminance of the brightest pixel around */
    float median; /* lower third of the luminances around: the surroundings */
    float r;      /* median radius of its bright pixels */
};

static bool find_highlight(const struct rf_pixels *p, int x, int y, struct highlight *h)
{
    float sorted[(2 * WINDOW + 1) * (2 * WINDOW + 1)], lowest = INFINITY;
    struct window w = window_at(p, x, y, WINDOW);
    h->peak = -1;
    h->brightest = *pixel(p, x, y);
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++) {
            float l = luminance(pixel(p, i, j));
            lowest = rf_min_float(lowest, l);
            if (l > h->peak) {
                h->peak = l;
                h->brightest = *pixel(p, i, j);
            }
        }
    if (!(h->peak > HIGHLIGHT_RATIO * (lowest + 1e-4f)))
        return false;
    int n = 0;
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++)
            insert_sorted(sorted, n++, luminance(pixel(p, i, j)));
    h->median = sorted[n / 3] + 1e-4f;
    float l = luminance(pixel(p, x, y));
    if (!(h->peak > HIGHLIGHT_RATIO * h->median && l > FRINGE_RATIO * h->median))
        return false;
    n = 0;
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++)
            if (luminance(pixel(p, i, j)) >= 0.6f * h->peak)
                insert_sorted(sorted, n++, pixel(p, i, j)->r);
    h->r = sorted[n / 2];
    return h->peak > HIGHLIGHT_OVER_FRINGE * l &&
           fabsf(h->r - pixel(p, x, y)->r) > 0.08f;
}

/* What the pixel would show without the highlight. */
static void base_colour(const struct rf_pixels *p, int x, int y,
                        const struct highlight *h, float base[4])
{
    const struct rf_surface *c = pixel(p, x, y);
    struct window w = window_at(p, x, y, BASE_WINDOW);
    float sum[4] = {0}, total = 0;
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++) {
            const struct rf_surface *q = pixel(p, i, j);
            if (fabsf(q->r - c->r) > SAME_SURFACE_PX || luminance(q) > 1.5f * h->median)
                continue;
            float k = distance_weight(i - x, j - y);
            for (int n = 0; n < 4; n++)
                sum[n] += k * q->c[n];
            total += k;
        }
    float l = luminance(c);
    for (int n = 0; n < 4; n++)
        base[n] = total > 0 ? sum[n] / total : c->c[n] * (n < 3 ? h->median / l : 1);
}

static bool split_fringe(const struct rf_pixels *p, int x, int y,
                         struct rf_surface *near, struct rf_surface *far, float *share)
{
    struct highlight h;
    if (!find_highlight(p, x, y, &h))
        return false;
    const struct rf_surface *c = pixel(p, x, y);
    struct rf_surface base = {.r = c->r}, light = {.r = h.r};
    base_colour(p, x, y, &h, base.c);
    float base_l = luminance(&base);
    float a = clamp01((luminance(c) - base_l) / (h.peak - base_l));
    for (int n = 0; n < 4; n++) {
        light.c[n] = a > 0 ? (c->c[n] - (1 - a) * base.c[n]) / a : h.brightest.c[n];
        light.c[n] = rf_max_float(light.c[n], 0);
    }
    bool is_light_near = h.r < c->r;
    *near = is_light_near ? light : base;
    *far = is_light_near ? base : light;
    *share = is_light_near ? a : 1 - a;
    return true;
}

/* ---- edges --------------------------------------------------------------------- */

struct edge {
    float threshold; /* near: r <= threshold */
    float gap, lowest, highest;
};

/*
 * Is the neighbourhood one slanted plane? Its rows of radii have gaps too, but no edge.
 * The least-squares plane of 3 x 3 leaves a third of the range at a step.
 */
static bool is_planar(const struct rf_pixels *p, int x, int y, float range)
{
    if (x < 1 || y < 1 || x >= p->width - 1 || y >= p->height - 1)
        return false;
    float mean = 0, slope_x = 0, slope_y = 0;
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            float r = pixel(p, x + i, y + j)->r;
            mean += r / 9;
            slope_x += r * (float)i / 6;
            slope_y += r * (float)j / 6;
        }
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            float fit = mean + slope_x * (float)i + slope_y * (float)j;
            if (fabsf(pixel(p, x + i, y + j)->r - fit) > PLANE_TOLERANCE * range)
                return false;
        }
    return true;
}

static bool find_edge(const struct rf_pixels *p, int x, int y, struct edge *e)
{
    float sorted[9];
    struct window w = window_at(p, x, y, 1);
    int n = 0;
    float lowest = INFINITY, highest = -INFINITY;
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++) {
            float r = pixel(p, i, j)->r;
            lowest = rf_min_float(lowest, r);
            highest = rf_max_float(highest, r);
        }
    if (highest - lowest < EDGE_GAP_PX || is_planar(p, x, y, highest - lowest))
        return false;
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++)
            insert_sorted(sorted, n++, pixel(p, i, j)->r);
    *e = (struct edge){.lowest = lowest, .highest = highest};
    for (int k = 1; k < n; k++)
        if (sorted[k] - sorted[k - 1] > e->gap) {
            e->gap = sorted[k] - sorted[k - 1];
            e->threshold = 0.5f * (sorted[k] + sorted[k - 1]);
        }
    return e->gap >= EDGE_GAP_PX;
}

/* Do all of the pixel's neighbours lie on its side of the edge? */
static bool is_interior(const struct rf_pixels *p, int x, int y, float threshold)
{
    bool is_far = pixel(p, x, y)->r > threshold;
    struct window w = window_at(p, x, y, 1);
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++)
            if ((pixel(p, i, j)->r > threshold) != is_far)
                return false;
    return true;
}

struct mean {
    float c[4], r, weight;
};

static void mean_add(struct mean *m, const struct rf_surface *s, float k)
{
    for (int n = 0; n < 4; n++)
        m->c[n] += k * s->c[n];
    m->r += k * s->r;
    m->weight += k;
}

static struct rf_surface mean_get(const struct mean *m)
{
    struct rf_surface s = {.r = m->r / m->weight};
    for (int n = 0; n < 4; n++)
        s.c[n] = m->c[n] / m->weight;
    return s;
}

/* A side without interior is thin: its pixel that differs most from the other side. */
static void take_most_unlike(const struct rf_pixels *p, int x, int y, float threshold,
                             bool is_far, const struct rf_surface *other,
                             struct rf_surface *out)
{
    struct window w = window_at(p, x, y, WINDOW);
    float best = -1;
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++) {
            const struct rf_surface *q = pixel(p, i, j);
            if ((q->r > threshold) != is_far)
                continue;
            float d = 0;
            for (int n = 0; n < 4; n++)
                d += fabsf(q->c[n] - other->c[n]);
            d /= 1 + 0.3f * (float)((i - x) * (i - x) + (j - y) * (j - y));
            if (d > best) {
                best = d;
                memcpy(out->c, q->c, sizeof out->c);
            }
        }
}

/* Colours and radii of the two surfaces that meet in the pixel; false: only one. */
static bool find_sides(const struct rf_pixels *p, int x, int y, const struct edge *e,
                       struct rf_surface *f, struct rf_surface *b)
{
    struct mean all[2] = {{{0}, 0, 0}}, inner[2] = {{{0}, 0, 0}};
    struct window w = window_at(p, x, y, WINDOW);
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++) {
            const struct rf_surface *q = pixel(p, i, j);
            int side = q->r > e->threshold;
            if (side ? q->r > e->highest + e->gap : q->r < e->lowest - e->gap)
                continue;
            float k = distance_weight(i - x, j - y);
            mean_add(&all[side], q, k);
            if (is_interior(p, i, j, e->threshold))
                mean_add(&inner[side], q, k);
        }
    if (all[0].weight == 0 || all[1].weight == 0)
        return false;
    *f = mean_get(inner[0].weight > 0 ? &inner[0] : &all[0]);
    *b = mean_get(inner[1].weight > 0 ? &inner[1] : &all[1]);
    if (inner[0].weight == 0)
        take_most_unlike(p, x, y, e->threshold, false, b, f);
    else if (inner[1].weight == 0)
        take_most_unlike(p, x, y, e->threshold, true, f, b);
    return true;
}

/*
 * Before transparent film alpha tells the share exactly, and nothing of the colour
 * belongs to the far side.
 */
static void split_by_alpha(const struct rf_surface *c, const struct rf_surface *f,
                           const struct edge *e, const struct rf_surface *b,
                           struct rf_surface *near, struct rf_surface *far,
                           float *share)
{
    float a = clamp01(c->c[3] / f->c[3]);
    bool is_near = c->r <= e->threshold;
    near->r = is_near ? c->r : f->r;
    far->r = is_near ? b->r : c->r;
    for (int n = 0; n < 4; n++) {
        near->c[n] = a > 0 ? c->c[n] / a : f->c[n];
        far->c[n] = 0;
    }
    *share = a;
}

static bool split_edge(const struct rf_pixels *p, int x, int y, struct rf_surface *near,
                       struct rf_surface *far, float *share)
{
    struct edge e;
    struct rf_surface f, b;
    if (!find_edge(p, x, y, &e) || !find_sides(p, x, y, &e, &f, &b))
        return false;
    const struct rf_surface *c = pixel(p, x, y);
    if (b.c[3] < EMPTY * f.c[3]) {
        split_by_alpha(c, &f, &e, &b, near, far, share);
        return true;
    }
    float dot = 0, norm = 0, size = 0;
    for (int n = 0; n < 4; n++) {
        float d = f.c[n] - b.c[n];
        dot += (c->c[n] - b.c[n]) * d;
        norm += d * d;
        size += n < 3 ? f.c[n] + b.c[n] : 0;
    }
    if (norm < ALIKE * ALIKE * size * size + 1e-8f)
        return false;
    float a = clamp01(dot / norm);
    for (int n = 0; n < 4; n++) {
        float residual = c->c[n] - (a * f.c[n] + (1 - a) * b.c[n]);
        float ff = f.c[n] + residual, bb = b.c[n] + residual;
        if (a > 0 && a < 1) { /* what would be negative goes to the other part */
            if (bb < 0) {
                ff += bb * (1 - a) / a;
                bb = 0;
            }
            if (ff < 0) {
                bb += ff * a / (1 - a);
                ff = 0;
            }
        } else if (a == 1) {
            ff = c->c[n];
        } else {
            bb = c->c[n];
        }
        near->c[n] = ff;
        far->c[n] = bb;
    }
    bool is_near = c->r <= e.threshold;
    near->r = is_near ? c->r : f.r;
    far->r = is_near ? b.r : c->r;
    *share = a;
    return true;
}

/* Rows of one thread: extremes of the luminance (5 x 5) and the radius (3 x 3). */
struct scratch {
    const struct rf_kernels *kernels;
    float *columns, *darkest, *brightest, *nearest, *farthest;
};

static void find_extremes(const struct rf_pixels *p, int y, const struct scratch *s)
{
    const float *rows[2 * WINDOW + 1];
    rf_plane_rows(p, p->luminance, y, WINDOW, rows);
    s->kernels->extremes(rows, 2 * WINDOW + 1, WINDOW, p->width, s->columns, s->darkest,
                         s->brightest);
    rf_plane_rows(p, p->radius, y, 1, rows);
    s->kernels->extremes(rows, 3, 1, p->width, s->columns, s->nearest, s->farthest);
}

static void split_row(const struct rf_pixels *pixels, int y, const struct scratch *s,
                      struct rf_surfaces *out)
{
    find_extremes(pixels, y, s);
    for (int x = 0; x < pixels->width; x++) {
        size_t i = (size_t)y * (size_t)pixels->width + (size_t)x;
        struct rf_surface *near = &out->near[i], *far = &out->far[i];
        *near = *far = pixels->at[i];
        out->share[i] = 1;
        bool is_fringe = s->brightest[x] > HIGHLIGHT_RATIO * (s->darkest[x] + 1e-4f) &&
                         split_fringe(pixels, x, y, near, far, &out->share[i]);
        if (!is_fringe && s->farthest[x] - s->nearest[x] >= EDGE_GAP_PX)
            split_edge(pixels, x, y, near, far, &out->share[i]);
    }
}

rf_result rf_split_edges(const struct rf_filter *filter, const struct rf_pixels *pixels,
                         struct rf_surfaces *out, struct rf_task *task,
                         struct rf_error *error)
{
    const struct rf_context *context = filter->context;
    size_t row = pixels->stride, n = row * 5 * (size_t)context->n_threads;
    float *memory = rf_alloc(context, n, sizeof *memory);
    if (!memory)
        return rf_fail_memory(error, n, sizeof *memory);
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 8)
    for (int y = 0; y < pixels->height; y++) {
        if (rf_task_is_cancelled(task))
            continue;
        float *at = memory + row * 5 * (size_t)rf_thread_num();
        struct scratch s = {context->kernels, at,           at + row,
                            at + 2 * row,     at + 3 * row, at + 4 * row};
        split_row(pixels, y, &s, out);
        rf_task_step(task);
    }
    rf_free(context, memory);
    return RF_OK;
}

void rf_split_nothing(const struct rf_filter *filter, const struct rf_pixels *pixels,
                      struct rf_surfaces *out)
{
    size_t n = (size_t)pixels->width * (size_t)pixels->height;
#pragma omp parallel for num_threads(filter->context->n_threads) schedule(static)
    for (size_t i = 0; i < n; i++) {
        out->near[i] = out->far[i] = pixels->at[i];
        out->share[i] = 1;
    }
}
