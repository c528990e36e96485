/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A straight edge between two surfaces, as a roof's before a sky, goes on straight
 * behind a post; the nearest candidates (hidden.c) bend it along the middle of the post.
 * A line through a pixel crosses such an edge once at the most. So where the first
 * candidates to both sides of the pixel have the same radius,
 *
 *   |r_a - r_b| < SAME
 *
 * no edge is between them, the pixel shows their surface, too, and no line shows the
 * surface on the other side of the edge at both ends. What the candidates voted for is
 * kept where one of 16 lines speaks for it, or none for another surface; else the
 * surface of the shortest line is the answer. A nearer surface that is less in focus
 * hides only a part of the lens, so it replaces none; where it was voted for, it gives
 * way to what the lens sees beside it with less than half of its blur, at a distance
 * below r_a - r.
 *
 * Worth up to 4.4 dB where a post crosses a straight edge (tests/quality/layers.py
 * --edges), 0.06 on posts, 0.1 on portrait, at 0.6 to 3 % of a picture.
 */
#include "surfaces/hidden_lines.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/*
 * px of radius; the answers hardly depend on them. KEEP, within which an answer is the
 * surface of a line, is wider, for surfaces that slope. What is out of focus by more than
 * CLEAR may give way to what lies behind it by more than CLEAR.
 */
static const float SAME = 1, KEEP = 2, CLEAR = 1;

/* px from the middle that lines are looked at: as good as every one up to 40. */
static const int8_t STEPS[RF_HIDDEN_LINE_STEPS] = {
    1, 2, 3, 4, 5, 6, 8, 10, 12, 15, RF_HIDDEN_LINE_PX};

void rf_hidden_lines_set(struct rf_hidden_lines *lines, float inv_x2, float inv_y2)
{
    enum { SIDE = RF_HIDDEN_LINES / 4 }; /* the lines end on a square of twice that */
    for (int i = 0; i < RF_HIDDEN_LINES; i++)
        for (int k = 0; k < RF_HIDDEN_LINE_STEPS; k++) {
            bool is_flat = i <= 2 * SIDE;
            int slope = is_flat ? i - SIDE : i - 3 * SIDE;
            int aside =
                (STEPS[k] * abs(slope) + SIDE / 2) / SIDE * (slope < 0 ? -1 : 1);
            int x = is_flat ? STEPS[k] : aside, y = is_flat ? aside : STEPS[k];
            lines->x[i][k] = (int8_t)x;
            lines->y[i][k] = (int8_t)y;
            lines->lens2[i][k] = (float)(x * x) * inv_x2 + (float)(y * y) * inv_y2;
        }
}

/* What a query looks for. */
struct look {
    const struct rf_hidden_lines *lines;
    const struct rf_backs *backs;
    const struct rf_hidden_query *query;
    float room2; /* the square of how far behind candidates may be at the most */
};

/* The end of half a line: its first candidate. */
struct end {
    float r, lens2; /* its squared distance in units of the lens */
    int d2;         /* and in px^2 */
};

static bool find_end(const struct look *look, int line, int sign, struct end *end)
{
    const struct rf_hidden_lines *lines = look->lines;
    const struct rf_backs *backs = look->backs;
    const struct rf_hidden_query *q = look->query;
    for (int k = 0; k < RF_HIDDEN_LINE_STEPS; k++) {
        float lens2 = lines->lens2[line][k];
        int dx = lines->x[line][k], dy = lines->y[line][k];
        int x = q->x + sign * dx, y = q->y + sign * dy;
        if (!(lens2 < look->room2) || (unsigned)x >= (unsigned)backs->width ||
            (unsigned)y >= (unsigned)backs->height)
            return false;
        float r = backs->r[(size_t)y * backs->stride + (size_t)x], room = r - q->s;
        if (room > 0 && lens2 < room * room) {
            *end = (struct end){r, lens2, dx * dx + dy * dy};
            return true;
        }
    }
    return false;
}

/* Does the lens see the end, with less than half of the blur, beside a surface of radius
 * r before it? At any lesser blur: -0.5 dB on walls before bright skies. */
static bool is_clearer(const struct end *end, float r)
{
    float room = end->r - r;
    return r < -CLEAR && room > CLEAR && 2 * fabsf(end->r) < fabsf(r) &&
           end->lens2 < room * room;
}

/* Is a at a lesser distance than b? The nearer surface, if both are as far: what is
 * mirrored has the mirrored answer. */
static bool is_before(const struct end *a, int d2, const struct end *b, int than_d2)
{
    return d2 < than_d2 || (d2 == than_d2 && a->r < b->r);
}

/* The answers that lines have told so far, and how far they are. */
struct told {
    struct end shown, clearer;
    int shown_d2, clearer_d2; /* of a line's both ends, of one; INT32_MAX: none */
    bool has_both, is_kept;
};

static void take_clearer(struct told *told, const struct end *end, float r)
{
    if (is_clearer(end, r) &&
        is_before(end, end->d2, &told->clearer, told->clearer_d2)) {
        told->clearer = *end;
        told->clearer_d2 = end->d2;
    }
}

/* Asks a line what is behind a query for which r was found. */
static void ask_line(const struct look *look, int line, float r, struct told *told)
{
    struct end a, b;
    bool may_give_way = r < -CLEAR;
    bool has_a = find_end(look, line, 1, &a);
    bool has_b = (has_a || may_give_way) && find_end(look, line, -1, &b);
    if (has_a && may_give_way)
        take_clearer(told, &a, r);
    if (has_b && may_give_way)
        take_clearer(told, &b, r);
    if (!has_a || !has_b)
        return;
    told->has_both = true;
    told->is_kept |= fabsf(a.r - r) < KEEP && fabsf(b.r - r) < KEEP;
    const struct end *end = is_before(&a, a.d2, &b, b.d2) ? &a : &b;
    int d2 = a.d2 + b.d2;
    if (fabsf(a.r - b.r) < SAME && is_before(end, d2, &told->shown, told->shown_d2)) {
        told->shown = *end;
        told->shown_d2 = d2;
    }
}

bool rf_hidden_line_up(const struct rf_hidden_lines *lines,
                       const struct rf_backs *backs,
                       const struct rf_hidden_query *query, float farthest, float *r,
                       int *d2)
{
    float room = farthest - query->s;
    const struct look look = {lines, backs, query, room * room};
    struct told told = {.shown_d2 = INT32_MAX, .clearer_d2 = INT32_MAX};
    /* Every second line first: there may be nothing on the other side. */
    for (int j = 0; j < RF_HIDDEN_LINES; j++) {
        if (j == RF_HIDDEN_LINES / 2 && !told.has_both)
            break;
        ask_line(&look, 2 * j % RF_HIDDEN_LINES + (j >= RF_HIDDEN_LINES / 2), *r,
                 &told);
        if (told.is_kept && *r >= -CLEAR)
            return true;
    }
    bool gives_way = told.clearer_d2 < INT32_MAX;
    const struct end *found = gives_way ? &told.clearer : &told.shown;
    bool is_less_clear = found->r < *r && fabsf(found->r) > fabsf(*r);
    if (gives_way || (!told.is_kept && told.shown_d2 < INT32_MAX && !is_less_clear)) {
        *r = found->r;
        *d2 = found->d2;
    }
    return told.has_both;
}
