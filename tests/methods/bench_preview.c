/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How fast the real-time family is: 1024 x 1024, RGBA float, packed, radii up to R.
 *
 *     bench_preview [THREADS [ROUNDS [METHOD]]]
 *
 * One line per method, blend and R: the best wall time of all rounds, the best process
 * CPU time divided by the threads (what the wall time is on an idle machine), frames
 * per second from the latter, multiples of a plain copy of the picture by as many
 * threads, and the same less the fixed costs of any method (loading, storing, depth to
 * radius), which the line "in focus" shows. Rounds of all lines alternate, so that the
 * load of the machine hits all alike.
 */
#include <stdio.h>
#include <time.h>

#include "physics/frames.h"
#include "portable.h"

enum { SIZE = 1024, MAX_LINES = 64 };

struct line {
    char name[64];
    int method, blend;
    double r_px, wall_s, cpu_s;
};

/* Memory that is kept from frame to frame, as a player would keep it: fresh pages cost
 * as much as some of the methods. Only the calling thread allocates. */
static struct block {
    void *memory;
    size_t n_bytes;
    bool is_used;
} blocks[32];

static void *keep_allocate(void *user, size_t n_bytes)
{
    struct block *b = blocks;
    while (b < blocks + 31 && b->memory && (b->is_used || b->n_bytes != n_bytes))
        b++;
    if (!b->memory)
        *b = (struct block){aligned_alloc(64, (n_bytes + 63) / 64 * 64), n_bytes, true};
    b->is_used = true;
    return b->memory;
}

static void keep_release(void *user, void *memory)
{
    for (int i = 0; i < 32; i++)
        if (blocks[i].memory == memory)
            blocks[i].is_used = false;
}

static double seconds(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void make_scene(struct frame *f, double r_px)
{
    uint32_t seed = 1;
    for (size_t i = 0; i < frame_pixels(f); i++) {
        double y = (double)(i / SIZE) / SIZE, x = (double)(i % SIZE) / SIZE;
        double r = r_px * (x * 12 - floor(x * 12) > 0.8 ? -0.9 : 2 * y - 1);
        f->depth[i] = plain_depth(r_px > 0 ? r : 0);
        for (int c = 0; c < 4; c++)
            f->colour[i * 4 + (size_t)c] = c == 3 ? 1 : (float)random_unit(&seed);
    }
}

static void measure(struct line *line, struct frame *f,
                    const struct rf_context *context)
{
    struct rf_params params;
    struct rf_filter *filter;
    plain_params(&params, line->method);
    params.blend = line->blend;
    params.blur_radius = line->r_px;
    params.max_radius = line->r_px > 0 ? line->r_px : 1;
    if (rf_filter_create(&filter, context, &params, SIZE, SIZE, NULL) != RF_OK)
        return;
    struct rf_view view = {.colour = rf_image_packed(f->colour, SIZE, SIZE, 4),
                           .depth = rf_image_packed(f->depth, SIZE, SIZE, 1)};
    struct rf_image out = rf_image_packed(f->out, SIZE, SIZE, 4);
    double wall = seconds(CLOCK_MONOTONIC), cpu = seconds(CLOCK_PROCESS_CPUTIME_ID);
    rf_filter_process(filter, &view, 1, &out, NULL, NULL);
    line->wall_s = fmin(line->wall_s, seconds(CLOCK_MONOTONIC) - wall);
    line->cpu_s = fmin(line->cpu_s, seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu);
    rf_filter_destroy(filter);
}

static double measure_copy(struct frame *f)
{
    double cpu = seconds(CLOCK_PROCESS_CPUTIME_ID);
    memcpy(f->out, f->colour, frame_bytes(f));
    return seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu;
}

static int list_lines(struct line *lines, const char *only)
{
    static const char *const blends[] = {"coc", "region"};
    static const double radii[] = {4, 64};
    const struct rf_method_info *methods = rf_method_list(NULL);
    int n = 0;
    lines[n++] = (struct line){"in focus", RF_METHOD_BOX, 0, 0, 1e9, 1e9};
    for (int m = RF_METHOD_BOX; m <= RF_METHOD_RECURSIVE_OFFSET; m++)
        for (int b = 0; b < 2; b++)
            for (int k = 0; k < 2 && n < MAX_LINES; k++) {
                if (only && strcmp(only, methods[m].name))
                    continue;
                lines[n] = (struct line){"", m, b, radii[k], 1e9, 1e9};
                snprintf(lines[n].name, sizeof lines[n].name, "%s %s %g px",
                         methods[m].name, blends[b], radii[k]);
                n++;
            }
    return n;
}

int main(int argc, char **argv)
{
    int n_threads = argc > 1 ? atoi(argv[1]) : 2,
        n_rounds = argc > 2 ? atoi(argv[2]) : 9;
    struct rf_context_params run = {.size = sizeof run,
                                    .n_threads = n_threads,
                                    .allocate = keep_allocate,
                                    .release = keep_release};
    struct rf_context *context;
    struct line lines[MAX_LINES];
    struct frame frames[3];
    double copy_s = 1e9;
    if (rf_context_create(&context, &run, NULL) != RF_OK)
        return 1;
    for (int i = 0; i < 3; i++) {
        frames[i] = frame_make(SIZE, SIZE, 4);
        make_scene(&frames[i], (const double[]){0, 4, 64}[i]);
    }
    int n = list_lines(lines, argc > 3 ? argv[3] : NULL);
    for (int round = 0; round < n_rounds; round++) {
        copy_s = fmin(copy_s, measure_copy(&frames[0]));
        for (int i = 0; i < n; i++)
            measure(&lines[i], &frames[lines[i].r_px > 4 ? 2 : lines[i].r_px > 0],
                    context);
    }
    printf("%-30s %8s %8s %8s %8s %8s\n", "", "wall ms", "cpu/n ms", "fps", "copies",
           "less");
    for (int i = 0; i < n; i++) {
        double t = lines[i].cpu_s / n_threads, copy = copy_s / n_threads;
        printf("%-30s %8.2f %8.2f %8.1f %8.1f %8.1f\n", lines[i].name,
               lines[i].wall_s * 1e3, t * 1e3, 1 / t, t / copy,
               (t - lines[0].cpu_s / n_threads) / copy);
    }
    printf("plain copy, %d threads: %.2f ms\n", n_threads, copy_s / n_threads * 1e3);
    for (int i = 0; i < 3; i++)
        frame_free(&frames[i]);
    rf_context_destroy(context);
    for (int i = 0; i < 32; i++)
        aligned_release(blocks[i].memory);
    return 0;
}
