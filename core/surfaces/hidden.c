/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Hidden background: what the pinhole could not see but the lens does
 * (docs/algorithm.md, "Hidden background").
 *
 * For a pixel p whose near surface has radius s, a pixel q at distance d shows a
 * surface (its far part where it is mixed) of radius r_q. The lens can reveal that
 * surface behind p only where
 *
 *   d < r_q - s                                              (q is a candidate)
 *
 * d measured in units of the aperture's extent; a receding plane of slope below 1 never
 * triggers itself. The candidates vote for the radius r_b of the surface behind (a
 * histogram of 1/2 px bins, weight (d^2 + 1/2)^-3, smoothed); with d_1 the distance of
 * the nearest candidate near r_b, the colour is the mean over the window w = 2.5 d_1 +
 * 3 with the weight exp(-(r_q - r_b)^2 / 2) (d^2 + 1/2)^-1.5 (1 - d^2 / w^2); without
 * the last factor pictures flicker, as d_1 grows in steps. The far part of a mixed pixel
 * counts by its share, as its colour is that unsure. Colours are limited to
 * 1.5 times the weighted geometric mean of the luminance: without it lamps at the edge
 * are doubled. Straight edges between two surfaces behind: hidden_lines.c.
 *
 * Worth 3.7 to 5.3 dB with one view.
 *
 * What is ours for speed: 8 x 8 blocks know their highest radius, and each block lists
 * once which others can hold the nearest candidate for its pixels, in rings from the
 * inside: only those that hold or touch an edge; the search ends at twice the nearest
 * candidate, or where no block that follows is far enough behind; far blocks and wide
 * windows are read at every 2nd, 4th, .. pixel; 2 x 2 pixels of one surface share one
 * answer, 4 x 4 where the rim of the hole is 3 px away and 8 x 8 where it is 12 px from
 * their middle, unless the answer is nearly in focus; behind a mixed pixel lies its own
 * far part, unless that is bright.
 * None of it costs more than 0.02 dB.
 */
#include "surfaces/hidden.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "input/frame.h"
#include "kernels/data.h"
#include "kernels/hidden_kernels.h"
#include "kernels/kernels.h"
#include "lens/aperture.h"
#include "surfaces/hidden_blocks.h"
#include "surfaces/hidden_lines.h"
#include "surfaces/hidden_steps.h"
#include "rackfocus/rackfocus.h"

enum {
    BLOCK = RF_HIDDEN_BLOCK,
    MAX_REACH = RF_HIDDEN_REACH,
    MAX_WINDOW = 120,
    GROUP = RF_HIDDEN_GROUP, /* px a side: pixels that may share one answer */
    FAR_HOLE2 = 3 * 3,       /* px^2: if the rim of the hole is as far as this */
    FAR_BLOCK2 = 12 * 12,    /* px^2: the same for BLOCK x BLOCK, from their middle */
    RIM_PX = 2,              /* a mixed pixel lies between */
    MOST_RINGS = RF_HIDDEN_RINGS,
    AREA = RF_HIDDEN_AREA,
    MOST_BLOCKS = RF_HIDDEN_BLOCKS,
    LINE_RINGS = (RF_HIDDEN_LINE_PX + BLOCK - 1) / BLOCK, /* of blocks, for lines */
};

/*
 * Ours; see split.c for what stands behind them. BRIGHTEST, over the geometric mean: at
 * 1.1 macro -0.10, posts -0.10; at 3 portrait +0.04, but lamps at the edge are doubled.
 * FLAT_PX of radius, within which blocks may share one answer, and BLURRED_PX, below
 * which an answer is nearly in focus and blocks of one would show: 0; 0, for speed.
 */
static const float BRIGHTEST = 1.5f;
static const float FLAT_PX = 4;
static const float BLURRED_PX = BLOCK / 2.0f;
static const float WHITE = 1; /* luminance of a far part that needs no mean */

/* ---- where candidates may be --------------------------------------------------- */

/* What a thread works with. */
struct scratch {
    struct rf_hidden_vote vote;
    struct rf_hidden_window window;
    struct rf_hidden_group group;
    int n_blocks, n_of_ring[MOST_RINGS + 1];
    float farthest; /* radius as far as lines reach */
    float step;   /* the greatest radius of a step's near side as far as lines reach */
    bool is_thin; /* a line through the group's first pixels may have two ends */
    struct rf_hidden_block found[MOST_BLOCKS], blocks[MOST_BLOCKS]; /* by rows, rings */
    struct rf_hidden_hit hits[MOST_BLOCKS];
};

/* Squared least distance of two blocks that are d blocks apart, in units of the lens.
 */
static float gap2_of(int d, double extent)
{
    float gap = (float)(rf_max_int(abs(d) - 1, 0) * BLOCK + (d != 0)) / (float)extent;
    return gap * gap;
}

static void set_gaps(struct rf_hidden_search *search)
{
    for (int k = 0; k < 2; k++)
        for (int d = 0; d <= MOST_RINGS; d++)
            search->gap2[k][d] = gap2_of(d, search->extent[k]);
}

/* Lists block (bx, by) of a ring if it can have candidates, in the ring's turn. */
static void add_block(const struct rf_hidden_search *search, struct scratch *scratch,
                      int bx, int by, int dx, int dy, float lowest)
{
    float highest = search->blocks[(by + dy) * search->n_x + bx + dx].highest;
    float room = highest - lowest;
    float gap2 = search->gap2[0][abs(dx)] + search->gap2[1][abs(dy)];
    if (!(room > 0) || !(gap2 < room * room))
        return;
    int ring = rf_max_int(abs(dx), abs(dy));
    scratch->found[scratch->n_blocks++] = (struct rf_hidden_block){
        (int16_t)(bx + dx), (int16_t)(by + dy), ring, highest,
        highest - sqrtf(gap2) + 1e-6f * fabsf(highest) + 1e-3f};
    scratch->n_of_ring[ring]++;
    if (ring > LINE_RINGS)
        return;
    float step = search->blocks[(by + dy) * search->n_x + bx + dx].step;
    scratch->step = rf_max_float(step, scratch->step);
    scratch->farthest = rf_max_float(highest, scratch->farthest);
}

/* Sorts what was found by rings from the inside. */
static void sort_blocks(struct scratch *scratch, int n_rings)
{
    int start[MOST_RINGS + 1], n = 0;
    for (int ring = 0; ring < n_rings; ring++) {
        start[ring] = n;
        n += scratch->n_of_ring[ring];
    }
    for (int i = 0; i < n; i++)
        scratch->blocks[start[scratch->found[i].ring]++] = scratch->found[i];
    for (int i = n - 2; i >= 0; i--)
        scratch->blocks[i].most =
            rf_max_float(scratch->blocks[i].most, scratch->blocks[i + 1].most);
}

/* The bits of rough blocks bx, bx + 1, .. of a row, of which that many exist. */
static uint32_t rough_from(const struct rf_hidden_search *search, int bx, int by, int n)
{
    const uint32_t *bits = search->rough + by * search->n_words + bx / 32;
    uint64_t two = bits[0] | (uint64_t)bits[1] << 32;
    return (uint32_t)(two >> bx % 32) & (((uint32_t)1 << n) - 1);
}

/*
 * Blocks that hold the nearest candidate for a pixel of block (bx, by), in rings from
 * the inside. They are rough: where no edge lies between, the next pixel on the way is
 * a candidate, too.
 */
static void list_blocks(const struct rf_hidden_search *search, int bx, int by,
                        struct scratch *scratch)
{
    float lowest = search->blocks[by * search->n_x + bx].lowest;
    float highest =
        search->highest[by / AREA * rf_hidden_n_areas(search->n_x) + bx / AREA];
    float room = highest - lowest;
    scratch->n_blocks = 0;
    scratch->farthest = scratch->step = -INFINITY;
    if (!(room > 0))
        return;
    double reach_px = room * fmax(search->extent[0], search->extent[1]);
    int reach = (int)fmin(ceil(reach_px), MAX_REACH) / BLOCK + 1;
    if (!rf_hidden_has_rough(search->blocks, search->n_x, search->n_y, bx, by, reach))
        return;
    memset(scratch->n_of_ring, 0, sizeof scratch->n_of_ring);
    int x0 = rf_max_int(bx - reach, 0);
    int n = rf_min_int(bx + reach + 1, search->n_x) - x0;
    int y0 = rf_max_int(by - reach, 0);
    int y1 = rf_min_int(by + reach + 1, search->n_y);
    for (int y = y0; y < y1; y++)
        for (uint32_t bits = rough_from(search, x0, y, n); bits; bits &= bits - 1)
            add_block(search, scratch, bx, by, x0 + __builtin_ctz(bits) - bx, y - by,
                      lowest);
    sort_blocks(scratch, reach + 1);
}

/* ---- the answer ---------------------------------------------------------------- */

/* Weighted mean of the window, no pixel brighter than the limit. */
static bool average(const struct rf_hidden_search *search, struct scratch *scratch,
                    struct rf_surface *mean)
{
    struct rf_hidden_window *window = &scratch->window;
    if (!(window->weight_sum > 0))
        return false;
    search->kernels->average_window(search->s, window, BRIGHTEST, mean->c);
    mean->r = window->r_sum * (1 / window->weight_sum);
    return true;
}

/*
 * Does the far part of the query's own pixel win the vote? At no distance it has more
 * votes than all other pixels together could have; *r receives the radius of its bin.
 */
static bool wins_by_itself(const struct rf_hidden_search *search,
                           const struct rf_hidden_query *query, float *r)
{
    const struct rf_backs *b = &search->backs;
    float room = b->r[(size_t)query->y * b->stride + (size_t)query->x];
    room -= query->s;
    if (!(room > 0) || !(room * room > 0))
        return false;
    int bin = (int)rf_min_float(room / RF_HIDDEN_BIN_PX, RF_HIDDEN_BINS - 1);
    *r = query->s + ((float)bin + 0.5f) * RF_HIDDEN_BIN_PX;
    return true;
}

/* What is known of the surface behind a query before its colour is. */
struct guess {
    float r;
    int d2;      /* to the hole's rim, px^2 */
    bool is_own; /* it is the far part of the query's pixel */
};

/* May a pixel of radius s have two surfaces behind it that an edge parts? */
static bool may_be_two(const struct scratch *scratch, float s)
{
    return scratch->is_thin && scratch->step > s + 1;
}

static bool guess_radius(const struct rf_hidden_search *search,
                         const struct rf_hidden_query *query, struct scratch *scratch,
                         struct guess *guess)
{
    *guess = (struct guess){.d2 = 0};
    guess->is_own = wins_by_itself(search, query, &guess->r);
    if (guess->is_own)
        return true;
    if (!search->kernels->vote_blocks(&search->backs, &scratch->group, query,
                                      &scratch->vote, &guess->r, &guess->d2))
        return false;
    if (may_be_two(scratch, query->s))
        scratch->is_thin = rf_hidden_line_up(&search->lines, &search->backs, query,
                                             scratch->farthest, &guess->r, &guess->d2);
    return true;
}

/* The surface of a guess. */
static bool fill_in(const struct rf_hidden_search *search,
                    const struct rf_hidden_query *query, struct scratch *scratch,
                    const struct guess *guess, struct rf_surface *hidden)
{
    float r = guess->r;
    if (guess->is_own) {
        const struct rf_surfaces *s = search->s;
        *hidden = *rf_far_at(s, (size_t)query->y * (size_t)s->width + (size_t)query->x);
        if (rf_luminance(hidden->c[0], hidden->c[1], hidden->c[2]) <= WHITE)
            return true;
    }
    float reach = rf_min_float(sqrtf((float)guess->d2) * 2.5f + 3, MAX_WINDOW);
    search->kernels->gather_window(&search->backs, query, r, reach, search->s->near,
                                   &scratch->window);
    return average(search, scratch, hidden);
}

/* Estimates what lies behind a query; `d2` receives how far the hole's rim is. */
static bool estimate(const struct rf_hidden_search *search,
                     const struct rf_hidden_query *query, struct scratch *scratch,
                     struct rf_surface *hidden, int *d2)
{
    struct guess guess;
    bool is_found = guess_radius(search, query, scratch, &guess);
    *d2 = guess.d2;
    return is_found && fill_in(search, query, scratch, &guess, hidden);
}

/* ---- all pixels ---------------------------------------------------------------- */

/*
 * Radius of the near surface of pixel i, which is (x, y); INFINITY: there is none. Pure
 * pixels have it in the plane, which is read sooner than the surfaces.
 */
static float near_radius(const struct rf_hidden_search *search, int x, int y, size_t i)
{
    const struct rf_surfaces *s = search->s;
    if (!rf_is_mixed(s, i))
        return rf_hidden_row(search, y)[x];
    return s->share[i] > 0 ? s->near[i].r : INFINITY;
}

/* May pixel (x, y) take the answer of pixel i? */
static bool is_same_surface(const struct rf_hidden_search *search, size_t i, int x,
                            int y)
{
    const struct rf_surfaces *s = search->s;
    size_t j = (size_t)y * (size_t)s->width + (size_t)x;
    bool is_pure = !rf_is_mixed(s, j) || s->share[j] == 1;
    return is_pure && s->share[i] == 1 &&
           fabsf(s->near[i].r - rf_hidden_row(search, y)[x]) < 0.25f;
}

static struct rf_hidden_query query_at(const struct rf_hidden_search *search, int x,
                                       int y, float s)
{
    return (struct rf_hidden_query){
        .x = x, .y = y, .s = s, .inv_x2 = search->inv_x2, .inv_y2 = search->inv_y2};
}

/* Notes that pixel (x, y) has an answer, and those beside it within its block. */
static void set_found(const struct rf_hidden_search *search, int x, int y,
                      unsigned bits)
{
    size_t row = rf_found_stride(search->s->width) * (size_t)y;
    search->out->found[row + (size_t)x / 8] |= (uint8_t)(bits << x % 8);
}

/* May anything lie behind one of 2 x 2 pixels? Not told of mixed ones. */
static bool quad_may_hide(const struct rf_hidden_search *search,
                          struct scratch *scratch, int x, int y)
{
    const struct rf_surfaces *s = search->s;
    size_t i = (size_t)y * (size_t)s->width + (size_t)x, below = i + (size_t)s->width;
    if (x + 1 >= s->width || y + 1 >= s->height || rf_is_mixed(s, i) ||
        rf_is_mixed(s, i + 1) || rf_is_mixed(s, below) || rf_is_mixed(s, below + 1))
        return true;
    const float *r = rf_hidden_row(search, y) + x,
                *r_below = rf_hidden_row(search, y + 1) + x;
    float least =
        rf_min_float(rf_min_float(r[0], r[1]), rf_min_float(r_below[0], r_below[1]));
    struct rf_hidden_query query = query_at(search, x, y, least);
    return search->kernels->quad_has_candidate(&search->backs, &scratch->group, &query);
}

/* Answers 2 x 2 pixels; returns how far the rim of the hole is from the first, px^2. */
static int search_quad(const struct rf_hidden_search *search, struct scratch *scratch,
                       int x0, int y0)
{
    const struct rf_surfaces *s = search->s;
    struct rf_surface *hidden = search->out->at;
    size_t found = 0; /* the last pixel that has an answer to share */
    bool has_found = false;
    int d2 = 0, first_d2 = 0;
    if (!quad_may_hide(search, scratch, x0, y0))
        return 0;
    for (int k = 0; k < 4; k++) {
        int x = x0 + (k & 1), y = y0 + (k >> 1);
        if (x >= s->width || y >= s->height)
            continue;
        size_t i = (size_t)y * (size_t)s->width + (size_t)x;
        if (has_found && is_same_surface(search, found, x, y)) {
            set_found(search, x, y, 1);
            hidden[i] = hidden[found];
            continue;
        }
        float r = near_radius(search, x, y, i);
        if (r == INFINITY)
            continue;
        struct rf_hidden_query query = query_at(search, x, y, r);
        bool is_found = estimate(search, &query, scratch, &hidden[i], &d2);
        if (k == 0 && is_found)
            first_d2 = rf_max_int(d2, 1);
        if (is_found) { /* nothing is not shared: a pixel on there may be */
            set_found(search, x, y, 1);
            found = i;
            has_found = true;
        }
    }
    return first_d2;
}

/* Gives 2 x 2 pixels the answer of `first` if all are of its surface. */
static bool share_quad(const struct rf_hidden_search *search, size_t first, int x0,
                       int y0)
{
    const struct rf_surfaces *s = search->s;
    if (x0 + 1 >= s->width || y0 + 1 >= s->height)
        return false;
    for (int k = 0; k < 4; k++)
        if (!is_same_surface(search, first, x0 + (k & 1), y0 + (k >> 1)))
            return false;
    const struct rf_surface found = search->out->at[first];
    for (int y = y0; y < y0 + 2; y++) {
        struct rf_surface *row = search->out->at + (size_t)y * (size_t)s->width;
        row[x0] = found;
        row[x0 + 1] = found;
        set_found(search, x0, y, 3);
    }
    return true;
}

/* May anything lie behind one of 4 x 4 pixels? Begins their group. */
static bool may_hide(const struct rf_hidden_search *search, struct scratch *scratch,
                     int x0, int y0)
{
    const struct rf_surfaces *s = search->s;
    float least = INFINITY;
    bool is_mixed = false;
    for (int y = y0; y < rf_min_int(y0 + GROUP, s->height); y++)
        for (int x = x0; x < rf_min_int(x0 + GROUP, s->width); x++) {
            size_t i = (size_t)y * (size_t)s->width + (size_t)x;
            is_mixed |= rf_is_mixed(s, i) && s->share[i] > 0 && s->share[i] < 1;
            least = rf_min_float(near_radius(search, x, y, i), least);
        }
    scratch->is_thin = true;
    scratch->group = (struct rf_hidden_group){.query = query_at(search, x0, y0, least),
                                              .n_blocks = scratch->n_blocks,
                                              .blocks = scratch->blocks,
                                              .hits = scratch->hits};
    /* The far part of a mixed pixel may be a candidate for the near one. */
    return is_mixed || search->kernels->has_candidate(&search->backs, &scratch->group);
}

enum answer { NONE, OWN, SHOWN };

/* The nearest of 4 x 4 pixels. */
static size_t nearest_of(const struct rf_surfaces *s, int x0, int y0)
{
    size_t first = (size_t)y0 * (size_t)s->width + (size_t)x0, best = first;
    float least = INFINITY;
    for (int y = 0; y < rf_min_int(GROUP, s->height - y0); y++)
        for (int x = 0; x < rf_min_int(GROUP, s->width - x0); x++) {
            size_t i = first + (size_t)y * (size_t)s->width + (size_t)x;
            if (s->share[i] > 0 && s->near[i].r < least) {
                least = s->near[i].r;
                best = i;
            }
        }
    return best;
}

/* Estimates what lies behind pixel i where somebody may show it. */
static enum answer ask(const struct rf_hidden_search *search, struct scratch *scratch,
                       size_t i)
{
    const struct rf_surfaces *s = search->s;
    int x = (int)(i % (size_t)s->width), y = (int)(i / (size_t)s->width);
    if (!(s->share[i] > 0))
        return NONE;
    struct rf_hidden_query query = query_at(search, x, y, s->near[i].r);
    struct guess guess;
    if (!guess_radius(search, &query, scratch, &guess))
        return NONE;
    if (search->known->is_shown(search->known->user, x, y, guess.r))
        return SHOWN;
    return fill_in(search, &query, scratch, &guess, &search->out->at[i]) ? OWN : NONE;
}

/* Do n pixels from one on, step by step, show something behind radius r by more than a
 * pixel? */
static bool shows_behind(const struct rf_hidden_search *search, int x, int y, int dx,
                         int dy, int n, float r)
{
    const struct rf_backs *b = &search->backs;
    for (int i = 0; i < n; i++, x += dx, y += dy)
        if ((unsigned)x < (unsigned)b->width && (unsigned)y < (unsigned)b->height &&
            b->r[(size_t)y * b->stride + (size_t)x] > r + 1)
            return true;
    return false;
}

/*
 * Is the rim of a hole next to a square of pixels, which have the radius r or more? What
 * lies behind its middle may be another thing then than behind its sides: the sky, and a
 * wall that is one step behind a roof.
 */
static bool is_beside_rim(const struct rf_hidden_search *search, int x, int y, int side,
                          float r)
{
    for (int d = 1; d <= RIM_PX; d++)
        if (shows_behind(search, x, y - d, 1, 0, side, r) ||
            shows_behind(search, x, y + side - 1 + d, 1, 0, side, r) ||
            shows_behind(search, x - d, y, 0, 1, side, r) ||
            shows_behind(search, x + side - 1 + d, y, 0, 1, side, r))
            return true;
    return false;
}

/*
 * Answers 4 x 4 pixels: deep behind a surface they share one answer, and everywhere
 * where other pictures show most of what is hidden.
 */
static void search_group(const struct rf_hidden_search *search, struct scratch *scratch,
                         int x0, int y0)
{
    const struct rf_surfaces *s = search->s;
    size_t first = (size_t)y0 * (size_t)s->width + (size_t)x0;
    if (!may_hide(search, scratch, x0, y0))
        return;
    enum answer answer = NONE;
    if (search->known) {
        size_t nearest = nearest_of(s, x0, y0);
        answer = ask(search, scratch, nearest);
        first = answer == OWN ? nearest : first; /* the others have none to share */
    }
    if (answer == SHOWN)
        return;
    bool is_shared = answer == OWN;
    for (int k = 0; k < 4; k++) {
        int x = x0 + 2 * (k & 1), y = y0 + 2 * (k >> 1);
        if (x >= s->width || y >= s->height ||
            (is_shared && share_quad(search, first, x, y)))
            continue;
        int d2 = search_quad(search, scratch, x, y);
        is_shared |= k == 0 && d2 >= FAR_HOLE2 &&
                     !may_be_two(scratch, scratch->group.query.s) &&
                     !is_beside_rim(search, x0, y0, GROUP, scratch->group.query.s);
    }
}

/*
 * Answers 8 x 8 pixels at once if they are one surface and every rim is farther than
 * they are large; false: they are not, or their middle has no answer.
 */
static bool share_block(const struct rf_hidden_search *search, struct scratch *scratch,
                        int bx, int by)
{
    const struct rf_surfaces *s = search->s;
    const struct rf_hidden_facts *b = &search->blocks[by * search->n_x + bx];
    int x0 = bx * BLOCK, y0 = by * BLOCK, x = x0 + BLOCK / 2, y = y0 + BLOCK / 2, d2;
    if (scratch->blocks[0].ring < 1 || search->known || x0 + BLOCK > s->width ||
        y0 + BLOCK > s->height || !(b->highest - b->lowest < FLAT_PX) ||
        !may_hide(search, scratch, x, y))
        return false;
    struct rf_surface found;
    float r = s->near[(size_t)y * (size_t)s->width + (size_t)x].r;
    struct rf_hidden_query query = query_at(search, x, y, r);
    if (!estimate(search, &query, scratch, &found, &d2) || d2 < FAR_BLOCK2 ||
        fabsf(found.r) < BLURRED_PX || may_be_two(scratch, r) ||
        is_beside_rim(search, x0, y0, BLOCK, b->lowest))
        return false;
    for (y = y0; y < y0 + BLOCK; y++) {
        struct rf_surface *row = search->out->at + (size_t)y * (size_t)s->width;
        for (x = x0; x < x0 + BLOCK; x++)
            row[x] = found;
        set_found(search, x0, y, 0xff);
    }
    return true;
}

/*
 * Asks for the estimates of a block, which are written soon and seldom at hand. Inline,
 * for GCC takes a call that only does this for one that does nothing.
 */
static inline __attribute__((always_inline)) void
fetch_block(const struct rf_hidden_search *search, int bx, int by)
{
    size_t width = (size_t)search->s->width, x0 = (size_t)bx * BLOCK;
    size_t n_bytes = sizeof(struct rf_surface) *
                     (size_t)rf_min_int(BLOCK, search->s->width - bx * BLOCK);
    int y1 = rf_min_int((by + 1) * BLOCK, search->s->height);
    for (int y = by * BLOCK; y < y1; y++) {
        const char *row = (const char *)(search->out->at + width * (size_t)y + x0);
        for (size_t i = 0; i < n_bytes; i += 64)
            __builtin_prefetch(row + i, 1);
        __builtin_prefetch(row + n_bytes - 1, 1);
    }
}

static void search_block(const struct rf_hidden_search *search, struct scratch *scratch,
                         int bx, int by)
{
    const struct rf_surfaces *s = search->s;
    int x1 = rf_min_int((bx + 1) * BLOCK, s->width);
    int y1 = rf_min_int((by + 1) * BLOCK, s->height);
    list_blocks(search, bx, by, scratch);
    if (scratch->n_blocks == 0)
        return;
    fetch_block(search, bx, by);
    if (share_block(search, scratch, bx, by))
        return;
    for (int y = by * BLOCK; y < y1; y += GROUP)
        for (int x = bx * BLOCK; x < x1; x += GROUP)
            search_group(search, scratch, x, y);
}

/* What the threads share that search for hidden surfaces. */
struct searching {
    const struct rf_hidden_search *search;
    struct scratch *scratch; /* one per thread */
    struct rf_task *task;
};

static void search_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct searching *s = data;
    const struct rf_hidden_search *search = s->search;
    size_t stride = rf_found_stride(search->s->width);
    for (int by = (int)begin; by < (int)end && !rf_task_is_cancelled(s->task); by++) {
        int n_rows = rf_min_int(search->s->height - by * BLOCK, BLOCK);
        memset(search->out->found + stride * (size_t)(by * BLOCK), 0,
               stride * (size_t)n_rows);
        for (int bx = 0; bx < search->n_x; bx++)
            search_block(search, &s->scratch[thread], bx, by);
        rf_task_step(s->task);
    }
}

/* Answers of pixels beside little steps. */
static void step_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct rf_hidden_search *search = data;
    const int width = search->s->width;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < width; x += 64) {
            uint64_t bits = rf_found_at(search->out, x, y, rf_min_int(width - x, 64));
            struct rf_surface *at = search->out->at + (size_t)y * (size_t)width + x;
            for (; bits; bits &= bits - 1) {
                int i = __builtin_ctzll(bits);
                rf_hidden_behind_step(search, x + i, y, &at[i]);
            }
        }
}

/* The plane of radii, at hand or not, and room for the rest. */
static rf_result begin(struct rf_hidden_search *search,
                       const struct rf_context *context, const struct rf_radii *radii,
                       float **own, struct rf_error *error)
{
    const struct rf_surfaces *s = search->s;
    size_t n = (size_t)s->width * (size_t)s->height;
    size_t n_blocks = (size_t)search->n_x * (size_t)search->n_y;
    size_t stride = radii ? radii->stride : (size_t)s->width + BLOCK;
    search->n_words = search->n_x / 32 + 2;
    *own = radii ? NULL : rf_alloc(context, stride * (size_t)s->height, sizeof **own);
    search->backs = (struct rf_backs){.width = s->width,
                                      .height = s->height,
                                      .stride = stride,
                                      .x = s->x,
                                      .y = s->y,
                                      .r = radii ? radii->at : *own};
    search->blocks = rf_alloc(context, n_blocks, sizeof *search->blocks);
    search->edges = rf_alloc(context, n_blocks, sizeof *search->edges);
    search->rough = rf_calloc(context, (size_t)search->n_words * (size_t)search->n_y,
                              sizeof *search->rough);
    size_t n_highest = 2 * (size_t)rf_hidden_n_areas(search->n_x) *
                       (size_t)rf_hidden_n_areas(search->n_y);
    search->highest = rf_alloc(context, n_highest, sizeof *search->highest);
    search->out->width = s->width;
    search->out->at = rf_alloc(context, n, sizeof *search->out->at);
    search->out->found =
        rf_alloc(context, rf_found_stride(s->width), (size_t)s->height);
    bool is_complete = search->backs.r && search->blocks && search->edges &&
                       search->rough && search->highest && search->out->at &&
                       search->out->found;
    return is_complete ? RF_OK : rf_fail_memory(error, n, sizeof *search->out->at);
}

rf_result rf_find_hidden(const struct rf_frame *frame,
                         const struct rf_surfaces *surfaces,
                         const struct rf_radii *radii, const struct rf_known *known,
                         struct rf_estimates *estimates, struct rf_task *task,
                         struct rf_error *error)
{
    static const double middle[2] = {0, 0};
    const struct rf_context *context = frame->context;
    struct rf_hidden_search search = {.s = surfaces,
                                      .known = known,
                                      .kernels = context->kernels,
                                      .out = estimates,
                                      .context = context,
                                      .n_x = (surfaces->width + BLOCK - 1) / BLOCK,
                                      .n_y = (surfaces->height + BLOCK - 1) / BLOCK};
    float *own;
    rf_result result = begin(&search, context, radii, &own, error);
    struct scratch *scratch =
        rf_calloc(context, (size_t)context->n_threads, sizeof *scratch);
    if (result == RF_OK && !scratch)
        result = rf_fail_memory(error, 1, sizeof *scratch);
    if (result == RF_OK) {
        rf_shape_extent(&frame->shape, search.extent);
        search.inv_x2 = (float)(1 / (search.extent[0] * search.extent[0]));
        search.inv_y2 = (float)(1 / (search.extent[1] * search.extent[1]));
        set_gaps(&search);
        rf_hidden_lines_set(&search.lines, search.inv_x2, search.inv_y2);
        rf_hidden_measure(&search, radii != NULL);
        struct searching s = {&search, scratch, task};
        rf_parallel(context, search.n_y, 1, search_rows, &s);
        for (int y = 0; y < surfaces->height && radii; y++)
            rf_hidden_restore_row(&search, y);
        if (!rf_task_is_cancelled(task))
            rf_parallel(context, surfaces->height, RF_EQUAL_PARTS, step_rows, &search);
    }
    rf_free(context, scratch);
    rf_free(context, search.highest);
    rf_free(context, search.rough);
    estimates->insides = (struct rf_insides){
        .blocks = search.blocks,
        .edges = search.edges,
        .n_x = search.n_x,
        .n_y = search.n_y,
        .extent = (float)fmax(search.extent[0], search.extent[1]),
        .reach = rf_shape_reach(&frame->shape, middle),
        .radius = radii && frame->shape.glow_px == 0 ? radii->at : NULL,
        .stride = search.backs.stride,
        .width = surfaces->width,
        .height = surfaces->height};
    rf_free(context, own);
    return result;
}

void rf_estimates_free(struct rf_estimates *e, const struct rf_context *context)
{
    rf_free(context, e->found);
    rf_free(context, e->at);
    rf_free(context, e->insides.blocks);
    rf_free(context, e->insides.edges);
    e->insides = (struct rf_insides){0};
    e->found = NULL;
    e->at = NULL;
}

int rf_hidden_steps(int height)
{
    return (height + BLOCK - 1) / BLOCK;
}
