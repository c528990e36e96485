/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A step of the radius by less than the distance from pixel to pixel has no candidates
 * (hidden.c), and what was found behind it is what is far behind all of it, as a sky: its
 * light came through the gap that the two sides leave. With r the radius of a pixel and
 * r_d that of what is shown d px beside it, in one of four directions, the side behind
 * lies behind the pixel where
 *
 *   LEAST < r_d - r < MOST,  r_d - r > STEEPER max(r - r_-1, r_d+1 - r_d)
 *
 * of d = 1, 2 (a mixed pixel lies between); the nearest of the four wins. Slopes are no
 * steps. Worth 4.3 dB on a stranger's bridge of columns before a bright sky, 0.1 to 0.2 on
 * a house, -0.01 to 0.05 on the scenes of tests/quality. Cost: 1.1 to 1.4 % of a picture.
 */
#include "surfaces/hidden_steps.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/math.h"
#include "kernels/data.h"
#include "kernels/hidden_kernels.h"

/* LEAST: 0.3 loses 0.9 dB on the bridge, 0.7 0.1. MOST: 2 and 6 are as good. STEEPER: 1.2 with
 * a LEAST of 0.1 takes curved things for steps, macro -1.2. FARTHER: px that the answer must
 * lie behind the step's far side; 8 is as good. */
static const float LEAST = 0.5f, MOST = 3, STEEPER = 2, FARTHER = 1;

enum { REACH = 2 };

/* A pixel and a direction. */
struct look {
    int x, y, dx, dy;
};

/* May there be a step? The plane of radii says, where it is read for nothing else. */
static bool may_step(const struct rf_hidden_search *search, int x, int y, float r)
{
    const struct rf_backs *b = &search->backs;
    const ptrdiff_t row = (ptrdiff_t)b->stride;
    const float *at = b->r + row * y + x;
    if (x < REACH || y < REACH || x >= b->width - REACH || y >= b->height - REACH)
        return true;
    bool may = false;
    for (int d = 1; d <= REACH; d++) {
        may |= (at[d] - r > LEAST) & (at[d] - r < MOST);
        may |= (at[-d] - r > LEAST) & (at[-d] - r < MOST);
        may |= (at[d * row] - r > LEAST) & (at[d * row] - r < MOST);
        may |= (at[-d * row] - r > LEAST) & (at[-d * row] - r < MOST);
    }
    return may;
}

/* What is shown d px from the pixel; NULL beyond the picture. */
static const struct rf_surface *shown_at(const struct rf_surfaces *s,
                                         const struct look *look, int d)
{
    int x = look->x + d * look->dx, y = look->y + d * look->dy;
    if ((unsigned)x >= (unsigned)s->width || (unsigned)y >= (unsigned)s->height)
        return NULL;
    return rf_shown_at(s, (size_t)y * (size_t)s->width + (size_t)x);
}

/* The surface one step behind radius r in a direction, nearer than `most`; or NULL. */
static const struct rf_surface *
behind_step(const struct rf_surfaces *s, const struct look *look, float r, float most)
{
    const struct rf_surface *before = shown_at(s, look, -1);
    for (int d = 1; d <= REACH && before; d++) {
        const struct rf_surface *at = shown_at(s, look, d);
        const struct rf_surface *beyond = shown_at(s, look, d + 1);
        if (!at || !beyond)
            return NULL;
        float step = at->r - r;
        if (!(step > LEAST && step < MOST))
            continue;
        float slope = rf_max_float(fabsf(r - before->r), fabsf(beyond->r - at->r));
        return step > STEEPER * slope && at->r < most ? at : NULL;
    }
    return NULL;
}

void rf_hidden_behind_step(const struct rf_hidden_search *search, int x, int y,
                           struct rf_surface *answer)
{
    static const int along[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    const struct rf_surfaces *s = search->s;
    size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    const struct rf_surface *found = NULL;
    if (!may_step(search, x, y, s->near[i].r) || (rf_is_mixed(s, i) && s->share[i] < 1))
        return; /* a mixed pixel's own far part lies behind it */
    float most = answer->r - FARTHER;
    for (int k = 0; k < 4; k++) {
        const struct look look = {x, y, along[k][0], along[k][1]};
        const struct rf_surface *one = behind_step(s, &look, s->near[i].r, most);
        if (one) {
            found = one;
            most = one->r;
        }
    }
    if (found)
        *answer = *found;
}
