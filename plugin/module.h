/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the Python extension share. */
#ifndef RF_PLUGIN_MODULE_H
#define RF_PLUGIN_MODULE_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <time.h>

#include "rackfocus/rackfocus.h"

/* Classes of the module; one set per interpreter. */
struct module_state {
    PyObject *error; /* base class; has the attributes field and message */
    PyObject *parameter_error, *depth_error, *pixel_error, *cancelled_error;
    PyObject *unread_warning, *views_warning;
    PyTypeObject *lens_type, *context_type;
};

/* ---- errors.c ------------------------------------------------------------------ */

/* Adds the exception classes to the module. 0, or -1 with an exception set. */
int plugin_add_errors(PyObject *module, struct module_state *state);

/* Sets the exception of a failed call and returns NULL. */
PyObject *plugin_raise(const struct module_state *state, const struct rf_error *error);

/*
 * Sets a ParameterError with its field: the argument at fault. The format is that of
 * PyUnicode_FromFormat(). Always -1.
 */
int plugin_fail(const char *field, const char *format, ...);

/* Sets an Error that the denoiser is to blame for. */
void plugin_raise_denoiser(const struct module_state *state, const char *message);

/* For O& of PyArg_Parse...(): a whole number; of those that are no int the nearest one,
 * which the checks of the core refuse by name. */
int plugin_take_int(PyObject *object, void *number);

/* ---- params.c ------------------------------------------------------------------ */

/* The lists of the core as tuples of tuples; see rackfocus/__init__.py. */
PyObject *plugin_parameters(PyObject *module, PyObject *unused);
PyObject *plugin_methods(PyObject *module, PyObject *unused);
PyObject *plugin_why_not_read(PyObject *module, PyObject *args, PyObject *keywords);

/*
 * Defaults, then every keyword in `keywords` (may be NULL) by its key or field name;
 * texts, numbers and bools. 0, or -1 with an exception set.
 */
int plugin_read_params(const struct module_state *state, PyObject *keywords,
                       struct rf_params *params);

/* Warns (UnreadParameterWarning) of keywords whose value is not the default and that
 * nothing reads; `is_mean`: of a mean of pictures, which reads blend_gamma and the
 * highlights. 0, or -1 where the warning became an exception. */
int plugin_warn_unread(const struct module_state *state, PyObject *keywords,
                       const struct rf_params *params, bool is_mean);

/* ---- image.c ------------------------------------------------------------------- */

/* A buffer of 32 bit floats that Python owns, and how the core sees it. */
struct plugin_image {
    Py_buffer buffer;
    struct rf_image image;
};

/*
 * Opens any object of shape (height, width) or (height, width, channels) without a
 * copy. `name` is the argument's name in errors. 0, or -1 with an exception set.
 */
int plugin_open_image(struct plugin_image *image, PyObject *object, const char *name,
                      bool is_writable);
void plugin_close_image(struct plugin_image *image);

/* Packed pixels of the first `n` channels of an image, or with `is_back` the image of
 * these. */
void plugin_copy_pixels(const struct rf_image *image, int n, float *packed,
                        bool is_back);

/* A packed copy of the first `n` channels, for free(); NULL with an exception set. */
float *plugin_packed(const struct rf_image *image, int n);

/* How many items an argument of this name may have. */
struct plugin_range {
    const char *name;
    int least, most;
};

/*
 * Calls `open` with each item of a sequence. Their number, or -1 with an exception set.
 */
int plugin_open_each(PyObject *sequence, struct plugin_range range,
                     int (*open)(void *user, PyObject *item), void *user);

/* ---- context.c ----------------------------------------------------------------- */

extern PyType_Spec plugin_context_spec;

/* Of an object of state->context_type. */
const struct rf_context *plugin_context_of(PyObject *object);

/*
 * Takes the keywords `context` and `threads` out of `keywords`; *context is a new
 * reference to what was given, or to a context of its own. 0, or -1 with an exception.
 */
int plugin_take_context(const struct module_state *state, PyObject *keywords,
                        PyObject **context);

/* ---- deep.c -------------------------------------------------------------------- */

/* Two buffers that Python owns, as a deep frame. */
struct plugin_deep {
    Py_buffer first, samples;
    struct rf_deep deep;
};

/* 0, or -1 with an exception set. */
int plugin_open_deep(struct plugin_deep *deep, PyObject *first, PyObject *samples,
                     const int size_px[2]);
void plugin_close_deep(struct plugin_deep *deep);

/* An object of plugin_filter_spec. */
struct plugin_filter {
    PyObject ob_base;
    PyObject *context; /* held */
    struct rf_filter *filter;
    int size_px[2];
    float white; /* of its parameters, to a power of two */
    struct rf_params params;
};

/* ---- filter_views.c ------------------------------------------------------------ */

/* Several views of one frame, and the buffers that Python owns. */
struct plugin_views {
    struct rf_view views[RF_MAX_VIEWS];
    struct plugin_image images[3 * RF_MAX_VIEWS];
    int n_images, n;
};

/* Opens a sequence of tuples (colour, depth, (u, v), shear distance); NULL with an
 * exception set. */
struct plugin_views *plugin_open_views(PyObject *sequence);
void plugin_close_views(struct plugin_views *open);

/* ---- views_doubts.c ------------------------------------------------------------ */

/* Warns of views of other places than they say, or of another exposure. 0, or -1 with an
 * exception set. */
int plugin_warn_views(const struct module_state *state,
                      const struct plugin_filter *filter,
                      const struct plugin_views *open);

/*
 * Work without the lock that calls a function of Python with a fraction, if there is
 * one, and on the thread in which Python handles signals lets their handlers run: Ctrl-C
 * ends it.
 */
struct plugin_progress {
    PyObject *function; /* or NULL */
    PyThreadState *thread;
    bool handles_signals;
    clock_t handled; /* when that was last done */
    bool has_raised; /* an exception is set */
};

/* `function` may be None. 0, without the lock; or -1 with it and an exception set. */
int plugin_start_progress(struct plugin_progress *progress, PyObject *function);

/* Takes the lock again. */
void plugin_end_progress(struct plugin_progress *progress);

/* Of struct rf_progress; `user` is a struct plugin_progress. */
bool plugin_report(void *user, double fraction);

/* -1 with an exception set, which may be that of a signal. */
int plugin_is_main_thread(void);

/* ---- aside.c ------------------------------------------------------------------- */

/* Returns early once *stop is true, which another thread makes it; `stop` may be NULL. */
typedef void (*plugin_work)(void *data, const bool *stop);

/*
 * Does work without Python's lock; where Python handles signals on this thread, their
 * handlers run meanwhile. 0, or -1 with an exception set: what a handler raised, and the
 * work ended early.
 */
int plugin_run_aside(plugin_work work, void *data);

/* ---- filter_seen.c ------------------------------------------------------------- */

/* Lights of a frame that are seen in mirrors or through glass, and their depths. */
struct plugin_seen {
    struct rf_seen_light lights[RF_MAX_SEEN];
    struct plugin_image images[2 * RF_MAX_SEEN];
    int n_images;
};

/* Opens None, or a sequence of tuples (light, depth), for a view. 0, or -1 with an
 * exception set; to be closed in any case. */
int plugin_open_seen(struct plugin_seen *seen, PyObject *sequence,
                     struct rf_view *view);
void plugin_close_seen(struct plugin_seen *seen);

/* None, or a sequence of such lights for each view. NULL with an exception set. */
struct plugin_view_lights *plugin_open_view_lights(PyObject *sequence,
                                                   struct plugin_views *views);
void plugin_close_view_lights(struct plugin_view_lights *open);

PyObject *plugin_filter_seen_depth(PyObject *object, PyObject *args,
                                   PyObject *keywords);
PyObject *plugin_filter_seen_way(PyObject *object, PyObject *args, PyObject *keywords);

/* mean_depth.c */
PyObject *plugin_filter_mean_depth(PyObject *object, PyObject *args,
                                   PyObject *keywords);

/* ---- compare.c ----------------------------------------------------------------- */

PyObject *plugin_compare(PyObject *module, PyObject *args, PyObject *keywords);
PyObject *plugin_fill_depth(PyObject *module, PyObject *args, PyObject *keywords);

/* ---- denoise.c ----------------------------------------------------------------- */

/* Which denoiser; see denoiser_open(). */
struct plugin_denoiser {
    const char *library;
    int quality; /* enum denoise_quality */
    int n_threads;
};

/* Takes the quality by its name. 0, or -1 with an exception set where that or the
 * threads are none. */
int plugin_check_denoiser(struct plugin_denoiser *how, const char *quality);

PyObject *plugin_finish(PyObject *module, PyObject *args, PyObject *keywords);

/* ---- denoise_views.c ----------------------------------------------------------- */

PyObject *plugin_filter_denoise_views(PyObject *object, PyObject *args,
                                      PyObject *keywords);

/* ---- merge_denoised.c ---------------------------------------------------------- */

PyObject *plugin_filter_merge_denoised(PyObject *object, PyObject *args,
                                       PyObject *keywords);

/* ---- lens.c, filter.c, accumulator.c -------------------------------------------- */

extern PyType_Spec plugin_lens_spec, plugin_filter_spec, plugin_accumulator_spec;

PyObject *plugin_lens_points(PyObject *module, PyObject *args, PyObject *keywords);

/* A new Lens object that holds a copy of `lens`. */
PyObject *plugin_lens_new(const struct module_state *state, const struct rf_lens *lens);

#endif
