/* SPDX-License-Identifier: Apache-2.0 */
/* The words of what goes wrong when a file is replaced. */
#include "exr_private.h"

#include <errno.h>
#include <string.h>

#include "folder.h"

/* A file in a temporary folder has no name that means anything to who reads it, and its
 * disk need not be that of the output. */
static bool fail_full(struct image_error *error, const char *path)
{
    char folder[1024];
    if (!os_folder_of_temporary(path, folder, sizeof folder))
        return image_fail(
            error, path,
            "no space left on the disk; nothing was written; free some space there");
    const bool is_usual = strcmp(folder, os_folder_for_temporary()) == 0;
    return image_fail(error, folder,
                      "no space left on its disk for temporary files; nothing was "
                      "written; free some space there%s",
                      is_usual ? " or name another folder in TMPDIR" : "");
}

static bool fail_number(struct image_error *error, const char *path, int number)
{
    if (number == OS_REPLACE_NOT_REGULAR)
        return image_fail(error, path, "is not a regular file and cannot be replaced");
    if (number == OS_REPLACE_IN_USE)
        return image_fail(error, path,
                          "another program has it open; close it there and try again");
    if (number == ENOMEM)
        return image_lacks_memory(error, path);
    if (number == ENOSPC || number == EDQUOT)
        return fail_full(error, path);
    return image_fail(error, path, "cannot write: %s", strerror(number));
}

bool partial_open(struct os_replace *file, const char *path, struct image_error *error)
{
    const int number = os_replace_open(file, path);
    return number == 0 || fail_number(error, path, number);
}

bool partial_commit(struct os_replace *file, const char *path,
                    struct image_error *error)
{
    const int number = os_replace_commit(file);
    return number == 0 || fail_number(error, path, number);
}

bool partial_fail(const char *path, int number, struct image_error *error)
{
    return fail_number(error, path, number);
}
