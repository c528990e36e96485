/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The radius of what is seen in mirrors and through glass (docs/algorithm.md,
 * Reflections). Semi-global matching (Hirschmueller 2008, "Stereo processing by
 * semiglobal matching and mutual information"): with C(p, k) how much the pictures
 * differ at the pixel p where the radius is the k-th, along each of eight directions
 *
 *   L(p, k) = C(p, k) + min(L(q, k), L(q, k +- 1) + P1, min L(q) + P2) - min L(q)
 *
 * for the pixel q before p, and the radius is where the sum S of the eight is least. No
 * path crosses the edge of a mirror. All of it but C is whole numbers, and so the same
 * everywhere. Ours: the radius of the surface itself is cheaper than others, and with it
 * stays what shows no pattern or the same in all views.
 * Cost: pixels times radii, 8 steps and 4 bytes each.
 */
#include "input/seen_match.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"

/*
 * Differences of tones, summed over the colours, that count as MOST_COST: more is
 * another thing, however much.
 */
static const float MOST_DIFFERENCE = 0.5f;
enum {
    MOST_COST = 200,
    /* Of a radius at which another view shows nothing, or something else before it. */
    UNKNOWN_COST = 30,
    /* Of every radius farther than SURFACE_PX from the surface's. */
    BIAS = 6,
    /* Of a step to the next radius between neighbours, and to any other. */
    STEP_PENALTY = 12,
    JUMP_PENALTY = 90,
    HALF_WINDOW = 2,
    N_PATHS = 4, /* and as many the other way */
};
static const float SURFACE_PX = 1;

struct matching {
    const struct rf_seen_problem *problem;
    uint8_t *raw, *cost; /* of every pixel and radius, before and after windows */
    uint16_t *sum;       /* S; `raw` lies there first */
};

static inline size_t place_of(const struct rf_seen_problem *p, int x, int y)
{
    return (size_t)y * (size_t)p->width + (size_t)x;
}

/* ---- differences --------------------------------------------------------------- */

/* The tones at (x, y), between pixels linear; false where a view shows nothing. */
static bool sample(const struct rf_seen_problem *p, const float *tones, float x,
                   float y, float rgb[3])
{
    if (!(x >= 0 && y >= 0 && x <= (float)(p->width - 1) &&
          y <= (float)(p->height - 1)))
        return false;
    int ix = rf_min_int((int)x, rf_max_int(p->width - 2, 0));
    int iy = rf_min_int((int)y, rf_max_int(p->height - 2, 0));
    float fx = x - (float)ix, fy = y - (float)iy;
    const float *a = tones + 3 * place_of(p, ix, iy);
    const float *right = a + (p->width > 1 ? 3 : 0);
    const float *below = a + (p->height > 1 ? 3 * (size_t)p->width : 0);
    const float *both = below + (right - a);
    if (a[0] < 0 || right[0] < 0 || below[0] < 0 || both[0] < 0)
        return false;
    for (int c = 0; c < 3; c++) {
        float up = a[c] + fx * (right[c] - a[c]);
        float down = below[c] + fx * (both[c] - below[c]);
        rgb[c] = up + fy * (down - up);
    }
    return true;
}

/* How much the views differ at a pixel, were its radius r: 0 to MOST_COST. */
static uint8_t cost_at(const struct rf_seen_problem *p, int x, int y, float r)
{
    const float *own = p->views[0].tones + 3 * place_of(p, x, y);
    float total = 0;
    for (int j = 1; j < p->n_views; j++) {
        const struct rf_seen_view *v = &p->views[j];
        float rgb[3], difference = 0;
        float to_x = (float)x + (float)(v->slope[0] * r + v->base[0]);
        float to_y = (float)y + (float)(v->slope[1] * r + v->base[1]);
        if (!sample(p, v->tones, to_x, to_y, rgb)) {
            total += UNKNOWN_COST;
            continue;
        }
        for (int c = 0; c < 3; c++)
            difference += fabsf(rgb[c] - own[c]);
        total += rf_min_float(difference / MOST_DIFFERENCE, 1) * MOST_COST;
    }
    return (uint8_t)(total / (float)(p->n_views - 1));
}

static void find_costs(void *data, int64_t begin, int64_t end, int thread)
{
    const struct matching *m = data;
    const struct rf_seen_problem *p = m->problem;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < p->width; x++) {
            size_t i = place_of(p, x, y);
            uint8_t *to = m->raw + i * (size_t)p->n_radii;
            for (int k = 0; k < p->n_radii && rf_seen_is_lit(p, i); k++)
                to[k] = cost_at(p, x, y, p->first + (float)k * p->step);
        }
}

/* The mean over a pixel's window, of what shows the same mirror. */
static void average_window(const struct matching *m, int x, int y, uint32_t *sums)
{
    const struct rf_seen_problem *p = m->problem;
    size_t n_radii = (size_t)p->n_radii, i = place_of(p, x, y);
    uint32_t n = 0;
    memset(sums, 0, n_radii * sizeof *sums);
    int x0 = rf_max_int(x - HALF_WINDOW, 0);
    int x1 = rf_min_int(x + HALF_WINDOW, p->width - 1);
    for (int b = rf_max_int(y - HALF_WINDOW, 0);
         b <= rf_min_int(y + HALF_WINDOW, p->height - 1); b++)
        for (int a = x0; a <= x1; a++) {
            size_t q = place_of(p, a, b);
            if (!rf_seen_are_joined(p, i, q))
                continue;
            const uint8_t *from = m->raw + q * n_radii;
            for (size_t k = 0; k < n_radii; k++)
                sums[k] += from[k];
            n++;
        }
    uint8_t *to = m->cost + i * n_radii;
    for (size_t k = 0; k < n_radii; k++) {
        float r = p->first + (float)k * p->step;
        to[k] = (uint8_t)((sums[k] + n / 2) / n +
                          (fabsf(r - p->surface[i]) > SURFACE_PX ? BIAS : 0));
    }
}

static void average_windows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct matching *m = data;
    const struct rf_seen_problem *p = m->problem;
    uint32_t sums[RF_SEEN_MOST_RADII];
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < p->width; x++)
            if (rf_seen_is_lit(p, place_of(p, x, y)))
                average_window(m, x, y, sums);
}

/* ---- paths --------------------------------------------------------------------- */

/* The four directions of a pass: the pixel before, for one from above; else mirrored. */
static const int BEFORE[N_PATHS][2] = {{-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

/* L of one direction at pixel i, from that of the pixel before or NULL; adds it to S. */
static void step_path(const struct matching *m, size_t i, const uint16_t *before,
                      uint16_t *to)
{
    int n = m->problem->n_radii;
    const uint8_t *cost = m->cost + i * (size_t)n;
    uint16_t *sum = m->sum + i * (size_t)n;
    int least = 0;
    if (before) {
        least = before[0];
        for (int k = 1; k < n; k++)
            least = rf_min_int(least, before[k]);
    }
    for (int k = 0; k < n; k++) {
        int of = 0;
        if (before) {
            of = rf_min_int(before[k] - least, JUMP_PENALTY);
            if (k > 0)
                of = rf_min_int(of, before[k - 1] - least + STEP_PENALTY);
            if (k < n - 1)
                of = rf_min_int(of, before[k + 1] - least + STEP_PENALTY);
        }
        to[k] = (uint16_t)(cost[k] + of);
        sum[k] = (uint16_t)(sum[k] + to[k]);
    }
}

/* The row of one direction that holds L of row y. */
static uint16_t *path_row(const struct matching *m, uint16_t *rows, int path, int y)
{
    size_t n = (size_t)m->problem->width * (size_t)m->problem->n_radii;
    return rows + n * (size_t)(2 * path + (y & 1));
}

/* A row of a pass; `sign` 1: from above and the left, -1: the other way. */
static void step_row(const struct matching *m, uint16_t *rows, int y, int sign)
{
    const struct rf_seen_problem *p = m->problem;
    for (int s = 0; s < p->width; s++) {
        int x = sign > 0 ? s : p->width - 1 - s;
        size_t i = place_of(p, x, y);
        if (!rf_seen_is_lit(p, i))
            continue;
        for (int path = 0; path < N_PATHS; path++) {
            int a = x + sign * BEFORE[path][0], b = y + sign * BEFORE[path][1];
            bool is_inside = a >= 0 && a < p->width && b >= 0 && b < p->height;
            const uint16_t *before =
                is_inside && rf_seen_are_joined(p, i, place_of(p, a, b))
                    ? path_row(m, rows, path, b) + (size_t)a * (size_t)p->n_radii
                    : NULL;
            step_path(m, i, before,
                      path_row(m, rows, path, y) + (size_t)x * (size_t)p->n_radii);
        }
    }
}

/* ---- radii --------------------------------------------------------------------- */

/* The radius of least S, between the steps where a parabola has it. */
static float best_radius(const struct rf_seen_problem *p, const uint16_t *sum)
{
    int best = 0;
    for (int k = 1; k < p->n_radii; k++)
        best = sum[k] < sum[best] ? k : best;
    float at = (float)best;
    if (best > 0 && best < p->n_radii - 1) {
        float left = sum[best - 1], right = sum[best + 1];
        float bend = left + right - 2 * (float)sum[best];
        if (bend > 0)
            at += (left - right) / (2 * bend);
    }
    return p->first + at * p->step;
}

/* The cost over all radii, and how much less it is at the radius r. */
static void weigh(const struct matching *m, size_t i, float r,
                  const struct rf_seen_match *to)
{
    const struct rf_seen_problem *p = m->problem;
    const uint8_t *cost = m->cost + i * (size_t)p->n_radii;
    uint32_t sum = 0;
    int k = (int)((r - p->first) / p->step + 0.5f);
    k = rf_max_int(rf_min_int(k, p->n_radii - 1), 0);
    for (int n = 0; n < p->n_radii; n++)
        sum += cost[n];
    float own = p->first + (float)k * p->step - p->surface[i], at = cost[k];
    if (fabsf(own) <= SURFACE_PX)
        at += BIAS; /* which it is spared */
    to->cost[i] = (float)sum / (float)p->n_radii;
    to->gain[i] = rf_max_float(to->cost[i] - at, 0);
}

static void find_radii(const struct matching *m, const struct rf_seen_match *to)
{
    const struct rf_seen_problem *p = m->problem;
    size_t n = (size_t)p->width * (size_t)p->height;
    for (size_t i = 0; i < n; i++) {
        to->found[i] = NAN;
        to->cost[i] = to->gain[i] = 0;
        if (!rf_seen_is_lit(p, i))
            continue;
        float r = best_radius(p, m->sum + i * (size_t)p->n_radii);
        if (r - p->surface[i] > SURFACE_PX)
            to->found[i] = r;
        weigh(m, i, r, to);
    }
}

size_t rf_seen_match_bytes(const struct rf_seen_problem *p)
{
    size_t n_pixels = (size_t)p->width * (size_t)p->height;
    return (size_t)p->n_radii * (3 * n_pixels + 4 * N_PATHS * (size_t)p->width);
}

rf_result rf_seen_match(const struct rf_context *context,
                        const struct rf_seen_problem *p,
                        const struct rf_seen_match *match, struct rf_error *error)
{
    size_t n = (size_t)p->width * (size_t)p->height * (size_t)p->n_radii;
    size_t n_rows = 2 * N_PATHS * (size_t)p->width * (size_t)p->n_radii;
    struct matching m = {.problem = p, .cost = rf_alloc(context, n, 1)};
    m.sum = rf_alloc(context, n, sizeof *m.sum);
    uint16_t *rows = rf_alloc(context, n_rows, sizeof *rows);
    rf_result result = RF_OK;
    if (m.cost && m.sum && rows) {
        m.raw = (uint8_t *)m.sum;
        rf_parallel(context, p->height, 4, find_costs, &m);
        rf_parallel(context, p->height, 4, average_windows, &m);
        memset(m.sum, 0, n * sizeof *m.sum);
        for (int y = 0; y < p->height; y++)
            step_row(&m, rows, y, 1);
        for (int y = p->height - 1; y >= 0; y--)
            step_row(&m, rows, y, -1);
        find_radii(&m, match);
    } else {
        result = rf_fail_memory(error, rf_seen_match_bytes(p), 1);
    }
    rf_free(context, rows);
    rf_free(context, m.sum);
    rf_free(context, m.cost);
    return result;
}
