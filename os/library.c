/* SPDX-License-Identifier: Apache-2.0 */
#include "library.h"

#include <dlfcn.h>

/* The handle itself: a struct os_library is never looked into. */

struct os_library *os_library_open(const char *path)
{
    return (struct os_library *)dlopen(path, RTLD_NOW | RTLD_LOCAL);
}

void *os_library_find(struct os_library *library, const char *name)
{
    return dlsym(library, name);
}

void os_library_close(struct os_library *library)
{
    if (library)
        dlclose(library);
}
