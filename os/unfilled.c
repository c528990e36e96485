/* SPDX-License-Identifier: Apache-2.0 */
#include "unfilled.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "folder.h"

enum { MOST_FOLDERS = 8 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct unfilled {
    char *path; /* NULL: the place is free */
    enum os_folder_end end;
} folders[MOST_FOLDERS];

/* A folder that cannot be remembered stays, as any other does. */
static void remember(const char *path, enum os_folder_end end)
{
    pthread_mutex_lock(&lock);
    int i = 0;
    while (i < MOST_FOLDERS && folders[i].path)
        i++;
    if (i < MOST_FOLDERS)
        folders[i] = (struct unfilled){strdup(path), end};
    pthread_mutex_unlock(&lock);
}

int os_folder_make_to_fill(const char *path, enum os_folder_end end)
{
    const int reason = os_folder_make(path, OS_FOLDER_SHARED);
    if (reason == 0)
        remember(path, end);
    return reason;
}

static struct unfilled take(int i)
{
    pthread_mutex_lock(&lock);
    const struct unfilled taken = folders[i];
    folders[i].path = NULL;
    pthread_mutex_unlock(&lock);
    return taken;
}

void os_folder_keep(const char *path)
{
    pthread_mutex_lock(&lock);
    for (int i = 0; i < MOST_FOLDERS; i++)
        if (folders[i].path && strcmp(folders[i].path, path) == 0) {
            free(folders[i].path);
            folders[i].path = NULL;
        }
    pthread_mutex_unlock(&lock);
}

void os_unfilled_remove(void)
{
    for (int i = 0; i < MOST_FOLDERS; i++) {
        const struct unfilled folder = take(i);
        if (folder.path && folder.end == OS_FOLDER_GOES_UNLESS_KEPT)
            os_folder_remove(folder.path);
        else if (folder.path)
            os_folder_remove_empty(folder.path);
        free(folder.path);
    }
}
