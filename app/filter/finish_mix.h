/* SPDX-License-Identifier: Apache-2.0 */
/* The host's own lens cleaned with our picture: the pixels of finish. */
#ifndef APP_FINISH_MIX_H
#define APP_FINISH_MIX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct denoiser;
struct image_error;

/* Packed pictures of one size, scene-linear RGB; all values finite. */
struct finish_picture {
    const float *own;    /* rendered with the lens */
    float *ours;         /* without grain; becomes the result */
    const float *albedo; /* of the own render, with its grain; NULL: not known */
    const float *normal; /* of any space, as the albedo */
    const float *apart;  /* half the difference of two halves of the own samples, whose
                            mean is `own`; NULL: not known */
    float *estimate; /* a channel, becomes the error that is left, of display values */
    int32_t width, height;
    int32_t
        n_samples; /* of a pixel of `own`, both halves; 0: not known, or at least 10 */
    float white;   /* luminance that is shown as white, a power of two */
    const char *name; /* of the own picture, for errors */
    const bool *stop; /* another thread makes it true to end this early; NULL: none */
};

/*
 * Two halves of the own samples, n values each: `own` becomes their mean and `half` half
 * their difference, for `apart`. False where they are the same: both are what they were.
 */
bool finish_join_halves(float *own, float *half, size_t n);

/* Gaussian mean of a plane in place, its edges repeated; `room` is as large; sigma up to
 * 16 px. */
void finish_smooth(const struct finish_picture *picture, float *plane, float *room,
                   double sigma);

/* False where the denoiser fails, memory is missing or it is stopped: `ours` is then no
 * result. */
bool finish_mix(struct denoiser *denoiser, const struct finish_picture *picture,
                struct image_error *error);

#endif
