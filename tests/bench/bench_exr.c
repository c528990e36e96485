/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How fast files are read and written: 1920 x 1080, RGB half and Z float, in wall and
 * CPU milliseconds with 1 and 2 threads, and the conversion of halves by single values
 * against runs (F16C where the processor has it). The smallest of several times, in
 * turns.
 *
 *     bench_exr [RUNS]
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "exr_private.h"
#include "../exr/rgbz.h"

enum { WIDTH = 1920, HEIGHT = 1080, N_CHANNELS = 4, N_PIXELS = WIDTH * HEIGHT };

struct span_ms {
    double wall, cpu;
};

static double now_ms(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static struct span_ms start(void)
{
    return (struct span_ms){now_ms(CLOCK_MONOTONIC), now_ms(CLOCK_PROCESS_CPUTIME_ID)};
}

static void stop(struct span_ms *best, struct span_ms since)
{
    best->wall = fmin(best->wall, now_ms(CLOCK_MONOTONIC) - since.wall);
    best->cpu = fmin(best->cpu, now_ms(CLOCK_PROCESS_CPUTIME_ID) - since.cpu);
}

static void check(bool is_good, const struct image_error *error)
{
    if (is_good)
        return;
    fprintf(stderr, "bench_exr: %s\n", error->message);
    exit(1);
}

static void write_picture(const char *path, const char *compression,
                          const float *samples, int n_threads)
{
    const struct image_box box = {0, 0, WIDTH - 1, HEIGHT - 1};
    struct image_output output = rgbz_output(box, compression, 0);
    output.samples = samples;
    struct image_error error;
    check(image_write(path, &output, n_threads, &error), &error);
}

static void read_picture(const char *path, float *samples, int n_threads)
{
    struct image_input *input;
    struct image_error error;
    struct image_layer layer;
    check(image_open(&input, path, &error), &error);
    check(image_find_layer(input, NULL, NULL, false, &layer, &error), &error);
    const int channels[] = {layer.r, layer.g, layer.b, layer.z};
    check(image_read(input, channels, N_CHANNELS, samples, n_threads, &error), &error);
    image_close(input);
}

static void bench_files(const char *path, const char *compression, float *samples,
                        int n_runs)
{
    struct span_ms write[2], read[2];
    for (int t = 0; t < 2; t++)
        write[t] = read[t] = (struct span_ms){1e30, 1e30};
    for (int run = 0; run < n_runs; run++)
        for (int t = 0; t < 2; t++) {
            struct span_ms since = start();
            write_picture(path, compression, samples, t + 1);
            stop(&write[t], since);
            since = start();
            read_picture(path, samples, t + 1);
            stop(&read[t], since);
        }
    for (int t = 0; t < 2; t++)
        printf("%-5s %d thread%s  write %7.1f ms (CPU %7.1f)  read %7.1f ms (CPU "
               "%7.1f)\n",
               compression, t + 1, t ? "s" : " ", write[t].wall, write[t].cpu,
               read[t].wall, read[t].cpu);
}

/* One thread; `is_run` converts runs, else one value after the other. */
static void convert(float *samples, uint16_t *halves, bool is_run,
                    struct span_ms best[2])
{
    struct span_ms since = start();
    if (is_run)
        image_floats_to_halves((uint8_t *)halves, samples, N_CHANNELS, N_PIXELS);
    for (size_t i = 0; !is_run && i < N_PIXELS; i++)
        halves[i] = image_float_to_half(samples[i * N_CHANNELS]);
    stop(&best[0], since);
    since = start();
    if (is_run)
        image_halves_to_floats(samples, N_CHANNELS, (const uint8_t *)halves, N_PIXELS);
    for (size_t i = 0; !is_run && i < N_PIXELS; i++)
        samples[i * N_CHANNELS] = image_half_to_float(halves[i]);
    stop(&best[1], since);
}

static void bench_halves(float *samples, uint16_t *halves, int n_runs)
{
    struct span_ms best[2][2];
    for (int i = 0; i < 4; i++)
        best[i / 2][i % 2] = (struct span_ms){1e30, 1e30};
    for (int run = 0; run < n_runs; run++)
        for (int is_run = 0; is_run < 2; is_run++)
            convert(samples, halves, is_run, best[is_run]);
    printf("one channel of 1920 x 1080, 1 thread, CPU: to half %.2f ms by values, %.2f "
           "by runs; to float %.2f, %.2f (F16C: %s)\n",
           best[0][0].cpu, best[1][0].cpu, best[0][1].cpu, best[1][1].cpu,
           image_has_f16c() ? "yes" : "no");
}

int main(int argc, char **argv)
{
    int n_runs = argc > 1 ? atoi(argv[1]) : 5;
    char path[] = "/tmp/rackfocus-bench-XXXXXX.exr";
    float *samples = malloc(sizeof *samples * N_PIXELS * N_CHANNELS);
    uint16_t *halves = malloc(sizeof *halves * N_PIXELS);
    int fd = mkstemps(path, 4);
    if (!samples || !halves || fd < 0)
        return 1;
    close(fd);
    uint32_t seed = 1;
    for (size_t i = 0; i < (size_t)N_PIXELS * N_CHANNELS; i++) {
        seed = seed * 1664525u + 1013904223u;
        samples[i] = (float)(i / 4 % WIDTH) / WIDTH + (float)(seed >> 20) / 65536;
    }
    bench_halves(samples, halves, 4 * n_runs);
    for (int i = 0; i < 3; i++)
        bench_files(path, (const char *const[]){"none", "zip", "piz"}[i], samples,
                    n_runs);
    unlink(path);
    free(samples);
    free(halves);
    return 0;
}
