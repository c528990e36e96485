/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.Accumulator and lens_points(): views from points of the lens. */
#include "module.h"

struct accumulator_object {
    PyObject ob_base;
    PyObject *context; /* held */
    struct rf_accumulator *accumulator;
};

static PyObject *accumulator_create(PyTypeObject *type, PyObject *args,
                                    PyObject *keywords)
{
    const struct module_state *state = PyType_GetModuleState(type);
    int shape[3];
    struct rf_params params;
    PyObject *context = NULL;
    if (!state ||
        !PyArg_ParseTuple(args, "O&O&O&:Accumulator", plugin_take_int, &shape[0],
                          plugin_take_int, &shape[1], plugin_take_int, &shape[2]))
        return NULL;
    PyObject *rest = keywords ? PyDict_Copy(keywords) : PyDict_New();
    bool is_read = rest && plugin_take_context(state, rest, &context) == 0 &&
                   plugin_read_params(state, rest, &params) == 0 &&
                   plugin_warn_unread(state, rest, &params, true) == 0;
    Py_XDECREF(rest);
    if (!is_read) {
        Py_XDECREF(context);
        return NULL;
    }
    allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
    struct accumulator_object *self = (struct accumulator_object *)allocate(type, 0);
    struct rf_error error;
    if (self)
        self->context = Py_NewRef(context);
    if (self &&
        rf_accumulator_create(&self->accumulator, plugin_context_of(context), &params,
                              shape[0], shape[1], shape[2], &error) != RF_OK) {
        plugin_raise(state, &error);
        Py_CLEAR(self);
    }
    Py_DECREF(context);
    return (PyObject *)self;
}

static void accumulator_dealloc(PyObject *object)
{
    struct accumulator_object *self = (struct accumulator_object *)object;
    rf_accumulator_destroy(self->accumulator);
    Py_XDECREF(self->context);
    PyTypeObject *type = Py_TYPE(object);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(object);
    Py_DECREF(type);
}

/* The lock of the interpreter is held: sums of two threads would race. */
static PyObject *accumulator_add(PyObject *object, PyObject *colour)
{
    struct accumulator_object *self = (struct accumulator_object *)object;
    struct plugin_image image;
    struct rf_error error;
    if (plugin_open_image(&image, colour, "colour", false) < 0)
        return NULL;
    rf_result result = rf_accumulator_add(self->accumulator, &image.image, &error);
    plugin_close_image(&image);
    if (result != RF_OK)
        return plugin_raise(PyType_GetModuleState(Py_TYPE(object)), &error);
    return Py_NewRef(Py_None);
}

static PyObject *accumulator_mean(PyObject *object, PyObject *out)
{
    struct accumulator_object *self = (struct accumulator_object *)object;
    struct plugin_image image;
    struct rf_error error;
    if (plugin_open_image(&image, out, "out", true) < 0)
        return NULL;
    rf_result result = rf_accumulator_mean(self->accumulator, &image.image, &error);
    plugin_close_image(&image);
    if (result != RF_OK)
        return plugin_raise(PyType_GetModuleState(Py_TYPE(object)), &error);
    return Py_NewRef(Py_None);
}

static PyObject *get_count(PyObject *object, void *unused)
{
    return PyLong_FromLongLong(
        rf_accumulator_count(((struct accumulator_object *)object)->accumulator));
}

static PyGetSetDef accumulator_getset[] = {
    {"count", get_count, NULL, "How many pictures have been added.", NULL},
    {0},
};

static PyMethodDef accumulator_methods[] = {
    {"add", accumulator_add, METH_O,
     "add($self, colour, /)\n--\n\nAdds one picture, (height, width, channels) "
     "float32, "
     "scene-linear, alpha premultiplied; (height, width) for one channel. PixelError "
     "for NaN and infinity, and then nothing was added."},
    {"mean", accumulator_mean, METH_O,
     "mean($self, out, /)\n--\n\nWrites the mean of what was added so far into a "
     "picture of the "
     "same shape."},
    {0},
};

static PyType_Slot accumulator_slots[] = {
    {Py_tp_doc,
     "Accumulator(width, height, channels, /, *, context=None, threads=0, "
     "**parameters)\n--\n\n"
     "The mean of any number of pictures, one in memory at a time. channels: 1, 3 or "
     "4. threads: 0 takes all processors. Of the parameters those of highlights matter "
     "and blend_gamma, of which 1 (default) sums linear light."},
    {Py_tp_new, accumulator_create},
    {Py_tp_dealloc, accumulator_dealloc},
    {Py_tp_methods, accumulator_methods},
    {Py_tp_getset, accumulator_getset},
    {0, NULL},
};

PyType_Spec plugin_accumulator_spec = {
    .name = "rackfocus.Accumulator",
    .basicsize = sizeof(struct accumulator_object),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE,
    .slots = accumulator_slots,
};

/* ---- lens_points ---------------------------------------------------------------- */

/* Takes the keyword `frame` out of `keywords`; -1 with an exception set. */
static int take_frame(PyObject *keywords, int *frame)
{
    *frame = 0;
    PyObject *value = PyDict_GetItemString(keywords, "frame");
    if (!value)
        return 0;
    if (!plugin_take_int(value, frame))
        return -1;
    return PyDict_DelItemString(keywords, "frame");
}

static PyObject *list_points(const struct rf_lens_point *points, int n)
{
    PyObject *list = PyTuple_New(n);
    for (int i = 0; list && i < n; i++) {
        PyObject *item =
            Py_BuildValue("(ddd)", points[i].u, points[i].v, points[i].time);
        if (!item || PyTuple_SetItem(list, i, item) < 0)
            Py_CLEAR(list);
    }
    return list;
}

PyObject *plugin_lens_points(PyObject *module, PyObject *args, PyObject *keywords)
{
    const struct module_state *state = PyModule_GetState(module);
    int n, frame;
    struct rf_params params;
    struct rf_error error;
    struct rf_lens_point points[RF_MAX_LENS_POINTS];
    if (!PyArg_ParseTuple(args, "O&:lens_points", plugin_take_int, &n))
        return NULL;
    PyObject *rest = keywords ? PyDict_Copy(keywords) : PyDict_New();
    bool is_read = rest && take_frame(rest, &frame) == 0 &&
                   plugin_read_params(state, rest, &params) == 0;
    Py_XDECREF(rest);
    if (!is_read)
        return NULL;
    if (rf_lens_points(&params, n, frame, points, &error) != RF_OK)
        return plugin_raise(state, &error);
    return list_points(points, n);
}
