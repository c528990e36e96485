/* SPDX-License-Identifier: Apache-2.0 */
/* Frames, layout, tips and what all controls share; buttons, toggles and sections. */
#include "controls/ui.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "controls/ui_parts.h"

#define SCROLL_ID 2u  /* even: no label's id is */
#define MARGIN_GAPS 3 /* between the panel's sides and its controls */

/* ---- frames --------------------------------------------------------------------- */

void ui_init(struct ui *ui, const struct font *font)
{
    *ui = (struct ui){.font = font};
    ui->row_height = font->line + font->size_px / 2;
    ui->gap = font->size_px / 5 + 1;
}

void ui_free(struct ui *ui)
{
    free(ui->flat.items);
    free(ui->above.items);
    free(ui->bubbles.items);
    ui->flat = ui->above = ui->bubbles = (struct vertices){0};
}

static void scroll_by_wheel(struct ui *ui)
{
    if (ui->input.wheel == 0 || ui->popup ||
        !area_has(&ui->panel, ui->input.x, ui->input.y))
        return;
    ui->scroll -= (int)(ui->input.wheel * 3 * ui->row_height);
    ui->has_wheel = true;
}

static int most_scroll(const struct ui *ui)
{
    const int most = ui->content_height - ui->panel.height;
    return most > 0 ? most : 0;
}

static struct area scroll_bar(const struct ui *ui)
{
    const struct area *p = &ui->panel;
    const int width = 2 * ui->gap, content = ui->content_height;
    if (content <= p->height || p->height < 4 * ui->row_height)
        return (struct area){p->x + p->width, p->y, 0, 0};
    const int height = p->height * p->height / content;
    const int bar = height > 2 * ui->row_height ? height : 2 * ui->row_height;
    const int y = (int)((double)(p->height - bar) * ui->scroll / most_scroll(ui));
    return (struct area){p->x + p->width - width, p->y + y, width, bar};
}

/* Takes the press on the bar, and the mouse while it is held. */
static void drag_scroll_bar(struct ui *ui)
{
    const struct area bar = scroll_bar(ui);
    struct area track = bar;
    track.y = ui->panel.y;
    track.height = ui->panel.height;
    if (ui->input.is_pressed && area_has(&track, ui->input.x, ui->input.y)) {
        const bool is_on_bar = area_has(&bar, ui->input.x, ui->input.y);
        ui->active = SCROLL_ID;
        ui->grabbed_y = is_on_bar ? ui->input.y - bar.y : bar.height / 2.0;
    }
    if (ui->active != SCROLL_ID || bar.height >= ui->panel.height)
        return;
    const double at = ui->input.y - ui->grabbed_y - ui->panel.y;
    ui->scroll = (int)(at * most_scroll(ui) / (ui->panel.height - bar.height));
}

static void limit_scroll(struct ui *ui)
{
    const int most = most_scroll(ui);
    ui->scroll = ui->scroll > most ? most : ui->scroll;
    ui->scroll = ui->scroll < 0 ? 0 : ui->scroll;
}

/* A press elsewhere takes what was typed, as Enter does. */
static void commit_by_press(struct ui *ui)
{
    if (!ui->input.is_pressed)
        return;
    ui->error_id = 0;
    if (!ui->is_editing)
        return;
    for (int i = 0; i < ui->n_controls; i++)
        if (ui->ids[i] == ui->focus &&
            area_has(&ui->controls[i].area, ui->input.x, ui->input.y))
            return;
    ui->commit = ui->focus;
    snprintf(ui->committed, sizeof(ui->committed), "%s", ui->edit);
    ui->is_editing = false;
}

void ui_begin(struct ui *ui, const struct ui_input *input, const struct area *panel)
{
    ui->input = *input;
    ui->panel = *panel;
    commit_by_press(ui);
    if (input->key != UI_KEY_NONE || input->text[0])
        ui->pressed = 0;
    ui->flat.n = ui->above.n = ui->bubbles.n = 0;
    ui->n_controls = 0;
    ui->has_wheel = false;
    ui->n_columns = 1;
    ui->column = 0;
    ui->about = (struct ui_about){0};
    ui->is_tip_due = false;
    scroll_by_wheel(ui);
    drag_scroll_bar(ui);
    limit_scroll(ui);
    ui->pen_y = panel->y + ui->gap - ui->scroll;
    if (input->key == UI_KEY_TAB || input->key == UI_KEY_BACK_TAB)
        ui->tab = input->key;
}

void ui_leave_focus(struct ui *ui)
{
    ui->focus = 0;
    ui->is_editing = false;
    ui->popup = 0;
}

static void scroll_to(struct ui *ui, const struct area *area)
{
    const int below = area->y + area->height - ui->panel.y - ui->panel.height;
    if (below > 0)
        ui->scroll += below + ui->gap;
    if (area->y < ui->panel.y)
        ui->scroll -= ui->panel.y - area->y + ui->gap;
}

/* The focus goes to the next control, or with back-tab to the one before. */
static void move_focus(struct ui *ui)
{
    int at = -1;
    const int n = ui->n_controls;
    for (int i = 0; i < n; i++)
        if (ui->ids[i] == ui->focus)
            at = i;
    ui_leave_focus(ui);
    for (int tried = 0; tried < n; tried++) {
        at = ui->tab == UI_KEY_TAB ? at + 1 : at <= 0 ? n - 1 : at - 1;
        at = at == n ? 0 : at;
        if (ui->controls[at].is_off)
            continue;
        ui->focus = ui->ids[at];
        scroll_to(ui, &ui->controls[at].area);
        return;
    }
}

/* ---- tips ------------------------------------------------------------------------- */

static bool is_overlapping(const struct area *a, const struct area *b)
{
    return a->x < b->x + b->width && b->x < a->x + a->width &&
           a->y < b->y + b->height && b->y < a->y + a->height;
}

/* A box beside a row, or below it where there is no room; over everything. It keeps
 * clear of `other`, whose width is 0 for none. Returns where it lies; without room it is
 * not drawn and its width is 0. */
static struct area draw_bubble(struct ui *ui, const struct area *row, const char *text,
                               uint32_t colour, const struct area *other)
{
    const int pad = 2 * ui->gap, em = ui->font->size_px;
    const int room = ui->panel.x - 4 * pad;
    struct area box = {0, row->y, room < 24 * em ? room : 24 * em, 0};
    const bool is_beside = box.width >= 10 * em;
    if (!is_beside)
        box.width = ui->panel.width - 4 * pad;
    const int one_line = font_width(ui->font, text, SIZE_MAX);
    box.width = one_line < box.width ? one_line : box.width;
    const int height = ui_draw_wrapped(ui, NULL, &box, text, colour) + 2 * pad;
    box.x = is_beside ? ui->panel.x - box.width - 2 * pad : ui->panel.x + 2 * pad;
    if (!is_beside)
        box.y = row->y + row->height + ui->gap;
    const int end = ui->panel.y + ui->panel.height - (is_beside ? ui->covered : 0);
    if (box.y + height > end)
        box.y = is_beside ? end - height : row->y - height;
    box.y = box.y < ui->panel.y ? ui->panel.y : box.y;
    struct area ground = {box.x - pad, box.y, box.width + 2 * pad, height};
    if (is_overlapping(&ground, other)) {
        const int below = other->y + other->height + ui->gap;
        ground.y = below + height <= end ? below : other->y - ui->gap - height;
        if (ground.y < ui->panel.y)
            return (struct area){0};
    }
    ui_draw_box(ui, &ui->bubbles, &ground, EDIT_COLOUR);
    ui_draw_frame(ui, &ui->bubbles, &ground, 1,
                  colour == TEXT_COLOUR ? DIM_COLOUR : colour);
    box.y = ground.y + pad;
    ui_draw_wrapped(ui, &ui->bubbles, &box, text, colour);
    return ground;
}

/* Remembers what would be said of the control below the mouse. */
static void note_tip(struct ui *ui, const struct ui_now *now, const struct area *area)
{
    const struct ui_about *about = &now->about;
    if (!about->tip && !about->why_off)
        return;
    ui->is_tip_due = true;
    ui->tip_row = *area;
    if (ui->hovered != now->id) {
        ui->hovered = now->id;
        ui->hovered_s = ui->input.now_s;
    }
    snprintf(ui->tip, sizeof(ui->tip), "%s%s%s%s", about->tip ? about->tip : "",
             about->tip && about->why_off ? "\n" : "",
             about->why_off ? "Without effect: " : "",
             about->why_off ? about->why_off : "");
}

/* `error`: where an error is shown. */
static void draw_tip(struct ui *ui, const struct area *error)
{
    if (!ui->is_tip_due || ui->active || ui->popup) {
        ui->is_tip_shown = false;
        if (!ui->is_tip_due)
            ui->hovered = 0;
        ui->tip[0] = ui->is_tip_due ? ui->tip[0] : 0;
        return;
    }
    ui->is_tip_shown = ui->input.now_s - ui->hovered_s >= UI_TIP_S;
    if (ui->is_tip_shown)
        draw_bubble(ui, &ui->tip_row, ui->tip, TEXT_COLOUR, error);
}

double ui_waits_s(const struct ui *ui, double now_s)
{
    if (!ui->is_tip_due || ui->is_tip_shown || ui->active || ui->popup)
        return INFINITY;
    return fmax(ui->hovered_s + UI_TIP_S - now_s, 0.001);
}

void ui_end(struct ui *ui)
{
    ui->content_height = ui->pen_y + ui->scroll - ui->panel.y + ui->row_height;
    if (ui->tab)
        move_focus(ui);
    ui->tab = UI_KEY_NONE;
    ui->commit = 0;
    if (ui->input.key == UI_KEY_ESCAPE) {
        ui_leave_focus(ui);
        ui->error_id = 0;
    }
    const bool is_outside =
        !area_has(&ui->panel, ui->input.x, ui->input.y) &&
        !(ui->popup && area_has(&ui->popup_area, ui->input.x, ui->input.y));
    if (ui->input.is_pressed && is_outside)
        ui_leave_focus(ui);
    if (ui->input.is_released || !ui->input.is_down)
        ui->active = 0;
    const struct area bar = scroll_bar(ui);
    ui_draw_box(ui, &ui->flat, &bar,
                ui->active == SCROLL_ID ? PRESSED_COLOUR : FIELD_COLOUR);
    struct area error = {0};
    if (ui->error_id)
        error = draw_bubble(ui, &ui->error_row, ui->error, ERROR_COLOUR, &error);
    draw_tip(ui, &error);
}

bool ui_has_keyboard(const struct ui *ui)
{
    return ui->focus != 0;
}

bool ui_is_dragging(const struct ui *ui)
{
    return ui->active != 0;
}

/* ---- layout --------------------------------------------------------------------- */

void ui_columns(struct ui *ui, int n)
{
    ui->n_columns = n;
    ui->column = 0;
}

struct area ui_next_area(struct ui *ui)
{
    const int pad = MARGIN_GAPS * ui->gap;
    const int room = ui->panel.width - 2 * pad - (ui->n_columns - 1) * ui->gap;
    const int width = room / ui->n_columns;
    const struct area area = {ui->panel.x + pad + ui->column * (width + ui->gap),
                              ui->pen_y, width > 1 ? width : 1, ui->row_height};
    if (++ui->column == ui->n_columns) {
        ui->pen_y += ui->row_height + ui->gap;
        ui->column = 0;
        ui->n_columns = 1;
    }
    return area;
}

struct area ui_split_label(struct ui *ui, const struct area *row, const char *label,
                           bool is_off, int twentieths)
{
    const int left = row->width * twentieths / 20;
    const struct area label_area = {row->x, row->y, left, row->height};
    ui_draw_label(ui, &label_area, 0, label, is_off ? OFF_COLOUR : DIM_COLOUR);
    return (struct area){row->x + left, row->y, row->width - left, row->height};
}

void ui_space(struct ui *ui)
{
    ui->pen_y += 2 * ui->gap;
}

void ui_heading(struct ui *ui, const char *text)
{
    ui_space(ui);
    const struct area area = ui_next_area(ui);
    ui_draw_label(ui, &area, 0, text, FOCUS_COLOUR);
}

void ui_note(struct ui *ui, const char *text)
{
    const int pad = MARGIN_GAPS * ui->gap;
    const struct area at = {ui->panel.x + pad, ui->pen_y, ui->panel.width - 2 * pad, 0};
    ui->pen_y += ui_draw_wrapped(ui, &ui->flat, &at, text, DIM_COLOUR) + ui->gap;
}

void ui_readout(struct ui *ui, const char *label, const char *value)
{
    const struct area row = ui_next_area(ui);
    const struct area area = ui_split_label(ui, &row, label, false, 9);
    struct ui_now now = {.about = ui->about};
    ui->about = (struct ui_about){0};
    now.id = 0;
    if (ui_is_over(ui, &row))
        note_tip(ui, &now, &row);
    ui_draw_label(ui, &area, ui->gap, value, TEXT_COLOUR);
}

/* ---- what all controls share ---------------------------------------------------- */

void ui_about(struct ui *ui, const struct ui_about *about)
{
    ui->about = *about;
}

void ui_fail(struct ui *ui, const char *text)
{
    ui->error_id = ui->last;
    ui->error_row = ui->last_area;
    snprintf(ui->error, sizeof(ui->error), "%s", text);
}

bool ui_was_reset(const struct ui *ui)
{
    return ui->was_reset;
}

static uint32_t id_of(const char *label)
{
    uint32_t hash = 2166136261u;
    for (; *label; label++)
        hash = (hash ^ (unsigned char)*label) * 16777619u;
    return hash | 1;
}

/* Is the mouse on it, and not on a list that lies above? */
bool ui_is_over(const struct ui *ui, const struct area *area)
{
    const double x = ui->input.x, y = ui->input.y;
    return area_has(area, x, y) && area_has(&ui->panel, x, y) &&
           !(ui->popup && area_has(&ui->popup_area, x, y));
}

struct ui_now ui_add_control(struct ui *ui, const char *label, const struct area *area)
{
    const struct ui_now now = {
        .id = id_of(label), .about = ui->about, .is_off = ui->about.why_off != NULL};
    ui->about = (struct ui_about){0};
    ui->last = now.id;
    ui->last_area = *area;
    ui->was_reset = false;
    if (ui->n_controls < UI_MAX_CONTROLS) {
        struct ui_control *control = &ui->controls[ui->n_controls];
        *control = (struct ui_control){.area = *area, .is_off = now.is_off};
        snprintf(control->label, sizeof(control->label), "%s", label);
        ui->ids[ui->n_controls++] = now.id;
    }
    if (now.is_off && ui->focus == now.id)
        ui_leave_focus(ui);
    /* The whole row, its label too. */
    const struct area row = {ui->panel.x, area->y, area->x + area->width - ui->panel.x,
                             area->height};
    const bool is_alone = ui->column == 0 && ui->n_columns == 1;
    if (ui_is_over(ui, is_alone && area->width < ui->panel.width * 3 / 4 ? &row : area))
        note_tip(ui, &now, area);
    return now;
}

bool ui_is_pressed(struct ui *ui, const struct ui_now *now, const struct area *area)
{
    if (now->is_off || !ui->input.is_pressed || !ui_is_over(ui, area) ||
        ui->active == SCROLL_ID)
        return false;
    if (ui->focus != now->id)
        ui_leave_focus(ui);
    ui->active = now->id;
    ui->focus = now->id;
    ui->pressed = now->id;
    ui->has_moved = false;
    ui->pressed_x = ui->input.x;
    return true;
}

static bool is_clicked(struct ui *ui, const struct ui_now *now, const struct area *area)
{
    if (now->is_off)
        return false;
    const bool was_pressed = ui_is_pressed(ui, now, area) || ui->active == now->id;
    const bool by_key = ui->focus == now->id && (ui->input.key == UI_KEY_ENTER ||
                                                 ui->input.key == UI_KEY_SPACE);
    return by_key || (was_pressed && ui->input.is_released && ui_is_over(ui, area));
}

bool ui_takes_reset(struct ui *ui, const struct ui_now *now, const struct area *area)
{
    const bool is_double = ui->input.is_pressed && ui->input.is_double &&
                           ui->pressed == now->id && ui_is_over(ui, area) &&
                           !now->is_off;
    const bool is_key =
        ui->focus == now->id && !ui->is_editing && ui->input.key == UI_KEY_DELETE;
    if (!is_double && !is_key)
        return false;
    ui->is_editing = false;
    ui->popup = 0;
    ui->active = ui->pressed = 0;
    ui->was_reset = true;
    return true;
}

void ui_draw_focus(struct ui *ui, const struct ui_now *now, const struct area *area)
{
    const int px = ui->font->size_px / 10 + 1;
    if (ui->error_id == now->id)
        ui_draw_frame(ui, &ui->flat, area, px, ERROR_COLOUR);
    else if (ui->focus == now->id)
        ui_draw_frame(ui, &ui->flat, area, px, FOCUS_COLOUR);
}

/* ---- buttons, toggles, sections ------------------------------------------------- */

static bool draw_button(struct ui *ui, const char *label, uint32_t colour)
{
    const struct area area = ui_next_area(ui);
    const struct ui_now now = ui_add_control(ui, label, &area);
    const bool is_done = is_clicked(ui, &now, &area);
    const uint32_t field = now.is_off             ? OFF_FIELD_COLOUR
                           : ui->active == now.id ? PRESSED_COLOUR
                                                  : colour;
    ui_draw_box(ui, &ui->flat, &area, field);
    ui_draw_label(ui, &area, 2 * ui->gap, label, now.is_off ? OFF_COLOUR : TEXT_COLOUR);
    ui_draw_focus(ui, &now, &area);
    return is_done;
}

bool ui_button(struct ui *ui, const char *label)
{
    return draw_button(ui, label, FIELD_COLOUR);
}

bool ui_toggle(struct ui *ui, const char *label, bool *value)
{
    const bool is_done = draw_button(ui, label, *value ? FILL_COLOUR : FIELD_COLOUR);
    if (is_done)
        *value = !*value;
    return is_done;
}

/* Was the section turned to the other than it was at first? */
static int find_fold(const struct ui *ui, uint32_t id)
{
    for (int i = 0; i < ui->n_folds; i++)
        if (ui->folds[i] == id)
            return i;
    return -1;
}

static void turn_fold(struct ui *ui, uint32_t id)
{
    const int at = find_fold(ui, id);
    if (at >= 0)
        ui->folds[at] = ui->folds[--ui->n_folds];
    else if (ui->n_folds < UI_MAX_FOLDS)
        ui->folds[ui->n_folds++] = id;
}

bool ui_section(struct ui *ui, const char *label, bool is_open_at_first)
{
    char name[48], text[64];
    ui_space(ui);
    snprintf(name, sizeof(name), "Section %s", label);
    const struct area area = ui_next_area(ui);
    const struct ui_now now = ui_add_control(ui, name, &area);
    if (is_clicked(ui, &now, &area))
        turn_fold(ui, now.id);
    const bool is_open = is_open_at_first != (find_fold(ui, now.id) >= 0);
    snprintf(text, sizeof(text), "%s %s", is_open ? "▾" : "▸", label);
    ui_draw_label(ui, &area, 0, text, FOCUS_COLOUR);
    ui_draw_focus(ui, &now, &area);
    return is_open;
}
