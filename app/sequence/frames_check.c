/* SPDX-License-Identifier: Apache-2.0 */
#include "sequence/frames_check.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <zlib.h>

#include "common/report.h"
#include "file.h"
#include "interrupt.h"
#include "sources/picture.h"
#include "sources/settings.h"

const char *frame_verdict_word(enum frame_verdict verdict)
{
    static const char *const words[FRAME_N_VERDICTS] = {"finished", "missing",
                                                        "damaged", "other", "unknown"};
    return words[verdict];
}

bool frames_report_start(struct frames_report *report, const struct frame_list *list,
                         struct image_error *error)
{
    *report = (struct frames_report){
        .frames = app_memory((size_t)list->n, sizeof(*report->frames), error)};
    for (; report->frames && report->n < list->n; report->n++)
        report->frames[report->n] = (struct frame_check){
            .number = list->numbers[report->n], .verdict = FRAME_UNKNOWN};
    return report->frames != NULL;
}

void frames_report_free(struct frames_report *report)
{
    for (int i = 0; i < report->n; i++)
        free(report->frames[i].path);
    free(report->frames);
    *report = (struct frames_report){0};
}

int frames_report_count(const struct frames_report *report, enum frame_verdict verdict)
{
    int n = 0;
    for (int i = 0; i < report->n; i++)
        n += report->frames[i].verdict == verdict;
    return n;
}

char *frames_report_open_list(const struct frames_report *report)
{
    struct frame_list list = {0};
    list.numbers = app_memory((size_t)report->n, sizeof(*list.numbers), NULL);
    for (int i = 0; i < report->n && list.numbers; i++)
        if (report->frames[i].verdict != FRAME_FINISHED)
            list.numbers[list.n++] = report->frames[i].number;
    char *text = list.numbers ? frame_list_text(list.numbers, list.n, NULL) : NULL;
    frame_list_free(&list);
    return text;
}

/* ---- sums ----------------------------------------------------------------------- */

/* Checksum and size of a file; false where it cannot be read. */
static bool sum_file(const char *path, uint32_t *sum, int64_t *size)
{
    enum { N = 1 << 14 };
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    unsigned char bytes[N];
    uLong crc = crc32(0, NULL, 0);
    size_t n;
    *size = 0;
    while ((n = fread(bytes, 1, N, file)) > 0) {
        crc = crc32(crc, bytes, (uInt)n);
        *size += (int64_t)n;
    }
    const bool is_good = !ferror(file);
    fclose(file);
    *sum = (uint32_t)crc;
    return is_good;
}

bool frame_sum_files(const struct frame_files *files, char sums[FRAME_SUMS])
{
    int n = 0;
    sums[0] = '\0';
    for (int i = 0; i < FRAME_MAX_FILES; i++) {
        uint32_t sum;
        int64_t size;
        if (!files->paths[i])
            continue;
        if (!sum_file(files->paths[i], &sum, &size))
            return false;
        n += snprintf(sums + n, (size_t)(FRAME_SUMS - n), "%s%08" PRIx32 ":%" PRId64,
                      n ? " " : "", sum, size);
    }
    return true;
}

void frame_hash_bytes(uint64_t *hash, const void *data, size_t n)
{
    const unsigned char *bytes = data;
    for (size_t i = 0; i < n; i++)
        *hash = (*hash ^ bytes[i]) * 0x100000001b3u;
}

void frame_hash_text(uint64_t *hash, const char *text)
{
    frame_hash_bytes(hash, text ? text : "", text ? strlen(text) + 1 : 1);
}

void frame_hash_file(uint64_t *hash, const char *path)
{
    frame_hash_text(hash, path);
    const struct os_file_facts facts =
        path ? os_file_facts(path) : (struct os_file_facts){.kind = OS_FILE_NONE};
    const int64_t numbers[3] = {facts.n_bytes, facts.changed_s, facts.changed_ns};
    if (facts.kind != OS_FILE_NONE)
        frame_hash_bytes(hash, numbers, sizeof(numbers));
}

void frame_hash_settings(uint64_t *hash, const struct settings *settings)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++)
        frame_hash_bytes(hash, (const char *)&settings->params + list[i].offset,
                         list[i].type == RF_TYPE_FLOAT ? sizeof(double)
                                                       : sizeof(int32_t));
    frame_hash_bytes(hash, settings->origins, sizeof(settings->origins));
}

/* ---- verdicts ------------------------------------------------------------------- */

static bool is_there(const struct frame_files *files)
{
    for (int i = 0; i < FRAME_MAX_FILES; i++)
        if (files->paths[i] && os_file_facts(files->paths[i]).kind == OS_FILE_NONE)
            return false;
    return true;
}

bool frame_is_finished(struct journal *journal, int32_t number, uint64_t hash,
                       const struct frame_files *files)
{
    char sums[FRAME_SUMS] = "";
    int n;
    if (!is_there(files) || !journal_load(journal, NULL))
        return false;
    const struct journal_line *lines = journal_lines(journal, number, &n);
    for (int i = n - 1; i >= 0; i--) {
        if (lines[i].kind != JOURNAL_FINISHED || lines[i].hash != hash)
            continue;
        if (!sums[0] && !frame_sum_files(files, sums))
            return false;
        if (strcmp(lines[i].text, sums) == 0)
            return true;
    }
    return false;
}

static bool can_be_read(const char *path, struct frame_check *check)
{
    struct picture picture;
    struct image_error error;
    if (!picture_read(path, NULL, 1, &picture, &error)) {
        snprintf(check->why, sizeof(check->why), "%.*s", (int)sizeof(check->why) - 1,
                 error.message);
        return false;
    }
    picture_free(&picture);
    return true;
}

/* What the lines say of files that are there; the line that it rests on. */
static const struct journal_line *judge(struct frame_check *check,
                                        const struct journal_line *lines, int n,
                                        const uint64_t *hash, const char *sums)
{
    bool has_lines = false, has_hash = false;
    const struct journal_line *other = NULL;
    for (int i = n - 1; i >= 0; i--) {
        if (lines[i].kind != JOURNAL_FINISHED)
            continue;
        const bool is_hash = !hash || lines[i].hash == *hash;
        const bool is_same = strcmp(lines[i].text, sums) == 0;
        if (is_hash && is_same)
            return &lines[i];
        has_lines = true;
        has_hash |= is_hash;
        if (is_same)
            other = &lines[i];
    }
    check->verdict = other       ? FRAME_OTHER
                     : has_hash  ? FRAME_DAMAGED
                     : has_lines ? FRAME_OTHER
                                 : FRAME_UNKNOWN;
    return other;
}

static void take_notes(struct frame_check *check, const struct journal_line *lines,
                       int n)
{
    for (int i = 0; i < n; i++) {
        const char *text = lines[i].text;
        if (lines[i].kind == JOURNAL_WARNING) {
            check->n_warnings++;
            snprintf(check->warning, sizeof(check->warning), "%s", text);
        } else if (lines[i].kind == JOURNAL_MADE) {
            const char *radii = strstr(text, ", radii ");
            snprintf(check->made, sizeof(check->made), "%s", text);
            check->has_radii =
                radii && sscanf(radii, ", radii %lf to %lf px", &check->least_radius_px,
                                &check->most_radius_px) == 2;
        }
    }
}

/* What is wrong, and what the last attempt failed with. */
static void explain(struct frame_check *check, const struct journal_line *lines, int n)
{
    static const char *const reasons[FRAME_N_VERDICTS] = {
        "", "there is no file", "the file is not as it was written",
        "made of other inputs, with other parameters or by another version",
        "no journal says what it was made of"};
    size_t used = strlen(check->why);
    if (!used)
        snprintf(check->why, sizeof(check->why), "%s", reasons[check->verdict]);
    used = strlen(check->why);
    for (int i = n - 1; i >= 0 && check->verdict != FRAME_FINISHED; i--) {
        if (lines[i].kind != JOURNAL_FAILED)
            continue;
        snprintf(check->why + used, sizeof(check->why) - used, "; %s said: %s",
                 lines[i].host, lines[i].text);
        return;
    }
}

/* Of a frame that no journal knows and that may be made in any way. */
static void judge_by_reading(struct frame_check *check, const struct frame_files *files)
{
    check->verdict =
        can_be_read(files->paths[0], check) ? FRAME_FINISHED : FRAME_DAMAGED;
}

bool frame_check_files(struct frame_check *check, struct journal *journal,
                       const uint64_t *hash, const struct frame_files *files,
                       struct image_error *error)
{
    char sums[FRAME_SUMS];
    int n;
    if (!journal_load(journal, error))
        return false;
    const struct journal_line *lines = journal_lines(journal, check->number, &n);
    const struct journal_line *line = NULL;
    check->verdict = FRAME_FINISHED;
    if (!is_there(files))
        check->verdict = FRAME_MISSING;
    else if (!frame_sum_files(files, sums))
        check->verdict = FRAME_DAMAGED;
    else
        line = judge(check, lines, n, hash, sums);
    if (check->verdict == FRAME_UNKNOWN && !hash)
        judge_by_reading(check, files);
    if (line) {
        snprintf(check->host, sizeof(check->host), "%s", line->host);
        check->process = line->process;
        check->date_s = line->date_s;
        check->seconds = line->seconds;
    }
    take_notes(check, lines, n);
    explain(check, lines, n);
    return true;
}

/* ---- a pattern ------------------------------------------------------------------ */

/* All from the first to the last that is there. */
static bool list_all(struct frame_list *list, const char *pattern,
                     struct image_error *error)
{
    struct frame_list found;
    char range[40];
    if (!frame_list_find(&found, pattern, error))
        return false;
    snprintf(range, sizeof(range), "%d-%d", (int)found.numbers[0],
             (int)found.numbers[found.n - 1]);
    /* A range is written with numbers that are not negative. */
    if (found.numbers[0] < 0) {
        *list = found;
        return true;
    }
    frame_list_free(&found);
    return frame_list_parse(list, range, error);
}

static bool check_list(struct frames_report *report, const char *pattern,
                       const struct frame_list *list, struct image_error *error)
{
    struct journal journal;
    report->frames = app_memory((size_t)list->n, sizeof(*report->frames), error);
    if (!report->frames || !journal_open(&journal, pattern, error))
        return false;
    bool is_good = true;
    for (int i = 0; i < list->n && is_good && !os_is_interrupted(); i++) {
        struct frame_check *check = &report->frames[report->n++];
        check->number = list->numbers[i];
        check->path = frame_name(pattern, check->number, error);
        const struct frame_files files = {{check->path}};
        is_good =
            check->path && frame_check_files(check, &journal, NULL, &files, error);
    }
    journal_close(&journal);
    return is_good;
}

bool frames_check_pattern(struct frames_report *report, const char *pattern,
                          const struct frame_list *list, struct image_error *error)
{
    struct frame_list all = {0};
    *report = (struct frames_report){0};
    if (!list && !list_all(&all, pattern, error))
        return false;
    const bool is_good = check_list(report, pattern, list ? list : &all, error);
    frame_list_free(&all);
    if (!is_good)
        frames_report_free(report);
    return is_good;
}
