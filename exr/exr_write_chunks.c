/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The chunks of a file's parts: copied as they are compressed, or packed and
 * compressed.
 *
 * The pipeline of the core holds a lock while it packs and takes a chunk that
 * compressed to exactly its own size for an uncompressed one, so packing and that
 * choice are made here.
 */
#include "exr_writer.h"

#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "parallel.h"
#include "thread.h"

/* ---- parts that are copied ------------------------------------------------------ */

static exr_result_t copy_chunk(struct writer *w, int part,
                               const exr_chunk_info_t *chunk, bool is_tiled)
{
    const struct image_input *like = w->parts[part].output->like;
    int from = w->parts[part].like_part;
    uint8_t *data = malloc(chunk->packed_size + chunk->sample_count_table_size + 1);
    bool is_deep = like->parts[from].is_deep;
    exr_result_t result;
    if (!data)
        return EXR_ERR_OUT_OF_MEMORY;
    uint8_t *counts = data + chunk->packed_size;
    if (is_deep)
        result = exr_read_deep_chunk(like->context, from, chunk, data, counts);
    else
        result = exr_read_chunk(like->context, from, chunk, data);
    if (result != EXR_ERR_SUCCESS)
        ;
    else if (is_deep && is_tiled)
        result = exr_write_deep_tile_chunk(
            w->context, part, chunk->start_x, chunk->start_y, chunk->level_x,
            chunk->level_y, data, chunk->packed_size, chunk->unpacked_size, counts,
            chunk->sample_count_table_size);
    else if (is_deep)
        result = exr_write_deep_scanline_chunk(w->context, part, chunk->start_y, data,
                                               chunk->packed_size, chunk->unpacked_size,
                                               counts, chunk->sample_count_table_size);
    else if (is_tiled)
        result = exr_write_tile_chunk(w->context, part, chunk->start_x, chunk->start_y,
                                      chunk->level_x, chunk->level_y, data,
                                      chunk->packed_size);
    else
        result = exr_write_scanline_chunk(w->context, part, chunk->start_y, data,
                                          chunk->packed_size);
    free(data);
    return result;
}

static exr_result_t copy_lines(struct writer *w, int part)
{
    const struct image_input *like = w->parts[part].output->like;
    int from = w->parts[part].like_part;
    const struct image_box *box = &like->parts[from].data_window;
    int32_t step = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(like->context, from, &step);
    for (int64_t y = box->min_y; y <= box->max_y && result == EXR_ERR_SUCCESS;
         y += step) {
        exr_chunk_info_t chunk = {0};
        result = exr_read_scanline_chunk_info(like->context, from, (int)y, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = copy_chunk(w, part, &chunk, false);
    }
    return result;
}

static exr_result_t copy_level(struct writer *w, int part, int level)
{
    exr_const_context_t like = w->parts[part].output->like->context;
    int from = w->parts[part].like_part;
    int32_t tile_width, tile_height, width, height;
    exr_result_t result =
        exr_get_tile_sizes(like, from, level, level, &tile_width, &tile_height);
    if (result == EXR_ERR_SUCCESS)
        result = exr_get_level_sizes(like, from, level, level, &width, &height);
    if (result != EXR_ERR_SUCCESS)
        return result;
    int n_x = (width + tile_width - 1) / tile_width;
    int n_y = (height + tile_height - 1) / tile_height;
    for (int i = 0; i < n_x * n_y && result == EXR_ERR_SUCCESS; i++) {
        exr_chunk_info_t chunk = {0};
        result = exr_read_tile_chunk_info(like, from, i % n_x, i / n_x, level, level,
                                          &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = copy_chunk(w, part, &chunk, true);
    }
    return result;
}

static bool copy_part(struct writer *w, int part)
{
    const struct image_input *like = w->parts[part].output->like;
    int from = w->parts[part].like_part;
    exr_result_t result;
    image_core_clear();
    if (like->parts[from].is_tiled) {
        int32_t n_levels = 0;
        result = exr_get_tile_levels(like->context, from, &n_levels, NULL);
        for (int level = 0; level < n_levels && result == EXR_ERR_SUCCESS; level++)
            result = copy_level(w, part, level);
    } else {
        result = copy_lines(w, part);
    }
    if (result != EXR_ERR_SUCCESS && w->write_errno == 0)
        return image_fail(w->error, image_path(like), "damaged: %s",
                          image_core_message(result));
    return result == EXR_ERR_SUCCESS || writer_fail(w, result);
}

/* ---- parts that are made anew --------------------------------------------------- */

/* Columns of a row. */
struct span {
    size_t x, n;
};

static uint32_t float_to_uint(float value)
{
    if (!(value > 0.0f))
        return 0;
    return value >= 4294967296.0f ? UINT32_MAX : (uint32_t)llrintf(value);
}

static size_t plane_width(const struct out_part *part,
                          const struct out_channel *channel)
{
    int64_t n = (int64_t)part->data_window.max.x - part->data_window.min.x + 1;
    return (size_t)(n / channel->x_sampling);
}

/* The first row of samples of a kept channel that is in memory. */
static int32_t first_plane_row(const struct out_part *part,
                               const struct out_channel *channel)
{
    return part->rows.first / channel->y_sampling;
}

static size_t plane_height(const struct out_part *part,
                           const struct out_channel *channel)
{
    int32_t last = (part->rows.first + part->rows.n - 1) / channel->y_sampling;
    return (size_t)(last - first_plane_row(part, channel) + 1);
}

static size_t sample_bytes(const struct out_channel *channel)
{
    return channel->type == EXR_PIXEL_HALF ? 2 : 4;
}

static void keep_run(void *user, int channel_in_part, int32_t x, int32_t y, int32_t n,
                     const uint8_t *samples)
{
    const struct out_part *part = user;
    for (int i = 0; i < part->n_channels; i++) {
        const struct out_channel *channel = &part->channels[i];
        if (channel->sample >= 0 || channel->like_channel != channel_in_part)
            continue;
        size_t width = plane_width(part, channel);
        int32_t row = y - first_plane_row(part, channel);
        if (row < 0 || (size_t)row >= plane_height(part, channel) ||
            (size_t)(x + n) > width)
            return;
        size_t at = (size_t)row * width + (size_t)x;
        memcpy(channel->plane + at * sample_bytes(channel), samples,
               (size_t)n * sample_bytes(channel));
    }
}

static bool load_kept_channels(struct writer *w, struct out_part *part)
{
    bool has_kept = false;
    for (int i = 0; i < part->n_channels; i++) {
        struct out_channel *channel = &part->channels[i];
        if (channel->sample >= 0)
            continue;
        has_kept = true;
        channel->plane =
            calloc(plane_width(part, channel) * plane_height(part, channel),
                   sample_bytes(channel));
        if (!channel->plane)
            return image_lacks_memory(w->error, w->path);
    }
    return !has_kept ||
           image_decode_rows(part->output->like, part->like_part, part->rows, keep_run,
                             part, w->n_threads, w->error);
}

static void free_planes(struct out_part *part)
{
    for (int i = 0; i < part->n_channels; i++) {
        free(part->channels[i].plane);
        part->channels[i].plane = NULL;
    }
}

/* The core sorts channels by name. */
bool writer_find_file_order(struct writer *w, int index)
{
    struct out_part *part = &w->parts[index];
    const exr_attr_chlist_t *list;
    exr_result_t result = exr_get_channels(w->context, index, &list);
    if (result != EXR_ERR_SUCCESS || list->num_channels != part->n_channels)
        return writer_fail(w, EXR_ERR_UNKNOWN);
    for (int i = 0; i < list->num_channels; i++)
        for (int k = 0; k < part->n_channels; k++)
            if (strcmp(list->entries[i].name.str, part->channels[k].name) == 0)
                part->in_file_order[i] = &part->channels[k];
    return true;
}

/* Converts n new samples of a row, from column x, to how they are stored. */
static void convert_line(const struct out_part *part, const struct out_channel *channel,
                         size_t row, struct span span, uint8_t *out)
{
    size_t stride = (size_t)part->output->n_channels;
    const float *in = part->samples +
                      (row * (size_t)part->output->width + span.x) * stride +
                      channel->sample;
    if (channel->type == EXR_PIXEL_HALF) {
        image_floats_to_halves(out, in, stride, span.n);
        return;
    }
    for (size_t i = 0; i < span.n; i++, in += stride, out += 4) {
        uint32_t whole;
        if (channel->type == EXR_PIXEL_FLOAT) {
            memcpy(out, in, 4);
        } else {
            whole = float_to_uint(*in);
            memcpy(out, &whole, 4);
        }
    }
}

/* What a chunk covers of a row of this channel, and its first row, from the top. */
static struct span chunk_span(const struct out_part *part,
                              const struct out_channel *channel,
                              const exr_chunk_info_t *chunk)
{
    if (part->tile_size > 0)
        return (struct span){(size_t)chunk->start_x * (size_t)part->tile_size,
                             (size_t)chunk->width};
    return (struct span){0, plane_width(part, channel)};
}

static int32_t chunk_row(const struct out_part *part, const exr_chunk_info_t *chunk)
{
    if (part->tile_size > 0)
        return chunk->start_y * part->tile_size;
    return chunk->start_y - part->data_window.min.y;
}

/* Returns the number of bytes; with out = NULL only counts. */
static size_t pack_lines(const struct out_part *part, const exr_chunk_info_t *chunk,
                         uint8_t *out)
{
    size_t n_bytes = 0;
    for (int32_t line = 0; line < chunk->height; line++) {
        int32_t row = chunk_row(part, chunk) + line;
        for (int i = 0; i < part->n_channels; i++) {
            const struct out_channel *channel = part->in_file_order[i];
            if ((part->data_window.min.y + row) % channel->y_sampling != 0)
                continue;
            struct span span = chunk_span(part, channel, chunk);
            size_t bytes = sample_bytes(channel);
            if (out && channel->sample >= 0) {
                convert_line(part, channel, (size_t)(row - part->rows.first), span,
                             out + n_bytes);
            } else if (out) {
                size_t plane_row = (size_t)(row / channel->y_sampling -
                                            first_plane_row(part, channel));
                size_t at = plane_row * plane_width(part, channel) + span.x;
                memcpy(out + n_bytes, channel->plane + at * bytes, span.n * bytes);
            }
            n_bytes += span.n * bytes;
        }
    }
    return n_bytes;
}

/* Packs and compresses; data and size stay with the pipeline. */
static exr_result_t encode_chunk(struct writer *w, int index,
                                 const exr_chunk_info_t *chunk,
                                 exr_encode_pipeline_t *pipeline, const void **data,
                                 uint64_t *size)
{
    const struct out_part *part = &w->parts[index];
    exr_result_t result = exr_encoding_initialize(w->context, index, chunk, pipeline);
    if (result == EXR_ERR_SUCCESS)
        result = exr_encoding_choose_default_routines(w->context, index, pipeline);
    if (result != EXR_ERR_SUCCESS)
        return result;
    size_t n_bytes = pack_lines(part, chunk, NULL);
    pipeline->packed_buffer = malloc(n_bytes + 1);
    if (!pipeline->packed_buffer)
        return EXR_ERR_OUT_OF_MEMORY;
    pipeline->packed_alloc_size = n_bytes + 1;
    pipeline->packed_bytes = n_bytes;
    pack_lines(part, chunk, pipeline->packed_buffer);
    *data = pipeline->packed_buffer;
    *size = n_bytes;
    if (!pipeline->compress_fn || n_bytes == 0)
        return EXR_ERR_SUCCESS;
    result = pipeline->compress_fn(pipeline);
    if (result == EXR_ERR_SUCCESS && pipeline->compressed_bytes < n_bytes) {
        *data = pipeline->compressed_buffer;
        *size = pipeline->compressed_bytes;
    }
    return result;
}

/* exr_encoding_destroy of 3.1 unlocks a lock that it does not hold. */
static void free_pipeline(exr_encode_pipeline_t *pipeline)
{
    if (pipeline->channels != pipeline->_quick_chan_store)
        free(pipeline->channels);
    free(pipeline->packed_buffer);
    free(pipeline->compressed_buffer);
    free(pipeline->scratch_buffer_1);
    free(pipeline->scratch_buffer_2);
}

/* Rows of a chunk; 0 on failure. */
int32_t writer_row_step(const struct writer *w, int index)
{
    int32_t step = w->parts[index].tile_size;
    if (step == 0 &&
        exr_get_scanlines_per_chunk(w->context, index, &step) != EXR_ERR_SUCCESS)
        step = 0;
    return step;
}

static int tiles_per_row(const struct out_part *part)
{
    int64_t width = (int64_t)part->data_window.max.x - part->data_window.min.x + 1;
    return part->tile_size > 0 ? (int)((width - 1) / part->tile_size) + 1 : 1;
}

static exr_result_t find_out_chunk(const struct writer *w, int index, int i,
                                   exr_chunk_info_t *chunk)
{
    const struct out_part *part = &w->parts[index];
    int n_x = tiles_per_row(part);
    if (part->tile_size > 0)
        return exr_write_tile_chunk_info(w->context, index, i % n_x, i / n_x, 0, 0,
                                         chunk);
    return exr_write_scanline_chunk_info(
        w->context, index, part->data_window.min.y + i * writer_row_step(w, index),
        chunk);
}

static exr_result_t store_chunk(const struct writer *w, int index,
                                const exr_chunk_info_t *chunk, const void *data,
                                uint64_t size)
{
    if (w->parts[index].tile_size > 0)
        return exr_write_tile_chunk(w->context, index, chunk->start_x, chunk->start_y,
                                    0, 0, data, size);
    return exr_write_scanline_chunk(w->context, index, chunk->start_y, data, size);
}

/* A chunk that is encoded and waits for those before it. */
struct encoded {
    bool is_ready;
    exr_result_t result;
    exr_encode_pipeline_t pipeline; /* owns data */
    exr_chunk_info_t chunk;
    const void *data;
    uint64_t size;
};

struct encoder {
    struct writer *w;
    int index;              /* of the part */
    int first;              /* chunk of chunks[0] */
    int n_chunks, n_stored; /* those before n_stored are in the file */
    struct encoded *chunks;
    _Atomic bool is_failed; /* asked outside the lock, to do no more in vain */
    char message[400];
    struct os_lock lock; /* of what is stored, and of the message */
};

static void encode_one(struct encoder *e, int i)
{
    static const exr_encode_pipeline_t empty = EXR_ENCODE_PIPELINE_INITIALIZER;
    struct encoded *c = &e->chunks[i];
    c->pipeline = empty;
    image_core_clear();
    c->result = find_out_chunk(e->w, e->index, e->first + i, &c->chunk);
    if (c->result == EXR_ERR_SUCCESS)
        c->result =
            encode_chunk(e->w, e->index, &c->chunk, &c->pipeline, &c->data, &c->size);
}

static void note_failure(struct encoder *e, exr_result_t result)
{
    if (!e->is_failed)
        snprintf(e->message, sizeof e->message, "%s", image_core_message(result));
    e->is_failed = true;
}

/* Stores what is next in the file, as far as it is encoded. One thread at a time. */
static void store_ready(struct encoder *e)
{
    while (e->n_stored < e->n_chunks && e->chunks[e->n_stored].is_ready) {
        struct encoded *c = &e->chunks[e->n_stored++];
        image_core_clear();
        exr_result_t result = c->result;
        if (!e->is_failed && result == EXR_ERR_SUCCESS)
            result = store_chunk(e->w, e->index, &c->chunk, c->data, c->size);
        if (result != EXR_ERR_SUCCESS)
            note_failure(e, result);
        free_pipeline(&c->pipeline);
    }
}

static void encode_chunks(void *data, int64_t begin, int64_t end, int thread)
{
    struct encoder *e = data;
    for (int i = (int)begin; i < (int)end; i++) {
        e->chunks[i].result = EXR_ERR_UNKNOWN;
        if (!e->is_failed)
            encode_one(e, i);
        os_lock_take(&e->lock);
        if (e->chunks[i].result != EXR_ERR_SUCCESS)
            note_failure(e, e->chunks[i].result);
        e->chunks[i].is_ready = true;
        store_ready(e);
        os_lock_release(&e->lock);
    }
}

/*
 * Encodes the rows in memory; they begin with a chunk. No thread waits for its turn to
 * write: whoever completes the next chunk in the file also stores those that are ready
 * behind it.
 */
static bool encode_rows(struct writer *w, int index)
{
    const struct out_part *part = &w->parts[index];
    int32_t step = writer_row_step(w, index);
    if (step < 1)
        return writer_fail(w, EXR_ERR_UNKNOWN);
    struct encoder e = {.w = w, .index = index};
    e.first = part->rows.first / step * tiles_per_row(part);
    int end = ((part->rows.first + part->rows.n - 1) / step + 1) * tiles_per_row(part);
    e.n_chunks = end - e.first;
    e.chunks = calloc((size_t)e.n_chunks, sizeof *e.chunks);
    if (!e.chunks)
        return image_lacks_memory(w->error, w->path);

    os_lock_init(&e.lock);
    os_parallel(w->n_threads < 1 ? 1 : w->n_threads, e.n_chunks, 1, encode_chunks, &e);
    os_lock_destroy(&e.lock);
    free(e.chunks);
    if (!e.is_failed)
        return true;
    image_core_clear();
    image_core_on_error(NULL, EXR_ERR_UNKNOWN, e.message);
    return writer_fail(w, EXR_ERR_UNKNOWN);
}

bool writer_make_rows(struct writer *w, int index, struct image_rows rows,
                      const float *samples)
{
    struct out_part *part = &w->parts[index];
    part->rows = rows;
    part->samples = samples;
    bool is_good = load_kept_channels(w, part) && encode_rows(w, index);
    free_planes(part);
    return is_good;
}

int32_t writer_height(const struct out_part *part)
{
    return part->data_window.max.y - part->data_window.min.y + 1;
}

static bool make_part(struct writer *w, int index)
{
    const struct out_part *part = &w->parts[index];
    return writer_find_file_order(w, index) &&
           writer_make_rows(w, index, (struct image_rows){0, writer_height(part)},
                            part->output->samples);
}

/* Parts first to end - 1. */
bool writer_write_parts(struct writer *w, int first, int end)
{
    for (int i = first; i < end; i++)
        if (!(w->parts[i].is_copied ? copy_part(w, i) : make_part(w, i)))
            return false;
    return true;
}
