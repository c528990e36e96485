/* SPDX-License-Identifier: Apache-2.0 */
/* Without OpenColorIO. */
#include <stdio.h>

#include "pixels/colour.h"

bool colour_list_make(struct colour_list *list, const char *config, char *text,
                      size_t n_bytes)
{
    *list = (struct colour_list){.n = 1, .names = {"sRGB"}};
    if (config)
        snprintf(text, n_bytes,
                 "%s: this build has no OpenColorIO, so the view stays sRGB; install "
                 "libopencolorio-dev and build again",
                 config);
    return !config;
}

bool colour_prepare(struct colour *colour, char *text, size_t n_bytes)
{
    (void)text, (void)n_bytes;
    return !colour;
}

void colour_list_free(struct colour_list *list)
{
    *list = (struct colour_list){0};
}

void colour_show(const struct colour *colour, const float *pixels, int n_channels,
                 size_t n, double exposure, uint8_t *rgba)
{
    (void)colour, (void)pixels, (void)n_channels, (void)n, (void)exposure, (void)rgba;
}
