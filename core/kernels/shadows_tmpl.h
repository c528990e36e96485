/* SPDX-License-Identifier: Apache-2.0 */
/* Shadows on the disc of a highlight: highlights_add.c says why; part of
 * kernels_tmpl.c. */
#include "kernels/kernels.h"
#include "kernels/vector.h"

/* Of numbers that an int holds. */
static inline vi vfloor(vf v)
{
    vi i = to_int(v);
    return i + (v < to_float(i)); /* true is -1 */
}

/* Both ends of a shadow's side, and the pixels of the mask's box that it touches. */
struct side {
    float low[LANES + 1], high[LANES + 1]; /* one more, which is read */
    int32_t first[LANES], last[LANES];
};

/*
 * Where the edge at `at` of what has radius q falls along one axis.
 *
 * With m = r0 / (r0 - q), light that comes from d inward of its pixel has the edge at
 * (1 - m) d farther. That undoes the pixel filter, which spread the lamp; the shares of
 * the occluder's pixels are spread, too, and m times as wide. The lens' picture is spread
 * by the filter once: where m < 1 the lamp has to leave sqrt(1 - m^2) of its spread.
 *
 * SPREAD in place of 1: what is hidden by more than 0.8 counts as hidden (rims.c), which
 * takes a part of the spread away. Macro + 0.13 dB, its 8 views + 0.18, night's + 0.03,
 * posts -0.04; with 1.2 macro + 0.18 and 0.24, but a rim of 0.92 in focus lets 0.11 of a
 * small lamp through. With none where m is 0 to 1 posts' 8 views -0.22, macro's -0.3,
 * foliage's -0.17, fur's -0.08.
 */
#define SPREAD 1.1f

static inline vf cast_edge(const struct rf_shadows *s, vf q, vf at, float lens,
                           float light, float inward)
{
    vf shift = SPLAT(s->shift_scale) * q + SPLAT(s->shift_bias);
    vf m = SPLAT(s->disc_r) / (SPLAT(s->light_r) - q);
    vf spread = vsqrt(vmax(SPLAT(SPREAD) - m * m, SPLAT(0)));
    return (at - SPLAT(lens) * shift - SPLAT(light)) * m + SPLAT(light) +
           (SPLAT(1) - m - spread) * SPLAT(inward);
}

/*
 * Radius of the edge to a neighbour: the mean where both are of one surface, so that
 * their shadows meet.
 */
static inline vf edge_radius(const struct rf_shadows *s, vf q, vf neighbour)
{
    vf mean = SPLAT(0.5f) * (q + neighbour);
    vi is_one = (vabs(neighbour - q) < SPLAT(s->join)) &
                (SPLAT(s->light_r) - mean >= SPLAT(s->nearer));
    return choose(is_one, mean, q);
}

/* Radii of the pixels x + dx of a row of n, INFINITY beyond it. */
static inline vf neighbours(const float *row, int x, int dx, int n)
{
    if (row && x + dx >= 0 && x + dx + LANES <= n)
        return LOAD(row + x + dx);
    float r[LANES];
    for (int l = 0; l < LANES; l++) {
        int at = x + l + dx;
        r[l] = row && at >= 0 && at < n ? row[at] : INFINITY;
    }
    return LOAD(r);
}

static inline void find_side(vf a, vf b, vi is_used, int from, int n, struct side *s)
{
    vf low = choose(is_used, vmin(a, b), SPLAT(0));
    vf high = choose(is_used, vmax(a, b), SPLAT(0));
    vi first = vfloor(low), last = vfloor(high), least = first - first + from;
    vi is_before = first<least, is_after = last> least + (n - 1);
    first = (least & is_before) | (first & ~is_before);
    last = ((least + (n - 1)) & is_after) | (last & ~is_after);
    STORE(s->low, low);
    STORE(s->high, high);
    memcpy(s->first, &first, sizeof first);
    memcpy(s->last, &last, sizeof last);
}

/* Length of the overlap of [a, b] with pixel x. */
static inline float overlap(float a, float b, int x)
{
    float low = a > (float)x ? a : (float)x;
    float high = b < (float)(x + 1) ? b : (float)(x + 1);
    return high > low ? high - low : 0;
}

/*
 * The shadow of one pixel, or of several side by side that meet at their edges and
 * reach from one height to one other, as those of a wall or a post do.
 */
struct shadow {
    float x0, x1, y0, y1, share; /* px; share 0: there is none yet */
    int first_x, last_x, first_y, last_y;
};

typedef unsigned char eight_bytes __attribute__((vector_size(8)));

/* Which of LANES pixels from x on in row y of the mask ask the view. */
static inline vi asks_view(const struct rf_shadows *s, int x, int y)
{
    size_t stride = (size_t)s->width + RF_SHADOW_MARGIN;
    eight_bytes views;
    memcpy(&views, s->views + stride * s->views_row[y - s->top] + (x - s->left),
           sizeof views);
    return __builtin_convertvector(views, vi) == (vi){0} + s->view;
}

/*
 * Draws LANES columns from x on, of which those after the last are left as they are; of
 * several views only in those pixels that ask this one.
 */
static inline void draw_columns(const struct rf_shadows *s, const struct shadow *d,
                                int x)
{
    vi at = lane_numbers() + x;
    vf low = vmax(SPLAT(d->x0), to_float(at));
    vf high = vmin(SPLAT(d->x1), to_float(at + 1));
    vi is_used = (high > low) & (at <= d->last_x);
    for (int y = d->first_y; y <= d->last_y; y++) {
        float k = d->share * overlap(d->y0, d->y1, y);
        float *to = s->blocked + (ptrdiff_t)(y - s->top) * s->width - s->left + x;
        vi is_drawn = s->views ? is_used & asks_view(s, x, y) : is_used;
        STORE(to, LOAD(to) + SPLAT(k) * choose(is_drawn, high - low, SPLAT(0)));
    }
}

static inline void draw_shadow(const struct rf_shadows *s, const struct shadow *d)
{
    for (int x = d->first_x; x <= d->last_x; x += LANES)
        draw_columns(s, d, x);
}

static inline struct shadow shadow_of(const struct side *across,
                                      const struct side *down, int l, float share)
{
    return (struct shadow){across->low[l],  across->high[l], down->low[l],
                           down->high[l],   share,           across->first[l],
                           across->last[l], down->first[l],  down->last[l]};
}

/* Makes a shadow longer by that of the next pixel, if it has its height and share. */
static inline bool join_shadows(struct shadow *d, const struct shadow *next)
{
    if (d->share != next->share || d->y0 != next->y0 || d->y1 != next->y1)
        return false;
    if (d->x1 == next->x0) {
        d->x1 = next->x1;
        d->last_x = next->last_x;
        return true;
    }
    if (d->x0 != next->x1)
        return false;
    d->x0 = next->x0;
    d->first_x = next->first_x;
    return true;
}

/* Are the values of all lanes those of the next in another array? */
static inline bool are_next(const float *at, const float *next)
{
    return (lane_bits(LOAD(at) == LOAD(next + 1)) & 0x7f) == 0x7f;
}

/* Are the values of all lanes the same? */
static inline bool are_alike(const float *at)
{
    return lane_bits(LOAD(at) == SPLAT(at[0])) == 0xff;
}

/*
 * LANES pixels of one surface, of one height and share, that meet at their edges: the
 * shadow of all of them; share 0 where they do not.
 */
static inline struct shadow join_lanes(const struct side *across,
                                       const struct side *down, const float *share)
{
    struct shadow all = {.share = 0};
    if (!are_alike(share) || !are_alike(down->low) || !are_alike(down->high))
        return all;
    if (are_next(across->high, across->low)) {
        all = shadow_of(across, down, 0, share[0]);
        all.x1 = across->high[LANES - 1];
        all.last_x = across->last[LANES - 1];
    } else if (are_next(across->low, across->high)) {
        all = shadow_of(across, down, 0, share[0]);
        all.x0 = across->low[LANES - 1];
        all.first_x = across->first[LANES - 1];
    }
    return all;
}

/* Adds a shadow to one that it may make longer, which is drawn where it does not. */
static inline void add_shadow(const struct rf_shadows *s, struct shadow *shadow,
                              struct shadow next, bool is_same)
{
    if (is_same && join_shadows(shadow, &next))
        return;
    if (shadow->share > 0)
        draw_shadow(s, shadow);
    *shadow = next;
}

static bool cast_shadows(const struct rf_shadows *s, const float *radius,
                         const float *share, int y, int x0, int x1)
{
    bool is_found = false;
    struct shadow shadow = {.share = 0};
    vf dy = SPLAT((float)y + 0.5f - s->seen_y);
    for (int x = x0; x < x1; x += LANES) {
        vi at = lane_numbers() + x;
        vf q = LOAD(radius + x), room = SPLAT(s->light_r) - q;
        vf dx = to_float(at) + SPLAT(0.5f) - SPLAT(s->seen_x);
        vi is_used = (at < x1) & (room >= SPLAT(s->nearer)) &
                     (vabs(dx) <= room * SPLAT(s->extent_x) + SPLAT(s->beside)) &
                     (vabs(dy) <= room * SPLAT(s->extent_y) + SPLAT(s->beside));
        unsigned bits = lane_bits(is_used);
        if (!bits)
            continue;
        is_found = true;
        if (!s->blocked)
            return true;
        vf before = neighbours(radius, x, -1, s->row);
        vf left = edge_radius(s, q, before);
        vf right = edge_radius(s, q, neighbours(radius, x, 1, s->row));
        vf upper = edge_radius(s, q, neighbours(s->above, x, 0, s->row));
        vf lower = edge_radius(s, q, neighbours(s->below, x, 0, s->row));
        vf ox = to_float(at - s->x), oy = SPLAT((float)(y - s->y)), one = SPLAT(1);
        struct side across, down;
        find_side(cast_edge(s, left, ox, s->lens_x, s->light_x, s->inward_x),
                  cast_edge(s, right, ox + one, s->lens_x, s->light_x, s->inward_x),
                  is_used, s->left, s->width, &across);
        find_side(cast_edge(s, upper, oy, -s->lens_y, s->light_y, s->inward_y),
                  cast_edge(s, lower, oy + one, -s->lens_y, s->light_y, s->inward_y),
                  is_used, s->top, s->height, &down);
        unsigned same = lane_bits(before == q);
        if (bits == 0xff && (same & 0xfe) == 0xfe) {
            struct shadow all = join_lanes(&across, &down, share + x);
            if (all.share > 0) {
                add_shadow(s, &shadow, all, same & 1);
                continue;
            }
        }
        for (; bits; bits &= bits - 1) {
            int l = __builtin_ctz(bits);
            add_shadow(s, &shadow, shadow_of(&across, &down, l, share[x + l]),
                       same >> l & 1);
        }
    }
    if (shadow.share > 0)
        draw_shadow(s, &shadow);
    return is_found;
}
