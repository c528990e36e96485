/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Work on a thread of its own, beside which this one handles signals: Ctrl-C ends what
 * reports no progress, or reports it on threads of others.
 */
#include "module.h"

/* How often signals are handled. */
enum { WAIT_US = 50000 };

struct aside {
    plugin_work work;
    void *data;
    PyThread_type_lock done; /* held until it is */
    bool stop;               /* atomic */
};

static void run(void *user)
{
    struct aside *aside = user;
    aside->work(aside->data, &aside->stop);
    PyThread_release_lock(aside->done);
}

/* With Python's lock. Handles signals until the work is done; whether none raised. */
static bool wait_for(struct aside *aside)
{
    bool is_done = false, has_raised = false;
    while (!is_done) {
        Py_BEGIN_ALLOW_THREADS;
        is_done = PyThread_acquire_lock_timed(aside->done, WAIT_US, 0) == 1;
        Py_END_ALLOW_THREADS;
        if (has_raised || PyErr_CheckSignals() == 0)
            continue;
        has_raised = true;
        __atomic_store_n(&aside->stop, true, __ATOMIC_RELAXED);
    }
    return !has_raised;
}

int plugin_run_aside(plugin_work work, void *data)
{
    struct aside aside = {.work = work, .data = data};
    const int is_main = plugin_is_main_thread();
    if (is_main < 0)
        return -1;
    aside.done = is_main ? PyThread_allocate_lock() : NULL;
    bool is_aside = aside.done != NULL, is_whole = true;
    if (is_aside) {
        PyThread_acquire_lock(aside.done, 1);
        is_aside = PyThread_start_new_thread(run, &aside) != (unsigned long)-1;
    }
    if (is_aside) {
        is_whole = wait_for(&aside);
    } else {
        Py_BEGIN_ALLOW_THREADS;
        work(data, NULL);
        Py_END_ALLOW_THREADS;
    }
    if (aside.done) {
        PyThread_release_lock(aside.done);
        PyThread_free_lock(aside.done);
    }
    return is_whole ? 0 : -1;
}
