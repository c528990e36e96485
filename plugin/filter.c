/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.Filter: one size and one set of parameters, any number of frames. */
#include "module.h"

struct filter_object {
    PyObject ob_base;
    struct rf_context *context;
    struct rf_filter *filter;
};

/* ---- making and ending --------------------------------------------------------- */

int plugin_take_threads(PyObject *keywords, int *n_threads)
{
    *n_threads = 0;
    PyObject *value = keywords ? PyDict_GetItemString(keywords, "threads") : NULL;
    if (!value)
        return 0;
    long number = PyLong_AsLong(value);
    if (number == -1 && PyErr_Occurred())
        return -1;
    *n_threads = number < -1 || number > INT16_MAX ? INT16_MAX : (int)number;
    return PyDict_DelItemString(keywords, "threads");
}

static rf_result build(struct filter_object *self, const struct rf_params *params,
                       const int size_px[2], int n_threads, struct rf_error *error)
{
    struct rf_context_params about = {.size = sizeof about, .n_threads = n_threads};
    rf_result result = rf_context_create(&self->context, &about, error);
    if (result != RF_OK)
        return result;
    return rf_filter_create(&self->filter, self->context, params, size_px[0],
                            size_px[1], error);
}

static PyObject *filter_create(PyTypeObject *type, PyObject *args, PyObject *keywords)
{
    const struct module_state *state = PyType_GetModuleState(type);
    int size_px[2], n_threads;
    struct rf_params params;
    if (!state || !PyArg_ParseTuple(args, "ii:Filter", &size_px[0], &size_px[1]))
        return NULL;
    PyObject *rest = keywords ? PyDict_Copy(keywords) : PyDict_New();
    bool is_read = rest && plugin_take_threads(rest, &n_threads) == 0 &&
                   plugin_read_params(state, rest, &params) == 0;
    Py_XDECREF(rest);
    if (!is_read)
        return NULL;
    allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
    struct filter_object *self = (struct filter_object *)allocate(type, 0);
    struct rf_error error;
    if (self && build(self, &params, size_px, n_threads, &error) != RF_OK) {
        plugin_raise(state, &error);
        Py_CLEAR(self);
    }
    return (PyObject *)self;
}

static void filter_dealloc(PyObject *object)
{
    struct filter_object *self = (struct filter_object *)object;
    rf_filter_destroy(self->filter);
    rf_context_destroy(self->context);
    PyTypeObject *type = Py_TYPE(object);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(object);
    Py_DECREF(type);
}

/* ---- one frame ----------------------------------------------------------------- */

/* The callback runs without the lock of the interpreter; this takes it for a moment. */
struct progress {
    PyObject *function;
    PyThreadState *thread;
    bool has_raised;
};

static bool report(void *user, double fraction)
{
    struct progress *progress = user;
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

static rf_result process(const struct filter_object *self, const struct rf_view *view,
                         const struct rf_image *out, struct progress *progress,
                         struct rf_error *error)
{
    struct rf_progress callback = {report, progress};
    const struct rf_progress *given = progress->function ? &callback : NULL;
    progress->thread = PyEval_SaveThread();
    rf_result result = rf_filter_process(self->filter, view, 1, out, given, error);
    PyEval_RestoreThread(progress->thread);
    return result;
}

static PyObject *filter_process(PyObject *object, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"colour", "depth", "out", "progress", NULL};
    PyObject *objects[3], *function = Py_None, *answer = NULL;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOO|O:process", names,
                                     &objects[0], &objects[1], &objects[2], &function))
        return NULL;
    const struct module_state *state = PyType_GetModuleState(Py_TYPE(object));
    struct plugin_image images[3];
    int n_open = 0;
    while (n_open < 3 && plugin_open_image(&images[n_open], objects[n_open],
                                           names[n_open], n_open == 2) == 0)
        n_open++;
    if (n_open == 3) {
        struct rf_view view = {.colour = images[0].image, .depth = images[1].image};
        struct progress progress = {function == Py_None ? NULL : function, NULL, false};
        struct rf_error error;
        rf_result result = process((struct filter_object *)object, &view,
                                   &images[2].image, &progress, &error);
        if (progress.has_raised)
            answer = NULL;
        else
            answer = result == RF_OK ? Py_NewRef(Py_None) : plugin_raise(state, &error);
    }
    while (n_open > 0)
        plugin_close_image(&images[--n_open]);
    return answer;
}

typedef rf_result convert_function(const struct rf_filter *, const struct rf_image *,
                                   const struct rf_image *, struct rf_error *);

static PyObject *convert(PyObject *object, PyObject *args, PyObject *keywords,
                         convert_function *function)
{
    static char *names[] = {"depth", "out", NULL};
    PyObject *depth, *out;
    struct plugin_image from, to;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OO", names, &depth, &out) ||
        plugin_open_image(&from, depth, "depth", false) < 0)
        return NULL;
    if (plugin_open_image(&to, out, "out", true) < 0) {
        plugin_close_image(&from);
        return NULL;
    }
    const struct filter_object *self = (struct filter_object *)object;
    struct rf_error error;
    rf_result result;
    Py_BEGIN_ALLOW_THREADS;
    result = function(self->filter, &from.image, &to.image, &error);
    Py_END_ALLOW_THREADS;
    plugin_close_image(&from);
    plugin_close_image(&to);
    if (result != RF_OK)
        return plugin_raise(PyType_GetModuleState(Py_TYPE(object)), &error);
    return Py_NewRef(Py_None);
}

static PyObject *filter_coc(PyObject *self, PyObject *args, PyObject *keywords)
{
    return convert(self, args, keywords, rf_filter_coc);
}

static PyObject *filter_planar_depth(PyObject *self, PyObject *args, PyObject *keywords)
{
    return convert(self, args, keywords, rf_filter_planar_depth);
}

/* ---- the type ------------------------------------------------------------------ */

static PyObject *get_lens(PyObject *object, void *unused)
{
    const struct module_state *state = PyType_GetModuleState(Py_TYPE(object));
    return plugin_lens_new(state,
                           rf_filter_lens(((struct filter_object *)object)->filter));
}

static PyObject *get_threads(PyObject *object, void *unused)
{
    return PyLong_FromLong(
        rf_context_threads(((struct filter_object *)object)->context));
}

static PyGetSetDef filter_getset[] = {
    {"lens", get_lens, NULL, "The Lens that the filter uses.", NULL},
    {"threads", get_threads, NULL, "Threads that a frame is filtered on.", NULL},
    {0},
};

#define KEYWORDS(function) (PyCFunction)(void (*)(void)) function

static PyMethodDef filter_methods[] = {
    {"process", KEYWORDS(filter_process), METH_VARARGS | METH_KEYWORDS,
     "process(colour, depth, out, progress=None)\n--\n\n"
     "Filters one frame.\n\n"
     "colour: (height, width, 1, 3 or 4) or (height, width) float32, scene-linear, "
     "alpha premultiplied.\n"
     "depth: (height, width) float32 in the convention of the parameter depth.\n"
     "out: writable, same shape as colour; may be the same memory.\n"
     "progress: called with a fraction from 0 to 1; False cancels."},
    {"coc", KEYWORDS(filter_coc), METH_VARARGS | METH_KEYWORDS,
     "coc(depth, out)\n--\n\nSigned radius of every pixel in px; both (height, width) "
     "float32, out may be the same memory."},
    {"planar_depth", KEYWORDS(filter_planar_depth), METH_VARARGS | METH_KEYWORDS,
     "planar_depth(depth, out)\n--\n\nPlanar distance of every pixel in scene units, "
     "inf where nothing was hit; shapes as in coc()."},
    {0},
};

static PyType_Slot filter_slots[] = {
    {Py_tp_doc,
     "Filter(width, height, *, threads=0, **parameters)\n--\n\nA filter for pictures "
     "of "
     "width x height px. threads: 0 takes all processors. Parameters as in "
     "parameters(), by field name; enumerated ones by name. Immutable; may be shared "
     "by threads, and process() releases the lock of the interpreter."},
    {Py_tp_new, filter_create},
    {Py_tp_dealloc, filter_dealloc},
    {Py_tp_methods, filter_methods},
    {Py_tp_getset, filter_getset},
    {0, NULL},
};

PyType_Spec plugin_filter_spec = {
    .name = "rackfocus.Filter",
    .basicsize = sizeof(struct filter_object),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE,
    .slots = filter_slots,
};
