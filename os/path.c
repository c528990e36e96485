/* SPDX-License-Identifier: Apache-2.0 */
#include "path.h"

#include <string.h>
#include <strings.h>

const char *os_path_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

bool os_path_is_same_name(const char *a, const char *b)
{
#ifdef __APPLE__
    return strcasecmp(a, b) == 0;
#else
    return strcmp(a, b) == 0;
#endif
}

bool os_path_is_absolute(const char *path)
{
    return path[0] == '/';
}
