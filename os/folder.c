/* SPDX-License-Identifier: Apache-2.0 */
#include "folder.h"

#include <dirent.h>
#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "temporary.h"

const char *os_folder_for_temporary(void)
{
    const char *base = getenv("TMPDIR");
    return base && base[0] == '/' ? base : "/tmp";
}

const char *os_folder_usual_temporary(void)
{
    return "/tmp";
}

int os_folder_make_temporary(const char *prefix, char *path, size_t n_bytes)
{
    const int n = snprintf(path, n_bytes, "%sXXXXXX", prefix);
    if (n < 0 || (size_t)n >= n_bytes)
        return ENAMETOOLONG;
    if (!mkdtemp(path))
        return errno;
    os_temporary_add(path);
    return 0;
}

int os_folder_make(const char *path, enum os_folder_access access)
{
    return mkdir(path, access == OS_FOLDER_PRIVATE ? 0700 : 0777) == 0 ? 0 : errno;
}

static int remove_entry(const char *path, const struct stat *info, int kind,
                        struct FTW *at)
{
    remove(path);
    return 0;
}

void os_folder_remove(const char *path)
{
    /* What stays, as where nftw() has no memory, os_leftovers_remove_own() tries again. */
    if (nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS) == 0 || errno == ENOENT)
        os_temporary_forget(path);
}

void os_folder_remove_empty(const char *path)
{
    rmdir(path);
}

int os_folder_list(const char *path, bool (*visit)(void *user, const char *name),
                   void *user)
{
    DIR *folder = opendir(path);
    if (!folder)
        return errno;
    for (struct dirent *entry; (entry = readdir(folder));) {
        const bool is_self =
            strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0;
        if (!is_self && !visit(user, entry->d_name))
            break;
    }
    closedir(folder);
    return 0;
}
