/* SPDX-License-Identifier: Apache-2.0 */
/* What the modules of the core share and nobody else sees. */
#ifndef RF_INTERNAL_H
#define RF_INTERNAL_H

#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "rackfocus/rackfocus.h"

#define RF_PI 3.14159265358979323846

/* ---- error.c ------------------------------------------------------------------- */

/* Fills `error` where it is not NULL and returns `code`. */
rf_result rf_fail(struct rf_error *error, rf_result code, const char *field,
                  const char *format, ...) __attribute__((format(printf, 4, 5)));

/* ---- params.c ------------------------------------------------------------------ */

/*
 * Parameters of a caller that was built with an older header, and knows fewer of them,
 * with the defaults for the rest.
 */
void rf_params_complete(struct rf_params *full, const struct rf_params *params);

/* ---- context.c ----------------------------------------------------------------- */

enum { RF_ALIGNMENT = 64 };

struct rf_block;

/* Memory that the context's pictures share, one after the other (pool.c). */
struct rf_pool {
    bool lock;
    struct rf_block *free;
    size_t total_bytes, used_bytes, peak_bytes; /* of blocks that may be kept */
};

struct rf_kernels;
struct rf_filter;
struct rf_shelf; /* footprint_shelf.c */

struct rf_context {
    struct rf_context_params params;
    int n_threads;
    const struct rf_kernels *kernels;
    struct rf_pool *pool;
    struct rf_shelf *shelf;
};

/* Gives back what the pool keeps; nothing of it is in use. */
void rf_pool_clear(const struct rf_context *context);

/* 64-byte aligned memory, not cleared; NULL where there is none. Size 0 gives memory.
 */
void *rf_alloc(const struct rf_context *context, size_t count, size_t size);
void *rf_calloc(const struct rf_context *context, size_t count, size_t size);
void rf_free(const struct rf_context *context, void *memory);
rf_result rf_fail_memory(struct rf_error *error, size_t count, size_t size);
void rf_log(const struct rf_context *context, enum rf_log_level level,
            const char *format, ...) __attribute__((format(printf, 3, 4)));

/* ---- aperture.c ---------------------------------------------------------------- */

/*
 * An aperture of unit size: a convex polygon (a disc has many corners) in lens
 * coordinates, u right and v up, that the footprint of a sample behind the focus has
 * when multiplied with its radius. Corners run counter-clockwise.
 */
enum { RF_DISC_CORNERS = 128, RF_MAX_CORNERS = RF_DISC_CORNERS + RF_MAX_VIEWS };

struct rf_shape {
    int n_corners;
    double corner[RF_MAX_CORNERS][2];
    bool is_disc; /* an ellipse with semi-axes 1/ratio and 1 */
    bool is_part; /* of an aperture, cut out by rf_shape_part() */
    double ratio;
    double size[2];      /* half width and half height of a box around it */
    double pixel_aspect; /* v is multiplied by it to get pixel rows */
    int min_lines;       /* v = const that a footprint is summed over */
};

void rf_shape_init(struct rf_shape *shape, const struct rf_params *params);
/* Is the lens point (u, v) inside? */
bool rf_shape_contains(const struct rf_shape *shape, double u, double v);
/* Half width and half height of the footprint, in px per px of radius. */
void rf_shape_extent(const struct rf_shape *shape, double extent[2]);
/*
 * The part of an aperture that is nearer to site j than to the other n sites (lens
 * coordinates), moved so that its centroid is the origin; `centroid` receives where it
 * was. Returns its area, shared among the sites at the same place; 0, and no part,
 * where it is empty.
 */
double rf_shape_part(const struct rf_shape *whole, double (*site)[2], int n, int j,
                     struct rf_shape *part, double centroid[2]);

/* Where the pixels at hand lie in the whole picture; of a whole one (0, 0). */
struct rf_place {
    int x, y, whole_width, whole_height; /* px */
};

/* ---- depth.c ------------------------------------------------------------------- */

/*
 * Signed radius in px of every pixel of `depth` (any of rf_depth) into `radius`, packed
 * width x height; with `planar` not NULL also the planar distance. `n_known` receives
 * how many depths are not infinite by a 0 alone; with NULL none at all is an error.
 * `largest` (or NULL) receives the greatest magnitude of a radius.
 */
rf_result rf_depth_to_radius(const struct rf_filter *filter,
                             const struct rf_image *depth, float *radius, float *planar,
                             int64_t *n_known, float *largest, struct rf_error *error);

/* RF_ERROR_DEPTH: all is infinite by a 0 alone, as in a channel without any depth. */
rf_result rf_fail_empty_depth(struct rf_error *error);

/*
 * One value of a depth channel at pixel (x, y): its planar distance, INFINITY where
 * nothing was hit, NAN where it cannot be a depth; *radius receives its signed radius.
 */
double rf_depth_of_value(const struct rf_params *params, const struct rf_lens *lens,
                         float value, int x, int y, float *radius);

/* ---- frame.c ------------------------------------------------------------------- */

/* Checks one view; `name` is the field in errors. */
rf_result rf_image_check(const struct rf_image *image, const char *name, int width,
                         int height, struct rf_error *error);

static inline const float *rf_image_at(const struct rf_image *image, int x, int y,
                                       int c)
{
    return (const float *)((const char *)image->data + (ptrdiff_t)y * image->row_bytes +
                           (ptrdiff_t)x * image->pixel_bytes +
                           (ptrdiff_t)c * image->channel_bytes);
}

/* Are the pixels RGBA quadruples, in the space that light is summed in? */
bool rf_image_is_plain(const struct rf_params *params, const struct rf_image *image);

/*
 * The colour of a view, unpacked to planes of width x height in the space in which
 * light is summed (blend gamma). Grey gives one plane, RGB three, RGBA four. `place`
 * is for errors; NULL: that of a whole picture.
 */
rf_result rf_frame_load(const struct rf_context *context,
                        const struct rf_params *params, const struct rf_image *colour,
                        const struct rf_place *place, float *planes[4],
                        struct rf_error *error);

/* One value of light in the space in which light is summed. */
float rf_to_blend_space(const struct rf_params *params, float v);

/* Can a value of that space be summed up? Not NaN, not infinite or nearly so. */
bool rf_is_light(const struct rf_params *params, float v);

/*
 * Copies plain pixels; false where they are not packed or not finite, or are the same,
 * which rf_frame_load() and rf_image_copy() know.
 */
bool rf_frame_copy(const struct rf_context *context, const struct rf_image *colour,
                   const struct rf_image *out);

/* Writes planes, rows of `stride` floats, to an image, undoing the blend gamma. */
void rf_frame_store(const struct rf_context *context, const struct rf_params *params,
                    float *const planes[4], size_t stride, const struct rf_image *out);

/* Copies pixels bit for bit between two views of the same size and channel count. */
void rf_image_copy(const struct rf_image *from, const struct rf_image *to);

/* ---- film.c -------------------------------------------------------------------- */

/* Is one of n pixels partly transparent and without depth, so that it needs that? */
bool rf_film_is_missing(const struct rf_filter *filter, const float *alpha,
                        const float *radius, int n);

/* Gives partly transparent pixels without depth that of a surface, as film_depth says.
 */
rf_result rf_film_fill(const struct rf_filter *filter, const float *alpha,
                       float *radius, bool *is_changed, struct rf_error *error);

/* ---- progress ------------------------------------------------------------------ */

/*
 * Progress over the phases of one method: fractions [from, to] of the whole. Worker
 * threads count finished tiles with rf_task_step(); the caller's thread reports.
 */
struct rf_task {
    const struct rf_progress *progress;
    double from, to; /* of the current phase */
    double last;     /* last fraction reported */
    int64_t n_steps; /* of the current phase */
    int64_t n_done;  /* atomic */
    int cancelled;   /* atomic */
};

void rf_task_begin(struct rf_task *task, const struct rf_progress *progress);
/* Reports 1. */
void rf_task_end(struct rf_task *task);
void rf_task_phase(struct rf_task *task, double to, int64_t n_steps);
/* Counts one tile; true while work goes on. Any thread. */
bool rf_task_step(struct rf_task *task);
/* Reports the last fraction again, if the caller's thread calls it; true while work
 * goes on. Any thread. */
bool rf_task_poll(struct rf_task *task);
bool rf_task_is_cancelled(const struct rf_task *task);

/* ---- filter.c, methods/ -------------------------------------------------------- */

struct rf_filter {
    const struct rf_context *context;
    struct rf_params params;
    struct rf_lens lens;
    struct rf_shape shape;
    int width, height; /* of the pixels at hand */
    struct rf_place place;
    struct rf_bokeh *bokeh; /* NULL until one is set */
};

/* One view, in the blend space. */
struct rf_work_view {
    float *colour[4];
    /* Instead of colours: plain pixels, whose rows are read where they are needed. */
    const struct rf_image *image;
    const float *radius;
    float lens[2]; /* where on the unit lens it was taken, u right and v up */
    /*
     * A point of radius r lies at (x, y) + (u, -v) (shift_scale r + shift_bias) in the
     * view, with (x, y) its place in the view of the lens' centre.
     */
    float shift_scale, shift_bias;
    const struct rf_survey *survey; /* of the whole picture; NULL: it is at hand */
};

rf_result rf_view_check_place(const struct rf_view *view, struct rf_error *error);

/* Sets where a view was taken: `lens` and `shift_*`. */
void rf_work_view_place(struct rf_work_view *w, const double lens_offset[2],
                        double shear_distance, const struct rf_lens *lens);

/*
 * A displacement to whole 128ths of a pixel. Sums of such are exact in all pictures
 * that there can be, so no place depends on where the window begins that it lies in.
 */
static inline float rf_snap_px(float v)
{
    static const float ROUND = 98304; /* 1.5 x 2^16, where floats are that far apart */
    return (v + ROUND) - ROUND;
}

/*
 * What a method gets: planes of colour (in the blend space) and the signed radius of
 * every pixel, width x height each, packed; it overwrites the colour with the result.
 * The methods of one view need only colour and radius, which are those of views[0].
 */
struct rf_work {
    const struct rf_filter *filter;
    int n_planes; /* 1, 3 or 4; the fourth is alpha */
    float *colour[4];
    size_t stride; /* floats between the rows of the result */
    /*
     * Plain pixels of the caller that the result may go to as soon as the views are
     * dropped; NULL: it is wanted in `colour`. Only layered and views write it, and
     * set is_stored.
     */
    const struct rf_image *out;
    bool is_stored;
    /* Of the planes, where they are the work's own: who loads them frees it. */
    float *memory;
    const float *radius;
    int n_views;
    struct rf_work_view *views;
    float largest_radius; /* of all views, without sign */
    /* Set by layered and views: an image is not so simple, and planes are needed. */
    bool needs_planes;
    struct rf_task *task;
};

/*
 * Loads view j from the caller's pixels to `memory`, which holds n_planes + 1 planes;
 * `n_known` as in rf_depth_to_radius(). A lone view that is sharp all over is only
 * copied where `out` is not NULL, and *is_copied then true.
 */
rf_result rf_work_load(struct rf_work *work, int j, const struct rf_view *view,
                       float *memory, int64_t *n_known, const struct rf_image *out,
                       bool *is_copied, struct rf_error *error);

/*
 * Gives work->memory back, for what comes after the views' planes. rf_composite_crop()
 * then gives the result planes of its own, in other memory.
 */
void rf_work_drop_views(struct rf_work *work);

/* A picture whose every radius is below this is its own blur: half a step of the
 * radius. */
static const float RF_SHARP_PX = 1.0f / 64;

/* One entry of the list of methods: see filter.c. */
struct rf_method_entry {
    struct rf_method_info info;
    rf_result (*run)(struct rf_work *work, struct rf_error *error);
    int max_views;
};

rf_result rf_layered_run(struct rf_work *work, struct rf_error *error);
rf_result rf_layered_preview_run(struct rf_work *work, struct rf_error *error);
/*
 * The preview straight from the caller's pixels, plain RGBA, to his, without the planes
 * of the picture: work->colour is not used. *is_done is false where the pixels are not
 * so simple: not finite, or partly transparent without depth.
 */
rf_result rf_layered_preview_stream(struct rf_work *work, const struct rf_image *from,
                                    const struct rf_image *to, bool *is_done,
                                    struct rf_error *error);
rf_result rf_scatter_run(struct rf_work *work, struct rf_error *error);
rf_result rf_views_run(struct rf_work *work, struct rf_error *error);
/* What a window of several views needs around it. */
struct rf_margin {
    int px;     /* how far a pixel of the result looks */
    int border; /* px that the whole picture is continued by */
    int level;  /* the coarsest */
};
/* `surface_px` is what splitting and highlights need, `hidden_px` what hidden.c does.
 */
rf_result rf_views_margin(struct rf_work *work, int surface_px, int hidden_px,
                          struct rf_margin *margin, struct rf_error *error);
rf_result rf_accumulate_run(struct rf_work *work, struct rf_error *error);

/* Index of the calling thread in its parallel region. */
int rf_thread_num(void);

/*
 * Asks for n > 0 floats which are read soon, so that nobody waits for them then. GCC
 * leaves out calls of functions that do nothing else: they are to be always inline.
 */
static inline __attribute__((always_inline)) void rf_fetch(const float *at, int n)
{
    for (int i = 0; i < n; i += 64 / (int)sizeof *at)
        __builtin_prefetch(at + i);
    __builtin_prefetch(at + n - 1);
}

static inline int rf_min_int(int a, int b)
{
    return a < b ? a : b;
}

static inline int rf_max_int(int a, int b)
{
    return a > b ? a : b;
}

/* fminf() and fmaxf() for numbers: without a call, b where a is NaN. */
static inline float rf_min_float(float a, float b)
{
    return a < b ? a : b;
}

static inline float rf_max_float(float a, float b)
{
    return a > b ? a : b;
}

/*
 * exp of the core: the C library's differs in the last bit between processors and
 * versions, and results must not. Relative error 4e-7 on [-80, 80].
 */
float rf_expf(float v);

static inline float rf_luminance(float r, float g, float b)
{
    return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

#endif
