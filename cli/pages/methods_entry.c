/* SPDX-License-Identifier: Apache-2.0 */
#include "pages/methods_entry.h"

#include <stdio.h>

void methods_file_name(const struct methods_entry *entry, char *name, size_t n_bytes)
{
    snprintf(name, n_bytes, "%s", entry->name);
    for (; *name; name++)
        if (*name == ' ')
            *name = '_';
}

void methods_time(const struct methods_entry *entry, char *text, size_t n_bytes)
{
    if (entry->method < 0)
        snprintf(text, n_bytes, "%s", "");
    else
        snprintf(text, n_bytes, "%.*f ms", entry->time_s < 0.1 ? 1 : 0,
                 entry->time_s * 1e3);
}
