/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Of a depth that was enlarged by repeating pixels whole columns and rows are the same as
 * those before them, each r-th differs, for an enlargement by r:
 *
 *   p_k = floor(c + k r)     the places where columns k and k + 1 differ
 *
 * A picture whose columns differ everywhere has r = 1; where flat things stand apart, the
 * places lie on no such line. Ours. Cost: one pass over the depth.
 */
#include "sources/depth_grid.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"

/* Pairs of lines that differ in less than this share of the mean are alike, but for some
 * pixels that were mended. */
static const double ALIKE = 0.02;

/* Larger enlargements are seen at a glance; fewer repeated lines lie so by chance. */
enum { MOST_TIMES = 4, FEWEST_REPEATED = 16 };

/* Of the places where lines differ; skies have none. */
static const double LEAST_SHARE = 0.8;

struct depth_grid {
    int32_t width, height, n_rows; /* rows at hand so far */
    size_t *columns, *rows;        /* pixels that differ from the next column, row */
    float *last;                   /* row */
};

struct depth_grid *depth_grid_create(int32_t width, int32_t height)
{
    struct depth_grid *grid = calloc(1, sizeof(*grid));
    if (!grid)
        return NULL;
    *grid = (struct depth_grid){.width = width, .height = height};
    grid->columns = calloc((size_t)width, sizeof(*grid->columns));
    grid->rows = calloc((size_t)height, sizeof(*grid->rows));
    grid->last = app_memory((size_t)width, sizeof(*grid->last), NULL);
    if (grid->columns && grid->rows && grid->last)
        return grid;
    depth_grid_free(grid);
    return NULL;
}

void depth_grid_free(struct depth_grid *grid)
{
    if (!grid)
        return;
    free(grid->columns);
    free(grid->rows);
    free(grid->last);
    free(grid);
}

void depth_grid_add(struct depth_grid *grid, const float *depth, int32_t n_rows)
{
    const int32_t width = grid->width;
    for (int32_t y = 0; y < n_rows && grid->n_rows < grid->height; y++) {
        const float *row = depth + (size_t)y * (size_t)width;
        for (int32_t x = 0; x + 1 < width; x++)
            grid->columns[x] += row[x] != row[x + 1];
        size_t n = 0;
        for (int32_t x = 0; x < width && grid->n_rows > 0; x++)
            n += row[x] != grid->last[x];
        if (grid->n_rows > 0)
            grid->rows[grid->n_rows - 1] = n;
        memcpy(grid->last, row, (size_t)width * sizeof(*row));
        grid->n_rows++;
    }
}

/* Lines that differ from the next, one after the other, and those that they lie on. */
struct stretch {
    int32_t first, last, n;
    bool is_even;
};

/* Looks from place `first` on, where lines differ, for as long as they do so often; at[i]
 * says whether they do. */
static struct stretch stretch_from(const bool *at, int32_t n, int32_t first)
{
    struct stretch found = {first, first, 1, true};
    for (int32_t i = first + 1; i < n && i - found.last <= MOST_TIMES; i++)
        if (at[i]) {
            found.last = i;
            found.n++;
        }
    const double times =
        found.n > 1 ? (double)(found.last - first) / (double)(found.n - 1) : 1;
    int32_t k = 0;
    for (int32_t i = first; i <= found.last; i++)
        if (at[i]) {
            const double off = (double)(i - first) - times * (double)k++;
            found.is_even = found.is_even && off <= 1 && off >= -1;
        }
    return found;
}

/* By how much an axis of n + 1 lines was enlarged; 1: not at all. */
static double times_of(const size_t *differ, bool *at, int32_t n)
{
    double mean = 0;
    int32_t n_all = 0, n_even = 0, length = 0, n_steps = 0;
    for (int32_t i = 0; i < n; i++)
        mean += (double)differ[i] / (double)n;
    for (int32_t i = 0; i < n; i++) {
        at[i] = differ[i] > 0 && (double)differ[i] > ALIKE * mean;
        n_all += at[i];
    }
    for (int32_t i = 0; i < n; i++) {
        if (!at[i])
            continue;
        const struct stretch found = stretch_from(at, n, i);
        const int32_t across = found.last - found.first;
        if (found.is_even && across + 1 - found.n >= FEWEST_REPEATED) {
            n_even += found.n;
            length += across;
            n_steps += found.n - 1;
        }
        i = found.last;
    }
    return n_steps > 0 && n_even >= LEAST_SHARE * n_all
               ? (double)length / (double)n_steps
               : 1;
}

bool depth_grid_find(const struct depth_grid *grid, int32_t *width, int32_t *height)
{
    const int32_t longer = grid->width > grid->height ? grid->width : grid->height;
    bool *at = app_memory((size_t)longer, sizeof(*at), NULL);
    if (!at)
        return false;
    const double across = times_of(grid->columns, at, grid->width - 1);
    const double down = times_of(grid->rows, at, grid->height - 1);
    free(at);
    *width = (int32_t)((double)grid->width / across + 0.5);
    *height = (int32_t)((double)grid->height / down + 0.5);
    return across > 1 && down > 1;
}
