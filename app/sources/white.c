/* SPDX-License-Identifier: Apache-2.0 */
/*
 * With p_q the luminance that a share q of the pixels with light stays below:
 *
 *   white = 2 p_99     where p_99 < 1/8: next to nothing of it would be shown as bright
 *           4 p_50     where p_50 > 4: more than half of it would be white
 *           1          else, and where fewer than 1/32 of a picture whose p_50 > 4 have
 *                      light: lamps on black
 *
 * to the nearest power of two. p_99 is 0.4 to 0.9 in renders of one view that are meant
 * for a white of 1, p_50 0.05 to 0.4; lamps are fewer than one pixel of a hundred. Ours.
 * Worth: docs/notebook/exposure.md.
 */
#include "sources/white.h"

#include <math.h>

#include "common/luminance.h"
#include "sources/settings.h"

static const double DARK = 0.125, BRIGHT = 4;

/* Lamps on black, 0.003 to 2 % of the pixels: 20 to 41 dB with a white of 4 p_50, 50 to 77
 * with 1; no smooth thing on black that small has less with 1 (docs/notebook/exposure.md). */
static const double FEWEST_LIT = 1.0 / 32;

/* Luminances from 2^-24 on, to 2^24. */
static int bin_of(float luminance)
{
    static const float quarters[] = {0.59460354f, 0.70710677f, 0.8408964f};
    int exponent, bin;
    const float fraction = frexpf(luminance, &exponent); /* 1/2 to 1 */
    bin = 4 * (exponent - 1 + WHITE_STOPS / 2);
    for (int i = 0; i < 3; i++)
        bin += fraction >= quarters[i];
    return bin < 0 ? 0 : bin >= WHITE_BINS ? WHITE_BINS - 1 : bin;
}

void white_tally_add(struct white_tally *tally, const float *samples, size_t n,
                     int n_channels)
{
    const size_t step = (size_t)n_channels;
    for (size_t i = 0; i < n; i++) {
        const float luminance = luminance_of(samples + i * step, n_channels);
        if (luminance > 0 && isfinite(luminance))
            tally->bins[bin_of(luminance)]++;
        else
            tally->n_unlit++;
    }
}

static double count_lit(const struct white_tally *tally)
{
    double all = 0;
    for (int i = 0; i < WHITE_BINS; i++)
        all += (double)tally->bins[i];
    return all;
}

/* The bin that a share of the pixels with light stays below or is in. */
static int bin_at(const struct white_tally *tally, double share)
{
    const double all = count_lit(tally);
    double sum = 0;
    for (int i = 0; i < WHITE_BINS; i++) {
        sum += (double)tally->bins[i];
        if (sum >= share * all)
            return i;
    }
    return WHITE_BINS - 1;
}

/* Stops of the middle of a bin. */
static double stops_of(int bin)
{
    return (bin + 0.5) / 4 - WHITE_STOPS / 2.0;
}

double white_of(const struct white_tally *tally)
{
    const int high = bin_at(tally, 0.99), middle = bin_at(tally, 0.5);
    const double n_lit = count_lit(tally), n_all = n_lit + (double)tally->n_unlit;
    double stops = 0;
    if (high > 0 && stops_of(high) < log2(DARK))
        stops = stops_of(high) + 1;
    else if (stops_of(middle) > log2(BRIGHT) && n_lit >= FEWEST_LIT * n_all)
        stops = stops_of(middle) + 2;
    return ldexp(1, (int)fmax(fmin(lrint(stops), 19), -19));
}

double white_of_pixels(const float *samples, size_t n, int n_channels)
{
    struct white_tally tally = {.n_unlit = 0};
    white_tally_add(&tally, samples, n, n_channels);
    return white_of(&tally);
}

bool white_is_open(const struct settings *settings)
{
    return settings_origin(settings, "white") == ORIGIN_DEFAULT;
}
