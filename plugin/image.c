/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers of Python as images of the core, without copies. */
#include "module.h"

#include <stdlib.h>
#include <string.h>

static bool is_float32(const Py_buffer *buffer)
{
    const char *format = buffer->format ? buffer->format : "B";
    if (*format == '@' || *format == '=' ||
        (*format == '<' && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__))
        format++;
    return strcmp(format, "f") == 0 && buffer->itemsize == sizeof(float);
}

/* Floats of another size or order, which NumPy makes those of 32 bit. */
static bool is_other_float(const Py_buffer *buffer)
{
    const char *format = buffer->format ? buffer->format : "B";
    format += *format && strchr("@=<>!", *format) != NULL;
    return *format && strchr("efdg", *format) && !format[1];
}

/* Whole numbers of any size and order. */
static bool is_whole(const Py_buffer *buffer)
{
    const char *format = buffer->format ? buffer->format : "B";
    format += *format && strchr("@=<>!", *format) != NULL;
    return *format && strchr("bBhHiIlLqQ", *format) && !format[1];
}

static int fail_format(const Py_buffer *buffer, const char *name, bool is_writable)
{
    const char *format = buffer->format ? buffer->format : "B";
    if (is_writable) /* a converted copy would be lost */
        PyErr_Format(PyExc_TypeError,
                     "%s: samples must be 32 bit floats, not of the format '%s'; make "
                     "the array with dtype=numpy.float32",
                     name, format);
    else if (is_other_float(buffer))
        PyErr_Format(PyExc_TypeError,
                     "%s: samples must be 32 bit floats, not of the format '%s'; give "
                     "%s.astype(numpy.float32)",
                     name, format, name);
    else if (is_whole(buffer))
        PyErr_Format(
            PyExc_TypeError,
            "%s: samples must be 32 bit floats, not of the format '%s'; give "
            "%s.astype(numpy.float32), made into what it stands for: distances, "
            "or scene-linear light, of 8 bits about (%s / 255) ** 2.2",
            name, format, name, name);
    else
        PyErr_Format(PyExc_TypeError,
                     "%s: samples must be 32 bit floats, not of the format '%s'", name,
                     format);
    return -1;
}

static int check(const Py_buffer *buffer, const char *name, bool is_writable)
{
    if (!is_float32(buffer))
        return fail_format(buffer, name, is_writable);
    if (buffer->ndim != 2 && buffer->ndim != 3)
        return plugin_fail(name,
                           "the shape must be (height, width) or (height, width, "
                           "channels), not of %d dimensions",
                           buffer->ndim);
    for (int i = 0; i < buffer->ndim; i++)
        if (buffer->shape[i] < 1 || buffer->shape[i] > 65535)
            return plugin_fail(name,
                               "dimension %d is %zd, which must lie in 1 to 65535", i,
                               buffer->shape[i]);
    return 0;
}

/* Is it one of NumPy's masked arrays, with something masked? Its buffer is that of all
 * numbers, those that the mask calls bad among them. */
static int check_mask(PyObject *object, const char *name)
{
    int is_masked = 0;
    if (!PyObject_HasAttrString(object, "filled") ||
        !PyObject_HasAttrString(object, "mask"))
        return 0;
    PyObject *mask = PyObject_GetAttrString(object, "mask");
    PyObject *any = mask ? PyObject_CallMethod(mask, "any", NULL) : NULL;
    if (any)
        is_masked = PyObject_IsTrue(any);
    Py_XDECREF(any);
    Py_XDECREF(mask);
    if (PyErr_Occurred())
        return -1;
    if (is_masked)
        PyErr_Format(PyExc_TypeError,
                     "%s: its mask would be lost; give %s.filled(VALUE), with what "
                     "stands for the masked pixels",
                     name, name);
    return is_masked ? -1 : 0;
}

/* It has no samples to read, or none that may be written. */
static void fail_buffer(PyObject *object, const char *name, bool is_writable)
{
    PyErr_Clear();
    /* PyType_GetName() came with 3.11, and 3.10 is Blender's until 4.0. */
    PyObject *kind = PyObject_GetAttrString((PyObject *)Py_TYPE(object), "__name__");
    if (!kind)
        return;
    if (is_writable)
        PyErr_Format(PyExc_TypeError,
                     "%s: a writable buffer of floats is needed, which this %U is not; "
                     "make it by numpy.empty(shape, numpy.float32)",
                     name, kind);
    else
        PyErr_Format(PyExc_TypeError,
                     "%s: a readable buffer of floats is needed, not %U; give "
                     "numpy.asarray(%s, numpy.float32)",
                     name, kind, name);
    Py_DECREF(kind);
}

int plugin_open_image(struct plugin_image *image, PyObject *object, const char *name,
                      bool is_writable)
{
    if (check_mask(object, name) < 0)
        return -1;
    int flags = is_writable ? PyBUF_RECORDS : PyBUF_RECORDS_RO;
    Py_buffer *buffer = &image->buffer;
    if (PyObject_GetBuffer(object, buffer, flags) < 0) {
        fail_buffer(object, name, is_writable);
        return -1;
    }
    if (check(buffer, name, is_writable) < 0) {
        PyBuffer_Release(buffer);
        return -1;
    }
    bool has_channels = buffer->ndim == 3;
    image->image = (struct rf_image){
        .data = buffer->buf,
        .height = (int32_t)buffer->shape[0],
        .width = (int32_t)buffer->shape[1],
        .channels = has_channels ? (int32_t)buffer->shape[2] : 1,
        .row_bytes = buffer->strides[0],
        .pixel_bytes = buffer->strides[1],
        .channel_bytes = has_channels ? buffer->strides[2] : (ptrdiff_t)sizeof(float),
    };
    return 0;
}

void plugin_close_image(struct plugin_image *image)
{
    PyBuffer_Release(&image->buffer);
}

void plugin_copy_pixels(const struct rf_image *image, int n, float *packed,
                        bool is_back)
{
    for (int32_t y = 0; y < image->height; y++)
        for (int32_t x = 0; x < image->width; x++)
            for (int c = 0; c < n; c++, packed++) {
                char *at = (char *)image->data + y * image->row_bytes +
                           x * image->pixel_bytes + c * image->channel_bytes;
                if (is_back)
                    memcpy(at, packed, sizeof(float));
                else
                    memcpy(packed, at, sizeof(float));
            }
}

float *plugin_packed(const struct rf_image *image, int n)
{
    float *memory =
        calloc((size_t)image->width * (size_t)image->height, (size_t)n * sizeof(float));
    if (memory)
        plugin_copy_pixels(image, n, memory, false);
    else
        PyErr_NoMemory();
    return memory;
}

int plugin_open_each(PyObject *sequence, struct plugin_range range,
                     int (*open)(void *user, PyObject *item), void *user)
{
    const Py_ssize_t n = PySequence_Size(sequence);
    if (n < 0) {
        PyErr_Format(PyExc_TypeError, "%s: a list or a tuple is needed", range.name);
        return -1;
    }
    if (n < range.least || n > range.most)
        return plugin_fail(range.name, "%zd were given; %d to %d can be", n,
                           range.least, range.most);
    for (Py_ssize_t i = 0; i < n; i++) {
        PyObject *item = PySequence_GetItem(sequence, i);
        const int result = item ? open(user, item) : -1;
        Py_XDECREF(item);
        if (result < 0)
            return -1;
    }
    return (int)n;
}
