/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the method views share: places, cells, pictures. */
#ifndef RF_METHODS_VIEWS_MERGE_H
#define RF_METHODS_VIEWS_MERGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/math.h"
#include "compose/footprint.h"
#include "compose/scene.h"
#include "input/frame.h"
#include "compose/light_map.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "kernels/sight_kernels.h"
#include "surfaces/hidden.h"
#include "surfaces/picture.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

enum { RF_MOST_CELLS = 8 };

/* Least and greatest shift of a place in any view, right and down: slope r + base. */
struct rf_view_range {
    float slope[2][2], base[2][2];
};

/* Which views a cell of the lens asks. */
struct rf_cell_views {
    uint64_t own;
    /* Per view: which others, not among the own, are nearer to the middle one. */
    uint64_t nearer[RF_MAX_VIEWS];
};

/*
 * A piece of surface that fills a gap in a cell whose views do not see it, of those to
 * which no other view that shows it is nearer.
 */
struct rf_unseen {
    int32_t part; /* 4 x, 1 more for the far part of the pixel, 2 if it is bright */
    float weight; /* its share of a pixel, a far one twice that or 1 */
};

/* The pieces for one cell after those for another. */
struct rf_unseen_row {
    struct rf_unseen *at;
    int first[RF_MOST_CELLS + 1];
    int n_bright[RF_MOST_CELLS]; /* of each cell: two samples each */
};

struct rf_views {
    struct rf_work *work;
    struct rf_picture *pictures;
    struct rf_occluders *occluders;
    struct rf_samples lights;     /* in the centre's view */
    uint32_t *light_leads;        /* of each the one whose mask it takes */
    struct rf_unseen_row *unseen; /* per view and row; NULL: not asked for */
    struct rf_view_range range;
    struct rf_sight sights[RF_MAX_VIEWS]; /* of the pictures */
    struct rf_cell_views cells[RF_MOST_CELLS];
    int n_cells;
};

/* Nearer by this, px of radius, hides. */
static const float RF_OCCLUDED_PX = 0.8f;

/* A place of the centre's view. */
struct rf_view_place {
    float x, y, r;
};

/* floorf() to int, without the call that the C library needs on plain x86-64. */
static inline int rf_view_floor(float v)
{
    v = v > -1e9f ? v : -1e9f; /* far beyond any picture, and what int can hold */
    v = v < 1e9f ? v : 1e9f;
    int i = (int)v;
    return i - (v < (float)i);
}

static inline float rf_view_shift(const struct rf_work_view *view, float r)
{
    return view->shift_scale * r + view->shift_bias;
}

/* The place of a point of view j that lies at (x, y) there. */
static inline struct rf_view_place rf_view_place_of(const struct rf_views *v, int j,
                                                    float x, float y, float r)
{
    const struct rf_work_view *view = &v->work->views[j];
    float shift = rf_view_shift(view, r);
    return (struct rf_view_place){x - rf_snap_px(view->lens[0] * shift),
                                  y + rf_snap_px(view->lens[1] * shift), r};
}

/* The pixel of view j that looks at a place; false outside of its padded picture. */
static inline bool rf_view_pixel_at(const struct rf_views *v, int j,
                                    struct rf_view_place p, int *px, int *py)
{
    const struct rf_work_view *view = &v->work->views[j];
    const struct rf_surfaces *s = &v->pictures[j].surfaces;
    float shift = rf_view_shift(view, p.r);
    *px = rf_view_floor(p.x + rf_snap_px(view->lens[0] * shift));
    *py = rf_view_floor(p.y - rf_snap_px(view->lens[1] * shift));
    return *px >= 0 && *py >= 0 && *px < s->width && *py < s->height;
}

/* Was the pixel rendered? The others continue the picture beyond its border. */
static inline bool rf_view_is_rendered(const struct rf_picture *picture, int x, int y)
{
    return x >= picture->x0 && y >= picture->y0 &&
           x < picture->x0 + picture->frame->width &&
           y < picture->y0 + picture->frame->height;
}

/* How much pixel (x, y) of a view sees of a place of radius r. */
static inline float rf_view_pixel_sees(const struct rf_picture *picture, int x, int y,
                                       float r)
{
    const struct rf_surfaces *s = &picture->surfaces;
    size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    float limit = r - RF_OCCLUDED_PX;
    if (!rf_is_mixed(s, i)) /* the plane of radii is denser than surfaces are */
        return rf_plane_row(&picture->pixels, picture->pixels.radius, y)[x] >= limit
                   ? 1
                   : 0;
    float share = s->share[i];
    if (share > 0 && s->near[i].r >= limit)
        return 1;
    return rf_far_at(s, i)->r >= limit ? 1 - share : 0;
}

/*
 * Places of a sample in a pixel; odd: one is its centre. The fine ones hold the others,
 * and are for what shows them: looks' highlights, which have footprints of their own
 * anyway (eight views: 0.1 to 0.4 dB), and a surface in focus that is no plane. Where a
 * look has other footprints in each zone besides, the coarse ones bound their number:
 * eight views of 480x270 with cat's eyes and a tilt take 0.5 GiB by them, 1.1 by 5 per
 * axis (0.07 dB better), 8.6 by 15 (0.14 dB).
 */
enum { RF_COARSE_PHASES = 3, RF_VIEW_PHASES = 5, RF_FINE_PHASES = 15 };

/* The part of the lens for which some of the views stand. */
struct rf_view_cell {
    struct rf_views *v;
    int index;             /* among the cells */
    uint64_t own;          /* those views */
    bool is_whole;         /* it is all of the lens, and they are all of the views */
    int middle;            /* the view to estimate hidden samples from */
    struct rf_frame frame; /* with the part as its aperture */
    float centroid[2];
    float extent[2]; /* half width and height of what it makes of radius 1, px */
    float reach[2];  /* how far samples of radius 1 have a part in the picture, px */
    /*
     * Of one view, and near its place: samples stay on that view's pixels, moved by
     * whole px, and footprints lie beside them as far as they would have moved. What
     * other views show goes to the nearest of those pixels.
     */
    bool is_on_grid;
    /* Near the place of its middle view, and one lens all over the picture: what is near
     * the focus lies where that view shows it, moved by `shift` px. */
    bool is_beside_view;
    int n_phases; /* places of its samples in a pixel, per axis */
    int shift[2];
    struct rf_drift drift;
    float *sum; /* planes that its picture is added to, times its weight */
    float weight;
    struct rf_light_map weights; /* at NULL: `weight` everywhere */
    struct rf_estimates hidden;  /* at NULL: not asked for */
    struct rf_sample *samples;
};

static inline int rf_view_cell_n_own(const struct rf_view_cell *cell)
{
    return __builtin_popcountll(cell->own);
}

/* A set of views: bit j, view j. */
static const uint64_t RF_ALL_VIEWS = UINT64_MAX;

#endif
