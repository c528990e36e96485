/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.Filter: what is seen in mirrors and through glass, and how far away. */
#include "module.h"

/* ---- lights of a frame ---------------------------------------------------------- */

static int open_light(void *user, PyObject *about)
{
    struct plugin_seen *seen = user;
    static const char *const names[] = {"seen: light", "seen: depth"};
    PyObject *objects[2];
    if (!PyTuple_Check(about)) {
        PyErr_SetString(PyExc_TypeError, "seen: each must be a tuple (light, depth)");
        return -1;
    }
    if (!PyArg_ParseTuple(about, "OO:seen", &objects[0], &objects[1]))
        return -1;
    for (int k = 0; k < 2; k++, seen->n_images++)
        if (plugin_open_image(&seen->images[seen->n_images], objects[k], names[k],
                              false) < 0)
            return -1;
    seen->lights[seen->n_images / 2 - 1] = (struct rf_seen_light){
        seen->images[seen->n_images - 2].image, seen->images[seen->n_images - 1].image};
    return 0;
}

int plugin_open_seen(struct plugin_seen *seen, PyObject *sequence, struct rf_view *view)
{
    seen->n_images = 0;
    if (sequence == Py_None)
        return 0;
    const struct plugin_range range = {"seen", 0, RF_MAX_SEEN};
    const int n = plugin_open_each(sequence, range, open_light, seen);
    if (n < 0)
        return -1;
    view->seen = seen->lights;
    view->n_seen = n;
    return 0;
}

void plugin_close_seen(struct plugin_seen *seen)
{
    while (seen->n_images > 0)
        plugin_close_image(&seen->images[--seen->n_images]);
}

/* ---- lights of several views ---------------------------------------------------- */

/* Those of the views that were opened so far. */
struct plugin_view_lights {
    struct plugin_views *views;
    int n;
    struct plugin_seen seen[RF_MAX_VIEWS];
};

static int open_lights(void *user, PyObject *about)
{
    struct plugin_view_lights *open = user;
    const int j = open->n++;
    return plugin_open_seen(&open->seen[j], about, &open->views->views[j]);
}

struct plugin_view_lights *plugin_open_view_lights(PyObject *sequence,
                                                   struct plugin_views *views)
{
    struct plugin_view_lights *open = PyMem_Calloc(1, sizeof *open);
    if (!open) {
        PyErr_NoMemory();
        return NULL;
    }
    open->views = views;
    const struct plugin_range range = {"seen", views->n, views->n};
    if (sequence == Py_None || plugin_open_each(sequence, range, open_lights, open) > 0)
        return open;
    plugin_close_view_lights(open);
    return NULL;
}

void plugin_close_view_lights(struct plugin_view_lights *open)
{
    while (open && open->n > 0)
        plugin_close_seen(&open->seen[--open->n]);
    PyMem_Free(open);
}

/* ---- their depth ---------------------------------------------------------------- */

/* One light from several points of the lens. */
struct open_lights {
    struct rf_view views[RF_MAX_VIEWS];
    struct rf_image lights[RF_MAX_VIEWS];
    struct plugin_image images[RF_MAX_VIEWS];
    int n;
};

static int open_place(void *user, PyObject *about)
{
    struct open_lights *open = user;
    struct rf_view *view = &open->views[open->n];
    PyObject *light;
    view->size = sizeof *view;
    if (!PyTuple_Check(about)) {
        PyErr_Format(PyExc_TypeError,
                     "lights: number %d must be a tuple (light, (u, v), "
                     "shear_distance)",
                     open->n);
        return -1;
    }
    if (!PyArg_ParseTuple(about, "O(dd)d:light", &light, &view->lens_offset[0],
                          &view->lens_offset[1], &view->shear_distance) ||
        plugin_open_image(&open->images[open->n], light, "lights", false) < 0)
        return -1;
    open->lights[open->n] = open->images[open->n].image;
    open->n++;
    return 0;
}

/* Opens so many images, the last one to write to; returns how many were. */
static int open_images(struct plugin_image *images, PyObject *const *objects,
                       char *const *names, int n)
{
    int n_open = 0;
    while (n_open < n && plugin_open_image(&images[n_open], objects[n_open],
                                           names[n_open], n_open == n - 1) == 0)
        n_open++;
    return n_open;
}

static PyObject *answer(PyObject *object, rf_result result,
                        const struct rf_error *error)
{
    if (result != RF_OK)
        return plugin_raise(PyType_GetModuleState(Py_TYPE(object)), error);
    return Py_NewRef(Py_None);
}

PyObject *plugin_filter_seen_depth(PyObject *object, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"colour", "depth", "lights", "out", NULL};
    static char *image_names[] = {"colour", "depth", "out"};
    PyObject *objects[3], *sequence, *made = NULL;
    struct plugin_image images[3];
    struct rf_error error;
    rf_result result;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOOO:seen_depth", names,
                                     &objects[0], &objects[1], &sequence, &objects[2]))
        return NULL;
    struct open_lights *open = PyMem_Calloc(1, sizeof *open);
    if (!open)
        return PyErr_NoMemory();
    int n_open = open_images(images, objects, image_names, 3);
    const struct plugin_range range = {"lights", 2, RF_MAX_VIEWS};
    if (n_open == 3 && plugin_open_each(sequence, range, open_place, open) > 0) {
        open->views[0].size = sizeof *open->views;
        open->views[0].colour = images[0].image;
        open->views[0].depth = images[1].image;
        Py_BEGIN_ALLOW_THREADS;
        result =
            rf_filter_seen_depth(((struct plugin_filter *)object)->filter, open->views,
                                 open->n, open->lights, &images[2].image, &error);
        Py_END_ALLOW_THREADS;
        made = answer(object, result, &error);
    }
    while (n_open > 0)
        plugin_close_image(&images[--n_open]);
    while (open->n > 0)
        plugin_close_image(&open->images[--open->n]);
    PyMem_Free(open);
    return made;
}

PyObject *plugin_filter_seen_way(PyObject *object, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"colour", "depth", "light", "way", "out", NULL};
    PyObject *objects[5], *made = NULL;
    struct plugin_image images[5];
    struct rf_error error;
    rf_result result;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOOOO:seen_way", names,
                                     &objects[0], &objects[1], &objects[2], &objects[3],
                                     &objects[4]))
        return NULL;
    int n_open = open_images(images, objects, names, 5);
    if (n_open == 5) {
        const struct rf_view view = {
            .size = sizeof view, .colour = images[0].image, .depth = images[1].image};
        Py_BEGIN_ALLOW_THREADS;
        result = rf_filter_seen_way(((struct plugin_filter *)object)->filter, &view,
                                    &images[2].image, &images[3].image,
                                    &images[4].image, &error);
        Py_END_ALLOW_THREADS;
        made = answer(object, result, &error);
    }
    while (n_open > 0)
        plugin_close_image(&images[--n_open]);
    return made;
}
