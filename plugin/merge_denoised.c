/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.Filter.merge_denoised(): merges views with and without their grain. */
#include "module.h"

#include <stdlib.h>

#include "common/report.h"
#include "denoise/denoise_mix.h"

enum { N_MERGES = 3 };

/* Everything of one call. */
struct job {
    const struct rf_filter *filter;
    float white; /* of the filter */
    struct plugin_views *views;
    struct plugin_image cleans[RF_MAX_VIEWS], out;
    int n_cleans;
    float *flipped[RF_MAX_VIEWS], *merged[N_MERGES];
    struct plugin_progress progress;
    int n_done; /* merges */
};

static const struct rf_image *first_of(const struct job *job)
{
    return &job->views->views[0].colour;
}

static bool is_like_first(const struct job *job, const struct rf_image *image)
{
    const struct rf_image *first = first_of(job);
    return image->width == first->width && image->height == first->height &&
           image->channels == first->channels;
}

/* ---- what was given ------------------------------------------------------------- */

/* Gives the grain of view j in flipped[j] random signs. */
static int flip(struct job *job, int j)
{
    const struct rf_image *image = &job->cleans[j].image;
    float *clean = plugin_packed(image, image->channels);
    if (!clean)
        return -1;
    const struct denoise_picture grainy = {job->flipped[j], image->width, image->height,
                                           image->channels, "views",      job->white};
    denoise_flip(&grainy, clean, j);
    free(clean);
    return 0;
}

/* The next colour without grain. */
static int open_clean(void *user, PyObject *object)
{
    struct job *job = user;
    const int j = job->n_cleans;
    const struct rf_image *colour = &job->views->views[j].colour;
    if (plugin_open_image(&job->cleans[j], object, "clean", false) < 0)
        return -1;
    job->n_cleans++;
    if (!is_like_first(job, colour) || !is_like_first(job, &job->cleans[j].image)) {
        return plugin_fail("clean",
                           "clean of view %d and its colour must have the shape of the "
                           "first view's colour",
                           j);
    }
    job->flipped[j] = plugin_packed(colour, colour->channels);
    return job->flipped[j] ? flip(job, j) : -1;
}

static int open_job(struct job *job, PyObject *cleans, PyObject *out)
{
    const struct rf_image *first = first_of(job);
    const struct plugin_range range = {"clean", job->views->n, job->views->n};
    if (plugin_open_each(cleans, range, open_clean, job) < 0 ||
        plugin_open_image(&job->out, out, "out", true) < 0)
        return -1;
    if (!is_like_first(job, &job->out.image))
        return plugin_fail("out", "must have the shape of a view's colour");
    for (int k = 0; k < N_MERGES; k++) {
        job->merged[k] = calloc((size_t)first->width * (size_t)first->height,
                                (size_t)first->channels * sizeof(float));
        if (!job->merged[k]) {
            PyErr_NoMemory();
            return -1;
        }
    }
    return 0;
}

static void close_job(struct job *job)
{
    for (int j = 0; j < job->n_cleans; j++) {
        plugin_close_image(&job->cleans[j]);
        free(job->flipped[j]);
    }
    for (int k = 0; k < N_MERGES; k++)
        free(job->merged[k]);
    if (job->out.image.data)
        plugin_close_image(&job->out);
    plugin_close_views(job->views);
    PyMem_Free(job);
}

/* ---- the run -------------------------------------------------------------------- */

/* A part of the whole, as rf_progress. */
static bool report(void *user, double fraction)
{
    struct job *job = user;
    return plugin_report(&job->progress, (job->n_done + fraction) / N_MERGES);
}

/* Merges the views, with their colours as they are, into merged[k]. */
static bool merge(struct job *job, const struct rf_view *views, int k,
                  struct rf_error *error)
{
    const struct rf_image *first = first_of(job);
    struct rf_image out =
        rf_image_packed(job->merged[k], first->width, first->height, first->channels);
    const struct rf_progress progress = {report, job};
    const rf_result result =
        rf_filter_process(job->filter, views, job->views->n, &out, &progress, error);
    job->n_done++;
    return result == RF_OK;
}

/* Without Python's lock; false with either error set. */
static bool run(struct job *job, int n_threads, struct rf_error *error,
                struct image_error *failure)
{
    const struct rf_image *first = first_of(job);
    const struct denoise_merges merges = {.clean = job->merged[0],
                                          .grainy = job->merged[1],
                                          .flipped = job->merged[2],
                                          .width = first->width,
                                          .height = first->height,
                                          .n_channels = first->channels,
                                          .white = job->white,
                                          .n_threads = n_threads};
    struct rf_view clean[RF_MAX_VIEWS], flipped[RF_MAX_VIEWS];
    for (int j = 0; j < job->views->n; j++) {
        clean[j] = flipped[j] = job->views->views[j];
        clean[j].colour = job->cleans[j].image;
        flipped[j].colour = rf_image_packed(job->flipped[j], first->width,
                                            first->height, first->channels);
    }
    return merge(job, clean, 0, error) && merge(job, job->views->views, 1, error) &&
           merge(job, flipped, 2, error) && denoise_mix(&merges, failure);
}

static PyObject *merge_denoised(struct job *job, const struct module_state *state,
                                int n_threads, PyObject *function)
{
    struct rf_error error = {.code = RF_OK};
    struct image_error failure = {0};
    if (plugin_start_progress(&job->progress, function) < 0)
        return NULL;
    const bool is_done = run(job, n_threads, &error, &failure);
    plugin_end_progress(&job->progress);
    if (job->progress.has_raised)
        return NULL;
    if (!is_done)
        return error.code != RF_OK ? plugin_raise(state, &error) : PyErr_NoMemory();
    plugin_copy_pixels(&job->out.image, job->out.image.channels, job->merged[0], true);
    return Py_NewRef(Py_None);
}

PyObject *plugin_filter_merge_denoised(PyObject *object, PyObject *args,
                                       PyObject *keywords)
{
    static char *names[] = {"views", "clean", "out", "progress", "check", NULL};
    const struct module_state *state = PyType_GetModuleState(Py_TYPE(object));
    const struct plugin_filter *filter = (struct plugin_filter *)object;
    PyObject *sequence, *cleans, *out, *function = Py_None, *answer = NULL;
    int is_checked = 1;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOO|Op:merge_denoised", names,
                                     &sequence, &cleans, &out, &function, &is_checked))
        return NULL;
    struct job *job = PyMem_Calloc(1, sizeof *job);
    if (!job)
        return PyErr_NoMemory();
    job->filter = filter->filter;
    job->white = filter->white;
    job->views = plugin_open_views(sequence);
    if (!job->views) {
        PyMem_Free(job);
        return NULL;
    }
    if (open_job(job, cleans, out) == 0 &&
        (!is_checked || plugin_warn_views(state, filter, job->views) == 0))
        answer = merge_denoised(job, state,
                                rf_context_threads(plugin_context_of(filter->context)),
                                function);
    close_job(job);
    return answer;
}
