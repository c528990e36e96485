/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a path. */
#ifndef OS_PATH_H
#define OS_PATH_H

#include <stdbool.h>

/* The last name of a path: what follows the last separator, which is / and on Windows \
 * and a drive's : as well. Empty where the path ends with one. */
const char *os_path_name(const char *path);

/* Do two last names name one file of a folder? Capitals differ but on Windows and, as
 * its disks are made unless asked otherwise, on macOS. */
bool os_path_is_same_name(const char *a, const char *b);

/* From the root, or from a drive's? */
bool os_path_is_absolute(const char *path);

#endif
