/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A progress bar with the time left, on stderr where that is a terminal that moves its
 * cursor.
 *
 *     struct progress bar;
 *     progress_start(&bar, "filtering", is_quiet);
 *     const struct rf_progress report = {progress_report, &bar};
 *     ... rf_filter_process(..., &report, ...);
 *     progress_end(&bar);
 */
#ifndef CLI_PROGRESS_H
#define CLI_PROGRESS_H

#include <stdbool.h>

struct progress {
    const char *label;
    bool is_shown;
    int n_drawn;               /* letters on the line */
    double started_s, drawn_s; /* seconds of the monotonic clock */
};

void progress_start(struct progress *bar, const char *label, bool is_quiet);

/* For struct rf_progress: draws, and returns false once the program was interrupted
 * (interrupt.h). */
bool progress_report(void *bar, double fraction);

/* Wipes the bar, so that nothing of it is left on the terminal. */
void progress_end(struct progress *bar);

#endif
