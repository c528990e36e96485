/* SPDX-License-Identifier: Apache-2.0 */
/* An end in the middle: nothing stays behind. */
#ifndef OS_CLEAN_UP_H
#define OS_CLEAN_UP_H

/*
 * Ends all child processes, removes the temporary folders and the files that were not
 * yet put in their place. For atexit() in a main(), and for the end by a signal. From
 * any thread; not from a signal handler.
 */
void os_clean_up(void);

/* Makes os_clean_up() call this first, from whichever thread it runs on. Up to four; 0
 * or ENOMEM. */
int os_clean_up_also(void (*clean_up)(void));

#endif
