/* SPDX-License-Identifier: Apache-2.0 */
/* Writes a picture as PFM: a header and 32 bit floats, the lowest row first. */
#ifndef PFM_H
#define PFM_H

#include <stdbool.h>
#include <stdio.h>

static inline bool write_pfm(const char *name, const float *rgb, int width, int height)
{
    FILE *file = fopen(name, "wb");
    if (!file)
        return false;
    bool is_good = fprintf(file, "PF\n%d %d\n-1.0\n", width, height) > 0;
    const size_t n_row = 3 * (size_t)width;
    for (int y = height - 1; y >= 0 && is_good; y--)
        is_good = fwrite(rgb + n_row * (size_t)y, sizeof *rgb, n_row, file) == n_row;
    return fclose(file) == 0 && is_good;
}

#endif
