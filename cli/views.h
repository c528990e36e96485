/* SPDX-License-Identifier: Apache-2.0 */
/* Pinhole views from points of the lens: files whose headers say where each was taken.
 */
#ifndef CLI_VIEWS_H
#define CLI_VIEWS_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"
#include "source.h"

#define VIEWS_OFFSET "rackfocus:lensOffset"   /* v2f, scene units right and up */
#define VIEWS_SHEAR "rackfocus:shearDistance" /* float, scene units; 0: parallel */

/* Where a view was taken. False where the header does not say it: no view. */
bool views_find_place(const struct exr_input *input, double lens_offset[2],
                      double *shear_distance);

/* How many of the files, from the first on, are views; *other is the one that then is
 * none. -1 on failure. */
int views_count(char *const *paths, int n_paths, const char **other,
                struct exr_error *error);

/* Opened files, and their pixels once they are read. */
struct views {
    int n;
    struct source *sources;
    struct rf_view *views; /* point to memory that belongs to this */
};

/* Reads all files; they must be like `first`, which is the first of them, opened. */
bool views_read(struct views *views, const struct source *first,
                const struct source_request *request, int n_threads,
                struct exr_error *error);
void views_free(struct views *views);

#endif
