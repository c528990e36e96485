/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.Lens: the optics of one picture size. */
#include "module.h"

#include <structmember.h>

struct lens_object {
    PyObject ob_base;
    struct rf_lens lens;
};

PyObject *plugin_lens_new(const struct module_state *state, const struct rf_lens *lens)
{
    allocfunc allocate = (allocfunc)PyType_GetSlot(state->lens_type, Py_tp_alloc);
    struct lens_object *self = (struct lens_object *)allocate(state->lens_type, 0);
    if (self)
        self->lens = *lens;
    return (PyObject *)self;
}

static PyObject *lens_create(PyTypeObject *type, PyObject *args, PyObject *keywords)
{
    const struct module_state *state = PyType_GetModuleState(type);
    int width, height;
    struct rf_params params;
    struct rf_error error;
    struct rf_lens lens;
    if (!state ||
        !PyArg_ParseTuple(args, "O&O&:Lens", plugin_take_int, &width, plugin_take_int,
                          &height) ||
        plugin_read_params(state, keywords, &params) < 0)
        return NULL;
    if (width < 1 || height < 1) {
        plugin_fail(width < 1 ? "width" : "height", "must be at least 1");
        return NULL;
    }
    if (rf_lens_init(&lens, &params, width, height, &error) != RF_OK)
        return plugin_raise(state, &error);
    return plugin_lens_new(state, &lens);
}

static void lens_dealloc(PyObject *self)
{
    PyTypeObject *type = Py_TYPE(self);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(self);
    Py_DECREF(type);
}

static const struct rf_lens *lens_of(PyObject *self)
{
    return &((struct lens_object *)self)->lens;
}

static PyObject *lens_radius(PyObject *self, PyObject *argument)
{
    double z = PyFloat_AsDouble(argument);
    if (z == -1 && PyErr_Occurred())
        return NULL;
    if (!(z > 0)) {
        plugin_fail("z", "a depth must be above 0");
        return NULL;
    }
    return PyFloat_FromDouble(rf_lens_radius_px(lens_of(self), z));
}

static PyObject *lens_depth_at(PyObject *self, PyObject *argument)
{
    double r_px = PyFloat_AsDouble(argument);
    if (r_px == -1 && PyErr_Occurred())
        return NULL;
    return PyFloat_FromDouble(rf_lens_depth_at(lens_of(self), r_px));
}

static PyObject *lens_depth_of_field(PyObject *self, PyObject *unused)
{
    double near_limit, far_limit;
    rf_lens_depth_of_field(lens_of(self), &near_limit, &far_limit);
    return Py_BuildValue("(dd)", near_limit, far_limit);
}

static PyObject *lens_hyperfocal(PyObject *self, PyObject *unused)
{
    return PyFloat_FromDouble(rf_lens_hyperfocal(lens_of(self)));
}

static PyMethodDef lens_methods[] = {
    {"radius_px", lens_radius, METH_O,
     "radius_px($self, z, /)\n--\n\nSigned radius of the circle of confusion in px of "
     "a point at "
     "the planar depth z (scene units, above 0, may be inf)."},
    {"depth_at", lens_depth_at, METH_O,
     "depth_at($self, radius_px, /)\n--\n\nPlanar depth in scene units whose signed "
     "radius is "
     "radius_px; inf where there is none beyond."},
    {"depth_of_field", lens_depth_of_field, METH_NOARGS,
     "depth_of_field($self, /)\n--\n\n(near, far) in scene units: between them the "
     "radius "
     "stays "
     "below coc_limit; far may be inf."},
    {"hyperfocal", lens_hyperfocal, METH_NOARGS,
     "hyperfocal($self, /)\n--\n\nFocus distance in scene units whose far limit is "
     "infinity."},
    {0},
};

#define MEMBER(name, doc)                                                              \
    {                                                                                  \
#name, T_DOUBLE, offsetof(struct lens_object, lens.name), READONLY, doc        \
    }

static PyMemberDef lens_members[] = {
    MEMBER(focus_distance, "Distance of the plane in focus, scene units."),
    MEMBER(lens_radius, "Radius of the aperture, scene units."),
    MEMBER(focal_length_px, "Focal length in px; 0 for orthographic cameras."),
    MEMBER(px_per_unit, "Orthographic cameras: px per scene unit; else 0."),
    MEMBER(max_radius_px, "Radii are clipped to this, px."),
    MEMBER(coc_limit_px, "Radius that still counts as sharp, px."),
    MEMBER(bias_px, "The radius is bias_px + scale / z (orthographic: scale * z)."),
    MEMBER(scale, "See bias_px."),
    {0},
};

static PyType_Slot lens_slots[] = {
    {Py_tp_doc, "Lens(width, height, /, **parameters)\n--\n\nThe lens resolved for a "
                "picture of width x height px. Parameters as in parameters()."},
    {Py_tp_new, lens_create},
    {Py_tp_dealloc, lens_dealloc},
    {Py_tp_methods, lens_methods},
    {Py_tp_members, lens_members},
    {0, NULL},
};

PyType_Spec plugin_lens_spec = {
    .name = "rackfocus.Lens",
    .basicsize = sizeof(struct lens_object),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE,
    .slots = lens_slots,
};
