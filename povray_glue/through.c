/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depth of what is seen through flat clear glass, and in flat mirrors. POV-Ray adds fog on
 * each part of a ray's way. Lit minus black fog of distance D and light K is, for a
 * surface at t that lets the share s of the light through (or mirrors it) from u behind,
 * and shows besides the share r of what is infinitely far (what glass mirrors weakly),
 *
 *     (B - B0) / K = 1 - e + e (s (1 - exp(-u / D)) + r),   e = exp(-t / D)
 *
 * t is known from the fogs that end at the first surface. Three distances D give u, s and
 * r. POV-Ray has no fog inside solid things: the glass's own thickness is missing in u.
 *
 * Only where the first surface is flat: through balls and lenses an image is seen, which
 * lies near them, not where the ray ends. 1 / z of a plane is affine in the picture (with
 * an orthographic camera z): its second differences vanish.
 *
 * Things that hold media (smoke, clouds, fire) and bend no light are often unseen themselves,
 * and of any shape: behind them is what a copy shows in which the camera does not see them.
 *
 * Who did not ask for that is told where it would count, at a glance: one bright fog in a
 * small picture. With r = 0 and s = 1 it gives the least distance u that is possible.
 */
#include "through.h"

#include <math.h>
#include <stdlib.h>

#include "camera.h"
#include "fogs.h"
#include "parallel.h"
#include "text.h"

/* Of the nearest fog's light, that comes from behind: less says nothing. */
#define LEAST_BEHIND 0.02
/* A surface that shows more of itself than of what is behind keeps its own depth. */
#define LEAST_SHARE 0.5
/* Where less of the fog's light comes from behind, that may still be most of the
 * picture's: a dark floor mirrors little, and shows nothing else. Of the light of a pixel
 * so much may be its own. */
#define MOST_OWN 0.25
/* Share of the nearest fog's light that must reach the surface. */
#define LEAST_LIGHT 1e-2
/* What is so many times as far without the things that hold media is behind them. */
#define LEAST_FARTHER 1.005
/* Of the fog's light that can come from behind media, so much has to: dense ones that fill
 * half of the way show half of it, as the fog is in them, too, and such as let half of what
 * is behind them through show three quarters. */
#define LEAST_HELD 0.75
/* Distances behind the surface that are tried, of that of the nearest fog: each so many
 * times the one before, then refined. */
#define FIRST_TRIED 0.02
#define STEP_TRIED 1.2
#define N_TRIED 46

/* Length over which flatness is tested, of the picture's width, and the mean second
 * difference over it that counts as flat, of the value: half floats bring 1e-3 to each,
 * which the mean takes out, a ball whose radius is a fifth of its distance 1.3e-3 to all.
 * What differs by more than MOST_BEND is another thing. */
#define FLAT_LENGTH 0.018
#define FLAT_BEND 6e-4
#define MOST_BEND 1e-2

/* A glance: width of its picture, px; share of the picture that is worth a warning; px
 * that the radius of the blur must be wrong by. */
#define GLANCE_PX 80
#define GLANCE_SHARE 0.05
#define GLANCE_BLUR 1.0
/* What is seen in weak mirrors counts as so far behind them, distances of the glance's
 * fog: one fog tells its share only together with its distance. */
#define WEAK_BEHIND 2

struct through {
    struct decode_picture lit[FOGS_MOST], dark[FOGS_MOST];
    struct decode_picture
        own; /* light of the first surfaces, in an assumed_gamma of 1 */
    const struct povray_passes *passes;
    double gamma, distances[FOGS_MOST], light, axis_length;
    const struct povray_camera *camera;
    int32_t width, height, step;
    bool is_glance;
    const float *depth;
    float *bare; /* the same without things that hold media; NULL: there are none */
    float *made; /* planar depth of what is seen through the surface, or of that */
    /* Second differences of the surface along the row and the column: INFINITY where
     * nothing is seen through it, NAN where it is too narrow to tell. */
    float (*bends)[2];
    _Atomic int64_t n_through;
};

/* Mean share of the fog's light in a pixel. */
static double fog_share(const struct through *t, int fog, size_t i)
{
    double sum = 0;
    for (size_t c = 0; c < 3; c++)
        sum += (double)t->lit[fog].rgba[4 * i + c] -
               (t->dark[fog].rgba ? (double)t->dark[fog].rgba[4 * i + c] : 0);
    return sum / (3 * t->light);
}

/* Is the first surface one that holds media? */
static bool is_held(const struct through *t, size_t i)
{
    return t->bare && t->bare[i] > (float)LEAST_FARTHER * t->depth[i];
}

/* Does most of a pixel's light come from behind its surface? */
static bool is_mostly_behind(const struct through *t, size_t i)
{
    if (!t->own.rgba)
        return false;
    const struct povray_passes *all = t->passes;
    const int64_t x = (int64_t)i % t->width, y = (int64_t)i / t->width;
    const int64_t px = (2 * x + 1) * all->width / (2 * t->width);
    const int64_t py = (2 * y + 1) * all->height / (2 * t->height);
    const float *rgb = all->colour + 4 * (py * all->width + px);
    double own = 0, whole = 0;
    for (size_t c = 0; c < 3; c++) {
        own += (double)t->own.rgba[4 * i + c];
        whole += pow(fmax((double)rgb[c], 0), 1 / t->gamma);
    }
    return own < MOST_OWN * whole;
}

/* What comes from behind a surface, in each fog. */
struct behind {
    double light[FOGS_MOST], weight[FOGS_MOST];
    const double *distances;
};

/* Least squares of the shares s and r, neither below 0, for a distance u; returns the
 * sum of the squares. */
static double fit_shares(const struct behind *behind, double u, double *s, double *r)
{
    double aa = 0, ab = 0, bb = 0, ac = 0, bc = 0, error = 0;
    for (int i = 0; i < FOGS_MOST; i++) {
        const double w = behind->weight[i], c = behind->light[i];
        const double a = -expm1(-u / behind->distances[i]);
        aa += w * a * a;
        ab += w * a;
        bb += w;
        ac += w * a * c;
        bc += w * c;
    }
    const double det = aa * bb - ab * ab;
    *r = det > 0 ? (aa * bc - ab * ac) / det : 0;
    *r = fmax(*r, 0);
    *s = fmax((ac - *r * ab) / aa, 0);
    if (*s == 0)
        *r = bc / bb;
    for (int i = 0; i < FOGS_MOST; i++) {
        double a = -expm1(-u / behind->distances[i]);
        double rest = *s * a + *r - behind->light[i];
        error += behind->weight[i] * rest * rest;
    }
    return error;
}

/* The distance that fits best, with its shares. */
static double fit(const struct behind *behind, double *s, double *r)
{
    double u = FIRST_TRIED * behind->distances[0], best = u, least = INFINITY;
    for (int i = 0; i < N_TRIED; i++, u *= STEP_TRIED) {
        double error = fit_shares(behind, u, s, r);
        if (error < least) {
            least = error;
            best = u;
        }
    }
    double step = STEP_TRIED;
    while ((step = sqrt(step)) > 1.001)
        for (int side = 0; side < 2; side++) {
            double tried = side ? best * step : best / step;
            double error = fit_shares(behind, tried, s, r);
            if (error < least) {
                least = error;
                best = tried;
            }
        }
    fit_shares(behind, best, s, r);
    return best;
}

/* Distance along the ray of what is seen behind a surface at `first`, or that. */
static double distance_through(const struct through *t, size_t i, double first)
{
    struct behind behind = {.distances = t->distances};
    double s, r;
    for (int fog = 0; fog < FOGS_MOST; fog++) {
        const double e = exp(-first / t->distances[fog]), all = fog_share(t, fog, i);
        if (e < LEAST_LIGHT)
            return first;
        behind.light[fog] = (all - (1 - e)) / e;
        /* Half floats: the error is a part of the value. */
        behind.weight[fog] = e * e / fmax(all * all, 1e-12);
    }
    if (behind.light[0] < LEAST_BEHIND)
        return first;
    const double more = fit(&behind, &s, &r);
    const double least = is_mostly_behind(t, i) ? fmax(s, r) : LEAST_SHARE;
    if (s >= least)
        return first + more;
    return r >= least ? INFINITY : first;
}

/* The same from one fog, at least so far. */
static double distance_at_glance(const struct through *t, size_t i, double first)
{
    const double e = exp(-first / t->distances[0]);
    const double behind = (fog_share(t, 0, i) - (1 - e)) / e;
    if (e < LEAST_LIGHT || behind < LEAST_BEHIND)
        return first;
    if (behind >= LEAST_SHARE)
        return first - t->distances[0] * log(fmax(1 - behind, LEAST_LIGHT));
    return is_mostly_behind(t, i) ? first + WEAK_BEHIND * t->distances[0] : first;
}

/* The same behind media; `more`: how far what is there lies behind their surface. Of fogs
 * that are longer than that, the light grows evenly along the way. */
static double distance_held(const struct through *t, size_t i, double first,
                            double more)
{
    const int last = t->is_glance || isinf(more) ? 0 : FOGS_MOST - 1;
    int fog = 0;
    while (fog < last && t->distances[fog] < more)
        fog++;
    const double e = exp(-first / t->distances[fog]);
    const double behind = (fog_share(t, fog, i) - (1 - e)) / e;
    const bool is_thin = behind >= LEAST_HELD * -expm1(-more / t->distances[fog]);
    return e >= LEAST_LIGHT && is_thin ? first + more : first;
}

static double distance_seen(const struct through *t, size_t i, double first)
{
    if (!isfinite(first))
        return first;
    if (is_held(t, i))
        return distance_held(t, i, first,
                             first * ((double)t->bare[i] / (double)t->depth[i] - 1));
    return t->is_glance ? distance_at_glance(t, i, first)
                        : distance_through(t, i, first);
}

/* What is affine in the picture on a plane, mean of 5 places across and 3 along; NAN
 * outside. */
static double affine_at(const struct through *t, int64_t x, int64_t y, bool is_row)
{
    const int64_t apart = t->step / 4 > 0 ? t->step / 4 : 1;
    double sum = 0;
    for (int k = 0; k < 15; k++) {
        const int64_t across = (k % 5 - 2) * apart, along = k / 5 - 1;
        const int64_t px = x + (is_row ? along : across);
        const int64_t py = y + (is_row ? across : along);
        if (px < 0 || py < 0 || px >= t->width || py >= t->height)
            return NAN;
        double z = (double)t->depth[py * t->width + px];
        sum += t->camera->is_orthographic ? z : 1 / z;
    }
    return sum / 15;
}

/* Second difference along a row or column, the least of those before, about and behind a
 * pixel; NAN where all of them reach other things. */
static float bend_along(const struct through *t, int32_t x, int32_t y, bool is_row)
{
    double at[5], least = NAN;
    for (int k = 0; k < 5; k++)
        at[k] = affine_at(t, is_row ? x + (k - 2) * t->step : x,
                          is_row ? y : y + (k - 2) * t->step, is_row);
    for (int k = 0; k < 3; k++) {
        double bend = (at[k] - 2 * at[k + 1] + at[k + 2]) / at[k + 1];
        if (fabs(bend) < MOST_BEND && !(fabs(bend) >= fabs(least)))
            least = bend;
    }
    return (float)least;
}

static void look_at_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct through *t = data;
    for (int32_t y = (int32_t)begin; y < (int32_t)end; y++)
        for (int32_t x = 0; x < t->width; x++) {
            size_t i = (size_t)y * (size_t)t->width + (size_t)x;
            double start[3], direction[3];
            camera_ray(t->camera, x + 0.5, y + 0.5, t->width, t->height, start,
                       direction);
            double planar = t->axis_length / vector_length(direction);
            double first = (double)t->depth[i] / planar;
            double seen = distance_seen(t, i, first);
            t->made[i] = (float)(seen * planar);
            t->bends[i][0] = seen > first ? bend_along(t, x, y, true) : INFINITY;
            t->bends[i][1] = seen > first ? bend_along(t, x, y, false) : INFINITY;
        }
}

/* Is the surface about a pixel flat, in the mean? */
static bool is_flat_about(const struct through *t, int32_t x, int32_t y)
{
    const int64_t apart = t->step / 2 > 0 ? t->step / 2 : 1;
    double sums[2] = {0, 0};
    int n[2] = {0, 0};
    for (int k = 0; k < 81; k++) {
        const int64_t px = x + (k % 9 - 4) * apart, py = y + (k / 9 - 4) * apart;
        if (px < 0 || py < 0 || px >= t->width || py >= t->height)
            continue;
        for (int c = 0; c < 2; c++) {
            double bend = (double)t->bends[py * t->width + px][c];
            sums[c] += isfinite(bend) ? bend : 0;
            n[c] += isfinite(bend);
        }
    }
    return n[0] > 0 && n[1] > 0 && fabs(sums[0]) < FLAT_BEND * n[0] &&
           fabs(sums[1]) < FLAT_BEND * n[1];
}

static void choose_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct through *t = data;
    int64_t n_through = 0;
    for (int32_t y = (int32_t)begin; y < (int32_t)end; y++)
        for (int32_t x = 0; x < t->width; x++) {
            size_t i = (size_t)y * (size_t)t->width + (size_t)x;
            if (!isinf(t->bends[i][0]) && (is_held(t, i) || is_flat_about(t, x, y)))
                n_through++;
            else
                t->made[i] = t->depth[i];
        }
    t->n_through += n_through;
}

static bool read_own(struct povray_scene *scene, const struct fog_runs *runs,
                     const struct povray_passes *size, struct through *t,
                     struct povray_error *error)
{
    return !runs->own.folder || (scene_read(scene, &runs->own, &t->own, error) &&
                                 scene_same_size(scene, size, &t->own, error));
}

/* The depth without the things that hold media. A glance goes without it where its copy of
 * the scene fails. */
static bool render_bare(struct povray_scene *scene, const struct shot *shot,
                        enum rewrite_mode mode, struct through *t,
                        struct povray_error *error)
{
    struct povray_error said = {.message = ""};
    struct povray_passes bare = {.width = t->width, .height = t->height};
    if (!scene->sources.holds_media || mode != REWRITE_PINHOLE)
        return true;
    const bool is_good = fogs_repeat(scene, shot, REWRITE_BARE, false, &bare, &said);
    if (is_good)
        t->bare = bare.depth;
    else
        free(bare.depth);
    if (is_good || (t->is_glance && !said.is_interrupted))
        return true;
    *error = said;
    return false;
}

static bool render(struct povray_scene *scene, const struct shot *shot,
                   enum rewrite_mode mode, const struct povray_passes *passes,
                   struct through *t, struct povray_error *error)
{
    struct fog_runs runs = {.mode = mode, .is_linear = true, .is_through = true};
    struct run *list[FOGS_RUNS];
    bool is_good = fogs_start(scene, shot, &runs, error) &&
                   scene_wait(scene, list, fogs_list(&runs, list, 0), error);
    for (int i = 0; i < FOGS_MOST && is_good; i++)
        is_good = scene_read(scene, &runs.fogged[i], &t->lit[i], error) &&
                  scene_same_size(scene, passes, &t->lit[i], error) &&
                  scene_read(scene, &runs.bases[i], &t->dark[i], error) &&
                  scene_same_size(scene, passes, &t->dark[i], error);
    is_good = is_good && read_own(scene, &runs, passes, t, error) &&
              render_bare(scene, shot, mode, t, error);
    for (int i = 0; i < FOGS_MOST; i++)
        t->distances[i] = runs.distances[i];
    t->light = runs.light;
    fogs_stop(&runs);
    return is_good;
}

static void replace_depth(struct through *t, struct povray_passes *passes,
                          bool is_only_view)
{
    os_parallel(0, t->height, 0, look_at_rows, t);
    os_parallel(0, t->height, 0, choose_rows, t);
    free(passes->depth);
    passes->depth = t->made;
    t->made = NULL;
    if (t->n_through == 0 && is_only_view)
        scene_add_warning(passes, "--through-glass: no flat clear glass or mirror is "
                                  "seen, and the depth stays as it is");
}

/* ---- a glance ------------------------------------------------------------------ */

/* The first surface in the pixels of the small picture; false without memory. */
static bool shrink_depth(struct through *t, const struct povray_passes *passes,
                         float **depth)
{
    const size_t n_pixels = (size_t)t->width * (size_t)t->height;
    *depth = glue_alloc(n_pixels, sizeof(**depth));
    t->made = glue_alloc(n_pixels, sizeof(*t->made));
    t->bends = glue_alloc(n_pixels, sizeof(*t->bends));
    if (!*depth || !t->made || !t->bends)
        return false;
    for (int64_t i = 0; i < (int64_t)n_pixels; i++) {
        const int64_t x = (2 * (i % t->width) + 1) * passes->width / (2 * t->width);
        const int64_t y = (2 * (i / t->width) + 1) * passes->height / (2 * t->height);
        (*depth)[i] = passes->depth[y * passes->width + x];
    }
    t->depth = *depth;
    return true;
}

static bool render_glance(struct povray_scene *scene, const struct shot *shot,
                          enum rewrite_mode mode, struct through *t,
                          struct povray_error *error)
{
    struct fog_runs runs = {
        .mode = mode, .is_linear = true, .is_through = true, .is_glance = true};
    struct run *list[FOGS_RUNS];
    const struct povray_passes size = {.width = t->width, .height = t->height};
    const bool is_good = fogs_start(scene, shot, &runs, error) &&
                         scene_wait(scene, list, fogs_list(&runs, list, 0), error) &&
                         scene_read(scene, &runs.fogged[0], &t->lit[0], error) &&
                         scene_same_size(scene, &size, &t->lit[0], error) &&
                         read_own(scene, &runs, &size, t, error) &&
                         render_bare(scene, shot, mode, t, error);
    t->distances[0] = runs.distances[0];
    t->light = runs.light;
    fogs_stop(&runs);
    return is_good;
}

/* Share of the picture whose blur the depth of the first surface makes wrong; *held is that
 * of things that hold media. */
static double share_wrong(const struct povray_scene *scene, const struct through *t,
                          double *held)
{
    const struct povray_camera *camera = &scene->camera;
    const double radius_px = scene_far_radius_px(scene), focus = camera->focus_distance;
    const int64_t n_pixels = (int64_t)t->width * t->height;
    int64_t n = 0, n_held = 0;
    for (int64_t i = 0; i < n_pixels; i++) {
        const double first = (double)t->depth[i], seen = (double)t->made[i];
        const double wrong = camera->is_orthographic ? (seen - first) / focus
                                                     : focus / first - focus / seen;
        const bool is_wrong =
            seen > first && (radius_px == 0 || wrong * radius_px > GLANCE_BLUR);
        n += is_wrong;
        n_held += is_wrong && is_held(t, (size_t)i);
    }
    *held = (double)n_held / (double)n_pixels;
    return (double)n / (double)n_pixels;
}

static void warn_by_share(const struct povray_scene *scene, const struct through *t,
                          struct povray_passes *passes)
{
    double held;
    const double share = share_wrong(scene, t, &held);
    if (share <= GLANCE_SHARE)
        return;
    if (held > share / 2)
        scene_add_warning(
            passes,
            "%.0f %% of the picture is seen through smoke, clouds or other media, and "
            "is blurred as if it were on the thing that holds them; "
            "--method accumulate is right, --through-glass sooner, where they are thin "
            "and faint: it blurs them by the distance of what is behind",
            100 * share);
    else
        scene_add_warning(
            passes,
            "%.0f %% of the picture is seen through something flat and clear, or "
            "in a flat mirror, and is blurred as if it were on it; "
            "--through-glass blurs it by its own distance%s",
            100 * share,
            scene->sources.has_media
                ? ", but media, too, by that of what is behind; where they are "
                  "dense, --method accumulate is right"
            : scene->sources.has_bumps
                ? ", but not what bumps (normal) scatter; where they are strong, "
                  "--method accumulate is right"
                : "");
}

static bool glance(struct povray_scene *scene, const struct shot *shot,
                   enum rewrite_mode mode, struct povray_passes *passes,
                   struct povray_error *error)
{
    struct shot small = *shot;
    small.is_scenes = false;
    small.width = GLANCE_PX;
    small.height =
        (int32_t)fmax(1, rint(GLANCE_PX * (double)shot->height / shot->width));
    struct through t = {.passes = passes,
                        .gamma = scene->space.gamma,
                        .axis_length = vector_length(scene->camera.direction),
                        .camera = &shot->camera,
                        .width = small.width,
                        .height = small.height,
                        .step = (int32_t)ceil(FLAT_LENGTH * small.width),
                        .is_glance = true};
    float *depth = NULL;
    scene->has_glanced = true;
    const bool is_good = shrink_depth(&t, passes, &depth) &&
                         render_glance(scene, &small, mode, &t, error);
    if (is_good) {
        os_parallel(0, t.height, 0, look_at_rows, &t);
        os_parallel(0, t.height, 0, choose_rows, &t);
        warn_by_share(scene, &t, passes);
    }
    free(t.lit[0].rgba);
    free(t.own.rgba);
    free(t.bare);
    free(t.made);
    free(t.bends);
    free(depth);
    return is_good;
}

bool through_look(struct povray_scene *scene, const struct shot *shot,
                  enum rewrite_mode mode, struct povray_passes *passes,
                  struct povray_error *error)
{
    if (!scene->options.is_through_glass)
        return !scene->options.warns_by_look || !scene->sources.has_clear ||
               scene->has_glanced || glance(scene, shot, mode, passes, error);
    const size_t n_pixels = (size_t)passes->width * (size_t)passes->height;
    struct through t = {.passes = passes,
                        .gamma = scene->space.gamma,
                        .axis_length = vector_length(scene->camera.direction),
                        .camera = &shot->camera,
                        .width = passes->width,
                        .height = passes->height,
                        .step = (int32_t)ceil(FLAT_LENGTH * passes->width),
                        .depth = passes->depth,
                        .made = glue_alloc(n_pixels, sizeof(float)),
                        .bends = glue_alloc(n_pixels, sizeof(*t.bends))};
    bool is_good = t.made && t.bends && render(scene, shot, mode, passes, &t, error);
    if (is_good)
        replace_depth(&t, passes, shot->view < 0);
    for (int i = 0; i < FOGS_MOST; i++) {
        free(t.lit[i].rgba);
        free(t.dark[i].rgba);
    }
    free(t.own.rgba);
    free(t.bare);
    free(t.made);
    free(t.bends);
    return is_good;
}
