/* SPDX-License-Identifier: Apache-2.0 */
#include "input/seen_regions.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"

/* ---- flat surfaces --------------------------------------------------------------- */

/*
 * The radii of a plane are linear in the picture, so the second difference
 * r(q - d) - 2 r(q) + r(q + d) is zero. Of the pixels q around one its mean, along each
 * of four directions, may be FLAT_PX, and what a depth that is sampled anywhere in its
 * pixel adds where the plane slants. A glass as wide as a seventh of the picture's
 * height is at 0.065 px (docs/notebook/reflections.md).
 */
static const float FLAT_PX = 0.006f, FLAT_SLOPE = 0.06f;
/* Greater steps and second differences are edges of things. */
static const float MOST_STEP_PX = 3, MOST_BEND_PX = 0.5f;
enum { FLAT_REACH = 12, FLAT_STEP = 3, FLAT_APART = 6, FLAT_LEAST = 4 };

/* Pixels that are something: flat, or an edge. */
struct marking {
    const struct rf_seen_problem *problem;
    uint8_t *is_so;
};

/* Of all pixels, along one direction: second differences, and half the first ones per
 * pixel; below 0: the three are not of one surface. */
struct bends {
    struct marking mark;
    int dx, dy;
    int n_least; /* about a pixel, else it is not flat; 0: any */
    float *second, *slope;
};

static bool find_bend(const struct bends *f, int x, int y, float *second, float *slope)
{
    const struct rf_seen_problem *p = f->mark.problem;
    int x0 = x - f->dx, y0 = y - f->dy, x1 = x + f->dx, y1 = y + f->dy;
    if (x0 < 0 || x1 >= p->width || rf_min_int(y0, y1) < 0 ||
        rf_max_int(y0, y1) >= p->height)
        return false;
    size_t width = (size_t)p->width, i = (size_t)y * width + (size_t)x;
    size_t a = (size_t)y0 * width + (size_t)x0, b = (size_t)y1 * width + (size_t)x1;
    if (!rf_seen_is_lit(p, i) || !rf_seen_is_lit(p, a) || !rf_seen_is_lit(p, b))
        return false;
    float before = p->surface[i] - p->surface[a], after = p->surface[b] - p->surface[i];
    if (fabsf(before) > MOST_STEP_PX || fabsf(after - before) > MOST_BEND_PX)
        return false;
    *second = after - before;
    *slope = fabsf(after + before) / (2 * FLAT_APART);
    return true;
}

static void find_bends(void *data, int64_t begin, int64_t end, int thread)
{
    const struct bends *f = data;
    const int width = f->mark.problem->width;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < width; x++) {
            size_t i = (size_t)y * (size_t)width + (size_t)x;
            if (!find_bend(f, x, y, &f->second[i], &f->slope[i])) {
                f->second[i] = 0;
                f->slope[i] = -1;
            }
        }
}

/* Sums about pixels that lie side by side: one pass over a row for all of them. */
enum { BESIDE = 64 };
struct bend_sums {
    int x, y, n_pixels; /* from (x, y) on */
    float second[BESIDE], slope[BESIDE], n[BESIDE];
};

/* Adds what lies `across` px to the right of each pixel, in row b. */
static void add_bends(const struct bends *f, int across, int b, struct bend_sums *sums)
{
    const struct rf_seen_problem *p = f->mark.problem;
    const size_t width = (size_t)p->width;
    const int x = sums->x, n = rf_min_int(sums->n_pixels, p->width - (x + across));
    const size_t at = (size_t)b * width + (size_t)(x + across);
    const float *own = p->surface + (size_t)sums->y * width + (size_t)x;
    const float *surface = p->surface + at;
    const float *second = f->second + at, *slope = f->slope + at;
    for (int i = 0; i < n; i++) {
        const bool is_near = fabsf(surface[i] - own[i]) <= MOST_STEP_PX;
        const bool is_one = !(slope[i] < 0);
        sums->second[i] += is_near & is_one ? second[i] : 0;
        sums->slope[i] += is_near & is_one ? slope[i] : 0;
        sums->n[i] += is_near & is_one ? 1.0f : 0;
    }
}

/* Is what lies around n pixels from (x, y) on flat along the direction? A sliver is not
 * told from what is curved. */
static void drop_bent(const struct bends *f, int x, int y, int n)
{
    const struct rf_seen_problem *p = f->mark.problem;
    struct bend_sums sums = {.x = x, .y = y, .n_pixels = n};
    uint8_t *is_so = f->mark.is_so + (size_t)y * (size_t)p->width + (size_t)x;
    const int first = rf_max_int(-FLAT_REACH, -x);
    for (int b = rf_max_int(y - FLAT_REACH, 0);
         b <= rf_min_int(y + FLAT_REACH, p->height - 1); b += FLAT_STEP)
        for (int a = first; a <= FLAT_REACH; a += FLAT_STEP)
            add_bends(f, a, b, &sums);
    for (int i = 0; i < n; i++) {
        const bool is_bent =
            sums.n[i] >= FLAT_LEAST &&
            fabsf(sums.second[i]) > FLAT_PX * sums.n[i] + FLAT_SLOPE * sums.slope[i];
        is_so[i] &= sums.n[i] >= (float)f->n_least && !is_bent;
    }
}

/* Beside the left border the places begin at it, so that each pixel has its own. */
static void keep_flats(void *data, int64_t begin, int64_t end, int thread)
{
    const struct bends *f = data;
    const int width = f->mark.problem->width;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0, n; x < width; x += n) {
            const uint8_t *is_so = f->mark.is_so + (size_t)y * (size_t)width;
            n = x < FLAT_REACH ? 1 : rf_min_int(BESIDE, width - x);
            bool is_any = false;
            for (int i = x; i < x + n; i++)
                is_any |= is_so[i];
            if (is_any)
                drop_bent(f, x, y, n);
        }
}

rf_result rf_seen_drop_curved(const struct rf_context *context,
                              const struct rf_seen_problem *p, float *tones,
                              struct rf_error *error)
{
    static const int along[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
    size_t n = (size_t)p->width * (size_t)p->height;
    float *room = rf_alloc(context, n, 2 * sizeof(float) + 1);
    if (!room)
        return rf_fail_memory(error, n, 2 * sizeof(float) + 1);
    struct bends f = {.second = room, .slope = room + n};
    f.mark = (struct marking){p, (uint8_t *)(room + 2 * n)};
    for (size_t i = 0; i < n; i++)
        f.mark.is_so[i] = rf_seen_is_lit(p, i);
    for (int k = 0; k < 4; k++) {
        f.dx = FLAT_APART * along[k][0];
        f.dy = FLAT_APART * along[k][1];
        f.n_least = k < 2 ? FLAT_LEAST : 0;
        rf_parallel(context, p->height, 4, find_bends, &f);
        rf_parallel(context, p->height, 4, keep_flats, &f);
    }
    for (size_t i = 0; i < n; i++)
        if (!f.mark.is_so[i])
            tones[3 * i] = -1;
    rf_free(context, room);
    return RF_OK;
}

/* ---- edges ----------------------------------------------------------------------- */

/* A line of mixed pixels has five of 5 x 5; a mirror's own edge ten and more. */
enum { EDGE_REACH = 2, EDGE_MOST = 7 };

static void mark_edges(void *data, int64_t begin, int64_t end, int thread)
{
    const struct marking *f = data;
    const struct rf_seen_problem *p = f->problem;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < p->width; x++) {
            size_t i = (size_t)y * (size_t)p->width + (size_t)x;
            int n = 0;
            for (int b = rf_max_int(y - EDGE_REACH, 0);
                 b <= rf_min_int(y + EDGE_REACH, p->height - 1); b++)
                for (int a = rf_max_int(x - EDGE_REACH, 0);
                     a <= rf_min_int(x + EDGE_REACH, p->width - 1); a++)
                    n += rf_seen_are_joined(p, i,
                                            (size_t)b * (size_t)p->width + (size_t)a);
            f->is_so[i] = n <= EDGE_MOST;
        }
}

void rf_seen_mark_edges(const struct rf_context *context,
                        const struct rf_seen_problem *p, uint8_t *is_edge)
{
    struct marking f = {p, is_edge};
    rf_parallel(context, p->height, 4, mark_edges, &f);
}

/* ---- regions --------------------------------------------------------------------- */

/*
 * Of a region: by which part of the mean cost what is found must be better, times the
 * part that this has in all gains; others are of what lies on the surface or before it.
 * Rough surfaces do not reach it (bar's table 0.33), faint reflections in a pane hardly
 * (mirrors 0.37 to 0.41), mirrors do (0.65 to 0.73; half out of the other view 0.42, of half grain 0.45). What is open
 * is filled then: all that a flat mirror shows lies behind it.
 */
static const double LEAST_SURE = 0.36;

struct regions {
    const struct rf_seen_problem *problem;
    int32_t *queue; /* the pixels of a region, in the order in which they are reached */
    uint8_t *is_known;
};

/* The pixels of the region of pixel i, into `queue`; how many. */
static size_t collect(const struct regions *s, size_t i)
{
    const struct rf_seen_problem *p = s->problem;
    size_t n = 0, done = 0, width = (size_t)p->width;
    s->queue[n++] = (int32_t)i;
    s->is_known[i] = 1;
    while (done < n) {
        size_t at = (size_t)s->queue[done++], x = at % width, y = at / width;
        const size_t beside[4] = {x > 0 ? at - 1 : at, x + 1 < width ? at + 1 : at,
                                  y > 0 ? at - width : at,
                                  y + 1 < (size_t)p->height ? at + width : at};
        for (int k = 0; k < 4; k++) {
            size_t q = beside[k];
            if (s->is_known[q] || !rf_seen_are_joined(p, at, q))
                continue;
            s->is_known[q] = 1;
            s->queue[n++] = (int32_t)q;
        }
    }
    return n;
}

/* Fills open pixels of a region from what is found beside them, ring by ring. */
static void fill(const struct regions *s, size_t n, float *found)
{
    const struct rf_seen_problem *p = s->problem;
    size_t width = (size_t)p->width, n_open = 0, n_before;
    for (size_t k = 0; k < n; k++)
        if (!isfinite(found[s->queue[k]]))
            s->queue[n_open++] = s->queue[k];
    do {
        n_before = n_open;
        n_open = 0;
        for (size_t k = 0; k < n_before; k++) {
            size_t at = (size_t)s->queue[k], x = at % width, y = at / width;
            float sum = 0, n_around = 0;
            for (int b = -1; b <= 1; b++)
                for (int a = -1; a <= 1; a++) {
                    if ((x == 0 && a < 0) || (x + 1 == width && a > 0) ||
                        (y == 0 && b < 0) || (y + 1 == (size_t)p->height && b > 0))
                        continue;
                    size_t q = at + (size_t)b * width + (size_t)a;
                    if (isfinite(found[q]) && rf_seen_are_joined(p, at, q)) {
                        sum += found[q];
                        n_around++;
                    }
                }
            if (n_around > 0)
                found[at] = sum / n_around;
            else
                s->queue[n_open++] = (int32_t)at;
        }
    } while (n_open > 0 && n_open < n_before);
}

static void settle_region(const struct regions *s, size_t n, float *found,
                          const struct rf_seen_match *match)
{
    double gain = 0, cost = 0, against = 0;
    for (size_t k = 0; k < n; k++) {
        size_t i = (size_t)s->queue[k];
        if (isfinite(found[i])) {
            gain += match->gain[i];
            cost += match->cost[i];
        } else {
            against += match->gain[i];
        }
    }
    if (cost > 0 && gain * gain >= LEAST_SURE * cost * (gain + against)) {
        fill(s, n, found);
        return;
    }
    for (size_t k = 0; k < n; k++)
        found[s->queue[k]] = NAN;
}

rf_result rf_seen_settle(const struct rf_context *context,
                         const struct rf_seen_problem *p,
                         const struct rf_seen_match *match, struct rf_error *error)
{
    size_t n = (size_t)p->width * (size_t)p->height;
    struct regions s = {p, rf_alloc(context, n, sizeof *s.queue),
                        rf_calloc(context, n, 1)};
    rf_result result = RF_OK;
    if (s.queue && s.is_known) {
        for (size_t i = 0; i < n; i++)
            if (!s.is_known[i] && rf_seen_is_lit(p, i))
                settle_region(&s, collect(&s, i), match->found, match);
    } else {
        result = rf_fail_memory(error, n, 1 + sizeof *s.queue);
    }
    rf_free(context, s.queue);
    rf_free(context, s.is_known);
    return result;
}
