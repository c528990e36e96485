/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which of several views sees what. Blocks of 8 x 8 pixels know the range of their
 * radii, so most of a picture is known to be seen by all views without a look at its
 * pixels.
 */
#include "views.h"

enum { BLOCK = 8 };

static const float LEAST_COUNT = 0.25f;

float rf_view_sees(const struct rf_views *v, int j, struct rf_view_place p,
                   bool *is_rendered)
{
    const struct rf_surfaces *s = &v->pictures[j].surfaces;
    int px, py;
    *is_rendered = false;
    if (!rf_view_pixel_at(v, j, p, &px, &py))
        return 0;
    *is_rendered = rf_view_is_rendered(&v->pictures[j], px, py);
    size_t i = (size_t)py * (size_t)s->width + (size_t)px;
    float limit = p.r - RF_OCCLUDED_PX, share = s->share[i];
    if (share <= 0)
        return s->far[i].r < limit ? 0 : 1;
    if (s->near[i].r >= limit)
        return 1;
    return share < 1 && s->far[i].r >= limit ? 1 - share : 0;
}

float rf_views_show(const struct rf_views *v, uint64_t views, int j,
                    struct rf_view_place p, float *continued)
{
    float shown = 0;
    *continued = 0;
    for (int k = 0; k < v->work->n_views; k++) {
        bool is_rendered;
        if (k == j || !(views >> k & 1))
            continue;
        float seen = rf_view_sees(v, k, p, &is_rendered);
        *(is_rendered ? &shown : continued) += seen;
    }
    return shown;
}

float rf_views_leave(const struct rf_views *v, int j, struct rf_view_place p,
                     float least)
{
    float left = 1;
    for (int k = 0; k < v->work->n_views && left > least; k++) {
        bool is_rendered;
        if (k == j)
            continue;
        float seen = rf_view_sees(v, k, p, &is_rendered);
        left -= is_rendered ? seen : 0;
    }
    return rf_max_float(left, least);
}

/* What rf_view_weight() says where the others show so much. */
static float weight_of(float share, float own, float shown, float continued,
                       bool is_rendered)
{
    if (is_rendered)
        return share / rf_max_float(own + shown, LEAST_COUNT);
    return share * rf_max_float(1 - shown, 1e-6f) /
           rf_max_float(own + continued, LEAST_COUNT);
}

float rf_view_weight(const struct rf_views *v, uint64_t views, int j,
                     struct rf_view_place p, float share, bool is_far,
                     bool is_rendered)
{
    float continued, shown = rf_views_show(v, views, j, p, &continued);
    return weight_of(share, is_far ? share : 1, shown, continued, is_rendered);
}

/* ---- blocks -------------------------------------------------------------------- */

struct block {
    float lowest, highest; /* radii */
    bool is_rendered;      /* all of it */
};

/* The blocks of all views, and which other views may not see all of each. */
struct blocks {
    struct rf_views *v;
    int n_x, n_y, n_failed;
    struct block *at;
    uint64_t *doubtful; /* bit j: view j */
};

static size_t block_index(const struct blocks *b, int view, int x, int y)
{
    return ((size_t)view * (size_t)b->n_y + (size_t)y) * (size_t)b->n_x + (size_t)x;
}

static void measure_blocks(const struct blocks *b, int view, int by)
{
    const struct rf_picture *l = &b->v->pictures[view];
    const struct rf_surfaces *s = &l->surfaces;
    struct block *row = &b->at[block_index(b, view, 0, by)];
    for (int bx = 0; bx < b->n_x; bx++)
        row[bx] = (struct block){INFINITY, -INFINITY, true};
    for (int y = by * BLOCK; y < rf_min_int((by + 1) * BLOCK, l->height); y++)
        for (int x = 0; x < l->width; x++) {
            size_t i = (size_t)y * (size_t)l->width + (size_t)x;
            struct block *at = &row[x / BLOCK];
            const struct rf_surface *back = s->share[i] < 1 ? &s->far[i] : &s->near[i];
            float far = back->r, near = s->share[i] > 0 ? s->near[i].r : far;
            at->lowest = rf_min_float(at->lowest, rf_min_float(near, far));
            at->highest = rf_max_float(at->highest, rf_max_float(near, far));
            at->is_rendered &= rf_view_is_rendered(l, x, y);
        }
}

/* Does view j surely see all that a block of another view shows? */
static bool is_seen(const struct blocks *b, int view, int bx, int by, int j)
{
    const struct rf_views *v = b->v;
    const struct block *block = &b->at[block_index(b, view, bx, by)];
    int first[2] = {INT32_MAX, INT32_MAX}, last[2] = {-1, -1};
    for (int corner = 0; corner < 4; corner++) {
        float r = corner & 1 ? block->lowest : block->highest;
        int end = corner & 2 ? BLOCK : 0, px, py;
        struct rf_view_place p = rf_view_place_of(v, view, (float)(bx * BLOCK + end),
                                                  (float)(by * BLOCK + end), r);
        if (!rf_view_pixel_at(v, j, p, &px, &py))
            return false;
        first[0] = rf_min_int(first[0], px / BLOCK);
        first[1] = rf_min_int(first[1], py / BLOCK);
        last[0] = rf_max_int(last[0], px / BLOCK);
        last[1] = rf_max_int(last[1], py / BLOCK);
    }
    for (int y = first[1]; y <= last[1]; y++)
        for (int x = first[0]; x <= last[0]; x++) {
            const struct block *other = &b->at[block_index(b, j, x, y)];
            if (!other->is_rendered || other->lowest < block->highest - RF_OCCLUDED_PX)
                return false;
        }
    return true;
}

static void find_doubtful(const struct blocks *b, int view, int by)
{
    for (int bx = 0; bx < b->n_x; bx++) {
        uint64_t *doubtful = &b->doubtful[block_index(b, view, bx, by)];
        *doubtful = 0;
        for (int j = 0; j < b->v->work->n_views; j++)
            if (j != view && !is_seen(b, view, bx, by, j))
                *doubtful |= (uint64_t)1 << j;
    }
}

/* ---- rows ---------------------------------------------------------------------- */

/* Collects a row of one view. */
struct lister {
    const struct blocks *blocks;
    int view;
    struct rf_unseen *at; /* room for two per pixel */
    int n;
};

/* How much of a place view j, which is doubtful, shows in what was rendered. */
static float shown_by(const struct blocks *b, int j, struct rf_view_place place)
{
    int px, py;
    bool is_rendered;
    if (!rf_view_pixel_at(b->v, j, place, &px, &py))
        return 0;
    const struct block *block = &b->at[block_index(b, j, px / BLOCK, py / BLOCK)];
    if (block->is_rendered && block->lowest >= place.r - RF_OCCLUDED_PX)
        return 1;
    float seen = rf_view_sees(b->v, j, place, &is_rendered);
    return is_rendered ? seen : 0;
}

static void list_part(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct lister *l = user;
    const struct blocks *b = l->blocks;
    const struct rf_views *v = b->v;
    const struct rf_picture *picture = &v->pictures[l->view];
    uint64_t left = b->doubtful[block_index(b, l->view, x / BLOCK, y / BLOCK)];
    if (!left || !rf_view_is_rendered(picture, x, y))
        return;
    struct rf_view_place place =
        rf_view_place_of(v, l->view, (float)x + 0.5f, (float)y + 0.5f, s->r);
    float shown = (float)(v->work->n_views - 1 - __builtin_popcountll(left));
    uint64_t views = 0;
    for (; left; left &= left - 1) {
        int j = __builtin_ctzll(left);
        float seen = shown_by(b, j, place);
        shown += seen;
        if (seen < 0.5f)
            views |= (uint64_t)1 << j;
    }
    if (!views)
        return;
    bool is_far =
        s != &picture->surfaces.near[(size_t)y * (size_t)picture->width + (size_t)x];
    l->at[l->n++] =
        (struct rf_unseen){.part = 2 * x + is_far,
                           .weight = weight_of(w, is_far ? w : 1, shown, 0, true),
                           .views = views};
}

static void list_row(struct blocks *b, int view, int y, struct rf_unseen *room)
{
    struct rf_views *v = b->v;
    struct rf_picture *picture = &v->pictures[view];
    struct rf_unseen_row *row =
        &v->unseen[(size_t)view * (size_t)picture->height + (size_t)y];
    struct lister l = {.blocks = b, .view = view, .at = room};
    rf_picture_visit_row(picture, y, list_part, &l);
    if (l.n == 0)
        return;
    row->at = rf_alloc(v->work->filter->context, (size_t)l.n, sizeof *row->at);
    if (!row->at) {
#pragma omp atomic
        b->n_failed++;
        return;
    }
    memcpy(row->at, room, (size_t)l.n * sizeof *row->at);
    row->n = l.n;
}

static void list_all(struct blocks *b, struct rf_unseen *room)
{
    const struct rf_picture *picture = &b->v->pictures[0];
    struct rf_task *task = b->v->work->task;
    int n_views = b->v->work->n_views, n_threads = picture->filter->context->n_threads;
    size_t n_room = 2 * (size_t)picture->width;
#pragma omp parallel num_threads(n_threads)
    {
#pragma omp for schedule(dynamic, 4)
        for (int i = 0; i < n_views * b->n_y; i++)
            measure_blocks(b, i / b->n_y, i % b->n_y);
#pragma omp for schedule(dynamic, 4)
        for (int i = 0; i < n_views * b->n_y; i++)
            find_doubtful(b, i / b->n_y, i % b->n_y);
#pragma omp for schedule(dynamic, 16)
        for (int i = 0; i < n_views * picture->height; i++)
            if (!rf_task_is_cancelled(task))
                list_row(b, i / picture->height, i % picture->height,
                         room + n_room * (size_t)rf_thread_num());
    }
    rf_task_poll(task);
}

rf_result rf_views_find_unseen(struct rf_views *v, struct rf_error *error)
{
    const struct rf_picture *picture = &v->pictures[0];
    const struct rf_context *context = v->work->filter->context;
    struct blocks b = {.v = v,
                       .n_x = (picture->width + BLOCK - 1) / BLOCK,
                       .n_y = (picture->height + BLOCK - 1) / BLOCK};
    size_t n_blocks = (size_t)b.n_x * (size_t)b.n_y * (size_t)v->work->n_views;
    size_t n_rows = (size_t)picture->height * (size_t)v->work->n_views;
    size_t n_room = 2 * (size_t)picture->width * (size_t)context->n_threads;
    b.at = rf_alloc(context, n_blocks, sizeof *b.at);
    b.doubtful = rf_alloc(context, n_blocks, sizeof *b.doubtful);
    struct rf_unseen *room = rf_alloc(context, n_room, sizeof *room);
    v->unseen = rf_calloc(context, n_rows, sizeof *v->unseen);
    bool is_complete = b.at && b.doubtful && room && v->unseen;
    if (is_complete)
        list_all(&b, room);
    rf_free(context, room);
    rf_free(context, b.doubtful);
    rf_free(context, b.at);
    return is_complete && !b.n_failed ? RF_OK
                                      : rf_fail_memory(error, n_room, sizeof *room);
}

void rf_views_free_unseen(struct rf_views *v)
{
    const struct rf_context *context = v->work->filter->context;
    if (!v->unseen)
        return;
    for (int i = 0; i < v->work->n_views * v->pictures[0].height; i++)
        rf_free(context, v->unseen[i].at);
    rf_free(context, v->unseen);
    v->unseen = NULL;
}
