/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.finish(): the host's own lens cleaned with our picture, as the command's. */
#include "module.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/denoise.h"
#include "filter/finish_headers.h"
#include "filter/finish_lens.h"
#include "filter/finish_light.h"
#include "filter/finish_mix.h"
#include "image.h"
#include "sources/white.h"

enum { OWN, OURS, OUT, ALBEDO, NORMAL, HALF, ESTIMATE, N_PICTURES };

static const char *const names[N_PICTURES] = {"own",    "ours", "out",  "albedo",
                                              "normal", "half", "error"};

/* The buffers of a call and packed copies of them. */
struct finish {
    struct plugin_image opened[N_PICTURES];
    bool is_open[N_PICTURES];
    float *rgb[N_PICTURES];
    float white;     /* a power of two */
    int n_samples;   /* of a pixel of own, and of half; 0: at least 10 */
    bool is_checked; /* is ours held against own? */
};

static int check_shape(const struct finish *f, int i)
{
    const struct rf_image *first = &f->opened[OWN].image, *image = &f->opened[i].image;
    const bool is_flat = i == ESTIMATE;
    if (is_flat ? image->channels != 1 : image->channels < 3 || image->channels > 4)
        return plugin_fail(names[i], is_flat ? "must be of shape (height, width)"
                                             : "must have 3 or 4 channels");
    if (image->width != first->width || image->height != first->height)
        return plugin_fail(names[i], "must be as large as own");
    return 0;
}

/* NULL with an exception set where there is no memory. */
static float *new_plane(size_t n_pixels, size_t n_channels)
{
    float *plane = calloc(n_pixels, n_channels * sizeof(float));
    if (!plane)
        PyErr_NoMemory();
    return plane;
}

/* Opens one buffer; of one that is read, makes a packed copy. */
static int open_picture(struct finish *f, int i, PyObject *object)
{
    if (object == Py_None && i >= ALBEDO)
        return 0;
    const bool is_result = i == OUT || i == ESTIMATE;
    if (plugin_open_image(&f->opened[i], object, names[i], is_result) < 0)
        return -1;
    f->is_open[i] = true;
    if (check_shape(f, i) < 0)
        return -1;
    if (is_result)
        return 0;
    const struct rf_image *image = &f->opened[i].image;
    const size_t n = (size_t)image->width * (size_t)image->height;
    if (!(f->rgb[i] = new_plane(n, 3)))
        return -1;
    plugin_copy_pixels(image, 3, f->rgb[i], false);
    for (size_t k = 0; k < 3 * n; k++)
        if (!isfinite(f->rgb[i][k]))
            return plugin_fail(names[i], "has NaN or infinity");
    return 0;
}

static int join_halves(struct finish *f)
{
    const struct rf_image *own = &f->opened[OWN].image;
    const size_t n = (size_t)own->width * (size_t)own->height;
    if (finish_join_halves(f->rgb[OWN], f->rgb[HALF], 3 * n))
        return 0;
    return plugin_fail(names[HALF],
                       "has the samples of own; render it with another seed");
}

static void close_pictures(struct finish *f)
{
    for (int i = 0; i < N_PICTURES; i++) {
        if (f->is_open[i])
            plugin_close_image(&f->opened[i]);
        free(f->rgb[i]);
    }
}

int plugin_check_denoiser(struct plugin_denoiser *how, const char *quality)
{
    static const char *const qualities[] = {"high", "balanced", "fast"};
    for (int i = 0; i < 3; i++)
        if (strcmp(quality, qualities[i]) == 0) {
            how->quality = i;
            return how->n_threads < 0 ? plugin_fail("threads", "must not be negative")
                                      : 0;
        }
    return plugin_fail("quality", "must be high, balanced or fast");
}

/* A run of it. */
struct run {
    struct finish_picture picture;
    const struct plugin_denoiser *how;
    struct image_error error;
    bool is_done;
    char light[500], lens[500]; /* doubts of ours; "": none */
};

/* Without Python's lock. */
static void find_doubts(void *data, const bool *stop)
{
    struct run *r = data;
    r->picture.stop = stop;
    if (!finish_light_is_other(&r->picture, names[OURS], r->light, sizeof(r->light)))
        *r->light = 0;
    if (!finish_lens_is_other(&r->picture, names[OURS], r->lens, sizeof(r->lens)))
        *r->lens = 0;
}

/* Without Python's lock. */
static void run(void *data, const bool *stop)
{
    struct run *r = data;
    const struct plugin_denoiser *how = r->how;
    struct denoiser *denoiser = denoiser_open(
        how->library, (enum denoise_quality)how->quality, how->n_threads, &r->error);
    r->picture.stop = stop;
    r->is_done = denoiser && finish_mix(denoiser, &r->picture, &r->error);
    denoiser_close(denoiser);
}

/* Raises or prints a ViewsWarning; `about` goes with it. */
static int warn(const struct module_state *state, const char *about, const char *doubt)
{
    if (!*doubt)
        return 0;
    PyObject *text = PyUnicode_FromFormat("%s: %s", names[OWN], doubt);
    PyObject *warning =
        text ? PyObject_CallFunctionObjArgs(state->views_warning, text, NULL) : NULL;
    PyObject *name = warning ? PyUnicode_FromString(about) : NULL;
    PyObject *module = name ? PyImport_ImportModule("warnings") : NULL;
    PyObject *done = NULL;
    if (module && PyObject_SetAttrString(warning, "about", name) == 0)
        done = PyObject_CallMethod(module, "warn", "OOi", warning, Py_None, 2);
    const int status = done ? 0 : -1;
    Py_XDECREF(done);
    Py_XDECREF(module);
    Py_XDECREF(name);
    Py_XDECREF(warning);
    Py_XDECREF(text);
    return status;
}

/* Warns of a guide of another light or lens, as the command does. */
static int warn_guide(const struct module_state *state, struct run *r)
{
    if (plugin_run_aside(find_doubts, r) < 0 || warn(state, "light", r->light) < 0)
        return -1;
    return warn(state, "lens", r->lens);
}

/* Runs, copies the results back; -1 with an exception set. */
static int finish(const struct module_state *state, struct finish *f,
                  const struct plugin_denoiser *how)
{
    const struct rf_image *own = &f->opened[OWN].image, *out = &f->opened[OUT].image;
    struct run r = {.picture = {.own = f->rgb[OWN],
                                .ours = f->rgb[OURS],
                                .albedo = f->rgb[ALBEDO],
                                .normal = f->rgb[NORMAL],
                                .apart = f->rgb[HALF],
                                .estimate = f->rgb[ESTIMATE],
                                .width = own->width,
                                .height = own->height,
                                .n_samples = (f->rgb[HALF] ? 2 : 1) * f->n_samples,
                                .white = f->white,
                                .name = names[OWN]},
                    .how = how};
    if ((f->is_checked && warn_guide(state, &r) < 0) || plugin_run_aside(run, &r) < 0)
        return -1;
    if (!r.is_done && r.error.code == IMAGE_NO_MEMORY)
        PyErr_NoMemory();
    else if (!r.is_done)
        plugin_raise_denoiser(state, r.error.message);
    if (!r.is_done)
        return -1;
    /* Alpha is the own render's. */
    plugin_copy_pixels(out, 3, f->rgb[OURS], true);
    if (own->channels == 4 && out->channels == 4)
        for (int32_t y = 0; y < own->height; y++)
            for (int32_t x = 0; x < own->width; x++)
                memcpy((char *)out->data + y * out->row_bytes + x * out->pixel_bytes +
                           3 * out->channel_bytes,
                       (const char *)own->data + y * own->row_bytes +
                           x * own->pixel_bytes + 3 * own->channel_bytes,
                       sizeof(float));
    if (f->is_open[ESTIMATE])
        plugin_copy_pixels(&f->opened[ESTIMATE].image, 1, f->rgb[ESTIMATE], true);
    return 0;
}

PyObject *plugin_finish(PyObject *module, PyObject *args, PyObject *keywords)
{
    static char *keys[] = {"own",   "ours",  "out",     "albedo",  "normal",
                           "half",  "error", "library", "quality", "threads",
                           "white", "check", "samples", NULL};
    PyObject *objects[N_PICTURES] = {0};
    struct plugin_denoiser how = {0};
    const char *quality = "high";
    double white = 1;
    int is_checked = 1, n_samples = 0;
    objects[ALBEDO] = objects[NORMAL] = objects[HALF] = objects[ESTIMATE] = Py_None;
    if (!PyArg_ParseTupleAndKeywords(
            args, keywords, "OOO|OOOO$zsO&dpO&:finish", keys, &objects[OWN],
            &objects[OURS], &objects[OUT], &objects[ALBEDO], &objects[NORMAL],
            &objects[HALF], &objects[ESTIMATE], &how.library, &quality, plugin_take_int,
            &how.n_threads, &white, &is_checked, plugin_take_int, &n_samples) ||
        plugin_check_denoiser(&how, quality) < 0)
        return NULL;
    if (!(white >= 1e-6 && white <= 1e6)) {
        plugin_fail("white", "must lie in 1e-6 to 1e6");
        return NULL;
    }
    if (n_samples < 0 || n_samples > FINISH_MOST_SAMPLES) {
        plugin_fail("samples", "must lie in 0 to 1000000");
        return NULL;
    }
    struct finish f = {.white = (float)white_round(white),
                       .n_samples = n_samples,
                       .is_checked = is_checked};
    int status = 0;
    for (int i = 0; i < N_PICTURES && status == 0; i++)
        status = open_picture(&f, i, objects[i]);
    const struct rf_image *own = &f.opened[OWN].image;
    if (status == 0 && f.rgb[HALF])
        status = join_halves(&f);
    if (status == 0)
        f.rgb[ESTIMATE] = new_plane((size_t)own->width * (size_t)own->height, 1);
    if (f.rgb[ESTIMATE])
        status = finish(PyModule_GetState(module), &f, &how);
    else
        status = -1;
    close_pictures(&f);
    return status < 0 ? NULL : Py_NewRef(Py_None);
}
