/* SPDX-License-Identifier: Apache-2.0 */
/* What the generators and blends of the real-time family share: passes, pixels. */
#include "methods/preview/blur.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "input/views_in.h"

bool rf_grid_alloc(const struct rf_context *context, struct rf_grid *grid, int width,
                   int height)
{
    grid->width = width;
    grid->height = height;
    grid->at = rf_alloc(context, (size_t)width * (size_t)height, sizeof *grid->at);
    return grid->at != NULL;
}

/* What the threads share that run a pass. */
struct passing {
    struct rf_task *task;
    int n, step; /* lines, and those of a band */
    rf_band_fn fn;
    void *user;
};

static void run_bands(void *data, int64_t begin, int64_t end, int thread)
{
    const struct passing *p = data;
    for (int i = (int)begin; i < (int)end && !rf_task_is_cancelled(p->task); i++) {
        p->fn(p->user, i * p->step, rf_min_int((i + 1) * p->step, p->n), thread);
        rf_task_step(p->task);
    }
}

void rf_blur_pass(const struct rf_blur *blur, int pass, int n_passes, int n, int step,
                  rf_band_fn fn, void *user)
{
    struct rf_task *task = blur->task;
    int n_bands = (n + step - 1) / step;
    double share = (double)(pass + 1) / n_passes;
    rf_task_phase(
        task, blur->progress_from + (blur->progress_to - blur->progress_from) * share,
        n_bands);
    struct passing passing = {task, n, step, fn, user};
    rf_parallel(blur->frame->context, n_bands, RF_EQUAL_PARTS, run_bands, &passing);
}

#define TRANSPOSE(a, b, c, d)                                                          \
    do {                                                                               \
        rf_f4 ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);                      \
        rf_f4 ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);                     \
        rf_f4 cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);                      \
        rf_f4 cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);                     \
        a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);                       \
        b = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);                       \
        c = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);                     \
        d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);                     \
    } while (0)

static rf_f4 load4(const float *from)
{
    rf_f4 v;
    memcpy(&v, from, sizeof v);
    return v;
}

void rf_pack(float *const planes[4], int n_planes, size_t at, int n, rf_f4 *pixels)
{
    int i = 0;
    for (; n_planes == 4 && i + 4 <= n; i += 4) {
        rf_f4 a = load4(planes[0] + at + i), b = load4(planes[1] + at + i);
        rf_f4 c = load4(planes[2] + at + i), d = load4(planes[3] + at + i);
        TRANSPOSE(a, b, c, d);
        pixels[i] = a, pixels[i + 1] = b, pixels[i + 2] = c, pixels[i + 3] = d;
    }
    for (; i < n; i++)
        for (int p = 0; p < 4; p++)
            pixels[i][p] = p < n_planes ? planes[p][at + (size_t)i] : 0;
}

void rf_unpack(const rf_f4 *pixels, int n, float *const planes[4], int n_planes,
               size_t at)
{
    int i = 0;
    for (; n_planes == 4 && i + 4 <= n; i += 4) {
        rf_f4 a = pixels[i], b = pixels[i + 1], c = pixels[i + 2], d = pixels[i + 3];
        TRANSPOSE(a, b, c, d);
        memcpy(planes[0] + at + i, &a, sizeof a);
        memcpy(planes[1] + at + i, &b, sizeof b);
        memcpy(planes[2] + at + i, &c, sizeof c);
        memcpy(planes[3] + at + i, &d, sizeof d);
    }
    for (; i < n; i++)
        for (int p = 0; p < n_planes; p++)
            planes[p][at + (size_t)i] = pixels[i][p];
}

void rf_put_planes(const struct rf_blur *blur, int x, int y, int n, rf_f4 *pixels)
{
    const struct rf_work *work = blur->user;
    size_t at = (size_t)y * (size_t)blur->source->width + (size_t)x;
    rf_unpack(pixels, n, work->colour, work->n_planes, at);
}
