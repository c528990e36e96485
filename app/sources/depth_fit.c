/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the depth has a step, the picture mostly has an edge in the same place: the
 * contrast of the two pixels
 *
 *   g = abs(a - b) / (a + b)     a, b luminances
 *
 * is greater than those 2 and 3 px before and behind it. Of five such numbers one is the
 * greatest by chance at a fifth of the steps. References of eight scenes, views, grain of
 * 16 samples, fur: 40 to 79 % where the depth lies right, 17 to 30 % where it is upside
 * down, mirrored or both. Radii are linear in 1 / z, whatever kind of depth there is.
 * Ours. Cost: two passes over the radii.
 */
#include "sources/depth_fit.h"

#include <math.h>
#include <stdbool.h>

#include "common/luminance.h"

/* A step is that much of all radii, and so many times those on both sides of it, which
 * leaves slanted and curved surfaces out. */
static const float STEP_SHARE = 0.05F, STEP_TIMES = 3;
enum { REACH_PX = 3, FEWEST_STEPS = 500 };
static const double LEAST_SHARE = 0.33, LEAST_TIMES = 1.6;

/* Pixels along a row or a column. */
struct line {
    const struct depth_fit_picture *picture;
    bool is_column;
    int32_t at, length; /* the row or column; pixels in it */
};

static size_t pixel_of(const struct line *line, int32_t i)
{
    const size_t width = (size_t)line->picture->width;
    return line->is_column ? (size_t)i * width + (size_t)line->at
                           : (size_t)line->at * width + (size_t)i;
}

static float contrast(const struct line *line, int32_t i)
{
    const struct depth_fit_picture *picture = line->picture;
    const size_t n = (size_t)picture->n_channels;
    const float *a = picture->colour + n * pixel_of(line, i);
    const float *b = picture->colour + n * pixel_of(line, i + 1);
    const float la = fmaxf(luminance_of(a, picture->n_channels), 0);
    const float lb = fmaxf(luminance_of(b, picture->n_channels), 0);
    return la + lb > 0 ? fabsf(la - lb) / (la + lb) : 0;
}

static bool is_edge(const struct line *line, int32_t i)
{
    const float own = contrast(line, i);
    return own > contrast(line, i - 3) && own > contrast(line, i - 2) &&
           own > contrast(line, i + 2) && own > contrast(line, i + 3);
}

static float change(const struct line *line, int32_t i)
{
    const float *radii = line->picture->radii;
    return fabsf(radii[pixel_of(line, i)] - radii[pixel_of(line, i + 1)]);
}

/* Looks for an edge at a step, and where it would be if the depth were turned. */
static void add_step(struct depth_fit *fit, const struct line *line, int32_t i)
{
    const struct depth_fit_picture *picture = line->picture;
    const int32_t across = line->is_column ? picture->width : picture->height;
    const int32_t other_i = line->length - 2 - i, other_at = across - 1 - line->at;
    fit->n++;
    for (int turn = 0; turn < DEPTH_N_TURNS; turn++) {
        const bool is_flipped = turn == DEPTH_FLIPPED || turn == DEPTH_ROTATED;
        const bool is_mirrored = turn == DEPTH_MIRRORED || turn == DEPTH_ROTATED;
        struct line turned = *line;
        turned.at = (line->is_column ? is_mirrored : is_flipped) ? other_at : line->at;
        fit->n_edges[turn] += is_edge(
            &turned, (line->is_column ? is_flipped : is_mirrored) ? other_i : i);
    }
}

static void add_line(struct depth_fit *fit, const struct line *line, float least)
{
    for (int32_t i = REACH_PX; i + 1 + REACH_PX < line->length; i++) {
        const float own = change(line, i);
        if (own > least &&
            own > STEP_TIMES * (change(line, i - 1) + change(line, i + 1)))
            add_step(fit, line, i);
    }
}

void depth_fit_find(struct depth_fit *fit, const struct depth_fit_picture *picture)
{
    const size_t n = (size_t)picture->width * (size_t)picture->height;
    float low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        low = fminf(low, picture->radii[i]);
        high = fmaxf(high, picture->radii[i]);
    }
    const float least = STEP_SHARE * (high - low);
    for (int32_t y = 0; y < picture->height; y++)
        add_line(fit, &(struct line){picture, false, y, picture->width}, least);
    for (int32_t x = 0; x < picture->width; x++)
        add_line(fit, &(struct line){picture, true, x, picture->height}, least);
}

enum depth_turn depth_fit_turn(const struct depth_fit *fit)
{
    enum depth_turn best = DEPTH_UPRIGHT;
    for (int turn = 0; turn < DEPTH_N_TURNS; turn++)
        if (fit->n_edges[turn] > fit->n_edges[best])
            best = (enum depth_turn)turn;
    const double n_best = (double)fit->n_edges[best];
    return fit->n >= FEWEST_STEPS && n_best >= LEAST_SHARE * (double)fit->n &&
                   n_best >= LEAST_TIMES * (double)fit->n_edges[DEPTH_UPRIGHT]
               ? best
               : DEPTH_UPRIGHT;
}
