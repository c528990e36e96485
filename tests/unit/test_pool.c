/* SPDX-License-Identifier: Apache-2.0 */
/* Memory that is given back serves again, in parts too, and within its bound. */
#include <stdlib.h>

#include "base/context.h"
#include "base/pool.h"
#include "portable.h"
#include "testing.h"

enum { MIB = 1 << 20 };

static struct rf_context *context;
static size_t n_asked, n_held; /* regions asked of the system, bytes it has given */
static size_t most_held;       /* bytes that the system has; 0: no limit */
static size_t sizes[64];
static void *regions[64];

static void *give(void *user, size_t n_bytes)
{
    (void)user;
    bool has_room = n_asked < 64 && (!most_held || n_held + n_bytes <= most_held);
    void *memory = has_room ? aligned_alloc(RF_ALIGNMENT, n_bytes) : NULL;
    if (!memory)
        return NULL;
    regions[n_asked] = memory;
    sizes[n_asked++] = n_bytes;
    n_held += n_bytes;
    return memory;
}

static void take_back(void *user, void *memory)
{
    (void)user;
    for (size_t i = 0; i < n_asked; i++)
        if (regions[i] == memory) {
            n_held -= sizes[i];
            regions[i] = NULL;
        }
    aligned_release(memory);
}

static void begin(size_t max_bytes)
{
    struct rf_context_params params = {.size = sizeof params,
                                       .n_threads = 1,
                                       .allocate = give,
                                       .release = take_back,
                                       .max_bytes = max_bytes};
    n_asked = 0;
    most_held = 0;
    REQUIRE(rf_context_create(&context, &params, NULL) == RF_OK);
    n_asked = 0;
    n_held = 0;
}

/* All blocks have been given back. */
static void end(void)
{
    rf_context_destroy(context);
    CHECK(n_held == 0);
}

static char *some(size_t n_mib, int value)
{
    char *memory = rf_alloc(context, n_mib, MIB);
    if (memory)
        memset(memory, value, n_mib * MIB);
    return memory;
}

static bool holds(const char *memory, size_t n_mib, int value)
{
    for (size_t i = 0; i < n_mib * MIB; i++)
        if (memory[i] != value)
            return false;
    return true;
}

static void parts_of_a_block_serve_again(void)
{
    begin(0);
    rf_free(context, some(16, 1));
    char *a = some(7, 2), *b = some(4, 3), *c = some(4, 4);
    CHECK(n_asked == 1);
    CHECK(holds(a, 7, 2) && holds(b, 4, 3) && holds(c, 4, 4));
    /* They join again, whichever goes first. */
    rf_free(context, b);
    rf_free(context, a);
    rf_free(context, c);
    rf_free(context, some(16, 5));
    CHECK(n_asked == 1);
    end();
}

static void the_smallest_that_holds_it_is_taken(void)
{
    begin(0);
    char *a = some(16, 1), *b = some(5, 2);
    rf_free(context, a);
    rf_free(context, b);
    char *c = some(4, 3), *d = some(15, 4);
    CHECK(c == b && d == a);
    CHECK(n_asked == 2);
    rf_free(context, c);
    rf_free(context, d);
    end();
}

/* What may stay for long does not cut what is large. */
static void small_blocks_leave_large_ones_whole(void)
{
    begin(0);
    rf_free(context, some(16, 1));
    void *small = rf_alloc(context, 1, 100 << 10);
    CHECK(n_asked == 2);
    char *large = some(16, 2);
    CHECK(n_asked == 2);
    rf_free(context, small);
    rf_free(context, large);
    end();
}

static void no_more_is_held_than_the_bound(void)
{
    begin(40 * MIB);
    char *a = some(20, 1), *b = some(10, 2);
    CHECK(a && b && !some(11, 3));
    CHECK(holds(a, 20, 1) && holds(b, 10, 2));
    rf_free(context, a);
    char *c = some(25, 4);
    CHECK(c != NULL);
    CHECK(n_held < 40 * MIB);
    rf_free(context, b);
    rf_free(context, c);
    end();
}

/* What is kept is not more than half of what was needed at once. */
static void the_rest_goes_back(void)
{
    begin(0);
    char *a = some(20, 1), *b = some(20, 2);
    rf_free(context, a);
    rf_free(context, b);
    a = some(25, 3);
    CHECK(a != NULL);
    b = some(30, 4);
    CHECK(b != NULL);
    CHECK(n_held < 83 * MIB);
    rf_free(context, a);
    rf_free(context, b);
    end();
}

/* Where the system has no more, blocks that are kept make room. */
static void what_is_kept_makes_room(void)
{
    begin(0);
    most_held = n_held + 50 * MIB;
    char *a = some(10, 1), *b = some(10, 2), *c = some(20, 3);
    CHECK(a && b && c);
    rf_free(context, b);
    rf_free(context, c);
    char *d = some(35, 4);
    CHECK(d != NULL);
    CHECK(holds(a, 10, 1));
    CHECK(!some(10, 5)); /* 45 are in use */
    rf_free(context, d);
    most_held = n_held;
    void *small = rf_alloc(context, 1, 100);
    CHECK(small != NULL && n_held < 11 * MIB);
    rf_free(context, small);
    rf_free(context, some(30, 6));
    rf_free(context, a);
    end();
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(parts_of_a_block_serve_again);
    TEST(the_smallest_that_holds_it_is_taken);
    TEST(small_blocks_leave_large_ones_whole);
    TEST(no_more_is_held_than_the_bound);
    TEST(the_rest_goes_back);
    TEST(what_is_kept_makes_room);
    return testing_end();
}
