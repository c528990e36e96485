/* SPDX-License-Identifier: Apache-2.0 */
/* Shared libraries that are loaded when they are there, and not linked. */
#ifndef OS_LIBRARY_H
#define OS_LIBRARY_H

struct os_library;

/* Opens a library by its path, or by its name where the system looks for libraries.
 * NULL where it cannot be loaded. */
struct os_library *os_library_open(const char *path);
/* The address of a function; NULL where the library has none of that name. */
void *os_library_find(struct os_library *library, const char *name);
void os_library_close(struct os_library *library);

#endif
