/* SPDX-License-Identifier: Apache-2.0 */
/* What a user is told of several views that are hardly of one lens, frame and exposure.
 */
#include "filter/filter_private.h"

#include <stdlib.h>

#include "common/report.h"
#include "sources/primaries.h"
#include "sources/views.h"
#include "sources/views_fit.h"
#include "sources/views_light.h"

/* Of a picture in windows, so many rows in its middle, as far as a part of the memory
 * that is allowed suffices; edges of things in them tell as well as those of all. */
enum { MOST_ROWS = 512, LEAST_ROWS = 64, PART_OF_MEMORY = 4 };

/* What one view's depth is at least of the others' where its unit is another; that of
 * right views is within 1.15 (views_light.c) in twelve sets. An inch is 2.54 cm. */
static const double UNIT_TIMES = 1.5;

/* Rows of all views. */
struct band {
    int32_t first, n;
    int n_views;
    float *colour;                      /* of one view */
    struct rf_view views[RF_MAX_VIEWS]; /* their depth alone */
    struct views_light *light;
};

static void free_band(struct band *band)
{
    for (int i = 0; i < band->n_views; i++)
        free(band->views[i].depth.data);
    free(band->colour);
    views_light_free(band->light);
}

static struct band middle_of(const struct run *run)
{
    const int32_t width = run->source.width, height = run->source.height;
    /* Depth, and what is made of it, of all; colour of one. */
    const size_t row_bytes =
        (size_t)width * sizeof(float) *
        (2 * (size_t)run->views.n + (size_t)run->source.n_channels);
    const size_t most =
        ((size_t)run->tool->max_memory_mib << 20) / PART_OF_MEMORY / row_bytes;
    int32_t n = most < MOST_ROWS ? (int32_t)most : MOST_ROWS;
    n = n > LEAST_ROWS ? n : LEAST_ROWS;
    n = n < height ? n : height;
    return (struct band){.first = (height - n) / 2, .n = n, .n_views = run->views.n};
}

static bool read_view(const struct run *run, int view, struct band *band)
{
    const struct source *source = &run->views.sources[view];
    const int channels[4] = {source->layer.r, source->layer.g, source->layer.b,
                             source->layer.a};
    const struct image_rows rows = {band->first, band->n};
    const size_t n = (size_t)source->width * (size_t)band->n;
    float *depth = NULL;
    if (rf_method_find(run->params.method)->needs_depth) {
        depth = app_memory(n, sizeof(float), run->error);
        if (!depth)
            return false;
        band->views[view] = run->views.views[view];
        band->views[view].depth = rf_image_packed(depth, source->width, band->n, 1);
        if (!image_read_rows(source->depth, &source->z, 1, rows, depth, run->n_threads,
                             run->error))
            return false;
        rf_depth_undo_mist(depth, n, (enum rf_mist)run->tool->mist_falloff);
    }
    if (!image_read_rows(source->colour, channels, source->n_channels, rows,
                         band->colour, run->n_threads, run->error))
        return false;
    const struct rf_image colour =
        rf_image_packed(band->colour, source->width, band->n, source->n_channels);
    views_light_add(band->light, view, &colour, band->first);
    return true;
}

/* Of views that are read strip by strip, from their files. */
static bool read_band(const struct run *run, struct band *band)
{
    *band = middle_of(run);
    band->light =
        views_light_create(band->n_views, run->source.width, run->source.height);
    band->colour =
        app_memory((size_t)run->source.width * (size_t)band->n,
                   (size_t)run->source.n_channels * sizeof(float), run->error);
    bool is_read = band->light && band->colour;
    for (int i = 0; i < band->n_views && is_read; i++)
        is_read = read_view(run, i, band);
    return is_read;
}

static int warn_fit(const struct run *run, const struct rf_view *views, int32_t first)
{
    struct views_fit found;
    char text[500];
    const struct views_fit_given given = {views,
                                          run->views.n,
                                          first,
                                          &run->params,
                                          rf_filter_lens(run->filter),
                                          &views_in_headers};
    if (!views_fit_is_wrong(&given, &found))
        return APP_DONE;
    views_fit_explain(&found, &views_in_headers, text, sizeof(text));
    const int view = found.wrong_view > 0 ? found.wrong_view : 0;
    return app_warn(run->tool->host, run->error, "%s: %s",
                    image_path(run->views.sources[view].colour), text);
}

static int warn_light(const struct run *run, const struct views_light *light)
{
    struct views_light_found found;
    char text[300];
    if (!views_light_differs(light, &found))
        return APP_DONE;
    views_light_explain(&found, text, sizeof(text));
    return app_warn(run->tool->host, run->error, "%s: %s",
                    image_path(run->views.sources[found.view].colour), text);
}

/* Depth of another unit in one view; `is_told`: there is. */
static int warn_unit(const struct run *run, const struct rf_view *views, int32_t first,
                     bool *is_told)
{
    struct views_light_found found;
    char text[300];
    struct views_light *depth =
        views_light_create(run->views.n, run->source.width, run->source.height);
    *is_told = false;
    if (!depth)
        return app_fail(run->error, APP_NO_MEMORY, "out of memory for views");
    for (int i = 0; i < run->views.n; i++)
        views_light_add(depth, i, &views[i].depth, first);
    *is_told = views_light_differs(depth, &found) &&
               (found.times[0] > UNIT_TIMES ||
                (found.times[0] > 0 && found.times[0] < 1 / UNIT_TIMES));
    views_light_free(depth);
    if (!*is_told)
        return APP_DONE;
    views_light_explain_depth(&found, text, sizeof(text));
    return app_warn(run->tool->host, run->error, "%s: %s",
                    image_path(run->views.sources[found.view].depth), text);
}

/* The first view whose numbers are other colours than those of the first. */
static int warn_primaries(const struct run *run)
{
    const struct source *sources = run->views.sources;
    struct primaries first, own;
    int i = 0;
    primaries_read(sources[0].colour, sources[0].part, &first);
    do {
        i++;
        if (i == run->views.n)
            return APP_DONE;
        primaries_read(sources[i].colour, sources[i].part, &own);
    } while (!primaries_differ(&own, &first));
    return primaries_warn(run->tool->host, image_path(sources[i].colour), &own,
                          image_path(sources[0].colour), &first, "they are merged",
                          run->error);
}

static int warn(const struct run *run, const struct views_light *light,
                const struct rf_view *views, int32_t first)
{
    const bool has_depth = rf_method_find(run->params.method)->needs_depth;
    bool is_told = false;
    int code = warn_primaries(run);
    if (code == APP_DONE)
        code = warn_light(run, light);
    if (code == APP_DONE && has_depth)
        code = warn_unit(run, views, first, &is_told);
    return code == APP_DONE && has_depth && !is_told ? warn_fit(run, views, first)
                                                     : code;
}

int filter_warn_views(const struct run *run)
{
    const struct app_host *host = run->tool->host;
    if (run->tool->scene || !run->has_views || run->is_deep || !host || !host->warn)
        return APP_DONE;
    if (run->windows) {
        struct band band;
        const int code = read_band(run, &band)
                             ? warn(run, band.light, band.views, band.first)
                             : app_code_of(run->error);
        free_band(&band);
        return code;
    }
    struct views_light *light =
        views_light_create(run->views.n, run->source.width, run->source.height);
    for (int i = 0; light && i < run->views.n; i++)
        views_light_add(light, i, &run->views.views[i].colour, 0);
    const int code =
        light ? warn(run, light, run->views.views, 0)
              : app_fail(run->error, APP_NO_MEMORY, "out of memory for views");
    views_light_free(light);
    return code;
}
