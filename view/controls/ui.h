/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Controls in one column: sections that fold, numbers with a slider, choices, toggles,
 * buttons, lines of text. Immediate mode: every frame the caller names all controls,
 * each draws itself and says whether it was changed. Nothing here knows SDL or OpenGL:
 * what the user did comes in as struct ui_input, what is to be drawn comes out as
 * vertices.
 *
 * Mouse: drag a number's bar, click it to type, double click puts it back; click the
 * rest; rest on a control for its tip. Keyboard: Tab and Shift+Tab go from control to
 * control, left and right change, digits or Enter type a number, Delete puts it back,
 * Enter or space presses a button, Escape leaves.
 */
#ifndef VIEW_UI_H
#define VIEW_UI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "controls/font.h"
#include "controls/gl.h"
#include "model/expression.h"
#include "pixels/zoom.h"

enum ui_key {
    UI_KEY_NONE,
    UI_KEY_TAB,
    UI_KEY_BACK_TAB,
    UI_KEY_ENTER,
    UI_KEY_SPACE,
    UI_KEY_ESCAPE,
    UI_KEY_BACKSPACE,
    UI_KEY_DELETE,
    UI_KEY_LEFT,
    UI_KEY_RIGHT,
    UI_KEY_UP,
    UI_KEY_DOWN,
    UI_KEY_HOME,
    UI_KEY_END,
};

/* What happened since the last frame. */
struct ui_input {
    double x, y;     /* the mouse, window px */
    bool is_down;    /* the left button */
    bool is_pressed; /* went down, came up */
    bool is_released;
    bool is_double;  /* the press is the second one of a double click */
    bool is_fine;    /* Shift is held */
    double wheel;    /* turns, up is positive */
    double now_s;    /* of a clock */
    enum ui_key key; /* at most one a frame */
    char text[256];  /* typed or pasted, UTF-8 */
};

/* The ground of the panel, 0xRRGGBBAA; the caller draws it. */
#define UI_PANEL_COLOUR 0x26262aff

#define UI_MAX_CONTROLS 160
#define UI_MAX_FOLDS 32
#define UI_TIP_S 0.5 /* the mouse rests for so long before a tip is shown */

struct ui_control {
    char label[48];
    struct area area;
    bool is_off; /* disabled */
};

/* What is said about the next control. */
struct ui_about {
    const char *tip;     /* what it does; NULL: nothing to say */
    const char *why_off; /* disables it: why it has no effect; NULL: it has */
    const char *mark;    /* a word beside the value, such as "guess"; NULL: none */
    const char *const *choice_tips; /* of a choice's items; NULL: none */
};

struct vertices {
    struct gl_vertex *items;
    size_t n, n_room;
};

struct ui {
    const struct font *font;
    struct ui_input input;
    /* Within the panel, after that anywhere, and last of all tips and errors. */
    struct vertices flat, above, bubbles;
    struct area panel;
    int pen_y, n_columns, column, row_height, gap; /* px */
    int scroll, content_height;
    int covered; /* px beside the panel's end that tips and errors leave free */
    uint32_t active, focus; /* 0: none */
    uint32_t pressed;       /* where the last press was, unless keys came since */
    bool is_editing, has_moved;
    bool is_selected; /* all of the text: what is typed replaces it */
    double pressed_x;
    char edit[4096];
    size_t caret;
    uint32_t popup;
    struct area popup_area;
    int popup_first; /* the item at its top, where it has no room for all */
    struct ui_control controls[UI_MAX_CONTROLS]; /* of this frame, in order */
    uint32_t ids[UI_MAX_CONTROLS];
    int n_controls;
    enum ui_key tab;       /* to be done when all controls are known */
    bool has_wheel;        /* the wheel was used by a control */
    struct ui_about about; /* of the next control */
    uint32_t last;         /* the control before that */
    struct area last_area;
    bool was_reset;   /* it is to be put back */
    uint32_t hovered; /* below the mouse; 0: none */
    double hovered_s; /* since when */
    char tip[640];    /* of that; "" for none */
    bool is_tip_due, is_tip_shown;
    struct area tip_row;
    uint32_t commit;      /* left while it was typed in; 0: none */
    char committed[4096]; /* what was typed there */
    uint32_t error_id;    /* what was typed or set there is impossible; 0: none */
    char error[256];      /* why */
    struct area error_row;
    uint32_t folds[UI_MAX_FOLDS]; /* sections that are not as they were at first */
    int n_folds;
    double grabbed_y; /* of the scroll bar */
};

void ui_init(struct ui *ui, const struct font *font);
void ui_free(struct ui *ui);

/* A frame: the controls named in between lie in `panel`. */
void ui_begin(struct ui *ui, const struct ui_input *input, const struct area *panel);
void ui_end(struct ui *ui);

/* Does a control have the keyboard? Then letters are no commands. */
bool ui_has_keyboard(const struct ui *ui);

/* Is a slider held? */
bool ui_is_dragging(const struct ui *ui);

/* Seconds until the picture changes though nothing happens: a tip comes; INFINITY. */
double ui_waits_s(const struct ui *ui, double now_s);

/* Says this about the next control; what it points to lives until the frame's end. */
void ui_about(struct ui *ui, const struct ui_about *about);

/* Says at the last control why what was typed or set there is impossible. */
void ui_fail(struct ui *ui, const char *text);

/* Is the last control, whose value holds, to be put back to where it came from? */
bool ui_was_reset(const struct ui *ui);

/* A heading that folds what follows; is that shown? */
bool ui_section(struct ui *ui, const char *label, bool is_open_at_first);
void ui_heading(struct ui *ui, const char *text);
/* A line of text that is not cut but goes on below. */
void ui_note(struct ui *ui, const char *text);
/* A value that cannot be changed. */
void ui_readout(struct ui *ui, const char *label, const char *value);
void ui_space(struct ui *ui);
/* The next n controls share a row. */
void ui_columns(struct ui *ui, int n);

struct ui_number {
    const char *label;
    const char *unit; /* "" for none */
    double min, max;  /* of the slider; typing may go beyond, up to the limits */
    double min_limit, max_limit;
    bool is_log, is_whole;
    bool has_infinity;             /* max_limit stands for it */
    struct expression_field field; /* what may be typed */
};
/* A value of NAN is not known; it goes with a control that is disabled. */
bool ui_number(struct ui *ui, const struct ui_number *number, double *value);
bool ui_choice(struct ui *ui, const char *label, const char *const *names, int n,
               int *index);
bool ui_toggle(struct ui *ui, const char *label, bool *value);
bool ui_button(struct ui *ui, const char *label);
bool ui_text_field(struct ui *ui, const char *label, char *text, size_t n_bytes);

/* ---- for everything else that is drawn ------------------------------------------ */

void ui_draw_box(struct ui *ui, struct vertices *to, const struct area *area,
                 uint32_t rgba);
/* Returns the width. Text that is wider than `max_width` is cut and ends in dots. */
int ui_draw_text(struct ui *ui, struct vertices *to, int x, int y, int max_width,
                 const char *text, uint32_t rgba);

/* A text in lines of at most `width` px; returns their height. With `to` NULL it is only
 * measured. */
int ui_draw_wrapped(struct ui *ui, struct vertices *to, const struct area *at,
                    const char *text, uint32_t rgba);

/* "8", "0.05", "1.25e+06": up to 5 digits that matter; "Infinity"; "unknown" for NAN. */
void ui_format(double value, char *text, size_t n_bytes);

#endif
