/* SPDX-License-Identifier: Apache-2.0 */
/*
 * views: several pinhole views from points of the lens, put through one layered pass.
 *
 * Every visible sample of every view j is moved to the view of the lens' centre,
 *
 *   x = X - u_j s(r),  y = Y + v_j s(r)
 *
 * - (u_j, v_j): where on the unit lens the view was taken, u right and v up
 * - r: the sample's signed radius for the lens and focus that are asked for
 * - s(r) = a r + b: the shift of a point of radius r between views, in px per unit of
 * the lens; s = r where the views were sheared to the plane in focus. Another focus or
 *   aperture than the views were rendered with changes a and b only, so the same views
 *   can be refocused, stopped down and opened up
 *
 * and weighted by how many views see its place,
 *
 *   w = share / max(1/4, n),  n = own + sum over the other views of how much of the
 *                                 place is not occluded there
 *
 * own is 1 for a near part, which looks past nothing, and its share for a far one.
 * Occluded at the nearest pixel: nearer by 0.8 px and pure, 0; nearer but mixed with a
 * far part at or behind r - 0.8, 1 - its share; else 1; outside the picture 0, and what
 * continues a picture beyond its border fills only what no view shows. Then all of them
 * are spread with the full aperture like those of one view (composite.c), highlights
 * with exact visibility, asking for each part of the lens the view nearest to it
 * (highlight.c). A light is the mean of the views that see it whole, and its depth one
 * at which the others show it too. Hidden background is real here; what no view saw
 * (less than 1 % with 8 views) is estimated from the view nearest to the middle, as
 * with one view.
 *
 * Ours. One view gives the method layered, bit for bit. Memory: 130 bytes per pixel and
 * view. Cost: the sum of the views' layered passes.
 */
#include "../picture.h"

enum { N_PHASES = 4, FREE_PX = 3 };

static const float OCCLUDED_PX = 0.8f;
static const float LEAST_COUNT = 0.25f;
static const float FREE_DEPTH_PX =
    1.6f;                      /* what is nearer by this much may be in front */
static const float LIT = 0.2f; /* of a light's luminance: the same light */

struct views {
    struct rf_work *work;
    struct rf_picture *pictures;
    struct rf_occluders *occluders;
    struct rf_samples highlights, visible, hidden;
    size_t *row_start; /* of the visible samples, per view and row */
};

static float shift_of(const struct rf_work_view *view, float r)
{
    return view->shift_scale * r + view->shift_bias;
}

/* A place of the centre's view. */
struct place {
    float x, y, r;
};

/* The pixel of view j that looks at a place; false outside of its padded picture. */
static bool pixel_at(const struct views *v, int j, struct place p, int *px, int *py)
{
    const struct rf_work_view *view = &v->work->views[j];
    const struct rf_surfaces *s = &v->pictures[j].surfaces;
    float shift = shift_of(view, p.r);
    *px = (int)floorf(p.x + view->lens[0] * shift);
    *py = (int)floorf(p.y - view->lens[1] * shift);
    return *px >= 0 && *py >= 0 && *px < s->width && *py < s->height;
}

/* Was the pixel rendered? The others continue the picture beyond its border. */
static bool is_rendered(const struct rf_picture *l, int x, int y)
{
    return x >= l->border && y >= l->border && x < l->width - l->border &&
           y < l->height - l->border;
}

/* How much of a place view j sees, and whether in what was rendered. */
static float seen_by(const struct views *v, int j, struct place p, bool *is_true)
{
    const struct rf_surfaces *s = &v->pictures[j].surfaces;
    int px, py;
    *is_true = false;
    if (!pixel_at(v, j, p, &px, &py))
        return 0;
    *is_true = is_rendered(&v->pictures[j], px, py);
    size_t i = (size_t)py * (size_t)s->width + (size_t)px;
    float limit = p.r - OCCLUDED_PX, share = s->share[i];
    if (share <= 0)
        return s->far[i].r < limit ? 0 : 1;
    if (s->near[i].r >= limit)
        return 1;
    return share < 1 && s->far[i].r >= limit ? 1 - share : 0;
}

/* Moves a sample of view j to the centre's view. */
static void move_sample(const struct views *v, int j, struct rf_sample *p)
{
    const struct rf_work_view *view = &v->work->views[j];
    float shift = shift_of(view, p->r);
    p->x -= view->lens[0] * shift;
    p->y += view->lens[1] * shift;
}

/*
 * The weight of a moved sample of view j. A near part counts its own pixel whole, since
 * its share is how much of the pixel it covers; a far part counts what the near one
 * leaves to be seen. What continues the picture beyond its border counts where no view
 * shows the place.
 */
static float weight_of(const struct views *v, int j, const struct rf_sample *p,
                       bool is_far, bool is_rendered)
{
    struct place place = {p->x, p->y, p->r};
    float own = is_far ? p->w : 1, shown = 0, all = 0;
    for (int k = 0; k < v->work->n_views; k++) {
        bool is_true;
        if (k == j)
            continue;
        float seen = seen_by(v, k, place, &is_true);
        all += seen;
        shown += is_true ? seen : 0;
    }
    if (is_rendered)
        return p->w / rf_max_float(own + shown, LEAST_COUNT);
    return p->w * rf_max_float(1 - shown, 1e-6f) /
           rf_max_float(own + all - shown, LEAST_COUNT);
}

/* ---- visible samples ----------------------------------------------------------- */

struct collector {
    struct views *v;
    int view;
    struct rf_samples out;
};

static void collect(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct collector *c = user;
    const struct rf_picture *picture = &c->v->pictures[c->view];
    struct rf_sample p = rf_sample_make(s, x, y, w);
    move_sample(c->v, c->view, &p);
    if (!(p.x >= 0 && p.y >= 0 && p.x < (float)picture->width &&
          p.y < (float)picture->height))
        return;
    size_t i = (size_t)y * (size_t)picture->width + (size_t)x;
    if (c->out.at)
        p.w = weight_of(c->v, c->view, &p, s != &picture->surfaces.near[i],
                        is_rendered(picture, x, y));
    rf_picture_emit(picture, p, x, y, &c->out);
}

static rf_result collect_visible(struct views *v, struct rf_error *error)
{
    const struct rf_context *context = v->work->filter->context;
    int height = v->pictures[0].height, n_views = v->work->n_views;
    size_t n_rows = (size_t)height * (size_t)n_views;
    v->row_start = rf_alloc(context, n_rows + 1, sizeof *v->row_start);
    if (!v->row_start)
        return rf_fail_memory(error, n_rows + 1, sizeof *v->row_start);
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 16)
    for (int64_t i = 0; i < (int64_t)n_rows; i++) {
        struct collector c = {.v = v, .view = (int)(i / height)};
        rf_picture_visit_row(&v->pictures[c.view], (int)(i % height), collect, &c);
        v->row_start[i + 1] = c.out.n;
    }
    v->row_start[0] = 0;
    for (size_t i = 0; i < n_rows; i++)
        v->row_start[i + 1] += v->row_start[i];
    v->visible.n = v->row_start[n_rows];
    v->visible.at = rf_alloc(context, v->visible.n, sizeof *v->visible.at);
    if (!v->visible.at)
        return rf_fail_memory(error, v->visible.n, sizeof *v->visible.at);
    rf_task_phase(v->work->task, 0.5, (int64_t)n_rows);
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 16)
    for (int64_t i = 0; i < (int64_t)n_rows; i++) {
        if (rf_task_is_cancelled(v->work->task))
            continue;
        struct collector c = {.v = v,
                              .view = (int)(i / height),
                              .out = {v->visible.at + v->row_start[i], 0}};
        rf_picture_visit_row(&v->pictures[c.view], (int)(i % height), collect, &c);
        rf_task_step(v->work->task);
    }
    return RF_OK;
}

/* ---- highlights ---------------------------------------------------------------- */

/*
 * Is the place free in view k: rendered, with nothing nearer in 7 x 7 pixels? Shares at
 * the edge of a light are no measure of how much of it is seen.
 */
static bool is_free(const struct views *v, int k, struct place p)
{
    const struct rf_picture *l = &v->pictures[k];
    const struct rf_surfaces *s = &l->surfaces;
    int px, py;
    if (!pixel_at(v, k, p, &px, &py))
        return false;
    for (int y = py - FREE_PX; y <= py + FREE_PX; y++)
        for (int x = px - FREE_PX; x <= px + FREE_PX; x++) {
            if (!is_rendered(l, x, y))
                return false;
            size_t i = (size_t)y * (size_t)s->width + (size_t)x;
            if (s->share[i] > 0.02f && s->near[i].r < p.r - FREE_DEPTH_PX)
                return false;
        }
    return true;
}

/* Does view k show a light like this near the place? */
static bool shows_light(const struct views *v, int k, struct place p, float luminance)
{
    const struct rf_picture *l = &v->pictures[k];
    int px, py;
    if (!pixel_at(v, k, p, &px, &py))
        return false;
    for (int y = rf_max_int(py - 1, 0); y <= rf_min_int(py + 1, l->height - 1); y++)
        for (int x = rf_max_int(px - 1, 0); x <= rf_min_int(px + 1, l->width - 1);
             x++) {
            const struct rf_surface *q =
                &l->pixels.at[(size_t)y * (size_t)l->width + (size_t)x];
            if (rf_luminance(q->c[0], q->c[1], q->c[2]) > luminance)
                return true;
        }
    return false;
}

/* Of the other views to which the place is free, how many show the light? */
struct support {
    int n_free, n_lit;
};

static struct support support_of(const struct views *v, int j, struct place p,
                                 float luminance)
{
    struct support s = {0, 0};
    for (int k = 0; k < v->work->n_views; k++) {
        if (k == j || !is_free(v, k, p))
            continue;
        s.n_free++;
        s.n_lit += shows_light(v, k, p, luminance);
    }
    return s;
}

static struct place move_place(const struct views *v, int j, float x, float y, float r)
{
    struct rf_sample p = {.x = x, .y = y, .r = r};
    move_sample(v, j, &p);
    return (struct place){p.x, p.y, p.r};
}

/* A search for the depth of a light, and the best so far. */
struct depth_search {
    const struct views *v;
    int view;
    float x, y; /* px of the view */
    float luminance;
    float r, lit_share; /* of the views to which it is free */
};

static bool is_settled(const struct depth_search *d)
{
    return d->lit_share >= 0.5f;
}

/* Takes the depth of what another pixel shows where more views agree on it. */
static void try_depth(struct depth_search *d, const struct rf_surface *q)
{
    if (rf_luminance(q->c[0], q->c[1], q->c[2]) < d->luminance ||
        fabsf(q->r - d->r) < OCCLUDED_PX)
        return;
    struct place place = move_place(d->v, d->view, d->x, d->y, q->r);
    struct support s = support_of(d->v, d->view, place, d->luminance);
    if (2 * s.n_lit >= s.n_free && (float)s.n_lit > d->lit_share * (float)s.n_free) {
        d->lit_share = (float)s.n_lit / (float)s.n_free;
        d->r = q->r;
    }
}

/* The depths of the lights around it in its own view. */
static void try_neighbours(struct depth_search *d)
{
    const struct rf_picture *l = &d->v->pictures[d->view];
    int cx = (int)d->x, cy = (int)d->y;
    for (int y = rf_max_int(cy - 2, 0); y <= rf_min_int(cy + 2, l->height - 1); y++)
        for (int x = rf_max_int(cx - 2, 0); x <= rf_min_int(cx + 2, l->width - 1); x++)
            try_depth(d, &l->pixels.at[(size_t)y * (size_t)l->width + (size_t)x]);
}

/* The lights that view k shows on the line on which this one must lie there. */
static void try_line(struct depth_search *d, int k)
{
    const struct rf_work_view *own = &d->v->work->views[d->view],
                              *other = &d->v->work->views[k];
    const struct rf_picture *l = &d->v->pictures[k];
    float pace = rf_max_float(fabsf(other->lens[0] - own->lens[0]),
                              fabsf(other->lens[1] - own->lens[1])) *
                 fabsf(own->shift_scale);
    float most = d->v->work->largest_radius;
    int n = rf_min_int((int)ceilf(most * pace), l->width + l->height);
    for (int i = -n; i <= n && !is_settled(d); i++) {
        float r = most * (float)i / (float)rf_max_int(n, 1);
        int px, py;
        if (!pixel_at(d->v, k, move_place(d->v, d->view, d->x, d->y, r), &px, &py))
            continue;
        const struct rf_surface *q =
            &l->pixels.at[(size_t)py * (size_t)l->width + (size_t)px];
        if (fabsf(q->r - r) <= rf_max_float(most / (float)rf_max_int(n, 1), 1))
            try_depth(d, q);
    }
}

/*
 * The depth of a pixel that a light only touches may be that of its neighbour. Where
 * the other views do not show the light at its place, the depths of the lights around
 * it are tried, then those that the other views show where it could be.
 */
static void find_depth(const struct views *v, int j, struct rf_sample *p)
{
    float luminance = LIT * rf_luminance(p->c[0], p->c[1], p->c[2]);
    struct support own =
        support_of(v, j, move_place(v, j, p->x, p->y, p->r), luminance);
    if (own.n_free == 0 || 2 * own.n_lit >= own.n_free)
        return;
    struct depth_search d = {.v = v,
                             .view = j,
                             .x = p->x,
                             .y = p->y,
                             .luminance = luminance,
                             .r = p->r,
                             .lit_share = (float)own.n_lit / (float)own.n_free};
    try_neighbours(&d);
    for (int k = 0; k < v->work->n_views && !is_settled(&d); k++)
        if (k != j)
            try_line(&d, k);
    p->r = d.r;
}

/*
 * The weight of a moved light: the mean over the views to which its place is free, else
 * as for other samples.
 */
static float light_weight(const struct views *v, int j, const struct rf_sample *p,
                          bool is_rendered)
{
    struct place place = {p->x, p->y, p->r};
    int n_free = 0;
    for (int k = 0; k < v->work->n_views; k++)
        n_free += is_free(v, k, place);
    if (n_free > 0)
        return is_free(v, j, place) ? p->w / (float)n_free : 0;
    return weight_of(v, j, p, true, is_rendered);
}

static rf_result collect_highlights(struct views *v, struct rf_error *error)
{
    const struct rf_context *context = v->work->filter->context;
    size_t n = 0;
    for (int j = 0; j < v->work->n_views; j++) {
        rf_result result = rf_picture_take_highlights(
            &v->pictures[j], &v->work->views[j], v->work->n_planes, error);
        if (result != RF_OK)
            return result;
        n += v->pictures[j].highlights.n;
    }
    v->highlights.at = rf_alloc(context, n, sizeof *v->highlights.at);
    if (!v->highlights.at)
        return rf_fail_memory(error, n, sizeof *v->highlights.at);
    for (int j = 0; j < v->work->n_views; j++) {
        const struct rf_samples *lights = &v->pictures[j].highlights;
        for (size_t i = 0; i < lights->n; i++) {
            struct rf_sample p = lights->at[i];
            bool is_true = is_rendered(&v->pictures[j], (int)p.x, (int)p.y);
            find_depth(v, j, &p);
            move_sample(v, j, &p);
            p.w = light_weight(v, j, &p, is_true);
            if (p.w > 0)
                v->highlights.at[v->highlights.n++] = p;
        }
    }
    return RF_OK;
}

/* ---- hidden samples ------------------------------------------------------------ */

static int middle_view(const struct rf_work *work)
{
    int best = 0;
    for (int j = 1; j < work->n_views; j++)
        if (hypotf(work->views[j].lens[0], work->views[j].lens[1]) <
            hypotf(work->views[best].lens[0], work->views[best].lens[1]))
            best = j;
    return best;
}

static rf_result collect_hidden(struct views *v, struct rf_error *error)
{
    const struct rf_filter *f = v->work->filter;
    int j = middle_view(v->work);
    const struct rf_picture *picture = &v->pictures[j];
    size_t n = (size_t)picture->width * (size_t)picture->height;
    struct rf_surface *hidden = rf_alloc(f->context, n, sizeof *hidden);
    float *weight = rf_alloc(f->context, n, sizeof *weight);
    v->hidden.at = rf_alloc(f->context, n, sizeof *v->hidden.at);
    rf_result result = hidden && weight && v->hidden.at
                           ? RF_OK
                           : rf_fail_memory(error, n, sizeof *v->hidden.at);
    rf_task_phase(v->work->task, 0.6, rf_hidden_steps(picture->height));
    if (result == RF_OK)
        result =
            rf_find_hidden(f, &picture->surfaces, hidden, weight, v->work->task, error);
    for (size_t i = 0; i < n && result == RF_OK; i++) {
        if (!(weight[i] > 0))
            continue;
        struct rf_sample p =
            rf_sample_make(&hidden[i], (int)(i % (size_t)picture->width),
                           (int)(i / (size_t)picture->width), weight[i]);
        move_sample(v, j, &p);
        v->hidden.at[v->hidden.n++] = p;
    }
    rf_free(f->context, weight);
    rf_free(f->context, hidden);
    return result;
}

/* ---- all ----------------------------------------------------------------------- */

static rf_result load(struct views *v, int border, struct rf_error *error)
{
    struct rf_work *work = v->work;
    for (int j = 0; j < work->n_views; j++) {
        rf_task_phase(work->task, 0.3 * (j + 1) / work->n_views,
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

static rf_result run(struct views *v, struct rf_error *error)
{
    struct rf_work *work = v->work;
    const struct rf_params *params = &work->filter->params;
    int border = rf_picture_border(work->largest_radius);
    rf_result result = load(v, border, error);
    if (result == RF_OK && params->exact_highlights)
        result = collect_highlights(v, error);
    if (result == RF_OK)
        result = collect_visible(v, error);
    for (int j = 0; j < work->n_views && result == RF_OK; j++)
        rf_picture_drop_pixels(&v->pictures[j]);
    if (result == RF_OK && params->fill_hidden)
        result = collect_hidden(v, error);
    if (result != RF_OK || rf_task_is_cancelled(work->task))
        return result;
    struct rf_scene scene = {.filter = work->filter,
                             .width = v->pictures[0].width,
                             .height = v->pictures[0].height,
                             .x0 = border,
                             .y0 = border,
                             .n_phases = N_PHASES,
                             .visible = v->visible,
                             .hidden = v->hidden,
                             .highlights = v->highlights,
                             .occluders = v->occluders,
                             .n_views = work->n_views,
                             .task = work->task,
                             .progress_to = 1};
    return rf_composite_crop(&scene, work, error);
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
    struct views v = {.work = work,
                      .pictures = rf_calloc(context, n, sizeof *v.pictures),
                      .occluders = rf_calloc(context, n, sizeof *v.occluders)};
    rf_result result = v.pictures && v.occluders
                           ? run(&v, error)
                           : rf_fail_memory(error, n, sizeof *v.pictures);
    for (size_t j = 0; j < n && v.pictures; j++)
        rf_picture_free(&v.pictures[j]);
    rf_free(context, v.hidden.at);
    rf_free(context, v.visible.at);
    rf_free(context, v.row_start);
    rf_free(context, v.highlights.at);
    rf_free(context, v.occluders);
    rf_free(context, v.pictures);
    return result;
}
