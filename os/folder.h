/* SPDX-License-Identifier: Apache-2.0 */
/* Folders, temporary ones, and what is in a folder. */
#ifndef OS_FOLDER_H
#define OS_FOLDER_H

#include <stdbool.h>
#include <stddef.h>

/* Where temporary files belong, without a slash at its end. */
const char *os_folder_for_temporary(void);

/* The same where no variable says otherwise: /tmp. */
const char *os_folder_usual_temporary(void);

/*
 * A new folder that only this user may enter; its name, `prefix` and six characters,
 * into `path`. It goes with os_clean_up(). A file in it, OS_FOLDER_MARK, is locked as
 * long as this process lives. 0 or errno.
 */
int os_folder_make_temporary(const char *prefix, char *path, size_t n_bytes);
#define OS_FOLDER_MARK ".alive"

/* The folder in which a temporary one of this process was made, where `path` lies in such
 * a one: into `folder`, without a slash at its end. False where it lies in none. */
bool os_folder_of_temporary(const char *path, char *folder, size_t n_bytes);

/* A new folder, for this user alone or for whom the user's mask lets in. 0 or errno. */
enum os_folder_access { OS_FOLDER_PRIVATE, OS_FOLDER_SHARED };
int os_folder_make(const char *path, enum os_folder_access access);

/* Removes a folder with all that is in it; links are not followed. */
void os_folder_remove(const char *path);

/* Calls `visit` with the name of each entry, in no order, . and .. left out, until it
 * returns false. 0 or errno. */
int os_folder_list(const char *path, bool (*visit)(void *user, const char *name),
                   void *user);

#endif
