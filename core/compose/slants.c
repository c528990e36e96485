/* SPDX-License-Identifier: Apache-2.0 */
#include "compose/slants.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/math.h"
#include "base/pool.h"
#include "compose/composer.h"
#include "compose/footprint.h"
#include "compose/lens_cells.h"
#include "compose/scene.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "rackfocus/rackfocus.h"

/*
 * No surface covers less or more of a cell than these parts of what it covers in the
 * middle: there the slope is hardly known.
 */
static const float LEAST_FACTOR = 0.3f, MOST_FACTOR = 3;

/*
 * What changes a factor by less is flat. 0.005 gains 0, 0.03 loses 0.02 dB; saves 1 %
 * of eight views.
 */
static const double LEAST_CHANGE = 0.02;

/* The slope of step i of one direction. */
static float slope_of_step(int i)
{
    float t = (float)i * RF_SLANT_STEP;
    return RF_SLANT_HALF * t / (1 - fabsf(t));
}

void rf_slant_slope(int slant, float slope[2])
{
    int i = slant + RF_MOST_SLANT;
    slope[0] = slope_of_step(i % RF_SLANT_ROW - RF_SLANT_STEPS);
    slope[1] = slope_of_step(i / RF_SLANT_ROW - RF_SLANT_STEPS);
}

static int step_of_slope(float slope)
{
    int i = (int)lrintf(slope / (RF_SLANT_HALF + fabsf(slope)) / RF_SLANT_STEP);
    return rf_min_int(rf_max_int(i, -RF_SLANT_STEPS), RF_SLANT_STEPS);
}

int rf_slant_of(const float slope[2])
{
    return step_of_slope(slope[1]) * RF_SLANT_ROW + step_of_slope(slope[0]);
}

bool rf_slants_init(struct rf_composer *c)
{
    const struct rf_footprints *f = c->footprints;
    const struct rf_lens_cells *cells = &f->zones.at[rf_zone_middle(&f->zones)].cells;
    const int n_row = cells->n + 1;
    double middle[RF_MAX_CELLS][2], most = 0;
    c->factors =
        rf_alloc(c->context, (size_t)RF_N_SLANTS * (size_t)n_row, sizeof *c->factors);
    if (!c->factors)
        return false;
    rf_lens_cells_middle(cells, f->shape, middle);
    for (int k = 0; k < cells->n; k++) { /* px right and down per px of radius */
        middle[k][0] += f->drift.slope[0];
        middle[k][1] = f->drift.slope[1] - middle[k][1] * f->shape->pixel_aspect;
        most = fmax(most, middle[k][0] * middle[k][0] + middle[k][1] * middle[k][1]);
    }
    most = sqrt(most); /* every libm has the same bits of it, but not of hypot() */
    c->least_slope = most > LEAST_CHANGE ? (float)(LEAST_CHANGE / most) : 1;
    for (int i = 0; i < RF_N_SLANTS; i++) {
        float *row = c->factors + n_row * i, slope[2];
        rf_slant_slope(i - RF_MOST_SLANT, slope);
        for (int k = 0; k < cells->n; k++) {
            double s = 1 + middle[k][0] * slope[0] + middle[k][1] * slope[1];
            row[k] = rf_min_float(rf_max_float((float)s, LEAST_FACTOR), MOST_FACTOR);
        }
        row[cells->n] = 1; /* of what all cells have in common */
    }
    return true;
}

bool rf_has_slants(const struct rf_composer *c, const struct rf_source *source)
{
    return c->canvas.n_cells > 1 && source->radius &&
           source == &c->scene->visible_source;
}

bool rf_slants_row(const struct rf_composer *c, const struct rf_source *source, int x,
                   int y, int n, int16_t out[RF_TILE_W])
{
    const int width = c->scene->width, height = c->scene->height;
    const float *rows[5];
    memset(out, 0, RF_TILE_W * sizeof *out);
    x -= source->x;
    y -= source->y;
    int from = rf_max_int(-x, 0), to = rf_min_int(width - x, n);
    if (y < 0 || y >= height || from >= to)
        return false;
    for (int i = 0; i < 5; i++) {
        int row = rf_min_int(rf_max_int(y + i - 2, 0), height - 1);
        rows[i] = source->radius + source->radius_stride * (size_t)row + x + from;
    }
    int16_t found[RF_TILE_W];
    bool is_any = c->kernels->find_slants(rows, c->least_slope, to - from, found);
    if (is_any)
        memcpy(out + from, found, (size_t)(to - from) * sizeof *out);
    return is_any;
}
