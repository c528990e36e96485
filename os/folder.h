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

/*
 * A new folder for what is about to be made, as OS_FOLDER_SHARED. A run that ends too
 * early for that leaves none: with os_clean_up() it goes if it is empty, or, with
 * OS_FOLDER_GOES_UNLESS_KEPT, with what is in it if os_folder_keep() was not called. 0 or
 * errno, EEXIST for one that is there, which stays in any case.
 */
enum os_folder_end { OS_FOLDER_GOES_IF_EMPTY, OS_FOLDER_GOES_UNLESS_KEPT };
int os_folder_make_to_fill(const char *path, enum os_folder_end end);

/* It is filled: it stays. `path` is as os_folder_make_to_fill() had it. */
void os_folder_keep(const char *path);

/* Removes a folder with all that is in it; links are not followed. */
void os_folder_remove(const char *path);

/* Removes a folder in which nothing is; another one stays. */
void os_folder_remove_empty(const char *path);

/* Calls `visit` with the name of each entry, in no order, . and .. left out, until it
 * returns false. 0 or errno. */
int os_folder_list(const char *path, bool (*visit)(void *user, const char *name),
                   void *user);

#endif
