/* SPDX-License-Identifier: Apache-2.0 */
/* The core's tables as Python objects, and keywords as parameters. */
#include <string.h>

#include "module.h"

static const char *const type_names[] = {
    [RF_TYPE_FLOAT] = "float",
    [RF_TYPE_INT] = "int",
    [RF_TYPE_BOOL] = "bool",
    [RF_TYPE_ENUM] = "enum",
};

static const char *const group_names[] = {
    [RF_GROUP_LENS] = "lens",
    [RF_GROUP_APERTURE] = "aperture",
    [RF_GROUP_DEPTH] = "depth",
    [RF_GROUP_METHOD] = "method",
    [RF_GROUP_HIGHLIGHTS] = "highlights",
};

static PyObject *choices_of(const struct rf_param_info *info)
{
    PyObject *choices = PyTuple_New(info->n_choices);
    for (int i = 0; choices && i < info->n_choices; i++) {
        PyObject *choice =
            Py_BuildValue("(ss)", info->choices[i].name, info->choices[i].help);
        if (!choice || PyTuple_SetItem(choices, i, choice) < 0)
            Py_CLEAR(choices);
    }
    return choices;
}

static PyObject *number_of(const struct rf_param_info *info, double value)
{
    switch (info->type) {
    case RF_TYPE_FLOAT:
        return PyFloat_FromDouble(value);
    case RF_TYPE_BOOL:
        return PyBool_FromLong(value != 0);
    default:
        return PyLong_FromDouble(value);
    }
}

static PyObject *default_of(const struct rf_param_info *info)
{
    if (info->type == RF_TYPE_ENUM)
        return PyUnicode_FromString(info->choices[(int)info->def].name);
    return number_of(info, info->def);
}

static PyObject *parameter(const struct rf_param_info *info)
{
    return Py_BuildValue("(ssssssNNNNN)", info->key, info->field, info->attribute,
                         info->unit, info->help, type_names[info->type],
                         PyUnicode_FromString(group_names[info->group]),
                         number_of(info, info->min), number_of(info, info->max),
                         default_of(info), choices_of(info));
}

PyObject *plugin_parameters(PyObject *module, PyObject *unused)
{
    size_t n;
    const struct rf_param_info *infos = rf_param_list(&n);
    PyObject *list = PyTuple_New((Py_ssize_t)n);
    for (size_t i = 0; list && i < n; i++) {
        PyObject *item = parameter(&infos[i]);
        if (!item || PyTuple_SetItem(list, (Py_ssize_t)i, item) < 0)
            Py_CLEAR(list);
    }
    return list;
}

PyObject *plugin_methods(PyObject *module, PyObject *unused)
{
    size_t n;
    const struct rf_method_info *infos = rf_method_list(&n);
    PyObject *list = PyTuple_New((Py_ssize_t)n);
    for (size_t i = 0; list && i < n; i++) {
        PyObject *item = Py_BuildValue("(ssss)", infos[i].name, infos[i].help,
                                       infos[i].cost, infos[i].source);
        if (!item || PyTuple_SetItem(list, (Py_ssize_t)i, item) < 0)
            Py_CLEAR(list);
    }
    return list;
}

static int set_text(const struct module_state *state, struct rf_params *params,
                    const char *name, PyObject *value)
{
    struct rf_error error;
    const char *text = PyUnicode_AsUTF8AndSize(value, NULL);
    if (!text)
        return -1;
    if (rf_params_set(params, name, text, &error) != RF_OK) {
        plugin_raise(state, &error);
        return -1;
    }
    return 0;
}

static int set_number(const struct module_state *state, struct rf_params *params,
                      const char *name, PyObject *value)
{
    struct rf_error error;
    double number = PyFloat_AsDouble(value);
    if (number == -1 && PyErr_Occurred()) {
        PyErr_Format(PyExc_TypeError, "%s: a number or a text is needed", name);
        return -1;
    }
    if (rf_params_set_number(params, name, number, &error) != RF_OK) {
        plugin_raise(state, &error);
        return -1;
    }
    return 0;
}

/* The parameter that was probably meant: the first that begins so, or the most alike one;
 * a new reference. NULL, without an exception: there is none. */
static PyObject *nearest(const char *name)
{
    size_t n;
    const struct rf_param_info *infos = rf_param_list(&n);
    for (size_t i = 0; i < n; i++)
        if (name[0] && strncmp(infos[i].field, name, strlen(name)) == 0)
            return PyUnicode_FromString(infos[i].field);
    PyObject *module = PyImport_ImportModule("difflib"), *names = PyList_New(0);
    for (size_t i = 0; i < n && names; i++) {
        PyObject *field = PyUnicode_FromString(infos[i].field);
        if (!field || PyList_Append(names, field) < 0)
            Py_CLEAR(names);
        Py_XDECREF(field);
    }
    PyObject *found = module && names ? PyObject_CallMethod(module, "get_close_matches",
                                                            "sOid", name, names, 1, 0.6)
                                      : NULL;
    PyObject *first = found ? PySequence_GetItem(found, 0) : NULL;
    Py_XDECREF(found);
    Py_XDECREF(names);
    Py_XDECREF(module);
    PyErr_Clear();
    return first;
}

static int fail_name(const char *name)
{
    PyObject *other = nearest(name);
    if (other)
        plugin_fail(name, "there is no parameter %s; did you mean %U?", name, other);
    else
        plugin_fail(name, "there is no parameter %s; parameters() lists them", name);
    Py_XDECREF(other);
    return -1;
}

int plugin_read_params(const struct module_state *state, PyObject *keywords,
                       struct rf_params *params)
{
    rf_params_init(params);
    PyObject *key, *value;
    Py_ssize_t at = 0;
    while (keywords && PyDict_Next(keywords, &at, &key, &value)) {
        const char *name = PyUnicode_AsUTF8AndSize(key, NULL);
        if (!name)
            return -1;
        if (!rf_param_find(name))
            return fail_name(name);
        int status = PyUnicode_Check(value) ? set_text(state, params, name, value)
                                            : set_number(state, params, name, value);
        if (status < 0)
            return -1;
    }
    return 0;
}

static double value_of(const struct rf_params *params, const struct rf_param_info *info)
{
    const char *member = (const char *)params + info->offset;
    return info->type == RF_TYPE_FLOAT ? *(const double *)member
                                       : *(const int32_t *)member;
}

static bool is_read_by_mean(const struct rf_param_info *info)
{
    return info->group == RF_GROUP_HIGHLIGHTS ||
           strcmp(info->field, "blend_gamma") == 0;
}

int plugin_warn_unread(const struct module_state *state, PyObject *keywords,
                       const struct rf_params *params, bool is_mean)
{
    struct rf_params defaults;
    PyObject *key, *value;
    Py_ssize_t at = 0;
    rf_params_init(&defaults);
    while (keywords && PyDict_Next(keywords, &at, &key, &value)) {
        const char *why_not =
            "a mean of pictures reads only blend_gamma and highlights";
        const char *name = PyUnicode_AsUTF8AndSize(key, NULL);
        const struct rf_param_info *info = name ? rf_param_find(name) : NULL;
        if (!info || value_of(params, info) == value_of(&defaults, info) ||
            (is_mean ? is_read_by_mean(info)
                     : rf_param_is_read(params, name, &why_not)))
            continue;
        if (PyErr_WarnFormat(state->unread_warning, 1, "%s: has no effect: %s", name,
                             why_not) < 0)
            return -1;
    }
    return 0;
}

PyObject *plugin_why_not_read(PyObject *module, PyObject *args, PyObject *keywords)
{
    const char *name, *why_not = NULL;
    struct rf_params params;
    if (!PyArg_ParseTuple(args, "s", &name))
        return NULL;
    if (plugin_read_params(PyModule_GetState(module), keywords, &params) < 0)
        return NULL;
    if (rf_param_is_read(&params, name, &why_not))
        return PyUnicode_FromString("");
    return PyUnicode_FromString(why_not ? why_not : "there is no such parameter");
}
