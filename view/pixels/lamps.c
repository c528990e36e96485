/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/lamps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "parallel.h"

enum {
    BLOCK = 16,        /* px of the square whose mean is what surrounds a lamp */
    MOST_FOUND = 32768 /* candidates; in more the picture is bright everywhere */
};
#define TIMES_MEAN 3.0   /* a lamp is so much brighter than the mean of its block ... */
#define LEAST_MORE 0.1f  /* ... and brighter by so much, of a white of 1 */
#define LEAST_RADIUS 1.5 /* px; smaller discs look the same either way */

struct block {
    float mean[3];
};

struct search {
    const float *colour, *radius;
    int n_channels;
    int32_t width, height;
    int n_across;
    struct block *blocks;
};

/* Without the px that are bright themselves a mean says more: the mean of those that are
 * not above twice the block's plain mean. */
static void find_mean(const struct search *s, int64_t block)
{
    const int32_t x0 = (int32_t)(block % s->n_across) * BLOCK;
    const int32_t y0 = (int32_t)(block / s->n_across) * BLOCK;
    float *mean = s->blocks[block].mean, limit = INFINITY;
    for (int round = 0; round < 2; round++) {
        double sum[3] = {0, 0, 0};
        int n = 0;
        for (int32_t y = y0; y < y0 + BLOCK && y < s->height; y++)
            for (int32_t x = x0; x < x0 + BLOCK && x < s->width; x++) {
                const float *at =
                    s->colour +
                    ((size_t)y * (size_t)s->width + (size_t)x) * (size_t)s->n_channels;
                if (!(fmaxf(at[0], fmaxf(at[1], at[2])) <= limit))
                    continue;
                for (int c = 0; c < 3; c++)
                    sum[c] += at[c];
                n++;
            }
        for (int c = 0; c < 3; c++)
            mean[c] = n > 0 ? (float)(sum[c] / n) : 0;
        limit = 2 * fmaxf(mean[0], fmaxf(mean[1], mean[2]));
    }
}

static void find_means(void *data, int64_t begin, int64_t end, int thread)
{
    for (int64_t i = begin; i < end; i++)
        find_mean(data, i);
}

/* Is it a lamp? */
static bool take_px(const struct search *s, int32_t x, int32_t y, struct lamp *lamp)
{
    const size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    const float *at = s->colour + i * (size_t)s->n_channels;
    const float *mean = s->blocks[y / BLOCK * s->n_across + x / BLOCK].mean;
    const float most = fmaxf(at[0], fmaxf(at[1], at[2]));
    const float around = fmaxf(mean[0], fmaxf(mean[1], mean[2]));
    const double radius = fabs(s->radius[i]);
    if (!(most > TIMES_MEAN * around + LEAST_MORE) || !isfinite(most) ||
        !(radius >= LEAST_RADIUS))
        return false;
    *lamp = (struct lamp){.x = x, .y = y, .radius = radius};
    for (int c = 0; c < 3; c++)
        lamp->excess[c] = fmaxf(at[c] - mean[c], 0);
    return true;
}

static double light_of(const struct lamp *lamp)
{
    return (double)lamp->excess[0] + lamp->excess[1] + lamp->excess[2];
}

/* The most light first; of equals the one that was found first. */
static int compare(const void *a, const void *b)
{
    const struct lamp *p = a, *q = b;
    const double x = light_of(p), y = light_of(q);
    if (x != y)
        return x < y ? 1 : -1;
    return p->y != q->y ? p->y - q->y : p->x - q->x;
}

static int find_lamps(const struct search *s, struct lamp *items)
{
    int n = 0;
    for (int32_t y = 0; y < s->height; y++)
        for (int32_t x = 0; x < s->width && n < MOST_FOUND; x++)
            n += take_px(s, x, y, &items[n]);
    return n;
}

/* Keeps those that there is time for. */
static void choose(struct lamps *lamps, int n)
{
    double px = 0;
    qsort(lamps->items, (size_t)n, sizeof(*lamps->items), compare);
    for (lamps->n = 0; lamps->n < n && lamps->n < LAMPS_MAX; lamps->n++) {
        const double r = lamps->items[lamps->n].radius;
        px += M_PI * (r + 1) * (r + 1);
        if (px > LAMPS_MOST_PX)
            break;
    }
}

bool lamps_take(struct lamps *lamps, float *colour, int n_channels, const float *radius,
                int32_t width, int32_t height)
{
    struct search s = {.colour = colour,
                       .radius = radius,
                       .n_channels = n_channels,
                       .width = width,
                       .height = height,
                       .n_across = (width + BLOCK - 1) / BLOCK};
    const int64_t n_blocks = (int64_t)s.n_across * ((height + BLOCK - 1) / BLOCK);
    lamps->n = 0;
    lamps->items = app_memory(MOST_FOUND + 1, sizeof(*lamps->items), NULL);
    s.blocks = app_memory((size_t)n_blocks, sizeof(*s.blocks), NULL);
    if (lamps->items && s.blocks) {
        os_parallel(0, n_blocks, 0, find_means, &s);
        const int n = find_lamps(&s, lamps->items);
        if (n < MOST_FOUND)
            choose(lamps, n);
    }
    for (int i = 0; i < lamps->n; i++) {
        const struct lamp *lamp = &lamps->items[i];
        float *at = colour + ((size_t)lamp->y * (size_t)width + (size_t)lamp->x) *
                                 (size_t)n_channels;
        for (int c = 0; c < 3; c++)
            at[c] -= lamp->excess[c];
    }
    const bool is_good = lamps->items && s.blocks;
    free(s.blocks);
    return is_good;
}

void lamps_free(struct lamps *lamps)
{
    free(lamps->items);
    *lamps = (struct lamps){0};
}

/* ---- discs ------------------------------------------------------------------------ */

struct adding {
    const struct lamps *lamps;
    float *colour;
    int n_channels;
    int32_t width, height;
};

/* The density at t = d^2 / r^2, and its mean over the disc. */
static double density(int32_t distribution, double t)
{
    if (distribution == RF_DISTRIBUTION_GAUSSIAN)
        return exp(-2 * t);
    return distribution == RF_DISTRIBUTION_RING ? 1 + 3 * t * t * t * t : 1;
}

static double mean_density(int32_t distribution)
{
    if (distribution == RF_DISTRIBUTION_GAUSSIAN)
        return (1 - exp(-2)) / 2;
    return distribution == RF_DISTRIBUTION_RING ? 1 + 3.0 / 5 : 1;
}

/* One row of a disc; its edge is a px wide. */
static void add_row(const struct adding *a, const struct lamp *lamp, int32_t y)
{
    const int32_t kind = a->lamps->distribution;
    const double r = lamp->radius, dy = y - lamp->y;
    const double half = sqrt(fmax((r + 0.5) * (r + 0.5) - dy * dy, 0));
    const int32_t from = (int32_t)fmax(ceil(lamp->x - half), 0);
    const int32_t to = (int32_t)fmin(floor(lamp->x + half), a->width - 1);
    const double level = 1 / (M_PI * r * r * mean_density(kind));
    for (int32_t x = from; x <= to; x++) {
        const double dx = x - lamp->x, d2 = dx * dx + dy * dy;
        const double edge = fmin(r + 0.5 - sqrt(d2), 1);
        const float share =
            (float)(level * fmax(edge, 0) * density(kind, fmin(d2 / (r * r), 1)));
        float *at = a->colour +
                    ((size_t)y * (size_t)a->width + (size_t)x) * (size_t)a->n_channels;
        for (int c = 0; c < 3; c++)
            at[c] += share * lamp->excess[c];
    }
}

/* Each row by one thread, its lamps in their order. */
static void add_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct adding *a = data;
    for (int32_t y = (int32_t)begin; y < (int32_t)end; y++)
        for (int i = 0; i < a->lamps->n; i++)
            if (fabs((double)y - a->lamps->items[i].y) <
                a->lamps->items[i].radius + 0.5)
                add_row(a, &a->lamps->items[i], y);
}

void lamps_add(const struct lamps *lamps, float *colour, int n_channels, int32_t width,
               int32_t height)
{
    struct adding a = {lamps, colour, n_channels, width, height};
    if (lamps->n > 0)
        os_parallel(0, height, 0, add_rows, &a);
}
