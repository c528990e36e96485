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
 * The lens is cut into the cells of points that are nearest to each view. What view j
 * sees is moved to the centroid of its cell,
 *
 *   x = X - u_j s(r) + m_j r
 *
 * and spread as in the method layered, over that cell only; the picture is the mean of
 * the cells' pictures by area. A cell is narrower than the lens by the square root of
 * the number of views, and so is what its view cannot see: other views show that, and
 * what none of them saw is estimated (hidden.c). Such samples only fill what the view's
 * own leave uncovered; each has the weight
 *
 *   w = share / max(1/4, n),  n = own + sum over the other views of how much of the
 *                                 place is not occluded there
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
 * Ours. One view gives the method layered, bit for bit. Memory: 175 bytes per pixel and
 * view. Cost: 11 to 14 layered passes for 8 views.
 */
#include "views.h"

enum { N_PHASES = 5 }; /* odd: one is the pixel's centre */

static const float LEAST_COUNT = 0.25f;
/* Of an estimated hidden sample, against those that another view shows. */
static const float ESTIMATE_WEIGHT = 0.1f;

static float shift_of(const struct rf_work_view *view, float r)
{
    return view->shift_scale * r + view->shift_bias;
}

struct rf_view_place rf_view_place_of(const struct rf_views *v, int j, float x, float y,
                                      float r)
{
    const struct rf_work_view *view = &v->work->views[j];
    float shift = shift_of(view, r);
    return (struct rf_view_place){x - view->lens[0] * shift, y + view->lens[1] * shift,
                                  r};
}

/* floorf() to int, without the call that the C library needs on plain x86-64. */
static int floor_int(float v)
{
    int i = (int)v;
    return i - (v < (float)i);
}

bool rf_view_pixel_at(const struct rf_views *v, int j, struct rf_view_place p, int *px,
                      int *py)
{
    const struct rf_work_view *view = &v->work->views[j];
    const struct rf_surfaces *s = &v->pictures[j].surfaces;
    float shift = shift_of(view, p.r);
    *px = floor_int(p.x + view->lens[0] * shift);
    *py = floor_int(p.y - view->lens[1] * shift);
    return *px >= 0 && *py >= 0 && *px < s->width && *py < s->height;
}

bool rf_view_is_rendered(const struct rf_picture *l, int x, int y)
{
    return x >= l->border && y >= l->border && x < l->width - l->border &&
           y < l->height - l->border;
}

/* How much of a place view j sees, and whether in what was rendered. */
static float seen_by(const struct rf_views *v, int j, struct rf_view_place p,
                     bool *is_rendered)
{
    const struct rf_surfaces *s = &v->pictures[j].surfaces;
    int px, py;
    *is_rendered = false;
    if (!rf_view_pixel_at(v, j, p, &px, &py))
        return 0;
    *is_rendered = rf_view_is_rendered(&v->pictures[j], px, py);
    size_t i = (size_t)py * (size_t)s->width + (size_t)px;
    float limit = p.r - RF_OCCLUDED_PX, share = s->share[i];
    if (share <= 0)
        return s->far[i].r < limit ? 0 : 1;
    if (s->near[i].r >= limit)
        return 1;
    return share < 1 && s->far[i].r >= limit ? 1 - share : 0;
}

/* How much of a place the views other than j show. */
static float shown_by_others(const struct rf_views *v, int j, struct rf_view_place p,
                             float *continued)
{
    float shown = 0;
    *continued = 0;
    for (int k = 0; k < v->work->n_views; k++) {
        bool is_rendered;
        if (k == j)
            continue;
        float seen = seen_by(v, k, p, &is_rendered);
        *(is_rendered ? &shown : continued) += seen;
    }
    return shown;
}

float rf_view_weight(const struct rf_views *v, int j, struct rf_view_place p,
                     float share, bool is_far, bool is_rendered)
{
    float continued, shown = shown_by_others(v, j, p, &continued);
    float own = is_far ? share : 1;
    if (is_rendered)
        return share / rf_max_float(own + shown, LEAST_COUNT);
    return share * rf_max_float(1 - shown, 1e-6f) /
           rf_max_float(own + continued, LEAST_COUNT);
}

/* ---- one cell of the lens ------------------------------------------------------ */

enum { ALL_VIEWS = -1 };

/* The part of the lens for which view `own` stands; or the whole one for ALL_VIEWS. */
struct cell {
    struct rf_views *v;
    int own;
    int middle;              /* the view to estimate hidden samples from */
    struct rf_filter filter; /* with the part as its aperture */
    float centroid[2];
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

static void put(struct collector *c, struct rf_sample p, int x, int y)
{
    const struct cell *cell = c->cell;
    const struct rf_picture *picture = &cell->v->pictures[c->view];
    struct rf_view_place place = rf_view_place_of(cell->v, c->view, p.x, p.y, p.r);
    p.x = place.x + cell->centroid[0] * p.r;
    p.y = place.y - cell->centroid[1] * p.r;
    if (p.x >= 0 && p.y >= 0 && p.x < (float)picture->width &&
        p.y < (float)picture->height)
        rf_picture_emit(picture, p, x, y, &c->out);
}

static void collect_own(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct collector *c = user;
    const struct rf_views *v = c->cell->v;
    struct rf_sample p = rf_sample_make(s, x, y, w);
    if (c->out.at && !rf_view_is_rendered(&v->pictures[c->view], x, y)) {
        float continued;
        struct rf_view_place place = rf_view_place_of(v, c->view, p.x, p.y, p.r);
        float shown = shown_by_others(v, c->view, place, &continued);
        p.w *= rf_max_float(1 - shown, 1e-6f);
    }
    put(c, p, x, y);
}

/* What view c->view adds to a picture of all views. */
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
        p.w = rf_view_weight(v, c->view, rf_view_place_of(v, c->view, p.x, p.y, p.r),
                             p.w, is_far, rf_view_is_rendered(picture, x, y));
    }
    put(c, p, x, y);
}

/* Where v->unseen speaks of a part of pixel (x, y) of view k. */
static size_t part_index(const struct rf_views *v, int k, const struct rf_surface *s,
                         int x, int y)
{
    const struct rf_picture *picture = &v->pictures[k];
    size_t n = (size_t)picture->width * (size_t)picture->height;
    size_t i = (size_t)y * (size_t)picture->width + (size_t)x;
    return 2 * (n * (size_t)k + i) + (s != &picture->surfaces.near[i]);
}

/* What the cell's own view does not see. */
static void collect_other(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct collector *c = user;
    const struct rf_views *v = c->cell->v;
    size_t part = part_index(v, c->view, s, x, y);
    if (!(v->unseen[part] >> c->cell->own & 1))
        return;
    struct rf_sample p = rf_sample_make(s, x, y, w);
    if (c->out.at) {
        bool is_true;
        struct rf_view_place place = rf_view_place_of(v, c->view, p.x, p.y, p.r);
        float seen = seen_by(v, c->cell->own, place, &is_true);
        p.w = (is_true ? 1 - seen : 1) *
              rf_view_weight(v, c->view, place, p.w, part & 1, true);
    }
    put(c, p, x, y);
}

enum { BLOCK = 16 };

/* What marks the rows of a view in v->unseen. */
struct marker {
    struct rf_views *v;
    int view, n_x, n_y;
    /* Per view and block: the least radius in it; -INFINITY where not all is rendered.
     */
    float *lowest;
};

static void find_lowest(const struct marker *m, int j, int by)
{
    const struct rf_picture *l = &m->v->pictures[j];
    const struct rf_surfaces *s = &l->surfaces;
    float *lowest =
        m->lowest + ((size_t)j * (size_t)m->n_y + (size_t)by) * (size_t)m->n_x;
    for (int bx = 0; bx < m->n_x; bx++)
        lowest[bx] = INFINITY;
    for (int y = by * BLOCK; y < rf_min_int((by + 1) * BLOCK, l->height); y++)
        for (int x = 0; x < l->width; x++) {
            size_t i = (size_t)y * (size_t)l->width + (size_t)x;
            float *low = &lowest[x / BLOCK];
            *low = rf_min_float(rf_min_float(*low, s->far[i].r),
                                s->share[i] > 0 ? s->near[i].r : INFINITY);
            if (!rf_view_is_rendered(l, x, y))
                *low = -INFINITY;
        }
}

static void mark_unseen(void *user, struct rf_surface *s, int x, int y, float w)
{
    (void)w;
    const struct marker *m = user;
    struct rf_views *v = m->v;
    struct rf_view_place place =
        rf_view_place_of(v, m->view, (float)x + 0.5f, (float)y + 0.5f, s->r);
    uint64_t unseen = 0;
    for (int j = 0; j < v->work->n_views; j++) {
        bool is_true;
        int px, py;
        if (j == m->view)
            continue;
        if (rf_view_pixel_at(v, j, place, &px, &py) &&
            m->lowest[((size_t)j * (size_t)m->n_y + (size_t)(py / BLOCK)) *
                          (size_t)m->n_x +
                      (size_t)(px / BLOCK)] >= place.r - RF_OCCLUDED_PX)
            continue;
        if (seen_by(v, j, place, &is_true) < 0.5f || !is_true)
            unseen |= (uint64_t)1 << j;
    }
    v->unseen[part_index(v, m->view, s, x, y)] = unseen;
}

static rf_result find_unseen(struct rf_views *v, struct rf_error *error)
{
    const struct rf_picture *picture = &v->pictures[0];
    const struct rf_context *context = v->work->filter->context;
    int n_views = v->work->n_views, height = picture->height;
    size_t n = 2 * (size_t)picture->width * (size_t)height * (size_t)n_views;
    struct marker all = {.v = v,
                         .n_x = (picture->width + BLOCK - 1) / BLOCK,
                         .n_y = (height + BLOCK - 1) / BLOCK};
    size_t n_blocks = (size_t)all.n_x * (size_t)all.n_y * (size_t)n_views;
    all.lowest = rf_alloc(context, n_blocks, sizeof *all.lowest);
    v->unseen = rf_calloc(context, n, sizeof *v->unseen);
    if (!v->unseen || !all.lowest) {
        rf_free(context, all.lowest);
        return rf_fail_memory(error, n, sizeof *v->unseen);
    }
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 4)
    for (int i = 0; i < n_views * all.n_y; i++)
        find_lowest(&all, i / all.n_y, i % all.n_y);
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 16)
    for (int i = 0; i < n_views * height; i++) {
        struct marker m = all;
        m.view = i / height;
        if (!rf_task_is_cancelled(v->work->task))
            rf_picture_visit_row(&v->pictures[m.view], i % height, mark_unseen, &m);
    }
    rf_free(context, all.lowest);
    rf_task_poll(v->work->task);
    return RF_OK;
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
        if (c->out.at && cell->own != ALL_VIEWS) {
            float continued;
            struct rf_view_place place =
                rf_view_place_of(cell->v, c->view, p.x, p.y, p.r);
            float shown = shown_by_others(cell->v, c->view, place, &continued);
            p.w *= rf_max_float(1 - shown, ESTIMATE_WEIGHT);
        }
        put(c, p, x, y);
    }
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
    struct collector c = {.cell = cell, .view = cell->own, .out = {at, 0}};
    if (block == v->work->n_views) {
        c.view = cell->middle;
        collect_hidden(&c, y);
    } else if (cell->own == ALL_VIEWS) {
        c.view = block;
        rf_picture_visit_row(&v->pictures[block], y, collect_shared, &c);
    } else if (block == 0)
        rf_picture_visit_row(&v->pictures[c.view], y, collect_own, &c);
    else {
        c.view = block <= cell->own ? block - 1 : block;
        const struct rf_picture *picture = &v->pictures[c.view];
        if (y >= picture->border && y < picture->height - picture->border)
            rf_picture_visit_row(&v->pictures[c.view], y, collect_other, &c);
    }
    return c.out.n;
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
    return rf_find_hidden(&cell->filter, &picture->surfaces, cell->hidden,
                          cell->hidden_weight, cell->v->work->task, error);
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
                             .x0 = picture->border,
                             .y0 = picture->border,
                             .n_phases = N_PHASES,
                             .occluders = &occluders,
                             .n_views = 1,
                             .task = work->task,
                             .progress_to = progress_to};
    int height = picture->height, n_views = work->n_views;
    int n_visible = (cell->own == ALL_VIEWS ? n_views : 1) * height;
    int n_others = (n_views + (cell->hidden ? 1 : 0)) * height - n_visible;
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = rf_collect_rows(&scene, n_visible, n_visible + n_others, collect_row,
                                 cell, &cell->samples, error);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = rf_composite_crop(&scene, work, error);
    return result;
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
                            work->n_planes, border, work->task, error);
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

static int middle_view(const struct rf_work *work)
{
    int best = 0;
    for (int j = 1; j < work->n_views; j++)
        if (hypotf(work->views[j].lens[0], work->views[j].lens[1]) <
            hypotf(work->views[best].lens[0], work->views[best].lens[1]))
            best = j;
    return best;
}

/* A cell is a sub-aperture itself and needs fewer of its own: two at the least. */
static int sub_apertures_of_cell(int whole, int n_views)
{
    return rf_max_int(rf_min_int(whole, 2), (2 * whole + n_views - 1) / n_views);
}

/*
 * Cuts the lens into cells; returns how many there are. One of all views where the lens
 * has been stopped down to the places of less than half of them: the few that are left
 * would waste the others' samples.
 */
static int make_cells(struct rf_views *v, struct cell *cells, double *area)
{
    const struct rf_work *work = v->work;
    double site[RF_MAX_VIEWS][2], sum = 0, squares = 0;
    int n = 0;
    for (int j = 0; j < work->n_views; j++)
        for (int k = 0; k < 2; k++)
            site[j][k] = work->views[j].lens[k];
    for (int j = 0; j < work->n_views; j++) {
        double centroid[2];
        cells[n] =
            (struct cell){.v = v, .own = j, .middle = j, .filter = *work->filter};
        area[n] = rf_shape_part(&work->filter->shape, site, work->n_views, j,
                                &cells[n].filter.shape, centroid);
        if (!(area[n] > 0))
            continue;
        int *sub_apertures = &cells[n].filter.params.sub_apertures;
        *sub_apertures = sub_apertures_of_cell(*sub_apertures, work->n_views);
        cells[n].centroid[0] = (float)centroid[0];
        cells[n].centroid[1] = (float)centroid[1];
        sum += area[n];
        squares += area[n] * area[n];
        n++;
    }
    if (n > 0 && 2 * sum * sum >= work->n_views * squares)
        return n;
    cells[0] = (struct cell){
        .v = v, .own = ALL_VIEWS, .middle = middle_view(work), .filter = *work->filter};
    area[0] = 1;
    return 1;
}

/* Adds the cells' pictures by area to `sum`; `total` receives the area of all. */
static rf_result add_cells(struct rf_views *v, float *sum, double *total,
                           struct rf_error *error)
{
    struct rf_work *work = v->work;
    const struct rf_context *context = work->filter->context;
    double area[RF_MAX_VIEWS], from = work->task->to;
    struct cell *cells = rf_alloc(context, (size_t)work->n_views, sizeof *cells);
    if (!cells)
        return rf_fail_memory(error, (size_t)work->n_views, sizeof *cells);
    int n = make_cells(v, cells, area);
    rf_result result = cells[0].own == ALL_VIEWS ? RF_OK : find_unseen(v, error);
    *total = 0;
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
        *total += area[i];
    }
    rf_free(context, cells);
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
                             .x0 = picture->border,
                             .y0 = picture->border,
                             .n_colours = n_colours,
                             .n_phases = N_PHASES,
                             .highlights = v->lights,
                             .occluders = v->occluders,
                             .n_views = v->work->n_views,
                             .task = v->work->task,
                             .progress_to = 1};
    float *planes[4];
    for (int p = 0; p < n_colours; p++)
        planes[p] =
            memory + (size_t)picture->width * (size_t)picture->height * (size_t)p;
    return rf_add_highlights(&scene, planes, error);
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
            const float *light =
                lights + n_padded * (size_t)p +
                (size_t)(y + picture->border) * (size_t)picture->width +
                (size_t)picture->border;
            float *out = work->colour[p] + (size_t)y * (size_t)width;
            for (int x = 0; x < width; x++)
                out[x] = from[x] / (float)total + light[x];
        }
}

static rf_result run(struct rf_views *v, struct rf_error *error)
{
    struct rf_work *work = v->work;
    const struct rf_filter *f = work->filter;
    int n_colours = work->n_planes == 4 ? 4 : 3;
    rf_result result = load(v, rf_picture_border(work->largest_radius), error);
    if (result == RF_OK && f->params.exact_highlights)
        result = rf_views_take_lights(v, error);
    if (result != RF_OK || rf_task_is_cancelled(work->task))
        return result;
    size_t n = (size_t)f->width * (size_t)f->height * (size_t)work->n_planes;
    size_t n_padded = (size_t)v->pictures[0].width * (size_t)v->pictures[0].height *
                      (size_t)n_colours;
    float *sum = rf_calloc(f->context, n, sizeof *sum);
    float *lights = rf_calloc(f->context, n_padded, sizeof *lights);
    double total = 0;
    result = sum && lights ? add_cells(v, sum, &total, error)
                           : rf_fail_memory(error, n + n_padded, sizeof *sum);
    for (int j = 0; j < work->n_views && result == RF_OK; j++)
        rf_picture_drop_pixels(&v->pictures[j]);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = add_lights(v, n_colours, lights, error);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        finish(v, sum, total, lights);
    rf_free(f->context, lights);
    rf_free(f->context, sum);
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
    for (size_t j = 0; j < n && v.pictures; j++)
        rf_picture_free(&v.pictures[j]);
    rf_free(context, v.unseen);
    rf_free(context, v.lights.at);
    rf_free(context, v.occluders);
    rf_free(context, v.pictures);
    return result;
}
