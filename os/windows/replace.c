/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files that appear complete or not at all: written as PATH.partXXXXXX in the same
 * folder, flushed, renamed over PATH. An old file stays until the rename.
 *
 * Whoever writes such a file shares it with readers only. So nobody can remove it while
 * its writer lives, on this machine or another; what can be removed is nobody's, and the
 * next one to write PATH does so.
 *
 * Names of unfinished files lie in static slots, because whoever ends the program may
 * neither allocate nor lock. A slot is claimed, filled, and only then shown.
 */
#include "replace.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "file.h"
#include "folder.h"
#include "part.h"
#include "path.h"
#include "wide.h"

enum { N_SLOTS = 16 };
enum slot_state { SLOT_FREE, SLOT_CLAIMED, SLOT_SHOWN };

static struct {
    _Atomic int state;
    HANDLE handle;
} slots[N_SLOTS];

static int show_to_cleaner(HANDLE handle)
{
    for (int i = 0; i < N_SLOTS; i++) {
        int expected = SLOT_FREE;
        if (!atomic_compare_exchange_strong(&slots[i].state, &expected, SLOT_CLAIMED))
            continue;
        slots[i].handle = handle;
        atomic_store(&slots[i].state, SLOT_SHOWN);
        return i;
    }
    return -1; /* more than N_SLOTS at once: not removed when interrupted */
}

static void hide_from_cleaner(int slot)
{
    if (slot >= 0)
        atomic_store(&slots[slot].state, SLOT_FREE);
}

/* The file goes when its last handle is closed. */
static bool mark_removed(HANDLE handle)
{
    FILE_DISPOSITION_INFO removed = {.DeleteFile = TRUE};
    return SetFileInformationByHandle(handle, FileDispositionInfo, &removed,
                                      sizeof(removed));
}

void os_replace_remove_all(void)
{
    for (int i = 0; i < N_SLOTS; i++)
        if (atomic_load(&slots[i].state) == SLOT_SHOWN)
            mark_removed(slots[i].handle);
}

/* ---- files of dead processes ---------------------------------------------------- */

struct search {
    const char *target, *name; /* its last part */
};

static bool remove_if_stale(void *user, const char *entry)
{
    const struct search *search = user;
    if (!os_part_is_of(entry, search->name))
        return true;
    const size_t n = (size_t)(search->name - search->target);
    char *path = malloc(n + strlen(entry) + 1);
    if (!path)
        return true;
    memcpy(path, search->target, n);
    strcpy(path + n, entry);
    HANDLE handle = os_handle_open(path, DELETE, FILE_SHARE_DELETE, OPEN_EXISTING, 0);
    if (handle != INVALID_HANDLE_VALUE) {
        mark_removed(handle);
        CloseHandle(handle);
    }
    free(path);
    return true;
}

static void remove_stale(const char *target)
{
    struct search search = {target, target + strlen(target)};
    while (search.name > target && !strchr("/\\:", search.name[-1]))
        search.name--;
    const size_t n = (size_t)(search.name - target);
    char *folder = malloc(n + 2);
    if (!folder)
        return;
    memcpy(folder, target, n);
    strcpy(folder + n, n == 0 || target[n - 1] == ':' ? "." : "");
    os_folder_list(folder, remove_if_stale, &search);
    free(folder);
}

/* ---- one file ------------------------------------------------------------------- */

static int open_unique(struct os_replace *file)
{
    LARGE_INTEGER now;
    QueryPerformanceCounter(&now);
    uint32_t number = (uint32_t)now.QuadPart ^ (uint32_t)GetCurrentProcessId() << 8;
    for (int attempt = 0; attempt < 100; attempt++) {
        number = number * 1664525u + 1013904223u;
        free(file->path);
        file->path =
            os_part_path(file->target, os_path_name(file->target), number >> 8);
        if (!file->path)
            return ENOMEM;
        HANDLE handle =
            os_handle_open(file->path, GENERIC_READ | GENERIC_WRITE | DELETE,
                           FILE_SHARE_READ, CREATE_NEW, 0);
        if (handle == INVALID_HANDLE_VALUE && errno == EEXIST)
            continue;
        if (handle == INVALID_HANDLE_VALUE)
            return errno;
        file->fd = _open_osfhandle((intptr_t)handle, _O_BINARY | _O_NOINHERIT);
        if (file->fd >= 0)
            return 0;
        mark_removed(handle);
        CloseHandle(handle);
        return EMFILE;
    }
    return EEXIST;
}

static HANDLE handle_of(const struct os_replace *file)
{
    return (HANDLE)_get_osfhandle(file->fd);
}

int os_replace_open(struct os_replace *file, const char *path)
{
    char *full = os_file_full_path(path); /* of what a link names: the link stays */
    *file = (struct os_replace){
        .fd = -1, .slot = -1, .target = full ? full : _strdup(path)};
    if (!file->target)
        return ENOMEM;
    const enum os_file_kind kind = os_file_facts(file->target).kind;
    if (kind != OS_FILE_NONE && kind != OS_FILE_REGULAR) {
        os_replace_abort(file);
        return OS_REPLACE_NOT_REGULAR;
    }
    remove_stale(file->target);
    const int number = open_unique(file);
    if (number != 0) {
        os_replace_abort(file);
        return number;
    }
    file->slot = show_to_cleaner(handle_of(file));
    return 0;
}

static void release(struct os_replace *file)
{
    hide_from_cleaner(file->slot);
    if (file->fd >= 0)
        _close(file->fd);
    free(file->path);
    free(file->target);
    *file = (struct os_replace){.fd = -1, .slot = -1};
}

void os_replace_abort(struct os_replace *file)
{
    if (file->fd >= 0)
        mark_removed(handle_of(file));
    release(file);
}

FILE *os_replace_stream(const struct os_replace *file)
{
    const int fd = _dup(file->fd);
    FILE *stream = fd >= 0 ? _fdopen(fd, "wb") : NULL;
    if (fd >= 0 && !stream)
        _close(fd);
    return stream;
}

/* The old file may be open in a viewer, or a virus scanner looks at it: a second of
 * patience. */
static int rename_over(HANDLE handle, const char *target)
{
    enum { N_ATTEMPTS = 20 };
    wchar_t *wide = os_wide_path(target);
    const size_t n = wide ? wcslen(wide) : 0;
    FILE_RENAME_INFO *info =
        wide ? calloc(1, sizeof(*info) + (n + 1) * sizeof(*wide)) : NULL;
    if (!info) {
        free(wide);
        return ENOMEM;
    }
    info->ReplaceIfExists = TRUE;
    info->FileNameLength = (DWORD)(n * sizeof(*wide));
    memcpy(info->FileName, wide, n * sizeof(*wide));
    int number = 0;
    for (int attempt = 0; attempt < N_ATTEMPTS; attempt++) {
        number =
            SetFileInformationByHandle(handle, FileRenameInfo, info,
                                       (DWORD)(sizeof(*info) + (n + 1) * sizeof(*wide)))
                ? 0
                : os_last_error();
        if (number != EACCES)
            break;
        os_sleep_s(0.05);
    }
    const DWORD kind = GetFileAttributesW(wide);
    if (number == EACCES && kind != INVALID_FILE_ATTRIBUTES &&
        !(kind & FILE_ATTRIBUTE_READONLY))
        number = OS_REPLACE_IN_USE;
    free(info);
    free(wide);
    return number;
}

int os_replace_commit(struct os_replace *file)
{
    int number = FlushFileBuffers(handle_of(file)) ? 0 : os_last_error();
    if (number == 0)
        number = rename_over(handle_of(file), file->target);
    if (number != 0) {
        os_replace_abort(file);
        return number;
    }
    release(file);
    return 0;
}
