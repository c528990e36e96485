/* SPDX-License-Identifier: Apache-2.0 */
#include "controls/font.h"

#include <ft2build.h>
#include FT_FREETYPE_H
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"

/* Letters beyond ASCII that the window writes; they follow those in the table. */
static const unsigned extra[] = {0x221e, 0xb0,   0xd7,   0x2026, 0x2192,
                                 0x25b8, 0x25be, 0x2212, 0x2013};
enum { FIRST = 32, N_ASCII = 95, N_EXTRA = sizeof(extra) / sizeof(extra[0]) };

/* ---- drawing the letters -------------------------------------------------------- */

static unsigned code_of(int i)
{
    return i < N_ASCII ? (unsigned)(FIRST + i) : extra[i - N_ASCII];
}

static void copy_glyph(struct font *font, const FT_GlyphSlot slot, int x, int y,
                       struct glyph *glyph)
{
    const FT_Bitmap *bitmap = &slot->bitmap;
    const float side = (float)font->side;
    *glyph = (struct glyph){.u0 = (float)x / side,
                            .v0 = (float)y / side,
                            .u1 = (float)(x + (int)bitmap->width) / side,
                            .v1 = (float)(y + (int)bitmap->rows) / side,
                            .width = (int)bitmap->width,
                            .height = (int)bitmap->rows,
                            .left = slot->bitmap_left,
                            .top = slot->bitmap_top,
                            .advance = (int)(slot->advance.x >> 6)};
    for (unsigned row = 0; row < bitmap->rows; row++)
        memcpy(font->coverage + (size_t)(y + (int)row) * (size_t)font->side + x,
               bitmap->buffer + (ptrdiff_t)row * bitmap->pitch, bitmap->width);
}

/* Row by row from the top left; the first px are left white for plain areas. */
static void pack_glyphs(struct font *font, FT_Face face)
{
    int x = 4, y = 0, row_height = 4;
    for (int i = 0; i < N_ASCII + N_EXTRA; i++) {
        if (FT_Load_Char(face, code_of(i), FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT) != 0)
            continue;
        const FT_GlyphSlot slot = face->glyph;
        const int width = (int)slot->bitmap.width, height = (int)slot->bitmap.rows;
        if (x + width + 1 > font->side) {
            x = 0;
            y += row_height;
            row_height = 0;
        }
        if (y + height + 1 > font->side)
            return;
        copy_glyph(font, slot, x, y, &font->glyphs[i]);
        x += width + 1;
        row_height = height + 1 > row_height ? height + 1 : row_height;
    }
}

bool font_load(struct font *font, const char *path, int size_px, char *text,
               size_t n_bytes)
{
    FT_Library library;
    FT_Face face;
    *font = (struct font){.size_px = size_px};
    if (FT_Init_FreeType(&library) != 0) {
        snprintf(text, n_bytes, "FreeType cannot be started");
        return false;
    }
    const int code = FT_New_Face(library, path, 0, &face);
    if (code != 0 || FT_Set_Pixel_Sizes(face, 0, (FT_UInt)size_px) != 0) {
        snprintf(text, n_bytes, "%s: is no font file that FreeType can read", path);
        FT_Done_FreeType(library);
        return false;
    }
    for (font->side = 128; font->side < 14 * size_px; font->side *= 2)
        ;
    const size_t side = (size_t)font->side;
    font->coverage = app_memory(side * side, 1, NULL);
    if (!font->coverage) {
        snprintf(text, n_bytes, "out of memory for the font");
        FT_Done_Face(face);
        FT_Done_FreeType(library);
        return false;
    }
    for (size_t i = 0; i < 9; i++)
        font->coverage[i / 3 * side + i % 3] = 255;
    font->white_u = font->white_v = 1.5f / (float)font->side;
    font->ascent = (int)(face->size->metrics.ascender >> 6);
    font->line = (int)(face->size->metrics.height >> 6);
    pack_glyphs(font, face);
    FT_Done_Face(face);
    FT_Done_FreeType(library);
    return true;
}

void font_free(struct font *font)
{
    free(font->coverage);
    font->coverage = NULL;
}

/* ---- text ----------------------------------------------------------------------- */

static unsigned next_code(const char **text)
{
    const unsigned char *at = (const unsigned char *)*text;
    unsigned code = *at++;
    const int n_more = code >= 0xf0 ? 3 : code >= 0xe0 ? 2 : code >= 0xc0 ? 1 : 0;
    if (n_more)
        code &= 0x3fu >> n_more;
    for (int i = 0; i < n_more && (*at & 0xc0) == 0x80; i++)
        code = code << 6 | (*at++ & 0x3f);
    *text = (const char *)at;
    return code;
}

const struct glyph *font_next(const struct font *font, const char **text)
{
    const unsigned code = next_code(text);
    if (code >= FIRST && code < FIRST + N_ASCII)
        return &font->glyphs[code - FIRST];
    for (int i = 0; i < N_EXTRA; i++)
        if (extra[i] == code)
            return &font->glyphs[N_ASCII + i];
    return &font->glyphs['?' - FIRST];
}

int font_width(const struct font *font, const char *text, size_t n_bytes)
{
    int width = 0;
    for (const char *at = text; *at && (size_t)(at - text) < n_bytes;)
        width += font_next(font, &at)->advance;
    return width;
}
