/* SPDX-License-Identifier: Apache-2.0 */
#include "filter/seen_way.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "filter/filter_private.h"
#include "filter/seen_light.h"
#include "sources/planar_means.h"
#include "sources/source.h"

static const char denoising_normal[] = "Denoising Normal";
static const float HALF = 0.5f; /* of a pixel's samples */

const char *seen_find_way(const struct source *source)
{
    int n;
    const struct image_channel_info *all = image_channels(source->colour, &n);
    const int i =
        seen_find_channel(source, DENOISING_LAYER, strlen(DENOISING_LAYER), 'Z', -1);
    return i >= 0 ? all[i].name : NULL;
}

int seen_make_planar(const struct run *run, const char *option, bool is_way,
                     const float *depth, float *planar)
{
    struct rf_params params = run->params;
    struct rf_filter *filter = NULL;
    struct rf_error error;
    const int width = run->source.width, height = run->source.height;
    const size_t n = (size_t)width * (size_t)height;
    if (is_way) {
        const bool has_unit =
            params.depth == RF_DEPTH_PLANAR || params.depth == RF_DEPTH_RADIAL;
        params.depth = RF_DEPTH_RADIAL;
        params.depth_scale = has_unit ? params.depth_scale : 1;
        params.depth_offset = 0;
    }
    /* 0: nothing is seen so. */
    for (size_t i = 0; i < n; i++)
        planar[i] = depth[i] > 0 ? depth[i] : 0;
    bool has_some = !is_way; /* not in a frame of nothing but sky */
    for (size_t i = 0; i < n && !has_some; i++)
        has_some = depth[i] > 0;
    const struct rf_image image = rf_image_packed(planar, width, height, 1);
    rf_result result =
        rf_filter_create(&filter, run->context, &params, width, height, &error);
    if (result == RF_OK && has_some)
        result = rf_filter_planar_depth(filter, &image, &image, &error);
    rf_filter_destroy(filter);
    for (size_t i = 0; i < n; i++)
        if (!(depth[i] > 0))
            planar[i] = NAN;
    return result == RF_OK
               ? APP_DONE
               : app_fail(run->error, APP_FAILED, "--%s: %s", option, error.message);
}

static float sum_of(const float *rgb)
{
    return rgb[0] + rgb[1] + rgb[2];
}

/* Squares of the lengths of Cycles' Denoising Normal; *has_some: are there any? Room for
 * three floats per pixel. */
static int read_normals(const struct run *run, const struct source *source,
                        float *normals, bool *has_some)
{
    const size_t n = (size_t)source->width * (size_t)source->height;
    int channels[3];
    *has_some = true;
    for (int c = 0; c < 3; c++) {
        channels[c] = seen_find_channel(source, denoising_normal,
                                        strlen(denoising_normal), "XYZ"[c], -1);
        *has_some &= channels[c] >= 0;
    }
    if (!*has_some)
        return APP_DONE;
    if (!image_read(source->colour, channels, 3, normals, run->n_threads, run->error))
        return app_code_of(run->error);
    for (size_t i = 0; i < n; i++) {
        const float *at = normals + 3 * i;
        normals[i] = at[0] * at[0] + at[1] * at[1] + at[2] * at[2];
    }
    return APP_DONE;
}

/*
 * Cycles counts ways from the near clip on, which the files do not name, and nothing for
 * rays that hit nothing (before 5.2): where most of the light is that of the mirror, the
 * way ends on it, and no rough surface gave a normal, sky is seen in it.
 */
int seen_complete_way(const struct run *run, const struct source *source,
                      const struct rf_view *view, const char *option,
                      const float *light, float *way, bool *fits)
{
    static const float FITS = 1.02f; /* as of ways that go on, take_ways() */
    const int width = source->width, height = source->height;
    const size_t n = (size_t)width * (size_t)height;
    float *depth = app_memory(n, 4 * sizeof(float), run->error);
    struct rf_error error;
    if (!depth)
        return app_code_of(run->error);
    const struct rf_image planar = rf_image_packed(depth, width, height, 1);
    int code = APP_DONE;
    bool has_normals = false;
    float *normals = depth + n;
    if (rf_filter_planar_depth(run->filter, &view->depth, &planar, &error) != RF_OK)
        code = app_fail(run->error, APP_FAILED, "--%s: %s", option, error.message);
    const float near_clip =
        code == APP_DONE ? planar_means_near_clip(depth, way, n, normals) : 0;
    *fits = !isnan(near_clip);
    if (code == APP_DONE && light)
        code = read_normals(run, source, normals, &has_normals);
    const struct rf_image *colour = &view->colour;
    for (size_t i = 0; i < n; i++) {
        const float *rgb = (const float *)colour->data + i * (size_t)colour->channels;
        way[i] += *fits ? near_clip : 0;
        if (has_normals && normals[i] < HALF * HALF && way[i] < FITS * depth[i] &&
            sum_of(light + 3 * i) > HALF * sum_of(rgb))
            way[i] = INFINITY;
    }
    free(depth);
    return code;
}

/* ---- what nobody asked for ------------------------------------------------------- */

/* Of the picture; as of POV-Ray's scenes, povray_glue/through.c. */
static const double WORTH_A_WARNING = 0.05;
enum { N_LOOKED_AT = 400 }; /* px of the shorter side */

/* The light of mirrors and glass together; *light NULL: the file has none. */
static int read_lights(const struct run *run, float **light)
{
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    *light = NULL;
    for (int kind = 0; kind < SEEN_KINDS; kind++) {
        if (!seen_has_light(run, &run->source, (enum seen_kind)kind))
            continue;
        float *more = seen_read_light(run, &run->source, (enum seen_kind)kind);
        if (!more)
            return app_code_of(run->error);
        for (size_t i = 0; i < 3 * n && *light; i++)
            more[i] += (*light)[i];
        free(*light);
        *light = more;
    }
    return APP_DONE;
}

/* Which share of the pixels is seen behind its surface by more than a pixel of radius? */
static double share_behind(const struct run *run, const struct rf_view *view,
                           const float *way, float *surface)
{
    const struct rf_lens *lens = rf_filter_lens(run->filter);
    const size_t n = (size_t)view->depth.width * (size_t)view->depth.height;
    const struct rf_image radii =
        rf_image_packed(surface, view->depth.width, view->depth.height, 1);
    struct rf_error ignored;
    size_t n_behind = 0;
    if (rf_filter_coc(run->filter, &view->depth, &radii, &ignored) != RF_OK)
        return 0;
    for (size_t i = 0; i < n; i++)
        n_behind += way[i] > 0 &&
                    rf_lens_radius_px(lens, (double)way[i]) > (double)surface[i] + 1;
    return (double)n_behind / (double)n;
}

/* Every step-th pixel of every step-th row. */
static void thin_out(const float *from, int n_channels, int width, int step,
                     const struct rf_image *to)
{
    const size_t n = (size_t)to->channels, all = (size_t)n_channels;
    float *at = to->data;
    for (int y = 0; y < to->height; y++)
        for (int x = 0; x < to->width; x++, at += n)
            memcpy(at,
                   from + all * (size_t)step * ((size_t)y * (size_t)width + (size_t)x),
                   n * sizeof(float));
}

/*
 * The same of flat surfaces, which the options are for, of a smaller picture: to look at
 * all of 1920 x 1080 takes four times as long as to filter it. `room` has five floats
 * for each of its pixels.
 */
static double share_flat(const struct run *run, const float *light, const float *way,
                         int step, float *room)
{
    struct rf_params params = run->params;
    struct rf_filter *filter = NULL;
    struct rf_error ignored;
    const int n_channels = light ? 3 : run->source.n_channels, full = run->source.width;
    const int width = full / step, height = run->source.height / step;
    const size_t n = (size_t)width * (size_t)height;
    struct rf_view view = {.size = sizeof(view)};
    const struct rf_image seen = rf_image_packed(room, width, height, 3);
    const struct rf_image behind = rf_image_packed(room + 3 * n, width, height, 1);
    view.colour = seen;
    view.depth = rf_image_packed(room + 4 * n, width, height, 1);
    thin_out(light ? light : run->colour, n_channels, full, step, &seen);
    thin_out(way, 1, full, step, &behind);
    thin_out(run->depth, 1, full, step, &view.depth);
    params.focal_length_px /= (float)step;
    size_t n_behind = 0;
    if (rf_filter_create(&filter, run->context, &params, width, height, &ignored) ==
            RF_OK &&
        rf_filter_seen_way(filter, &view, &seen, &behind, &behind, &ignored) == RF_OK)
        for (size_t i = 0; i < n; i++)
            n_behind += room[3 * n + i] > 0;
    rf_filter_destroy(filter);
    return (double)n_behind / (double)n;
}

/* What the rays show that the depth does not have, with the light of mirrors or without
 * it. `room` has two floats per pixel. */
static int find_share(const struct run *run, const float *rays, const float *light,
                      float *room, double *share)
{
    const int width = run->source.width, height = run->source.height;
    const size_t n = (size_t)width * (size_t)height;
    const struct rf_view view = {
        .size = sizeof(view),
        .colour = rf_image_packed(run->colour, width, height, run->source.n_channels),
        .depth = rf_image_packed(run->depth, width, height, 1)};
    float *way = room, *surface = room + n;
    bool fits = false;
    *share = 0;
    int code = seen_make_planar(run, "reflection-depth", true, rays, way);
    if (code == APP_DONE)
        code = seen_complete_way(run, &run->source, &view, "reflection-depth", light,
                                 way, &fits);
    if (code != APP_DONE || !fits ||
        share_behind(run, &view, way, surface) <= WORTH_A_WARNING)
        return code;
    const int step = 1 + (width > height ? height : width) / N_LOOKED_AT;
    float *small = app_memory(n / (size_t)(step * step), 5 * sizeof(float), run->error);
    if (!small)
        return APP_NO_MEMORY;
    *share = share_flat(run, light, way, step, small);
    free(small);
    return APP_DONE;
}

/* Has so much of the picture a depth and no normal, as sky in mirrors? Then all of the
 * light is worth reading. */
static int may_mirror_sky(const struct run *run, bool *may)
{
    static const float SKY = 1e9f; /* Blender's depth of it is 1e10 */
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    float *normals = app_memory(n, 3 * sizeof(float), run->error);
    size_t n_bare = 0;
    if (!normals)
        return APP_NO_MEMORY;
    const int code = read_normals(run, &run->source, normals, may);
    for (size_t i = 0; i < n && *may; i++)
        n_bare += run->depth[i] < SKY && normals[i] < HALF * HALF;
    *may = (double)n_bare > WORTH_A_WARNING * (double)n;
    free(normals);
    return code;
}

static int say_share(const struct run *run, double share, bool has_light)
{
    return app_warn(
        run->tool->host, run->error,
        "%s: %.0f %% of the picture is seen in flat mirrors or through glass, and "
        "blurred by the distance of these; %s--reflection-depth denoising and "
        "--transmission-depth denoising give it its own",
        image_path(run->source.colour), 100 * share,
        has_light ? ""
                  : "save Passes > Light > Glossy and Transmission, each with Direct, "
                    "Indirect and Color, too: then ");
}

int seen_warn(struct run *run, const float *rays)
{
    const struct app_host *host = run->tool->host;
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    if (!host || !host->warn || run->tool->temporal || run->source.is_grey)
        return APP_DONE;
    const bool has_light = seen_has_light(run, &run->source, SEEN_REFLECTION) ||
                           seen_has_light(run, &run->source, SEEN_TRANSMISSION);
    float *light = NULL, *room = app_memory(n, 2 * sizeof(float), run->error);
    bool may_be_sky = false;
    double share = 0;
    int code = room ? find_share(run, rays, NULL, room, &share) : APP_NO_MEMORY;
    if (code == APP_DONE && has_light && share <= WORTH_A_WARNING)
        code = may_mirror_sky(run, &may_be_sky);
    if (code == APP_DONE && may_be_sky)
        code = read_lights(run, &light);
    if (code == APP_DONE && may_be_sky)
        code = find_share(run, rays, light, room, &share);
    free(room);
    free(light);
    return code == APP_DONE && share > WORTH_A_WARNING
               ? say_share(run, share, has_light)
               : code;
}
