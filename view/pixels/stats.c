/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/stats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void stats_start(struct stats *stats, double now_s)
{
    const uint64_t last_id = stats->last_id;
    *stats = (struct stats){.started_s = now_s, .last_id = last_id};
}

void stats_input(struct stats *stats, double at_s)
{
    if (stats->pending_s == 0)
        stats->pending_s = at_s;
}

void stats_change(struct stats *stats, uint64_t id)
{
    stats->input_s[id % 256] = stats->pending_s;
    stats->pending_s = 0;
}

void stats_no_change(struct stats *stats)
{
    stats->pending_s = 0;
}

void stats_shown(struct stats *stats, uint64_t id, double now_s, double filter_ms,
                 double display_ms, bool is_preview, bool is_small)
{
    stats->filter_ms += filter_ms;
    stats->display_ms += display_ms;
    if (id <= stats->last_id)
        return;
    stats->last_id = id;
    const double input_s = stats->input_s[id % 256];
    if (input_s == 0)
        return; /* no input made it: a file was opened */
    if (stats->n == 0)
        stats->first_s = now_s;
    stats->last_s = now_s;
    stats->latency_ms[stats->n % STATS_MAX] = (float)(1000 * (now_s - input_s));
    stats->n++;
    stats->n_previews += is_preview;
    stats->n_small += is_small;
}

void stats_drawn(struct stats *stats, double ms)
{
    stats->draw_ms += ms;
    stats->n_draws++;
}

double stats_rate(const struct stats *stats)
{
    return stats->n > 1 ? (stats->n - 1) / (stats->last_s - stats->first_s) : 0;
}

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

double stats_latency_ms(const struct stats *stats, double share)
{
    const int n = stats->n < STATS_MAX ? stats->n : STATS_MAX;
    float sorted[STATS_MAX];
    if (n == 0)
        return NAN;
    memcpy(sorted, stats->latency_ms, (size_t)n * sizeof(float));
    qsort(sorted, (size_t)n, sizeof(float), compare);
    const int at = (int)ceil(share * n) - 1;
    return sorted[at < 0 ? 0 : at];
}
