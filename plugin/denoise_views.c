/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.Filter.denoise_views(): the grain of several views, out of all together. */
#include "module.h"

#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "denoise/denoise_seeds.h"
#include "denoise/denoise_views.h"

/* Everything of one call. */
struct job {
    const struct rf_filter *filter;
    float white; /* of the filter */
    struct plugin_views *views;
    struct plugin_image outs[RF_MAX_VIEWS], guides[2 * RF_MAX_VIEWS];
    int n_outs, n_guides;
    const char *names[RF_MAX_VIEWS];
    float *made[RF_MAX_VIEWS];
    struct denoise_views work;
    struct plugin_progress progress;
};

static int fail(const char *field, int j, const char *what, const char *rule)
{
    return plugin_fail(field, "%s of view %d %s", what, j, rule);
}

static bool is_as_large(const struct rf_image *image, const struct rf_image *other)
{
    return image->width == other->width && image->height == other->height;
}

/* ---- what was given ------------------------------------------------------------- */

/* Albedo or normals of view j, where they are not None; a packed copy. */
static int open_guide(struct job *job, int j, PyObject *object, const char *name,
                      float **guide)
{
    struct plugin_image *image = &job->guides[job->n_guides];
    if (object == Py_None)
        return 0;
    if (plugin_open_image(image, object, name, false) < 0)
        return -1;
    job->n_guides++;
    if (image->image.channels < 3 ||
        !is_as_large(&image->image, &job->views->views[0].colour))
        return fail("guides", j, name,
                    "must have the height and the width of its colour, and 3 "
                    "channels");
    *guide = plugin_packed(&image->image, 3);
    return *guide ? 0 : -1;
}

/* A tuple (albedo, normal) of each view; normals alone guide nothing. */
static int open_guides(struct job *job, int j, PyObject *sequence)
{
    struct denoise_guides *guides = &job->work.share.views[j].guides;
    PyObject *albedo, *normal, *about = PySequence_GetItem(sequence, j);
    int result = -1;
    if (!about)
        return -1;
    if (!PyTuple_Check(about))
        PyErr_Format(PyExc_TypeError,
                     "guides: view %d must have a tuple (albedo, "
                     "normal)",
                     j);
    else if (PyArg_ParseTuple(about, "OO:guides", &albedo, &normal))
        result = open_guide(job, j, albedo, "albedo", &guides->albedo);
    if (result == 0 && guides->albedo)
        result = open_guide(job, j, normal, "normal", &guides->normal);
    Py_DECREF(about);
    return result;
}

static int open_out(struct job *job, int j, PyObject *sequence)
{
    PyObject *object = PySequence_GetItem(sequence, j);
    const struct rf_image *colour = &job->views->views[j].colour;
    struct plugin_image *out = &job->outs[j];
    const int result = object ? plugin_open_image(out, object, "out", true) : -1;
    Py_XDECREF(object);
    if (result < 0)
        return -1;
    job->n_outs++;
    if (!is_as_large(&out->image, colour) || out->image.channels != colour->channels)
        return fail("outs", j, "out", "must have the shape of its colour");
    return 0;
}

static int open_view(struct job *job, const struct module_state *state, int j)
{
    const struct rf_view *view = &job->views->views[j];
    const struct rf_image *first = &job->views->views[0].colour;
    struct share_view *to = &job->work.share.views[j];
    struct rf_error error;
    if (!is_as_large(&view->colour, first) || view->colour.channels != first->channels)
        return fail("views", j, "the colour", "must have the shape of the first");
    const size_t n = (size_t)first->width * (size_t)first->height;
    float *shift = calloc(n, sizeof *shift);
    to->shift_px = shift;
    to->samples = plugin_packed(&view->colour, first->channels);
    job->made[j] = calloc(n, (size_t)first->channels * sizeof(float));
    memcpy(to->offset, view->lens_offset, sizeof to->offset);
    job->names[j] = "views";
    if (!shift || !to->samples || !job->made[j]) {
        PyErr_NoMemory();
        return -1;
    }
    if (!denoise_find_shifts(job->filter, view, shift, &error)) {
        plugin_raise(state, &error);
        return -1;
    }
    return 0;
}

static int open_job(struct job *job, const struct module_state *state, PyObject *outs,
                    PyObject *guides)
{
    struct share *share = &job->work.share;
    const struct rf_image *first = &job->views->views[0].colour;
    const int n = job->views->n;
    if (PySequence_Size(outs) != n ||
        (guides != Py_None && PySequence_Size(guides) != n)) {
        if (!PyErr_Occurred())
            plugin_fail("outs", "outs and guides must have an item for each view");
        return -1;
    }
    share->n = n;
    share->width = first->width;
    share->height = first->height;
    share->n_channels = first->channels;
    share->lens_radius = rf_filter_lens(job->filter)->lens_radius;
    share->white = job->white;
    share->views = calloc((size_t)n, sizeof *share->views);
    if (!share->views) {
        PyErr_NoMemory();
        return -1;
    }
    for (int j = 0; j < n; j++)
        if (open_view(job, state, j) < 0 || open_out(job, j, outs) < 0 ||
            (guides != Py_None && open_guides(job, j, guides) < 0))
            return -1;
    return 0;
}

static void close_job(struct job *job)
{
    struct share *share = &job->work.share;
    for (int j = 0; j < share->n && share->views; j++) {
        denoise_free_guides(&share->views[j].guides);
        free((float *)share->views[j].samples);
        free((float *)share->views[j].shift_px);
        free(job->made[j]);
    }
    free(share->views);
    share_close(share);
    while (job->n_outs > 0)
        plugin_close_image(&job->outs[--job->n_outs]);
    while (job->n_guides > 0)
        plugin_close_image(&job->guides[--job->n_guides]);
    plugin_close_views(job->views);
    PyMem_Free(job);
}

/* ---- the run -------------------------------------------------------------------- */

/* Without Python's lock; an enum app_code. */
static int run(struct job *job, const struct plugin_denoiser *how,
               struct image_error *error)
{
    struct denoiser *denoiser = denoiser_open(
        how->library, (enum denoise_quality)how->quality, how->n_threads, error);
    int code = APP_FAILED;
    if (denoiser)
        code = share_open(&job->work.share, error)
                   ? denoise_views(denoiser, &job->work, job->made, error)
                   : app_code_of(error);
    denoiser_close(denoiser);
    return code;
}

static PyObject *denoise(struct job *job, const struct module_state *state,
                         const struct plugin_denoiser *how, PyObject *function)
{
    struct image_error error = {0};
    job->work.names = job->names;
    job->work.progress = plugin_report;
    job->work.user = &job->progress;
    if (plugin_start_progress(&job->progress, function) < 0)
        return NULL;
    const int code = run(job, how, &error);
    plugin_end_progress(&job->progress);
    if (job->progress.has_raised)
        return NULL;
    if (code == APP_INTERRUPTED) {
        const struct rf_error cancelled = {.code = RF_ERROR_CANCELLED,
                                           .message = "cancelled"};
        return plugin_raise(state, &cancelled);
    }
    if (code == APP_NO_MEMORY)
        return PyErr_NoMemory();
    if (code != APP_DONE) {
        plugin_raise_denoiser(state, error.message);
        return NULL;
    }
    for (int j = 0; j < job->n_outs; j++)
        plugin_copy_pixels(&job->outs[j].image, job->outs[j].image.channels,
                           job->made[j], true);
    if (job->work.have_one_seed &&
        PyErr_WarnFormat(PyExc_UserWarning, 1, DENOISE_ONE_SEED) < 0)
        return NULL;
    return PyFloat_FromDouble(job->work.n_shared);
}

PyObject *plugin_filter_denoise_views(PyObject *object, PyObject *args,
                                      PyObject *keywords)
{
    static char *names[] = {"views",   "outs",    "guides",  "progress",
                            "library", "quality", "threads", NULL};
    const struct module_state *state = PyType_GetModuleState(Py_TYPE(object));
    PyObject *sequence, *outs, *guides = Py_None, *function = Py_None, *answer = NULL;
    struct plugin_denoiser how = {0};
    const char *quality = "high";
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OO|OO$zsO&:denoise_views", names,
                                     &sequence, &outs, &guides, &function, &how.library,
                                     &quality, plugin_take_int, &how.n_threads) ||
        plugin_check_denoiser(&how, quality) < 0)
        return NULL;
    struct job *job = PyMem_Calloc(1, sizeof *job);
    if (!job)
        return PyErr_NoMemory();
    job->filter = ((struct plugin_filter *)object)->filter;
    job->white = ((struct plugin_filter *)object)->white;
    job->views = plugin_open_views(sequence);
    job->work.share.n_threads = thread_count(how.n_threads);
    if (!job->views) {
        PyMem_Free(job);
        return NULL;
    }
    if (open_job(job, state, outs, guides) == 0)
        answer = denoise(job, state, &how, function);
    close_job(job);
    return answer;
}
