/* SPDX-License-Identifier: Apache-2.0 */
/*
 * With x the host's own picture, y ours, g the host's denoised with ours as guide, and
 * t(v) = clip(v)^(1/2.2):
 *
 *   q   = t(x) - t(y)
 *   m   = Gaussian mean of q, sigma 2 px
 *   se2 = (Gaussian mean of q^2 - m^2) / (4 pi sigma^2), the error of that mean
 *   w   = max(0, 1 - k se2 / m^2), k = 2, then Gaussian mean, sigma 1 px
 *   out = y + w (g - y)
 *
 * per channel: where the grain does not tell x from y, y is kept. g is the mean of two
 * pictures, guided by y alone and by y and the host's normals: one or the other is
 * better by up to 0.5 dB, with few samples the second. The estimate of the error is
 *
 *   e = sqrt(((1 - w) m)^2 + se2)
 *
 * of t, the largest of the channels. Ours. Worth, with passes of 64 samples in 8 views,
 * over the host's own lens denoised by albedo and normals, 64 own samples: foliage
 * + 4.6 dB, posts + 4.7; 16 own samples + 3.1 and + 4.3; one view + 3.4 and + 4.4.
 * k = 1 is 0.3 dB less, k = 3 as good. The guide alone 0.4 to 0.7 less.
 */
#include "finish.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "denoise.h"
#include "filter_many.h"
#include "filter_run.h"
#include "folder.h"
#include "interrupt.h"
#include "picture.h"
#include "report.h"
#include "settings.h"
#include "source.h"

static const double SIGMA_PX = 2, BLEND_SIGMA_PX = 1, CONTRADICTION = 2;

/* What one run holds; pictures are packed RGB of width x height. */
struct finish {
    const struct finish_options *tool;
    struct image_error *error;
    struct settings *settings;
    struct source own;
    float *samples; /* of the own picture, as source_read_colour() gives them */
    float *rgb, *ours, *guided;
    float *estimate; /* of the error, a channel */
    struct denoise_guides guides;
    struct denoiser *denoiser;
    int n_threads;
};

static size_t n_pixels(const struct finish *f)
{
    return (size_t)f->own.width * (size_t)f->own.height;
}

/* ---- mixing ----------------------------------------------------------------------- */

static float display_value(float v)
{
    return powf(fminf(fmaxf(v, 0), 1), 1 / 2.2f);
}

enum { MOST_REACH = 8 };

/* Weights of a Gaussian over 4 sigma, which sum to 1; returns the reach. */
static int make_gaussian(double sigma, float weights[2 * MOST_REACH + 1])
{
    const int reach = (int)(4 * sigma);
    double sum = 0;
    for (int i = -reach; i <= reach; i++)
        sum += exp(-i * i / (2 * sigma * sigma));
    for (int i = -reach; i <= reach; i++)
        weights[i + reach] = (float)(exp(-i * i / (2 * sigma * sigma)) / sum);
    return reach;
}

static int clamp(int v, int most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

/* Gaussian mean of a plane in place, its edges repeated; `room` is as large. */
static void smooth(float *plane, float *room, int width, int height, double sigma)
{
    float weights[2 * MOST_REACH + 1];
    const int reach = make_gaussian(sigma, weights);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float sum = 0;
            for (int i = -reach; i <= reach; i++)
                sum +=
                    weights[i + reach] *
                    plane[(size_t)y * (size_t)width + (size_t)clamp(x + i, width - 1)];
            room[(size_t)y * (size_t)width + (size_t)x] = sum;
        }
    for (int y = 0; y < height; y++) {
        float *row = plane + (size_t)y * (size_t)width;
        memset(row, 0, (size_t)width * sizeof(*row));
        for (int i = -reach; i <= reach; i++) {
            const float *from = room + (size_t)clamp(y + i, height - 1) * (size_t)width;
            for (int x = 0; x < width; x++)
                row[x] += weights[i + reach] * from[x];
        }
    }
}

/* Mixes one channel into f->ours; `planes` are three of them. */
static void mix_channel(struct finish *f, int channel, float *planes)
{
    const size_t n = n_pixels(f);
    float *mean = planes, *square = planes + n, *room = planes + 2 * n;
    for (size_t i = 0; i < n; i++) {
        const size_t k = 3 * i + (size_t)channel;
        mean[i] = display_value(f->rgb[k]) - display_value(f->ours[k]);
        square[i] = mean[i] * mean[i];
    }
    smooth(mean, room, f->own.width, f->own.height, SIGMA_PX);
    smooth(square, room, f->own.width, f->own.height, SIGMA_PX);
    const double n_averaged = 4 * 3.14159265358979 * SIGMA_PX * SIGMA_PX;
    float *weight = room;
    for (size_t i = 0; i < n; i++) {
        const double m2 = (double)mean[i] * mean[i];
        square[i] = (float)(fmax(square[i] - m2, 0) / n_averaged);
        weight[i] = (float)(m2 > 0 ? fmax(0, 1 - CONTRADICTION * square[i] / m2) : 0);
    }
    for (size_t i = 0; i < n; i++) {
        const double left = (1 - weight[i]) * mean[i];
        const float e = (float)sqrt(left * left + square[i]);
        f->estimate[i] = fmaxf(f->estimate[i], e);
    }
    smooth(weight, mean, f->own.width, f->own.height, BLEND_SIGMA_PX);
    for (size_t i = 0; i < n; i++) {
        const size_t k = 3 * i + (size_t)channel;
        f->ours[k] += weight[i] * (f->guided[k] - f->ours[k]);
    }
}

static int mix(struct finish *f)
{
    float *planes = app_memory(n_pixels(f), 3 * sizeof(float), f->error);
    f->estimate = app_memory(n_pixels(f), sizeof(float), f->error);
    if (!planes || !f->estimate) {
        free(planes);
        return APP_NO_MEMORY;
    }
    for (int c = 0; c < 3; c++)
        mix_channel(f, c, planes);
    free(planes);
    return APP_DONE;
}

/* ---- our picture ------------------------------------------------------------------ */

/* Do the guides have a depth, so that our picture is to be made of them? */
static int find_passes(struct finish *f, char *const *guides, int n, bool *are_passes)
{
    const struct source_request request = {.paths = guides, .n_paths = 1};
    struct source source;
    *are_passes = n > 1;
    if (*are_passes || picture_kind(guides[0]) != PICTURE_EXR)
        return APP_DONE;
    if (!source_open(&source, &request, f->error))
        return app_code_of(f->error);
    *are_passes = source.z >= 0;
    source_close(&source);
    return APP_DONE;
}

/* Filters passes to a temporary file. */
static int filter_passes(struct finish *f, char *const *guides, int n, const char *path)
{
    const struct filter_options how = {.output = path,
                                       .shown_output = guides[0],
                                       .type = FILTER_TYPE_FLOAT,
                                       .denoise = true,
                                       .n_threads = f->tool->n_threads,
                                       .host = f->tool->host};
    return filter_any(&how, f->settings, guides, n, f->error);
}

/* Reads our picture; `shown` is its name for errors. */
static int read_ours(struct finish *f, const char *path, const char *shown)
{
    struct picture picture;
    if (!picture_read(path, NULL, f->n_threads, &picture, f->error))
        return app_code_of(f->error);
    f->ours = picture.samples;
    if (picture.width == f->own.width && picture.height == f->own.height)
        return APP_DONE;
    return app_fail(f->error, APP_FAILED,
                    "%s: is %d x %d px and %s %d x %d; render both in one size", shown,
                    picture.width, picture.height, image_path(f->own.colour),
                    f->own.width, f->own.height);
}

static int make_ours(struct finish *f, char *const *guides, int n)
{
    char folder[1024], path[1100];
    bool are_passes;
    int code = find_passes(f, guides, n, &are_passes);
    if (code != APP_DONE)
        return code;
    if (!are_passes)
        return read_ours(f, guides[0], guides[0]);
    snprintf(path, sizeof(path), "%.900s/rackfocus-", os_folder_for_temporary());
    if (os_folder_make_temporary(path, folder, sizeof(folder)) != 0)
        return app_fail(f->error, APP_FAILED,
                        "%s: no temporary folder can be made there; name another in "
                        "TMPDIR",
                        os_folder_for_temporary());
    snprintf(path, sizeof(path), "%s/guide.exr", folder);
    code = filter_passes(f, guides, n, path);
    if (code == APP_DONE)
        code = read_ours(f, path, guides[0]);
    os_folder_remove(folder);
    return code;
}

/* ---- the own picture --------------------------------------------------------------- */

static int read_own(struct finish *f, const char *path)
{
    char *paths[] = {(char *)path};
    const struct source_request request = {.paths = paths, .n_paths = 1};
    if (!source_open(&f->own, &request, f->error))
        return app_code_of(f->error);
    if (f->own.layer.r < 0)
        return app_fail(f->error, APP_FAILED, "%s: has no colour", path);
    f->samples = source_read_colour(&f->own, f->n_threads, f->error);
    f->rgb = f->samples ? app_memory(n_pixels(f), 3 * sizeof(float), f->error) : NULL;
    if (!f->rgb || !denoise_read_guides(&f->own, f->n_threads, &f->guides, f->error))
        return app_code_of(f->error);
    const size_t n_channels = (size_t)f->own.n_channels;
    for (size_t i = 0; i < n_pixels(f); i++)
        for (size_t c = 0; c < 3; c++) {
            const float v = f->samples[n_channels * i + (n_channels >= 3 ? c : 0)];
            if (!isfinite(v))
                return app_fail(f->error, APP_FAILED,
                                "%s: pixel (%zu, %zu) is NaN or infinite; render it "
                                "again",
                                path, i % (size_t)f->own.width,
                                i / (size_t)f->own.width);
            f->rgb[3 * i + c] = v;
        }
    return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
}

/* Denoises a copy of the own picture in `rgb` by some guides. */
static int denoise(struct finish *f, float *rgb, const struct denoise_guides *guides)
{
    const struct denoise_picture picture = {rgb, f->own.width, f->own.height, 3,
                                            image_path(f->own.colour)};
    memcpy(rgb, f->rgb, 3 * n_pixels(f) * sizeof(*rgb));
    if (!denoise_picture(f->denoiser, &picture, guides, f->error))
        return app_code_of(f->error);
    return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
}

/* The mean of what our picture alone and our picture with the normals guide. */
static int denoise_by_ours(struct finish *f)
{
    const size_t n = 3 * n_pixels(f);
    float *memory = app_memory(n, 2 * sizeof(float), f->error);
    if (!memory)
        return APP_NO_MEMORY;
    float *limited = memory, *other = memory + n;
    for (size_t i = 0; i < n; i++)
        limited[i] = fminf(fmaxf(f->ours[i], 0), 1);
    struct denoise_guides by = {.albedo = limited, .are_clean = true};
    int code = denoise(f, f->guided, &by);
    if (code == APP_DONE && f->guides.normal) {
        by.normal = f->guides.normal;
        code = denoise(f, other, &by);
        for (size_t i = 0; i < n && code == APP_DONE; i++)
            f->guided[i] = (f->guided[i] + other[i]) / 2;
    }
    free(memory);
    return code;
}

/* ---- output ------------------------------------------------------------------------ */

static int write_estimate(const struct finish *f)
{
    static const char *const names[] = {"Y"};
    static const enum image_sample_type types[] = {IMAGE_SAMPLE_FLOAT};
    const struct image_output output = {.width = f->own.width,
                                        .height = f->own.height,
                                        .n_channels = 1,
                                        .channel_names = names,
                                        .types = types,
                                        .samples = f->estimate,
                                        .like = f->own.colour,
                                        .like_part = f->own.part};
    return image_write(f->tool->output_error, &output, f->n_threads, f->error)
               ? APP_DONE
               : app_code_of(f->error);
}

static int write_output(struct finish *f, const float *rgb)
{
    const size_t n_channels = (size_t)f->own.n_channels;
    const size_t n_colours = n_channels >= 3 ? 3 : 1;
    const struct filter_options how = {.output = f->tool->output,
                                       .type = f->tool->type,
                                       .png_bits = f->tool->png_bits,
                                       .n_threads = f->tool->n_threads,
                                       .host = f->tool->host};
    for (size_t i = 0; i < n_pixels(f); i++)
        for (size_t c = 0; c < n_colours; c++)
            f->samples[n_channels * i + c] = rgb[3 * i + c];
    if (!filter_write(&how, f->settings, &f->own, f->samples, f->error))
        return app_code_of(f->error);
    return f->tool->output_error ? write_estimate(f) : APP_DONE;
}

static int run(struct finish *f, const char *own, char *const *guides, int n)
{
    int code = read_own(f, own);
    if (code == APP_DONE && n > 0)
        code = make_ours(f, guides, n);
    if (code != APP_DONE)
        return code;
    f->guided = app_memory(n_pixels(f), 3 * sizeof(float), f->error);
    f->denoiser = f->guided ? denoiser_open(f->n_threads, f->error) : NULL;
    if (!f->denoiser)
        return app_code_of(f->error);
    app_begin(f->tool->host, "denoising");
    code = f->ours ? denoise_by_ours(f) : denoise(f, f->guided, &f->guides);
    app_end(f->tool->host);
    if (code == APP_DONE && f->ours)
        code = mix(f);
    return code == APP_DONE ? write_output(f, f->ours ? f->ours : f->guided) : code;
}

int finish_run(const struct finish_options *tool, struct settings *settings,
               const char *own, char *const *guides, int n_guides,
               struct image_error *error)
{
    struct finish f = {.tool = tool,
                       .error = error,
                       .settings = settings,
                       .n_threads = thread_count(tool->n_threads)};
    if (tool->output_error && n_guides == 0)
        return app_fail(error, APP_USAGE,
                        "--output-error: is told by our picture; give passes or a "
                        "filtered picture after the own one");
    const int code = run(&f, own, guides, n_guides);
    denoiser_close(f.denoiser);
    denoise_free_guides(&f.guides);
    free(f.estimate);
    free(f.guided);
    free(f.ours);
    free(f.rgb);
    free(f.samples);
    source_close(&f.own);
    return code;
}
