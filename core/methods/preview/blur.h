/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The real-time family: a generator, which blurs the picture, times a blend, which puts
 * the blurred picture and the sharp one together. A generator is one function of one
 * file and one line in methods.c, a blend one function of one file and one line in
 * preview.c.
 *
 * Pictures are packed pixels of four floats, so that a tap is one load; grey and RGB
 * leave lanes at zero. Work goes by bands of rows on all threads; every pixel is made
 * by the same sums whatever the number of threads.
 */
#ifndef RF_METHODS_PREVIEW_BLUR_H
#define RF_METHODS_PREVIEW_BLUR_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/context.h"
#include "base/math.h"
#include "base/task.h"
#include "input/frame.h"
#include "rackfocus/rackfocus.h"

typedef float rf_f4 __attribute__((vector_size(16)));

enum {
    RF_PIECE = 256,   /* rows are handed on in pieces of at most so many pixels */
    RF_BAND_ROWS = 16 /* what one thread does at a time */
};

struct rf_grid {
    int width, height;
    rf_f4 *at;
};

struct rf_blur;

/* Takes n <= RF_PIECE finished pixels from (x, y) on; they may be overwritten. Called
 * by any thread. */
typedef void (*rf_put_fn)(const struct rf_blur *blur, int x, int y, int n,
                          rf_f4 *pixels);

/* One run of a generator. */
struct rf_blur {
    const struct rf_frame *frame;
    struct rf_task *task;
    const struct rf_grid *source;
    const float *radius_map; /* per pixel, any sign; NULL: radius_px everywhere */
    float radius_px;
    double progress_from, progress_to;
    rf_put_fn put;
    void *user; /* of put */
};

/*
 * Blurs `source` by discs of the radius that `blur` says for each pixel, or something
 * with the same spread, and hands the pixels to blur->put, each once. Radius 0 is the
 * identity, a constant stays what it is, the picture is continued beyond its border.
 */
typedef rf_result (*rf_generator_fn)(const struct rf_blur *blur,
                                     struct rf_error *error);

/* Does the pieces [from, to) of a pass; `thread` counts the threads from 0. */
typedef void (*rf_band_fn)(void *user, int from, int to, int thread);

/* Runs `fn` over [0, n) in bands of `step`, as pass `pass` of `n_passes` of the blur.
 * Nothing more is done once the task is cancelled. */
void rf_blur_pass(const struct rf_blur *blur, int pass, int n_passes, int n, int step,
                  rf_band_fn fn, void *user);

bool rf_grid_alloc(const struct rf_context *context, struct rf_grid *grid, int width,
                   int height);

/* Pixels of planes to packed ones and back. */
void rf_pack(float *const planes[4], int n_planes, size_t at, int n, rf_f4 *pixels);

void rf_unpack(const rf_f4 *pixels, int n, float *const planes[4], int n_planes,
               size_t at);

/* put: straight into the planes of the struct rf_work that `user` points to. */
void rf_put_planes(const struct rf_blur *blur, int x, int y, int n, rf_f4 *pixels);

static inline rf_f4 rf_f4_of(float v)
{
    return (rf_f4){v, v, v, v};
}

/* Unlike fminf and fmaxf these become one instruction; no NaN comes here. */
static inline float rf_minf(float a, float b)
{
    return a < b ? a : b;
}

static inline float rf_maxf(float a, float b)
{
    return a > b ? a : b;
}

static inline int rf_clamp_int(int v, int least, int most)
{
    return rf_min_int(rf_max_int(v, least), most);
}

/* Absolute radii of n pixels from (x, y). */
static inline void rf_blur_radii(const struct rf_blur *blur, int x, int y, int n,
                                 float *radius)
{
    if (blur->radius_map) {
        const float *r =
            blur->radius_map + (size_t)y * (size_t)blur->source->width + (size_t)x;
        for (int i = 0; i < n; i++)
            radius[i] = fabsf(r[i]);
    } else {
        for (int i = 0; i < n; i++)
            radius[i] = fabsf(blur->radius_px);
    }
}

#endif
