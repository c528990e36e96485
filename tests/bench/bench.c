/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Speed of the methods on synthetic frames of 1920 x 1080, in ms and as multiples of a
 * plain copy of the same buffers: 20 bytes read (RGBA and depth) and 16 written per
 * pixel by the same threads, the buffers rotating through 1 GB so that no cache holds
 * them. The smallest of several runs counts.
 */
#include <stdio.h>
#include <time.h>

#include "physics/frames.h"

enum { COPY_RUNS = 12 };

struct options {
    int width, height, n_runs;
    const char *method; /* NULL: all */
    double radius;      /* 0: all */
    int threads;        /* 0: 1 and 2 */
};

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

/* One frame's worth of traffic: all of `depth` and `from` read, `to` written. */
static void copy_frame(float *to, const float *from, const float *depth, long n,
                       int n_threads)
{
#pragma omp parallel for num_threads(n_threads) schedule(static)
    for (long i = 0; i < n; i++) {
        float d = depth[i];
        for (int c = 0; c < 4; c++)
            to[4 * i + c] = from[4 * i + c] + d;
    }
}

static double copy_ms(const struct options *o, int n_threads)
{
    long n = (long)o->width * o->height;
    long set = n * 9; /* floats of one set of buffers */
    int n_sets = (int)((1L << 30) / (set * (long)sizeof(float))) + 1;
    float *memory = malloc((size_t)(n_sets * set) * sizeof *memory);
    double best = 1e30;
    if (!memory)
        return 0;
#pragma omp parallel for num_threads(n_threads) schedule(static)
    for (long i = 0; i < n_sets * set; i++)
        memory[i] = 0;
    for (int i = 0; i < COPY_RUNS + n_sets; i++) {
        float *at = memory + (i % n_sets) * set;
        double start = now_ms();
        copy_frame(at, at + 4 * n, at + 8 * n, n, n_threads);
        best = fmin(best, now_ms() - start);
    }
    free(memory);
    return best;
}

/* A floor through the focus, posts before it, lamps and a wall behind. */
static struct frame bench_frame(const struct options *o, double r_px)
{
    struct frame f = frame_make(o->width, o->height, 4);
    uint32_t seed = 1;
    for (int y = 0; y < f.height; y++)
        for (int x = 0; x < f.width; x++) {
            float *c = frame_at(&f, f.colour, x, y);
            double r = y > f.height / 3 ? r_px * (1 - 1.5 * y / f.height) : r_px;
            bool is_post = x % 240 < 16;
            bool is_lamp = y < f.height / 3 && random_unit(&seed) < 2e-4;
            if (is_post)
                r = -r_px * 0.8;
            double texture = 0.2 + 0.6 * ((x / 16 + y / 16) % 2);
            for (int k = 0; k < 3; k++)
                c[k] = is_post   ? 0.05f
                       : is_lamp ? 200
                                 : (float)(texture * (0.6 + 0.2 * k));
            c[3] = 1;
            f.depth[(size_t)y * (size_t)f.width + (size_t)x] = plain_depth(r);
        }
    return f;
}

/* The smallest time of the filter alone, with contexts made beforehand. */
static double filter_ms(const struct options *o, struct frame *f, int method,
                        int n_threads)
{
    struct rf_context_params run = {.size = sizeof run, .n_threads = n_threads};
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    struct rf_error error;
    double best = 1e30;
    plain_params(&params, method);
    if (rf_context_create(&context, &run, &error) != RF_OK)
        return NAN;
    if (rf_filter_create(&filter, context, &params, f->width, f->height, &error) !=
        RF_OK)
        return NAN;
    struct rf_view view = {.colour = rf_image_packed(f->colour, f->width, f->height, 4),
                           .depth = rf_image_packed(f->depth, f->width, f->height, 1)};
    struct rf_image out = rf_image_packed(f->out, f->width, f->height, 4);
    for (int i = 0; i < o->n_runs; i++) {
        double start = now_ms();
        if (rf_filter_process(filter, &view, 1, &out, NULL, &error) != RF_OK) {
            fprintf(stderr, "%s: %s\n", error.field, error.message);
            best = NAN;
            break;
        }
        best = fmin(best, now_ms() - start);
    }
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return best;
}

static void bench_method(const struct options *o, int method, const double copies[2])
{
    static const double radii[] = {2, 8, 32, 128};
    size_t n;
    const char *name = rf_method_list(&n)[method].name;
    for (int k = 0; k < 4; k++) {
        if (o->radius > 0 && radii[k] != o->radius)
            continue;
        struct frame f = bench_frame(o, radii[k]);
        double one = NAN;
        for (int threads = 1; threads <= 2; threads++) {
            if (o->threads && threads != o->threads)
                continue;
            double ms = filter_ms(o, &f, method, threads);
            printf("%-10s r <= %3g px  %d thread%s %9.1f ms %8.0f copies", name,
                   radii[k], threads, threads > 1 ? "s" : " ", ms,
                   ms / copies[threads - 1]);
            if (threads == 2 && !o->threads)
                printf("   %.2f times as fast", one / ms);
            printf("\n");
            fflush(stdout);
            one = ms;
        }
        frame_free(&f);
    }
}

static int usage(FILE *to)
{
    fprintf(to, "Usage: bench [--method NAME] [--radius 2|8|32|128] [--threads 1|2]\n"
                "             [--size WIDTHxHEIGHT] [--runs N]\n\nMethods:");
    size_t n;
    const struct rf_method_info *methods = rf_method_list(&n);
    for (size_t i = 0; i < n; i++)
        fprintf(to, " %s", methods[i].name);
    fprintf(to, "\n");
    return to == stderr ? 2 : 0;
}

static bool parse(struct options *o, int argc, char **argv)
{
    for (int i = 1; i < argc; i += 2) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : "";
        if (!strcmp(name, "--method"))
            o->method = value;
        else if (!strcmp(name, "--radius"))
            o->radius = atof(value);
        else if (!strcmp(name, "--threads"))
            o->threads = atoi(value);
        else if (!strcmp(name, "--runs"))
            o->n_runs = atoi(value);
        else if (strcmp(name, "--size") ||
                 sscanf(value, "%dx%d", &o->width, &o->height) != 2)
            return false;
    }
    return o->n_runs > 0 && o->width > 0 && o->height > 0 && o->threads >= 0 &&
           o->threads <= 2;
}

int main(int argc, char **argv)
{
    struct options o = {.width = 1920, .height = 1080, .n_runs = 3};
    if (argc > 1 && (!strcmp(argv[1], "--list") || !strcmp(argv[1], "--help")))
        return usage(stdout);
    if (!parse(&o, argc, argv))
        return usage(stderr);
    double copies[2] = {copy_ms(&o, 1), copy_ms(&o, 2)};
    printf(
        "%d x %d, RGBA and depth; a cold copy of the buffers: %.2f ms with 1 thread, "
        "%.2f ms with 2\n",
        o.width, o.height, copies[0], copies[1]);
    size_t n;
    const struct rf_method_info *methods = rf_method_list(&n);
    for (size_t m = 0; m < n; m++)
        if (!o.method || !strcmp(o.method, methods[m].name))
            bench_method(&o, (int)m, copies);
    return 0;
}
