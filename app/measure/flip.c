/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/stop.h"
#include "measure/measure.h"
#include "parallel.h"

#define PI 3.14159265358979323846

enum { RADIUS = 10, TAPS = 2 * RADIUS + 1 }; /* px of the widest kernel */

/* How the error of colour is spread over 0 to 1, section 4.3 of the paper. */
#define COLOUR_POWER 0.7
#define COLOUR_KNEE 0.4     /* of the largest error */
#define COLOUR_AT_KNEE 0.95 /* of the result */
#define FEATURE_POWER 0.5
#define FEATURE_DEGREES 0.082 /* width of edges and points, section 4.2.1 */

/* ---- colour ---------------------------------------------------------------------- */

/* Linear sRGB to CIE XYZ, exact, of the chromaticities in IEC 61966-2-1. */
static const double to_xyz[3][3] = {
    {10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382},
};

/* Its inverse. */
static const double to_rgb[3][3] = {
    {3.241003232976, -1.537398969489, -0.498615881996},
    {-0.969224252203, 1.875929983695, 0.041554226340},
    {0.055639419852, -0.204011206124, 1.057148977188},
};

static void multiply(const double matrix[3][3], const double from[3], double to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] =
            matrix[i][0] * from[0] + matrix[i][1] * from[1] + matrix[i][2] * from[2];
}

/* Relative to white: X, Y and Z of it are 1. */
static void rgb_to_relative(const double rgb[3], double relative[3])
{
    multiply(to_xyz, rgb, relative);
    for (int i = 0; i < 3; i++)
        relative[i] /= to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2];
}

/* The opponent space that is filtered: luminance, red to green, blue to yellow. */
static void rgb_to_opponent(const double rgb[3], double opponent[3])
{
    double w[3];
    rgb_to_relative(rgb, w);
    opponent[0] = 116 * w[1] - 16;
    opponent[1] = 500 * (w[0] - w[1]);
    opponent[2] = 200 * (w[1] - w[2]);
}

static void opponent_to_rgb(const double opponent[3], double rgb[3])
{
    double xyz[3];
    const double y = (opponent[0] + 16) / 116;
    const double relative[3] = {y + opponent[1] / 500, y, y - opponent[2] / 200};
    for (int i = 0; i < 3; i++)
        xyz[i] = relative[i] * (to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]);
    multiply(to_rgb, xyz, rgb);
}

static double lab_curve(double t)
{
    const double delta = 6.0 / 29;
    return t > delta * delta * delta ? cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
}

/* CIELAB with Hunt's adjustment: less colour where it is dark. */
static void rgb_to_hunt_lab(const double rgb[3], double lab[3])
{
    double w[3];
    rgb_to_relative(rgb, w);
    const double x = lab_curve(w[0]), y = lab_curve(w[1]), z = lab_curve(w[2]);
    lab[0] = 116 * y - 16;
    lab[1] = 0.01 * lab[0] * 500 * (x - y);
    lab[2] = 0.01 * lab[0] * 200 * (y - z);
}

/* Abasi et al. 2020: city blocks in lightness, straight in colour. */
static double hyab(const double a[3], const double b[3])
{
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}

/* ---- kernels --------------------------------------------------------------------- */

enum kernel {
    LUMINANCE,
    RED_GREEN,
    BLUE_YELLOW, /* a sum of two Gaussians, each of which is separable */
    BLUE_YELLOW_FINE,
    FEATURE_SMOOTH,
    FEATURE_EDGE,  /* first derivative of the Gaussian */
    FEATURE_POINT, /* second derivative */
    N_KERNELS,
};

struct kernels {
    double taps[N_KERNELS][TAPS];
    double fine_share; /* of BLUE_YELLOW_FINE in the sum of both */
    double largest;    /* error of colour: of green against blue */
};

/* Of the contrast sensitivity a sqrt(pi / b) exp(-pi^2 d^2 / b), d in degrees. */
static double set_sensitivity(double *taps, double b)
{
    return measure_gaussian(taps, RADIUS, sqrt(b / 2) / PI * FLIP_PIXELS_PER_DEGREE);
}

/* Positive taps sum to 1, negative ones to -1. */
static void set_balanced(double *taps)
{
    double plus = 0, minus = 0;
    for (int i = 0; i < TAPS; i++) {
        plus += fmax(taps[i], 0);
        minus -= fmin(taps[i], 0);
    }
    for (int i = 0; i < TAPS; i++)
        if (taps[i] != 0)
            taps[i] /= taps[i] > 0 ? plus : minus;
}

static void set_features(struct kernels *kernels)
{
    const double sigma = 0.5 * FEATURE_DEGREES * FLIP_PIXELS_PER_DEGREE;
    const int reach = (int)ceil(3 * sigma);
    for (int i = 0; i < TAPS; i++) {
        const double x = i - RADIUS;
        const double g = fabs(x) > reach ? 0 : exp(-x * x / (2 * sigma * sigma));
        kernels->taps[FEATURE_SMOOTH][i] = g;
        kernels->taps[FEATURE_EDGE][i] = -x * g;
        kernels->taps[FEATURE_POINT][i] = (x * x / (sigma * sigma) - 1) * g;
    }
    set_balanced(kernels->taps[FEATURE_SMOOTH]);
    set_balanced(kernels->taps[FEATURE_EDGE]);
    set_balanced(kernels->taps[FEATURE_POINT]);
}

/* Table 1 of the paper. */
static void set_kernels(struct kernels *kernels)
{
    static const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    double lab_green[3], lab_blue[3];
    set_sensitivity(kernels->taps[LUMINANCE], 0.0047);
    set_sensitivity(kernels->taps[RED_GREEN], 0.0053);
    const double wide = set_sensitivity(kernels->taps[BLUE_YELLOW], 0.04);
    const double fine = set_sensitivity(kernels->taps[BLUE_YELLOW_FINE], 0.025);
    const double of_wide = 34.1 * sqrt(PI / 0.04) * wide * wide;
    const double of_fine = 13.5 * sqrt(PI / 0.025) * fine * fine;
    kernels->fine_share = of_fine / (of_wide + of_fine);
    set_features(kernels);
    rgb_to_hunt_lab(green, lab_green);
    rgb_to_hunt_lab(blue, lab_blue);
    kernels->largest = pow(hyab(lab_green, lab_blue), COLOUR_POWER);
}

/* ---- filtering ------------------------------------------------------------------- */

/* One picture: luminance, red to green and blue to yellow, a plane each. */
struct observed {
    float *plane[3];
};

struct comparison {
    struct kernels kernels;
    const float *rgb[2];
    struct observed observed[2];
    int32_t width, height;
    double *row_sums; /* FLIP of each row */
    bool *is_done;    /* rows that had memory */
    const bool *stop;
};

enum made {
    MADE_COLOUR, /* three */
    MADE_EDGE_X = 3,
    MADE_EDGE_Y,
    MADE_POINT_X,
    MADE_POINT_Y,
    MADE_FINE,
    N_MADE,
};

/* Where a row is filtered. */
struct lines {
    double *column; /* filtered from above, RADIUS copies of either end */
    double *made[N_MADE];
};

static int32_t clamp(int32_t i, int32_t n)
{
    return i < 0 ? 0 : i < n ? i : n - 1;
}

/* Row y of a plane, by one kernel down and one along; borders repeat. */
static void filter_row(const struct comparison *c, const float *plane, int32_t y,
                       enum kernel down, enum kernel along, double *column, double *out)
{
    const int32_t width = c->width;
    memset(column, 0, (size_t)(width + 2 * RADIUS) * sizeof *column);
    for (int i = 0; i < TAPS; i++) {
        const double tap = c->kernels.taps[down][i];
        const float *row =
            plane + (size_t)clamp(y + i - RADIUS, c->height) * (size_t)width;
        for (int32_t x = 0; x < width; x++)
            column[x + RADIUS] += tap * row[x];
    }
    for (int i = 0; i < RADIUS; i++) {
        column[i] = column[RADIUS];
        column[width + RADIUS + i] = column[width + RADIUS - 1];
    }
    memset(out, 0, (size_t)width * sizeof *out);
    for (int i = 0; i < TAPS; i++)
        for (int32_t x = 0; x < width; x++)
            out[x] += c->kernels.taps[along][i] * column[x + i];
}

static void filter_picture(const struct comparison *c, int picture, int32_t y,
                           const struct lines *to)
{
    static const struct {
        int plane;
        enum kernel down, along;
        int made;
    } steps[] = {
        {0, LUMINANCE, LUMINANCE, MADE_COLOUR},
        {1, RED_GREEN, RED_GREEN, MADE_COLOUR + 1},
        {2, BLUE_YELLOW, BLUE_YELLOW, MADE_COLOUR + 2},
        {2, BLUE_YELLOW_FINE, BLUE_YELLOW_FINE, MADE_FINE},
        {0, FEATURE_SMOOTH, FEATURE_EDGE, MADE_EDGE_X},
        {0, FEATURE_EDGE, FEATURE_SMOOTH, MADE_EDGE_Y},
        {0, FEATURE_SMOOTH, FEATURE_POINT, MADE_POINT_X},
        {0, FEATURE_POINT, FEATURE_SMOOTH, MADE_POINT_Y},
    };
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++)
        filter_row(c, c->observed[picture].plane[steps[i].plane], y, steps[i].down,
                   steps[i].along, to->column, to->made[steps[i].made]);
    const double share = c->kernels.fine_share;
    for (int32_t x = 0; x < c->width; x++)
        to->made[MADE_COLOUR + 2][x] =
            (1 - share) * to->made[MADE_COLOUR + 2][x] + share * to->made[MADE_FINE][x];
}

/* ---- the difference -------------------------------------------------------------- */

static void lab_at(const struct lines *lines, int32_t x, double lab[3])
{
    const double opponent[3] = {lines->made[MADE_COLOUR][x],
                                lines->made[MADE_COLOUR + 1][x],
                                lines->made[MADE_COLOUR + 2][x]};
    double rgb[3];
    opponent_to_rgb(opponent, rgb);
    for (int i = 0; i < 3; i++)
        rgb[i] = fmin(fmax(rgb[i], 0), 1);
    rgb_to_hunt_lab(rgb, lab);
}

/* 0 to 1 of both pictures filtered at x. */
static double colour_error(const struct comparison *c, const struct lines *lines,
                           int32_t x)
{
    double a[3], b[3];
    lab_at(&lines[0], x, a);
    lab_at(&lines[1], x, b);
    const double error = pow(hyab(a, b), COLOUR_POWER);
    const double knee = COLOUR_KNEE * c->kernels.largest;
    if (error < knee)
        return COLOUR_AT_KNEE / knee * error;
    return COLOUR_AT_KNEE +
           (error - knee) / (c->kernels.largest - knee) * (1 - COLOUR_AT_KNEE);
}

/* How much stronger one picture's edge or point is at x, 0 to 1. */
static double feature_error(const struct lines *lines, int32_t x)
{
    double edge[2], point[2];
    for (int i = 0; i < 2; i++) { /* 116: luminance from 0 to 1 */
        double *const *made = lines[i].made;
        edge[i] = hypot(made[MADE_EDGE_X][x], made[MADE_EDGE_Y][x]) / 116;
        point[i] = hypot(made[MADE_POINT_X][x], made[MADE_POINT_Y][x]) / 116;
    }
    const double most = fmax(fabs(edge[0] - edge[1]), fabs(point[0] - point[1]));
    return fmin(pow(most / sqrt(2), FEATURE_POWER), 1);
}

static void measure_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct comparison *c = data;
    struct lines lines[2];
    const size_t n = (size_t)c->width, n_column = n + 2 * RADIUS;
    double *memory = malloc((n_column + 2 * N_MADE * n) * sizeof *memory);
    for (int i = 0; memory && i < 2 * N_MADE; i++) {
        lines[i / N_MADE].column = memory;
        lines[i / N_MADE].made[i % N_MADE] = memory + n_column + (size_t)i * n;
    }
    for (int64_t y = begin; memory && y < end && !is_stopped(c->stop); y++) {
        filter_picture(c, 0, (int32_t)y, &lines[0]);
        filter_picture(c, 1, (int32_t)y, &lines[1]);
        double sum = 0;
        for (int32_t x = 0; x < c->width; x++)
            sum += pow(colour_error(c, lines, x), 1 - feature_error(lines, x));
        c->row_sums[y] = sum;
        c->is_done[y] = true;
    }
    free(memory);
}

static void observe_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct comparison *c = data;
    for (int64_t i = begin * c->width; i < end * c->width; i++)
        for (int p = 0; p < 2; p++) {
            double rgb[3], opponent[3];
            for (int k = 0; k < 3; k++)
                rgb[k] = fmin(fmax(c->rgb[p][3 * i + k], 0), 1);
            rgb_to_opponent(rgb, opponent);
            for (int k = 0; k < 3; k++)
                c->observed[p].plane[k][i] = (float)opponent[k];
        }
}

bool flip_measure(const float *a, const float *b, int32_t width, int32_t height,
                  double *flip, const bool *stop)
{
    struct comparison c = {
        .rgb = {a, b}, .width = width, .height = height, .stop = stop};
    const size_t n = (size_t)width * (size_t)height;
    float *planes = malloc(6 * n * sizeof *planes);
    c.row_sums = calloc((size_t)height, sizeof *c.row_sums);
    c.is_done = calloc((size_t)height, sizeof *c.is_done);
    bool is_good = planes && c.row_sums && c.is_done;
    if (is_good) {
        for (size_t i = 0; i < 6; i++)
            c.observed[i / 3].plane[i % 3] = planes + i * n;
        set_kernels(&c.kernels);
        os_parallel(0, height, 16, observe_rows, &c);
        os_parallel(0, height, 16, measure_rows, &c);
    }
    double sum = 0;
    for (int32_t y = 0; is_good && y < height; y++) {
        is_good = c.is_done[y];
        sum += c.row_sums[y];
    }
    free(c.is_done);
    free(c.row_sums);
    free(planes);
    *flip = sum / (double)n;
    return is_good;
}
