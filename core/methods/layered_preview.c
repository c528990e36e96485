/* SPDX-License-Identifier: Apache-2.0 */
/*
 * quality = preview: layered at 1/2, 1/4, .. of the size, for pictures that must follow
 * the mouse.
 *
 * With S the picture, L its means over F x F pixels, B what layered makes of L at that
 * size, and up() bilinear magnification,
 *
 *   out = up(B) + k (S - up(L)),  k = max(1 - |r| / (3/4 F), 0) (1 - c)
 *
 * so what is in focus keeps its detail: there B = L. c is how much of the pixel lies
 * under the blur of something nearer, estimated from the nearest radius q of blocks of
 * 4 x 4 small pixels: (1 - d / |q|) / 2 at the distance d from the block.
 *
 * Ours. Artefacts: a blur of 1 to F px is drawn from too few pixels, edges between
 * sharp and blurred things wobble by a small pixel, and detail behind a thin blurred
 * thing is a little too strong or too weak.
 */
#include <stdlib.h>

#include "../kernels/kernels.h"

enum {
    SMALL_PIXELS = 160000, /* at most: the size is halved until it fits */
    MAX_HALVINGS = 5,
    BLOCK_HALVINGS = 2, /* blocks of 4 x 4 small pixels */
};

static const float LEAST_NEAR_PX = 1; /* small pixels: nearer blur hides detail */

struct preview {
    struct rf_work *work;
    const struct rf_context *context;
    int halvings;
    int width, height, n_x, n_y; /* small pixels, blocks */
    float *low[4], *blurred[4];  /* L and B */
    float *radius;               /* px of the small picture */
    float *nearest, *covered;    /* per block */
};

static int halvings_of(int width, int height)
{
    int n = 0;
    while (n < MAX_HALVINGS && (int64_t)width * height > (int64_t)SMALL_PIXELS
                                                             << (2 * n))
        n++;
    return n;
}

/* Means of one row of small pixels, and their radii. */
static void shrink_row(struct preview *p, int y)
{
    const struct rf_work *work = p->work;
    int size = 1 << p->halvings, width = work->filter->width;
    int y0 = y * size, n_rows = rf_min_int(size, work->filter->height - y0);
    int middle = rf_min_int(y0 + size / 2, work->filter->height - 1);
    for (int c = 0; c < work->n_planes; c++) {
        float *out = p->low[c] + (size_t)y * (size_t)p->width;
        const float *from = work->colour[c] + (size_t)y0 * (size_t)width;
        for (int x = 0; x < p->width; x++) {
            int n = rf_min_int(size, width - x * size);
            float sum = 0;
            for (int j = 0; j < n_rows; j++)
                for (int i = 0; i < n; i++)
                    sum += from[(size_t)j * (size_t)width + (size_t)(x * size + i)];
            out[x] = sum / (float)(n * n_rows);
        }
        memcpy(p->blurred[c] + (size_t)y * (size_t)p->width, out,
               (size_t)p->width * sizeof *out);
    }
    const float *radius = work->radius + (size_t)middle * (size_t)width;
    for (int x = 0; x < p->width; x++)
        p->radius[(size_t)y * (size_t)p->width + (size_t)x] =
            radius[rf_min_int(x * size + size / 2, width - 1)] / (float)size;
}

static void find_nearest(struct preview *p)
{
    for (int i = 0; i < p->n_x * p->n_y; i++)
        p->nearest[i] = p->covered[i] = 0;
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            float *b =
                &p->nearest[(y >> BLOCK_HALVINGS) * p->n_x + (x >> BLOCK_HALVINGS)];
            *b = rf_min_float(p->radius[(size_t)y * (size_t)p->width + (size_t)x], *b);
        }
}

/* Marks the blocks that block (bx, by) reaches with its blur. */
static void cover(struct preview *p, int bx, int by)
{
    float reach = -p->nearest[by * p->n_x + bx] / (1 << BLOCK_HALVINGS); /* blocks */
    if (reach * (1 << BLOCK_HALVINGS) < LEAST_NEAR_PX)
        return;
    int n = (int)reach + 1;
    for (int y = rf_max_int(by - n, 0); y <= rf_min_int(by + n, p->n_y - 1); y++)
        for (int x = rf_max_int(bx - n, 0); x <= rf_min_int(bx + n, p->n_x - 1); x++) {
            float d = sqrtf((float)((x - bx) * (x - bx) + (y - by) * (y - by)));
            float *c = &p->covered[y * p->n_x + x];
            *c = rf_max_float(0.5f * (1 - d / (reach + 0.5f)), *c);
        }
}

/* Rows of a small plane around row y of the picture, magnified to its width. */
static void magnify(const struct preview *p, const float *plane, int n_x, int n_y,
                    int halvings, int y, float *row, float *out)
{
    float at = ((float)y + 0.5f) / (float)(1 << halvings) - 0.5f;
    int low = (int)floorf(at);
    const float *a = plane + (size_t)rf_max_int(low, 0) * (size_t)n_x;
    const float *b = plane + (size_t)rf_min_int(low + 1, n_y - 1) * (size_t)n_x;
    p->context->kernels->magnify(a, b, at - (float)low, n_x, halvings, row, out,
                                 p->work->filter->width);
}

/* out = up(B) + k (S - up(L)) for one row; `rows` holds four of them. */
static void join_row(const struct preview *p, int y, float *rows, size_t stride)
{
    const struct rf_work *work = p->work;
    int width = work->filter->width;
    float *detail = rows + stride, *low = rows + 2 * stride, *high = rows + 3 * stride;
    const float *radius = work->radius + (size_t)y * (size_t)width;
    float scale = 1 / (0.75f * (float)(1 << p->halvings));
    magnify(p, p->covered, p->n_x, p->n_y, p->halvings + BLOCK_HALVINGS, y, rows,
            detail);
    for (int x = 0; x < width; x++) {
        float k = 1 - fabsf(radius[x]) * scale;
        detail[x] = (k > 0 ? k : 0) * (1 - detail[x]);
    }
    for (int c = 0; c < work->n_planes; c++) {
        float *at = work->colour[c] + (size_t)y * (size_t)width;
        magnify(p, p->low[c], p->width, p->height, p->halvings, y, rows, low);
        magnify(p, p->blurred[c], p->width, p->height, p->halvings, y, rows, high);
        for (int x = 0; x < width; x++) {
            float v = high[x] + detail[x] * (at[x] - low[x]);
            at[x] = v > 0 ? v : 0;
        }
        if (c == 3)
            for (int x = 0; x < width; x++)
                at[x] = at[x] > 1 ? 1 : at[x];
    }
}

/* Blurs the small picture in place. */
static rf_result blur(struct preview *p, struct rf_error *error)
{
    const struct rf_work *work = p->work;
    struct rf_filter small = *work->filter;
    small.width = p->width;
    small.height = p->height;
    small.place = (struct rf_place){0, 0, p->width, p->height};
    small.params.sub_apertures = 1;
    small.params.quality = RF_QUALITY_NORMAL;
    struct rf_work_view view = {.radius = p->radius};
    memcpy(view.colour, p->blurred, sizeof view.colour);
    struct rf_work inner = {.filter = &small,
                            .n_planes = work->n_planes,
                            .radius = p->radius,
                            .n_views = 1,
                            .views = &view,
                            .largest_radius =
                                work->largest_radius / (float)(1 << p->halvings),
                            .task = work->task};
    memcpy(inner.colour, p->blurred, sizeof inner.colour);
    return rf_layered_run(&inner, error);
}

static rf_result run(struct preview *p, float *rows, size_t stride,
                     struct rf_error *error)
{
    const struct rf_work *work = p->work;
    int n_threads = p->context->n_threads;
#pragma omp parallel for num_threads(n_threads) schedule(static)
    for (int y = 0; y < p->height; y++)
        shrink_row(p, y);
    rf_result result = blur(p, error);
    if (result != RF_OK || rf_task_is_cancelled(work->task))
        return result;
    find_nearest(p);
    for (int i = 0; i < p->n_x * p->n_y; i++)
        cover(p, i % p->n_x, i / p->n_x);
#pragma omp parallel for num_threads(n_threads) schedule(static)
    for (int y = 0; y < work->filter->height; y++)
        join_row(p, y, rows + 4 * stride * (size_t)rf_thread_num(), stride);
    return RF_OK;
}

rf_result rf_layered_preview_run(struct rf_work *work, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    struct preview p = {.work = work, .context = f->context};
    p.halvings = halvings_of(f->width, f->height);
    p.width = (f->width + (1 << p.halvings) - 1) >> p.halvings;
    p.height = (f->height + (1 << p.halvings) - 1) >> p.halvings;
    p.n_x = (p.width + (1 << BLOCK_HALVINGS) - 1) >> BLOCK_HALVINGS;
    p.n_y = (p.height + (1 << BLOCK_HALVINGS) - 1) >> BLOCK_HALVINGS;
    size_t n = (size_t)p.width * (size_t)p.height, n_planes = (size_t)work->n_planes;
    size_t n_blocks = (size_t)p.n_x * (size_t)p.n_y;
    size_t stride = (size_t)f->width + 2 * RF_FOOTPRINT_LANES;
    size_t n_rows = 4 * stride * (size_t)f->context->n_threads;
    size_t n_all = n * (2 * n_planes + 1) + 2 * n_blocks + n_rows;
    float *memory = rf_alloc(f->context, n_all, sizeof *memory), *at = memory;
    if (!memory)
        return rf_fail_memory(error, n_all, sizeof *memory);
    for (size_t c = 0; c < n_planes; c++, at += 2 * n) {
        p.low[c] = at;
        p.blurred[c] = at + n;
    }
    p.radius = at;
    p.nearest = at + n;
    p.covered = p.nearest + n_blocks;
    rf_result result = run(&p, p.covered + n_blocks, stride, error);
    rf_free(f->context, memory);
    return result;
}
