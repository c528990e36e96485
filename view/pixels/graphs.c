/* SPDX-License-Identifier: Apache-2.0 */
/*
 *   c = |a (s (1/f - 1/d) - 1)|                                       Yu 2004
 *
 *   c   diameter of the circle of confusion, px
 *   a   aperture; its diameter f / N here, which is in the same ratio
 *   s   distance of the screen from the lens: sharp is d = s f / (s - f)
 *   f   focal length
 *   d   distance of the thing
 */
#include "pixels/graphs.h"

#include <math.h>
#include <stdio.h>

#define UNCLIPPED_PX 16384 /* the most that max-radius takes */
#define LEAST_TOP_PX 1.0   /* what is sharp all along has an axis, too */
#define LEAST_SHARE 1e-6   /* of the focal length, that the screen is beyond it */

/* The lens of a graph, all lengths in scene units. */
struct yu {
    struct rf_params params;
    int32_t width, height;
    double per_mm; /* scene units */
    double aperture, screen, focal, distance;
};

/* The diameter in px; NAN where there is no such lens. */
static double diameter(const struct yu *yu)
{
    struct rf_params params = yu->params;
    struct rf_lens lens;
    struct rf_error error;
    params.focal_length = yu->focal / yu->per_mm;
    params.lens_radius = yu->aperture / 2;
    params.screen_position = yu->screen;
    if (yu->aperture == 0) /* a radius of 0 says nothing */
        return 0;
    if (rf_lens_init(&lens, &params, yu->width, yu->height, &error) != RF_OK)
        return NAN;
    return 2 * fabs(rf_lens_radius_px(&lens, yu->distance));
}

static bool begin(struct yu *yu, const struct rf_params *params, double distance,
                  char *why_not, size_t n_bytes)
{
    struct rf_lens lens;
    struct rf_error error;
    yu->params = *params;
    yu->params.optics = RF_OPTICS_YU;
    yu->params.aperture_coefficient = 0;
    yu->params.max_radius = UNCLIPPED_PX;
    if (params->projection != RF_PROJECTION_PERSPECTIVE) {
        snprintf(why_not, n_bytes, "the graphs are of a perspective camera");
        return false;
    }
    if (rf_lens_init(&lens, &yu->params, yu->width, yu->height, &error) != RF_OK) {
        snprintf(why_not, n_bytes, "%s", error.message);
        return false;
    }
    yu->per_mm = params->unit_scale / 1000;
    yu->aperture = 2 * lens.lens_radius;
    yu->focal = lens.focal_length;
    yu->screen = fmax(lens.screen_position, lens.focal_length * (1 + LEAST_SHARE));
    yu->distance = distance;
    return true;
}

/* ---- axes ------------------------------------------------------------------------- */

/* What is changed along the axis, and its unit in scene units. */
static double *find_subject(struct yu *yu, enum graph_axis axis, double *unit)
{
    *unit = axis == GRAPH_DISTANCE ? 1 : yu->per_mm;
    switch (axis) {
    case GRAPH_APERTURE:
        return &yu->aperture;
    case GRAPH_SCREEN:
        return &yu->screen;
    case GRAPH_FOCAL:
        return &yu->focal;
    default:
        return &yu->distance;
    }
}

/* Where the thing is sharp, in scene units. */
static double find_sharp(const struct yu *yu, enum graph_axis axis)
{
    const double s = yu->screen, f = yu->focal, d = yu->distance;
    switch (axis) {
    case GRAPH_SCREEN:
        return d > f ? f * d / (d - f) : NAN;
    case GRAPH_FOCAL:
        return s * d / (s + d);
    case GRAPH_DISTANCE:
        return s * f / (s - f);
    default:
        return NAN;
    }
}

/* What is set and what would be sharp, both well within. */
static void find_range(const struct yu *yu, enum graph_axis axis, double sharp,
                       double *from, double *to)
{
    const double s = yu->screen, f = yu->focal, d = yu->distance;
    const double spread = fmax(fmax(s - f, fabs(sharp - f)), 0.002 * f);
    switch (axis) {
    case GRAPH_APERTURE:
        *from = 0;
        *to = 2 * yu->aperture;
        break;
    case GRAPH_SCREEN:
        *from = f * (1 + LEAST_SHARE);
        *to = f + 2 * spread;
        break;
    case GRAPH_FOCAL:
        *from = fmax(s - 3 * fmax(s - f, s - sharp), 0.1 * f);
        *to = s * (1 - LEAST_SHARE);
        break;
    default:
        *from = fmin(d, sharp) / 2;
        *to = sharp < 100 * d ? 3 * fmax(d, sharp) : 3 * d;
        break;
    }
}

int graph_ticks(double from, double to, double *ticks)
{
    static const double steps[] = {1, 2, 5, 10};
    const double rough = (to - from) / (GRAPH_MOST_TICKS - 1);
    const double power = pow(10, floor(log10(rough)));
    double step = power;
    for (int i = 0; i < 4 && step < rough * (1 - 1e-9); i++)
        step = steps[i] * power;
    int n = 0;
    const double first = ceil(from / step - 1e-9);
    for (int i = 0; i < GRAPH_MOST_TICKS && (first + i) * step <= to + 1e-9 * step; i++)
        ticks[n++] = (first + i) * step;
    return n;
}

bool graph_make(enum graph_axis axis, const struct rf_params *params, int32_t width,
                int32_t height, double distance, struct graph *graph, char *why_not,
                size_t n_bytes)
{
#define GRAPH_LABEL(name, label) label,
    static const char *const labels[] = {GRAPH_AXES(GRAPH_LABEL)};
#undef GRAPH_LABEL
    struct yu yu = {.width = width, .height = height};
    double unit, from, to, most = 0;
    if (!begin(&yu, params, distance, why_not, n_bytes))
        return false;
    *graph = (struct graph){.label = labels[axis], .now_px = diameter(&yu)};
    double *subject = find_subject(&yu, axis, &unit);
    const double sharp = find_sharp(&yu, axis);
    graph->now = *subject / unit;
    find_range(&yu, axis, sharp, &from, &to);
    for (int i = 0; i < GRAPH_STEPS; i++) {
        *subject = from + (to - from) * i / (GRAPH_STEPS - 1.0);
        graph->px[i] = diameter(&yu);
        most = fmax(most, graph->px[i]);
    }
    graph->from = from / unit;
    graph->to = to / unit;
    graph->sharp = sharp > from && sharp < to ? sharp / unit : NAN;
    graph->n_ticks = graph_ticks(graph->from, graph->to, graph->ticks);
    most = fmax(most, LEAST_TOP_PX);
    graph->n_ticks_px = graph_ticks(0, most, graph->ticks_px);
    graph->top_px = most;
    return true;
}
