/* SPDX-License-Identifier: Apache-2.0 */
#include "filter/filter_many.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "file.h"
#include "filter/filter_output.h"
#include "folder.h"
#include "interrupt.h"
#include "sources/picture.h"
#include "sources/png_picture.h"
#include "sources/primaries.h"
#include "sources/settings.h"
#include "sources/source.h"

/* ---- results on their way ------------------------------------------------------- */

/* A folder beside the output, so that what goes there will fit. */
struct folder {
    char path[4096];
    int n_files;
};

static bool folder_make(struct folder *folder, const char *output,
                        struct image_error *error)
{
    char prefix[4096];
    snprintf(prefix, sizeof(prefix), "%s.", output);
    folder->n_files = 0;
    const int reason =
        os_folder_make_temporary(prefix, folder->path, sizeof(folder->path));
    if (reason == 0)
        return true;
    set_error(error, "%.800s: cannot make a folder beside it: %s", output,
              strerror(reason));
    return false;
}

static void folder_file(const struct folder *folder, int i, char *path, size_t n_bytes)
{
    snprintf(path, n_bytes, "%s/%d.exr", folder->path, i);
}

static void folder_remove(const struct folder *folder)
{
    os_folder_remove(folder->path);
}

static int fail_image(const struct image_error *error)
{
    return os_is_interrupted() ? APP_INTERRUPTED : app_code_of(error);
}

/* ---- layers --------------------------------------------------------------------- */

static bool open_result(const char *path, struct source *source,
                        struct image_error *error)
{
    char *paths[] = {(char *)path};
    const struct source_request request = {.paths = paths, .n_paths = 1};
    return source_open(source, &request, error);
}

static bool check_layers(const struct source *top, const char *top_name,
                         const struct source *bottom, const char *bottom_name,
                         struct image_error *error)
{
    const char *what = NULL;
    if (memcmp(&top->info.data_window, &bottom->info.data_window,
               sizeof(top->info.data_window)) != 0)
        what = "has another data window than";
    else if (top->is_grey != bottom->is_grey)
        what = "has other colour channels than";
    else if (top->n_channels != 4)
        what = "has no alpha and so would hide all of";
    if (!what)
        return true;
    set_error(
        error,
        "%s: %s %s; layers are of one window and kind, and those on top have alpha",
        top_name, what, bottom_name);
    return false;
}

/* bottom = top + (1 - alpha of top) bottom, all channels, alpha among them. */
static void put_over(const float *top, float *bottom, size_t n_pixels, int n_channels)
{
    for (size_t i = 0; i < n_pixels; i++) {
        const float *over = top + 4 * i;
        float *at = bottom + (size_t)n_channels * i;
        const float alpha = over[3] < 0 ? 0 : over[3] > 1 ? 1 : over[3];
        for (int c = 0; c < n_channels; c++)
            at[c] = over[n_channels == 1 ? 0 : c] + (1 - alpha) * at[c];
    }
}

static int warn_of_primaries(const struct filter_options *tool,
                             const struct source *top, const char *top_name,
                             const struct source *bottom, const char *bottom_name,
                             struct image_error *error)
{
    struct primaries own, other;
    primaries_read(top->colour, top->part, &own);
    primaries_read(bottom->colour, bottom->part, &other);
    return primaries_warn(tool->host, top_name, &own, bottom_name, &other,
                          "they are put over each other", error);
}

/* Puts the results 0 .. n - 2 over the last, whose samples are given. */
static bool put_all_over(const struct filter_options *tool, const struct folder *folder,
                         char *const *names, const struct source *bottom,
                         float *samples, struct image_error *error)
{
    const int n_threads = thread_count(tool->n_threads);
    const size_t n_pixels = (size_t)bottom->width * (size_t)bottom->height;
    const int last = folder->n_files - 1;
    bool is_good = true;
    for (int i = last - 1; i >= 0 && is_good; i--) {
        char path[4200];
        struct source top;
        folder_file(folder, i, path, sizeof(path));
        if (!open_result(path, &top, error))
            return false;
        float *over = NULL;
        is_good = check_layers(&top, names[i], bottom, names[last], error) &&
                  warn_of_primaries(tool, &top, names[i], bottom, names[last], error) ==
                      APP_DONE &&
                  (over = source_read_colour(&top, n_threads, error)) != NULL;
        if (is_good)
            put_over(over, samples, n_pixels, bottom->n_channels);
        free(over);
        source_close(&top);
    }
    return is_good;
}

/* `name` of the input that the result of the last layer was made of. */
static bool write_layers(const struct filter_options *tool, const struct source *bottom,
                         const char *name, float *samples, struct image_error *error)
{
    const struct png_picture png = {.source = bottom,
                                    .name = name,
                                    .samples = samples,
                                    .bits = tool->png_bits == FILTER_PNG_16 ? 16 : 8};
    if (picture_kind(tool->output) == PICTURE_PNG)
        return png_picture_write(tool->host, tool->output, &png, error);
    const bool is_half = tool->type == FILTER_TYPE_HALF;
    const struct source_output how = {.type = is_half ? IMAGE_SAMPLE_HALF
                                                      : IMAGE_SAMPLE_FLOAT,
                                      .n_threads = thread_count(tool->n_threads)};
    const size_t n_samples =
        (size_t)bottom->width * (size_t)bottom->height * (size_t)bottom->n_channels;
    if (is_half && picture_warn_clipped(tool->host, tool->output,
                                        picture_clip_to_half(samples, n_samples),
                                        error) != APP_DONE)
        return false;
    return source_write_colour(bottom, tool->output, samples, &how, error);
}

static int join_layers(const struct filter_options *tool, const struct folder *folder,
                       char *const *names, struct image_error *error)
{
    struct source bottom;
    char path[4200];
    const int n_threads = thread_count(tool->n_threads);
    folder_file(folder, folder->n_files - 1, path, sizeof(path));
    if (!open_result(path, &bottom, error))
        return fail_image(error);
    float *samples = source_read_colour(&bottom, n_threads, error);
    const bool is_good =
        samples && put_all_over(tool, folder, names, &bottom, samples, error) &&
        !os_is_interrupted() &&
        write_layers(tool, &bottom, names[folder->n_files - 1], samples, error);
    free(samples);
    source_close(&bottom);
    return is_good ? APP_DONE : fail_image(error);
}

int filter_over(const struct filter_options *tool, const struct settings *settings,
                char *const *paths, int n_paths, struct image_error *error)
{
    struct folder folder;
    if (!picture_check_writable(tool->output, error) ||
        !folder_make(&folder, tool->output, error))
        return fail_image(error);
    const struct app_host host = app_host_of_part(tool->host);
    int code = APP_DONE;
    for (int i = 0; i < n_paths && code == APP_DONE; i++) {
        struct filter_options one = *tool;
        struct settings own = *settings;
        char path[4200];
        folder_file(&folder, folder.n_files++, path, sizeof(path));
        one.output = path;
        one.type = FILTER_TYPE_FLOAT;
        one.host = &host;
        code = filter_run(&one, &own, paths + i, 1, error);
    }
    if (code == APP_DONE)
        code = join_layers(tool, &folder, paths, error);
    if (code == APP_DONE)
        app_say(tool->host, "%s: %d pictures, each with its own blur, over each other",
                tool->shown_output ? tool->shown_output : tool->output, n_paths);
    folder_remove(&folder);
    return code;
}

/* ---- stereo --------------------------------------------------------------------- */

/* A view to filter, and what it is called. */
struct eye {
    char *path;
    char name[64];
    bool is_inside; /* a view of a multi-view file */
    bool is_new;    /* its output was not there before */
};

enum { MAX_EYES = RF_MAX_VIEWS };

bool filter_has_view_mark(const char *name)
{
    return strstr(name, "%V") || strstr(name, "%v");
}

/* The name of the output for one view. */
static void mark_name(const char *pattern, const char *view, char *name, size_t n_bytes)
{
    size_t n = 0;
    for (const char *at = pattern; *at && n + 1 < n_bytes; at++) {
        const bool is_mark = at[0] == '%' && (at[1] == 'V' || at[1] == 'v');
        if (!is_mark) {
            name[n++] = *at;
            continue;
        }
        at++;
        const int length = *at == 'v' ? 1 : (int)strlen(view);
        n += (size_t)snprintf(name + n, n_bytes - n, "%.*s", length, view);
    }
    name[n < n_bytes ? n : n_bytes - 1] = 0;
}

/* The views of one file. */
static int list_inside(char *path, struct eye *eyes, struct image_error *error)
{
    struct image_input *input;
    if (!image_open(&input, path, error))
        return 0;
    const int n = image_view_count(input);
    for (int i = 0; i < n && i < MAX_EYES; i++) {
        eyes[i] = (struct eye){.path = path, .is_inside = true};
        snprintf(eyes[i].name, sizeof(eyes[i].name), "%s", image_view_name(input, i));
    }
    image_close(input);
    if (n >= 2 && n <= MAX_EYES)
        return n;
    set_error(
        error,
        "%s: holds %d views; --stereo takes a file of 2 to %d, or two files, left "
        "and right",
        path, n, MAX_EYES);
    return 0;
}

/* Two files: their own names of views, where both have one, else left and right. */
static bool name_pair(char *const *paths, struct eye *eyes, struct image_error *error)
{
    static const char *const usual[] = {"left", "right"};
    bool is_named = true;
    for (int i = 0; i < 2; i++) {
        struct image_input *input;
        if (!image_open(&input, paths[i], error))
            return false;
        const char *own = image_view_name(input, 0);
        eyes[i] = (struct eye){.path = paths[i]};
        snprintf(eyes[i].name, sizeof(eyes[i].name), "%s", own ? own : "");
        is_named = is_named && own;
        image_close(input);
    }
    if (!is_named || strcmp(eyes[0].name, eyes[1].name) == 0)
        for (int i = 0; i < 2; i++)
            snprintf(eyes[i].name, sizeof(eyes[i].name), "%s", usual[i]);
    return true;
}

/* ---- the headers of a pair ------------------------------------------------------- */

/* Parameters are those of the first header, which count in its pixels. */
static bool check_shapes(char *const *paths, struct image_input *const *eyes,
                         struct image_error *error)
{
    int n;
    const struct image_part_info *a = image_parts(eyes[0], &n);
    const struct image_part_info *b = image_parts(eyes[1], &n);
    const struct image_box *p = &a->display_window, *q = &b->display_window;
    const int width[2] = {p->max_x - p->min_x + 1, q->max_x - q->min_x + 1};
    const int height[2] = {p->max_y - p->min_y + 1, q->max_y - q->min_y + 1};
    if (width[0] != width[1] || height[0] != height[1])
        return set_error(error,
                         "%.400s: its displayWindow has %d x %d px, that of %.400s "
                         "%d x %d; render both eyes in one size, or filter each by "
                         "itself, without --stereo",
                         paths[1], width[1], height[1], paths[0], width[0], height[0]);
    return a->pixel_aspect == b->pixel_aspect ||
           set_error(error,
                     "%.400s: its pixelAspectRatio is %.9g, that of %.400s %.9g; "
                     "render both eyes with one, or filter each by itself, without "
                     "--stereo",
                     paths[1], (double)b->pixel_aspect, paths[0],
                     (double)a->pixel_aspect);
}

static bool check_headers(const struct filter_options *tool, char *const *paths,
                          struct image_input *const *eyes, struct image_error *error)
{
    struct image_error found;
    if (!check_shapes(paths, eyes, error))
        return false;
    if (filter_has_view_mark(tool->output) ||
        image_check_alike(eyes[0], eyes[1], &found))
        return true;
    return set_error(error,
                     "%s; EXR wants it alike in all views of a file: give both files "
                     "the same, or write a file for each with %%V in its name, as in "
                     "-o out_%%V.exr",
                     found.message);
}

/* Two files: can they be filtered with one header, and joined where one file is to be
 * written? Views of one file can. */
static bool check_pair(const struct filter_options *tool, char *const *paths,
                       struct image_error *error)
{
    struct image_input *eyes[2] = {NULL};
    const bool is_good = image_open(&eyes[0], paths[0], error) &&
                         image_open(&eyes[1], paths[1], error) &&
                         check_headers(tool, paths, eyes, error);
    for (int i = 0; i < 2; i++)
        if (eyes[i])
            image_close(eyes[i]);
    return is_good;
}

static bool join_eyes(const struct filter_options *tool, const struct folder *folder,
                      const struct eye *eyes, struct image_error *error)
{
    struct image_input *inputs[MAX_EYES] = {NULL};
    const char *names[MAX_EYES];
    bool is_good = true;
    for (int i = 0; i < folder->n_files && is_good; i++) {
        char path[4200];
        folder_file(folder, i, path, sizeof(path));
        names[i] = eyes[i].name;
        is_good = image_open(&inputs[i], path, error);
    }
    is_good = is_good &&
              image_join_views(tool->output, inputs, names, folder->n_files, error);
    for (int i = 0; i < folder->n_files; i++)
        if (inputs[i])
            image_close(inputs[i]);
    return is_good;
}

/* One file of a set is of no use: on failure those that are new go. */
static void remove_new(const struct filter_options *tool, const struct eye *eyes, int n)
{
    for (int i = 0; i < n; i++) {
        char path[4200];
        mark_name(tool->output, eyes[i].name, path, sizeof(path));
        if (eyes[i].is_new)
            remove(path);
    }
}

/* Into files of the folder, or where it is NULL into those that the output names. */
static int filter_eyes(const struct filter_options *tool, struct settings *settings,
                       struct eye *eyes, int n, struct folder *folder,
                       struct image_error *error)
{
    const char *shown_output = tool->shown_output ? tool->shown_output : tool->output;
    int code = APP_DONE;
    for (int i = 0; i < n && code == APP_DONE; i++) {
        struct filter_options one = *tool;
        char path[4200], shown[4200];
        if (folder) {
            snprintf(shown, sizeof(shown), "%s, view %s", shown_output, eyes[i].name);
            one.shown_output = shown;
        }
        if (folder)
            folder_file(folder, folder->n_files++, path, sizeof(path));
        else
            mark_name(tool->output, eyes[i].name, path, sizeof(path));
        eyes[i].is_new = os_file_facts(path).kind == OS_FILE_NONE;
        one.output = path;
        one.view = eyes[i].is_inside ? eyes[i].name : NULL;
        /* What the first found in its header stays for the others. */
        code = filter_run(&one, settings, &eyes[i].path, 1, error);
    }
    if (code != APP_DONE && !folder)
        remove_new(tool, eyes, n);
    return code;
}

/* An output per eye that is an input; filter_check_files() knows no names of views. */
static int check_eyes(const struct filter_options *tool, const struct eye *eyes, int n,
                      char *const *paths, int n_paths, struct image_error *error)
{
    for (int i = 0; i < n; i++) {
        struct filter_options one = *tool;
        char path[4200];
        mark_name(tool->output, eyes[i].name, path, sizeof(path));
        one.output = path;
        const int code = filter_check_files(&one, paths, n_paths, NULL, error);
        if (code != APP_DONE)
            return code;
    }
    return APP_DONE;
}

/* A view's name chooses that one alone; the other has no such layer. */
static int check_layer(const struct filter_options *tool, const struct eye *eyes, int n,
                       struct image_error *error)
{
    for (int i = 0; i < n && tool->layer; i++)
        if (eyes[i].is_inside && strcmp(eyes[i].name, tool->layer) == 0)
            return app_fail(error, APP_USAGE,
                            "--layer %s: names one view, and --stereo filters all of "
                            "them; leave one of the two out",
                            tool->layer);
    return APP_DONE;
}

int filter_stereo(const struct filter_options *tool, struct settings *settings,
                  char *const *paths, int n_paths, struct image_error *error)
{
    struct folder folder;
    struct eye eyes[MAX_EYES];
    int n = 2;
    if (n_paths == 1)
        n = list_inside(paths[0], eyes, error);
    else if (!name_pair(paths, eyes, error) || !check_pair(tool, paths, error))
        n = 0;
    if (n == 0 || !picture_check_writable(tool->output, error))
        return fail_image(error);
    if (check_layer(tool, eyes, n, error) != APP_DONE)
        return APP_USAGE;
    if (filter_has_view_mark(tool->output)) {
        const int code = check_eyes(tool, eyes, n, paths, n_paths, error);
        return code == APP_DONE ? filter_eyes(tool, settings, eyes, n, NULL, error)
                                : code;
    }
    if (!folder_make(&folder, tool->output, error))
        return fail_image(error);
    int code = filter_eyes(tool, settings, eyes, n, &folder, error);
    if (code == APP_DONE && !join_eyes(tool, &folder, eyes, error))
        code = fail_image(error);
    folder_remove(&folder);
    return code;
}

int filter_any(const struct filter_options *tool, struct settings *settings,
               char *const *paths, int n_paths, struct image_error *error)
{
    if (tool->is_over)
        return filter_over(tool, settings, paths, n_paths, error);
    if (tool->is_stereo)
        return filter_stereo(tool, settings, paths, n_paths, error);
    return filter_run(tool, settings, paths, n_paths, error);
}
