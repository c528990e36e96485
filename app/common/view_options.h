/* SPDX-License-Identifier: Apache-2.0 */
/* What the window is asked to show. */
#ifndef APP_VIEW_OPTIONS_H
#define APP_VIEW_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

struct view_options {
    const char *output; /* name that saving begins with; NULL: made from the input's */
    const char *depth_file, *depth_channel, *layer;
    const char *distribution_image;
    const char *reference; /* picture for the difference view */
    const char *params;    /* file of parameters */
    const char *look;      /* of a kind of lens: a name or a file */
    const char *keep;      /* folder for the passes of a POV-Ray scene */
    const char *povray;    /* POV-Ray's program; NULL: as rackfocus povray finds it */
    const char *ocio;      /* configuration of OpenColorIO */
    const char *font, *trace;
    double scale;                       /* of the controls; 0: from the display */
    double exposure;                    /* stops */
    double benchmark_s;                 /* 0: none */
    int32_t depth_repair, mist_falloff; /* as in depth_repair.h */
    int32_t n_views;                    /* of a POV-Ray scene */
    int32_t demo_width, demo_height;    /* px; height 0: 9/16 of the width */
    int32_t demo_views;                 /* accumulated from the start; 0: none */
    int32_t type; /* of EXR files that are saved, enum filter_type */
    int32_t n_threads;
    bool is_demo, is_quiet, is_benchmark_turn;
    bool is_over, is_stereo; /* as of filter */
};

#endif
