/* SPDX-License-Identifier: Apache-2.0 */
/* Temporary folders that nobody removed. */
#ifndef OS_LEFTOVERS_H
#define OS_LEFTOVERS_H

/* Removes all of this process that still exist, of 16 at most. */
void os_leftovers_remove_own(void);

/* Removes this user's of that prefix whose process is no more, as one that was killed.
 * Not for a folder that several machines share: locks may not reach the other. */
void os_leftovers_remove(const char *prefix);

#endif
