/* SPDX-License-Identifier: Apache-2.0 */
/* Letters of one size from a font file, packed into one picture of coverage. */
#ifndef VIEW_FONT_H
#define VIEW_FONT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct glyph {
    float u0, v0, u1, v1; /* in the picture, 0 to 1 */
    int width, height;    /* px */
    int left, top;        /* of its box from the pen, px; top is up */
    int advance;          /* of the pen, px */
};

#define FONT_N_GLYPHS 128

struct font {
    int size_px, ascent, line; /* px */
    int side;                  /* of the picture */
    uint8_t *coverage;         /* side * side; free with font_free */
    float white_u, white_v;    /* a px that is covered, for plain areas */
    struct glyph glyphs[FONT_N_GLYPHS];
};

/* False with a message that names the file. */
bool font_load(struct font *font, const char *path, int size_px, char *text,
               size_t n_bytes);
void font_free(struct font *font);

/* The glyph of the next letter of UTF-8 text; moves on. */
const struct glyph *font_next(const struct font *font, const char **text);

/* Width of the text, or of its first n_bytes. */
int font_width(const struct font *font, const char *text, size_t n_bytes);

#endif
