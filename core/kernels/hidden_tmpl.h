/* SPDX-License-Identifier: Apache-2.0 */
/* Inner loops of hidden.c, which says what they compute; part of kernels_tmpl.c. */
#include "hidden_kernels.h"
#include "vector.h"

/* Votes from farther than sqrt(5) times the nearest candidate count for nothing. */
enum { FAR2 = 5 };

/* Distances from which a block is read at every 2nd and every 4th pixel. */
enum { STRIDE_2_PX = 3, STRIDE_4_PX = 7 };

static void log_row(float *v, int n)
{
    for (int x = 0; x < n; x += LANES)
        STORE(v + x, vlog(vmax(LOAD(v + x), SPLAT(0)) + SPLAT(1e-3f)));
}

static inline vi differs(vf a, vf b, float most)
{
    return ~(((a - b) <= SPLAT(most)) & ((b - a) <= SPLAT(most)));
}

/* The greatest and least of eight lanes. */
static inline float greatest_of(vf v)
{
    v = vmax(v, SHUFFLE(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = vmax(v, SHUFFLE(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
    return rf_max_float(v[0], v[1]);
}

static inline float least_of(vf v)
{
    v = vmin(v, SHUFFLE(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = vmin(v, SHUFFLE(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
    return rf_min_float(v[0], v[1]);
}

/*
 * Does the radius differ by no more than `most` between any two pixels of a block and
 * around it, all of which there are? Tells the greatest and the least of the block.
 */
static inline bool is_calm(const struct rf_backs *backs, int x0, int y0, float most,
                           float *highest, float *lowest)
{
    const float *row = backs->r + (size_t)y0 * backs->stride + x0;
    vf above = LOAD(row - backs->stride);
    vf high = SPLAT(-INFINITY), low = SPLAT(INFINITY), high_beside = high;
    vf low_beside = low;
    for (int y = 0; y < RF_HIDDEN_BLOCK; y++, row += backs->stride) {
        vf r = LOAD(row), left = LOAD(row - 1), right = LOAD(row + 1);
        high = vmax(r, high);
        low = vmin(r, low);
        high_beside = vmax(left, vmax(right, high_beside));
        low_beside = vmin(left, vmin(right, low_beside));
    }
    vf below = LOAD(row);
    *highest = greatest_of(high);
    *lowest = least_of(low);
    high = vmax(vmax(above, below), vmax(high, high_beside));
    low = vmin(vmin(above, below), vmin(low, low_beside));
    return greatest_of(high) - least_of(low) <= most;
}

static bool measure_block(const struct rf_backs *backs, int block_x, int block_y,
                          float most_x, float most_y, float *highest, float *lowest)
{
    int x0 = block_x * RF_HIDDEN_BLOCK, y0 = block_y * RF_HIDDEN_BLOCK;
    int y1 = rf_min_int(y0 + RF_HIDDEN_BLOCK, backs->height);
    bool is_inner = x0 > 0 && y0 > 0 && x0 + RF_HIDDEN_BLOCK < backs->width &&
                    y0 + RF_HIDDEN_BLOCK < backs->height;
    if (is_inner &&
        is_calm(backs, x0, y0, rf_min_float(most_x, most_y), highest, lowest))
        return false;
    vi is_inside = lane_numbers() + x0 < backs->width, is_rough = {0};
    vi has_right = lane_numbers() + x0 < backs->width - 1;
    vi is_first = lane_numbers() == 0;
    vf high = SPLAT(-INFINITY), low = SPLAT(INFINITY);
    const float *row = backs->r + (size_t)y0 * backs->stride + x0;
    vf above = y0 > 0 ? LOAD(row - backs->stride) : LOAD(row);
    for (int y = y0; y < y1; y++, row += backs->stride) {
        vf r = LOAD(row), left = x0 > 0 ? LOAD(row - 1) : r;
        high = vmax(r, high);
        low = vmin(choose(r > SPLAT(-INFINITY), r, low), low);
        is_rough |= has_right & differs(LOAD(row + 1), r, most_x);
        is_rough |= is_first & differs(left, r, most_x);
        is_rough |= is_inside & differs(above, r, most_y);
        above = r;
    }
    if (y1 < backs->height)
        is_rough |= is_inside & differs(LOAD(row), above, most_y);
    *highest = greatest_of(high);
    *lowest = least_of(low);
    return lane_bits(is_rough) != 0;
}

/* Distance from the n pixels x, x + 1, .. to those of block b, in px. */
static inline int gap_to_block(int x, int n, int b)
{
    int x0 = b * RF_HIDDEN_BLOCK, x1 = x0 + RF_HIDDEN_BLOCK - 1;
    return x + n - 1 < x0 ? x0 - (x + n - 1) : x > x1 ? x - x1 : 0;
}

/* How many pixels apart those are that are read of a block at a distance. */
static inline int stride_at(int gap)
{
    return gap < STRIDE_2_PX ? 1 : gap < STRIDE_4_PX ? 2 : 4;
}

/* A bit for each row that is read of a block then. */
static inline unsigned rows_at(int stride)
{
    return stride == 1 ? 0xff : stride == 2 ? 0x55 : 0x11;
}

/* The votes of those pixels of a row whose bits are set; d2 in px^2. */
static inline void cast_votes(struct rf_hidden_vote *vote, unsigned bits, vi d2,
                              vf room, float weight)
{
    vf k = SPLAT(1) / (to_float(d2) + SPLAT(0.5f));
    vf w = SPLAT(weight) * k * k * k;
    vi bin = to_int(vmin(room * SPLAT(2), SPLAT(RF_HIDDEN_BINS - 1))) + 2;
    float weights[LANES];
    int32_t bins[LANES], distances[LANES];
    STORE(weights, w);
    memcpy(bins, &bin, sizeof bins);
    memcpy(distances, &d2, sizeof distances);
    for (; bits; bits &= bits - 1) {
        int l = __builtin_ctz(bits), b = bins[l], d = distances[l];
        vote->nearest = d < vote->nearest ? d : vote->nearest;
        if (vote->histogram[b] == 0 || d < vote->nearest2[b])
            vote->nearest2[b] = d;
        vote->histogram[b] += weights[l];
        vote->first = b < vote->first ? b : vote->first;
        vote->last = b > vote->last ? b : vote->last;
    }
}

/* Squared distance from which votes count for nothing. */
static inline int farthest2(const struct rf_hidden_vote *vote)
{
    return vote->nearest < INT32_MAX / FAR2 ? FAR2 * vote->nearest : INT32_MAX;
}

static inline void vote_block(const struct rf_backs *backs,
                              const struct rf_hidden_query *q,
                              const struct rf_hidden_block *block, unsigned rows,
                              struct rf_hidden_vote *vote)
{
    int gx = gap_to_block(q->x, 1, block->x), gy = gap_to_block(q->y, 1, block->y);
    float limit = block->highest - q->s;
    float gap2 = (float)(gx * gx) * q->inv_x2 + (float)(gy * gy) * q->inv_y2;
    if (limit <= 0 || gap2 >= limit * limit || gx * gx + gy * gy > farthest2(vote))
        return;
    int stride = stride_at(gx > gy ? gx : gy);
    vi is_read = (lane_numbers() & (stride - 1)) == 0;
    int x0 = block->x * RF_HIDDEN_BLOCK, y0 = block->y * RF_HIDDEN_BLOCK;
    vi dx = lane_numbers() + (x0 - q->x);
    vf dx2 = to_float(dx * dx) * SPLAT(q->inv_x2);
    const float *row = backs->r + (size_t)y0 * backs->stride + x0;
    rows &= rows_at(stride);
    for (; rows; rows &= rows - 1) {
        int y = __builtin_ctz(rows);
        vf room = LOAD(row + (size_t)y * backs->stride) - SPLAT(q->s);
        int dy = y0 + y - q->y;
        vf d2 = dx2 + SPLAT((float)(dy * dy) * q->inv_y2);
        int most = farthest2(vote);
        if (dy * dy > most)
            continue;
        vi is_near = dx * dx <= most - dy * dy;
        unsigned bits =
            lane_bits(is_read & is_near & (room > SPLAT(0)) & (d2 < room * room));
        if (bits)
            cast_votes(vote, bits, dx * dx + dy * dy, room, (float)(stride * stride));
    }
}

/* Distance from x to n pixels that begin at `first`. */
static inline int gap_to_pixels(int x, int first, int n)
{
    return x < first ? first - x : rf_max_int(x - (first + n - 1), 0);
}

/*
 * What vote_block() reads of some rows, seen from the nearest of n x n pixels, but not
 * from itself: every rounding is monotone, so no pixel has a candidate that is not one
 * here. With is_any one row is enough.
 */
static inline __attribute__((always_inline)) unsigned
candidate_rows(const struct rf_backs *backs, const struct rf_hidden_query *q, int n,
               const struct rf_hidden_block *block, unsigned rows, bool is_any)
{
    int gx = gap_to_block(q->x, n, block->x), gy = gap_to_block(q->y, n, block->y);
    float limit = block->highest - q->s;
    float gap2 = (float)(gx * gx) * q->inv_x2 + (float)(gy * gy) * q->inv_y2;
    if (limit <= 0 || gap2 >= limit * limit)
        return 0;
    int stride = stride_at(gx > gy ? gx : gy);
    vi is_read = (lane_numbers() & (stride - 1)) == 0;
    int x0 = block->x * RF_HIDDEN_BLOCK, y0 = block->y * RF_HIDDEN_BLOCK;
    vi before = q->x - (lane_numbers() + x0), after = -before - (n - 1);
    vi dx = (before & (before > 0)) | (after & (after > 0));
    vf dx2 = to_float(dx * dx) * SPLAT(q->inv_x2);
    const float *row = backs->r + (size_t)y0 * backs->stride + x0;
    vf least2 = SPLAT(rf_min_float(q->inv_x2, q->inv_y2));
    unsigned found = 0;
    for (rows &= rows_at(stride); rows && !(is_any && found); rows &= rows - 1) {
        int y = __builtin_ctz(rows), dy = gap_to_pixels(y0 + y, q->y, n);
        vf room = LOAD(row + (size_t)y * backs->stride) - SPLAT(q->s);
        vf d2 = vmax(dx2 + SPLAT((float)(dy * dy) * q->inv_y2), least2);
        vi is_found = is_read & (room > SPLAT(0)) & (d2 < room * room);
        found |= (unsigned)(lane_bits(is_found) != 0) << y;
    }
    return found;
}

/* The rows of a block that lie in the picture. */
static inline unsigned rows_inside(const struct rf_backs *backs,
                                   const struct rf_hidden_block *block)
{
    int n = backs->height - block->y * RF_HIDDEN_BLOCK;
    return (1u << rf_min_int(n, RF_HIDDEN_BLOCK)) - 1;
}

/* Is a block so far beyond the nearest candidate that the search ends? */
static inline bool is_beyond(const struct rf_hidden_block *block, int nearest)
{
    int gap = (block->ring - 1) * RF_HIDDEN_BLOCK + 1;
    return block->ring > 1 && nearest < INT32_MAX && 4 * gap * gap > 9 * nearest;
}

/*
 * Looks for the group's next hit for a pixel of radius s, in blocks that are not
 * beyond; false: there is none.
 */
static inline bool find_hit(const struct rf_backs *backs, struct rf_hidden_group *g,
                            float s, int nearest)
{
    while (g->n_seen < g->n_blocks && s < g->blocks[g->n_seen].most &&
           !is_beyond(&g->blocks[g->n_seen], nearest)) {
        int i = g->n_seen++;
        const struct rf_hidden_block *block = &g->blocks[i];
        unsigned rows = candidate_rows(backs, &g->query, RF_HIDDEN_GROUP, block,
                                       rows_inside(backs, block), false);
        if (rows) {
            g->hits[g->n_hits++] = (struct rf_hidden_hit){(int16_t)i, (int16_t)rows};
            return true;
        }
    }
    return false;
}

static bool has_candidate(const struct rf_backs *backs, struct rf_hidden_group *group)
{
    return group->n_hits || find_hit(backs, group, group->query.s, INT32_MAX);
}

static bool quad_has_candidate(const struct rf_backs *backs,
                               struct rf_hidden_group *group,
                               const struct rf_hidden_query *q)
{
    for (int i = 0; i < group->n_hits || find_hit(backs, group, q->s, INT32_MAX); i++) {
        const struct rf_hidden_hit *hit = &group->hits[i];
        const struct rf_hidden_block *block = &group->blocks[hit->block];
        if (q->s >= block->most)
            return false;
        if (candidate_rows(backs, q, 2, block, (unsigned)hit->rows, true))
            return true;
    }
    return false;
}

static void vote_blocks(const struct rf_backs *backs, struct rf_hidden_group *group,
                        const struct rf_hidden_query *q, struct rf_hidden_vote *vote)
{
    vote->first = RF_HIDDEN_BINS + 4;
    vote->last = -1;
    vote->nearest = INT32_MAX;
    for (int i = 0;
         i < group->n_hits || find_hit(backs, group, q->s, vote->nearest); i++) {
        const struct rf_hidden_hit *hit = &group->hits[i];
        const struct rf_hidden_block *block = &group->blocks[hit->block];
        if (is_beyond(block, vote->nearest) || q->s >= block->most)
            return;
        vote_block(backs, q, block, (unsigned)hit->rows, vote);
    }
}

/* Every stride-th float from p on, n <= LANES of them if they are not in turn. */
static inline vf load_strided(const float *p, int stride, int n)
{
    vf v = SPLAT(-INFINITY);
    if (stride == 1)
        return LOAD(p);
    if (stride == 2)
        return SHUFFLE(LOAD(p), 2 * n > LANES ? LOAD(p + LANES) : v, 0, 2, 4, 6, 8, 10,
                       12, 14);
    if (n < LANES)
        for (int l = 0; l < n; l++)
            v[l] = p[l * stride];
    else
        for (int l = 0; l < LANES; l++)
            v[l] = p[l * stride];
    return v;
}

/* From this reach on every second row of a window is read, if not fewer. */
enum { WIDE_WINDOW = 5 };

/* The pixels of a window, one after the other, before they have weights. */
struct found {
    int32_t r[RF_HIDDEN_ROOM]; /* the bits of a float */
    int32_t d2[RF_HIDDEN_ROOM];
};

/* Gathers the pixels of row y, from x0 on, that show a surface of radius about r. */
static inline void gather_row(const struct rf_backs *backs,
                              const struct rf_hidden_query *q, float r, int most_d2,
                              int x0, int x1, int y, int stride, struct found *found,
                              struct rf_hidden_window *out)
{
    const float *row = backs->r + (size_t)y * backs->stride;
    int dy = y - q->y, most_dx2 = most_d2 - dy * dy;
    vi step = lane_numbers() * stride;
    for (int x = x0; x <= x1; x += LANES * stride) {
        vi dx = step + (x - q->x), dx2 = dx * dx;
        vf qr = load_strided(row + x, stride, (x1 - x) / stride + 1);
        vf t = qr - SPLAT(r);
        unsigned bits =
            lane_bits((dx2 <= most_dx2) & (qr > SPLAT(q->s)) & (t * t <= SPLAT(9)));
        if (!bits)
            continue;
        store_lanes(out->index + out->n, step + (y * backs->width + x), bits);
        store_lanes(found->r + out->n, (vi)qr, bits);
        store_lanes(found->d2 + out->n, dx2 + dy * dy, bits);
        out->n += __builtin_popcount(bits);
    }
}

/* Weights of what was found: see hidden.c. */
static inline void weigh_window(const struct found *found, float r, float reach,
                                struct rf_hidden_window *out)
{
    vf r_sum = {0}, weight_sum = {0}, share = SPLAT(1 / (reach * reach));
    for (int i = 0; i < out->n; i += LANES) {
        vi is_found = lane_numbers() + i < out->n, d2_bits, r_bits;
        memcpy(&d2_bits, found->d2 + i, sizeof d2_bits);
        memcpy(&r_bits, found->r + i, sizeof r_bits);
        vf d2 = to_float(d2_bits), qr = (vf)(r_bits & is_found), t = qr - SPLAT(r);
        vf fade = SPLAT(1) - d2 * share;
        d2 += SPLAT(0.5f);
        vf w = fade * vexp(SPLAT(-0.5f) * t * t) / (d2 * vsqrt(d2));
        w = choose(is_found, w, SPLAT(0));
        weight_sum += w;
        r_sum += w * qr;
        STORE(out->weight + i, w);
    }
    out->r_sum = lane_sum(r_sum);
    out->weight_sum = lane_sum(weight_sum);
}

static void gather_window(const struct rf_backs *backs, const struct rf_hidden_query *q,
                          float r, float reach, struct rf_hidden_window *out)
{
    struct found found;
    int n = (int)reach, stride = (n + RF_HIDDEN_STEPS - 1) / RF_HIDDEN_STEPS;
    int y0 = rf_max_int(q->y - n, 0), y1 = rf_min_int(q->y + n, backs->height - 1);
    int x0 = rf_max_int(q->x - n, 0), x1 = rf_min_int(q->x + n, backs->width - 1);
    y0 = (backs->y + y0 + stride - 1) / stride * stride - backs->y;
    x0 = (backs->x + x0 + stride - 1) / stride * stride - backs->x;
    out->n = 0;
    int step = stride;
    if (stride == 1 && n >= WIDE_WINDOW) {
        step = 2;
        y0 += (q->y - y0) & 1; /* so that mirrored pictures have mirrored windows */
    }
    /* A distance in whole pixels that is no more than reach^2. */
    int most_d2 = (int)(reach * reach);
    for (int y = y0; y <= y1; y += step)
        gather_row(backs, q, r, most_d2, x0, x1, y, stride, &found, out);
    weigh_window(&found, r, reach, out);
}

static void average_window(struct rf_hidden_window *w, float brightest, float c[4])
{
    enum { MOST = RF_HIDDEN_ROOM / LANES };
    vf colour[MOST][4], luminance[MOST], log_sum = {0}, sum[4] = {{0}};
    for (int i = w->n; i % LANES; i++)
        w->shown[i] = w->shown[0];
    for (int i = 0; i < w->n; i += LANES) {
        vf *v = colour[i / LANES];
        const struct rf_surface *const *at = w->shown + i;
        for (int k = 0; k < 4; k++)
            v[k] = load_halves(at[k]->c, at[k + 4]->c);
        turn_halves(v);
        vf l = luminance_of(v);
        log_sum += LOAD(w->weight + i) * vlog(vmax(l, SPLAT(0)) + SPLAT(1e-3f));
        luminance[i / LANES] = l;
    }
    vf limit = SPLAT(brightest * rf_expf(lane_sum(log_sum) / w->weight_sum));
    for (int i = 0; i < w->n; i += LANES) {
        const vf *v = colour[i / LANES], l = luminance[i / LANES];
        vf k = LOAD(w->weight + i), dim = choose(l > limit, k * (limit / l), k);
        for (int p = 0; p < 3; p++)
            sum[p] += dim * v[p];
        sum[3] += k * v[3];
    }
    for (int p = 0; p < 4; p++)
        c[p] = lane_sum(sum[p]) * (1 / w->weight_sum);
}
