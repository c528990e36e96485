/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The command line of `rackfocus view`. The window is a program of its own,
 * rackfocus-view, so that nothing else of Rack Focus loads SDL and OpenGL; both parse
 * their arguments with this.
 */
#ifndef CLI_CMD_VIEW_H
#define CLI_CMD_VIEW_H

#include "common/view_options.h"
#include "console/options.h"
#include "sources/settings.h"

/* One command line, parsed. */
struct view_call {
    struct view_options options;
    struct settings below_look; /* without what --look says */
    struct settings settings;   /* with what was typed and what --params says */
    struct operands operands;   /* free with operands_free */
};

/* OPTIONS_GO_ON, or the exit code to end with; messages have been printed. */
int view_parse(int argc, char **argv, struct view_call *call);

#endif
