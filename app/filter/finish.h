/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The host's own lens finished: its grainy render is denoised with our picture as a
 * guide, and our picture is kept where the grain does not contradict it.
 */
#ifndef APP_FINISH_H
#define APP_FINISH_H

#include <stdbool.h>
#include <stdint.h>

struct app_host;
struct image_error;
struct settings;

struct finish_options {
    const char *output;       /* EXR or PNG */
    const char *output_error; /* EXR, or NULL: the estimate of the error */
    const char *half; /* NULL: none; else `own` is of one half of the samples, and this
                         of the other half */
    const char *albedo_file, *normal_file; /* of `own`, or NULL: they lie beside it */
    int32_t
        samples;  /* of a pixel of `own`, and of `half`; 0: what the header says, else
                        at least 10 */
    int32_t type; /* as in struct filter_options, as the next */
    int32_t png_bits;
    int32_t quality; /* enum denoise_quality */
    /* The passes are so many times as large as `own`, as in struct filter_options; 0: they
     * are as large. */
    int32_t supersample;
    int32_t pixel_filter; /* of them, likewise, as the next */
    double pixel_filter_width;
    int32_t n_threads;
    const struct app_host *host;
};

/*
 * `own` was rendered with the lens. The guides are our picture, of its size, or passes
 * that our picture is made of as filter does with denoise: colour and depth, or several
 * views; `settings` is the lens for that. Without guides `own` is denoised by its
 * albedo and normals. An enum app_code.
 */
int finish_run(const struct finish_options *tool, struct settings *settings,
               const char *own, char *const *guides, int n_guides,
               struct image_error *error);

#endif
