/* SPDX-License-Identifier: Apache-2.0 */
/* The temporary folders that this process made, each with its mark. Within os/ only. */
#ifndef OS_TEMPORARY_H
#define OS_TEMPORARY_H

#include <stdbool.h>

/* Of folders, and bytes of a path, that are known here. */
enum { OS_TEMPORARY_MOST = 16, OS_TEMPORARY_MOST_BYTES = 1024 };

/* Marks a folder that was just made, and remembers it. */
void os_temporary_add(const char *folder);

/* It is gone, or about to go: its mark is let go. */
void os_temporary_forget(const char *folder);

/* The i-th place's folder into `folder`, "" where the place is free. */
void os_temporary_get(int i, char folder[OS_TEMPORARY_MOST_BYTES]);

/* The path of a folder's mark; false where it is too long. */
bool os_temporary_name_mark(const char *folder, char path[OS_TEMPORARY_MOST_BYTES]);

#endif
