/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Footprints that stay with a context. They depend on the aperture alone, not on the
 * focus: pictures of a sequence, or of a view whose focus is pulled, need the same ones
 * again. Kept are tables of footprints that reach up to MOST_PX, with a copy of the
 * picture of the aperture: the host's is that of one filter.
 */
#include "compose/footprint_shelf.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/pool.h"
#include "compose/footprint.h"
#include "input/bokeh.h"
#include "lens/aperture.h"
#include "rackfocus/rackfocus.h"

enum {
    N_KEPT = 24,
    MOST_PX = 9,
    MOST_IMAGE = 1 << 19 /* pixels of a picture of the aperture: 4 MiB a colour */
};

static const double ROUNDED = 1e-3; /* px: a radius from a float */

struct kept {
    struct rf_shape shape;  /* what footprints.shape points to */
    struct rf_bokeh *light; /* what footprints.bokeh points to */
    struct rf_footprints footprints;
    int n_users; /* pictures in work */
};

struct rf_shelf {
    bool lock;
    int oldest; /* what is replaced next */
    struct kept *at[N_KEPT];
};

size_t rf_shelf_bytes(void)
{
    return sizeof(struct rf_shelf);
}

static void lock(struct rf_shelf *shelf)
{
    while (__atomic_test_and_set(&shelf->lock, __ATOMIC_ACQUIRE))
        ;
}

static void unlock(struct rf_shelf *shelf)
{
    __atomic_clear(&shelf->lock, __ATOMIC_RELEASE);
}

static void free_kept(const struct rf_context *context, struct kept *k)
{
    if (!k)
        return;
    rf_footprints_free(&k->footprints);
    rf_bokeh_free(k->light, context);
    rf_free(context, k);
}

/* Is the light over the aperture that of the use? */
static bool has_light(const struct kept *k, const struct rf_footprint_use *use)
{
    if (k->footprints.obstruction != use->obstruction)
        return false;
    if (use->obstruction > 0 || !use->bokeh)
        return use->obstruction > 0 || !k->light;
    return k->light && rf_bokeh_is_plane(k->light, use->bokeh, use->bokeh_plane);
}

static bool serves(const struct kept *k, const struct rf_footprint_use *use)
{
    const struct rf_footprints *f = &k->footprints;
    return f->zones.at->cells.n == use->n_cells && f->n_phases == use->n_phases &&
           rf_radius_of_index(f->max_index) > use->max_radius &&
           memcmp(&f->drift, &use->drift, sizeof f->drift) == 0 &&
           f->spherical == use->spherical && f->is_boundless == use->is_boundless &&
           f->is_of_points == use->is_of_points &&
           memcmp(&f->zones.look, &use->look, sizeof use->look) == 0 &&
           memcmp(&k->shape, use->shape, sizeof k->shape) == 0 && has_light(k, use);
}

static struct kept *find(const struct rf_shelf *shelf,
                         const struct rf_footprint_use *use)
{
    for (int i = 0; i < N_KEPT; i++)
        if (shelf->at[i] && serves(shelf->at[i], use))
            return shelf->at[i];
    return NULL;
}

/*
 * Puts `made` on the shelf, where another picture has not put its like meanwhile, and
 * returns what is there; *excess receives what has to be freed. NULL: all places are in
 * use.
 */
static struct kept *place(struct rf_shelf *shelf, struct kept *made,
                          const struct rf_footprint_use *use, struct kept **excess)
{
    *excess = made;
    struct kept *k = find(shelf, use);
    for (int i = 0; i < N_KEPT && !k; i++) {
        struct kept **at = &shelf->at[shelf->oldest];
        shelf->oldest = (shelf->oldest + 1) % N_KEPT;
        if (*at && (*at)->n_users > 0)
            continue;
        *excess = *at;
        *at = k = made;
    }
    if (k)
        k->n_users++;
    return k;
}

static struct kept *make(const struct rf_context *context,
                         const struct rf_footprint_use *use, struct rf_error *error)
{
    struct kept *k = rf_calloc(context, 1, sizeof *k);
    if (!k) {
        rf_fail_memory(error, 1, sizeof *k);
        return NULL;
    }
    memcpy(&k->shape, use->shape, sizeof k->shape);
    struct rf_footprint_use own = *use;
    own.shape = &k->shape;
    own.max_radius = fmax(own.max_radius, MOST_PX);
    rf_result result = RF_OK;
    if (use->obstruction > 0)
        result = rf_bokeh_make_ring(&k->light, context, use->obstruction, error);
    else if (use->bokeh)
        result = rf_bokeh_copy_plane(&k->light, context, use->bokeh, use->bokeh_plane,
                                     error);
    own.bokeh = k->light;
    own.bokeh_plane = 0;
    if (result == RF_OK)
        result = rf_footprints_init(&k->footprints, context, &own, error);
    if (result == RF_OK)
        return k;
    rf_bokeh_free(k->light, context);
    rf_free(context, k);
    return NULL;
}

/* Is the light over the aperture a picture that is too large to keep? */
static bool is_large_image(const struct rf_footprint_use *use)
{
    return use->bokeh && use->obstruction == 0 &&
           (int64_t)use->bokeh->width * use->bokeh->height > MOST_IMAGE;
}

rf_result rf_footprints_get(struct rf_footprints **f, struct rf_footprints *own,
                            const struct rf_context *context,
                            const struct rf_footprint_use *use, struct rf_error *error)
{
    struct rf_shelf *shelf = context->shelf;
    const struct rf_shape *shape = use->shape;
    double extent[2];
    own->table = NULL;
    *f = own;
    rf_shape_extent(shape, extent);
    /* Footprints of level 0 and 1 px of radius more, which a tile holds, are kept. */
    double wide = fmax(extent[0], extent[1]);
    if (use->list || is_large_image(use) ||
        use->max_radius * wide > MOST_PX + fmax(wide - 1, 0) + ROUNDED)
        return rf_footprints_init(own, context, use, error);
    lock(shelf);
    struct kept *k = find(shelf, use), *excess = NULL;
    if (k)
        k->n_users++;
    unlock(shelf);
    if (!k) {
        struct kept *made = make(context, use, error);
        if (!made)
            return RF_ERROR_MEMORY;
        lock(shelf);
        k = place(shelf, made, use, &excess);
        unlock(shelf);
        free_kept(context, excess);
    }
    if (!k)
        return rf_footprints_init(own, context, use, error);
    *f = &k->footprints;
    return RF_OK;
}

void rf_footprints_put(struct rf_footprints *f, struct rf_footprints *own)
{
    if (f == own) {
        rf_footprints_free(own);
        return;
    }
    struct kept *k = (struct kept *)((char *)f - offsetof(struct kept, footprints));
    lock(f->context->shelf);
    k->n_users--;
    unlock(f->context->shelf);
}

void rf_shelf_clear(const struct rf_context *context)
{
    for (int i = 0; i < N_KEPT; i++)
        free_kept(context, context->shelf->at[i]);
}
