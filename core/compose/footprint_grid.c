/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The weights of a footprint while it is built: Catmull-Rom's kernel and the box, and
 * lines of the aperture that they smooth.
 */
#include "compose/footprint_grid.h"

#include <math.h>
#include <stddef.h>

#include "base/math.h"

static double cubic(double t, double height)
{
    (void)height;
    t = fabs(t);
    if (t < 1)
        return (1.5 * t - 2.5) * t * t + 1;
    if (t < 2)
        return ((-0.5 * t + 2.5) * t - 4) * t + 2;
    return 0;
}

/* Antiderivative of cubic() that is 0 at -2 and 1 at 2. */
static double cubic_integral(double t)
{
    double s = fabs(t), v;
    if (s >= 2)
        return t < 0 ? 0 : 1;
    if (s < 1)
        v = ((0.375 * s - 2.5 / 3) * s * s + 1) * s;
    else
        v = (((-0.125 * s + 2.5 / 3) * s - 2) * s + 2) * s - 1.0 / 6;
    return t < 0 ? 0.5 - v : 0.5 + v;
}

static double box_integral(double t)
{
    return t < -0.5 ? 0 : t > 0.5 ? 1 : t + 0.5;
}

static double box(double t, double height)
{
    double half = 0.5 * fmax(height, 1e-6);
    return (box_integral(t + half) - box_integral(t - half)) / (2 * half);
}

/*
 * k, meant over a line's height where it is not smooth, and its antiderivative; per
 * enum rf_footprint_kind.
 */
const struct rf_footprint_kernel rf_footprint_kernels[RF_N_KINDS] = {
    [RF_SHARP] = {cubic, cubic_integral},
    [RF_POSITIVE] = {box, box_integral},
};

double *rf_grid_row(const struct rf_grid *g, int cell, int y)
{
    return g->weight +
           ((size_t)cell * (size_t)g->height + (size_t)y) * (size_t)g->width;
}

/* Two numbers of an array. */
typedef double two __attribute__((vector_size(16), aligned(8), may_alias));

/* Adds k times n numbers to others. */
static void add_times(double *out, const double *line, double k, int n)
{
    int x = 0;
    for (; x + 2 <= n; x += 2)
        *(two *)(out + x) += (two){k, k} * *(const two *)(line + x);
    if (x < n)
        out[x] += k * line[x];
}

void rf_grid_add_line(struct rf_grid *g, int cell, const struct rf_grid_line *line)
{
    const double from = line->from, to = line->to, y = line->y;
    int first = rf_max_int((int)floor(from - 0.5) - RF_KERNEL_REACH + 1, -g->reach_x);
    int last = rf_min_int((int)floor(to - 0.5) + RF_KERNEL_REACH, g->reach_x);
    /* Integrals are 1 before either end's kernel and 0 beyond it. */
    for (int x = first; x <= last; x++) {
        double center = x + 0.5;
        g->line[x + g->reach_x] =
            (x > to - 3.5 ? g->kernel->integral(to - center) : 1) -
            (x < from + 2.5 ? g->kernel->integral(from - center) : 0);
    }
    int row = (int)floor(y - 0.5) - RF_KERNEL_REACH + 1;
    for (int i = 0; i < 2 * RF_KERNEL_REACH; i++, row++) {
        double k = g->kernel->value(row + 0.5 - y, line->height) * line->weight;
        if (row < -g->reach_y || row > g->reach_y || k == 0)
            continue;
        double *out = rf_grid_row(g, cell, row + g->reach_y) + g->reach_x;
        add_times(out + first, g->line + first + g->reach_x, k, last - first + 1);
    }
}
