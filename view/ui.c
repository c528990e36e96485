/* SPDX-License-Identifier: Apache-2.0 */
#include "ui.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "number.h"
#include "report.h"

/* 0xRRGGBBAA, on UI_PANEL_COLOUR; contrast of text to ground 11:1 and more. */
#define FIELD_COLOUR 0x3a3a40ff
#define FILL_COLOUR 0x4a6a94ff
#define PRESSED_COLOUR 0x5a86c4ff
#define TEXT_COLOUR 0xecececff
#define DIM_COLOUR 0xb8b8beff
#define FOCUS_COLOUR 0xffc14dff
#define EDIT_COLOUR 0x101014ff

/* ---- drawing -------------------------------------------------------------------- */

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

static void draw_frame(struct ui *ui, const struct area *a, int px, uint32_t rgba)
{
    const struct area sides[4] = {{a->x, a->y, a->width, px},
                                  {a->x, a->y + a->height - px, a->width, px},
                                  {a->x, a->y, px, a->height},
                                  {a->x + a->width - px, a->y, px, a->height}};
    for (int i = 0; i < 4; i++)
        ui_draw_box(ui, &ui->flat, &sides[i], rgba);
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
static int text_top(const struct ui *ui, const struct area *area)
{
    return area->y + (area->height - ui->font->line) / 2;
}

static void draw_label(struct ui *ui, const struct area *area, int pad,
                       const char *text, uint32_t rgba)
{
    ui_draw_text(ui, &ui->flat, area->x + pad, text_top(ui, area),
                 area->width - 2 * pad, text, rgba);
}

void ui_format(double value, char *text, size_t n_bytes)
{
    if (isinf(value))
        snprintf(text, n_bytes, "%s∞", value < 0 ? "−" : "");
    else
        snprintf(text, n_bytes, "%.5g", value);
}

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
    ui->flat = ui->above = (struct vertices){0};
}

static void scroll_by_wheel(struct ui *ui)
{
    if (ui->input.wheel == 0 || ui->popup ||
        !area_has(&ui->panel, ui->input.x, ui->input.y))
        return;
    ui->scroll -= (int)(ui->input.wheel * 3 * ui->row_height);
    ui->has_wheel = true;
}

void ui_begin(struct ui *ui, const struct ui_input *input, const struct area *panel)
{
    ui->input = *input;
    ui->panel = *panel;
    ui->flat.n = ui->above.n = 0;
    ui->n_controls = 0;
    ui->has_wheel = false;
    ui->n_columns = 1;
    ui->column = 0;
    scroll_by_wheel(ui);
    const int most = ui->content_height - panel->height;
    ui->scroll = ui->scroll > most ? most : ui->scroll;
    ui->scroll = ui->scroll < 0 ? 0 : ui->scroll;
    ui->pen_y = panel->y + ui->gap - ui->scroll;
    if (input->key == UI_KEY_TAB || input->key == UI_KEY_BACK_TAB)
        ui->tab = input->key;
}

static void leave_focus(struct ui *ui)
{
    ui->focus = 0;
    ui->is_editing = false;
    ui->popup = 0;
}

/* The focus goes to the next control, or with back-tab to the one before. */
static void move_focus(struct ui *ui)
{
    int at = -1;
    const int n = ui->n_controls;
    for (int i = 0; i < n; i++)
        if (ui->ids[i] == ui->focus)
            at = i;
    leave_focus(ui);
    if (n == 0)
        return;
    at = ui->tab == UI_KEY_TAB ? at + 1 : at <= 0 ? n - 1 : at - 1;
    at = at == n ? 0 : at;
    const struct area *area = &ui->controls[at].area;
    ui->focus = ui->ids[at];
    const int below = area->y + area->height - ui->panel.y - ui->panel.height;
    if (below > 0)
        ui->scroll += below + ui->gap;
    if (area->y < ui->panel.y)
        ui->scroll -= ui->panel.y - area->y + ui->gap;
}

void ui_end(struct ui *ui)
{
    ui->content_height = ui->pen_y + ui->scroll - ui->panel.y + ui->row_height;
    if (ui->tab)
        move_focus(ui);
    ui->tab = UI_KEY_NONE;
    if (ui->input.key == UI_KEY_ESCAPE)
        leave_focus(ui);
    const bool is_outside =
        !area_has(&ui->panel, ui->input.x, ui->input.y) &&
        !(ui->popup && area_has(&ui->popup_area, ui->input.x, ui->input.y));
    if (ui->input.is_pressed && is_outside)
        leave_focus(ui);
    if (ui->input.is_released || !ui->input.is_down)
        ui->active = 0;
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

static struct area next_area(struct ui *ui)
{
    const int pad = 2 * ui->gap;
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

void ui_space(struct ui *ui)
{
    ui->pen_y += 2 * ui->gap;
}

void ui_heading(struct ui *ui, const char *text)
{
    ui_space(ui);
    const struct area area = next_area(ui);
    draw_label(ui, &area, 0, text, FOCUS_COLOUR);
}

void ui_readout(struct ui *ui, const char *label, const char *value)
{
    struct area area = next_area(ui);
    const int left = area.width * 9 / 20;
    const struct area value_area = {area.x + left, area.y, area.width - left,
                                    area.height};
    area.width = left;
    draw_label(ui, &area, 0, label, DIM_COLOUR);
    draw_label(ui, &value_area, ui->gap, value, TEXT_COLOUR);
}

/* ---- what all controls share ---------------------------------------------------- */

static uint32_t id_of(const char *label)
{
    uint32_t hash = 2166136261u;
    for (; *label; label++)
        hash = (hash ^ (unsigned char)*label) * 16777619u;
    return hash | 1;
}

/* Is the mouse on it, and not on a list that lies above? */
static bool is_over(const struct ui *ui, const struct area *area)
{
    const double x = ui->input.x, y = ui->input.y;
    return area_has(area, x, y) && area_has(&ui->panel, x, y) &&
           !(ui->popup && area_has(&ui->popup_area, x, y));
}

/* Names the control for Tab and for tests; returns its id. */
static uint32_t add_control(struct ui *ui, const char *label, const struct area *area)
{
    const uint32_t id = id_of(label);
    if (ui->n_controls < UI_MAX_CONTROLS) {
        struct ui_control *control = &ui->controls[ui->n_controls];
        snprintf(control->label, sizeof(control->label), "%s", label);
        control->area = *area;
        ui->ids[ui->n_controls++] = id;
    }
    return id;
}

/* Takes the mouse and the focus where it was pressed. */
static bool is_pressed(struct ui *ui, uint32_t id, const struct area *area)
{
    if (!ui->input.is_pressed || !is_over(ui, area))
        return false;
    if (ui->focus != id)
        leave_focus(ui);
    ui->active = id;
    ui->focus = id;
    ui->has_moved = false;
    ui->pressed_x = ui->input.x;
    return true;
}

static bool is_clicked(struct ui *ui, uint32_t id, const struct area *area)
{
    const bool was_pressed = is_pressed(ui, id, area) || ui->active == id;
    const bool by_key = ui->focus == id && (ui->input.key == UI_KEY_ENTER ||
                                            ui->input.key == UI_KEY_SPACE);
    return by_key || (was_pressed && ui->input.is_released && is_over(ui, area));
}

static void draw_focus(struct ui *ui, uint32_t id, const struct area *area)
{
    if (ui->focus == id)
        draw_frame(ui, area, ui->font->size_px / 10 + 1, FOCUS_COLOUR);
}

/* ---- buttons and toggles -------------------------------------------------------- */

static bool draw_button(struct ui *ui, const char *label, uint32_t colour)
{
    const struct area area = next_area(ui);
    const uint32_t id = add_control(ui, label, &area);
    const bool is_done = is_clicked(ui, id, &area);
    ui_draw_box(ui, &ui->flat, &area, ui->active == id ? PRESSED_COLOUR : colour);
    draw_label(ui, &area, 2 * ui->gap, label, TEXT_COLOUR);
    draw_focus(ui, id, &area);
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

/* ---- typing --------------------------------------------------------------------- */

static void begin_edit(struct ui *ui, const char *text)
{
    ui->is_editing = true;
    snprintf(ui->edit, sizeof(ui->edit), "%s", text);
    ui->caret = strlen(ui->edit);
    ui->is_selected = *text != 0;
}

static void insert_text(struct ui *ui, const char *text)
{
    if (*text && ui->is_selected)
        begin_edit(ui, "");
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
static bool type(struct ui *ui)
{
    insert_text(ui, ui->input.text);
    const bool is_erased =
        ui->input.key == UI_KEY_BACKSPACE || ui->input.key == UI_KEY_DELETE;
    if (is_erased && ui->is_selected) {
        begin_edit(ui, "");
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

static void draw_edit(struct ui *ui, const struct area *area)
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
    ui_draw_text(ui, &ui->flat, area->x + pad + skipped - shift, text_top(ui, area),
                 room, from, TEXT_COLOUR);
    ui_draw_box(ui, &ui->flat, &bar, FOCUS_COLOUR);
}

bool ui_text_field(struct ui *ui, const char *label, char *text, size_t n_bytes)
{
    struct area area = next_area(ui);
    const int left = area.width * 6 / 20;
    const struct area label_area = {area.x, area.y, left, area.height};
    area.x += left;
    area.width -= left;
    const uint32_t id = add_control(ui, label, &area);
    bool is_done = false;
    if (is_pressed(ui, id, &area) && !ui->is_editing)
        begin_edit(ui, text);
    else if (ui->focus == id && !ui->is_editing && ui->input.key == UI_KEY_ENTER)
        begin_edit(ui, text);
    else if (ui->focus == id && ui->is_editing)
        is_done = type(ui);
    if (is_done)
        snprintf(text, n_bytes, "%s", ui->edit);
    draw_label(ui, &label_area, 0, label, DIM_COLOUR);
    ui_draw_box(ui, &ui->flat, &area, FIELD_COLOUR);
    if (ui->focus == id && ui->is_editing)
        draw_edit(ui, &area);
    else
        draw_label(ui, &area, ui->gap, text, TEXT_COLOUR);
    draw_focus(ui, id, &area);
    return is_done;
}

/* ---- numbers -------------------------------------------------------------------- */

static bool drag_number(struct ui *ui, uint32_t id, const struct ui_number *n,
                        const struct area *area, double *value)
{
    is_pressed(ui, id, area);
    if (ui->active != id || ui->is_editing)
        return false;
    if (fabs(ui->input.x - ui->pressed_x) >= 3)
        ui->has_moved = true;
    if (!ui->has_moved && ui->input.is_released) {
        char text[32];
        snprintf(text, sizeof(text), "%.9g", *value);
        begin_edit(ui, text);
    }
    if (!ui->has_moved)
        return false;
    const double at = (ui->input.x - area->x) / area->width;
    const double dragged = number_limit(n, number_round(number_at(n, at)));
    const bool is_changed = dragged != *value;
    *value = dragged;
    return is_changed;
}

static bool is_number_text(const char *text)
{
    return *text && strchr("0123456789.-+", *text) != NULL;
}

static bool type_number(struct ui *ui, const struct ui_number *n, double *value)
{
    if (!ui->is_editing && is_number_text(ui->input.text))
        begin_edit(ui, "");
    else if (!ui->is_editing)
        return false;
    if (!type(ui))
        return false;
    char *end;
    for (char *c = ui->edit; *c; c++)
        *c = *c == ',' ? '.' : *c;
    const double typed = strtod(ui->edit, &end);
    if (end == ui->edit || isnan(typed))
        return false;
    const double limited = number_limit(n, n->is_whole ? round(typed) : typed);
    const bool is_changed = limited != *value;
    *value = limited;
    return is_changed;
}

/* Left and right: a fiftieth of the slider, with Shift a tenth of that. */
static bool step_number(struct ui *ui, const struct ui_number *n, double *value)
{
    const bool is_up = ui->input.key == UI_KEY_RIGHT || ui->input.key == UI_KEY_UP;
    const bool is_down = ui->input.key == UI_KEY_LEFT || ui->input.key == UI_KEY_DOWN;
    if (ui->input.key == UI_KEY_ENTER) {
        char text[32];
        snprintf(text, sizeof(text), "%.9g", *value);
        begin_edit(ui, text);
    }
    if (!is_up && !is_down)
        return false;
    const double step = (is_up ? 1 : -1) * (ui->input.is_fine ? 0.002 : 0.02);
    double next = number_at(n, number_position(n, *value) + step);
    if (n->is_whole)
        next = *value + (is_up ? 1 : -1);
    next = number_limit(n, number_round(next));
    const bool is_changed = next != *value;
    *value = next;
    return is_changed;
}

static void draw_number(struct ui *ui, const struct ui_number *n,
                        const struct area *area, double value)
{
    char text[64], number[40];
    struct area fill = *area;
    fill.width = (int)(number_position(n, value) * area->width);
    ui_format(value, number, sizeof(number));
    snprintf(text, sizeof(text), "%s%s%s", number, *n->unit ? " " : "", n->unit);
    ui_draw_box(ui, &ui->flat, area, FIELD_COLOUR);
    ui_draw_box(ui, &ui->flat, &fill, FILL_COLOUR);
    draw_label(ui, area, ui->gap, text, TEXT_COLOUR);
}

bool ui_number(struct ui *ui, const struct ui_number *number, double *value)
{
    struct area area = next_area(ui);
    const int left = area.width * 9 / 20;
    const struct area label_area = {area.x, area.y, left, area.height};
    area.x += left;
    area.width -= left;
    const uint32_t id = add_control(ui, number->label, &area);
    bool is_changed = drag_number(ui, id, number, &area, value);
    const bool was_editing = ui->is_editing;
    if (ui->focus == id && !is_changed)
        is_changed = type_number(ui, number, value);
    if (ui->focus == id && !was_editing && !ui->is_editing && !is_changed)
        is_changed = step_number(ui, number, value);
    draw_label(ui, &label_area, 0, number->label, DIM_COLOUR);
    if (ui->focus == id && ui->is_editing)
        draw_edit(ui, &area);
    else
        draw_number(ui, number, &area, *value);
    draw_focus(ui, id, &area);
    return is_changed;
}

/* ---- choices -------------------------------------------------------------------- */

/* The list below the field, or above it where there is no room. */
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

static bool pick_from_list(struct ui *ui, const struct area *field,
                           const char *const *names, int n, int *index)
{
    const struct area list = list_area(ui, field, n);
    bool is_changed = false;
    ui->popup_area = list;
    ui_draw_box(ui, &ui->above, &list, EDIT_COLOUR);
    for (int i = 0; i < n; i++) {
        const struct area item = {list.x, list.y + i * ui->row_height, list.width,
                                  ui->row_height};
        const bool is_here = area_has(&item, ui->input.x, ui->input.y);
        if (is_here || i == *index)
            ui_draw_box(ui, &ui->above, &item, is_here ? FILL_COLOUR : FIELD_COLOUR);
        ui_draw_text(ui, &ui->above, item.x + ui->gap, text_top(ui, &item),
                     item.width - 2 * ui->gap, names[i], TEXT_COLOUR);
        if (is_here && ui->input.is_pressed) {
            is_changed = i != *index;
            *index = i;
            ui->popup = 0;
        }
    }
    return is_changed;
}

static int step_choice(const struct ui *ui, int n, int index)
{
    switch (ui->input.key) {
    case UI_KEY_LEFT:
    case UI_KEY_UP:
        return (index + n - 1) % n;
    case UI_KEY_RIGHT:
    case UI_KEY_DOWN:
    case UI_KEY_ENTER:
    case UI_KEY_SPACE:
        return (index + 1) % n;
    default:
        return index;
    }
}

bool ui_choice(struct ui *ui, const char *label, const char *const *names, int n,
               int *index)
{
    struct area area = next_area(ui);
    const int left = area.width * 9 / 20;
    const struct area label_area = {area.x, area.y, left, area.height};
    area.x += left;
    area.width -= left;
    const uint32_t id = add_control(ui, label, &area);
    const int before = *index;
    if (ui->popup == id)
        pick_from_list(ui, &area, names, n, index);
    if (is_pressed(ui, id, &area))
        ui->popup = ui->popup == id ? 0 : id;
    if (ui->focus == id)
        *index = step_choice(ui, n, *index);
    char text[64];
    snprintf(text, sizeof(text), "▸ %s", names[*index]);
    draw_label(ui, &label_area, 0, label, DIM_COLOUR);
    ui_draw_box(ui, &ui->flat, &area, FIELD_COLOUR);
    draw_label(ui, &area, ui->gap, text, TEXT_COLOUR);
    draw_focus(ui, id, &area);
    return *index != before;
}
