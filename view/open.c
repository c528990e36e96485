/* SPDX-License-Identifier: Apache-2.0 */
/* What the user opens: files that are dropped or chosen from a list. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "app.h"
#include "clock.h"
#include "console/cli.h"
#include "sources/params_file.h"

#define TYPING_S 1.0 /* between letters of one name */

static bool ends_with(const char *path, const char *ending)
{
    const size_t n = strlen(path), m = strlen(ending);
    return n > m && strcasecmp(path + n - m, ending) == 0;
}

void view_set_reference(struct app *app, const struct picture *picture,
                        const char *path)
{
    accumulation_switch(app, false); /* what is named last counts */
    reference_drop(app->reference);
    app->reference = reference_create(picture, 0);
    if (path != app->reference_path)
        snprintf(app->reference_path, sizeof(app->reference_path), "%s", path);
    if (!app->reference)
        view_say(app, "out of memory for the reference");
    app->state.id++;
}

bool open_reference(struct app *app, const char *path)
{
    struct image_error error;
    struct picture read = {0};
    if (!picture_read(path, NULL, thread_count(app->options->n_threads), &read,
                      &error)) {
        view_say(app, "%s", error.message);
        return false;
    }
    view_set_reference(app, &read, path);
    if (read.width != app->state.width || read.height != app->state.height)
        view_say(app, "%s: is %d x %d, the picture %d x %d: they cannot be compared",
                 path, read.width, read.height, app->state.width, app->state.height);
    else
        view_say(app, "reference: %s", path);
    return true;
}

static void set_params(struct app *app, const char *path)
{
    struct image_error error;
    struct settings read;
    int n_named = 0;
    settings_init(&read);
    if (!params_file_read(path, &read, &n_named, &error))
        view_say(app, "%s", error.message);
    else if (n_named == 0)
        view_say(app, PARAMS_FILE_IS_EMPTY, path);
    else if (!state_merge(&app->state, &read))
        view_say(app, "%s: %.400s", path, app->state.problem);
    else
        view_say(app, "parameters of %s are set", path);
}

/* Takes the place of what is shown, once it is read. */
static void show_files(struct app *app, char *const *paths, int n)
{
    struct image_error error;
    if (app->loader.is_running) {
        view_say(app, "wait until %s is done", app->loader.stage->label);
        return;
    }
    if (!playlist_open(&app->opening, paths, n, &error)) {
        view_say(app, "%s", error.message);
        return;
    }
    app->is_opening = true;
    load_begin(app);
}

void open_files(struct app *app, char *const *paths, int n)
{
    if (n == 1 && ends_with(paths[0], ".params"))
        set_params(app, paths[0]);
    else if (n == 1 && ends_with(paths[0], ".png"))
        open_reference(app, paths[0]);
    else if (app->options->is_demo)
        view_say(app, "the demo shows its own scene; start rackfocus view with a file");
    else
        show_files(app, paths, n);
}

/* ---- dropping --------------------------------------------------------------------- */

void open_forget(struct app *app)
{
    for (int i = 0; i < app->n_dropped; i++)
        SDL_free(app->dropped[i]);
    free(app->dropped);
    app->dropped = NULL;
    app->n_dropped = 0;
}

static void add_dropped(struct app *app, char *path)
{
    char **list = realloc(app->dropped, ((size_t)app->n_dropped + 1) * sizeof(*list));
    if (!list) {
        SDL_free(path);
        view_say(app, "out of memory");
        return;
    }
    list[app->n_dropped++] = path;
    app->dropped = list;
}

void open_drop(struct app *app, const SDL_DropEvent *event)
{
    if (event->type == SDL_DROPBEGIN)
        open_forget(app);
    if (event->type == SDL_DROPFILE && event->file)
        add_dropped(app, event->file);
    if (event->type != SDL_DROPCOMPLETE || app->n_dropped == 0)
        return;
    if (app->has_stage)
        open_files(app, app->dropped, app->n_dropped);
    open_forget(app);
}

/* ---- the list of files ------------------------------------------------------------ */

static struct area list_area(const struct app *app)
{
    const struct area area = view_picture_area(app);
    const int em = app->font.size_px;
    const int most = 56 * em, width = area.width - 2 * em;
    const int inner = width < most ? width : most;
    return (struct area){area.x + (area.width - inner) / 2, area.y + em, inner,
                         area.height - 2 * em};
}

/* The first row that is shown, and how many there are room for. */
static int list_rows(const struct app *app, int *first)
{
    const int rows = list_area(app).height / app->ui.row_height - 2;
    const int n = rows > 1 ? rows : 1;
    *first = app->browser.at - n / 2;
    *first = *first > app->browser.n - n ? app->browser.n - n : *first;
    *first = *first < 0 ? 0 : *first;
    return n;
}

/* The folder of what is shown; "": none. */
static void find_folder(const struct app *app, char folder[MAX_PATH])
{
    *folder = 0;
    if (app->stage)
        snprintf(folder, MAX_PATH, "%s", app->stage->files->paths[0]);
    char *slash = strrchr(folder, '/');
    if (slash)
        slash[slash == folder] = 0;
    else
        folder[0] = 0;
}

void open_any(struct app *app)
{
    char folder[MAX_PATH];
    find_folder(app, folder);
    if (app->has_browser ||
        (!app->dialog.is_open && !dialog_open(&app->dialog, folder)))
        open_list(app);
    else
        view_say(app,
                 "choose a file in the dialog of the desktop; Ctrl+Shift+O has the "
                 "files opened last");
}

void open_step(struct app *app)
{
    char path[MAX_PATH];
    char *const paths[] = {path};
    switch (dialog_take(&app->dialog, path, sizeof(path))) {
    case DIALOG_CHOSEN:
        open_files(app, paths, 1);
        app->is_redraw_due = true;
        break;
    case DIALOG_FAILED:
        open_list(app);
        app->is_redraw_due = true;
        break;
    default:
        break;
    }
}

void open_list(struct app *app)
{
    char folder[MAX_PATH];
    app->has_browser = !app->has_browser;
    if (!app->has_browser)
        return;
    find_folder(app, folder);
    browser_open(&app->browser, folder, &app->remembered);
    trace_text(app, "list", app->browser.folder);
}

static void choose(struct app *app)
{
    char path[MAX_PATH + 512];
    char *const paths[] = {path};
    if (!browser_choose(&app->browser, path, sizeof(path))) {
        trace_text(app, "list", app->browser.folder);
        return;
    }
    app->has_browser = false;
    open_files(app, paths, 1);
}

bool open_list_key(struct app *app, SDL_Keycode key)
{
    int first;
    if (!app->has_browser)
        return false;
    app->is_redraw_due = true;
    if (key == SDLK_ESCAPE)
        app->has_browser = false;
    else if (key == SDLK_UP || key == SDLK_DOWN)
        browser_move(&app->browser, key == SDLK_UP ? -1 : 1);
    else if (key == SDLK_PAGEUP || key == SDLK_PAGEDOWN)
        browser_move(&app->browser,
                     list_rows(app, &first) * (key == SDLK_PAGEUP ? -1 : 1));
    else if (key == SDLK_RETURN || key == SDLK_KP_ENTER)
        choose(app);
    else if (key == SDLK_BACKSPACE || key == SDLK_LEFT)
        browser_up(&app->browser);
    else
        return key != SDLK_o && key != SDLK_q && key != SDLK_F1;
    return true;
}

void open_list_type(struct app *app, const char *text)
{
    const double now_s = os_clock_s();
    browser_type(&app->browser, text, now_s > app->typed_s + TYPING_S);
    app->typed_s = now_s;
    app->is_redraw_due = true;
    trace_text(app, app->browser.is_unknown ? "not in list" : "in list",
               app->browser.typed);
}

bool open_list_click(struct app *app, double x, double y)
{
    int first;
    if (!app->has_browser)
        return false;
    const struct area area = list_area(app);
    const int n = list_rows(app, &first);
    const int row = (int)(y - area.y) / app->ui.row_height - 1;
    if (!area_has(&area, x, y)) {
        app->has_browser = false;
    } else if (row >= 0 && row < n && first + row < app->browser.n) {
        app->browser.at = first + row;
        choose(app);
    }
    return true;
}

void open_list_draw(struct app *app)
{
    struct ui *ui = &app->ui;
    const struct browser *b = &app->browser;
    int first;
    if (!app->has_browser)
        return;
    const struct area area = list_area(app);
    const int pad = app->font.size_px / 2, height = ui->row_height;
    const int width = area.width - 2 * pad, n = list_rows(app, &first);
    ui_draw_box(ui, &ui->above, &area, 0x101014f4);
    ui_draw_text(ui, &ui->above, area.x + pad, area.y + 4, width,
                 b->problem[0] ? b->problem : b->folder, 0xffc14dff);
    for (int i = 0; i < n && first + i < b->n; i++) {
        const struct browser_item *item = &b->items[first + i];
        const struct area row = {area.x, area.y + (i + 1) * height, area.width, height};
        char text[REMEMBERED_PATH + 16];
        snprintf(text, sizeof(text), "%s%s", item->kind == BROWSER_FOLDER ? "▸ " : "",
                 item->name);
        if (first + i == b->at)
            ui_draw_box(ui, &ui->above, &row, 0x4a6a94ff);
        ui_draw_text(ui, &ui->above, row.x + pad, row.y + 4, width, text,
                     item->kind == BROWSER_RECENT ? 0xb8b8beff : 0xecececff);
    }
    char hint[160];
    snprintf(hint, sizeof(hint), "no name begins with %s", b->typed);
    ui_draw_text(ui, &ui->above, area.x + pad, area.y + area.height - height, width,
                 b->is_unknown ? hint
                               : "Letters find a name, Enter opens, Backspace goes up, "
                                 "Escape leaves; a PNG becomes the reference",
                 b->is_unknown ? 0xffc14dff : 0xb8b8beff);
}
