/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How far two pictures are apart.
 *
 *   t(v)    tone mapped: clip(v, 0, 1)^(1/2.2)
 *   PSNR    -10 log10 mean (clip(a) - clip(b))^2, linear values, peak 1
 *   tPSNR   -10 log10 mean (t(a) - t(b))^2
 *   RMSE    sqrt mean (a - b)^2, linear values, not clipped
 *   energy  sum a / sum b, linear values, not clipped
 *   SSIM    Wang 2004 on t(a) and t(b): Gaussian window of 11 x 11, sigma 1.5, range 1,
 *           population covariance; per channel, then the mean over the channels. The
 *           border of 5 pixels is left out as in scikit-image; pictures smaller than
 *           the window are mirrored instead.
 *
 * All means run over pixels and over red, green and blue.
 */
#ifndef APP_MEASURE_H
#define APP_MEASURE_H

#include <stdbool.h>
#include <stdint.h>

struct measures {
    double psnr_db, tpsnr_db; /* INFINITY for identical pictures */
    double ssim;
    double rmse;
    double energy_ratio;  /* NAN where b is black */
    double max_error;     /* linear, over pixels and channels */
    int32_t max_x, max_y; /* its pixel, from the top left corner */
    int max_channel;
};

/* Packed RGB floats, width * height * 3 each; no NaN. False without memory, or where
 * another thread set `stop` (may be NULL), which ends it early. */
bool measure_pictures(const float *a, const float *b, int32_t width, int32_t height,
                      struct measures *measures, const bool *stop);

/* tPSNR alone, which takes a small part of the time; NAN without memory. */
double measure_tpsnr(const float *a, const float *b, int32_t width, int32_t height);

/* The tone mapped value that tPSNR and SSIM compare. */
double measure_tone(double value);

/*
 * A Gaussian, exp(-x^2 / (2 sigma^2)), scaled to a sum of 1: 2 radius + 1 taps, the
 * middle one at x = 0; `sigma` in taps, above 0. Returns the sum before the scaling.
 */
double measure_gaussian(double *taps, int radius, double sigma);

/* Errors from here on have the brightest colour of the heat map (tone mapped). */
#define HEAT_FULL_SCALE 0.25

/*
 * Heat map: the largest tone mapped error over the channels, from black over violet,
 * red and yellow to white. `rgb` is packed, in the encoding of the screen.
 */
void measure_heatmap(const float *a, const float *b, int32_t width, int32_t height,
                     float *rgb);

/* The same with the brightest colour for errors from `full_scale` on, above 0. */
void measure_heatmap_to(const float *a, const float *b, int32_t width, int32_t height,
                        double full_scale, float *rgb);

#endif
