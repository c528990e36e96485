/* SPDX-License-Identifier: Apache-2.0 */
/*
 * scatter: every pixel's light spread over its circle of confusion.
 *
 *   out(q) = sum over p of colour(p) w(q - p; r_p),   w = D(t) / sum of D,
 *   t = |q - p|^2 / m,   m = max(ceil((u r_p)^2), 1)
 *   |q - p|^2 = floor((u col)^2 + (u row / a)^2)
 *
 *   r_p   radius of the circle of confusion of pixel p, px (no sign)
 *   a     the pixel aspect: a circle is r px wide and a r rows high either way
 *   u     units of keys per px, max(a, 1): the side of a pixel that is the shorter one
 *         is 1; less where keys would be too many, 1 at the least
 *   D     the distribution; the pixels with |q - p|^2 < m take part, and the pixel
 *         itself always does, so r = 0 is the identity
 *
 *   uniform    D = 1            Yu 2004
 *   gaussian   D = exp(-2 t)    sigma = r / 2 as a disc has it, cut at the circle
 *   ring       D = 1 + 3 t^4    the rim four times as bright as the centre
 *   image      w = the share of the picture's light within the pixel, when the
 * picture's longer side is 2 |r| px; upright for r > 0, turned by 180 degrees for r < 0
 * (distribution.c has the integral)
 *
 * Source: Yu 2004, section "distribution": every pixel inside the circle receives
 * colour / area; the paper names other distributions as what is missing. (The paper
 * prints (row^2 * col^2)^0.5, a misprint for the sum.) The weights of one circle add up
 * to exactly 1, so no light is made or lost but what leaves the picture.
 *
 * Known artefacts: knows no occlusion, so blurred background runs over a sharp
 * foreground; the border darkens, since nothing comes in from outside; the width of the
 * circle moves in whole pixels (not with an image).
 *
 * Cost: the uniform distribution adds two differences per row of the circle, O(r) per
 * pixel; the others every pixel of it, O(r^2). Sums run in double precision, so that a
 * highlight leaves no trace beside it.
 *
 * Alpha, the fourth plane, ends at 1; the colours, which also overlap, keep their light.
 */
#include "methods/scatter/scatter.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "lens/look.h"
#include "input/bokeh.h"
#include "rackfocus/rackfocus.h"

enum { BAND_ROWS = 32, ROWS_TO_POLL = 8 };

enum { N_DENSITIES = 1024 }; /* steps of the table of D */

/* Keys of pixels that are not square are made finer up to circles of this radius. */
static const double FINE_RADIUS = 2048;

typedef double (*density_fn)(double t);

/* A disc of the same mean square distance: sigma = r / 2 on each axis. */
static double density_gaussian(double t)
{
    return rf_expf((float)(-2 * t));
}

static double density_ring(double t)
{
    return 1 + 3 * (t * t) * (t * t);
}

/* One line per distribution, in the order of RF_LIST_DISTRIBUTION; NULL: D = 1. */
static const density_fn densities[] = {
    [RF_DISTRIBUTION_UNIFORM] = NULL,
    [RF_DISTRIBUTION_GAUSSIAN] = density_gaussian,
    [RF_DISTRIBUTION_RING] = density_ring,
    [RF_DISTRIBUTION_IMAGE] = NULL,
};

struct scatter {
    const struct rf_work *work;
    struct rf_look look;
    bool is_dark;                 /* looks take light away */
    const struct rf_bokeh *image; /* NULL: a density */
    bool is_uniform;
    double density[N_DENSITIES + 2]; /* D at t = i / N_DENSITIES */
    double side[2];                  /* of a pixel in the units of keys: u and u / a */
    float *source; /* a copy of the colour planes, n_planes each width x height */
    double *area;  /* area[m]: sum of D over the circle of key m, where one occurs */
    int *ring;     /* ring[k]: how many pixels have the squared distance k */
    int max_key;
    bool has_squares; /* both sides are 1 */
    int reach[2];     /* of the largest circle, columns and rows */
};

/* Circles of the same key hold the same pixels. */
static int circle_key(const struct scatter *s, float r)
{
    double m = ceil(s->side[0] * s->side[0] * ((double)r * (double)r));
    return m < 1 ? 1 : (int)m;
}

/* |q - p|^2, 0 for the pixel itself only. */
static int square(const struct scatter *s, int dx, int dy)
{
    if (s->has_squares)
        return dx * dx + dy * dy;
    double x = dx * s->side[0], y = dy * s->side[1];
    return dx || dy ? rf_max_int((int)(x * x + y * y), 1) : 0;
}

/* The largest n with (n side)^2 < rest. */
static int half_side(double rest, double side)
{
    int n = (int)(sqrt(rest) / side);
    while (n > 0 && n * side * (n * side) >= rest)
        n--;
    while ((n + 1) * side * ((n + 1) * side) < rest)
        n++;
    return n;
}

/* Columns of a circle beside its middle, in the row `dy` of those it has. */
static int half_width(const struct scatter *s, int key, int dy)
{
    double y = dy * s->side[1];
    return half_side(key - y * y, s->side[0]);
}

static int half_height(const struct scatter *s, int key)
{
    return key > 1 ? half_side(key, s->side[1]) : 0;
}

static double density_at(const struct scatter *s, int d2, int key)
{
    double t = (double)d2 / key * N_DENSITIES;
    int i = (int)t;
    return s->density[i] + (s->density[i + 1] - s->density[i]) * (t - i);
}

static void build_densities(struct scatter *s, density_fn density)
{
    s->is_uniform = !density;
    for (int i = 0; i < N_DENSITIES + 2; i++)
        s->density[i] = density ? density((double)i / N_DENSITIES) : 1;
}

static void count_rings(struct scatter *s)
{
    for (int y = -s->reach[1]; y <= s->reach[1]; y++)
        for (int x = -s->reach[0]; x <= s->reach[0]; x++)
            if (square(s, x, y) < s->max_key)
                s->ring[square(s, x, y)]++;
}

/* The sides of a pixel, the largest key and how far its circle goes. */
static void measure_circles(struct scatter *s)
{
    const struct rf_frame *f = s->work->frame;
    double aspect = f->params.pixel_aspect, most = 1;
    size_t n = (size_t)f->width * (size_t)f->height;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs((double)s->work->radius[i]));
    s->side[0] = fmax(fmin(aspect, FINE_RADIUS / most), 1);
    s->side[1] = s->side[0] / aspect;
    s->has_squares = aspect == 1;
    s->max_key = circle_key(s, (float)most);
    s->reach[0] = half_width(s, s->max_key, 0) + (s->image ? 1 : 0);
    s->reach[1] = half_height(s, s->max_key) + (s->image ? 1 : 0);
}

static rf_result build_areas(struct scatter *s, struct rf_error *error)
{
    const struct rf_frame *f = s->work->frame;
    size_t n = (size_t)f->width * (size_t)f->height;
    measure_circles(s);
    if (s->image)
        return RF_OK;
    size_t n_keys = (size_t)s->max_key + 1;
    s->area = rf_calloc(f->context, n_keys, sizeof *s->area);
    s->ring = rf_calloc(f->context, n_keys, sizeof *s->ring);
    if (!s->area || !s->ring)
        return rf_fail_memory(error, n_keys, sizeof *s->area + sizeof *s->ring);
    count_rings(s);
    if (s->is_uniform) {
        for (int m = 1; m <= s->max_key; m++)
            s->area[m] = s->area[m - 1] + s->ring[m - 1];
        return RF_OK;
    }
    for (size_t i = 0; i < n; i++) {
        int key = circle_key(s, s->work->radius[i]);
        if (s->area[key] > 0)
            continue;
        for (int d2 = 0; d2 < key; d2++)
            if (s->ring[d2])
                s->area[key] += s->ring[d2] * density_at(s, d2, key);
    }
    return RF_OK;
}

/*
 * What looks leave of a circle: the pixels d = (dx, dy) from its middle, px, y up, with
 * |d - eye| <= eye_r and, for each door, side_i . d >= least_i. lens/look.c has the
 * formulas; without astigmatism the pixel's own place comes out of them.
 */
struct opening {
    double row_px;        /* height of a row */
    double eye[2], eye_r; /* INFINITY: no second disc */
    double side[RF_N_DOORS], least[RF_N_DOORS];
};

static struct opening opening_of(const struct scatter *s, int x, int y, double r)
{
    const struct rf_look *look = &s->look;
    struct opening o = {.row_px = 1 / look->pixel_aspect, .eye_r = INFINITY};
    double q[2], scale = 1 / r - look->cat_eye / look->half_px;
    rf_look_place(look, x + 0.5, y + 0.5, q);
    if (look->cat_eye > 0 && scale != 0) {
        o.eye_r = fabs(1 / scale);
        for (int k = 0; k < 2; k++)
            o.eye[k] = look->cat_eye * q[k] / scale;
    }
    for (int i = 0; i < RF_N_DOORS; i++) {
        double sign = i == RF_DOOR_RIGHT || i == RF_DOOR_TOP ? 1 : -1,
               b = look->door[i];
        o.side[i] = b > 0 ? sign * (1 / r - b / look->half_px) : 0;
        o.least[i] = b > 0 ? b * sign * q[i / 2] - 1 : -1;
    }
    return o;
}

/* Columns from the middle that are open in a row of a circle: none where n[0] > n[1].
 */
static void open_row(const struct opening *o, int dy, int w, int n[2])
{
    double from = -w, to = w, up = -dy * o->row_px, h = up - o->eye[1];
    if (o->eye_r < INFINITY) {
        double rest = o->eye_r * o->eye_r - h * h;
        double half = rest < 0 ? -INFINITY : sqrt(rest);
        from = fmax(from, o->eye[0] - half);
        to = fmin(to, o->eye[0] + half);
    }
    for (int i = 0; i < RF_N_DOORS; i++) {
        bool is_upright = i < RF_DOOR_TOP;
        if (o->side[i] == 0 || !is_upright) {
            if ((is_upright ? 0 : o->side[i] * up) < o->least[i])
                to = -INFINITY;
        } else if (o->side[i] > 0) {
            from = fmax(from, o->least[i] / o->side[i]);
        } else {
            to = fmin(to, o->least[i] / o->side[i]);
        }
    }
    bool is_open = from <= to;
    n[0] = is_open ? (int)ceil(from) : 1;
    n[1] = is_open ? (int)floor(to) : 0;
}

/* The sum of D over what is open of a circle; 0: nothing is. */
static double open_area(const struct scatter *s, const struct opening *o, int key)
{
    int reach = half_height(s, key), n[2];
    double sum = 0;
    for (int dy = -reach; dy <= reach; dy++) {
        open_row(o, dy, half_width(s, key, dy), n);
        if (s->is_uniform)
            sum += rf_max_int(n[1] - n[0] + 1, 0);
        for (int dx = n[0]; dx <= n[1] && !s->is_uniform; dx++)
            sum += density_at(s, square(s, dx, dy), key);
    }
    return sum;
}

/* The row `dy` below the centre, its columns n[0] to n[1]: light times density, all
 * planes. */
static void scatter_row(const struct scatter *s, double *line, int x, int dy,
                        const int n[2], int key, const double light[4])
{
    int width = s->work->frame->width, stride = width + 1;
    int left = rf_max_int(x + n[0], 0), right = rf_min_int(x + n[1], width - 1);
    for (int i = left; i <= right; i++) {
        double d = density_at(s, square(s, i - x, dy), key);
        for (int c = 0; c < s->work->n_planes; c++)
            line[c * stride + i] += light[c] * d;
    }
}

static void scatter_pixel(const struct scatter *s, int x, int y, int y0, int y1,
                          double *band)
{
    const struct rf_work *work = s->work;
    int width = work->frame->width, stride = width + 1, n_planes = work->n_planes;
    size_t at = (size_t)y * (size_t)width + (size_t)x;
    size_t n_all = (size_t)width * (size_t)work->frame->height;
    int key = circle_key(s, work->radius[at]);
    double light[4], area = s->area[key];
    struct opening opening;
    bool is_cut = s->is_dark && key > 1;
    if (is_cut) {
        opening = opening_of(s, x, y, (double)work->radius[at]);
        double open = open_area(s, &opening, key);
        is_cut = open > 0;
        area = is_cut ? open : area;
    }
    for (int c = 0; c < n_planes; c++)
        light[c] = s->source[(size_t)c * n_all + at] / area;
    int reach = half_height(s, key);
    int from = rf_max_int(y - reach, y0), to = rf_min_int(y + reach, y1 - 1);
    for (int row = from; row <= to; row++) {
        int w = half_width(s, key, row - y), n[2] = {-w, w};
        double *line = band + (size_t)(row - y0) * (size_t)(stride * n_planes);
        if (is_cut)
            open_row(&opening, row - y, w, n);
        if (!s->is_uniform) {
            scatter_row(s, line, x, row - y, n, key, light);
            continue;
        }
        int left = rf_min_int(rf_max_int(x + n[0], 0), width);
        int right = rf_max_int(rf_min_int(x + n[1] + 1, width), 0);
        for (int c = 0; c < n_planes && left < right; c++) {
            line[c * stride + left] += light[c];
            line[c * stride + right] -= light[c];
        }
    }
}

/*
 * The picture over the circle of one pixel. It is cut into pixels along the lines
 * between them: `corners` holds its integral up to the points of two such lines, above
 * and below the row at hand, n_corners of each plane.
 */
struct stamp {
    const struct rf_bokeh *image;
    int n_planes, n_corners, reach[2];
    double scale[2]; /* its pixels per column and row, negative where upside down */
    double *corners[2];
};

static void integrate_line(const struct stamp *stamp, int line, double *corners)
{
    const struct rf_bokeh *d = stamp->image;
    double y = d->height / 2.0 + (line - stamp->reach[1] - 0.5) * stamp->scale[1];
    for (int c = 0; c < stamp->n_planes; c++)
        for (int i = 0; i < stamp->n_corners; i++) {
            double x = d->width / 2.0 + (i - stamp->reach[0] - 0.5) * stamp->scale[0];
            corners[c * stamp->n_corners + i] = rf_bokeh_sum(d, c, x, y);
        }
}

static void stamp_row(const struct scatter *s, const struct stamp *stamp, int x,
                      const double light[4], double *line)
{
    int width = s->work->frame->width, stride = width + 1;
    int left = rf_max_int(x - stamp->reach[0], 0);
    int right = rf_min_int(x + stamp->reach[0], width - 1);
    for (int c = 0; c < s->work->n_planes; c++) {
        int plane = stamp->n_planes == 1 ? 0 : s->work->n_planes == 1 ? 3 : c;
        const double *above = stamp->corners[0] + plane * stamp->n_corners;
        const double *below = stamp->corners[1] + plane * stamp->n_corners;
        for (int i = left; i <= right; i++) {
            int k = i - x + stamp->reach[0];
            line[c * stride + i] +=
                light[c] * (below[k + 1] - below[k] - above[k + 1] + above[k]);
        }
    }
}

static struct stamp stamp_of(const struct scatter *s, double r)
{
    struct stamp stamp = {.image = s->image, .n_planes = s->image->n_planes};
    int longer = rf_max_int(s->image->width, s->image->height);
    for (int k = 0; k < 2; k++) {
        /* Up to half a pixel all of the picture lies within the pixel. */
        double aspect = k ? s->work->frame->params.pixel_aspect : 1;
        double size = fmax(fabs(r) * aspect, 0.5);
        stamp.reach[k] = (int)ceil(size - 0.5);
        stamp.scale[k] = longer / copysign(2 * size, r);
    }
    stamp.n_corners = 2 * stamp.reach[0] + 2;
    return stamp;
}

static void scatter_picture(const struct scatter *s, int x, int y, int y0, int y1,
                            double *band, double *corners)
{
    const struct rf_work *work = s->work;
    int width = work->frame->width, n_planes = work->n_planes;
    size_t at = (size_t)y * (size_t)width + (size_t)x;
    size_t n = (size_t)width * (size_t)work->frame->height;
    struct stamp stamp = stamp_of(s, (double)work->radius[at]);
    stamp.corners[0] = corners;
    stamp.corners[1] = corners + stamp.n_planes * stamp.n_corners;
    double light[4];
    for (int c = 0; c < n_planes; c++)
        light[c] = (double)s->source[(size_t)c * n + at];
    int from = rf_max_int(y - stamp.reach[1], y0);
    int to = rf_min_int(y + stamp.reach[1], y1 - 1);
    if (from <= to)
        integrate_line(&stamp, from - y + stamp.reach[1], stamp.corners[0]);
    for (int row = from; row <= to; row++) {
        integrate_line(&stamp, row - y + stamp.reach[1] + 1, stamp.corners[1]);
        stamp_row(s, &stamp, x, light,
                  band + (size_t)(row - y0) * (size_t)((width + 1) * n_planes));
        double *kept = stamp.corners[0];
        stamp.corners[0] = stamp.corners[1];
        stamp.corners[1] = kept;
    }
}

/*
 * Circles before and behind each other add up to an alpha above 1, behind which a layer
 * below would be taken away: no more than 1, or than the pixel itself has.
 */
static void cap_alpha(const struct scatter *s, int y0, int y1)
{
    const struct rf_frame *f = s->work->frame;
    size_t from = (size_t)y0 * (size_t)f->width, to = (size_t)y1 * (size_t)f->width;
    const float *own = s->source + 3 * (size_t)f->width * (size_t)f->height;
    float *alpha = s->work->colour[3];
    for (size_t i = from; i < to; i++)
        alpha[i] = rf_min_float(alpha[i], rf_max_float(own[i], 1));
}

static void finish_band(const struct scatter *s, int y0, int y1, const double *band)
{
    const struct rf_work *work = s->work;
    int width = work->frame->width, stride = width + 1, n_planes = work->n_planes;
    for (int y = y0; y < y1; y++)
        for (int c = 0; c < n_planes; c++) {
            const double *line =
                band + (size_t)((y - y0) * n_planes + c) * (size_t)stride;
            float *out = work->colour[c] + (size_t)y * (size_t)width;
            double sum = 0;
            for (int x = 0; x < width; x++) {
                sum = s->is_uniform ? sum + line[x] : line[x];
                out[x] = (float)sum;
            }
        }
    if (n_planes == 4)
        cap_alpha(s, y0, y1);
}

static void run_band(const struct scatter *s, int band_index, double *band)
{
    const struct rf_frame *f = s->work->frame;
    int y0 = band_index * BAND_ROWS, y1 = rf_min_int(y0 + BAND_ROWS, f->height);
    size_t n = (size_t)(f->width + 1) * (size_t)s->work->n_planes * BAND_ROWS;
    memset(band, 0, n * sizeof *band);
    int from = rf_max_int(y0 - s->reach[1], 0);
    int to = rf_min_int(y1 + s->reach[1], f->height);
    for (int y = from; y < to; y++) {
        /* A band of large radii takes long: who cancels must not wait for its end. */
        if ((y - from) % ROWS_TO_POLL == 0 && !rf_task_poll(s->work->task))
            return;
        for (int x = 0; x < f->width; x++) {
            if (s->image)
                scatter_picture(s, x, y, y0, y1, band, band + n);
            else
                scatter_pixel(s, x, y, y0, y1, band);
        }
    }
    finish_band(s, y0, y1, band);
}

/* What the threads share that run bands. */
struct running {
    const struct scatter *s;
    double *bands; /* band_size numbers for each thread */
    size_t band_size;
};

static void run_some(void *data, int64_t begin, int64_t end, int thread)
{
    const struct running *r = data;
    struct rf_task *task = r->s->work->task;
    for (int64_t i = begin; i < end && !rf_task_is_cancelled(task); i++) {
        run_band(r->s, (int)i, r->bands + r->band_size * (size_t)thread);
        rf_task_step(task);
    }
}

static void run_bands(const struct scatter *s, double *bands, size_t band_size)
{
    const struct rf_frame *f = s->work->frame;
    int n_bands = (f->height + BAND_ROWS - 1) / BAND_ROWS;
    struct running r = {s, bands, band_size};
    rf_task_phase(s->work->task, 1, n_bands);
    rf_parallel(f->context, n_bands, 1, run_some, &r);
}

rf_result rf_scatter_run(struct rf_work *work, struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    const struct rf_context *context = f->context;
    struct scatter s = {.work = work, .look = rf_frame_look(f)};
    s.is_dark = rf_look_is_dark(&s.look);
    if (f->params.distribution == RF_DISTRIBUTION_IMAGE) {
        s.image = f->bokeh;
        if (!s.image)
            return rf_fail(error, RF_ERROR_PARAMETER, "distribution",
                           "the distribution image needs its picture: none was given");
    }
    build_densities(&s, densities[f->params.distribution]);
    s.is_uniform = s.is_uniform && !s.image;
    size_t n = (size_t)f->width * (size_t)f->height;
    size_t n_source = n * (size_t)work->n_planes;
    rf_result result = rf_work_unpack(work, error);
    if (result == RF_OK)
        result = build_areas(&s, error);
    size_t band_size = (size_t)(f->width + 1) * (size_t)work->n_planes * BAND_ROWS;
    if (s.image) /* and two lines of corners behind each band */
        band_size += 2 * (size_t)s.image->n_planes * (2 * (size_t)s.reach[0] + 2);
    size_t n_bands = band_size * (size_t)context->n_threads;
    s.source = result == RF_OK ? rf_alloc(context, n_source, sizeof *s.source) : NULL;
    double *bands = s.source ? rf_alloc(context, n_bands, sizeof *bands) : NULL;
    if (result == RF_OK && !s.source)
        result = rf_fail_memory(error, n_source, sizeof *s.source);
    else if (result == RF_OK && !bands)
        result = rf_fail_memory(error, n_bands, sizeof *bands);
    if (result == RF_OK) {
        for (int c = 0; c < work->n_planes; c++)
            memcpy(s.source + n * (size_t)c, work->colour[c], n * sizeof(float));
        run_bands(&s, bands, band_size);
    }
    rf_free(context, bands);
    rf_free(context, s.source);
    rf_free(context, s.ring);
    rf_free(context, s.area);
    return result;
}
