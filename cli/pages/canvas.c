/* SPDX-License-Identifier: Apache-2.0 */
#include "pages/canvas.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "console/cli.h"
#include "pages/lettering_glyphs.h"
#include "srgb.h"

#define LINE_HEIGHT 1.35 /* of the size of the letters */

bool canvas_make(struct canvas *canvas, int32_t width, int32_t height, canvas_grey grey)
{
    *canvas = (struct canvas){.width = width, .height = height};
    const size_t n = 3 * (size_t)width * (size_t)height;
    canvas->rgb = app_memory(n, sizeof *canvas->rgb, NULL);
    for (size_t i = 0; canvas->rgb && i < n; i++)
        canvas->rgb[i] = grey;
    return canvas->rgb != NULL;
}

void canvas_free(struct canvas *canvas)
{
    free(canvas->rgb);
    canvas->rgb = NULL;
}

/* NULL outside. */
static float *pixel_at(const struct canvas *canvas, int32_t x, int32_t y)
{
    if (x < 0 || y < 0 || x >= canvas->width || y >= canvas->height)
        return NULL;
    return canvas->rgb + 3 * ((size_t)y * (size_t)canvas->width + (size_t)x);
}

void canvas_frame(struct canvas *canvas, struct canvas_box box, const float colour[3])
{
    enum { BORDER = 2 };
    for (int32_t y = 0; y < box.height; y++)
        for (int32_t x = 0; x < box.width; x++) {
            const bool is_inside = x >= BORDER && y >= BORDER &&
                                   x < box.width - BORDER && y < box.height - BORDER;
            float *p = is_inside ? NULL : pixel_at(canvas, box.x + x, box.y + y);
            if (p)
                memcpy(p, colour, 3 * sizeof *p);
        }
}

/* ---- pictures -------------------------------------------------------------------- */

static void put(float *to, const double sum[3], double n, bool is_linear)
{
    for (int c = 0; to && c < 3; c++)
        to[c] = is_linear ? srgb_encode((float)fmin(fmax(sum[c] / n, 0), 1))
                          : (float)(sum[c] / n);
}

/* The mean of pixels x0 to x1 - 1 of rows y0 to y1 - 1, at least one of them. */
static void put_mean(float *to, const struct canvas_picture *picture, int32_t x0,
                     int32_t x1, int32_t y0, int32_t y1)
{
    double sum[3] = {0, 0, 0};
    x1 = x1 > x0 ? x1 : x0 + 1;
    y1 = y1 > y0 ? y1 : y0 + 1;
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++) {
            const size_t at = (size_t)y * (size_t)picture->width + (size_t)x;
            for (size_t c = 0; c < 3; c++)
                sum[c] += fmin(fmax(picture->rgb[3 * at + c], 0), 1);
        }
    put(to, sum, (double)(x1 - x0) * (y1 - y0), picture->is_linear);
}

/* Where pixel i of n begins in a row of `of` pixels. */
static int32_t begin_of(int32_t i, int32_t n, int32_t of)
{
    return (int32_t)((int64_t)i * of / n);
}

void canvas_fit(struct canvas *canvas, struct canvas_box box,
                const struct canvas_picture *picture)
{
    const int32_t width = picture->width, height = picture->height;
    for (int32_t y = 0; y < box.height; y++)
        for (int32_t x = 0; x < box.width; x++)
            put_mean(pixel_at(canvas, box.x + x, box.y + y), picture,
                     begin_of(x, box.width, width), begin_of(x + 1, box.width, width),
                     begin_of(y, box.height, height),
                     begin_of(y + 1, box.height, height));
}

void canvas_crop(struct canvas *canvas, struct canvas_box box,
                 const struct canvas_picture *picture, int32_t x, int32_t y)
{
    for (int32_t j = 0; j < box.height && y + j < picture->height; j++)
        for (int32_t i = 0; i < box.width && x + i < picture->width; i++)
            put_mean(pixel_at(canvas, box.x + i, box.y + j), picture, x + i, x + i + 1,
                     y + j, y + j + 1);
}

/* ---- text ------------------------------------------------------------------------ */

/* The next character of UTF-8; what is none is taken byte by byte. */
static int next_code(const char **text)
{
    const unsigned char *at = (const unsigned char *)*text;
    const int n = at[0] >= 0xf0 ? 4 : at[0] >= 0xe0 ? 3 : at[0] >= 0xc0 ? 2 : 1;
    int code = n == 1 ? at[0] : at[0] & (0xff >> (n + 1));
    for (int i = 1; i < n; i++) {
        if ((at[i] & 0xc0) != 0x80) {
            *text += 1;
            return at[0];
        }
        code = code << 6 | (at[i] & 0x3f);
    }
    *text += n;
    return code;
}

static const struct glyph *find_glyph(int code)
{
    const struct glyph *other = glyphs;
    for (int i = 0; i < n_glyphs; i++) {
        if (glyphs[i].code == code)
            return &glyphs[i];
        if (glyphs[i].code == '?')
            other = &glyphs[i];
    }
    return other;
}

static double digit_of(char c)
{
    return c <= '9' ? c - '0' : c - 'a' + 10;
}

/* How much of the square from (x0, y0), side px, in the glyph's pixels, has ink. */
static double coverage(const struct glyph *g, double x0, double y0, double side)
{
    double sum = 0;
    const int end_x = (int)fmin(ceil(x0 + side), g->width);
    const int end_y = (int)fmin(ceil(y0 + side), g->height);
    for (int y = (int)fmax(floor(y0), 0); y < end_y; y++)
        for (int x = (int)fmax(floor(x0), 0); x < end_x; x++)
            sum += digit_of(g->coverage[y * g->width + x]) / 15 *
                   (fmin(x + 1, x0 + side) - fmax(x, x0)) *
                   (fmin(y + 1, y0 + side) - fmax(y, y0));
    return sum / (side * side);
}

static void draw_glyph(struct canvas *canvas, double x, int32_t y, double size_px,
                       canvas_grey grey, const struct glyph *g)
{
    const double side = GLYPH_SIZE_PX / size_px; /* of a pixel here, in the glyph */
    const double left = x + g->left / side, top = y + g->top / side;
    for (int32_t j = (int32_t)floor(top); j < top + g->height / side; j++)
        for (int32_t i = (int32_t)floor(left); i < left + g->width / side; i++) {
            const double share = coverage(g, (i - left) * side, (j - top) * side, side);
            float *p = pixel_at(canvas, i, j);
            for (int c = 0; p && c < 3; c++)
                p[c] += (float)(share * (grey - p[c]));
        }
}

int32_t canvas_text(struct canvas *canvas, int32_t x, int32_t y, double size_px,
                    canvas_grey grey, const char *text)
{
    double at = x;
    while (*text) {
        const struct glyph *g = find_glyph(next_code(&text));
        if (canvas)
            draw_glyph(canvas, at, y, size_px, grey, g);
        at += g->advance * size_px / GLYPH_SIZE_PX;
    }
    return (int32_t)ceil(at) - x;
}

int32_t canvas_text_width(double size_px, const char *text)
{
    return canvas_text(NULL, 0, 0, size_px, 0, text);
}

int32_t canvas_paragraph(struct canvas *canvas, struct canvas_box box, double size_px,
                         canvas_grey grey, const char *text)
{
    char line[256] = "";
    int32_t y = box.y;
    while (*text) {
        char longer[sizeof line];
        const size_t n_word = strcspn(text, " ");
        const size_t n_gap = strspn(text + n_word, " ");
        snprintf(longer, sizeof longer, "%s%s%.*s", line, *line ? " " : "", (int)n_word,
                 text);
        if (*line && canvas_text_width(size_px, longer) > box.width) {
            canvas_text(canvas, box.x, y, size_px, grey, line);
            y += (int32_t)lround(size_px * LINE_HEIGHT);
            snprintf(longer, sizeof longer, "%.*s", (int)n_word, text);
        }
        memcpy(line, longer, sizeof line);
        text += n_word + n_gap;
    }
    canvas_text(canvas, box.x, y, size_px, grey, line);
    return y + (int32_t)lround(size_px * LINE_HEIGHT);
}
