/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files that appear complete or not at all: written as PATH.partXXXXXX in the same
 * folder, synced, renamed over PATH. An old file stays until the rename.
 *
 * Names of unfinished files lie in static slots, because a signal handler may neither
 * allocate nor lock. A slot is claimed, filled, and only then shown to the handler.
 */
#include "exr_private.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { N_SLOTS = 16 };
enum slot_state { SLOT_FREE, SLOT_CLAIMED, SLOT_SHOWN };

static struct {
    _Atomic int state;
    char path[PATH_MAX];
} slots[N_SLOTS];

static int show_to_handler(const char *path)
{
    size_t length = strlen(path);
    for (int i = 0; i < N_SLOTS && length < PATH_MAX; i++) {
        int expected = SLOT_FREE;
        if (!atomic_compare_exchange_strong(&slots[i].state, &expected, SLOT_CLAIMED))
            continue;
        memcpy(slots[i].path, path, length + 1);
        atomic_store(&slots[i].state, SLOT_SHOWN);
        return i;
    }
    return -1; /* more than N_SLOTS at once: not removed when interrupted */
}

static void hide_from_handler(int slot)
{
    if (slot >= 0)
        atomic_store(&slots[slot].state, SLOT_FREE);
}

void exr_remove_partial(void)
{
    int saved_errno = errno;
    for (int i = 0; i < N_SLOTS; i++)
        if (atomic_load(&slots[i].state) == SLOT_SHOWN)
            unlink(slots[i].path);
    errno = saved_errno;
}

/* The words of a full disk are worth a way out. */
static bool fail_errno(struct exr_error *error, const char *path, int number)
{
    if (number == ENOSPC || number == EDQUOT)
        return exr_fail(error, path, "no space left on the disk; nothing was written");
    return exr_fail(error, path, "cannot write: %s", strerror(number));
}

/* Where a link points to, so that the link itself survives the rename. */
static char *resolve(const char *path)
{
    char *resolved = realpath(path, NULL);
    return resolved ? resolved : strdup(path);
}

static int open_unique(struct partial_file *file, mode_t mode)
{
    size_t size = strlen(file->target) + sizeof ".part123456";
    struct timespec now;
    file->path = malloc(size);
    if (!file->path)
        return ENOMEM;
    clock_gettime(CLOCK_REALTIME, &now);
    uint32_t number = (uint32_t)now.tv_nsec ^ (uint32_t)getpid() << 8;
    for (int attempt = 0; attempt < 100; attempt++) {
        number = number * 1664525u + 1013904223u;
        snprintf(file->path, size, "%s.part%06x", file->target,
                 (unsigned)(number >> 8));
        file->fd = open(file->path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (file->fd >= 0)
            return 0;
        if (errno != EEXIST)
            return errno;
    }
    return EEXIST;
}

bool partial_open(struct partial_file *file, const char *path, struct exr_error *error)
{
    struct stat status;
    *file = (struct partial_file){.fd = -1, .slot = -1, .target = resolve(path)};
    if (!file->target)
        return exr_fail(error, path, "out of memory");
    bool is_old = stat(file->target, &status) == 0;
    if (is_old && !S_ISREG(status.st_mode)) {
        exr_fail(error, path, "is not a regular file and cannot be replaced");
        partial_abort(file);
        return false;
    }
    int number = open_unique(file, 0666);
    if (number != 0) {
        fail_errno(error, path, number);
        free(file->path); /* not ours: do not unlink */
        file->path = NULL;
        partial_abort(file);
        return false;
    }
    file->slot = show_to_handler(file->path);
    if (is_old && fchmod(file->fd, status.st_mode & 07777) != 0)
        errno = 0; /* some file systems have no modes */
    return true;
}

static void release(struct partial_file *file)
{
    if (file->fd >= 0)
        close(file->fd);
    hide_from_handler(file->slot);
    free(file->path);
    free(file->target);
    *file = (struct partial_file){.fd = -1, .slot = -1};
}

void partial_abort(struct partial_file *file)
{
    if (file->path)
        unlink(file->path);
    release(file);
}

/* The name reaches the disk with its folder; not all file systems can sync one. */
static void sync_folder(const char *path)
{
    char *folder = strdup(path);
    char *slash = folder ? strrchr(folder, '/') : NULL;
    if (slash)
        slash[slash == folder] = '\0';
    int fd =
        folder ? open(slash ? folder : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
    free(folder);
}

bool partial_commit(struct partial_file *file, struct exr_error *error)
{
    int number = 0;
    /* EINVAL: a file system without fsync. */
    if (fsync(file->fd) != 0 && errno != EINVAL)
        number = errno;
    int fd = file->fd;
    file->fd = -1;
    if (close(fd) != 0 && number == 0)
        number = errno;
    if (number == 0 && rename(file->path, file->target) != 0)
        number = errno;
    if (number != 0) {
        fail_errno(error, file->target, number);
        partial_abort(file);
        return false;
    }
    sync_folder(file->target);
    release(file);
    return true;
}

bool partial_fail(const struct partial_file *file, int number, struct exr_error *error)
{
    return fail_errno(error, file->target, number);
}
