/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parameters per frame, from CSV: the first line names the columns, `frame` and then
 * parameters, each further one is a frame with its values.
 *
 * With a column `easing` the rows are key frames. Its word says how values go from this
 * row to the next one, t being 0 at this frame and 1 at the next:
 *
 *     hold         as at this one
 *     linear       t
 *     ease-in      t^2
 *     ease-out     1 - (1 - t)^2
 *     ease-in-out  t^2 (3 - 2 t)
 *
 * Numbers are interpolated, whole ones and choices keep the value of the row before, and
 * so does what 0 turns off, from or to 0.
 * Frames before the first row have its values, those behind the last its.
 */
#ifndef APP_FRAME_TABLE_H
#define APP_FRAME_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "image.h"

struct frame_table {
    char **keys; /* of the columns behind the first */
    int n_keys, n_rows;
    int32_t *frames;
    char **values;  /* n_keys per row */
    int easing_key; /* the column `easing`, which is no parameter; -1: there is none */
};

bool frame_table_read(struct frame_table *table, const char *path,
                      struct image_error *error);
void frame_table_free(struct frame_table *table);

/* The value of a column, which is a parameter, at a frame, at most 63 characters; false where the
 * table has no row for it. */
enum { FRAME_VALUE = 64 };
bool frame_table_value(const struct frame_table *table, int key, int32_t frame,
                       char value[FRAME_VALUE]);

#endif
