/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.Filter.mean_depth(): planar means from mean lengths of rays. */
#include "module.h"
#include "sources/planar_means.h"

static float *sample_at(const struct rf_image *image, int x, int y)
{
    return (float *)((char *)image->data + y * image->row_bytes +
                     x * image->pixel_bytes);
}

static void pack(const struct rf_image *image, float *to)
{
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++)
            *to++ = *sample_at(image, x, y);
}

/* The means in `out`, by three planes of memory. */
static bool make(const struct plugin_filter *self, const struct rf_image *rays,
                 const struct rf_image *depth, const struct rf_image *out,
                 struct rf_view *view, float *memory)
{
    const int width = out->width, height = out->height;
    const size_t n = (size_t)width * (size_t)height;
    float *mean = memory, *planar = memory + n;
    pack(rays, mean);
    pack(depth, planar);
    view->depth = rf_image_packed(planar, width, height, 1);
    const bool is_made = planar_means_make(rf_filter_lens(self->filter), &self->params,
                                           view, mean, memory + 2 * n);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            *sample_at(out, x, y) = *mean++;
    return is_made;
}

/* Are the three of the filter's size, with one channel? */
static bool check_sizes(const struct plugin_image images[3], const int32_t size_px[2])
{
    for (int k = 0; k < 3; k++) {
        const struct rf_image *image = &images[k].image;
        if (image->width == size_px[0] && image->height == size_px[1] &&
            image->channels == 1)
            continue;
        PyErr_Format(PyExc_ValueError,
                     "mean_depth: rays, depth and out must be (%d, %d)", size_px[1],
                     size_px[0]);
        return false;
    }
    return true;
}

PyObject *plugin_filter_mean_depth(PyObject *object, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"rays",        "depth",          "out",
                            "lens_offset", "shear_distance", NULL};
    const struct plugin_filter *self = (struct plugin_filter *)object;
    PyObject *objects[3], *answer = NULL;
    struct rf_view view = {.size = sizeof view};
    struct plugin_image images[3];
    int n_open = 0;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOO|(dd)d:mean_depth", names,
                                     &objects[0], &objects[1], &objects[2],
                                     &view.lens_offset[0], &view.lens_offset[1],
                                     &view.shear_distance))
        return NULL;
    while (n_open < 3 && plugin_open_image(&images[n_open], objects[n_open],
                                           names[n_open], n_open == 2) == 0)
        n_open++;
    if (n_open == 3 && check_sizes(images, self->size_px)) {
        const size_t n = (size_t)self->size_px[0] * (size_t)self->size_px[1];
        float *memory = PyMem_Calloc(3 * n, sizeof *memory);
        bool is_made = false;
        Py_BEGIN_ALLOW_THREADS;
        if (memory)
            is_made = make(self, &images[0].image, &images[1].image, &images[2].image,
                           &view, memory);
        Py_END_ALLOW_THREADS;
        answer = memory ? PyBool_FromLong(is_made) : PyErr_NoMemory();
        PyMem_Free(memory);
    }
    while (n_open > 0)
        plugin_close_image(&images[--n_open]);
    return answer;
}
