/* SPDX-License-Identifier: Apache-2.0 */
#include "difference.h"

#include <stdlib.h>

#include "display.h"
#include "input.h"
#include "measure.h"
#include "report.h"

static float *first_three(const float *pixels, int n_channels, size_t n)
{
    float *rgb = app_memory(n, 3 * sizeof(float), NULL);
    for (size_t i = 0; rgb && i < n; i++)
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] = pixels[i * (size_t)n_channels + (n_channels > 1 ? c : 0)];
    return rgb;
}

void difference_show(const struct job *job, const float *pixels, struct shot *shot)
{
    const size_t n = (size_t)shot->width * (size_t)shot->height;
    const struct picture *reference = job->reference;
    float *rgb = first_three(pixels, job->input->n_channels, n);
    float *heat = app_memory(n, 3 * sizeof(float), NULL);
    struct measures measures;
    if (rgb && heat &&
        measure_pictures(rgb, reference->samples, shot->width, shot->height,
                         &measures)) {
        measure_heatmap(rgb, reference->samples, shot->width, shot->height, heat);
        display_encoded(heat, n, shot->rgba);
        shot->tpsnr_db = measures.tpsnr_db;
    }
    free(heat);
    free(rgb);
}
