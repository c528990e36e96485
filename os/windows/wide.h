/* SPDX-License-Identifier: Apache-2.0 */
/* Text and errors of Windows. Our text is UTF-8; Windows' own is UTF-16. */
#ifndef OS_WINDOWS_WIDE_H
#define OS_WINDOWS_WIDE_H

#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#include <stdbool.h>
#include <wchar.h>
#include <windows.h>

/* Text as Windows has it; free() it. NULL with errno. */
wchar_t *os_wide_text(const char *text);

/* A path as Windows takes it, however long it is (beyond 259 characters it wants a
 * prefix and no . or ..); free() it. NULL with errno. */
wchar_t *os_wide_path(const char *path);

/* Text of Windows as UTF-8; free() it. NULL with errno. */
char *os_narrow_text(const wchar_t *text);

/* The same of a path: / between folders, no prefix for long ones. */
char *os_narrow_path(const wchar_t *path);

/* The number of errno.h for GetLastError(); sets errno, too. */
int os_last_error(void);

/* A file with these rights (GENERIC_READ ..) and this way to open it (OPEN_EXISTING ..).
 * Others may do to it what `share` says. INVALID_HANDLE_VALUE with errno. */
HANDLE os_handle_open(const char *path, DWORD access, DWORD share, DWORD how,
                      DWORD flags);

/* Where others may read, write, rename and remove the file, as on other systems. */
#define OS_SHARE_ALL (FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE)

#endif
