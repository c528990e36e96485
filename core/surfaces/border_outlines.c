/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is cut by the border goes on as it leans: a stalk that leaves the picture aslant
 * does not stand upright beyond it, where it would hide other things from the lens. An
 * outline is where the radius steps at the border, and belongs to the nearer surface. It
 * is followed inwards, as far as it is smooth, and goes on along its tangent, by the line
 * of least squares or, where it is bowed, the parabola. The nearer surface is seen where
 * two meet, the farther one where they part. There is always one that owns no outline,
 * which stays: surfaces are one more than outlines. Ours.
 */
#include "surfaces/border_outlines.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "rackfocus/rackfocus.h"

/* Pixels inwards that an outline is followed: at the most, and at the least to tell how
 * it leans. (The worth of all thresholds here: docs/notebook/border.md.) */
enum { FOLLOWED = 32, LEAST_FOLLOWED = 8 };
/* px that an outline's middle lies off the line through its ends, for it to be bowed. */
static const float BOWED = 1;
/*
 * How far it may lie from a line or a parabola, px: so much, and so much per px that it is
 * followed. Rough outlines lean as a whole does, not as the last 8 px do.
 */
static const float BENT = 0.25f, BENT_PER_PX = 1.0f / 16;
/* Lines per px of what leans most. */
enum { STEEPEST = 2 };
/* Lines beside an outline that may show what is on its other side. */
enum { RIM = 2 };
/* Lines that an outline must move by to lean. */
static const float UPRIGHT = 0.5f;

static float radius_at(const struct rf_border_radii *s, int line, int i)
{
    return s->first[line * s->next + i * s->inwards];
}

/* Where an outline lies i px inwards, the line after it: near `line`. -1: lost. */
static int follow(const struct rf_border_radii *s, int line, int i, bool is_before,
                  float *nearer)
{
    static const int BESIDE[] = {0, 1, -1, 2, -2};
    for (int k = 0; k < 5; k++) {
        int at = line + BESIDE[k];
        if (at < 1 || at >= s->n_lines)
            continue;
        float near = radius_at(s, is_before ? at - 1 : at, i);
        float far = radius_at(s, is_before ? at : at - 1, i);
        if (rf_is_same_surface(near, *nearer) && far > near + RF_LARGEST_STEP) {
            *nearer = near;
            return at;
        }
    }
    return -1;
}

/*
 * The slope at the first of n places, lines per px; NAN where they are neither on a line
 * nor, where that is bowed, on a parabola.
 */
static float slope_of(const int *place, int n)
{
    float middle = 0.5f * (float)(n - 1);
    float mean = 0, squares = 0, fourths = 0, slope = 0, bow = 0;
    for (int i = 0; i < n; i++) {
        float x = (float)i - middle;
        mean += (float)(place[i] - place[0]);
        squares += x * x;
    }
    mean /= (float)n;
    float square = squares / (float)n;
    for (int i = 0; i < n; i++) {
        float x = (float)i - middle, y = (float)(place[i] - place[0]) - mean;
        float curved = x * x - square;
        slope += x * y;
        bow += curved * y;
        fourths += curved * curved;
    }
    slope /= squares;
    bow /= fourths;
    if (fabsf(bow) * middle * middle < BOWED)
        bow = 0;
    float bent = BENT + BENT_PER_PX * (float)n;
    for (int i = 0; i < n; i++) {
        float x = (float)i - middle;
        float on = mean + slope * x + bow * (x * x - square);
        if (fabsf(on - (float)(place[i] - place[0])) > bent)
            return NAN;
    }
    return slope - 2 * bow * middle;
}

/* How an outline leans whose nearer surface lies before `line`, or else from it on. */
static float lean(const struct rf_border_radii *s, int line, bool is_before)
{
    int place[FOLLOWED] = {line}, n = 1;
    int most = rf_min_int(rf_min_int(FOLLOWED, s->depth), 2 * s->border);
    float nearer = radius_at(s, is_before ? line - 1 : line, 0);
    while (n < most && (place[n] = follow(s, place[n - 1], n, is_before, &nearer)) >= 0)
        n++;
    for (; n >= LEAST_FOLLOWED; n /= 2) {
        float slope = slope_of(place, n);
        if (!isnan(slope))
            return fabsf(slope) * (float)s->border < UPRIGHT
                       ? 0
                       : fminf(fmaxf(-slope, -STEEPEST), STEEPEST);
    }
    return 0;
}

/* Measures a surface's slopes at both ends. */
static void measure(struct rf_outlines *outlines, const struct rf_border_radii *s,
                    struct rf_outline *o)
{
    const int last = o->end - 1;
    bool is_first = o->begin == 0, is_last = o->end == s->n_lines;
    o->slope[0] = o->slope[1] = 0;
    if (!is_first && radius_at(s, o->begin, 0) < radius_at(s, o->begin - 1, 0))
        o->slope[0] = lean(s, o->begin, false);
    if (!is_last && radius_at(s, last, 0) < radius_at(s, o->end, 0))
        o->slope[1] = lean(s, o->end, true);
    int n = rf_min_int(o->end - o->begin, STEEPEST * s->border);
    o->n_affected = (float)n;
    outlines->are_upright &= o->slope[0] == 0 && o->slope[1] == 0;
}

rf_result rf_outlines_find(struct rf_outlines *outlines,
                           const struct rf_border_radii *s,
                           const struct rf_context *context, struct rf_error *error)
{
    *outlines = (struct rf_outlines){.are_upright = true};
    int n = 1;
    for (int i = 1; i < s->n_lines; i++)
        n += !rf_is_same_surface(radius_at(s, i, 0), radius_at(s, i - 1, 0));
    outlines->at = rf_alloc(context, (size_t)n, sizeof *outlines->at);
    if (!outlines->at)
        return rf_fail_memory(error, (size_t)n, sizeof *outlines->at);
    for (int begin = 0, end; begin < s->n_lines; begin = end) {
        for (end = begin + 1; end < s->n_lines; end++)
            if (!rf_is_same_surface(radius_at(s, end, 0), radius_at(s, end - 1, 0)))
                break;
        struct rf_outline *o = &outlines->at[outlines->n++];
        *o = (struct rf_outline){.begin = begin, .end = end};
        measure(outlines, s, o);
    }
    return RF_OK;
}

void rf_outlines_free(struct rf_outlines *outlines, const struct rf_context *context)
{
    rf_free(context, outlines->at);
    outlines->at = NULL;
}

/* Where the side of a line lies k px beyond the border. */
static float moved(const struct rf_outline *o, int side, int k)
{
    float before = fmaxf(1 - (float)(side - o->begin) / o->n_affected, 0);
    float after = fmaxf(1 - (float)(o->end - side) / o->n_affected, 0);
    return (float)side + (float)k * (o->slope[0] * before + o->slope[1] * after);
}

/* Lays a surface where nothing nearer is; not with lines that may show a nearer one
 * beside it which leans. */
static void lay(const struct rf_outlines *outlines, const struct rf_border_radii *s,
                const struct rf_outline *o, int k, int *line)
{
    int begin = o->begin, end = o->end;
    if (o > outlines->at && o[-1].slope[1] != 0)
        begin += RIM;
    if (o < outlines->at + outlines->n - 1 && o[1].slope[0] != 0)
        end -= RIM;
    if (begin >= end)
        begin = o->begin, end = o->end;
    float to = moved(o, begin, k);
    for (int i = begin; i < end; i++) {
        float from = to;
        to = moved(o, i + 1, k);
        int first = rf_max_int((int)ceilf(from - 0.5f), 0);
        for (int at = first; at < s->n_lines && (float)at + 0.5f < to; at++)
            if (line[at] < 0 || radius_at(s, i, 0) < radius_at(s, line[at], 0))
                line[at] = i;
    }
}

static const struct rf_outline *surface_of(const struct rf_outlines *outlines, int line)
{
    int low = 0, high = outlines->n - 1;
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (outlines->at[middle].begin <= line)
            low = middle;
        else
            high = middle - 1;
    }
    return &outlines->at[low];
}

/*
 * Fills n places, from one on by `step`, with the surface of the line `from` beside them:
 * with its lines from there on, to and fro, but not with pixels that may show both.
 */
static void fill_by(const struct rf_outlines *outlines, const struct rf_border_radii *s,
                    int from, int step, int n, int *place)
{
    const struct rf_outline *o = surface_of(outlines, from);
    int n_lines = step > 0 ? from - o->begin + 1 : o->end - from;
    int skipped = rf_min_int(RIM, n_lines - 1);
    n_lines = rf_min_int(n_lines - skipped, s->border);
    for (int i = 0; i < n; i++) {
        int at = i % (2 * n_lines);
        at = skipped + (at < n_lines ? at : 2 * n_lines - 1 - at);
        place[step * i] = from - step * at;
    }
}

/* Fills places where surfaces parted with the farther one beside them. */
static void fill(const struct rf_outlines *outlines, const struct rf_border_radii *s,
                 int *line)
{
    int n = s->n_lines;
    for (int begin = 0, end; begin < n; begin = end + 1) {
        for (end = begin; end < n && line[end] < 0; end++)
            ;
        if (end == begin)
            continue;
        int before = begin > 0 ? line[begin - 1] : -1, after = end < n ? line[end] : -1;
        bool is_before = after < 0 || (before >= 0 && radius_at(s, before, 0) >=
                                                          radius_at(s, after, 0));
        if (is_before)
            fill_by(outlines, s, before, 1, end - begin, &line[begin]);
        else
            fill_by(outlines, s, after, -1, end - begin, &line[end - 1]);
    }
}

void rf_outlines_at(const struct rf_outlines *outlines, const struct rf_border_radii *s,
                    int k, int *line)
{
    for (int i = 0; i < s->n_lines; i++)
        line[i] = outlines->are_upright ? i : -1;
    if (outlines->are_upright)
        return;
    for (int i = 0; i < outlines->n; i++)
        lay(outlines, s, &outlines->at[i], k, line);
    fill(outlines, s, line);
}
