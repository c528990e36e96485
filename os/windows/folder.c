/* SPDX-License-Identifier: Apache-2.0 */
#include "folder.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "temporary.h"
#include "wide.h"

/* The user's own, by its short name where it has one: without blanks. */
static void find_temporary(char *path)
{
    wchar_t wide[MAX_PATH + 1], brief[MAX_PATH + 1];
    const DWORD n = GetTempPathW(MAX_PATH + 1, wide);
    const DWORD n_brief = n > 0 ? GetShortPathNameW(wide, brief, MAX_PATH + 1) : 0;
    char *found =
        n == 0 ? NULL
               : os_narrow_path(n_brief > 0 && n_brief <= MAX_PATH ? brief : wide);
    snprintf(path, OS_TEMPORARY_MOST_BYTES, "%s", found ? found : ".");
    const size_t length = strlen(path);
    if (length > 1 && path[length - 1] == '/')
        path[length - 1] = 0;
    free(found);
}

const char *os_folder_for_temporary(void)
{
    static SRWLOCK lock = SRWLOCK_INIT;
    static char path[OS_TEMPORARY_MOST_BYTES];
    AcquireSRWLockExclusive(&lock);
    if (!path[0])
        find_temporary(path);
    ReleaseSRWLockExclusive(&lock);
    return path;
}

const char *os_folder_usual_temporary(void)
{
    return os_folder_for_temporary();
}

int os_folder_make(const char *path, enum os_folder_access access)
{
    /* A folder of the user's profile is the user's alone already. */
    (void)access;
    wchar_t *wide = os_wide_path(path);
    if (!wide)
        return errno;
    const int number = CreateDirectoryW(wide, NULL) ? 0 : os_last_error();
    free(wide);
    return number;
}

int os_folder_make_temporary(const char *prefix, char *path, size_t n_bytes)
{
    LARGE_INTEGER now;
    QueryPerformanceCounter(&now);
    uint32_t number = (uint32_t)now.QuadPart ^ (uint32_t)GetCurrentProcessId() << 8;
    for (int attempt = 0; attempt < 100; attempt++) {
        number = number * 1664525u + 1013904223u;
        const int n =
            snprintf(path, n_bytes, "%s%06x", prefix, (unsigned)(number >> 8));
        if (n < 0 || (size_t)n >= n_bytes)
            return ENAMETOOLONG;
        const int reason = os_folder_make(path, OS_FOLDER_PRIVATE);
        if (reason == EEXIST)
            continue;
        if (reason == 0)
            os_temporary_add(path);
        return reason;
    }
    return EEXIST;
}

/* ---- what is in a folder --------------------------------------------------------- */

/* The path of an entry, with room for it; free() it. */
static wchar_t *entry_of(const wchar_t *folder, const wchar_t *name)
{
    const size_t n = wcslen(folder), n_name = wcslen(name);
    wchar_t *path = malloc((n + n_name + 2) * sizeof(*path));
    if (path) {
        memcpy(path, folder, n * sizeof(*path));
        path[n] = L'\\';
        memcpy(path + n + 1, name, (n_name + 1) * sizeof(*path));
    }
    return path;
}

static bool is_self(const wchar_t *name)
{
    return wcscmp(name, L".") == 0 || wcscmp(name, L"..") == 0;
}

/* Calls `visit` for each entry; Windows' error, ERROR_SUCCESS for none. */
static DWORD walk(const wchar_t *folder,
                  bool (*visit)(void *user, const wchar_t *folder,
                                const WIN32_FIND_DATAW *entry),
                  void *user)
{
    WIN32_FIND_DATAW entry;
    wchar_t *all = entry_of(folder, L"*");
    HANDLE search = all ? FindFirstFileW(all, &entry) : INVALID_HANDLE_VALUE;
    const DWORD code = !all ? ERROR_OUTOFMEMORY : GetLastError();
    free(all);
    if (search == INVALID_HANDLE_VALUE)
        return code;
    do
        if (!is_self(entry.cFileName) && !visit(user, folder, &entry))
            break;
    while (FindNextFileW(search, &entry));
    FindClose(search);
    return ERROR_SUCCESS;
}

static void remove_tree(const wchar_t *folder);

static bool remove_entry(void *user, const wchar_t *folder,
                         const WIN32_FIND_DATAW *entry)
{
    (void)user;
    wchar_t *path = entry_of(folder, entry->cFileName);
    if (!path)
        return true;
    const DWORD kind = entry->dwFileAttributes;
    if (kind & FILE_ATTRIBUTE_READONLY)
        SetFileAttributesW(path, kind & ~(DWORD)FILE_ATTRIBUTE_READONLY);
    if (!(kind & FILE_ATTRIBUTE_DIRECTORY))
        DeleteFileW(path);
    else if (kind & FILE_ATTRIBUTE_REPARSE_POINT) /* a link: not what it names */
        RemoveDirectoryW(path);
    else
        remove_tree(path);
    free(path);
    return true;
}

static void remove_tree(const wchar_t *folder)
{
    walk(folder, remove_entry, NULL);
    RemoveDirectoryW(folder);
}

void os_folder_remove(const char *path)
{
    os_temporary_forget(path); /* first: an open mark cannot be removed */
    wchar_t *wide = os_wide_path(path);
    if (wide)
        remove_tree(wide);
    free(wide);
}

void os_folder_remove_empty(const char *path)
{
    wchar_t *wide = os_wide_path(path);
    if (wide)
        RemoveDirectoryW(wide);
    free(wide);
}

struct listing {
    bool (*visit)(void *user, const char *name);
    void *user;
};

static bool list_entry(void *user, const wchar_t *folder, const WIN32_FIND_DATAW *entry)
{
    (void)folder;
    const struct listing *listing = user;
    char *name = os_narrow_text(entry->cFileName);
    const bool goes_on = !name || listing->visit(listing->user, name);
    free(name);
    return goes_on;
}

int os_folder_list(const char *path, bool (*visit)(void *user, const char *name),
                   void *user)
{
    struct listing listing = {visit, user};
    wchar_t *wide = os_wide_path(path);
    if (!wide)
        return errno;
    const DWORD code = walk(wide, list_entry, &listing);
    free(wide);
    SetLastError(code);
    return code == ERROR_SUCCESS || code == ERROR_FILE_NOT_FOUND ? 0 : os_last_error();
}
