/* SPDX-License-Identifier: Apache-2.0 */
#include "module.h"

#include <limits.h>
#include <stdarg.h>

static PyObject *add_class(PyObject *module, const char *name, const char *doc,
                           PyObject *bases, PyObject *members)
{
    char path[64];
    PyOS_snprintf(path, sizeof path, "rackfocus.%s", name);
    PyObject *class = PyErr_NewExceptionWithDoc(path, doc, bases, members);
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
    PyObject *class = add_class(module, name, doc, bases, NULL);
    Py_DECREF(bases);
    return class;
}

int plugin_add_errors(PyObject *module, struct module_state *state)
{
    /* Those of errors that Python code raises by the class alone. */
    PyObject *members = Py_BuildValue("{s:s,s:s}", "field", "", "message", "");
    if (!members)
        return -1;
    state->error = add_class(
        module, "Error",
        "Base of all errors.\n\nfield: name of the parameter or argument at fault, or "
        "''.\nmessage: one sentence that says what is wrong and the way out.",
        NULL, members);
    Py_DECREF(members);
    if (!state->error)
        return -1;
    state->parameter_error =
        add_subclass(module, "ParameterError",
                     "A parameter or argument is unknown, out of range, of another "
                     "shape than is needed or in conflict.",
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
                  PyExc_UserWarning, NULL);
    members = Py_BuildValue("{s:s}", "about", "");
    if (!members)
        return -1;
    state->views_warning = add_class(
        module, "ViewsWarning",
        "Several views, or the two pictures of finish(), are hardly of one lens and "
        "exposure.\n\nabout: of finish(), 'light' where one is brighter, 'lens' where "
        "they are blurred in another way; else ''.",
        PyExc_UserWarning, members);
    Py_DECREF(members);
    bool is_complete = state->unread_warning && state->views_warning &&
                       state->parameter_error && state->depth_error &&
                       state->pixel_error && state->cancelled_error;
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

static void raise_class(PyObject *class, const char *name, const char *text)
{
    PyObject *whole = PyUnicode_FromFormat("%s%s%s", name, name[0] ? ": " : "", text);
    PyObject *exception =
        whole ? PyObject_CallFunctionObjArgs(class, whole, NULL) : NULL;
    Py_XDECREF(whole);
    if (!exception)
        return;
    PyObject *field = PyUnicode_FromString(name);
    PyObject *message = PyUnicode_FromString(text);
    if (field && message && PyObject_SetAttrString(exception, "field", field) == 0 &&
        PyObject_SetAttrString(exception, "message", message) == 0)
        PyErr_SetObject(class, exception);
    Py_XDECREF(field);
    Py_XDECREF(message);
    Py_DECREF(exception);
}

PyObject *plugin_raise(const struct module_state *state, const struct rf_error *error)
{
    if (error->code == RF_ERROR_MEMORY)
        PyErr_SetString(PyExc_MemoryError, error->message);
    else
        raise_class(class_of(state, error->code), error->field, error->message);
    return NULL;
}

void plugin_raise_denoiser(const struct module_state *state, const char *message)
{
    raise_class(state->error, "library", message);
}

/* Images and numbers are opened where no state of the module is at hand. */
static PyObject *find_parameter_error(void)
{
    PyObject *module = PyImport_ImportModule("rackfocus._core");
    PyObject *class = module ? PyObject_GetAttrString(module, "ParameterError") : NULL;
    Py_XDECREF(module);
    return class;
}

int plugin_fail(const char *field, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    PyObject *message = PyUnicode_FromFormatV(format, arguments);
    va_end(arguments);
    const char *text = message ? PyUnicode_AsUTF8AndSize(message, NULL) : NULL;
    PyObject *class = text ? find_parameter_error() : NULL;
    if (class)
        raise_class(class, field, text);
    Py_XDECREF(class);
    Py_XDECREF(message);
    return -1;
}

int plugin_take_int(PyObject *object, void *number)
{
    int overflow = 0;
    PyObject *index = PyNumber_Index(object);
    const long value = index ? PyLong_AsLongAndOverflow(index, &overflow) : -1;
    Py_XDECREF(index);
    if (value == -1 && PyErr_Occurred())
        return 0;
    const bool is_above = overflow > 0 || value > INT_MAX;
    const bool is_below = overflow < 0 || value < INT_MIN;
    *(int *)number = is_above ? INT_MAX : is_below ? INT_MIN : (int)value;
    return 1;
}
