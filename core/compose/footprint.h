/* SPDX-License-Identifier: Apache-2.0 */
/* Footprints: what one sample of a given radius leaves on the pixels around it. */
#ifndef RF_COMPOSE_FOOTPRINT_H
#define RF_COMPOSE_FOOTPRINT_H

#include <math.h>
#include <stddef.h>

#include "base/context.h"
#include "base/math.h"
#include "base/task.h"
#include "compose/footprint_grid.h"
#include "compose/zones.h"
#include "kernels/data.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

/* Footprints by quantised radius, sub-pixel phase and kind, built when first asked for.
 */

/*
 * Averaging down to level l = 1, 2, .. and magnifying again widen a footprint by 4^l /
 * 4 px^2 per axis: the place in the block adds (4^l - 1)/12, the tent (2 4^l + 1)/12.
 * The footprints of a coarse level have as much less, 1/4 in pixels of the level, so that
 * the second moments come out right: sharp ones are sharpened, which leaves rims in their
 * place, positive ones have a smaller radius.
 */
enum { RF_N_LEVELS = 13 }; /* that footprints differ for: 2 without aberration */

/*
 * Spherical aberration reaches so far beyond the radius at the most, px of the level,
 * but of highlights: what a tile may hold (RF_TILE_HALO) less the radius and kernel.
 */
#define RF_MOST_GLOW 5.5

/* One of the footprints of a list: of a place and a radius, both rounded. */
struct rf_listed {
    double q[2]; /* see lens/look.h */
    int index;   /* of the radius */
    int phase;
};

struct rf_footprints {
    const struct rf_context *context;
    const struct rf_shape *shape;
    struct rf_drift drift;
    struct rf_zones zones;
    const struct rf_bokeh *bokeh; /* light of the aperture; NULL: even */
    int bokeh_plane;
    double obstruction; /* as in struct rf_footprint_use */
    double spherical;   /* aberration, px */
    bool is_boundless;  /* no tile limits it */
    bool is_of_points;  /* as in struct rf_footprint_use */
    int n_levels;       /* that footprints differ for; the last: and above */
    int max_index;      /* radii from -max_index to max_index, in steps */
    int n_phases;       /* per axis: 1 puts every sample on its pixel's centre */
    double extent[2]
                 [2]; /* of the drifting aperture along x and y: px, px per px of r */
    const struct rf_listed *list; /* not NULL: slots are its indices */
    size_t n_listed;
    struct rf_footprint **table;
};

rf_result rf_footprints_init(struct rf_footprints *f, const struct rf_context *context,
                             const struct rf_footprint_use *use,
                             struct rf_error *error);

void rf_footprints_free(struct rf_footprints *f);

/*
 * Radii are quantised to 1/32 px below 4 px, 1/16 below 8 px and 1/8 above. A step of
 * the radius changes the second moment by r dr / 2, which shows as a ripple of the
 * coverage where a slanted surface passes it: the smaller the footprint, the finer the
 * steps.
 */
enum { RF_INDEX_4PX = 4 * 32, RF_INDEX_8PX = RF_INDEX_4PX + 4 * 16 };

static inline int rf_radius_index(const struct rf_footprints *f, float r)
{
    float a = r < 0 ? -r : r;
    int i = a < 4   ? (int)lrintf(a * 32)
            : a < 8 ? RF_INDEX_4PX + (int)lrintf((a - 4) * 16)
                    : RF_INDEX_8PX + (int)lrintf((a - 8) * 8);
    i = i > f->max_index ? f->max_index : i;
    return r < 0 ? -i : i;
}

static inline double rf_radius_of_index(int index)
{
    int i = index < 0 ? -index : index;
    double r = i < RF_INDEX_4PX   ? i / 32.0
               : i < RF_INDEX_8PX ? 4 + (i - RF_INDEX_4PX) / 16.0
                                  : 8 + (i - RF_INDEX_8PX) / 8.0;
    return index < 0 ? -r : r;
}

/* Phase of a sample's place in its pixel. */
static inline int rf_phase_of(const struct rf_footprints *f, float x, float y)
{
    int n = f->n_phases;
    int px = (int)((x - floorf(x)) * (float)n), py = (int)((y - floorf(y)) * (float)n);
    return rf_min_int(py, n - 1) * n + rf_min_int(px, n - 1);
}

/* The phase of a sample on its pixel's centre. */
static inline int rf_centre_phase(const struct rf_footprints *f)
{
    return f->n_phases / 2 * f->n_phases + f->n_phases / 2;
}

static inline size_t rf_footprint_count(const struct rf_footprints *f)
{
    if (f->list)
        return f->n_listed;
    return (size_t)f->zones.n * (size_t)(2 * f->max_index + 1) *
           (size_t)(f->n_phases * f->n_phases) * RF_N_KINDS * (size_t)f->n_levels;
}

/* Radii up to here have no shape: all zones share their footprints. 1/4 px. */
enum { RF_SHAPELESS_INDEX = 8 };

/* Slot of (zone, radius in pixels of the level, phase, kind, level). */
static inline size_t rf_footprint_slot(const struct rf_footprints *f, int zone,
                                       int index, int phase,
                                       enum rf_footprint_kind kind, int level)
{
    int n_phases = f->n_phases * f->n_phases;
    int level_class = rf_min_int(level, f->n_levels - 1);
    if (index <= RF_SHAPELESS_INDEX && index >= -RF_SHAPELESS_INDEX)
        zone = rf_zone_middle(&f->zones);
    size_t row = (size_t)zone * (size_t)(2 * f->max_index + 1);
    size_t slot = (row + (size_t)(index + f->max_index)) * (size_t)n_phases;
    return ((slot + (size_t)phase) * RF_N_KINDS + (size_t)kind) * (size_t)f->n_levels +
           (size_t)level_class;
}

/* Pixels right, left, up or down that a level's footprints reach at the most, of radii
 * from 0 to r, r < 0 before the focus, whether they are built or not. */
int rf_footprints_reach(const struct rf_footprints *f, int level, double r);

/*
 * Builds every slot i with needed[i] != 0 on all threads, as one phase of `task` that
 * ends at `progress_to`. After a cancel the slots are incomplete and RF_OK comes back.
 */
rf_result rf_footprints_build(struct rf_footprints *f, const unsigned char *needed,
                              struct rf_task *task, double progress_to,
                              struct rf_error *error);

#endif
