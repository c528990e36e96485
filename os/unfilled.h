/* SPDX-License-Identifier: Apache-2.0 */
/* The folders that os_folder_make_to_fill() made (folder.h). Within os/ only. */
#ifndef OS_UNFILLED_H
#define OS_UNFILLED_H

/* Removes those that nothing came into, and those that were not kept. */
void os_unfilled_remove(void);

#endif
