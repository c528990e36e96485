/* SPDX-License-Identifier: Apache-2.0 */
/* Text that is typed. */
#include "controls/ui_parts.h"

#include <stdio.h>
#include <string.h>

void ui_begin_edit(struct ui *ui, const char *text)
{
    ui->is_editing = true;
    snprintf(ui->edit, sizeof(ui->edit), "%s", text);
    ui->caret = strlen(ui->edit);
    ui->is_selected = *text != 0;
}

static void insert_text(struct ui *ui, const char *text)
{
    if (*text && ui->is_selected)
        ui_begin_edit(ui, "");
    if (*text)
        ui->error_id = 0;
    const size_t n = strlen(ui->edit), more = strlen(text);
    if (n + more >= sizeof(ui->edit))
        return;
    memmove(ui->edit + ui->caret + more, ui->edit + ui->caret, n - ui->caret + 1);
    memcpy(ui->edit + ui->caret, text, more);
    ui->caret += more;
}

static bool is_inside(const char *at)
{
    return ((unsigned char)*at & 0xc0) == 0x80; /* of a letter of several bytes */
}

static void erase(struct ui *ui, size_t from, size_t to)
{
    memmove(ui->edit + from, ui->edit + to, strlen(ui->edit + to) + 1);
    ui->caret = from;
}

static size_t before_caret(const struct ui *ui)
{
    size_t at = ui->caret;
    while (at > 0 && is_inside(ui->edit + --at))
        ;
    return at;
}

static size_t after_caret(const struct ui *ui)
{
    size_t at = ui->caret;
    at += ui->edit[at] != 0;
    while (is_inside(ui->edit + at))
        at++;
    return at;
}

/* True when the text is to be taken. */
bool ui_type(struct ui *ui)
{
    insert_text(ui, ui->input.text);
    const bool is_erased =
        ui->input.key == UI_KEY_BACKSPACE || ui->input.key == UI_KEY_DELETE;
    if (is_erased && ui->is_selected) {
        ui_begin_edit(ui, "");
        return false;
    }
    if (ui->input.key != UI_KEY_NONE)
        ui->is_selected = false;
    switch (ui->input.key) {
    case UI_KEY_BACKSPACE:
        erase(ui, before_caret(ui), ui->caret);
        break;
    case UI_KEY_DELETE:
        erase(ui, ui->caret, after_caret(ui));
        break;
    case UI_KEY_LEFT:
        ui->caret = before_caret(ui);
        break;
    case UI_KEY_RIGHT:
        ui->caret = after_caret(ui);
        break;
    case UI_KEY_HOME:
        ui->caret = 0;
        break;
    case UI_KEY_END:
        ui->caret = strlen(ui->edit);
        break;
    case UI_KEY_ENTER:
    case UI_KEY_TAB:
    case UI_KEY_BACK_TAB:
        ui->is_editing = false;
        return true;
    default:
        break;
    }
    return false;
}

void ui_draw_edit(struct ui *ui, const struct area *area)
{
    const int pad = ui->gap, caret = font_width(ui->font, ui->edit, ui->caret);
    const int room = area->width - 2 * pad;
    const int shift = caret > room ? caret - room : 0;
    const struct area bar = {area->x + pad + caret - shift, area->y + pad,
                             ui->font->size_px / 12 + 1, area->height - 2 * pad};
    ui_draw_box(ui, &ui->flat, area, EDIT_COLOUR);
    struct area selected = *area;
    selected.width =
        ui->is_selected ? font_width(ui->font, ui->edit, SIZE_MAX) + 2 * pad : 0;
    selected.width = selected.width < area->width ? selected.width : area->width;
    ui_draw_box(ui, &ui->flat, &selected, FILL_COLOUR);
    /* What was scrolled out on the left is not drawn. */
    const char *from = ui->edit;
    int skipped = 0;
    while (skipped < shift)
        skipped += font_next(ui->font, &from)->advance;
    ui_draw_text(ui, &ui->flat, area->x + pad + skipped - shift, ui_text_top(ui, area),
                 room, from, TEXT_COLOUR);
    ui_draw_box(ui, &ui->flat, &bar, FOCUS_COLOUR);
}

bool ui_is_committed(struct ui *ui, const struct ui_now *now)
{
    return now->id == ui->commit;
}

bool ui_text_field(struct ui *ui, const char *label, char *text, size_t n_bytes)
{
    const struct area row = ui_next_area(ui);
    const bool is_off = ui->about.why_off != NULL;
    const struct area area = ui_split_label(ui, &row, label, is_off, 6);
    const struct ui_now now = ui_add_control(ui, label, &area);
    bool is_done = ui_is_committed(ui, &now);
    if (is_done) {
        snprintf(text, n_bytes, "%s", ui->committed);
    } else if (ui_is_pressed(ui, &now, &area)) {
        if (!ui->is_editing)
            ui_begin_edit(ui, text);
    } else if (ui->focus == now.id && !ui->is_editing) {
        if (ui->input.key == UI_KEY_ENTER)
            ui_begin_edit(ui, text);
    } else if (ui->focus == now.id) {
        is_done = ui_type(ui);
        if (is_done)
            snprintf(text, n_bytes, "%s", ui->edit);
    }
    ui_draw_box(ui, &ui->flat, &area, is_off ? OFF_FIELD_COLOUR : FIELD_COLOUR);
    if (ui->focus == now.id && ui->is_editing)
        ui_draw_edit(ui, &area);
    else
        ui_draw_label(ui, &area, ui->gap, text, is_off ? OFF_COLOUR : TEXT_COLOUR);
    ui_draw_focus(ui, &now, &area);
    return is_done;
}
