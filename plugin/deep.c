/* SPDX-License-Identifier: Apache-2.0 */
/* Deep frames from two buffers: where each pixel's samples begin, and the samples. */
#include <string.h>

#include "module.h"

/* A row of the samples is one struct: depth, depth_back, r, g, b, a, opacity. */
enum { N_VALUES = sizeof(struct rf_deep_sample) / sizeof(float) };
_Static_assert(sizeof(struct rf_deep_sample) == 7 * sizeof(float),
               "samples are rows of seven floats");

static bool is_size_format(const Py_buffer *buffer)
{
    const char *format = buffer->format ? buffer->format : "";
    format += *format == '@' || *format == '=' || *format == '<';
    return buffer->itemsize == sizeof(size_t) && strchr("qQlLnN", *format) &&
           format[0] && !format[1];
}

static int check_first(const Py_buffer *buffer)
{
    if (buffer->ndim != 1 || !is_size_format(buffer))
        return plugin_fail("first", "must be whole numbers of 64 bit in one dimension");
    return 0;
}

static int check_samples(const Py_buffer *buffer)
{
    const char *format = buffer->format ? buffer->format : "";
    format += *format == '@' || *format == '=' || *format == '<';
    if (buffer->ndim != 2 || buffer->shape[1] != N_VALUES || strcmp(format, "f") != 0)
        return plugin_fail("samples",
                           "must be 32 bit floats of the shape (n, 7): depth, "
                           "depth_back, r, g, b, a, opacity");
    return 0;
}

/* Offsets from 0 that do not fall and end at the number of samples. */
static int check_offsets(const struct plugin_deep *deep, size_t n_pixels)
{
    const size_t *first = deep->deep.first;
    const size_t n_samples = (size_t)deep->samples.shape[0];
    if ((size_t)deep->first.shape[0] != n_pixels + 1 || first[0] != 0 ||
        first[n_pixels] != n_samples)
        return plugin_fail("first",
                           "must have width * height + 1 offsets, from 0 to the "
                           "number of samples");
    for (size_t i = 0; i < n_pixels; i++)
        if (first[i] > first[i + 1])
            return plugin_fail("first", "its offsets must not fall");
    return 0;
}

int plugin_open_deep(struct plugin_deep *deep, PyObject *first, PyObject *samples,
                     const int size_px[2])
{
    const int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT;
    if (PyObject_GetBuffer(first, &deep->first, flags) < 0)
        return -1;
    if (PyObject_GetBuffer(samples, &deep->samples, flags) < 0) {
        PyBuffer_Release(&deep->first);
        return -1;
    }
    deep->deep = (struct rf_deep){.width = size_px[0],
                                  .height = size_px[1],
                                  .first = deep->first.buf,
                                  .samples = deep->samples.buf};
    if (check_first(&deep->first) == 0 && check_samples(&deep->samples) == 0 &&
        check_offsets(deep, (size_t)size_px[0] * (size_t)size_px[1]) == 0)
        return 0;
    plugin_close_deep(deep);
    return -1;
}

void plugin_close_deep(struct plugin_deep *deep)
{
    PyBuffer_Release(&deep->first);
    PyBuffer_Release(&deep->samples);
}
