/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Chromatic aberration, and apertures in colour.
 *
 *   red    r + x, magnified by 1 + m about the middle of the picture
 *   green  r
 *   blue   r - x, magnified by 1 - m
 *
 *   x   axial chroma, px;  m   lateral chroma
 *
 * Where the radius or the aperture differs, the method makes the picture colour by
 * colour, if it can: a view's surfaces are the same for all, since the radii differ by
 * as much everywhere. Else the whole picture is made three times and each time one
 * colour is kept, at three times the cost. Either way occlusion and highlights are
 * right for each. Lateral colour alone needs one picture. What is
 * magnified is interpolated by Catmull and Rom's kernel, within the range of the four
 * pixels around, so that highlights do not ring; beyond the edge it goes on as there.
 */
#include "api/chroma.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "input/bokeh.h"
#include "input/frame.h"
#include "input/image.h"
#include "methods/methods.h"
#include "rackfocus/rackfocus.h"

static bool has_colours(const struct rf_frame *frame)
{
    const struct rf_bokeh *bokeh = rf_frame_bokeh(frame);
    return frame->params.axial_chroma != 0 || (bokeh && bokeh->n_planes > 1);
}

bool rf_chroma_is_on(const struct rf_frame *frame, int n_channels)
{
    return n_channels >= RF_N_COLOURS &&
           (has_colours(frame) || frame->params.lateral_chroma != 0);
}

const char *rf_chroma_field(const struct rf_frame *frame)
{
    return frame->params.axial_chroma != 0     ? "axial_chroma"
           : frame->params.lateral_chroma != 0 ? "lateral_chroma"
                                               : "aperture_image";
}

/* Copies a channel. */
struct copying {
    const struct rf_image *from, *to;
    int channel;
};

static void copy_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct copying *c = data;
    ptrdiff_t step_in = c->from->pixel_bytes / (ptrdiff_t)sizeof(float);
    ptrdiff_t step_out = c->to->pixel_bytes / (ptrdiff_t)sizeof(float);
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++) {
        const float *in = rf_image_at(c->from, 0, y, c->channel);
        float *out = (float *)rf_image_at(c->to, 0, y, c->channel);
        for (int x = 0; x < c->to->width; x++)
            out[x * step_out] = in[x * step_in];
    }
}

/* A place between pixels i and i + 1, and the weights of pixels i - 1 to i + 2. */
struct tap {
    int i;
    float weight[4];
};

/* Pixels beyond an edge that taps may ask for: all have the value of the edge. */
enum { BEYOND = 4 };

static struct tap tap_at(double at, int n)
{
    int i = (int)floor(at);
    double t = at - i;
    return (struct tap){
        .i = rf_min_int(rf_max_int(i, 1 - BEYOND), n + BEYOND - 3),
        .weight = {(float)(((-0.5 * t + 1) * t - 0.5) * t),
                   (float)((1.5 * t - 2.5) * t * t + 1),
                   (float)(((-1.5 * t + 2) * t + 0.5) * t),
                   (float)((0.5 * t - 0.5) * t * t)},
    };
}

/* A place of the output in the input, of n pixels. */
static struct tap tap_of(int x, int n, double scale)
{
    double middle = n / 2.0 - 0.5;
    return tap_at(middle + (x - middle) * scale, n);
}

/* A row between four rows: interpolated, and the range of the two next to it. */
struct row {
    float *value, *least, *most; /* from -BEYOND to width + BEYOND - 1 */
};

struct magnifying {
    const struct rf_image *from, *to;
    int channel;
    double scale;           /* pixels of `from` per pixel of `to` */
    const struct tap *taps; /* of the columns */
    const struct row *rows; /* of the threads */
};

static void interpolate_row(const struct magnifying *m, int y, const struct row *row)
{
    const struct tap tap = tap_of(y, m->from->height, m->scale);
    ptrdiff_t step = m->from->pixel_bytes / (ptrdiff_t)sizeof(float);
    const float *in[4];
    int width = m->from->width;
    for (int k = 0; k < 4; k++) {
        int j = rf_min_int(rf_max_int(tap.i - 1 + k, 0), m->from->height - 1);
        in[k] = rf_image_at(m->from, 0, j, m->channel);
    }
    for (int x = 0; x < width; x++) {
        float a = in[1][x * step], b = in[2][x * step];
        row->value[x] = tap.weight[0] * in[0][x * step] + tap.weight[1] * a +
                        tap.weight[2] * b + tap.weight[3] * in[3][x * step];
        row->least[x] = rf_min_float(a, b);
        row->most[x] = rf_max_float(a, b);
    }
    float *const all[] = {row->value, row->least, row->most};
    for (int k = 0; k < 3; k++)
        for (int i = 1; i <= BEYOND; i++) {
            all[k][-i] = all[k][0];
            all[k][width - 1 + i] = all[k][width - 1];
        }
}

static void magnify_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct magnifying *m = data;
    const struct row *row = &m->rows[thread];
    ptrdiff_t step = m->to->pixel_bytes / (ptrdiff_t)sizeof(float);
    for (int y = (int)begin; y < (int)end; y++) {
        float *out = (float *)rf_image_at(m->to, 0, y, m->channel);
        interpolate_row(m, y, row);
        for (int x = 0; x < m->to->width; x++) {
            const struct tap *tap = &m->taps[x];
            const float *v = &row->value[tap->i - 1];
            const float *least = &row->least[tap->i], *most = &row->most[tap->i];
            float sum = tap->weight[0] * v[0] + tap->weight[1] * v[1] +
                        tap->weight[2] * v[2] + tap->weight[3] * v[3];
            sum = rf_max_float(sum, rf_min_float(least[0], least[1]));
            out[x * step] = rf_min_float(sum, rf_max_float(most[0], most[1]));
        }
    }
}

static rf_result magnify(const struct rf_context *context, struct magnifying *m,
                         struct rf_error *error)
{
    size_t width = (size_t)m->to->width, n_threads = (size_t)context->n_threads;
    size_t n_row = width + 2 * BEYOND;
    struct tap *taps = rf_alloc(context, width, sizeof *taps);
    struct row *rows = rf_alloc(context, n_threads, sizeof *rows);
    float *memory = rf_alloc(context, 3 * n_row * n_threads, sizeof *memory);
    m->taps = taps;
    m->rows = rows;
    for (int x = 0; taps && x < m->to->width; x++)
        taps[x] = tap_of(x, m->from->width, m->scale);
    for (size_t i = 0; rows && memory && i < n_threads; i++) {
        float *at = memory + 3 * n_row * i + BEYOND;
        rows[i] = (struct row){at, at + n_row, at + 2 * n_row};
    }
    bool is_made = taps && rows && memory;
    if (is_made)
        rf_parallel(context, m->to->height, RF_EQUAL_PARTS, magnify_rows, m);
    rf_free(context, memory);
    rf_free(context, rows);
    rf_free(context, taps);
    return is_made ? RF_OK
                   : rf_fail_memory(error, 3 * n_row * n_threads, sizeof(float));
}

/* Keeps a colour of a picture, magnified; with green also what is no colour. */
static rf_result keep_colour(const struct rf_frame *frame, const struct rf_image *from,
                             const struct rf_image *to, int colour,
                             struct rf_error *error)
{
    double size = 1 + (1 - colour) * frame->params.lateral_chroma;
    struct copying copy = {from, to, colour};
    if (size != 1) {
        struct magnifying m = {from, to, colour, 1 / size, NULL, NULL};
        return magnify(frame->context, &m, error);
    }
    rf_parallel(frame->context, to->height, RF_EQUAL_PARTS, copy_rows, &copy);
    copy.channel = RF_N_COLOURS;
    if (colour == 1 && to->channels > RF_N_COLOURS)
        rf_parallel(frame->context, to->height, RF_EQUAL_PARTS, copy_rows, &copy);
    return RF_OK;
}

/* Does the method make the colours of a picture one by one? */
static bool can_part(const struct rf_frame *frame, int n_views)
{
    return n_views == 1 && frame->params.quality != RF_QUALITY_PREVIEW &&
           rf_method_find(frame->params.method)->has_layers;
}

rf_result rf_chroma_process(const struct rf_frame *frame, const struct rf_view *views,
                            int n_views, const struct rf_image *out,
                            const struct rf_progress *progress, rf_process_fn process,
                            struct rf_error *error)
{
    bool by_colour = has_colours(frame) && can_part(frame, n_views);
    int n_parts = has_colours(frame) && !by_colour ? RF_N_COLOURS : 1;
    int n_channels = out->channels;
    struct rf_frame whole = *frame;
    whole.by_colour = by_colour;
    if (by_colour && frame->params.lateral_chroma == 0)
        return process(&whole, views, n_views, out, progress, error);
    size_t n = (size_t)frame->width * (size_t)frame->height * (size_t)n_channels;
    /* What the caller takes may be its own input, as long as that is needed. */
    size_t n_pictures = n_parts > 1 ? 2 : 1;
    float *memory = rf_alloc(frame->context, n_pictures * n, sizeof *memory);
    rf_result result =
        memory ? RF_OK : rf_fail_memory(error, n_pictures * n, sizeof *memory);
    struct rf_image made =
        rf_image_packed(memory, frame->width, frame->height, n_channels);
    struct rf_image kept = n_parts > 1 ? made : *out;
    if (n_parts > 1)
        kept.data = memory ? memory + n : NULL;
    for (int i = 0; i < n_parts && result == RF_OK; i++) {
        struct rf_progress_part part = {progress, i, n_parts};
        const struct rf_progress own = {rf_progress_report_part, &part};
        struct rf_frame one = whole;
        if (n_parts > 1) {
            one.colour = 1 + i;
            one.radius_shift = rf_frame_colour_shift(frame, i);
        }
        result = process(&one, views, n_views, &made, progress ? &own : NULL, error);
        for (int c = 0; c < RF_N_COLOURS && result == RF_OK; c++)
            if (n_parts == 1 || c == i)
                result = keep_colour(frame, &made, &kept, c, error);
    }
    for (int c = 0; c < n_channels && n_parts > 1 && result == RF_OK; c++) {
        struct copying copy = {&kept, out, c};
        rf_parallel(frame->context, out->height, RF_EQUAL_PARTS, copy_rows, &copy);
    }
    rf_free(frame->context, memory);
    return result;
}
