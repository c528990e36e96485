/* SPDX-License-Identifier: Apache-2.0 */
#include "path.h"

#include <stdlib.h>
#include <string.h>

#include "wide.h"

const char *os_path_name(const char *path)
{
    const char *name = path + strlen(path);
    while (name > path && !strchr("/\\:", name[-1]))
        name--;
    return name;
}

bool os_path_is_same_name(const char *a, const char *b)
{
    wchar_t *wide_a = os_wide_text(a), *wide_b = os_wide_text(b);
    const bool is_same =
        wide_a && wide_b &&
        CompareStringOrdinal(wide_a, -1, wide_b, -1, TRUE) == CSTR_EQUAL;
    free(wide_a);
    free(wide_b);
    return is_same;
}

bool os_path_is_absolute(const char *path)
{
    if (path[0] && path[1] == ':')
        path += 2;
    return path[0] == '/' || path[0] == '\\';
}
