/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A list of files to choose from: those that were opened last, and a folder's folders
 * and files that the window can open. No window, no drawing.
 */
#ifndef VIEW_BROWSER_H
#define VIEW_BROWSER_H

#include <stdbool.h>
#include <stddef.h>

#include "model/remembered.h"

enum browser_kind { BROWSER_RECENT, BROWSER_FOLDER, BROWSER_FILE };

struct browser_item {
    enum browser_kind kind;
    char *name; /* of a folder's; the whole path of a recent one */
};

struct browser {
    char folder[REMEMBERED_PATH];
    struct browser_item *items;
    int n, at;         /* items; the chosen one */
    char typed[64];    /* what names are looked for by */
    bool is_unknown;   /* no name begins with it */
    char problem[160]; /* why the folder cannot be read; "" */
};

/* Lists `folder` ("": the working one); recent files come first where `recent` is not
 * NULL. Recent files that are gone are left out. */
void browser_open(struct browser *browser, const char *folder,
                  const struct remembered *recent);
void browser_free(struct browser *browser);

void browser_move(struct browser *browser, int by);

/* Chooses the first item whose name begins with what was typed, capitals or not: with `text`
 * behind what was typed before, or alone. */
void browser_type(struct browser *browser, const char *text, bool is_anew);

/* The chosen item's path; true where it is a file to open. A folder is listed then, and
 * false returned. */
bool browser_choose(struct browser *browser, char *path, size_t n_bytes);

/* Lists the folder above. */
void browser_up(struct browser *browser);

/* Can the window do something with a file of this name: EXR, PNG, a POV-Ray scene or
 * parameters? */
bool browser_is_for_us(const char *name);

#endif
