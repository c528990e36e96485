/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A test program in C: functions with CHECK lines, a main that runs them, TAP output
 * (meson: protocol: 'tap').
 *
 *     static void adds_up(void)
 *     {
 *         CHECK(1 + 1 == 2);
 *         CHECK_NEAR(0.1 + 0.2, 0.3, 1e-12);
 *         CHECK_STR("a", "a");
 *     }
 *
 *     int main(int argc, char **argv)
 *     {
 *         testing_begin(argc, argv);
 *         TEST(adds_up);
 *         return testing_end();
 *     }
 *
 * A failed CHECK prints where and what, and the function goes on; REQUIRE returns from
 * it (for what would crash afterwards). SKIP("why") ends a test that cannot run here.
 * A word on the command line runs only the tests whose name contains it.
 * Include it from one source file per program: its state is static.
 */
#ifndef RF_TESTING_H
#define RF_TESTING_H

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static struct {
    const char *filter;
    const char *skip_reason;
    int n_run, n_failed_tests;
    int n_checks, n_failed_checks; /* of the running test */
} testing;

static inline void testing_begin(int argc, char **argv)
{
    testing.filter = argc > 1 ? argv[1] : NULL;
    setvbuf(stdout, NULL, _IOLBF, 0);
    printf("TAP version 13\n");
}

static inline bool testing_check(bool is_good, const char *file, int line,
                                 const char *text)
{
    testing.n_checks++;
    if (!is_good) {
        testing.n_failed_checks++;
        printf("# %s:%d: %s\n", file, line, text);
    }
    return is_good;
}

static inline bool testing_check_near(double got, double want, double tolerance,
                                      const char *file, int line, const char *text)
{
    /* Written so that a NaN fails. */
    bool is_good = got == want || fabs(got - want) <= tolerance;
    if (!testing_check(is_good, file, line, text))
        printf("#     got %.17g, want %.17g +- %g\n", got, want, tolerance);
    return is_good;
}

static inline bool testing_check_str(const char *got, const char *want,
                                     const char *file, int line, const char *text)
{
    bool is_good = got && want && strcmp(got, want) == 0;
    if (!testing_check(is_good, file, line, text))
        printf("#     got \"%s\", want \"%s\"\n", got ? got : "(null)",
               want ? want : "(null)");
    return is_good;
}

/* The program's argument: tests whose name has it; after a minus those that do not. */
static inline bool testing_is_wanted(const char *name)
{
    const char *filter = testing.filter;
    if (filter && *filter == '-')
        return !strstr(name, filter + 1);
    return !filter || strstr(name, filter);
}

static inline void testing_run(const char *name, void (*function)(void))
{
    if (!testing_is_wanted(name))
        return;
    testing.n_checks = testing.n_failed_checks = 0;
    testing.skip_reason = NULL;
    function();
    /* A test that checked nothing cannot fail, and so counts as failed. */
    bool is_good =
        testing.n_failed_checks == 0 && (testing.n_checks > 0 || testing.skip_reason);
    testing.n_failed_tests += !is_good;
    printf("%s %d - %s", is_good ? "ok" : "not ok", ++testing.n_run, name);
    if (testing.skip_reason)
        printf(" # SKIP %s", testing.skip_reason);
    printf("\n");
}

static inline int testing_end(void)
{
    printf("1..%d\n", testing.n_run);
    return testing.n_failed_tests > 0 ? 1 : 0;
}

#define CHECK(condition)                                                               \
    ((void)testing_check((condition), __FILE__, __LINE__, "CHECK(" #condition ")"))

#define CHECK_NEAR(got, want, tolerance)                                               \
    ((void)testing_check_near((got), (want), (tolerance), __FILE__, __LINE__,          \
                              "CHECK_NEAR(" #got ", " #want ")"))

#define CHECK_STR(got, want)                                                           \
    ((void)testing_check_str((got), (want), __FILE__, __LINE__,                        \
                             "CHECK_STR(" #got ", " #want ")"))

/* "text contains part", for messages. */
#define CHECK_CONTAINS(text, part)                                                     \
    do {                                                                               \
        const char *text_ = (text);                                                    \
        if (!testing_check(strstr(text_, (part)) != NULL, __FILE__, __LINE__,          \
                           "CHECK_CONTAINS(" #text ", " #part ")"))                    \
            printf("#     got \"%s\"\n", text_);                                       \
    } while (0)

#define REQUIRE(condition)                                                             \
    do {                                                                               \
        if (!testing_check((condition), __FILE__, __LINE__,                            \
                           "REQUIRE(" #condition ")"))                                 \
            return;                                                                    \
    } while (0)

#define SKIP(why)                                                                      \
    do {                                                                               \
        testing.skip_reason = (why);                                                   \
        return;                                                                        \
    } while (0)

#define TEST(function) testing_run(#function, function)

#endif
