/* SPDX-License-Identifier: Apache-2.0 */
/* The extension module rackfocus._core: limited API of Python 3.11. */
#include "module.h"

static PyObject *version(PyObject *module, PyObject *unused)
{
    return PyUnicode_FromString(rf_version());
}

static PyObject *cpu_level(PyObject *module, PyObject *unused)
{
#if defined(__AVX2__)
    return PyUnicode_FromString("x86-64, AVX2");
#elif defined(__SSE4_1__)
    return PyUnicode_FromString("x86-64, SSE4.1");
#elif defined(__x86_64__)
    return PyUnicode_FromString("x86-64, SSE2");
#elif defined(__aarch64__)
    return PyUnicode_FromString("aarch64, NEON");
#else
    return PyUnicode_FromString("generic");
#endif
}

static PyMethodDef functions[] = {
    {"version", version, METH_NOARGS,
     "version()\n--\n\nVersion of the library, '0.1.0'."},
    {"cpu_level", cpu_level, METH_NOARGS,
     "cpu_level()\n--\n\nInstruction set that the filter uses."},
    {"parameters", plugin_parameters, METH_NOARGS, NULL},
    {"methods", plugin_methods, METH_NOARGS, NULL},
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
    if (add_type(module, &plugin_lens_spec, &state->lens_type) < 0)
        return -1;
    return add_type(module, &plugin_filter_spec, NULL);
}

static int traverse(PyObject *module, visitproc visit, void *arg)
{
    struct module_state *state = PyModule_GetState(module);
    Py_VISIT(state->error);
    Py_VISIT(state->parameter_error);
    Py_VISIT(state->depth_error);
    Py_VISIT(state->pixel_error);
    Py_VISIT(state->cancelled_error);
    Py_VISIT(state->lens_type);
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
    Py_CLEAR(state->lens_type);
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
