/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The command line of `rackfocus view`. The window is a program of its own,
 * rackfocus-view, so that nothing else of Rack Focus loads SDL and OpenGL; both parse
 * their arguments with this.
 */
#ifndef CLI_CMD_VIEW_H
#define CLI_CMD_VIEW_H

#include <stdbool.h>
#include <stdint.h>

#include "options.h"
#include "settings.h"

struct view_options {
    const char *output; /* name that saving begins with; NULL: made from the input's */
    const char *depth_file, *depth_channel, *layer;
    const char *distribution_image;
    const char *reference; /* picture for the difference view */
    const char *params;    /* file of parameters */
    const char *keep;      /* folder for the passes of a POV-Ray scene */
    const char *font, *trace;
    double scale;                       /* of the controls; 0: from the display */
    double exposure;                    /* stops */
    double benchmark_s;                 /* 0: none */
    int32_t depth_repair, mist_falloff; /* as in depth_repair.h */
    int32_t n_views;                    /* of a POV-Ray scene */
    int32_t demo_width;                 /* px; the height follows */
    int32_t n_threads;
    bool is_demo, is_quiet, is_benchmark_turn;
};

/* One command line, parsed. */
struct view_call {
    struct view_options options;
    struct settings settings; /* with what was typed and what --params says */
    struct operands operands; /* free with operands_free */
};

/* OPTIONS_GO_ON, or the exit code to end with; messages have been printed. */
int view_parse(int argc, char **argv, struct view_call *call);

/* Is this the name of a POV-Ray scene? */
bool view_is_scene(const char *path);

#endif
