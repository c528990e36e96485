/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A picture as the distribution of light over a circle of confusion.
 *
 *   S(X, Y) = sum of the picture left of X and above Y / sum of the picture
 *
 * with X in [0, W], Y in [0, H], linear within each pixel: the integral of the picture
 * as W x H even squares, so that the share of any rectangle is exact (Crow 1984,
 * summed-area tables).
 */
#include "input/bokeh.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "input/image.h"
#include "lens/aperture.h"
#include "rackfocus/rackfocus.h"

static double value_at(const struct rf_image *image, int x, int y, int plane)
{
    if (plane < 3)
        return (double)*rf_image_at(image, x, y, plane);
    double sum = 0;
    for (int c = 0; c < 3; c++)
        sum += (double)*rf_image_at(image, x, y, c);
    return sum / 3;
}

static rf_result check_values(const struct rf_image *image, struct rf_error *error)
{
    int n_colours = image->channels == 1 ? 1 : 3;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++)
            for (int c = 0; c < n_colours; c++) {
                float v = *rf_image_at(image, x, y, c);
                if (!isfinite(v) || v < 0)
                    return rf_fail(error, RF_ERROR_PIXEL, "distribution",
                                   "the picture of the aperture is %g at pixel "
                                   "(%d, %d): light must be finite and not negative",
                                   (double)v, x, y);
            }
    return RF_OK;
}

static void sum_plane(struct rf_bokeh *d, const struct rf_image *image, int plane)
{
    size_t stride = (size_t)d->width + 1;
    double *sum = d->sum + stride * (size_t)(d->height + 1) * (size_t)plane;
    for (int y = 0; y < d->height; y++) {
        double row = 0;
        double *above = sum + (size_t)y * stride, *at = above + stride;
        for (int x = 0; x < d->width; x++) {
            row += value_at(image, x, y, plane);
            at[x + 1] = above[x + 1] + row;
        }
    }
}

/* Makes the whole of a plane 1. */
static bool normalise(struct rf_bokeh *d, int plane)
{
    size_t n = (size_t)(d->width + 1) * (size_t)(d->height + 1);
    double *sum = d->sum + n * (size_t)plane, total = sum[n - 1];
    for (size_t i = 0; i < n && total > 0; i++)
        sum[i] /= total;
    return total > 0;
}

static rf_result check_picture(const struct rf_image *image, struct rf_error *error)
{
    rf_result result =
        rf_image_check(image, "distribution", image->width, image->height, error);
    if (result == RF_OK && (image->width < 1 || image->height < 1))
        result = rf_fail(error, RF_ERROR_ARGUMENT, "distribution",
                         "the picture of the aperture has no pixels");
    return result == RF_OK ? check_values(image, error) : result;
}

/* Do the colours have the same light everywhere? Files and PNG pictures of grey do. */
static bool is_grey(const struct rf_image *image)
{
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            const float red = *rf_image_at(image, x, y, 0);
            for (int c = 1; c < image->channels && c < 3; c++)
                if (*rf_image_at(image, x, y, c) != red)
                    return false;
        }
    return true;
}

rf_result rf_bokeh_make(struct rf_bokeh **bokeh, const struct rf_context *context,
                        const struct rf_image *image, struct rf_error *error)
{
    *bokeh = NULL;
    rf_result result = check_picture(image, error);
    if (result != RF_OK)
        return result;
    int n_planes = is_grey(image) ? 1 : 4;
    size_t n = (size_t)(image->width + 1) * (size_t)(image->height + 1);
    struct rf_bokeh *d = rf_alloc(context, 1, sizeof *d);
    double *sum = rf_calloc(context, n * (size_t)n_planes, sizeof *sum);
    if (!d || !sum) {
        rf_free(context, d);
        rf_free(context, sum);
        return rf_fail_memory(error, n * (size_t)n_planes, sizeof *sum);
    }
    *d = (struct rf_bokeh){image->width, image->height, n_planes, sum};
    bool is_good = true;
    for (int c = 0; c < n_planes; c++) {
        sum_plane(d, image, c);
        is_good &= normalise(d, c);
    }
    if (is_good) {
        *bokeh = d;
        return RF_OK;
    }
    rf_bokeh_free(d, context);
    return rf_fail(error, RF_ERROR_PIXEL, "distribution",
                   "the picture of the aperture is black%s: nothing would be left "
                   "of the light",
                   n_planes > 1 ? " in a channel" : "");
}

/* Pixels of the ring's picture: at 200 px of radius one is not half a pixel wide. */
enum { RING_PX = 512, RING_PARTS = 4 };

/* The share of a pixel of it that lies outside the hole, of squared radius. */
static float share_outside(int x, int y, double hole2)
{
    double at[2], size = RING_PX / 2.0, edge = sqrt(hole2), wide = 1 / size;
    double far = rf_length((x + 0.5) / size - 1, (y + 0.5) / size - 1);
    int n = 0;
    if (fabs(far - edge) > wide) /* no edge within the pixel */
        return far > edge;
    for (int j = 0; j < RING_PARTS; j++)
        for (int i = 0; i < RING_PARTS; i++) {
            at[0] = (x + (i + 0.5) / RING_PARTS) / size - 1;
            at[1] = (y + (j + 0.5) / RING_PARTS) / size - 1;
            n += at[0] * at[0] + at[1] * at[1] >= hole2;
        }
    return (float)n / (RING_PARTS * RING_PARTS);
}

/*
 * The share of what lies in the polygon of a pixel that hollow blades and the hole leave:
 * what a footprint cuts at the polygon's edges is not cut twice.
 */
static float share_of_hollow(const struct rf_hollow *hollow, int x, int y, double hole)
{
    double size = RING_PX / 2.0, wide = 1 / size, beside, beyond = -1;
    double u = (x + 0.5) / size - 1, v = 1 - (y + 0.5) / size;
    double within = rf_hollow_within(hollow, u, v, &beside);
    if (hole > 0)
        beyond = rf_length(u, v) - hole;
    bool is_near = fabs(within) <= wide || fabs(beside) <= wide || fabs(beyond) <= wide;
    if (!is_near)
        return within > 0 && beside > 0 && (hole == 0 || beyond > 0);
    int n = 0, n_within = 0;
    for (int i = 0; i < RING_PARTS * RING_PARTS; i++) {
        int column = i % RING_PARTS, row = i / RING_PARTS;
        u = (x + (column + 0.5) / RING_PARTS) / size - 1;
        v = 1 - (y + (row + 0.5) / RING_PARTS) / size;
        if (!(rf_hollow_within(hollow, u, v, &beside) > 0))
            continue;
        n_within++;
        n += beside > 0 && u * u + v * v >= hole * hole;
    }
    return n > 0 ? (float)n / (float)n_within : 0;
}

rf_result rf_bokeh_make_hollow(struct rf_bokeh **bokeh,
                               const struct rf_context *context,
                               const struct rf_hollow *hollow, double hole,
                               struct rf_error *error)
{
    size_t n = (size_t)RING_PX * RING_PX;
    float *light = rf_alloc(context, n, sizeof *light);
    *bokeh = NULL;
    if (!light)
        return rf_fail_memory(error, n, sizeof *light);
    for (int y = 0; y < RING_PX; y++)
        for (int x = 0; x < RING_PX; x++)
            light[y * RING_PX + x] = hollow->n > 0 ? share_of_hollow(hollow, x, y, hole)
                                                   : share_outside(x, y, hole * hole);
    const struct rf_image picture = rf_image_packed(light, RING_PX, RING_PX, 1);
    rf_result result = rf_bokeh_make(bokeh, context, &picture, error);
    rf_free(context, light);
    return result;
}

rf_result rf_bokeh_make_ring(struct rf_bokeh **bokeh, const struct rf_context *context,
                             double hole, struct rf_error *error)
{
    const struct rf_hollow none = {.n = 0};
    return rf_bokeh_make_hollow(bokeh, context, &none, hole, error);
}

static size_t plane_bytes(const struct rf_bokeh *d)
{
    return (size_t)(d->width + 1) * (size_t)(d->height + 1) * sizeof *d->sum;
}

static const double *plane_of(const struct rf_bokeh *d, int plane)
{
    return d->sum + plane_bytes(d) / sizeof *d->sum * (size_t)plane;
}

rf_result rf_bokeh_copy_plane(struct rf_bokeh **copy, const struct rf_context *context,
                              const struct rf_bokeh *bokeh, int plane,
                              struct rf_error *error)
{
    struct rf_bokeh *d = rf_alloc(context, 1, sizeof *d);
    double *sum = rf_alloc(context, 1, plane_bytes(bokeh));
    *copy = NULL;
    if (!d || !sum) {
        rf_free(context, d);
        rf_free(context, sum);
        return rf_fail_memory(error, 1, plane_bytes(bokeh));
    }
    memcpy(sum, plane_of(bokeh, plane), plane_bytes(bokeh));
    *d = (struct rf_bokeh){bokeh->width, bokeh->height, 1, sum};
    *copy = d;
    return RF_OK;
}

bool rf_bokeh_is_plane(const struct rf_bokeh *copy, const struct rf_bokeh *bokeh,
                       int plane)
{
    return copy->width == bokeh->width && copy->height == bokeh->height &&
           memcmp(copy->sum, plane_of(bokeh, plane), plane_bytes(copy)) == 0;
}

void rf_bokeh_free(struct rf_bokeh *bokeh, const struct rf_context *context)
{
    if (bokeh)
        rf_free(context, bokeh->sum);
    rf_free(context, bokeh);
}

double rf_bokeh_sum(const struct rf_bokeh *d, int plane, double x, double y)
{
    x = fmin(fmax(x, 0), d->width);
    y = fmin(fmax(y, 0), d->height);
    int i = rf_min_int((int)x, d->width - 1), j = rf_min_int((int)y, d->height - 1);
    double s = x - i, t = y - j;
    size_t stride = (size_t)d->width + 1;
    const double *at = d->sum + stride * (size_t)(d->height + 1) * (size_t)plane +
                       stride * (size_t)j + (size_t)i;
    return (1 - t) * ((1 - s) * at[0] + s * at[1]) +
           t * ((1 - s) * at[stride] + s * at[stride + 1]);
}
