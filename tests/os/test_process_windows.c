/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Child processes of Windows: arguments arrive as they are, they end with all that they
 * started. The child is this program itself, told by its first argument what to do.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arguments.h"
#include "clean_up.h"
#include "clock.h"
#include "file.h"
#include "folder.h"
#include "process.h"
#include "testing.h"

static char folder[1024], log_file[1100], program[1200];

static char *said(char *text, size_t n_bytes)
{
    FILE *file = fopen(log_file, "rb");
    const size_t n = file ? fread(text, 1, n_bytes - 1, file) : 0;
    if (file)
        fclose(file);
    text[n] = 0;
    return text;
}

/* ---- the child ------------------------------------------------------------------ */

static int say_arguments(char **arguments)
{
    for (; *arguments; arguments++)
        printf("<%s>\n", *arguments);
    printf("%s %s %d\n", getenv("RF_TEST"), getenv("RF_TWO"),
           os_file_facts("log").kind == OS_FILE_REGULAR);
    return 3;
}

/* Starts another child that appends to a file as long as it lives, and waits. */
static int start_another(char **arguments)
{
    char *words[] = {program, "tick", arguments[0], NULL};
    struct os_process process;
    const struct os_process_request request = {.arguments = words, .log = arguments[1]};
    if (os_process_start(&process, &request) != 0)
        return 1;
    os_process_wait(&process);
    return 0;
}

static int tick(char **arguments)
{
    for (int i = 0; i < 600; i++) {
        os_file_append(arguments[0], "x", 1);
        os_sleep_s(0.1);
    }
    return 0;
}

/* Has a file open as most programs of Windows do, so that nobody can replace it, until
 * another one appears. */
static int hold(char **arguments)
{
    FILE *file = fopen(arguments[0], "rb");
    puts(file ? "open" : "not open");
    fflush(stdout);
    for (int i = 0; i < 1200; i++) {
        if (os_file_facts(arguments[1]).kind == OS_FILE_REGULAR)
            break;
        os_sleep_s(0.1);
    }
    return file ? fclose(file) : 1;
}

/* ---- the tests ------------------------------------------------------------------ */

static void arguments_arrive_as_they_are(void)
{
    char *words[] = {program,  "say",      "a b",   "",     "say \"hi\"",
                     "back\\", "b\\ \\\"", "C:\\x", "\\\\", "Gr\303\266\303\237e",
                     NULL};
    struct os_process process;
    char text[2048], expected[2048] = "";
    const struct os_process_request request = {
        .arguments = words,
        .log = log_file,
        .folder = folder,
        .variables = {{"RF_TEST", "a b"}, {"RF_TWO", "c"}}};
    for (int i = 2; words[i]; i++) {
        strcat(expected, "<");
        strcat(expected, words[i]);
        strcat(expected, ">\n");
    }
    strcat(expected, "a b c 1\n");
    REQUIRE(os_process_start(&process, &request) == 0);
    os_process_wait(&process);
    CHECK(process.has_ended && process.exit_code == 3 && process.id == 0);
    CHECK_STR(said(text, sizeof text), expected);
    CHECK(getenv("RF_TEST") == NULL && getenv("RF_TWO") == NULL);
}

static void what_cannot_be_started_is_said(void)
{
    char *nothing[] = {"no-such-program-there", NULL}, *words[] = {program, NULL};
    struct os_process process;
    const struct os_process_request missing = {.arguments = nothing, .log = log_file};
    CHECK(os_process_start(&process, &missing) == ENOENT && process.id == 0);
    const struct os_process_request nowhere = {.arguments = words,
                                               .log = "Z:/no/such/folder/log"};
    CHECK(os_process_start(&process, &nowhere) == ENOENT && process.id == 0);
}

static int64_t size_of(const char *path)
{
    return os_file_facts(path).n_bytes;
}

static void a_child_is_killed_with_its_children(void)
{
    char ticks[1100], other_log[1100];
    snprintf(ticks, sizeof ticks, "%s/ticks", folder);
    snprintf(other_log, sizeof other_log, "%s/other", folder);
    char *words[] = {program, "start", ticks, other_log, NULL};
    struct os_process process;
    const struct os_process_request request = {.arguments = words, .log = log_file};
    REQUIRE(os_process_start(&process, &request) == 0);
    for (int i = 0; i < 600 && size_of(ticks) < 2; i++)
        os_sleep_s(0.1);
    CHECK(size_of(ticks) >= 2 && !os_process_has_ended(&process));
    os_process_end(&process);
    CHECK(process.has_ended && process.exit_code == -1);
    os_sleep_s(0.3);
    const int64_t size = size_of(ticks);
    os_sleep_s(1);
    CHECK(size_of(ticks) == size);
}

int main(int argc, char **argv)
{
    char prefix[512], own[1024];
    argv = os_arguments(&argc, argv);
    if (!os_program_folder(own, sizeof own))
        return 1;
    snprintf(program, sizeof program, "%stest_process_windows.exe", own);
    if (argc > 1 && strcmp(argv[1], "say") == 0)
        return say_arguments(argv + 2);
    if (argc > 3 && strcmp(argv[1], "start") == 0)
        return start_another(argv + 2);
    if (argc > 2 && strcmp(argv[1], "tick") == 0)
        return tick(argv + 2);
    if (argc > 3 && strcmp(argv[1], "hold") == 0) /* for tests/platforms */
        return hold(argv + 2);
    testing_begin(argc, argv);
    snprintf(prefix, sizeof prefix, "%s/rf-test-os-", os_folder_for_temporary());
    if (os_folder_make_temporary(prefix, folder, sizeof folder) != 0)
        return 1;
    snprintf(log_file, sizeof log_file, "%s/log", folder);
    TEST(arguments_arrive_as_they_are);
    TEST(what_cannot_be_started_is_said);
    TEST(a_child_is_killed_with_its_children);
    os_clean_up();
    return testing_end();
}
