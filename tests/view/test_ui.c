/* SPDX-License-Identifier: Apache-2.0 */
/* The controls, by mouse and by keyboard, without a window. */
#include <stdlib.h>

#include "controls/font_find.h"
#include "controls/ui.h"
#include "testing.h"

static struct font font;
static struct ui ui;
static struct ui_input input;
static double number;
static int choice;
static bool toggle;
static char text[64];
static int n_pressed, n_changed, n_reset, n_headings;
static struct ui_about about;
static struct area panel = {100, 0, 300, 400};
static const struct ui_number spec = {.label = "Number",
                                      .unit = "mm",
                                      .min = 1,
                                      .max = 100,
                                      .min_limit = 0.1,
                                      .max_limit = 1000,
                                      .is_log = true,
                                      .field = {.per_mm = 1}};
static const char *const names[] = {"one", "two", "three"};

static void frame(void)
{
    ui_begin(&ui, &input, &panel);
    for (int i = 0; i < n_headings; i++)
        ui_heading(&ui, "Heading");
    ui_about(&ui, &about);
    n_changed += ui_number(&ui, &spec, &number);
    n_reset += ui_was_reset(&ui);
    n_changed += ui_choice(&ui, "Choice", names, 3, &choice);
    n_changed += ui_toggle(&ui, "Toggle", &toggle);
    n_pressed += ui_button(&ui, "Button");
    n_changed += ui_text_field(&ui, "Text", text, sizeof(text));
    ui_end(&ui);
    input.is_pressed = input.is_released = false;
    input.key = UI_KEY_NONE;
    input.text[0] = 0;
}

static void start(void)
{
    ui_free(&ui);
    ui_init(&ui, &font);
    input = (struct ui_input){.x = 5, .y = 5};
    number = 10;
    choice = 0;
    toggle = false;
    n_pressed = n_changed = n_reset = 0;
    about = (struct ui_about){0};
    strcpy(text, "old");
    frame();
}

static struct area area_of(const char *label)
{
    for (int i = 0; i < ui.n_controls; i++)
        if (strcmp(ui.controls[i].label, label) == 0)
            return ui.controls[i].area;
    return (struct area){0};
}

static void move_to(double x, double y)
{
    input.x = x;
    input.y = y;
    frame();
}

static void press_at(double x, double y)
{
    move_to(x, y);
    input.is_down = input.is_pressed = true;
    frame();
}

static void release(void)
{
    input.is_down = false;
    input.is_released = true;
    frame();
}

static void click(const char *label)
{
    const struct area area = area_of(label);
    press_at(area.x + area.width / 2.0, area.y + area.height / 2.0);
    release();
}

static void key(enum ui_key which)
{
    input.key = which;
    frame();
}

static void write_text(const char *letters)
{
    for (; *letters; letters++) {
        snprintf(input.text, sizeof(input.text), "%c", *letters);
        frame();
    }
}

static void a_slider_is_dragged(void)
{
    start();
    const struct area area = area_of("Number");
    press_at(area.x + 20, area.y + 5);
    CHECK(n_changed == 0);
    move_to(area.x + area.width / 2.0, area.y + 200); /* the mouse may leave the row */
    CHECK_NEAR(number, 10, 0.2);
    move_to(area.x + area.width, area.y);
    CHECK(number == 100);
    move_to(area.x - 500, area.y);
    CHECK(number == 1);
    CHECK(ui_is_dragging(&ui));
    release();
    CHECK(!ui_is_dragging(&ui));
    move_to(area.x + area.width, area.y);
    CHECK(number == 1);
}

static void a_number_is_typed(void)
{
    start();
    click("Number");
    CHECK(ui.is_editing && n_changed == 0);
    write_text("2.5"); /* replaces the old text */
    CHECK(number == 10);
    key(UI_KEY_ENTER);
    CHECK(number == 2.5 && n_changed == 1);
    click("Number");
    key(UI_KEY_END); /* keeps it */
    write_text("5");
    key(UI_KEY_LEFT);
    key(UI_KEY_BACKSPACE);
    key(UI_KEY_ENTER);
    CHECK(number == 2.5); /* 2.55 less the first 5 */
    click("Number");
    write_text("7");
    key(UI_KEY_ESCAPE);
    CHECK(number == 2.5 && !ui_has_keyboard(&ui));
}

static void expressions_are_typed(void)
{
    start();
    click("Number");
    write_text("2*3 + 1/4");
    key(UI_KEY_ENTER);
    CHECK(number == 6.25 && ui.error_id == 0);
    click("Number");
    write_text("8.5 cm");
    key(UI_KEY_ENTER);
    CHECK(number == 85);
}

static void what_cannot_be_says_so_at_the_field(void)
{
    static const char *const texts[] = {"9e9", "-3", "nonsense", "inf"};
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); i++) {
        start();
        click("Number");
        write_text(texts[i]);
        key(i % 2 ? UI_KEY_TAB : UI_KEY_ENTER);
        CHECK(number == 10 && ui.error_id != 0 && ui.error[0]);
        CHECK(ui.is_editing && ui.focus != 0); /* goes on typing */
        write_text("5");
        CHECK(ui.error_id == 0);
        key(UI_KEY_ESCAPE);
        CHECK(number == 10);
    }
}

/* What the vertices of this colour cover, of tips and errors. */
static struct area covered(uint32_t rgba)
{
    float from[2] = {1e9f, 1e9f}, to[2] = {-1e9f, -1e9f};
    for (size_t i = 0; i < ui.bubbles.n; i++) {
        const struct gl_vertex *v = &ui.bubbles.items[i];
        const uint32_t colour = (uint32_t)v->rgba[0] << 24 |
                                (uint32_t)v->rgba[1] << 16 | (uint32_t)v->rgba[2] << 8 |
                                v->rgba[3];
        if (colour != rgba)
            continue;
        from[0] = fminf(from[0], v->x);
        from[1] = fminf(from[1], v->y);
        to[0] = fmaxf(to[0], v->x);
        to[1] = fmaxf(to[1], v->y);
    }
    return (struct area){(int)from[0], (int)from[1], (int)(to[0] - from[0]),
                         (int)(to[1] - from[1])};
}

/* Beside the panel, below the row where there is no room, and above it at the end. */
static void an_error_and_a_tip_are_both_read(void)
{
    static const struct area panels[] = {
        {500, 0, 300, 400}, {100, 0, 300, 400}, {500, 0, 300, 200}, {500, 0, 300, 300}};
    const struct area old = panel;
    for (size_t i = 0; i < 4; i++) {
        panel = panels[i];
        n_headings = i < 2 ? 0 : 5;
        start();
        ui.covered = i == 3 ? 100 : 0;
        about = (struct ui_about){.tip = "A number.\nOf several\nlines."};
        click("Number");
        write_text("nonsense");
        key(UI_KEY_ENTER);
        input.now_s += UI_TIP_S;
        frame();
        const struct area error = covered(0xff7b6bff), tip = covered(0xb8b8beff);
        CHECK(ui.error_id != 0 && ui.is_tip_shown);
        CHECK(error.width > 0 && tip.width > 0);
        CHECK(tip.y >= error.y + error.height || error.y >= tip.y + tip.height);
        CHECK(tip.y >= panel.y &&
              tip.y + tip.height <= panel.y + panel.height - ui.covered);
        key(UI_KEY_ESCAPE);
    }
    panel = old;
    n_headings = 0;
    about = (struct ui_about){0};
}

/* A press elsewhere takes what was typed, and does what it is for. */
static void a_press_elsewhere_takes_what_was_typed(void)
{
    start();
    click("Number");
    write_text("12");
    click("Button");
    CHECK(number == 12 && n_pressed == 1 && !ui.is_editing);
    click("Number");
    write_text("abc");
    press_at(5, 5);
    release();
    CHECK(number == 12 && ui.error_id != 0 && strstr(ui.error, "abc"));
    press_at(5, 5);
    CHECK(ui.error_id == 0);
    release();
    click("Text");
    write_text("name");
    click("Toggle");
    CHECK_STR(text, "name");
}

static void a_double_click_puts_back(void)
{
    start();
    click("Number");
    CHECK(n_reset == 0 && ui.is_editing);
    input.is_double = true;
    click("Number");
    input.is_double = false;
    CHECK(n_reset == 1 && !ui.is_editing && number == 10);
    click("Button"); /* the system calls two quick presses nearby a double click */
    input.is_double = true;
    click("Number");
    input.is_double = false;
    CHECK(n_reset == 1);
    key(UI_KEY_ESCAPE);
    CHECK(n_reset == 1);
    key(UI_KEY_TAB);
    key(UI_KEY_DELETE);
    CHECK(n_reset == 2);
}

static void what_is_off_does_nothing_and_says_why(void)
{
    start();
    about = (struct ui_about){.tip = "A number.", .why_off = "it is not read"};
    frame();
    const struct area area = area_of("Number");
    press_at(area.x + 20, area.y + 5);
    move_to(area.x + 200, area.y + 5);
    release();
    CHECK(number == 10 && n_changed == 0 && ui.focus == 0 && !ui.is_editing);
    CHECK(ui.controls[0].is_off);
    key(UI_KEY_TAB);
    CHECK(ui.focus == ui.ids[1]); /* it is skipped */
    move_to(area.x + 20, area.y + 5);
    CHECK(!ui.is_tip_shown && ui_waits_s(&ui, input.now_s) <= UI_TIP_S);
    input.now_s += UI_TIP_S;
    frame();
    CHECK(ui.is_tip_shown && strstr(ui.tip, "A number."));
    CHECK(strstr(ui.tip, "it is not read"));
    move_to(5, 5);
    CHECK(!ui.is_tip_shown && isinf(ui_waits_s(&ui, input.now_s)));
    about = (struct ui_about){0};
}

static bool is_open;

static void folding_frame(void)
{
    ui_begin(&ui, &input, &panel);
    is_open = ui_section(&ui, "Fold", true);
    if (is_open)
        ui_button(&ui, "Inside");
    ui_end(&ui);
    input.is_pressed = input.is_released = false;
}

static void a_section_folds(void)
{
    start();
    for (int i = 0; i < 4; i++) {
        folding_frame();
        CHECK(is_open == (i % 2 == 0));
        CHECK(ui.n_controls == (is_open ? 2 : 1));
        const struct area area = area_of("Section Fold");
        input.x = area.x + 5;
        input.y = area.y + 5;
        input.is_down = input.is_pressed = true;
        folding_frame();
        input.is_down = false;
        input.is_released = true;
        folding_frame();
    }
}

static void the_scroll_bar_is_dragged(void)
{
    static const struct area low = {100, 0, 300, 120};
    start();
    input = (struct ui_input){.x = 398, .y = 5};
    for (int pass = 0; pass < 4; pass++) {
        input.is_pressed = pass == 1;
        input.is_down = pass >= 1;
        input.y = pass >= 2 ? 500 : 5;
        ui_begin(&ui, &input, &low);
        for (int i = 0; i < 20; i++) {
            char label[20];
            snprintf(label, sizeof(label), "Button %d", i);
            CHECK(!ui_button(&ui, label));
        }
        ui_end(&ui);
        CHECK(pass >= 2 || ui.scroll == 0);
    }
    const struct area *last = &ui.controls[19].area;
    CHECK(last->y >= 0 && last->y + last->height <= 120);
}

static void long_text_is_wrapped(void)
{
    start();
    const struct area at = {0, 0, 80, 0};
    ui.flat.n = 0;
    const int height = ui_draw_wrapped(&ui, &ui.flat, &at,
                                       "some words\nthat go on and on", 0xffffffff);
    CHECK(height >= 3 * font.line && height % font.line == 0);
    CHECK(ui_draw_wrapped(&ui, NULL, &at, "some words\nthat go on and on", 0) ==
          height);
    for (size_t i = 0; i < ui.flat.n; i++)
        CHECK(ui.flat.items[i].x <= 82);
    const struct area narrow = {0, 0, 1, 0};
    CHECK(ui_draw_wrapped(&ui, NULL, &narrow, "abc", 0) == 3 * font.line);
}

static void tab_goes_round(void)
{
    start();
    CHECK(!ui_has_keyboard(&ui));
    for (int round = 0; round < 2; round++)
        for (int i = 0; i < ui.n_controls; i++) {
            key(UI_KEY_TAB);
            CHECK(ui.focus == ui.ids[i]);
        }
    key(UI_KEY_TAB);
    key(UI_KEY_BACK_TAB);
    CHECK(ui.focus == ui.ids[ui.n_controls - 1]);
}

static void keys_change_values(void)
{
    start();
    key(UI_KEY_TAB);
    key(UI_KEY_RIGHT);
    CHECK(number > 10);
    key(UI_KEY_LEFT);
    CHECK_NEAR(number, 10, 1e-3);
    write_text("42"); /* digits begin to type */
    key(UI_KEY_TAB);  /* takes it, and goes on */
    CHECK(number == 42);
    key(UI_KEY_RIGHT);
    CHECK(choice == 1);
    key(UI_KEY_LEFT);
    key(UI_KEY_LEFT);
    CHECK(choice == 2);
    key(UI_KEY_TAB);
    key(UI_KEY_SPACE);
    CHECK(toggle);
    key(UI_KEY_TAB);
    key(UI_KEY_ENTER);
    CHECK(n_pressed == 1);
    key(UI_KEY_TAB);
    key(UI_KEY_ENTER);
    write_text("new");
    key(UI_KEY_ENTER);
    CHECK_STR(text, "new");
}

static void a_list_is_walked_by_keys(void)
{
    start();
    key(UI_KEY_TAB);
    key(UI_KEY_TAB);
    key(UI_KEY_ENTER);
    CHECK(ui.popup != 0 && choice == 0);
    key(UI_KEY_DOWN);
    key(UI_KEY_DOWN);
    CHECK(ui.popup != 0 && choice == 2);
    key(UI_KEY_ENTER);
    CHECK(ui.popup == 0 && choice == 2);
    key(UI_KEY_SPACE);
    CHECK(ui.popup != 0);
    key(UI_KEY_UP);
    key(UI_KEY_SPACE);
    CHECK(ui.popup == 0 && choice == 1);
    key(UI_KEY_SPACE);
    key(UI_KEY_TAB); /* goes on, and closes it */
    CHECK(ui.popup == 0 && choice == 1);
}

static void a_list_opens_above_the_rest(void)
{
    start();
    click("Choice");
    CHECK(ui.popup != 0);
    /* The third item lies where the button is; the button must not be pressed. */
    const struct area list = ui.popup_area;
    const double y = list.y + 2.5 * ui.row_height;
    press_at(list.x + 5, y);
    release();
    CHECK(choice == 2 && n_pressed == 0 && !toggle);
    CHECK(ui.popup == 0);
    /* Nor is anything else that lies below an item. */
    for (int i = 0; i < 3; i++) {
        start();
        click("Choice");
        const struct area items = ui.popup_area;
        press_at(items.x + 5, items.y + (i + 0.5) * ui.row_height);
        release();
        CHECK(choice == i && n_pressed == 0 && !toggle && !ui.is_editing);
    }
    click("Choice");
    press_at(10, 10); /* elsewhere */
    release();
    CHECK(ui.popup == 0 && choice == 2);
}

/* A list of more items than the panel has rows for: all can be seen and taken. */
static void a_long_list_scrolls(void)
{
    enum { N = 40 };
    static const char *many[N];
    int index = 39;
    for (int i = 0; i < N; i++)
        many[i] = names[i % 3];
    const int rows = panel.height / ui.row_height;
    start();
    for (int step = 0; step < 6; step++) {
        const struct area *area = &ui.controls[0].area;
        const struct area list = ui.popup_area;
        input.is_pressed = step == 0 || step == 2 || step == 3 || step == 5;
        input.is_released = false;
        input.wheel = step == 4 ? 100 : 0;
        input.x = area->x + 5;
        input.y = step == 2 ? list.y + (rows - 0.5) * ui.row_height : area->y + 3;
        if (step == 5)
            input.y = list.y + 0.5 * ui.row_height;
        ui_begin(&ui, &input, &panel);
        ui_choice(&ui, "Many", many, N, &index);
        ui_end(&ui);
        if (step == 1) { /* it shows the item that is set */
            CHECK(ui.popup != 0 && ui.popup_first == N - rows);
            CHECK(ui.popup_area.y + ui.popup_area.height <= panel.y + panel.height);
            index = 3;
        }
        if (step == 2)
            CHECK(ui.popup == 0 && index == N - 1);
    }
    CHECK(ui.popup == 0 && index == 0); /* turned to its begin */
}

static void a_button_needs_the_release(void)
{
    start();
    const struct area area = area_of("Button");
    press_at(area.x + 5, area.y + 5);
    CHECK(n_pressed == 0);
    move_to(5, 5);
    release();
    CHECK(n_pressed == 0);
    click("Button");
    CHECK(n_pressed == 1);
    click("Toggle");
    CHECK(toggle);
    click("Toggle");
    CHECK(!toggle);
}

static void a_long_column_scrolls(void)
{
    static const struct area low = {100, 0, 300, 60};
    start();
    for (int i = 0; i < 5; i++) {
        input.key = UI_KEY_TAB;
        for (int pass = 0; pass < 2; pass++) {
            ui_begin(&ui, &input, &low);
            ui_number(&ui, &spec, &number);
            ui_choice(&ui, "Choice", names, 3, &choice);
            ui_toggle(&ui, "Toggle", &toggle);
            ui_button(&ui, "Button");
            ui_text_field(&ui, "Text", text, sizeof(text));
            ui_end(&ui);
            input.key = UI_KEY_NONE;
        }
        const struct area *area = &ui.controls[i].area;
        CHECK(ui.focus == ui.ids[i]);
        CHECK(area->y >= 0 && area->y + area->height <= 60);
    }
}

static void long_text_is_cut(void)
{
    start();
    ui.flat.n = 0;
    const int width =
        ui_draw_text(&ui, &ui.flat, 0, 0, 60, "a rather long line of text", 0xffffffff);
    CHECK(width <= 60 && width > 30);
    for (size_t i = 0; i < ui.flat.n; i++)
        CHECK(ui.flat.items[i].x <= 62);
    CHECK(ui_draw_text(&ui, &ui.flat, 0, 0, 1, "x", 0xffffffff) <= 1);
}

int main(int argc, char **argv)
{
    char path[4096], message[4200];
    testing_begin(argc, argv);
    if (!font_find(path, sizeof(path)) ||
        !font_load(&font, path, 14, message, sizeof(message))) {
        printf("Bail out! no font\n");
        return 1;
    }
    TEST(a_slider_is_dragged);
    TEST(a_number_is_typed);
    TEST(expressions_are_typed);
    TEST(what_cannot_be_says_so_at_the_field);
    TEST(an_error_and_a_tip_are_both_read);
    TEST(a_press_elsewhere_takes_what_was_typed);
    TEST(a_double_click_puts_back);
    TEST(what_is_off_does_nothing_and_says_why);
    TEST(a_section_folds);
    TEST(the_scroll_bar_is_dragged);
    TEST(long_text_is_wrapped);
    TEST(tab_goes_round);
    TEST(keys_change_values);
    TEST(a_list_is_walked_by_keys);
    TEST(a_list_opens_above_the_rest);
    TEST(a_long_list_scrolls);
    TEST(a_button_needs_the_release);
    TEST(a_long_column_scrolls);
    TEST(long_text_is_cut);
    ui_free(&ui);
    font_free(&font);
    return testing_end();
}
