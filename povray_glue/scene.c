/* SPDX-License-Identifier: Apache-2.0 */
/* An opened scene: its folder, its renders, and what POV-Ray says where one fails. */
#include "scene.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "folder.h"
#include "ini.h"
#include "replace.h"
#include "text.h"

bool scene_fail_file(struct povray_error *error, const char *path)
{
    const int reason = errno;
    const bool is_full = reason == ENOSPC || reason == EDQUOT;
    char folder[300];
    if (is_full && os_folder_of_temporary(path, folder, sizeof folder))
        path = folder; /* the private one is gone when this is read */
    snprintf(error->message, sizeof error->message, "%s: %s%s", path, strerror(reason),
             is_full ? "; free some space there" : "");
    return false;
}

/* Keeps what the scene will append to or replace, so that every render finds the same.
 */
static void keep_written(struct povray_scene *scene)
{
    const struct sources *sources = &scene->sources;
    scene->copies = text_format("%scopies/", scene->temp_folder);
    if (!sources->writes_files || os_folder_make(scene->copies, OS_FOLDER_PRIVATE) != 0)
        return;
    for (int i = 0; i < sources->n_written; i++) {
        struct text text = {0};
        char *copy = text_format("%s%s", scene->copies, sources->written[i]);
        if (text_read_file(&text, sources->written[i]))
            text_write_file(&text, copy);
        free(copy);
        text_free(&text);
    }
}

bool povray_open(struct povray_scene **scene, const struct povray_options *options,
                 struct povray_error *error)
{
    *scene = NULL;
    char *folder = temp_folder_make(error);
    if (!folder)
        return glue_settle(false, error);
    struct povray_scene *made = glue_alloc(1, sizeof *made);
    if (!made) {
        temp_folder_remove(folder);
        free(folder);
        return glue_settle(false, error);
    }
    made->options = *options;
    made->temp_folder = folder;
    made->probe_scale = 1;
    if (!sources_load(&made->sources, options->scene, options->args, options->n_args,
                      folder)) {
        scene_fail_file(error, options->scene);
        povray_close(made);
        return glue_settle(false, error);
    }
    keep_written(made);
    const bool is_good = glue_settle(true, error);
    if (is_good)
        *scene = made;
    else
        povray_close(made);
    return is_good;
}

const char *povray_lens_remark(const struct povray_camera *camera)
{
    return camera->is_sharp
               ? "the camera has an aperture but no blur_samples: POV-Ray itself draws "
                 "the scene without blur; write 'blur_samples 37' into the camera to "
                 "have it blur as well, or take POV-Ray's own picture for a sharp one"
               : "";
}

const char *povray_remark(const struct povray_scene *scene)
{
    const struct sources *sources = &scene->sources;
    if (sources->writes_elsewhere)
        return "the scene writes files (#fopen) by names that are computed or lie in "
               "another folder; POV-Ray renders it several times, and each render "
               "writes "
               "them";
    if (sources->n_written > 0)
        return "the scene writes files (#fopen); the colour's render writes them, and "
               "the other renders copies of their own";
    return "";
}

bool povray_reads_time(const struct povray_scene *scene)
{
    return scene->sources.has_now;
}

bool povray_keeps_light(const struct povray_scene *scene)
{
    return scene->sources.keeps_light;
}

void povray_close(struct povray_scene *scene)
{
    if (!scene)
        return;
    temp_folder_remove(scene->temp_folder);
    sources_free(&scene->sources);
    free(scene->records);
    free(scene->temp_folder);
    free(scene->copies);
    free(scene);
}

const char *povray_folder(const struct povray_scene *scene)
{
    return scene->temp_folder;
}

static const char *or_nothing(const char *text)
{
    return text ? text : "";
}

/* ---- messages ------------------------------------------------------------------ */

/* Joins POV-Ray's wrapped lines from `from` on; NULL without memory. */
static char *joined(const char *from)
{
    struct text text = {0};
    text_add(&text, "", 0);
    for (; from && *from; from++) {
        bool is_blank = *from == '\n' || *from == ' ' || *from == '\r';
        if (!is_blank)
            text_add(&text, from, 1);
        else if (text.n > 0 && text.data[text.n - 1] != ' ')
            text_add(&text, " ", 1);
    }
    while (text.n > 0 && text.data[text.n - 1] == ' ')
        text.data[--text.n] = 0;
    return text.data;
}

/* "File: X  Line: N ... Parse Error: what" becomes "X:N: Parse Error: what". */
static bool explain_parse_error(const struct povray_scene *scene, const char *fatal,
                                struct povray_error *error)
{
    const char *file = strstr(fatal, "File: "), *line = strstr(fatal, "Line: ");
    const char *what = strstr(fatal, "Error: ");
    if (!file || !line || !what || line < file)
        return false;
    while (what > fatal && what[-1] != '\n')
        what--;
    char *name = text_format("%.*s", (int)(line - file - 6), file + 6);
    char *tidy = joined(name);
    char *original = sources_original_names(&scene->sources, or_nothing(tidy));
    char *renamed = sources_original_names(&scene->sources, what),
         *text = joined(renamed);
    snprintf(error->message, sizeof error->message, "%s:%d: %s", or_nothing(original),
             atoi(line + 6), or_nothing(text));
    free(name);
    free(tidy);
    free(original);
    free(renamed);
    free(text);
    return true;
}

/* What POV-Ray printed since its last heading, or at the end, where it gave no parse
 * error. */
static void explain_log(const struct povray_scene *scene, const char *log,
                        struct povray_error *error)
{
    const char *from = log, *at, *configuration = "user configuration file";
    while ((at = strstr(from, "====\n")))
        from = at + 5;
    if (from == log && (at = strstr(log, configuration)) && strchr(at, '\n'))
        from = strchr(at, '\n');
    char *renamed = sources_original_names(&scene->sources, from);
    char *text = joined(renamed);
    const size_t n = strlen(or_nothing(text)), n_shown = 500;
    if (n == 0)
        snprintf(error->message, sizeof error->message,
                 "%s: POV-Ray made no picture and said nothing; does it render the "
                 "scene by itself, with the same options?",
                 scene->options.scene);
    else
        snprintf(error->message, sizeof error->message, "%s: POV-Ray says: %s",
                 scene->options.scene, n > n_shown ? text + n - n_shown : text);
    free(renamed);
    free(text);
}

/* A picture, font or the like that POV-Ray did not find: it says so among its warnings,
 * and then ends with an error without a name. */
static bool explain_missing_file(const struct povray_scene *scene, char *warnings,
                                 struct povray_error *error)
{
    char *what = strstr(warnings, "Possible Parse Error: Cannot find file"),
         *from = what;
    if (!what)
        return false;
    while (from > warnings && strncmp(from, "File: ", 6) != 0)
        from--;
    char *next = strstr(what, "\nFile: ");
    if (next)
        *next = 0;
    return explain_parse_error(scene, from, error);
}

/* Is the option neither a switch, NAME=VALUE nor a scene, nor a file that is there, with
 * or without the ending of initialisation files? */
static bool is_stray(const char *option)
{
    char *file = ini_file(option), *longer = text_format("%s.ini", or_nothing(file));
    const size_t n = strlen(option);
    const bool is_other = strchr("+-", option[0]) || strchr(option, '=') ||
                          (n > 4 && strcasecmp(option + n - 4, ".pov") == 0) || !file ||
                          !longer || path_is_file(file) || path_is_file(longer);
    free(file);
    free(longer);
    return !is_other;
}

/* POV-Ray repeats its whole command line where it cannot read a part of it. */
static bool explain_options(const struct povray_scene *scene, const char *log,
                            struct povray_error *error)
{
    const struct povray_options *options = &scene->options;
    struct text list = {0};
    if (!strstr(log, "Failed to parse command-line option"))
        return false;
    for (int i = 0; i < options->n_args; i++)
        if (is_stray(options->args[i])) {
            snprintf(error->message, sizeof error->message,
                     "%s: '%s' is no option of POV-Ray and no initialisation file; "
                     "options begin with + or -, as +W640, or are as Width=640",
                     options->scene, options->args[i]);
            return true;
        }
    for (int i = 0; i < options->n_args; i++)
        text_addf(&list, "%s %s", i ? "" : "correct it:", options->args[i]);
    /* All renders are EXR files. */
    snprintf(error->message, sizeof error->message,
             "%s: POV-Ray cannot read one of its options, or a line of the "
             "initialisation files among them; %s%sif '%s --version' does not list "
             "openexr as supported, take a POV-Ray that does, with --povray",
             options->scene, or_nothing(list.data), options->n_args ? "; " : "",
             options->program ? options->program : "povray");
    text_free(&list);
    return true;
}

/* Has the disk of the private folder no room for as much as a small picture? */
static bool is_disk_full(const char *path)
{
    enum { N_BYTES = 1 << 18 };
    struct text text = {.data = glue_alloc(N_BYTES, 1), .n = N_BYTES};
    const bool is_full = text.data && !text_write_file(&text, path) &&
                         (errno == ENOSPC || errno == EDQUOT);
    remove(path);
    text_free(&text);
    return is_full;
}

/* POV-Ray keeps its pixels, pictures and messages in the private folder. What it says of
 * a file that it cannot write is the same in each of its threads, and names none. */
static bool explain_full_disk(const struct povray_scene *scene, const char *log,
                              struct povray_error *error)
{
    char *path = text_format("%sroom", scene->temp_folder), folder[300];
    const bool is_full = path && is_disk_full(path);
    const bool is_explained = path &&
                              (is_full || strstr(log, "Cannot access data in file")) &&
                              os_folder_of_temporary(path, folder, sizeof folder);
    if (is_explained)
        snprintf(error->message, sizeof error->message,
                 "%s: %s for POV-Ray's files in %s; free some space there, or name "
                 "another folder within %s in TMPDIR",
                 scene->options.scene,
                 is_full ? "no space is left on the disk"
                         : "there seems to be no space",
                 folder, os_folder_usual_temporary());
    free(path);
    return is_explained;
}

static void explain_run(const struct povray_scene *scene, const struct run *run,
                        struct povray_error *error)
{
    char *fatal = run_stream(run, "fatal"), *log = run_stream(run, "log"),
         *warnings = run_stream(run, "warning");
    const bool is_explained =
        explain_full_disk(scene, or_nothing(log), error) ||
        explain_parse_error(scene, or_nothing(fatal), error) ||
        (warnings && explain_missing_file(scene, warnings, error)) ||
        explain_options(scene, or_nothing(log), error);
    if (!is_explained)
        explain_log(scene, or_nothing(log), error);
    free(fatal);
    free(log);
    free(warnings);
}

/* Is the parse error in the lines that we put behind the scene? */
static bool is_behind_scene(const struct povray_scene *scene, const struct run *run)
{
    const struct text *content = &scene->sources.items[0].content;
    char *fatal = run_stream(run, "fatal");
    const char *file = strstr(or_nothing(fatal), "File: ");
    const char *line = strstr(or_nothing(fatal), "Line: ");
    const char *ending = file && line ? strstr(file, ".pov") : NULL;
    int n_lines = 1;
    for (size_t i = 0; i < content->n; i++)
        n_lines += content->data[i] == '\n';
    const bool is_behind = ending && ending < line && atoi(line + 6) > n_lines;
    free(fatal);
    return is_behind;
}

/* A brace, an #end or a quote that the scene lacks reaches into our lines, whose words
 * and numbers the error then names: has POV-Ray say it of the scene alone. */
static void explain_alone(struct povray_scene *scene, struct povray_error *error)
{
    const struct scene_render render = {
        .name = "alone", .mode = REWRITE_PINHOLE, .after = "+W8 +H8 -A"};
    struct run run = {0}, *runs[] = {&run};
    struct povray_error ignored = {.message = ""};
    if (sources_write(&scene->sources, REWRITE_PINHOLE, "alone.pov", "", "") &&
        scene_start_run(scene, &run, "alone.pov", &render, &ignored) &&
        scene_wait(scene, runs, 1, error) && !run_is_good(&run))
        explain_run(scene, &run, error);
    run_stop(&run);
}

void scene_explain(struct povray_scene *scene, const struct run *run,
                   struct povray_error *error)
{
    explain_run(scene, run, error);
    if (is_behind_scene(scene, run))
        explain_alone(scene, error);
}

/* ---- renders ------------------------------------------------------------------- */

bool scene_wait(const struct povray_scene *scene, struct run *const *runs, int n,
                struct povray_error *error)
{
    struct povray_options options = scene->options;
    options.progress = NULL;
    return run_wait(runs, n, &options, error);
}

/* The options that win in a render; the caller frees. */
static char *last_words(const struct povray_scene *scene,
                        const struct scene_render *render)
{
    static const char *const light[] = {
        [SCENE_LIGHT_NONE] = "Radiosity_From_File=off Radiosity_To_File=off",
        [SCENE_LIGHT_READ] = "Radiosity_To_File=off",
        [SCENE_LIGHT_KEPT] = ""};
    const char *header = sources_header(&scene->sources, render->mode);
    return text_format("%s %s %s %s%s", or_nothing(render->after), scene->clock_words,
                       light[render->light], header ? "+HI" : "", or_nothing(header));
}

bool scene_start_run(struct povray_scene *scene, struct run *run, const char *file,
                     const struct scene_render *render, struct povray_error *error)
{
    const struct sources *sources = &scene->sources;
    const struct run_sandbox sandbox = {sources->folders, sources->n_folders,
                                        scene->copies};
    char *words = last_words(scene, render);
    const bool is_writing = render->is_picture && !scene->has_written;
    /* Names in other folders lead out of a sandbox, or nowhere. */
    const bool is_boxed =
        sources->writes_files && !(is_writing && sources->writes_elsewhere);
    const struct run_request request = {.temp_folder = scene->temp_folder,
                                        .name = render->name,
                                        .scene = file,
                                        .before = or_nothing(render->before),
                                        .after = words,
                                        .options = &scene->options,
                                        .sandbox = is_boxed ? &sandbox : NULL};
    bool is_started = words && file && render->name && run_start(run, &request, error);
    free(words);
    run->is_writing = is_writing && is_boxed;
    run->ends_itself = sources->keeps_light && render->light == SCENE_LIGHT_KEPT;
    scene->has_written |= is_writing && !is_boxed;
    /* Two runs that write the same file would read each other's halves. */
    if (is_started && sources->writes_elsewhere)
        is_started = scene_wait(scene, &run, 1, error);
    return is_started;
}

bool scene_start_render(struct povray_scene *scene, struct run *run,
                        const struct scene_render *render, struct povray_error *error)
{
    char *file = text_format("%s.pov", or_nothing(render->name));
    bool is_started =
        file && sources_write(&scene->sources, render->mode, file,
                              or_nothing(render->head), or_nothing(render->tail));
    if (!is_started)
        scene_fail_file(error, scene->temp_folder);
    else
        is_started = scene_start_run(scene, run, file, render, error);
    free(file);
    return is_started;
}

/* The old file stays where the new one finds no room. False with errno. */
static bool replace_file(const struct text *text, const char *path)
{
    struct os_replace file;
    int reason = os_replace_open(&file, path);
    if (reason == OS_REPLACE_NOT_REGULAR)
        return text_write_file(text, path);
    if (reason == 0) {
        errno = 0;
        FILE *stream = os_replace_stream(&file);
        const bool is_written =
            stream && fwrite(text->data, 1, text->n, stream) == text->n;
        if (stream && fclose(stream) == 0 && is_written) {
            reason = os_replace_commit(&file);
        } else {
            reason = errno ? errno : EIO;
            os_replace_abort(&file);
        }
    }
    errno = reason > 0 ? reason : EIO;
    return reason == 0;
}

/* Puts what the scene wrote into the current folder, where POV-Ray itself would have
 * written it: once. Not while other runs read what was there. */
static bool publish_written(struct povray_scene *scene, const struct run *run,
                            struct povray_error *error)
{
    const struct sources *sources = &scene->sources;
    bool is_good = true;
    for (int i = 0; i < sources->n_written && is_good; i++) {
        struct text text = {0};
        char *made =
            text_format("%s" RUN_SANDBOX "%s", run->folder, sources->written[i]);
        if (path_is_file(made) &&
            (!text_read_file(&text, made) || !replace_file(&text, sources->written[i])))
            is_good = scene_fail_file(error, sources->written[i]);
        text_free(&text);
        free(made);
    }
    scene->has_written = true;
    return is_good;
}

bool scene_read(struct povray_scene *scene, const struct run *run,
                struct decode_picture *picture, struct povray_error *error)
{
    char *path = run_is_good(run) ? run_picture(run) : NULL;
    bool is_read = path && decode_read(picture, path, scene->options.n_threads, error);
    if (is_read && run->is_writing && !scene->has_written &&
        !publish_written(scene, run, error)) {
        free(picture->rgba);
        picture->rgba = NULL;
        is_read = false;
    }
    if (!path)
        scene_explain(scene, run, error);
    else if (!is_read)
        explain_full_disk(scene, "", error); /* else what decode_read() said stays */
    free(path);
    return is_read;
}

void scene_add_warning(struct povray_passes *passes, const char *format, ...)
{
    va_list arguments;
    size_t n = strlen(passes->warning);
    if (n > 0)
        n += (size_t)snprintf(passes->warning + n, sizeof passes->warning - n, "; ");
    if (n >= sizeof passes->warning)
        return;
    va_start(arguments, format);
    vsnprintf(passes->warning + n, sizeof passes->warning - n, format, arguments);
    va_end(arguments);
}

void scene_take_colour(struct povray_passes *passes,
                       const struct decode_picture *picture, const struct run *run)
{
    passes->width = picture->width;
    passes->height = picture->height;
    passes->has_alpha = picture->has_alpha;
    passes->colour = picture->rgba;
    passes->colour_s = run->ended_s - run->started_s;
    if (picture->n_clipped > 0)
        scene_add_warning(
            passes,
            "%lld px of the colour are brighter than 65504, the most that POV-Ray's "
            "files can say, and their blur is too dark; scale all lights, ambient and "
            "emission down by the same factor and the picture up again",
            (long long)picture->n_clipped);
}

bool scene_same_size(const struct povray_scene *scene,
                     const struct povray_passes *passes,
                     const struct decode_picture *picture, struct povray_error *error)
{
    if (passes->width == picture->width && passes->height == picture->height)
        return true;
    snprintf(
        error->message, sizeof error->message,
        "%s: POV-Ray rendered pictures of different sizes; give +W and +H after --",
        scene->options.scene);
    return false;
}
