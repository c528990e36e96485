/* SPDX-License-Identifier: Apache-2.0 */
/* What the search for hidden background (hidden.c) and its inner loops share. */
#ifndef RF_HIDDEN_KERNELS_H
#define RF_HIDDEN_KERNELS_H

#include <stddef.h>
#include <stdint.h>

enum {
    RF_HIDDEN_BLOCK = 8,
    RF_HIDDEN_BINS = 512,
    RF_HIDDEN_STEPS = 8, /* of the window, to each side */
    RF_HIDDEN_GROUP = 4, /* px a side: pixels that are looked at together */
    RF_HIDDEN_NEIGHBOURS = 4 * (RF_HIDDEN_STEPS + 1) * (RF_HIDDEN_STEPS + 1),
    RF_HIDDEN_ROOM = RF_HIDDEN_NEIGHBOURS + 8, /* some more than a window has */
    RF_HIDDEN_REACH = 60, /* px that candidates are away at the most */
    RF_HIDDEN_RINGS = RF_HIDDEN_REACH / RF_HIDDEN_BLOCK + 1, /* of blocks around one */
    RF_HIDDEN_BLOCKS = (2 * RF_HIDDEN_RINGS + 1) * (2 * RF_HIDDEN_RINGS + 1),
    /*
     * Candidates: all pixels of the nearest blocks, every 4th of both axes of those
     * beyond, and eight more.
     */
    RF_HIDDEN_VOTES = 9 * 64 + (RF_HIDDEN_BLOCKS - 9) * 4 + 8,
};

static const float RF_HIDDEN_BIN_PX = 0.5f;

/*
 * The radii of the surfaces that pixels show behind others, -INFINITY where those are
 * unreliable and for RF_HIDDEN_BLOCK floats after each row.
 */
struct rf_backs {
    int width, height;
    size_t stride;
    int x, y; /* the first pixel's place, which decides on pixels that are read */
    float *r;
};

struct rf_hidden_query {
    int x, y;
    float s;              /* radius of the near surface */
    float inv_x2, inv_y2; /* 1 / extent of the aperture, squared */
};

/* A block that may hold candidates. */
struct rf_hidden_block {
    int16_t x, y;
    int ring;      /* distance in blocks from the queries' block */
    float highest; /* radius in it */
    /*
     * Neither this block nor one that follows has candidates for a pixel of that radius
     * or of more.
     */
    float most;
};

/* A block that may hold candidates of a group. */
struct rf_hidden_hit {
    int16_t block;
    int16_t rows; /* a bit for each row that may */
};

/*
 * RF_HIDDEN_GROUP x RF_HIDDEN_GROUP pixels that are searched one after the
 * other. What one of them has learnt of the blocks serves the next.
 */
struct rf_hidden_group {
    struct rf_hidden_query query; /* of the first pixel, with the least radius of all */
    int n_blocks, n_seen, n_hits;
    const struct rf_hidden_block *blocks; /* by ring */
    struct rf_hidden_hit *hits;           /* of the first n_seen blocks; room for all */
};

/*
 * The candidates of a pixel, which vote for a radius: r - s as bits of a float, the
 * squared distance as such bits, the weight, the bin; and the histogram over r - s, two
 * spare bins before it, which is 0 between the votes.
 */
struct rf_hidden_vote {
    int n, nearest; /* squared distance of the nearest candidate */
    int32_t room[RF_HIDDEN_VOTES], d2[RF_HIDDEN_VOTES], bin[RF_HIDDEN_VOTES];
    float weight[RF_HIDDEN_VOTES];
    float histogram[2 + RF_HIDDEN_BINS + 16];
};

/*
 * Pixels of a window with their weights. What lies beyond the n-th is not defined, but
 * for weights: those are 0 up to the next multiple of eight.
 */
struct rf_hidden_window {
    int n;
    float weight_sum, r_sum;       /* of weights, of radii times weight */
    int32_t index[RF_HIDDEN_ROOM]; /* of the pixel, width x height */
    float weight[RF_HIDDEN_ROOM];
};

#endif
