/* SPDX-License-Identifier: Apache-2.0 */
/* Inner loops of hidden.c, which says what they compute; part of kernels_tmpl.c. */
#include "hidden_kernels.h"
#include "vector.h"

/* Distances from which a block is read at every 2nd and every 4th pixel. */
enum { STRIDE_2_PX = 4, STRIDE_4_PX = 12 };

static void log_row(float *v, int n)
{
    for (int x = 0; x < n; x += LANES)
        STORE(v + x, vlog(vmax(LOAD(v + x), SPLAT(0)) + SPLAT(1e-3f)));
}

/* Distance from x to the interval of block b, in px. */
static inline int gap_to_block(int x, int b)
{
    int x0 = b * RF_HIDDEN_BLOCK, x1 = x0 + RF_HIDDEN_BLOCK - 1;
    return x < x0 ? x0 - x : x > x1 ? x - x1 : 0;
}

static inline void cast_vote(struct rf_hidden_vote *vote, int d2, float room,
                             float weight)
{
    int b = (int)(room * 2); /* half a pixel */
    b = (b < RF_HIDDEN_BINS - 1 ? b : RF_HIDDEN_BINS - 1) + 2;
    for (; vote->top < b + 1; vote->top++) {
        vote->histogram[vote->top + 1] = 0;
        vote->nearest2[vote->top + 1] = INT32_MAX;
    }
    float k = 1 / ((float)d2 + 0.5f);
    vote->histogram[b] += weight * k * k * k;
    vote->nearest = d2 < vote->nearest ? d2 : vote->nearest;
    vote->nearest2[b] = d2 < vote->nearest2[b] ? d2 : vote->nearest2[b];
}

static inline void vote_block(const struct rf_backs *backs,
                              const struct rf_hidden_query *q,
                              const struct rf_hidden_block *block,
                              struct rf_hidden_vote *vote)
{
    int gx = gap_to_block(q->x, block->x), gy = gap_to_block(q->y, block->y);
    float limit = block->highest - q->s;
    float gap2 = (float)(gx * gx) * q->inv_x2 + (float)(gy * gy) * q->inv_y2;
    if (limit <= 0 || gap2 >= limit * limit)
        return;
    int gap = gx > gy ? gx : gy;
    int stride = gap < STRIDE_2_PX ? 1 : gap < STRIDE_4_PX ? 2 : 4;
    vi is_read = (lane_numbers() & (stride - 1)) == 0;
    int x0 = block->x * RF_HIDDEN_BLOCK, y0 = block->y * RF_HIDDEN_BLOCK;
    vi dx = lane_numbers() + (x0 - q->x);
    vf dx2 = to_float(dx * dx) * SPLAT(q->inv_x2);
    const float *row = backs->r + (size_t)y0 * (size_t)backs->stride + x0;
    for (int y = 0; y < RF_HIDDEN_BLOCK; y += stride) {
        vf room = LOAD(row + (size_t)y * (size_t)backs->stride) - SPLAT(q->s);
        int dy = y0 + y - q->y;
        vf d2 = dx2 + SPLAT((float)(dy * dy) * q->inv_y2);
        unsigned bits = lane_bits(is_read & (room > SPLAT(0)) & (d2 < room * room));
        for (; bits; bits &= bits - 1) {
            int l = __builtin_ctz(bits), distance = x0 + l - q->x;
            cast_vote(vote, distance * distance + dy * dy, room[l],
                      (float)(stride * stride));
        }
    }
}

static void vote_blocks(const struct rf_backs *backs, const struct rf_hidden_query *q,
                        const struct rf_hidden_block *blocks, int n,
                        struct rf_hidden_vote *vote)
{
    vote->top = 1;
    vote->nearest = INT32_MAX;
    for (int b = 0; b < 2; b++) {
        vote->histogram[b] = 0;
        vote->nearest2[b] = INT32_MAX;
    }
    for (int i = 0; i < n; i++) {
        int gap = (blocks[i].ring - 1) * RF_HIDDEN_BLOCK + 1;
        if (blocks[i].ring > 1 && vote->nearest < INT32_MAX &&
            4 * gap * gap > 9 * vote->nearest)
            return;
        vote_block(backs, q, &blocks[i], vote);
    }
}

/* Every stride-th float from p on. */
static inline vf load_strided(const float *p, int stride)
{
    vf v;
    if (stride == 1)
        return LOAD(p);
    for (int l = 0; l < LANES; l++)
        v[l] = p[l * stride];
    return v;
}

static void gather_window(const struct rf_backs *backs, const struct rf_hidden_query *q,
                          float r, float reach, struct rf_hidden_window *out)
{
    int n = (int)reach, stride = (n + RF_HIDDEN_STEPS - 1) / RF_HIDDEN_STEPS;
    int y0 = rf_max_int(q->y - n, 0), y1 = rf_min_int(q->y + n, backs->height - 1);
    int x0 = rf_max_int(q->x - n, 0), x1 = rf_min_int(q->x + n, backs->width - 1);
    y0 = (backs->y + y0 + stride - 1) / stride * stride - backs->y;
    x0 = (backs->x + x0 + stride - 1) / stride * stride - backs->x;
    vf log_sum = {0}, weight_sum = {0};
    out->n = 0;
    for (int y = y0; y <= y1; y += stride) {
        size_t row = (size_t)y * (size_t)backs->stride;
        int dy = y - q->y;
        for (int x = x0; x <= x1; x += LANES * stride) {
            vi at = lane_numbers() * stride + x;
            vi dx = at - q->x;
            vf d2 = to_float(dx * dx + dy * dy);
            vf qr = load_strided(backs->r + row + (size_t)x, stride);
            vf t = qr - SPLAT(r);
            vi is_used = (at <= x1) & (d2 <= SPLAT(reach * reach)) &
                         (qr > SPLAT(q->s)) & (t * t <= SPLAT(9));
            unsigned bits = lane_bits(is_used);
            if (!bits)
                continue;
            t = choose(is_used, t, SPLAT(0)); /* keeps infinities out */
            d2 += SPLAT(0.5f);
            vf w = vexp(SPLAT(-0.5f) * t * t) / (d2 * vsqrt(d2));
            w = choose(is_used, w, SPLAT(0));
            weight_sum += w;
            vf l = load_strided(backs->log_luminance + row + (size_t)x, stride);
            log_sum += w * choose(is_used, l, SPLAT(0));
            for (; bits; bits &= bits - 1) {
                int lane = __builtin_ctz(bits);
                out->index[out->n] = y * backs->width + at[lane];
                out->weight[out->n++] = w[lane];
            }
        }
    }
    out->log_sum = lane_sum(log_sum);
    out->weight_sum = lane_sum(weight_sum);
}
