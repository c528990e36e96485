/* SPDX-License-Identifier: Apache-2.0 */
#include "sequence/sequence.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "common/frame_list.h"
#include "common/report.h"
#include "file.h"
#include "filter/filter_many.h"
#include "filter/filter_output.h"
#include "filter/temporal.h"
#include "interrupt.h"
#include "rackfocus/rackfocus.h"
#include "sequence/frame_table.h"
#include "sequence/frames_check.h"
#include "sequence/journal.h"
#include "sources/picture.h"
#include "thread.h"

enum state { WAITING, MADE, SKIPPED, FAILED, CANCELLED };

struct frame {
    int32_t number;
    enum state state;
    int code;
    int32_t width, height;    /* of its input, px; 0: not known */
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
    struct journal journal;
    struct os_lock lock;
    int next;
    bool is_stopped;
};

bool sequence_is_pattern(const char *name)
{
    return frame_is_pattern(name) && os_file_facts(name).kind == OS_FILE_NONE;
}

/* ---- what a frame is made of and with ------------------------------------------- */

/* The names and settings of one frame, out of those of the sequence. */
struct job {
    struct filter_options tool;
    struct settings settings;
    char *paths[RF_MAX_VIEWS];
    int n_paths;
    struct temporal_frames beside; /* of --temporal */
    uint64_t hash;
};

/* Is a column for nothing, since its parameter was typed? */
static bool is_typed(const struct sequence *sequence, int column)
{
    const struct settings *typed = sequence->how->typed;
    return column != sequence->table.easing_key && typed &&
           settings_origin(typed, sequence->table.keys[column]) == ORIGIN_COMMAND_LINE;
}

static bool set_row(const struct sequence *sequence, int32_t number,
                    struct settings *settings, struct image_error *error)
{
    const struct frame_table *table = &sequence->table;
    for (int i = 0; i < table->n_keys; i++) {
        char value[FRAME_VALUE];
        if (i == table->easing_key || is_typed(sequence, i))
            continue;
        if (!frame_table_value(table, i, number, value))
            return set_error(error,
                             "%s has no row for it; give it one, or let the column "
                             "'easing' say how values go from row to row",
                             sequence->how->parameters);
        struct rf_error core_error;
        if (settings_set(settings, table->keys[i], value, &core_error) != RF_OK)
            return set_error(error, "%s: %s", sequence->how->parameters,
                             core_error.message);
    }
    return true;
}

/* Files whose names are separated by commas. */
static void hash_files(uint64_t *hash, const char *names)
{
    char path[4096];
    frame_hash_text(hash, names);
    for (const char *name = names; name && *name;) {
        const size_t length = strcspn(name, ",");
        snprintf(path, sizeof(path), "%.*s", (int)length, name);
        frame_hash_file(hash, path);
        name += length + (name[length] == ',');
    }
}

/* How each kind of FILTER_OPTIONS counts. */
#define HASH_OUTPUT(name) frame_hash_text(&hash, tool->name)
#define HASH_INPUT(name) frame_hash_file(&hash, tool->name)
#define HASH_INPUTS(name) hash_files(&hash, tool->name)
#define HASH_INPUT_OR_TEXT(name) HASH_INPUTS(name)
#define HASH_TEXT(name) frame_hash_text(&hash, tool->name)
#define HASH_NUMBER(name) frame_hash_bytes(&hash, &tool->name, sizeof(tool->name))
#define HASH_ASIDE(name)
#define HASH_OPTION(kind, type, name) HASH_##kind(name);

static void hash_beside(uint64_t *hash, const struct temporal_frame *frame)
{
    frame_hash_bytes(hash, &frame->offset, sizeof(frame->offset));
    for (int i = 0; i < frame->n_paths; i++)
        frame_hash_file(hash, frame->paths[i]);
    frame_hash_file(hash, frame->depth_file);
    frame_hash_settings(hash, frame->settings);
}

static void hash_job(const struct sequence *sequence, struct job *job)
{
    uint64_t hash = FRAME_HASH_START;
    const struct filter_options *tool = &job->tool;
    frame_hash_text(&hash, rf_version());
    frame_hash_settings(&hash, &job->settings);
    FILTER_OPTIONS(HASH_OPTION)
    for (int i = 0; i < sequence->n_paths; i++)
        frame_hash_file(&hash, job->paths[i]);
    for (int k = 0; k < job->beside.n; k++)
        hash_beside(&hash, &job->beside.at[k]);
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
#define EXPAND_INPUTS(name) EXPAND_OUTPUT(name)
#define EXPAND_INPUT_OR_TEXT(name) EXPAND_OUTPUT(name)
#define EXPAND_TEXT(name)
#define EXPAND_NUMBER(name)
#define EXPAND_ASIDE(name)
#define EXPAND_OPTION(kind, type, name) EXPAND_##kind(name);

static void free_beside(struct temporal_frame *frame)
{
    for (int i = 0; i < frame->n_paths; i++)
        free(frame->paths[i]);
    free(frame->depth_file);
    free(frame->settings);
}

/* The lens of a frame beside one; where the table has no row for it, that one's. */
static bool set_beside(const struct sequence *sequence, const struct job *job,
                       int32_t number, struct temporal_frame *beside,
                       struct image_error *error)
{
    struct image_error ignored;
    beside->settings = app_memory(1, sizeof(*beside->settings), error);
    if (!beside->settings)
        return false;
    *beside->settings = *sequence->settings;
    if (!set_row(sequence, number, beside->settings, &ignored))
        *beside->settings = job->settings;
    return true;
}

/* Adds the frame that lies so far away, if all its files are there; false on failure.
 */
static bool add_beside(const struct sequence *sequence, struct job *job,
                       struct frame *frame, int32_t offset)
{
    struct temporal_frame *beside = &job->beside.at[job->beside.n];
    const char *depth_file = sequence->tool->depth_file;
    bool is_there = true;
    *beside = (struct temporal_frame){.offset = offset};
    bool is_good =
        set_beside(sequence, job, frame->number + offset, beside, &frame->error);
    for (int i = 0; i < sequence->n_paths && is_good; i++) {
        char *path =
            frame_name(sequence->paths[i], frame->number + offset, &frame->error);
        is_good = path != NULL;
        beside->paths[beside->n_paths] = path;
        beside->n_paths += is_good;
        is_there = is_there && is_good && os_file_facts(path).kind != OS_FILE_NONE;
    }
    if (is_good && depth_file) {
        beside->depth_file =
            frame_name(depth_file, frame->number + offset, &frame->error);
        is_good = beside->depth_file != NULL;
        is_there = is_there && is_good &&
                   os_file_facts(beside->depth_file).kind != OS_FILE_NONE;
    }
    if (is_good && is_there)
        job->beside.n++;
    else
        free_beside(beside);
    return is_good;
}

/* Those on both sides that there are, the nearest first. */
static bool find_beside(const struct sequence *sequence, struct job *job,
                        struct frame *frame)
{
    for (int32_t k = 1; k <= job->tool.temporal; k++)
        if (!add_beside(sequence, job, frame, -k) ||
            !add_beside(sequence, job, frame, k))
            return false;
    if (job->tool.temporal > 0)
        job->tool.beside = &job->beside;
    return true;
}

static bool job_make(const struct sequence *sequence, struct job *job,
                     struct frame *frame)
{
    bool is_good = true;
    job->tool = *sequence->tool;
    job->settings = *sequence->settings;
    FILTER_OPTIONS(EXPAND_OPTION)
    for (int i = 0; i < sequence->n_paths; i++) {
        job->paths[i] = frame_name(sequence->paths[i], frame->number, &frame->error);
        is_good = is_good && job->paths[i];
    }
    job->n_paths = sequence->n_paths;
    if (!is_good || !set_row(sequence, frame->number, &job->settings, &frame->error) ||
        !find_beside(sequence, job, frame))
        return false;
    hash_job(sequence, job);
    return true;
}

#define FREE_OUTPUT(name) free((char *)job->tool.name)
#define FREE_INPUT(name) FREE_OUTPUT(name)
#define FREE_INPUTS(name) FREE_OUTPUT(name)
#define FREE_INPUT_OR_TEXT(name) FREE_OUTPUT(name)
#define FREE_TEXT(name)
#define FREE_NUMBER(name)
#define FREE_ASIDE(name)
#define FREE_OPTION(kind, type, name) FREE_##kind(name);

static void job_free(struct job *job)
{
    FILTER_OPTIONS(FREE_OPTION)
    for (int i = 0; i < job->n_paths; i++)
        free(job->paths[i]);
    for (int i = 0; i < job->beside.n; i++)
        free_beside(&job->beside.at[i]);
}

/* ---- what is finished ----------------------------------------------------------- */

static struct frame_files files_of(const struct job *job)
{
    return (struct frame_files){
        {job->tool.output, job->tool.output_coc, job->tool.flattened}};
}

static void note_finished(struct sequence *sequence, const struct job *job,
                          int32_t number, double seconds)
{
    char sums[FRAME_SUMS];
    const struct frame_files files = files_of(job);
    if (!frame_sum_files(&files, sums))
        return;
    struct image_error ignored;
    /* Without it the frame is only made again the next time. */
    const int reason =
        journal_add_finished(&sequence->journal, number, job->hash, sums, seconds);
    if (reason != 0)
        app_warn(&sequence->host, &ignored, "%s: %s; frame %d will not be skipped",
                 sequence->journal.path, strerror(reason), (int)number);
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

/* Who hears of a frame: the journal, and then the host. */
struct listener {
    struct sequence *sequence;
    int32_t number;
};

static bool hear_warning(void *user, const char *text)
{
    const struct listener *listener = user;
    const struct app_host *host = &listener->sequence->host;
    journal_add_note(&listener->sequence->journal, listener->number, JOURNAL_WARNING,
                     text);
    return !host->warn || host->warn(host->user, text);
}

static void hear_result(void *user, const char *text)
{
    const struct listener *listener = user;
    journal_add_note(&listener->sequence->journal, listener->number, JOURNAL_MADE,
                     text);
}

static void make_files(struct sequence *sequence, struct frame *frame, struct job *job,
                       struct filter_kept *kept)
{
    const double started_s = os_clock_s();
    struct listener listener = {sequence, frame->number};
    const struct app_host host = {
        .user = &listener, .warn = hear_warning, .say = hear_result};
    job->tool.host = &host;
    job->tool.kept = kept;
    frame->code =
        filter_any(&job->tool, &job->settings, job->paths, job->n_paths, &frame->error);
    frame->width = kept->width;
    frame->height = kept->height;
    if (frame->code == APP_DONE) {
        frame->state = MADE;
        note_finished(sequence, job, frame->number, os_clock_s() - started_s);
        app_say(sequence->tool->host, "frame %d: %s, %.1f s", (int)frame->number,
                job->tool.output, os_clock_s() - started_s);
    } else if (os_is_interrupted()) {
        frame->state = CANCELLED;
    }
}

static void find_or_make(struct sequence *sequence, struct frame *frame,
                         struct job *job, struct filter_kept *kept)
{
    const struct frame_files files = files_of(job);
    if (sequence->how->is_anew ||
        !frame_is_finished(&sequence->journal, frame->number, job->hash, &files)) {
        make_files(sequence, frame, job, kept);
        return;
    }
    frame->state = SKIPPED;
    app_say(sequence->tool->host, "frame %d: %s is there", (int)frame->number,
            job->tool.output);
}

static struct frame_check *check_of(const struct sequence *sequence,
                                    const struct frame *frame)
{
    return &sequence->how->report->frames[frame - sequence->frames];
}

/* Looks, and makes nothing. */
static void check_frame(struct sequence *sequence, struct frame *frame,
                        const struct job *job)
{
    struct frame_check *check = check_of(sequence, frame);
    const struct frame_files files = files_of(job);
    check->path = frame_name(job->tool.output, frame->number, &frame->error);
    if (check->path &&
        frame_check_files(check, &sequence->journal, &job->hash, &files, &frame->error))
        frame->state = SKIPPED;
}

static void make_frame(struct sequence *sequence, struct frame *frame,
                       struct filter_kept *kept)
{
    struct job *job = app_memory(1, sizeof(*job), &frame->error);
    frame->state = FAILED;
    frame->code = APP_FAILED;
    if (job && job_make(sequence, job, frame)) {
        if (sequence->how->report)
            check_frame(sequence, frame, job);
        else
            find_or_make(sequence, frame, job, kept);
    }
    if (frame->state == FAILED && sequence->how->report) {
        struct frame_check *check = check_of(sequence, frame);
        snprintf(check->why, sizeof(check->why), "%.*s", (int)sizeof(check->why) - 1,
                 frame->error.message);
    } else if (frame->state == FAILED) {
        say_failed(sequence, frame, "");
        if (frame->code != APP_USAGE)
            journal_add_note(&sequence->journal, frame->number, JOURNAL_FAILED,
                             frame->error.message);
    }
    if (job)
        job_free(job);
    free(job);
}

/* Takes frames until there are none, or one says that the command line is wrong. */
static void work(void *user)
{
    struct sequence *sequence = user;
    struct filter_kept kept = {.context = NULL};
    for (;;) {
        os_lock_take(&sequence->lock);
        struct frame *frame = NULL;
        if (!sequence->is_stopped && !os_is_interrupted() &&
            sequence->next < sequence->n_frames)
            frame = &sequence->frames[sequence->next++];
        os_lock_release(&sequence->lock);
        if (!frame)
            break;
        make_frame(sequence, frame, &kept);
        if (frame->code == APP_USAGE) {
            os_lock_take(&sequence->lock);
            sequence->is_stopped = true;
            os_lock_release(&sequence->lock);
        }
    }
    filter_kept_free(&kept);
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

static bool is_like(const struct frame *a, const struct frame *b)
{
    return a->width == b->width && a->height == b->height;
}

/* Has the frame been made in this run, so that its size is known? */
static bool is_made(const struct frame *frame)
{
    return frame->state == MADE && frame->width > 0;
}

/* A frame of the size that most have that were made; NULL: there is none. */
static const struct frame *find_usual(const struct sequence *sequence)
{
    const struct frame *usual = NULL;
    int lead = 0; /* Boyer and Moore's vote */
    for (int i = 0; i < sequence->n_frames; i++) {
        const struct frame *frame = &sequence->frames[i];
        if (!is_made(frame))
            continue;
        if (lead == 0)
            usual = frame;
        lead += is_like(frame, usual) ? 1 : -1;
    }
    return usual;
}

/* Frames of a shot are of one size; a proxy among them is no mistake of ours. */
static int warn_of_sizes(const struct sequence *sequence)
{
    const struct frame *usual = find_usual(sequence), *other = NULL;
    int n = 0;
    for (int i = 0; i < sequence->n_frames && usual; i++) {
        const struct frame *frame = &sequence->frames[i];
        if (!is_made(frame) || is_like(frame, usual))
            continue;
        other = other ? other : frame;
        n++;
    }
    if (!other)
        return APP_DONE;
    return app_warn(sequence->tool->host, sequence->error,
                    "%s: frames are of different sizes: %d is %d x %d px%s, %d is "
                    "%d x %d px; each was filtered as it is",
                    sequence->paths[0], (int)other->number, (int)other->width,
                    (int)other->height, n > 1 ? ", as others are" : "",
                    (int)usual->number, (int)usual->width, (int)usual->height);
}

static int summarise(const struct sequence *sequence, double seconds)
{
    const int n_failed = count(sequence, FAILED), n_made = count(sequence, MADE);
    const int n_open = count(sequence, WAITING) + count(sequence, CANCELLED);
    int code = APP_DONE;
    if (sequence->how->report)
        return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
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
    const int sizes = warn_of_sizes(sequence);
    /* Each failure has been said: the error has no words of its own. */
    if (code != APP_DONE)
        app_fail(sequence->error, code, "%s", "");
    else
        code = sizes;
    return os_is_interrupted() ? APP_INTERRUPTED : code;
}

static int take_frames(struct sequence *sequence, const struct frame_list *list)
{
    sequence->n_frames = list->n;
    sequence->frames =
        app_memory((size_t)list->n, sizeof(*sequence->frames), sequence->error);
    for (int i = 0; sequence->frames && i < list->n; i++)
        sequence->frames[i].number = list->numbers[i];
    const bool has_memory =
        sequence->frames &&
        (!sequence->how->report ||
         frames_report_start(sequence->how->report, list, sequence->error));
    return has_memory ? APP_DONE : APP_NO_MEMORY;
}

/* Of a job and of a check, too: whoever waits for all frames hears that some never come.
 */
static int warn_of_missing(const struct sequence *sequence,
                           const struct frame_list *list)
{
    char holes[FRAME_LIST_HOLES];
    if (!frame_list_holes(list, holes, sequence->error))
        return APP_NO_MEMORY;
    return !*holes ? APP_DONE
                   : app_warn(sequence->tool->host, sequence->error,
                              "%s: %s; name with --frames what is to be filtered",
                              sequence->paths[0], holes);
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
    int code = filter_check_files(sequence->tool, sequence->paths, sequence->n_paths,
                                  &list, sequence->error);
    if (code == APP_DONE && !asked)
        code = warn_of_missing(sequence, &list);
    if (code == APP_DONE)
        code = take_frames(sequence, &list);
    frame_list_free(&list);
    return code;
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

/* The folders of the outputs, which have no place for the number: else every frame says
 * that its own is not there. */
static bool check_folders(const struct filter_options *tool, struct image_error *error)
{
    const char *const outputs[] = {tool->output, tool->output_coc, tool->flattened};
    for (size_t i = 0; i < sizeof(outputs) / sizeof(outputs[0]); i++)
        if (outputs[i] && !picture_check_writable(outputs[i], error))
            return false;
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

static int warn_typed(const struct sequence *sequence)
{
    const struct frame_table *table = &sequence->table;
    for (int i = 0; i < table->n_keys && !sequence->how->report; i++) {
        if (!is_typed(sequence, i))
            continue;
        const char *name = rf_param_find(table->keys[i])->key;
        const int code = app_warn(sequence->tool->host, sequence->error,
                                  "--%s: is taken for all frames, and the column '%s' "
                                  "of %s is not read; leave one of them out",
                                  name, table->keys[i], sequence->how->parameters);
        if (code != APP_DONE)
            return code;
    }
    return APP_DONE;
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
    if (!check_outputs(tool, error))
        return APP_USAGE;
    int code = list_frames(&sequence, paths[0]);
    if (code == APP_DONE && !how->report && !check_folders(tool, error))
        code = app_code_of(error);
    if (code == APP_DONE && how->parameters)
        code = frame_table_read(&sequence.table, how->parameters, error)
                   ? warn_typed(&sequence)
                   : app_code_of(error);
    if (code == APP_DONE && !journal_open(&sequence.journal, tool->output, error))
        code = app_code_of(error);
    if (code == APP_DONE) {
        os_lock_init(&sequence.lock);
        run_all(&sequence);
        os_lock_destroy(&sequence.lock);
        journal_close(&sequence.journal);
        code = summarise(&sequence, os_clock_s() - started_s);
    }
    free(sequence.frames);
    frame_table_free(&sequence.table);
    return code;
}
