/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Threads of a page that is isolated from other origins: workers that run this module on
 * one shared memory and wait in rw_help() for loops. Without shared memory there is one
 * thread.
 */
#ifndef WEB_THREADS_H
#define WEB_THREADS_H

#include "rackfocus/rackfocus.h"

/* Parameters of a context whose loops run on n_threads workers, the caller's too. */
struct rf_context_params threads_params(int n_threads);

#endif
