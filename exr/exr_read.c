/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Decodes OpenEXR files.
 *
 * OpenEXRCore undoes the compression of a chunk; finding the chunks, unpacking them and
 * converting samples is done here, because the unpackers of the core depend on the
 * channels in ways that 3.1 gets wrong for mixed types.
 */
#include "exr_private.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "parallel.h"
#include "thread.h"

/* ---- chunks --------------------------------------------------------------------- */

struct decoder {
    struct image_input *input;
    int part;
    image_run_fn run;
    void *user;
    struct image_chunks chunks;
    exr_result_t (*undo)(exr_decode_pipeline_t *); /* of the core, or ours */
};

bool image_plan_chunks(const struct image_input *input, int part,
                       struct image_chunks *c, struct image_error *error)
{
    const struct image_part_info *info = &input->parts[part];
    exr_const_context_t context = input->context;
    int32_t width = info->data_window.max_x - info->data_window.min_x + 1;
    int32_t height = info->data_window.max_y - info->data_window.min_y + 1;
    exr_result_t result;

    image_core_clear();
    if (info->is_tiled) {
        result =
            exr_get_tile_sizes(context, part, 0, 0, &c->tile_width, &c->tile_height);
        if (result == EXR_ERR_SUCCESS && c->tile_width > 0 && c->tile_height > 0) {
            c->n_tiles_x = (width + c->tile_width - 1) / c->tile_width;
            c->n_chunks =
                c->n_tiles_x * ((height + c->tile_height - 1) / c->tile_height);
            return true;
        }
    } else {
        result = exr_get_scanlines_per_chunk(context, part, &c->lines_per_chunk);
        if (result == EXR_ERR_SUCCESS && c->lines_per_chunk > 0) {
            c->n_chunks = (height + c->lines_per_chunk - 1) / c->lines_per_chunk;
            return true;
        }
    }
    return image_fail(error, input->path, "damaged header: %s",
                      image_core_message(result));
}

exr_result_t image_find_chunk(const struct image_input *input, int part,
                              const struct image_chunks *c, int index,
                              exr_chunk_info_t *chunk)
{
    const struct image_part_info *info = &input->parts[part];
    /* The core leaves fields alone that mean nothing for this kind of part. */
    memset(chunk, 0, sizeof *chunk);
    if (c->n_tiles_x > 0)
        return exr_read_tile_chunk_info(input->context, part, index % c->n_tiles_x,
                                        index / c->n_tiles_x, 0, 0, chunk);
    return exr_read_scanline_chunk_info(
        input->context, part, info->data_window.min_y + index * c->lines_per_chunk,
        chunk);
}

/* In place of the core's: chunks as large as their pixels are stored as they are. */
static exr_result_t undo_compression(exr_decode_pipeline_t *pipeline)
{
    const struct decoder *d = pipeline->decoding_user_data;
    if (pipeline->chunk.packed_size == pipeline->chunk.unpacked_size)
        return EXR_ERR_SUCCESS;
    return d->undo(pipeline);
}

/* Hands the lines of an uncompressed chunk to the user, channel by channel. */
static exr_result_t unpack(exr_decode_pipeline_t *pipeline)
{
    const struct decoder *d = pipeline->decoding_user_data;
    const exr_chunk_info_t *chunk = &pipeline->chunk;
    const struct image_box *box = &d->input->parts[d->part].data_window;
    const uint8_t *samples = pipeline->unpacked_buffer;
    const uint8_t *end = samples + chunk->unpacked_size;
    bool is_tile = d->chunks.n_tiles_x > 0;
    /* Without compression the core takes any size and would leave the rest unset. */
    if (!pipeline->decompress_fn && chunk->packed_size != chunk->unpacked_size)
        return EXR_ERR_CORRUPT_CHUNK;
    int32_t x = is_tile ? chunk->start_x * d->chunks.tile_width : 0;
    int32_t y0 =
        is_tile ? chunk->start_y * d->chunks.tile_height : chunk->start_y - box->min_y;

    for (int32_t line = 0; line < chunk->height; line++) {
        for (int c = 0; c < pipeline->channel_count; c++) {
            const exr_coding_channel_info_t *channel = &pipeline->channels[c];
            int32_t step = channel->y_samples > 1 ? channel->y_samples : 1;
            if ((box->min_y + y0 + line) % step != 0)
                continue;
            size_t n_bytes =
                (size_t)channel->width * (size_t)channel->bytes_per_element;
            if ((size_t)(end - samples) < n_bytes)
                return EXR_ERR_CORRUPT_CHUNK;
            d->run(d->user, c, x, (y0 + line) / step, channel->width, samples);
            samples += n_bytes;
        }
    }
    return EXR_ERR_SUCCESS;
}

static exr_result_t start_pipeline(struct decoder *d, const exr_chunk_info_t *chunk,
                                   exr_decode_pipeline_t *pipeline)
{
    exr_const_context_t context = d->input->context;
    exr_result_t result = exr_decoding_initialize(context, d->part, chunk, pipeline);
    if (result != EXR_ERR_SUCCESS)
        return result;
    result = exr_decoding_choose_default_routines(context, d->part, pipeline);
    pipeline->decoding_user_data = d;
    if (pipeline->decompress_fn)
        pipeline->decompress_fn = undo_compression;
    pipeline->unpack_and_convert_fn = unpack;
    return result;
}

/* The core's own decompressor is only reachable through a pipeline. */
static bool choose_undo(struct decoder *d, struct image_error *error)
{
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    exr_const_context_t context = d->input->context;

    image_core_clear();
    exr_result_t result = image_find_chunk(d->input, d->part, &d->chunks, 0, &chunk);
    if (result == EXR_ERR_SUCCESS)
        result = exr_decoding_initialize(context, d->part, &chunk, &pipeline);
    if (result == EXR_ERR_SUCCESS)
        result = exr_decoding_choose_default_routines(context, d->part, &pipeline);
    d->undo = pipeline.decompress_fn;
    exr_decoding_destroy(context, &pipeline);
#ifdef IMAGE_UNDO_DWA
    if (chunk.compression == EXR_COMPRESSION_DWAA ||
        chunk.compression == EXR_COMPRESSION_DWAB)
        d->undo = image_undo_dwa;
#endif
    return result == EXR_ERR_SUCCESS ||
           image_fail(error, d->input->path, "damaged: %s", image_core_message(result));
}

static exr_result_t decode_chunk(struct decoder *d, int index,
                                 exr_decode_pipeline_t *pipeline, bool *is_started)
{
    exr_chunk_info_t chunk;
    exr_result_t result =
        image_find_chunk(d->input, d->part, &d->chunks, index, &chunk);
    if (result != EXR_ERR_SUCCESS)
        return result;
    if (*is_started) {
        result = exr_decoding_update(d->input->context, d->part, &chunk, pipeline);
    } else {
        result = start_pipeline(d, &chunk, pipeline);
        *is_started = true;
    }
    if (result != EXR_ERR_SUCCESS)
        return result;
    return exr_decoding_run(d->input->context, d->part, pipeline);
}

/* The first chunk of these rows, and the one after the last. */
static void find_range(const struct image_chunks *c, struct image_rows rows,
                       int range[2])
{
    int32_t step = c->n_tiles_x > 0 ? c->tile_height : c->lines_per_chunk;
    int per_row = c->n_tiles_x > 0 ? c->n_tiles_x : 1;
    range[0] = rows.first / step * per_row;
    range[1] = (rows.first + rows.n - 1) / step * per_row + per_row;
}

/* What the threads share that decode chunks. */
struct decoding {
    struct decoder *d;
    int first; /* chunk */
    struct pipeline {
        exr_decode_pipeline_t state;
        bool is_started;
    } * pipelines; /* one per thread */
    _Atomic bool is_failed;
    struct os_lock lock; /* of the message, which is the first's */
    char message[400];
};

static void note_failure(struct decoding *d, exr_result_t result)
{
    os_lock_take(&d->lock);
    if (!d->is_failed)
        snprintf(d->message, sizeof d->message, "%s", image_core_message(result));
    d->is_failed = true;
    os_lock_release(&d->lock);
}

static void decode_chunks(void *data, int64_t begin, int64_t end, int thread)
{
    struct decoding *d = data;
    struct pipeline *p = &d->pipelines[thread];
    for (int i = (int)begin; i < (int)end && !d->is_failed; i++) {
        image_core_clear();
        exr_result_t result =
            decode_chunk(d->d, d->first + i, &p->state, &p->is_started);
        if (result != EXR_ERR_SUCCESS)
            note_failure(d, result);
    }
}

/* Decodes chunks range[0] to range[1] - 1. */
static bool decode_range(struct decoder *decoder, const int range[2], int n_threads,
                         struct image_error *error)
{
    static const exr_decode_pipeline_t empty = EXR_DECODE_PIPELINE_INITIALIZER;
    struct decoding d = {.d = decoder, .first = range[0]};
    d.pipelines = calloc((size_t)n_threads, sizeof *d.pipelines);
    if (!d.pipelines)
        return image_lacks_memory(error, decoder->input->path);
    for (int i = 0; i < n_threads; i++)
        d.pipelines[i].state = empty;
    os_lock_init(&d.lock);
    os_parallel(n_threads, range[1] - range[0], 1, decode_chunks, &d);
    os_lock_destroy(&d.lock);
    for (int i = 0; i < n_threads; i++)
        exr_decoding_destroy(decoder->input->context, &d.pipelines[i].state);
    free(d.pipelines);
    return !d.is_failed ||
           image_fail(error, decoder->input->path, "damaged: %s", d.message);
}

bool image_decode_rows(struct image_input *input, int part, struct image_rows rows,
                       image_run_fn run, void *user, int n_threads,
                       struct image_error *error)
{
    struct decoder d = {.input = input, .part = part, .run = run, .user = user};
    if (input->parts[part].is_deep)
        return image_fail(
            error, input->path,
            "part %d (\"%s\") holds deep samples, and here a flat picture is needed; "
            "rackfocus filter --flattened makes one",
            part, input->parts[part].name);
    if (!image_plan_chunks(input, part, &d.chunks, error) || !choose_undo(&d, error))
        return false;
    int range[2];
    find_range(&d.chunks, rows, range);
    return decode_range(&d, range, n_threads < 1 ? 1 : n_threads, error);
}

/* ---- samples -------------------------------------------------------------------- */

int image_sample_bytes(enum image_sample_type type)
{
    return type == IMAGE_SAMPLE_HALF ? 2 : 4;
}

struct interleaver {
    const struct image_input *input;
    int part;
    const int *wanted; /* indices into input->channels */
    int n;
    float *samples; /* of the first of the rows */
    size_t width;
    struct image_rows rows;
};

void image_convert_run(float *out, size_t stride, enum image_sample_type type,
                       int32_t n, const uint8_t *samples)
{
    if (type == IMAGE_SAMPLE_HALF) {
        image_halves_to_floats(out, stride, samples, (size_t)n);
        return;
    }
    for (int32_t i = 0; i < n; i++, out += stride) {
        uint32_t whole;
        if (type == IMAGE_SAMPLE_FLOAT) {
            memcpy(out, samples + 4 * (size_t)i, 4);
        } else {
            memcpy(&whole, samples + 4 * (size_t)i, 4);
            *out = (float)whole;
        }
    }
}

/* Samples of a sub-sampled channel fill the pixels that they stand for. */
static void spread_run(const struct interleaver *to, int channel, int c, int32_t x,
                       int32_t y, int32_t n, const uint8_t *samples)
{
    const struct image_channel_info *info = &to->input->channels[channel];
    const struct image_box *box = &to->input->parts[to->part].data_window;
    int32_t width = (int32_t)to->width, height = box->max_y - box->min_y + 1;
    int32_t step_x = info->x_sampling, step_y = info->y_sampling;
    int32_t y0 = y * step_y, y1 = height - y0 < step_y ? height : y0 + step_y;
    int32_t end = to->rows.first + to->rows.n;
    y0 = y0 < to->rows.first ? to->rows.first : y0;
    y1 = y1 > end ? end : y1;
    /* Without the samples of its rest the last block of a cut window has none. */
    for (int32_t i = 0; i < n; i++) {
        float v;
        image_convert_run(&v, 1, info->type, 1,
                          samples + (size_t)i * (size_t)image_sample_bytes(info->type));
        int32_t x0 = (x + i) * step_x, x1 = i + 1 < n ? x0 + step_x : width;
        for (int32_t py = y0; py < y1; py++)
            for (int32_t px = x0; px < x1 && px < width; px++)
                to->samples[((size_t)(py - to->rows.first) * to->width + (size_t)px) *
                                (size_t)to->n +
                            (size_t)c] = v;
    }
}

static void interleave_run(void *user, int channel_in_part, int32_t x, int32_t y,
                           int32_t n, const uint8_t *samples)
{
    const struct interleaver *to = user;
    int channel = to->input->first_channel[to->part] + channel_in_part;
    const struct image_channel_info *info = &to->input->channels[channel];
    for (int c = 0; c < to->n; c++) {
        if (to->wanted[c] != channel)
            continue;
        int32_t row = y - to->rows.first;
        size_t pixel = (size_t)row * to->width + (size_t)x;
        if (info->x_sampling != 1 || info->y_sampling != 1)
            spread_run(to, channel, c, x, y, n, samples);
        else if (row >= 0 && row < to->rows.n)
            image_convert_run(to->samples + pixel * (size_t)to->n + c, (size_t)to->n,
                              info->type, n, samples);
    }
}

static bool check_wanted(const struct image_input *input, const int *channels, int n,
                         struct image_error *error)
{
    const struct image_box *box = NULL;
    for (int c = 0; c < n; c++) {
        if (channels[c] == -1)
            continue;
        if (channels[c] < -1 || channels[c] >= input->n_channels)
            return image_fail(error, input->path, "there is no channel number %d",
                              channels[c]);
        const struct image_channel_info *info = &input->channels[channels[c]];
        const struct image_box *other = &input->parts[info->part].data_window;
        if (box && memcmp(box, other, sizeof *box) != 0)
            return image_fail(error, input->path,
                              "channel %s has another data window than the first",
                              info->name);
        box = other;
    }
    if (!box)
        return image_fail(error, input->path, "no channel is asked for");
    return true;
}

static bool is_wanted_part(const struct image_input *input, int part,
                           const int *channels, int n)
{
    for (int c = 0; c < n; c++)
        if (channels[c] >= 0 && input->channels[channels[c]].part == part)
            return true;
    return false;
}

static void fill_ones(float *samples, size_t n_pixels, const int *channels, int n)
{
    for (int c = 0; c < n; c++)
        for (size_t i = 0; channels[c] == -1 && i < n_pixels; i++)
            samples[i * (size_t)n + (size_t)c] = 1.0f;
}

/* Rows that hold what is to be seen in `rows`: a sub-sampled channel's block may begin
 * above them. */
static struct image_rows with_blocks(const struct image_input *input, int part,
                                     struct image_rows rows)
{
    int32_t step = 1;
    for (int c = input->first_channel[part]; c < input->first_channel[part + 1]; c++)
        if (input->channels[c].y_sampling > step)
            step = input->channels[c].y_sampling;
    int32_t more = rows.first < step - 1 ? rows.first : step - 1;
    return (struct image_rows){rows.first - more, rows.n + more};
}

/* Of the data window that all wanted channels have; one of them is not -1. */
static int32_t wanted_height(const struct image_input *input, const int *channels)
{
    while (*channels < 0)
        channels++;
    const struct image_box *box =
        &input->parts[input->channels[*channels].part].data_window;
    return box->max_y - box->min_y + 1;
}

static bool check_rows(const struct image_input *input, const int *channels,
                       struct image_rows rows, struct image_error *error)
{
    int32_t height = wanted_height(input, channels);
    if (rows.first >= 0 && rows.n > 0 && rows.n <= height &&
        rows.first <= height - rows.n)
        return true;
    return image_fail(
        error, input->path, "rows %d to %lld are asked for, but there are only 0 to %d",
        (int)rows.first, (long long)rows.first + rows.n - 1, (int)height - 1);
}

bool image_read_rows(struct image_input *input, const int *channels, int n,
                     struct image_rows rows, float *samples, int n_threads,
                     struct image_error *error)
{
    if (!check_wanted(input, channels, n, error) ||
        !check_rows(input, channels, rows, error))
        return false;
    for (int part = 0; part < input->n_parts; part++) {
        if (!is_wanted_part(input, part, channels, n))
            continue;
        const struct image_box *box = &input->parts[part].data_window;
        struct interleaver to = {
            .input = input,
            .part = part,
            .wanted = channels,
            .n = n,
            .samples = samples,
            .width = (size_t)(box->max_x - box->min_x + 1),
            .rows = rows,
        };
        fill_ones(samples, to.width * (size_t)rows.n, channels, n);
        if (!image_decode_rows(input, part, with_blocks(input, part, rows),
                               interleave_run, &to, n_threads, error))
            return false;
    }
    return true;
}

bool image_read(struct image_input *input, const int *channels, int n, float *samples,
                int n_threads, struct image_error *error)
{
    if (!check_wanted(input, channels, n, error))
        return false;
    const struct image_rows all = {0, wanted_height(input, channels)};
    return image_read_rows(input, channels, n, all, samples, n_threads, error);
}

int32_t image_row_step(const struct image_input *input, int part)
{
    struct image_chunks chunks = {0};
    if (!image_plan_chunks(input, part, &chunks, NULL))
        return 1;
    return chunks.n_tiles_x > 0 ? chunks.tile_height : chunks.lines_per_chunk;
}
