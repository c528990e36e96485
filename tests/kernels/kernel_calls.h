/* SPDX-License-Identifier: Apache-2.0 */
/* Every kernel as a function that calls it on a workspace; see test_kernels.c. */
#ifndef KERNEL_CALLS_H
#define KERNEL_CALLS_H

#include <stdint.h>

#include "base/math.h"
#include "kernels/data.h"
#include "kernels/hidden_kernels.h"
#include "kernels/kernels.h"
#include "kernels/sight_kernels.h"

enum { WORK_FLOATS = 1 << 17, N_SPLATS = 64, N_FOOTPRINTS = 4, MAX_SEGMENTS = 32 };
enum { ACC_FLOATS = 3 * RF_TILE_H * RF_MAX_PLANES * RF_ACC_STRIDE };
enum { N_BLOCKS = 24, SHADOWS_W = 61, SHADOWS_H = 47, BACKS_W = 128, BACKS_H = 64 };
enum { SIGHT_W = 48, SIGHT_H = 24 };

/* Everything that a kernel may read or write. */
struct workspace {
    float at[WORK_FLOATS];
    struct rf_spread_sums acc;
};

/* The same for all levels and runs. */
struct given {
    struct rf_splat splats[N_SPLATS];
    struct rf_footprint footprints[N_FOOTPRINTS];
    struct rf_footprint *pointers[N_FOOTPRINTS];
    struct rf_segment segments[N_FOOTPRINTS][MAX_SEGMENTS];
    float weights[N_FOOTPRINTS][(MAX_SEGMENTS + 1) * 24];
    float factors[3 * RF_N_SLANTS]; /* of two cells and what they have in common */
};

extern struct given given;

void make_given(void);

/* Of noise(), which is in [0, 1). */
extern uint32_t seed;
float noise(void);

/* Variants differ in alignment, numbers of planes, levels and the like. */
struct kernel {
    const char *name;
    void (*call)(const struct rf_kernels *kernels, struct workspace *w, int variant);
    int n_variants;
    void (*prepare)(struct workspace *w); /* NULL: noise will do */
};

extern const struct kernel kernels[];
extern const int n_kernels;

/* ---- what some of them are given ------------------------------------------------ */

struct rf_spread_sums *make_accumulator(struct workspace *w, int n_planes);

/* A light at the pixel (40, 30), with one view or two. */
struct rf_shadows shadows_of(struct workspace *w, int variant);

struct rf_backs backs_of(struct workspace *w);

/* The first n blocks for a group that a query belongs to. */
struct rf_hidden_group group_of(const struct rf_hidden_query *query, int n);

/* A query for the group of 4 x 4 pixels number i, which may find something or not. */
struct rf_hidden_query group_query(int i);

struct rf_sight sight_of(const struct workspace *w);
struct rf_sight_places places_of(const struct workspace *w, int variant);

/* What call_vote() leaves. */
struct vote_result {
    int is_found, n, d2;
    float r;
    int32_t room[RF_HIDDEN_VOTES];
    float weight[RF_HIDDEN_VOTES], histogram[RF_HIDDEN_BINS];
};

void call_vote(const struct rf_kernels *k, struct workspace *w, int variant);
void call_window(const struct rf_kernels *k, struct workspace *w, int variant);

#endif
