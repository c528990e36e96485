/* SPDX-License-Identifier: Apache-2.0 */
/* From the events of SDL to actions, drags and what the controls are told. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app.h"
#include "clock.h"

#define MARK_S 3.0 /* the mark of the focus hides no pixels for longer */
#define CLICK_PX 4 /* a button that moved less is a click */

/* ---- keys ----------------------------------------------------------------------- */

static const struct {
    SDL_Keycode key;
    int modifiers;
} keys[N_ACTIONS] = {
#define ACTION_KEY(name, subject, code, mods, shown, help) {code, mods},
    ACTIONS(ACTION_KEY)
#undef ACTION_KEY
};

/* Signs are taken from the typed text, since where they lie depends on the keyboard. */
static bool is_sign(SDL_Keycode key)
{
    return key < 128 && strchr("[],.+-", key) != NULL;
}

static int find_action(SDL_Keycode key, int modifiers)
{
    const int held = (modifiers & KMOD_CTRL ? KMOD_CTRL : 0) |
                     (modifiers & KMOD_SHIFT ? KMOD_SHIFT : 0);
    for (int i = 0; i < N_ACTIONS; i++)
        if (keys[i].key == key && keys[i].modifiers == held && !is_sign(key))
            return i;
    return -1;
}

static enum ui_key key_of_ui(SDL_Keycode key, int modifiers)
{
    switch (key) {
    case SDLK_TAB:
        return modifiers & KMOD_SHIFT ? UI_KEY_BACK_TAB : UI_KEY_TAB;
    case SDLK_RETURN:
    case SDLK_KP_ENTER:
        return UI_KEY_ENTER;
    case SDLK_SPACE:
        return UI_KEY_SPACE;
    case SDLK_ESCAPE:
        return UI_KEY_ESCAPE;
    case SDLK_BACKSPACE:
        return UI_KEY_BACKSPACE;
    case SDLK_DELETE:
        return UI_KEY_DELETE;
    case SDLK_LEFT:
        return UI_KEY_LEFT;
    case SDLK_RIGHT:
        return UI_KEY_RIGHT;
    case SDLK_UP:
        return UI_KEY_UP;
    case SDLK_DOWN:
        return UI_KEY_DOWN;
    case SDLK_HOME:
        return UI_KEY_HOME;
    case SDLK_END:
        return UI_KEY_END;
    default:
        return UI_KEY_NONE;
    }
}

/* Ctrl with a letter while a text is typed. */
static bool edit_by_command(struct app *app, SDL_Keycode key)
{
    char *text = NULL;
    if (key == SDLK_v) {
        text = SDL_GetClipboardText();
        for (char *c = text; c && *c; c++)
            *c = (unsigned char)*c < ' ' ? ' ' : *c;
        snprintf(app->input.text, sizeof(app->input.text), "%s", text ? text : "");
        SDL_free(text);
    } else if (key == SDLK_c) {
        SDL_SetClipboardText(app->ui.edit);
    } else if (key == SDLK_a) {
        app->ui.is_selected = app->ui.edit[0] != 0;
    } else {
        return key == SDLK_z || key == SDLK_y;
    }
    panel_pass(app);
    return true;
}

/* A command is about what was typed, too: as if Enter came before it. False where that
 * cannot be. */
static bool take_typed(struct app *app)
{
    app->input.key = UI_KEY_ENTER;
    panel_pass(app);
    return !app->ui.is_editing;
}

/* Keys that move the help while it is shown. */
static bool scroll_help(struct app *app, SDL_Keycode key)
{
    if (!app->has_help || (key != SDLK_PAGEDOWN && key != SDLK_PAGEUP))
        return false;
    overlay_scroll_help(app, key == SDLK_PAGEDOWN ? 12 : -12);
    return true;
}

static void press_key(struct app *app, const SDL_KeyboardEvent *event)
{
    const SDL_Keycode key = event->keysym.sym;
    const int modifiers = event->keysym.mod;
    const bool is_command = modifiers & KMOD_CTRL;
    const enum ui_key ui_key = key_of_ui(key, modifiers);
    const bool is_tab = ui_key == UI_KEY_TAB || ui_key == UI_KEY_BACK_TAB;
    app->input.is_fine = modifiers & KMOD_SHIFT;
    if ((app->ui.is_editing && is_command && edit_by_command(app, key)) ||
        scroll_help(app, key) || open_list_key(app, key))
        return;
    const int action = find_action(key, modifiers);
    if (app->ui.is_editing && is_command && action >= 0 && action != ACTION_QUIT &&
        !take_typed(app))
        return;
    if (ui_key && !is_command && (is_tab || ui_has_keyboard(&app->ui))) {
        app->input.key = ui_key;
        panel_pass(app);
        return;
    }
    if (ui_key == UI_KEY_ESCAPE) {
        app->has_help = false;
        state_set_eye(&app->state, false, 0, 0);
    }
    /* While a text is typed, letters are letters. */
    if (app->ui.is_editing && !is_command && key < 128)
        return;
    if (app->has_stage && key >= SDLK_1 && key <= SDLK_9 &&
        modifiers & (KMOD_CTRL | KMOD_SHIFT)) {
        if (is_command)
            view_keep_look(app, key - SDLK_0);
        else
            view_set_look(app, key - SDLK_0);
        return;
    }
    if (action >= 0)
        view_act(app, (enum action)action);
    panel_pass(app);
}

static void type_text(struct app *app, const char *text)
{
    const bool is_for_ui = app->ui.is_editing || (ui_has_keyboard(&app->ui) &&
                                                  strchr("0123456789.-(", *text));
    if (is_for_ui) {
        snprintf(app->input.text, sizeof(app->input.text), "%s", text);
    } else if (is_sign((SDL_Keycode)*text)) {
        for (int i = 0; i < N_ACTIONS; i++)
            if (keys[i].key == *text)
                view_act(app, (enum action)i);
    }
    panel_pass(app);
}

/* ---- the mouse ------------------------------------------------------------------ */

static bool is_on_picture(const struct app *app, double x, double y)
{
    const struct area area = view_picture_area(app);
    return area_has(&area, x, y) &&
           !(app->ui.popup && area_has(&app->ui.popup_area, x, y));
}

static bool is_on_split(const struct app *app, double x)
{
    const struct zoom *zoom = &app->state.zoom;
    const double at =
        zoom->x + app->state.split * app->state.width * zoom->scale * zoom->aspect;
    return app->state.is_split && fabs(x - at) < 6 * app->scale;
}

static void move_eye(struct app *app, double dx, double dy)
{
    const struct area area = view_picture_area(app);
    const double radius = 0.3 * (area.width < area.height ? area.width : area.height);
    state_set_eye(&app->state, true, app->state.eye[0] + dx / radius,
                  app->state.eye[1] - dy / radius);
}

static void press_button(struct app *app, const SDL_MouseButtonEvent *event)
{
    const double x = app->input.x, y = app->input.y;
    app->drag_x = x;
    app->drag_y = y;
    if (open_list_click(app, x, y))
        return;
    if (event->button == SDL_BUTTON_LEFT) {
        app->input.is_down = app->input.is_pressed = true;
        app->input.is_double = event->clicks >= 2;
        if (app->has_stage && is_on_picture(app, x, y))
            app->drag = is_on_split(app, x) ? DRAG_SPLIT : DRAG_CLICK;
    } else if (!app->has_stage || !is_on_picture(app, x, y)) {
        return;
    } else if (event->button == SDL_BUTTON_MIDDLE) {
        app->drag = DRAG_PAN;
    } else if (event->button == SDL_BUTTON_RIGHT) {
        app->drag = DRAG_EYE;
        state_set_eye(&app->state, true, 0, 0);
    }
}

static void click(struct app *app, double x, double y)
{
    double depth;
    int32_t px, py;
    char number[32];
    if (play_lacks_pixels(app) || !view_depth_at(app, x, y, &depth, &px, &py))
        return;
    ui_format(depth, number, sizeof(number));
    const bool is_good = state_focus(&app->state, depth);
    app->mark.is_set = is_good;
    app->mark.until_s = os_clock_s() + MARK_S;
    app->mark.x = px;
    app->mark.y = py;
    app->mark.focus = app->state.settings.params.focus_distance;
    if (is_good)
        view_say(app, "focus at depth %s, px (%d, %d)", number, px, py);
}

static void release_button(struct app *app, const SDL_MouseButtonEvent *event)
{
    if (event->button == SDL_BUTTON_LEFT) {
        app->input.is_down = false;
        app->input.is_released = true;
        app->is_let_go = true;
        if (app->drag == DRAG_CLICK)
            click(app, app->input.x, app->input.y);
    }
    if (event->button == SDL_BUTTON_RIGHT && app->drag == DRAG_EYE)
        state_set_eye(&app->state, false, 0, 0);
    app->drag = DRAG_NONE;
}

static void drag(struct app *app, double x, double y)
{
    const double dx = x - app->drag_x, dy = y - app->drag_y;
    struct zoom *zoom = &app->state.zoom;
    const struct area area = view_picture_area(app);
    double px, py;
    if (app->drag == DRAG_CLICK && hypot(dx, dy) < CLICK_PX * app->scale)
        return;
    if (app->drag == DRAG_CLICK)
        app->drag = app->options->is_demo ? DRAG_TURN : DRAG_PAN;
    app->drag_x = x;
    app->drag_y = y;
    switch (app->drag) {
    case DRAG_PAN:
        zoom_pan(zoom, dx, dy);
        zoom_settle(zoom, &area, app->state.width, app->state.height);
        break;
    case DRAG_TURN:
        demo_turn(&app->demo, dx, dy);
        app->is_demo_due = true;
        break;
    case DRAG_SPLIT:
        zoom_to_picture(zoom, x, y, &px, &py);
        app->state.split = fmin(fmax(px / app->state.width, 0), 1);
        break;
    case DRAG_EYE:
        move_eye(app, dx, dy);
        break;
    default:
        break;
    }
}

static void turn_wheel(struct app *app, const SDL_MouseWheelEvent *event)
{
    const double turns = event->preciseY != 0 ? event->preciseY : event->y;
    const struct area area = view_picture_area(app);
    if (app->has_browser) {
        browser_move(&app->browser, turns > 0 ? -3 : 3);
    } else if (app->has_help) {
        overlay_scroll_help(app, -3 * turns);
    } else if (app->has_stage && is_on_picture(app, app->input.x, app->input.y)) {
        zoom_by(&app->state.zoom, pow(2, turns / 4), app->input.x, app->input.y);
        zoom_settle(&app->state.zoom, &area, app->state.width, app->state.height);
    } else {
        app->input.wheel = turns;
    }
    panel_pass(app);
}

/* ---- events --------------------------------------------------------------------- */

static void place_mouse(struct app *app, int x, int y)
{
    app->input.x = x * app->density;
    app->input.y = y * app->density;
}

/* When it happened, in seconds of os_clock_s(). */
static double time_of(const SDL_Event *event)
{
    return os_clock_s() - 1e-3 * (SDL_GetTicks() - event->common.timestamp);
}

static void take_window_event(struct app *app, const SDL_WindowEvent *event)
{
    if (event->event == SDL_WINDOWEVENT_SIZE_CHANGED ||
        event->event == SDL_WINDOWEVENT_EXPOSED)
        view_measure(app);
    if (event->event == SDL_WINDOWEVENT_CLOSE)
        app->is_ending = true;
}

static void take_user_event(struct app *app, const SDL_UserEvent *event)
{
    if (event->code == APP_LOADED) {
        load_end(app);
        play_take_frame(app);
    }
    if (event->code == APP_SAVED) {
        view_say(app, "%s", (const char *)event->data1);
        trace_text(app, "saved", event->data1);
        SDL_free(event->data1);
    }
}

void events_take(struct app *app, const SDL_Event *event)
{
    app->is_redraw_due = true;
    switch (event->type) {
    case SDL_QUIT:
        app->is_ending = true;
        break;
    case SDL_WINDOWEVENT:
        take_window_event(app, &event->window);
        break;
    case SDL_MOUSEMOTION:
        stats_input(&app->stats, time_of(event));
        place_mouse(app, event->motion.x, event->motion.y);
        if (app->drag != DRAG_NONE)
            drag(app, app->input.x, app->input.y);
        break;
    case SDL_MOUSEBUTTONDOWN:
    case SDL_MOUSEBUTTONUP:
        panel_pass(app);
        stats_input(&app->stats, time_of(event));
        place_mouse(app, event->button.x, event->button.y);
        if (event->type == SDL_MOUSEBUTTONDOWN)
            press_button(app, &event->button);
        else
            release_button(app, &event->button);
        panel_pass(app);
        break;
    case SDL_MOUSEWHEEL:
        stats_input(&app->stats, time_of(event));
        turn_wheel(app, &event->wheel);
        break;
    case SDL_KEYDOWN:
        stats_input(&app->stats, time_of(event));
        press_key(app, &event->key);
        break;
    case SDL_TEXTINPUT:
        if (app->has_browser)
            open_list_type(app, event->text.text);
        else
            type_text(app, event->text.text);
        break;
    case SDL_DROPBEGIN:
    case SDL_DROPFILE:
    case SDL_DROPCOMPLETE:
        open_drop(app, &event->drop);
        break;
    default:
        if (event->type == app->event_type)
            take_user_event(app, &event->user);
        break;
    }
}
