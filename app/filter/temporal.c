/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What one frame hides, from those beside it.
 *
 * Every pixel of a neighbour is moved to its place in the frame (temporal_map.h) and
 * spread over the four pixels around it. Where it lies behind what the frame shows, it
 * counts; of several surfaces that which was seen most does, and all that show that one
 * are averaged. Left out are pixels beside something nearer, whose colour may be a mix of
 * both, and neighbours that do not fit: of what the frame shows, less than half would
 * lie where the map says, or what does has another light (behind a cut, or as a lamp
 * goes on): of the mean lights A and B of a part of the picture,
 *
 *   |A - B| / (A + B) > 0.2 in the mean, a factor of 1.5.
 *
 * Only inputs are read, in the order of their distance, so a frame does not depend on
 * which others are made, nor by whom. Memory: 8 (channels + 4) bytes per pixel and
 * view, and one neighbour at a time.
 */
#include "filter/temporal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/luminance.h"
#include "common/report.h"
#include "filter/filter_private.h"
#include "filter/temporal_lights.h"
#include "filter/temporal_map.h"
#include "interrupt.h"
#include "sources/beside.h"

enum {
    SAMPLE_STEP = 4,  /* px between those that a map is tried on */
    N_SLOTS = 2,      /* hidden surfaces that are told apart at a pixel */
    N_PARTS = 8,      /* across and down, of which the light is looked at */
    POINTS_EVERY = 4, /* pixels there is one of a light at most: more is no lamp */
};

/* Of a pixel, to be known; less is the rim of something that others do not show. */
static const float LEAST_COVER = 0.1f;
/* Of what the frame shows, to lie where a map says that it does. */
static const double LEAST_FIT = 0.5;
/* Of its light, for it to be the same shot in the same light. */
static const double MOST_SHIFT = 0.2;

/* What is known of a hidden surface of a pixel. */
struct hidden {
    float r; /* of the first that came, px */
    float weight, z;
};

/* One view of the frame that is made. */
struct target {
    int32_t width, height;
    int n_channels;
    struct rf_lens lens;
    const float *colour;   /* packed, as are all */
    float *radius;         /* of what is seen, of the lens without any field */
    float *front;          /* the least of 3 x 3: what lies behind may be hidden */
    struct hidden *hidden; /* N_SLOTS of each pixel */
    float *sums;           /* of their colours */
    int32_t margin;        /* px beyond the border, from which light comes in */
    int32_t frame;         /* beside, whose points are added: 0 is the first */
    bool wants_lights;
    float white;                    /* of the picture */
    float least_light;              /* luminance of lamps */
    struct light_points *lights;    /* that it does not show */
    struct temporal_border *border; /* NULL: it is not continued */
};

/* A neighbour's view, read. */
struct neighbour {
    struct source source;
    bool is_open;
    float *colour, *depth, *vectors, *radius;
    struct temporal_map map;
};

struct temporal_behind {
    float *colour, *depth; /* NULL: nothing is known */
    struct rf_unseen_light *lights;
    size_t n_lights;
    bool has_too_many; /* lights: some are left out */
};

static float radius_at(const struct rf_lens *lens, double z)
{
    return (float)rf_lens_radius_px(lens, z);
}

/* The nearest of 3 x 3 pixels, of which the middle one's colour may hold a part. */
static float nearest_beside(const float *radius, int32_t width, int32_t height,
                            int32_t x, int32_t y)
{
    float least = INFINITY;
    for (int32_t j = y > 0 ? y - 1 : 0; j <= y + 1 && j < height; j++)
        for (int32_t i = x > 0 ? x - 1 : 0; i <= x + 1 && i < width; i++)
            least = fminf(least, radius[(size_t)j * (size_t)width + (size_t)i]);
    return least;
}

/* ---- the frame ------------------------------------------------------------------ */

/* Radii of what a packed depth says. */
static rf_result make_radii(const struct rf_filter *filter,
                            const struct rf_image *depth, float *radius,
                            struct rf_error *error)
{
    const struct rf_image planar =
        rf_image_packed(radius, depth->width, depth->height, 1);
    const rf_result result = rf_filter_planar_depth(filter, depth, &planar, error);
    const size_t n = (size_t)depth->width * (size_t)depth->height;
    for (size_t i = 0; i < n && result == RF_OK; i++)
        radius[i] = radius_at(rf_filter_lens(filter), (double)radius[i]);
    return result;
}

/* How far beyond the border something lies that the lens can see, px; the core looks no
 * farther than MOST_MARGIN. */
static int32_t margin_of(const float *radius, size_t n)
{
    enum { MOST_MARGIN = 256 };
    float most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmaxf(most, fabsf(radius[i]));
    return most < MOST_MARGIN ? (int32_t)ceilf(most) : MOST_MARGIN;
}

static void target_free(struct target *target)
{
    if (target->lights)
        light_points_free(target->lights);
    temporal_border_free(target->border);
    free(target->lights);
    free(target->radius);
    free(target->front);
    free(target->hidden);
    free(target->sums);
}

static int target_open(struct run *run, int view, struct target *target)
{
    const struct source *source = &run->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    struct rf_error error;
    *target = (struct target){
        .width = source->width,
        .height = source->height,
        .n_channels = source->n_channels,
        .lens = *rf_filter_lens(run->filter),
        .colour = run->has_views ? run->views.views[view].colour.data : run->colour,
        .radius = app_memory(n, sizeof(float), run->error),
        .front = app_memory(n, sizeof(float), run->error),
        .hidden = app_memory(n, N_SLOTS * sizeof(struct hidden), run->error),
        .sums = app_memory(n, N_SLOTS * (size_t)source->n_channels * sizeof(float),
                           run->error)};
    target->lights = app_memory(1, sizeof(*target->lights), run->error);
    if (!target->radius || !target->front || !target->hidden || !target->sums ||
        !target->lights)
        return APP_NO_MEMORY;
    target->lights->most = n / POINTS_EVERY;
    target->wants_lights = !run->has_views && run->settings->params.exact_highlights;
    target->white = (float)run->params.white;
    target->least_light = LEAST_LIGHT * target->white;
    const struct rf_image depth =
        rf_image_packed(run->has_views ? run->views.views[view].depth.data : run->depth,
                        target->width, target->height, 1);
    if (make_radii(run->filter, &depth, target->radius, &error) != RF_OK)
        return filter_fail_view(run, view, &error);
    target->margin = margin_of(target->radius, n);
    if (temporal_border_is_of(run)) {
        target->border = temporal_border_make(run, target->margin, run->error);
        if (!target->border)
            return APP_NO_MEMORY;
    }
    for (int32_t y = 0; y < target->height; y++)
        for (int32_t x = 0; x < target->width; x++)
            target->front[(size_t)y * (size_t)target->width + (size_t)x] =
                nearest_beside(target->radius, target->width, target->height, x, y);
    return APP_DONE;
}

/* ---- what the header says of the camera ------------------------------------------- */

static void read_camera(const struct source *source, const char *view,
                        const struct rf_lens *lens, double pixel_aspect,
                        struct temporal_camera *camera)
{
    double *matrix = camera->world_to_camera;
    camera->lens = *lens;
    camera->pixel_aspect = pixel_aspect;
    views_find_place(source->colour, view, camera->lens_offset,
                     &camera->shear_distance);
    camera->has_matrix =
        image_attribute_matrix(source->colour, "worldToCamera", matrix) ||
        (source->depth &&
         image_attribute_matrix(source->depth, "worldToCamera", matrix));
}

/* ---- motion vectors -------------------------------------------------------------- */

/* How programs name and sign the way to the frame before and the one after. */
static const struct {
    const char *x, *y;
    int offset;     /* of the frame that has them from the one they lead to */
    double sign[2]; /* to px right and down */
} passes[] = {{"Vector.X", "Vector.Y", 1, {1, -1}},  /* Cycles, Eevee: before - here */
              {"Vector.Z", "Vector.W", -1, {-1, 1}}, /* here - after */
              {"backward.u", "backward.v", 1, {1, -1}}, /* Nuke */
              {"forward.u", "forward.v", -1, {1, -1}}};

/* The channel of this name, whatever the layers before it, of the colour's view; -1:
 * there is none. */
static int find_channel(const struct source *source, const char *name)
{
    int n;
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    const char *view = beside_view(source);
    const size_t length = strlen(name);
    for (int i = 0; i < n; i++) {
        char plain[256];
        beside_drop_view(channels[i].name, view ? view : "", plain, sizeof(plain));
        const size_t own = strlen(plain);
        if (beside_is_of_view(source, i) && own >= length &&
            strcmp(plain + own - length, name) == 0 &&
            (own == length || plain[own - length - 1] == '.'))
            return i;
    }
    return -1;
}

/* Reads the vectors that lead from a neighbour to the frame; false on failure. */
static bool read_vectors(struct neighbour *from, int32_t offset, int n_threads,
                         struct image_error *error)
{
    const struct source *source = &from->source;
    int n_parts;
    const struct image_part_info *parts = image_parts(source->colour, &n_parts);
    for (size_t i = 0; i < sizeof(passes) / sizeof(passes[0]); i++) {
        int n;
        const struct image_channel_info *channels = image_channels(source->colour, &n);
        const int xy[2] = {find_channel(source, passes[i].x),
                           find_channel(source, passes[i].y)};
        if (passes[i].offset != offset || xy[0] < 0 || xy[1] < 0 ||
            channels[xy[0]].part != channels[xy[1]].part ||
            memcmp(&parts[channels[xy[0]].part].data_window, &source->info.data_window,
                   sizeof(struct image_box)) != 0)
            continue;
        from->vectors = app_memory((size_t)source->width * (size_t)source->height,
                                   2 * sizeof(float), error);
        memcpy(from->map.vector_sign, passes[i].sign, sizeof(passes[i].sign));
        from->map.vectors = from->vectors;
        from->map.width = source->width;
        return from->vectors &&
               image_read(source->colour, xy, 2, from->vectors, n_threads, error);
    }
    return true;
}

/* ---- neighbours ------------------------------------------------------------------ */

static void neighbour_free(struct neighbour *from)
{
    free(from->colour);
    free(from->depth);
    free(from->vectors);
    free(from->radius);
    if (from->is_open)
        source_close(&from->source);
}

/* Which of the run's paths a view is read from. */
static int path_of_view(const struct run *run, int view)
{
    for (int i = 0; run->has_views && i < run->request.n_paths; i++)
        if (run->request.paths[i] == run->list.items[view].path)
            return i;
    return 0;
}

static bool open_neighbour(const struct run *run, int view,
                           const struct temporal_frame *frame, struct neighbour *from)
{
    struct source_request request = run->request;
    request.paths = frame->paths + path_of_view(run, view);
    request.n_paths = run->has_views ? 1 : frame->n_paths;
    request.depth_file = frame->depth_file;
    request.view = run->has_views ? run->list.items[view].name : run->tool->view;
    from->is_open = source_open(&from->source, &request, run->error);
    if (!from->is_open || !source_check(&from->source, run->error))
        return false;
    if (from->source.n_channels == run->source.n_channels)
        return true;
    return set_error(run->error,
                     "%s: has %d channels of colour, and %s beside it %d; --temporal "
                     "takes frames that are alike",
                     image_path(from->source.colour), from->source.n_channels,
                     image_path(run->source.colour), run->source.n_channels);
}

/* Depth as the run repairs its own. */
static int mend_depth(const struct run *run, struct neighbour *from)
{
    const struct source *source = &from->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    struct rf_depth_stats stats = {.size = sizeof(stats)};
    struct rf_depth_channel channel = {
        from->depth,
        rf_image_packed(from->colour, source->width, source->height,
                        source->n_channels),
        source->width, source->height, run->settings->params.depth_infinity};
    const bool is_distance = run->settings->params.depth == RF_DEPTH_PLANAR ||
                             run->settings->params.depth == RF_DEPTH_RADIAL;
    rf_depth_undo_mist(from->depth, n, (enum rf_mist)run->tool->mist_falloff);
    if (!filter_needs_depth(run) || !is_distance)
        return APP_DONE;
    return rf_depth_repair(run->context, &channel, &stats, NULL) == RF_OK
               ? APP_DONE
               : app_fail(run->error, APP_NO_MEMORY, "%s: out of memory",
                          image_path(source->depth));
}

/* Planar distances in place of the depth, radii beside it, and the camera. */
static int measure_neighbour(const struct run *run, int view,
                             const struct temporal_frame *frame, struct neighbour *from)
{
    struct settings *settings = app_memory(1, sizeof(*settings), run->error);
    struct rf_filter *filter = NULL;
    struct rf_params params = {0};
    struct rf_error error;
    char text[1024];
    const struct source *source = &from->source;
    const struct rf_image depth =
        rf_image_packed(from->depth, source->width, source->height, 1);
    const char *name = run->has_views ? run->list.items[view].name : run->tool->view;
    if (!settings)
        return APP_NO_MEMORY;
    *settings = *frame->settings;
    int code = APP_DONE;
    if (!source_read_facts(source, settings, text, sizeof(text)))
        code = app_fail(run->error, APP_FAILED, "%s", text);
    else if (settings_fit_window(settings, &source->info, &params, &error) != RF_OK)
        code = app_fail(run->error, APP_FAILED, "%s: %s", image_path(source->colour),
                        error.message);
    free(settings);
    if (code != APP_DONE)
        return code;
    params.method = RF_METHOD_LAYERED;
    params.aperture = RF_APERTURE_DISC; /* needs no picture */
    if (rf_filter_create(&filter, run->context, &params, source->width, source->height,
                         &error) != RF_OK ||
        rf_filter_planar_depth(filter, &depth, &depth, &error) != RF_OK) {
        rf_filter_destroy(filter);
        return app_fail(run->error, APP_FAILED, "%s: %s", image_path(source->depth),
                        error.message);
    }
    read_camera(source, name, rf_filter_lens(filter), params.pixel_aspect,
                &from->map.from);
    rf_filter_destroy(filter);
    return APP_DONE;
}

static int read_neighbour(const struct run *run, int view, const struct target *target,
                          const struct temporal_frame *frame, struct neighbour *from)
{
    const struct source *source = &from->source;
    if (!open_neighbour(run, view, frame, from))
        return app_code_of(run->error);
    from->colour = source_read_colour(source, run->n_threads, run->error);
    from->depth =
        from->colour ? source_read_depth(source, run->n_threads, run->error) : NULL;
    const size_t n = (size_t)source->width * (size_t)source->height;
    from->radius = from->depth ? app_memory(n, sizeof(float), run->error) : NULL;
    if (!from->radius || !read_vectors(from, frame->offset, run->n_threads, run->error))
        return app_code_of(run->error);
    int code = mend_depth(run, from);
    if (code == APP_DONE)
        code = measure_neighbour(run, view, frame, from);
    for (size_t i = 0; i < n && code == APP_DONE; i++)
        from->radius[i] = radius_at(&target->lens, (double)from->depth[i]);
    return code;
}

/* ---- does a map fit? ------------------------------------------------------------- */

struct fit {
    double score; /* of the colours, 0: the same; where they disagree 1 */
    double share; /* of what lies within the frame */
    double shift; /* of the light of its parts, 0: the same; to 1 */
};

/* The light of parts of the picture, in the frame and beside it; sums have less grain
 * than pixels, and fireflies count as white. */
struct parts {
    double here[N_PARTS * N_PARTS], beside[N_PARTS * N_PARTS];
    int n[N_PARTS * N_PARTS];
};

static void add_part(struct parts *parts, const struct target *target,
                     const struct temporal_place *at, float here, float beside)
{
    const int x = (int)(at->x * N_PARTS / target->width);
    const int y = (int)(at->y * N_PARTS / target->height);
    parts->here[N_PARTS * y + x] += (double)fminf(fmaxf(here, 0), target->white);
    parts->beside[N_PARTS * y + x] += (double)fminf(fmaxf(beside, 0), target->white);
    parts->n[N_PARTS * y + x]++;
}

static double shift_of(const struct parts *parts)
{
    double sum = 0;
    int n = 0;
    for (int i = 0; i < N_PARTS * N_PARTS; i++) {
        const double here = parts->here[i], beside = parts->beside[i];
        if (here + beside > 0)
            sum += parts->n[i] * fabs(here - beside) / (here + beside);
        n += parts->n[i];
    }
    return n ? sum / n : 0;
}

/* Where pixel (x, y) lies in the frame; false where it shows nothing that can be used. */
static bool find_place(const struct neighbour *from, int32_t x, int32_t y,
                       struct temporal_place *at)
{
    const size_t i = (size_t)y * (size_t)from->source.width + (size_t)x;
    const size_t n = (size_t)from->source.n_channels;
    for (size_t c = 0; c < n; c++)
        if (!isfinite(from->colour[i * n + c]))
            return false;
    return !isnan(from->depth[i]) &&
           temporal_map_place(&from->map, x, y, (double)from->depth[i], at);
}

static struct fit try_map(const struct target *target, const struct neighbour *from)
{
    double score = 0;
    int n = 0, n_same = 0;
    struct parts parts = {.n = {0}};
    const size_t step = (size_t)target->n_channels;
    for (int32_t y = SAMPLE_STEP / 2; y < from->source.height; y += SAMPLE_STEP)
        for (int32_t x = SAMPLE_STEP / 2; x < from->source.width; x += SAMPLE_STEP) {
            const size_t i = (size_t)y * (size_t)from->source.width + (size_t)x;
            struct temporal_place at;
            if (!find_place(from, x, y, &at) || !(at.x >= 0 && at.x < target->width &&
                                                  at.y >= 0 && at.y < target->height))
                continue;
            const size_t j = (size_t)at.y * (size_t)target->width + (size_t)at.x;
            n++;
            if (fabsf(radius_at(&target->lens, at.z) - target->radius[j]) >=
                TEMPORAL_SAME_PX) {
                score += 1;
                continue;
            }
            const float a = luminance_of(from->colour + i * step, target->n_channels);
            const float b = luminance_of(target->colour + j * step, target->n_channels);
            score += fabs((double)(a - b)) / (fabs((double)(a + b)) + 1e-6);
            add_part(&parts, target, &at, b, a);
            n_same++;
        }
    return (struct fit){n ? score / n : 1, n ? (double)n_same / n : 0,
                        shift_of(&parts)};
}

static bool does_fit(const struct fit *fit)
{
    return fit->share >= LEAST_FIT && fit->shift <= MOST_SHIFT;
}

/* Chooses vectors, or the matrices and axes that fit best; false: none does. */
static bool choose_map(const struct target *target, struct neighbour *from)
{
    struct fit best = {2, 0, 1};
    int best_axes = 0;
    struct temporal_map *map = &from->map;
    if (map->vectors) {
        map->kind = TEMPORAL_VECTORS;
        const struct fit fit = try_map(target, from);
        if (does_fit(&fit))
            return true;
    }
    if (!map->from.has_matrix || !map->to.has_matrix || !temporal_map_join(map))
        return false;
    map->kind = TEMPORAL_MATRICES;
    for (int i = 0; i < TEMPORAL_N_AXES; i++) {
        temporal_map_take_axes(map, i);
        const struct fit fit = try_map(target, from);
        if (fit.score < best.score) {
            best = fit;
            best_axes = i;
        }
    }
    temporal_map_take_axes(map, best_axes);
    return does_fit(&best);
}

/* ---- what is hidden -------------------------------------------------------------- */

/* The slot of pixel i for a surface of radius r; -1: there is none. */
static int slot_of(const struct target *target, size_t i, float r)
{
    for (int k = 0; k < N_SLOTS; k++) {
        const struct hidden *hidden = &target->hidden[N_SLOTS * i + (size_t)k];
        if (hidden->weight == 0 || fabsf(r - hidden->r) <= TEMPORAL_SAME_PX)
            return k;
    }
    return -1;
}

/* Adds a point to a pixel if it is hidden there. */
static void add_point(const struct target *target, size_t i, float weight, float r,
                      float z, const float *colour)
{
    const int slot =
        r < target->front[i] + TEMPORAL_SAME_PX ? -1 : slot_of(target, i, r);
    if (slot < 0)
        return;
    const size_t n = (size_t)target->n_channels, at = N_SLOTS * i + (size_t)slot;
    struct hidden *hidden = &target->hidden[at];
    float *sums = target->sums + at * n;
    if (hidden->weight == 0)
        hidden->r = r;
    hidden->weight += weight;
    hidden->z += weight * z;
    for (size_t c = 0; c < n; c++)
        sums[c] += weight * colour[c];
}

/* Adds a part of a bright pixel, where the frame does not show it. */
static void add_light(const struct target *target, const struct light_point *point,
                      float r)
{
    const int32_t x = point->x, y = point->y, margin = target->margin;
    const bool is_inside = x >= 0 && x < target->width && y >= 0 && y < target->height;
    if (x < -margin || x >= target->width + margin || y < -margin ||
        y >= target->height + margin)
        return;
    if (is_inside && r < target->front[(size_t)y * (size_t)target->width + (size_t)x] +
                             TEMPORAL_SAME_PX)
        return;
    light_points_add(target->lights, point);
}

/* Spreads a neighbour's pixel over the four around its place in the frame; what may be
 * a mix of two surfaces only if it is a light, which outshines the other. */
static void spread_point(const struct target *target, const struct temporal_place *at,
                         const float *colour, bool is_mixed)
{
    const double left = floor(at->x - 0.5), top = floor(at->y - 0.5);
    const float across = (float)(at->x - 0.5 - left), down = (float)(at->y - 0.5 - top);
    const float r = radius_at(&target->lens, at->z);
    const bool is_light =
        target->wants_lights &&
        luminance_of(colour, target->n_channels) > target->least_light;
    const int32_t margin = is_light || target->border ? target->margin : 0;
    if (!(left >= -1 - margin && left < target->width + margin && top >= -1 - margin &&
          top < target->height + margin))
        return;
    struct light_point point = {.frame = target->frame, .z = (float)at->z};
    for (int c = 0; c < target->n_channels && is_light; c++)
        point.colour[c] = colour[c];
    for (int k = 0; k < 4; k++) {
        const int32_t x = (int32_t)left + (k & 1), y = (int32_t)top + (k >> 1);
        const float weight = (k & 1 ? across : 1 - across) * (k >> 1 ? down : 1 - down);
        if (!(weight > 0))
            continue;
        point.x = x;
        point.y = y;
        point.weight = weight;
        if (is_light)
            add_light(target, &point, r);
        else if (target->border && !is_mixed)
            temporal_border_add(target->border, x, y, weight, r, (float)at->z, colour,
                                target->n_channels);
        if (!is_mixed && x >= 0 && x < target->width && y >= 0 && y < target->height)
            add_point(target, (size_t)y * (size_t)target->width + (size_t)x, weight, r,
                      (float)at->z, colour);
    }
}

static void add_neighbour(const struct target *target, const struct neighbour *from)
{
    const size_t step = (size_t)target->n_channels;
    for (int32_t y = 0; y < from->source.height; y++)
        for (int32_t x = 0; x < from->source.width; x++) {
            const size_t i = (size_t)y * (size_t)from->source.width + (size_t)x;
            struct temporal_place at;
            if (!find_place(from, x, y, &at))
                continue;
            const bool is_mixed =
                nearest_beside(from->radius, from->source.width, from->source.height, x,
                               y) < from->radius[i] - TEMPORAL_SAME_PX;
            spread_point(target, &at, from->colour + i * step, is_mixed);
        }
}

/* The surface of a pixel that was seen most: of the frames' places, as of those on the
 * lens, most see it. Nearest instead: tPSNR 35.18 dB in place of 35.35, and falling with
 * more frames, 35.04 in place of 35.62 with four on each side (measure_flicker.py). */
static size_t choose_slot(const struct hidden *hidden)
{
    size_t best = 0;
    for (size_t k = 1; k < N_SLOTS; k++)
        if (hidden[k].weight > hidden[best].weight)
            best = k;
    return best;
}

/* The means of what is known, in place of the sums. */
static bool finish(struct target *target, struct temporal_behind *behind,
                   struct image_error *error)
{
    const size_t n = (size_t)target->width * (size_t)target->height;
    const size_t n_channels = (size_t)target->n_channels;
    behind->depth = app_memory(n, sizeof(float), error);
    if (!behind->depth)
        return false;
    for (size_t i = 0; i < n; i++) {
        const size_t at = N_SLOTS * i + choose_slot(&target->hidden[N_SLOTS * i]);
        const struct hidden *hidden = &target->hidden[at];
        const bool is_known = hidden->weight >= LEAST_COVER;
        behind->depth[i] = is_known ? hidden->z / hidden->weight : NAN;
        /* Never later in memory than where it comes from. */
        for (size_t c = 0; c < n_channels; c++)
            target->sums[i * n_channels + c] =
                is_known ? target->sums[at * n_channels + c] / hidden->weight : 0;
    }
    behind->colour = target->sums;
    target->sums = NULL;
    behind->has_too_many = target->lights->is_full;
    return light_points_join(target->lights, target->n_channels, &behind->lights,
                             &behind->n_lights, error);
}

/* ---- all of it ------------------------------------------------------------------- */

/* Adds what one neighbour shows; *is_used: it fits. */
static int add_frame(struct run *run, int view, const struct target *target,
                     const struct temporal_frame *frame, bool *is_used)
{
    struct neighbour from = {.is_open = false};
    const struct source *source =
        run->has_views ? &run->views.sources[view] : &run->source;
    const char *name = run->has_views ? run->list.items[view].name : run->tool->view;
    read_camera(source, name, &target->lens, run->params.pixel_aspect, &from.map.to);
    int code = read_neighbour(run, view, target, frame, &from);
    *is_used = code == APP_DONE && choose_map(target, &from);
    if (*is_used)
        add_neighbour(target, &from);
    neighbour_free(&from);
    return code == APP_DONE && os_is_interrupted() ? APP_INTERRUPTED : code;
}

static int find_of_view(struct run *run, int view, int *n_used)
{
    struct target target;
    const struct temporal_frames *beside = run->tool->beside;
    int code = target_open(run, view, &target);
    for (int i = 0; i < beside->n && code == APP_DONE; i++) {
        bool is_used;
        target.frame = i;
        code = add_frame(run, view, &target, &beside->at[i], &is_used);
        *n_used += is_used;
    }
    if (code == APP_DONE && !finish(&target, &run->behind[view], run->error))
        code = APP_NO_MEMORY;
    if (code == APP_DONE && target.border && temporal_border_finish(target.border)) {
        run->border = target.border;
        target.border = NULL;
    }
    target_free(&target);
    return code;
}

/* Is there anything that would read what is found? */
static const char *why_useless(const struct run *run)
{
    const struct rf_params *params = &run->settings->params;
    if (!rf_method_find(params->method)->has_layers)
        return "only the methods layered and views look behind things";
    if (params->quality == RF_QUALITY_PREVIEW)
        return "the quality preview looks behind nothing";
    return params->fill_hidden ? NULL : "with --no-fill-hidden nothing is put there";
}

/* Bright pixels that only the frames beside show, more than there is room for. */
static int warn_lights(const struct run *run)
{
    bool has_too_many = false;
    for (int i = 0; i < filter_n_views(run); i++)
        has_too_many |= run->behind[i].has_too_many;
    if (!has_too_many)
        return APP_DONE;
    return app_warn(run->tool->host, run->error,
                    "%s: --temporal: the frames beside it show more bright pixels "
                    "(above %g) behind what it shows than it has room for, a quarter "
                    "of its own; some are left out; where these are no lamps, add "
                    "--no-exact-highlights",
                    image_path(run->source.colour),
                    (double)LEAST_LIGHT * run->params.white);
}

int temporal_find(struct run *run)
{
    const struct temporal_frames *beside = run->tool->beside;
    int n_used = 0, code = APP_DONE;
    const char *path = image_path(run->source.colour);
    if (!beside)
        return APP_DONE;
    if (why_useless(run))
        return app_warn(run->tool->host, run->error, "--temporal: has no effect: %s",
                        why_useless(run));
    if (run->is_deep || run->windows)
        return app_fail(run->error, APP_USAGE,
                        run->is_deep ? "--temporal: %s holds deep samples, which hide "
                                       "nothing; leave it out"
                                     : "--temporal: takes %s in memory as a whole; "
                                       "allow more by --max-memory, or leave it out",
                        path);
    run->behind =
        app_memory((size_t)filter_n_views(run), sizeof(*run->behind), run->error);
    if (!run->behind)
        return APP_NO_MEMORY;
    for (int i = 0; i < filter_n_views(run) && code == APP_DONE; i++)
        code = find_of_view(run, i, &n_used);
    if (code == APP_DONE)
        code = warn_lights(run);
    if (code != APP_DONE || n_used > 0)
        return code;
    return app_warn(run->tool->host, run->error,
                    "%s: --temporal: %s, so it is filtered alone", path,
                    beside->n == 0
                        ? "there is no frame beside it"
                        : "the frames beside it do not say where what they show lies "
                          "in it: neither worldToCamera in the headers nor a pass of "
                          "motion vectors (Vector, forward, backward) fits, or "
                          "their light is another one");
}

void temporal_set_behind(const struct run *run, int i, struct rf_view *view)
{
    const struct source *source = &run->source;
    if (!run->behind || !run->behind[i].depth)
        return;
    view->size = sizeof(*view);
    view->behind_colour = rf_image_packed(run->behind[i].colour, source->width,
                                          source->height, source->n_channels);
    view->behind_depth =
        rf_image_packed(run->behind[i].depth, source->width, source->height, 1);
    view->unseen_lights = run->behind[i].lights;
    view->n_unseen_lights = run->behind[i].n_lights;
}

void temporal_free(struct run *run)
{
    for (int i = 0; run->behind && i < filter_n_views(run); i++) {
        free(run->behind[i].colour);
        free(run->behind[i].depth);
        free(run->behind[i].lights);
    }
    free(run->behind);
    run->behind = NULL;
    temporal_border_free(run->border);
    run->border = NULL;
}
