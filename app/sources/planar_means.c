/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Cycles adds up the lengths of all camera rays of a pixel, from the camera's near clip
 * on, 0 for those that hit nothing, from 5.2 on FLT_MAX / 4. On the way to a planar mean: the cosine of the ray,
 * and the near clip, which is what is missing where a pixel shows one surface. After
 * mirrors and glass the length of the next ray is added: there and around it the mean is
 * not known.
 *
 * Worth with 8 views and the denoiser 0.8 dB on cut-out leaves, with one view 0 to 1.7
 * (docs/notebook/rivals.md).
 */
#include "sources/planar_means.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the distance: how well means of one surface fit single samples. Ours: slanted floors
 * at the horizon need the most. */
static const float FITS = 0.02f;
/* Least share of the pixels whose mean fits their sample; 0.72 of cut-out leaves do, of
 * fur less than 0.3. */
static const float LEAST_FITTING = 0.1f;
static const float NEARER = 0.8f; /* than the median distance; both sides have to fit */
/* Of a sample: where the mean is less, sky takes part. */
static const float LEAST_MEAN = 0.5f;
static const float NO_HIT = FLT_MAX / 4; /* of a ray */
static const float HAS_NO_HIT = 1e30f;   /* a mean with some of those */
static const float SKY = 1e9f;           /* Blender's depth of it is 1e10 */
enum { AROUND = 2 };                     /* px around a mean that does not fit */
enum { N_ASKED = 1 << 14 };              /* pixels for quantiles, of large pictures */

/* By which lengths along the rays are multiplied for planar distances. */
static float cosine_at(const struct rf_lens *lens, const struct rf_params *params,
                       const struct rf_view *view, int x, int y)
{
    if (lens->projection != RF_PROJECTION_PERSPECTIVE)
        return 1;
    double f = lens->focal_length_px, u = 0, v = 0;
    if (view->shear_distance > 0) {
        u = view->lens_offset[0] / view->shear_distance;
        v = view->lens_offset[1] / view->shear_distance;
    }
    double dx = (x + 0.5 - lens->principal_px[0]) / f - u;
    double dy = (y + 0.5 - lens->principal_px[1]) / (f * params->pixel_aspect) + v;
    return (float)(1 / sqrt(1 + dx * dx + dy * dy));
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The middle of the shortest range that has a tenth of sorted values: the most frequent
 * one. NAN of none. */
static float usual_of(const float *sorted, size_t n)
{
    const size_t n_within = n / 10;
    size_t best = 0;
    for (size_t i = 0; i + n_within < n; i++)
        if (sorted[i + n_within] - sorted[i] < sorted[best + n_within] - sorted[best])
            best = i;
    return n > 0 ? sorted[best + n_within / 2] : NAN;
}

/* Has a pixel a sample and a mean, from which so much is missing, and shows no sky? */
static bool is_known(float depth, float mean, float missing)
{
    return depth > 0 && depth < SKY && isfinite(depth - mean) &&
           mean > LEAST_MEAN * (depth - missing);
}

/*
 * The median distance, and what is missing from the means to the samples, as most often:
 * of mirrors and mixed pixels each is another. `guess`: of what is missing, INFINITY:
 * sky takes part nowhere. NAN: none are known.
 */
static void find_usual(const float *depth, const float *mean, size_t n, float *scratch,
                       float guess, float *distance, float *missing)
{
    size_t n_known = 0, step = n / N_ASKED + 1;
    for (size_t i = 0; i < n; i += step)
        if (is_known(depth[i], mean[i], guess))
            scratch[n_known++] = depth[i];
    qsort(scratch, n_known, sizeof(*scratch), compare_floats);
    *distance = n_known > 0 ? scratch[n_known / 2] : NAN;
    n_known = 0;
    for (size_t i = 0; i < n; i += step)
        if (is_known(depth[i], mean[i], guess))
            scratch[n_known++] = depth[i] - mean[i];
    qsort(scratch, n_known, sizeof(*scratch), compare_floats);
    *missing = usual_of(scratch, n_known);
}

/* The nearest of the pixels around one. */
static float nearest_of(const float *depth, int width, int height, int x, int y)
{
    float nearest = INFINITY;
    for (int j = y > 0 ? y - 1 : y; j <= y + 1 && j < height; j++)
        for (int i = x > 0 ? x - 1 : x; i <= x + 1 && i < width; i++)
            nearest = fminf(nearest, depth[(size_t)j * (size_t)width + (size_t)i]);
    return nearest;
}

/* What is missing from a mean where sky takes part: of what was hit alone. */
static float missing_beside_sky(const float *depth, float mean, int width, int height,
                                int x, int y, float missing)
{
    float z = depth[(size_t)y * (size_t)width + (size_t)x];
    if (!(z < SKY))
        z = nearest_of(depth, width, height, x, y);
    const bool has_sky = !signbit(mean) && z > mean && z < SKY;
    return has_sky ? missing * fminf(mean / (z - missing), 1) : 0;
}

/* Adds what is missing. Do the means of nearer and of farther things fit their samples? */
static bool add_missing(const float *depth, float *mean, int width, int height,
                        float distance, float missing)
{
    size_t n_fitting[2] = {0}, n_known[2] = {0};
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const float z = depth[(size_t)y * (size_t)width + (size_t)x];
            float *at = &mean[(size_t)y * (size_t)width + (size_t)x];
            if (!is_known(z, *at, missing)) {
                *at += missing_beside_sky(depth, *at, width, height, x, y, missing);
                continue;
            }
            *at += missing;
            const int k = z > NEARER * distance;
            n_known[k]++;
            n_fitting[k] += fabsf(*at - z) < FITS * z;
        }
    return n_known[1] > 0 && (float)n_fitting[0] >= LEAST_FITTING * (float)n_known[0] &&
           (float)n_fitting[1] >= LEAST_FITTING * (float)n_known[1];
}

/* Do the 3 x 3 pixels around one show one surface? */
static bool is_even(const float *depth, int width, int height, int x, int y)
{
    const float z = depth[(size_t)y * (size_t)width + (size_t)x];
    for (int j = y > 0 ? y - 1 : y; j <= y + 1 && j < height; j++)
        for (int i = x > 0 ? x - 1 : x; i <= x + 1 && i < width; i++)
            if (!(fabsf(depth[(size_t)j * (size_t)width + (size_t)i] - z) < FITS * z))
                return false;
    return z < SKY;
}

/* Is a pixel amid one surface, and its mean beyond that? Its rays went on. */
static bool is_strange(const float *depth, const float *mean, int width, int height,
                       int x, int y)
{
    const size_t i = (size_t)y * (size_t)width + (size_t)x;
    return (signbit(mean[i]) || mean[i] > (1 + FITS) * depth[i]) &&
           is_even(depth, width, height, x, y);
}

/* Takes the means around a pixel away. */
static void forget_around(float *mean, int width, int height, int x, int y)
{
    for (int j = y - AROUND; j <= y + AROUND; j++)
        for (int i = x - AROUND; i <= x + AROUND; i++)
            if (i >= 0 && j >= 0 && i < width && j < height)
                mean[(size_t)j * (size_t)width + (size_t)i] = NAN;
}

/*
 * Rays that hit nothing count as 0: of the mean only their share is left, by which the
 * nearest surface around is multiplied. Such means become negative, till all are planar.
 */
static void undo_no_hit(const float *depth, float *mean, int width, int height)
{
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float *at = &mean[(size_t)y * (size_t)width + (size_t)x];
            if (!(*at > HAS_NO_HIT))
                continue;
            const float share = fmaxf(0, 1 - *at / NO_HIT);
            const float nearest = nearest_of(depth, width, height, x, y);
            *at = share > 0 ? (nearest < SKY ? -share * nearest : NAN) : -0.0f;
        }
}

bool planar_means_make(const struct rf_lens *lens, const struct rf_params *params,
                       const struct rf_view *view, float *mean, float *scratch)
{
    const int width = view->depth.width, height = view->depth.height;
    const float *depth = view->depth.data;
    const size_t n = (size_t)width * (size_t)height;
    undo_no_hit(depth, mean, width, height);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float *at = &mean[(size_t)y * (size_t)width + (size_t)x];
            *at *= signbit(*at) ? 1 : cosine_at(lens, params, view, x, y);
        }
    /* Where things are nearer than twice the near clip, sky would seem to take part. */
    float distance, missing, guess;
    find_usual(depth, mean, n, scratch, 0, &distance, &guess);
    find_usual(depth, mean, n, scratch, isnan(guess) ? INFINITY : guess, &distance,
               &missing);
    if (!add_missing(depth, mean, width, height, distance, missing))
        return false;
    memcpy(scratch, mean, n * sizeof(*mean));
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            if (is_strange(depth, scratch, width, height, x, y))
                forget_around(mean, width, height, x, y);
    for (size_t i = 0; i < n; i++)
        mean[i] = mean[i] == 0 ? 0
                               : (float)(params->depth_scale * (double)fabsf(mean[i]) +
                                         params->depth_offset);
    return true;
}

float planar_means_near_clip(const float *depth, const float *way, size_t n,
                             float *scratch)
{
    const size_t step = n / N_ASKED + 1;
    size_t n_known = 0, n_short = 0, n_fitting = 0;
    float nearest = INFINITY;
    for (size_t i = 0; i < n; i += step)
        if (depth[i] > 0 && depth[i] < SKY && way[i] > 0) {
            nearest = fminf(nearest, depth[i]);
            n_known++;
        }
    /* Ways that go on, in mirrors and behind glass, are longer than their depth. */
    for (size_t i = 0; i < n; i += step)
        if (depth[i] > 0 && depth[i] < SKY && way[i] > 0 && way[i] <= depth[i])
            scratch[n_short++] = depth[i] - way[i];
    qsort(scratch, n_short, sizeof(*scratch), compare_floats);
    const float missing = n_short > 0 ? usual_of(scratch, n_short) : 0;
    for (size_t i = 0; i < n; i += step)
        n_fitting +=
            depth[i] < SKY && fabsf(depth[i] - way[i] - missing) < FITS * depth[i];
    /* Nothing is before the near clip. */
    return (float)n_fitting > LEAST_FITTING * (float)n_known && missing <= nearest
               ? missing
               : NAN;
}
