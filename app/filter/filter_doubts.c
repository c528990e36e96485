/* SPDX-License-Identifier: Apache-2.0 */
/* What a user is told of depth and alpha that can hardly be what they are taken for. */
#include "filter/filter_private.h"

#include <math.h>
#include <stdio.h>

#include "common/report.h"
#include "sources/picture_doubts.h"

/* Slanted places that are enough: fewer are one thing, which may be curved or cut by
 * chance. The references but foliage's leaves have 8000 to 28000. */
enum { FEWEST_SLANTED = 300 };

/* Of slanted places, those that speak for another kind, and how many times more they are
 * than those against it. Another kind of the references has 45 to 89 % and none against;
 * of right depth mirrors has 19 %, but as many against. */
static const double KIND_SHARE = 0.3, KIND_TIMES = 10;

/* From that share of the far end on nothing was hit, rounding left aside. */
static const double NEARLY_FAR = 0.9999;

/* Of the hits; the rest may be specks. */
static const double NEARLY_ALL = 0.99;

void filter_begin_doubts(struct run *run)
{
    const struct app_host *host = run->tool->host;
    const struct source *source = &run->source;
    int n;
    if (!host || !host->warn || !rf_method_find(run->params.method)->needs_depth)
        return;
    const bool is_half =
        source->z >= 0 &&
        image_channels(source->depth, &n)[source->z].type == IMAGE_SAMPLE_HALF;
    run->doubts = doubts_create(&run->params, rf_filter_lens(run->filter),
                                source->width, source->height, is_half);
}

void filter_count_doubts(struct run *run, const struct doubts_rows *rows,
                         const float *colour)
{
    const size_t width = (size_t)run->source.width;
    if (!run->doubts)
        return;
    doubts_add(run->doubts, rows);
    for (int32_t y = 0; run->source.n_channels == 4 && y < rows->n; y++)
        alpha_tally_add(&run->alpha, colour + 4 * width * (size_t)y, width);
}

/* Of a picture in memory. */
static void count(struct run *run)
{
    filter_begin_doubts(run);
    filter_count_doubts(run, &(struct doubts_rows){run->depth, 0, run->source.height},
                        run->colour);
}

/* ---- unit ------------------------------------------------------------------------- */

/* Units that scenes are built in, how many of them are a metre. */
static const struct {
    const char *name, *to_metres, *from_metres;
    double per_metre;
} units[] = {{"centimetres", "0.01", "100", 100},
             {"millimetres", "0.001", "1000", 1000},
             {"inches", "0.0254", "39.37", 39.37}};

static bool lies_within(const struct doubts_range *range, double distance)
{
    return distance >= range->nearest && distance <= range->farthest;
}

/*
 * Nothing is near the focus, but another unit would bring it among what is seen. Without
 * that second condition a wall or a skyline that is blurred on purpose would be warned of.
 */
static int warn_unit(const struct run *run)
{
    const struct rf_lens *lens = rf_filter_lens(run->filter);
    const double focus = lens->focus_distance;
    struct doubts_range range;
    doubts_find_range(run->doubts, &range);
    const double most = NEARLY_ALL * (double)range.n_hits;
    const bool is_far = (double)range.n_far > most,
               is_near = (double)range.n_near > most;
    const bool is_distance =
        run->params.depth == RF_DEPTH_PLANAR || run->params.depth == RF_DEPTH_RADIAL;
    if (!is_distance || !(is_far || is_near) ||
        settings_origin(run->settings, "focus-distance") == ORIGIN_DEFAULT ||
        settings_origin(run->settings, "depth-scale") == ORIGIN_COMMAND_LINE)
        return APP_DONE;
    for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); i++) {
        const double per_metre = units[i].per_metre;
        if (!lies_within(&range, is_far ? focus * per_metre : focus / per_metre))
            continue;
        if (run->tool->scene)
            return app_warn(
                run->tool->host, run->error,
                "%s: nothing is in focus: what is seen is %.3g to %.3g away, the focus "
                "%.3g; give what is to be sharp by --focal-point or --focus-distance",
                run->tool->scene, range.nearest, range.farthest, focus);
        return app_warn(
            run->tool->host, run->error,
            "%s: nothing is in focus: the depth is %.3g to %.3g, the focus distance "
            "%.3g; if %s is in %s and %s in metres, say --depth-scale %s, else another "
            "--focus-distance (--depth-scale %g: it is meant so)",
            image_path(run->source.depth), range.nearest, range.farthest, focus,
            is_far ? "the depth" : "the focus", units[i].name,
            is_far ? "the focus" : "the depth",
            is_far ? units[i].to_metres : units[i].from_metres,
            run->params.depth_scale);
    }
    return APP_DONE;
}

/* ---- kind ------------------------------------------------------------------------- */

/* The kind that flat things speak for; `taken` where they do not speak for another. */
static enum doubts_kind spoken_for(const struct doubts_kinds *kinds,
                                   enum doubts_kind taken)
{
    size_t n_all = 0;
    enum doubts_kind most = taken;
    for (int k = 0; k < DOUBTS_N_KINDS; k++) {
        n_all += kinds->n_alone[k];
        most = kinds->n_alone[k] > kinds->n_alone[most] ? (enum doubts_kind)k : most;
    }
    const double n = (double)kinds->n_alone[most];
    return kinds->n >= FEWEST_SLANTED && n >= KIND_SHARE * (double)kinds->n &&
                   n >= KIND_TIMES * (double)(n_all - kinds->n_alone[most])
               ? most
               : taken;
}

/* Of depth that nobody named a kind of. */
static int warn_distances(const struct run *run, enum doubts_kind kind)
{
    const char *path = image_path(run->source.depth);
    if (kind == DOUBTS_RADIAL)
        return app_warn(
            run->tool->host, run->error,
            "%s: the depth is taken for distances along the axis, but flat "
            "things are flat only if it is those along the ray; say --depth "
            "radial, or --depth planar if they are along the axis",
            path);
    return app_warn(
        run->tool->host, run->error,
        "%s: the depth is taken for distances of a perspective, but "
        "flat things are flat only if it is 1 / distance or a z-buffer; say --depth "
        "inverse, --depth buffer with --depth-near and --depth-far (0 is near, 1 is "
        "far), --depth buffer-reversed-infinite with --depth-near if "
        "it is a z-buffer of a game, --projection orthographic if the "
        "camera is, or --depth planar if all is right",
        path);
}

/* Of depth between a near and a far end. */
static int warn_ends(const struct run *run, enum doubts_kind kind)
{
    const struct rf_params *p = &run->params;
    const char *path = image_path(run->source.depth);
    const bool is_swapped = kind == DOUBTS_SWAPPED || kind == DOUBTS_SWAPPED_RADIAL;
    const double deep = p->depth_far - p->depth_near;
    const double scale = is_swapped ? -p->depth_scale : p->depth_scale;
    const double offset = is_swapped ? 1 - p->depth_offset : p->depth_offset;
    const char *what = is_swapped ? " and near is at 1, far at 0" : "";
    if (kind == DOUBTS_INVERSE)
        return app_warn(run->tool->host, run->error,
                        "%s: flat things are flat only if the depth is a z-buffer or 1 "
                        "/ distance; say --depth buffer or --depth inverse in place of "
                        "normalised, or --projection orthographic if the camera is",
                        path);
    if (kind == DOUBTS_PLANAR || kind == DOUBTS_SWAPPED)
        return app_warn(run->tool->host, run->error,
                        "%s: flat things are flat only if the depth grows evenly along "
                        "the axis%s; say --depth normalised --depth-scale %.9g "
                        "--depth-offset %.9g",
                        path, what, scale, offset);
    return app_warn(run->tool->host, run->error,
                    "%s: flat things are flat only if the depth grows evenly along the "
                    "ray%s; say --depth radial --depth-scale %.9g --depth-offset %.9g "
                    "--depth-infinity %.6g",
                    path, what, deep * scale, p->depth_near + deep * offset,
                    NEARLY_FAR * p->depth_far);
}

/* The kind that flat things should be flat with, as depth is taken. */
static enum doubts_kind taken_kind(const struct rf_params *params)
{
    return params->depth == RF_DEPTH_BUFFER || params->depth == RF_DEPTH_BUFFER_REVERSED
               ? DOUBTS_INVERSE
               : DOUBTS_PLANAR;
}

/* Distances along the axis that make flat things bent, and other kinds that do not. */
static int warn_kind(const struct run *run)
{
    const int32_t depth = run->params.depth;
    const bool is_open = settings_origin(run->settings, "depth") == ORIGIN_DEFAULT;
    const bool has_ends = depth == RF_DEPTH_NORMALISED || depth == RF_DEPTH_BUFFER ||
                          depth == RF_DEPTH_BUFFER_REVERSED;
    const enum doubts_kind taken = taken_kind(&run->params);
    struct doubts_kinds kinds[DOUBTS_N_STEPS];
    doubts_find_kinds(run->doubts, kinds);
    enum doubts_kind kind = taken;
    for (int i = 0; i < DOUBTS_N_STEPS && kind == taken; i++)
        kind = spoken_for(&kinds[i], taken);
    if (run->tool->scene || kind == taken || !filter_needs_depth(run) ||
        !(is_open || has_ends))
        return APP_DONE;
    return has_ends ? warn_ends(run, kind) : warn_distances(run, kind);
}

/* ---- veils ------------------------------------------------------------------------ */

/* Every so many pixels along both axes are looked at. */
enum { VEIL_STEP = 4 };

/* Alphas of what is seen, and lets see through it; of the picture, what is worth a word. */
static const float LEAST_VEIL = 0.1f, MOST_VEIL = 0.99f;
static const double VEIL_SHARE = 0.01;

static bool has_depth(const struct run *run, int32_t x, int32_t y)
{
    const int32_t width = run->source.width, height = run->source.height;
    x = x < 0 ? 0 : x < width ? x : width - 1;
    y = y < 0 ? 0 : y < height ? y : height - 1;
    const float z = run->depth[(size_t)y * (size_t)width + (size_t)x];
    const struct rf_params *p = &run->params;
    const double v = (double)z * p->depth_scale + p->depth_offset;
    return v > 0 && v < p->depth_infinity && (double)z < p->depth_infinity;
}

/* Further from a surface than --film-depth edges looks for one (core/input/film.c). */
static int32_t veil_px(const struct run *run)
{
    const int32_t width = run->source.width, height = run->source.height;
    const int32_t reach = (width > height ? width : height) / 30;
    return (reach < 8 ? 8 : reach < 64 ? reach : 64) + 1;
}

static bool is_veil(const struct run *run, int32_t x, int32_t y)
{
    const int32_t far = veil_px(run);
    const size_t i = (size_t)y * (size_t)run->source.width + (size_t)x;
    const float alpha = run->colour[4 * i + 3];
    if (alpha < LEAST_VEIL || alpha > MOST_VEIL)
        return false;
    for (int32_t k = -far; k <= far; k += far)
        for (int32_t l = -far; l <= far; l += far)
            if (has_depth(run, x + l, y + k))
                return false;
    return true;
}

/* What lets see through it, has no depth, and no surface near that it could be part of. */
static int warn_veils(const struct run *run)
{
    const bool is_distance = run->params.depth == RF_DEPTH_PLANAR ||
                             run->params.depth == RF_DEPTH_RADIAL ||
                             run->params.depth == RF_DEPTH_INVERSE;
    if (run->source.n_channels != 4 || !is_distance ||
        run->params.film_depth == RF_FILM_DEPTH_KEEP)
        return APP_DONE;
    size_t n = 0, n_veils = 0;
    for (int32_t y = 0; y < run->source.height; y += VEIL_STEP)
        for (int32_t x = 0; x < run->source.width; x += VEIL_STEP, n++)
            n_veils += is_veil(run, x, y);
    const double share = (double)n_veils / (double)n;
    if (share < VEIL_SHARE)
        return APP_DONE;
    return app_warn(run->tool->host, run->error,
                    "%s: %.0f %% of the picture is partly transparent and has no "
                    "depth, such as smoke "
                    "or a veil; it is blurred as if infinitely far: render it as a "
                    "layer of its own "
                    "with a depth (--film-depth keep: it is far)",
                    run->tool->scene ? run->tool->scene
                                     : image_path(run->source.colour),
                    100 * share);
}

/* ---- alpha ------------------------------------------------------------------------ */

static int warn_straight(const struct run *run)
{
    char way_out[700];
    if (run->tool->scene || run->is_deep || !alpha_is_straight(&run->alpha))
        return APP_DONE;
    explain_straight(&run->source, way_out, sizeof(way_out));
    return app_warn(run->tool->host, run->error, "%s: %s%s",
                    image_path(run->source.colour), alpha_straight_words, way_out);
}

/* ---- place ------------------------------------------------------------------------ */

/* A depth that was enlarged lies a part of a pixel beside its picture, too. */
static int warn_place(const struct run *run)
{
    const char *path = image_path(run->source.depth);
    int32_t width, height;
    char text[900];
    if (run->tool->scene || run->is_deep || !filter_needs_depth(run))
        return APP_DONE;
    if (doubts_find_size(run->doubts, &width, &height))
        explain_size(width, height, text, sizeof(text));
    else if (!place_is_doubtful(&run->fit, &run->source, text, sizeof(text)))
        return APP_DONE;
    return app_warn(run->tool->host, run->error, "%s: %s", path, text);
}

int filter_warn_doubts(struct run *run)
{
    int code = APP_DONE;
    if (!run->windows) {
        count(run);
        code = run->doubts ? warn_veils(run) : APP_DONE;
    }
    if (code == APP_DONE && run->doubts)
        code = warn_place(run);
    if (code == APP_DONE)
        code = filter_warn_views(run);
    if (code == APP_DONE && run->doubts)
        code = warn_straight(run);
    if (code == APP_DONE && run->doubts)
        code = warn_unit(run);
    if (code == APP_DONE && run->doubts)
        code = warn_kind(run);
    doubts_free(run->doubts);
    run->doubts = NULL;
    return code;
}
