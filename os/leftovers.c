/* SPDX-License-Identifier: Apache-2.0 */
#include "leftovers.h"

#include <stdio.h>
#include <string.h>

#include "folder.h"
#include "mark.h"
#include "path.h"
#include "temporary.h"

void os_leftovers_remove_own(void)
{
    for (int i = 0; i < OS_TEMPORARY_MOST; i++) {
        char path[OS_TEMPORARY_MOST_BYTES];
        os_temporary_get(i, path);
        if (path[0])
            os_folder_remove(path);
    }
}

struct abandoned {
    const char *prefix, *start; /* start: of the folder's name in the prefix */
};

static bool remove_if_abandoned(void *user, const char *name)
{
    const struct abandoned *abandoned = user;
    const int n_base = (int)(abandoned->start - abandoned->prefix);
    char path[OS_TEMPORARY_MOST_BYTES], mark[OS_TEMPORARY_MOST_BYTES];
    const int n =
        snprintf(path, sizeof(path), "%.*s%s", n_base, abandoned->prefix, name);
    if (strncmp(name, abandoned->start, strlen(abandoned->start)) == 0 && n > 0 &&
        n < OS_TEMPORARY_MOST_BYTES && os_temporary_name_mark(path, mark) &&
        os_mark_is_free(path, mark))
        os_folder_remove(path);
    return true;
}

void os_leftovers_remove(const char *prefix)
{
    struct abandoned abandoned = {prefix, os_path_name(prefix)};
    const size_t n_base = (size_t)(abandoned.start - prefix);
    char base[OS_TEMPORARY_MOST_BYTES] = ".";
    if (n_base >= sizeof(base))
        return;
    if (n_base > 0)
        snprintf(base, sizeof(base), "%.*s", (int)n_base, prefix);
    os_folder_list(base, remove_if_abandoned, &abandoned);
}
