/* SPDX-License-Identifier: Apache-2.0 */
/* The luminance that a picture shows as white, of its pixels. */
#ifndef APP_WHITE_H
#define APP_WHITE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct rf_params;
struct settings;

/* Pixels by their luminance, in quarters of a stop; all zeros at first. */
enum { WHITE_STOPS = 48, WHITE_BINS = 4 * WHITE_STOPS };
struct white_tally {
    int64_t bins[WHITE_BINS];
    int64_t n_unlit; /* pixels without light, which are in no bin */
};

/* Counts n packed pixels of 1, 3 or 4 channels. */
void white_tally_add(struct white_tally *tally, const float *samples, size_t n,
                     int n_channels);

/* A power of two: 1 for pictures that can be meant for a white of 1. */
double white_of(const struct white_tally *tally);

/* The same of n packed pixels. */
double white_of_pixels(const float *samples, size_t n, int n_channels);

/* To the nearest power of two, as the core takes it. */
static inline double white_round(double white)
{
    return ldexp(1, (int)lrint(log2(white)));
}

/* Has nobody given it? */
bool white_is_open(const struct settings *settings);

#endif
