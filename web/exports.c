/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What JavaScript calls. Text is UTF-8 with a final zero in this module's memory; what
 * returns text keeps it until the next call. Numbers that are results: 1 is done, 0
 * failed, and rw_error() says why.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "document.h"
#include "png_rows.h"
#include "sources/picture.h"
#include "threads.h"

#define EXPORT(name) __attribute__((export_name(#name), used)) name

static struct image_error last_error;
static char last_field[48], text[256];

static int note(rf_result result, const struct rf_error *error)
{
    if (result == RF_OK)
        return 1;
    snprintf(last_error.message, sizeof last_error.message, "%s", error->message);
    snprintf(last_field, sizeof last_field, "%s", error->field);
    return 0;
}

const char *EXPORT(rw_error)(void)
{
    return last_error.message;
}

/* The parameter or argument at fault, or "". */
const char *EXPORT(rw_error_field)(void)
{
    return last_field;
}

void *EXPORT(rw_allocate)(size_t n_bytes)
{
    return malloc(n_bytes ? n_bytes : 1);
}

void EXPORT(rw_release)(void *memory)
{
    free(memory);
}

const char *EXPORT(rw_version)(void)
{
    return rf_version();
}

/* ---- parameters ------------------------------------------------------------------ */

struct rf_params *EXPORT(rw_params_new)(void)
{
    struct rf_params *params = malloc(sizeof *params);
    if (params)
        rf_params_init(params);
    return params;
}

int EXPORT(rw_params_set)(struct rf_params *params, const char *name, const char *value)
{
    struct rf_error error = {0};
    return note(rf_params_set(params, name, value, &error), &error);
}

/* NULL: there is no such parameter. */
const char *EXPORT(rw_params_get)(const struct rf_params *params, const char *name)
{
    return rf_params_get(params, name, text, sizeof text) == RF_OK ? text : NULL;
}

/* Why the parameter has no effect while the others are as they are; NULL: it has. */
const char *EXPORT(rw_why_not_read)(const struct rf_params *params, const char *name)
{
    const char *why = NULL;
    return rf_param_is_read(params, name, &why) ? NULL : why ? why : "not read";
}

/* The i-th parameter's key, type, unit, least, greatest, default, group, choices (names
 * with commas), help: fields with tabs between; NULL beyond the last. */
const char *EXPORT(rw_param_row)(int i)
{
    static const char *const types[] = {"float", "int", "bool", "enum"};
    static const char *const groups[] = {"lens", "aperture", "depth", "method",
                                         "highlights"};
    static char row[2048];
    const struct rf_param_info *p = rf_param_at((size_t)i);
    if (!p)
        return NULL;
    size_t used = (size_t)snprintf(
        row, sizeof row, "%s\t%s\t%s\t%.17g\t%.17g\t%.17g\t%s\t", p->key,
        types[p->type], p->unit, p->min, p->max, p->def, groups[p->group]);
    for (int c = 0; c < p->n_choices && used < sizeof row; c++)
        used += (size_t)snprintf(row + used, sizeof row - used, "%s%s", c ? "," : "",
                                 p->choices[c].name);
    if (used < sizeof row)
        snprintf(row + used, sizeof row - used, "\t%s", p->help);
    return row;
}

/* ---- filters --------------------------------------------------------------------- */

struct rf_context *EXPORT(rw_context_new)(int n_threads)
{
    struct rf_context *context = NULL;
    const struct rf_context_params how = threads_params(n_threads);
    struct rf_error error;
    note(rf_context_create(&context, &how, &error), &error);
    return context;
}

struct rf_filter *EXPORT(rw_filter_new)(const struct rf_context *context,
                                        const struct rf_params *params, int width,
                                        int height)
{
    struct rf_filter *filter = NULL;
    struct rf_error error = {0};
    note(rf_filter_create(&filter, context, params, width, height, &error), &error);
    return filter;
}

void EXPORT(rw_filter_free)(struct rf_filter *filter)
{
    rf_filter_destroy(filter);
}

/*
 * n_views views, one after the other: colour of n_channels floats a pixel, depth of
 * one; `places` has three doubles of each, offset on the lens right and up and the
 * distance that the shear keeps fixed, or is NULL for one view. `out` is like one
 * view's colour.
 */
int EXPORT(rw_filter_apply)(const struct rf_filter *filter, int width, int height,
                            int n_channels, int n_views, float *colour, float *depth,
                            const double *places, float *out)
{
    struct rf_view views[RF_MAX_VIEWS] = {0};
    struct rf_error error = {0};
    const size_t n = (size_t)width * (size_t)height;
    if (n_views < 1 || n_views > RF_MAX_VIEWS) {
        snprintf(error.message, sizeof error.message, "%d views: 1 to %d can be merged",
                 n_views, RF_MAX_VIEWS);
        return note(RF_ERROR_ARGUMENT, &error);
    }
    for (int i = 0; i < n_views; i++) {
        views[i] = (struct rf_view){
            .size = sizeof *views,
            .colour = rf_image_packed(colour + (size_t)i * n * (size_t)n_channels,
                                      width, height, n_channels),
            .depth = rf_image_packed(depth + (size_t)i * n, width, height, 1)};
        for (int k = 0; places && k < 2; k++)
            views[i].lens_offset[k] = places[3 * i + k];
        views[i].shear_distance = places ? places[3 * i + 2] : 0;
    }
    const struct rf_image image = rf_image_packed(out, width, height, n_channels);
    return note(rf_filter_process(filter, views, n_views, &image, NULL, &error),
                &error);
}

/* Signed radii of the circles of confusion, px. */
int EXPORT(rw_filter_coc)(const struct rf_filter *filter, int width, int height,
                          float *depth, float *out)
{
    struct rf_error error = {0};
    const struct rf_image in = rf_image_packed(depth, width, height, 1);
    const struct rf_image image = rf_image_packed(out, width, height, 1);
    return note(rf_filter_coc(filter, &in, &image, &error), &error);
}

/* ---- documents ------------------------------------------------------------------- */

/* Opens EXR files, whose names lie one after the other, each with its zero. */
struct document *EXPORT(rw_open)(char *names, int n_names, int n_threads)
{
    char *paths[RF_MAX_VIEWS];
    if (n_names > RF_MAX_VIEWS) {
        set_error(&last_error, "%d files: up to %d views can be opened", n_names,
                  RF_MAX_VIEWS);
        return NULL;
    }
    for (int i = 0; i < n_names; i++) {
        paths[i] = names;
        names += strlen(names) + 1;
    }
    return document_open(paths, n_names, n_threads, &last_error);
}

void EXPORT(rw_close)(struct document *document)
{
    document_close(document);
}

int EXPORT(rw_width)(const struct document *document)
{
    return document->input->width;
}

int EXPORT(rw_height)(const struct document *document)
{
    return document->input->height;
}

int EXPORT(rw_n_views)(const struct document *document)
{
    return document->input->n_views;
}

double EXPORT(rw_nearest)(const struct document *document)
{
    return document->input->nearest;
}

double EXPORT(rw_farthest)(const struct document *document)
{
    return document->input->farthest;
}

/* What is doubtful of the file and what was done to its depth, or "". */
const char *EXPORT(rw_remark)(const struct document *document)
{
    return document->remark;
}

/* Forgets what was set. */
void EXPORT(rw_reset)(struct document *document)
{
    settings_init(&document->typed);
}

/* As typed on a command line; the header gives what is not set. */
int EXPORT(rw_set)(struct document *document, const char *key, const char *value)
{
    struct rf_error error = {0};
    const rf_result result = settings_set(&document->typed, key, value, &error);
    settings_imply(&document->typed);
    return note(result, &error);
}

/* Takes what was set and the header together; before rw_get() and rw_origin(). */
int EXPORT(rw_resolve)(struct document *document)
{
    return document_resolve(document, &last_error);
}

const char *EXPORT(rw_get)(const struct document *document, const char *key)
{
    return rw_params_get(&document->settings.params, key);
}

const char *EXPORT(rw_origin)(const struct document *document, const char *key)
{
    settings_describe_origin(&document->settings, key, text, sizeof text);
    return text;
}

const char *EXPORT(rw_why_unused)(const struct document *document, const char *key)
{
    return rw_why_not_read(&document->settings.params, key);
}

/* Scene units along the axis; infinite where nothing was hit. */
double EXPORT(rw_distance_at)(const struct document *document, int x, int y)
{
    const struct input *input = document->input;
    if (x < 0 || y < 0 || x >= input->width || y >= input->height)
        return NAN;
    return input->planar[(size_t)y * (size_t)input->width + (size_t)x];
}

/* Radius in px of the circle of confusion there. */
double EXPORT(rw_radius_at)(const struct document *document, int x, int y)
{
    struct rf_lens lens;
    struct rf_error error;
    const double z = rw_distance_at(document, x, y);
    if (rf_lens_init(&lens, &document->params, document->input->width,
                     document->input->height, &error) != RF_OK)
        return NAN;
    return rf_lens_radius_px(&lens, z);
}

__attribute__((import_module("rackfocus"), import_name("progress"))) int
report_to_page(double fraction);

static bool report(void *user, double fraction)
{
    (void)user;
    return report_to_page(fraction) != 0;
}

/* is_best: the final picture; else one `times` smaller at preview quality. */
int EXPORT(rw_render)(struct document *document, int is_best, int times)
{
    const struct rf_progress progress = {report, NULL};
    return document_render(document, is_best, times, &progress, &last_error);
}

int EXPORT(rw_picture_width)(const struct document *document)
{
    return document->width;
}

int EXPORT(rw_picture_height)(const struct document *document)
{
    return document->height;
}

/* Floats of the picture; n_channels a pixel. */
const float *EXPORT(rw_pixels)(const struct document *document)
{
    return document->pixels;
}

int EXPORT(rw_n_channels)(const struct document *document)
{
    return document->input->n_channels;
}

/* 8 bit RGBA; `what` is an enum document_show. */
const uint8_t *EXPORT(rw_show)(struct document *document, int what, double exposure)
{
    return document_show(document, (enum document_show)what, exposure, &last_error);
}

int EXPORT(rw_save)(struct document *document, const char *path)
{
    return document_save(document, path, &last_error);
}

/* The last picture as the bytes of a PNG's rows, 8 bit, n_channels a pixel, each row
 * with a zero before it (no filter); to be released. */
uint8_t *EXPORT(rw_png_rows)(const struct document *document)
{
    const int n_channels = document->input->n_channels;
    const size_t n_row = (size_t)document->width * (size_t)n_channels;
    uint8_t *rows = app_memory((size_t)document->height, n_row + 1, &last_error);
    for (int32_t y = 0; rows && y < document->height; y++)
        png_encode_row(document->pixels + (size_t)y * n_row, document->width,
                       n_channels, 8, false, rows + (size_t)y * (n_row + 1) + 1);
    return rows;
}

/* Another picture of the same size, such as the host's own lens, as 8 bit RGBA to be
 * released. */
uint8_t *EXPORT(rw_show_file)(const struct document *document, const char *path,
                              double exposure)
{
    struct picture picture = {0};
    const struct input *input = document->input;
    const size_t n = (size_t)input->width * (size_t)input->height;
    uint8_t *rgba = NULL;
    if (!picture_read(path, NULL, 1, &picture, &last_error))
        return NULL;
    if (picture.width != input->width || picture.height != input->height)
        set_error(&last_error, "%s: is %d x %d px, the picture %d x %d", path,
                  (int)picture.width, (int)picture.height, (int)input->width,
                  (int)input->height);
    else
        rgba = app_memory(n, 4, &last_error);
    if (rgba)
        display_picture(document->tone, picture.samples, 3, n, exposure, rgba);
    picture_free(&picture);
    return rgba;
}
