/* SPDX-License-Identifier: Apache-2.0 */
#include "sequence.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <zlib.h>

#include "clock.h"
#include "file.h"
#include "filter_many.h"
#include "frame_list.h"
#include "interrupt.h"
#include "rackfocus/rackfocus.h"
#include "report.h"
#include "thread.h"

enum state { WAITING, MADE, SKIPPED, FAILED, CANCELLED };

struct frame {
    int32_t number;
    enum state state;
    int code;
    struct image_error error; /* of a failed one */
};

struct sequence {
    const struct sequence_options *how;
    const struct filter_options *tool; /* with patterns */
    const struct settings *settings;
    struct app_host host; /* of the frames: their progress is not shown */
    struct image_error *error;
    char *const *paths;
    int n_paths, n_jobs;
    struct frame *frames;
    int n_frames;
    struct frame_table table;
    char *journal_path;
    char *journal; /* what it held at the start; "" where there was none */
    struct os_lock lock;
    int next;
    bool is_stopped;
};

bool sequence_is_pattern(const char *name)
{
    return frame_is_pattern(name) && os_file_facts(name).kind == OS_FILE_NONE;
}

/* ---- what a frame is made of and with ------------------------------------------- */

/* FNV-1a. */
static void hash_bytes(uint64_t *hash, const void *data, size_t n)
{
    const unsigned char *bytes = data;
    for (size_t i = 0; i < n; i++)
        *hash = (*hash ^ bytes[i]) * 0x100000001b3u;
}

static void hash_text(uint64_t *hash, const char *text)
{
    hash_bytes(hash, text ? text : "", text ? strlen(text) + 1 : 1);
}

/* A file by name, size and time. */
static void hash_file(uint64_t *hash, const char *path)
{
    hash_text(hash, path);
    const struct os_file_facts facts =
        path ? os_file_facts(path) : (struct os_file_facts){.kind = OS_FILE_NONE};
    const int64_t numbers[3] = {facts.n_bytes, facts.changed_s, facts.changed_ns};
    if (facts.kind != OS_FILE_NONE)
        hash_bytes(hash, numbers, sizeof(numbers));
}

/* The names and settings of one frame, out of those of the sequence. */
struct job {
    struct filter_options tool;
    struct settings settings;
    char *paths[RF_MAX_VIEWS];
    int n_paths;
    uint64_t hash;
};

static bool set_row(const struct sequence *sequence, struct job *job,
                    struct frame *frame)
{
    const struct frame_table *table = &sequence->table;
    if (table->n_keys == 0)
        return true;
    const int row = frame_table_row(table, frame->number);
    if (row < 0)
        return set_error(&frame->error, "%s has no row for it",
                         sequence->how->parameters);
    for (int i = 0; i < table->n_keys; i++) {
        const char *value = table->values[row * table->n_keys + i];
        struct rf_error error;
        if (settings_set(&job->settings, table->keys[i], value, &error) != RF_OK)
            return set_error(&frame->error, "%s: %s", sequence->how->parameters,
                             error.message);
    }
    return true;
}

static void hash_params(uint64_t *hash, const struct rf_params *params)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++)
        hash_bytes(hash, (const char *)params + list[i].offset,
                   list[i].type == RF_TYPE_FLOAT ? sizeof(double) : sizeof(int32_t));
}

/* How each kind of FILTER_OPTIONS counts. */
#define HASH_OUTPUT(name) hash_text(&hash, tool->name)
#define HASH_INPUT(name) hash_file(&hash, tool->name)
#define HASH_TEXT(name) hash_text(&hash, tool->name)
#define HASH_NUMBER(name) hash_bytes(&hash, &tool->name, sizeof(tool->name))
#define HASH_ASIDE(name)
#define HASH_OPTION(kind, type, name) HASH_##kind(name);

static void hash_job(const struct sequence *sequence, struct job *job)
{
    uint64_t hash = 0xcbf29ce484222325u;
    const struct filter_options *tool = &job->tool;
    hash_text(&hash, rf_version());
    hash_params(&hash, &job->settings.params);
    hash_bytes(&hash, job->settings.origins, sizeof(job->settings.origins));
    FILTER_OPTIONS(HASH_OPTION)
    for (int i = 0; i < sequence->n_paths; i++)
        hash_file(&hash, job->paths[i]);
    job->hash = hash;
}

/* Puts the number into a copy of the name; false without memory. */
static bool expand(const char **name, struct frame *frame)
{
    const char *pattern = *name;
    if (pattern)
        *name = frame_name(pattern, frame->number, &frame->error);
    return !pattern || *name;
}

#define EXPAND_OUTPUT(name) is_good = expand(&job->tool.name, frame) && is_good
#define EXPAND_INPUT(name) EXPAND_OUTPUT(name)
#define EXPAND_TEXT(name)
#define EXPAND_NUMBER(name)
#define EXPAND_ASIDE(name)
#define EXPAND_OPTION(kind, type, name) EXPAND_##kind(name);

static bool job_make(const struct sequence *sequence, struct job *job,
                     struct frame *frame)
{
    bool is_good = true;
    job->tool = *sequence->tool;
    job->settings = *sequence->settings;
    job->tool.host = &sequence->host;
    FILTER_OPTIONS(EXPAND_OPTION)
    for (int i = 0; i < sequence->n_paths; i++) {
        job->paths[i] = frame_name(sequence->paths[i], frame->number, &frame->error);
        is_good = is_good && job->paths[i];
    }
    job->n_paths = sequence->n_paths;
    if (!is_good || !set_row(sequence, job, frame))
        return false;
    hash_job(sequence, job);
    return true;
}

#define FREE_OUTPUT(name) free((char *)job->tool.name)
#define FREE_INPUT(name) FREE_OUTPUT(name)
#define FREE_TEXT(name)
#define FREE_NUMBER(name)
#define FREE_ASIDE(name)
#define FREE_OPTION(kind, type, name) FREE_##kind(name);

static void job_free(struct job *job)
{
    FILTER_OPTIONS(FREE_OPTION)
    for (int i = 0; i < job->n_paths; i++)
        free(job->paths[i]);
}

/* ---- the journal ---------------------------------------------------------------- */

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

/* The line that a finished frame has; false where one of its files is missing. */
static bool journal_line(const struct job *job, int32_t number, char *line,
                         size_t n_bytes)
{
    const char *files[3] = {job->tool.output, job->tool.output_coc,
                            job->tool.flattened};
    int n = snprintf(line, n_bytes, "\n%d %016" PRIx64, (int)number, job->hash);
    for (int i = 0; i < 3; i++) {
        uint32_t sum;
        int64_t size;
        if (!files[i])
            continue;
        if (!sum_file(files[i], &sum, &size))
            return false;
        n += snprintf(line + n, n_bytes - (size_t)n, " %08" PRIx32 ":%" PRId64, sum,
                      size);
    }
    snprintf(line + n, n_bytes - (size_t)n, "\n");
    return true;
}

static bool is_finished(const struct sequence *sequence, const struct job *job,
                        int32_t number)
{
    char line[200], start[40];
    snprintf(start, sizeof(start), "\n%d %016" PRIx64 " ", (int)number, job->hash);
    /* The sums cost reading the files: only where the rest is right. */
    return !sequence->how->is_anew && strstr(sequence->journal, start) &&
           journal_line(job, number, line, sizeof(line)) &&
           strstr(sequence->journal, line);
}

static void journal_add(const struct sequence *sequence, const struct job *job,
                        int32_t number)
{
    char line[200];
    if (!journal_line(job, number, line, sizeof(line)))
        return;
    struct image_error ignored;
    /* Without it the frame is only made again the next time. */
    const int reason = os_file_append(sequence->journal_path, line, strlen(line));
    if (reason != 0)
        app_warn(&sequence->host, &ignored, "%s: %s; frame %d will not be skipped",
                 sequence->journal_path, strerror(reason), (int)number);
}

static bool journal_read(struct sequence *sequence)
{
    const char *pattern = sequence->tool->output;
    const size_t n_path = strlen(pattern) + sizeof(".frames");
    sequence->journal_path = app_memory(n_path, 1, sequence->error);
    if (!sequence->journal_path)
        return false;
    snprintf(sequence->journal_path, n_path, "%s.frames", pattern);
    FILE *file = fopen(sequence->journal_path, "rb");
    const size_t room =
        file ? (size_t)os_file_facts(sequence->journal_path).n_bytes : 0;
    sequence->journal = app_memory(room + 1, 1, sequence->error);
    if (file && sequence->journal)
        sequence->journal[fread(sequence->journal, 1, room, file)] = '\0';
    if (file)
        fclose(file);
    return sequence->journal != NULL;
}

/* ---- frames --------------------------------------------------------------------- */

static void say_failed(const struct sequence *sequence, const struct frame *frame,
                       const char *before)
{
    const struct app_host *host = sequence->tool->host;
    char text[sizeof(frame->error.message) + 64];
    snprintf(text, sizeof(text), "%sframe %d: %s", before, (int)frame->number,
             frame->error.message);
    if (host && host->fail)
        host->fail(host->user, text);
}

static void make_files(struct sequence *sequence, struct frame *frame, struct job *job)
{
    const double started_s = os_clock_s();
    frame->code =
        filter_any(&job->tool, &job->settings, job->paths, job->n_paths, &frame->error);
    if (frame->code == APP_DONE) {
        frame->state = MADE;
        journal_add(sequence, job, frame->number);
        app_say(sequence->tool->host, "frame %d: %s, %.1f s", (int)frame->number,
                job->tool.output, os_clock_s() - started_s);
    } else if (os_is_interrupted()) {
        frame->state = CANCELLED;
    }
}

static void make_frame(struct sequence *sequence, struct frame *frame)
{
    struct job *job = app_memory(1, sizeof(*job), &frame->error);
    frame->state = FAILED;
    frame->code = APP_FAILED;
    if (job && job_make(sequence, job, frame)) {
        if (is_finished(sequence, job, frame->number)) {
            frame->state = SKIPPED;
            app_say(sequence->tool->host, "frame %d: %s is there", (int)frame->number,
                    job->tool.output);
        } else {
            make_files(sequence, frame, job);
        }
    }
    if (frame->state == FAILED)
        say_failed(sequence, frame, "");
    if (job)
        job_free(job);
    free(job);
}

/* Takes frames until there are none, or one says that the command line is wrong. */
static void work(void *user)
{
    struct sequence *sequence = user;
    for (;;) {
        os_lock_take(&sequence->lock);
        struct frame *frame = NULL;
        if (!sequence->is_stopped && !os_is_interrupted() &&
            sequence->next < sequence->n_frames)
            frame = &sequence->frames[sequence->next++];
        os_lock_release(&sequence->lock);
        if (!frame)
            return;
        make_frame(sequence, frame);
        if (frame->code == APP_USAGE) {
            os_lock_take(&sequence->lock);
            sequence->is_stopped = true;
            os_lock_release(&sequence->lock);
        }
    }
}

static void run_all(struct sequence *sequence)
{
    struct os_thread threads[16];
    int n = 0;
    while (n < sequence->n_jobs - 1 && n < sequence->n_frames - 1 && n < 16 &&
           os_thread_start(&threads[n], work, sequence) == 0)
        n++;
    work(sequence); /* also where no thread could be made */
    for (int i = 0; i < n; i++)
        os_thread_join(&threads[i]);
}

static int count(const struct sequence *sequence, enum state state)
{
    int n = 0;
    for (int i = 0; i < sequence->n_frames; i++)
        n += sequence->frames[i].state == state;
    return n;
}

static int summarise(const struct sequence *sequence, double seconds)
{
    const int n_failed = count(sequence, FAILED), n_made = count(sequence, MADE);
    const int n_open = count(sequence, WAITING) + count(sequence, CANCELLED);
    int code = APP_DONE;
    for (int i = 0; i < sequence->n_frames; i++) {
        const struct frame *frame = &sequence->frames[i];
        if (frame->state != FAILED)
            continue;
        say_failed(sequence, frame, "failed: ");
        code = frame->code == APP_USAGE ? APP_USAGE : code ? code : APP_FAILED;
    }
    app_say(sequence->tool->host,
            "%d frame%s: %d filtered, %d skipped, %d failed, %d left; %.1f s",
            sequence->n_frames, sequence->n_frames == 1 ? "" : "s", n_made,
            count(sequence, SKIPPED), n_failed, n_open, seconds);
    /* Each failure has been said: the error has no words of its own. */
    if (code != APP_DONE)
        app_fail(sequence->error, code, "%s", "");
    return os_is_interrupted() ? APP_INTERRUPTED : code;
}

/* What was filtered must not be read again as if it had not been. */
static bool check_inputs(const struct sequence *sequence)
{
    for (int i = 0; i < sequence->n_paths; i++)
        if (strcmp(sequence->paths[i], sequence->tool->output) == 0)
            return set_error(sequence->error,
                             "--output: '%s' is also the input; a run that is taken up "
                             "again would blur its frames twice; give another name",
                             sequence->tool->output);
    return true;
}

static int list_frames(struct sequence *sequence, const char *pattern)
{
    struct frame_list list;
    struct image_error error;
    const char *asked = sequence->how->frames;
    const bool is_good = asked ? frame_list_parse(&list, asked, &error)
                               : frame_list_find(&list, pattern, &error);
    if (!is_good)
        return app_fail(sequence->error, APP_USAGE, "%s%s", asked ? "--frames: " : "",
                        error.message);
    sequence->n_frames = list.n;
    sequence->frames =
        app_memory((size_t)list.n, sizeof(*sequence->frames), sequence->error);
    for (int i = 0; sequence->frames && i < list.n; i++)
        sequence->frames[i].number = list.numbers[i];
    frame_list_free(&list);
    return sequence->frames ? APP_DONE : APP_NO_MEMORY;
}

/* Every output needs a place for the number, or frames would write over each other. */
static bool check_outputs(const struct filter_options *tool, struct image_error *error)
{
    const struct {
        const char *name, *path;
    } outputs[] = {{"--output", tool->output},
                   {"--output-coc", tool->output_coc},
                   {"--flattened", tool->flattened}};
    char pattern[4096];
    for (size_t i = 0; i < sizeof(outputs) / sizeof(outputs[0]); i++)
        if (outputs[i].path &&
            frame_guess_foreign(outputs[i].path, pattern, sizeof(pattern)))
            return set_error(error,
                             "%s: '%s': the number of the frame is written with #, as "
                             "in '%s'",
                             outputs[i].name, outputs[i].path, pattern);
        else if (outputs[i].path && !frame_is_pattern(outputs[i].path))
            return set_error(
                error,
                "%s: '%s' has no #### for the number of the frame, as the input has",
                outputs[i].name, outputs[i].path);
    return true;
}

/* The host of the frames: several are made at a time, so no progress is shown. */
static struct app_host host_of_frames(const struct app_host *host)
{
    struct app_host of_frames = app_host_of_part(host);
    of_frames.begin = NULL;
    of_frames.progress = NULL;
    of_frames.end = NULL;
    return of_frames;
}

int sequence_run(const struct sequence_options *how, const struct filter_options *tool,
                 const struct settings *settings, char *const *paths, int n_paths,
                 struct image_error *error)
{
    const double started_s = os_clock_s();
    struct sequence sequence = {.how = how,
                                .tool = tool,
                                .settings = settings,
                                .host = host_of_frames(tool->host),
                                .error = error,
                                .paths = paths,
                                .n_paths = n_paths,
                                .n_jobs = how->n_jobs ? how->n_jobs : 2};
    if (!check_outputs(tool, error) || !check_inputs(&sequence))
        return APP_USAGE;
    int code = list_frames(&sequence, paths[0]);
    if (code == APP_DONE &&
        ((how->parameters &&
          !frame_table_read(&sequence.table, how->parameters, error)) ||
         !journal_read(&sequence)))
        code = app_code_of(error);
    if (code == APP_DONE) {
        os_lock_init(&sequence.lock);
        run_all(&sequence);
        os_lock_destroy(&sequence.lock);
        code = summarise(&sequence, os_clock_s() - started_s);
    }
    free(sequence.frames);
    frame_table_free(&sequence.table);
    free(sequence.journal_path);
    free(sequence.journal);
    return code;
}
