/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The cells of the lens. A line v = const cuts the convex aperture, and every cell of
 * it, in one interval.
 */
#include "compose/lens_cells.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "base/math.h"
#include "kernels/data.h"
#include "lens/aperture.h"

enum { MAX_LINES = 4096, BLOCK = 128 /* of lines that are cut at a time */ };

/* What the edge from a to b leaves of the line v, if that reaches it. */
static void cut_edge(const double a[2], const double b[2], double v,
                     struct rf_interval *cut)
{
    double du = b[0] - a[0], dv = b[1] - a[1], rest = du * (v - a[1]);
    if ((v - a[1]) * (v - b[1]) > 0)
        return; /* there are many edges, and two of them count */
    double at = a[0] + rest / dv;
    if (fabs(dv) < 1e-12) {
        if (rest < 0)
            *cut = (struct rf_interval){0, 0};
    } else if (dv > 0) {
        cut->to = at < cut->to ? at : cut->to;
    } else {
        cut->from = at > cut->from ? at : cut->from;
    }
}

/* Where the line v cuts an aperture that no look has cut. */
static struct rf_interval cut_plain(const struct rf_shape *shape, double v)
{
    struct rf_interval cut = {-INFINITY, INFINITY};
    if (shape->is_disc) {
        double half = v * v < 1 ? sqrt(1 - v * v) / shape->ratio : 0;
        return (struct rf_interval){-half, half};
    }
    for (int i = 0; i < shape->n_corners; i++) {
        const double *a = shape->corner[i];
        const double *b = shape->corner[(i + 1) % shape->n_corners];
        double du = b[0] - a[0], dv = b[1] - a[1];
        /* Inside: du (v - a1) - dv (u - a0) >= 0. */
        double rest = du * (v - a[1]);
        if (fabs(dv) < 1e-12) {
            if (rest < 0)
                return (struct rf_interval){0, 0};
        } else if (dv > 0) {
            double at = a[0] + rest / dv;
            cut.to = at < cut.to ? at : cut.to;
        } else {
            double at = a[0] + rest / dv;
            cut.from = at > cut.from ? at : cut.from;
        }
    }
    return cut;
}

/* Where lines `first` to `end` - 1 of n cut the aperture. */
static void cut_lines(const struct rf_shape *shape, struct rf_interval range, int n,
                      int first, int end, struct rf_interval *cut)
{
    double step = (range.to - range.from) / n;
    for (int i = first; i < end; i++)
        cut[i - first] = shape->is_cut ? (struct rf_interval){-INFINITY, INFINITY}
                                       : cut_plain(shape, rf_line_at(range, i, n));
    bool has_edges = shape->is_cut && step > 0; /* else the doors left no area */
    for (int k = 0, next = 1; has_edges && k < shape->n_corners; k++, next++) {
        const double *a = shape->corner[k];
        const double *b = shape->corner[next < shape->n_corners ? next : 0];
        /* The lines that the edge may reach, and one more for what rounds. */
        double low = (fmin(a[1], b[1]) - range.from) / step - 1.5;
        double high = (fmax(a[1], b[1]) - range.from) / step + 0.5;
        for (int i = rf_max_int((int)low, first); i < end && i <= high; i++)
            cut_edge(a, b, rf_line_at(range, i, n), &cut[i - first]);
    }
}

void rf_shape_lines(const struct rf_shape *shape, struct rf_interval range, int n,
                    struct rf_interval *cut)
{
    cut_lines(shape, range, n, 0, n, cut);
}

/* The part of `cut` that is nearer to site c than to the others. */
struct rf_interval rf_lens_cell_line(const struct rf_lens_cells *cells, int c, double v,
                                     struct rf_interval cut)
{
    const double *s = cells->site[c];
    for (int d = 0; d < cells->n; d++) {
        const double *t = cells->site[d];
        double du = t[0] - s[0];
        double limit = 0.5 * (t[0] * t[0] + t[1] * t[1] - s[0] * s[0] - s[1] * s[1]) -
                       v * (t[1] - s[1]) + 0.5 * (cells->weight[c] - cells->weight[d]);
        if (d == c)
            continue;
        if (du > 0)
            cut.to = limit / du < cut.to ? limit / du : cut.to;
        else if (du < 0)
            cut.from = limit / du > cut.from ? limit / du : cut.from;
        else if (limit < 0)
            return (struct rf_interval){0, 0};
    }
    return cut;
}

struct rf_interval rf_shape_v_range(const struct rf_shape *shape)
{
    struct rf_interval range = {-1, 1};
    if (shape->is_disc)
        return range;
    range = (struct rf_interval){1, -1};
    for (int i = 0; i < shape->n_corners; i++) {
        range.from = fmin(range.from, shape->corner[i][1]);
        range.to = fmax(range.to, shape->corner[i][1]);
    }
    return range;
}

/* Lines of an aperture, and where they cut it. */
struct lines {
    double v[BLOCK], from[BLOCK], to[BLOCK];
};

/* Lines `first` to `first` + BLOCK - 1 of n. */
static void find_lines(struct lines *lines, const struct rf_shape *shape, int n,
                       int first)
{
    struct rf_interval range = rf_shape_v_range(shape), cut[BLOCK];
    cut_lines(shape, range, n, first, first + BLOCK, cut);
    for (int i = 0; i < BLOCK; i++) {
        lines->v[i] = rf_line_at(range, first + i, n);
        lines->from[i] = cut[i].from;
        lines->to[i] = cut[i].to;
    }
}

/*
 * How long each line is within cell c: as rf_lens_cell_line() says, to the bit, but line
 * beside line, of which the compiler takes several at a time.
 */
static void measure_lines(const struct rf_lens_cells *cells, int c,
                          const struct lines *lines, double *length)
{
    const double *s = cells->site[c], *v = lines->v;
    double from[BLOCK], to[BLOCK];
    memcpy(from, lines->from, sizeof from);
    memcpy(to, lines->to, sizeof to);
    for (int d = 0; d < cells->n; d++) {
        const double *t = cells->site[d];
        double du = t[0] - s[0], dv = t[1] - s[1];
        double middle = 0.5 * (t[0] * t[0] + t[1] * t[1] - s[0] * s[0] - s[1] * s[1]);
        double heavier = 0.5 * (cells->weight[c] - cells->weight[d]);
        if (d == c)
            continue;
        for (int i = 0; i < BLOCK && du > 0; i++) {
            double at = (middle - v[i] * dv + heavier) / du;
            to[i] = at < to[i] ? at : to[i];
        }
        for (int i = 0; i < BLOCK && du < 0; i++) {
            double at = (middle - v[i] * dv + heavier) / du;
            from[i] = at > from[i] ? at : from[i];
        }
        for (int i = 0; i < BLOCK && du == 0; i++)
            if (middle - v[i] * dv + heavier < 0)
                from[i] = to[i] = 0; /* what follows adds nothing to it */
    }
    for (int i = 0; i < BLOCK; i++)
        length[i] = to[i] - from[i] > 0 ? to[i] - from[i] : 0;
}

/* Adds the lines to the shares of cells, and to the total of all, as lengths. */
static void add_lines(struct rf_lens_cells *cells, const struct lines *lines,
                      double *total)
{
    double length[RF_MAX_CELLS][BLOCK];
    for (int c = 0; c < cells->n; c++)
        measure_lines(cells, c, lines, length[c]);
    for (int i = 0; i < BLOCK; i++)
        for (int c = 0; c < cells->n; c++) {
            cells->share[c] += length[c][i];
            *total += length[c][i];
        }
}

void rf_lens_cells_middle(const struct rf_lens_cells *cells,
                          const struct rf_shape *shape, double middle[][2])
{
    enum { N_LINES = 256 };
    const struct rf_interval range = rf_shape_v_range(shape);
    struct rf_interval cut[N_LINES];
    rf_shape_lines(shape, range, N_LINES, cut);
    for (int c = 0; c < cells->n; c++) {
        double area = 0, u = 0, v = 0;
        for (int i = 0; i < N_LINES; i++) {
            double at = rf_line_at(range, i, N_LINES);
            struct rf_interval part = rf_lens_cell_line(cells, c, at, cut[i]);
            double length = fmax(part.to - part.from, 0);
            area += length;
            u += length * (part.from + part.to) / 2;
            v += length * at;
        }
        middle[c][0] = area > 0 ? u / area : 0;
        middle[c][1] = area > 0 ? v / area : 0;
    }
}

/*
 * Two lie side by side, three around the middle, one on top: as floors slant down, that
 * gains 0.4 dB (plane) over Vogel's three, 0.02 to 0.05 elsewhere. Four around the middle
 * gain 0.2 (plane) and 0.05 (portrait), and lose 0.1 on a house and on looks.
 */
static void place_site(int i, int n, double site[2])
{
    const double low = sqrt(0.75);
    const double around[2][3][2] = {{{1, 0}, {-1, 0}},
                                    {{0, 1}, {-low, -0.5}, {low, -0.5}}};
    double rho = sqrt((i + 0.5) / n), theta = 2.399963 * i;
    bool is_around = n == 2 || n == 3;
    site[0] = is_around ? 0.5 * around[n - 2][i][0] : rho * cos(theta);
    site[1] = is_around ? 0.5 * around[n - 2][i][1] : rho * sin(theta);
}

void rf_lens_cells_init(struct rf_lens_cells *cells, const struct rf_shape *shape,
                        int n)
{
    *cells = (struct rf_lens_cells){.n = n};
    for (int i = 0; i < n && n > 1; i++) {
        place_site(i, n, cells->site[i]);
        for (int k = 0; k < 2; k++)
            cells->site[i][k] *= shape->size[k];
    }
    double total = 0;
    for (int first = 0; first < MAX_LINES; first += BLOCK) {
        struct lines lines;
        find_lines(&lines, shape, MAX_LINES, first);
        add_lines(cells, &lines, &total);
    }
    for (int c = 0; c < n; c++)
        cells->share[c] /= total;
}

/*
 * Weighs cells until their shares are those of `plain` within 1 % of one: weights take a
 * part of what is lacking, `step` times the area. False: they do not settle.
 */
static bool settle(struct rf_lens_cells *cells, const struct lines *lines, double area,
                   const struct rf_lens_cells *plain, double step, int n_rounds)
{
    static const double CLOSE = 0.01;
    for (int i = 0; i < n_rounds; i++) {
        double worst = 0, total = 0;
        memset(cells->share, 0, sizeof cells->share);
        add_lines(cells, lines, &total);
        for (int c = 0; c < plain->n; c++) {
            double lack = plain->share[c] - cells->share[c] / total;
            worst = fmax(worst, fabs(lack) / plain->share[c]);
            cells->weight[c] += step * lack * area;
        }
        if (worst < CLOSE)
            return true;
    }
    return false;
}

/*
 * Sites move as the shape's extent does; then the weights settle. Where a look has made
 * the lens narrow, sites lie close and weights overshoot: cells had up to four times the
 * light of others (astigmatism 0.5, swirl -0.5), so steps are halved until they settle.
 */
void rf_lens_cells_follow(struct rf_lens_cells *cells, const struct rf_shape *shape,
                          const struct rf_lens_cells *plain, double variance[2][2])
{
    enum { ROUNDS = 24, HALVINGS = 5 };
    double step = 0.7, middle[2], area = rf_shape_area(shape, middle);
    struct lines lines;
    *cells = *plain;
    if (plain->n == 1)
        return;
    for (int c = 0; c < plain->n; c++)
        for (int k = 0; k < 2; k++)
            cells->site[c][k] *= sqrt(variance[1][k] / variance[0][k]);
    find_lines(&lines, shape, BLOCK, 0);
    for (int i = 0; i <= HALVINGS; i++, step /= 2) {
        memcpy(cells->weight, plain->weight, sizeof cells->weight);
        if (settle(cells, &lines, area, plain, step, ROUNDS << i))
            break;
    }
    memcpy(cells->share, plain->share, sizeof cells->share);
}

/* Variance of u and v over the aperture. */
void rf_shape_line_variance(const struct rf_shape *shape, double variance[2])
{
    struct rf_interval range = rf_shape_v_range(shape), cuts[BLOCK];
    double area = 0, uu = 0, vv = 0;
    for (int line = 0; line < MAX_LINES; line++) {
        if (line % BLOCK == 0)
            cut_lines(shape, range, MAX_LINES, line, line + BLOCK, cuts);
        struct rf_interval cut = cuts[line % BLOCK];
        double v = rf_line_at(range, line, MAX_LINES),
               length = fmax(cut.to - cut.from, 0);
        area += length;
        vv += length * v * v;
        uu += length * (cut.from * cut.from + cut.from * cut.to + cut.to * cut.to) / 3;
    }
    variance[0] = uu / area;
    variance[1] = vv / area;
}
