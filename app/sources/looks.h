/* SPDX-License-Identifier: Apache-2.0 */
/* Looks: parameters of kinds of lenses under a name. */
#ifndef APP_LOOKS_H
#define APP_LOOKS_H

#include <stdbool.h>

#include "image.h"
#include "looks_given.h" /* LOOK_NAMES */
#include "sources/settings.h"

/*
 * Sets what the look says, as if typed; what was typed before stays. A look of the
 * user's, NAME.params in rackfocus/looks of the folder for settings, wins over one of
 * that name that comes with the program; a path, which has a folder or ends in .params,
 * is a file. A message names those that there are.
 */
bool look_read(const char *name, struct settings *settings, struct image_error *error);

struct look_about {
    char name[64];
    char about[96]; /* which kind of lens */
    bool is_own;
};

/* Fills `list` with the program's looks, then the user's by name, `most` at most; one of
 * the user's that wins stands in the other's place. Returns how many. */
int look_list(struct look_about *list, int most);

/* Does a look of this name come with the program? One of the user's hides it. */
bool look_is_given(const char *name);

/* The file of a look of the user's; false where there is no folder for it. */
bool look_path(const char *name, char *path, size_t n_bytes);

/* Writes what was typed as a look of the user's, in place of an older one. */
bool look_save(const char *name, const struct settings *settings,
               struct image_error *error);

#endif
