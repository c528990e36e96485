/* SPDX-License-Identifier: Apache-2.0 */
/* Threads take parts of chunks; no part reaches into another, and all go back. */
#include "base/arena.h"
#include "base/context.h"
#include "base/pool.h"
#include "kernels/kernels.h"
#include "testing.h"

enum { N_THREADS = 2, N_PARTS = 400 };

static struct rf_context *context;

static void begin(size_t max_bytes)
{
    struct rf_context_params params = {
        .size = sizeof params, .n_threads = 1, .max_bytes = max_bytes};
    REQUIRE(rf_context_create(&context, &params, NULL) == RF_OK);
}

static bool holds(const unsigned char *at, size_t n, int value)
{
    for (size_t i = 0; i < n; i++)
        if (at[i] != value)
            return false;
    return true;
}

/* What is asked for and given back again is what the next one gets. */
static void parts_keep_what_they_hold(void)
{
    begin(0);
    struct rf_arena arena = rf_arena_make(context, 300, 200);
    struct rf_room rooms[N_THREADS] = {{NULL, NULL}};
    unsigned char *parts[N_PARTS];
    size_t sizes[N_PARTS];
    for (int i = 0; i < N_PARTS; i++) {
        struct rf_room *room = &rooms[i % 3 % N_THREADS];
        sizes[i] = 1 + (size_t)i * 37 % 5000;
        parts[i] = rf_arena_take(&arena, room, 5000);
        REQUIRE(parts[i] && (uintptr_t)parts[i] % 16 == 0);
        REQUIRE(parts[i] + 5000 <= (unsigned char *)room->end);
        rf_arena_give_back(room, parts[i] + sizes[i]);
        size_t left = (size_t)((unsigned char *)room->at - parts[i]);
        CHECK(left >= sizes[i] && left < sizes[i] + 16);
        memset(parts[i], i % 256, sizes[i]);
    }
    for (int i = 0; i < N_PARTS; i++)
        CHECK(holds(parts[i], sizes[i], i % 256));
    CHECK(rf_arena_take(&arena, &rooms[0], 3 * arena.chunk_bytes));
    rf_arena_free(&arena);
    CHECK(context->pool->used_bytes == 0);
    rf_context_destroy(context);
}

static void want_of_memory_is_told(void)
{
    begin(1 << 20);
    struct rf_arena arena = rf_arena_make(context, 300, 200);
    struct rf_room room = {NULL, NULL};
    char *part = rf_arena_take(&arena, &room, 100);
    REQUIRE(part);
    memset(part, 7, 100);
    CHECK(!rf_arena_take(&arena, &room, 1 << 20));
    CHECK(holds((unsigned char *)part, 100, 7));
    CHECK(rf_arena_take(&arena, &room, 100));
    rf_arena_free(&arena);
    rf_context_destroy(context);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(parts_keep_what_they_hold);
    TEST(want_of_memory_is_told);
    return testing_end();
}
