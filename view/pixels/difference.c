/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/difference.h"

#include <stdlib.h>

#include "common/report.h"
#include "measure/measure.h"
#include "pixels/display.h"
#include "pixels/input.h"

static float *first_three(const float *pixels, int n_channels, size_t n)
{
    float *rgb = app_memory(n, 3 * sizeof(float), NULL);
    for (size_t i = 0; rgb && i < n; i++)
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] = pixels[i * (size_t)n_channels + (n_channels > 1 ? c : 0)];
    return rgb;
}

double difference_full_scale(const struct job *job)
{
    return HEAT_FULL_SCALE / (job->gain > 0 ? job->gain : 1);
}

void difference_show(const struct job *job, const float *pixels, struct shot *shot)
{
    const size_t n = (size_t)shot->width * (size_t)shot->height;
    const float *wanted = job->reference->picture.samples;
    float *rgb = first_three(pixels, job->input->n_channels, n);
    float *heat = app_memory(n, 3 * sizeof(float), NULL);
    if (rgb && heat) {
        measure_heatmap_to(rgb, wanted, shot->width, shot->height,
                           difference_full_scale(job), heat);
        display_encoded(heat, n, shot->rgba);
    }
    free(heat);
    free(rgb);
}

void difference_measure(const struct job *job, const float *pixels, struct shot *shot)
{
    const size_t n = (size_t)shot->width * (size_t)shot->height;
    float *rgb = first_three(pixels, job->input->n_channels, n);
    shot->n_views = job->reference->n_views;
    if (rgb)
        shot->tpsnr_db = measure_tpsnr(rgb, job->reference->picture.samples,
                                       shot->width, shot->height);
    free(rgb);
}
