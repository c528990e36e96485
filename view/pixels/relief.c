/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Cost: per px as many steps as the px it may have moved, |slope| (w_max - w_min).
 */
#include "pixels/relief.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "parallel.h"

struct march {
    const struct relief *relief;
    int32_t width, height;
    const float *disparity;
    float nearest, farthest; /* of the disparities */
    int n_steps;
    double step; /* disparity */
};

/* Where px (x, y) of the result came from, had it the disparity w. */
static size_t source_of(const struct march *m, int32_t x, int32_t y, double w)
{
    const struct relief *r = m->relief;
    long sx = lrint(x - r->slope[0] * w - r->base[0]);
    long sy = lrint(y - r->slope[1] * w - r->base[1]);
    sx = sx < 0 ? 0 : sx >= m->width ? m->width - 1 : sx;
    sy = sy < 0 ? 0 : sy >= m->height ? m->height - 1 : sy;
    return (size_t)sy * (size_t)m->width + (size_t)sx;
}

/*
 * The source px that px (x, y) of the result shows. Along the line, `off` is how far
 * the disparity that is found lies behind the one that would bring it here. The surface
 * itself is there where that is half a step, which is half a px, or passes through 0
 * from px to px; a jump is the flank of something nearer, and is not there.
 */
static size_t find_source(const struct march *m, int32_t x, int32_t y)
{
    size_t farthest = 0, before = 0;
    float farthest_w = -INFINITY;
    double off_before = INFINITY;
    for (int i = 0; i <= m->n_steps; i++) {
        const double w = m->nearest + i * m->step;
        const size_t at = source_of(m, x, y, w);
        const float found = m->disparity[at];
        const double off = (found - w) / m->step;
        if (fabs(off) <= 0.5)
            return at;
        if (off < 0 && off_before > 0 && off > -1.5 && off_before < 1.5)
            return off_before < -off ? before : at;
        if (found > farthest_w) {
            farthest_w = found;
            farthest = at;
        }
        off_before = off;
        before = at;
    }
    return farthest;
}

static void find_range(struct march *m)
{
    const size_t n = (size_t)m->width * (size_t)m->height;
    m->nearest = INFINITY;
    m->farthest = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        m->nearest = fminf(m->nearest, m->disparity[i]);
        m->farthest = fmaxf(m->farthest, m->disparity[i]);
    }
    const double slope = hypot(m->relief->slope[0], m->relief->slope[1]);
    const double range = (double)m->farthest - m->nearest;
    const double limit = hypot(m->width, m->height);
    m->n_steps = (int)ceil(fmin(slope * range, limit));
    m->step = m->n_steps > 0 ? range / m->n_steps : 1;
}

/* What the threads share that warp a view. */
struct warping {
    const struct march *march;
    size_t n_channels;
    const float *colour, *depth; /* depth may be NULL */
    float *out_colour, *out_depth;
};

static void warp_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct warping *w = data;
    const struct march *m = w->march;
    const size_t n = w->n_channels;
    for (int32_t y = (int32_t)begin; y < (int32_t)end; y++)
        for (int32_t x = 0; x < m->width; x++) {
            const size_t to = (size_t)y * (size_t)m->width + (size_t)x;
            const size_t from = find_source(m, x, y);
            memcpy(w->out_colour + n * to, w->colour + n * from, n * sizeof(float));
            if (w->depth)
                w->out_depth[to] = w->depth[from];
        }
}

void relief_warp(const struct relief *relief, int32_t width, int32_t height,
                 int n_channels, const float *disparity, const float *colour,
                 const float *depth, float *out_colour, float *out_depth)
{
    struct march m = {
        .relief = relief, .width = width, .height = height, .disparity = disparity};
    find_range(&m);
    struct warping w = {&m, (size_t)n_channels, colour, depth, out_colour, out_depth};
    os_parallel(0, height, 8, warp_rows, &w);
}
