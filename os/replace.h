/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A file that appears complete or not at all: written beside its place, synced,
 * renamed.
 *
 *     struct os_replace file;
 *     if (os_replace_open(&file, path) == 0) {
 *         ... write to file.fd ...
 *         number = is_good ? os_replace_commit(&file) : (os_replace_abort(&file), EIO);
 *     }
 */
#ifndef OS_REPLACE_H
#define OS_REPLACE_H

#include <stdio.h>

struct os_replace {
    char *target, *path; /* its place, and where it is written */
    int fd;
    int slot;
};

/* What os_replace_open() returns where a device, a pipe or a folder has the name. */
#define OS_REPLACE_NOT_REGULAR (-1)
/* What os_replace_commit() returns where another program has the old file open and the
 * system does not part with it; no error on others than Windows. */
#define OS_REPLACE_IN_USE (-2)

/* 0, errno or OS_REPLACE_NOT_REGULAR; then there is nothing to abort. The new file has
 * the mode of the old one but for setuid, setgid and sticky. Unfinished files of dead
 * processes beside it are removed. */
int os_replace_open(struct os_replace *file, const char *path);

/* A stream that writes to it, with a descriptor of its own: close it before the commit.
 * NULL with errno. */
FILE *os_replace_stream(const struct os_replace *file);

/* Puts the file into its place and ends the struct. 0, or errno or OS_REPLACE_IN_USE and
 * the old file stays. */
int os_replace_commit(struct os_replace *file);

/* Removes the new file and ends the struct; the old one stays. */
void os_replace_abort(struct os_replace *file);

/* Removes what this process has open; calls nothing but unlink(). Writing goes on and
 * os_replace_commit() then fails. */
void os_replace_remove_all(void);

#endif
