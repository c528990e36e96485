/* SPDX-License-Identifier: Apache-2.0 */
/* Which pictures the command line names. */
#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/frame_list.h"
#include "common/report.h"
#include "file.h"
#include "folder.h"
#include "filtering/stage.h"

static struct picture_files *add_picture(struct playlist *playlist,
                                         struct image_error *error)
{
    const size_t n = (size_t)playlist->n;
    struct picture_files *list = app_memory(n + 1, sizeof(*list), error);
    if (!list)
        return NULL;
    if (n)
        memcpy(list, playlist->pictures, n * sizeof(*list));
    free(playlist->pictures);
    playlist->pictures = list;
    playlist->n++;
    return &list[n];
}

static bool add_path(struct picture_files *picture, const char *path,
                     struct image_error *error)
{
    const size_t n = (size_t)picture->n_paths;
    char **paths = app_memory(n + 1, sizeof(*paths), error);
    char *copy = paths ? app_memory(strlen(path) + 1, 1, error) : NULL;
    if (!copy) {
        free(paths);
        return false;
    }
    strcpy(copy, path);
    if (n)
        memcpy(paths, picture->paths, n * sizeof(*paths));
    free(picture->paths);
    picture->paths = paths;
    picture->paths[picture->n_paths++] = copy;
    return true;
}

/* Length of the name before "_v00.exr"; 0 where it does not end so. */
static size_t stem_of_view(const char *name)
{
    const size_t n = strlen(name);
    size_t at = n - strlen(".exr");
    size_t n_digits = 0;
    while (at > 0 && isdigit((unsigned char)name[at - 1])) {
        at--;
        n_digits++;
    }
    return n_digits > 0 && at > 2 && strncmp(name + at - 2, "_v", 2) == 0 ? at - 2 : 0;
}

static bool is_same_set(const char *a, const char *b)
{
    const size_t n = stem_of_view(a);
    return n > 0 && n == stem_of_view(b) && strncmp(a, b, n) == 0;
}

/* Names of the EXR files of a folder. */
struct names {
    char **items;
    int n;
    bool has_passes; /* only those that begin with "passes", since there are some */
    struct image_error *error;
    bool is_lost; /* with the error */
};

static void names_free(struct names *names)
{
    for (int i = 0; i < names->n; i++)
        free(names->items[i]);
    free(names->items);
    names->items = NULL;
    names->n = 0;
}

static bool add_name(void *user, const char *name)
{
    struct names *names = user;
    const size_t n = strlen(name);
    const bool is_passes = strncmp(name, "passes", 6) == 0;
    if (n <= 4 || name[0] == '.' || strcasecmp(name + n - 4, ".exr") != 0 ||
        (names->has_passes && !is_passes))
        return true;
    if (is_passes && !names->has_passes)
        names_free(names);
    names->has_passes |= is_passes;
    char **items = realloc(names->items, ((size_t)names->n + 1) * sizeof(*items));
    char *copy = app_memory(n + 1, 1, names->error);
    names->items = items ? items : names->items;
    names->is_lost = !items || !copy;
    if (names->is_lost) {
        free(copy);
        return set_error(names->error, "out of memory");
    }
    strcpy(copy, name);
    items[names->n++] = copy;
    return true;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static bool add_names(struct playlist *playlist, const char *folder,
                      const struct names *names, struct image_error *error)
{
    struct picture_files *picture = NULL;
    const char *slash = folder[strlen(folder) - 1] == '/' ? "" : "/";
    for (int i = 0; i < names->n; i++) {
        char path[4352];
        snprintf(path, sizeof(path), "%s%s%s", folder, slash, names->items[i]);
        if (i == 0 || !is_same_set(names->items[i - 1], names->items[i]))
            picture = add_picture(playlist, error);
        if (!picture || !add_path(picture, path, error))
            return false;
    }
    return true;
}

/* The kept passes of a folder; where there is none called so, all its EXR files. */
static bool open_folder(struct playlist *playlist, const char *folder,
                        struct image_error *error)
{
    struct names names = {.error = error};
    const int reason = os_folder_list(folder, add_name, &names);
    bool is_good = reason == 0 && !names.is_lost;
    if (reason != 0)
        set_error(error, "%s: cannot be read: %s", folder, strerror(reason));
    else if (is_good && names.n == 0)
        is_good = set_error(error,
                            "%s: there is no EXR file in this folder; rackfocus povray "
                            "--keep %s puts passes there",
                            folder, folder);
    if (is_good) {
        qsort(names.items, (size_t)names.n, sizeof(*names.items), compare_names);
        is_good = add_names(playlist, folder, &names, error);
    }
    names_free(&names);
    return is_good;
}

/* Says which frames are missing where a folder holds a sequence and nothing else, as
 * `rackfocus filter` does. */
static void note_missing(struct playlist *playlist)
{
    char pattern[4352];
    struct image_error ignored;
    struct frame_list list = {0};
    if (playlist->n < 2 ||
        !frame_guess_pattern(playlist->pictures[0].paths[0], pattern,
                             sizeof(pattern)) ||
        !frame_list_find(&list, pattern, &ignored))
        return;
    if (list.n == playlist->n)
        frame_list_holes(&list, playlist->remark, &ignored);
    frame_list_free(&list);
}

bool playlist_open(struct playlist *playlist, char *const *paths, int n_paths,
                   struct image_error *error)
{
    *playlist = (struct playlist){0};
    for (int i = 0; i < n_paths; i++) {
        if (os_file_facts(paths[i]).kind != OS_FILE_NONE)
            continue;
        set_error(error, "%s: %s", paths[i], strerror(errno));
        return false;
    }
    if (n_paths == 1 && os_file_facts(paths[0]).kind == OS_FILE_FOLDER) {
        if (open_folder(playlist, paths[0], error)) {
            note_missing(playlist);
            return true;
        }
        playlist_close(playlist);
        return false;
    }
    struct picture_files *picture = add_picture(playlist, error);
    bool is_good = picture != NULL;
    for (int i = 0; i < n_paths && is_good; i++)
        is_good = add_path(picture, paths[i], error);
    if (!is_good)
        playlist_close(playlist);
    return is_good;
}

void playlist_close(struct playlist *playlist)
{
    for (int i = 0; i < playlist->n; i++) {
        for (int k = 0; k < playlist->pictures[i].n_paths; k++)
            free(playlist->pictures[i].paths[k]);
        free(playlist->pictures[i].paths);
    }
    free(playlist->pictures);
    *playlist = (struct playlist){0};
}
