/* SPDX-License-Identifier: Apache-2.0 */
/* What `rackfocus frames` found: on the terminal, as JSON, as a page. */
#ifndef CLI_FRAMES_PRINT_H
#define CLI_FRAMES_PRINT_H

#include <stdbool.h>

#include "commands/command_line.h"
#include "sequence/frames_check.h"

/* Frames that are not finished and the sum; how to make them where `line` has a command.
 * Quiet: the frames alone. */
void frames_print_text(const struct frames_report *report,
                       const struct command_line *line, bool is_quiet);

void frames_print_json(const struct frames_report *report);

/* A page with a contact sheet; its pictures go into the folder "NAME_frames" beside it,
 * where NAME is `path` without its ending. False with the error. */
bool frames_write_html(const struct frames_report *report, const char *path,
                       struct image_error *error);

#endif
