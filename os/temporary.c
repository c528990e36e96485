/* SPDX-License-Identifier: Apache-2.0 */
#include "temporary.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "folder.h"
#include "mark.h"
#include "path.h"

enum { MOST_FOLDERS = OS_TEMPORARY_MOST, MOST_BYTES = OS_TEMPORARY_MOST_BYTES };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static char folders[MOST_FOLDERS][MOST_BYTES];
static intptr_t marks[MOST_FOLDERS];

bool os_temporary_name_mark(const char *folder, char path[OS_TEMPORARY_MOST_BYTES])
{
    const int n = snprintf(path, MOST_BYTES, "%s/" OS_FOLDER_MARK, folder);
    return n > 0 && n < MOST_BYTES;
}

void os_temporary_add(const char *folder)
{
    char path[MOST_BYTES];
    const intptr_t mark =
        os_temporary_name_mark(folder, path) ? os_mark_take(path) : -1;
    pthread_mutex_lock(&lock);
    int i = 0;
    while (i < MOST_FOLDERS && folders[i][0])
        i++;
    if (i < MOST_FOLDERS && strlen(folder) < MOST_BYTES) {
        strcpy(folders[i], folder);
        marks[i] = mark;
    } /* else the mark stays until this process ends */
    pthread_mutex_unlock(&lock);
}

/* Without the slashes at its end, of either kind: names of ours end with neither. */
static size_t length_of(const char *folder)
{
    size_t n = strlen(folder);
    while (n > 1 && strchr("/\\", folder[n - 1]))
        n--;
    return n;
}

static bool is_same_folder(const char *a, const char *b)
{
    const size_t n = length_of(a);
    return n == length_of(b) && strncmp(a, b, n) == 0;
}

void os_temporary_forget(const char *folder)
{
    pthread_mutex_lock(&lock);
    for (int i = 0; i < MOST_FOLDERS; i++)
        if (folders[i][0] && is_same_folder(folders[i], folder)) {
            folders[i][0] = 0;
            if (marks[i] != -1)
                os_mark_release(marks[i]);
        }
    pthread_mutex_unlock(&lock);
}

void os_temporary_get(int i, char folder[OS_TEMPORARY_MOST_BYTES])
{
    pthread_mutex_lock(&lock);
    strcpy(folder, folders[i]);
    pthread_mutex_unlock(&lock);
}

bool os_folder_of_temporary(const char *path, char *folder, size_t n_bytes)
{
    char own[MOST_BYTES];
    for (int i = 0; i < MOST_FOLDERS; i++) {
        os_temporary_get(i, own);
        const size_t n = length_of(own), n_base = (size_t)(os_path_name(own) - own);
        if (!own[0] || strncmp(path, own, n) != 0 || !path[n] ||
            !strchr("/\\", path[n]))
            continue;
        const int n_shown = (int)(n_base > 1 ? n_base - 1 : n_base);
        return snprintf(folder, n_bytes, "%.*s", n_base ? n_shown : 1,
                        n_base ? own : ".") < (int)n_bytes;
    }
    return false;
}
