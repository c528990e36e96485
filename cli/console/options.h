/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Command line options: a table per sub-command for what the tool itself needs, and
 * every parameter of params.def, taken from rf_param_list().
 *
 * Forms: `--key value`, `--key=value`, `-o value`, `-ovalue`; flags `--key`, `-q`.
 * A boolean parameter is `--key`, `--no-key` or `--key=false`. `--` ends the options.
 */
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/operands.h"

struct command;
struct settings;

enum option_kind {
    OPTION_FLAG,   /* bool, set to true */
    OPTION_TEXT,   /* const char * */
    OPTION_FILE,   /* const char *; completes to file names */
    OPTION_INT,    /* int32_t from min to max */
    OPTION_NUMBER, /* double from min to max */
    OPTION_CHOICE, /* int32_t, the index in choices */
};

/* One option of a tool. The value is stored at `offset` in the tool's own struct. */
struct option {
    const char *name; /* "output": --output */
    char letter;      /* 'o': -o; 0 for none */
    enum option_kind kind;
    size_t offset;
    const char *value; /* what help shows for the value, "FILE"; NULL for flags */
    const char *help;  /* a sentence */
    double min, max;
    const char *choices; /* "half|float" */
};

/* What options_parse returns where the command is to go on. */
#define OPTIONS_GO_ON (-1)

/*
 * Parses the arguments of a sub-command into `values` (its own struct, defaults already
 * set), `settings` (parameters; NULL where it takes none) and `operands`. --help is
 * answered here. Returns OPTIONS_GO_ON or the exit code to end with; messages have been
 * printed then and there is nothing to free.
 */
int options_parse(const struct command *command, int argc, char **argv, void *values,
                  struct settings *settings, struct operands *operands);

/* Was the command's own option of this name given, with whatever value? */
bool options_given(const struct operands *operands, const char *name);

/* Warns of a text that was given twice, and differently, as options_parse() does but for
 * commands that are handed over. OPTIONS_GO_ON, or with --strict EXIT_USAGE. */
int options_warn_twice(const struct operands *operands);

void operands_free(struct operands *operands);

/* False with a message where an operand of a command that reads one frame names the
 * frames of a sequence, as in.####.exr, and no file. */
bool options_are_of_one_frame(const struct operands *operands, const char *command);

/* Why OPTION_PIXEL_FILTER_ROWS' options do not go with the others, or NULL. `kind` is an
 * enum filter_pixels. */
const char *options_refuse_pixel_filter(const struct operands *operands,
                                        int32_t supersample, int32_t kind);

/* The candidate most like `name`, or NULL where none is near. */
const char *nearest_name(const char *name, const char *const *candidates, size_t n);

/*
 * Rows of the tables. `key` is the option's name, `at` where its value is stored (the
 * offset), `what` how help calls the value, `text` the help: a sentence.
 */
#define OPTION_FLAG_ROW(key, at, text)                                                 \
    {                                                                                  \
        .name = key, .kind = OPTION_FLAG, .offset = at, .help = text                   \
    }
#define OPTION_TEXT_ROW(key, at, what, text)                                           \
    {                                                                                  \
        .name = key, .kind = OPTION_TEXT, .offset = at, .value = what, .help = text    \
    }
#define OPTION_FILE_ROW(key, at, what, text)                                           \
    {                                                                                  \
        .name = key, .kind = OPTION_FILE, .offset = at, .value = what, .help = text    \
    }
#define OPTION_CHOICE_ROW(key, at, what, names, text)                                  \
    {                                                                                  \
        .name = key, .kind = OPTION_CHOICE, .offset = at, .value = what,               \
        .choices = names, .help = text                                                 \
    }
#define OPTION_INT_ROW(key, at, what, least, most, text)                               \
    {                                                                                  \
        .name = key, .kind = OPTION_INT, .offset = at, .value = what, .min = least,    \
        .max = most, .help = text                                                      \
    }
#define OPTION_NUMBER_ROW(key, at, what, least, most, text)                            \
    {                                                                                  \
        .name = key, .kind = OPTION_NUMBER, .offset = at, .value = what, .min = least, \
        .max = most, .help = text                                                      \
    }

/* Rows that several sub-commands share. */
#define OPTION_OUTPUT_ROW(at, text)                                                    \
    {                                                                                  \
        .name = "output", .letter = 'o', .kind = OPTION_FILE, .offset = at,            \
        .value = "FILE", .help = text                                                  \
    }
#define OPTION_DEPTH_FILE_ROW(at)                                                      \
    OPTION_FILE_ROW("depth-file", at, "FILE.exr", "File that has the depth.")
#define OPTION_DEPTH_CHANNEL_ROW(at)                                                   \
    OPTION_TEXT_ROW("depth-channel", at, "NAME",                                       \
                    "Channel that has the depth, by its full name.")
#define OPTION_LAYER_ROW(at, verb)                                                     \
    OPTION_TEXT_ROW("layer", at, "NAME", "Layer to " verb " where a file has several.")
#define OPTION_HELP_ROW                                                                \
    {                                                                                  \
        .name = "help", .letter = 'h', .kind = OPTION_FLAG, .help = "Show this help."  \
    }
#define OPTION_QUIET_ROW(at)                                                           \
    {                                                                                  \
        .name = "quiet", .letter = 'q', .kind = OPTION_FLAG, .offset = (at),           \
        .help = "No progress bar and no warnings."                                     \
    }
#define OPTION_STRICT_ROW(at)                                                          \
    OPTION_FLAG_ROW("strict", at,                                                      \
                    "Warnings are errors: nothing is written where one is due.")
#define OPTION_DISTRIBUTION_ROW(at)                                                    \
    OPTION_FILE_ROW("distribution-image", at, "FILE",                                  \
                    "Method scatter: picture of the aperture, EXR or PNG of any "      \
                    "size, as the camera sees it; implies --distribution image.")
#define OPTION_DENOISE_QUALITY_ROW(at)                                                 \
    OPTION_CHOICE_ROW("denoise-quality", at, "KIND", DENOISE_QUALITIES,                \
                      "Of Open Image Denoise's filters, as in Cycles: high, balanced " \
                      "or fast; they take about 1, 0.5 and 0.4 of the time. "          \
                      "[default high]")
#define OPTION_PIXEL_FILTER_ROWS(at, at_width)                                         \
    OPTION_CHOICE_ROW("pixel-filter", at, "KIND", FILTER_PIXELS_CHOICES,               \
                      "With --supersample: the renderer's pixel filter, which the "    \
                      "picture gets as if it was rendered in its size: "               \
                      "blackman-harris, gaussian, or box, the mean of N x N pixels. "  \
                      "[default blackman-harris]"),                                    \
        OPTION_NUMBER_ROW("pixel-filter-width", at_width, "PX", 0.01,                  \
                          FILTER_MOST_PIXELS_WIDTH,                                    \
                          "Its width in pixels of the passes, as Cycles names it: "    \
                          "half of the whole. [default 1.5]")
#define OPTION_GUIDE_FILE_ROWS(at_albedo, at_normal)                                   \
    OPTION_FILE_ROW("albedo-file", at_albedo, "FILE.exr",                              \
                    "The albedo for the denoiser, where it is a file of its own."),    \
        OPTION_FILE_ROW("normal-file", at_normal, "FILE.exr",                          \
                        "The normals, likewise; with --albedo-file.")
#define OPTION_THREADS_ROW(at)                                                         \
    {                                                                                  \
        .name = "threads", .letter = 'j', .kind = OPTION_INT, .offset = (at),          \
        .value = "COUNT", .min = 0, .max = 1024,                                       \
        .help = "Threads; 0 is one per processor. The result does not depend on it. "  \
                "[default 0]"                                                          \
    }

#endif
