/* SPDX-License-Identifier: Apache-2.0 */
#include "part.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char MARK[] = ".part";
/* Of a name: bytes, and on Windows, which has no fewer, UTF-16. */
enum { MOST_BYTES = 255, N_DIGITS = 6 };

/* How much of a name stays: no half of a letter of UTF-8. */
static size_t stem_bytes(const char *name)
{
    const size_t most = MOST_BYTES - (sizeof(MARK) - 1) - N_DIGITS;
    size_t n = strlen(name);
    if (n <= most)
        return n;
    n = most;
    while (n > 0 && ((unsigned char)name[n] & 0xc0) == 0x80)
        n--;
    return n;
}

char *os_part_path(const char *target, const char *name, uint32_t number)
{
    const size_t n = (size_t)(name - target) + stem_bytes(name);
    const size_t size = n + sizeof(MARK) + N_DIGITS;
    char *path = malloc(size);
    if (path)
        snprintf(path, size, "%.*s%s%0*x", (int)n, target, MARK, N_DIGITS,
                 (unsigned)(number & 0xffffff));
    return path;
}

bool os_part_is_of(const char *entry, const char *name)
{
    const size_t n = stem_bytes(name), n_mark = sizeof(MARK) - 1;
    if (strncmp(entry, name, n) != 0 || strncmp(entry + n, MARK, n_mark) != 0)
        return false;
    const char *number = entry + n + n_mark;
    return strlen(number) == N_DIGITS && strspn(number, "0123456789abcdef") == N_DIGITS;
}
