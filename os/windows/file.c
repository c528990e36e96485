/* SPDX-License-Identifier: Apache-2.0 */
#include "file.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <stdlib.h>
#include <string.h>

#include "wide.h"

/* Tenths of microseconds between 1601, where Windows begins, and 1970. */
static const int64_t TO_1970 = 116444736000000000;

static int64_t joined(DWORD high, DWORD low)
{
    return (int64_t)((uint64_t)high << 32 | low);
}

static struct os_file_facts facts_of(HANDLE handle)
{
    BY_HANDLE_FILE_INFORMATION info;
    if (!GetFileInformationByHandle(handle, &info)) {
        os_last_error();
        return (struct os_file_facts){.kind = GetFileType(handle) == FILE_TYPE_DISK
                                                  ? OS_FILE_NONE
                                                  : OS_FILE_OTHER};
    }
    const int64_t changed = joined(info.ftLastWriteTime.dwHighDateTime,
                                   info.ftLastWriteTime.dwLowDateTime) -
                            TO_1970;
    const bool is_folder = info.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY;
    return (struct os_file_facts){
        .kind = is_folder                               ? OS_FILE_FOLDER
                : GetFileType(handle) == FILE_TYPE_DISK ? OS_FILE_REGULAR
                                                        : OS_FILE_OTHER,
        .n_bytes = joined(info.nFileSizeHigh, info.nFileSizeLow),
        .changed_s = changed / 10000000,
        .changed_ns = changed % 10000000 * 100,
        .device = info.dwVolumeSerialNumber,
        .number = (uint64_t)joined(info.nFileIndexHigh, info.nFileIndexLow)};
}

struct os_file_facts os_file_facts(const char *path)
{
    HANDLE handle = os_handle_open(path, 0, OS_SHARE_ALL, OPEN_EXISTING,
                                   FILE_FLAG_BACKUP_SEMANTICS);
    if (handle == INVALID_HANDLE_VALUE)
        return (struct os_file_facts){.kind = OS_FILE_NONE};
    const struct os_file_facts facts = facts_of(handle);
    CloseHandle(handle);
    return facts;
}

int os_file_open(const char *path, int *fd, struct os_file_facts *facts)
{
    *fd = -1;
    HANDLE handle = os_handle_open(path, GENERIC_READ, OS_SHARE_ALL, OPEN_EXISTING,
                                   FILE_FLAG_BACKUP_SEMANTICS);
    if (handle == INVALID_HANDLE_VALUE)
        return errno;
    if (facts)
        *facts = facts_of(handle);
    *fd = _open_osfhandle((intptr_t)handle, _O_RDONLY | _O_BINARY | _O_NOINHERIT);
    if (*fd >= 0)
        return 0;
    CloseHandle(handle);
    return EMFILE;
}

void os_file_close(int fd)
{
    _close(fd);
}

/* Most bytes that one call reads or writes. */
enum { MOST_BYTES = 1 << 30 };

static OVERLAPPED place_of(uint64_t offset)
{
    return (OVERLAPPED){.Offset = (DWORD)offset, .OffsetHigh = (DWORD)(offset >> 32)};
}

size_t os_file_read_at(int fd, void *data, size_t n_bytes, uint64_t offset)
{
    HANDLE handle = (HANDLE)_get_osfhandle(fd);
    size_t done = 0;
    errno = 0;
    while (done < n_bytes) {
        const size_t left = n_bytes - done;
        OVERLAPPED at = place_of(offset + done);
        DWORD n = 0;
        if (!ReadFile(handle, (char *)data + done,
                      (DWORD)(left < MOST_BYTES ? left : MOST_BYTES), &n, &at)) {
            if (GetLastError() != ERROR_HANDLE_EOF)
                os_last_error();
            break;
        }
        if (n == 0)
            break;
        done += n;
    }
    return done;
}

size_t os_file_write_at(int fd, const void *data, size_t n_bytes, uint64_t offset)
{
    HANDLE handle = (HANDLE)_get_osfhandle(fd);
    size_t done = 0;
    errno = 0;
    while (done < n_bytes) {
        const size_t left = n_bytes - done;
        OVERLAPPED at = place_of(offset + done);
        DWORD n = 0;
        if (!WriteFile(handle, (const char *)data + done,
                       (DWORD)(left < MOST_BYTES ? left : MOST_BYTES), &n, &at)) {
            os_last_error();
            break;
        }
        if (n == 0) {
            errno = EIO;
            break;
        }
        done += n;
    }
    return done;
}

char *os_file_full_path(const char *path)
{
    HANDLE handle = os_handle_open(path, 0, OS_SHARE_ALL, OPEN_EXISTING,
                                   FILE_FLAG_BACKUP_SEMANTICS);
    if (handle == INVALID_HANDLE_VALUE)
        return NULL;
    const DWORD n = GetFinalPathNameByHandleW(handle, NULL, 0, 0);
    wchar_t *wide = n > 0 ? malloc(((size_t)n + 1) * sizeof(*wide)) : NULL;
    const bool is_known = wide && GetFinalPathNameByHandleW(handle, wide, n + 1, 0) > 0;
    if (!is_known)
        os_last_error();
    CloseHandle(handle);
    char *full = is_known ? os_narrow_path(wide) : NULL;
    free(wide);
    return full;
}

int os_file_link(const char *target, const char *link)
{
    const DWORD unprivileged = 2; /* SYMBOLIC_LINK_FLAG_ALLOW_UNPRIVILEGED_CREATE */
    const bool is_folder = os_file_facts(target).kind == OS_FILE_FOLDER;
    wchar_t *to = os_wide_path(target), *at = os_wide_path(link);
    int number = to && at ? 0 : ENOMEM;
    for (wchar_t *c = to; c && *c; c++)
        if (*c == L'/') /* is a letter of a name there */
            *c = L'\\';
    if (number == 0 && !CreateSymbolicLinkW(at, to, (is_folder ? 1 : 0) | unprivileged))
        number = os_last_error();
    free(to);
    free(at);
    return number;
}

/* The file itself, or with .exe behind. */
bool os_file_is_program(const char *path)
{
    if (os_file_facts(path).kind == OS_FILE_REGULAR)
        return true;
    const size_t n = strlen(path);
    char *longer = malloc(n + sizeof(".exe"));
    if (longer) {
        memcpy(longer, path, n);
        memcpy(longer + n, ".exe", sizeof(".exe"));
    }
    const bool is_there = longer && os_file_facts(longer).kind == OS_FILE_REGULAR;
    free(longer);
    return is_there;
}

bool os_program_folder(char *path, size_t n_bytes)
{
    enum { MOST = 32768 }; /* Windows' longest path */
    wchar_t *wide = malloc(MOST * sizeof(*wide));
    const DWORD n = wide ? GetModuleFileNameW(NULL, wide, MOST) : 0;
    char *own = n > 0 && n < MOST ? os_narrow_path(wide) : NULL;
    char *slash = own ? strrchr(own, '/') : NULL;
    const bool is_known = slash && (size_t)(slash - own) + 2 <= n_bytes;
    if (is_known) {
        memcpy(path, own, (size_t)(slash - own) + 1);
        path[slash - own + 1] = 0;
    }
    free(own);
    free(wide);
    return is_known;
}

int os_folder_is_writable(const char *folder)
{
    HANDLE handle = os_handle_open(folder, FILE_ADD_FILE, OS_SHARE_ALL, OPEN_EXISTING,
                                   FILE_FLAG_BACKUP_SEMANTICS);
    if (handle == INVALID_HANDLE_VALUE)
        return errno;
    CloseHandle(handle);
    return 0;
}

int os_file_append(const char *path, const void *data, size_t n_bytes)
{
    HANDLE handle = os_handle_open(path, FILE_APPEND_DATA | SYNCHRONIZE, OS_SHARE_ALL,
                                   OPEN_ALWAYS, 0);
    if (handle == INVALID_HANDLE_VALUE)
        return errno;
    DWORD n = 0;
    const bool is_written = WriteFile(handle, data, (DWORD)n_bytes, &n, NULL);
    const int number = !is_written ? os_last_error() : n == n_bytes ? 0 : ENOSPC;
    CloseHandle(handle);
    return number;
}
