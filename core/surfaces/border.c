/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The surface at the border goes on with its radius there. Its light goes from that of
 * the edge pixel to the mean of what lies inside, mirrored, as fast as the picture
 * changes inwards: the best guess of a pixel is its mean and what the nearest known one
 * differs from it, times their correlation (docs/algorithm.md, "Border"). Light that is
 * to add up with that of other pictures is mirrored alone: a guess from what this picture
 * shows would differ from theirs.
 */
#include "surfaces/border.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "kernels/data.h"
#include "surfaces/border_outlines.h"
#include "surfaces/surfaces.h"

/* Pixels before such a step that may show both. */
enum { RIM = 2 };
/*
 * Brighter light is dimmed to that, unless half of the LAMP px beside it are nearly as
 * bright: a lamp that is cut by the border is no bar of light, and a sky beside a wall is
 * no lamp. What is nearer than the light does not count. Of all pixels that are looked
 * at, as it was once, a sky of 9 that fills less than half of a picture of 200 px came
 * out as 5 at the border.
 */
static const float LEAST_LIMIT = 1;
enum { LAMP = 48, ENOUGH = 4 };
static const float NEARER_PX = 2; /* of radius, as in bright_areas.c */
/* Pixels to each side, of which the mean is taken along the border. */
enum { TAPS = 4 };
/* Pixels of a line that are looked at: so many, or twice the continued width. */
enum { DEPTH = 48 };
/* Pairs of pixels that tell how far a line changes inwards. */
enum { PAIRS = 8 };

/* Distances that pixels of a line are compared at: 1, 2, 4 .. px. */
enum { N_DISTANCES = 8 };

/* Variance of luminance, of its square, that is none: rounding has a tenth of that. */
static const float FLAT = 1e-6f;

/* The pixels of one line, from the border inwards. */
struct line {
    int run;         /* pixels of the first one's surface */
    int first, last; /* lines beside it that begin on the same surface */
    float limit;     /* of luminance, beyond the border */
    float unit;      /* by which luminance is multiplied before it is squared */
    rf_quad edge;    /* the light of the first one, no brighter than the limit */
    int n_changes;
    /* Half of the mean square by which its pixels differ that are 1 << i px apart, each
     * times `unit`. */
    float change[N_DISTANCES];
};

/* What a line tells of the lines beside it, so many px beyond the border. */
struct taken {
    rf_quad light; /* mirrored */
    /* Its luminance, in the side's unit, the square of that, how much the line changes
     * inwards, and 1; of a line that does not tell 0 and 0. */
    rf_quad facts;
};

/* One side of the picture: lines of pixels that begin at its border. */
struct side {
    const struct rf_pixels *pixels;
    bool is_column;     /* are its lines columns? Else rows. */
    bool is_mirrored;   /* nothing but mirrored */
    int begin, n_lines; /* which */
    int edge, way;      /* a line's first pixel; 1 or -1, the way inwards */
    int depth;          /* pixels of a line that are looked at */
    int border;         /* pixels that are continued */
    int top, height;    /* rows of the frame */
    struct line *lines;
    float unit; /* the least of all lines */
    struct rf_border_radii radii;
    struct rf_outlines outlines;
    struct taken *scratch; /* n_scratch for each thread */
    int *seen;             /* lines: n_scratch for each thread */
    size_t n_scratch;
};

/* The pixel of a line: 0 the first, -1 that beyond the border. */
struct place {
    int x, y;
};

static struct place place_at(const struct side *s, int line, int i)
{
    int across = s->begin + line, along = s->edge + s->way * i;
    return s->is_column ? (struct place){across, along} : (struct place){along, across};
}

static struct rf_surface *surface_at(const struct side *s, struct place p)
{
    return s->pixels->at + (size_t)p.y * (size_t)s->pixels->width + p.x;
}

static float *value_at(const struct side *s, float *plane, struct place p)
{
    return rf_plane_row(s->pixels, plane, p.y) + p.x;
}

static float radius_at(const struct side *s, int line, int i)
{
    return *value_at(s, s->pixels->radius, place_at(s, line, i));
}

static int run_of(const struct side *s, int line)
{
    const float *radius = value_at(s, s->pixels->radius, place_at(s, line, 0));
    const ptrdiff_t step = s->radii.inwards;
    for (int i = 1; i < s->depth; i++)
        if (!rf_is_same_surface(radius[step * i], radius[step * (i - 1)]))
            return rf_max_int(i - RIM, 1);
    return s->depth;
}

static bool is_in_frame(const struct side *s, int row)
{
    return row >= s->top && row < s->top + s->height;
}

/*
 * Are more than half of a line's first n pixels brighter, but for what stands before the
 * first one and may hide more of its light? What continues the picture already is dimmed
 * as it is to be: of that a pixel is enough.
 */
static bool is_mostly_brighter(const struct side *s, int line, int n, float limit)
{
    const struct place first = place_at(s, line, 0);
    const float *radius = value_at(s, s->pixels->radius, first);
    const float *luminance = value_at(s, s->pixels->luminance, first);
    const ptrdiff_t step = s->radii.inwards;
    const float nearest = radius[0] - NEARER_PX;
    int n_seen = 0, n_brighter = 0;
    for (int i = 0; i < n; i++) {
        const bool is_seen = !(radius[step * i] < nearest);
        n_seen += is_seen;
        n_brighter += is_seen & (luminance[step * i] > limit);
    }
    const int enough = s->is_column || is_in_frame(s, line) ? ENOUGH : 1;
    return n_seen >= enough && n_brighter > n_seen / 2;
}

/* Two to four times the median luminance of a line's first pixels, or LEAST_LIMIT. */
static float limit_of(const struct side *s, int line)
{
    if (s->is_mirrored)
        return INFINITY;
    const int n = rf_min_int(s->depth, LAMP);
    float limit = LEAST_LIMIT;
    while (is_mostly_brighter(s, line, n, limit / 2))
        limit *= 2;
    return limit;
}

static float dimmed_at(const struct side *s, int line, int i)
{
    return rf_min_float(*value_at(s, s->pixels->luminance, place_at(s, line, i)),
                        s->lines[line].limit);
}

static float change_of(const struct side *s, int line, int apart)
{
    int n = s->lines[line].run - apart, n_pairs = rf_min_int(n, PAIRS);
    float sum = 0;
    for (int j = 0; j < n_pairs; j++) {
        int i = j * n / n_pairs;
        float d = dimmed_at(s, line, i + apart) - dimmed_at(s, line, i);
        d *= s->lines[line].unit;
        sum += d * d;
    }
    return sum / (float)(2 * n_pairs);
}

/* Where the light of pixel k beyond the border comes from, 1 the nearest. */
static int mirrored(int k, int run)
{
    int i = (k - 1) % (2 * run);
    return i < run ? i : 2 * run - 1 - i;
}

/* The light of a line, mirrored to pixel k beyond the border. */
static rf_quad mirrored_light(const struct side *s, int line, int k)
{
    const struct line *l = &s->lines[line];
    struct place from = place_at(s, line, mirrored(k, l->run));
    float luminance = *value_at(s, s->pixels->luminance, from);
    rf_quad c;
    memcpy(&c, surface_at(s, from)->c, sizeof c);
    if (luminance > l->limit) {
        float factor = l->limit / luminance;
        c *= (rf_quad){factor, factor, factor, 1};
    }
    return c;
}

static void look_inside(void *data, int64_t begin, int64_t end, int thread)
{
    const struct side *s = data;
    for (int i = (int)begin; i < (int)end; i++) {
        s->lines[i].run = run_of(s, i);
        s->lines[i].limit = limit_of(s, i);
        s->lines[i].unit =
            s->lines[i].limit > RF_MOST_TO_SQUARE ? RF_UNIT_TO_SQUARE : 1;
        s->lines[i].edge = mirrored_light(s, i, 1);
        s->lines[i].n_changes = 0;
        for (int k = 0; k < N_DISTANCES && 2 << k <= s->lines[i].run; k++)
            s->lines[i].change[s->lines[i].n_changes++] = change_of(s, i, 1 << k);
    }
}

static void find_neighbours(const struct side *s)
{
    struct line *lines = s->lines;
    int n = s->n_lines;
    for (int i = 0; i < n; i++)
        lines[i].first =
            i > 0 && rf_is_same_surface(radius_at(s, i, 0), radius_at(s, i - 1, 0))
                ? lines[i - 1].first
                : i;
    for (int i = n - 1; i >= 0; i--)
        lines[i].last = i < n - 1 && lines[i + 1].first <= i ? lines[i + 1].last : i;
}

/* Brings the changes of all lines to one unit. */
static void share_unit(struct side *s)
{
    s->unit = 1;
    for (int i = 0; i < s->n_lines; i++)
        s->unit = rf_min_float(s->unit, s->lines[i].unit);
    for (int i = 0; i < s->n_lines; i++)
        for (int k = 0; k < s->lines[i].n_changes && s->lines[i].unit > s->unit; k++)
            s->lines[i].change[k] *= s->unit * s->unit;
}

/* What a line tells `distance` px beyond the border, as a power of two, and pixel k. */
static struct taken take(const struct side *s, int line, int k, int distance)
{
    const struct line *l = &s->lines[line];
    const rf_quad c = mirrored_light(s, line, k);
    const float luminance = rf_luminance(c[0], c[1], c[2]) * s->unit;
    const bool tells = l->n_changes > 0;
    const float change =
        tells ? l->change[rf_min_int(distance, l->n_changes - 1)] : 0.0f;
    return (struct taken){c, {luminance, luminance * luminance, change, tells}};
}

/* What lines beside each other come to. */
struct along {
    struct taken sum;
    int n;
};

static struct along look_along(const struct side *s, int line, int step,
                               const struct taken *taken)
{
    const struct line *l = &s->lines[line];
    struct along a = {.n = 0};
    int from = line - TAPS * step, to = rf_min_int(line + TAPS * step, l->last);
    while (from < l->first)
        from += step;
    for (; from <= to; from += step) {
        a.sum.light += taken[from].light;
        a.sum.facts += taken[from].facts;
        a.n++;
    }
    return a;
}

/*
 * How much the pixel at the border tells of one beyond it: their correlation, 1 less the
 * change inwards over the variance along the border.
 */
static float correlation_of(const struct along *a)
{
    const rf_quad sum = a->sum.facts;
    float mean = sum[0] / (float)a->n, square = mean * mean;
    float variance = rf_max_float(sum[1] / (float)a->n - square, 0);
    if (sum[3] == 0)
        return 0;
    return rf_clamp01(1 - sum[2] / sum[3] / (variance + FLAT * (square + FLAT)));
}

/* The best guess of a pixel beyond the border, by lines that are `step` apart. */
static rf_quad guessed_light(const struct side *s, int line, int step,
                             const struct taken *taken)
{
    const struct along a = look_along(s, line, step, taken);
    const rf_quad mean = a.sum.light / (float)a.n;
    return mean + correlation_of(&a) * (s->lines[line].edge - mean);
}

/* Which pixel is this one or, where it lies beyond the border, does it go on from? */
static size_t source_at(const struct side *s, struct place p)
{
    size_t i = (size_t)p.y * (size_t)s->pixels->width + (size_t)p.x;
    return s->is_column || is_in_frame(s, p.y) ? i : s->pixels->source[i];
}

/* Gives pixel k beyond the border this light and the radius of the edge of a line. */
static void put_pixel(const struct side *s, int line, int k, int seen, rf_quad c)
{
    struct place to = place_at(s, line, -k);
    struct rf_surface *out = surface_at(s, to);
    memcpy(out->c, &c, sizeof out->c);
    out->r = radius_at(s, seen, 0);
    *value_at(s, s->pixels->luminance, to) = rf_luminance(c[0], c[1], c[2]);
    *value_at(s, s->pixels->radius, to) = out->r;
    if (s->pixels->source)
        s->pixels->source[(size_t)to.y * (size_t)s->pixels->width + (size_t)to.x] =
            source_at(s, place_at(s, seen, 0));
}

/* Continues all lines by the pixels begin + 1 to end beyond the border. */
static void continue_lines(void *data, int64_t begin, int64_t end, int thread)
{
    const struct side *s = data;
    struct taken *taken = s->scratch + s->n_scratch * (size_t)thread;
    int *seen = s->seen + s->n_scratch * (size_t)thread;
    for (int k = (int)begin + 1; k <= (int)end; k++) {
        int step = rf_max_int(rf_min_int(2 * k, s->border / 2), 1);
        int distance = 31 - __builtin_clz((unsigned)k); /* the power of two up to k */
        rf_outlines_at(&s->outlines, &s->radii, k, seen);
        for (int i = 0; i < s->n_lines; i++)
            taken[i] = take(s, i, k, distance);
        for (int i = 0; i < s->n_lines; i++)
            put_pixel(s, i, k, seen[i],
                      s->is_mirrored ? taken[seen[i]].light
                                     : guessed_light(s, seen[i], step, taken));
    }
}

static rf_result continue_side(const struct rf_context *context, struct side *s,
                               struct rf_error *error)
{
    const struct rf_pixels *p = s->pixels;
    const struct place first = place_at(s, 0, 0);
    const ptrdiff_t row = (ptrdiff_t)p->stride;
    s->radii = (struct rf_border_radii){.first = value_at(s, p->radius, first),
                                        .next = s->is_column ? 1 : row,
                                        .inwards = s->way * (s->is_column ? row : 1),
                                        .n_lines = s->n_lines,
                                        .depth = s->depth,
                                        .border = s->border};
    rf_result result = rf_outlines_find(&s->outlines, &s->radii, context, error);
    if (result != RF_OK)
        return result;
    rf_parallel(context, s->n_lines, RF_EQUAL_PARTS, look_inside, s);
    find_neighbours(s);
    share_unit(s);
    rf_parallel(context, s->border, RF_EQUAL_PARTS, continue_lines, s);
    rf_outlines_free(&s->outlines, context);
    return RF_OK;
}

/* Continues the lines at both ends where the n pixels from `first` on, of `size`, do not
 * reach. */
static rf_result continue_ends(const struct rf_context *context, struct side *s,
                               int first, int n, int size, struct rf_error *error)
{
    rf_result result = RF_OK;
    s->depth = rf_min_int(rf_max_int(2 * s->border, DEPTH), n);
    s->edge = first, s->way = 1;
    if (first > 0)
        result = continue_side(context, s, error);
    s->edge = first + n - 1, s->way = -1;
    if (result == RF_OK && first + n < size)
        result = continue_side(context, s, error);
    return result;
}

rf_result rf_border_continue(const struct rf_frame *frame,
                             const struct rf_pixels *pixels, int x0, int y0, int border,
                             struct rf_error *error)
{
    const struct rf_context *context = frame->context;
    const struct rf_params *params = &frame->params;
    struct side s = {.pixels = pixels,
                     .is_mirrored = !params->split_edges && !params->exact_highlights,
                     .border = border,
                     .top = y0,
                     .height = frame->height};
    s.n_scratch = (size_t)rf_max_int(frame->width, pixels->height);
    size_t n = s.n_scratch * (size_t)context->n_threads;
    s.lines = rf_alloc(context, s.n_scratch, sizeof *s.lines);
    s.scratch = rf_alloc(context, n, sizeof *s.scratch);
    s.seen = rf_alloc(context, n, sizeof *s.seen);
    bool is_complete = s.lines && s.scratch && s.seen;
    rf_result result =
        is_complete ? RF_OK : rf_fail_memory(error, n, sizeof *s.scratch);
    /* Up and down, and then all rows to the sides. */
    s.is_column = true, s.begin = x0, s.n_lines = frame->width;
    if (result == RF_OK)
        result = continue_ends(context, &s, y0, frame->height, pixels->height, error);
    s.is_column = false, s.begin = 0, s.n_lines = pixels->height;
    if (result == RF_OK)
        result = continue_ends(context, &s, x0, frame->width, pixels->width, error);
    rf_free(context, s.seen);
    rf_free(context, s.scratch);
    rf_free(context, s.lines);
    return result;
}
