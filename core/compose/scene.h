/* SPDX-License-Identifier: Apache-2.0 */
/* Samples of surfaces, and what the compositing is to make of them. */
#ifndef RF_COMPOSE_SCENE_H
#define RF_COMPOSE_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/task.h"
#include "compose/footprint.h"
#include "input/field.h"
#include "input/frame.h"
#include "compose/light_map.h"
#include "kernels/data.h"

/* A small emitter: where the lens' centre sees it, radius, weight, colour. */
struct rf_sample {
    float x, y; /* px; pixel centres at +0.5 */
    float r;    /* signed radius, px */
    float w;    /* share of a pixel that it covers */
    float c[4]; /* premultiplied */
    /*
     * RF_SHARP: a surface. RF_POSITIVE: only light, without coverage, for what is so
     * far above its surroundings that negative weights would show.
     */
    enum rf_footprint_kind kind : 16;
    int slant : 16; /* of its surface's radius, see kernels/data.h */
};

struct rf_samples {
    struct rf_sample *at;
    size_t n;
};

/* What a source has at up to 64 pixels: a bit for each, in one of the two or none. */
struct rf_emission {
    uint64_t plain; /* its surface as it is, on the pixel's centre, with weight 1 */
    uint64_t other; /* samples that emit() gives */
};

/* Samples that are made when they are needed. Any thread calls. */
struct rf_source {
    /* What n pixels from (x, y) on have; NULL: the samples are in an array. */
    struct rf_emission (*emission)(void *user, int x, int y, int n);
    /* Puts the other samples of pixel (x, y) into `at`; returns how many. */
    int (*emit)(void *user, int x, int y, struct rf_sample *at);
    void *user;
    /* Of the plain samples; as large as the scene, packed, but moved by whole px. */
    const struct rf_surface *surfaces;
    int x, y;             /* of the first surface, in the scene */
    const float *radius;  /* of the plain samples' surfaces; NULL: not at hand */
    size_t radius_stride; /* floats */
    int most_per_pixel;
    float largest_radius; /* of its samples, without sign */
};

/* The surfaces of one view, as what may stand before a highlight. */
struct rf_estimates;

struct rf_occluders {
    const struct rf_surfaces *surfaces;
    /*
     * Of the near surfaces that stand before others, else INFINITY; RF_ROW_MARGIN
     * floats may be read after a row. NULL: not at hand; the same for all views.
     */
    const float *radius;
    size_t radius_stride;
    /*
     * Radii of what lies behind the near surfaces, INFINITY where that is not known;
     * RF_ROW_MARGIN floats may be read after a row. NULL: not known of any pixel.
     */
    const float *behind;
    size_t behind_stride;
    const struct rf_estimates *estimates;   /* of the same, of the one view; or NULL */
    float lens[2], shift_scale, shift_bias; /* as in struct rf_work_view */
};

struct rf_insides;

struct rf_scene {
    const struct rf_frame *frame;
    int width, height; /* with the border */
    int x0, y0;        /* where the picture begins within it */
    int n_colours;     /* 1, 3 or 4: set by rf_composite_crop() */
    int first_colour;  /* the one of n_colours 1, else 0; likewise */
    /* Of a picture that is made colour by colour, all others are not wanted: 1 to 3, or
     * 0; and what its radii are more than the samples', px. */
    int colour;
    float radius_shift;
    bool is_opaque; /* every alpha is 1: it needs no sums */
    /* What the result has at the least: of what is below 0 in the picture the least, so
     * that what a cubic leaves beside bright edges is cut off and all else is kept. */
    float least[3];
    const struct rf_insides *insides; /* of the visible surfaces; NULL: not known */
    bool fills_gaps; /* what samples leave open looks like the pixels around */
    int n_phases;    /* sub-pixel positions per axis; 1: samples lie on pixel centres */
    struct rf_drift drift;     /* of the samples' footprints */
    struct rf_samples visible; /* spread near to far */
    struct rf_samples hidden;  /* after all visible ones, fill what is left */
    struct rf_source visible_source, hidden_source; /* beside those arrays */
    struct rf_samples highlights; /* light to add, with exact visibility */
    /*
     * Of each highlight the one whose mask it takes, what stands before that one:
     * itself or one before it, and those between do so too. NULL: each has its own.
     */
    const uint32_t *highlight_leads;
    const struct rf_occluders *occluders;
    int n_views; /* of occluders */
    /*
     * Of one view: the radii of the pixels that one surface covers, INFINITY or a share
     * below 1 in occluders->surfaces elsewhere, in rows of whole_stride; the first pixel
     * of both lies at whole_at. Those from whole_from to before whole_to have neighbours
     * that are known. NULL: not at hand, or holes are wanted.
     */
    const float *whole_radius;
    size_t whole_stride;
    int whole_at[2], whole_from[2], whole_to[2];
    /*
     * If not NULL, the result is not the work's: its colours, times `weight`, are added
     * to these planes of the picture's size, packed.
     */
    float *sum;
    float weight;
    /* Of each place, instead of `weight`; NULL: the same everywhere. */
    const struct rf_light_map *weights;
    /* What the colours of a picture have in common, which stays with the caller
     * (rf_common_free()); NULL: there is one picture. */
    struct rf_common *common;
    struct rf_task *task;
    double progress_to; /* fraction that this part ends at */
};

/* Of the disc of a highlight. What stands before it is as far from it in all colours and
 * wherever the surface in focus lies. */
static inline float rf_scene_disc_radius(const struct rf_scene *scene,
                                         const struct rf_sample *s)
{
    const struct rf_field *apart = scene->frame->apart;
    float r = s->r + scene->radius_shift;
    return apart ? rf_field_radius(apart, s->x - (float)scene->x0,
                                   s->y - (float)scene->y0, r)
                 : r;
}

/* How far away a pixel looks where it is a gap, px. */
enum { RF_GAP_REACH = 3 };

/* A part of the scene, as planes; NULL: that colour is not wanted. */
struct rf_crop {
    int x, y, width, height; /* of the part, in the scene */
    ptrdiff_t stride;        /* floats */
    float *planes[4];
    float *rgba;  /* instead of planes: quadruples, all wanted */
    float weight; /* not 0: colours are added to the planes, times this */
    const struct rf_light_map *weights; /* of each place instead, if not NULL */
};

#endif
