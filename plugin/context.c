/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.Context: threads and memory that filters share. */
#include <stdlib.h>
#include <string.h>

#include "module.h"

struct context_object {
    PyObject ob_base;
    struct rf_context *context;
    PyObject *log; /* a function of level and text, or NULL */
};

/* Remarks come while the lock of the interpreter is released. What `log` raises is
 * reported as Python reports what nobody can catch. */
static void log_remark(void *user, enum rf_log_level level, const char *text)
{
    const struct context_object *self = user;
    const PyGILState_STATE state = PyGILState_Ensure();
    PyObject *answer = PyObject_CallFunction(
        self->log, "ss", level == RF_LOG_WARNING ? "warning" : "info", text);
    if (!answer)
        PyErr_WriteUnraisable(self->log);
    Py_XDECREF(answer);
    PyGILState_Release(state);
}

static int read_size(PyObject *value, size_t *size)
{
    *size = 0;
    if (!value)
        return 0;
    *size = PyLong_AsSize_t(value);
    if (*size != (size_t)-1 || !PyErr_Occurred())
        return 0;
    if (!PyErr_ExceptionMatches(PyExc_OverflowError))
        return -1;
    PyErr_Clear();
    return plugin_fail("max_bytes", "must lie in 0 (no bound) to %zu", SIZE_MAX);
}

static PyObject *context_create(PyTypeObject *type, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"threads", "max_bytes", "cpu", "log", NULL};
    const struct module_state *state = PyType_GetModuleState(type);
    int n_threads = 0;
    const char *cpu = NULL;
    PyObject *max_bytes = NULL, *log = Py_None;
    size_t bytes;
    if (!state ||
        !PyArg_ParseTupleAndKeywords(args, keywords, "|$O&OzO:Context", names,
                                     plugin_take_int, &n_threads, &max_bytes, &cpu,
                                     &log) ||
        read_size(max_bytes, &bytes) < 0)
        return NULL;
    if (log != Py_None && !PyCallable_Check(log)) {
        PyErr_SetString(PyExc_TypeError, "log: a function of a level and a text");
        return NULL;
    }
    allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
    struct context_object *self = (struct context_object *)allocate(type, 0);
    if (!self)
        return NULL;
    self->log = log == Py_None ? NULL : Py_NewRef(log);
    struct rf_context_params about = {.size = sizeof about,
                                      .n_threads = n_threads,
                                      .cpu = cpu ? cpu : getenv("RACKFOCUS_CPU"),
                                      .max_bytes = bytes,
                                      .log = self->log ? log_remark : NULL,
                                      .user = self};
    struct rf_error error;
    if (rf_context_create(&self->context, &about, &error) != RF_OK) {
        if (strcmp(error.field, "n_threads") == 0) /* as it is called here */
            strcpy(error.field, "threads");
        plugin_raise(state, &error);
        Py_CLEAR(self);
    }
    return (PyObject *)self;
}

static void context_dealloc(PyObject *object)
{
    struct context_object *self = (struct context_object *)object;
    rf_context_destroy(self->context);
    Py_XDECREF(self->log);
    PyTypeObject *type = Py_TYPE(object);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(object);
    Py_DECREF(type);
}

const struct rf_context *plugin_context_of(PyObject *object)
{
    return ((struct context_object *)object)->context;
}

int plugin_take_context(const struct module_state *state, PyObject *keywords,
                        PyObject **context)
{
    static const char *const own[] = {"threads"};
    PyObject *given = PyDict_GetItemString(keywords, "context");
    *context = NULL;
    if (given && given != Py_None) {
        if (!PyObject_TypeCheck(given, state->context_type)) {
            PyErr_SetString(PyExc_TypeError, "context: a rackfocus.Context is needed");
            return -1;
        }
        if (PyDict_GetItemString(keywords, own[0])) {
            PyErr_SetString(PyExc_TypeError,
                            "threads: belong to the context; leave out one of them");
            return -1;
        }
        *context = Py_NewRef(given);
        return PyDict_DelItemString(keywords, "context");
    }
    if (given && PyDict_DelItemString(keywords, "context") < 0)
        return -1;
    /* A context of its own, with the threads that were asked for. */
    PyObject *threads = PyDict_GetItemString(keywords, own[0]);
    PyObject *about = PyDict_New(), *none = PyTuple_New(0);
    if (about && none &&
        (!threads || PyDict_SetItemString(about, own[0], threads) == 0) &&
        (!threads || PyDict_DelItemString(keywords, own[0]) == 0))
        *context = PyObject_Call((PyObject *)state->context_type, none, about);
    Py_XDECREF(about);
    Py_XDECREF(none);
    return *context ? 0 : -1;
}

static PyObject *get_threads(PyObject *object, void *unused)
{
    return PyLong_FromLong(rf_context_threads(plugin_context_of(object)));
}

static PyObject *get_cpu(PyObject *object, void *unused)
{
    return PyUnicode_FromString(rf_context_cpu(plugin_context_of(object)));
}

static PyGetSetDef context_getset[] = {
    {"threads", get_threads, NULL, "Threads that its filters use.", NULL},
    {"cpu", get_cpu, NULL, "Instruction set of the inner loops.", NULL},
    {0},
};

static PyType_Slot context_slots[] = {
    {Py_tp_doc,
     "Context(*, threads=0, max_bytes=0, cpu=None, log=None)\n--\n\n"
     "Threads and memory that any number of filters share, on any threads; kept, a "
     "new filter of another focus costs next to nothing.\n\n"
     "threads: 0 takes all processors.\n"
     "max_bytes: most memory that its filters may hold at once; what needs more is a "
     "MemoryError. 0: no bound.\n"
     "cpu: 'generic', 'sse4', 'avx2' or 'avx512'; all give the same bits.\n"
     "log: called with a level ('info', 'warning') and a text for each remark."},
    {Py_tp_new, context_create},
    {Py_tp_dealloc, context_dealloc},
    {Py_tp_getset, context_getset},
    {0, NULL},
};

PyType_Spec plugin_context_spec = {
    .name = "rackfocus.Context",
    .basicsize = sizeof(struct context_object),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE,
    .slots = context_slots,
};
