/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Gaps: pixels that the samples leave open. Where two thin things cross before a wall
 * in focus, behind the first lies the second, and no sample of the wall comes to the
 * pixel: the little light S of both, divided by their small coverage W, is a dark point
 * in the blur. With F the mean of the finished pixels up to REACH away that are no
 * gaps, weighted by (d^2 + 1/2)^-1.5,
 *
 *   out = S / W + k (1 - W) (F - S / W),  k = (MOST - W) / (MOST - LEAST), at most 1
 *
 * which for k = 1 is S + (1 - W) F: no light is counted twice. What has a coverage of
 * MOST or more is no gap. Ours. Worth 0.5 dB on wires before checks. Cost: a comparison
 * per pixel; 0.03 to 1 % of the pixels are gaps.
 */
#include "compose/gaps.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/math.h"
#include "base/parallel.h"
#include "compose/scene.h"
#include "kernels/data.h"

/* Ours. Half or twice of what each leaves open: no scene of tests/quality changes by
 * more than 0.01 dB; that gaps are filled at all is worth 0.5 dB on wires before checks
 * (docs/algorithm.md). */
static const float MOST = 0.9f, LEAST = 0.7f; /* coverage */
/* Where less of what is around is finished, by weight, k is less, down to nothing in
 * the middle of what is wider. */
static const float ENOUGH = 0.25f;

enum { REACH = RF_GAP_REACH, FULL = 255 /* k (1 - W) = 1 */ };

typedef int32_t truths __attribute__((vector_size(16)));

void rf_gaps_note(unsigned char *gaps, const float *coverage, int n)
{
    const rf_quad most = {MOST, MOST, MOST, MOST};
    truths is_gap = {0};
    int any = 0, i = 0;
    for (; i + 4 <= n; i += 4)
        is_gap |= *(const rf_quad *)(coverage + i) < most;
    for (; i < n; i++)
        any |= coverage[i] < MOST;
    any |= is_gap[0] | is_gap[1] | is_gap[2] | is_gap[3];
    for (int x = 0; x < n && any; x++) {
        float w = rf_max_float(coverage[x], 0);
        float k = rf_min_float((MOST - w) / (MOST - LEAST), 1);
        gaps[x] = k > 0 ? (unsigned char)(k * (1 - w) * (FULL - 1) + 1) : 0;
    }
}

/* Colour p of a pixel of the part. */
static float *colour_at(const struct rf_crop *crop, int p, int x, int y)
{
    ptrdiff_t row = crop->stride * y;
    if (crop->rgba)
        return crop->rgba + row + 4 * x + p;
    return crop->planes[p] ? crop->planes[p] + row + x : NULL;
}

/* Weights by squared distances; the gap itself is not looked at. */
static void set_weights(float weights[2 * REACH * REACH + 1])
{
    weights[0] = 0;
    for (int i = 1; i <= 2 * REACH * REACH; i++)
        weights[i] = 1 / (((float)i + 0.5f) * sqrtf((float)i + 0.5f));
}

static void fill_gap(const struct rf_crop *crop, const unsigned char *gaps,
                     const float *weights, int x, int y)
{
    float sum[4] = {0}, total = 0, all = 0;
    int x1 = rf_min_int(x + REACH, crop->width - 1);
    int y1 = rf_min_int(y + REACH, crop->height - 1);
    for (int j = rf_max_int(y - REACH, 0); j <= y1; j++)
        for (int i = rf_max_int(x - REACH, 0); i <= x1; i++) {
            float weight = weights[(i - x) * (i - x) + (j - y) * (j - y)];
            all += weight;
            if (gaps[(size_t)j * (size_t)crop->width + (size_t)i])
                continue;
            total += weight;
            for (int p = 0; p < 4; p++) {
                const float *colour = colour_at(crop, p, i, j);
                sum[p] += colour ? weight * *colour : 0;
            }
        }
    if (!(total > 0))
        return;
    float k = (float)gaps[(size_t)y * (size_t)crop->width + (size_t)x] / FULL;
    k *= rf_min_float(total / (all * ENOUGH), 1);
    for (int p = 0; p < 4; p++) {
        float *colour = colour_at(crop, p, x, y);
        if (colour)
            *colour = (1 - k) * *colour + k * (sum[p] / total);
    }
}

/* Is there a gap among 64 pixels? */
static bool has_gap(const unsigned char *row)
{
    uint64_t part[8], any = 0;
    memcpy(part, row, sizeof part);
    for (int i = 0; i < 8; i++)
        any |= part[i];
    return any != 0;
}

/* The first gap of a row from x on; n where there is none. */
static int find_gap(const unsigned char *row, int x, int n)
{
    while (x < n) {
        int end = rf_min_int(x + 64, n);
        if (end - x == 64 && !has_gap(row + x)) {
            x = end;
            continue;
        }
        for (; x < end; x++)
            if (row[x])
                return x;
    }
    return n;
}

/* What the threads share that fill gaps. */
struct filling {
    const struct rf_crop *crop;
    const unsigned char *gaps;
    float weights[2 * REACH * REACH + 1];
};

static void fill_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct filling *f = data;
    const struct rf_crop *crop = f->crop;
    for (int y = (int)begin; y < (int)end; y++) {
        const unsigned char *row = f->gaps + (size_t)y * (size_t)crop->width;
        for (int x = 0; (x = find_gap(row, x, crop->width)) < crop->width; x++)
            fill_gap(crop, f->gaps, f->weights, x, y);
    }
}

void rf_gaps_fill(const struct rf_crop *crop, const unsigned char *gaps,
                  const struct rf_context *context)
{
    struct filling f = {.crop = crop, .gaps = gaps};
    set_weights(f.weights);
    rf_parallel(context, crop->height, RF_EQUAL_PARTS, fill_rows, &f);
}
