/* SPDX-License-Identifier: Apache-2.0 */
/* The table of methods. */
#include "methods/methods.h"

#include <stddef.h>

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
    return work->filter->params.quality == RF_QUALITY_PREVIEW
               ? rf_layered_preview_run(work, error)
               : rf_layered_run(work, error);
}

/* One line per method, in the order of RF_LIST_METHOD. */
static const struct rf_method_entry entries[] = {
    [RF_METHOD_LAYERED] = {.run = run_layered},
    [RF_METHOD_SCATTER] = {.run = rf_scatter_run},
    [RF_METHOD_BOX] = {.run = rf_box_run},
    [RF_METHOD_LOWRES] = {.run = rf_lowres_run},
    [RF_METHOD_MIPMAP] = {.run = rf_mipmap_run},
    [RF_METHOD_OFFSET] = {.run = rf_offset_run},
    [RF_METHOD_MIPMAP_OFFSET] = {.run = rf_mipmap_offset_run},
    [RF_METHOD_RECURSIVE_OFFSET] = {.run = rf_recursive_offset_run},
    [RF_METHOD_VIEWS] = {.run = rf_views_run, .max_views = RF_MAX_VIEWS},
    [RF_METHOD_ACCUMULATE] = {.run = rf_accumulate_run, .max_views = RF_MAX_VIEWS},
};

#define THESIS "thesis on depth of field in a surgical simulator: "

static const struct rf_method_info infos[] = {
    [RF_METHOD_LAYERED] = {"layered",
                           "occlusion-aware layers from one view; the default",
                           "grows with the mean area of the blur",
                           "Rack Focus; after Kosloff 2009, Lee et al. 2009"},
    [RF_METHOD_SCATTER] = {"scatter", "each pixel spread over its circle of confusion",
                           "grows with the mean radius of the blur", "Yu 2004"},
    [RF_METHOD_BOX] = {"box", "preview: running sums along rows and columns",
                       "the same for every radius", THESIS "convolution"},
    [RF_METHOD_LOWRES] = {"lowres", "preview: a small picture, magnified",
                          "the same for every radius; the cheapest",
                          THESIS "low resolution"},
    [RF_METHOD_MIPMAP] = {"mipmap", "preview: coarser levels of detail, magnified",
                          "the same for every radius", THESIS "mipmap"},
    [RF_METHOD_OFFSET] = {"offset", "preview: shifted copies, averaged",
                          "grows with the number of copies", THESIS "offset"},
    [RF_METHOD_MIPMAP_OFFSET] = {"mipmap-offset",
                                 "preview: four shifts of a coarser level of detail",
                                 "the same for every radius",
                                 THESIS "offset on mipmaps"},
    [RF_METHOD_RECURSIVE_OFFSET] =
        {"recursive-offset", "preview: four shifts in x, four in +, again and again",
         "grows with the number of recursions", THESIS "recursive offset"},
    [RF_METHOD_VIEWS] = {"views", "several views from points of the lens, merged",
                         "about the sum of the views' layered passes", "Rack Focus"},
    [RF_METHOD_ACCUMULATE] = {"accumulate", "the mean of views; needs no depth",
                              "the renders of the views",
                              "OpenGL programming guide; OpenGL wikibook"},
};

const struct rf_method_entry *rf_method_of(enum rf_method method)
{
    return &entries[method];
}

const struct rf_method_info *rf_method_list(size_t *n)
{
    if (n)
        *n = sizeof infos / sizeof infos[0];
    return infos;
}
