/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files that appear complete or not at all: written as PATH.partXXXXXX in the same
 * folder, synced, renamed over PATH. An old file stays until the rename. Of a long name
 * the temporary one has the beginning (part.h); files that begin alike then take each
 * other's for their own, which the lock makes harmless.
 *
 * Whoever writes such a file holds a lock on it, which the system lets go when the
 * process dies, however that comes. So the next one to write PATH knows which of the
 * PATH.partXXXXXX are nobody's, and removes them. Three things keep that from taking a
 * file from a living writer:
 *   - between making a file and locking it another may have removed it: the writer
 * looks after locking, and takes another name;
 *   - a name may have passed to another file: it is removed only while the lock on the
 *     very file that it names is held, and then nobody else renames or removes it;
 *   - locks may not reach other machines: on other than the usual local file systems a
 *     file must also not have been written to for a day.
 *
 * Names of unfinished files lie in static slots, because whoever ends the program may
 * neither allocate nor lock. A slot is claimed, filled, and only then shown.
 */
#include "replace.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#ifdef __APPLE__
#include <sys/mount.h>
#include <sys/param.h>
#else
#include <linux/magic.h>
#include <sys/vfs.h>
#endif

#include "part.h"
#include "path.h"

enum { N_SLOTS = 16 };
enum slot_state { SLOT_FREE, SLOT_CLAIMED, SLOT_SHOWN };

static struct {
    _Atomic int state;
    char path[PATH_MAX];
} slots[N_SLOTS];

static int show_to_cleaner(const char *path)
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

static void hide_from_cleaner(int slot)
{
    if (slot >= 0)
        atomic_store(&slots[slot].state, SLOT_FREE);
}

void os_replace_remove_all(void)
{
    int saved_errno = errno;
    for (int i = 0; i < N_SLOTS; i++)
        if (atomic_load(&slots[i].state) == SLOT_SHOWN)
            unlink(slots[i].path);
    errno = saved_errno;
}

/* Where a link points to, so that the link itself survives the rename. */
static char *resolve(const char *path)
{
    char *resolved = realpath(path, NULL);
    return resolved ? resolved : strdup(path);
}

/* ---- files of dead processes ---------------------------------------------------- */

static bool is_named(int fd, const char *path)
{
    struct stat own, named;
    return fstat(fd, &own) == 0 && lstat(path, &named) == 0 &&
           own.st_ino == named.st_ino && own.st_dev == named.st_dev;
}

/* Do all who may write here see each other's locks? */
static bool has_local_locks(int fd)
{
#ifdef __APPLE__
    struct statfs status;
    return fstatfs(fd, &status) == 0 && (status.f_flags & MNT_LOCAL) != 0;
#else
    enum { XFS_MAGIC = 0x58465342, ZFS_MAGIC = 0x2fc12fc1 };
    static const long long locals[] = {EXT4_SUPER_MAGIC,  XFS_MAGIC,
                                       BTRFS_SUPER_MAGIC, F2FS_SUPER_MAGIC,
                                       TMPFS_MAGIC,       OVERLAYFS_SUPER_MAGIC,
                                       ZFS_MAGIC};
    struct statfs status;
    if (fstatfs(fd, &status) != 0)
        return false;
    for (size_t i = 0; i < sizeof locals / sizeof locals[0]; i++)
        if ((long long)status.f_type == locals[i])
            return true;
    return false;
#endif
}

static bool is_a_day_old(int fd)
{
    struct stat status;
    return fstat(fd, &status) == 0 && status.st_mtime < time(NULL) - 24 * 60 * 60;
}

static void remove_if_stale(const char *path)
{
    int fd = open(path, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0)
        return;
    if (flock(fd, LOCK_EX | LOCK_NB) == 0 && is_named(fd, path) &&
        (has_local_locks(fd) || is_a_day_old(fd)))
        unlink(path);
    close(fd);
}

static void remove_stale(const char *target)
{
    char folder[PATH_MAX], path[PATH_MAX];
    const char *slash = strrchr(target, '/');
    size_t n = slash ? (size_t)(slash - target) + 1 : 0;
    if (n >= sizeof folder)
        return;
    memcpy(folder, target, n);
    folder[n] = '\0';
    DIR *stream = opendir(n > 0 ? folder : ".");
    for (struct dirent *entry; stream && (entry = readdir(stream));)
        if (os_part_is_of(entry->d_name, target + n) &&
            snprintf(path, sizeof path, "%s%s", folder, entry->d_name) <
                (int)sizeof path)
            remove_if_stale(path);
    if (stream)
        closedir(stream);
}

/* ---- one file ------------------------------------------------------------------- */

/* Locked, and still there; file systems without locks have nobody who removes. */
static bool is_ours(int fd, const char *path)
{
    bool is_taken = flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    return !is_taken && is_named(fd, path);
}

static int open_unique(struct os_replace *file, mode_t mode)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    uint32_t number = (uint32_t)now.tv_nsec ^ (uint32_t)getpid() << 8;
    for (int attempt = 0; attempt < 100; attempt++) {
        number = number * 1664525u + 1013904223u;
        free(file->path);
        file->path =
            os_part_path(file->target, os_path_name(file->target), number >> 8);
        if (!file->path)
            return ENOMEM;
        file->fd = open(file->path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (file->fd >= 0 && is_ours(file->fd, file->path))
            return 0;
        if (file->fd < 0 && errno != EEXIST)
            return errno;
        if (file->fd >= 0)
            close(file->fd);
        file->fd = -1;
    }
    return EEXIST;
}

int os_replace_open(struct os_replace *file, const char *path)
{
    struct stat status;
    *file = (struct os_replace){.fd = -1, .slot = -1, .target = resolve(path)};
    if (!file->target)
        return ENOMEM;
    const bool is_old = stat(file->target, &status) == 0;
    if (is_old && !S_ISREG(status.st_mode)) {
        os_replace_abort(file);
        return OS_REPLACE_NOT_REGULAR;
    }
    remove_stale(file->target);
    const int number = open_unique(file, 0666);
    if (number != 0) {
        free(file->path); /* not ours: do not unlink */
        file->path = NULL;
        os_replace_abort(file);
        return number;
    }
    file->slot = show_to_cleaner(file->path);
    /* Not the bits that lend the rights of an owner, who may be another one now. */
    if (is_old && fchmod(file->fd, status.st_mode & 0777) != 0)
        errno = 0; /* some file systems have no modes */
    return 0;
}

static void release(struct os_replace *file)
{
    if (file->fd >= 0)
        close(file->fd);
    hide_from_cleaner(file->slot);
    free(file->path);
    free(file->target);
    *file = (struct os_replace){.fd = -1, .slot = -1};
}

void os_replace_abort(struct os_replace *file)
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

FILE *os_replace_stream(const struct os_replace *file)
{
    const int fd = fcntl(file->fd, F_DUPFD_CLOEXEC, 0);
    FILE *stream = fd >= 0 ? fdopen(fd, "wb") : NULL;
    if (fd >= 0 && !stream)
        close(fd);
    return stream;
}

int os_replace_commit(struct os_replace *file)
{
    int number = 0;
    /* EINVAL: a file system without fsync. */
    if (fsync(file->fd) != 0 && errno != EINVAL)
        number = errno;
    /* The second descriptor keeps the lock until the file has its name. */
    const int fd = file->fd;
    file->fd = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    if (close(fd) != 0 && number == 0)
        number = errno;
    if (number == 0 && rename(file->path, file->target) != 0)
        number = errno;
    if (number != 0) {
        os_replace_abort(file);
        return number;
    }
    sync_folder(file->target);
    release(file);
    return 0;
}
