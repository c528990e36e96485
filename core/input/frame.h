/* SPDX-License-Identifier: Apache-2.0 */
/* What is filtered: size, place, lens, aperture and parameters. */
#ifndef RF_INPUT_FRAME_H
#define RF_INPUT_FRAME_H

#include <stdbool.h>

#include "base/context.h"
#include "input/bokeh.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

/* Where the pixels at hand lie in the whole picture; of a whole one (0, 0). */
struct rf_place {
    int x, y, whole_width, whole_height; /* px */
};

struct rf_field;

/*
 * The pixels at hand of a picture, and how they are filtered: those of a filter, of a
 * window of it, of its picture at a reduced size, or through a part of its lens.
 */
struct rf_frame {
    const struct rf_context *context;
    struct rf_params params;
    struct rf_lens lens;
    struct rf_shape shape;
    int width, height; /* of the pixels at hand */
    struct rf_place place;
    const struct rf_bokeh *bokeh; /* of the distribution image; NULL: none */
    const struct rf_bokeh *ring; /* what obstruction and hollow blades leave, or NULL */
    bool is_hollow;              /* its blades are */
    /* Of a picture that is made colour by colour: 1 to 3, red to blue; 0: all at once.
     */
    int colour;
    double radius_shift; /* of that colour, px: axial chroma */
    bool by_colour;      /* the method makes each colour by itself */
    /* Of a picture of one focus of many, which a split diopter has: its share, all
     * over the picture. */
    bool has_even_share;
    double even_share;
    /*
     * What places add to radii, of views that were rendered for a plane: their radii are
     * by that plane, and this is added where they are spread. NULL: radii have it.
     */
    const struct rf_field *apart;
};

enum { RF_N_COLOURS = 3 };

/* Px that the radii of colour i, 0 to 2, are larger by axial chroma. */
static inline double rf_frame_colour_shift(const struct rf_frame *f, int i)
{
    return (1 - i) * f->params.axial_chroma;
}

/* The looks of a frame that depend on the place; all zeros where there are none. */
static inline struct rf_look rf_frame_look(const struct rf_frame *f)
{
    struct rf_look look =
        rf_look_make(&f->params, f->place.whole_width, f->place.whole_height);
    return rf_look_is_on(&look) ? look : (struct rf_look){.cat_eye = 0};
}

/* The picture of the aperture that the blur is to have; NULL: its light is even. */
static inline const struct rf_bokeh *rf_frame_bokeh(const struct rf_frame *f)
{
    return f->params.aperture == RF_APERTURE_IMAGE ? f->bokeh : f->ring;
}

/* The obstruction that this picture is the ring of; 0: it is another, or none. */
static inline double rf_frame_obstruction(const struct rf_frame *f)
{
    bool is_ring = f->ring && rf_frame_bokeh(f) == f->ring && !f->is_hollow;
    return is_ring ? f->params.obstruction : 0;
}

/* The plane of that picture that the blur is to have. */
static inline int rf_frame_bokeh_plane(const struct rf_frame *f)
{
    const struct rf_bokeh *bokeh = rf_frame_bokeh(f);
    return bokeh && bokeh->n_planes > 1 && f->colour > 0 ? f->colour - 1
           : bokeh                                       ? bokeh->n_planes - 1
                                                         : 0;
}

#endif
