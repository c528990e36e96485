/* SPDX-License-Identifier: Apache-2.0 */
/* Steps back and forth. */
#include "model/undo.h"
#include "testing.h"

static int value_of(const void *item)
{
    return item ? *(const int *)item : -1;
}

static struct undo begin(int first)
{
    struct undo undo = {0};
    CHECK(undo_start(&undo, &first, sizeof(first)));
    return undo;
}

static void note(struct undo *undo, int value)
{
    undo_note(undo, &value);
}

static void back_and_forth(void)
{
    struct undo undo = begin(1);
    CHECK(value_of(undo_back(&undo)) == -1 && value_of(undo_forth(&undo)) == -1);
    note(&undo, 2);
    note(&undo, 3);
    CHECK(value_of(undo_back(&undo)) == 2);
    CHECK(value_of(undo_back(&undo)) == 1);
    CHECK(value_of(undo_back(&undo)) == -1);
    CHECK(value_of(undo_forth(&undo)) == 2);
    CHECK(value_of(undo_forth(&undo)) == 3);
    CHECK(value_of(undo_forth(&undo)) == -1);
    undo_free(&undo);
}

static void no_change_is_no_step(void)
{
    struct undo undo = begin(1);
    note(&undo, 2);
    note(&undo, 2);
    CHECK(value_of(undo_back(&undo)) == 1);
    note(&undo, 1); /* what was undone is still there to be redone */
    CHECK(value_of(undo_forth(&undo)) == 2);
    undo_free(&undo);
}

static void a_change_forgets_what_was_undone(void)
{
    struct undo undo = begin(1);
    note(&undo, 2);
    note(&undo, 3);
    undo_back(&undo);
    undo_back(&undo);
    note(&undo, 4);
    CHECK(value_of(undo_forth(&undo)) == -1);
    CHECK(value_of(undo_back(&undo)) == 1);
    undo_free(&undo);
}

static void the_oldest_are_forgotten(void)
{
    struct undo undo = begin(0);
    for (int i = 1; i <= 3 * UNDO_MAX; i++)
        note(&undo, i);
    int last = -1, n = 0;
    for (const void *item = undo_back(&undo); item; item = undo_back(&undo), n++)
        last = value_of(item);
    CHECK(n == UNDO_MAX - 1 && last == 2 * UNDO_MAX + 1);
    undo_free(&undo);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(back_and_forth);
    TEST(no_change_is_no_step);
    TEST(a_change_forgets_what_was_undone);
    TEST(the_oldest_are_forgotten);
    return testing_end();
}
