/* SPDX-License-Identifier: Apache-2.0 */
/* Names of files that are being written: NAME.part and six digits, beside NAME. Within
 * os/ only. */
#ifndef OS_PART_H
#define OS_PART_H

#include <stdbool.h>
#include <stdint.h>

/* The path beside `target`, whose last name is `name`, a part of it, with the lowest 24
 * bits of a number; free() it. NULL without memory. Of a long name the end is left out,
 * so that the new one is no longer than file systems allow. */
char *os_part_path(const char *target, const char *name, uint32_t number);

/* Is it such a name beside the file `name`? Files whose long names begin alike share
 * theirs. */
bool os_part_is_of(const char *entry, const char *name);

#endif
