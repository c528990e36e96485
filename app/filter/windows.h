/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The steps of a run (filter_run.c) for a picture that does not fit into memory: they
 * take the place of those that read, filter and write it whole, with the same bits. The
 * functions return an enum app_code, with run->error.
 */
#ifndef APP_WINDOWS_H
#define APP_WINDOWS_H

#include <stdbool.h>

struct run;

/* Does the way through windows know pictures like this one? Before its views are read
 * the first of them counts alone. */
bool windows_are_possible(const struct run *run);

/* Would the picture take more memory than is allowed, and does the way through windows
 * know pictures like this one? */
bool windows_are_needed(const struct run *run);

/* Measures and judges the depth by a pass over the file, and counts by another what
 * windows must know of the whole; run->largest_radius is known then. */
int windows_open(struct run *run);

/* Reads strips of rows, filters windows of them and writes each strip when it is done,
 * beside the output's place. */
int windows_filter(struct run *run);

/* Puts the output into its place. */
int windows_finish(struct run *run);

/* What is not finished is removed. */
void windows_free(struct run *run);

#endif
