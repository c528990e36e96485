/* SPDX-License-Identifier: Apache-2.0 */
#include "model/remembered.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "folder.h"
#include "path.h"
#include "replace.h"

enum { LEAST_SIDE = 200, MOST_SIDE = 32768 };

bool remembered_path(char *path, size_t n_bytes)
{
    static const struct {
        const char *variable, *below;
    } places[] = {
        {"XDG_STATE_HOME", ""}, {"LOCALAPPDATA", ""}, {"HOME", "/.local/state"}};
    for (size_t i = 0; i < sizeof(places) / sizeof(places[0]); i++) {
        const char *home = getenv(places[i].variable);
        if (!home || !os_path_is_absolute(home))
            continue;
        const char *const parts[] = {"/.local", places[i].below, "/rackfocus"};
        char folder[REMEMBERED_PATH];
        snprintf(folder, sizeof(folder), "%s", home);
        os_folder_make(folder, OS_FOLDER_PRIVATE); /* may be there */
        if (*places[i].below) {
            snprintf(folder, sizeof(folder), "%s%s", home, parts[0]);
            os_folder_make(folder, OS_FOLDER_PRIVATE);
            snprintf(folder, sizeof(folder), "%s%s", home, parts[1]);
            os_folder_make(folder, OS_FOLDER_PRIVATE);
        }
        snprintf(folder, sizeof(folder), "%s%s%s", home, parts[1], parts[2]);
        os_folder_make(folder, OS_FOLDER_PRIVATE);
        const int n = snprintf(path, n_bytes, "%s/view.txt", folder);
        return n > 0 && (size_t)n < n_bytes;
    }
    return false;
}

void remembered_add(struct remembered *r, const char *file)
{
    if (!*file || strlen(file) >= REMEMBERED_PATH || strpbrk(file, "\r\n"))
        return;
    char copy[REMEMBERED_PATH]; /* `file` may be one of them */
    snprintf(copy, sizeof(copy), "%s", file);
    int at = 0;
    while (at < r->n_files && strcmp(r->files[at], copy) != 0)
        at++;
    if (at == r->n_files && r->n_files < REMEMBERED_FILES)
        r->n_files++;
    at = at < r->n_files ? at : r->n_files - 1;
    memmove(r->files[1], r->files[0], (size_t)at * sizeof(r->files[0]));
    memcpy(r->files[0], copy, sizeof(copy));
}

static void read_line(struct remembered *r, char *line)
{
    int v[4];
    line[strcspn(line, "\r\n")] = 0;
    if (sscanf(line, "window %d %d %d %d", &v[0], &v[1], &v[2], &v[3]) == 4 &&
        v[2] >= LEAST_SIDE && v[3] >= LEAST_SIDE && v[2] <= MOST_SIDE &&
        v[3] <= MOST_SIDE) {
        r->has_window = true;
        r->x = v[0];
        r->y = v[1];
        r->width = v[2];
        r->height = v[3];
    } else if (strncmp(line, "file ", 5) == 0 && r->n_files < REMEMBERED_FILES &&
               strlen(line + 5) < REMEMBERED_PATH && line[5]) {
        snprintf(r->files[r->n_files++], REMEMBERED_PATH, "%s", line + 5);
    }
}

void remembered_read(struct remembered *r, const char *path)
{
    char line[REMEMBERED_PATH + 16];
    *r = (struct remembered){0};
    FILE *file = fopen(path, "r");
    if (!file)
        return;
    while (fgets(line, sizeof(line), file))
        read_line(r, line);
    fclose(file);
}

bool remembered_write(const struct remembered *r, const char *path)
{
    struct os_replace replace;
    if (os_replace_open(&replace, path) != 0)
        return false;
    FILE *file = os_replace_stream(&replace);
    if (file && r->has_window)
        fprintf(file, "window %d %d %d %d\n", r->x, r->y, r->width, r->height);
    for (int i = 0; file && i < r->n_files; i++)
        fprintf(file, "file %s\n", r->files[i]);
    if (file && fclose(file) == 0)
        return os_replace_commit(&replace) == 0;
    os_replace_abort(&replace);
    return false;
}
