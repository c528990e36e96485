/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depth as renderers write it, made fit for use: what can be undone is undone and said,
 * what cannot be known is refused with the reason.
 */
#ifndef APP_DEPTH_REPAIR_H
#define APP_DEPTH_REPAIR_H

#include <stdbool.h>

#include "depth_stats.h"
#include "settings.h"
#include "source.h"

enum depth_repair { DEPTH_REPAIR_AUTO, DEPTH_REPAIR_OFF };
/* Blender's Mist pass, t in 0 to 1 from start to end: t, t^2 or sqrt(t). */
enum mist_falloff { MIST_NONE, MIST_LINEAR, MIST_QUADRATIC, MIST_INVERSE };

#define DEPTH_REPAIR_CHOICES "auto|off"
#define MIST_CHOICES "none|linear|quadratic|inverse-quadratic"

/* What is seen in a depth, and what filter would do about it. */
struct depth_findings {
    struct depth_stats stats;
    bool is_premultiplied, is_mixed;
    bool is_half;        /* 16 bit */
    double half_step_px; /* largest step of the radius that 16 bit make, 0: unknown */
    bool is_mist;        /* the channel's name says so */
    bool is_kind_open;   /* nobody said which kind of depth it is */
};

/* `alpha` (may be NULL) has `stride` floats from pixel to pixel. False without memory.
 */
bool depth_find(struct depth_findings *found, const struct source *source,
                const struct settings *settings, const struct rf_lens *lens,
                const float *depth, const float *alpha, size_t stride);

/* The same from what was measured. */
void depth_judge(struct depth_findings *found, const struct source *source,
                 const struct settings *settings, const struct rf_lens *lens,
                 const struct depth_stats *stats);

/* Why the depth cannot be used as it is, into `text`; false: it can. */
bool depth_is_refused(const struct depth_findings *found, char *text, size_t n_bytes);

/* Undoes the mist's falloff, in place. */
void depth_undo_mist(float *depth, size_t n, enum mist_falloff falloff);
/* Divides by alpha; 0 where there is none. Returns how many pixels changed. */
size_t depth_divide_by_alpha(float *depth, const float *alpha, size_t stride, size_t n);
/* Gives pixels whose depth lies between those of two flat sides the nearer of the two
 * depths, and adds how many to *n_changed. False without memory. What a pixel gets
 * depends on those within DEPTH_SNAP_REACH in its row and its column, and on its
 * neighbours. */
enum { DEPTH_SNAP_REACH = DEPTH_STEP_PIXELS + 1 };
bool depth_snap(float *depth, int32_t width, int32_t height, double infinity,
                size_t *n_changed);

#endif
