/* SPDX-License-Identifier: Apache-2.0 */
#include "file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#ifdef __APPLE__
#include <mach-o/dyld.h>
#endif

static struct timespec changed_of(const struct stat *status)
{
#ifdef __APPLE__
    return status->st_mtimespec;
#else
    return status->st_mtim;
#endif
}

static struct os_file_facts facts_of(const struct stat *status)
{
    const struct timespec changed = changed_of(status);
    return (struct os_file_facts){.kind = S_ISREG(status->st_mode)   ? OS_FILE_REGULAR
                                          : S_ISDIR(status->st_mode) ? OS_FILE_FOLDER
                                                                     : OS_FILE_OTHER,
                                  .n_bytes = status->st_size,
                                  .changed_s = changed.tv_sec,
                                  .changed_ns = changed.tv_nsec,
                                  .device = (uint64_t)status->st_dev,
                                  .number = (uint64_t)status->st_ino};
}

struct os_file_facts os_file_facts(const char *path)
{
    struct stat status;
    if (stat(path, &status) != 0)
        return (struct os_file_facts){.kind = OS_FILE_NONE};
    return facts_of(&status);
}

int os_file_open(const char *path, int *fd, struct os_file_facts *facts)
{
    struct stat status;
    *fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (*fd < 0)
        return errno;
    if (fstat(*fd, &status) != 0) {
        const int number = errno;
        os_file_close(*fd);
        *fd = -1;
        return number;
    }
    if (facts)
        *facts = facts_of(&status);
    return 0;
}

void os_file_close(int fd)
{
    close(fd);
}

size_t os_file_read_at(int fd, void *data, size_t n_bytes, uint64_t offset)
{
    size_t done = 0;
    while (done < n_bytes) {
        errno = 0;
        const ssize_t n =
            pread(fd, (char *)data + done, n_bytes - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            break;
        done += (size_t)n;
    }
    return done;
}

size_t os_file_write_at(int fd, const void *data, size_t n_bytes, uint64_t offset)
{
    size_t done = 0;
    while (done < n_bytes) {
        errno = 0;
        const ssize_t n = pwrite(fd, (const char *)data + done, n_bytes - done,
                                 (off_t)(offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n == 0)
            errno = EIO;
        if (n <= 0)
            break;
        done += (size_t)n;
    }
    return done;
}

char *os_file_full_path(const char *path)
{
#ifdef __wasi__
    return strdup(path); /* there is one folder, and no links */
#else
    return realpath(path, NULL);
#endif
}

int os_file_link(const char *target, const char *link)
{
    return symlink(target, link) == 0 ? 0 : errno;
}

bool os_file_is_program(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode) &&
           access(path, X_OK) == 0;
}

bool os_program_folder(char *path, size_t n_bytes)
{
#ifdef __APPLE__
    uint32_t n = n_bytes < UINT32_MAX ? (uint32_t)n_bytes : UINT32_MAX;
    if (_NSGetExecutablePath(path, &n) != 0)
        return false;
#else
    const ssize_t n = readlink("/proc/self/exe", path, n_bytes - 1);
    if (n <= 0)
        return false;
    path[n] = 0;
#endif
    char *slash = strrchr(path, '/');
    if (slash)
        slash[1] = 0;
    return slash != NULL;
}

int os_folder_is_writable(const char *folder)
{
    return access(folder, W_OK | X_OK) == 0 ? 0 : errno;
}

int os_file_append(const char *path, const void *data, size_t n_bytes)
{
    const int fd = open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
    if (fd < 0)
        return errno;
    const ssize_t n = write(fd, data, n_bytes);
    const int number = n < 0 ? errno : n == (ssize_t)n_bytes ? 0 : ENOSPC;
    return close(fd) == 0 || number != 0 ? number : errno;
}
