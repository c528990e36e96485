/* SPDX-License-Identifier: Apache-2.0 */
/* The extension module rackfocus._core: limited API of Python 3.11. */
#include <stdlib.h>

#include "looks_given.h"
#include "module.h"

static PyObject *version(PyObject *module, PyObject *unused)
{
    return PyUnicode_FromString(rf_version());
}

static PyObject *cpu_level(PyObject *module, PyObject *unused)
{
    struct rf_context *context;
    struct rf_error error;
    struct rf_context_params about = {.size = sizeof about,
                                      .cpu = getenv("RACKFOCUS_CPU")};
    if (rf_context_create(&context, &about, &error) != RF_OK)
        return plugin_raise(PyModule_GetState(module), &error);
    PyObject *name = PyUnicode_FromString(rf_context_cpu(context));
    rf_context_destroy(context);
    return name;
}

/* The looks that come with the program. */
static PyObject *looks(PyObject *module, PyObject *unused)
{
    PyObject *list = PyList_New(0);
    for (const struct look_given *look = looks_given; list && look->name; look++) {
        PyObject *row = Py_BuildValue("(ss)", look->name, look->text);
        if (!row || PyList_Append(list, row) < 0)
            Py_CLEAR(list);
        Py_XDECREF(row);
    }
    return list;
}

static PyMethodDef functions[] = {
    {"version", version, METH_NOARGS,
     "version($module, /)\n--\n\nVersion of the library, '0.1.0'."},
    {"cpu_level", cpu_level, METH_NOARGS,
     "cpu_level($module, /)\n--\n\nInstruction set that the inner loops of the filter "
     "use on "
     "this machine: 'generic', 'sse4', 'avx2' or 'avx512'. The environment variable "
     "RACKFOCUS_CPU chooses another; avx512 is only taken when asked for."},
    {"looks", looks, METH_NOARGS,
     "looks($module, /)\n--\n\nThe looks of lenses that come with the program, as "
     "(name, text of its file)."},
    {"parameters", plugin_parameters, METH_NOARGS, NULL},
    {"methods", plugin_methods, METH_NOARGS, NULL},
    {"why_not_read", (PyCFunction)(void (*)(void))plugin_why_not_read,
     METH_VARARGS | METH_KEYWORDS, NULL},
    {"lens_points", (PyCFunction)(void (*)(void))plugin_lens_points,
     METH_VARARGS | METH_KEYWORDS,
     "lens_points($module, n, /, *, frame=0, **parameters)\n--\n\n"
     "n points (2 to 1024) that share out the lens evenly, for views to accumulate or "
     "merge, as a tuple of (u, v, time): lens radii right and up of the middle as the "
     "camera sees it, and the moment within the shutter's time from 0 to 1. frame: its "
     "number, which matters with lens_random only. Parameters: lens_pattern, "
     "lens_random, lens_seed and those of the aperture."},
#ifdef PLUGIN_HAS_DENOISER
    {"finish", (PyCFunction)(void (*)(void))plugin_finish, METH_VARARGS | METH_KEYWORDS,
     NULL},
#endif
    {"compare", (PyCFunction)(void (*)(void))plugin_compare,
     METH_VARARGS | METH_KEYWORDS,
     "compare($module, /, a, b)\n--\n\n"
     "How far picture a is from the reference b; the figures of the command's compare."
     "\n\n"
     "a, b: (height, width, 1, 3 or 4) or (height, width) float32 of one size, "
     "scene-linear; grey stands for three channels alike, alpha is not compared.\n\n"
     "Returns a dict of\n"
     "psnr: dB, on linear values clipped to [0, 1]; inf where alike\n"
     "tpsnr: dB, on values clipped and raised to 1/2.2; inf where alike\n"
     "ssim: on the same values as tpsnr, 1 where alike\n"
     "rmse: of the linear values, not clipped\n"
     "energy_ratio: sum of a / sum of b; None where b is black\n"
     "max_error: largest difference of two linear values\n"
     "max_error_pixel: its (x, y) in px from the first row and column\n"
     "identical: whether all values are equal\n"
     "flip: LDR-FLIP of Andersson et al. 2020, 0 alike to 1"},
    {"fill_depth", (PyCFunction)(void (*)(void))plugin_fill_depth,
     METH_VARARGS | METH_KEYWORDS,
     "fill_depth($module, /, depth, colour, *, infinity=1e9, always=False)\n--\n\n"
     "Gives pixels without depth that fog made holes in a surface its depth, in place, "
     "as the command does.\n\n"
     "depth: (height, width) float32, planar or radial distances; 0, or infinity and "
     "more, is none. colour: of the same pixels. always: also where the picture alone "
     "does not tell fog, since you know that there is some; gaps of a pixel or two "
     "before a sky may be filled then.\n\n"
     "Returns (pixels filled, share of the pixels between two of one surface that were "
     "holes)."},
    {0},
};

static int add_type(PyObject *module, PyType_Spec *spec, PyTypeObject **kept)
{
    PyObject *type = PyType_FromModuleAndSpec(module, spec, NULL);
    if (!type)
        return -1;
    int status = PyModule_AddType(module, (PyTypeObject *)type);
    if (kept)
        *kept = (PyTypeObject *)type;
    else
        Py_DECREF(type);
    return status;
}

static int execute(PyObject *module)
{
    struct module_state *state = PyModule_GetState(module);
    if (plugin_add_errors(module, state) < 0)
        return -1;
    if (PyModule_AddIntConstant(module, "SURVEY_MARGIN", RF_SURVEY_MARGIN) < 0 ||
        add_type(module, &plugin_lens_spec, &state->lens_type) < 0)
        return -1;
    if (add_type(module, &plugin_context_spec, &state->context_type) < 0)
        return -1;
    if (add_type(module, &plugin_filter_spec, NULL) < 0)
        return -1;
    return add_type(module, &plugin_accumulator_spec, NULL);
}

static int traverse(PyObject *module, visitproc visit, void *arg)
{
    struct module_state *state = PyModule_GetState(module);
    Py_VISIT(state->error);
    Py_VISIT(state->parameter_error);
    Py_VISIT(state->depth_error);
    Py_VISIT(state->pixel_error);
    Py_VISIT(state->cancelled_error);
    Py_VISIT(state->unread_warning);
    Py_VISIT(state->views_warning);
    Py_VISIT(state->lens_type);
    Py_VISIT(state->context_type);
    return 0;
}

static int clear(PyObject *module)
{
    struct module_state *state = PyModule_GetState(module);
    Py_CLEAR(state->error);
    Py_CLEAR(state->parameter_error);
    Py_CLEAR(state->depth_error);
    Py_CLEAR(state->pixel_error);
    Py_CLEAR(state->cancelled_error);
    Py_CLEAR(state->unread_warning);
    Py_CLEAR(state->views_warning);
    Py_CLEAR(state->lens_type);
    Py_CLEAR(state->context_type);
    return 0;
}

static PyModuleDef_Slot slots[] = {
    {Py_mod_exec, (void *)execute},
    {0, NULL},
};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT,
    .m_name = "rackfocus._core",
    .m_size = sizeof(struct module_state),
    .m_methods = functions,
    .m_slots = slots,
    .m_traverse = traverse,
    .m_clear = clear,
};

PyMODINIT_FUNC PyInit__core(void)
{
    return PyModuleDef_Init(&definition);
}
