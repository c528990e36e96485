/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depth from fog. POV-Ray shows through fog of distance D and colour K
 *
 *     B = A e + F + K (1 - e),   e = exp(-t / D)
 *
 *   A  what is seen without this fog    t  distance along the ray
 *   F  light of the scene's own fogs, which POV-Ray adds up side by side
 *
 * With F = 0 and A from a render without fog, e = (K - B) / (K - A). Where the scene
 * has fog, the difference of a lit and a black fog is used: 1 - e = (B - B0) / K. What
 * is about as bright as the fog shows no difference to it: there e = B0 / A, and where
 * A is beyond half floats, 1 - e = (B - B0) / K. Half floats carry 11 bits: the error
 * of t is about 2.4e-4 D (exp(t / D) - 1), so the near fog serves up to 1.5 D and the
 * far one from 2.5 D on, mixed in between.
 */
#include "decode.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"
#include "image.h"
#include "parallel.h"
#include "srgb.h"
#include "text.h"

#define MIX_FROM 1.5
#define MIX_TO 2.5
/* e below which nothing was hit: twice the step of a half float near 1. */
#define LEAST_LIGHT 1e-3
#define HALF_MAX 65504.0f
/* Share of the fog's light that a pixel may differ from it by and still tell its depth
 * well: the error of e grows with the inverse. */
#define BRIGHT 0.3

/* POV-Ray's files are of half floats: what is brighter than they can say is infinite
 * or the most that they can, and counted. */
static void clip(struct decode_picture *picture)
{
    const size_t n = (size_t)picture->width * (size_t)picture->height;
    for (size_t i = 0; i < n; i++) {
        bool is_clipped = false;
        for (int k = 0; k < 4; k++) {
            float *v = &picture->rgba[4 * i + k];
            is_clipped |= k < 3 && *v >= HALF_MAX;
            *v = *v != *v ? 0 : *v > HALF_MAX ? HALF_MAX : *v;
        }
        picture->n_clipped += is_clipped;
    }
}

bool decode_read(struct decode_picture *picture, const char *path, int n_threads,
                 struct povray_error *error)
{
    struct image_input *input = NULL;
    struct image_error image_error = {.message = ""};
    struct image_layer layer;
    int n;
    *picture = (struct decode_picture){0};
    bool is_read = image_open(&input, path, &image_error) &&
                   image_find_layer(input, NULL, NULL, false, &layer, &image_error);
    if (is_read) {
        const struct image_box box = image_parts(input, &n)->data_window;
        picture->width = box.max_x - box.min_x + 1;
        picture->height = box.max_y - box.min_y + 1;
        picture->has_alpha = layer.a >= 0;
        size_t n_samples = (size_t)picture->width * (size_t)picture->height * 4;
        picture->rgba = glue_alloc(n_samples, sizeof(float));
        is_read = picture->rgba &&
                  image_read(input, (const int[]){layer.r, layer.g, layer.b, layer.a},
                             4, picture->rgba, n_threads, &image_error);
        if (is_read)
            clip(picture);
    }
    image_close(input);
    if (!is_read) {
        snprintf(error->message, sizeof error->message, "%s", image_error.message);
        free(picture->rgba);
        picture->rgba = NULL;
    }
    return is_read;
}

double decode_value(const struct decode_space *space, double value)
{
    if (value <= 0)
        return 0;
    if (!space->is_srgb)
        return space->gamma == 1 ? value : pow(value, 1 / space->gamma);
    return srgb_encode((float)value);
}

bool decode_find_space(struct decode_space *space, const double seen[3],
                       const double shown[3])
{
    double sum = 0, error = 0;
    for (int c = 0; c < 3; c++)
        sum += log(fmax(seen[c], 1e-30)) / log(shown[c]);
    *space = (struct decode_space){sum / 3, false};
    for (int c = 0; c < 3; c++)
        error = fmax(error, fabs(decode_value(space, seen[c]) - shown[c]) / shown[c]);
    /* Half floats: 5e-4 of the value, less after the root. */
    if (error < 2e-3 && space->gamma > 0.2 && space->gamma < 20) {
        if (fabs(space->gamma - round(space->gamma * 100) / 100) < 1e-3)
            space->gamma = round(space->gamma * 100) / 100;
        return true;
    }
    *space = (struct decode_space){2.2, true};
    for (int c = 0; c < 3; c++)
        if (fabs(decode_value(space, seen[c]) - shown[c]) > 2e-3 * shown[c])
            return false;
    return true;
}

static double value_at(const struct decode_space *space, const float *rgba, size_t i,
                       int c)
{
    return decode_value(space, (double)rgba[4 * i + (size_t)c]);
}

static bool is_beyond_half(const float *rgba, size_t i)
{
    return rgba[4 * i] >= HALF_MAX || rgba[4 * i + 1] >= HALF_MAX ||
           rgba[4 * i + 2] >= HALF_MAX;
}

/* e of a pixel that is as bright as the fog, from the black fog; NAN where even that is
 * beyond half floats. */
static double bright_transmission(const struct decode_fog *fog,
                                  const struct decode_space *space, size_t i,
                                  bool *has_fog)
{
    double base = 0, dark = 0, lit = 0, light = 0;
    for (int c = 0; c < 3; c++) {
        base += value_at(space, fog->base, i, c);
        dark += value_at(space, fog->dark, i, c);
        lit += value_at(space, fog->fogged, i, c);
        light += fog->light[c];
    }
    *has_fog = true;
    if (is_beyond_half(fog->dark, i) || is_beyond_half(fog->fogged, i))
        return NAN;
    if (is_beyond_half(fog->base, i))
        return 1 - (lit - dark) / light;
    *has_fog = dark != base;
    return dark / base;
}

/* Share e of the light that came through one fog, NAN where that cannot be told;
 * *has_fog false where no fog was seen, *is_bright true where only a black fog tells.
 */
static double fog_transmission(const struct decode_fog *fog,
                               const struct decode_space *space, size_t i,
                               bool *has_fog, bool *is_bright)
{
    double sum = 0, weights = 0, light = 0;
    *has_fog = false;
    for (int c = 0; c < 3; c++) {
        double base = value_at(space, fog->base, i, c);
        double fogged = value_at(space, fog->fogged, i, c);
        double range = fog->light[c] - (fog->is_dark ? 0 : base);
        light += fog->light[c];
        if (range < 0.1 * fog->light[c])
            continue; /* as bright as the fog: says nothing */
        sum += range - (fogged - base);
        weights += range;
        *has_fog |= fogged != base;
    }
    if (weights >= BRIGHT * light)
        return sum / weights;
    *is_bright = true;
    if (fog->dark)
        return bright_transmission(fog, space, i, has_fog);
    *has_fog = true; /* not known yet */
    return weights > 0 ? sum / weights : 1;
}

static double distance_through(const struct decode_fog fogs[2],
                               const struct decode_space *space, size_t i,
                               bool *has_fog, bool *is_bright)
{
    bool is_near_seen, is_far_seen;
    double near_e = fog_transmission(&fogs[0], space, i, &is_near_seen, is_bright);
    double far_e = fog_transmission(&fogs[1], space, i, &is_far_seen, is_bright);
    *has_fog = is_near_seen || is_far_seen;
    double near_t = -log(fmax(near_e, 1e-9)), far_t = INFINITY;
    if (far_e > LEAST_LIGHT)
        far_t = -log(fmin(far_e, 1)) * fogs[1].distance;
    if (isnan(near_e) || isnan(far_e))
        return isnan(near_e) ? far_t : near_t * fogs[0].distance;
    double mix = (near_t - MIX_FROM) / (MIX_TO - MIX_FROM);
    near_t = fmax(near_t, 0) * fogs[0].distance;
    if (mix <= 0)
        return near_t;
    return mix >= 1 ? far_t : near_t + mix * (far_t - near_t);
}

/* What the threads share that decode a depth. */
struct decoding {
    const struct decode_fog *fogs;
    const struct decode_space *space;
    const struct povray_camera *camera;
    double axis_length;
    int32_t width, height;
    float *depth;
    _Atomic int64_t n_inside, n_bright, n_beyond;
};

static void decode_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct decoding *d = data;
    int64_t n_inside = 0, n_bright = 0, n_beyond = 0;
    for (int32_t y = (int32_t)begin; y < (int32_t)end; y++) {
        for (int32_t x = 0; x < d->width; x++) {
            size_t i = (size_t)y * (size_t)d->width + (size_t)x;
            bool has_fog, is_bright = false;
            double start[3], direction[3];
            double t = distance_through(d->fogs, d->space, i, &has_fog, &is_bright);
            camera_ray(d->camera, x + 0.5, y + 0.5, d->width, d->height, start,
                       direction);
            d->depth[i] = (float)(t * d->axis_length / vector_length(direction));
            n_inside += !has_fog;
            n_bright += is_bright;
            n_beyond += is_beyond_half(d->fogs[0].base, i);
        }
    }
    d->n_inside += n_inside;
    d->n_bright += n_bright;
    d->n_beyond += n_beyond;
}

struct decode_counts decode_depth(const struct decode_fog fogs[2],
                                  const struct decode_space *space,
                                  const struct povray_camera *camera,
                                  double axis_length, int32_t width, int32_t height,
                                  float *depth)
{
    struct decoding d = {.fogs = fogs,
                         .space = space,
                         .camera = camera,
                         .axis_length = axis_length,
                         .width = width,
                         .height = height,
                         .depth = depth};
    os_parallel(0, height, 0, decode_rows, &d);
    return (struct decode_counts){d.n_inside, d.n_bright, d.n_beyond};
}
