/* SPDX-License-Identifier: Apache-2.0 */
/* One line of compare-methods: a method with its blend, and how it fared. */
#ifndef CLI_METHODS_ENTRY_H
#define CLI_METHODS_ENTRY_H

#include <stddef.h>
#include <stdint.h>

#include "measure/measure.h"

struct methods_entry {
    char name[64]; /* "box coc" */
    int method;    /* of enum rf_method; -1: the input as it is */
    int blend;     /* of enum rf_blend, for methods that have blends */
    double time_s; /* of the filter alone, the fastest run */
    struct measures measures;
    double flip;         /* 0 to 1 */
    double leak_percent; /* NAN where nothing can leak */
};

/* What is compared, as a heading says it. */
struct methods_subject {
    char title[256]; /* "pinhole.exr against lens.exr" */
    char about[256]; /* size, lens, radii */
    int32_t width, height;
};

/* "box_coc", as files are called. */
void methods_file_name(const struct methods_entry *entry, char *name, size_t n_bytes);

/* "12.3 ms", or "" for the input. */
void methods_time(const struct methods_entry *entry, char *text, size_t n_bytes);

#endif
