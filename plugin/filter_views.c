/* SPDX-License-Identifier: Apache-2.0 */
/* Several views of one frame, as Python gives them; the progress of work on them. */
#include "module.h"

int plugin_is_main_thread(void)
{
    PyObject *module = PyImport_ImportModule("threading");
    PyObject *thread = module ? PyObject_CallMethod(module, "main_thread", NULL) : NULL;
    PyObject *ident = thread ? PyObject_GetAttrString(thread, "ident") : NULL;
    const unsigned long number = ident ? PyLong_AsUnsignedLongMask(ident) : 0;
    Py_XDECREF(ident);
    Py_XDECREF(thread);
    Py_XDECREF(module);
    return PyErr_Occurred() ? -1 : number == PyThread_get_thread_ident();
}

int plugin_start_progress(struct plugin_progress *progress, PyObject *function)
{
    const int is_main = plugin_is_main_thread();
    if (is_main < 0)
        return -1;
    *progress =
        (struct plugin_progress){.function = function == Py_None ? NULL : function,
                                 .handles_signals = is_main > 0,
                                 .handled = clock()};
    progress->thread = PyEval_SaveThread();
    return 0;
}

void plugin_end_progress(struct plugin_progress *progress)
{
    PyEval_RestoreThread(progress->thread);
}

/* Asks the function whether to go on; -1 with an exception. */
static int ask(PyObject *function, double fraction)
{
    PyObject *answer = PyObject_CallFunction(function, "d", fraction);
    const int goes_on = !answer ? -1 : answer == Py_None ? 1 : PyObject_IsTrue(answer);
    Py_XDECREF(answer);
    return goes_on;
}

/* Other threads may hold the lock for a while, so it is not taken for nothing. */
bool plugin_report(void *user, double fraction)
{
    struct plugin_progress *progress = user;
    int goes_on = 1;
    if (progress->has_raised)
        return false;
    const bool is_time =
        progress->handles_signals && clock() - progress->handled > CLOCKS_PER_SEC / 10;
    if (!progress->function && !is_time)
        return true;
    PyEval_RestoreThread(progress->thread);
    if (progress->function)
        goes_on = ask(progress->function, fraction);
    if (goes_on >= 0 && is_time && PyErr_CheckSignals() < 0)
        goes_on = -1;
    progress->has_raised = goes_on < 0;
    progress->thread = PyEval_SaveThread();
    progress->handled = is_time ? clock() : progress->handled;
    return goes_on > 0;
}

void plugin_close_views(struct plugin_views *open)
{
    while (open->n_images > 0)
        plugin_close_image(&open->images[--open->n_images]);
    PyMem_Free(open);
}

/* Opens the next view from its tuple (colour, depth, (u, v), shear distance[, mean
 * depth]). */
static int open_view(void *user, PyObject *about)
{
    static const char *const names[] = {"colour", "depth", "mean_depth"};
    struct plugin_views *open = user;
    struct rf_view *view = &open->views[open->n];
    PyObject *objects[3] = {NULL, NULL, Py_None};
    if (!PyTuple_Check(about) || PyTuple_Size(about) < 4 || PyTuple_Size(about) > 5 ||
        !PyArg_ParseTuple(about, "OO(dd)d|O:view", &objects[0], &objects[1],
                          &view->lens_offset[0], &view->lens_offset[1],
                          &view->shear_distance, &objects[2])) {
        PyErr_Format(PyExc_TypeError,
                     "views: view %d must be a rackfocus.View, or a tuple (colour, "
                     "depth, (u, v), shear_distance[, mean_depth]) of it",
                     open->n);
        return -1;
    }
    const int n = objects[2] == Py_None ? 2 : 3;
    for (int k = 0; k < n; k++, open->n_images++)
        if (plugin_open_image(&open->images[open->n_images], objects[k], names[k],
                              false) < 0)
            return -1;
    const struct plugin_image *images = &open->images[open->n_images - n];
    view->colour = images[0].image;
    view->depth = images[1].image;
    if (n == 3)
        view->mean_depth = images[2].image;
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
