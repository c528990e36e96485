/* SPDX-License-Identifier: Apache-2.0 */
/* Child processes: where they work, what they know, how they end. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clean_up.h"
#include "clock.h"
#include "file.h"
#include "folder.h"
#include "process.h"
#include "testing.h"

static char folder[1024], log_file[1100];

static char *said(char *text, size_t n_bytes)
{
    FILE *file = fopen(log_file, "rb");
    const size_t n = file ? fread(text, 1, n_bytes - 1, file) : 0;
    if (file)
        fclose(file);
    text[n] = 0;
    return text;
}

static void a_child_works_where_it_is_told(void)
{
    char *arguments[] = {"sh", "-c", "pwd; echo \"$RF_TEST $RF_TWO\"; cat; exit 3",
                         NULL};
    struct os_process process;
    char text[2048], expected[2048];
    const struct os_process_request request = {
        .arguments = arguments,
        .log = log_file,
        .folder = folder,
        .variables = {{"RF_TEST", "a b"}, {"RF_TWO", "c"}}};
    CHECK(os_process_start(&process, &request) == 0);
    os_process_wait(&process);
    CHECK(process.has_ended && process.exit_code == 3 && process.id == 0);
    char *full = os_file_full_path(folder);
    snprintf(expected, sizeof(expected), "%s\na b c\n", full);
    CHECK(strcmp(said(text, sizeof(text)), expected) == 0);
    free(full);
}

static void what_cannot_be_started_is_said(void)
{
    char *nothing[] = {"no-such-program-there", NULL}, *shell[] = {"sh", NULL};
    struct os_process process;
    const struct os_process_request missing = {.arguments = nothing, .log = log_file};
    CHECK(os_process_start(&process, &missing) == ENOENT && process.id == 0);
    const struct os_process_request nowhere = {
        .arguments = shell, .log = log_file, .folder = "/no/such/folder"};
    CHECK(os_process_start(&process, &nowhere) == ENOENT && process.id == 0);
}

static void processes_and_the_machine_have_names(void)
{
    char name[40], cut[3];
    char *arguments[] = {"sh", "-c", "exit 0", NULL};
    struct os_process process;
    os_machine_name(name, sizeof(name));
    os_machine_name(cut, sizeof(cut));
    CHECK(strlen(cut) <= 2 && strncmp(name, cut, strlen(cut)) == 0);
    CHECK(strpbrk(name, "/\\ :") == NULL);
    CHECK(os_process_number() > 0 && os_process_exists(os_process_number()));
    const struct os_process_request request = {.arguments = arguments, .log = log_file};
    CHECK(os_process_start(&process, &request) == 0);
    const int64_t number = process.id;
    CHECK(os_process_exists(number));
    os_process_wait(&process);
    CHECK(!os_process_exists(number) && !os_process_exists(0));
    CHECK(os_clock_date_s() > 1.7e9 && os_clock_date_s() < 1e11);
}

static void a_child_is_killed_with_its_children(void)
{
    char *arguments[] = {"sh", "-c", "sleep 60 & echo $!; wait", NULL};
    struct os_process process;
    const struct os_process_request request = {.arguments = arguments, .log = log_file};
    char text[64] = "", name[80];
    CHECK(os_process_start(&process, &request) == 0);
    for (int i = 0; i < 500 && !strchr(said(text, sizeof(text)), '\n'); i++)
        os_sleep_s(0.01);
    CHECK(!os_process_has_ended(&process));
    os_process_end(&process);
    CHECK(process.has_ended && process.exit_code == -1);
    snprintf(name, sizeof(name), "/proc/%d/exe", atoi(text));
    for (int i = 0; i < 500 && os_file_facts(name).kind != OS_FILE_NONE; i++)
        os_sleep_s(0.01);
    CHECK(atoi(text) > 0 && os_file_facts(name).kind == OS_FILE_NONE);
}

int main(int argc, char **argv)
{
    char prefix[512];
    testing_begin(argc, argv);
    snprintf(prefix, sizeof(prefix), "%s/rf-test-os-", os_folder_for_temporary());
    if (os_folder_make_temporary(prefix, folder, sizeof(folder)) != 0)
        return 1;
    snprintf(log_file, sizeof(log_file), "%s/log", folder);
    TEST(a_child_works_where_it_is_told);
    remove(log_file);
    TEST(what_cannot_be_started_is_said);
    remove(log_file);
    TEST(processes_and_the_machine_have_names);
    TEST(a_child_is_killed_with_its_children);
    os_clean_up();
    return testing_end();
}
