/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The real-time family: a generator, which blurs the picture, times a blend, which puts
 * the blurred picture and the sharp one together. A generator is one function of one
 * file and one line in core/filter.c, a blend one function of one file and one line in
 * preview.c.
 *
 * Pictures are packed pixels of four floats, so that a tap is one load; grey and RGB
 * leave lanes at zero. Work goes by bands of rows on all threads; every pixel is made
 * by the same sums whatever the number of threads.
 */
#ifndef RF_PREVIEW_H
#define RF_PREVIEW_H

#include "../internal.h"

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
    const struct rf_filter *filter;
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

rf_result rf_generate_box(const struct rf_blur *blur, struct rf_error *error);
rf_result rf_generate_lowres(const struct rf_blur *blur, struct rf_error *error);
rf_result rf_generate_mipmap(const struct rf_blur *blur, struct rf_error *error);
rf_result rf_generate_mipmap_offset(const struct rf_blur *blur, struct rf_error *error);
rf_result rf_generate_offset(const struct rf_blur *blur, struct rf_error *error);
rf_result rf_generate_recursive_offset(const struct rf_blur *blur,
                                       struct rf_error *error);

/* A frame on its way through a method of this family. */
struct rf_preview {
    struct rf_work *work;
    rf_generator_fn generate;
    struct rf_grid sharp;
    float radius_px; /* of the blurred copy in the blends region and slices */
};

typedef rf_result (*rf_blend_fn)(struct rf_preview *preview, struct rf_error *error);

rf_result rf_blend_coc(struct rf_preview *preview, struct rf_error *error);
rf_result rf_blend_region(struct rf_preview *preview, struct rf_error *error);
rf_result rf_blend_slices(struct rf_preview *preview, struct rf_error *error);

/* The methods: each generator with the blend that the parameters name. */
rf_result rf_box_run(struct rf_work *work, struct rf_error *error);
rf_result rf_lowres_run(struct rf_work *work, struct rf_error *error);
rf_result rf_mipmap_run(struct rf_work *work, struct rf_error *error);
rf_result rf_mipmap_offset_run(struct rf_work *work, struct rf_error *error);
rf_result rf_offset_run(struct rf_work *work, struct rf_error *error);
rf_result rf_recursive_offset_run(struct rf_work *work, struct rf_error *error);

/* ---- shared steps -------------------------------------------------------------- */

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

/*
 * How far each of n pixels from (x, y) is out of focus by the rules of a blend, 0 to 1.
 */
typedef void (*rf_alpha_fn)(const struct rf_preview *preview, const void *user, int x,
                            int y, int n, float *alpha);

/* One blurred copy, mixed into `base` (which is also where the result goes). */
struct rf_layer {
    struct rf_preview *preview;
    struct rf_grid *base; /* NULL: the sharp picture below, the result to the planes */
    const float *radius_map;
    float radius_px;
    rf_alpha_fn alpha;
    const void *alpha_user;
    double progress_from, progress_to;
};

/* leak.c: base += w (blurred - base), w as the parameters of leak control say. */
rf_result rf_layer_run(const struct rf_layer *layer, struct rf_error *error);

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
