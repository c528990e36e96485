/* SPDX-License-Identifier: Apache-2.0 */
/* Runs of POV-Ray as child processes, several at a time, each in its own folder. */
#ifndef POVRAY_RUN_H
#define POVRAY_RUN_H

#include <stdbool.h>

#include "povray.h"
#include "process.h"

struct run {
    struct os_process process;
    char *folder; /* private, with its slash */
    double started_s, ended_s;
    bool has_picture; /* the picture was complete before the process ended */
    bool ends_itself; /* it writes other files behind its picture */
    bool is_writing;  /* what the scene writes in the run's sandbox is for the user */
};

/* Where a scene that writes files writes them, instead of the current folder: in
 * RUN_SANDBOX within the run's own. */
#define RUN_SANDBOX "work/"
struct run_sandbox {
    char *const *folders; /* where the scene's files are looked for */
    int n_folders;
    const char *copies; /* folder of files that are there when the scene begins */
};

struct run_request {
    const char *temp_folder;    /* with its slash */
    const char *name;           /* of the run's own folder in there */
    const char *scene;          /* file in there */
    const char *before, *after; /* options before the user's, and those that win */
    const struct povray_options *options;
    const struct run_sandbox *sandbox; /* NULL: writes where the user's would */
};

/* Makes the run's folder and starts POV-Ray. */
bool run_start(struct run *run, const struct run_request *request,
               struct povray_error *error);

/* Has it ended, or is its picture complete? Does not wait. */
bool run_has_ended(struct run *run);

/* Waits for all of them; false (and all are stopped) where the user cancelled. */
bool run_wait(struct run *const *runs, int n, const struct povray_options *options,
              struct povray_error *error);

/* Ends the process if it is running, frees the struct's memory. */
void run_stop(struct run *run);

/* Has it ended well? */
bool run_is_good(const struct run *run);

/* Content of a stream file ("debug", "fatal", "warning"); the caller frees. */
char *run_stream(const struct run *run, const char *name);

/* The picture that it wrote; NULL where there is none. The caller frees. */
char *run_picture(const struct run *run);

/* Share of the picture that is rendered so far, from what POV-Ray prints. */
double run_fraction(const struct run *run);

/* Private folder for one job, with its slash; NULL with a message. Removes those of
 * jobs that were killed. */
char *temp_folder_make(struct povray_error *error);
void temp_folder_remove(const char *folder);

/* A few milliseconds. */
void run_pause(void);

#endif
