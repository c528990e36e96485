/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Splitting mixed pixels (docs/algorithm.md, the section of that name).
 *
 * The renderer's colour is anti-aliased, its depth is one jittered sample: an edge
 * pixel shows two surfaces but has one depth. With c its colour, f and b the colours of
 * the near and the far surface around it, e = f - b,
 *
 *   A = clamp((c - b) . e / |e|^2)      share of the near surface
 *
 * and c - (A f + (1 - A) b), the residual, goes to each part as far as its colour is
 * unsure: with v_f and v_b, the variances of the pixels around from f and b, the near
 * part takes it A v_f / (A^2 v_f + (1 - A)^2 v_b) times and the far one (1 - A) v_b over
 * the same. So a shaded wire leaves next to no lines on an even thing in focus behind it
 * (worth up to 5 dB there; tests/quality -0.01 to 0.04). Where A is 0 or 1 the pixel
 * stays as it is, with the depth that it has (worth 0.2 to 1.0 dB on four of six scenes,
 * 0.6 and 1.2 with eight views), unless mean distances know better. But
 * a lone view gives a thin thing back the pixels that
 * it fills and the depth sample missed: they would stay sharp, a dotted line in the place
 * of a wire (worth 0.1 to 0.4 dB on wires, hair and meshes). It also gives a thing near
 * the focus back what the depth sample missed of its rim, where the rim is brighter than
 * the rest of it and the ground behind is even: f is then a pixel of the rim beside it
 * (worth 2 to 5 dB on a stranger's chair before a grey sky; tests/quality 0). And where
 * the surface that the depth says is textured along e, the colour cannot tell texture from
 * mixture: of a lone view the pixel stays whole, or the dark squares of a chessboard would
 * become teeth of a dark thing before it (worth up to 0.2 dB on six scenes, 0.8 on posts
 * before a chessboard; several views of portrait would lose 0.5).
 * Two cases:
 *
 *   fringe   a small bright thing bleeds into a pixel whose depth sample missed it;
 *            first, since its share is told by luminance alone
 *   edge     the radii of the 3 x 3 pixels around fall into two groups with a gap, and
 *            do not lie on one slanted plane (worth 0.03 to 0.11 dB)
 *
 * Worth 0.9 to 1.3 dB with one view. Cost: a few comparisons per pixel, 5 x 5 pixels
 * where there is an edge.
 */
#include "surfaces/split.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/arena.h"
#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/image.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "surfaces/split_around.h"
#include "surfaces/split_fringe.h"
#include "surfaces/split_means.h"
#include "surfaces/split_pixels.h"
#include "surfaces/split_sides.h"
#include "surfaces/splitter.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

/*
 * Ours. Behind each: tPSNR in dB of scenes of tests/quality with half of it and with
 * twice (docs/notebook/thresholds.md); "0" where no scene changes by 0.02.
 */
/* Smallest jump of the radius at an edge: rough depth has smaller ones. Foliage -0.01 for
 * 0.1, macro whose depth is off by 0.1 % + 0.7; 0. Of one view beside what is brighter than
 * white, whose light is seen farther, 0.4: two cubes of bright colours +2.2; everywhere
 * focalblur.pov -0.08, macro whose depth is off by 0.3 % -0.41. */
static const float EDGE_GAP_PX = 0.6f, BRIGHT_EDGE_GAP_PX = 0.4f;
/* Of the range of radii, off a plane. 0; macro -0.52, ortho -0.13, posts +0.11. */
static const float PLANE_TOLERANCE = 0.3f;
static const float ALIKE = 0.02f; /* colours closer stay whole. 0; posts +0.04 */
/* Colours of a thin thing, of what sets it off. 0; 0: few of these scenes have any. */
static const float THIN_ALIKE = 0.3f;
/* Colours within a surface, likewise. Macro -0.19, posts +0.27; posts -0.10. */
static const float TEXTURE = 0.35f;
/* Luminance of display white: what is brighter may be a lamp. */
static const float WHITE = 1;
/* Of a thing's rim before an even ground: how much the ground's pixels vary, and how far a
 * colour lies from mixtures of rim and ground, in parts of e. 0; 0, the chair likewise. */
static const float EVEN_GROUND = 0.2f, MIXTURE = 0.15f;
enum { LEAST_GROUND = 3 }; /* pixels that tell whether it is even. 6: 0 */
/* How unsure a colour is at the least, of what sets the surfaces off. At 0.16 lines of
 * wires are 1 dB weaker, posts +0.01, at 0.6 1.7 dB stronger, plane -0.01; but a slow pan
 * of even stripes flickers 2 % more at 0.2, 12 % at 0.08. */
static const float UNSURE = 0.3f;

static const float EVEN = 0.02f; /* smaller measured shares are slants of a surface */
/* What is brighter within 5 x 5 px is left to colours: else 4 views of portrait have the
 * ghost of a lamp, -1.3 dB. */
static const float LAMP = 2;
/* Of several views, what stays whole: all that lies before the focus by this radius, and
 * parts of which the difference is this part of the smaller radius. foliage -0.05, grass
 * -0.01; grass -0.02, snow -0.07. */
static const float BLURRED_PX = 8, BLURRED = 0.6f;
static const float EMPTY = 0.02f; /* alpha behind an edge, of that before it */

enum { WINDOW = RF_SPLIT_WINDOW };

/*
 * What one thread works with. Rows: extremes of the luminance (5 x 5) and the radius
 * (3 x 3), gaps of the radius.
 */
struct scratch {
    const struct rf_kernels *kernels;
    const int32_t *steps; /* to the pixels around one, as struct rf_sides has them */
    float *columns, *darkest, *brightest, *nearest, *farthest, *gap, *threshold;
    unsigned char *candidates;
    bool is_alone; /* the only view */
    const struct rf_splitter *splitter;
};

enum { N_ROWS = 8 }; /* of floats, for all that: two for the columns */

/* Is the pixel of a thin thing's colour, as its position lets one tell? */
static bool is_thin_thing(const struct rf_surface *c, const struct rf_surface *f,
                          const struct rf_split_position *p)
{
    float d2 = 0;
    for (int n = 0; n < 4; n++) {
        float d = p->unit * (c->c[n] - f->c[n]);
        d2 += d * d;
    }
    return d2 < THIN_ALIKE * THIN_ALIKE * p->norm && rf_split_luminance(c) <= WHITE;
}

/* Do pixels within the surface that the depth says look as if the other one had a share
 * of them? */
static bool is_textured(const struct scratch *s, const struct rf_surface *c,
                        const struct rf_meeting *m, const struct rf_split_position *p)
{
    float most = 0;
    const struct rf_surface *own = m->is_near ? &m->f : &m->b;
    const struct rf_surface *other = m->is_near ? &m->b : &m->f;
    for (uint32_t bits = m->own; bits; bits &= bits - 1) {
        const struct rf_surface *q = c + s->steps[__builtin_ctz(bits)];
        float dot = 0;
        for (int n = 0; n < 4; n++)
            dot +=
                p->unit * (q->c[n] - own->c[n]) * (p->unit * (other->c[n] - own->c[n]));
        most = rf_max_float(most, dot);
    }
    return most > TEXTURE * p->norm;
}

/* How often the parts of a pixel take the residual. */
struct taken {
    float near, far;
};

/* By how much the pixels of a set that is not empty differ from a colour: the mean square
 * over |e|^2. */
static float variance_from(const struct scratch *s, const struct rf_surface *c,
                           uint32_t bits, const struct rf_surface *from,
                           const struct rf_split_position *p)
{
    const rf_quad mean = *(const rf_quad *)from->c;
    rf_quad squares = {0};
    float n_pixels = 0, unit = p->unit / sqrtf(p->norm);
    for (; bits; bits &= bits - 1, n_pixels++) {
        const struct rf_surface *q = c + s->steps[__builtin_ctz(bits)];
        rf_quad d = unit * (*(const rf_quad *)q->c - mean);
        squares += d * d;
    }
    return (squares[0] + squares[1] + squares[2]) / n_pixels;
}

/* What the near part, which covers a, and the far one take. */
static struct taken taken_by(const struct scratch *s, const struct rf_surface *c,
                             const struct rf_meeting *m,
                             const struct rf_split_position *p, float a)
{
    float near = a * (variance_from(s, c, m->near, &m->f, p) + UNSURE * UNSURE);
    float far = (1 - a) * (variance_from(s, c, m->far, &m->b, p) + UNSURE * UNSURE);
    float whole = a * near + (1 - a) * far;
    return whole < FLT_MAX ? (struct taken){near / whole, far / whole}
                           : (struct taken){1, 1};
}

/* Colours of both parts, of which the near one covers a: f and b with the residual. */
static void share_colour(const struct rf_surface *c, const struct rf_surface *f,
                         const struct rf_surface *b, float a, struct taken taken,
                         struct rf_surface *near, struct rf_surface *far)
{
    for (int n = 0; n < 4; n++) {
        float residual = c->c[n] - (a * f->c[n] + (1 - a) * b->c[n]);
        float ff = f->c[n] + taken.near * residual, bb = b->c[n] + taken.far * residual;
        if (bb < 0) { /* what would be negative goes to the other part */
            ff += bb * (1 - a) / a;
            bb = 0;
        }
        if (ff < 0) {
            bb += ff * a / (1 - a);
            ff = 0;
        }
        near->c[n] = ff;
        far->c[n] = bb;
    }
}

/* Has what is behind an edge light of its own: a sky that has no alpha? */
static bool is_lit(const struct rf_surface *b, const struct rf_surface *f)
{
    float light = 0, others = 0;
    for (int n = 0; n < 3; n++) {
        light += fabsf(b->c[n]);
        others += fabsf(f->c[n]);
    }
    return light > EMPTY * others;
}

/*
 * Before transparent film alpha tells the share exactly. Nothing of the colour belongs
 * to the far side, unless the film is lit.
 */
static void split_by_alpha(const struct rf_surface *c, const struct rf_surface *f,
                           const struct rf_split_edge *e, const struct rf_surface *b,
                           struct rf_surface *near, struct rf_surface *far,
                           float *share)
{
    static const struct rf_surface nothing;
    float a = rf_split_share_of(c->c[3] / f->c[3]);
    bool is_near = c->r <= e->threshold, has_light = is_lit(b, f);
    const struct rf_surface *behind = !has_light ? &nothing : a > 0 ? b : c;
    for (int n = 0; n < 4; n++) {
        near->c[n] = a > 0 ? c->c[n] / a : f->c[n];
        far->c[n] = behind->c[n];
    }
    if (has_light && a > 0 && a < 1)
        share_colour(c, f, b, a, (struct taken){1, 1}, near, far);
    near->r = is_near ? c->r : f->r;
    far->r = is_near ? b->r : c->r;
    *share = a;
}

/* Least and most of each channel of the pixels of a set; of none, nothing is between. */
static void find_range(const struct rf_split_around *around, uint32_t bits,
                       float least[4], float most[4])
{
    for (int n = 0; n < 4; n++) {
        least[n] = INFINITY;
        most[n] = -INFINITY;
    }
    for (; bits; bits &= bits - 1) {
        const float *c = around->middle[around->steps[__builtin_ctz(bits)]].c;
        for (int n = 0; n < 4; n++) {
            least[n] = rf_min_float(least[n], c[n]);
            most[n] = rf_max_float(most[n], c[n]);
        }
    }
}

/* Can the middle pixel be such a mixture of colours that both sides show around it? */
static bool is_mixture(const struct rf_split_around *around, const struct rf_meeting *m,
                       float a)
{
    const uint32_t others = ~(uint32_t)RF_SPLIT_MIDDLE;
    float near[2][4], far[2][4];
    find_range(around, m->near & others, near[0], near[1]);
    find_range(around, m->far & others, far[0], far[1]);
    bool is_within = true;
    for (int n = 0; n < 4; n++) {
        float c = around->middle->c[n], least = a * near[0][n] + (1 - a) * far[0][n];
        float most = a * near[1][n] + (1 - a) * far[1][n];
        float room = ALIKE * (fabsf(least) + fabsf(most));
        is_within &= c > least - room && c < most + room;
    }
    return is_within;
}

/* The square of what a colour is apart from a mixture of f and b, of which f covers a. */
static float residual_of(const struct rf_surface *c, const struct rf_surface *f,
                         const struct rf_surface *b, float a, float unit)
{
    float sum = 0;
    for (int n = 0; n < 4; n++) {
        float d = unit * (c->c[n] - (a * f->c[n] + (1 - a) * b->c[n]));
        sum += d * d;
    }
    return sum;
}

/*
 * Splits a pixel whose depth is that of an even ground, but not its colour, which is
 * farther from the ground's than the mean of the near side's: as a mixture with the rim
 * of a thing near the focus, if a pixel next to it is the rim.
 */
static bool split_rim(const struct scratch *s, const struct rf_surface *c,
                      const struct rf_meeting *m, const struct rf_split_position *p,
                      struct rf_surface *near, struct rf_surface *far, float *share)
{
    enum { NEXT = 7 << 6 | 5 << 11 | 7 << 16 };
    const uint32_t ground = m->own & ~(uint32_t)RF_SPLIT_MIDDLE;
    float least = MIXTURE * MIXTURE * p->norm;
    const struct rf_surface *rim = NULL;
    if (fabsf(m->f.r) >= RF_SPLIT_SHARP_PX ||
        __builtin_popcount(ground) < LEAST_GROUND ||
        variance_from(s, c, ground, &m->b, p) > EVEN_GROUND * EVEN_GROUND)
        return false;
    for (uint32_t bits = m->near & NEXT; bits; bits &= bits - 1) {
        const struct rf_surface *q = c + s->steps[__builtin_ctz(bits)];
        const struct rf_split_position at = rf_split_position_of(c, q, &m->b);
        float a = at.norm > 0 ? rf_split_share_of(at.dot / at.norm) : 0;
        float residual = residual_of(c, q, &m->b, a, p->unit);
        if (a > 0 && residual < least) {
            least = residual;
            rim = q;
            *share = a;
        }
    }
    if (!rim)
        return false;
    *near = *far = *c;
    if (*share < 1)
        share_colour(c, rim, &m->b, *share, (struct taken){1, 1}, near, far);
    near->r = m->f.r;
    return true;
}

/*
 * Of several views, are both parts blurred so much that their shares tell less than
 * their guessed colours may be wrong: before the focus, or by more than they differ?
 */
static bool is_blurred_alike(const struct scratch *s, const struct rf_surface *f,
                             const struct rf_surface *b, int x)
{
    if (s->is_alone)
        return false;
    if (b->r < -BLURRED_PX)
        return true;
    float least = rf_min_float(fabsf(f->r), fabsf(b->r));
    return f->r * b->r > 0 && b->r - f->r < BLURRED * least && s->brightest[x] <= LAMP;
}

static bool split_edge(const struct scratch *s, const struct rf_pixels *p, int x, int y,
                       const struct rf_split_edge *e, struct rf_surface *near,
                       struct rf_surface *far, float *share)
{
    struct rf_meeting m;
    const bool has_lamp = s->brightest[x] > LAMP;
    if (e->gap < EDGE_GAP_PX && s->brightest[x] <= WHITE)
        return false;
    if (!rf_split_find_sides(s->splitter, x, y, e, has_lamp, &m))
        return false;
    const struct rf_surface *c = rf_split_pixel(p, x, y), *f = &m.f, *b = &m.b;
    if (b->c[3] < EMPTY * f->c[3]) {
        split_by_alpha(c, f, e, b, near, far, share);
        return true;
    }
    if (is_blurred_alike(s, f, b, x))
        return false;
    const struct rf_split_position at = rf_split_position_of(c, f, b);
    if (at.norm < ALIKE * ALIKE * at.size * at.size + 1e-8f)
        return false;
    float a = rf_split_share_of(at.dot / at.norm);
    if (a >= 1 && !m.is_near && m.is_within && s->is_alone &&
        is_thin_thing(c, f, &at)) {
        *near = *far = *c;
        near->r = f->r;
        *share = 1;
        return true;
    }
    const bool is_whole = a <= 0 || a >= 1; /* as colours say */
    if (is_whole && has_lamp)
        return false;
    if (a >= 1 && !m.is_near && s->is_alone &&
        split_rim(s, c, &m, &at, near, far, share))
        return true;
    const struct rf_split_around around = {c, s->steps};
    float measured = rf_split_measured_share(s->splitter, &around, &m, x, y);
    if (is_whole && (!(measured > EVEN && measured < 1 - EVEN) ||
                     !is_mixture(&around, &m, measured) ||
                     !rf_split_are_told_whole(s->splitter, &around, &m, x, y)))
        return false;
    if (measured >= 0 ? measured <= EVEN || measured >= 1 - EVEN
                      : s->is_alone && is_textured(s, c, &m, &at))
        return false;
    a = measured >= 0 ? measured : a;
    share_colour(c, f, b, a, taken_by(s, c, &m, &at, a), near, far);
    near->r = m.is_near ? c->r : f->r;
    far->r = m.is_near ? b->r : c->r;
    *share = a;
    return true;
}

/* Is a pixel opaque? If not its alpha tells its share, and no fringe has to. */
static bool is_opaque(const struct rf_pixels *pixels, int x, int y)
{
    return rf_split_pixel(pixels, x, y)->c[3] >= 1;
}

/* What a pixel may be, as far as extremes tell. */
enum { MAY_BE_FRINGE = 1, MAY_BE_EDGE = 2 };

static void find_candidates(const struct rf_pixels *p, int y, const struct scratch *s)
{
    const float *rows[2 * WINDOW + 1];
    rf_plane_rows(p, p->luminance, y, WINDOW, rows);
    s->kernels->extremes(rows, 2 * WINDOW + 1, WINDOW, p->width, s->columns, s->darkest,
                         s->brightest);
    rf_plane_rows(p, p->radius, y, 1, rows);
    s->kernels->extremes(rows, 3, 1, p->width, s->columns, s->nearest, s->farthest);
    const float gap = s->is_alone ? BRIGHT_EDGE_GAP_PX : EDGE_GAP_PX;
    const struct rf_around around = {rf_plane_row(p, p->luminance, y), s->darkest,
                                     s->brightest, s->nearest, s->farthest};
    s->kernels->find_mixed(&around, RF_HIGHLIGHT_RATIO, RF_HIGHLIGHT_OVER_FRINGE, gap,
                           p->width, MAY_BE_FRINGE, MAY_BE_EDGE, s->candidates);
    if (y > 0 && y < p->height - 1) {
        int first = s->candidates[0], last = s->candidates[p->width - 1];
        s->kernels->keep_edges(rows, s->nearest, s->farthest, PLANE_TOLERANCE, p->width,
                               MAY_BE_EDGE, s->candidates);
        s->candidates[0] = (unsigned char)first;
        s->candidates[p->width - 1] = (unsigned char)last;
    }
    s->kernels->find_gaps(rows, gap, p->width, MAY_BE_EDGE, s->candidates, s->gap,
                          s->threshold);
}

/* Splits a pixel that may be mixed; false: it is pure. */
static bool split_pixel(const struct rf_pixels *pixels, int x, int y,
                        const struct scratch *s, struct rf_surface *near,
                        struct rf_surface *far, float *share)
{
    int candidate = s->candidates[x];
    bool is_blurred = !s->is_alone && rf_split_pixel(pixels, x, y)->r < -BLURRED_PX;
    if (candidate & MAY_BE_FRINGE && !is_blurred && is_opaque(pixels, x, y) &&
        rf_may_be_fringe(pixels, x, y, s->brightest[x]) &&
        rf_split_fringe(pixels, x, y, near, far, share))
        return true;
    const struct rf_split_edge edge = {s->threshold[x], s->gap[x], s->nearest[x],
                                       s->farthest[x]};
    return candidate & MAY_BE_EDGE &&
           split_edge(s, pixels, x, y, &edge, near, far, share);
}

/* The first pixel after x that may be mixed; n or more: there is none. */
static int next_candidate(const struct scratch *s, int x, int n)
{
    for (x++; x < n; x++) {
        uint64_t eight;
        memcpy(&eight, s->candidates + x / 8 * 8, sizeof eight);
        if (!eight)
            x = x / 8 * 8 + 7;
        else if (s->candidates[x])
            return x;
    }
    return n;
}

/* ---- all pixels ---------------------------------------------------------------- */

/* A pixel that has been split: it may show its near part alone, but not as it came. */
struct split {
    struct rf_surface near, far;
    int x;
};

/* The split pixels of one row. */
struct rf_split_row {
    int n;
    struct split *at;
};

/* As if all pixels of a row stayed whole. */
static void set_pure(const struct rf_splitter *s, int y)
{
    const struct rf_pixels *p = s->pixels;
    float *share = s->out->share + (size_t)y * (size_t)p->width;
    const float *row = rf_plane_row(p, p->luminance, y);
    uint64_t *possible_highlights =
        s->possible_highlights + rf_row_words(p->width) * (size_t)y;
    for (int x = 0; x < p->width; x++)
        share[x] = 1;
    s->frame->context->kernels->find_above(row, s->bright, p->width,
                                           possible_highlights);
}

static bool may_be_highlight(const struct rf_splitter *s, const struct split *split)
{
    return rf_split_luminance(&split->near) > s->bright ||
           rf_split_luminance(&split->far) > s->bright;
}

/* Splits a row; its split pixels go to `at`. Returns how many they are. */
static int split_row(const struct rf_splitter *splitter, int y, const struct scratch *s,
                     struct split *at)
{
    const struct rf_pixels *pixels = splitter->pixels;
    struct rf_surfaces *out = splitter->out;
    size_t row = (size_t)y * (size_t)pixels->width;
    uint64_t *possible_highlights =
        splitter->possible_highlights + rf_row_words(pixels->width) * (size_t)y;
    int n = 0;
    find_candidates(pixels, y, s);
    for (int x = next_candidate(s, -1, pixels->width); x < pixels->width;
         x = next_candidate(s, x, pixels->width)) {
        struct split *split = &at[n];
        float *share = &out->share[row + (size_t)x];
        if (!split_pixel(pixels, x, y, s, &split->near, &split->far, share))
            continue;
        if (may_be_highlight(splitter, split))
            possible_highlights[x / 64] |= (uint64_t)1 << x % 64;
        *share = rf_min_float(*share, 1);
        if (*share < 1)
            rf_far_mark(out, row + (size_t)x);
        split->x = x;
        n++;
    }
    return n;
}

/* What a thread works with for row y. */
static struct scratch scratch_of(const struct rf_splitter *s, int y, int thread)
{
    size_t row = s->pixels->stride;
    float *at = s->rows + row * N_ROWS * (size_t)thread;
    return (struct scratch){s->frame->context->kernels,
                            s->steps,
                            at,
                            rf_plane_row(s->pixels, s->darkest, y),
                            at + 2 * row,
                            at + 3 * row,
                            at + 4 * row,
                            at + 5 * row,
                            at + 6 * row,
                            (unsigned char *)(at + 7 * row),
                            s->is_alone,
                            s};
}

rf_result rf_split_begin(struct rf_splitter *s, struct rf_error *error)
{
    const struct rf_context *context = s->frame->context;
    size_t n_threads = (size_t)context->n_threads, n_rows = (size_t)s->pixels->height;
    size_t n = s->pixels->stride * N_ROWS * n_threads;
    for (int i = 0; i < RF_SPLIT_STEPS; i++)
        s->steps[i] = (i / RF_SIDES_AROUND - WINDOW) * s->pixels->width +
                      i % RF_SIDES_AROUND - WINDOW;
    s->arena = rf_arena_make(context, s->pixels->width, s->pixels->height);
    s->rows = rf_alloc(context, n, sizeof *s->rows);
    s->splits = rf_calloc(context, n_rows, sizeof *s->splits);
    s->rooms = rf_calloc(context, n_threads, sizeof *s->rooms);
    return s->rows && s->splits && s->rooms ? rf_far_begin(s->out, context, error)
                                            : rf_fail_memory(error, n, sizeof *s->rows);
}

bool rf_split_row(struct rf_splitter *s, int y, int thread)
{
    set_pure(s, y);
    if (!s->frame->params.split_edges)
        return true;
    struct scratch scratch = scratch_of(s, y, thread);
    struct rf_room *room = &s->rooms[thread];
    struct split *to =
        rf_arena_take(&s->arena, room, (size_t)s->pixels->width * sizeof *to);
    if (!to)
        return false;
    int n = split_row(s, y, &scratch, to);
    rf_arena_give_back(room, to + n);
    s->splits[y] = (struct rf_split_row){n, to};
    return true;
}

/* Keeps the radii of split pixels, while the plane has them as they came. */
static rf_result keep_radii(const struct rf_splitter *s, struct rf_error *error)
{
    const struct rf_context *context = s->frame->context;
    struct rf_pixels *pixels = s->pixels;
    size_t n_rows = (size_t)pixels->height + 1;
    size_t *row = pixels->split_row = rf_alloc(context, n_rows, sizeof *row);
    if (!row)
        return rf_fail_memory(error, n_rows, sizeof *row);
    row[0] = 0;
    for (int y = 0; y < pixels->height; y++)
        row[y + 1] = row[y] + (size_t)s->splits[y].n;
    size_t n = row[pixels->height];
    pixels->split = rf_alloc(context, n, sizeof *pixels->split);
    if (!pixels->split)
        return rf_fail_memory(error, n, sizeof *pixels->split);
    for (int y = 0; y < pixels->height; y++)
        for (int k = 0; k < s->splits[y].n; k++) {
            int x = s->splits[y].at[k].x;
            pixels->split[row[y] + (size_t)k] =
                (struct rf_split_radius){x, rf_plane_row(pixels, pixels->radius, y)[x]};
        }
    return RF_OK;
}

float rf_split_radius_at(const struct rf_pixels *p, int x, int y)
{
    size_t from = p->split_row[y], end = p->split_row[y + 1];
    while (from < end) {
        size_t middle = from + (end - from) / 2;
        if (p->split[middle].x < x)
            from = middle + 1;
        else
            end = middle;
    }
    return from < p->split_row[y + 1] && p->split[from].x == x
               ? p->split[from].r
               : rf_plane_row(p, p->radius, y)[x];
}

/* Puts the split pixels' parts in their places, and their radii in the plane. */
static void keep_split(void *data, int64_t begin, int64_t end, int thread)
{
    const struct rf_splitter *s = data;
    const struct rf_pixels *pixels = s->pixels;
    struct rf_surfaces *out = s->out;
    for (int y = (int)begin; y < (int)end; y++) {
        size_t row = (size_t)y * (size_t)out->width;
        for (int k = 0; k < s->splits[y].n; k++) {
            const struct split *p = &s->splits[y].at[k];
            size_t i = row + (size_t)p->x;
            out->near[i] = p->near;
            rf_plane_row(pixels, pixels->radius, y)[p->x] =
                out->share[i] > RF_OCCLUDER_SHARE ? p->near.r : INFINITY;
            if (out->share[i] < 1)
                *rf_far_at(out, i) = p->far;
        }
    }
}

rf_result rf_split_end(struct rf_splitter *s, struct rf_error *error)
{
    rf_result result = rf_far_allocate(s->out, s->frame->context, error);
    if (result != RF_OK)
        return result;
    if (s->keeps_radii)
        result = keep_radii(s, error);
    if (result != RF_OK)
        return result;
    s->out->near = s->pixels->at;
    s->pixels->at = NULL;
    rf_parallel(s->frame->context, s->out->height, RF_EQUAL_PARTS, keep_split, s);
    return RF_OK;
}

void rf_split_free(struct rf_splitter *s)
{
    const struct rf_context *context = s->frame->context;
    rf_arena_free(&s->arena);
    rf_free(context, s->rooms);
    rf_free(context, s->splits);
    rf_free(context, s->rows);
}
