/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the browser has in place of a system's own. os_replace_*() work in the files that
 * wasi.js keeps in memory: nobody else is there, so a file is written in its place.
 */
#include "replace.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/report.h"
#include "folder.h"
#include "image.h"
#include "thread.h"

int os_replace_open(struct os_replace *file, const char *path)
{
    *file = (struct os_replace){.target = strdup(path), .fd = -1};
    if (!file->target)
        return ENOMEM;
    file->path = file->target;
    file->fd = open(path, O_RDWR | O_CREAT | O_TRUNC, 0666);
    if (file->fd >= 0)
        return 0;
    const int number = errno;
    free(file->target);
    return number;
}

FILE *os_replace_stream(const struct os_replace *file)
{
    (void)file;
    errno = ENOSYS;
    return NULL;
}

int os_replace_commit(struct os_replace *file)
{
    const int number = close(file->fd) == 0 ? 0 : errno;
    free(file->target);
    return number;
}

void os_replace_abort(struct os_replace *file)
{
    close(file->fd);
    unlink(file->target);
    free(file->target);
}

/* There is one folder, and no temporary ones. */

const char *os_folder_for_temporary(void)
{
    return "";
}

bool os_folder_of_temporary(const char *path, char *folder, size_t n_bytes)
{
    (void)path;
    (void)folder;
    (void)n_bytes;
    return false;
}

/* Nobody else runs here, either. */

void os_lock_init(struct os_lock *lock)
{
    (void)lock;
}

void os_lock_destroy(struct os_lock *lock)
{
    (void)lock;
}

void os_lock_take(struct os_lock *lock)
{
    (void)lock;
}

void os_lock_release(struct os_lock *lock)
{
    (void)lock;
}

/* PNG files are the page's: it has the browser's own reader and zlib. */

bool image_write_png(const char *path, const float *samples, int32_t width,
                     int32_t height, int n_channels, int bits, bool is_encoded,
                     struct image_error *error)
{
    return set_error(error, "%s: PNG files are not written here", path);
}

bool image_read_png(const char *path, float **samples, int32_t *width, int32_t *height,
                    struct image_error *error)
{
    return set_error(error, "%s: is a PNG; drop an OpenEXR file", path);
}
