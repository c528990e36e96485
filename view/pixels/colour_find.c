/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/colour_find.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "folder.h"

#define CONFIG "datafiles/colormanagement/config.ocio"

/* The folder of an installation, and the newest version's that was found in it. */
struct search {
    const char *folder;
    char best[64];
};

static bool is_file(const char *path)
{
    return os_file_facts(path).kind == OS_FILE_REGULAR;
}

static bool look_at(void *user, const char *name)
{
    struct search *search = user;
    char path[4096];
    snprintf(path, sizeof(path), "%s/%s/" CONFIG, search->folder, name);
    if (isdigit((unsigned char)*name) && is_file(path) &&
        strtod(name, NULL) > strtod(search->best, NULL))
        snprintf(search->best, sizeof(search->best), "%s", name);
    return true;
}

/* Beside the program lie folders of versions, "4.2". */
static bool find_in(const char *folder, char *path, size_t n_bytes)
{
    struct search search = {.folder = folder};
    snprintf(path, n_bytes, "%s/" CONFIG, folder);
    if (is_file(path))
        return true;
    os_folder_list(folder, look_at, &search);
    snprintf(path, n_bytes, "%s/%s/" CONFIG, folder, search.best);
    return search.best[0] && is_file(path);
}

/* The folder of the program of that name in the search path, links followed. */
static bool find_program(const char *name, char *folder, size_t n_bytes)
{
    const char *at = getenv("PATH");
    while (at && *at) {
        char path[4096];
        const size_t n = strcspn(at, ":");
        snprintf(path, sizeof(path), "%.*s/%s", (int)n, at, name);
        char *full = n > 0 && os_file_is_program(path) ? os_file_full_path(path) : NULL;
        char *slash = full ? strrchr(full, '/') : NULL;
        if (slash) {
            *slash = 0;
            snprintf(folder, n_bytes, "%s", full);
        }
        free(full);
        if (slash)
            return true;
        at += n + (at[n] == ':');
    }
    return false;
}

bool colour_find_blender(char *path, size_t n_bytes)
{
    char folder[4096];
    return (find_program("blender", folder, sizeof(folder)) &&
            find_in(folder, path, n_bytes)) ||
           find_in("/usr/share/blender", path, n_bytes);
}
