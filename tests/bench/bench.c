/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Times the methods on a synthetic frame and prints one JSON object per case, for
 * bench.py. All cases of one size take turns, run by run, so that a busy machine
 * disturbs all alike; the smallest time of each counts.
 *
 * Beside the methods runs a plain copy of the same buffers: 20 bytes read (RGBA and
 * depth) and 16 written per pixel by as many threads, the buffers rotating through 1 GB
 * so that no cache holds them.
 */
#include <stdio.h>
#include <time.h>

#include "parallel.h"
#include "physics/frames.h"

enum { MAX_LIST = 16, MAX_CASES = 512, COPIES_PER_RUN = 4 };
enum { FOCAL_PX = 1000, LENS_RADIUS = 40 }; /* of plain_params() */

struct size {
    int width, height;
};

/* A method, perhaps with parameters: "layered:sub-apertures=4". */
struct variant {
    char name[128];
    int method;
};

struct options {
    struct size sizes[MAX_LIST];
    double radii[MAX_LIST];
    struct variant variants[MAX_LIST];
    int threads[MAX_LIST];
    int n_sizes, n_radii, n_variants, n_threads;
    int n_runs, n_views;
    double limit_s; /* CPU */
    double slant_px;
    const char *dump;
};

/* What is measured: a variant at a radius, or the copy where there is none. */
struct bench_case {
    const struct variant *variant;
    int radius, n_threads; /* radius: index into the list */
    int n_views;
    double wall_s, cpu_s;
    int n_runs;
};

/* The frames of one size: one per radius, and views of the largest radius. */
struct scene {
    struct size size;
    struct frame frames[MAX_LIST];
    struct frame views[RF_MAX_VIEWS];
    float *copies;
    int n_copies, next_copy;
};

static double seconds(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- the scene ------------------------------------------------------------------ */

/* The radius and the kind of what is seen at a point of the middle view. */
enum surface { FLOOR, WALL, POST };

static double floor_radius(const struct size *size, double y, double r_px)
{
    return y > size->height / 3 ? r_px * (1 - 1.5 * y / size->height) : r_px;
}

static bool is_post(double x)
{
    return x - 240 * floor(x / 240) < 16;
}

static bool is_lamp(const struct size *size, double x, double y)
{
    uint32_t seed = (uint32_t)(int)floor(x) * 2654435761u + (uint32_t)(int)floor(y);
    random_unit(&seed);
    return y < size->height / 3 && random_unit(&seed) < 2e-4;
}

/*
 * A floor through the focus, posts before it, lamps and a wall behind, seen from the
 * point (u, v) of the unit lens: a point of radius r is shifted by (u, -v) r.
 */
static void fill_frame(struct frame *f, double r_px, double u, double v)
{
    struct size size = {f->width, f->height};
    for (int y = 0; y < f->height; y++) {
        double at_y = y, r = 0;
        for (int i = 0; i < 20; i++) { /* the floor's row whose shift ends here */
            r = floor_radius(&size, at_y, r_px);
            at_y = y + v * r;
        }
        for (int x = 0; x < f->width; x++) {
            float *c = frame_at(f, f->colour, x, y);
            double at_x = x - u * r, post_x = x + u * r_px * 0.8;
            bool in_post = is_post(post_x);
            bool in_lamp = is_lamp(&size, at_x, at_y);
            double texture =
                0.2 + 0.6 * (((int)floor(at_x / 16) + (int)floor(at_y / 16)) & 1);
            for (int k = 0; k < 3; k++)
                c[k] = in_post   ? 0.05f
                       : in_lamp ? 200
                                 : (float)(texture * (0.6 + 0.2 * k));
            c[3] = 1;
            f->depth[(size_t)y * (size_t)f->width + (size_t)x] =
                plain_depth(in_post ? -r_px * 0.8 : r);
        }
    }
}

/* Points spread evenly over the unit lens. */
static void lens_point(int i, int n, double *u, double *v)
{
    double rho = sqrt((i + 0.5) / n), angle = i * 2.399963;
    *u = rho * cos(angle);
    *v = rho * sin(angle);
}

/* Adds to the radii what a tilted lens would: up to so many px, at the right edge. */
static void slant(struct frame *f, double slant_px)
{
    for (size_t i = 0; slant_px != 0 && i < frame_pixels(f); i++) {
        double x = (double)(i % (size_t)f->width) + 0.5 - f->width / 2.0;
        double r = 400 - 40000 / (double)f->depth[i]; /* plain_depth() */
        f->depth[i] = plain_depth(r + slant_px * x / (f->width / 2.0));
    }
}

static void make_scene(struct scene *s, const struct options *o, int size)
{
    s->size = o->sizes[size];
    for (int i = 0; i < o->n_radii; i++) {
        s->frames[i] = frame_make(s->size.width, s->size.height, 4);
        fill_frame(&s->frames[i], o->radii[i], 0, 0);
        slant(&s->frames[i], o->slant_px);
    }
    for (int i = 0; i < o->n_views; i++) {
        double u, v;
        lens_point(i, o->n_views, &u, &v);
        s->views[i] = frame_make(s->size.width, s->size.height, 4);
        fill_frame(&s->views[i], o->radii[o->n_radii - 1], u, v);
    }
    size_t set = (size_t)s->size.width * (size_t)s->size.height * 9;
    s->n_copies = (int)(((size_t)1 << 30) / (set * sizeof(float))) + 1;
    size_t n = (size_t)s->n_copies * set;
    s->copies = malloc(n * sizeof(float));
    if (!s->copies)
        abort();
    /* Not zeros: pages that were never written would all be one, which caches hold. */
    for (size_t i = 0; i < n; i++)
        s->copies[i] = (float)(i & 1023);
}

static void free_scene(struct scene *s, const struct options *o)
{
    for (int i = 0; i < o->n_radii; i++)
        frame_free(&s->frames[i]);
    for (int i = 0; i < o->n_views; i++)
        frame_free(&s->views[i]);
    free(s->copies);
}

/* ---- one run -------------------------------------------------------------------- */

static void keep_least(struct bench_case *c, double wall, double cpu)
{
    c->wall_s = fmin(c->wall_s, seconds(CLOCK_MONOTONIC) - wall);
    c->cpu_s = fmin(c->cpu_s, seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu);
}

struct copy {
    float *to;
    const float *from, *depth;
};

static void copy_some(void *data, int64_t begin, int64_t end, int thread)
{
    const struct copy *copy = data;
    for (int64_t i = begin; i < end; i++) {
        float d = copy->depth[i];
        for (int c = 0; c < 4; c++)
            copy->to[4 * i + c] = copy->from[4 * i + c] + d;
    }
}

/* One frame's worth of traffic: all of `depth` and `from` read, `to` written. */
static void copy_frame(float *to, const float *from, const float *depth, long n,
                       int n_threads)
{
    struct copy copy = {to, from, depth};
    os_parallel(n_threads, n, 0, copy_some, &copy);
}

static void run_copy(struct bench_case *c, struct scene *s)
{
    long n = (long)s->size.width * s->size.height;
    for (int i = 0; i < COPIES_PER_RUN; i++) {
        float *at = s->copies + s->next_copy * n * 9;
        s->next_copy = (s->next_copy + 1) % s->n_copies;
        double wall = seconds(CLOCK_MONOTONIC), cpu = seconds(CLOCK_PROCESS_CPUTIME_ID);
        copy_frame(at, at + 4 * n, at + 8 * n, n, c->n_threads);
        keep_least(c, wall, cpu);
    }
}

static struct rf_view view_of(const struct frame *f)
{
    return (struct rf_view){.colour =
                                rf_image_packed(f->colour, f->width, f->height, 4),
                            .depth = rf_image_packed(f->depth, f->width, f->height, 1)};
}

static void die(const struct rf_error *error)
{
    fprintf(stderr, "bench: %s: %s\n", error->field, error->message);
    exit(1);
}

/* What stands after the method's name. */
static void set_parameters(struct rf_params *params, const char *name)
{
    char text[sizeof((struct variant *)0)->name];
    struct rf_error error;
    char *rest;
    snprintf(text, sizeof text, "%s", name);
    strtok_r(text, ":", &rest);
    for (char *item; (item = strtok_r(NULL, ":", &rest));) {
        char *value = strchr(item, '=');
        if (value)
            *value++ = 0;
        if (rf_params_set(params, item, value ? value : "true", &error) != RF_OK)
            die(&error);
    }
}

/* The filter is made beforehand, as a program that filters many frames has it. */
static void run_method(struct bench_case *c, struct scene *s,
                       struct rf_context *context)
{
    struct frame *f = &s->frames[c->radius];
    struct rf_view views[RF_MAX_VIEWS] = {view_of(f)};
    struct rf_image out = rf_image_packed(f->out, f->width, f->height, 4);
    struct rf_filter *filter;
    struct rf_params params;
    struct rf_error error;
    plain_params(&params, c->variant->method);
    set_parameters(&params, c->variant->name);
    for (int i = 0; c->n_views > 1 && i < c->n_views; i++) {
        double u, v;
        lens_point(i, c->n_views, &u, &v);
        views[i] = view_of(&s->views[i]);
        views[i].lens_offset[0] = u * LENS_RADIUS;
        views[i].lens_offset[1] = v * LENS_RADIUS;
        views[i].shear_distance = PLAIN_FOCUS;
    }
    if (rf_filter_create(&filter, context, &params, f->width, f->height, &error) !=
        RF_OK)
        die(&error);
    double wall = seconds(CLOCK_MONOTONIC), cpu = seconds(CLOCK_PROCESS_CPUTIME_ID);
    if (rf_filter_process(filter, views, c->n_views, &out, NULL, &error) != RF_OK)
        die(&error);
    keep_least(c, wall, cpu);
    rf_filter_destroy(filter);
}

/* ---- all cases ------------------------------------------------------------------ */

static int list_cases(const struct options *o, struct bench_case *cases)
{
    static const struct variant views = {"views", RF_METHOD_VIEWS};
    int n = 0;
    for (int t = 0; t < o->n_threads; t++)
        cases[n++] = (struct bench_case){.n_threads = o->threads[t]};
    for (int m = 0; m < o->n_variants; m++)
        for (int r = 0; r < o->n_radii; r++)
            for (int t = 0; t < o->n_threads; t++)
                cases[n++] = (struct bench_case){.variant = &o->variants[m],
                                                 .radius = r,
                                                 .n_threads = o->threads[t],
                                                 .n_views = 1};
    for (int t = 0; o->n_views > 1 && t < o->n_threads; t++)
        cases[n++] = (struct bench_case){.variant = &views,
                                         .radius = o->n_radii - 1,
                                         .n_threads = o->threads[t],
                                         .n_views = o->n_views};
    for (int i = 0; i < n; i++)
        cases[i].wall_s = cases[i].cpu_s = 1e30;
    return n;
}

/* What a case that has not run will take: grows from the last radius as it grew to it,
 * at most with the area of the blur. Radius 0 is a copy and tells nothing. */
static double expect_s(const struct options *o, const struct bench_case *c)
{
    const struct bench_case *last = c - o->n_threads, *before = last - o->n_threads;
    if (!c->variant || c->n_views > 1 || c->radius == 0)
        return 0;
    if (last->n_runs == 0)
        return 1e30;
    if (c->radius < 2 || o->radii[c->radius - 2] == 0)
        return last->cpu_s;
    double to = o->radii[c->radius] / o->radii[c->radius - 1];
    return last->cpu_s * fmin(fmax(last->cpu_s / before->cpu_s, 1), to * to);
}

/* The first run asks whether the limit allows it, the others whether any is left. */
static bool is_too_slow(const struct options *o, const struct bench_case *c)
{
    if (!c->variant)
        return false;
    return (c->n_runs > 0 ? c->cpu_s * (c->n_runs + 1) : expect_s(o, c)) > o->limit_s;
}

static void print_case(const struct options *o, const struct scene *s,
                       const struct bench_case *c, const char *cpu)
{
    printf("{\"name\": \"%s\", \"width\": %d, \"height\": %d, \"threads\": %d, "
           "\"cpu\": \"%s\"",
           c->variant ? c->variant->name : "copy", s->size.width, s->size.height,
           c->n_threads, cpu);
    if (c->variant)
        printf(", \"radius\": %g, \"views\": %d", o->radii[c->radius], c->n_views);
    if (c->n_runs > 0)
        printf(", \"wall_s\": %.6f, \"cpu_s\": %.6f", c->wall_s, c->cpu_s);
    printf(", \"runs\": %d}\n", c->n_runs);
}

static void run_cases(const struct options *o, struct scene *s)
{
    struct bench_case cases[MAX_CASES];
    struct rf_context *contexts[MAX_LIST];
    struct rf_error error;
    int n = list_cases(o, cases);
    for (int t = 0; t < o->n_threads; t++) {
        struct rf_context_params run = {.size = sizeof run, .n_threads = o->threads[t]};
        if (rf_context_create(&contexts[t], &run, &error) != RF_OK)
            die(&error);
    }
    for (int run = 0; run < o->n_runs; run++)
        for (struct bench_case *c = cases; c < cases + n; c++) {
            int t = 0;
            while (o->threads[t] != c->n_threads)
                t++;
            if (is_too_slow(o, c))
                continue;
            if (!c->variant)
                run_copy(c, s);
            else
                run_method(c, s, contexts[t]);
            c->n_runs++;
        }
    for (struct bench_case *c = cases; c < cases + n; c++)
        print_case(o, s, c, rf_context_cpu(contexts[0]));
    fflush(stdout);
    for (int t = 0; t < o->n_threads; t++)
        rf_context_destroy(contexts[t]);
}

/* The frame as other programs' wrappers take it: width, height, largest radius, RGBA,
 * signed radii. */
static int dump_frame(const struct options *o)
{
    const struct size *size = &o->sizes[0];
    float r_px = (float)o->radii[0];
    struct frame f = frame_make(size->width, size->height, 4);
    size_t n = frame_pixels(&f);
    fill_frame(&f, o->radii[0], 0, 0);
    for (size_t i = 0; i < n; i++)
        f.depth[i] = 400 - 40000 / f.depth[i];
    FILE *file = fopen(o->dump, "wb");
    bool is_good = file && fwrite(size, sizeof *size, 1, file) == 1 &&
                   fwrite(&r_px, sizeof r_px, 1, file) == 1 &&
                   fwrite(f.colour, sizeof(float), 4 * n, file) == 4 * n &&
                   fwrite(f.depth, sizeof(float), n, file) == n;
    if (file && fclose(file) != 0)
        is_good = false;
    if (!is_good)
        perror(o->dump);
    frame_free(&f);
    return is_good ? 0 : 1;
}

/* ---- options -------------------------------------------------------------------- */

static int usage(FILE *to)
{
    fprintf(to,
            "Usage: bench [--sizes WxH,...] [--radii PX,...] [--methods "
            "NAME[:KEY=VALUE],...]\n"
            "             [--threads N,...] [--runs N] [--limit SECONDS] [--views N]\n"
            "             [--slant PX]\n"
            "       bench --dump FILE --sizes WxH --radii PX\n\nMethods:");
    size_t n;
    const struct rf_method_info *methods = rf_method_list(&n);
    for (size_t i = 0; i < n; i++)
        fprintf(to, " %s", methods[i].name);
    fprintf(to, "\n");
    return to == stderr ? 2 : 0;
}

/* Parses one item into the k-th place of the list that `name` means. */
static bool parse_item(struct options *o, const char *name, const char *item, int k)
{
    size_t n;
    const struct rf_method_info *methods = rf_method_list(&n);
    if (!strcmp(name, "--sizes")) {
        o->n_sizes = k + 1;
        return sscanf(item, "%dx%d", &o->sizes[k].width, &o->sizes[k].height) == 2 &&
               o->sizes[k].width > 0 && o->sizes[k].height > 0;
    }
    if (!strcmp(name, "--radii")) {
        o->n_radii = k + 1;
        o->radii[k] = atof(item);
        return o->radii[k] >= 0 && o->radii[k] < 400;
    }
    if (!strcmp(name, "--threads")) {
        o->n_threads = k + 1;
        o->threads[k] = atoi(item);
        return o->threads[k] > 0;
    }
    if (strcmp(name, "--methods") != 0)
        return false;
    o->n_variants = k + 1;
    snprintf(o->variants[k].name, sizeof o->variants[k].name, "%s", item);
    for (size_t i = 0; i < n; i++)
        if (!strncmp(item, methods[i].name, strcspn(item, ":")) &&
            methods[i].name[strcspn(item, ":")] == 0) {
            o->variants[k].method = (int)i;
            return true;
        }
    return false;
}

static bool parse_list(struct options *o, const char *name, const char *value)
{
    char text[2048];
    int k = 0;
    snprintf(text, sizeof text, "%s", value);
    if (!strcmp(name, "--methods"))
        o->n_variants = 0; /* an empty list is only the copies */
    for (char *rest, *item = strtok_r(text, ",", &rest); item;
         item = strtok_r(NULL, ",", &rest), k++)
        if (k >= MAX_LIST || !parse_item(o, name, item, k))
            return false;
    return true;
}

static bool parse(struct options *o, int argc, char **argv)
{
    for (int i = 1; i < argc; i += 2) {
        const char *name = argv[i];
        if (i + 1 >= argc)
            return false;
        if (!strcmp(name, "--runs"))
            o->n_runs = atoi(argv[i + 1]);
        else if (!strcmp(name, "--limit"))
            o->limit_s = atof(argv[i + 1]);
        else if (!strcmp(name, "--views"))
            o->n_views = atoi(argv[i + 1]);
        else if (!strcmp(name, "--dump"))
            o->dump = argv[i + 1];
        else if (!strcmp(name, "--slant"))
            o->slant_px = atof(argv[i + 1]);
        else if (!parse_list(o, name, argv[i + 1]))
            return false;
    }
    return o->n_runs > 0 && o->n_views >= 0 && o->n_views <= RF_MAX_VIEWS;
}

int main(int argc, char **argv)
{
    struct options o = {.sizes = {{1920, 1080}},
                        .radii = {0, 2, 8, 32, 128},
                        .variants = {{"layered", RF_METHOD_LAYERED}},
                        .threads = {1, 2},
                        .n_sizes = 1,
                        .n_radii = 5,
                        .n_variants = 1,
                        .n_threads = 2,
                        .n_runs = 3,
                        .limit_s = 10};
    if (argc > 1 && !strcmp(argv[1], "--help"))
        return usage(stdout);
    if (!parse(&o, argc, argv))
        return usage(stderr);
    if (o.dump)
        return dump_frame(&o);
    for (int i = 0; i < o.n_sizes; i++) {
        struct scene scene = {0};
        make_scene(&scene, &o, i);
        run_cases(&o, &scene);
        free_scene(&scene, &o);
    }
    return 0;
}
