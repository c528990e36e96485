/* SPDX-License-Identifier: Apache-2.0 */
#include "common/text_file.h"

#include <errno.h>
#include <string.h>

#include "common/report.h"
#include "replace.h"

/* Closes the stream, too. 0 or errno. */
static int print_all(FILE *stream, text_print_fn print, const void *data)
{
    if (!stream)
        return errno;
    errno = 0;
    print(stream, data);
    const bool is_good = fflush(stream) == 0 && !ferror(stream);
    const int reason = is_good ? 0 : errno ? errno : EIO;
    return fclose(stream) == 0 || reason != 0 ? reason : errno;
}

bool text_file_write(const char *path, text_print_fn print, const void *data,
                     struct image_error *error)
{
    struct os_replace file;
    int reason = os_replace_open(&file, path);
    if (reason == 0) {
        reason = print_all(os_replace_stream(&file), print, data);
        if (reason == 0)
            reason = os_replace_commit(&file);
        else
            os_replace_abort(&file);
    }
    if (reason == 0)
        return true;
    return set_error(
        error, "%s: cannot be written: %s; choose another name or free some space",
        path,
        reason == OS_REPLACE_NOT_REGULAR ? "is no regular file"
        : reason == OS_REPLACE_IN_USE    ? "another program has it open"
                                         : strerror(reason));
}
