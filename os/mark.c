/* SPDX-License-Identifier: Apache-2.0 */
#include "mark.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* A lock that the system takes from a process that is killed. */
intptr_t os_mark_take(const char *path)
{
    const int mark = open(path, O_CREAT | O_RDWR | O_CLOEXEC, 0600);
    if (mark >= 0)
        flock(mark, LOCK_EX | LOCK_NB);
    return mark;
}

void os_mark_release(intptr_t mark)
{
    close((int)mark);
}

bool os_mark_is_free(const char *folder, const char *path)
{
    struct stat info;
    if (lstat(folder, &info) != 0 || !S_ISDIR(info.st_mode) || info.st_uid != geteuid())
        return false;
    const int mark = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    const bool is_free = mark >= 0 && flock(mark, LOCK_EX | LOCK_NB) == 0;
    if (mark >= 0)
        close(mark);
    return is_free;
}
