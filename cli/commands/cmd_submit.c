/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus submit: a sequence as the job of a scheduler. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "commands/command_line.h"
#include "commands/farm_job.h"
#include "common/outputs.h"
#include "console/cli.h"
#include "file.h"
#include "pages/html.h"
#include "povray.h"
#include "process.h"
#include "rackfocus/rackfocus.h"
#include "sequence/frames_check.h"

struct submit_options {
    const char *job, *program, *html;
    int32_t kind, n_chunk, n_threads, n_views_each;
    bool is_dry, is_measured, is_quiet;
};

#define AT(member) offsetof(struct submit_options, member)

static const struct option options[] = {
    OPTION_CHOICE_ROW(
        "to", AT(kind), "KIND", FARM_CHOICES,
        "What runs the job: slurm (an array of tasks), openjd (an Open Job "
        "Description template) or script (GNU parallel or xargs on this "
        "machine)."),
    OPTION_INT_ROW("chunk", AT(n_chunk), "FRAMES", 1, 1000000,
                   "Frames of a task. [default as many as take a minute, by the frames "
                   "that are there already, else by the size of the picture]"),
    OPTION_INT_ROW("views-per-task", AT(n_views_each), "VIEWS", 1, RF_MAX_VIEWS,
                   "povray with --views and --keep DIR: render so many views of the "
                   "frames in tasks of their own, before those that merge them. "
                   "[default all views of a frame in one task]"),
    OPTION_FLAG_ROW("measure", AT(is_measured),
                    "Make the first frame now, to know how long one takes."),
    OPTION_FILE_ROW(
        "job", AT(job), "FILE",
        "The file to write. [default OUTPUT.slurm.sh, OUTPUT.openjd.json or "
        "OUTPUT.script.sh]"),
    OPTION_FLAG_ROW("dry-run", AT(is_dry), "Write the file and submit nothing."),
    OPTION_FILE_ROW("html", AT(html), "FILE.html",
                    "Have the last step write a report with a contact sheet."),
    OPTION_FILE_ROW("program", AT(program), "FILE",
                    "rackfocus on the machines of the farm. [default this one]"),
    {.name = "threads",
     .letter = 'j',
     .kind = OPTION_INT,
     .offset = AT(n_threads),
     .value = "COUNT",
     .min = 0,
     .max = 1024,
     .help = "Threads of a task, for which Slurm reserves processors; 0 is one per "
             "processor of the machine (openjd). [default slurm and script 1, openjd "
             "0]"},
    OPTION_QUIET_ROW(AT(is_quiet)),
    OPTION_HELP_ROW,
};

/* ---- how many frames a task has -------------------------------------------------- */

/* Tasks of a minute: Slurm takes 0.1 to 1 s to start one, so that it costs 2 % at most,
 * and what a kill loses is little. Short sequences are cut further, for 16 workers to
 * have something, down to 10 s: with 5 s, 1,000 frames of 480 x 270 took two workers 19
 * to 30 % longer than a loop (tests/farm/measure_overhead.py). */
static const double TASK_S = 60, LEAST_TASK_S = 10;
enum { LEAST_CHUNKS = 16 };

/* A frame on one thread where nothing has been measured: 0.04 s for 480 x 270, 0.63 s for
 * 1080p, 2.1 s for 4K and 8.8 s for 8K with radii up to 1 % of the width
 * (tests/farm/measure_sizes.py). */
static const double GUESSED_S_PER_MEGAPIXEL = 0.3;

static int chunk_for(double frame_s, int n_frames)
{
    double n = TASK_S / frame_s;
    n = fmin(n, fmax((double)n_frames / LEAST_CHUNKS, LEAST_TASK_S / frame_s));
    n = fmax(n, ceil((double)n_frames / FARM_MAX_CHUNKS));
    n = fmax(1, fmin(n, n_frames));
    /* Even tasks: workers that began together end together. */
    return (int)ceil(n_frames / ceil(n_frames / n));
}

static int compare_seconds(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The median of the frames that are there; 0: there are none. */
static double known_frame_s(const struct frames_report *report)
{
    double *seconds = app_memory((size_t)report->n, sizeof(*seconds), NULL);
    int n = 0;
    for (int i = 0; seconds && i < report->n; i++)
        if (report->frames[i].seconds > 0)
            seconds[n++] = report->frames[i].seconds;
    if (n > 0)
        qsort(seconds, (size_t)n, sizeof(*seconds), compare_seconds);
    const double median = n > 0 ? seconds[n / 2] : 0;
    free(seconds);
    return median;
}

/* By the size of the first picture that is there; 0: none can be read. */
static double guessed_frame_s(const struct command_line *line,
                              const struct frames_report *report)
{
    const int at = command_line_operand(line, 0);
    double pixels = 0;
    for (int i = 0; i < report->n && i < 3 && pixels == 0 && at >= 0; i++) {
        struct image_input *input;
        struct image_error ignored;
        char *name = frame_name(line->argv[at], report->frames[i].number, &ignored);
        if (name && image_open(&input, name, &ignored)) {
            int n;
            const struct image_box box = image_parts(input, &n)->data_window;
            pixels = ((double)box.max_x - box.min_x + 1) *
                     ((double)box.max_y - box.min_y + 1);
            image_close(input);
        }
        free(name);
    }
    return GUESSED_S_PER_MEGAPIXEL * pixels * 1e-6;
}

/* ---- which frames ---------------------------------------------------------------- */

/* Makes the first frame that is not finished; its time. */
static int measure_frame(const struct submit_options *tool,
                         const struct command_line *line, struct frames_report *report,
                         double *frame_s)
{
    char number[16], threads[16];
    int n_head, first = 0;
    while (first < report->n && report->frames[first].verdict == FRAME_FINISHED)
        first++;
    char **words = app_memory((size_t)line->argc + 5, sizeof(*words), NULL);
    if (!words)
        return exit_without_memory();
    snprintf(number, sizeof(number), "%d", (int)report->frames[first].number);
    snprintf(threads, sizeof(threads), "%d", (int)tool->n_threads);
    command_line_words(line, "frames", words, &n_head);
    words[n_head++] = "--frames";
    words[n_head++] = number;
    if (!command_line_value(line, "threads")) {
        words[n_head++] = "-j";
        words[n_head++] = threads;
    }
    const double started_s = os_clock_s();
    const int code = command_line_run(line, n_head, words, NULL);
    *frame_s = os_clock_s() - started_s;
    free(words);
    if (code == EXIT_DONE)
        report->frames[first].verdict = FRAME_FINISHED;
    return code;
}

/* ---- chunks ---------------------------------------------------------------------- */

struct chunks {
    char **items;
    int n;
    int32_t *numbers; /* of the frames to make */
    int n_numbers, n_each;
    char *views[RF_MAX_VIEWS]; /* of each task of views; see farm_job.h */
    int n_views;
};

static void chunks_free(struct chunks *chunks)
{
    for (int i = 0; i < chunks->n; i++)
        free(chunks->items[i]);
    for (int i = 0; i < chunks->n_views; i++)
        free(chunks->views[i]);
    free(chunks->items);
    free(chunks->numbers);
}

/* Shares out the views of a frame. */
static bool chunks_cut_views(struct chunks *chunks, int n_views, int n_each)
{
    for (int first = 0; first < n_views && n_each > 0; first += n_each) {
        const int end = first + n_each < n_views ? first + n_each : n_views;
        char *list = app_memory(16, 1, NULL);
        if (!list)
            return false;
        if (end - first > 1)
            snprintf(list, 16, "%d-%d", first, end - 1);
        else
            snprintf(list, 16, "%d", first);
        chunks->views[chunks->n_views++] = list;
    }
    return true;
}

/* An item may hold 1024 characters (Open Job Description), 11 per number. */
static int chunk_end(const struct chunks *chunks, int begin)
{
    enum { MAX_RANGES = 40 };
    int end = begin + 1, n_ranges = 1;
    while (end < chunks->n_numbers && end - begin < chunks->n_each) {
        if (chunks->numbers[end] != chunks->numbers[end - 1] + 1 &&
            ++n_ranges > MAX_RANGES)
            break;
        end++;
    }
    return end;
}

static bool chunks_cut(struct chunks *chunks)
{
    chunks->items = app_memory((size_t)chunks->n_numbers, sizeof(char *), NULL);
    for (int begin = 0; chunks->items && begin < chunks->n_numbers;) {
        const int end = chunk_end(chunks, begin);
        char *list = frame_list_text(chunks->numbers + begin, end - begin, NULL);
        if (!list)
            return false;
        chunks->items[chunks->n++] = list;
        begin = end;
    }
    return chunks->items != NULL;
}

static bool chunks_make(struct chunks *chunks, const struct frames_report *report)
{
    chunks->numbers = app_memory((size_t)report->n, sizeof(int32_t), NULL);
    for (int i = 0; chunks->numbers && i < report->n; i++)
        if (report->frames[i].verdict != FRAME_FINISHED)
            chunks->numbers[chunks->n_numbers++] = report->frames[i].number;
    return chunks->numbers && chunks_cut(chunks);
}

/* ---- the job --------------------------------------------------------------------- */

/* The animation that frames belong to, for every task: alone, its frames would be taken
 * for all of it. `words` has room for three more. False with a message, for a scene that
 * is not there, too. */
static bool complete_povray(struct command_line *line, char **words, char range[2][24])
{
    struct povray_plan plan;
    struct povray_error error = {.is_interrupted = false};
    struct frame_list list;
    struct image_error list_error;
    int n_head;
    const int scene = command_line_operand(line, 0);
    const char *frames = command_line_value(line, "frames");
    int n = command_line_words(line, NULL, words, &n_head);
    char **rest = words + n_head + (n_head < n);
    if (!povray_plan_make(&plan, line->argv[scene], rest, (int)(words + n - rest),
                          &error)) {
        message("%s", error.message);
        return false;
    }
    const bool is_animation = plan.is_animation;
    const bool is_there = os_file_facts(plan.scene).kind == OS_FILE_REGULAR;
    if (!is_there) /* every task would end so */
        message("%s: there is no such file; correct the scene's name or folder",
                plan.scene);
    povray_plan_free(&plan);
    if (!is_there)
        return false;
    if (!is_animation && frame_list_parse(&list, frames, &list_error)) {
        static char end_of_options[] = "--";
        if (n_head == n)
            words[n++] = end_of_options;
        snprintf(range[0], sizeof(range[0]), "+KFI%d", (int)list.numbers[0]);
        snprintf(range[1], sizeof(range[1]), "+KFF%d", (int)list.numbers[list.n - 1]);
        words[n++] = range[0];
        words[n++] = range[1];
        frame_list_free(&list);
    }
    line->argv = words;
    line->argc = n;
    return true;
}

/* Starts what submits the file; returns only where that cannot be. */
static int hand_over(enum farm_kind kind, const char *path)
{
    char shell[] = "sh", openjd[] = "openjd", run[] = "run";
    char *file = os_file_full_path(path);
    if (!file)
        return exit_without_memory();
    char *by_shell[] = {shell, file, NULL}, *by_openjd[] = {openjd, run, file, NULL};
    fflush(stdout);
    const int reason = kind == FARM_OPENJD ? os_process_become(openjd, by_openjd)
                                           : os_process_become(shell, by_shell);
    message("%s: %s; the job is written and not submitted: %s",
            kind == FARM_OPENJD ? openjd : shell, strerror(reason), file);
    free(file);
    return EXIT_FAILED;
}

/* The program's own path; the caller frees. */
static char *own_program(void)
{
    char folder[4096];
    char *path = app_memory(sizeof(folder) + 16, 1, NULL);
    if (path && os_program_folder(folder, sizeof(folder)))
        snprintf(path, sizeof(folder) + 16, "%srackfocus", folder);
    else if (path)
        strcpy(path, "rackfocus");
    return path;
}

static char *job_path(const struct submit_options *tool, const char *output)
{
    static const char *const endings[FARM_N_KINDS] = {".slurm.sh", ".openjd.json",
                                                      ".script.sh"};
    const size_t n_bytes = strlen(tool->job ? tool->job : output) + 20;
    char *path = app_memory(n_bytes, 1, NULL);
    if (path)
        snprintf(path, n_bytes, "%s%s", tool->job ? tool->job : output,
                 tool->job ? "" : endings[tool->kind]);
    return path;
}

static int write_job(const struct submit_options *tool, const struct farm_job *job,
                     const char *path, const char *how)
{
    struct image_error error;
    if (!farm_job_write(job, (enum farm_kind)tool->kind, path, &error)) {
        message("%s", error.message);
        return EXIT_FAILED;
    }
    if (!tool->is_quiet)
        printf("%s: %d task%s of %s\n", path, job->n_chunks,
               job->n_chunks == 1 ? "" : "s", how);
    return tool->is_dry ? EXIT_DONE : hand_over((enum farm_kind)tool->kind, path);
}

static int submit_chunks(const struct submit_options *tool,
                         const struct command_line *line,
                         const struct frames_report *report,
                         const struct chunks *chunks, const char *how)
{
    int code = EXIT_FAILED;
    const char *output = command_line_value(line, "output");
    char *folder = os_file_full_path("."), *program = own_program();
    char *path = job_path(tool, output);
    int32_t *numbers = app_memory((size_t)report->n, sizeof(*numbers), NULL);
    for (int i = 0; numbers && i < report->n; i++)
        numbers[i] = report->frames[i].number;
    char *all = numbers ? frame_list_text(numbers, report->n, NULL) : NULL;
    if (!folder || !program || !path || !all)
        code = exit_without_memory();
    else
        code = write_job(
            tool,
            &(struct farm_job){.program = tool->program ? tool->program : program,
                               .folder = folder,
                               .name = output,
                               .line = *line,
                               .frames = all,
                               .chunks = chunks->items,
                               .n_chunks = chunks->n,
                               .views = chunks->views,
                               .n_views = chunks->n_views,
                               .n_threads = tool->n_threads,
                               .html = tool->html},
            path, how);
    free(numbers);
    free(all);
    free(folder);
    free(program);
    free(path);
    return code;
}

/* Frames of a task, and how that is known. */
static int choose_chunk(const struct submit_options *tool,
                        const struct command_line *line, struct frames_report *report,
                        struct chunks *chunks, char *how, size_t n_bytes)
{
    double frame_s = 0;
    const char *source = "one was made now";
    int code = EXIT_DONE;
    if (tool->is_measured)
        code = measure_frame(tool, line, report, &frame_s);
    if (frame_s == 0) {
        frame_s = known_frame_s(report);
        source = "as those that are there took";
    }
    if (frame_s == 0) {
        frame_s = guessed_frame_s(line, report);
        source = "guessed by their size; --measure makes one first";
    }
    const int n_open = report->n - frames_report_count(report, FRAME_FINISHED);
    chunks->n_each = tool->n_chunk ? tool->n_chunk
                     : frame_s > 0 ? chunk_for(frame_s, n_open)
                                   : 1;
    const int most = FARM_MAX_CHUNKS / (chunks->n_views > 0 ? chunks->n_views : 1);
    const int least = (n_open + most - 1) / most;
    const bool is_raised = chunks->n_each < least;
    if (is_raised)
        chunks->n_each = least;
    const int n = chunks->n_each;
    if (is_raised)
        snprintf(how, n_bytes, "%d frames, so that there are %d tasks at most", n,
                 most);
    else if (tool->n_chunk || frame_s == 0)
        snprintf(how, n_bytes, "%d frame%s", n, n == 1 ? "" : "s");
    else
        snprintf(how, n_bytes, "%d frame%s, %.3g s each (%s)", n, n == 1 ? "" : "s",
                 frame_s, source);
    return code;
}

/* What is written must be nothing that the frames are made of, and none of them. */
static int check_outputs(const struct submit_options *tool,
                         const struct command_line *line,
                         const struct frames_report *report)
{
    struct image_error error;
    struct outputs outputs = {.error = &error};
    outputs_add(&outputs, "job", tool->job);
    outputs_add(&outputs, "html", tool->html);
    return command_line_spare(line, report, &outputs) ? exit_code(outputs.code, &error)
                                                      : exit_without_memory();
}

static int number_of_views(const struct command_line *line)
{
    const char *text = command_line_value(line, "views");
    const long n = text ? strtol(text, NULL, 10) : 1;
    return n > 0 && n <= RF_MAX_VIEWS ? (int)n : 1;
}

static int submit(const struct submit_options *tool, struct command_line *line,
                  struct frames_report *report)
{
    char how[160];
    struct chunks chunks = {0};
    int code = command_line_run(line, line->argc, line->argv, report);
    if (code == EXIT_DONE)
        code = check_outputs(tool, line, report);
    if (code != EXIT_DONE)
        return code;
    const int n_finished = frames_report_count(report, FRAME_FINISHED);
    if (!tool->is_quiet && n_finished > 0)
        printf("%d of %d frames are finished\n", n_finished, report->n);
    if (n_finished == report->n)
        return EXIT_DONE;
    code = chunks_cut_views(&chunks, number_of_views(line), tool->n_views_each)
               ? choose_chunk(tool, line, report, &chunks, how, sizeof(how))
               : exit_without_memory();
    if (code == EXIT_DONE && frames_report_count(report, FRAME_FINISHED) < report->n) {
        code = chunks_make(&chunks, report)
                   ? submit_chunks(tool, line, report, &chunks, how)
                   : exit_without_memory();
    }
    chunks_free(&chunks);
    return code;
}

/* ---- usage ----------------------------------------------------------------------- */

static bool fail_usage(const char *text)
{
    message("%s; see rackfocus submit --help", text);
    return false;
}

static bool check_usage(const struct submit_options *tool,
                        const struct operands *operands,
                        const struct command_line *line)
{
    if (!options_given(operands, "to"))
        return fail_usage("submit needs --to slurm, --to openjd or --to script");
    if (tool->is_measured && tool->n_chunk)
        return fail_usage("--measure chooses what --chunk says; leave one out");
    const char *method = command_line_value(line, "method");
    if (tool->n_views_each &&
        (line->command != &command_povray || !command_line_value(line, "views") ||
         !command_line_value(line, "keep") ||
         (method && strcmp(method, "accumulate") == 0)))
        return fail_usage("--views-per-task is for povray with --views and --keep DIR, "
                          "where the views wait for each other");
    if (!html_check_name(tool->html))
        return false;
    const char *output = command_line_value(line, "output");
    if (!output)
        return fail_usage("the command line of the frames has no output, -o");
    if (!frame_is_pattern(output)) {
        message("--output: '%s' has no #### for the number of the frame", output);
        return false;
    }
    for (int i = 0; i < line->argc; i++)
        if (strchr(line->argv[i], '\n') ||
            (tool->kind == FARM_OPENJD && strstr(line->argv[i], "{{")))
            return fail_usage("a word of the frames' command has an end of line, or "
                              "{{, which is Open Job "
                              "Description's own; give files other names");
    return true;
}

static int cmd_submit(int argc, char **argv)
{
    struct submit_options tool = {.n_threads = -1};
    struct frames_report report = {0};
    struct command_line line;
    struct operands operands;
    char range[2][24];
    int code = options_parse(&command_submit, argc, argv, &tool, NULL, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    if (tool.n_threads < 0)
        tool.n_threads = tool.kind == FARM_OPENJD ? 0 : 1;
    code = EXIT_USAGE;
    char **words = app_memory((size_t)operands.n_rest + 4, sizeof(*words), NULL);
    if (!words)
        code = exit_without_memory();
    else if (command_line_open(&line, operands.n_rest, operands.rest, "submit") &&
             check_usage(&tool, &operands, &line)) {
        if (strcmp(line.argv[0], "povray") != 0 || command_line_operand(&line, 0) < 0 ||
            !command_line_value(&line, "frames") ||
            complete_povray(&line, words, range))
            code = submit(&tool, &line, &report);
    }
    frames_report_free(&report);
    operands_free(&operands);
    free(words);
    return code;
}

const struct command command_submit = {
    .name = "submit",
    .summary = "give a sequence to a render farm",
    .usage = "--to slurm|openjd|script [options] -- filter 'IN.####.exr' -o "
             "'OUT.####.exr' ...",
    .description =
        "Cuts the frames of a command line into tasks, writes the job, and submits it: "
        "a Slurm array, an Open Job Description template, or a shell script for this "
        "machine. It ends with a command line of filter, povray or accumulate as it "
        "would "
        "run here; -- may stand before it.\n\n"
        "Frames that are finished are left out. A task that was killed, or failed, "
        "costs the frame it was at: the same command again submits what is missing, "
        "and all frames are, bit for bit, those of one machine. The last step of the "
        "job checks every frame, as rackfocus frames does.\n\n"
        "The folder must be on every machine, under the same name.",
    .examples =
        "rackfocus submit --to slurm -- filter 'shot.####.exr' -o 'out.####.exr' "
        "--focus-distance 8\n"
        "rackfocus submit --to openjd --dry-run --job shot.json -- filter "
        "'shot.####.exr' -o 'out.####.exr'\n"
        "rackfocus submit --to script -- povray scene.pov -o 'out.####.exr' --frames "
        "1-48",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .keeps_rest = true,
    .takes_line = true,
    .run = cmd_submit,
};
