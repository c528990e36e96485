/* SPDX-License-Identifier: Apache-2.0 */
/* Key frames of the focus; frame_table.h reads what is written. */
#include <stdlib.h>

#include "folder.h"
#include "leftovers.h"
#include "model/pull.h"
#include "sequence/frame_table.h"
#include "testing.h"

static void set(struct pull *pull, int32_t frame, double focus, double aperture)
{
    CHECK(pull_set(pull, &(struct pull_key){frame, focus, aperture}));
}

static void keys_are_in_order(void)
{
    static struct pull pull;
    set(&pull, 20, 5, 2);
    set(&pull, 10, 3, 4);
    set(&pull, 15, 9, 9);
    set(&pull, 15, 4, 3); /* in its place */
    CHECK(pull.n == 3 && pull.keys[0].frame == 10 && pull.keys[1].focus == 4);
    CHECK(pull_has(&pull, 15) && !pull_has(&pull, 16));
    CHECK(pull_remove(&pull, 15) && !pull_remove(&pull, 15) && pull.n == 2);
    for (int i = 0; i < PULL_MAX - 2; i++)
        set(&pull, 100 + i, 1, 1);
    CHECK(!pull_set(&pull, &(struct pull_key){50, 1, 1}));
    set(&pull, 100, 2, 2); /* of one that is there */
}

static void values_ease_in_and_out(void)
{
    static struct pull pull;
    struct pull_key key;
    CHECK(!pull_at(&pull, 1, &key));
    set(&pull, 10, 2, 8);
    set(&pull, 20, 4, 4);
    for (int32_t frame = 1; frame <= 10; frame++)
        CHECK(pull_at(&pull, frame, &key) && key.focus == 2 && key.aperture == 8);
    CHECK(pull_at(&pull, 15, &key) && key.focus == 3 && key.aperture == 6);
    CHECK(pull_at(&pull, 12, &key));
    CHECK_NEAR(key.focus, 2 + 2 * 0.2 * 0.2 * 2.6, 1e-12);
    CHECK(pull_at(&pull, 99, &key) && key.focus == 4 && key.aperture == 4);
}

/* `rackfocus filter` reads the same values for every frame. */
static void the_file_says_the_same(void)
{
    static struct pull pull;
    char folder[256], path[512];
    struct frame_table table;
    struct image_error error;
    CHECK(os_folder_make_temporary("rackfocus-test-", folder, sizeof(folder)) == 0);
    snprintf(path, sizeof(path), "%s/keys.csv", folder);
    set(&pull, 3, 1.5, 2.8);
    set(&pull, 9, 7.25, 1.4);
    set(&pull, 30, 2, 11);
    CHECK(pull_write(&pull, path, &error));
    CHECK(frame_table_read(&table, path, &error));
    for (int32_t frame = 1; frame < 35; frame++) {
        struct pull_key key;
        char value[FRAME_VALUE];
        pull_at(&pull, frame, &key);
        for (int k = 0; k < table.n_keys; k++) {
            if (k == table.easing_key)
                continue;
            CHECK(frame_table_value(&table, k, frame, value));
            const bool is_focus = strcmp(table.keys[k], "focus-distance") == 0;
            CHECK(is_focus || strcmp(table.keys[k], "f-stop") == 0);
            CHECK_NEAR(atof(value), is_focus ? key.focus : key.aperture, 1e-5);
        }
    }
    frame_table_free(&table);
    CHECK(!pull_write(&pull, "/nowhere/at/all.csv", &error));
    os_leftovers_remove_own();
}

static void names_have_numbers(void)
{
    CHECK(pull_frame_of("/a/shot.0012.exr", 5) == 12);
    CHECK(pull_frame_of("passes_0007.exr", 5) == 7);
    CHECK(pull_frame_of("b7_left.exr", 5) == 7);
    CHECK(pull_frame_of("/v2/passes.exr", 5) == 5);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(keys_are_in_order);
    TEST(values_ease_in_and_out);
    TEST(the_file_says_the_same);
    TEST(names_have_numbers);
    return testing_end();
}
