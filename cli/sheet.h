/* SPDX-License-Identifier: Apache-2.0 */
/* A contact sheet: labelled pictures with their heat maps, in rows of a few. */
#ifndef CLI_SHEET_H
#define CLI_SHEET_H

#include <stdbool.h>
#include <stdint.h>

#include "image.h"

struct sheet {
    int32_t width, height;           /* of the sheet, px */
    int32_t cell_width, cell_height; /* of one cell, label included */
    int32_t source_width, source_height;
    int32_t picture_width, picture_height; /* as shown */
    int32_t shrink;                        /* pictures are made smaller by this */
    int32_t n_columns;                     /* of cells */
    float *rgb; /* width * height * 3, encoded; free with sheet_free */
};

/* For `n` cells of pictures of width x height. False without memory. */
bool sheet_make(struct sheet *sheet, int n, int32_t width, int32_t height);
void sheet_free(struct sheet *sheet);

/*
 * Fills cell i: a linear packed RGB picture, its heat map (encoded; NULL: none), and a
 * label. Labels are shown in capitals and cut where they do not fit.
 */
void sheet_put(struct sheet *sheet, int i, const float *picture, const float *heat,
               const char *label);

bool sheet_write(const struct sheet *sheet, const char *path,
                 struct image_error *error);

#endif
