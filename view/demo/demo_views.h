/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The demo's scene from many points of the lens, drawn by OpenGL and accumulated: the
 * mean is what a lens of that size sees, with nothing guessed. The views come in an
 * order in which any first part of them is spread over the lens, so that the mean can be
 * shown while it grows.
 *
 * Sources: OpenGL programming guide, "depth of field" (shift); OpenGL programming
 * wikibook (look-at). Sums are floats of linear light; the guide's own blending into 8
 * bits loses levels.
 */
#ifndef VIEW_DEMO_VIEWS_H
#define VIEW_DEMO_VIEWS_H

#include <stdbool.h>
#include <stdint.h>

#include "demo/demo.h"
#include "rackfocus/rackfocus.h"

enum { DEMO_MOST_VIEWS = 256 };

struct demo_views {
    int n, n_done;                         /* wanted, added up so far */
    double yaw, pitch;                     /* of the scene that is drawn */
    struct demo_eye eyes[DEMO_MOST_VIEWS]; /* in the order of drawing */
    float *sum;                            /* RGB, rows from the top */
    uint8_t *rgba;                         /* of one view */
    double drawn_ms;                       /* what the views so far took */
};

/* Zeroed is none. False without memory. */
bool demo_views_make(struct demo_views *views, const struct demo *demo);
void demo_views_free(struct demo_views *views);

/*
 * From now on `n` views (1 to DEMO_MOST_VIEWS; one is the pinhole in the middle) of this
 * lens: pattern and aperture of `params`, the blur of `lens`. Begins anew where
 * they or the scene differ from what is being drawn; *is_new says so. False with the
 * core's message; a lens without perspective is RF_ERROR_PARAMETER.
 */
bool demo_views_aim(struct demo_views *views, struct demo *demo, int n,
                    enum demo_move move, const struct rf_params *params,
                    const struct rf_lens *lens, bool *is_new, struct rf_error *error);

/* Draws at least one view, and more until a clock of os_clock_s() has come there. */
void demo_views_step(struct demo_views *views, const struct demo *demo, double until_s);

/* The mean of the views so far, at least one; `rgb` is packed, linear light. */
void demo_views_mean(const struct demo_views *views, const struct demo *demo,
                     float *rgb);

#endif
