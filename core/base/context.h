/* SPDX-License-Identifier: Apache-2.0 */
/* The context: what a host gives, and what its pictures share. */
#ifndef RF_BASE_CONTEXT_H
#define RF_BASE_CONTEXT_H

#include "rackfocus/rackfocus.h"

enum { RF_ALIGNMENT = 64 };

struct rf_pool;
struct rf_kernels;
struct rf_threads;

struct rf_shelf; /* footprint_shelf.c */

struct rf_context {
    struct rf_context_params params;
    int n_threads;
    const struct rf_kernels *kernels;
    struct rf_pool *pool;
    struct rf_shelf *shelf;
    struct rf_threads *threads; /* those of params.parallel_for take their place */
};

#endif
