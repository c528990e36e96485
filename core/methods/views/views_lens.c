/* SPDX-License-Identifier: Apache-2.0 */
/*
 * views: cuts the lens into cells, and says how far beyond a picture or a window lies
 * what they need of it.
 */
#include "methods/views/views_lens.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "compose/levels.h"
#include "compose/zones.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "lens/aperture.h"
#include "methods/views/merge.h"
#include "methods/views/views_lights.h"
#include "surfaces/border_outlines.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

enum { MOST_SHIFT = 1 << 20 /* px, by which a picture is moved as a whole */ };

/* Of some views, the one from the place nearest to (u, v) of the lens. */
static int nearest_view(const struct rf_work *work, uint64_t views, const double at[2])
{
    int best = -1;
    double least = INFINITY;
    for (; views; views &= views - 1) {
        int j = __builtin_ctzll(views);
        double d = rf_length(work->views[j].lens[0] - at[0],
                             work->views[j].lens[1] / work->frame->params.pixel_aspect -
                                 at[1]);
        if (d < least) {
            least = d;
            best = j;
        }
    }
    return best;
}

int rf_views_middle(const struct rf_work *work)
{
    return nearest_view(work, RF_ALL_VIEWS >> (64 - work->n_views), (double[2]){0, 0});
}

/*
 * A cell is a sub-aperture itself and needs fewer of its own: three of four, two at the
 * least. Two of four are worth 1.0 dB less on leaves before leaves, 0.4 on snow, 0.00 to
 * 0.05 on ten other scenes, and 5 % of the instructions (8 views); docs/notebook/views.md.
 */
static int sub_apertures_of_cell(int whole, int n_views)
{
    int least = rf_max_int(rf_min_int(whole, 2), 3 * whole / 4);
    return rf_max_int(least, (2 * whole + n_views - 1) / n_views);
}

static void measure_cell(struct rf_view_cell *cell, const double centroid[2])
{
    double extent[2];
    rf_shape_extent(&cell->frame.shape, extent);
    for (int k = 0; k < 2; k++) {
        cell->extent[k] = (float)extent[k];
        cell->centroid[k] =
            (float)(centroid[k] * (k ? cell->frame.shape.pixel_aspect : 1));
    }
}

/* The views' own parts of the lens. */
struct parts {
    double area[RF_MAX_VIEWS];        /* 0: none */
    double centroid[RF_MAX_VIEWS][2]; /* of the parts, units of the lens */
};

static void copy_places(const struct rf_work *work, double (*place)[2])
{
    for (int j = 0; j < work->n_views; j++)
        for (int k = 0; k < 2; k++)
            place[j][k] =
                work->views[j].lens[k] / (k ? work->frame->params.pixel_aspect : 1);
}

static struct parts cut_lens(const struct rf_work *work)
{
    struct parts parts = {{0}, {{0}}};
    double site[RF_MAX_VIEWS][2];
    copy_places(work, site);
    for (int j = 0; j < work->n_views; j++) {
        struct rf_shape unused;
        parts.area[j] = rf_shape_part(&work->frame->shape, site, work->n_views, j,
                                      &unused, parts.centroid[j]);
    }
    return parts;
}

/*
 * The views of a lens stopped down to the places of less than half of them see it as
 * one: the few that are left would waste the others' samples.
 */
static bool is_stopped_down(const struct parts *parts, int n_views)
{
    double sum = 0, squares = 0;
    for (int j = 0; j < n_views; j++) {
        sum += parts->area[j];
        squares += parts->area[j] * parts->area[j];
    }
    return !(sum > 0) || 2 * sum * sum < n_views * squares;
}

static double distance2(const double a[2], const double b[2])
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

static int nearest_site(const double p[2], double (*site)[2], int n)
{
    int best = 0;
    for (int i = 1; i < n; i++)
        if (distance2(p, site[i]) < distance2(p, site[best]))
            best = i;
    return best;
}

/* Moves each site to the middle of the parts that are nearest to it. */
static void move_sites(const struct parts *parts, int n_views, double (*site)[2], int n)
{
    double sum[RF_MAX_VIEWS][2] = {{0}}, area[RF_MAX_VIEWS] = {0};
    for (int j = 0; j < n_views; j++) {
        int i = nearest_site(parts->centroid[j], site, n);
        area[i] += parts->area[j];
        for (int k = 0; k < 2 && parts->area[j] > 0; k++)
            sum[i][k] += parts->area[j] * parts->centroid[j][k];
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 2 && area[i] > 0; k++)
            site[i][k] = sum[i][k] / area[i];
}

enum { MOVES = 20 }; /* of the sites, when they settle */

/* Sites of n cells that hold about equally many of the views' parts (Lloyd). */
static void find_sites(const struct parts *parts, int n_views, double (*site)[2], int n)
{
    int first = 0;
    for (int j = 1; j < n_views; j++)
        if (parts->area[j] > parts->area[first])
            first = j;
    memcpy(site[0], parts->centroid[first], sizeof site[0]);
    for (int i = 1; i < n; i++) { /* the part that is farthest from the others */
        int best = first;
        double most = 0;
        for (int j = 0; j < n_views; j++) {
            const double *p = parts->centroid[j];
            double d =
                parts->area[j] > 0 ? distance2(p, site[nearest_site(p, site, i)]) : 0;
            if (d > most) {
                most = d;
                best = j;
            }
        }
        memcpy(site[i], parts->centroid[best], sizeof site[i]);
    }
    for (int i = 0; i < MOVES; i++)
        move_sites(parts, n_views, site, n);
}

/* The views whose part lies in the cell of site i. */
static uint64_t views_at(const struct parts *parts, int n_views, double (*site)[2],
                         int n_sites, int i)
{
    uint64_t views = 0;
    if (n_sites == n_views)
        return (uint64_t)1 << i;
    for (int j = 0; j < n_views; j++)
        if (parts->area[j] > 0 && nearest_site(parts->centroid[j], site, n_sites) == i)
            views |= (uint64_t)1 << j;
    return views;
}

/*
 * Keeps the samples of a cell of one view on that view's pixels, where its place on the
 * lens is near enough that footprints do not lie far beside them.
 */
static void set_grid(struct rf_view_cell *cell)
{
    static const double FAR = 1; /* in extents of the cell */
    const struct rf_work_view *view = &cell->v->work->views[cell->middle];
    cell->is_beside_view = !cell->frame.apart;
    for (int k = 0; k < 2; k++) {
        double sign = k ? -1 : 1; /* v is up */
        double slope = cell->centroid[k] - (double)view->lens[k] * view->shift_scale;
        double base = -sign * rf_snap_px(view->lens[k] * view->shift_bias);
        if (!(fabs(slope) <= FAR * cell->extent[k] && fabs(base) < MOST_SHIFT))
            cell->is_beside_view = false;
        else
            cell->shift[k] = (int)lrint(base);
        cell->drift.slope[k] = sign * slope;
        cell->drift.base[k] = base - cell->shift[k];
    }
    cell->is_on_grid = cell->is_beside_view && rf_view_cell_n_own(cell) == 1;
    if (!cell->is_on_grid)
        memset(&cell->drift, 0, sizeof cell->drift);
}

/* The light that comes through a part of the lens. */
static double light_of(const struct rf_shape *part, const struct rf_frame *frame)
{
    struct rf_zone zone = {.shape = part, .cells = {.n = 1}};
    return rf_zone_weigh(&zone, rf_frame_bokeh(frame), rf_frame_bokeh_plane(frame));
}

static struct rf_view_cell whole_lens(struct rf_views *v)
{
    struct rf_view_cell cell = {.v = v,
                                .own = RF_ALL_VIEWS >> (64 - v->work->n_views),
                                .is_whole = true,
                                .middle = rf_views_middle(v->work),
                                .frame = *v->work->frame};
    measure_cell(&cell, (double[2]){0, 0});
    return cell;
}

int rf_views_make_cells(struct rf_views *v, struct rf_view_cell *cells, double *area)
{
    const struct rf_work *work = v->work;
    int n_views = work->n_views, n_sites = rf_min_int(n_views, RF_MOST_CELLS), n = 0;
    double site[RF_MAX_VIEWS][2];
    struct parts parts = cut_lens(work);
    if (is_stopped_down(&parts, n_views)) {
        cells[0] = whole_lens(v);
        area[0] = 1;
        return 1;
    }
    copy_places(work, site);
    if (n_sites < n_views)
        find_sites(&parts, n_views, site, n_sites);
    for (int i = 0; i < n_sites; i++) {
        double centroid[2];
        uint64_t own = views_at(&parts, n_views, site, n_sites, i);
        cells[n] = (struct rf_view_cell){.v = v, .own = own, .frame = *work->frame};
        area[n] = rf_shape_part(&work->frame->shape, site, n_sites, i,
                                &cells[n].frame.shape, centroid);
        if (area[n] > 0 && rf_frame_bokeh(work->frame))
            area[n] = light_of(&cells[n].frame.shape, work->frame);
        if (!own || !(area[n] > 0))
            continue;
        cells[n].middle = nearest_view(work, own, centroid);
        int *sub_apertures = &cells[n].frame.params.sub_apertures;
        *sub_apertures = sub_apertures_of_cell(*sub_apertures, n_sites);
        measure_cell(&cells[n], centroid);
        set_grid(&cells[n]);
        cells[n].index = n;
        n++;
    }
    return n;
}

float rf_views_border(const struct rf_work *work, const struct rf_view_cell *cells,
                      int n)
{
    float most = 0, largest = work->largest_radius;
    if (cells[0].is_whole)
        return largest;
    for (int i = 0; i < n; i++)
        for (uint64_t left = cells[i].own; left; left &= left - 1)
            for (int k = 0; k < 4; k++) {
                const struct rf_work_view *view = &work->views[__builtin_ctzll(left)];
                float r = k & 1 ? largest : -largest;
                float moved = cells[i].centroid[k / 2] * r -
                              view->lens[k / 2] * rf_view_shift(view, r);
                most =
                    rf_max_float(most, fabsf(moved) + largest * cells[i].extent[k / 2]);
            }
    return rf_min_float(most, largest);
}

/* ---- windows ------------------------------------------------------------------- */

/* How far a view shifts what is blurred by r or less, px along the longer axis. */
static float largest_shift(const struct rf_work *work, float r)
{
    float most = 0;
    for (int j = 0; j < work->n_views; j++) {
        const struct rf_work_view *view = &work->views[j];
        float lens = rf_max_float(fabsf(view->lens[0]), fabsf(view->lens[1]));
        float shift =
            rf_max_float(fabsf(rf_view_shift(view, r)), fabsf(rf_view_shift(view, -r)));
        most = rf_max_float(lens * shift, most);
    }
    return most + 1;
}

/* What the widest cell needs; see rf_views_margin(). */
struct widest {
    float moved, extent, footprint, lens;
    int level;
};

static struct widest widest_of(const struct rf_work *work,
                               const struct rf_view_cell *cells, int n, float r)
{
    struct widest w = {.level = 0};
    for (int i = 0; i < n; i++) {
        const struct rf_levels levels = rf_levels_of(&cells[i].frame.shape);
        w.level = rf_max_int(w.level, rf_level_up_to(&levels, r));
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 2; k++) {
            float centroid = cells[i].centroid[k], extent = cells[i].extent[k];
            w.moved = rf_max_float(fabsf(centroid) * r, w.moved);
            w.extent = rf_max_float(extent, w.extent);
            for (uint64_t left = cells[i].own; left; left &= left - 1) {
                const struct rf_work_view *view = &work->views[__builtin_ctzll(left)];
                float at = fabsf(centroid - view->shift_scale * view->lens[k]);
                w.lens = rf_max_float(extent + at, w.lens);
            }
        }
    w.footprint = w.extent * r + (float)(4 << w.level);
    return w;
}

/*
 * With M how far the cells' centroids move a sample, U how far a view shifts it, F the
 * footprint of a cell, E that of the lens and T, H and S of core/window.c: a pixel
 * depends on samples within T + F, or half of T and H. Each stands for a place within
 * M, which the views show within U. It also depends on lights within E. They lie within
 * U of the place where a view shows them, whose depth is looked for on a line as long
 * as 2 U in the others; what stands before them lies within the cones to their cell, 2
 * R times its extent from the place that they have in the view, and what other views
 * show of that within 2 U of there, in blocks of 8 px. Beyond the border it depends on
 * what border_outlines.h says.
 */
rf_result rf_views_margin(struct rf_work *work, int surface_px, int hidden_px,
                          struct rf_margin *margin, struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    struct rf_views v = {.work = work};
    size_t n = (size_t)work->n_views;
    double area[RF_MAX_VIEWS], extent[2];
    struct rf_view_cell *cells = rf_alloc(f->context, n, sizeof *cells);
    if (!cells)
        return rf_fail_memory(error, n, sizeof *cells);
    int n_cells = rf_views_make_cells(&v, cells, area);
    float r = work->largest_radius * 1.0001f, shift = largest_shift(work, r);
    struct widest w = widest_of(work, cells, n_cells, r);
    rf_shape_extent(&f->shape, extent);
    float lens = (float)fmax(extent[0], extent[1]);
    float passes = w.level ? (float)(16 << w.level) : 0;
    float samples = rf_max_float(passes, passes / 2 + (float)hidden_px) + w.footprint +
                    w.moved + shift;
    float lines = 3 * shift + 8, cones = 3 * shift + 2 * r * (w.lens + lens / 8) + 10;
    float lights = lens * r + rf_max_float(lines, cones) + RF_LAMP_REACH_PX;
    int border = rf_picture_border(rf_views_border(work, cells, n_cells));
    float beyond = lens * r + (float)(RF_BESIDE_BORDER * border);
    *margin = (struct rf_margin){
        .px = (int)ceilf(rf_max_float(rf_max_float(samples, lights), beyond)) +
              surface_px,
        .border = border,
        .level = w.level};
    rf_free(f->context, cells);
    return RF_OK;
}
