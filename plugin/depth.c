/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.fill_depth(): the holes that fog leaves in a depth. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/stop.h"
#include "module.h"

static int check_shapes(const struct rf_image *depth, const struct rf_image *colour)
{
    if (depth->channels != 1)
        return plugin_fail("depth", "1 channel is needed, not %d",
                           (int)depth->channels);
    if (colour->width != depth->width || colour->height != depth->height)
        return plugin_fail("colour",
                           "is %d x %d px, but the depth %d x %d; give one size",
                           (int)colour->width, (int)colour->height, (int)depth->width,
                           (int)depth->height);
    return 0;
}

/* Rows that are filled at a time, so that it can be stopped between them. */
enum { BAND_ROWS = 32, MOST_ROWS = BAND_ROWS + 2 * RF_DEPTH_FILL_REACH };

/* A packed depth that is to be filled. */
struct filling {
    struct rf_depth_channel channel;
    const struct rf_image *depth; /* where it goes */
    bool is_always;
    struct rf_depth_stats stats; /* with n_filled, and what there was before */
    rf_result result;
};

/* Fills the rows from y on and copies them to the image. `band` has MOST_ROWS rows. */
static rf_result fill_band(struct filling *f, int32_t y, float *band)
{
    const struct rf_depth_channel *all = &f->channel;
    const int32_t end = y + BAND_ROWS < all->height ? y + BAND_ROWS : all->height;
    const int32_t from = y > RF_DEPTH_FILL_REACH ? y - RF_DEPTH_FILL_REACH : 0;
    const int32_t to = end + RF_DEPTH_FILL_REACH < all->height
                           ? end + RF_DEPTH_FILL_REACH
                           : all->height;
    const size_t width = (size_t)all->width;
    struct rf_depth_channel part = *all;
    part.depth = memcpy(band, all->depth + (size_t)from * width,
                        (size_t)(to - from) * width * sizeof(float));
    part.colour.data = (char *)all->colour.data + from * all->colour.row_bytes;
    part.colour.height = part.height = to - from;
    size_t n_changed = 0;
    const rf_result result = rf_depth_fill(NULL, &part, &n_changed, NULL);
    struct rf_image image = *f->depth;
    image.data = (char *)image.data + y * image.row_bytes;
    image.height = end - y;
    band += (size_t)(y - from) * width;
    const float *before = all->depth + (size_t)y * width;
    for (size_t i = 0; result == RF_OK && i < (size_t)(end - y) * width; i++)
        f->stats.n_filled += !isnan(before[i]) && band[i] != before[i];
    if (result == RF_OK && n_changed > 0)
        plugin_copy_pixels(&image, 1, band, true);
    return result;
}

static rf_result fill(struct filling *f, const bool *stop)
{
    rf_result result = rf_depth_measure(NULL, &f->channel, &f->stats, NULL);
    if (result != RF_OK || !(f->is_always || f->stats.is_speckled))
        return result;
    float *band = calloc((size_t)f->channel.width, MOST_ROWS * sizeof *band);
    if (!band)
        return RF_ERROR_MEMORY;
    for (int32_t y = 0; y < f->channel.height && result == RF_OK && !is_stopped(stop);
         y += BAND_ROWS)
        result = fill_band(f, y, band);
    free(band);
    return result;
}

static void run(void *data, const bool *stop)
{
    struct filling *f = data;
    f->result = fill(f, stop);
}

/* The same of images, as fill_depth() returns it. */
static PyObject *fill_images(const struct rf_image *depth,
                             const struct rf_image *colour, double infinity,
                             bool is_always)
{
    if (check_shapes(depth, colour) < 0)
        return NULL;
    struct filling f = {.channel = {plugin_packed(depth, 1), *colour, depth->width,
                                    depth->height, infinity},
                        .depth = depth,
                        .is_always = is_always,
                        .stats = {.size = sizeof f.stats}};
    if (!f.channel.depth)
        return NULL;
    const int status = plugin_run_aside(run, &f);
    free(f.channel.depth);
    if (status < 0)
        return NULL;
    if (f.result != RF_OK)
        return PyErr_NoMemory();
    return Py_BuildValue("(nd)", (Py_ssize_t)f.stats.n_filled, f.stats.hole_share);
}

PyObject *plugin_fill_depth(PyObject *module, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"depth", "colour", "infinity", "always", NULL};
    PyObject *objects[2];
    struct plugin_image opened[2];
    double infinity = 1e9;
    int is_always = 0;
    (void)module;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OO|$dp:fill_depth", names,
                                     &objects[0], &objects[1], &infinity, &is_always))
        return NULL;
    if (plugin_open_image(&opened[0], objects[0], names[0], true) < 0)
        return NULL;
    if (plugin_open_image(&opened[1], objects[1], names[1], false) < 0) {
        plugin_close_image(&opened[0]);
        return NULL;
    }
    PyObject *answer =
        fill_images(&opened[0].image, &opened[1].image, infinity, is_always != 0);
    plugin_close_image(&opened[0]);
    plugin_close_image(&opened[1]);
    return answer;
}
