/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.compare(): the figures of the command's `compare`, from the same source. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure/flip.h"
#include "measure/measure.h"
#include "module.h"

/* Red, green and blue of any image, packed; grey gives three alike. */
static void pack(const struct rf_image *image, float *samples)
{
    const int n_colours = image->channels < 3 ? 1 : 3;
    for (int32_t y = 0; y < image->height; y++)
        for (int32_t x = 0; x < image->width; x++) {
            const char *at = (const char *)image->data + y * image->row_bytes +
                             x * image->pixel_bytes;
            for (int c = 0; c < 3; c++)
                memcpy(samples++, at + c % n_colours * image->channel_bytes,
                       sizeof(float));
        }
}

static rf_result fail(struct rf_error *error, rf_result code, const char *field)
{
    *error = (struct rf_error){.code = code};
    snprintf(error->field, sizeof error->field, "%s", field);
    return code;
}

static rf_result check_shapes(const struct rf_image *images, const char *const *names,
                              struct rf_error *error)
{
    for (int i = 0; i < 2; i++) {
        const int32_t n = images[i].channels;
        if (n == 1 || n == 3 || n == 4)
            continue;
        fail(error, RF_ERROR_PARAMETER, names[i]);
        snprintf(error->message, sizeof error->message,
                 "has %d channels; pictures of 1, 3 or 4 can be compared", n);
        return error->code;
    }
    if (images[0].width == images[1].width && images[0].height == images[1].height)
        return RF_OK;
    fail(error, RF_ERROR_PARAMETER, names[1]);
    snprintf(error->message, sizeof error->message,
             "is %d x %d, but %s is %d x %d; pictures of one size can be compared",
             images[1].width, images[1].height, names[0], images[0].width,
             images[0].height);
    return error->code;
}

static rf_result check_finite(const float *samples, int32_t width, size_t n,
                              const char *name, struct rf_error *error)
{
    size_t n_bad = 0, first = 0;
    for (size_t i = 0; i < n; i++)
        if (!isfinite(samples[i]) && n_bad++ == 0)
            first = i / 3;
    if (n_bad == 0)
        return RF_OK;
    fail(error, RF_ERROR_PIXEL, name);
    snprintf(error->message, sizeof error->message,
             "%zu values are NaN or infinite, the first at pixel (%zu, %zu)", n_bad,
             first % (size_t)width, first / (size_t)width);
    return error->code;
}

static rf_result fail_memory(struct rf_error *error, int32_t width, int32_t height)
{
    fail(error, RF_ERROR_MEMORY, "");
    snprintf(error->message, sizeof error->message,
             "out of memory: the comparison of %d x %d px", width, height);
    return error->code;
}

/* Two pictures, and what comes of them. */
struct measuring {
    struct rf_image images[2];
    const char *const *names;
    struct measures measures;
    double flip;
    struct rf_error error;
    rf_result result;
};

static rf_result measure(struct measuring *m, const bool *stop)
{
    const struct rf_image *images = m->images;
    struct rf_error *error = &m->error;
    rf_result result = check_shapes(images, m->names, error);
    if (result != RF_OK)
        return result;
    const int32_t width = images[0].width, height = images[0].height;
    const size_t n = 3 * (size_t)width * (size_t)height;
    float *samples[2] = {calloc(n, sizeof(float)), calloc(n, sizeof(float))};
    const bool has_memory = samples[0] && samples[1];
    if (!has_memory)
        result = fail_memory(error, width, height);
    for (int i = 0; has_memory && i < 2 && result == RF_OK; i++) {
        pack(&images[i], samples[i]);
        result = check_finite(samples[i], width, n, m->names[i], error);
    }
    if (result == RF_OK &&
        (!measure_pictures(samples[0], samples[1], width, height, &m->measures, stop) ||
         !flip_measure(samples[0], samples[1], width, height, &m->flip, stop)))
        result = fail_memory(error, width, height);
    free(samples[0]);
    free(samples[1]);
    return result;
}

static void run(void *data, const bool *stop)
{
    struct measuring *m = data;
    m->result = measure(m, stop);
}

/* The names of the command's JSON; a ratio to a black picture is None. */
static PyObject *describe(const struct measures *m, double flip)
{
    PyObject *ratio = isnan(m->energy_ratio) ? Py_NewRef(Py_None)
                                             : PyFloat_FromDouble(m->energy_ratio);
    return Py_BuildValue("{s:d,s:d,s:d,s:N,s:d,s:(ii),s:N,s:d,s:d}", "psnr", m->psnr_db,
                         "ssim", m->ssim, "rmse", m->rmse, "energy_ratio", ratio,
                         "max_error", m->max_error, "max_error_pixel", m->max_x,
                         m->max_y, "identical", PyBool_FromLong(m->max_error == 0),
                         "tpsnr", m->tpsnr_db, "flip", flip);
}

PyObject *plugin_compare(PyObject *module, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"a", "b", NULL};
    PyObject *objects[2];
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OO:compare", names, &objects[0],
                                     &objects[1]))
        return NULL;
    struct plugin_image opened[2];
    if (plugin_open_image(&opened[0], objects[0], names[0], false) < 0)
        return NULL;
    if (plugin_open_image(&opened[1], objects[1], names[1], false) < 0) {
        plugin_close_image(&opened[0]);
        return NULL;
    }
    struct measuring m = {.images = {opened[0].image, opened[1].image},
                          .names = (const char *const *)names};
    const int status = plugin_run_aside(run, &m);
    plugin_close_image(&opened[0]);
    plugin_close_image(&opened[1]);
    if (status < 0)
        return NULL;
    if (m.result != RF_OK)
        return plugin_raise(PyModule_GetState(module), &m.error);
    return describe(&m.measures, m.flip);
}
