/* SPDX-License-Identifier: Apache-2.0 */
/* Looks of lenses: their menu, keeping one's own, and what is said of them. */
#include <stdio.h>
#include <string.h>

#include "app.h"
#include "clock.h"
#include "console/cli.h"
#include "model/fields.h"
#include "sources/look_window.h"
#include "sources/looks.h"

/* ---- the menu -------------------------------------------------------------------- */

enum { MOST_LOOKS = 254 };

/* How old the list may be, s: other programs keep and remove looks, too. */
#define LISTED_S 1.0

/* The names of the looks behind the first item of a menu; returns how many. A look that
 * is set and is not among them, as a file of --look, stands at the end. */
static int list_looks(const struct app *app, const char **names)
{
    static struct look_about looks[MOST_LOOKS];
    static int n_looks;
    static double listed_s;
    const double now_s = os_clock_s();
    const char *set = app->state.setters.look;
    bool is_listed = !*set;
    if (n_looks == 0 || now_s - listed_s > LISTED_S) {
        n_looks = look_list(looks, MOST_LOOKS);
        listed_s = now_s;
    }
    names[0] = "no look";
    for (int i = 0; i < n_looks; i++) {
        names[i + 1] = looks[i].name;
        is_listed |= strcmp(looks[i].name, set) == 0;
    }
    if (!is_listed)
        names[n_looks + 1] = set;
    return n_looks + 1 + !is_listed;
}

/* Does a look that is kept have the parameter? */
static bool is_of_look(const struct rf_param_info *info)
{
    struct field field;
    field_of(info, &field);
    return field.section >= FIELD_FOCUS_SURFACE && field.section <= FIELD_CHARACTER;
}

/* Parameters of surface in focus, aperture and character that are set beside a look: "",
 * or "; swirl, cat-eye stay as they were set". */
static void list_others(const struct state *state, char *text, size_t n_bytes)
{
    size_t n, used = 0;
    int n_others = 0;
    const struct rf_param_info *list = rf_param_list(&n);
    *text = 0;
    for (size_t i = 0; i < n && used < n_bytes; i++) {
        if (!is_of_look(&list[i]) ||
            settings_origin(&state->typed, list[i].key) != ORIGIN_COMMAND_LINE ||
            state_setter(state, list[i].key) == SETTER_LOOK)
            continue;
        used += (size_t)snprintf(text + used, n_bytes - used, "%s%s",
                                 n_others++ ? ", " : "; ", list[i].key);
    }
    if (n_others > 0 && used < n_bytes)
        snprintf(text + used, n_bytes - used, " %s",
                 n_others == 1 ? "stays as it was set" : "stay as they were set");
}

/* A look sets several parameters at once, in place of the look before. */
void looks_menu_row(struct app *app)
{
    const char *names[MOST_LOOKS + 2];
    char others[256];
    const int n = list_looks(app, names);
    int index = 0;
    for (int i = 1; i < n; i++)
        if (strcmp(names[i], app->state.setters.look) == 0)
            index = i;
    ui_about(&app->ui,
             &(struct ui_about){.tip = "Sets the parameters of a kind of lens, as "
                                       "--look does, in place of those that the look "
                                       "before set; rackfocus looks lists them."});
    const bool is_changed = ui_choice(&app->ui, "Look", names, n, &index);
    const bool was_reset = ui_was_reset(&app->ui);
    if (!is_changed && !was_reset)
        return;
    if (was_reset)
        index = 0;
    if (!state_set_look(&app->state, index ? names[index] : "")) {
        ui_fail(&app->ui, app->state.problem);
        return;
    }
    list_others(&app->state, others, sizeof(others));
    if (index)
        view_say(app, "look %s is set%s", names[index], others);
    else
        view_say(app, "no look is set%s", others);
}

/* ---- one's own ------------------------------------------------------------------- */

/* What a look keeps of what is set; false: nothing is. */
static bool take_look(const struct state *state, struct settings *look)
{
    size_t n;
    int n_taken = 0;
    const struct rf_param_info *list = rf_param_list(&n);
    settings_init(look);
    for (size_t i = 0; i < n; i++) {
        if (!is_of_look(&list[i]) ||
            settings_origin(&state->typed, list[i].key) != ORIGIN_COMMAND_LINE)
            continue;
        settings_take(look, &state->typed, list[i].key);
        n_taken++;
    }
    return n_taken > 0;
}

static void keep_look(struct app *app)
{
    struct settings look;
    struct image_error error;
    char path[MAX_PATH];
    const char *name = app->look_name;
    if (!take_look(&app->state, &look)) {
        view_say(app, "nothing is to be kept: no parameter of Aperture, Character and "
                      "Focus surface is set");
        return;
    }
    if (look_path(name, path, sizeof(path)) && !save_may_replace(app, path))
        return;
    if (!look_save(name, &look, &error)) {
        view_say(app, "%s", error.message);
        return;
    }
    if (!state_set_look(&app->state, name))
        view_say(app, "%s", app->state.problem);
    else if (look_is_given(name))
        view_say(app,
                 "look %s is kept, in place of the one of that name that comes with "
                 "the program; remove %s to have that again",
                 name, path);
    else
        view_say(app, "look %s is kept: --look %s sets it", name, name);
}

void looks_menu_keep_rows(struct app *app)
{
    struct ui *ui = &app->ui;
    ui_about(ui, &(struct ui_about){.tip = "The name of a look of your own: letters, "
                                           "digits, - and _."});
    ui_text_field(ui, "Look's name", app->look_name, sizeof(app->look_name));
    ui_about(ui,
             &(struct ui_about){
                 .tip = "Keeps what is set of Aperture, Character and Focus surface "
                        "as a look, for this menu and --look.",
                 .why_off = app->look_name[0] ? NULL : "type a name above it"});
    if (ui_button(ui, "Keep as a look"))
        keep_look(app);
}

/* ---- a part of the picture ------------------------------------------------------- */

static bool is_read(const void *user, const struct rf_param_info *info)
{
    return !state_why_off(user, info->key);
}

void looks_menu_describe_place(struct app *app, char *text, size_t n_bytes)
{
    char why[2400];
    const struct stage *stage = app->stage;
    const char *key = NULL;
    *text = 0;
    if (stage) {
        const struct look_window given = {.source = &stage->source,
                                          .settings = &app->state.settings,
                                          .is_scene = stage->is_scene,
                                          .is_read = is_read,
                                          .user = &app->state};
        key = look_window_explain(&given, why, sizeof(why));
    }
    if (key)
        snprintf(
            text, n_bytes,
            "The file is a part of its picture: --%s is measured in that part, not "
            "in the whole.",
            key);
    if (key && !app->misplaced) {
        char before[1510] = "";
        if (os_clock_s() < app->status_until_s) /* what is being read */
            snprintf(before, sizeof(before), "%.1500s; ", app->status);
        view_say(app, "%s%s", before, why);
        message("%s", why);
    }
    app->misplaced = key;
}
