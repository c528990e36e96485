/* SPDX-License-Identifier: Apache-2.0 */
#include "folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* More at once are not known to os_folder_remove_all(). */
enum { MOST_FOLDERS = 16, MOST_BYTES = 1024 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static char folders[MOST_FOLDERS][MOST_BYTES];
static int marks[MOST_FOLDERS]; /* descriptors of locked files */

static void remember(const char *path, int mark)
{
    pthread_mutex_lock(&lock);
    int i = 0;
    while (i < MOST_FOLDERS && folders[i][0])
        i++;
    if (i < MOST_FOLDERS && strlen(path) < MOST_BYTES) {
        strcpy(folders[i], path);
        marks[i] = mark;
    } /* else the lock stays until this process ends */
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
        if (folders[i][0] && is_same_folder(folders[i], path)) {
            folders[i][0] = 0;
            if (marks[i] >= 0)
                close(marks[i]);
        }
    pthread_mutex_unlock(&lock);
}

const char *os_folder_for_temporary(void)
{
    const char *base = getenv("TMPDIR");
    return base && base[0] == '/' ? base : "/tmp";
}

const char *os_folder_usual_temporary(void)
{
    return "/tmp";
}

static bool name_mark(const char *folder, char *path)
{
    const int n = snprintf(path, MOST_BYTES, "%s/" OS_FOLDER_MARK, folder);
    return n > 0 && n < MOST_BYTES;
}

/* A lock that the system takes from a process that is killed; -1 where it fails. */
static int lock_mark(const char *folder)
{
    char path[MOST_BYTES];
    const int mark =
        name_mark(folder, path) ? open(path, O_CREAT | O_RDWR | O_CLOEXEC, 0600) : -1;
    if (mark >= 0)
        flock(mark, LOCK_EX | LOCK_NB);
    return mark;
}

int os_folder_make_temporary(const char *prefix, char *path, size_t n_bytes)
{
    const int n = snprintf(path, n_bytes, "%sXXXXXX", prefix);
    if (n < 0 || (size_t)n >= n_bytes)
        return ENAMETOOLONG;
    if (!mkdtemp(path))
        return errno;
    remember(path, lock_mark(path));
    return 0;
}

/* Is it a folder of this user with a mark that nobody holds? One without a mark is just
 * being made. */
static bool is_abandoned(const char *folder)
{
    char path[MOST_BYTES];
    struct stat info;
    if (lstat(folder, &info) != 0 || !S_ISDIR(info.st_mode) ||
        info.st_uid != geteuid() || !name_mark(folder, path))
        return false;
    const int mark = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    const bool is_free = mark >= 0 && flock(mark, LOCK_EX | LOCK_NB) == 0;
    if (mark >= 0)
        close(mark);
    return is_free;
}

struct abandoned {
    const char *prefix;
    size_t n_base; /* bytes of the folder's name in it, with its slash */
};

static bool remove_if_abandoned(void *user, const char *name)
{
    const struct abandoned *abandoned = user;
    const char *start = abandoned->prefix + abandoned->n_base;
    char path[MOST_BYTES];
    const int n = snprintf(path, sizeof(path), "%.*s%s", (int)abandoned->n_base,
                           abandoned->prefix, name);
    if (strncmp(name, start, strlen(start)) == 0 && n > 0 && n < MOST_BYTES &&
        is_abandoned(path))
        os_folder_remove(path);
    return true;
}

void os_folder_remove_abandoned(const char *prefix)
{
    const char *slash = strrchr(prefix, '/');
    struct abandoned abandoned = {prefix, slash ? (size_t)(slash - prefix) + 1 : 0};
    char base[MOST_BYTES] = ".";
    if (abandoned.n_base >= sizeof(base))
        return;
    if (slash)
        snprintf(base, sizeof(base), "%.*s", (int)abandoned.n_base, prefix);
    os_folder_list(base, remove_if_abandoned, &abandoned);
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
    /* What stays, as where nftw() has no memory, os_folder_remove_all() tries again. */
    if (nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS) == 0 || errno == ENOENT)
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
