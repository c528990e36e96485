/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sheet of compare-methods: the pinhole and the reference on top, then methods that
 * need no blend, then a row for each generator with a column for each blend; without
 * rows where there is one blend. Each
 * picture has its figures, the map of its error and two details one to one.
 */
#ifndef CLI_METHODS_SHEET_H
#define CLI_METHODS_SHEET_H

#include "image.h"
#include "pages/canvas.h"
#include "pages/methods_details.h"
#include "pages/methods_entry.h"

struct methods_sheet {
    struct canvas canvas;
    const struct methods_subject *subject;
    struct canvas_box details[N_DETAILS];
    int32_t picture_width, picture_height, strip_height, cell_width;
    int n_columns, n_blends, n_plain_rows;
    int generator_rows[64]; /* row of the method, of which there are fewer; 0: none */
    int n_plain;            /* drawn so far */
    float *error;           /* map of the picture that is drawn; encoded */
};

/* How large details can be, px. */
void methods_sheet_detail_size(const struct methods_subject *subject, int32_t *width,
                               int32_t *height);

/* For these entries. The subject must stay. False without memory; free it then, too. */
bool methods_sheet_make(struct methods_sheet *sheet,
                        const struct methods_subject *subject,
                        const struct canvas_box details[N_DETAILS],
                        const struct methods_entry *entries, int n_entries);
void methods_sheet_free(struct methods_sheet *sheet);

/* Draws an entry's picture and its error, linear packed RGB; in the order of the
 * entries. A NULL entry is the reference itself. */
void methods_sheet_put(struct methods_sheet *sheet, const struct methods_entry *entry,
                       const float *picture, const float *reference);

bool methods_sheet_write(const struct methods_sheet *sheet, const char *path,
                         struct image_error *error);

#endif
