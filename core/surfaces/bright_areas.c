/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Highlights stand out from what is usual around them, and all of them together must
 * not cost more than a budget of disc area: where they would, the thresholds double
 * until they fit. The budget is the whole picture's, so that no part of it has other
 * highlights than its neighbour; pictures in windows are surveyed first.
 *
 * Areas of discs are rounded to whole px^2, so that their sum is exact and the same in
 * any order.
 */
#include "surfaces/bright_areas.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/system_threads.h"
#include "input/field.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "rackfocus/rackfocus.h"

/*
 * Ours. Half or twice of each of the five changes no scene of tests/quality by more
 * than 0.01 dB, but twice the radius foliage by -0.03 (docs/notebook/thresholds.md):
 * lamps there are far above them. They bound the time, and keep what is bright all
 * over, as snow and windows, from being spread pixel by pixel.
 */
static const float HIGHLIGHT_LUMINANCE = 2; /* above display white by a stop */
static const float HIGHLIGHT_OVER_AREA = 8; /* times the usual luminance around */
static const float HIGHLIGHT_RADIUS_PX = 1;

/* Of the radius: what is nearer may hide more of what is bright (skies between leaves
 * 20 to 37 dB, now 37 to 72: docs/notebook/methods.md). */
static const float NEARER_PX = 2;

/* Shares of a window that is as wide as the blur, and of the luminance within. */
static const float LARGE_SHARE = 1 / 3.0f, LARGE_LUMINANCE = 0.25f;

enum {
    LARGE_PLACES = 6, /* across it */
    LARGE_ENOUGH = 4, /* of these: where fewer can be seen, nearer ones are asked */
    LARGE_LEAST_PX = 8,
    LARGE_MOST_PX = 30,     /* less than what a pixel's areas reach */
    AREA = 32,              /* px a side */
    HIGHLIGHT_BUDGET = 192, /* disc pixels of all highlights per picture pixel */
};

/* Pixel (x, y) at hand, row by row pixel i. */
static float luminance_at(const struct rf_work_view *view, int n_planes, int x, int y,
                          size_t i)
{
    if (view->image) {
        const float *c = rf_image_at(view->image, x, y, 0);
        return rf_luminance(c[0], c[1], c[2]);
    }
    if (n_planes == 1)
        return rf_luminance(view->colour[0][i], view->colour[0][i], view->colour[0][i]);
    return rf_luminance(view->colour[0][i], view->colour[1][i], view->colour[2][i]);
}

/* Every second pixel of the whole picture counts. */
static float mean_of_area(const struct rf_areas *a, const struct rf_kernels *kernels,
                          const float *luminance, size_t stride, int column, int row)
{
    float logs[AREA * AREA / 4];
    int x0 = rf_max_int((a->first_x + column) * AREA, (a->x + 1) / 2 * 2) - a->x;
    int y0 = rf_max_int((a->first_y + row) * AREA, (a->y + 1) / 2 * 2) - a->y;
    int x1 = rf_min_int((a->first_x + column + 1) * AREA - a->x, a->width);
    int y1 = rf_min_int((a->first_y + row + 1) * AREA - a->y, a->height);
    int n = 0;
    float sum = 0;
    for (int y = y0; y < y1; y += 2)
        for (int x = x0; x < x1; x += 2)
            logs[n++] = luminance[stride * (size_t)y + (size_t)x];
    for (int i = n; i % RF_FOOTPRINT_LANES; i++)
        logs[i] = 0;
    kernels->log_row(logs, (n + RF_FOOTPRINT_LANES - 1) / RF_FOOTPRINT_LANES *
                               RF_FOOTPRINT_LANES);
    for (int i = 0; i < n; i++)
        sum += logs[i];
    return n ? rf_expf(sum / (float)n) : 0;
}

rf_result rf_areas_begin(struct rf_areas *areas, const struct rf_frame *frame,
                         struct rf_error *error)
{
    struct rf_areas a = {.x = frame->place.x,
                         .y = frame->place.y,
                         .width = frame->width,
                         .height = frame->height};
    a.first_x = a.x / AREA;
    a.first_y = a.y / AREA;
    a.n_x = (a.x + a.width - 1) / AREA - a.first_x + 1;
    a.n_y = (a.y + a.height - 1) / AREA - a.first_y + 1;
    size_t n = (size_t)a.n_x * (size_t)a.n_y;
    a.mean = rf_alloc(frame->context, n, sizeof *a.mean);
    *areas = a;
    return a.mean ? RF_OK : rf_fail_memory(error, n, sizeof *a.mean);
}

int rf_area_of(const struct rf_areas *a, int x, int y)
{
    x = rf_min_int(rf_max_int(x, 0), a->width - 1);
    y = rf_min_int(rf_max_int(y, 0), a->height - 1);
    int ax = (a->x + x) / AREA - a->first_x, ay = (a->y + y) / AREA - a->first_y;
    return ay * a->n_x + ax;
}

/* Is an area or one around it wanted? */
static bool is_wanted(const struct rf_areas *a, const unsigned char *wanted, int column,
                      int row)
{
    for (int j = rf_max_int(row - 1, 0); j <= rf_min_int(row + 1, a->n_y - 1); j++)
        for (int i = rf_max_int(column - 1, 0); i <= rf_min_int(column + 1, a->n_x - 1);
             i++)
            if (wanted[j * a->n_x + i])
                return true;
    return false;
}

/* What the threads share that measure areas. */
struct measuring {
    struct rf_areas *areas;
    const struct rf_kernels *kernels;
    const unsigned char *wanted; /* NULL: all */
    const float *luminance;
    size_t stride;
};

static void measure_some(void *data, int64_t begin, int64_t end, int thread)
{
    const struct measuring *m = data;
    const struct rf_areas *a = m->areas;
    for (int i = (int)begin; i < (int)end; i++) {
        int column = i % a->n_x, row = i / a->n_x;
        if (!m->wanted || is_wanted(a, m->wanted, column, row))
            a->mean[i] =
                mean_of_area(a, m->kernels, m->luminance, m->stride, column, row);
    }
}

void rf_areas_measure_some(struct rf_areas *a, const struct rf_context *context,
                           const unsigned char *wanted, const float *luminance,
                           size_t stride)
{
    struct measuring m = {a, context->kernels, wanted, luminance, stride};
    rf_parallel(context, (int64_t)a->n_x * a->n_y, 16, measure_some, &m);
}

/* What the threads share that find the luminance of a view. */
struct luminances {
    const struct rf_work_view *view;
    int n_planes, width;
    float *at;
};

static void find_luminances(void *data, int64_t begin, int64_t end, int thread)
{
    const struct luminances *l = data;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < l->width; x++) {
            size_t i = (size_t)l->width * (size_t)y + (size_t)x;
            l->at[i] = luminance_at(l->view, l->n_planes, x, y, i);
        }
}

rf_result rf_areas_measure(struct rf_areas *areas, const struct rf_frame *frame,
                           const struct rf_work_view *view, int n_planes,
                           struct rf_error *error)
{
    const struct rf_context *context = frame->context;
    size_t width = (size_t)frame->width, n = width * (size_t)frame->height;
    rf_result result = rf_areas_begin(areas, frame, error);
    float *luminance = rf_alloc(context, n, sizeof *luminance);
    if (result == RF_OK && !luminance)
        result = rf_fail_memory(error, n, sizeof *luminance);
    if (result == RF_OK) {
        struct luminances l = {view, n_planes, frame->width, luminance};
        rf_parallel(context, frame->height, RF_EQUAL_PARTS, find_luminances, &l);
        rf_areas_measure_some(areas, context, NULL, luminance, width);
    }
    rf_free(context, luminance);
    return result;
}

void rf_areas_free(struct rf_areas *areas, const struct rf_context *context)
{
    rf_free(context, areas->mean);
    areas->mean = NULL;
}

float rf_usual_luminance(const struct rf_areas *a, int x, int y)
{
    float sorted[9];
    int area = rf_area_of(a, x, y), ax = area % a->n_x, ay = area / a->n_x, n = 0;
    for (int j = rf_max_int(ay - 1, 0); j <= rf_min_int(ay + 1, a->n_y - 1); j++)
        for (int i = rf_max_int(ax - 1, 0); i <= rf_min_int(ax + 1, a->n_x - 1); i++) {
            float mean = a->mean[(size_t)j * (size_t)a->n_x + (size_t)i];
            int k = n++;
            for (; k > 0 && sorted[k - 1] > mean; k--)
                sorted[k] = sorted[k - 1];
            sorted[k] = mean;
        }
    return sorted[(n - 1) / 2];
}

bool rf_is_highlight(float luminance, float r, float factor, float usual)
{
    return luminance > HIGHLIGHT_LUMINANCE * factor && fabsf(r) > HIGHLIGHT_RADIUS_PX &&
           luminance > HIGHLIGHT_OVER_AREA * factor * usual;
}

/* The i-th of places across a window from -reach on, even and odd ones in turn: lamps
 * may stand at every second pixel. */
static int place_across(int i, int reach)
{
    int place = (2 * i - (LARGE_PLACES - 1)) * reach / (LARGE_PLACES - 1);
    return (place & ~1) | (i & 1);
}

/* What a bright pixel may be a part of. */
struct light {
    const struct rf_areas *areas;
    const struct rf_work_view *view;
    int n_planes;
    float least;     /* luminance of its other parts */
    float nearest_r; /* what is nearer may hide some of them, px */
};

/* Of places around a pixel that say what it is part of. */
struct tally {
    int n, n_bright;
};

static struct tally look_around(const struct light *light, int x, int y, int reach)
{
    const struct rf_areas *a = light->areas;
    struct tally tally = {0, 0};
    for (int j = 0; j < LARGE_PLACES; j++)
        for (int i = 0; i < LARGE_PLACES; i++) {
            int at_x = x + place_across(i, reach), at_y = y + place_across(j, reach);
            if ((unsigned)at_x >= (unsigned)a->width ||
                (unsigned)at_y >= (unsigned)a->height)
                continue;
            size_t at = (size_t)at_y * (size_t)a->width + (size_t)at_x;
            const bool is_bright = luminance_at(light->view, light->n_planes, at_x,
                                                at_y, at) >= light->least;
            tally.n_bright += is_bright;
            tally.n += is_bright || !(light->view->radius[at] < light->nearest_r);
        }
    return tally;
}

bool rf_is_large_light(const struct rf_areas *a, const struct rf_work_view *view,
                       int n_planes, int x, int y, float luminance, float r)
{
    const struct light light = {a, view, n_planes, LARGE_LUMINANCE * luminance,
                                r - NEARER_PX};
    struct tally tally = {0, 0};
    int reach = (int)rf_min_float(fabsf(r), LARGE_MOST_PX);
    x = rf_min_int(rf_max_int(x, 0), a->width - 1); /* beyond the border it goes on */
    y = rf_min_int(rf_max_int(y, 0), a->height - 1);
    reach = rf_max_int(reach, LARGE_LEAST_PX);
    for (; reach > 1 && tally.n < LARGE_ENOUGH; reach /= 2)
        tally = look_around(&light, x, y, reach);
    return (float)tally.n_bright > LARGE_SHARE * (float)tally.n;
}

float rf_least_highlight(void)
{
    return HIGHLIGHT_LUMINANCE;
}

void rf_survey_add_light(struct rf_survey *survey, const struct rf_frame *frame,
                         const struct rf_work_view *view, int n_planes,
                         const struct rf_areas *areas, int x, int y)
{
    size_t i = (size_t)y * (size_t)frame->width + (size_t)x;
    float l = luminance_at(view, n_planes, x, y, i), factor = 1;
    if (!(l > HIGHLIGHT_LUMINANCE))
        return;
    float usual = rf_usual_luminance(areas, x, y);
    float r = rf_field_seen(frame, x, y, view->radius[i]);
    if (!rf_is_highlight(l, r, factor, usual) ||
        rf_is_large_light(areas, view, n_planes, x, y, l, r))
        return;
    double disc = floor(RF_PI * (double)r * r + 0.5);
    for (int k = 0; k < RF_SURVEY_FACTORS && rf_is_highlight(l, r, factor, usual);
         k++) {
        survey->disc_area[k] += disc;
        factor *= 2;
    }
}

/* What the threads share that survey a window. */
struct surveying {
    struct rf_survey *survey;
    const struct rf_frame *frame;
    const struct rf_work_view *view;
    int n_planes;
    const struct rf_areas *areas;
    const struct rf_window *window;
    bool lock; /* of the survey */
};

static void add_row(struct rf_survey *survey, const struct surveying *s, int y)
{
    const struct rf_window *window = s->window;
    size_t row = (size_t)y * (size_t)s->frame->width;
    for (int x = window->x; x < window->x + window->width; x++) {
        float r = s->view->radius[row + (size_t)x];
        survey->largest_radius = rf_max_float(fabsf(r), survey->largest_radius);
        if (s->n_planes == 4)
            survey->n_transparent += s->view->colour[3][row + (size_t)x] != 1;
        for (int c = 0; c < 3; c++)
            survey->least[c] = rf_min_float(
                survey->least[c],
                s->view->colour[s->n_planes == 1 ? 0 : c][row + (size_t)x]);
        rf_survey_add_light(survey, s->frame, s->view, s->n_planes, s->areas, x, y);
    }
}

/* Sums are of whole numbers, exact in any order. */
static void add_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct surveying *s = data;
    struct rf_survey own = {.largest_radius = 0}, *survey = s->survey;
    for (int64_t y = begin; y < end; y++)
        add_row(&own, s, s->window->y + (int)y);
    rf_spin_lock(&s->lock);
    survey->largest_radius = rf_max_float(own.largest_radius, survey->largest_radius);
    survey->n_transparent += own.n_transparent;
    for (int c = 0; c < 3; c++)
        survey->least[c] = rf_min_float(survey->least[c], own.least[c]);
    for (int i = 0; i < RF_SURVEY_FACTORS; i++)
        survey->disc_area[i] += own.disc_area[i];
    rf_spin_unlock(&s->lock);
}

void rf_survey_add(struct rf_survey *survey, const struct rf_frame *frame,
                   const struct rf_work_view *view, int n_planes,
                   const struct rf_areas *areas, const struct rf_window *window)
{
    struct surveying s = {.survey = survey,
                          .frame = frame,
                          .view = view,
                          .n_planes = n_planes,
                          .areas = areas,
                          .window = window};
    rf_parallel(frame->context, window->height, 16, add_rows, &s);
    survey->n_pixels += (double)window->width * window->height;
}

float rf_survey_factor(const struct rf_survey *survey)
{
    float factor = 1;
    for (int i = 0; i < RF_SURVEY_FACTORS - 1 &&
                    survey->disc_area[i] > HIGHLIGHT_BUDGET * survey->n_pixels;
         i++)
        factor *= 2;
    return factor;
}
