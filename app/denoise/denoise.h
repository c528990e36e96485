/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Grain, taken out by Open Image Denoise (OIDN, version 1.4 or 2), which is loaded when
 * it is there: from the file or folder that the environment's RACKFOCUS_OIDN names,
 * else where the system looks for libraries.
 *
 * OIDN's results differ in the last bits between processors and versions, so those of
 * what comes after it do, too.
 */
#ifndef APP_DENOISE_H
#define APP_DENOISE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct denoiser;
struct image_error;
struct source;

/* Its filters, as Cycles names them. Times of all 32 filters of 8 views 1, 0.5, 0.4. */
#define DENOISE_QUALITIES "high|balanced|fast"
enum denoise_quality { DENOISE_HIGH, DENOISE_BALANCED, DENOISE_FAST };

/*
 * `library` is the file or folder to take where the environment names none, NULL where
 * the system is to look. NULL, with the error saying how to get the library, where
 * there is none.
 */
struct denoiser *denoiser_open(const char *library, enum denoise_quality quality,
                               int n_threads, struct image_error *error);
void denoiser_close(struct denoiser *denoiser);

/* Ends what denoises early, with an error, once another thread makes *stop true; NULL:
 * none does. */
void denoiser_stop_at(struct denoiser *denoiser, const bool *stop);

/* Noise-free or nearly so, of the picture's size, packed RGB; NULL: not known. */
struct denoise_guides {
    float *albedo; /* 0 to 1 */
    float *normal; /* of any space, -1 to 1 */
    bool are_clean;
};

/* Files of their own, as many renderers write; NULL: what lies beside the colour. */
struct denoise_files {
    const char *albedo, *normal;
};

/*
 * Reads the albedo and the normals beside the colour of a source, where it has them:
 * Blender's Denoising Albedo and Denoising Normal, Arnold's denoise_albedo and
 * denoise_normal, and layers named albedo and normal or N. `files` (may be NULL) have
 * them by such names, or as their only R G B or X Y Z. To be freed in any case.
 */
bool denoise_read_guides(const struct source *source, const struct denoise_files *files,
                         int n_threads, struct denoise_guides *guides,
                         struct image_error *error);
void denoise_free_guides(struct denoise_guides *guides);

/* Packed pixels of 1, 3 or 4 channels, the fourth alpha; `path` is for errors. */
struct denoise_picture {
    float *samples;
    int32_t width, height, n_channels;
    const char *path;
    float white; /* luminance that is shown as white, a power of two */
};

/*
 * Looks whether the grain of a picture is smeared over pixels (denoise_grain.h), and has
 * all that is denoised afterwards taken apart where it is: every second pixel of every
 * second row is a picture of its own, whose grain OIDN knows as such. Call it with samples
 * and guides as they were rendered. Worth 7.5 dB of 4 samples, 1.6 of 64
 * (docs/notebook/renderers.md).
 */
void denoise_judge_grain(struct denoiser *denoiser,
                         const struct denoise_picture *picture,
                         const struct denoise_guides *guides);

/*
 * Takes the grain out of the guides of a picture, in place, as Cycles does by default
 * ("Prefilter: Accurate"). For the host's own lens, whose albedo and normals have the
 * grain of the lens: worth 0 to 3 dB at 64 samples, 6 on a plain floor. Those of a
 * pinhole are better left alone (docs/notebook/rivals.md).
 */
bool denoise_clean_guides(struct denoiser *denoiser,
                          const struct denoise_picture *picture,
                          struct denoise_guides *guides, struct image_error *error);

/*
 * Takes the grain out of the colours of a picture, in place; alpha stays, and so does
 * the light of lamps (denoise_lamps.h). One with NaN or infinity is left as it is, for
 * the filter to refuse. `guides` may be NULL.
 */
bool denoise_picture(struct denoiser *denoiser, const struct denoise_picture *picture,
                     const struct denoise_guides *guides, struct image_error *error);

#endif
