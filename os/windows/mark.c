/* SPDX-License-Identifier: Apache-2.0 */
#include "mark.h"

#include "wide.h"

/* Open, and shared with nobody. */
intptr_t os_mark_take(const char *path)
{
    return (intptr_t)os_handle_open(path, GENERIC_WRITE, 0, CREATE_NEW, 0);
}

void os_mark_release(intptr_t mark)
{
    CloseHandle((HANDLE)mark);
}

bool os_mark_is_free(const char *folder, const char *path)
{
    (void)folder; /* of the user's profile: the user's */
    HANDLE mark = os_handle_open(path, GENERIC_WRITE, 0, OPEN_EXISTING, 0);
    if (mark != INVALID_HANDLE_VALUE)
        CloseHandle(mark);
    return mark != INVALID_HANDLE_VALUE;
}
