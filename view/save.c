/* SPDX-License-Identifier: Apache-2.0 */
/* Saving the picture, the parameters and the command line. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "clock.h"
#include "common/report.h"
#include "file.h"
#include "sources/params_file.h"

#define REPLACE_S 8.0 /* the time to say yes to replacing a file */

/* One saving on its way; the worker's thread ends it. */
struct saving {
    struct app *app;
    const struct stage *stage; /* NULL: the demo */
    struct settings settings;
    char path[MAX_PATH];
    int32_t width, height, type;
};

static void make_name(char *out, const char *name, const char *ending)
{
    const char *slash = strrchr(name, '/');
    const char *base = slash ? slash + 1 : name;
    const char *dot = strrchr(base, '.');
    const int length = dot && dot > base ? (int)(dot - base) : (int)strlen(base);
    snprintf(out, MAX_PATH, "%.*s%s", length, base, ending);
}

void save_default_name(struct app *app)
{
    if (app->options->output)
        snprintf(app->output, sizeof(app->output), "%s", app->options->output);
    else
        make_name(app->output, app->stage ? app->stage->files->paths[0] : "demo",
                  "_focus.exr");
}

/* On the worker's thread. */
static void finish(void *user, float *pixels, const char *error)
{
    struct saving *saving = user;
    struct image_error image_error;
    char text[MAX_PATH + 1100], remarks[1000] = "";
    const struct stage_output output = {saving->path, saving->type};
    const int n_threads = thread_count(saving->app->options->n_threads);
    if (error)
        snprintf(text, sizeof(text), "%s: not saved: %.900s", saving->path, error);
    else if (saving->stage
                 ? stage_save(saving->stage, &saving->settings, &output, pixels,
                              remarks, sizeof(remarks), &image_error)
                 : demo_save(saving->path, pixels, saving->width, saving->height,
                             &saving->settings, n_threads, &image_error))
        snprintf(text, sizeof(text), "saved %s%s%s", saving->path, *remarks ? ": " : "",
                 remarks);
    else
        snprintf(text, sizeof(text), "%s", image_error.message);
    SDL_Event event = {.user = {.type = saving->app->event_type,
                                .code = APP_SAVED,
                                .data1 = SDL_strdup(text)}};
    SDL_PushEvent(&event);
    free(saving);
}

/* A file that is there is replaced when it is saved a second time at once. */
bool save_may_replace(struct app *app, const char *path)
{
    const double now_s = os_clock_s();
    const bool is_asked =
        strcmp(app->replacing, path) == 0 && now_s < app->replacing_until_s;
    app->replacing[0] = 0;
    if (is_asked || os_file_facts(path).kind == OS_FILE_NONE)
        return true;
    snprintf(app->replacing, sizeof(app->replacing), "%s", path);
    app->replacing_until_s = now_s + REPLACE_S;
    view_say(app, "%s is there: save once more to replace it", path);
    return false;
}

/* A picture has no depth: over what it is made of it would be a loss, asked or not. */
static bool is_input(struct app *app, const char *path)
{
    const bool has_own = !app->stage && app->operands->n > 0; /* of the demo */
    if (!(app->stage ? stage_reads(app->stage, path)
                     : has_own && os_file_is_same(app->operands->items[0], path)))
        return false;
    view_say(app,
             "not saved: %s is what is shown here, and would be lost; type "
             "another name into File",
             path);
    trace_text(app, "refused", app->status);
    return true;
}

void save_picture(struct app *app)
{
    struct image_error error;
    if (!picture_check_kind(app->output, &error) ||
        !picture_check_writable(app->output, &error)) {
        view_say(app, "%s", error.message);
        return;
    }
    if (view_is_stereo(app)) {
        view_say(app,
                 "both eyes are written by rackfocus filter --stereo: Ctrl+C copies "
                 "that line");
        return;
    }
    if (is_input(app, app->output) || !save_may_replace(app, app->output))
        return;
    struct saving *saving = app_memory(1, sizeof(*saving), &error);
    if (!saving) {
        view_say(app, "%s", error.message);
        return;
    }
    *saving = (struct saving){.app = app,
                              .stage = app->stage,
                              .settings = app->state.settings,
                              .width = app->state.width,
                              .height = app->state.height,
                              .type = app->sample_type};
    snprintf(saving->path, sizeof(saving->path), "%s", app->output);
    struct save save = {.write = finish, .user = saving};
    char problem[512];
    view_job(app, NULL, &save.job, problem, sizeof(problem));
    if (problem[0]) {
        view_say(app, "not saved: %s", problem);
        free(saving);
        return;
    }
    save.job.mode = MODE_PICTURE;
    save.job.has_eye = false;
    save.job.eye[0] = save.job.eye[1] = 0;
    view_say(app, "saving %s", app->output);
    worker_save(app->worker, &save);
}

void save_name_beside(const struct app *app, const char *ending, char *path)
{
    make_name(path, app->output, ending);
    const char *slash = strrchr(app->output, '/');
    if (slash) {
        char name[MAX_PATH];
        snprintf(name, sizeof(name), "%s", path);
        snprintf(path, MAX_PATH, "%.*s/%.255s", (int)(slash - app->output), app->output,
                 name);
    }
}

void save_params(struct app *app)
{
    char path[MAX_PATH];
    struct image_error error;
    save_name_beside(app, ".params", path);
    if (!save_may_replace(app, path))
        return;
    if (params_file_write(path, &app->state.typed, &error))
        view_say(app, "saved %s", path);
    else
        view_say(app, "%s", error.message);
    trace_text(app, "saved", app->status);
}

/* The views, too, where all of them are there. */
static void say_passes(struct app *app)
{
    struct image_error error;
    const struct accumulation *a = &app->accumulation;
    const int n_threads = thread_count(app->options->n_threads);
    if (view_is_stereo(app))
        view_say(app, "saved demo.exr and demo_right.exr: colour, depth buffer, near, "
                      "far and lens of both eyes");
    else if (!a->is_on || !app->reference || app->reference->n_views < a->n)
        view_say(app, "saved demo.exr: colour, depth buffer, near, far and lens%s",
                 a->is_on ? "; the views are not all drawn yet" : "");
    else if (demo_save_views("demo_views.exr", &app->reference->picture, a->n, a->move,
                             n_threads, &error))
        view_say(app,
                 "saved demo.exr: colour, depth buffer, near, far and lens; and "
                 "demo_views.exr, the mean of %d views",
                 a->n);
    else
        view_say(app, "saved demo.exr; %s", error.message);
}

void save_passes(struct app *app)
{
    struct image_error error;
    const int n_threads = thread_count(app->options->n_threads);
    const struct input *source = app->source;
    const struct input *right =
        source && source->n_others > 0 ? source->others[0] : NULL;
    if (!app->options->is_demo)
        return;
    /* The pixels are there once something was shown. */
    if (!app->shot || app->shot->input != app->source)
        view_say(app, "wait until the picture is shown");
    else if (is_input(app, "demo.exr") || !save_may_replace(app, "demo.exr"))
        return;
    else if (demo_save_passes("demo.exr", app->source, n_threads, &error) &&
             (!right || demo_save_passes("demo_right.exr", right, n_threads, &error)))
        say_passes(app);
    else
        view_say(app, "%s", error.message);
    trace_text(app, "saved", app->status);
}

void save_command(struct app *app)
{
    char text[MAX_PATH + 5000];
    if (app->stage) {
        stage_command(app->stage, &app->state.typed,
                      &(struct stage_output){app->output, app->sample_type}, text,
                      sizeof(text));
    } else {
        char used[4096];
        settings_print_options(&app->state.params, used, sizeof(used));
        const char *light = app->options->distribution_image;
        const bool has_light = light && stage_uses_light(&app->state.params);
        snprintf(text, sizeof(text),
                 "rackfocus filter demo.exr%s -o %s --type float %s%s%s%s",
                 view_is_stereo(app) ? " demo_right.exr --stereo" : "", app->output,
                 used, has_light ? " --distribution-image '" : "",
                 has_light ? light : "", has_light ? "'" : "");
    }
    SDL_SetClipboardText(text);
    printf("%s\n", text);
    fflush(stdout);
    view_say(app, "copied: %.900s", text);
}
