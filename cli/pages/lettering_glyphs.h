/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CLI_LETTERING_GLYPHS_H
#define CLI_LETTERING_GLYPHS_H

#define GLYPH_SIZE_PX 32 /* of the font that they were drawn with */

/* The box of the ink, px from the point on the base line, and how far the next is. */
struct glyph {
    int code; /* Unicode */
    int left, top, width, height, advance;
    const char *coverage; /* width * height digits, 0 to f, from the top */
};

extern const struct glyph glyphs[];
extern const int n_glyphs;

#endif
