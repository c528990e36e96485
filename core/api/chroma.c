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
 * Where the radius or the aperture differs, the whole picture is made three times and
 * each time one colour is kept: occlusion, highlights and hidden background are right
 * for each, at three times the cost. Lateral colour alone needs one picture. What is
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
#include "input/bokeh.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "rackfocus/rackfocus.h"

enum { N_COLOURS = 3 };

static bool has_colours(const struct rf_frame *frame)
{
    const struct rf_bokeh *bokeh = rf_frame_bokeh(frame);
    return frame->params.axial_chroma != 0 || (bokeh && bokeh->n_planes > 1);
}

bool rf_chroma_is_on(const struct rf_frame *frame, int n_channels)
{
    return n_channels >= N_COLOURS &&
           (has_colours(frame) || frame->params.lateral_chroma != 0);
}

/* The progress of part i of n. */
struct part {
    const struct rf_progress *whole;
    int i, n;
};

static bool report_part(void *user, double fraction)
{
    const struct part *part = user;
    return part->whole->report(part->whole->user, (part->i + fraction) / part->n);
}

struct magnifying {
    const struct rf_image *from, *to;
    int channel;
    double scale; /* pixels of `from` per pixel of `to` */
};

static void weigh(double t, double w[4])
{
    w[0] = ((-0.5 * t + 1) * t - 0.5) * t;
    w[1] = (1.5 * t - 2.5) * t * t + 1;
    w[2] = ((-1.5 * t + 2) * t + 0.5) * t;
    w[3] = (0.5 * t - 0.5) * t * t;
}

static int within(int i, int n)
{
    return rf_min_int(rf_max_int(i, 0), n - 1);
}

static float interpolate(const struct magnifying *m, double x, double y)
{
    const struct rf_image *from = m->from;
    double wx[4], wy[4], sum = 0;
    int i = (int)floor(x), j = (int)floor(y);
    float least = INFINITY, most = -INFINITY;
    weigh(x - i, wx);
    weigh(y - j, wy);
    for (int k = 0; k < 16; k++) {
        int column = k % 4, row = k / 4;
        float v = *rf_image_at(from, within(i - 1 + column, from->width),
                               within(j - 1 + row, from->height), m->channel);
        sum += wx[column] * wy[row] * (double)v;
        if ((column == 1 || column == 2) && (row == 1 || row == 2)) {
            least = rf_min_float(v, least);
            most = rf_max_float(v, most);
        }
    }
    return rf_min_float(rf_max_float((float)sum, least), most);
}

static void magnify_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct magnifying *m = data;
    double middle[2] = {m->to->width / 2.0 - 0.5, m->to->height / 2.0 - 0.5};
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < m->to->width; x++) {
            float *out = (float *)rf_image_at(m->to, x, y, m->channel);
            *out = m->scale == 1
                       ? *rf_image_at(m->from, x, y, m->channel)
                       : interpolate(m, middle[0] + (x - middle[0]) * m->scale,
                                     middle[1] + (y - middle[1]) * m->scale);
        }
}

/* Keeps a colour of a picture, magnified; with green also what is no colour. */
static void keep_colour(const struct rf_frame *frame, const struct rf_image *from,
                        const struct rf_image *to, int colour)
{
    double size = 1 + (1 - colour) * frame->params.lateral_chroma;
    struct magnifying m = {from, to, colour, 1 / size};
    rf_parallel(frame->context, to->height, RF_EQUAL_PARTS, magnify_rows, &m);
    for (m.channel = N_COLOURS; colour == 1 && m.channel < to->channels; m.channel++)
        rf_parallel(frame->context, to->height, RF_EQUAL_PARTS, magnify_rows, &m);
}

rf_result rf_chroma_process(const struct rf_frame *frame, const struct rf_view *views,
                            int n_views, const struct rf_image *out,
                            const struct rf_progress *progress, rf_process_fn process,
                            struct rf_error *error)
{
    int n_parts = has_colours(frame) ? N_COLOURS : 1, n_channels = out->channels;
    size_t n = (size_t)frame->width * (size_t)frame->height * (size_t)n_channels;
    float *memory = rf_alloc(frame->context, 2 * n, sizeof *memory);
    rf_result result = memory ? RF_OK : rf_fail_memory(error, 2 * n, sizeof *memory);
    struct rf_image made =
        rf_image_packed(memory, frame->width, frame->height, n_channels);
    struct rf_image kept = made;
    kept.data = memory ? memory + n : NULL; /* the caller's may be its own input */
    for (int i = 0; i < n_parts && result == RF_OK; i++) {
        struct part part = {progress, i, n_parts};
        const struct rf_progress own = {report_part, &part};
        struct rf_frame one = *frame;
        if (n_parts > 1) {
            one.colour = 1 + i;
            one.radius_shift = (1 - i) * frame->params.axial_chroma;
        }
        result = process(&one, views, n_views, &made, progress ? &own : NULL, error);
        for (int c = 0; c < N_COLOURS && result == RF_OK; c++)
            if (n_parts == 1 || c == i)
                keep_colour(frame, &made, &kept, c);
    }
    if (result == RF_OK)
        rf_image_copy(&kept, out);
    rf_free(frame->context, memory);
    return result;
}
