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
#include "methods/layered/layered_preview.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "methods/layered/layered.h"
#include "rackfocus/rackfocus.h"

enum {
    SMALL_PIXELS = 160000, /* at most: the size is halved until it fits */
    MAX_HALVINGS = 5,
    BLOCK_HALVINGS = 2, /* blocks of 4 x 4 small pixels */
};

/* In small pixels: nearer blur hides detail. Ours: with half plane loses 0.05 dB and
 * ortho 0.04, with twice nothing changes by 0.02 (docs/notebook/thresholds.md). */
static const float LEAST_NEAR_PX = 1;

struct preview {
    struct rf_work *work;
    const struct rf_context *context;
    /* The caller's plain pixels, which are read and written row by row; NULL: planes,
     * work->colour. */
    const struct rf_image *from, *to;
    int halvings;
    int width, height, n_x, n_y; /* small pixels, blocks */
    int n_planes;
    float *low[4], *blurred[4]; /* L and B */
    float *radius;              /* px of the small picture */
    float *nearest, *covered;   /* per block */
    float *memory;              /* of all that */
    float *scratch;             /* of the threads: n_scratch floats each */
    size_t n_scratch, stride;
};

static int halvings_of(int width, int height)
{
    int n = 0;
    while (n < MAX_HALVINGS && (int64_t)width * height > (int64_t)SMALL_PIXELS
                                                             << (2 * n))
        n++;
    return n;
}

/* What a row of the caller's pixels holds. */
struct row_kind {
    bool is_finite;
    bool is_opaque; /* every alpha is 1 */
};

static bool is_opaque_row(const float *alpha, int n)
{
    int n_transparent = 0;
    for (int x = 0; x < n; x++)
        n_transparent += alpha[x] != 1;
    return n_transparent == 0;
}

/* The n_rows rows from y0 on as planes: where they begin, and how far rows are apart.
 */
static size_t fetch_rows(const struct preview *p, int y0, int n_rows, float *scratch,
                         const float *at[4], struct row_kind *kind)
{
    int width = p->work->frame->width;
    size_t row = (size_t)y0 * (size_t)width;
    *kind = (struct row_kind){true, false};
    for (int c = 0; c < p->work->n_planes; c++)
        at[c] = p->from ? scratch + p->stride * (size_t)(c * n_rows)
                        : p->work->colour[c] + row;
    if (!p->from)
        return (size_t)width;
    kind->is_opaque = true;
    for (int j = 0; j < n_rows; j++) {
        float *to[4];
        for (int c = 0; c < 4; c++)
            to[c] = scratch + p->stride * (size_t)(c * n_rows + j);
        kind->is_finite &=
            p->context->kernels->unpack(rf_image_at(p->from, 0, y0 + j, 0), width, to);
        kind->is_opaque &= is_opaque_row(to[3], width);
    }
    return p->stride;
}

/* Means of one row of small pixels, and their radii. */
static struct row_kind shrink_row(struct preview *p, int y, float *scratch)
{
    const struct rf_work *work = p->work;
    int size = 1 << p->halvings, width = work->frame->width;
    int y0 = y * size, n_rows = rf_min_int(size, work->frame->height - y0);
    int middle = rf_min_int(y0 + size / 2, work->frame->height - 1);
    int n_whole = width >> p->halvings;
    const float *at[4];
    float *sums = scratch + p->stride * (size_t)(4 * size);
    struct row_kind kind;
    size_t stride = fetch_rows(p, y0, n_rows, scratch, at, &kind);
    for (int c = 0; c < work->n_planes; c++) {
        float *out = p->low[c] + (size_t)y * (size_t)p->width;
        p->context->kernels->shrink(at[c], stride, n_rows, p->halvings, n_whole, sums,
                                    out);
        if (n_whole < p->width) {
            int n = width - n_whole * size;
            float sum = 0;
            for (int j = 0; j < n_rows; j++)
                for (int i = 0; i < n; i++)
                    sum += at[c][(size_t)j * stride + (size_t)(n_whole * size + i)];
            out[n_whole] = sum / (float)(n * n_rows);
        }
        memcpy(p->blurred[c] + (size_t)y * (size_t)p->width, out,
               (size_t)p->width * sizeof *out);
    }
    const float *radius = work->radius + (size_t)middle * (size_t)width;
    for (int x = 0; x < p->width; x++)
        p->radius[(size_t)y * (size_t)p->width + (size_t)x] =
            radius[rf_min_int(x * size + size / 2, width - 1)] / (float)size;
    return kind;
}

/* The nearest radius of each block of a row of them. */
static void find_nearest(struct preview *p, int by)
{
    float *nearest = p->nearest + by * p->n_x;
    int y0 = by << BLOCK_HALVINGS;
    int y1 = rf_min_int(y0 + (1 << BLOCK_HALVINGS), p->height);
    for (int i = 0; i < p->n_x; i++)
        nearest[i] = p->covered[by * p->n_x + i] = 0;
    for (int y = y0; y < y1; y++)
        for (int x = 0; x < p->width; x++) {
            float *b = &nearest[x >> BLOCK_HALVINGS];
            *b = rf_min_float(p->radius[(size_t)y * (size_t)p->width + (size_t)x], *b);
        }
}

/* What covers a row of blocks: the blur of blocks that are near enough. */
static void cover_row(struct preview *p, int y, int most)
{
    float *covered = p->covered + y * p->n_x;
    for (int by = rf_max_int(y - most, 0); by <= rf_min_int(y + most, p->n_y - 1); by++)
        for (int bx = 0; bx < p->n_x; bx++) {
            float reach = -p->nearest[by * p->n_x + bx] / (1 << BLOCK_HALVINGS);
            if (reach * (1 << BLOCK_HALVINGS) < LEAST_NEAR_PX)
                continue;
            int n = (int)reach + 1, x1 = rf_min_int(bx + n, p->n_x - 1);
            float scale = 0.5f / (reach + 0.5f), dy2 = (float)((y - by) * (y - by));
            if (abs(y - by) > n)
                continue;
            for (int x = rf_max_int(bx - n, 0); x <= x1; x++) {
                float dx = (float)(x - bx);
                float c = 0.5f - sqrtf(dx * dx + dy2) * scale;
                covered[x] = rf_max_float(c, covered[x]);
            }
        }
}

static void find_nearest_rows(void *data, int64_t begin, int64_t end, int thread)
{
    for (int64_t by = begin; by < end; by++)
        find_nearest(data, (int)by);
}

/* What the threads share that find what covers blocks. */
struct covering {
    struct preview *preview;
    int most; /* rows of blocks that one reaches */
};

static void cover_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct covering *c = data;
    for (int64_t y = begin; y < end; y++)
        cover_row(c->preview, (int)y, c->most);
}

static void find_covered(struct preview *p)
{
    float nearest = 0;
    rf_parallel(p->context, p->n_y, RF_EQUAL_PARTS, find_nearest_rows, p);
    for (int i = 0; i < p->n_x * p->n_y; i++)
        nearest = rf_min_float(p->nearest[i], nearest);
    int most = (int)(-nearest / (1 << BLOCK_HALVINGS)) + 1;
    struct covering covering = {p, most};
    rf_parallel(p->context, p->n_y, 4, cover_rows, &covering);
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
                                 p->work->frame->width);
}

/* out = up(B) + k (S - up(L)) for one row. */
static void join_row(const struct preview *p, int y, float *scratch)
{
    const struct rf_work *work = p->work;
    const struct rf_kernels *k = p->context->kernels;
    int width = work->frame->width;
    float *row = scratch, *detail = row + p->stride, *low = detail + p->stride;
    float *out[4], *own = low + p->stride;
    const float *at[4];
    float scale = 1 / (0.75f * (float)(1 << p->halvings));
    magnify(p, p->covered, p->n_x, p->n_y, p->halvings + BLOCK_HALVINGS, y, row,
            detail);
    bool has_detail = k->detail(work->radius + (size_t)y * (size_t)width, detail, scale,
                                width, detail);
    if (!p->from)
        for (int c = 0; c < work->n_planes; c++)
            at[c] = out[c] = work->colour[c] + (size_t)y * (size_t)width;
    for (int c = 0; c < 4 && p->from; c++)
        at[c] = out[c] = own + p->stride * (size_t)c;
    if (p->from && has_detail)
        k->unpack(rf_image_at(p->from, 0, y, 0), width, out);
    for (int c = 0; c < p->n_planes; c++) {
        float *high = p->from ? row + 7 * p->stride : row + 3 * p->stride;
        magnify(p, p->blurred[c], p->width, p->height, p->halvings, y, row, high);
        if (has_detail)
            magnify(p, p->low[c], p->width, p->height, p->halvings, y, row, low);
        k->join(high, low, at[c], has_detail ? detail : NULL, c == 3 ? 1 : INFINITY,
                width, out[c]);
    }
    for (int x = 0; x < width && p->from && p->n_planes == 3; x++)
        out[3][x] = 1;
    if (p->from)
        k->pack((const float *const *)out, width, (float *)rf_image_at(p->to, 0, y, 0));
}

/* Blurs the small picture in place. */
static rf_result blur(struct preview *p, struct rf_error *error)
{
    const struct rf_work *work = p->work;
    struct rf_frame small = *work->frame;
    small.width = p->width;
    small.height = p->height;
    small.place = (struct rf_place){0, 0, p->width, p->height};
    small.params.sub_apertures = 1;
    small.params.quality = RF_QUALITY_NORMAL;
    struct rf_work_view view = {.radius = p->radius};
    memcpy(view.colour, p->blurred, sizeof view.colour);
    struct rf_work inner = {.frame = &small,
                            .n_planes = p->n_planes,
                            .radius = p->radius,
                            .n_views = 1,
                            .views = &view,
                            .largest_radius =
                                work->largest_radius / (float)(1 << p->halvings),
                            .task = work->task};
    memcpy(inner.colour, p->blurred, sizeof inner.colour);
    return rf_layered_run(&inner, error);
}

/* What the threads share that shrink the picture; atomic: what not all rows are. */
struct shrinking {
    struct preview *preview;
    bool is_infinite, is_transparent;
};

static void shrink_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct shrinking *s = data;
    struct preview *p = s->preview;
    for (int y = (int)begin; y < (int)end; y++) {
        struct row_kind kind =
            shrink_row(p, y, p->scratch + p->n_scratch * (size_t)thread);
        if (!kind.is_finite)
            __atomic_store_n(&s->is_infinite, true, __ATOMIC_RELAXED);
        if (!kind.is_opaque)
            __atomic_store_n(&s->is_transparent, true, __ATOMIC_RELAXED);
    }
}

static struct row_kind shrink_all(struct preview *p)
{
    struct shrinking s = {.preview = p};
    rf_parallel(p->context, p->height, RF_EQUAL_PARTS, shrink_rows, &s);
    return (struct row_kind){!s.is_infinite, !s.is_transparent};
}

static void join_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct preview *p = data;
    for (int64_t y = begin; y < end; y++)
        join_row(p, (int)y, p->scratch + p->n_scratch * (size_t)thread);
}

static rf_result run(struct preview *p, struct rf_error *error)
{
    struct row_kind kind = shrink_all(p);
    if (!kind.is_finite)
        return rf_frame_check(p->work->frame, p->from, error);
    p->n_planes = kind.is_opaque ? 3 : p->work->n_planes;
    rf_result result = blur(p, error);
    if (result != RF_OK || rf_task_is_cancelled(p->work->task))
        return result;
    find_covered(p);
    rf_parallel(p->context, p->work->frame->height, RF_EQUAL_PARTS, join_rows, p);
    return RF_OK;
}

static rf_result allocate(struct preview *p, struct rf_error *error)
{
    const struct rf_frame *f = p->work->frame;
    p->halvings = halvings_of(f->width, f->height);
    int size = 1 << p->halvings, block = 1 << BLOCK_HALVINGS;
    p->width = (f->width + size - 1) >> p->halvings;
    p->height = (f->height + size - 1) >> p->halvings;
    p->n_x = (p->width + block - 1) >> BLOCK_HALVINGS;
    p->n_y = (p->height + block - 1) >> BLOCK_HALVINGS;
    p->n_planes = p->work->n_planes;
    size_t n = (size_t)p->width * (size_t)p->height, n_planes = (size_t)p->n_planes;
    size_t n_blocks = (size_t)p->n_x * (size_t)p->n_y;
    p->stride = ((size_t)f->width + 3 * RF_FOOTPRINT_LANES - 1) / RF_FOOTPRINT_LANES *
                RF_FOOTPRINT_LANES;
    p->n_scratch = p->stride * (size_t)rf_max_int(4 * size + 1, 8);
    size_t n_all = n * (2 * n_planes + 1) + 2 * n_blocks +
                   p->n_scratch * (size_t)f->context->n_threads;
    p->memory = rf_alloc(f->context, n_all, sizeof *p->memory);
    if (!p->memory)
        return rf_fail_memory(error, n_all, sizeof *p->memory);
    float *at = p->memory;
    for (size_t c = 0; c < n_planes; c++, at += 2 * n) {
        p->low[c] = at;
        p->blurred[c] = at + n;
    }
    p->radius = at;
    p->nearest = at + n;
    p->covered = p->nearest + n_blocks;
    p->scratch = p->covered + n_blocks;
    return RF_OK;
}

/* Do two pictures share memory, other than pixel by pixel? */
static bool is_tangled(const struct rf_image *a, const struct rf_image *b)
{
    if (a->data == b->data && a->row_bytes == b->row_bytes)
        return false;
    const char *ends[2][2];
    const struct rf_image *both[] = {a, b};
    for (int i = 0; i < 2; i++) {
        const char *first = (const char *)rf_image_at(both[i], 0, 0, 0);
        const char *last =
            (const char *)rf_image_at(both[i], 0, both[i]->height - 1, 0);
        ends[i][0] = first < last ? first : last;
        ends[i][1] =
            (first < last ? last : first) + (size_t)both[i]->width * 4 * sizeof(float);
    }
    return ends[0][0] < ends[1][1] && ends[1][0] < ends[0][1];
}

rf_result rf_layered_preview_run(struct rf_work *work, struct rf_error *error)
{
    struct preview p = {.work = work, .context = work->frame->context};
    const struct rf_image *from = work->views->image;
    rf_result result = RF_OK;
    if (from && work->out && !is_tangled(from, work->out)) {
        p.from = from;
        p.to = work->out;
    } else {
        result = rf_work_unpack(work, error);
    }
    if (result == RF_OK)
        result = allocate(&p, error);
    if (result == RF_OK)
        result = run(&p, error);
    rf_free(p.context, p.memory);
    return result;
}
