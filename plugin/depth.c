/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.fill_depth(): the holes that fog leaves in a depth. */
#include <math.h>
#include <stdlib.h>

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

/* Fills a packed depth; `stats` receives n_filled, and what there was before. */
static rf_result fill(struct rf_depth_channel *channel, bool is_always,
                      struct rf_depth_stats *stats)
{
    rf_result result = rf_depth_measure(NULL, channel, stats, NULL);
    if (result == RF_OK && (is_always || stats->is_speckled))
        result = rf_depth_fill(NULL, channel, &stats->n_filled, NULL);
    return result;
}

/* The same of images, as fill_depth() returns it. */
static PyObject *fill_images(const struct rf_image *depth,
                             const struct rf_image *colour, double infinity,
                             bool is_always)
{
    struct rf_depth_stats stats = {.size = sizeof stats};
    rf_result result;
    if (check_shapes(depth, colour) < 0)
        return NULL;
    struct rf_depth_channel channel = {plugin_packed(depth, 1), *colour, depth->width,
                                       depth->height, infinity};
    if (!channel.depth)
        return NULL;
    Py_BEGIN_ALLOW_THREADS;
    result = fill(&channel, is_always, &stats);
    if (result == RF_OK && stats.n_filled > 0)
        plugin_copy_pixels(depth, 1, channel.depth, true);
    Py_END_ALLOW_THREADS;
    free(channel.depth);
    if (result != RF_OK)
        return PyErr_NoMemory();
    return Py_BuildValue("(nd)", (Py_ssize_t)stats.n_filled, stats.hole_share);
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
