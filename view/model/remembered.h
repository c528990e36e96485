/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the window knows from the last time: its size and place, and the files that were
 * opened, the last one first. A text file, view.txt in rackfocus/ of the folder for
 * state: $XDG_STATE_HOME, else ~/.local/state, on Windows %LOCALAPPDATA%. A file that is
 * missing or broken is as good as none.
 */
#ifndef VIEW_REMEMBERED_H
#define VIEW_REMEMBERED_H

#include <stdbool.h>
#include <stddef.h>

#define REMEMBERED_FILES 12
#define REMEMBERED_PATH 4096

struct remembered {
    bool has_window;
    int x, y, width, height; /* of the window, as SDL counts */
    int n_files;
    char files[REMEMBERED_FILES][REMEMBERED_PATH];
};

/* Where it is kept; false where there is no such folder. The folder is made. */
bool remembered_path(char *path, size_t n_bytes);

void remembered_read(struct remembered *remembered, const char *path);

/* False where it cannot be written; nobody need be told. */
bool remembered_write(const struct remembered *remembered, const char *path);

/* Puts a file to the front; the last one may fall off. Paths with line ends are left
 * out. */
void remembered_add(struct remembered *remembered, const char *file);

#endif
