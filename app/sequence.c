/* SPDX-License-Identifier: Apache-2.0 */
#include "sequence.h"

#include <inttypes.h>
#include <pthread.h>
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

enum state { WAITING, MADE, SKIPPED, FAILED, CANCELLED };

struct frame {
    int32_t number;
    enum state state;
    int code;
    char reason[400];
};

struct sequence {
    const struct sequence_options *how;
    const struct filter_options *tool; /* with patterns */
    const struct settings *settings;
    char *const *paths;
    int n_paths, n_jobs;
    struct frame *frames;
    int n_frames;
    struct frame_table table;
    char *journal_path;
    char *journal; /* what it held at the start; "" where there was none */
    pthread_mutex_t lock;
    int next;
    bool is_stopped;
};

bool sequence_is_pattern(const char *name)
{
    const char *slash = strrchr(name, '/');
    return strchr(slash ? slash : name, '#') &&
           os_file_facts(name).kind == OS_FILE_NONE;
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

static void expand(const char **name, int32_t number)
{
    if (*name)
        *name = frame_name(*name, number);
}

static bool set_row(const struct sequence *sequence, struct job *job,
                    struct frame *frame)
{
    const struct frame_table *table = &sequence->table;
    if (table->n_keys == 0)
        return true;
    const int row = frame_table_row(table, frame->number);
    if (row < 0) {
        snprintf(frame->reason, sizeof(frame->reason), "%s has no row for it",
                 sequence->how->parameters);
        return false;
    }
    for (int i = 0; i < table->n_keys; i++) {
        const char *value = table->values[row * table->n_keys + i];
        struct rf_error error;
        if (settings_set(&job->settings, table->keys[i], value, &error) != RF_OK) {
            snprintf(frame->reason, sizeof(frame->reason), "%s: %s",
                     sequence->how->parameters, error.message);
            return false;
        }
    }
    return true;
}

static void hash_job(const struct sequence *sequence, struct job *job)
{
    uint64_t hash = 0xcbf29ce484222325u;
    const struct filter_options *tool = &job->tool;
    char used[4000];
    hash_text(&hash, rf_version());
    settings_print_options(&job->settings.params, used, sizeof(used));
    hash_text(&hash, used);
    hash_bytes(&hash, job->settings.origins, sizeof(job->settings.origins));
    hash_text(&hash, tool->output);
    hash_text(&hash, tool->output_coc);
    hash_text(&hash, tool->flattened);
    hash_text(&hash, tool->depth_channel);
    hash_text(&hash, tool->layer);
    hash_text(&hash, tool->filter_layers);
    hash_file(&hash, tool->depth_file);
    hash_file(&hash, tool->holdout);
    hash_file(&hash, tool->distribution_image);
    const int32_t kinds[] = {tool->type,         tool->compression,  tool->png_bits,
                             tool->pass_through, tool->depth_repair, tool->mist_falloff,
                             tool->is_over,      tool->is_stereo};
    hash_bytes(&hash, kinds, sizeof(kinds));
    for (int i = 0; i < sequence->n_paths; i++)
        hash_file(&hash, job->paths[i]);
    job->hash = hash;
}

static bool job_make(const struct sequence *sequence, struct job *job,
                     struct frame *frame)
{
    job->tool = *sequence->tool;
    job->settings = *sequence->settings;
    job->tool.is_in_sequence = true;
    expand(&job->tool.output, frame->number);
    expand(&job->tool.output_coc, frame->number);
    expand(&job->tool.flattened, frame->number);
    expand(&job->tool.depth_file, frame->number);
    expand(&job->tool.holdout, frame->number);
    for (job->n_paths = 0; job->n_paths < sequence->n_paths; job->n_paths++)
        job->paths[job->n_paths] =
            frame_name(sequence->paths[job->n_paths], frame->number);
    if (!set_row(sequence, job, frame))
        return false;
    hash_job(sequence, job);
    return true;
}

static void job_free(struct job *job)
{
    free((char *)job->tool.output);
    free((char *)job->tool.output_coc);
    free((char *)job->tool.flattened);
    free((char *)job->tool.depth_file);
    free((char *)job->tool.holdout);
    for (int i = 0; i < job->n_paths; i++)
        free(job->paths[i]);
}

/* ---- the journal ---------------------------------------------------------------- */

/* Checksum and size of a file; false where it cannot be read. */
static bool sum_file(const char *path, uint32_t *sum, int64_t *size)
{
    enum { N = 1 << 16 };
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    unsigned char *bytes = need_memory(N, 1);
    uLong crc = crc32(0, NULL, 0);
    size_t n;
    *size = 0;
    while ((n = fread(bytes, 1, N, file)) > 0) {
        crc = crc32(crc, bytes, (uInt)n);
        *size += (int64_t)n;
    }
    const bool is_good = !ferror(file);
    fclose(file);
    free(bytes);
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
    /* Without it the frame is only made again the next time. */
    const int reason = os_file_append(sequence->journal_path, line, strlen(line));
    if (reason != 0)
        warning(sequence->tool->is_quiet, "%s: %s; frame %d will not be skipped",
                sequence->journal_path, strerror(reason), (int)number);
}

static void journal_read(struct sequence *sequence)
{
    const char *pattern = sequence->tool->output;
    sequence->journal_path = need_memory(strlen(pattern) + 8, 1);
    sprintf(sequence->journal_path, "%s.frames", pattern);
    FILE *file = fopen(sequence->journal_path, "rb");
    size_t n = 0;
    if (file) {
        n = (size_t)os_file_facts(sequence->journal_path).n_bytes;
        sequence->journal = need_memory(n + 1, 1);
        n = fread(sequence->journal, 1, n, file);
        fclose(file);
    } else {
        sequence->journal = need_memory(1, 1);
    }
    sequence->journal[n] = '\0';
}

/* ---- frames --------------------------------------------------------------------- */

static void make_frame(struct sequence *sequence, struct frame *frame)
{
    struct job *job = need_memory(1, sizeof(*job));
    const double started_s = os_clock_s();
    const bool is_quiet = sequence->tool->is_quiet;
    message_capture(frame->reason, sizeof(frame->reason));
    frame->state = FAILED;
    frame->code = EXIT_FAILED;
    if (!job_make(sequence, job, frame)) {
        message("frame %d: %s", (int)frame->number, frame->reason);
    } else if (is_finished(sequence, job, frame->number)) {
        frame->state = SKIPPED;
        if (!is_quiet)
            printf("frame %d: %s is there\n", (int)frame->number, job->tool.output);
    } else {
        frame->code = filter_any(&job->tool, &job->settings, job->paths, job->n_paths);
        if (frame->code == EXIT_DONE) {
            frame->state = MADE;
            journal_add(sequence, job, frame->number);
            if (!is_quiet)
                printf("frame %d: %s, %.1f s\n", (int)frame->number, job->tool.output,
                       os_clock_s() - started_s);
        } else if (os_is_interrupted()) {
            frame->state = CANCELLED;
        }
    }
    fflush(stdout);
    message_capture(NULL, 0);
    job_free(job);
    free(job);
}

/* Takes frames until there are none, or one says that the command line is wrong. */
static void *work(void *user)
{
    struct sequence *sequence = user;
    for (;;) {
        pthread_mutex_lock(&sequence->lock);
        struct frame *frame = NULL;
        if (!sequence->is_stopped && !os_is_interrupted() &&
            sequence->next < sequence->n_frames)
            frame = &sequence->frames[sequence->next++];
        pthread_mutex_unlock(&sequence->lock);
        if (!frame)
            return NULL;
        make_frame(sequence, frame);
        if (frame->code == EXIT_USAGE) {
            pthread_mutex_lock(&sequence->lock);
            sequence->is_stopped = true;
            pthread_mutex_unlock(&sequence->lock);
        }
    }
}

static void run_all(struct sequence *sequence)
{
    pthread_t threads[16];
    int n = 0;
    while (n < sequence->n_jobs - 1 && n < sequence->n_frames - 1 && n < 16 &&
           pthread_create(&threads[n], NULL, work, sequence) == 0)
        n++;
    work(sequence); /* also where no thread could be made */
    for (int i = 0; i < n; i++)
        pthread_join(threads[i], NULL);
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
    int code = EXIT_DONE;
    for (int i = 0; i < sequence->n_frames; i++) {
        const struct frame *frame = &sequence->frames[i];
        if (frame->state != FAILED)
            continue;
        fprintf(stderr, "rackfocus: failed: frame %d: %s\n", (int)frame->number,
                frame->reason);
        code = frame->code == EXIT_USAGE ? EXIT_USAGE : code ? code : EXIT_FAILED;
    }
    if (!sequence->tool->is_quiet)
        printf("%d frame%s: %d filtered, %d skipped, %d failed, %d left; %.1f s\n",
               sequence->n_frames, sequence->n_frames == 1 ? "" : "s", n_made,
               count(sequence, SKIPPED), n_failed, n_open, seconds);
    return os_is_interrupted() ? os_interrupt_code() : code;
}

/* What was filtered must not be read again as if it had not been. */
static bool check_inputs(const struct sequence *sequence)
{
    for (int i = 0; i < sequence->n_paths; i++)
        if (strcmp(sequence->paths[i], sequence->tool->output) == 0) {
            message("--output: '%s' is also the input; a run that is taken up again "
                    "would blur its frames twice; give another name",
                    sequence->tool->output);
            return false;
        }
    return true;
}

static bool list_frames(struct sequence *sequence, const char *pattern)
{
    char text[600];
    struct frame_list list;
    const bool is_good =
        sequence->how->frames
            ? frame_list_parse(&list, sequence->how->frames, text, sizeof(text))
            : frame_list_find(&list, pattern, text, sizeof(text));
    if (!is_good) {
        message("%s%s", sequence->how->frames ? "--frames: " : "", text);
        return false;
    }
    sequence->n_frames = list.n;
    sequence->frames = need_memory((size_t)list.n, sizeof(*sequence->frames));
    for (int i = 0; i < list.n; i++)
        sequence->frames[i].number = list.numbers[i];
    frame_list_free(&list);
    return true;
}

/* Every output needs a place for the number, or frames would write over each other. */
static bool check_outputs(const struct filter_options *tool)
{
    const struct {
        const char *name, *path;
    } outputs[] = {{"--output", tool->output},
                   {"--output-coc", tool->output_coc},
                   {"--flattened", tool->flattened}};
    for (size_t i = 0; i < sizeof(outputs) / sizeof(outputs[0]); i++) {
        const char *path = outputs[i].path;
        const char *slash = path ? strrchr(path, '/') : NULL;
        if (!path || strchr(slash ? slash : path, '#'))
            continue;
        message("%s: '%s' has no # for the number of the frame, as the input has",
                outputs[i].name, path);
        return false;
    }
    return true;
}

int sequence_run(const struct sequence_options *how, const struct filter_options *tool,
                 const struct settings *settings, char *const *paths, int n_paths)
{
    char text[600];
    const double started_s = os_clock_s();
    struct sequence sequence = {.how = how,
                                .tool = tool,
                                .settings = settings,
                                .paths = paths,
                                .n_paths = n_paths,
                                .n_jobs = how->n_jobs ? how->n_jobs : 2,
                                .lock = PTHREAD_MUTEX_INITIALIZER};
    if (!check_outputs(tool) || !check_inputs(&sequence) ||
        !list_frames(&sequence, paths[0]))
        return EXIT_USAGE;
    int code = EXIT_FAILED;
    if (how->parameters &&
        !frame_table_read(&sequence.table, how->parameters, text, sizeof(text))) {
        message("%s", text);
    } else {
        journal_read(&sequence);
        run_all(&sequence);
        code = summarise(&sequence, os_clock_s() - started_s);
    }
    free(sequence.frames);
    frame_table_free(&sequence.table);
    free(sequence.journal_path);
    free(sequence.journal);
    return code;
}
