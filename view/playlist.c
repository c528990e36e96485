/* SPDX-License-Identifier: Apache-2.0 */
/* Which pictures the command line names. */
#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "report.h"
#include "stage.h"

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

static int is_exr(const struct dirent *entry)
{
    const size_t n = strlen(entry->d_name);
    return n > 4 && entry->d_name[0] != '.' &&
           strcasecmp(entry->d_name + n - 4, ".exr") == 0;
}

static int is_passes(const struct dirent *entry)
{
    return is_exr(entry) && strncmp(entry->d_name, "passes", 6) == 0;
}

/* The kept passes of a folder; where there is none called so, all its EXR files. */
static bool open_folder(struct playlist *playlist, const char *folder,
                        struct image_error *error)
{
    struct dirent **names;
    int n = scandir(folder, &names, is_passes, alphasort);
    if (n == 0) {
        free(names);
        n = scandir(folder, &names, is_exr, alphasort);
    }
    if (n < 0) {
        set_error(error, "%s: cannot be read: %s", folder, strerror(errno));
        return false;
    }
    struct picture_files *picture = NULL;
    bool is_good = true;
    for (int i = 0; i < n && is_good; i++) {
        char path[4352];
        const char *slash = folder[strlen(folder) - 1] == '/' ? "" : "/";
        snprintf(path, sizeof(path), "%s%s%s", folder, slash, names[i]->d_name);
        if (i == 0 || !is_same_set(names[i - 1]->d_name, names[i]->d_name))
            picture = add_picture(playlist, error);
        is_good = picture && add_path(picture, path, error);
    }
    for (int i = 0; i < n; i++)
        free(names[i]);
    free(names);
    if (n == 0)
        set_error(error,
                  "%s: there is no EXR file in this folder; rackfocus povray --keep %s "
                  "puts passes there",
                  folder, folder);
    return n > 0 && is_good;
}

bool playlist_open(struct playlist *playlist, char *const *paths, int n_paths,
                   struct image_error *error)
{
    struct stat status;
    *playlist = (struct playlist){0};
    for (int i = 0; i < n_paths; i++) {
        if (stat(paths[i], &status) == 0)
            continue;
        set_error(error, "%s: %s", paths[i], strerror(errno));
        return false;
    }
    if (n_paths == 1 && S_ISDIR(status.st_mode)) {
        if (open_folder(playlist, paths[0], error))
            return true;
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
