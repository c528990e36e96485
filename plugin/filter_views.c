/* SPDX-License-Identifier: Apache-2.0 */
/* Several views of one frame, as Python gives them; the progress of work on them. */
#include "module.h"

/* The callback runs without the lock of the interpreter; this takes it for a moment. */
bool plugin_report(void *user, double fraction)
{
    struct plugin_progress *progress = user;
    if (progress->has_raised)
        return false;
    PyEval_RestoreThread(progress->thread);
    PyObject *answer = PyObject_CallFunction(progress->function, "d", fraction);
    int goes_on = answer ? answer == Py_None || PyObject_IsTrue(answer) : -1;
    progress->has_raised = goes_on < 0;
    Py_XDECREF(answer);
    progress->thread = PyEval_SaveThread();
    return goes_on > 0;
}

void plugin_close_views(struct plugin_views *open)
{
    while (open->n_images > 0)
        plugin_close_image(&open->images[--open->n_images]);
    PyMem_Free(open);
}

/* Opens the next view from its tuple (colour, depth, (u, v), shear distance). */
static int open_view(void *user, PyObject *about)
{
    static const char *const names[] = {"colour", "depth"};
    struct plugin_views *open = user;
    struct rf_view *view = &open->views[open->n];
    PyObject *objects[2];
    if (!PyTuple_Check(about) || PyTuple_Size(about) != 4 ||
        !PyArg_ParseTuple(about, "OO(dd)d:view", &objects[0], &objects[1],
                          &view->lens_offset[0], &view->lens_offset[1],
                          &view->shear_distance)) {
        PyErr_Format(PyExc_TypeError,
                     "views: view %d must be a rackfocus.View, or a tuple (colour, "
                     "depth, (u, v), shear_distance) of it",
                     open->n);
        return -1;
    }
    for (int k = 0; k < 2; k++, open->n_images++)
        if (plugin_open_image(&open->images[open->n_images], objects[k], names[k],
                              false) < 0)
            return -1;
    view->colour = open->images[open->n_images - 2].image;
    view->depth = open->images[open->n_images - 1].image;
    open->n++;
    return 0;
}

struct plugin_views *plugin_open_views(PyObject *sequence)
{
    struct plugin_views *open = PyMem_Calloc(1, sizeof *open);
    if (!open) {
        PyErr_NoMemory();
        return NULL;
    }
    const struct plugin_range range = {"views", 1, RF_MAX_VIEWS};
    if (plugin_open_each(sequence, range, open_view, open) > 0)
        return open;
    plugin_close_views(open);
    return NULL;
}
