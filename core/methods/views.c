/* SPDX-License-Identifier: Apache-2.0 */
/*
 * views: several pinhole views from points of the lens, each for its part of the lens.
 *
 * A point of signed radius r at (x, y) of the lens' centre's view is seen by view j,
 * taken from (u_j, v_j) of the unit lens (u right and v up), at
 *
 *   X = x + u_j s(r),  Y = y - v_j s(r)
 *
 * - s(r) = a r + b: the shift in px per unit of the lens; s = r where the views were
 *   sheared to the plane in focus. Another focus or aperture than the views were
 *   rendered with changes a and b only, so the same views can be refocused, stopped
 *   down and opened up
 *
 * The lens is cut into the cells of points that are nearest to each view; more than
 * eight views share eight cells, each for those nearest to its middle. What view j
 * sees is moved to the centroid of its cell,
 *
 *   x = X - u_j s(r) + m_j r
 *
 * and spread as in the method layered, over that cell only; the picture is the mean of
 * the cells' pictures by area. Not the samples of a view alone in its cell are moved,
 * which stay on that view's pixels, but their footprints: these depend on r alone
 * then, and neighbours are spread together.
 *
 * A cell is narrower than the lens by the square root of the number of cells, and so is
 * what its views cannot see. Of the other views, the nearest that does shows that; what
 * none of them saw is estimated (hidden.c). Such samples only fill what the cell's own
 * leave uncovered. Those of views that share a cell have the weight
 *
 *   w = share / max(1/4, n),  n = own + sum over the other views (of the cell) of how
 *                                 much of the place is not occluded there
 *
 * own is 1 for a near part, which looks past nothing, and its share for a far one.
 * Occluded at the nearest pixel: nearer by 0.8 px and pure, 0; nearer but mixed with a
 * far part at or behind r - 0.8, 1 - its share; else 1; outside the picture 0. What
 * continues a picture beyond its border fills only what no view shows.
 *
 * A lens stopped down to the places of less than half of the views is one cell instead,
 * of which the samples of all views are the own ones, with that weight.
 *
 * Lights are taken out first and added at the end with exact visibility over the whole
 * lens (views_lights.c, highlight.c).
 *
 * Ours. One view gives the method layered, bit for bit. Memory: 155 bytes per pixel and
 * view; core/window.c does with less, of a part of the picture at a time. Cost: 5 to
 * 8 layered passes for 8 views at 1920x1080.
 */
#include "../composer.h"
#include "views.h"

enum {
    N_PHASES = 5, /* odd: one is the pixel's centre */
    MOST_SHIFT = 1 << 20 /* px, by which a picture is moved as a whole */
};

/* Of an estimated hidden sample, against those that another view shows. */
static const float ESTIMATE_WEIGHT = 0.1f;

/* ---- one cell of the lens ------------------------------------------------------ */

/* The part of the lens for which some of the views stand. */
struct cell {
    struct rf_views *v;
    int index;               /* among the cells */
    uint64_t own;            /* those views */
    bool is_whole;           /* it is all of the lens, and they are all of the views */
    int middle;              /* the view to estimate hidden samples from */
    struct rf_filter filter; /* with the part as its aperture */
    float centroid[2];
    float extent[2]; /* half width and height of what it makes of radius 1, px */
    /*
     * Of one view, and near its place: samples stay on that view's pixels, moved by
     * whole px, and footprints lie beside them as far as they would have moved. What
     * other views show goes to the nearest of those pixels.
     */
    bool is_on_grid;
    int shift[2];
    struct rf_drift drift;
    struct rf_surface *hidden; /* NULL: not asked for */
    float *hidden_weight;
    struct rf_sample *samples;
};

/* What collects the samples of one row of view `view` for a cell. */
struct collector {
    const struct cell *cell;
    int view;
    struct rf_samples out;
};

/* Does a sample's footprint reach the scene, and does the sample lie in it? */
static bool is_in_scene(const struct cell *cell, const struct rf_sample *p)
{
    const struct rf_picture *l = &cell->v->pictures[cell->middle];
    const float at[2] = {p->x, p->y};
    const int first[2] = {l->x0, l->y0}, size[2] = {l->width, l->height};
    const int rendered[2] = {l->filter->width, l->filter->height};
    for (int k = 0; k < 2; k++) {
        /* Coarse levels reach farther than the footprint does. */
        float reach = 1.5f * cell->extent[k] + fabsf((float)cell->drift.slope[k]);
        float px = fabsf(p->r) * reach + 8;
        float from = rf_max_float((float)first[k] - px, 0);
        float to = rf_min_float((float)(first[k] + rendered[k]) + px, (float)size[k]);
        if (!(at[k] >= from && at[k] < to))
            return false;
    }
    return true;
}

static void put(struct collector *c, struct rf_sample p, int x, int y)
{
    const struct cell *cell = c->cell;
    const struct rf_picture *picture = &cell->v->pictures[c->view];
    struct rf_view_place place = rf_view_place_of(cell->v, c->view, p.x, p.y, p.r);
    p.x = place.x + rf_snap_px(cell->centroid[0] * p.r);
    p.y = place.y - rf_snap_px(cell->centroid[1] * p.r);
    if (is_in_scene(cell, &p))
        rf_picture_emit(picture, p, x, y, &c->out);
}

/* Of what continues a picture, where other views show what is there. */
static const float CONTINUED_WEIGHT = 1e-6f;

static void collect_own(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct collector *c = user;
    const struct rf_views *v = c->cell->v;
    struct rf_sample p = rf_sample_make(s, x, y, w);
    if (c->out.at && !rf_view_is_rendered(&v->pictures[c->view], x, y)) {
        struct rf_view_place place = rf_view_place_of(v, c->view, p.x, p.y, p.r);
        p.w *= rf_views_leave(v, c->view, place, CONTINUED_WEIGHT);
    }
    put(c, p, x, y);
}

/* What view c->view adds to the cell of several views. */
static void collect_shared(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct collector *c = user;
    const struct rf_views *v = c->cell->v;
    const struct rf_picture *picture = &v->pictures[c->view];
    struct rf_sample p = rf_sample_make(s, x, y, w);
    if (c->out.at) {
        bool is_far =
            s !=
            &picture->surfaces.near[(size_t)y * (size_t)picture->width + (size_t)x];
        p.w = rf_view_weight(v, c->cell->own, c->view,
                             rf_view_place_of(v, c->view, p.x, p.y, p.r), p.w, is_far,
                             rf_view_is_rendered(picture, x, y));
    }
    put(c, p, x, y);
}

/* How much the cell's own views show of a place in what was rendered. */
static float seen_by_own(const struct cell *cell, struct rf_view_place place)
{
    float most = 0;
    for (uint64_t left = cell->own; left; left &= left - 1) {
        bool is_true;
        float seen = rf_view_sees(cell->v, __builtin_ctzll(left), place, &is_true);
        most = is_true ? rf_max_float(seen, most) : most;
    }
    return most;
}

/* What the cell's own views do not see, in row y of view c->view. */
static void collect_others(struct collector *c, int y)
{
    const struct cell *cell = c->cell;
    const struct rf_views *v = cell->v;
    const struct rf_picture *picture = &v->pictures[c->view];
    const struct rf_unseen_row *row =
        &v->unseen[(size_t)c->view * (size_t)picture->height + (size_t)y];
    for (int k = 0; k < row->n; k++) {
        const struct rf_unseen *u = &row->at[k];
        if (!(u->cells >> cell->index & 1))
            continue;
        int x = u->part / 4;
        size_t i = (size_t)y * (size_t)picture->width + (size_t)x;
        const struct rf_surface *s =
            u->part & 1 ? &picture->surfaces.far[i] : &picture->surfaces.near[i];
        struct rf_sample p = rf_sample_make(s, x, y, u->weight);
        if (c->out.at) {
            struct rf_view_place place = rf_view_place_of(v, c->view, p.x, p.y, p.r);
            p.w *= 1 - seen_by_own(cell, place);
        }
        put(c, p, x, y);
    }
}

/* Estimates count little where a view shows what they stand for. */
static void collect_hidden(struct collector *c, int y)
{
    const struct cell *cell = c->cell;
    int width = cell->v->pictures[c->view].width;
    for (int x = 0; x < width; x++) {
        size_t i = (size_t)y * (size_t)width + (size_t)x;
        struct rf_sample p =
            rf_sample_make(&cell->hidden[i], x, y, cell->hidden_weight[i]);
        if (!(p.w > 0))
            continue;
        if (c->out.at && !cell->is_whole) {
            struct rf_view_place place =
                rf_view_place_of(cell->v, c->view, p.x, p.y, p.r);
            p.w *= rf_views_leave(cell->v, c->view, place, ESTIMATE_WEIGHT);
        }
        put(c, p, x, y);
    }
}

static int n_own(const struct cell *cell)
{
    return __builtin_popcountll(cell->own);
}

/* The own views come first, then the others. */
static int view_of_block(const struct cell *cell, int block)
{
    bool is_own = block < n_own(cell);
    int left = is_own ? block : block - n_own(cell), j = 0;
    for (;; j++)
        if ((cell->own >> j & 1) == is_own && left-- == 0)
            return j;
}

/*
 * Row i of the visible samples, then of those of the other views, then of the
 * estimates.
 */
static size_t collect_row(void *user, int i, struct rf_sample *at)
{
    struct cell *cell = user;
    struct rf_views *v = cell->v;
    int height = v->pictures[0].height, block = i / height, y = i % height;
    struct collector c = {.cell = cell, .out = {at, 0}};
    if (block == v->work->n_views) {
        c.view = cell->middle;
        collect_hidden(&c, y);
        return c.out.n;
    }
    c.view = view_of_block(cell, block);
    if (!(cell->own >> c.view & 1))
        collect_others(&c, y);
    else
        rf_picture_visit_row(&v->pictures[c.view], y,
                             n_own(cell) > 1 ? collect_shared : collect_own, &c);
    return c.out.n;
}

/* ---- cells of one view ---------------------------------------------------------- */

/* Pixels of the scene to those of the view, and the part of n that the view has. */
struct run {
    int x, y, first, end;
};

static struct run run_of(const struct cell *cell, int x, int y, int n)
{
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    struct run r = {.x = x - cell->shift[0], .y = y - cell->shift[1]};
    r.first = rf_min_int(rf_max_int(-r.x, 0), n);
    r.end = rf_max_int(rf_min_int(picture->width - r.x, n), r.first);
    if (r.y < 0 || r.y >= picture->height)
        r.end = r.first;
    return r;
}

static struct rf_emission survey_own(void *user, int x, int y, int n)
{
    const struct cell *cell = user;
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    struct run r = run_of(cell, x, y, n);
    if (r.first == r.end)
        return (struct rf_emission){0, 0};
    uint64_t all = UINT64_MAX >> (64 - (r.end - r.first)) << r.first, plain = 0;
    /* What continues the picture has another weight. */
    int first = rf_max_int(r.first, picture->x0 - r.x);
    int end = rf_min_int(r.end, picture->x0 + picture->filter->width - r.x);
    bool is_rendered =
        r.y >= picture->y0 && r.y < picture->y0 + picture->filter->height;
    if (is_rendered && first < end)
        plain = rf_picture_find_plain(picture, r.x + first, r.y, end - first) << first;
    return (struct rf_emission){plain, all & ~plain};
}

/* Emits a sample of the view's pixel (x, y), moved by whole px. */
static void emit_moved(const struct cell *cell, struct rf_sample p, int x, int y,
                       struct rf_samples *out)
{
    p.x += (float)cell->shift[0];
    p.y += (float)cell->shift[1];
    rf_picture_emit(&cell->v->pictures[cell->middle], p, x, y, out);
}

static int emit_own(void *user, int x, int y, struct rf_sample *at)
{
    const struct cell *cell = user;
    const struct rf_views *v = cell->v;
    const struct rf_picture *picture = &v->pictures[cell->middle];
    const struct rf_surfaces *s = &picture->surfaces;
    struct rf_samples out = {at, 0};
    x -= cell->shift[0];
    y -= cell->shift[1];
    size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    const float shares[2] = {s->share[i], 1 - s->share[i]};
    for (int part = 0; part < 2; part++) {
        if (!(shares[part] > 0))
            continue;
        struct rf_sample p =
            rf_sample_make(part ? &s->far[i] : &s->near[i], x, y, shares[part]);
        if (!rf_view_is_rendered(picture, x, y)) {
            struct rf_view_place place =
                rf_view_place_of(v, cell->middle, p.x, p.y, p.r);
            float left = rf_views_leave(v, cell->middle, place, CONTINUED_WEIGHT);
            if (left <= CONTINUED_WEIGHT)
                continue;
            p.w *= left;
        }
        emit_moved(cell, p, x, y, &out);
    }
    return (int)out.n;
}

static struct rf_emission survey_estimates(void *user, int x, int y, int n)
{
    const struct cell *cell = user;
    struct run r = run_of(cell, x, y, n);
    if (r.first == r.end)
        return (struct rf_emission){0, 0};
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    const struct rf_kernels *kernels = picture->filter->context->kernels;
    const float *w = cell->hidden_weight + (size_t)r.y * (size_t)picture->width;
    uint64_t found = kernels->find_positive(w + r.x + r.first, r.end - r.first);
    return (struct rf_emission){0, found << r.first};
}

static int emit_estimate(void *user, int x, int y, struct rf_sample *at)
{
    const struct cell *cell = user;
    struct rf_samples out = {at, 0};
    x -= cell->shift[0];
    y -= cell->shift[1];
    size_t i = (size_t)y * (size_t)cell->v->pictures[cell->middle].width + (size_t)x;
    struct rf_sample p = rf_sample_make(&cell->hidden[i], x, y, cell->hidden_weight[i]);
    struct rf_view_place place = rf_view_place_of(cell->v, cell->middle, p.x, p.y, p.r);
    p.w *= rf_views_leave(cell->v, cell->middle, place, ESTIMATE_WEIGHT);
    emit_moved(cell, p, x, y, &out);
    return (int)out.n;
}

/* What view `view` shows in one entry of its row y, and the cell's own does not see. */
static struct rf_sample unseen_sample(const struct cell *cell, int view, int y,
                                      const struct rf_unseen *u)
{
    const struct rf_views *v = cell->v;
    const struct rf_picture *from = &v->pictures[view];
    const struct rf_picture *own = &v->pictures[cell->middle];
    const struct rf_work_view *own_view = &v->work->views[cell->middle];
    int x = u->part / 4;
    size_t i = (size_t)y * (size_t)from->width + (size_t)x;
    const struct rf_surface *s =
        u->part & 1 ? &from->surfaces.far[i] : &from->surfaces.near[i];
    struct rf_sample p = rf_sample_make(s, x, y, u->weight);
    struct rf_view_place place = rf_view_place_of(v, view, p.x, p.y, p.r);
    float shift = rf_view_shift(own_view, p.r);
    p.x = place.x + rf_snap_px(own_view->lens[0] * shift);
    p.y = place.y - rf_snap_px(own_view->lens[1] * shift);
    int px = rf_view_floor(p.x), py = rf_view_floor(p.y);
    if (rf_view_is_rendered(own, px, py))
        p.w *= 1 - rf_view_pixel_sees(own, px, py, p.r);
    p.x += (float)cell->shift[0];
    p.y += (float)cell->shift[1];
    return p;
}

/* Row i of the samples of the other views; counted are those out of reach, too. */
static size_t collect_others_row(void *user, int i, struct rf_sample *at)
{
    struct cell *cell = user;
    int height = cell->v->pictures[0].height, block = i / height, y = i % height;
    int view = block < cell->middle ? block : block + 1;
    const struct rf_unseen_row *row = &cell->v->unseen[(size_t)view * (size_t)height +
                                                       (size_t)y];
    struct rf_samples out = {at, 0};
    for (int k = 0; k < row->n; k++) {
        const struct rf_unseen *u = &row->at[k];
        bool is_bright = u->part & 2;
        if (!(u->cells >> cell->index & 1))
            continue;
        if (!at) {
            out.n += is_bright ? 2 : 1;
            continue;
        }
        struct rf_sample p = unseen_sample(cell, view, y, u);
        if (!is_in_scene(cell, &p))
            continue;
        if (is_bright)
            rf_picture_emit(&cell->v->pictures[view], p, u->part / 4, y, &out);
        else
            at[out.n++] = p;
    }
    return out.n;
}

/* The samples of a cell that is on its view's grid. */
static rf_result set_sources(struct cell *cell, struct rf_scene *scene,
                             struct rf_error *error)
{
    const struct rf_views *v = cell->v;
    const struct rf_picture *picture = &v->pictures[cell->middle];
    struct rf_source source = {.survey = survey_own,
                               .emit = emit_own,
                               .user = cell,
                               .surfaces = picture->surfaces.near,
                               .x = cell->shift[0],
                               .y = cell->shift[1],
                               .most_per_pixel = 4,
                               .largest_radius = v->work->largest_radius};
    scene->drift = cell->drift;
    scene->visible_source = source;
    if (cell->hidden) {
        source.survey = survey_estimates;
        source.emit = emit_estimate;
        source.most_per_pixel = 2;
        scene->hidden_source = source;
    }
    return rf_collect_rows(scene, 0, (v->work->n_views - 1) * picture->height,
                           collect_others_row, cell, &cell->samples, error);
}

/* ---- all cells ------------------------------------------------------------------ */

/* Do other views show what may lie behind a pixel of the middle one? */
static bool is_shown(void *user, int x, int y, const struct rf_surface *hidden)
{
    const struct cell *cell = user;
    struct rf_view_place place = rf_view_place_of(
        cell->v, cell->middle, (float)x + 0.5f, (float)y + 0.5f, hidden->r);
    return rf_views_leave(cell->v, cell->middle, place, ESTIMATE_WEIGHT) <=
           ESTIMATE_WEIGHT;
}

static rf_result find_hidden(struct cell *cell, double progress_to,
                             struct rf_error *error)
{
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    const struct rf_context *context = cell->filter.context;
    size_t n = (size_t)picture->width * (size_t)picture->height;
    cell->hidden = rf_alloc(context, n, sizeof *cell->hidden);
    cell->hidden_weight = rf_alloc(context, n, sizeof *cell->hidden_weight);
    if (!cell->hidden || !cell->hidden_weight)
        return rf_fail_memory(error, n, sizeof *cell->hidden);
    rf_task_phase(cell->v->work->task, progress_to, rf_hidden_steps(picture->height));
    struct rf_known known = {is_shown, cell};
    return rf_find_hidden(&cell->filter, &picture->surfaces,
                          cell->is_whole ? NULL : &known, cell->hidden,
                          cell->hidden_weight, cell->v->work->task, error);
}

static bool is_opaque(const struct rf_views *v)
{
    for (int j = 0; j < v->work->n_views; j++) {
        const struct rf_survey *survey = v->work->views[j].survey;
        if (survey ? survey->n_transparent > 0 : v->pictures[j].has_alpha)
            return false;
    }
    return true;
}

/* The picture through the cell, to the colours of the work. */
static rf_result run_cell(struct cell *cell, double progress_to, struct rf_error *error)
{
    struct rf_work *work = cell->v->work;
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    double from = work->task->to;
    rf_result result = RF_OK;
    if (work->filter->params.fill_hidden)
        result = find_hidden(cell, from + 0.2 * (progress_to - from), error);
    struct rf_occluders occluders = {.surfaces = &picture->surfaces};
    struct rf_scene scene = {.filter = &cell->filter,
                             .width = picture->width,
                             .height = picture->height,
                             .x0 = picture->x0,
                             .y0 = picture->y0,
                             .n_phases = cell->is_on_grid ? 1 : N_PHASES,
                             .is_opaque = is_opaque(cell->v),
                             .occluders = &occluders,
                             .n_views = 1,
                             .task = work->task,
                             .progress_to = progress_to};
    int height = picture->height, n_views = work->n_views;
    int n_visible = n_own(cell) * height;
    int n_others = (n_views + (cell->hidden ? 1 : 0)) * height - n_visible;
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = cell->is_on_grid
                     ? set_sources(cell, &scene, error)
                     : rf_collect_rows(&scene, n_visible, n_visible + n_others,
                                       collect_row, cell, &cell->samples, error);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = rf_composite_crop(&scene, work, error);
    return result;
}

/* ---- the cells ------------------------------------------------------------------ */

/* Of some views, the one from the place nearest to (u, v) of the lens. */
static int nearest_view(const struct rf_work *work, uint64_t views, const double at[2])
{
    int best = -1;
    double least = INFINITY;
    for (; views; views &= views - 1) {
        int j = __builtin_ctzll(views);
        double d =
            hypot(work->views[j].lens[0] - at[0], work->views[j].lens[1] - at[1]);
        if (d < least) {
            least = d;
            best = j;
        }
    }
    return best;
}

static int middle_view(const struct rf_work *work)
{
    return nearest_view(work, RF_ALL_VIEWS >> (64 - work->n_views), (double[2]){0, 0});
}

/* A cell is a sub-aperture itself and needs fewer of its own: two at the least. */
static int sub_apertures_of_cell(int whole, int n_views)
{
    return rf_max_int(rf_min_int(whole, 2), (2 * whole + n_views - 1) / n_views);
}

static void measure_cell(struct cell *cell, const double centroid[2])
{
    double extent[2];
    rf_shape_extent(&cell->filter.shape, extent);
    for (int k = 0; k < 2; k++) {
        cell->extent[k] = (float)extent[k];
        cell->centroid[k] = (float)centroid[k];
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
            place[j][k] = work->views[j].lens[k];
}

static struct parts cut_lens(const struct rf_work *work)
{
    struct parts parts = {{0}, {{0}}};
    double site[RF_MAX_VIEWS][2];
    copy_places(work, site);
    for (int j = 0; j < work->n_views; j++) {
        struct rf_shape unused;
        parts.area[j] = rf_shape_part(&work->filter->shape, site, work->n_views, j,
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
            double d = parts->area[j] > 0 ? distance2(p, site[nearest_site(p, site, i)])
                                          : 0;
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
        if (parts->area[j] > 0 &&
            nearest_site(parts->centroid[j], site, n_sites) == i)
            views |= (uint64_t)1 << j;
    return views;
}

/*
 * Keeps the samples of a cell of one view on that view's pixels, where its place on the
 * lens is near enough that footprints do not lie far beside them.
 */
static void set_grid(struct cell *cell)
{
    static const double FAR = 1; /* in extents of the cell */
    const struct rf_work_view *view = &cell->v->work->views[cell->middle];
    cell->is_on_grid = n_own(cell) == 1;
    for (int k = 0; k < 2; k++) {
        double sign = k ? -1 : 1; /* v is up */
        double slope = cell->centroid[k] - (double)view->lens[k] * view->shift_scale;
        double base = -sign * rf_snap_px(view->lens[k] * view->shift_bias);
        if (!(fabs(slope) <= FAR * cell->extent[k] && fabs(base) < MOST_SHIFT))
            cell->is_on_grid = false;
        else
            cell->shift[k] = (int)lrint(base);
        cell->drift.slope[k] = sign * slope;
        cell->drift.base[k] = base - cell->shift[k];
    }
    if (!cell->is_on_grid)
        memset(&cell->drift, 0, sizeof cell->drift);
}

static struct cell whole_lens(struct rf_views *v)
{
    struct cell cell = {.v = v,
                        .own = RF_ALL_VIEWS >> (64 - v->work->n_views),
                        .is_whole = true,
                        .middle = middle_view(v->work),
                        .filter = *v->work->filter};
    measure_cell(&cell, (double[2]){0, 0});
    return cell;
}

/*
 * Cuts the lens into cells; returns how many there are. Many views share them: a pixel
 * of a cell has the samples of its own views alone, and few of them are grain.
 */
static int make_cells(struct rf_views *v, struct cell *cells, double *area)
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
        cells[n] = (struct cell){.v = v, .own = own, .filter = *work->filter};
        area[n] = rf_shape_part(&work->filter->shape, site, n_sites, i,
                                &cells[n].filter.shape, centroid);
        if (!own || !(area[n] > 0))
            continue;
        cells[n].middle = nearest_view(work, own, centroid);
        int *sub_apertures = &cells[n].filter.params.sub_apertures;
        *sub_apertures = sub_apertures_of_cell(*sub_apertures, n_sites);
        measure_cell(&cells[n], centroid);
        set_grid(&cells[n]);
        cells[n].index = n;
        n++;
    }
    return n;
}

/*
 * How far beyond the picture lies what the cells can show of it: what their views see,
 * moved to the cell's place, and its footprint.
 */
static float border_of(const struct rf_work *work, const struct cell *cells, int n)
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

static struct widest widest_of(const struct rf_work *work, const struct cell *cells,
                               int n, float r)
{
    struct widest w = {.level = 0};
    for (int i = 0; i < n; i++)
        w.level =
            rf_max_int(w.level, rf_level_of(rf_level_split(&cells[i].filter.shape), r));
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
 * R times its extent from the place that they have in the view.
 */
rf_result rf_views_margin(struct rf_work *work, int surface_px, int hidden_px,
                          struct rf_margin *margin, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    struct rf_views v = {.work = work};
    size_t n = (size_t)work->n_views;
    double area[RF_MAX_VIEWS], extent[2];
    struct cell *cells = rf_alloc(f->context, n, sizeof *cells);
    if (!cells)
        return rf_fail_memory(error, n, sizeof *cells);
    int n_cells = make_cells(&v, cells, area);
    float r = work->largest_radius * 1.0001f, shift = largest_shift(work, r);
    struct widest w = widest_of(work, cells, n_cells, r);
    rf_shape_extent(&f->shape, extent);
    float lens = (float)fmax(extent[0], extent[1]);
    float passes = w.level ? (float)(16 << w.level) : 0;
    float samples = rf_max_float(passes, passes / 2 + (float)hidden_px) + w.footprint +
                    w.moved + shift;
    float lines = 3 * shift + 8, cones = shift + 2 * r * (w.lens + lens / 8) + 2;
    float lights = lens * r + rf_max_float(lines, cones);
    *margin =
        (struct rf_margin){.px = (int)ceilf(rf_max_float(samples, lights)) + surface_px,
                           .border = rf_picture_border(border_of(work, cells, n_cells)),
                           .level = w.level};
    rf_free(f->context, cells);
    return RF_OK;
}

/* ---- all ----------------------------------------------------------------------- */

static rf_result load(struct rf_views *v, int border, struct rf_error *error)
{
    struct rf_work *work = v->work;
    for (int j = 0; j < work->n_views; j++) {
        rf_task_phase(work->task, 0.2 * (j + 1) / work->n_views,
                      work->filter->height + 2 * border);
        rf_result result =
            rf_picture_load(&v->pictures[j], work->filter, &work->views[j],
                            work->n_planes, border, true, work->task, error);
        if (result != RF_OK)
            return result;
        const struct rf_work_view *view = &work->views[j];
        v->occluders[j] = (struct rf_occluders){
            .surfaces = &v->pictures[j].surfaces,
            .lens = {view->lens[0], view->lens[1]},
            .shift_scale = view->shift_scale,
            .shift_bias = view->shift_bias,
        };
    }
    return RF_OK;
}

/* Adds the planes of the work, times `weight`, to planes of width x height. */
static void add_picture(const struct rf_work *work, double weight, float *sum)
{
    int64_t n = (int64_t)work->filter->width * work->filter->height;
    for (int p = 0; p < work->n_planes; p++) {
        float *out = sum + n * p;
#pragma omp parallel for num_threads(work->filter->context->n_threads) schedule(static)
        for (int64_t i = 0; i < n; i++)
            out[i] += (float)weight * work->colour[p][i];
    }
}

/* Finds which views the cell asks, and in which order. */
static void rank_views(const struct cell *cell)
{
    const struct rf_work *work = cell->v->work;
    const float *middle = work->views[cell->middle].lens;
    struct rf_cell_views *views = &cell->v->cells[cell->index];
    float distance2[RF_MAX_VIEWS];
    for (int j = 0; j < work->n_views; j++) {
        const float *lens = work->views[j].lens;
        float u = lens[0] - middle[0], v = lens[1] - middle[1];
        distance2[j] = u * u + v * v;
    }
    *views = (struct rf_cell_views){.own = cell->own};
    for (int j = 0; j < work->n_views; j++)
        for (int k = 0; k < work->n_views; k++)
            if (!(cell->own >> k & 1) &&
                (distance2[k] < distance2[j] ||
                 (distance2[k] == distance2[j] && k < j)))
                views->nearer[j] |= (uint64_t)1 << k;
}

static rf_result find_unseen(struct rf_views *v, const struct cell *cells, int n,
                             struct rf_error *error)
{
    if (cells[0].is_whole)
        return RF_OK;
    v->n_cells = n;
    for (int i = 0; i < n; i++)
        rank_views(&cells[i]);
    return rf_views_find_unseen(v, error);
}

/* Adds the cells' pictures by area to `sum`. */
static rf_result add_cells(struct rf_views *v, struct cell *cells, const double *area,
                           int n, float *sum, struct rf_error *error)
{
    struct rf_work *work = v->work;
    const struct rf_context *context = work->filter->context;
    double from = work->task->to;
    rf_result result = find_unseen(v, cells, n, error);
    for (int i = 0; i < n && result == RF_OK; i++) {
        struct cell *cell = &cells[i];
        result = run_cell(cell, from + (0.9 - from) * (i + 1) / n, error);
        rf_free(context, cell->samples);
        rf_free(context, cell->hidden_weight);
        rf_free(context, cell->hidden);
        if (rf_task_is_cancelled(work->task))
            break;
        if (result == RF_OK)
            add_picture(work, area[i], sum);
    }
    return result;
}

/* The light of the lights over the whole lens, in planes of the padded picture. */
static rf_result add_lights(const struct rf_views *v, int n_colours, float *memory,
                            struct rf_error *error)
{
    const struct rf_picture *picture = &v->pictures[0];
    struct rf_scene scene = {.filter = v->work->filter,
                             .width = picture->width,
                             .height = picture->height,
                             .x0 = picture->x0,
                             .y0 = picture->y0,
                             .n_colours = n_colours,
                             .n_phases = N_PHASES,
                             .highlights = v->lights,
                             .occluders = v->occluders,
                             .n_views = v->work->n_views,
                             .task = v->work->task,
                             .progress_to = 1};
    struct rf_crop all = {0, 0, picture->width, picture->height, {NULL}};
    for (int p = 0; p < n_colours; p++)
        all.planes[p] =
            memory + (size_t)picture->width * (size_t)picture->height * (size_t)p;
    return rf_add_highlights(&scene, &all, error);
}

/* Writes the mean of the cells and the lights to the colours of the work. */
static void finish(const struct rf_views *v, const float *sum, double total,
                   const float *lights)
{
    const struct rf_work *work = v->work;
    const struct rf_picture *picture = &v->pictures[0];
    int width = work->filter->width, height = work->filter->height;
    size_t n = (size_t)width * (size_t)height;
    size_t n_padded = (size_t)picture->width * (size_t)picture->height;
#pragma omp parallel for num_threads(work->filter->context->n_threads) schedule(static)
    for (int y = 0; y < height; y++)
        for (int p = 0; p < work->n_planes; p++) {
            const float *from = sum + n * (size_t)p + (size_t)y * (size_t)width;
            const float *light = lights + n_padded * (size_t)p +
                                 (size_t)(y + picture->y0) * (size_t)picture->width +
                                 (size_t)picture->x0;
            float *out = work->colour[p] + (size_t)y * (size_t)width;
            for (int x = 0; x < width; x++)
                out[x] = from[x] / (float)total + light[x];
        }
}

/* The picture of loaded views whose lights have been taken. */
static rf_result merge(struct rf_views *v, struct cell *cells, const double *area,
                       int n_cells, struct rf_error *error)
{
    struct rf_work *work = v->work;
    const struct rf_filter *f = work->filter;
    int n_colours = work->n_planes == 4 ? 4 : 3;
    size_t n = (size_t)f->width * (size_t)f->height * (size_t)work->n_planes;
    size_t n_padded = (size_t)v->pictures[0].width * (size_t)v->pictures[0].height *
                      (size_t)n_colours;
    float *sum = rf_calloc(f->context, n, sizeof *sum), *lights = NULL;
    double total = 0;
    for (int i = 0; i < n_cells; i++)
        total += area[i];
    rf_result result = sum ? add_cells(v, cells, area, n_cells, sum, error)
                           : rf_fail_memory(error, n, sizeof *sum);
    if (result == RF_OK && !rf_task_is_cancelled(work->task)) {
        lights = rf_calloc(f->context, n_padded, sizeof *lights);
        result = lights ? add_lights(v, n_colours, lights, error)
                        : rf_fail_memory(error, n_padded, sizeof *lights);
    }
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        finish(v, sum, total, lights);
    rf_free(f->context, lights);
    rf_free(f->context, sum);
    return result;
}

static rf_result run(struct rf_views *v, struct rf_error *error)
{
    struct rf_work *work = v->work;
    const struct rf_context *context = work->filter->context;
    double area[RF_MAX_VIEWS];
    struct cell *cells = rf_alloc(context, (size_t)work->n_views, sizeof *cells);
    if (!cells)
        return rf_fail_memory(error, (size_t)work->n_views, sizeof *cells);
    int n_cells = make_cells(v, cells, area);
    rf_views_measure_range(v);
    int border = rf_picture_border(border_of(work, cells, n_cells));
    rf_result result = load(v, border, error);
    if (result == RF_OK && work->filter->params.exact_highlights)
        result = rf_views_take_lights(v, error);
    for (int j = 0; j < work->n_views && result == RF_OK; j++)
        rf_picture_drop_pixels(&v->pictures[j]);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = merge(v, cells, area, n_cells, error);
    rf_free(context, cells);
    return result;
}

/* A preview takes the view nearest to the lens' centre alone. */
static rf_result run_preview(struct rf_work *work, struct rf_error *error)
{
    const struct rf_work_view *view = &work->views[middle_view(work)];
    memcpy(work->colour, view->colour, sizeof work->colour);
    work->radius = view->radius;
    return rf_layered_preview_run(work, error);
}

rf_result rf_views_run(struct rf_work *work, struct rf_error *error)
{
    if (work->filter->params.quality == RF_QUALITY_PREVIEW)
        return run_preview(work, error);
    if (work->n_views == 1)
        return rf_layered_run(work, error);
    const struct rf_context *context = work->filter->context;
    size_t n = (size_t)work->n_views;
    struct rf_views v = {.work = work,
                         .pictures = rf_calloc(context, n, sizeof *v.pictures),
                         .occluders = rf_calloc(context, n, sizeof *v.occluders)};
    rf_result result = v.pictures && v.occluders
                           ? run(&v, error)
                           : rf_fail_memory(error, n, sizeof *v.pictures);
    rf_views_free_unseen(&v);
    for (size_t j = 0; j < n && v.pictures; j++)
        rf_picture_free(&v.pictures[j]);
    rf_free(context, v.lights.at);
    rf_free(context, v.occluders);
    rf_free(context, v.pictures);
    return result;
}
