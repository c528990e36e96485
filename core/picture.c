/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A view becomes surfaces: the picture is continued by its edge pixels, bright ones
 * dimmed to white (recipe step 0); mixed pixels are split (split.c); the light of
 * highlights is taken out, to be spread with exact visibility (highlight.c).
 */
#include "kernels/kernels.h"
#include "picture.h"

static const float BORDER_LUMINANCE = 1;
static const float BRIGHT = 4;   /* times the darkest pixel of 5 x 5, in focus */
static const float MOST_R2 = 64; /* px^2, from which it is no more */

enum { MAX_BORDER = 256 };

/*
 * What is brighter than this times its surroundings is spread without the cubic's
 * negative weights. The darkest pixel of 5 x 5 changes fast where an edge passes, and
 * with it what is spread so: a pan flickers. So the limit grows as the negative weights
 * lose their strength: beside a step they leave 0.074 of it below zero at r = 0, 0.022
 * at 1 px, 0.0085 at 2 px, 0.0011 at 8 px. Lamps, far above it, keep the limit that
 * things in focus have: no ring shows around them.
 */
static inline float bright_limit(float r)
{
    float r2 = r * r;
    return BRIGHT + BRIGHT * (r2 < MOST_R2 ? r2 : MOST_R2);
}

static size_t padded_size(const struct rf_picture *l)
{
    return (size_t)l->width * (size_t)l->height;
}

/* ---- border -------------------------------------------------------------------- */

/* Repeats the ends of a plane's row in its margins. */
static void fill_margins(const struct rf_pixels *p, float *row)
{
    for (int x = -RF_ROW_MARGIN; x < 0; x++)
        row[x] = row[0];
    for (size_t x = (size_t)p->width; x < p->stride - RF_ROW_MARGIN; x++)
        row[x] = row[p->width - 1];
}

/* Dims what continues the picture to white; returns its luminance. */
static float dim(struct rf_surface *s, float luminance)
{
    if (!(luminance > BORDER_LUMINANCE))
        return luminance;
    for (int n = 0; n < 3; n++)
        s->c[n] *= BORDER_LUMINANCE / luminance;
    return rf_luminance(s->c[0], s->c[1], s->c[2]);
}

/* Continues a row by pixel `edge`, if that is not dimmed yet, from x0 to x1 - 1. */
static void continue_row(struct rf_surface *at, float *luminance, float *radius,
                         int edge, bool is_dimmed, int x0, int x1)
{
    struct rf_surface s = at[edge];
    float dimmed = is_dimmed ? luminance[edge] : dim(&s, luminance[edge]);
    for (int x = x0; x < x1; x++) {
        at[x] = s;
        luminance[x] = dimmed;
        radius[x] = s.r;
    }
}

/* What is found in rows of a view. */
struct row_kind {
    bool has_alpha;
    bool is_refused; /* an image that is not finite, or film without depth */
};

/* The alphas of a row of plain pixels. */
static void copy_alphas(const float *rgba, int n, float *alpha)
{
    for (int x = 0; x < n; x++)
        alpha[x] = rgba[4 * x + 3];
}

/* The surfaces of row y of a view; `own` has room for a row. */
static struct row_kind fetch_row(const struct rf_filter *f,
                                 const struct rf_work_view *view, int n_planes, int y,
                                 float *own, struct rf_surface *at, float *luminance)
{
    const struct rf_kernels *kernels = f->context->kernels;
    size_t row = (size_t)y * (size_t)f->width;
    const float *radius = view->radius + row, *planes[4] = {NULL};
    if (!view->image) {
        for (int n = 0; n < 3; n++)
            planes[n] = view->colour[n_planes == 1 ? 0 : n] + row;
        planes[3] = n_planes == 4 ? view->colour[3] + row : NULL;
        return (struct row_kind){
            .has_alpha = kernels->load_row(planes, radius, f->width, at, luminance)};
    }
    const float *rgba = rf_image_at(view->image, 0, y, 0);
    unsigned found = kernels->load_rgba(rgba, radius, f->width, at, luminance);
    struct row_kind kind = {.has_alpha = found & RF_ROW_FILM,
                            .is_refused = found & RF_ROW_INFINITE};
    if (kind.has_alpha && !kind.is_refused) {
        copy_alphas(rgba, f->width, own);
        kind.is_refused = rf_film_is_missing(f, own, radius, f->width);
    }
    return kind;
}

static struct row_kind load_row(const struct rf_picture *l,
                                const struct rf_work_view *view, int n_planes, int y,
                                float *own)
{
    const struct rf_filter *f = l->filter;
    const struct rf_pixels *p = &l->pixels;
    int sy = y - l->y0, cy = rf_min_int(rf_max_int(sy, 0), f->height - 1);
    int x0 = l->x0, x1 = x0 + f->width;
    size_t row = (size_t)cy * (size_t)f->width;
    struct rf_surface *at = p->at + (size_t)y * (size_t)l->width;
    float *luminance = rf_plane_row(p, p->luminance, y);
    float *radius = rf_plane_row(p, p->radius, y);
    struct row_kind kind =
        fetch_row(f, view, n_planes, cy, own, at + x0, luminance + x0);
    memcpy(radius + x0, view->radius + row, (size_t)f->width * sizeof *radius);
    for (int x = x0; x < x1 && cy != sy; x++)
        luminance[x] = dim(&at[x], luminance[x]);
    continue_row(at, luminance, radius, x0, cy != sy, 0, x0);
    continue_row(at, luminance, radius, x1 - 1, cy != sy, x1, l->width);
    fill_margins(p, luminance);
    fill_margins(p, radius);
    return kind;
}

/* The rows that a row of areas looks at, and with the first and the last the border. */
static void rows_of_areas(const struct rf_picture *l, int row, int *y0, int *y1)
{
    rf_areas_rows(&l->areas, row, y0, y1);
    *y0 = row == 0 ? 0 : *y0 + l->y0;
    *y1 = row == l->areas.n_y - 1 ? l->height : *y1 + l->y0;
}

/* Loads the pixels and measures their areas. */
static rf_result load_pixels(struct rf_picture *l, const struct rf_work_view *view,
                             int n_planes, struct rf_error *error)
{
    const struct rf_context *context = l->filter->context;
    const struct rf_pixels *p = &l->pixels;
    const float *luminance = rf_plane_row(p, p->luminance, l->y0) + l->x0;
    size_t n_own = (size_t)l->filter->width;
    float *own = rf_alloc(context, n_own * (size_t)context->n_threads, sizeof *own);
    if (!own)
        return rf_fail_memory(error, n_own, sizeof *own);
    bool has_alpha = false, is_refused = false;
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 1)          \
    reduction(|| : has_alpha, is_refused)
    for (int row = 0; row < l->areas.n_y; row++) {
        int y0, y1;
        rows_of_areas(l, row, &y0, &y1);
        for (int y = y0; y < y1; y++) {
            struct row_kind kind = load_row(l, view, n_planes, y,
                                            own + n_own * (size_t)rf_thread_num());
            has_alpha = has_alpha || kind.has_alpha;
            is_refused = is_refused || kind.is_refused;
        }
        rf_areas_measure_row(&l->areas, context->kernels, luminance, p->stride, row);
    }
    l->has_alpha = has_alpha;
    l->is_refused = is_refused;
    rf_free(context, own);
    return RF_OK;
}

/*
 * Luminance with the premultiplication undone; what is transparent has no colour that
 * others could stand out from.
 */
static void undo_alpha_row(const struct rf_picture *l, int y, float *out)
{
    const struct rf_surface *s = l->pixels.at + (size_t)y * (size_t)l->width;
    const float *luminance = rf_plane_row(&l->pixels, l->pixels.luminance, y);
    for (int x = 0; x < l->width; x++)
        out[x] = s[x].c[3] == 1  ? luminance[x]
                 : s[x].c[3] > 0 ? luminance[x] / s[x].c[3]
                                 : INFINITY;
    fill_margins(&l->pixels, out);
}

static rf_result find_darkest(struct rf_picture *l, struct rf_error *error)
{
    const struct rf_context *context = l->filter->context;
    const struct rf_pixels *p = &l->pixels;
    size_t n = p->stride * (size_t)l->height;
    size_t n_scratch = p->stride * (size_t)context->n_threads;
    float *shade = l->has_alpha ? rf_alloc(context, n, sizeof *shade) : p->luminance;
    float *scratch = rf_alloc(context, n_scratch, sizeof *scratch);
    rf_result result =
        shade && scratch ? RF_OK : rf_fail_memory(error, n + n_scratch, sizeof *shade);
    if (result == RF_OK) {
#pragma omp parallel num_threads(context->n_threads)
        {
            if (l->has_alpha) {
#pragma omp for schedule(static)
                for (int y = 0; y < l->height; y++)
                    undo_alpha_row(l, y, rf_plane_row(p, shade, y));
            }
#pragma omp for schedule(static)
            for (int y = 0; y < l->height; y++) {
                const float *rows[5];
                rf_plane_rows(p, shade, y, 2, rows);
                context->kernels->extremes(
                    rows, 5, 2, l->width, scratch + p->stride * (size_t)rf_thread_num(),
                    rf_plane_row(p, l->darkest, y), NULL);
            }
        }
    }
    rf_free(context, scratch);
    if (l->has_alpha)
        rf_free(context, shade);
    return result;
}

/* ---- highlights ---------------------------------------------------------------- */

static float usual_luminance(const struct rf_picture *l, int x, int y)
{
    return rf_usual_luminance(&l->areas, x - l->x0, y - l->y0);
}

static bool is_highlight(const struct rf_picture *l, const struct rf_surface *s, int x,
                         int y, float factor)
{
    float luminance = rf_luminance(s->c[0], s->c[1], s->c[2]);
    return rf_is_highlight(luminance, s->r, factor, 0) &&
           rf_is_highlight(luminance, s->r, factor, usual_luminance(l, x, y));
}

struct rf_sample rf_sample_make(const struct rf_surface *s, int x, int y, float w)
{
    struct rf_sample p = {
        .x = (float)x + 0.5f, .y = (float)y + 0.5f, .r = s->r, .w = w};
    memcpy(p.c, s->c, sizeof p.c);
    return p;
}

/*
 * Moves all but the fraction `keep` of a colour into `light`. Coverage stays with the
 * surface.
 */
static void take_light(float surface[4], float light[4], float keep)
{
    light[3] = 0;
    for (int n = 0; n < 3; n++) {
        light[n] = surface[n] * (1 - keep);
        surface[n] -= light[n];
    }
}

void rf_picture_visit_row(struct rf_picture *l, int y, rf_visit_fn visit, void *user)
{
    struct rf_surfaces *s = &l->surfaces;
    for (int x = 0; x < l->width; x++) {
        size_t i = (size_t)y * (size_t)l->width + (size_t)x;
        if (s->share[i] > 0)
            visit(user, &s->near[i], x, y, s->share[i]);
        if (s->share[i] < 1)
            visit(user, rf_far_at(s, i), x, y, 1 - s->share[i]);
    }
}

struct lights {
    struct rf_picture *l;
    float factor;
    struct rf_samples out; /* at NULL: only count */
};

static void collect_light(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct lights *lights = user;
    if (!is_highlight(lights->l, s, x, y, lights->factor))
        return;
    if (lights->out.at) {
        struct rf_sample *light = &lights->out.at[lights->out.n];
        *light = rf_sample_make(s, x, y, w);
        take_light(s->c, light->c,
                   usual_luminance(lights->l, x, y) /
                       rf_luminance(s->c[0], s->c[1], s->c[2]));
    }
    lights->out.n++;
}

/* May a row hold a highlight, as far as its brightest surface tells? */
static bool is_bright_row(const struct rf_picture *l, int y, float factor)
{
    return rf_is_highlight(l->surfaces.peak[y], INFINITY, factor, 0);
}

/* The rows of the picture that may hold highlights, without its border. */
static struct rf_window bright_rows(const struct rf_picture *l)
{
    int y0 = 0, y1 = l->filter->height;
    while (y0 < y1 && !is_bright_row(l, y0 + l->y0, 1))
        y0++;
    while (y0 < y1 && !is_bright_row(l, y1 - 1 + l->y0, 1))
        y1--;
    return (struct rf_window){0, y0, l->filter->width, y1 - y0};
}

/* Moves the light of the highlights into `l->highlights`, in the order of rows. */
static rf_result collect_lights(struct rf_picture *l, float factor, size_t *start,
                                struct rf_error *error)
{
    const struct rf_context *context = l->filter->context;
    start[0] = 0;
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 16)
    for (int y = 0; y < l->height; y++) {
        struct lights lights = {.l = l, .factor = factor};
        if (is_bright_row(l, y, factor))
            rf_picture_visit_row(l, y, collect_light, &lights);
        start[y + 1] = lights.out.n;
    }
    for (int y = 0; y < l->height; y++)
        start[y + 1] += start[y];
    size_t n = start[l->height];
    l->highlights.at = rf_alloc(context, n, sizeof *l->highlights.at);
    if (!l->highlights.at)
        return rf_fail_memory(error, n, sizeof *l->highlights.at);
    l->highlights.n = n;
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 16)
    for (int y = 0; y < l->height; y++) {
        struct lights lights = {
            .l = l, .factor = factor, .out = {l->highlights.at + start[y], 0}};
        if (start[y + 1] > start[y])
            rf_picture_visit_row(l, y, collect_light, &lights);
    }
    return RF_OK;
}

rf_result rf_picture_take_highlights(struct rf_picture *l,
                                     const struct rf_work_view *view, int n_planes,
                                     struct rf_error *error)
{
    const struct rf_filter *f = l->filter;
    size_t n_rows = (size_t)l->height;
    size_t *start = rf_alloc(f->context, n_rows + 1, sizeof *start);
    if (!start)
        return rf_fail_memory(error, n_rows + 1, sizeof *start);
    struct rf_survey survey = {.n_pixels = 0};
    if (!view->survey) {
        struct rf_window window = bright_rows(l);
        rf_survey_add(&survey, f, view, n_planes, &l->areas, &window);
        survey.n_pixels = (double)f->width * f->height;
    }
    float factor = rf_survey_factor(view->survey ? view->survey : &survey);
    rf_result result = collect_lights(l, factor, start, error);
    rf_free(f->context, start);
    return result;
}

/* ---- samples ------------------------------------------------------------------- */

static void put_sample(struct rf_samples *out, const struct rf_sample *s)
{
    if (out->at)
        out->at[out->n] = *s;
    out->n++;
}

/* Luminance that a pixel of that alpha has where it is as dark as its surroundings. */
static float shade_at(const struct rf_picture *l, float alpha, int x, int y)
{
    float darkest = rf_max_float(rf_plane_row(&l->pixels, l->darkest, y)[x], 0);
    return rf_max_float(alpha, 0) * darkest;
}

void rf_picture_emit(const struct rf_picture *l, struct rf_sample p, int x, int y,
                     struct rf_samples *out)
{
    float lum = rf_luminance(p.c[0], p.c[1], p.c[2]);
    float shade = shade_at(l, p.c[3], x, y);
    float bright = bright_limit(p.r) * shade;
    if (lum > bright) {
        float limit = rf_max_float(4 * bright - 3 * lum, BRIGHT * shade);
        struct rf_sample light = p;
        light.kind = RF_POSITIVE;
        take_light(p.c, light.c, limit / lum);
        put_sample(out, &light);
    }
    put_sample(out, &p);
}

void rf_picture_emit_pixel(const struct rf_picture *l, int x, int y,
                           struct rf_samples *out)
{
    const struct rf_surfaces *s = &l->surfaces;
    size_t i = (size_t)y * (size_t)l->width + (size_t)x;
    float share = s->share[i];
    if (share > 0)
        rf_picture_emit(l, rf_sample_make(&s->near[i], x, y, share), x, y, out);
    if (share < 1)
        rf_picture_emit(l, rf_sample_make(rf_far_at(s, i), x, y, 1 - share), x, y, out);
}

static inline bool is_bright(const struct rf_surface *p, float darkest)
{
    float shade = rf_max_float(p->c[3], 0) * rf_max_float(darkest, 0);
    return rf_luminance(p->c[0], p->c[1], p->c[2]) > bright_limit(p->r) * shade;
}

bool rf_picture_is_bright(const struct rf_picture *l, const struct rf_surface *p, int x,
                          int y)
{
    return is_bright(p, rf_plane_row(&l->pixels, l->darkest, y)[x]);
}

/* Are there two samples of a pixel that is not opaque? */
static bool is_bright_film(const struct rf_picture *l, int x, int y)
{
    const struct rf_surface *s =
        l->surfaces.near + (size_t)y * (size_t)l->width + (size_t)x;
    return s->c[3] != 1 && rf_luminance(s->c[0], s->c[1], s->c[2]) >
                               bright_limit(s->r) * shade_at(l, s->c[3], x, y);
}

static size_t words_of_row(const struct rf_picture *l)
{
    return ((size_t)l->width + 63) / 64;
}

/* Notes which pixels of a row are mixed or bright, while all about them is at hand. */
static void note_others(void *user, int y)
{
    const struct rf_picture *l = user;
    const float *share = l->surfaces.share + (size_t)y * (size_t)l->width;
    const float *luminance = rf_plane_row(&l->pixels, l->pixels.luminance, y);
    const float *radius = rf_plane_row(&l->pixels, l->pixels.radius, y);
    const float *darkest = rf_plane_row(&l->pixels, l->darkest, y);
    uint64_t *others = l->others + words_of_row(l) * (size_t)y;
    for (int x = 0; x < l->width; x += 64)
        others[x / 64] = l->filter->context->kernels->find_others(
            share + x, luminance + x, radius + x, darkest + x, BRIGHT, MOST_R2,
            rf_min_int(l->width - x, 64));
}

struct rf_emission rf_picture_survey(const struct rf_picture *l, int x, int y, int n)
{
    uint64_t all = UINT64_MAX >> (64 - n);
    /* Highlights may be darker by now: then they are found not to be bright. */
    const uint64_t *at = l->others + words_of_row(l) * (size_t)y + (size_t)x / 64;
    int first = x % 64;
    uint64_t other = at[0] >> first;
    if (first + n > 64)
        other |= at[1] << (64 - first);
    other &= all;
    for (int i = 0; i < n && l->has_alpha; i++)
        other |= (uint64_t)is_bright_film(l, x + i, y) << i;
    return (struct rf_emission){all & ~other, other};
}

/* ---- all ----------------------------------------------------------------------- */

static rf_result allocate(struct rf_picture *l, bool keeps_pixels,
                          struct rf_error *error)
{
    const struct rf_context *context = l->filter->context;
    size_t n = padded_size(l);
    size_t stride =
        ((size_t)l->width + RF_ROW_MARGIN - 1) / RF_ROW_MARGIN * RF_ROW_MARGIN +
        2 * RF_ROW_MARGIN;
    size_t n_plane = stride * (size_t)l->height;
    l->pixels = (struct rf_pixels){
        .width = l->width,
        .height = l->height,
        .at = rf_alloc(context, n, sizeof *l->pixels.at),
        .stride = stride,
        .luminance = rf_alloc(context, n_plane, sizeof(float)),
        .radius = rf_alloc(context, n_plane, sizeof(float)),
    };
    l->darkest = rf_alloc(context, n_plane, sizeof *l->darkest);
    l->others =
        rf_alloc(context, words_of_row(l) * (size_t)l->height, sizeof *l->others);
    const struct rf_place *place = &l->filter->place;
    l->surfaces = (struct rf_surfaces){
        .width = l->width,
        .height = l->height,
        .x = place->x + l->border - l->x0,
        .y = place->y + l->border - l->y0,
        .near = keeps_pixels ? rf_alloc(context, n, sizeof *l->surfaces.near) : NULL,
        .share = rf_alloc(context, n, sizeof *l->surfaces.share),
        .peak = rf_alloc(context, (size_t)l->height, sizeof *l->surfaces.peak),
    };
    bool is_complete = l->pixels.at && l->pixels.luminance && l->pixels.radius &&
                       l->darkest && l->others && (l->surfaces.near || !keeps_pixels) &&
                       l->surfaces.share && l->surfaces.peak;
    return is_complete ? RF_OK : rf_fail_memory(error, n * 3, sizeof *l->pixels.at);
}

int rf_picture_border(float largest_radius)
{
    return rf_min_int((int)ceilf(largest_radius), MAX_BORDER);
}

rf_result rf_picture_load(struct rf_picture *l, const struct rf_filter *filter,
                          const struct rf_work_view *view, int n_planes, int border,
                          bool keeps_pixels, struct rf_task *task,
                          struct rf_error *error)
{
    const struct rf_place *at = &filter->place;
    int x1 = at->x + filter->width, y1 = at->y + filter->height;
    *l = (struct rf_picture){
        .filter = filter,
        .border = border,
        .x0 = at->x == 0 ? border : 0,
        .y0 = at->y == 0 ? border : 0,
    };
    l->width = l->x0 + filter->width + (x1 == at->whole_width ? border : 0);
    l->height = l->y0 + filter->height + (y1 == at->whole_height ? border : 0);
    rf_result result = allocate(l, keeps_pixels, error);
    if (result != RF_OK)
        return result;
    result = rf_areas_begin(&l->areas, filter, error);
    if (result == RF_OK)
        result = load_pixels(l, view, n_planes, error);
    if (result != RF_OK || l->is_refused)
        return result;
    rf_task_poll(task);
    /* Of opaque pixels splitting looks for the same. */
    struct rf_split how = {
        .darkest = filter->params.split_edges && !l->has_alpha ? l->darkest : NULL,
        .end_row = note_others,
        .user = l};
    if (!how.darkest)
        result = find_darkest(l, error);
    rf_task_poll(task);
    if (result == RF_OK && filter->params.split_edges)
        result =
            rf_split_edges(filter, &l->pixels, &l->surfaces, &how, task, error);
    else if (result == RF_OK)
        result = rf_split_nothing(filter, &l->pixels, &l->surfaces, &how, error);
    if (!keeps_pixels) {
        rf_free(filter->context, l->pixels.luminance);
        l->pixels.luminance = NULL;
    }
    return result;
}

void rf_picture_drop_pixels(struct rf_picture *l)
{
    const struct rf_context *context = l->filter->context;
    rf_free(context, l->pixels.luminance);
    rf_free(context, l->pixels.at);
    l->pixels.luminance = NULL;
    l->pixels.at = NULL;
}

void rf_picture_free(struct rf_picture *l)
{
    if (!l->filter)
        return;
    const struct rf_context *context = l->filter->context;
    rf_picture_drop_pixels(l);
    rf_free(context, l->pixels.radius);
    rf_free(context, l->others);
    rf_free(context, l->darkest);
    rf_free(context, l->highlights.at);
    rf_free(context, l->surfaces.peak);
    rf_free(context, l->surfaces.share);
    rf_far_free(&l->surfaces, context);
    rf_free(context, l->surfaces.near);
    rf_areas_free(&l->areas, context);
}

/* Moves rows together that have left room between them; start[i] is where row i is. */
static void join_rows(struct rf_sample *at, size_t *start, const size_t *n, int n_rows)
{
    size_t end = 0;
    for (int i = 0; i < n_rows; i++) {
        if (end != start[i])
            memmove(at + end, at + start[i], n[i] * sizeof *at);
        start[i] = end;
        end += n[i];
    }
    start[n_rows] = end;
}

rf_result rf_collect_rows(struct rf_scene *scene, int n_visible, int n_rows,
                          rf_row_fn row, void *user, struct rf_sample **memory,
                          struct rf_error *error)
{
    const struct rf_context *context = scene->filter->context;
    struct rf_task *task = scene->task;
    size_t *start = rf_alloc(context, 2 * (size_t)n_rows + 1, sizeof *start);
    if (!start)
        return rf_fail_memory(error, 2 * (size_t)n_rows + 1, sizeof *start);
    size_t *n_of = start + n_rows + 1;
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 16)
    for (int i = 0; i < n_rows; i++)
        n_of[i] = rf_task_is_cancelled(task) ? 0 : row(user, i, NULL);
    start[0] = 0;
    for (int i = 0; i < n_rows; i++)
        start[i + 1] = start[i] + n_of[i];
    rf_task_poll(task);
    size_t n = start[n_rows];
    struct rf_sample *at = rf_alloc(context, n, sizeof *at);
    if (at) {
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 16)
        for (int i = 0; i < n_rows; i++)
            n_of[i] = rf_task_is_cancelled(task) ? 0 : row(user, i, at + start[i]);
        join_rows(at, start, n_of, n_rows);
        size_t n_first = start[n_visible];
        scene->visible = (struct rf_samples){at, n_first};
        scene->hidden = (struct rf_samples){at + n_first, start[n_rows] - n_first};
    }
    *memory = at;
    rf_free(context, start);
    rf_task_poll(task);
    return at ? RF_OK : rf_fail_memory(error, n, sizeof *at);
}
