/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The filter with any parameters of params.def and any small picture: a result code or
 * a finite picture, on strided, padded and mirrored views.
 */
#include <math.h>

#include "bytes.h"
#include "rackfocus/rackfocus.h"

enum { MAX_SIDE = 24 };

/* A value of a parameter: its ends, its default, or one between. */
static double pick_value(struct bytes *b, const struct rf_param_info *p)
{
    int how = bytes_pick(b, 8);
    double k = bytes_take(b) / 255.0;
    double lo = p->min, hi = p->max, v;
    if (how == 0)
        return lo;
    if (how == 1)
        return hi;
    if (how == 2)
        return p->def;
    if (how < 6 && p->def > 0 && lo >= 0) /* around the default */
        v = p->def * exp((k - 0.5) * 6);
    else if (lo > 0)
        v = exp(log(lo) + k * (log(hi) - log(lo)));
    else
        v = lo + k * (hi - lo);
    if (p->type != RF_TYPE_FLOAT)
        v = floor(v);
    return fmin(fmax(v, lo), hi);
}

static void pick_params(struct bytes *b, struct rf_params *params)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    rf_params_init(params);
    params->lens_radius = 0.01 * bytes_take(b);
    params->focal_length_px = 20;
    for (int k = bytes_pick(b, 24); k > 0; k--) {
        const struct rf_param_info *p = &list[bytes_pick(b, (int)n)];
        PROMISE(rf_params_set_number(params, p->key, pick_value(b, p), NULL) == RF_OK);
    }
}

/* Numbers that renderers write, among them the worst. */
static float pick_number(struct bytes *b, bool is_depth)
{
    static const float odd[] = {0,        1,     1e-30f, 1e9f,      1e10f, 0.5f,
                                INFINITY, NAN,   -1,     65504,     1e6f,  -0.0f,
                                2,        1e-6f, 10,     0.999999f, 3,     1e-45f};
    int v = bytes_take(b);
    if (v < 18)
        return odd[v];
    return is_depth ? (float)v * 0.1f : (float)(v - 18) / 200;
}

struct picture {
    float *memory;
    struct rf_image image;
};

/* A view into memory with padding that must not be touched, perhaps mirrored. */
static struct picture make_picture(struct bytes *b, int width, int height, int channels)
{
    int pad = bytes_pick(b, 3), flip = bytes_pick(b, 4), row = width * channels + pad;
    struct picture p = {calloc((size_t)row * (size_t)height, sizeof(float)), {0}};
    p.image = rf_image_packed(p.memory, width, height, channels);
    p.image.row_bytes = row * (ptrdiff_t)sizeof(float);
    if (flip & 1) {
        p.image.data = p.memory + (size_t)row * (size_t)(height - 1);
        p.image.row_bytes = -p.image.row_bytes;
    }
    if (flip & 2) {
        p.image.data = (float *)p.image.data + (width - 1) * channels;
        p.image.pixel_bytes = -p.image.pixel_bytes;
    }
    for (int i = 0; i < row * height; i++)
        p.memory[i] = NAN;
    return p;
}

static float *sample(const struct rf_image *image, int x, int y, int c)
{
    return (float *)((char *)image->data + y * image->row_bytes +
                     x * image->pixel_bytes + c * image->channel_bytes);
}

static void fill(struct bytes *b, const struct rf_image *image, bool is_depth)
{
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++)
            for (int c = 0; c < image->channels; c++)
                *sample(image, x, y, c) = pick_number(b, is_depth);
}

static bool is_finite(const struct rf_image *image)
{
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++)
            for (int c = 0; c < image->channels; c++)
                if (!isfinite(*sample(image, x, y, c)))
                    return false;
    return true;
}

static void run(struct bytes *b, const struct rf_filter *filter, int width, int height)
{
    static const int channels[] = {1, 3, 4};
    int n_channels = channels[bytes_pick(b, 3)], n_views = 1 + bytes_pick(b, 3);
    struct rf_view views[3];
    struct picture colour[3], depth[3];
    struct rf_error error = {RF_OK, "", ""};
    bool is_good = true;
    for (int i = 0; i < n_views; i++) {
        colour[i] = make_picture(b, width, height, n_channels);
        depth[i] = make_picture(b, width, height, 1);
        fill(b, &colour[i].image, false);
        fill(b, &depth[i].image, true);
        is_good &= is_finite(&colour[i].image);
        const double u = bytes_take(b) * 0.01 - 1, v = bytes_take(b) * 0.01;
        views[i] = (struct rf_view){.size = sizeof views[i],
                                    .colour = colour[i].image,
                                    .depth = depth[i].image,
                                    .lens_offset = {u, v},
                                    .shear_distance = bytes_pick(b, 2) * 5.0};
    }
    struct picture out = make_picture(b, width, height, n_channels);
    rf_result result =
        rf_filter_process(filter, views, n_views, &out.image, NULL, &error);
    PROMISE(result == RF_OK || (error.code == result && error.message[0]));
    PROMISE(result != RF_ERROR_MEMORY && result != RF_ERROR_CANCELLED);
    PROMISE(result != RF_OK || !is_good || is_finite(&out.image));
    rf_filter_coc(filter, &depth[0].image, &depth[0].image, &error);
    free(out.memory);
    for (int i = 0; i < n_views; i++) {
        free(colour[i].memory);
        free(depth[i].memory);
    }
}

static void run_deep(struct bytes *b, const struct rf_filter *filter, int width,
                     int height)
{
    static const int channels[] = {1, 3, 4};
    enum { MOST = 5 };
    size_t n_pixels = (size_t)width * (size_t)height, n = 0;
    size_t *first = calloc(n_pixels + 1, sizeof *first);
    struct rf_deep_sample *samples = calloc(n_pixels * MOST, sizeof *samples);
    for (size_t i = 0; i < n_pixels; i++) {
        first[i] = n;
        for (int k = bytes_pick(b, MOST); k > 0; k--, n++) {
            samples[n].depth = pick_number(b, true);
            samples[n].depth_back = pick_number(b, true);
            samples[n].opacity = pick_number(b, false);
            for (int c = 0; c < 4; c++)
                samples[n].colour[c] = pick_number(b, false);
        }
    }
    first[n_pixels] = n;
    struct rf_deep deep = {width, height, first, samples};
    struct picture out = make_picture(b, width, height, channels[bytes_pick(b, 3)]);
    struct picture depth = make_picture(b, width, height, 1);
    struct rf_error error = {RF_OK, "", ""};
    rf_result result = rf_filter_process_deep(filter, &deep, &out.image, NULL, &error);
    PROMISE(result == RF_OK || (error.code == result && error.message[0]));
    PROMISE(result != RF_OK || is_finite(&out.image));
    result = rf_deep_flatten(filter, &deep, &out.image, &depth.image, &error);
    PROMISE(result == RF_OK || (error.code == result && error.message[0]));
    PROMISE(result != RF_OK || is_finite(&out.image));
    free(out.memory);
    free(depth.memory);
    free(first);
    free(samples);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct bytes b = {data, size};
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_error error = {RF_OK, "", ""};
    int width = 1 + bytes_pick(&b, MAX_SIDE), height = 1 + bytes_pick(&b, MAX_SIDE);
    pick_params(&b, &params);
    /* Time grows with radius and depth complexity; the code does not change. */
    bool is_deep = bytes_pick(&b, 4) == 0;
    params.max_radius = fmin(params.max_radius, is_deep ? 32 : 300);
    struct rf_context_params how = {.size = sizeof how, .n_threads = 1};
    PROMISE(rf_context_create(&context, &how, &error) == RF_OK);
    rf_result result =
        rf_filter_create(&filter, context, &params, width, height, &error);
    if (result == RF_OK) {
        if (is_deep)
            run_deep(&b, filter, width, height);
        else
            run(&b, filter, width, height);
        rf_filter_destroy(filter);
    } else {
        PROMISE(result == RF_ERROR_PARAMETER && error.message[0]);
    }
    rf_context_destroy(context);
    return 0;
}
