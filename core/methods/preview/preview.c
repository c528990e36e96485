/* SPDX-License-Identifier: Apache-2.0 */
/* What the generators and blends of the real-time family share. */
#include "methods/preview/preview.h"

#include <math.h>
#include <stddef.h>

#include "base/error.h"
#include "base/pool.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "methods/preview/blend_coc.h"
#include "methods/preview/blend_region.h"
#include "methods/preview/blend_slices.h"
#include "methods/preview/blur.h"
#include "methods/preview/box.h"
#include "methods/preview/leak.h"
#include "methods/preview/lowres.h"
#include "methods/preview/mipmap.h"
#include "methods/preview/mipmap_offset.h"
#include "methods/preview/offset.h"
#include "methods/preview/recursive_offset.h"
#include "methods/preview/stages.h"
#include "rackfocus/rackfocus.h"

/* One line per blend, in the order of RF_LIST_BLEND. */
static const rf_blend_fn blends[] = {
    [RF_BLEND_COC] = rf_blend_coc,
    [RF_BLEND_REGION] = rf_blend_region,
    [RF_BLEND_SLICES] = rf_blend_slices,
};

/* ---- pixels -------------------------------------------------------------------- */

static void pack_band(void *user, int from, int to, int thread)
{
    const struct rf_preview *p = user;
    size_t at = (size_t)from * (size_t)p->sharp.width;
    int n = (to - from) * p->sharp.width;
    rf_pack(p->work->colour, p->work->n_planes, at, n, p->sharp.at + at);
}

/* ---- methods ------------------------------------------------------------------- */

/* What the parameter says, else the radius of what lies at infinity. */
static float copy_radius(const struct rf_frame *f)
{
    double r = f->params.blur_radius;
    if (r == 0)
        r = fmin(fabs(f->lens.bias_px), f->lens.max_radius_px);
    return (float)r;
}

static rf_result run(struct rf_work *work, rf_generator_fn generate,
                     struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    rf_result result = rf_work_unpack(work, error);
    if (result != RF_OK)
        return result;
    struct rf_preview p = {
        .work = work, .generate = generate, .radius_px = copy_radius(f)};
    if (!rf_grid_alloc(f->context, &p.sharp, f->width, f->height))
        return rf_fail_memory(error, (size_t)f->width * (size_t)f->height,
                              sizeof *p.sharp.at);
    struct rf_blur packing = {.frame = f, .task = work->task, .progress_to = 0.1};
    rf_blur_pass(&packing, 0, 1, f->height, RF_BAND_ROWS, pack_band, &p);
    if (f->params.stage == RF_STAGE_LEVELS) {
        result = rf_stage_levels(&p, error);
    } else {
        if (f->params.stage != RF_STAGE_RESULT)
            rf_stage_blacken(&p);
        result = blends[f->params.blend](&p, error);
    }
    rf_free(f->context, p.sharp.at);
    return result;
}

rf_result rf_box_run(struct rf_work *work, struct rf_error *error)
{
    return run(work, rf_generate_box, error);
}

rf_result rf_lowres_run(struct rf_work *work, struct rf_error *error)
{
    return run(work, rf_generate_lowres, error);
}

rf_result rf_mipmap_run(struct rf_work *work, struct rf_error *error)
{
    return run(work, rf_generate_mipmap, error);
}

rf_result rf_mipmap_offset_run(struct rf_work *work, struct rf_error *error)
{
    return run(work, rf_generate_mipmap_offset, error);
}

rf_result rf_offset_run(struct rf_work *work, struct rf_error *error)
{
    return run(work, rf_generate_offset, error);
}

rf_result rf_recursive_offset_run(struct rf_work *work, struct rf_error *error)
{
    return run(work, rf_generate_recursive_offset, error);
}
