/* SPDX-License-Identifier: Apache-2.0 */
/* The command line of rackfocus povray. */
#ifndef CLI_POVRAY_COMMAND_H
#define CLI_POVRAY_COMMAND_H

#include <stdbool.h>
#include <stdint.h>

#include "common/frame_list.h"
#include "console/options.h"
#include "povray.h"
#include "sources/settings.h"

struct povray_tool {
    const char *program, *output, *keep, *reference, *focal_point, *look, *frames,
        *distribution_image;
    double aperture, shutter;
    int32_t n_views, n_reference, n_threads; /* n_views 0: not given */
    int32_t n_samples, overscan_px;
    int32_t move;            /* enum povray_move */
    struct povray_stop stop; /* that was typed */
    bool is_linear, is_camera_only, is_quiet, is_strict, has_subpixel;
    bool is_through_glass;
    bool is_average;        /* the method is accumulate */
    bool is_anew;           /* frames that are finished are made again */
    const char *only_views; /* a list of views to render and keep, and no picture */
};

struct povray_frames {
    struct frame_list list;                  /* to make; of a still none */
    int32_t animation_first, animation_last; /* of the whole, which set the clock */
    bool is_animation;
};

/* Checks what was typed, with a message; chooses the number of views. An f-stop becomes
 * the tool's stop. */
bool povray_command_check(struct povray_tool *tool, struct settings *settings,
                          const struct operands *operands);

/* What --frames says wins; else the frames of POV-Ray's own options. False with a
 * message; the list is to be freed in any case. */
bool povray_command_frames(const char *text, const struct povray_plan *plan,
                           struct povray_frames *frames);

/* Refuses outputs that are the scene, its includes or the pictures that it names, with a
 * message. An enum exit_code. */
int povray_command_spares(const struct povray_tool *tool,
                          const struct povray_plan *plan,
                          const struct povray_frames *frames);

/* Runs the command, as filter_command_run() does (filter_command.h). */
struct frames_report;
int povray_command_run(int argc, char **argv, struct frames_report *report);

/* What the glue needs to know of the command line. False with a message. */
bool povray_command_plan(const struct povray_tool *tool,
                         const struct settings *settings,
                         const struct povray_plan *plan, struct povray_options *made);

#endif
