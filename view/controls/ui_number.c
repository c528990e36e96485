/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers with a slider. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "controls/ui_parts.h"
#include "model/number.h"

static bool change(double *value, double to)
{
    const bool is_changed = to != *value;
    *value = to;
    return is_changed;
}

/* What typing begins with. */
static void begin(struct ui *ui, const struct ui_number *n, double value)
{
    char text[32];
    if (n->has_infinity && value >= n->max_limit)
        snprintf(text, sizeof(text), "inf");
    else if (isnan(value))
        text[0] = 0;
    else
        snprintf(text, sizeof(text), "%.9g", value);
    ui_begin_edit(ui, text);
}

static bool drag_number(struct ui *ui, const struct ui_now *now,
                        const struct ui_number *n, const struct area *area,
                        double *value)
{
    ui_is_pressed(ui, now, area);
    if (ui->active != now->id || ui->is_editing)
        return false;
    if (fabs(ui->input.x - ui->pressed_x) >= 3)
        ui->has_moved = true;
    if (!ui->has_moved && ui->input.is_released)
        begin(ui, n, *value);
    if (!ui->has_moved)
        return false;
    const double at = (ui->input.x - area->x) / area->width;
    return change(value, number_limit(n, number_round(number_at(n, at))));
}

/* Digits, and what expressions may begin with. */
static bool is_number_text(const char *text)
{
    return *text && strchr("0123456789.-+(", *text) != NULL;
}

/* Takes a text that was typed; says at the field why it cannot be. */
static bool take_text(struct ui *ui, const struct ui_number *n, const char *text,
                      double *value)
{
    char reason[160], low[32], high[32];
    double typed;
    if (!expression_read(text, &n->field, &typed, reason, sizeof(reason))) {
        ui_fail(ui, reason);
        return false;
    }
    if (n->has_infinity && typed >= n->max_limit)
        typed = n->max_limit;
    ui_format(n->min_limit, low, sizeof(low));
    ui_format(n->has_infinity ? INFINITY : n->max_limit, high, sizeof(high));
    snprintf(reason, sizeof(reason), "from %s to %s%s%s is possible", low, high,
             n->unit[0] ? " " : "", n->unit);
    const bool is_within = typed >= n->min_limit && typed <= n->max_limit;
    if (!is_within)
        ui_fail(ui, reason);
    else if (n->is_whole && typed != round(typed))
        ui_fail(ui, "a whole number is needed");
    else
        return change(value, typed);
    return false;
}

static bool type_number(struct ui *ui, const struct ui_number *n, double *value)
{
    if (!ui->is_editing && is_number_text(ui->input.text))
        ui_begin_edit(ui, "");
    else if (!ui->is_editing)
        return false;
    if (!ui_type(ui))
        return false;
    const bool is_changed = take_text(ui, n, ui->edit, value);
    if (ui->error_id == ui->last) { /* goes on typing */
        ui->is_editing = true;
        ui->tab = UI_KEY_NONE;
    }
    return is_changed;
}

/* Left and right: a fiftieth of the slider, with Shift a tenth of that. */
static bool step_number(struct ui *ui, const struct ui_number *n, double *value)
{
    const bool is_up = ui->input.key == UI_KEY_RIGHT || ui->input.key == UI_KEY_UP;
    const bool is_down = ui->input.key == UI_KEY_LEFT || ui->input.key == UI_KEY_DOWN;
    if (ui->input.key == UI_KEY_ENTER)
        begin(ui, n, *value);
    if ((!is_up && !is_down) || isnan(*value))
        return false;
    const double step = (is_up ? 1 : -1) * (ui->input.is_fine ? 0.002 : 0.02);
    double next = number_at(n, number_position(n, *value) + step);
    if (n->is_whole)
        next = *value + (is_up ? 1 : -1);
    return change(value, number_limit(n, number_round(next)));
}

static void draw_number(struct ui *ui, const struct ui_number *n,
                        const struct ui_now *now, const struct area *area, double value)
{
    char text[64], number[40];
    struct area fill = *area;
    const bool is_infinite = n->has_infinity && value >= n->max_limit;
    ui_format(is_infinite ? INFINITY : value, number, sizeof(number));
    snprintf(text, sizeof(text), "%s%s%s", number,
             *n->unit && !is_infinite && !isnan(value) ? " " : "",
             is_infinite || isnan(value) ? "" : n->unit);
    ui_draw_box(ui, &ui->flat, area, now->is_off ? OFF_FIELD_COLOUR : FIELD_COLOUR);
    if (!now->is_off) {
        fill.width = (int)(number_position(n, value) * area->width);
        ui_draw_box(ui, &ui->flat, &fill, FILL_COLOUR);
    }
    ui_draw_label(ui, area, ui->gap, text, now->is_off ? OFF_COLOUR : TEXT_COLOUR);
    if (!now->about.mark)
        return;
    const int width = font_width(ui->font, now->about.mark, SIZE_MAX) + 2 * ui->gap;
    const struct area right = {area->x + area->width - width, area->y, width,
                               area->height};
    if (font_width(ui->font, text, SIZE_MAX) + width + ui->gap < area->width)
        ui_draw_label(ui, &right, ui->gap, now->about.mark, FOCUS_COLOUR);
}

bool ui_number(struct ui *ui, const struct ui_number *number, double *value)
{
    const struct area row = ui_next_area(ui);
    const bool is_off = ui->about.why_off != NULL;
    const struct area area = ui_split_label(ui, &row, number->label, is_off, 9);
    const struct ui_now now = ui_add_control(ui, number->label, &area);
    bool is_changed = false;
    if (ui_is_committed(ui, &now))
        is_changed = take_text(ui, number, ui->committed, value);
    else if (!ui_takes_reset(ui, &now, &area))
        is_changed = drag_number(ui, &now, number, &area, value);
    const bool was_editing = ui->is_editing;
    const bool has_keys = ui->focus == now.id && !is_changed && !ui->was_reset;
    if (has_keys)
        is_changed = type_number(ui, number, value);
    if (has_keys && !was_editing && !ui->is_editing && !is_changed)
        is_changed = step_number(ui, number, value);
    if (ui->focus == now.id && ui->is_editing)
        ui_draw_edit(ui, &area);
    else
        draw_number(ui, number, &now, &area, *value);
    ui_draw_focus(ui, &now, &area);
    return is_changed;
}
