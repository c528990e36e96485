/* SPDX-License-Identifier: Apache-2.0 */
#include "run.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "file.h"
#include "folder.h"
#include "leftovers.h"
#include "ini.h"
#include "program.h"
#include "text.h"

/* ---- folders ------------------------------------------------------------------- */

/* POV-Ray may write to the usual folder (/tmp) by default, and the name must fit into its
 * strings. */
static bool is_good_folder(const char *folder)
{
    const char *usual = os_folder_usual_temporary();
    const size_t n = strlen(usual);
    return strncmp(folder, usual, n) == 0 && folder[n] == '/' && strlen(folder) < 200 &&
           !strpbrk(folder, "\"'\\ ;") && os_folder_is_writable(folder) == 0;
}

char *temp_folder_make(struct povray_error *error)
{
    const char *base = os_folder_for_temporary();
    char prefix[256], path[300];
    if (!is_good_folder(base))
        base = os_folder_usual_temporary();
    snprintf(prefix, sizeof prefix, "%s/rackfocus-", base);
    os_leftovers_remove(prefix);
    const int reason = os_folder_make_temporary(prefix, path, sizeof path);
    char *folder = reason == 0 ? text_format("%s/", path) : NULL;
    if (!folder)
        snprintf(
            error->message, sizeof error->message,
            "%s: no temporary folder can be made there: %s; free some space there, "
            "or name another folder within %s in TMPDIR",
            base, strerror(reason == 0 ? ENOMEM : reason), os_folder_usual_temporary());
    if (!folder && reason == 0)
        os_folder_remove(path);
    return folder;
}

void temp_folder_remove(const char *folder)
{
    os_folder_remove(folder);
}

/* ---- processes ----------------------------------------------------------------- */

struct argument_list {
    char **items;
    int n;
    bool is_lost; /* memory was missing */
};

/* The list owns the argument. */
static void add_argument(struct argument_list *list, char *argument)
{
    char **items =
        argument ? glue_grow(list->items, (size_t)list->n + 2, sizeof *items) : NULL;
    if (!items) {
        list->is_lost = true;
        free(argument);
        return;
    }
    list->items = items;
    list->items[list->n++] = argument;
    list->items[list->n] = NULL;
}

/* The options of a text, parted by blanks. */
static void add_words(struct argument_list *list, const char *words)
{
    while (*words) {
        size_t n = strcspn(words, " ");
        if (n > 0)
            add_argument(list, text_format("%.*s", (int)n, words));
        words += n + (words[n] == ' ');
    }
}

/* +L for a folder. POV-Ray has no way to write one with both quotes: a link serves. */
static char *library_option(const char *folder, const char *private_folder)
{
    const char *quote = strchr(folder, '"') ? "'" : "\"";
    char *full =
        strpbrk(folder, "'") && *quote == '\'' ? os_file_full_path(folder) : NULL;
    char *link = text_format("%sbeside", private_folder);
    const bool is_linked = full && link && os_file_link(full, link) == 0;
    char *option = text_format("+L%s%s%s", quote, is_linked ? link : folder, quote);
    free(link);
    free(full);
    return option;
}

/* The file or folder that an option names, NULL for none. */
static const char *named_file(const char *option)
{
    static const char *const options[][2] = {{"Include_Header", "HI"},
                                             {"Include_Ini", ""},
                                             {"Library_Path", "L"},
                                             {"Input_File_Name", "I"},
                                             {"Output_File_Name", "O"}};
    const bool is_file = option[0] != '+' && option[0] != '-' && !strchr(option, '=');
    const char *name = is_file ? option : NULL;
    for (size_t i = 0; i < sizeof options / sizeof *options && !name; i++)
        name = ini_value(option, options[i][0], options[i][1]);
    return name;
}

/* The user's option as POV-Ray takes it, which ends names at blanks unless they stand in
 * quotes. Where the current folder is another (IS_MOVED) files are named from the root. */
static char *option_for_povray(const char *option, bool is_moved)
{
    const char *name = named_file(option);
    if (!name)
        return text_format("%s", option);
    char *plain = ini_unquoted(name), *made = NULL;
    char *file = plain ? ini_file(plain) : NULL;
    char *full = is_moved && file && file[0] ? os_file_full_path(file) : NULL;
    if (file) {
        const char *path = full ? full : file, *section = plain + strlen(file);
        const bool has_blank = strpbrk(path, " \t") || strpbrk(section, " \t");
        const char *quote = !has_blank ? "" : strchr(path, '"') ? "'" : "\"";
        made = full || has_blank ? text_format("%.*s%s%s%s%s", (int)(name - option),
                                               option, quote, path, section, quote)
                                 : text_format("%s", option);
    }
    free(full);
    free(file);
    free(plain);
    return made;
}

static void add_user_options(struct argument_list *list,
                             const struct run_request *request)
{
    const struct povray_options *options = request->options;
    for (int i = 0; i < options->n_args; i++)
        add_argument(list,
                     option_for_povray(options->args[i], request->sandbox != NULL));
}

/* The folders of the scene's files. */
static void add_folders(struct argument_list *list, const struct run *run,
                        const struct run_request *request)
{
    const struct run_sandbox *sandbox = request->sandbox;
    for (int i = 0; sandbox && i < sandbox->n_folders; i++) {
        const char *name = sandbox->folders[i][0] ? sandbox->folders[i] : ".";
        char *full = os_file_full_path(name);
        if (full)
            add_argument(list, library_option(full, run->folder));
        free(full);
    }
    char *folder = path_folder(request->options->scene);
    list->is_lost |= !folder;
    if (folder && folder[0] && !sandbox)
        add_argument(list, library_option(folder, run->folder));
    free(folder);
}

static void make_arguments(struct argument_list *list, const struct run *run,
                           const struct run_request *request)
{
    const struct povray_options *options = request->options;
    add_words(list, request->before);
    if (options->frame >= 0) { /* the user's own +KFI and +KFF win */
        add_argument(list, text_format("+KFI%d", options->first_frame));
        add_argument(list, text_format("+KFF%d", options->last_frame));
    }
    add_user_options(list, request);
    add_folders(list, run, request);
    if (options->frame >= 0) {
        add_argument(list, text_format("+SF%d", options->frame));
        add_argument(list, text_format("+EF%d", options->frame));
    }
    add_words(list, request->after);
    add_argument(list, text_format("+I%s%s", request->temp_folder, request->scene));
    add_argument(list, text_format("+O%so.exr", run->folder));
    add_words(list, "+FE -D -P -C -GA +GDdebug +GFfatal +GWwarning");
}

static void free_arguments(struct argument_list *list)
{
    for (int i = 0; i < list->n; i++)
        free(list->items[i]);
    free(list->items);
    *list = (struct argument_list){0};
}

/* Where POV-Ray works: NULL for the current folder, which its own file may stand in. */
struct place {
    char *folder, *ini;
};

/* POV-Ray keeps large pictures in a file while it renders, of some hundred megabytes,
 * which stays where POV-Ray is killed. Its folder, with its slash; NULL without memory. */
static char *pixels_folder(const struct run *run)
{
    return text_format("%spixels/", run->folder);
}

static void remove_pixels(const struct run *run)
{
    char *folder = run->folder ? pixels_folder(run) : NULL;
    if (folder)
        os_folder_remove(folder);
    free(folder);
}

/* 0 or errno. */
static int spawn(struct run *run, char *const *arguments, const struct place *place)
{
    char *log = text_format("%slog", run->folder), *pixels = pixels_folder(run);
    const struct os_process_request request = {
        .arguments = arguments,
        .log = log,
        .folder = place->folder,
        .variables = {
            {"POV_TEMP_DIR", pixels},
            {place->ini ? "POVINI" : NULL, place->ini},
        }};
    run->started_s = os_clock_s();
    int reason = log && pixels ? os_folder_make(pixels, OS_FOLDER_PRIVATE) : ENOMEM;
    if (reason == 0)
        reason = os_process_start(&run->process, &request);
    if (reason != 0)
        remove_pixels(run);
    free(log);
    free(pixels);
    return reason;
}

static bool copy_file(const char *from, const char *to)
{
    struct text text = {0};
    const bool is_copied = text_read_file(&text, from) && text_write_file(&text, to);
    text_free(&text);
    return is_copied;
}

struct copying {
    const char *from, *to; /* folders */
    int reason;
};

static bool copy_entry(void *user, const char *name)
{
    struct copying *copying = user;
    char *from = text_format("%s%s", copying->from, name);
    char *to = text_format("%s%s", copying->to, name);
    if (!from || !to)
        copying->reason = ENOMEM;
    else if (path_is_file(from))
        copy_file(from, to);
    free(from);
    free(to);
    return copying->reason == 0;
}

/* The folder that a scene may write to, with the files that it finds there. 0 or errno.
 */
static int make_sandbox(struct place *place, const struct run *run,
                        const struct run_sandbox *sandbox)
{
    char *ini = ini_standard_file();
    place->folder = text_format("%s" RUN_SANDBOX, run->folder);
    place->ini = ini ? os_file_full_path(ini) : NULL;
    free(ini);
    if (!place->folder)
        return ENOMEM;
    const int reason = os_folder_make(place->folder, OS_FOLDER_PRIVATE);
    if (reason != 0)
        return reason;
    struct copying copying = {sandbox->copies, place->folder, 0};
    os_folder_list(sandbox->copies, copy_entry, &copying);
    return copying.reason;
}

/* 0 or errno. */
static int start(struct run *run, const struct run_request *request,
                 struct argument_list *list, struct place *place)
{
    const char *chosen = request->options->program;
    if (!run->folder)
        return ENOMEM;
    os_folder_remove(run->folder); /* of an earlier run of this name */
    int reason = os_folder_make(run->folder, OS_FOLDER_PRIVATE);
    if (reason == 0 && request->sandbox)
        reason = make_sandbox(place, run, request->sandbox);
    if (reason != 0)
        return reason;
    const char *program;
    reason = ENOENT;
    for (int i = 0; reason == ENOENT && (program = program_name(chosen, i)); i++) {
        free_arguments(list);
        add_argument(list, text_format("%s", program));
        make_arguments(list, run, request);
        if (program_has_window(program))
            add_words(list, "/EXIT");
        reason = list->is_lost ? ENOMEM : spawn(run, list->items, place);
    }
    return reason;
}

bool run_start(struct run *run, const struct run_request *request,
               struct povray_error *error)
{
    *run = (struct run){.folder =
                            text_format("%s%s/", request->temp_folder, request->name)};
    struct argument_list list = {0};
    struct place place = {0};
    const int reason = start(run, request, &list, &place);
    const char *chosen = request->options->program;
    if (reason == ENOENT && chosen)
        snprintf(error->message, sizeof error->message,
                 "%s: there is no such program; --povray names that of POV-Ray 3.7",
                 chosen);
    else if (reason == ENOENT)
        snprintf(error->message, sizeof error->message,
                 "povray was not found; install POV-Ray 3.7 (Debian: apt-get install "
                 "povray), put it on the PATH, or name it with --povray FILE");
    else if (reason != 0)
        snprintf(error->message, sizeof error->message, "%s cannot be started: %s",
                 chosen ? chosen : "povray", strerror(reason));
    free_arguments(&list);
    free(place.folder);
    free(place.ini);
    return reason == 0;
}

/* POV-Ray takes a third of a second to end after its picture is written. */
static bool is_picture_complete(const struct run *run)
{
    char *path = run_picture(run);
    const bool is_complete = path && os_file_facts(path).n_bytes > 0 &&
                             !os_process_holds(&run->process, path);
    free(path);
    return is_complete;
}

bool run_has_ended(struct run *run)
{
    if (run->process.id == 0)
        return true;
    if (!os_process_has_ended(&run->process)) {
        if (run->ends_itself || !is_picture_complete(run))
            return false;
        run->has_picture = true;
        os_process_end(&run->process);
    }
    remove_pixels(run);
    run->ended_s = os_clock_s();
    return true;
}

void run_stop(struct run *run)
{
    os_process_end(&run->process);
    remove_pixels(run);
    free(run->folder);
    *run = (struct run){0};
}

bool run_wait(struct run *const *runs, int n, const struct povray_options *options,
              struct povray_error *error)
{
    for (;;) {
        bool is_busy = false;
        for (int i = 0; i < n; i++)
            is_busy |= !run_has_ended(runs[i]);
        if (options->is_cancelled && options->is_cancelled(options->user)) {
            snprintf(error->message, sizeof error->message, "interrupted");
            error->is_interrupted = true;
            return false;
        }
        if (!is_busy)
            return true;
        if (options->progress)
            options->progress(options->user, run_fraction(runs[0]));
        run_pause();
    }
}

bool run_is_good(const struct run *run)
{
    return run->has_picture || (run->process.has_ended && run->process.exit_code == 0);
}

static char *read_named(const struct run *run, const char *name)
{
    char *path = text_format("%s%s", run->folder, name);
    struct text text = {0};
    if (path)
        text_read_file(&text, path);
    text_add(&text, "", 0);
    free(path);
    return text.data;
}

char *run_stream(const struct run *run, const char *name)
{
    return read_named(run, name);
}

struct search {
    const struct run *run;
    char *picture;
};

static bool find_picture(void *user, const char *name)
{
    struct search *search = user;
    const size_t n = strlen(name);
    if (n > 4 && strcmp(name + n - 4, ".exr") == 0)
        search->picture = text_format("%s%s", search->run->folder, name);
    return !search->picture;
}

char *run_picture(const struct run *run)
{
    struct search search = {run, NULL};
    os_folder_list(run->folder, find_picture, &search);
    return search.picture;
}

double run_fraction(const struct run *run)
{
    char *path = text_format("%slog", run->folder), tail[513];
    struct os_file_facts facts;
    int file;
    const bool is_open = path && os_file_open(path, &file, &facts) == 0;
    free(path);
    if (!is_open)
        return 0;
    const uint64_t end = (uint64_t)facts.n_bytes;
    const size_t n = os_file_read_at(file, tail, 512, end > 512 ? end - 512 : 0);
    os_file_close(file);
    tail[n] = 0;
    double fraction = 0;
    for (const char *at = tail; (at = strstr(at, " pixels (")); at++)
        fraction = strtod(at + 9, NULL) / 100;
    return fraction;
}

void run_pause(void)
{
    os_sleep_s(0.005);
}
