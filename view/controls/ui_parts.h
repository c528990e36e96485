/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the controls share; for no other file. */
#ifndef VIEW_UI_PARTS_H
#define VIEW_UI_PARTS_H

#include "controls/ui.h"

/* 0xRRGGBBAA, on UI_PANEL_COLOUR; contrast of text to ground 11:1 and more, of what is
 * disabled 4:1. */
#define FIELD_COLOUR 0x3a3a40ff
#define FILL_COLOUR 0x4a6a94ff
#define PRESSED_COLOUR 0x5a86c4ff
#define TEXT_COLOUR 0xecececff
#define DIM_COLOUR 0xb8b8beff
#define OFF_COLOUR 0x8a8a90ff
#define OFF_FIELD_COLOUR 0x2c2c30ff
#define FOCUS_COLOUR 0xffc14dff
#define EDIT_COLOUR 0x101014ff
#define ERROR_COLOUR 0xff7b6bff

/* ---- drawing ---------------------------------------------------------------------- */

void ui_draw_frame(struct ui *ui, struct vertices *to, const struct area *area, int px,
                   uint32_t rgba);
/* A text in a row of a control, vertically in the middle, `pad` px from its sides. */
void ui_draw_label(struct ui *ui, const struct area *area, int pad, const char *text,
                   uint32_t rgba);
int ui_text_top(const struct ui *ui, const struct area *area);

/* ---- what all controls share ------------------------------------------------------ */

/* The place of the next control. */
struct area ui_next_area(struct ui *ui);

/* A control and what the caller said about it. */
struct ui_now {
    uint32_t id;
    struct ui_about about;
    bool is_off; /* disabled */
};

/* Names the control for Tab, tips and tests; uses up what was said about it. */
struct ui_now ui_add_control(struct ui *ui, const char *label, const struct area *area);

/* Splits the label off the left of a row and draws it. */
struct area ui_split_label(struct ui *ui, const struct area *row, const char *label,
                           bool is_off, int twentieths);

/* Takes the mouse and the focus where it was pressed. */
bool ui_is_pressed(struct ui *ui, const struct ui_now *now, const struct area *area);
bool ui_is_over(const struct ui *ui, const struct area *area);
void ui_leave_focus(struct ui *ui);
void ui_draw_focus(struct ui *ui, const struct ui_now *now, const struct area *area);

/* A double click on it, or Delete while it has the keyboard: the caller puts the value
 * back. Ends typing. */
bool ui_takes_reset(struct ui *ui, const struct ui_now *now, const struct area *area);

/* ---- typing ------------------------------------------------------------------------ */

void ui_begin_edit(struct ui *ui, const char *text);

/* True when the text in ui->edit is to be taken. */
bool ui_type(struct ui *ui);
void ui_draw_edit(struct ui *ui, const struct area *area);

/* Was the control left while it was typed in? ui->committed is to be taken. */
bool ui_is_committed(struct ui *ui, const struct ui_now *now);

#endif
