/* SPDX-License-Identifier: Apache-2.0 */
/* The terminal that messages go to. */
#ifndef OS_TERMINAL_H
#define OS_TERMINAL_H

#include <stdbool.h>
#include <stdio.h>

/* Is it a terminal? */
bool os_terminal_is_one(FILE *stream);

/* Is it a terminal that obeys escape sequences: none that TERM calls dumb, or nothing?
 */
bool os_terminal_is_live(FILE *stream);

/* Columns; 80 where nobody says. */
int os_terminal_columns(FILE *stream);

#endif
