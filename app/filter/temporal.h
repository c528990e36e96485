/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Neighbouring frames as further evidence: what one frame hides, those before and after
 * may show. Their pixels are moved to where they lie in the frame, by the cameras'
 * matrices (worldToCamera in the headers) or by a pass of motion vectors, and those
 * behind its surfaces are handed to the core as known (rf_view.behind_colour).
 */
#ifndef APP_TEMPORAL_H
#define APP_TEMPORAL_H

#include <stdint.h>

#include "rackfocus/rackfocus.h"

struct settings;
struct run;

/* Surfaces of one place differ by less, px of radius, as between views. Ours. */
static const float TEMPORAL_SAME_PX = 0.8f;

/* Frames on each side of one: at most, and what a shot takes. On the camera move of
 * tests/farm/measure_flicker.py one gives flicker 0.0242, two 0.0198, three 0.0189 and
 * more no less. */
enum { TEMPORAL_MOST = 8, TEMPORAL_OF_SHOTS = 3 };

/* A frame that is there beside the one that is made. */
struct temporal_frame {
    int32_t offset; /* of its number: 1 is the next */
    char *paths[RF_MAX_VIEWS];
    int n_paths;               /* as many as the frame has */
    char *depth_file;          /* or NULL */
    struct settings *settings; /* as typed for that frame, without any header */
};

struct temporal_frames {
    int n;
    struct temporal_frame at[2 * TEMPORAL_MOST]; /* nearest first */
};

/*
 * Finds what the views of a run hide, once their pixels are read: sets
 * run->behind. APP_DONE where --temporal is off. An enum app_code.
 */
int temporal_find(struct run *run);

/* What view i hides, for the core; `view` is left as it is where nothing is known. */
void temporal_set_behind(const struct run *run, int i, struct rf_view *view);

void temporal_free(struct run *run);

#endif
