/* SPDX-License-Identifier: Apache-2.0 */
/* Marks in temporary folders: files that show that the process lives that made them.
 * Within os/ only. */
#ifndef OS_MARK_H
#define OS_MARK_H

#include <stdbool.h>
#include <stdint.h>

/* Opens a new mark, which the system lets go when this process dies; -1 where it cannot
 * be had. */
intptr_t os_mark_take(const char *path);
void os_mark_release(intptr_t mark);

/* Is `folder` this user's, with the mark `path` in it that no process holds? A folder
 * without one is just being made. */
bool os_mark_is_free(const char *folder, const char *path);

#endif
