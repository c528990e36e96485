/* SPDX-License-Identifier: Apache-2.0 */
/* The standard streams, and the terminal that messages go to. */
#ifndef OS_TERMINAL_H
#define OS_TERMINAL_H

#include <stdbool.h>
#include <stdio.h>

/* Can a standard stream be used: the input to read, the others to write? Not where who
 * started the program closed it. */
bool os_stream_is_open(FILE *stream);

/* Is it a terminal? */
bool os_terminal_is_one(FILE *stream);

/* Is it a terminal that obeys escape sequences: none that TERM calls dumb, or nothing?
 */
bool os_terminal_is_live(FILE *stream);

/* Columns; 80 where nobody says. */
int os_terminal_columns(FILE *stream);

#endif
