/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shares of pixels are estimates, and of a lamp of 1e4 a thousandth is white: where most of
 * a light is blocked, all of it is. Rims of what is in focus are another thing. There the
 * mask is the rim's own share, and a ring of dark pixels would surround what is sharp
 * before a lamp.
 */
#include "compose/rims.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/math.h"
#include "compose/scene.h"
#include "surfaces/surfaces.h"

/*
 * What is blocked by more than this is dark: shares are estimates, surfaces that slant
 * along both axes leave cracks, and of a lamp of 1e4 one thousandth is white. Macro
 * -1.21, posts -0.49 with half; posts -0.18, portrait -0.16, its views -0.67 with 1.
 */
static const float WHOLE = 0.8f;
/* Not so at rims near the focus, whose own share it is: the mask has no cracks there.
 * Macro + 0.13 dB, its views + 0.14 and 0.4, night's + 0.07. At 0.5 macro - 0.1. */
static const float RIM_PX = 1;
static const float RIM_SHARE = 0.05f; /* what is blocked may be more than the share */
/* A pixel of a rough surface is no rim: what is behind one is farther by this. */
static const float BEHIND_RIM_PX = 4;

/* Is so much of pixel (x, y) of the scene blocked by its own rim, near the focus? */
static bool is_rim(const struct rf_occluders *o, int x, int y, float blocked)
{
    const struct rf_surfaces *s = o->surfaces;
    x += (int)floorf(o->lens[0] * o->shift_bias + 0.5f);
    y -= (int)floorf(o->lens[1] * o->shift_bias + 0.5f);
    if (x < 0 || y < 0 || x >= s->width || y >= s->height)
        return false;
    const size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    const float near = s->near[i].r;
    return rf_is_mixed(s, i) && s->share[i] >= blocked - RIM_SHARE &&
           fabsf(near) < RIM_PX && rf_far_at(s, i)->r > near + BEHIND_RIM_PX;
}

void rf_rims_darken(const struct rf_occluder_layers *layers, const struct rf_shadows *m)
{
    for (int y = 0; y < m->height; y++)
        for (int x = 0; x < m->width; x++) {
            float *blocked = &m->blocked[(size_t)y * (size_t)m->width + (size_t)x];
            if (*blocked < WHOLE)
                continue;
            const int at_x = m->x + m->left + x, at_y = m->y + m->top + y;
            const bool is_open = is_rim(layers->at[0].occluders, at_x, at_y, *blocked);
            *blocked = is_open ? rf_min_float(*blocked, 1) : 1;
        }
}
