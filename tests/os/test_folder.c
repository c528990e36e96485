/* SPDX-License-Identifier: Apache-2.0 */
/* Temporary folders: those of living processes stay, those of dead ones go. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clean_up.h"
#include "file.h"
#include "folder.h"
#include "leftovers.h"
#include "testing.h"
#include "unfilled.h"

static char base[512], own[1024];

static bool is_there(const char *path)
{
    return os_file_facts(path).kind == OS_FILE_FOLDER;
}

/* What a process leaves that is killed: a folder with a mark that nobody holds. */
static void make_dead(const char *name, bool has_mark, char *path, size_t n_bytes)
{
    char mark[1200];
    snprintf(path, n_bytes, "%s/%s", base, name);
    snprintf(mark, sizeof(mark), "%s/%s", path, OS_FOLDER_MARK);
    CHECK(os_folder_make(path, OS_FOLDER_PRIVATE) == 0);
    if (has_mark)
        CHECK(os_file_append(mark, "", 0) == 0);
}

static void only_folders_of_the_dead_go(void)
{
    char prefix[600], dead[700], young[700], other[700];
    snprintf(prefix, sizeof(prefix), "%s/job-", base);
    CHECK(os_folder_make_temporary(prefix, own, sizeof(own)) == 0);
    make_dead("job-abcdef", true, dead, sizeof(dead));
    make_dead("job-ghijkl", false, young, sizeof(young));
    make_dead("work-abcdef", true, other, sizeof(other));
    os_leftovers_remove(prefix);
    CHECK(!is_there(dead));
    CHECK(is_there(own) && is_there(young) && is_there(other));
    os_folder_remove(own);
    CHECK(!is_there(own));
}

static bool count_entry(void *user, const char *name)
{
    int *n = user;
    CHECK(strcmp(name, ".") != 0 && strcmp(name, "..") != 0);
    return ++*n < 2;
}

static void listing_ends_when_told(void)
{
    int n = 0;
    CHECK(os_folder_list(base, count_entry, &n) == 0 && n == 2);
    CHECK(os_folder_list("/no/such/folder", count_entry, &n) == ENOENT);
    CHECK(os_folder_make(base, OS_FOLDER_SHARED) == EEXIST);
}

static void a_link_leads_to_its_target(void)
{
    char link[700];
    snprintf(link, sizeof(link), "%s/link", base);
    CHECK(os_file_link(base, link) == 0 && os_file_link(base, link) == EEXIST);
    char *full = os_file_full_path(link), *target = os_file_full_path(base);
    CHECK(full && target && strcmp(full, target) == 0);
    free(full);
    free(target);
    CHECK(!os_file_full_path("/no/such/folder") && errno == ENOENT);
}

static void folders_that_nothing_came_into_go(void)
{
    const char *names[] = {"there", "empty", "filled", "page", "kept"};
    char paths[5][700], file[800];
    for (int i = 0; i < 5; i++)
        snprintf(paths[i], sizeof(paths[i]), "%s/%s", base, names[i]);
    CHECK(os_folder_make(paths[0], OS_FOLDER_SHARED) == 0);
    CHECK(os_folder_make_to_fill(paths[0], OS_FOLDER_GOES_UNLESS_KEPT) == EEXIST);
    for (int i = 1; i < 5; i++) {
        CHECK(os_folder_make_to_fill(paths[i], i < 3
                                                   ? OS_FOLDER_GOES_IF_EMPTY
                                                   : OS_FOLDER_GOES_UNLESS_KEPT) == 0);
        snprintf(file, sizeof(file), "%s/file", paths[i]);
        CHECK(i == 1 || os_file_append(file, "", 0) == 0);
    }
    os_folder_keep(paths[4]);
    os_unfilled_remove();
    CHECK(is_there(paths[0]) && !is_there(paths[1]) && is_there(paths[2]));
    CHECK(!is_there(paths[3]) && is_there(paths[4]));
    os_folder_remove_empty(paths[2]);
    CHECK(is_there(paths[2]));
}

int main(int argc, char **argv)
{
    char prefix[256];
    testing_begin(argc, argv);
    snprintf(prefix, sizeof(prefix), "%.200s/rf-test-os-", os_folder_for_temporary());
    if (os_folder_make_temporary(prefix, base, sizeof(base)) != 0)
        return 1;
    TEST(only_folders_of_the_dead_go);
    TEST(listing_ends_when_told);
    TEST(a_link_leads_to_its_target);
    TEST(folders_that_nothing_came_into_go);
    os_clean_up();
    CHECK(!is_there(base));
    return testing_end();
}
