/* SPDX-License-Identifier: Apache-2.0 */
#include "wide.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

wchar_t *os_wide_text(const char *text)
{
    const int n = MultiByteToWideChar(CP_UTF8, 0, text, -1, NULL, 0);
    wchar_t *wide = n > 0 ? malloc((size_t)n * sizeof(*wide)) : NULL;
    if (wide)
        MultiByteToWideChar(CP_UTF8, 0, text, -1, wide, n);
    else
        errno = ENOMEM;
    return wide;
}

static bool is_prefixed(const wchar_t *path)
{
    return wcsncmp(path, L"\\\\?\\", 4) == 0 || wcsncmp(path, L"\\\\.\\", 4) == 0;
}

/* The full path behind the prefix that lifts the limit of 259 characters. */
static wchar_t *with_prefix(const wchar_t *path, DWORD n_full)
{
    static const wchar_t LOCAL[] = L"\\\\?\\", SHARE[] = L"\\\\?\\UNC";
    enum { N_LONGER = 8 };
    wchar_t *full = malloc(((size_t)n_full + N_LONGER) * sizeof(*full));
    if (!full)
        return NULL;
    GetFullPathNameW(path, n_full, full + N_LONGER, NULL);
    wchar_t *start = full + N_LONGER;
    const bool is_share = start[0] == L'\\' && start[1] == L'\\';
    const wchar_t *prefix = is_share ? SHARE : LOCAL;
    start += is_share; /* one \ stays */
    const size_t n_prefix = wcslen(prefix);
    memmove(full + n_prefix, start, (wcslen(start) + 1) * sizeof(*full));
    memcpy(full, prefix, n_prefix * sizeof(*full));
    return full;
}

wchar_t *os_wide_path(const char *path)
{
    enum { LONG_FOLDER = 247 }; /* a folder's limit: that of a file less 12 */
    wchar_t *wide = os_wide_text(path);
    if (!wide || !*wide || is_prefixed(wide))
        return wide;
    const DWORD n_full = GetFullPathNameW(wide, 0, NULL, NULL);
    if (n_full <= LONG_FOLDER)
        return wide;
    wchar_t *full = with_prefix(wide, n_full);
    free(wide);
    if (!full)
        errno = ENOMEM;
    return full;
}

char *os_narrow_text(const wchar_t *text)
{
    const int n = WideCharToMultiByte(CP_UTF8, 0, text, -1, NULL, 0, NULL, NULL);
    char *narrow = n > 0 ? malloc((size_t)n) : NULL;
    if (narrow)
        WideCharToMultiByte(CP_UTF8, 0, text, -1, narrow, n, NULL, NULL);
    else
        errno = ENOMEM;
    return narrow;
}

char *os_narrow_path(const wchar_t *path)
{
    const bool is_share = wcsncmp(path, L"\\\\?\\UNC\\", 8) == 0;
    char *narrow = os_narrow_text(path + (is_share ? 6 : is_prefixed(path) ? 4 : 0));
    if (narrow && is_share)
        *narrow = '/';
    for (char *c = narrow; c && *c; c++)
        if (*c == '\\')
            *c = '/';
    return narrow;
}

int os_last_error(void)
{
    static const struct {
        DWORD code;
        int number;
    } known[] = {
        {ERROR_FILE_NOT_FOUND, ENOENT},
        {ERROR_PATH_NOT_FOUND, ENOENT},
        {ERROR_BAD_NETPATH, ENOENT},
        {ERROR_INVALID_DRIVE, ENOENT},
        {ERROR_INVALID_NAME, ENOENT},
        {ERROR_BAD_PATHNAME, ENOENT},
        {ERROR_ACCESS_DENIED, EACCES},
        {ERROR_SHARING_VIOLATION, EACCES},
        {ERROR_LOCK_VIOLATION, EACCES},
        {ERROR_WRITE_PROTECT, EROFS},
        {ERROR_ALREADY_EXISTS, EEXIST},
        {ERROR_FILE_EXISTS, EEXIST},
        {ERROR_NOT_ENOUGH_MEMORY, ENOMEM},
        {ERROR_OUTOFMEMORY, ENOMEM},
        {ERROR_DISK_FULL, ENOSPC},
        {ERROR_HANDLE_DISK_FULL, ENOSPC},
        {ERROR_DIR_NOT_EMPTY, ENOTEMPTY},
        {ERROR_DIRECTORY, ENOTDIR},
        {ERROR_INVALID_HANDLE, EBADF},
        {ERROR_BROKEN_PIPE, EPIPE},
        {ERROR_TOO_MANY_OPEN_FILES, EMFILE},
        {ERROR_PRIVILEGE_NOT_HELD, EPERM},
        {ERROR_FILENAME_EXCED_RANGE, ENAMETOOLONG},
    };
    const DWORD code = GetLastError();
    errno = EIO;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (known[i].code == code)
            errno = known[i].number;
    return errno;
}

HANDLE os_handle_open(const char *path, DWORD access, DWORD share, DWORD how,
                      DWORD flags)
{
    wchar_t *wide = os_wide_path(path);
    if (!wide)
        return INVALID_HANDLE_VALUE;
    HANDLE handle = CreateFileW(wide, access, share, NULL, how,
                                FILE_ATTRIBUTE_NORMAL | flags, NULL);
    if (handle == INVALID_HANDLE_VALUE)
        os_last_error();
    free(wide);
    return handle;
}
