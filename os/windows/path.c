/* SPDX-License-Identifier: Apache-2.0 */
#include "path.h"

#include <string.h>

const char *os_path_name(const char *path)
{
    const char *name = path + strlen(path);
    while (name > path && !strchr("/\\:", name[-1]))
        name--;
    return name;
}

bool os_path_is_absolute(const char *path)
{
    if (path[0] && path[1] == ':')
        path += 2;
    return path[0] == '/' || path[0] == '\\';
}
