/* SPDX-License-Identifier: Apache-2.0 */
/* The background that only the lens can see, estimated. */
#ifndef RF_SURFACES_HIDDEN_H
#define RF_SURFACES_HIDDEN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/task.h"
#include "input/frame.h"
#include "kernels/data.h"
#include "surfaces/insides.h"
#include "rackfocus/rackfocus.h"

/*
 * Who knows better than an estimate: does anyone show what lies behind pixel (x, y), if
 * it is of radius r? Any thread asks.
 */
struct rf_known {
    bool (*is_shown)(void *user, int x, int y, float r);
    void *user;
};

/* What lies behind the near surfaces of a picture, where that was found. */
struct rf_estimates {
    struct rf_insides insides;
    int width;             /* of the picture */
    struct rf_surface *at; /* packed */
    uint8_t *found;        /* a bit for each pixel, rows in whole bytes and some more */
};

static inline size_t rf_found_stride(int width)
{
    return (size_t)width / 8 + 10;
}

/* A bit for each of n <= 64 pixels from (x, y) on: was anything found? */
static inline uint64_t rf_found_at(const struct rf_estimates *e, int x, int y, int n)
{
    const uint8_t *at = e->found + rf_found_stride(e->width) * (size_t)y + x / 8;
    uint64_t bits = 0;
    for (int i = 0; i < 8; i++)
        bits |= (uint64_t)at[i] << 8 * i;
    bits >>= x % 8;
    if (x % 8)
        bits |= (uint64_t)at[8] << (64 - x % 8);
    return bits & UINT64_MAX >> (64 - n);
}

/*
 * The radii of the near surfaces as a plane, INFINITY where their share is not above
 * RF_OCCLUDER_SHARE. RF_ROW_MARGIN floats after each row repeat its last one.
 */
struct rf_radii {
    float *at; /* of the first pixel */
    size_t stride;
};

/*
 * Estimates what lies behind the near surface of each pixel (hidden.c). `radii` (or
 * NULL: not at hand) change while it works. Around pixels for which `known` (or NULL)
 * shows what lies behind nothing is estimated. Afterwards, and when it fails, the
 * estimates are to be freed.
 */
rf_result rf_find_hidden(const struct rf_frame *frame,
                         const struct rf_surfaces *surfaces,
                         const struct rf_radii *radii, const struct rf_known *known,
                         struct rf_estimates *estimates, struct rf_task *task,
                         struct rf_error *error);

void rf_estimates_free(struct rf_estimates *e, const struct rf_context *context);

/* How often rf_find_hidden() steps its task for a picture of that height. */
int rf_hidden_steps(int height);

#endif
