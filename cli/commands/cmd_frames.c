/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus frames: are the frames of a sequence there, whole, made as they should? */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands/command_line.h"
#include "commands/frames_print.h"
#include "common/outputs.h"
#include "console/cli.h"
#include "interrupt.h"
#include "pages/html.h"
#include "sequence/frames_check.h"

struct frames_options {
    const char *frames, *html;
    bool is_json, is_quiet;
};

#define AT(member) offsetof(struct frames_options, member)

static const struct option options[] = {
    OPTION_TEXT_ROW("frames", AT(frames), "LIST",
                    "These frames, such as 1-240x2,300. [default all from the first to "
                    "the last that is there; after --, what the command line says]"),
    OPTION_FLAG_ROW("json", AT(is_json), "Print everything as JSON."),
    OPTION_FILE_ROW(
        "html", AT(html), "FILE.html",
        "Also write a report with a contact sheet, whose pictures go into a "
        "folder beside it, FILE_frames."),
    OPTION_QUIET_ROW(AT(is_quiet)),
    OPTION_HELP_ROW,
};

/* Of what the command writes, by its pattern. */
static int check_pattern(struct frames_report *report, const char *pattern,
                         const char *frames)
{
    struct image_error error;
    struct frame_list list = {0};
    if (!frame_is_pattern(pattern)) {
        message("%s: has no place for the number of the frame; write # for each digit, "
                "as in 'out.####.exr'",
                pattern);
        return EXIT_USAGE;
    }
    if (frames && !frame_list_parse(&list, frames, &error)) {
        message("--frames: %s", error.message);
        return EXIT_USAGE;
    }
    const bool is_good =
        frames_check_pattern(report, pattern, frames ? &list : NULL, &error);
    frame_list_free(&list);
    if (is_good)
        return EXIT_DONE;
    message("%s", error.message);
    return EXIT_FAILED;
}

static int check(const struct frames_options *tool, const struct operands *operands,
                 struct command_line *line, struct frames_report *report)
{
    if (operands->n == 1 && operands->n_rest == 0)
        return check_pattern(report, operands->items[0], tool->frames);
    if (operands->n > 0) {
        message("frames takes one name of a sequence, or a command line after --; see "
                "rackfocus frames --help");
        return EXIT_USAGE;
    }
    if (tool->frames) {
        message("--frames: give it behind --, to the command that makes the frames");
        return EXIT_USAGE;
    }
    if (!command_line_open(line, operands->n_rest, operands->rest, "frames"))
        return EXIT_USAGE;
    return command_line_run(line, line->argc, line->argv, report);
}

/* The lines of all processes into one file: nobody needs to know how many there were. */
static void fold(const char *pattern)
{
    struct journal journal;
    struct image_error error;
    if (!pattern || !journal_open(&journal, pattern, NULL))
        return;
    if (!journal_fold(&journal, &error))
        message("%s", error.message);
    journal_close(&journal);
}

/* The page must be none of the frames, and nothing that they are made of. */
static int check_page(const struct frames_options *tool,
                      const struct command_line *line,
                      const struct frames_report *report)
{
    struct image_error error;
    struct outputs outputs = {.error = &error};
    outputs_add(&outputs, "html", tool->html);
    if (!command_line_spare(line, report, &outputs))
        return exit_without_memory();
    for (int i = 0; i < report->n; i++)
        outputs_spare(&outputs, NULL, report->frames[i].path);
    return exit_code(outputs.code, &error);
}

static int report_frames(const struct frames_options *tool,
                         const struct operands *operands,
                         const struct command_line *line,
                         const struct frames_report *report)
{
    struct image_error error;
    const int code = check_page(tool, line, report);
    if (code != EXIT_DONE)
        return code;
    const int n_open = report->n - frames_report_count(report, FRAME_FINISHED);
    fold(line->command ? command_line_value(line, "output") : operands->items[0]);
    if (tool->is_json)
        frames_print_json(report);
    else
        frames_print_text(report, line, tool->is_quiet);
    if (tool->html && !frames_write_html(report, tool->html, &error))
        return exit_code(os_is_interrupted() ? APP_INTERRUPTED : APP_FAILED, &error);
    return n_open ? EXIT_FAILED : EXIT_DONE;
}

static int cmd_frames(int argc, char **argv)
{
    struct frames_options tool = {0};
    struct frames_report report = {0};
    struct command_line line = {0};
    struct operands operands;
    int code = options_parse(&command_frames, argc, argv, &tool, NULL, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    code = EXIT_USAGE;
    if (operands.n == 0 && operands.n_rest == 0)
        message("frames needs the name of a sequence, or a command line after --; see "
                "rackfocus frames --help");
    else if (html_check_name(tool.html))
        code = check(&tool, &operands, &line, &report);
    if (code == EXIT_DONE)
        code = os_is_interrupted() ? os_interrupt_code()
                                   : report_frames(&tool, &operands, &line, &report);
    frames_report_free(&report);
    operands_free(&operands);
    return code;
}

const struct command command_frames = {
    .name = "frames",
    .summary = "check that the frames of a sequence are there and whole",
    .usage = "'OUT.####.exr' [options]\n"
             "       rackfocus frames [options] -- filter 'IN.####.exr' -o "
             "'OUT.####.exr' ...",
    .description =
        "Looks at every frame: is its file there, and is it as it was written, by size "
        "and checksum? A frame that no journal knows is read whole. After --, the "
        "command line that makes the frames: then they must also be made of these "
        "inputs, with these parameters, by this version.\n\n"
        "Lists what is not finished, why, and what to type; the exit status is then 1. "
        "Joins what the processes of a farm wrote down into one file, "
        "OUT.####.exr.frames.",
    .examples = "rackfocus frames 'out.####.exr' --frames 1-240\n"
                "rackfocus frames --html shot.html -- filter 'shot.####.exr' -o "
                "'out.####.exr' --focus-distance 8",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .keeps_rest = true,
    .run = cmd_frames,
};
