/* SPDX-License-Identifier: Apache-2.0 */
/*
 * layered: occlusion-aware depth of field from one view; the default.
 *
 * Every pixel is a small emitter that spreads over its aperture's footprint. The steps,
 * each in a module of its own:
 *
 *   border      the picture is continued by its edge pixels, bright ones dimmed to
 * white split       edge pixels become their two surfaces (split.c) hidden background
 * that only the lens can see is estimated           (hidden.c) highlights  first, each
 * with the exact shape that things before it leave (highlight.c) composite   all other
 * samples near to far, then the hidden ones       (composite.c)
 *
 * Ours; reading: Kosloff 2009 (spreading), Lee, Eisemann and Seidel 2009 (layers), the
 * coverage partition of deep compositing. Approximates: one hidden surface behind each
 * pixel; surfaces without slope; bins of 2 px of radius; radii above 8 px at a reduced
 * resolution. Mirrors and glass are blurred by the depth of their surface.
 */
#include "../composite.h"

static const float HIGHLIGHT_LUMINANCE = 2; /* above display white by a stop */
static const float HIGHLIGHT_OVER_AREA = 8; /* times the usual luminance around */
static const float HIGHLIGHT_RADIUS_PX = 1;
static const float BORDER_LUMINANCE = 1;
static const float BRIGHT = 4; /* times the darkest pixel of 5 x 5 */

enum {
    MAX_BORDER = 256,
    AREA = 32,              /* px: blocks whose luminance tells what is usual */
    HIGHLIGHT_BUDGET = 192, /* disc pixels of all highlights per picture pixel */
};

struct layered {
    struct rf_work *work;
    int border, width, height; /* of the padded picture */
    struct rf_surface *pixels;
    struct rf_surfaces surfaces;
    struct rf_surface *hidden;
    float *hidden_weight;
    float *darkest; /* per pixel: least luminance of 5 x 5 */
    float *area;    /* per block of AREA: geometric mean luminance */
    int n_area_x, n_area_y;
    struct rf_sample *samples;
    struct rf_samples highlights;
};

static size_t padded_size(const struct layered *l)
{
    return (size_t)l->width * (size_t)l->height;
}

/* ---- border -------------------------------------------------------------------- */

static struct rf_surface load_pixel(const struct rf_work *work, int x, int y)
{
    size_t i = (size_t)y * (size_t)work->filter->width + (size_t)x;
    struct rf_surface s = {.r = work->radius[i]};
    for (int n = 0; n < 3; n++)
        s.c[n] = work->colour[work->n_planes == 1 ? 0 : n][i];
    s.c[3] = work->n_planes == 4 ? work->colour[3][i] : 1;
    return s;
}

static void load_pixels(struct layered *l)
{
    const struct rf_filter *f = l->work->filter;
#pragma omp parallel for num_threads(f->context->n_threads) schedule(static)
    for (int y = 0; y < l->height; y++)
        for (int x = 0; x < l->width; x++) {
            int sx = x - l->border, sy = y - l->border;
            int cx = rf_min_int(rf_max_int(sx, 0), f->width - 1);
            int cy = rf_min_int(rf_max_int(sy, 0), f->height - 1);
            struct rf_surface s = load_pixel(l->work, cx, cy);
            float lum = rf_luminance(s.c[0], s.c[1], s.c[2]);
            if ((cx != sx || cy != sy) && lum > BORDER_LUMINANCE)
                for (int n = 0; n < 3; n++)
                    s.c[n] *= BORDER_LUMINANCE / lum;
            l->pixels[(size_t)y * (size_t)l->width + (size_t)x] = s;
        }
}

/*
 * Least luminance of 5 x 5 pixels, premultiplication undone; what is transparent has no
 * colour that others could stand out from.
 */
static float darkest_around(const struct layered *l, int x, int y)
{
    float least = INFINITY;
    for (int j = rf_max_int(y - 2, 0); j <= rf_min_int(y + 2, l->height - 1); j++)
        for (int i = rf_max_int(x - 2, 0); i <= rf_min_int(x + 2, l->width - 1); i++) {
            const struct rf_surface *s =
                &l->pixels[(size_t)j * (size_t)l->width + (size_t)i];
            float lum = rf_luminance(s->c[0], s->c[1], s->c[2]);
            if (s->c[3] == 1)
                least = lum < least ? lum : least;
            else if (s->c[3] > 0)
                least = lum < least * s->c[3] ? lum / s->c[3] : least;
        }
    return least;
}

static void find_darkest(struct layered *l)
{
#pragma omp parallel for num_threads(l->work->filter->context->n_threads)              \
    schedule(static)
    for (int y = 0; y < l->height; y++)
        for (int x = 0; x < l->width; x++)
            l->darkest[(size_t)y * (size_t)l->width + (size_t)x] =
                darkest_around(l, x, y);
}

/* ---- highlights ---------------------------------------------------------------- */

static void measure_areas(struct layered *l)
{
    for (int i = 0; i < l->n_area_x * l->n_area_y; i++) {
        int x0 = i % l->n_area_x * AREA, y0 = i / l->n_area_x * AREA, n = 0;
        int x1 = rf_min_int(x0 + AREA, l->width), y1 = rf_min_int(y0 + AREA, l->height);
        float sum = 0;
        for (int y = y0; y < y1; y += 2)
            for (int x = x0; x < x1; x += 2, n++) {
                const struct rf_surface *s =
                    &l->pixels[(size_t)y * (size_t)l->width + (size_t)x];
                sum +=
                    rf_logf(fmaxf(rf_luminance(s->c[0], s->c[1], s->c[2]), 0) + 1e-3f);
            }
        l->area[i] = rf_expf(sum / (float)n);
    }
}

/* Lower middle of the areas around a pixel: a lamp that fills its own does not count.
 */
static float usual_luminance(const struct layered *l, int x, int y)
{
    float sorted[9];
    int n = 0, ax = x / AREA, ay = y / AREA;
    for (int j = rf_max_int(ay - 1, 0); j <= rf_min_int(ay + 1, l->n_area_y - 1); j++)
        for (int i = rf_max_int(ax - 1, 0); i <= rf_min_int(ax + 1, l->n_area_x - 1);
             i++) {
            int k = n++;
            for (; k > 0 && sorted[k - 1] > l->area[j * l->n_area_x + i]; k--)
                sorted[k] = sorted[k - 1];
            sorted[k] = l->area[j * l->n_area_x + i];
        }
    return sorted[(n - 1) / 2];
}

static bool is_highlight(const struct layered *l, const struct rf_surface *s, int x,
                         int y, float factor)
{
    float lum = rf_luminance(s->c[0], s->c[1], s->c[2]);
    return lum > HIGHLIGHT_LUMINANCE * factor && fabsf(s->r) > HIGHLIGHT_RADIUS_PX &&
           lum > HIGHLIGHT_OVER_AREA * factor * usual_luminance(l, x, y);
}

static struct rf_sample make_sample(const struct rf_surface *s, int x, int y, float w)
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

typedef void (*visit_fn)(void *user, struct rf_surface *s, int x, int y, float w);

/* Every visible piece of surface, rows from the top. */
static void visit_visible(struct layered *l, visit_fn visit, void *user)
{
    struct rf_surfaces *s = &l->surfaces;
    for (int y = 0; y < l->height; y++)
        for (int x = 0; x < l->width; x++) {
            size_t i = (size_t)y * (size_t)l->width + (size_t)x;
            if (s->share[i] > 0)
                visit(user, &s->near[i], x, y, s->share[i]);
            if (s->share[i] < 1)
                visit(user, &s->far[i], x, y, 1 - s->share[i]);
        }
}

enum { N_FACTORS = 24 };

struct budget {
    struct layered *l;
    double area[N_FACTORS]; /* of the discs that stay with the threshold times 2^i */
};

static void count_area(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct budget *b = user;
    float factor = 1;
    for (int i = 0; i < N_FACTORS && is_highlight(b->l, s, x, y, factor); i++) {
        b->area[i] += RF_PI * (double)s->r * s->r;
        factor *= 2;
    }
}

/* The least factor on the thresholds at which the discs fit into the budget. */
static float highlight_factor(struct layered *l)
{
    struct budget b = {.l = l};
    visit_visible(l, count_area, &b);
    double limit = (double)HIGHLIGHT_BUDGET * (double)padded_size(l);
    float factor = 1;
    for (int i = 0; i < N_FACTORS - 1 && b.area[i] > limit; i++)
        factor *= 2;
    return factor;
}

struct lights {
    struct layered *l;
    float factor;
    struct rf_samples *out; /* NULL: only count */
    size_t n;
};

static void collect_light(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct lights *lights = user;
    if (!is_highlight(lights->l, s, x, y, lights->factor))
        return;
    lights->n++;
    if (!lights->out)
        return;
    struct rf_sample *light = &lights->out->at[lights->out->n++];
    *light = make_sample(s, x, y, w);
    take_light(s->c, light->c,
               usual_luminance(lights->l, x, y) /
                   rf_luminance(s->c[0], s->c[1], s->c[2]));
}

/*
 * Takes the light of the highlights out of their surfaces, which keep the usual
 * luminance of the place: what is left can be blended, normalised and continued behind
 * things like any other surface, without doubling a lamp.
 */
static rf_result take_highlights(struct layered *l, struct rf_error *error)
{
    struct lights lights = {.l = l, .factor = highlight_factor(l)};
    visit_visible(l, collect_light, &lights);
    l->highlights.at =
        rf_alloc(l->work->filter->context, lights.n, sizeof *l->highlights.at);
    if (!l->highlights.at)
        return rf_fail_memory(error, lights.n, sizeof *l->highlights.at);
    lights.out = &l->highlights;
    visit_visible(l, collect_light, &lights);
    return RF_OK;
}

/* ---- samples ------------------------------------------------------------------- */

struct collector {
    const struct layered *l;
    struct rf_samples samples; /* at NULL: only count */
};

static void put_sample(struct collector *c, const struct rf_sample *s)
{
    if (c->samples.at)
        c->samples.at[c->samples.n] = *s;
    c->samples.n++;
}

/* One sample, or two where the surface is bright: see enum rf_footprint_kind. */
static void collect(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct collector *c = user;
    struct rf_sample p = make_sample(s, x, y, w);
    float lum = rf_luminance(s->c[0], s->c[1], s->c[2]);
    float limit =
        BRIGHT * p.c[3] * c->l->darkest[(size_t)y * (size_t)c->l->width + (size_t)x];
    if (lum > limit) {
        struct rf_sample light = p;
        light.kind = RF_POSITIVE;
        take_light(p.c, light.c, limit / lum);
        put_sample(c, &light);
    }
    put_sample(c, &p);
}

static void collect_hidden(const struct layered *l, struct rf_samples *hidden)
{
    for (int y = 0; y < l->height; y++)
        for (int x = 0; x < l->width; x++) {
            size_t i = (size_t)y * (size_t)l->width + (size_t)x;
            if (l->hidden_weight[i] > 0)
                hidden->at[hidden->n++] =
                    make_sample(&l->hidden[i], x, y, l->hidden_weight[i]);
        }
}

/* ---- all ----------------------------------------------------------------------- */

static rf_result composite(struct layered *l, struct rf_error *error)
{
    struct rf_work *work = l->work;
    const struct rf_context *context = work->filter->context;
    size_t n = padded_size(l);
    int n_colours = work->n_planes == 4 ? 4 : 3;
    struct collector count = {.l = l}, fill = {.l = l};
    visit_visible(l, collect, &count);
    size_t n_samples = count.samples.n + (l->hidden ? n : 0);
    l->samples = rf_alloc(context, n_samples, sizeof *l->samples);
    float *planes = rf_alloc(context, n * (size_t)n_colours, sizeof *planes);
    if (!l->samples || !planes) {
        rf_free(context, planes);
        return rf_fail_memory(error, n_samples, sizeof *l->samples);
    }
    fill.samples.at = l->samples;
    visit_visible(l, collect, &fill);
    struct rf_scene scene = {.filter = work->filter,
                             .width = l->width,
                             .height = l->height,
                             .n_colours = n_colours,
                             .visible = fill.samples,
                             .highlights = l->highlights,
                             .occluders = &l->surfaces,
                             .task = work->task,
                             .progress_to = 1};
    scene.hidden.at = l->samples + scene.visible.n;
    if (l->hidden)
        collect_hidden(l, &scene.hidden);
    float *out[4];
    for (int p = 0; p < n_colours; p++)
        out[p] = planes + n * (size_t)p;
    rf_result result = rf_composite(&scene, out, error);
    for (int y = 0; y < work->filter->height && result == RF_OK; y++)
        for (int p = 0; p < work->n_planes; p++)
            memcpy(work->colour[p] + (size_t)y * (size_t)work->filter->width,
                   out[p] + (size_t)(y + l->border) * (size_t)l->width + l->border,
                   (size_t)work->filter->width * sizeof(float));
    rf_free(context, planes);
    return result;
}

static rf_result find_surfaces(struct layered *l, struct rf_error *error)
{
    const struct rf_filter *f = l->work->filter;
    struct rf_task *task = l->work->task;
    struct rf_pixels pixels = {l->width, l->height, l->pixels};
    load_pixels(l);
    measure_areas(l);
    find_darkest(l);
    rf_task_phase(task, 0.15, l->height);
    if (f->params.split_edges)
        rf_split_edges(f, &pixels, &l->surfaces, task);
    else
        rf_split_nothing(f, &pixels, &l->surfaces);
    if (f->params.exact_highlights) {
        rf_result result = take_highlights(l, error);
        if (result != RF_OK)
            return result;
    }
    if (!f->params.fill_hidden)
        return RF_OK;
    rf_task_phase(task, 0.4, (l->height + 1) / 2);
    return rf_find_hidden(f, &l->surfaces, l->hidden, l->hidden_weight, task, error);
}

static rf_result allocate(struct layered *l, struct rf_error *error)
{
    const struct rf_context *context = l->work->filter->context;
    size_t n = padded_size(l);
    l->n_area_x = (l->width + AREA - 1) / AREA;
    l->n_area_y = (l->height + AREA - 1) / AREA;
    l->area =
        rf_alloc(context, (size_t)l->n_area_x * (size_t)l->n_area_y, sizeof(float));
    l->pixels = rf_alloc(context, n, sizeof *l->pixels);
    l->darkest = rf_alloc(context, n, sizeof *l->darkest);
    l->surfaces = (struct rf_surfaces){
        .width = l->width,
        .height = l->height,
        .near = rf_alloc(context, n, sizeof *l->surfaces.near),
        .far = rf_alloc(context, n, sizeof *l->surfaces.far),
        .share = rf_alloc(context, n, sizeof *l->surfaces.share),
    };
    bool is_complete = l->area && l->pixels && l->darkest && l->surfaces.near &&
                       l->surfaces.far && l->surfaces.share;
    if (l->work->filter->params.fill_hidden) {
        l->hidden = rf_alloc(context, n, sizeof *l->hidden);
        l->hidden_weight = rf_alloc(context, n, sizeof *l->hidden_weight);
        is_complete = is_complete && l->hidden && l->hidden_weight;
    }
    return is_complete ? RF_OK : rf_fail_memory(error, n * 4, sizeof *l->pixels);
}

static float largest_radius(const struct rf_work *work)
{
    size_t n = (size_t)work->filter->width * (size_t)work->filter->height;
    float most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmaxf(most, fabsf(work->radius[i]));
    return most;
}

rf_result rf_layered_run(struct rf_work *work, struct rf_error *error)
{
    const struct rf_context *context = work->filter->context;
    struct layered l = {.work = work};
    l.border = rf_min_int((int)ceilf(largest_radius(work)), MAX_BORDER);
    l.width = work->filter->width + 2 * l.border;
    l.height = work->filter->height + 2 * l.border;
    rf_result result = allocate(&l, error);
    if (result == RF_OK)
        result = find_surfaces(&l, error);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = composite(&l, error);
    rf_free(context, l.samples);
    rf_free(context, l.highlights.at);
    rf_free(context, l.hidden_weight);
    rf_free(context, l.hidden);
    rf_free(context, l.surfaces.share);
    rf_free(context, l.surfaces.far);
    rf_free(context, l.surfaces.near);
    rf_free(context, l.darkest);
    rf_free(context, l.pixels);
    rf_free(context, l.area);
    return result;
}
