/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the C library of Windows lacks or does in a way of its own, included before every
 * source: functions of POSIX 2008, and files by names that are UTF-8.
 */
#ifndef OS_WINDOWS_LIBC_H
#define OS_WINDOWS_LIBC_H

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef EDQUOT
#define EDQUOT ENOSPC
#endif

char *os_strsep(char **text, const char *separators);
char *os_strcasestr(const char *text, const char *part);
char *os_strndup(const char *text, size_t n);
FILE *os_fopen(const char *path, const char *mode);
int os_remove(const char *path);

#define strsep os_strsep
#define strcasestr os_strcasestr
#define strndup os_strndup
#define fopen os_fopen
#define flockfile _lock_file
#define funlockfile _unlock_file
#define remove os_remove

#endif
