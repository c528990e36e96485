/* SPDX-License-Identifier: Apache-2.0 */
#include "library.h"

#include <stdlib.h>
#include <string.h>

#include "wide.h"

/* The handle itself: a struct os_library is never looked into. */

struct os_library *os_library_open(const char *path)
{
    wchar_t *wide = os_wide_text(path);
    if (!wide)
        return NULL;
    for (wchar_t *c = wide; *c; c++)
        if (*c == L'/')
            *c = L'\\';
    /* What a library needs lies beside it; that wants the path from the root. */
    const bool is_path = wcschr(wide, L'\\') != NULL;
    HMODULE library =
        LoadLibraryExW(wide, NULL, is_path ? LOAD_WITH_ALTERED_SEARCH_PATH : 0);
    free(wide);
    return (struct os_library *)library;
}

void *os_library_find(struct os_library *library, const char *name)
{
    FARPROC found = GetProcAddress((HMODULE)library, name);
    void *address;
    memcpy(&address, &found, sizeof(address)); /* C has no cast for it */
    return address;
}

void os_library_close(struct os_library *library)
{
    if (library)
        FreeLibrary((HMODULE)library);
}
