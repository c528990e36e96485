/* SPDX-License-Identifier: Apache-2.0 */
/* Facts about files, and reading and writing at a place. */
#ifndef OS_FILE_H
#define OS_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum os_file_kind { OS_FILE_NONE, OS_FILE_REGULAR, OS_FILE_FOLDER, OS_FILE_OTHER };

struct os_file_facts {
    enum os_file_kind kind;
    int64_t n_bytes;
    int64_t changed_s, changed_ns; /* when its content last changed */
    uint64_t device, number;       /* alike for two names of one file */
};

/* Follows links. kind is OS_FILE_NONE, and errno says why, where there is nothing or
 * nobody may look. */
struct os_file_facts os_file_facts(const char *path);

/* Do both paths name one file? Of files that are not there yet: would they? */
bool os_file_is_same(const char *a, const char *b);

/* Opens a file to read; does not wait where it is a pipe. `facts` (may be NULL) are of
 * what was opened. 0 or errno. */
int os_file_open(const char *path, int *fd, struct os_file_facts *facts);
void os_file_close(int fd);

/* Reads or writes up to n_bytes from or at a place, from any thread. How many were;
 * what is less ended early: at the end of the file where errno is 0. */
size_t os_file_read_at(int fd, void *data, size_t n_bytes, uint64_t offset);
size_t os_file_write_at(int fd, const void *data, size_t n_bytes, uint64_t offset);

/* The path from the root, without links; free() it. NULL with errno. */
char *os_file_full_path(const char *path);

/* Makes the name `link` for the file or folder `target`, a path from the root. 0 or
 * errno. */
int os_file_link(const char *target, const char *link);

/* A file that may be run as a program? */
bool os_file_is_program(const char *path);

/* The folder of this program with its slash. False where it cannot be told. */
bool os_program_folder(char *path, size_t n_bytes);

/* May files be made in this folder? 0 or errno. */
int os_folder_is_writable(const char *folder);

/* Adds to the end of a file, which is made where there is none, in one write, so that
 * several processes may. 0 or errno. */
int os_file_append(const char *path, const void *data, size_t n_bytes);

#endif
