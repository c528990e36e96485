/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "file.h"
#include "path.h"

/* Two names of one thing? What has no number of its own (a device of Windows) is none. */
static bool is_same_thing(const struct os_file_facts *a, const struct os_file_facts *b)
{
    const bool has_number = a->kind == OS_FILE_REGULAR || a->kind == OS_FILE_FOLDER;
    return has_number && a->kind == b->kind && a->device == b->device &&
           a->number == b->number;
}

/* Of the folder that a file lies in, or would lie in. */
static struct os_file_facts facts_of_folder(const char *path)
{
    char folder[4096];
    const int n = (int)(os_path_name(path) - path);
    if (snprintf(folder, sizeof(folder), "%.*s.", n, path) >= (int)sizeof(folder))
        return (struct os_file_facts){.kind = OS_FILE_NONE};
    return os_file_facts(folder);
}

static bool would_be_same(const char *a, const char *b)
{
    const struct os_file_facts folder_a = facts_of_folder(a);
    const struct os_file_facts folder_b = facts_of_folder(b);
    return is_same_thing(&folder_a, &folder_b) &&
           os_path_is_same_name(os_path_name(a), os_path_name(b));
}

bool os_file_is_same(const char *a, const char *b)
{
    const struct os_file_facts of_a = os_file_facts(a), of_b = os_file_facts(b);
    if (of_a.kind == OS_FILE_NONE && of_b.kind == OS_FILE_NONE)
        return would_be_same(a, b);
    return is_same_thing(&of_a, &of_b);
}
