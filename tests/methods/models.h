/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The previews in double precision, written from the formulas of docs/methods.md and
 * not from the code: slow, pixel by pixel. One plane at a time.
 */
#ifndef RF_TEST_MODELS_H
#define RF_TEST_MODELS_H

#include <math.h>

#include "physics/frames.h"
#include "testing.h"

struct plane {
    int width, height;
    double *at;
};

static inline struct plane plane_make(int width, int height)
{
    struct plane p = {width, height, calloc((size_t)(width * height), sizeof(double))};
    if (!p.at)
        abort();
    return p;
}

static inline void plane_free(struct plane *p)
{
    free(p->at);
}

/* The pixel, continued beyond the border. */
static inline double pixel(const struct plane *p, int x, int y)
{
    x = x < 0 ? 0 : x >= p->width ? p->width - 1 : x;
    y = y < 0 ? 0 : y >= p->height ? p->height - 1 : y;
    return p->at[y * p->width + x];
}

/* Bilinear between samples whose first one lies at 0. */
static inline double bilinear(const struct plane *p, double u, double v)
{
    int i = (int)floor(u), j = (int)floor(v);
    double fx = u - i, fy = v - j;
    return (1 - fy) * ((1 - fx) * pixel(p, i, j) + fx * pixel(p, i + 1, j)) +
           fy * ((1 - fx) * pixel(p, i, j + 1) + fx * pixel(p, i + 1, j + 1));
}

/* ---- generators: `radius` in px per pixel, signed ------------------------------- */

/* Mean over the part of [centre - w/2, centre + w/2] that lies in the line. */
static inline double line_mean(const double *line, int step, int n, double centre,
                               double w)
{
    double sum = 0, total = 0;
    for (int i = 0; i < n; i++) {
        double overlap = fmin(centre + w / 2, i + 1) - fmax(centre - w / 2, i);
        if (overlap > 0) {
            sum += overlap * line[i * step];
            total += overlap;
        }
    }
    return sum / total;
}

/* Mean square distance of the pixels of a box about its middle pixel. */
static inline double box_spread(double w)
{
    double sum = 0;
    for (int i = -(int)ceil(w); i <= (int)ceil(w); i++)
        sum += fmax(0, fmin(w / 2, i + 0.5) - fmax(-w / 2, i - 0.5)) * i * i;
    return sum / w;
}

/* The width at which n boxes spread as a disc of radius r, by bisection. */
static inline double box_size(double r, int n)
{
    double low = 1, high = 4 * fabs(r) + 2;
    for (int i = 0; i < 60; i++) {
        double w = (low + high) / 2;
        if (n * box_spread(w) < r * r / 4)
            low = w;
        else
            high = w;
    }
    return low;
}

static inline void model_box(const struct plane *in, const double *radius,
                             const struct rf_params *p, struct plane *out)
{
    int w = in->width, h = in->height;
    struct plane from = plane_make(w, h), rows = plane_make(w, h);
    memcpy(from.at, in->at, sizeof(double) * (size_t)(w * h));
    for (int n = 0; n < p->box_repeats; n++) {
        for (int i = 0; i < w * h; i++) {
            double size = box_size(radius[i], p->box_repeats);
            rows.at[i] = line_mean(from.at + i / w * w, 1, w, i % w + 0.5, size);
        }
        for (int i = 0; i < w * h; i++) {
            double size = box_size(radius[i], p->box_repeats);
            from.at[i] = line_mean(rows.at + i % w, w, h, i / w + 0.5, size);
        }
    }
    memcpy(out->at, from.at, sizeof(double) * (size_t)(w * h));
    plane_free(&from);
    plane_free(&rows);
}

static inline void model_lowres(const struct plane *in, const double *radius,
                                const struct rf_params *p, struct plane *out)
{
    int f = p->lowres_factor, w = in->width, h = in->height;
    struct plane small = plane_make((w + f - 1) / f, (h + f - 1) / f);
    for (int j = 0; j < small.height; j++)
        for (int i = 0; i < small.width; i++) {
            double sum = 0;
            int n = 0;
            for (int y = j * f; y < h && y < (j + 1) * f; y++)
                for (int x = i * f; x < w && x < (i + 1) * f; x++, n++)
                    sum += pixel(in, x, y);
            small.at[j * small.width + i] = sum / n;
        }
    for (int i = 0; i < w * h; i++) {
        double blurred =
            bilinear(&small, (i % w + 0.5) / f - 0.5, (i / w + 0.5) / f - 0.5);
        double a = fmin(1, radius[i] * radius[i] / (f * f));
        out->at[i] = in->at[i] + a * (blurred - in->at[i]);
    }
    plane_free(&small);
}

static inline struct plane level_of_detail(const struct plane *in, int level)
{
    struct plane p = plane_make(in->width, in->height);
    memcpy(p.at, in->at, sizeof(double) * (size_t)(p.width * p.height));
    for (int l = 0; l < level; l++) {
        struct plane half = plane_make((p.width + 1) / 2, (p.height + 1) / 2);
        for (int j = 0; j < half.height; j++)
            for (int i = 0; i < half.width; i++)
                half.at[j * half.width + i] =
                    (pixel(&p, 2 * i, 2 * j) + pixel(&p, 2 * i + 1, 2 * j) +
                     pixel(&p, 2 * i, 2 * j + 1) + pixel(&p, 2 * i + 1, 2 * j + 1)) /
                    4;
        plane_free(&p);
        p = half;
    }
    return p;
}

/* Level l at the centre of pixel (x, y), moved by (dx, dy) px. */
static inline double level_at(const struct plane *in, int level, int x, int y,
                              double dx, double dy)
{
    struct plane p = level_of_detail(in, level);
    double t = pow(2, level);
    double v = bilinear(&p, (x + 0.5 + dx) / t - 0.5, (y + 0.5 + dy) / t - 0.5);
    plane_free(&p);
    return v;
}

/* Four shifts of half a sample, or none at level 0. */
static inline double shifted_level(const struct plane *in, int level, int x, int y,
                                   bool is_offset)
{
    double d = is_offset && level > 0 ? pow(2, level) / 2 : 0, sum = 0;
    for (int i = 0; i < 4; i++)
        sum += level_at(in, level, x, y, i % 2 ? d : -d, i / 2 ? d : -d);
    return sum / 4;
}

static inline void model_mipmap(const struct plane *in, const double *radius,
                                const struct rf_params *p, struct plane *out,
                                bool is_offset)
{
    int last = 0;
    for (int side = in->width > in->height ? in->width : in->height; side > 1; last++)
        side = (side + 1) / 2;
    for (int i = 0; i < in->width * in->height; i++) {
        int x = i % in->width, y = i / in->width;
        double r = radius[i] * pow(2, p->mipmap_bias);
        double t = sqrt(1 + r * r / (is_offset ? 2 : 1));
        int level = (int)floor(log2(t));
        double f = t / pow(2, level) - 1;
        if (level >= last)
            level = last, f = 0;
        double a = shifted_level(in, level, x, y, is_offset);
        double b = f > 0 ? shifted_level(in, level + 1, x, y, is_offset) : 0;
        out->at[i] = (1 - f) * a + f * b;
    }
}

/* The value `shift` px from a pixel along one axis, spread over two pixels so that the
 * mean square of the distance is shift^2: whole parts and the share of the farther. */
static inline double split(double shift, int *near, int *far)
{
    double s = fabs(shift), k = floor(s);
    *near = (int)(shift < 0 ? -k : k);
    *far = (int)(shift < 0 ? -k - 1 : k + 1);
    return (s * s - k * k) / ((k + 1) * (k + 1) - k * k);
}

static inline void model_offset(const struct plane *in, const double *radius,
                                const struct rf_params *p, struct plane *out)
{
    for (int i = 0; i < in->width * in->height; i++) {
        int x = i % in->width, y = i / in->width;
        double sum = 0;
        for (int k = 0; k < p->copies; k++) {
            double rho = sqrt((k + 0.5) / p->copies) * radius[i];
            double angle = k * 3.14159265358979323846 * (3 - sqrt(5));
            int x0, x1, y0, y1;
            double fx = split(rho * cos(angle), &x0, &x1);
            double fy = split(-rho * sin(angle), &y0, &y1);
            sum += (1 - fy) * ((1 - fx) * pixel(in, x + x0, y + y0) +
                               fx * pixel(in, x + x1, y + y0)) +
                   fy * ((1 - fx) * pixel(in, x + x0, y + y1) +
                         fx * pixel(in, x + x1, y + y1));
        }
        out->at[i] = sum / p->copies;
    }
}

static inline double four(const struct plane *p, int x, int y, int e, bool is_plus)
{
    if (is_plus)
        return (pixel(p, x - e, y) + pixel(p, x + e, y) + pixel(p, x, y - e) +
                pixel(p, x, y + e)) /
               4;
    return (pixel(p, x - e, y - e) + pixel(p, x + e, y - e) + pixel(p, x - e, y + e) +
            pixel(p, x + e, y + e)) /
           4;
}

static inline void model_recursive(const struct plane *in, const double *radius,
                                   const struct rf_params *p, struct plane *out)
{
    int w = in->width, h = in->height;
    struct plane from = plane_make(w, h);
    double spread = 0;
    for (int k = 0; k < p->recursions; k++)
        spread += pow(4, -(k / 2)) * (k % 2 ? 0.5 : 1);
    memcpy(from.at, in->at, sizeof(double) * (size_t)(w * h));
    for (int k = 0; k < p->recursions; k++) {
        for (int i = 0; i < w * h; i++) {
            double first = fabs(radius[i]) / 2 / sqrt(spread);
            int near, far;
            double f = split(first * pow(2, -(k / 2)), &near, &far);
            out->at[i] = (1 - f) * four(&from, i % w, i / w, near, k % 2) +
                         f * four(&from, i % w, i / w, far, k % 2);
        }
        memcpy(from.at, out->at, sizeof(double) * (size_t)(w * h));
    }
    plane_free(&from);
}

static inline void model_generate(const struct plane *in, const double *radius,
                                  const struct rf_params *p, struct plane *out)
{
    if (p->method == RF_METHOD_BOX)
        model_box(in, radius, p, out);
    else if (p->method == RF_METHOD_LOWRES)
        model_lowres(in, radius, p, out);
    else if (p->method == RF_METHOD_MIPMAP)
        model_mipmap(in, radius, p, out, false);
    else if (p->method == RF_METHOD_MIPMAP_OFFSET)
        model_mipmap(in, radius, p, out, true);
    else if (p->method == RF_METHOD_OFFSET)
        model_offset(in, radius, p, out);
    else
        model_recursive(in, radius, p, out);
}

/* ---- frames to planes ----------------------------------------------------------- */

static inline struct plane plane_of(const struct frame *f, int channel)
{
    struct plane p = plane_make(f->width, f->height);
    for (int i = 0; i < f->width * f->height; i++)
        p.at[i] = f->colour[i * f->channels + channel];
    return p;
}

/* The core's signed radii, which tests/reference checks. */
static inline double *radii_of(const struct frame *f, const struct rf_params *params)
{
    size_t n = frame_pixels(f);
    float *radius = calloc(n, sizeof *radius);
    double *out = calloc(n, sizeof *out);
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_image in = rf_image_packed(f->depth, f->width, f->height, 1);
    struct rf_image to = rf_image_packed(radius, f->width, f->height, 1);
    if (rf_context_create(&context, NULL, NULL) != RF_OK ||
        rf_filter_create(&filter, context, params, f->width, f->height, NULL) !=
            RF_OK ||
        rf_filter_coc(filter, &in, &to, NULL) != RF_OK)
        abort();
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    for (size_t i = 0; i < n; i++)
        out[i] = radius[i];
    free(radius);
    return out;
}

#endif
