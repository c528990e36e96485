/* SPDX-License-Identifier: Apache-2.0 */
#include "libc.h"

#include <strings.h>

#include "wide.h"

char *os_strsep(char **text, const char *separators)
{
    char *part = *text;
    if (!part)
        return NULL;
    char *end = part + strcspn(part, separators);
    *text = *end ? end + 1 : NULL;
    *end = 0;
    return part;
}

char *os_strcasestr(const char *text, const char *part)
{
    const size_t n = strlen(part);
    for (; strlen(text) >= n; text++) {
        if (strncasecmp(text, part, n) == 0)
            return (char *)text;
        if (!*text)
            break;
    }
    return NULL;
}

char *os_strndup(const char *text, size_t n)
{
    const size_t length = strnlen(text, n);
    char *copy = malloc(length + 1);
    if (copy) {
        memcpy(copy, text, length);
        copy[length] = 0;
    }
    return copy;
}

/* "r" and "w" as well as "rb" and "wb" are bytes; whoever reads lines takes CR LF. */
FILE *os_fopen(const char *path, const char *mode)
{
    wchar_t kind[8];
    wchar_t *wide = os_wide_path(path);
    if (!wide)
        return NULL;
    size_t n = 0;
    for (; mode[n] && n < 6; n++)
        kind[n] = (wchar_t)mode[n];
    if (!strchr(mode, 'b'))
        kind[n++] = L'b';
    kind[n] = 0;
    FILE *file = _wfopen(wide, kind);
    free(wide);
    return file;
}

int os_remove(const char *path)
{
    wchar_t *wide = os_wide_path(path);
    if (!wide)
        return -1;
    const int result = DeleteFileW(wide) ? 0 : -1;
    if (result != 0)
        os_last_error();
    free(wide);
    return result;
}
