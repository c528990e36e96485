/* SPDX-License-Identifier: Apache-2.0 */
/* Ctrl+C, a polite request to end and a lost terminal (SIGINT, SIGTERM, SIGHUP). */
#ifndef OS_INTERRUPT_H
#define OS_INTERRUPT_H

#include <stdbool.h>

/*
 * From now on a signal sets a flag that long work asks for. Work that does not ask (a
 * header of a million channels, a disk that hangs) is ended all the same: a watching
 * thread cleans up (clean_up.h) and ends the process OS_INTERRUPT_PATIENCE_S after the
 * signal. Once per process; for a main().
 */
void os_interrupt_catch(void);

#define OS_INTERRUPT_PATIENCE_S 0.6

/* A reader that has gone and a file that may not grow are errors of the write from now
 * on, not an end of the process. For a main(). */
void os_interrupt_not_by_writing(void);

/* Is this the errno of a write whose reader has gone? */
bool os_interrupt_is_reader_gone(int number);

/* Was there a signal? */
bool os_is_interrupted(void);

/* The exit code for it: 128 and the signal's number, 130 for SIGINT; 128 for none. */
int os_interrupt_code(void);

#endif
