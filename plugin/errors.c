/* SPDX-License-Identifier: Apache-2.0 */
#include "module.h"

static PyObject *add_class(PyObject *module, const char *name, const char *doc,
                           PyObject *bases)
{
    char path[64];
    PyOS_snprintf(path, sizeof path, "rackfocus.%s", name);
    PyObject *class = PyErr_NewExceptionWithDoc(path, doc, bases, NULL);
    if (class && PyModule_AddObjectRef(module, name, class) < 0)
        Py_CLEAR(class);
    return class;
}

static PyObject *add_subclass(PyObject *module, const char *name, const char *doc,
                              PyObject *error, PyObject *builtin)
{
    PyObject *bases = PyTuple_Pack(2, error, builtin);
    if (!bases)
        return NULL;
    PyObject *class = add_class(module, name, doc, bases);
    Py_DECREF(bases);
    return class;
}

int plugin_add_errors(PyObject *module, struct module_state *state)
{
    state->error = add_class(
        module, "Error",
        "Base of all errors.\n\nfield: name of the parameter or argument at fault, or "
        "''.\nmessage: one sentence that says what is wrong and the way out.",
        NULL);
    if (!state->error)
        return -1;
    state->parameter_error =
        add_subclass(module, "ParameterError",
                     "A parameter is unknown, out of range or in conflict.",
                     state->error, PyExc_ValueError);
    state->depth_error =
        add_subclass(module, "DepthError", "NaN, negative or nothing but 0 depth.",
                     state->error, PyExc_ValueError);
    state->pixel_error =
        add_subclass(module, "PixelError", "NaN or infinity in the colour.",
                     state->error, PyExc_ValueError);
    state->cancelled_error =
        add_subclass(module, "CancelledError", "The progress callback returned False.",
                     state->error, PyExc_RuntimeError);
    state->unread_warning =
        add_class(module, "UnreadParameterWarning",
                  "A parameter was given that the method or another parameter leaves "
                  "without effect.",
                  PyExc_UserWarning);
    bool is_complete = state->unread_warning && state->parameter_error &&
                       state->depth_error && state->pixel_error &&
                       state->cancelled_error;
    return is_complete ? 0 : -1;
}

static PyObject *class_of(const struct module_state *state, rf_result code)
{
    switch (code) {
    case RF_ERROR_DEPTH:
        return state->depth_error;
    case RF_ERROR_PIXEL:
        return state->pixel_error;
    case RF_ERROR_CANCELLED:
        return state->cancelled_error;
    default:
        return state->parameter_error;
    }
}

PyObject *plugin_raise(const struct module_state *state, const struct rf_error *error)
{
    if (error->code == RF_ERROR_MEMORY) {
        PyErr_SetString(PyExc_MemoryError, error->message);
        return NULL;
    }
    PyObject *class = class_of(state, error->code);
    const char *colon = error->field[0] ? ": " : "";
    PyObject *text =
        PyUnicode_FromFormat("%s%s%s", error->field, colon, error->message);
    PyObject *exception = text ? PyObject_CallFunctionObjArgs(class, text, NULL) : NULL;
    Py_XDECREF(text);
    if (!exception)
        return NULL;
    PyObject *field = PyUnicode_FromString(error->field);
    PyObject *message = PyUnicode_FromString(error->message);
    if (field && message && PyObject_SetAttrString(exception, "field", field) == 0 &&
        PyObject_SetAttrString(exception, "message", message) == 0)
        PyErr_SetObject(class, exception);
    Py_XDECREF(field);
    Py_XDECREF(message);
    Py_DECREF(exception);
    return NULL;
}
