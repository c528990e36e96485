/* SPDX-License-Identifier: Apache-2.0 */
/* A run of rackfocus povray, for the parts of the command. */
#ifndef CLI_POVRAY_JOB_H
#define CLI_POVRAY_JOB_H

#include <stdint.h>

#include "commands/povray_command.h"
#include "commands/povray_journal.h"
#include "povray.h"
#include "sources/settings.h"

struct frames_report;

struct povray_job {
    const struct povray_tool *tool;
    struct settings settings;
    struct povray_options options;
    struct povray_scene *scene;
    struct povray_passes passes;
    struct rf_params used;     /* with the facts of the passes */
    char *paths[RF_MAX_VIEWS]; /* of the passes, one per view */
    double started_s;
    int n_pictures;                /* begun */
    struct povray_journal journal; /* of an animation */
    struct povray_journal views;   /* of those that are kept in a folder */
    bool keeps_views;              /* which is open */
    bool has_view[RF_MAX_VIEWS];   /* not to be rendered */
    double view_started_s;
    struct frames_report *report; /* not NULL: nothing is made */
};

/* "out.exr" becomes "out0012.exr", "out_##.exr" "out_12.exr"; a still (frame -1) keeps
 * its name. The caller frees; NULL without memory. */
char *povray_picture_name(const char *name, int32_t frame);

/* Prints why; returns the exit code. */
int povray_fail(const struct povray_error *error);

/* Prints the scene's camera, checked by a small render. An exit code. */
int povray_print_camera(struct povray_job *job);

/* Says which lens it was and what it did. */
void povray_print_lens(const struct povray_job *job);
/* Where the time went, for those who would rather trade it. */
void povray_explain_time(const struct povray_job *job);

/* Renders POV-Ray's own focal blur, writes it where that is asked for, and prints how
 * the output, which took own_s, compares. An exit code. */
int povray_compare_reference(struct povray_job *job, const char *output, double own_s);

#endif
