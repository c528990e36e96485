/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Highlights under the artist's control. With c a pixel's light, M its largest channel
 * and Y() luminance:
 *
 *   c  <- c min(1, k / M)                 clamp k, for stray samples; 0: none
 *   x   = c max(0, 1 - t / M)             what is above the threshold t, in c's colour
 *   c  <- c - x + g (Y(x) + s (x - Y(x))) gain g and saturation s of that alone
 *
 * s is less where a channel would fall below 0. So luminance above the threshold is
 * multiplied by g whatever s is, and without a clamp the picture has (g - 1) times the
 * sum of Y(x) more light than it had; the blur itself neither adds nor takes any. Ours;
 * gain and threshold as in Nuke's ZDefocus. What is in focus is changed alike: a lamp
 * keeps its light while the focus is pulled through it.
 */
#include "input/highlights.h"

#include <stdbool.h>

#include "base/math.h"
#include "rackfocus/rackfocus.h"

static bool has_gain(const struct rf_params *params)
{
    return params->highlight_gain != 1 || params->highlight_saturation != 1;
}

bool rf_highlights_are_changed(const struct rf_params *params)
{
    return params->highlight_clamp > 0 || has_gain(params);
}

static float largest(const float *c, int n)
{
    float most = c[0];
    for (int i = 1; i < n; i++)
        most = c[i] > most ? c[i] : most;
    return most;
}

static float smallest(const float *c, int n)
{
    float least = c[0];
    for (int i = 1; i < n; i++)
        least = c[i] < least ? c[i] : least;
    return least;
}

/* Gives light x of three channels the saturation s; its luminance stays. */
static void saturate(float *x, float s)
{
    float y = rf_luminance(x[0], x[1], x[2]), least = smallest(x, 3);
    if (!(y > 0))
        return;
    if (y + s * (least - y) < 0)
        s = least < 0 ? 1 : y / (y - least);
    for (int i = 0; i < 3; i++)
        x[i] = y + s * (x[i] - y);
}

void rf_highlights_change(const struct rf_params *params, float *c, int n_channels)
{
    int n = n_channels < 3 ? 1 : 3;
    float most = largest(c, n), clamp = (float)params->highlight_clamp;
    float threshold = (float)params->highlight_threshold;
    float gain = (float)params->highlight_gain;
    float saturation = (float)params->highlight_saturation;
    if (clamp > 0 && most > clamp) {
        for (int i = 0; i < n; i++)
            c[i] *= clamp / most;
        most = clamp;
    }
    if (!has_gain(params) || !(most > threshold))
        return;
    float x[3], rest = threshold / most;
    for (int i = 0; i < n; i++)
        x[i] = c[i] - c[i] * rest;
    for (int i = 0; i < n; i++)
        c[i] *= rest;
    if (n == 3 && saturation != 1)
        saturate(x, saturation);
    for (int i = 0; i < n; i++)
        c[i] += gain * x[i];
}
