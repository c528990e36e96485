/* SPDX-License-Identifier: Apache-2.0 */
/* Names of one file, whether it is there or not. */
#include <stdio.h>
#include <stdlib.h>

#include "clean_up.h"
#include "file.h"
#include "folder.h"
#include "testing.h"

static char base[512];

/* Of names in the folder of the test. */
static bool is_same(const char *a, const char *b)
{
    char path_a[700], path_b[700];
    snprintf(path_a, sizeof(path_a), "%s/%s", base, a);
    snprintf(path_b, sizeof(path_b), "%s/%s", base, b);
    return os_file_is_same(path_a, path_b);
}

static void make_file(const char *name)
{
    char path[700];
    snprintf(path, sizeof(path), "%s/%s", base, name);
    CHECK(os_file_append(path, "x", 1) == 0);
}

static void names_of_a_file_that_is_there(void)
{
    make_file("one");
    make_file("two");
    CHECK(is_same("one", "one") && is_same("one", "./one"));
    CHECK(is_same("folder/../one", "one"));
    CHECK(!is_same("one", "two") && !is_same("one", "none"));
    CHECK(!is_same("none", "one") && !is_same("folder", "one"));
}

static void names_of_a_file_that_is_not(void)
{
    CHECK(is_same("none", "none") && is_same("none", "./none"));
    CHECK(is_same("folder/../none", ".//none"));
    CHECK(!is_same("none", "other") && !is_same("none", "folder/none"));
    CHECK(!is_same("lost/none", "lost/../none"));
    CHECK(os_file_is_same("no-such-file", "./no-such-file"));
}

static void names_by_a_link(void)
{
    char link[700], target[700];
    snprintf(link, sizeof(link), "%s/link", base);
    snprintf(target, sizeof(target), "%s/folder", base);
    CHECK(os_file_link(target, link) == 0);
    make_file("folder/three");
    CHECK(is_same("link/three", "folder/three"));
    CHECK(is_same("link/none", "folder/none") && !is_same("link/none", "none"));
}

int main(int argc, char **argv)
{
    char prefix[256], folder[700];
    testing_begin(argc, argv);
    snprintf(prefix, sizeof(prefix), "%.200s/rf-test-os-", os_folder_for_temporary());
    if (os_folder_make_temporary(prefix, base, sizeof(base)) != 0)
        return 1;
    snprintf(folder, sizeof(folder), "%s/folder", base);
    if (os_folder_make(folder, OS_FOLDER_PRIVATE) != 0)
        return 1;
    TEST(names_of_a_file_that_is_there);
    TEST(names_of_a_file_that_is_not);
    TEST(names_by_a_link);
    os_clean_up();
    return testing_end();
}
