/* SPDX-License-Identifier: Apache-2.0 */
/* What is remembered from the last time, and the list of files to open. */
#include <stdlib.h>

#include "file.h"
#include "folder.h"
#include "leftovers.h"
#include "model/browser.h"
#include "model/remembered.h"
#include "testing.h"

static char folder[256], path[4096];

static void make_file(const char *name)
{
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    CHECK(file != NULL);
    if (file)
        fclose(file);
}

static void files_come_back_the_last_one_first(void)
{
    static struct remembered r, again;
    memset(&r, 0, sizeof(r));
    for (int i = 0; i < REMEMBERED_FILES + 5; i++) {
        char name[32];
        snprintf(name, sizeof(name), "/a/file %d.exr", i);
        remembered_add(&r, name);
    }
    CHECK(r.n_files == REMEMBERED_FILES);
    remembered_add(&r, r.files[3]); /* no copy, to the front */
    CHECK(r.n_files == REMEMBERED_FILES);
    CHECK_STR(r.files[0], "/a/file 13.exr");
    CHECK_STR(r.files[1], "/a/file 16.exr");
    CHECK_STR(r.files[REMEMBERED_FILES - 1], "/a/file 5.exr");
    remembered_add(&r, "bad\nname");
    CHECK_STR(r.files[0], "/a/file 13.exr");
    r.has_window = true;
    r.x = -5;
    r.y = 7;
    r.width = 900;
    r.height = 700;
    snprintf(path, sizeof(path), "%s/view.txt", folder);
    CHECK(remembered_write(&r, path));
    remembered_read(&again, path);
    CHECK(again.has_window && again.x == -5 && again.y == 7);
    CHECK(again.width == 900 && again.height == 700 && again.n_files == r.n_files);
    for (int i = 0; i < r.n_files; i++)
        CHECK_STR(again.files[i], r.files[i]);
}

static void what_is_broken_is_as_good_as_none(void)
{
    static struct remembered r;
    snprintf(path, sizeof(path), "%s/broken.txt", folder);
    FILE *file = fopen(path, "w");
    fputs("window 1 2 -3 99999999\nwindow x\nfile \nnonsense\nfile /b.exr\n", file);
    fclose(file);
    remembered_read(&r, path);
    CHECK(!r.has_window && r.n_files == 1);
    CHECK_STR(r.files[0], "/b.exr");
    remembered_read(&r, "/nowhere/at/all");
    CHECK(!r.has_window && r.n_files == 0);
}

static void the_folder_for_state_is_found(void)
{
    char *full = os_file_full_path(folder);
    setenv("XDG_STATE_HOME", full ? full : "", 1);
    setenv("HOME", full ? full : "", 1); /* is not written to */
    CHECK(full != NULL && remembered_path(path, sizeof(path)));
    CHECK(full && strncmp(path, full, strlen(full)) == 0);
    CHECK(!strstr(path, ".local") && strstr(path, "rackfocus"));
    static const struct remembered nothing;
    CHECK(remembered_write(&nothing, path)); /* the folder was made */
    /* XDG's Base Directory Specification: a path that is not full does not count. */
    setenv("XDG_STATE_HOME", folder, 1);
    unsetenv("LOCALAPPDATA");
    CHECK(remembered_path(path, sizeof(path)) && strstr(path, "/.local/state/"));
    free(full);
}

static void a_folder_is_listed_and_entered(void)
{
    static struct remembered recent;
    struct browser b = {0};
    make_file("b.exr");
    make_file("A.EXR");
    make_file("notes.md");
    make_file(".hidden.exr");
    snprintf(path, sizeof(path), "%s/inner", folder);
    os_folder_make(path, OS_FOLDER_PRIVATE);
    make_file("inner/c.png");
    snprintf(path, sizeof(path), "%s/b.exr", folder);
    remembered_add(&recent, "/gone.exr");
    remembered_add(&recent, path);
    browser_open(&b, folder, &recent);
    CHECK(b.items[0].kind == BROWSER_RECENT && strcmp(b.items[0].name, path) == 0);
    CHECK(b.items[1].kind == BROWSER_FOLDER);
    CHECK(b.items[b.n - 1].kind == BROWSER_FILE);
    CHECK_STR(b.items[b.n - 1].name, "b.exr");
    for (int i = 0; i < b.n; i++)
        CHECK(!strstr(b.items[i].name, "notes") && !strstr(b.items[i].name, "hidden"));
    while (strcmp(b.items[b.at].name, "inner") != 0 && b.at < b.n - 1)
        browser_move(&b, 1);
    CHECK(!browser_choose(&b, path, sizeof(path)));
    CHECK(b.n == 1 && strcmp(b.items[0].name, "c.png") == 0);
    CHECK(browser_choose(&b, path, sizeof(path)) && strstr(path, "inner/c.png"));
    browser_move(&b, -9);
    browser_move(&b, 9);
    CHECK(b.at == 0);
    browser_up(&b);
    CHECK(b.n > 1);
    browser_type(&b, "B", true);
    browser_type(&b, ".", false);
    CHECK_STR(b.items[b.at].name, "b.exr");
    CHECK(!b.is_unknown);
    browser_type(&b, "inn", true);
    CHECK_STR(b.items[b.at].name, "inner");
    browser_type(&b, "x", false);
    CHECK(b.is_unknown && strcmp(b.items[b.at].name, "inner") == 0);
    browser_move(&b, 0);
    CHECK(!b.is_unknown && !b.typed[0]);
    browser_open(&b, "/nowhere/at/all", NULL);
    CHECK(b.n == 0 && b.problem[0] && !browser_choose(&b, path, sizeof(path)));
    browser_free(&b);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    if (os_folder_make_temporary("rackfocus-test-", folder, sizeof(folder)) != 0)
        return 1;
    TEST(files_come_back_the_last_one_first);
    TEST(what_is_broken_is_as_good_as_none);
    TEST(the_folder_for_state_is_found);
    TEST(a_folder_is_listed_and_entered);
    os_leftovers_remove_own();
    return testing_end();
}
