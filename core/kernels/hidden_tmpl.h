/* SPDX-License-Identifier: Apache-2.0 */
/* Inner loops of hidden.c, which says what they compute; part of kernels_tmpl.c. */
#include "base/math.h"
#include "kernels/hidden_kernels.h"
#include "kernels/vector.h"

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

/* The nearer of two radii where they are a step apart, else -INFINITY. */
static inline vf near_side(vf a, vf b, vi is_pair)
{
    return choose(is_pair & differs(a, b, 2), vmin(a, b), SPLAT(-INFINITY));
}

static float nearest_step(const struct rf_backs *backs, int block_x, int block_y)
{
    enum { APART = 2 }; /* px; a mixed pixel may lie between */
    int x0 = block_x * RF_HIDDEN_BLOCK, y0 = block_y * RF_HIDDEN_BLOCK;
    int y1 = rf_min_int(y0 + RF_HIDDEN_BLOCK, backs->height);
    const vi x = lane_numbers() + x0;
    const vi is_inside = x < backs->width, has_right = x < backs->width - APART;
    const size_t down = APART * backs->stride;
    vf best = SPLAT(-INFINITY);
    const float *row = backs->r + (size_t)y0 * backs->stride + x0;
    for (int y = y0; y < y1; y++, row += backs->stride) {
        vf r = LOAD(row);
        if (x0 > 0)
            best = vmax(near_side(r, LOAD(row - APART), is_inside), best);
        if (x0 + APART < backs->width)
            best = vmax(near_side(r, LOAD(row + APART), has_right), best);
        if (y >= APART)
            best = vmax(near_side(r, LOAD(row - down), is_inside), best);
        if (y + APART < backs->height)
            best = vmax(near_side(r, LOAD(row + down), is_inside), best);
    }
    return greatest_of(best);
}

/* Distance from the n pixels x, x + 1, .. to those of block b, in px. */
static inline int gap_to_block(int x, int n, int b)
{
    int after = b * RF_HIDDEN_BLOCK - (x + n - 1);
    int before = x - (b * RF_HIDDEN_BLOCK + RF_HIDDEN_BLOCK - 1);
    return rf_max_int(rf_max_int(after, before), 0);
}

/* How many pixels apart those are that are read of a block at a distance. */
static inline int stride_at(int gap)
{
    return 1 << ((gap >= STRIDE_2_PX) + (gap >= STRIDE_4_PX));
}

/* A bit for each row that is read of a block then. */
static inline unsigned rows_at(int stride)
{
    return 0x01155ffu >> 8 * (stride / 2) & 0xff;
}

/*
 * The squared distances of the pixels of a block from a place, along each axis: in px,
 * INFINITY for columns that are not read, and in units of the lens.
 */
struct distances {
    vf x2, lens_x2;
    float y2[LANES], lens_y2[LANES];
};

static inline void set_distances(struct distances *d, vf dx, vf dy, int stride,
                                 const struct rf_hidden_query *q)
{
    vi is_read = (lane_numbers() & (stride - 1)) == 0;
    d->x2 = choose(is_read, dx * dx, SPLAT(INFINITY));
    d->lens_x2 = d->x2 * SPLAT(q->inv_x2);
    STORE(d->y2, dy * dy);
    STORE(d->lens_y2, dy * dy * SPLAT(q->inv_y2));
}

/* x |x|, which is above a square if x is above its root. */
static inline vf signed_square(vf x)
{
    return x * (vf)((vi)x & ~(vi)SPLAT(-0.0f));
}

static inline vf load_bits(const int32_t *p)
{
    vf v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* Squared distance from which votes count for nothing. */
static inline float farthest2(const struct rf_hidden_vote *vote)
{
    return vote->nearest < INT32_MAX ? (float)(FAR2 * vote->nearest) : 1e30f;
}

/* Lists the candidates of a block, and some that are too far to count. */
static inline void list_candidates(const struct rf_backs *backs,
                                   const struct rf_hidden_query *q,
                                   const struct rf_hidden_block *block, unsigned rows,
                                   struct rf_hidden_vote *vote)
{
    int gx = gap_to_block(q->x, 1, block->x), gy = gap_to_block(q->y, 1, block->y);
    float limit = block->highest - q->s, most = farthest2(vote);
    float gap2 = (float)(gx * gx) * q->inv_x2 + (float)(gy * gy) * q->inv_y2;
    if (limit <= 0 || gap2 >= limit * limit || (float)(gx * gx + gy * gy) > most)
        return;
    int stride = stride_at(rf_max_int(gx, gy)), n = vote->n;
    int x0 = block->x * RF_HIDDEN_BLOCK, y0 = block->y * RF_HIDDEN_BLOCK;
    struct distances to;
    set_distances(&to, to_float(lane_numbers() + (x0 - q->x)),
                  to_float(lane_numbers() + (y0 - q->y)), stride, q);
    const size_t row_size = backs->stride;
    const float *row = backs->r + (size_t)y0 * row_size + x0;
    const vf s = SPLAT(q->s), farthest = SPLAT(most), weight = SPLAT(stride * stride);
    vf nearest = SPLAT(INFINITY);
    for (rows &= rows_at(stride); rows; rows &= rows - 1) {
        int y = __builtin_ctz(rows);
        vf room = LOAD(row + (size_t)y * row_size) - s;
        vf d2 = to.x2 + SPLAT(to.y2[y]), lens2 = to.lens_x2 + SPLAT(to.lens_y2[y]);
        vi is_found = (d2 <= farthest) & (lens2 < signed_square(room));
        unsigned bits = lane_bits(is_found);
        if (!bits)
            continue;
        nearest = vmin(nearest, choose(is_found, d2, SPLAT(INFINITY)));
        store_lanes(vote->room + n, (vi)room, bits);
        store_lanes(vote->d2 + n, (vi)d2, bits);
        STORE(vote->weight + n, weight);
        n += __builtin_popcount(bits);
    }
    if (n > vote->n)
        vote->nearest = rf_min_int((int)least_of(nearest), vote->nearest);
    vote->n = n;
}

/* Bins of what lies that far behind. */
static inline vi bins_of(vf room)
{
    return to_int(vmin(room * SPLAT(1 / RF_HIDDEN_BIN_PX), SPLAT(RF_HIDDEN_BINS - 1))) +
           2;
}

static inline int bin_of(float room)
{
    return (int)rf_min_float(room * (1 / RF_HIDDEN_BIN_PX), RF_HIDDEN_BINS - 1) + 2;
}

/* The bin from `first` to `last` that has most votes with half of those beside it. */
static inline int fullest_bin(const float *h, int first, int last)
{
    float best = 0;
    int winner = first;
    for (int b = first; b <= last; b += LANES) {
        vf v =
            SPLAT(0.5f) * LOAD(h + b - 1) + LOAD(h + b) + SPLAT(0.5f) * LOAD(h + b + 1);
        float most = greatest_of(v);
        if (most > best) {
            best = most;
            winner = b + __builtin_ctz(lane_bits(v == SPLAT(most)));
        }
    }
    return winner;
}

/* The candidates vote; returns the winning bin, *d2 receives the distance to it. */
static inline int count_votes(struct rf_hidden_vote *vote, int *d2)
{
    float *h = vote->histogram;
    const vf most = SPLAT(farthest2(vote)), none = SPLAT(INFINITY);
    vf least_room = none, most_room = {0}, nearest = none;
    memcpy(vote->d2 + vote->n, &none, sizeof none);
    memcpy(vote->room + vote->n, &most_room, sizeof most_room);
    for (int i = 0; i < vote->n; i += LANES) {
        vf at = load_bits(vote->d2 + i), room = load_bits(vote->room + i);
        vf k = SPLAT(1) / (at + SPLAT(0.5f));
        vi counts = at <= most, bin = bins_of(room);
        STORE(vote->weight + i,
              choose(counts, LOAD(vote->weight + i) * k * k * k, SPLAT(0)));
        memcpy(vote->bin + i, &bin, sizeof bin);
        least_room = vmin(least_room, choose(counts, room, none));
        most_room = vmax(most_room, choose(counts, room, SPLAT(0)));
    }
    int first = bin_of(least_of(least_room)), last = bin_of(greatest_of(most_room));
    *d2 = vote->nearest;
    if (first == last)
        return first;
    for (int i = 0; i < vote->n; i++)
        h[vote->bin[i]] += vote->weight[i];
    int winner = fullest_bin(h, first, last);
    for (int b = first; b <= last; b += LANES)
        STORE(h + b, SPLAT(0));
    for (int i = 0; i < vote->n; i += LANES) {
        vi bin;
        memcpy(&bin, vote->bin + i, sizeof bin);
        vi is_winner = (bin - winner <= 2) & (winner - bin <= 2);
        vf at = load_bits(vote->d2 + i);
        nearest = vmin(nearest, choose(is_winner & (at <= most), at, none));
    }
    *d2 = (int)least_of(nearest);
    return winner;
}

/* Distances from n pixels that begin at `first` to those of a block from x0 on. */
static inline vf gaps_to_pixels(int first, int n, int x0)
{
    vi before = first - (lane_numbers() + x0), after = -before - (n - 1);
    return to_float((before & (before > 0)) | (after & (after > 0)));
}

/*
 * What list_candidates() reads of some rows, seen from the nearest of n x n pixels, but
 * not from itself: every rounding is monotone, so no pixel has a candidate that is not
 * one here. With is_any one row is enough.
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
    int stride = stride_at(rf_max_int(gx, gy));
    int x0 = block->x * RF_HIDDEN_BLOCK, y0 = block->y * RF_HIDDEN_BLOCK;
    struct distances to;
    set_distances(&to, gaps_to_pixels(q->x, n, x0), gaps_to_pixels(q->y, n, y0), stride,
                  q);
    const size_t row_size = backs->stride;
    const float *row = backs->r + (size_t)y0 * row_size + x0;
    const vf s = SPLAT(q->s);
    vf least2 = SPLAT(rf_min_float(q->inv_x2, q->inv_y2));
    unsigned found = 0;
    for (rows &= rows_at(stride); rows && !(is_any && found); rows &= rows - 1) {
        int y = __builtin_ctz(rows);
        vf room = LOAD(row + (size_t)y * row_size) - s;
        vf lens2 = vmax(to.lens_x2 + SPLAT(to.lens_y2[y]), least2);
        found |= (unsigned)(lane_bits(lens2 < signed_square(room)) != 0) << y;
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
/* Its distance is more than 3/2 of the candidate's from a square of which on. */
#define NEAREST(ring) (4 * (8 * (ring)-7) * (8 * (ring)-7) - 1) / (3 * 3)
    static const int16_t ENDS[] = {-1,         -1,         NEAREST(2),
                                   NEAREST(3), NEAREST(4), NEAREST(5),
                                   NEAREST(6), NEAREST(7), NEAREST(8)};
#undef NEAREST
    _Static_assert(RF_HIDDEN_BLOCK == 8 && RF_HIDDEN_RINGS == 8, "one of each ring");
    return nearest <= ENDS[block->ring];
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

static bool vote_blocks(const struct rf_backs *backs, struct rf_hidden_group *group,
                        const struct rf_hidden_query *q, struct rf_hidden_vote *vote,
                        float *r, int *d2)
{
    vote->n = 0;
    vote->nearest = INT32_MAX;
    for (int i = 0; i < group->n_hits || find_hit(backs, group, q->s, vote->nearest);
         i++) {
        const struct rf_hidden_hit *hit = &group->hits[i];
        const struct rf_hidden_block *block = &group->blocks[hit->block];
        if (is_beyond(block, vote->nearest) || q->s >= block->most)
            break;
        list_candidates(backs, q, block, (unsigned)hit->rows, vote);
    }
    if (vote->n == 0)
        return false;
    int winner = count_votes(vote, d2);
    *r = q->s + ((float)(winner - 2) + 0.5f) * RF_HIDDEN_BIN_PX;
    return true;
}

/* Every stride-th float from p on, up to `end`. */
static inline __attribute__((always_inline)) vf load_strided(const float *p, int stride,
                                                             const float *end)
{
    vf v = SPLAT(-INFINITY);
    if (stride == 1)
        return LOAD(p);
    if (stride == 2)
        return SHUFFLE(LOAD(p), p + LANES <= end ? LOAD(p + LANES) : v, 0, 2, 4, 6, 8,
                       10, 12, 14);
    if (p + 7 * stride <= end)
        return (vf){p[0],          p[stride],     p[2 * stride], p[3 * stride],
                    p[4 * stride], p[5 * stride], p[6 * stride], p[7 * stride]};
    for (int l = 0; p + l * stride <= end; l++)
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

/* A window: the rows first, first + step, .. that reach so far to both sides. */
struct span {
    int x0, x1, y0, step, n_rows;
    int32_t half[2 * RF_HIDDEN_STEPS + 2 * LANES];
};

/* Gathers the pixels of a window that show a surface of radius about r. */
static inline __attribute__((always_inline)) void
gather_rows(const struct rf_backs *backs, const struct rf_hidden_query *q, float r,
            const struct span *span, int stride, struct found *found,
            struct rf_hidden_window *out)
{
    const vi step = lane_numbers() * stride;
    const vf s = SPLAT(q->s), middle = SPLAT(r);
    const int qx = q->x, qy = q->y, width = backs->width;
    int n = 0;
    for (int j = 0; j < span->n_rows; j++) {
        int y = span->y0 + j * span->step, half = span->half[j];
        int x1 = rf_min_int(qx + half, span->x1);
        int x0 = stride == 1 ? rf_max_int(qx - half, span->x0) : span->x0;
        const float *row = backs->r + (size_t)y * backs->stride;
        const vi most_dx2 = half * half + (vi){0}, dy2 = (y - qy) * (y - qy) + (vi){0};
        for (int x = x0; x <= x1; x += LANES * stride) {
            vi dx = step + (x - qx), dx2 = dx * dx;
            vf qr = load_strided(row + x, stride, row + x1), t = qr - middle;
            unsigned bits =
                lane_bits((dx2 <= most_dx2) & (qr > s) & (t * t <= SPLAT(9)));
            if (!bits)
                continue;
            store_lanes(out->index + n, step + (y * width + x), bits);
            store_lanes(found->r + n, (vi)qr, bits);
            store_lanes(found->d2 + n, dx2 + dy2, bits);
            n += __builtin_popcount(bits);
        }
    }
    out->n = n;
}

/* How far rows at distances first, first + step, .. reach within a squared distance. */
static inline void set_halves(int first, int step, int n, int d2, int32_t *half)
{
    for (int i = 0; i < n; i += LANES) {
        vi dy = lane_numbers() * step + (first + i * step);
        vi v = to_int(vsqrt(vmax(to_float(d2 - dy * dy), SPLAT(0))));
        memcpy(half + i, &v, sizeof v);
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
                          float r, float reach, const struct rf_surface *near,
                          struct rf_hidden_window *out)
{
    struct found found;
    int n = (int)reach, stride = (n + RF_HIDDEN_STEPS - 1) / RF_HIDDEN_STEPS;
    int y0 = rf_max_int(q->y - n, 0), y1 = rf_min_int(q->y + n, backs->height - 1);
    int x0 = rf_max_int(q->x - n, 0), x1 = rf_min_int(q->x + n, backs->width - 1);
    y0 = (backs->y + y0 + stride - 1) / stride * stride - backs->y;
    x0 = (backs->x + x0 + stride - 1) / stride * stride - backs->x;
    int step = stride;
    if (stride == 1 && n >= WIDE_WINDOW) {
        step = 2;
        y0 += (q->y - y0) & 1; /* so that mirrored pictures have mirrored windows */
    }
    struct span span = {x0, x1, y0, step, y1 < y0 ? 0 : (y1 - y0) / step + 1, {0}};
    set_halves(y0 - q->y, step, span.n_rows, (int)(reach * reach), span.half);
    if (stride == 1)
        gather_rows(backs, q, r, &span, 1, &found, out);
    else if (stride == 2)
        gather_rows(backs, q, r, &span, 2, &found, out);
    else
        gather_rows(backs, q, r, &span, stride, &found, out);
    for (int i = 0; i < out->n; i++)
        __builtin_prefetch(near + out->index[i]);
    weigh_window(&found, r, reach, out);
}

static void average_window(const struct rf_surfaces *s, struct rf_hidden_window *w,
                           float brightest, float c[4])
{
    enum { MOST = RF_HIDDEN_ROOM / LANES };
    vf colour[MOST][4], luminance[MOST], log_sum = {0}, weight_sum = {0},
                                         sum[4] = {{0}};
    for (int i = w->n; i % LANES; i++)
        w->index[i] = w->index[0];
    for (int i = 0; i < w->n; i += LANES) {
        vf *v = colour[i / LANES];
        const struct rf_surface *at[LANES];
        vf part;
        for (int l = 0; l < LANES; l++) {
            at[l] = rf_shown_at(s, (size_t)w->index[i + l]);
            part[l] = s->share[w->index[i + l]];
        }
        part = choose(part < SPLAT(1), SPLAT(1) - part, SPLAT(1));
        const vf k = LOAD(w->weight + i) * part;
        STORE(w->weight + i, k);
        weight_sum += k;
        for (int l = 0; l < 4; l++)
            v[l] = load_halves(at[l]->c, at[l + 4]->c);
        turn_halves(v);
        vf l = luminance_of(v);
        log_sum += k * vlog(vmax(l, SPLAT(0)) + SPLAT(1e-3f));
        luminance[i / LANES] = l;
    }
    const float weight = lane_sum(weight_sum);
    vf limit = SPLAT(brightest * rf_expf(lane_sum(log_sum) / weight));
    for (int i = 0; i < w->n; i += LANES) {
        const vf *v = colour[i / LANES], l = luminance[i / LANES];
        vf k = LOAD(w->weight + i), dim = choose(l > limit, k * (limit / l), k);
        for (int p = 0; p < 3; p++)
            sum[p] += dim * v[p];
        sum[3] += k * v[3];
    }
    /* One store: it is read as a whole soon, before it has left for the cache. */
    const vf_half mean = {lane_sum(sum[0]), lane_sum(sum[1]), lane_sum(sum[2]),
                          lane_sum(sum[3])};
    *(vf_half *)c = mean * (1 / weight);
}
