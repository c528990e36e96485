/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the method `views` share: places, and which view sees them. */
#ifndef RF_VIEWS_H
#define RF_VIEWS_H

#include "../picture.h"

struct rf_views {
    struct rf_work *work;
    struct rf_picture *pictures;
    struct rf_occluders *occluders;
    struct rf_samples lights; /* in the centre's view */
    /*
     * Per view, pixel, and near (0) or far (1) part: bit j is set where view j does not
     * show it. NULL where it is not asked for.
     */
    uint64_t *unseen;
};

/* Nearer by this, px of radius, hides. */
static const float RF_OCCLUDED_PX = 0.8f;

/* A place of the centre's view. */
struct rf_view_place {
    float x, y, r;
};

/* The place of a point of view j that lies at (x, y) there. */
struct rf_view_place rf_view_place_of(const struct rf_views *v, int j, float x, float y,
                                      float r);

/* The pixel of view j that looks at a place; false outside of its padded picture. */
bool rf_view_pixel_at(const struct rf_views *v, int j, struct rf_view_place p, int *px,
                      int *py);

/* Was the pixel rendered? The others continue the picture beyond its border. */
bool rf_view_is_rendered(const struct rf_picture *l, int x, int y);

/*
 * The weight of a sample of view j at a place: its share of a pixel, divided among the
 * views that see the place. A near part counts its own pixel whole, since its share is
 * how much of the pixel it covers; a far part counts what the near one leaves to be
 * seen. What continues the picture beyond its border counts where no view shows the
 * place.
 */
float rf_view_weight(const struct rf_views *v, int j, struct rf_view_place p,
                     float share, bool is_far, bool is_rendered);

/*
 * Takes the lights out of all pictures (views_lights.c): each once, the mean of the
 * views that see it whole, its depth one at which the other views show it too.
 */
rf_result rf_views_take_lights(struct rf_views *v, struct rf_error *error);

#endif
