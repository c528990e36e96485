/* SPDX-License-Identifier: Apache-2.0 */
/* Choices with a list. */
#include <stdio.h>

#include "controls/ui_parts.h"

/* How many of n items the list shows. */
static int rows_of_list(const struct ui *ui, int n)
{
    const int most = ui->panel.height / ui->row_height;
    return n < most ? n : most > 1 ? most : 1;
}

/* Moves the list of n items so that an item is seen; < 0: none need be. */
static void scroll_list(struct ui *ui, int n, int item)
{
    const int rows = rows_of_list(ui, n);
    int *first = &ui->popup_first;
    if (item >= 0 && item < *first)
        *first = item;
    if (item >= *first + rows)
        *first = item - rows + 1;
    if (*first > n - rows)
        *first = n - rows;
    if (*first < 0)
        *first = 0;
}

/* The list of n rows below the field, or above it where there is no room. */
static struct area list_area(const struct ui *ui, const struct area *field, int n)
{
    struct area list = {field->x, field->y + field->height, field->width,
                        n * ui->row_height};
    if (list.y + list.height > ui->panel.y + ui->panel.height)
        list.y = field->y - list.height;
    if (list.y < ui->panel.y)
        list.y = ui->panel.y;
    return list;
}

/* What an item is, to the left of the list. */
static void draw_item_tip(struct ui *ui, const struct area *item, const char *tip)
{
    const int pad = 2 * ui->gap, width = font_width(ui->font, tip, SIZE_MAX);
    const struct area ground = {item->x - width - 2 * pad, item->y, width + 2 * pad,
                                item->height};
    ui_draw_box(ui, &ui->above, &ground, EDIT_COLOUR);
    ui_draw_text(ui, &ui->above, ground.x + pad, ui_text_top(ui, item), width, tip,
                 DIM_COLOUR);
}

static void pick_from_list(struct ui *ui, const struct area *field,
                           const char *const *names, const char *const *tips, int n,
                           int *index)
{
    const int rows = rows_of_list(ui, n);
    const struct area list = list_area(ui, field, rows);
    if (ui->input.wheel != 0) {
        ui->popup_first -= (int)(3 * ui->input.wheel);
        scroll_list(ui, n, -1);
    }
    const int first = ui->popup_first;
    ui->popup_area = list;
    ui_draw_box(ui, &ui->above, &list, EDIT_COLOUR);
    for (int i = first; i < first + rows; i++) {
        const struct area item = {list.x, list.y + (i - first) * ui->row_height,
                                  list.width, ui->row_height};
        const bool is_here = area_has(&item, ui->input.x, ui->input.y);
        if (is_here || i == *index)
            ui_draw_box(ui, &ui->above, &item, is_here ? FILL_COLOUR : FIELD_COLOUR);
        ui_draw_text(ui, &ui->above, item.x + ui->gap, ui_text_top(ui, &item),
                     item.width - 2 * ui->gap, names[i], TEXT_COLOUR);
        if (is_here && tips && tips[i])
            draw_item_tip(ui, &item, tips[i]);
        if (is_here && ui->input.is_pressed) {
            *index = i;
            ui->popup = 0;
            ui->pressed = 0; /* a press of the control soon after is no double click */
            ui->input.is_pressed = false; /* not for what lies below the list */
        }
    }
    if (rows < n) {
        const struct area bar = {list.x + list.width - ui->gap,
                                 list.y + first * list.height / n, ui->gap,
                                 rows * list.height / n};
        ui_draw_box(ui, &ui->above, &bar, OFF_COLOUR);
    }
}

static void open_or_close_list(struct ui *ui, uint32_t id, int n, int index)
{
    ui->popup = ui->popup == id ? 0 : id;
    ui->popup_first = 0;
    scroll_list(ui, n, index);
}

static int step_choice(const struct ui *ui, int n, int index)
{
    switch (ui->input.key) {
    case UI_KEY_LEFT:
    case UI_KEY_UP:
        return (index + n - 1) % n;
    case UI_KEY_RIGHT:
    case UI_KEY_DOWN:
        return (index + 1) % n;
    default:
        return index;
    }
}

bool ui_choice(struct ui *ui, const char *label, const char *const *names, int n,
               int *index)
{
    const struct area row = ui_next_area(ui);
    const bool is_off = ui->about.why_off != NULL;
    const struct area area = ui_split_label(ui, &row, label, is_off, 9);
    const struct ui_now now = ui_add_control(ui, label, &area);
    const int before = *index;
    if (ui->popup == now.id)
        pick_from_list(ui, &area, names, now.about.choice_tips, n, index);
    if (!ui_takes_reset(ui, &now, &area)) {
        if (ui_is_pressed(ui, &now, &area))
            open_or_close_list(ui, now.id, n, *index);
        if (ui->focus == now.id) {
            *index = step_choice(ui, n, *index);
            if (ui->popup == now.id && *index != before)
                scroll_list(ui, n, *index);
        }
        /* Space and Enter open the list, and close it when it was walked. */
        if (ui->focus == now.id &&
            (ui->input.key == UI_KEY_ENTER || ui->input.key == UI_KEY_SPACE))
            open_or_close_list(ui, now.id, n, *index);
    }
    char text[96];
    snprintf(text, sizeof(text), "▸ %s", names[*index]);
    ui_draw_box(ui, &ui->flat, &area, is_off ? OFF_FIELD_COLOUR : FIELD_COLOUR);
    ui_draw_label(ui, &area, ui->gap, text, is_off ? OFF_COLOUR : TEXT_COLOUR);
    ui_draw_focus(ui, &now, &area);
    return *index != before;
}
