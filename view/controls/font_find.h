/* SPDX-License-Identifier: Apache-2.0 */
/* Which font file of the system the controls are written with. */
#ifndef VIEW_FONT_FIND_H
#define VIEW_FONT_FIND_H

#include <stdbool.h>
#include <stddef.h>

/*
 * The path of a font file into `path`: DejaVu Sans, else another of the usual sans
 * serifs, else what fontconfig takes for a sans serif. A program that is built without
 * fontconfig tries the usual places of a few files. False where there is none.
 */
bool font_find(char *path, size_t n_bytes);

#endif
