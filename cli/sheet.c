/* SPDX-License-Identifier: Apache-2.0 */
#include "sheet.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>

#include "cli.h"

enum {
    MARGIN = 4,      /* px around pictures */
    LABEL = 20,      /* height of a label's line */
    GLYPH_STEP = 12, /* letters of 5 x 7, doubled */
    LETTER_SCALE = 2,
    MAX_PICTURE = 320, /* longest side of a picture in its cell */
    MAX_WIDTH = 2000,  /* of the sheet */
};

/* Rows from the top; the highest of five bits is the left one. */
static const struct glyph {
    char letter;
    unsigned char rows[7];
} glyphs[] = {
    {'A', {0x0e, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11}},
    {'B', {0x1e, 0x11, 0x11, 0x1e, 0x11, 0x11, 0x1e}},
    {'C', {0x0e, 0x11, 0x10, 0x10, 0x10, 0x11, 0x0e}},
    {'D', {0x1e, 0x11, 0x11, 0x11, 0x11, 0x11, 0x1e}},
    {'E', {0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x1f}},
    {'F', {0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x10}},
    {'G', {0x0e, 0x11, 0x10, 0x17, 0x11, 0x11, 0x0e}},
    {'H', {0x11, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11}},
    {'I', {0x0e, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'J', {0x07, 0x02, 0x02, 0x02, 0x02, 0x12, 0x0c}},
    {'K', {0x11, 0x12, 0x14, 0x18, 0x14, 0x12, 0x11}},
    {'L', {0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x1f}},
    {'M', {0x11, 0x1b, 0x15, 0x15, 0x11, 0x11, 0x11}},
    {'N', {0x11, 0x19, 0x15, 0x13, 0x11, 0x11, 0x11}},
    {'O', {0x0e, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0e}},
    {'P', {0x1e, 0x11, 0x11, 0x1e, 0x10, 0x10, 0x10}},
    {'Q', {0x0e, 0x11, 0x11, 0x11, 0x15, 0x12, 0x0d}},
    {'R', {0x1e, 0x11, 0x11, 0x1e, 0x14, 0x12, 0x11}},
    {'S', {0x0f, 0x10, 0x10, 0x0e, 0x01, 0x01, 0x1e}},
    {'T', {0x1f, 0x04, 0x04, 0x04, 0x04, 0x04, 0x04}},
    {'U', {0x11, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0e}},
    {'V', {0x11, 0x11, 0x11, 0x11, 0x11, 0x0a, 0x04}},
    {'W', {0x11, 0x11, 0x11, 0x15, 0x15, 0x15, 0x0a}},
    {'X', {0x11, 0x11, 0x0a, 0x04, 0x0a, 0x11, 0x11}},
    {'Y', {0x11, 0x11, 0x0a, 0x04, 0x04, 0x04, 0x04}},
    {'Z', {0x1f, 0x01, 0x02, 0x04, 0x08, 0x10, 0x1f}},
    {'0', {0x0e, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0e}},
    {'1', {0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'2', {0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f}},
    {'3', {0x1f, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0e}},
    {'4', {0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02}},
    {'5', {0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e}},
    {'6', {0x06, 0x08, 0x10, 0x1e, 0x11, 0x11, 0x0e}},
    {'7', {0x1f, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08}},
    {'8', {0x0e, 0x11, 0x11, 0x0e, 0x11, 0x11, 0x0e}},
    {'9', {0x0e, 0x11, 0x11, 0x0f, 0x01, 0x02, 0x0c}},
    {'-', {0x00, 0x00, 0x00, 0x1f, 0x00, 0x00, 0x00}},
    {'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x0c, 0x0c}},
};

static float encode(double v)
{
    v = fmin(fmax(v, 0), 1);
    return (float)(v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055);
}

bool sheet_make(struct sheet *sheet, int n, int32_t width, int32_t height)
{
    const int32_t longest = width > height ? width : height;
    *sheet = (struct sheet){.source_width = width,
                            .source_height = height,
                            .shrink = (longest + MAX_PICTURE - 1) / MAX_PICTURE};
    sheet->picture_width = (width + sheet->shrink - 1) / sheet->shrink;
    sheet->picture_height = (height + sheet->shrink - 1) / sheet->shrink;
    sheet->cell_width = 2 * sheet->picture_width + 3 * MARGIN;
    sheet->cell_height = sheet->picture_height + LABEL + 2 * MARGIN;
    int columns = MAX_WIDTH / sheet->cell_width;
    sheet->n_columns = columns < 1 ? 1 : columns > n ? n : columns;
    sheet->width = sheet->n_columns * sheet->cell_width;
    sheet->height = (n + sheet->n_columns - 1) / sheet->n_columns * sheet->cell_height;
    const size_t n_values = 3 * (size_t)sheet->width * (size_t)sheet->height;
    sheet->rgb = app_memory(n_values, sizeof(*sheet->rgb), NULL);
    for (size_t i = 0; sheet->rgb && i < n_values; i++)
        sheet->rgb[i] = 0.12f;
    return sheet->rgb != NULL;
}

void sheet_free(struct sheet *sheet)
{
    free(sheet->rgb);
    sheet->rgb = NULL;
}

static float *pixel_at(const struct sheet *sheet, int32_t x, int32_t y)
{
    return sheet->rgb + 3 * ((size_t)y * (size_t)sheet->width + (size_t)x);
}

static void draw_dot(struct sheet *sheet, int32_t x, int32_t y)
{
    for (int i = 0; i < LETTER_SCALE * LETTER_SCALE; i++)
        for (int c = 0; c < 3; c++)
            pixel_at(sheet, x + i % LETTER_SCALE, y + i / LETTER_SCALE)[c] = 0.95f;
}

static void draw_glyph(struct sheet *sheet, int32_t x, int32_t y, char letter)
{
    for (size_t g = 0; g < sizeof(glyphs) / sizeof(glyphs[0]); g++)
        for (int i = 0; glyphs[g].letter == letter && i < 5 * 7; i++)
            if (glyphs[g].rows[i / 5] >> (4 - i % 5) & 1)
                draw_dot(sheet, x + i % 5 * LETTER_SCALE, y + i / 5 * LETTER_SCALE);
}

static void draw_label(struct sheet *sheet, int32_t x, int32_t y, const char *text)
{
    const int32_t end = x + sheet->cell_width - 2 * MARGIN - GLYPH_STEP;
    for (; *text && x <= end; text++, x += GLYPH_STEP)
        draw_glyph(sheet, x, y, (char)toupper((unsigned char)*text));
}

/* The mean of the block of the picture under pixel (x, y) of the small one. */
static void shrink_pixel(const struct sheet *sheet, const float *picture, int32_t x,
                         int32_t y, double mean[3])
{
    const int32_t width = sheet->source_width, step = sheet->shrink;
    const int32_t x1 = step * (x + 1) < width ? step * (x + 1) : width;
    const int32_t y1 =
        step * (y + 1) < sheet->source_height ? step * (y + 1) : sheet->source_height;
    const double share = 1.0 / ((x1 - step * x) * (y1 - step * y));
    mean[0] = mean[1] = mean[2] = 0;
    for (int32_t j = step * y; j < y1; j++)
        for (int32_t i = step * x; i < x1; i++) {
            const float *p = picture + 3 * ((size_t)j * (size_t)width + (size_t)i);
            for (int c = 0; c < 3; c++)
                mean[c] += fmin(fmax(p[c], 0), 1) * share;
        }
}

static void paste(struct sheet *sheet, const float *picture, bool is_linear, int32_t x0,
                  int32_t y0)
{
    for (int32_t y = 0; y < sheet->picture_height; y++)
        for (int32_t x = 0; x < sheet->picture_width; x++) {
            double mean[3];
            shrink_pixel(sheet, picture, x, y, mean);
            for (int c = 0; c < 3; c++)
                pixel_at(sheet, x0 + x, y0 + y)[c] =
                    is_linear ? encode(mean[c]) : (float)mean[c];
        }
}

void sheet_put(struct sheet *sheet, int i, const float *picture, const float *heat,
               const char *label)
{
    const int32_t x = i % sheet->n_columns * sheet->cell_width + MARGIN;
    const int32_t y = i / sheet->n_columns * sheet->cell_height + MARGIN;
    draw_label(sheet, x, y, label);
    paste(sheet, picture, true, x, y + LABEL);
    if (heat)
        paste(sheet, heat, false, x + sheet->picture_width + MARGIN, y + LABEL);
}

bool sheet_write(const struct sheet *sheet, const char *path, struct image_error *error)
{
    return image_write_png(path, sheet->rgb, sheet->width, sheet->height, 3, 8, true,
                           error);
}
