/* SPDX-License-Identifier: Apache-2.0 */
/* Boxes and text as vertices. */
#include "controls/ui_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"

static void add_quad(struct vertices *to, const float at[4], const float uv[4],
                     uint32_t rgba)
{
    if (to->n + 4 > to->n_room) {
        struct gl_vertex *items =
            app_memory(2 * to->n_room + 256, sizeof(*items), NULL);
        if (!items)
            return; /* this piece is not drawn */
        if (to->n)
            memcpy(items, to->items, to->n * sizeof(*items));
        free(to->items);
        to->items = items;
        to->n_room = 2 * to->n_room + 256;
    }
    for (int i = 0; i < 4; i++) {
        const int right = i == 1 || i == 2, low = i >= 2;
        to->items[to->n++] =
            (struct gl_vertex){.x = at[right ? 2 : 0],
                               .y = at[low ? 3 : 1],
                               .u = uv[right ? 2 : 0],
                               .v = uv[low ? 3 : 1],
                               .rgba = {(uint8_t)(rgba >> 24), (uint8_t)(rgba >> 16),
                                        (uint8_t)(rgba >> 8), (uint8_t)rgba}};
    }
}

void ui_draw_box(struct ui *ui, struct vertices *to, const struct area *area,
                 uint32_t rgba)
{
    const float u = ui->font->white_u, v = ui->font->white_v;
    const float at[4] = {(float)area->x, (float)area->y, (float)(area->x + area->width),
                         (float)(area->y + area->height)};
    const float uv[4] = {u, v, u, v};
    if (area->width > 0 && area->height > 0)
        add_quad(to, at, uv, rgba);
}

void ui_draw_frame(struct ui *ui, struct vertices *to, const struct area *a, int px,
                   uint32_t rgba)
{
    const struct area sides[4] = {{a->x, a->y, a->width, px},
                                  {a->x, a->y + a->height - px, a->width, px},
                                  {a->x, a->y, px, a->height},
                                  {a->x + a->width - px, a->y, px, a->height}};
    for (int i = 0; i < 4; i++)
        ui_draw_box(ui, to, &sides[i], rgba);
}

static void draw_glyph(struct vertices *to, const struct glyph *g, int x, int y,
                       uint32_t rgba)
{
    const float at[4] = {(float)(x + g->left), (float)(y - g->top),
                         (float)(x + g->left + g->width),
                         (float)(y - g->top + g->height)};
    const float uv[4] = {g->u0, g->v0, g->u1, g->v1};
    if (g->width > 0)
        add_quad(to, at, uv, rgba);
}

int ui_draw_text(struct ui *ui, struct vertices *to, int x, int y, int max_width,
                 const char *text, uint32_t rgba)
{
    const struct font *font = ui->font;
    const bool is_cut = font_width(font, text, SIZE_MAX) > max_width;
    const int room = is_cut ? max_width - font_width(font, "…", SIZE_MAX) : max_width;
    int pen = 0;
    for (const char *at = text; *at;) {
        const struct glyph *glyph = font_next(font, &at);
        if (is_cut && pen + glyph->advance > room) {
            const char *dots = "…";
            glyph = font_next(font, &dots);
            at = "";
        }
        if (pen + glyph->advance > max_width && is_cut && max_width < glyph->advance)
            return pen;
        draw_glyph(to, glyph, x + pen, y + font->ascent, rgba);
        pen += glyph->advance;
    }
    return pen;
}

/* In a row of a control: vertically in the middle. */
int ui_text_top(const struct ui *ui, const struct area *area)
{
    return area->y + (area->height - ui->font->line) / 2;
}

void ui_draw_label(struct ui *ui, const struct area *area, int pad, const char *text,
                   uint32_t rgba)
{
    ui_draw_text(ui, &ui->flat, area->x + pad, ui_text_top(ui, area),
                 area->width - 2 * pad, text, rgba);
}

/* Bytes of the line that begins here and fits; at least one letter. */
static size_t line_length(const struct font *font, const char *text, int width)
{
    size_t good = 0;
    int pen = 0;
    for (const char *at = text; *at && *at != '\n';) {
        if (*at == ' ')
            good = (size_t)(at - text);
        const char *before = at;
        pen += font_next(font, &at)->advance;
        if (pen > width)
            return good > 0        ? good
                   : before > text ? (size_t)(before - text)
                                   : (size_t)(at - text);
    }
    return strcspn(text, "\n");
}

int ui_draw_wrapped(struct ui *ui, struct vertices *to, const struct area *at,
                    const char *text, uint32_t rgba)
{
    int height = 0;
    while (*text) {
        char line[512];
        const size_t n = line_length(ui->font, text, at->width);
        snprintf(line, sizeof(line), "%.*s", (int)n, text);
        if (to)
            ui_draw_text(ui, to, at->x, at->y + height, at->width, line, rgba);
        height += ui->font->line;
        text += n;
        text += *text == ' ' || *text == '\n';
    }
    return height;
}

void ui_format(double value, char *text, size_t n_bytes)
{
    if (isnan(value))
        snprintf(text, n_bytes, "unknown");
    else if (isinf(value))
        snprintf(text, n_bytes, "%sInfinity", value < 0 ? "-" : "");
    else
        snprintf(text, n_bytes, "%.5g", value);
}
