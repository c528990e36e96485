/* SPDX-License-Identifier: Apache-2.0 */
/* The table of methods. */
#include "methods/methods.h"

#include <stddef.h>
#include <stdint.h>

#include "input/views_in.h"
#include "methods/accumulate.h"
#include "methods/layered/layered.h"
#include "methods/layered/layered_preview.h"
#include "methods/preview/preview.h"
#include "methods/scatter/scatter.h"
#include "methods/views/views.h"
#include "rackfocus/rackfocus.h"

static rf_result run_layered(struct rf_work *work, struct rf_error *error)
{
    return work->frame->params.quality == RF_QUALITY_PREVIEW
               ? rf_layered_preview_run(work, error)
               : rf_layered_run(work, error);
}

#define THESIS "thesis on depth of field in a surgical simulator: "

/*
 * One row per method, in the order of RF_LIST_METHOD: ROW(METHOD, run, members of
 * struct rf_method_info). A new method is a file, a row here and a line of
 * RF_LIST_METHOD.
 */
#define ROWS(ROW)                                                                      \
    ROW(LAYERED, run_layered, .name = "layered",                                       \
        .help = "occlusion-aware layers from one view; the default",                   \
        .cost = "grows with the mean area of the blur",                                \
        .source = "Rack Focus; after Kosloff 2009, Lee et al. 2009", .max_views = 1,   \
        .needs_depth = true, .has_layers = true, .reads_aperture = true,               \
        .can_window = true, .can_deep = true)                                          \
    ROW(SCATTER, rf_scatter_run, .name = "scatter",                                    \
        .help = "each pixel spread over its circle of confusion",                      \
        .cost = "grows with the mean radius of the blur", .source = "Yu 2004",         \
        .max_views = 1, .needs_depth = true)                                           \
    ROW(BOX, rf_box_run, .name = "box",                                                \
        .help = "preview: running sums along rows and columns",                        \
        .cost = "the same for every radius", .source = THESIS "convolution",           \
        .max_views = 1, .needs_depth = true, .has_blend = true)                        \
    ROW(LOWRES, rf_lowres_run, .name = "lowres",                                       \
        .help = "preview: a small picture, magnified",                                 \
        .cost = "the same for every radius; the cheapest",                             \
        .source = THESIS "low resolution", .max_views = 1, .needs_depth = true,        \
        .has_blend = true)                                                             \
    ROW(MIPMAP, rf_mipmap_run, .name = "mipmap",                                       \
        .help = "preview: coarser levels of detail, magnified",                        \
        .cost = "the same for every radius", .source = THESIS "mipmap",                \
        .max_views = 1, .needs_depth = true, .has_blend = true)                        \
    ROW(OFFSET, rf_offset_run, .name = "offset",                                       \
        .help = "preview: shifted copies, averaged",                                   \
        .cost = "grows with the number of copies", .source = THESIS "offset",          \
        .max_views = 1, .needs_depth = true, .has_blend = true,                        \
        .reads_aperture = true)                                                        \
    ROW(MIPMAP_OFFSET, rf_mipmap_offset_run, .name = "mipmap-offset",                  \
        .help = "preview: four shifts of a coarser level of detail",                   \
        .cost = "the same for every radius", .source = THESIS "offset on mipmaps",     \
        .max_views = 1, .needs_depth = true, .has_blend = true)                        \
    ROW(RECURSIVE_OFFSET, rf_recursive_offset_run, .name = "recursive-offset",         \
        .help = "preview: four shifts in x, four in +, again and again",               \
        .cost = "grows with the number of recursions",                                 \
        .source = THESIS "recursive offset", .max_views = 1, .needs_depth = true,      \
        .has_blend = true)                                                             \
    ROW(VIEWS, rf_views_run, .name = "views",                                          \
        .help = "several views from points of the lens, merged",                       \
        .cost = "about the sum of the views' layered passes", .source = "Rack Focus",  \
        .max_views = RF_MAX_VIEWS, .needs_depth = true, .has_layers = true,            \
        .reads_aperture = true, .can_window = true)                                    \
    ROW(ACCUMULATE, rf_accumulate_run, .name = "accumulate",                           \
        .help = "the mean of views; needs no depth",                                   \
        .cost = "the renders of the views",                                            \
        .source = "OpenGL programming guide; OpenGL wikibook",                         \
        .max_views = RF_MAX_VIEWS)

#define INFO(method, run, ...) [RF_METHOD_##method] = {__VA_ARGS__},
#define RUN(method, run, ...) [RF_METHOD_##method] = run,

static const struct rf_method_info infos[] = {ROWS(INFO)};
static const rf_method_fn functions[] = {ROWS(RUN)};

#define COUNT(method, name, help) +1
_Static_assert(sizeof infos / sizeof *infos == RF_LIST_METHOD(COUNT),
               "a row for each method of RF_LIST_METHOD");

rf_method_fn rf_method_run(enum rf_method method)
{
    return functions[method];
}

const struct rf_method_info *rf_method_list(size_t *n)
{
    if (n)
        *n = sizeof infos / sizeof infos[0];
    return infos;
}

const struct rf_method_info *rf_method_find(int32_t method)
{
    size_t n = sizeof infos / sizeof infos[0];
    return method >= 0 && (size_t)method < n ? &infos[method] : NULL;
}
