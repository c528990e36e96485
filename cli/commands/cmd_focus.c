/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus focus: how far away is what a pixel shows, and the pull from one to another.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/frame_list.h"
#include "common/outputs.h"
#include "common/text_file.h"
#include "console/cli.h"
#include "sources/focus_pick.h"
#include "sources/settings.h"
#include "sources/source.h"

struct focus_options {
    const char *output, *depth_file, *depth_channel, *layer;
    int32_t easing;
};

#define AT(member) offsetof(struct focus_options, member)
#define EASINGS "hold|linear|ease-in|ease-out|ease-in-out"

static const struct option options[] = {
    {.name = "output",
     .letter = 'o',
     .kind = OPTION_FILE,
     .offset = AT(output),
     .value = "FILE.csv",
     .help = "Sequence: the file to write, for filter --frame-parameters. [default "
             "standard output]"},
    OPTION_CHOICE_ROW("easing", AT(easing), "KIND", EASINGS,
                      "Sequence: how the focus goes from one pick to the next. "
                      "[default ease-in-out]"),
    OPTION_DEPTH_FILE_ROW(AT(depth_file)),
    OPTION_DEPTH_CHANNEL_ROW(AT(depth_channel)),
    OPTION_LAYER_ROW(AT(layer), "look at"),
    OPTION_HELP_ROW,
};

/* What was picked: "48@500,120", in one picture "500,120". */
struct pick {
    int32_t frame;
    struct focus_place place;
    double distance;
};

static bool parse_pick(const char *text, bool is_sequence, struct pick *pick)
{
    const char *at = strchr(text, '@');
    char number[16] = "";
    int used = 0;
    if (at && at - text < (int)sizeof(number))
        memcpy(number, text, (size_t)(at - text));
    const char *place = at ? at + 1 : text;
    if (is_sequence == (at != NULL) &&
        (!at || frame_number_parse(number, &pick->frame)) &&
        sscanf(place, "%lf,%lf%n", &pick->place.x, &pick->place.y, &used) == 2 &&
        place[used] == '\0')
        return true;
    message("'%s' is no pick; %s; see rackfocus focus --help", text,
            is_sequence ? "give frame and pixel, as in 48@500,120"
                        : "give a pixel, as in 500,120");
    return false;
}

/* Picks of one command: the settings, and who is told of doubts, once of each. */
struct measuring {
    const struct focus_options *tool;
    const struct settings *settings;
    struct cli_host cli;
    const struct app_host *host;
};

static int measure(const struct measuring *m, char *pattern, bool is_sequence,
                   struct pick *pick)
{
    const struct focus_options *tool = m->tool;
    struct image_error error;
    char *path = is_sequence ? frame_name(pattern, pick->frame, &error) : pattern;
    char *depth_file = tool->depth_file && is_sequence
                           ? frame_name(tool->depth_file, pick->frame, &error)
                           : (char *)tool->depth_file;
    bool is_good = path && (depth_file || !tool->depth_file);
    const struct source_request request = {.paths = &path,
                                           .n_paths = 1,
                                           .layer = tool->layer,
                                           .depth_file = depth_file,
                                           .depth_channel = tool->depth_channel};
    const struct focus_request wanted = {&request, pick->place, m->host};
    is_good = is_good && focus_pick(&wanted, m->settings, &pick->distance, &error);
    if (is_sequence) {
        free(path);
        free(depth_file);
    }
    if (is_good)
        return EXIT_DONE;
    message("%s", error.message);
    return EXIT_FAILED;
}

/* What is picked, in the order of the frames. */
struct pull {
    const struct focus_options *tool;
    const struct pick *picks;
    int n;
};

static void print_csv(FILE *file, const void *data)
{
    static const char *const words[] = {"hold", "linear", "ease-in", "ease-out",
                                        "ease-in-out"};
    const struct pull *pull = data;
    fprintf(file, "frame,focus-distance,easing\n");
    for (int i = 0; i < pull->n; i++)
        fprintf(file, "%d,%.9g,%s\n", (int)pull->picks[i].frame,
                pull->picks[i].distance, words[pull->tool->easing]);
}

static int write_csv(const struct pull *pull)
{
    struct image_error error;
    if (!pull->tool->output) {
        print_csv(stdout, pull);
        return EXIT_DONE; /* main() looks whether it could be written */
    }
    if (text_file_write(pull->tool->output, print_csv, pull, &error))
        return EXIT_DONE;
    message("%s", error.message);
    return EXIT_FAILED;
}

/* The table must be none of the frames, whether they are picked from or not. */
static int check_output(const struct focus_options *tool, const char *pattern)
{
    struct image_error error;
    struct frame_list list;
    if (!tool->output || !frame_list_find(&list, pattern, &error))
        return EXIT_DONE; /* to measure says what is not there */
    struct outputs outputs = {.frames = &list, .error = &error};
    outputs_add(&outputs, "output", tool->output);
    outputs_spare(&outputs, NULL, pattern);
    outputs_spare(&outputs, "depth-file", tool->depth_file);
    frame_list_free(&list);
    return exit_code(outputs.code, &error);
}

static int compare_picks(const void *a, const void *b)
{
    const int32_t x = ((const struct pick *)a)->frame;
    const int32_t y = ((const struct pick *)b)->frame;
    return (x > y) - (x < y);
}

static int run(const struct focus_options *tool, const struct settings *settings,
               const struct operands *operands, struct pick *picks)
{
    char *input = operands->items[0];
    const bool is_sequence = frame_is_pattern(input);
    const int n = operands->n - 1;
    if (!is_sequence && (tool->output || n != 1)) {
        message(
            "focus: '%s' is one picture, and takes one pick and no --output; name a "
            "sequence with # for the digits of the number, as in 'shot.####.exr'",
            input);
        return EXIT_USAGE;
    }
    for (int i = 0; i < n; i++)
        if (!parse_pick(operands->items[i + 1], is_sequence, &picks[i]))
            return EXIT_USAGE;
    struct measuring m = {.tool = tool, .settings = settings};
    m.host = cli_host_open(&m.cli, false, false);
    int code = check_output(tool, input);
    for (int i = 0; i < n && code == EXIT_DONE; i++)
        code = measure(&m, input, is_sequence, &picks[i]);
    if (code != EXIT_DONE)
        return code;
    qsort(picks, (size_t)n, sizeof(*picks), compare_picks);
    for (int i = 1; i < n; i++)
        if (picks[i].frame == picks[i - 1].frame) {
            message("frame %d has two picks; a focus is one distance",
                    (int)picks[i].frame);
            return EXIT_USAGE;
        }
    if (is_sequence)
        return write_csv(&(struct pull){tool, picks, n});
    printf("--focus-distance %.9g\n", picks[0].distance);
    return EXIT_DONE;
}

static int cmd_focus(int argc, char **argv)
{
    enum { EASE_IN_OUT = 4 };
    struct focus_options tool = {.easing = EASE_IN_OUT};
    struct settings settings;
    struct operands operands;
    int code = options_parse(&command_focus, argc, argv, &tool, &settings, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    code = EXIT_USAGE;
    struct pick *picks = app_memory((size_t)operands.n + 1, sizeof(*picks), NULL);
    if (!picks)
        code = exit_without_memory();
    else if (operands.n < 2)
        message("focus takes a file or a sequence, and what to pick in it, as in "
                "'shot.####.exr' 1@320,200 48@500,120; see rackfocus focus --help");
    else
        code = run(&tool, &settings, &operands, picks);
    free(picks);
    operands_free(&operands);
    return code;
}

const struct command command_focus = {
    .name = "focus",
    .summary = "measure distances at pixels, for focus pulls",
    .usage = "'SHOT.####.exr' FRAME@X,Y ... [-o FOCUS.csv] [options]\n"
             "       rackfocus focus IN.exr X,Y [options]",
    .description =
        "Measures how far away is what the pixel shows that lies X to the right of the "
        "picture's upper left corner and Y below it: the median of 3 x 3 px, as "
        "distance along the camera's axis. Of a sequence it writes a row per pick, "
        "which filter --frame-parameters takes as key frames of the focus.",
    .examples = "rackfocus focus 'shot.####.exr' 1@320,200 48@500,120 -o focus.csv\n"
                "rackfocus filter 'shot.####.exr' -o 'out.####.exr' "
                "--frame-parameters focus.csv\n"
                "rackfocus focus passes.exr 320,200",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .takes_params = true,
    .run = cmd_focus,
};
