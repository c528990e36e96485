/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/scopes.h"

#include <stddef.h>

#define MOST_PX 250000.0 /* some 1 ms */

static void count_px(struct scopes *s, const uint8_t *px, int column)
{
    int is_black = 0, is_white = 0;
    for (int c = 0; c < 3; c++) {
        s->histogram[c][px[c]]++;
        is_black |= px[c] == 0;
        is_white |= px[c] == 255;
    }
    s->black += is_black;
    s->white += is_white;
    const int luma = (54 * px[0] + 183 * px[1] + 19 * px[2]) / 256;
    s->waveform[column][luma * SCOPES_LEVELS / 256]++;
    s->n++;
}

static void find_most(struct scopes *s)
{
    for (int c = 0; c < 3; c++)
        for (int i = 1; i < 255; i++)
            s->most = s->histogram[c][i] > s->most ? s->histogram[c][i] : s->most;
    for (int x = 0; x < SCOPES_COLUMNS; x++)
        for (int y = 0; y < SCOPES_LEVELS; y++)
            s->most_waveform = s->waveform[x][y] > s->most_waveform ? s->waveform[x][y]
                                                                    : s->most_waveform;
}

void scopes_count(struct scopes *s, const uint8_t *rgba, int32_t width, int32_t height)
{
    int32_t step = 1;
    *s = (struct scopes){0};
    while ((double)width * height / ((double)step * step) > MOST_PX)
        step++;
    for (int32_t y = 0; y < height; y += step)
        for (int32_t x = 0; x < width; x += step)
            count_px(s, rgba + 4 * ((size_t)y * (size_t)width + (size_t)x),
                     (int)((int64_t)x * SCOPES_COLUMNS / width));
    find_most(s);
    s->black /= s->n > 0 ? s->n : 1;
    s->white /= s->n > 0 ? s->n : 1;
}
