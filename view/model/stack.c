/* SPDX-License-Identifier: Apache-2.0 */
#include "model/stack.h"

#include <math.h>
#include <string.h>

void stack_put_over(const float *top, float *bottom, size_t n, int n_channels)
{
    for (size_t i = 0; i < n; i++) {
        const float *over = top + 4 * i;
        float *at = bottom + (size_t)n_channels * i;
        const float alpha = fminf(fmaxf(over[3], 0), 1);
        for (int c = 0; c < n_channels; c++)
            at[c] = over[n_channels == 1 ? 0 : c] + (1 - alpha) * at[c];
    }
}

/* A row of half the width: means of two px. */
static void halve(const float *from, int32_t width, int n_channels, float *to)
{
    for (int32_t x = 0; x < width / 2; x++)
        for (int c = 0; c < n_channels; c++)
            to[x * n_channels + c] = 0.5f * (from[2 * x * n_channels + c] +
                                             from[(2 * x + 1) * n_channels + c]);
}

static void put_beside(float *left, const float *right, int32_t width, int n_channels)
{
    halve(left, width, n_channels, left); /* reads ahead of where it writes */
    halve(right, width, n_channels, left + (size_t)(width / 2) * (size_t)n_channels);
    if (width % 2)
        memset(left + (size_t)(width - 1) * (size_t)n_channels, 0,
               (size_t)n_channels * sizeof(float));
}

void stack_join_eyes(float *left, const float *right, int32_t width, int32_t height,
                     int n_channels, int32_t eyes)
{
    const size_t row = (size_t)width * (size_t)n_channels;
    if (eyes == EYES_RIGHT)
        memcpy(left, right, row * (size_t)height * sizeof(float));
    for (size_t i = 0; eyes == EYES_ANAGLYPH && i < row * (size_t)height; i++)
        if (n_channels < 3 || i % (size_t)n_channels != 0)
            left[i] = right[i];
    for (int32_t y = 0; eyes == EYES_BESIDE && y < height; y++)
        put_beside(left + (size_t)y * row, right + (size_t)y * row, width, n_channels);
}
