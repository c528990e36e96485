/* SPDX-License-Identifier: Apache-2.0 */
/* Folders of passes: frames to step through, views that belong together. */
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "testing.h"
#include "filtering/stage.h"

static char folder[64];

static void make_folder(const char *const *names)
{
    snprintf(folder, sizeof(folder), "/tmp/rf-playlist-XXXXXX");
    if (!mkdtemp(folder))
        abort();
    for (; *names; names++) {
        char path[128];
        snprintf(path, sizeof(path), "%s/%s", folder, *names);
        FILE *file = fopen(path, "w");
        if (file)
            fclose(file);
    }
}

static void remove_folder(const char *const *names)
{
    for (; *names; names++) {
        char path[128];
        snprintf(path, sizeof(path), "%s/%s", folder, *names);
        unlink(path);
    }
    rmdir(folder);
}

static void frames_and_views(void)
{
    static const char *const names[] = {
        "passes0002.exr", "passes0001.exr",     "passes_v00.exr",
        "passes_v01.exr", "passes0003_v01.exr", "passes0003_v00.exr",
        "lens.exr",       "notes.txt",          NULL};
    struct playlist list;
    struct image_error error;
    make_folder(names);
    char *paths[] = {folder};
    REQUIRE(playlist_open(&list, paths, 1, &error));
    CHECK(list.n == 4);
    CHECK(list.pictures[0].n_paths == 1 &&
          strstr(list.pictures[0].paths[0], "/passes0001.exr"));
    CHECK(list.pictures[1].n_paths == 1 &&
          strstr(list.pictures[1].paths[0], "/passes0002.exr"));
    CHECK(list.pictures[2].n_paths == 2 &&
          strstr(list.pictures[2].paths[0], "/passes0003_v00.exr"));
    CHECK(list.pictures[3].n_paths == 2 &&
          strstr(list.pictures[3].paths[1], "/passes_v01.exr"));
    playlist_close(&list);
    remove_folder(names);
}

static void other_names(void)
{
    static const char *const names[] = {"a.exr", "b.EXR", "c.png", NULL};
    struct playlist list;
    struct image_error error;
    make_folder(names);
    char *paths[] = {folder};
    REQUIRE(playlist_open(&list, paths, 1, &error));
    CHECK(list.n == 2);
    playlist_close(&list);
    remove_folder(names);
}

/* What the folder that holds `names` is told of. */
static void check_remark(const char *const *names, const char *remark)
{
    struct playlist list;
    struct image_error error;
    make_folder(names);
    char *paths[] = {folder};
    REQUIRE(playlist_open(&list, paths, 1, &error));
    CHECK(strcmp(list.remark, remark) == 0);
    playlist_close(&list);
    remove_folder(names);
}

static void missing_frames(void)
{
    static const char *const holes[] = {"s.0001.exr", "s.0002.exr", "s.0003.exr",
                                        "s.0005.exr", "s.0008.exr", NULL};
    static const char *const steps[] = {"s.0001.exr", "s.0003.exr", "s.0005.exr", NULL};
    static const char *const mixed[] = {"a.exr", "s.0001.exr", "s.0002.exr",
                                        "s.0004.exr", NULL};
    static const char *const few[] = {"s.0001.exr", "s.0002.exr", "s.0090.exr", NULL};
    check_remark(holes, "of frames 1 to 8 there is no 4,6-7");
    check_remark(steps, "");
    check_remark(mixed, "");
    check_remark(few, "");
}

static void nothing_there(void)
{
    static const char *const names[] = {"c.png", NULL};
    struct playlist list;
    struct image_error error;
    make_folder(names);
    char *paths[] = {folder};
    CHECK(!playlist_open(&list, paths, 1, &error));
    CHECK(strstr(error.message, folder) && strstr(error.message, "--keep"));
    remove_folder(names);
    CHECK(!playlist_open(&list, paths, 1, &error));
    CHECK(strstr(error.message, "No such file"));
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(frames_and_views);
    TEST(other_names);
    TEST(missing_frames);
    TEST(nothing_there);
    return testing_end();
}
