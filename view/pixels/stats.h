/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How long things take: from input to picture, the filter, the way to 8 bits, drawing.
 * Pure numbers; times are seconds of one clock.
 */
#ifndef VIEW_STATS_H
#define VIEW_STATS_H

#include <stdbool.h>
#include <stdint.h>

#define STATS_MAX 4096

struct stats {
    double input_s[256];    /* when the input came that made the state with this id */
    double pending_s;       /* input whose effect is not known yet; 0: none */
    double started_s;       /* of the counting */
    uint64_t last_id;       /* that was shown */
    double first_s, last_s; /* when the first and the last update was shown */
    int n;                  /* updates: pictures of a newer state that were shown */
    float latency_ms[STATS_MAX];           /* of the last ones */
    double filter_ms, display_ms, draw_ms; /* sums */
    int n_previews, n_draws;
    int n_small; /* previews that were made smaller */
};

void stats_start(struct stats *stats, double now_s);

/* Input came at this time. */
void stats_input(struct stats *stats, double at_s);

/* The state has this id now: what came since the last one made it so. */
void stats_change(struct stats *stats, uint64_t id);

/* What came since then changed nothing: a slider that was held still. */
void stats_no_change(struct stats *stats);

/* A picture of that state is on the screen. */
void stats_shown(struct stats *stats, uint64_t id, double now_s, double filter_ms,
                 double display_ms, bool is_preview, bool is_small);
void stats_drawn(struct stats *stats, double ms);

double stats_rate(const struct stats *stats); /* updates a second */

/* The latency that a share of the updates stayed below, ms; NAN for none. */
double stats_latency_ms(const struct stats *stats, double share);

#endif
