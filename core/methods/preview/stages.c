/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stages: what is between the picture and the result.
 *
 *   levels   the samples of the levels of detail, as pyramid.c builds them
 *   alpha    w of leak.c: the result with c = 0, which is made here, and B = 1
 *   slices   the same with a colour for each slice in place of 1 (paint() of leak.c)
 *
 * Source: the figures of the master's thesis on depth of field in a surgical simulator
 * (docs/methods.md); its mip chain, its blurred alpha, its slice planes.
 */
#include "methods/preview/stages.h"

#include <stddef.h>
#include <string.h>

#include "base/math.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "methods/preview/pyramid.h"

static void black_band(void *user, int from, int to, int thread)
{
    struct rf_preview *p = user;
    size_t end = (size_t)to * (size_t)p->sharp.width;
    for (size_t i = (size_t)from * (size_t)p->sharp.width; i < end; i++)
        p->sharp.at[i] = (rf_f4){0, 0, 0, 1};
}

static void on_rows(struct rf_preview *p, rf_band_fn fn, void *user)
{
    struct rf_blur pass = {.frame = p->work->frame,
                           .task = p->work->task,
                           .progress_from = 0.1,
                           .progress_to = 0.1};
    rf_blur_pass(&pass, 0, 1, p->sharp.height, RF_BAND_ROWS, fn, user);
}

void rf_stage_blacken(struct rf_preview *preview)
{
    on_rows(preview, black_band, preview);
}

/* ---- levels ---------------------------------------------------------------------- */

struct chain {
    struct rf_preview *preview;
    const struct rf_pyramid *pyramid;
};

/* The corner of a level. */
static void place_level(const struct rf_pyramid *p, int level, int *x, int *y)
{
    *x = *y = 0;
    if (level > 1)
        *x = p->level[1].width;
    for (int l = 2; l < level; l++)
        *y += p->level[l].height;
}

static void lay_row(const struct chain *chain, int level, int y, rf_f4 *row)
{
    const struct rf_grid *g = &chain->pyramid->level[level];
    int width = chain->preview->sharp.width, left, top;
    place_level(chain->pyramid, level, &left, &top);
    if (y < top || y >= top + g->height || left >= width)
        return;
    memcpy(row + left, g->at + (size_t)(y - top) * (size_t)g->width,
           (size_t)rf_min_int(g->width, width - left) * sizeof *row);
}

static void chain_band(void *user, int from, int to, int thread)
{
    const struct chain *chain = user;
    struct rf_preview *p = chain->preview;
    for (int y = from; y < to; y++) {
        rf_f4 *row = p->sharp.at + (size_t)y * (size_t)p->sharp.width;
        for (int level = 1; level < chain->pyramid->n_levels; level++)
            lay_row(chain, level, y, row);
        rf_unpack(row, p->sharp.width, p->work->colour, p->work->n_planes,
                  (size_t)y * (size_t)p->sharp.width);
    }
}

rf_result rf_stage_levels(struct rf_preview *preview, struct rf_error *error)
{
    const struct rf_frame *f = preview->work->frame;
    struct rf_pyramid pyramid;
    struct rf_blur blur = {.frame = f,
                           .task = preview->work->task,
                           .source = &preview->sharp,
                           .progress_from = 0.1,
                           .progress_to = 1};
    bool is_offset = f->params.method == RF_METHOD_MIPMAP_OFFSET;
    rf_result result = rf_pyramid_build(&pyramid, &blur, is_offset, error);
    if (result == RF_OK) {
        rf_stage_blacken(preview); /* level 0 is the picture itself */
        on_rows(preview, chain_band, &(struct chain){preview, &pyramid});
    }
    rf_pyramid_free(&pyramid, f->context);
    return result;
}
