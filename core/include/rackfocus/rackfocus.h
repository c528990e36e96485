/* SPDX-License-Identifier: Apache-2.0 */
/**
 * librackfocus: depth of field after the render.
 *
 * A pinhole render (colour and depth) goes in, the picture that the host's own lens
 * would have made comes out. Nothing here knows a host or a file format.
 *
 * The simple way:
 *
 *     struct rf_params params;
 *     rf_params_init(&params);
 *     params.focus_distance = 8;
 *     params.f_stop = 1.4;
 *     struct rf_error error;
 *     if (rf_apply(&params, &colour, &depth, &out, &error) != RF_OK)
 *         fprintf(stderr, "%s: %s\n", error.field, error.message);
 *
 * The way of a program that filters many frames: one rf_context (threads, allocator),
 * one rf_filter per size and set of parameters, rf_filter_process() per frame.
 *
 * Conventions. Pixel centres lie at +0.5, x to the right, y down. Lengths are scene
 * units unless a name ends in _px, _mm, _deg or _bytes. The **signed radius** of the
 * circle of confusion is in pixels (of the picture's width), positive behind the plane
 * in focus and negative before it. Colour is scene-linear, with premultiplied alpha
 * where there is an alpha.
 *
 * Threads. Contexts and filters are immutable and may be shared by any number of
 * threads. Results do not depend on the number of threads, the compiler or the
 * processor: the same input gives the same bits. There is no global state.
 *
 * Errors. Every function that can fail returns an rf_result and, where `error` is not
 * NULL, fills it with a message and the name of the offending field. On failure the
 * outputs are left untouched or, for pixels, undefined; nothing is leaked. Such a
 * function answers RF_ERROR_ARGUMENT to a NULL that it cannot do with; those that return
 * something else must not be given one, unless their comment allows it.
 *
 * Binaries. A program goes on working with a newer library of the same soversion, which
 * is the first number of the version, without being built again:
 * - functions, enum values and macros are added, and none is changed or removed;
 * - a struct with a member `size` grows at its end. What the library fills or reads of
 *   one ends where the caller's ends; of arrays of them size is the step from one to
 *   the next. Members that the caller does not know have their defaults;
 * - tables that the library gives (rf_param_list(), rf_method_list()) grow as well:
 *   rf_param_at() and rf_method_find() give their rows to programs that were built with
 *   an older header;
 * - all other structs never change: rf_error, rf_choice, rf_image, rf_window,
 *   rf_progress, rf_lens_point, rf_deep_sample, rf_deep, rf_depth_channel.
 * Before 1.0 the second number counts, too: 0.1 and 0.2 may differ in all of this.
 * "Since" says in which version something came; what says none is of 0.1.
 *
 * Since 0.1.
 */
#ifndef RACKFOCUS_RACKFOCUS_H
#define RACKFOCUS_RACKFOCUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "params_lists.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RF_VERSION_MAJOR 0 /**< of this header; rf_version() is the library's */
#define RF_VERSION_MINOR 1 /**< likewise */
#define RF_VERSION_PATCH 0 /**< likewise */

#if defined(_WIN32)
#define RF_API
#else
/** Marks what the library exports. */
#define RF_API __attribute__((visibility("default")))
#endif

/* ---- results ------------------------------------------------------------------- */

/** How a call ended. */
typedef enum rf_result {
    RF_OK = 0,              /**< all is done */
    RF_ERROR_ARGUMENT = 1,  /**< a NULL pointer or a malformed image view */
    RF_ERROR_PARAMETER = 2, /**< a parameter out of range or in conflict; see field */
    RF_ERROR_DEPTH = 3,     /**< NaN, negative or nothing but 0 depth */
    RF_ERROR_PIXEL = 4,     /**< NaN or infinity in the colour */
    RF_ERROR_MEMORY = 5,    /**< an allocation failed */
    RF_ERROR_CANCELLED = 6, /**< the progress callback returned false */
} rf_result;

/** What went wrong. Filled only on failure; plain text, no newline. */
struct rf_error {
    rf_result code;    /**< what the call returned */
    char field[48];    /**< parameter or argument at fault ("f_stop", "depth"), or "" */
    char message[256]; /**< one sentence that says what is wrong and the way out */
};

/** Short English name of a result, such as "out of memory". Never NULL. */
RF_API const char *rf_result_name(rf_result result);

/** Version of the library at run time, "0.1.0". */
RF_API const char *rf_version(void);

/* ---- parameters ---------------------------------------------------------------- */

#define RF_X_ENUM(constant, name, help) constant,
enum rf_sensor_fit { RF_LIST_SENSOR_FIT(RF_X_ENUM) };
enum rf_projection { RF_LIST_PROJECTION(RF_X_ENUM) };
enum rf_optics { RF_LIST_OPTICS(RF_X_ENUM) };
enum rf_aperture { RF_LIST_APERTURE(RF_X_ENUM) };
enum rf_orientation { RF_LIST_ORIENTATION(RF_X_ENUM) };
enum rf_depth { RF_LIST_DEPTH(RF_X_ENUM) };
enum rf_film_depth { RF_LIST_FILM_DEPTH(RF_X_ENUM) };
enum rf_method { RF_LIST_METHOD(RF_X_ENUM) };
enum rf_distribution { RF_LIST_DISTRIBUTION(RF_X_ENUM) };
enum rf_blend { RF_LIST_BLEND(RF_X_ENUM) };
enum rf_leak { RF_LIST_LEAK(RF_X_ENUM) };
enum rf_quality { RF_LIST_QUALITY(RF_X_ENUM) };
enum rf_stage { RF_LIST_STAGE(RF_X_ENUM) };
enum rf_direction { RF_LIST_DIRECTION(RF_X_ENUM) };
enum rf_lens_pattern { RF_LIST_LENS_PATTERN(RF_X_ENUM) };
enum rf_exposure { RF_LIST_EXPOSURE(RF_X_ENUM) };
#undef RF_X_ENUM

/**
 * All parameters; params.def documents each one (unit, range, default, help).
 * Always start with rf_params_init(). Members are only ever added at the end. A `size`
 * that no version had, or that is of a newer header than the library, which would leave
 * parameters out, is RF_ERROR_ARGUMENT, field "size", wherever parameters are taken.
 */
struct rf_params {
    size_t size; /**< sizeof(struct rf_params) of the caller; set by rf_params_init */
#define RF_FLOAT(key, field, attr, unit, min, max, def, group, rule, help) double field;
#define RF_INT(key, field, attr, unit, min, max, def, group, rule, help) int32_t field;
#define RF_BOOL(key, field, attr, def, group, rule, help) int32_t field;
#define RF_ENUM(key, field, attr, list, def, group, rule, help) int32_t field;
#include "params.def"
#undef RF_FLOAT
#undef RF_INT
#undef RF_BOOL
#undef RF_ENUM
};

/** Bytes of the longest text of rf_params_get(), its final zero with it. Since 0.1. */
enum { RF_PARAM_TEXT_BYTES = 64 };

/** Sets every parameter to its default. NULL is allowed: nothing is set. */
#define rf_params_init(params) rf_params_init_sized((params), sizeof(struct rf_params))
/** The same for a struct of `size` bytes; call rf_params_init(). */
RF_API void rf_params_init_sized(struct rf_params *params, size_t size);

/** What a parameter is: its member is a double or, of the others, an int32_t. */
enum rf_param_type {
    RF_TYPE_FLOAT, /**< a number */
    RF_TYPE_INT,   /**< a whole number */
    RF_TYPE_BOOL,  /**< 0 or 1 */
    RF_TYPE_ENUM,  /**< one of its choices */
};

/** Headings under which help and panels show parameters. */
enum rf_param_group {
    RF_GROUP_LENS,       /**< focus, f-stop, focal length, sensor, optics */
    RF_GROUP_APERTURE,   /**< shape of the bokeh */
    RF_GROUP_DEPTH,      /**< what the depth channel holds */
    RF_GROUP_METHOD,     /**< how the blur is made */
    RF_GROUP_HIGHLIGHTS, /**< light of the brightest, before the blur */
};

/** One choice of an enumerated parameter; its value is its index in the list. */
struct rf_choice {
    const char *name; /**< as rf_params_set() takes it */
    const char *help; /**< a few words */
};

/** Description of one parameter, straight from params.def. Static, never freed. */
struct rf_param_info {
    const char *key;           /**< "focus-distance" */
    const char *field;         /**< "focus_distance" */
    const char *attribute;     /**< name in an EXR header, "rackfocus:focusDistance" */
    const char *unit;          /**< "scene units"; "1": a number; "": bool, enum */
    const char *help;          /**< one sentence or two */
    enum rf_param_type type;   /**< of its member */
    enum rf_param_group group; /**< heading under which it is shown */
    size_t offset;             /**< of the member in struct rf_params, bytes */
    double min, max, def;      /**< both ends are allowed; its default */
    const struct rf_choice *choices; /**< enum only, else NULL */
    int n_choices;                   /**< enum only, else 0 */
};

/** All parameters in the order of params.def; *n receives their number. */
RF_API const struct rf_param_info *rf_param_list(size_t *n);

/** The i-th parameter in the order of params.def, or NULL beyond the last. Since 0.1. */
RF_API const struct rf_param_info *rf_param_at(size_t i);

/**
 * The parameter with this key or field name, or NULL. The picture's `squeeze` is another
 * name of pixel-aspect, here and wherever a name is taken.
 */
RF_API const struct rf_param_info *rf_param_find(const char *name);

/**
 * Sets one parameter from text ("2.8", "polygon", "true"). Numbers are decimal and read
 * in the C locale whatever the program's locale is.
 * RF_ERROR_PARAMETER: unknown name, not a number, out of range, no such choice; the
 * message lists the range or the choices.
 */
RF_API rf_result rf_params_set(struct rf_params *params, const char *name,
                               const char *text, struct rf_error *error);

/** Sets one numeric, bool or enum parameter from a number. Errors as rf_params_set. */
RF_API rf_result rf_params_set_number(struct rf_params *params, const char *name,
                                      double value, struct rf_error *error);

/**
 * Prints one parameter so that rf_params_set() reads the same value back. At most
 * `n_bytes` with the final zero; RF_PARAM_TEXT_BYTES are enough for every one.
 * RF_ERROR_PARAMETER: an unknown name, and `text` is as it was. RF_ERROR_ARGUMENT: it
 * does not fit, or `text` is NULL; a `text` of 1 byte and more is then "".
 */
RF_API rf_result rf_params_get(const struct rf_params *params, const char *name,
                               char *text, size_t n_bytes);

/** Checks every range and the combinations that need each other (blades 1 or 2, ...).
 */
RF_API rf_result rf_params_check(const struct rf_params *params,
                                 struct rf_error *error);

/**
 * Does a parameter, by key or field name, have any effect while the others are as they
 * are? On pictures, on the circles of confusion and limits that rf_lens_*() give or, of
 * the methods of several views, on the points of the lens. For hosts that warn of what
 * is not read, or grey it out. Where it is false and `why_not` is not NULL, *why_not
 * receives the reason, a static sentence without a full stop such as "read only with
 * projection orthographic"; else NULL. An unknown name or parameters that were not
 * begun with rf_params_init() are not read. Since 0.1.
 */
RF_API bool rf_param_is_read(const struct rf_params *params, const char *name,
                             const char **why_not);

/** Description of a method for lists and menus, and what it can do. */
struct rf_method_info {
    const char *name;   /**< as in --method */
    const char *help;   /**< one line */
    const char *cost;   /**< how the time grows, one line */
    const char *source; /**< paper or our own */
    /** Most views of one frame, 1 to RF_MAX_VIEWS; above 1 those of points of the lens.
     * Since 0.1. */
    int32_t max_views;
    /** false: views may come without, and any depth will do. Since 0.1. */
    bool needs_depth;
    /** Of the real-time family: reads blend, leak-control, ... Since 0.1. */
    bool has_blend;
    bool has_layers;     /**< reads quality, split-edges, fill-hidden, .. Since 0.1 */
    bool reads_aperture; /**< its blur has the aperture's shape. Since 0.1 */
    /** Can rf_filter_process_window(), but for what rf_filter_survey() names. Since 0.1. */
    bool can_window;
    bool can_deep; /**< can rf_filter_process_deep(). Since 0.1 */
};

/** All methods, in the order of enum rf_method. */
RF_API const struct rf_method_info *rf_method_list(size_t *n);

/** What an enum rf_method can do; NULL where there is no such method. Since 0.1. */
RF_API const struct rf_method_info *rf_method_find(int32_t method);

/* ---- optics -------------------------------------------------------------------- */

/**
 * A lens resolved for one picture size: everything that maps depth to a radius.
 *
 * Perspective: r = bias + scale / z with z the planar distance; orthographic:
 * r = bias + scale z. For the CG camera scale = -K and bias = K / s, r = K (1/s -
 * 1/z), K = lens radius times focal length in px (docs/algorithm.md).
 */
struct rf_lens {
    size_t size;    /**< sizeof(struct rf_lens) of the caller; set by rf_lens_init */
    double bias_px; /**< radius at infinity; orthographic: at the camera */
    double scale; /**< px times scene units (perspective), px per unit (orthographic) */
    double focus_distance;  /**< scene units */
    double lens_radius;     /**< scene units */
    double focal_length;    /**< scene units; 0 where the lens was given by radius */
    double focal_length_px; /**< perspective; 0 for orthographic */
    double px_per_unit;     /**< orthographic; 0 for perspective */
    double principal_px[2]; /**< where the axis meets the picture, x and y (down) */
    double max_radius_px;   /**< radii are clipped to this */
    double coc_limit_px;    /**< from the parameters */
    double screen_position; /**< scene units behind the lens, f s / (s - f); 0: none */
    /** Optics buffer: r = buffer_bias_px + buffer_scale_px d. */
    double buffer_scale_px;
    double buffer_bias_px; /**< px; see buffer_scale_px */
    int32_t projection;    /**< enum rf_projection */
    int32_t optics;        /**< enum rf_optics */
};

/**
 * Resolves the lens for a picture of width x height px, 1 to 65535 each.
 * RF_ERROR_PARAMETER names the field: a focus distance inside the focal length with a
 * real lens, depth_far not beyond depth_near with optics buffer, and so on.
 * RF_ERROR_ARGUMENT: the size of the picture or of a struct.
 */
#define rf_lens_init(lens, params, width, height, error)                               \
    rf_lens_init_sized((lens), sizeof(struct rf_lens), (params), (width), (height),    \
                       (error))
/** rf_lens_init() of a caller whose struct rf_lens has `size` bytes. Since 0.1. */
RF_API rf_result rf_lens_init_sized(struct rf_lens *lens, size_t size,
                                    const struct rf_params *params, int32_t width,
                                    int32_t height, struct rf_error *error);

/**
 * Signed radius in px of a point at planar depth z (scene units, > 0, may be INFINITY),
 * clipped to +-max_radius_px. NAN of NAN.
 */
RF_API double rf_lens_radius_px(const struct rf_lens *lens, double z);

/** Planar depth whose signed radius is r_px; INFINITY where there is none beyond; NAN of
 * NAN. */
RF_API double rf_lens_depth_at(const struct rf_lens *lens, double r_px);

/** Near and far limit of the depth of field: abs(r) <= coc_limit_px. Far may be
 * INFINITY. */
RF_API void rf_lens_depth_of_field(const struct rf_lens *lens, double *near_limit,
                                   double *far_limit);

/**
 * Hyperfocal distance: focusing there (same lens, same coc_limit_px) puts the far limit
 * at infinity. INFINITY for orthographic cameras, 0 for a pinhole.
 */
RF_API double rf_lens_hyperfocal(const struct rf_lens *lens);

/**
 * Where the screen of a real lens stands so that `focus_distance` is sharp, s = f d /
 * (d - f); all in one unit. NAN where focus_distance <= focal_length.
 */
RF_API double rf_screen_position(double focal_length, double focus_distance);

/* ---- points of the lens -------------------------------------------------------- */

/** Most points that rf_lens_points() gives. Since 0.1. */
#define RF_MAX_LENS_POINTS 1024

/** A view to render: where on the lens, and when. Since 0.1. */
struct rf_lens_point {
    /** Lens radii right and up of the middle, as the camera sees it; u at most 1 /
     * aperture_ratio, v at most 1, without sign. The eye goes there. */
    double u, v;
    /** Moment within the shutter's time, 0 (opens) to 1 (closes). Every n-th part of
     * it has one view, and moments do not follow the place on the lens. */
    double time;
};

/**
 * `n` points (2 to RF_MAX_LENS_POINTS) that share out the lens evenly, for views that
 * are averaged or merged. Of `params` it takes lens_pattern, lens_random, lens_seed,
 * method and the group aperture. The same arguments give the same points; `frame`, the
 * number of the frame, matters only with lens_random.
 *
 * Formulas, with i from 0 to n - 1 and g = 2.39996 (the golden angle):
 * - disc (Vogel 1979): radius sqrt((i + 1/2) / n), angle g i;
 * - circle: radius 1, angle 2 pi i / n;
 * - polygon: the disc's point, its radius and its place along the circle kept as those
 *   of the corners' triangles, so that equal areas hold equally many;
 * - two, three and four points of the disc or the polygon, unless the method is
 *   accumulate or lens_random is set: a ring of radius 0.5, 0.551, 0.6, the first at
 *   angle pi / 4, pi / 12, -atan(1 / 3); the rest of the lens is near to one of them;
 * - grid: about sqrt(n) rows of cells of equal area, a random place in each, mapped to
 *   the disc (Shirley and Chiu 1997), from there to the polygon where blades are given.
 * lens_random turns the disc's and the circle's points by a random angle, puts a random
 * number in place of the 1/2, and draws the grid's places and the moments anew.
 *
 * RF_ERROR_PARAMETER: n out of range (field "n"), or a bad parameter, such as a polygon
 * without blades. Since 0.1.
 */
RF_API rf_result rf_lens_points(const struct rf_params *params, int32_t n,
                                int32_t frame, struct rf_lens_point *points,
                                struct rf_error *error);

/* ---- images -------------------------------------------------------------------- */

/**
 * A view of 32 bit float pixels that the caller owns. Sample c of pixel (x, y) lies at
 * data + y * row_bytes + x * pixel_bytes + c * channel_bytes; every stride may be
 * negative (data then points at the first pixel all the same). Of an image that is read
 * a stride may be 0, as of a colour that is the same everywhere; of one that is written
 * only where there is one step (RF_ERROR_ARGUMENT). Rows may be padded; the padding is
 * neither read nor written.
 */
struct rf_image {
    void *data; /**< the first sample of the first pixel, aligned as floats are */
    int32_t width, height; /**< px, 1 to 65535 each */
    int32_t channels;      /**< colour: 1 (grey), 3 (RGB) or 4 (RGBA); depth: 1 */
    ptrdiff_t channel_bytes, pixel_bytes, row_bytes; /**< multiples of 4 */
};

/** View of tightly packed interleaved floats. */
RF_API struct rf_image rf_image_packed(float *data, int32_t width, int32_t height,
                                       int32_t channels);

/**
 * The same of pixels that are only read: no function writes to an image that it takes
 * as an input. Since 0.1.
 */
RF_API struct rf_image rf_image_input(const float *data, int32_t width, int32_t height,
                                      int32_t channels);

/* ---- context ------------------------------------------------------------------- */

/** How much a remark matters. */
enum rf_log_level {
    RF_LOG_INFO,    /**< what was done */
    RF_LOG_WARNING, /**< what the picture may suffer from */
};

/** How to run; zero means the default everywhere. */
struct rf_context_params {
    size_t size;       /**< sizeof(struct rf_context_params) */
    int32_t n_threads; /**< 0: as many as the process has processors; at most 1024 */
    /** Allocator: 64-byte aligned memory or NULL; both or neither must be set. */
    void *(*allocate)(void *user, size_t n_bytes);
    void (*release)(void *user, void *memory); /**< what `allocate` gave */
    /** Remarks such as "12 deep samples have an opacity above 1, the first at pixel (7,
     * 4): taken as 1"; NULL: silent. */
    void (*log)(void *user, enum rf_log_level level, const char *message);
    void *user; /**< handed to the callbacks */
    /**
     * Instruction set of the inner loops: "generic", "sse4", "avx2", "avx512", "neon" as
     * far as the machine has them. NULL or "": the best, but AVX-512 only when asked for.
     * All give the same bits. Unknown: RF_ERROR_PARAMETER, field "cpu". Since 0.1.
     */
    const char *cpu;
    /**
     * Most memory that filters of this context may hold at once, in blocks of 256 KiB
     * and more. Bytes, 0: no bound. What needs more fails with RF_ERROR_MEMORY. The
     * caller's pictures are not counted. Since 0.1.
     */
    size_t max_bytes;
    /**
     * The host's own threads in place of the context's: runs task(data, i) once for
     * every i from 0 to n_tasks - 1 and returns when all of them have returned. On
     * which threads, in which order and how many at once is the host's choice; what it
     * leaves out, the calling thread does after it. n_tasks: 2 to the number of
     * threads, n_threads or 0 for one per processor; the tasks share what there is to
     * do, and i, to which memory belongs, must not run twice at once. It is called on
     * the threads that call the library, on several at once where they do so, and never
     * from within a task. Progress is reported, and cancelling asked for, only while
     * the calling thread runs a task. Pictures are the same bits. NULL: threads of the
     * context's own, started when they are first needed, which sleep between pictures.
     * Since 0.1.
     */
    void (*parallel_for)(void *user, int32_t n_tasks,
                         void (*task)(void *data, int32_t index), void *data);
};

struct rf_context;

/** Makes a context; `params` may be NULL for the defaults. */
RF_API rf_result rf_context_create(struct rf_context **context,
                                   const struct rf_context_params *params,
                                   struct rf_error *error);
/** Frees a context whose filters are destroyed. NULL is allowed. */
RF_API void rf_context_destroy(struct rf_context *context);
/** Threads that its filters use at most, at least 1; fewer where the system gives none.
 */
RF_API int32_t rf_context_threads(const struct rf_context *context);

/**
 * Name of the instruction set that the inner loops use; see rf_context_params.cpu.
 * Static, never freed. Since 0.1.
 */
RF_API const char *rf_context_cpu(const struct rf_context *context);

/* ---- filter -------------------------------------------------------------------- */

struct rf_filter;

/**
 * Progress: called on the thread that called rf_filter_process(), with a fraction that
 * never falls, 0 first and 1 last. Returning false cancels; processing then ends after
 * the tiles in flight (each thread finishes at most one) with RF_ERROR_CANCELLED. The
 * picture is whole when 1 is reported: what is returned then is not looked at.
 */
struct rf_progress {
    bool (*report)(void *user, double fraction); /**< false cancels */
    void *user;                                  /**< handed to `report` */
};

/** Most views that the method `views` takes. */
#define RF_MAX_VIEWS 64

/**
 * Light of a view that its surfaces mirror or let through, with the depth of what is
 * seen in them. Since 0.1.
 */
struct rf_seen_light {
    /** A part of the view's colour, scene-linear: three channels, or one where the view
     * is grey. No NaN, no infinity. */
    struct rf_image colour;
    /**
     * One channel: the planar distance of what is seen, scene units, whatever
     * params.depth says: of a mirror the way from the camera to it and on to the thing,
     * along the axis. NAN or 0, or nearer than the surface: the light has the depth of
     * its surface. rf_filter_seen_depth() finds it.
     */
    struct rf_image depth;
};

/** Most seen lights of a view. Since 0.1. */
#define RF_MAX_SEEN 4

/** A light, one pixel large, that a picture does not show; see
 * rf_view.unseen_lights. Since 0.1. */
struct rf_unseen_light {
    /** Its place, px right and down from the picture's first pixel, a pixel's middle at
     * + 0.5; beyond the picture too. It is taken to the middle of its pixel. */
    double x, y;
    double
        depth; /**< planar distance, scene units, (0, inf], whatever params.depth is */
    float colour[4]; /**< of that pixel, as many as `colour` of the view has channels */
};

/** One pinhole view of the scene. */
struct rf_view {
    /** sizeof(struct rf_view) of the caller; of an array that of the first counts. 0: the
     * members of 0.1. */
    size_t size;
    struct rf_image
        colour; /**< scene-linear, alpha premultiplied; no NaN, no infinity; sums of
                     values beyond +-1e36 may overflow, so that no picture comes out */
    struct rf_image depth; /**< one channel, in the convention params.depth names */
    /** Where on the lens the view was taken, scene units right and up; 0 for one view.
     */
    double lens_offset[2];
    /** Distance of the plane that the view's shear keeps fixed; 0: parallel cameras. */
    double shear_distance;
    /**
     * What lies behind the visible surfaces, as other frames or a second layer show it:
     * colours like `colour`, and planar distances in scene units, whatever
     * params.depth says; NAN or 0 where nothing is known. It takes the place of
     * estimates (fill_hidden) where the lens looks behind something. Both data NULL: nothing
     * is known. Read by `layered` and `views`, but not by quality preview; windows
     * refuse it (RF_ERROR_ARGUMENT). Since 0.1.
     */
    struct rf_image behind_colour;
    struct rf_image behind_depth; /**< see behind_colour */
    /**
     * Lamps behind the visible surfaces or beyond the border, as other frames show
     * them: the lens sees a part of their discs. What the picture shows itself, what is
     * no highlight (exact_highlights) and what lies farther outside than the largest
     * radius is left out. Where there are any, behind_colour adds no lamps of its own.
     * Read by `layered`, but not by quality preview; windows refuse them
     * (RF_ERROR_ARGUMENT). NULL and 0: none are known. Since 0.1.
     */
    const struct rf_unseen_light *unseen_lights;
    size_t n_unseen_lights; /**< at most INT32_MAX / 4 */
    /**
     * What of the colour is seen in mirrors or through glass: each light is blurred by
     * its own depth, as if the mirror were a window into a dark room, and added to the
     * rest. Of several views each has the same lights in the same order, with depths of
     * its own; windows refuse them (RF_ERROR_ARGUMENT). Since 0.1.
     */
    const struct rf_seen_light *seen;
    int32_t n_seen; /**< 0 to RF_MAX_SEEN */
    /**
     * One channel: the mean planar distance over the samples of a pixel, as `colour` is
     * their mean, scene units, whatever params.depth says; a sample that hits nothing
     * counts as 0. It tells how large the parts of the two surfaces are that meet in a
     * pixel at an edge, where `depth` has one of both. NAN: not known there; data NULL:
     * nowhere. Read by `layered` and `views` with split_edges, but not by quality
     * preview, nor with tilt, field curvature or a split diopter of one view. Since 0.1.
     */
    struct rf_image mean_depth;
};

/** Builds a filter for pictures of width x height; checks every parameter. */
RF_API rf_result rf_filter_create(struct rf_filter **filter,
                                  const struct rf_context *context,
                                  const struct rf_params *params, int32_t width,
                                  int32_t height, struct rf_error *error);
/** Frees a filter that no thread uses any more. NULL is allowed. */
RF_API void rf_filter_destroy(struct rf_filter *filter);

/**
 * rf_filter_create() with the picture that `distribution` = image of the method scatter
 * spreads light by, of any size: the aperture as the camera sees it, or the bokeh of a
 * bright point behind the focus; before the focus it stands on its head. Its longer
 * side is the diameter of the circle of confusion, its middle the middle. One channel,
 * or three (each normalised, so that only the bokeh is coloured), or four, of which the
 * last is not looked at; scene-linear, not negative. The light of each channel adds up
 * to 1 whatever the numbers are. The picture is copied; NULL: there is none.
 * RF_ERROR_PIXEL: NaN, infinity, negative, or all black; RF_ERROR_ARGUMENT: a malformed
 * view. Since 0.1.
 */
RF_API rf_result rf_filter_create_with(struct rf_filter **filter,
                                       const struct rf_context *context,
                                       const struct rf_params *params, int32_t width,
                                       int32_t height,
                                       const struct rf_image *distribution,
                                       struct rf_error *error);

/** The lens that the filter uses. Valid as long as the filter. */
RF_API const struct rf_lens *rf_filter_lens(const struct rf_filter *filter);

/**
 * Filters one frame. `out` has the size and the channel count of the first view's
 * colour and may be the same view. `n_views` is 1 for the methods of one view. A
 * picture whose radii are all below 1/64 px is returned bit for bit, but for what tilt,
 * curvature, a split diopter, chroma, exposure and spherical aberration do to it.
 * `progress` may be NULL. RF_ERROR_DEPTH and RF_ERROR_PIXEL name the first bad pixel and the count.
 * Depth that is all infinite is all blurred; where 0 means infinite, nothing but 0 is
 * taken for an empty channel: RF_ERROR_DEPTH.
 */
RF_API rf_result rf_filter_process(const struct rf_filter *filter,
                                   const struct rf_view *views, int32_t n_views,
                                   const struct rf_image *out,
                                   const struct rf_progress *progress,
                                   struct rf_error *error);

/* ---- pictures larger than memory ----------------------------------------------- */

/** A rectangle of a picture, px from its top left pixel. */
struct rf_window {
    int32_t x, y, width, height; /**< first pixel and size, px */
};

enum { RF_SURVEY_FACTORS = 24 };

/**
 * What the windows of a picture must know of the whole: {.size = sizeof} at first, then
 * each pixel is counted once by rf_filter_survey(). Several views have one each, in an
 * array. Since 0.1.
 */
struct rf_survey {
    size_t size;          /**< sizeof(struct rf_survey) */
    float largest_radius; /**< px, without sign */
    double n_pixels;      /**< counted */
    double n_known;       /**< of the pixels given, those not infinite by a 0 alone */
    double n_transparent; /**< pixels whose alpha is not 1 */
    double disc_area[RF_SURVEY_FACTORS]; /**< px^2 of highlights, by threshold */
    double lens_offset[2];               /**< of the view, as in struct rf_view */
    double shear_distance;               /**< likewise */
    /** Of colours below 0 the least, as the method sees them: to params.blend_gamma, in
     * parts of the power of two next to params.white. 0: none is. */
    float least[3];
};

/**
 * How many px around `counted` rf_filter_survey() is to be given, where the picture
 * goes on.
 */
enum { RF_SURVEY_MARGIN = 96 };

/**
 * Counts the pixels of window `counted`, which lies within `given`, the window that
 * `view` shows of the filter's picture. The windows that are counted must not overlap
 * and together be the picture, in any order. The method must be `layered` or `views`,
 * not of quality preview. Memory: 24 bytes per pixel given. RF_ERROR_ARGUMENT: windows
 * outside of the picture or of each other, sizes that differ; RF_ERROR_PARAMETER:
 * another method, or what needs the whole picture at once (axial and lateral chroma, an
 * aperture in colour, a split diopter and, with `views`, tilt and field curvature);
 * RF_ERROR_DEPTH and RF_ERROR_PIXEL as rf_filter_process(), places
 * counted from the picture's first pixel. Since 0.1.
 */
RF_API rf_result rf_filter_survey(const struct rf_filter *filter,
                                  const struct rf_view *view,
                                  const struct rf_window *given,
                                  const struct rf_window *counted,
                                  struct rf_survey *survey, struct rf_error *error);

/**
 * Which window must be given for `kept` to come out with the bits that it has in the
 * whole picture: what can reach into it, its first pixel where the grids of the method
 * begin, cut off at the picture's edges. With R the largest radius times the aperture's
 * longer extent (at least 1), px, the margin is 6 R + 100 px and less than 212 + R for
 * R below 8 px, else less than 6 R + 84 and 4 R + 212, whichever is more; what the grid
 * adds is less than 64 px to the left, from 8 px on 16 R, and half of it
 * above. `surveys` are those of n_views views; with U how far the views move what is
 * blurred by R, along either axis, more than one of them need up to R + U px more, or
 * 6 R + 3 U + 100 if that is more; and up to 56 px more of pictures that are partly
 * transparent, whose film_depth is edges. RF_ERROR_ARGUMENT: the window, or a survey that has
 * not counted every pixel; RF_ERROR_DEPTH: every depth is 0; RF_ERROR_PARAMETER as
 * rf_filter_survey(). Since 0.1.
 */
RF_API rf_result rf_filter_window(const struct rf_filter *filter,
                                  const struct rf_survey *surveys, int32_t n_views,
                                  const struct rf_window *kept, struct rf_window *given,
                                  struct rf_error *error);

/**
 * Filters window `kept` of a picture: the views, in the order of their surveys, show
 * the window `given` that rf_filter_window() names, and `out` has the size of `kept`
 * and receives the same bits that rf_filter_process() gives for the whole picture. One
 * filter serves all windows, on any threads. Memory: rf_window_bytes(). Errors as
 * rf_filter_process() and rf_filter_window(). Since 0.1.
 */
RF_API rf_result rf_filter_process_window(
    const struct rf_filter *filter, const struct rf_survey *surveys,
    const struct rf_view *views, int32_t n_views, const struct rf_window *given,
    const struct rf_window *kept, const struct rf_image *out,
    const struct rf_progress *progress, struct rf_error *error);

/** What rf_window_bytes() counts. */
enum {
    RF_WINDOW_BYTES_PER_PIXEL = 320, /**< given, or continued beyond the edges */
    RF_WINDOW_BYTES_PER_VIEW = 128,  /**< per pixel, of each of several views */
    RF_WINDOW_BYTES = 32 << 20       /**< whatever the window is */
};

/**
 * Bytes that filtering a window takes: per pixel given and continued beyond the
 * picture's edges RF_WINDOW_BYTES_PER_PIXEL, for each of several views
 * RF_WINDOW_BYTES_PER_VIEW more, and RF_WINDOW_BYTES; what the context keeps from one
 * window to the next is in it. Pictures most of
 * whose pixels are edges or lights may take up to three times as much; a bound that is
 * kept is rf_context_params.max_bytes. Since 0.1.
 */
RF_API size_t rf_window_bytes(const struct rf_filter *filter,
                              const struct rf_survey *surveys, int32_t n_views,
                              const struct rf_window *given);

/* ---- deep frames --------------------------------------------------------------- */

/** One sample of a deep pixel: a surface, or a volume from depth to depth_back. */
struct rf_deep_sample {
    float depth;      /**< in the convention params.depth names */
    float depth_back; /**< the same; equal to depth or not farther: a surface */
    float colour[4];  /**< scene-linear, premultiplied; grey pictures use the first */
    /**
     * Share of what lies behind that it hides, [0, 1]. Of an ordinary sample equal to
     * its alpha; a holdout has it with colour and alpha 0. 0 with a colour only adds
     * light. Above 1, as pixel filters of renderers make it, counts as 1, which is
     * remarked to rf_context_params.log from 1.001 on; below 0, infinity and NaN are
     * RF_ERROR_PIXEL.
     */
    float opacity;
};

/**
 * A deep picture: the samples of pixel (x, y) are samples[first[i]] to before
 * samples[first[i + 1]], i = y width + x, in any order. What lies behind opaque samples
 * is used: it is what a lens sees around them.
 */
struct rf_deep {
    int32_t width, height;                /**< px, those of the filter */
    const size_t *first;                  /**< width * height + 1 offsets */
    const struct rf_deep_sample *samples; /**< first[width * height] of them */
};

/**
 * Filters one deep frame: every sample is spread on its own, near to far, and hides
 * what is behind it by its opacity. `out` is width x height with 1, 3 or 4 channels.
 * A volume is cut into slices of 1 px of radius, at most 16. The method must be
 * `layered`, whose parameters apply, but for the splitting of edges and the exact
 * highlights, which a deep frame does not need or have.
 *
 * A picture whose radii are all below 1/64 px gives rf_deep_flatten(), but with
 * spherical aberration, which glows there, too. RF_ERROR_DEPTH
 * and RF_ERROR_PIXEL name the first bad pixel and the count of bad samples;
 * RF_ERROR_PARAMETER: another method, tilt, field curvature, a split diopter, chroma or
 * an aperture in colour. Since 0.1.
 */
RF_API rf_result rf_filter_process_deep(const struct rf_filter *filter,
                                        const struct rf_deep *deep,
                                        const struct rf_image *out,
                                        const struct rf_progress *progress,
                                        struct rf_error *error);

/**
 * The flat picture: samples composited near to far. `colour` has 1, 3 or 4 channels.
 * `depth` (may be NULL) has one and gets the depth of the sample at which half of the
 * pixel is covered, else of the farthest, INFINITY (0 for the kinds of depth in which
 * that is infinitely far) where there is none. Errors as rf_filter_process_deep().
 */
RF_API rf_result rf_deep_flatten(const struct rf_filter *filter,
                                 const struct rf_deep *deep,
                                 const struct rf_image *colour,
                                 const struct rf_image *depth, struct rf_error *error);

/* ---- depth as renderers write it ----------------------------------------------- */

/** A depth channel in memory, packed row by row, and the colours beside it. Since 0.1. */
struct rf_depth_channel {
    float *depth;           /**< width * height numbers, as params.depth says */
    struct rf_image colour; /**< of the same pixels; data NULL: not known */
    int32_t width, height;  /**< px */
    double infinity;        /**< depth from here on means that nothing was hit */
};

/** What a depth channel looks like, and whether it can be used as it is. Since 0.1. */
struct rf_depth_stats {
    size_t size;              /**< sizeof(struct rf_depth_stats) of the caller */
    size_t n_pixels;          /**< all of them */
    size_t n_nan, n_negative; /**< NaN, below 0 */
    size_t n_no_hit;          /**< infinite, or from `infinity` on */
    size_t n_zero, n_one;     /**< exactly 0 and exactly 1 */
    double min, max, median;  /**< of what is finite, not negative, below infinity */
    double inner_median; /**< the same without exact 0 and 1; NAN: there are none */
    double mixed_share;  /**< of depth steps, those with averages between the sides */
    double premultiplied_share; /**< of part-covered pixels, those scaled by alpha */
    /** How much of the near side's colour the last pixel of a near depth has, that before
     * it, and the first of the far depth: means over depth steps in rows; NAN: too few */
    double near_shares[3];
    int32_t kind;            /**< enum rf_depth that fits best */
    const char *kind_reason; /**< why, half a sentence; static */
    bool is_mixed;           /**< a pixel filter averaged depths: see rf_depth_snap() */
    bool is_premultiplied;   /**< see rf_depth_divide_by_alpha() */
    bool is_widened; /**< near depth reaches over far colours: rf_depth_narrow() */
    size_t n_divided, n_snapped; /**< pixels that rf_depth_repair() has changed */
    size_t n_narrowed;           /**< likewise, those that showed what is behind */
    size_t n_holes;    /**< pixels without depth between two of one surface, in rows */
    double hole_share; /**< theirs of all pixels between two of one surface */
    bool is_speckled;  /**< holes are scattered over surfaces: rf_depth_fill() */
    size_t n_filled;   /**< pixels that rf_depth_repair() gave the depth of a surface */
};

/**
 * Looks at a depth channel. `context` (may be NULL) gives the memory. RF_ERROR_MEMORY;
 * RF_ERROR_ARGUMENT: a pointer is NULL, `stats` says no size, or the colours have not
 * the channel's. Since 0.1.
 */
RF_API rf_result rf_depth_measure(const struct rf_context *context,
                                  const struct rf_depth_channel *channel,
                                  struct rf_depth_stats *stats, struct rf_error *error);

/** Measures of a channel that comes in strips. Since 0.1. */
struct rf_depth_tally;

/**
 * The same of a channel that comes in strips from the top: create, add each, finish,
 * which frees the tally. Strips have the width and the infinity of `channel`, whose
 * height is that of all of them; its pointers are not looked at. Since 0.1.
 */
RF_API rf_result rf_depth_tally_create(struct rf_depth_tally **tally,
                                       const struct rf_context *context,
                                       const struct rf_depth_channel *channel,
                                       struct rf_error *error);
/** Adds a strip; colours of another width, or of fewer rows, are not looked at. Since
 * 0.1. */
RF_API void rf_depth_tally_add(struct rf_depth_tally *tally,
                               const struct rf_depth_channel *strip);
/** Fills `stats`, whose size is set, and frees the tally. Since 0.1. */
RF_API void rf_depth_tally_finish(struct rf_depth_tally *tally,
                                  struct rf_depth_stats *stats);

/**
 * Undoes in place what can be undone of a depth of kind planar or radial: a depth that
 * was multiplied by alpha is divided by it, pixels whose depth was averaged between two
 * sides get that of one, those that show what is behind their depth that of it, and
 * those that fog left without depth that of the surface around them.
 * Measures first; `stats` receives what was found and done.
 * Errors as rf_depth_measure(). Since 0.1.
 */
RF_API rf_result rf_depth_repair(const struct rf_context *context,
                                 struct rf_depth_channel *channel,
                                 struct rf_depth_stats *stats, struct rf_error *error);

/** Divides depth by alpha, the fourth channel of the colours, in place; 0 where that is
 * 0. Returns how many pixels changed: none where the colours have not the channel's
 * size. Since 0.1. */
RF_API size_t rf_depth_divide_by_alpha(struct rf_depth_channel *channel);

/** How far away pixels decide on what rf_depth_snap() gives one, px. Since 0.1. */
enum { RF_DEPTH_SNAP_REACH = 7 };

/**
 * Gives pixels whose depth lies between those of two flat sides the nearer of the two
 * depths, in place; *n_changed is raised by how many. What a pixel gets depends on
 * those within RF_DEPTH_SNAP_REACH in its row and its column, and on its neighbours.
 * Errors as rf_depth_measure(). Since 0.1.
 */
RF_API rf_result rf_depth_snap(const struct rf_context *context,
                               struct rf_depth_channel *channel, size_t *n_changed,
                               struct rf_error *error);

/**
 * Gives pixels whose depth is that of a near thing, but whose colour is that of what is
 * behind it, the depth behind, in place; *n_changed is raised by how many. `stats` is
 * what rf_depth_measure() found in the whole picture, whose kind is planar or radial.
 * What a pixel gets depends on those within RF_DEPTH_SNAP_REACH in its row and its
 * column. Errors as rf_depth_measure(); the channel has no colours. Since 0.1.
 */
RF_API rf_result rf_depth_narrow(const struct rf_context *context,
                                 struct rf_depth_channel *channel,
                                 const struct rf_depth_stats *stats, size_t *n_changed,
                                 struct rf_error *error);

/** How far away pixels decide on what rf_depth_fill() gives one, px. Since 0.1. */
enum { RF_DEPTH_FILL_REACH = 5 };

/**
 * Gives pixels without depth that have a surface of their colour around them its depth,
 * in place; *n_changed is raised by how many. It is for depth of kind planar or radial
 * that fog made holes in (rf_depth_stats.is_speckled, or the renderer says so): gaps of
 * a pixel or two that show the sky may be filled, too. What a pixel gets depends on
 * those within RF_DEPTH_FILL_REACH. Errors as rf_depth_measure(). Since 0.1.
 */
RF_API rf_result rf_depth_fill(const struct rf_context *context,
                               struct rf_depth_channel *channel, size_t *n_changed,
                               struct rf_error *error);

/** How Blender's Mist pass falls off over t, 0 at its start to 1 at its end. */
enum rf_mist {
    RF_MIST_NONE,      /**< no Mist pass */
    RF_MIST_LINEAR,    /**< t */
    RF_MIST_QUADRATIC, /**< t^2 */
    RF_MIST_INVERSE,   /**< sqrt(t) */
};

/** Makes normalised depth of the numbers of a Mist pass, in place. Since 0.1. */
RF_API void rf_depth_undo_mist(float *depth, size_t n, enum rf_mist falloff);

/* ---- maps ---------------------------------------------------------------------- */

/**
 * The signed radius of every pixel in px: `depth` as in struct rf_view, `out` one
 * channel, may be the same view. Errors as rf_filter_process().
 */
RF_API rf_result rf_filter_coc(const struct rf_filter *filter,
                               const struct rf_image *depth, const struct rf_image *out,
                               struct rf_error *error);

/**
 * Planar distance in scene units of every pixel, INFINITY where nothing was hit:
 * `depth` as in struct rf_view, `out` one channel, may be the same view.
 */
RF_API rf_result rf_filter_planar_depth(const struct rf_filter *filter,
                                        const struct rf_image *depth,
                                        const struct rf_image *out,
                                        struct rf_error *error);

/**
 * Finds the depth of what is seen in mirrors or through glass from several views of the
 * same light, for struct rf_seen_light. views[0] is the view that is to be filtered,
 * with colour and depth; of the others, 1 and more from other points of the lens,
 * lens_offset and shear_distance are read. lights[j] is the light of views[j], all of
 * one size, with three channels or one: no NaN, no infinity. `out`, one channel, gets
 * planar distances in scene units, INFINITY included, and NAN where the depth of the
 * surface holds: where there is no light, where nothing tells the two apart, and where
 * what is seen would be nearer than its surface. Some samples per pixel are enough.
 * RF_ERROR_ARGUMENT: fewer than two views, or all from one point of the lens.
 * Since 0.1.
 */
RF_API rf_result rf_filter_seen_depth(const struct rf_filter *filter,
                                      const struct rf_view *views, int32_t n_views,
                                      const struct rf_image *lights,
                                      const struct rf_image *out,
                                      struct rf_error *error);

/**
 * The same from one view that knows the way of its rays through mirrors and glass, such
 * as Cycles' Denoising Depth: `way`, one channel, has planar distances in scene units
 * that may be means over a pixel, and that end at the surface where nothing is mirrored.
 * `out` gets them where the surface of `light` is flat and they lie behind it, and NAN
 * elsewhere; it may be `way`. Since 0.1.
 */
RF_API rf_result rf_filter_seen_way(const struct rf_filter *filter,
                                    const struct rf_view *view,
                                    const struct rf_image *light,
                                    const struct rf_image *way,
                                    const struct rf_image *out, struct rf_error *error);

/* ---- accumulation -------------------------------------------------------------- */

struct rf_accumulator;

/**
 * The mean of any number of pictures, one in memory at a time: renders from points of
 * the lens that hold the plane in focus fixed give the lens's picture, without depth.
 * Sums are in double precision, in the space of params.blend_gamma (POV-Ray averages
 * its lens samples so), of pictures whose highlights are changed as those of
 * RF_GROUP_HIGHLIGHTS say; nothing else of `params` matters. Pictures are width x height
 * of 1, 3 or 4 `channels`. Not to be used by two threads at a time. Source: OpenGL
 * programming guide, "depth of field". RF_ERROR_ARGUMENT: size or channels, field
 * "width", "height" or "channels". Since 0.1.
 */
RF_API rf_result rf_accumulator_create(struct rf_accumulator **accumulator,
                                       const struct rf_context *context,
                                       const struct rf_params *params, int32_t width,
                                       int32_t height, int32_t channels,
                                       struct rf_error *error);
/** Frees it. NULL is allowed. */
RF_API void rf_accumulator_destroy(struct rf_accumulator *accumulator);

/**
 * Adds one picture, scene-linear, alpha premultiplied. RF_ERROR_PIXEL for NaN and
 * infinity, and then nothing was added. Since 0.1.
 */
RF_API rf_result rf_accumulator_add(struct rf_accumulator *accumulator,
                                    const struct rf_image *colour,
                                    struct rf_error *error);

/** How many pictures have been added. Since 0.1. */
RF_API int64_t rf_accumulator_count(const struct rf_accumulator *accumulator);

/**
 * Writes the mean of what was added so far; more may be added afterwards.
 * RF_ERROR_ARGUMENT where nothing was added. Since 0.1.
 */
RF_API rf_result rf_accumulator_mean(const struct rf_accumulator *accumulator,
                                     const struct rf_image *out,
                                     struct rf_error *error);

/** Context, filter and one frame in one call, on all processors. */
RF_API rf_result rf_apply(const struct rf_params *params, const struct rf_image *colour,
                          const struct rf_image *depth, const struct rf_image *out,
                          struct rf_error *error);

#ifdef __cplusplus
}
#endif

#endif
