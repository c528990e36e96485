/* SPDX-License-Identifier: Apache-2.0 */
#include "folder.h"

#include <dirent.h>
#include <errno.h>
#include <ftw.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* More at once are not known to os_folder_remove_all(). */
enum { MOST_FOLDERS = 16, MOST_BYTES = 1024 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static char folders[MOST_FOLDERS][MOST_BYTES];

static void remember(const char *path)
{
    pthread_mutex_lock(&lock);
    int i = 0;
    while (i < MOST_FOLDERS && folders[i][0])
        i++;
    if (i < MOST_FOLDERS && strlen(path) < MOST_BYTES)
        strcpy(folders[i], path);
    pthread_mutex_unlock(&lock);
}

static bool is_same_folder(const char *a, const char *b)
{
    size_t n_a = strlen(a), n_b = strlen(b);
    while (n_a > 1 && a[n_a - 1] == '/')
        n_a--;
    while (n_b > 1 && b[n_b - 1] == '/')
        n_b--;
    return n_a == n_b && strncmp(a, b, n_a) == 0;
}

static void forget(const char *path)
{
    pthread_mutex_lock(&lock);
    for (int i = 0; i < MOST_FOLDERS; i++)
        if (is_same_folder(folders[i], path))
            folders[i][0] = 0;
    pthread_mutex_unlock(&lock);
}

const char *os_folder_for_temporary(void)
{
    const char *base = getenv("TMPDIR");
    return base && base[0] == '/' ? base : "/tmp";
}

int os_folder_make_temporary(const char *prefix, char *path, size_t n_bytes)
{
    const int n = snprintf(path, n_bytes, "%sXXXXXX", prefix);
    if (n < 0 || (size_t)n >= n_bytes)
        return ENAMETOOLONG;
    if (!mkdtemp(path))
        return errno;
    remember(path);
    return 0;
}

int os_folder_make(const char *path)
{
    return mkdir(path, 0700) == 0 ? 0 : errno;
}

static int remove_entry(const char *path, const struct stat *info, int kind,
                        struct FTW *at)
{
    remove(path);
    return 0;
}

void os_folder_remove(const char *path)
{
    nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
    forget(path);
}

void os_folder_remove_all(void)
{
    for (int i = 0; i < MOST_FOLDERS; i++) {
        char path[MOST_BYTES];
        pthread_mutex_lock(&lock);
        strcpy(path, folders[i]);
        pthread_mutex_unlock(&lock);
        if (path[0])
            os_folder_remove(path);
    }
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
