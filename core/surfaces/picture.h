/* SPDX-License-Identifier: Apache-2.0 */
/* One view on its way to samples: border, surfaces. */
#ifndef RF_SURFACES_PICTURE_H
#define RF_SURFACES_PICTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/task.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "surfaces/bright_areas.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

/*
 * What is brighter than RF_BRIGHT times the darkest of 5 x 5 pixels is spread without
 * the cubic's negative weights where it is in focus; emit.c says how that limit grows
 * with the squared radius, up to RF_BRIGHT_R2 px^2.
 */
static const float RF_BRIGHT = 4, RF_BRIGHT_R2 = 64;

struct rf_sample;

/*
 * A view, continued beyond its border where that is the whole picture's; width and
 * height with it.
 */
struct rf_picture {
    const struct rf_frame *frame;
    int border; /* px, where there is one */
    int x0, y0; /* the view's first pixel: the border, or 0 within a picture */
    int width, height;
    struct rf_pixels pixels;
    struct rf_surfaces surfaces;
    float *darkest; /* plane: least luminance of 5 x 5, premultiplication undone */
    /* A bit for each pixel that is mixed or bright, rows in whole words. */
    uint64_t *others;
    uint64_t *possible_highlights; /* the same for those that may be highlights */
    bool has_alpha;                /* some pixel is not opaque */
    float least[3];                /* of the colours; 0 where none is negative */
    struct rf_areas areas;
    /* Their light, once it is taken out of the surfaces (highlights_find.c). */
    struct rf_sample *highlights;
    size_t n_highlights;
    float highlight_factor; /* as in rf_is_highlight(); 0: they were not looked for */
    /* Radii behind the near surfaces that the caller knows, as in struct rf_occluders;
     * NULL: none. */
    float *behind;
    size_t behind_stride;
};

/* What stays of the pixels of a picture that is loaded. */
enum rf_picture_kept {
    RF_KEPT_RADII,
    RF_KEPT_PIXELS, /* also luminances and rf_split_radius_at() */
    RF_KEPT_SOURCES /* and the pixels that those beyond the border go on from */
};

/*
 * Loads a view and splits its edges (if the parameters say so); steps `task` once per
 * row of the padded picture. `border` is what rf_picture_border() says for the largest
 * radius in use. Of the pixels their radii stay, which are those of the near parts by
 * then, and what `kept` says. After a cancel RF_OK comes back and there are no surfaces.
 */
rf_result rf_picture_load(struct rf_picture *picture, const struct rf_frame *frame,
                          const struct rf_work_view *view, int n_planes, int border,
                          enum rf_picture_kept kept, struct rf_task *task,
                          struct rf_error *error);

void rf_picture_free(struct rf_picture *picture);

/*
 * Frees what is kept of the pixels as they came, once edges are split and highlights
 * taken; the radii of the near parts stay.
 */
void rf_picture_drop_pixels(struct rf_picture *picture);

int rf_picture_border(float largest_radius);

/* Calls for the pixels of row y that may be highlights. */
typedef void (*rf_visit_pixel_fn)(struct rf_picture *picture, int x, int y, void *user);
void rf_picture_visit_possible_highlights(struct rf_picture *picture, int y,
                                          rf_visit_pixel_fn visit, void *user);

#endif
