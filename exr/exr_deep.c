/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads deep parts. A chunk is one or more lines, or a tile, in two pieces: per pixel
 * the running count of samples of its line, then for each line and channel the samples
 * of all its pixels. Each piece is compressed on its own (none, RLE, ZIPS, ZIP), or
 * stored as it is where that is no longer.
 *
 * The counts of all chunks are read first and held against the size that each chunk
 * says its samples have; only then memory for the samples is taken.
 */
#include "exr_private.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <zlib.h>

#include "file.h"
#include "parallel.h"

struct reader {
    struct image_input *input;
    int part;
    struct image_chunks chunks;
    const int *wanted; /* indices into input->channels */
    int n;
    int sample_bytes; /* of all channels */
    struct image_deep *deep;
};

/* ---- compression --------------------------------------------------------------- */

static bool undo_rle(const uint8_t *in, size_t n_in, uint8_t *out, size_t n_out)
{
    while (n_in > 0) {
        int count = (int8_t)*in++;
        n_in--;
        size_t n = count < 0 ? (size_t)-count : (size_t)count + 1;
        size_t n_read = count < 0 ? n : 1;
        if (n > n_out || n_read > n_in)
            return false;
        if (count < 0)
            memcpy(out, in, n);
        else
            memset(out, *in, n);
        in += n_read;
        n_in -= n_read;
        out += n;
        n_out -= n;
    }
    return n_out == 0;
}

/* Differences to values, then the two halves of the bytes into one. */
static void undo_predictor(uint8_t *bytes, uint8_t *out, size_t n)
{
    for (size_t i = 1; i < n; i++)
        bytes[i] = (uint8_t)(bytes[i - 1] + bytes[i] - 128);
    const uint8_t *even = bytes, *odd = bytes + (n + 1) / 2;
    for (size_t i = 0; i < n; i++)
        out[i] = i % 2 ? *odd++ : *even++;
}

static bool undo(int compression, const uint8_t *packed, size_t n_packed,
                 uint8_t *scratch, uint8_t *out, size_t n_out)
{
    uLongf n = n_out;
    switch (compression) {
    case EXR_COMPRESSION_RLE:
        if (!undo_rle(packed, n_packed, scratch, n_out))
            return false;
        break;
    case EXR_COMPRESSION_ZIPS:
    case EXR_COMPRESSION_ZIP:
        if (uncompress(scratch, &n, packed, n_packed) != Z_OK || n != n_out)
            return false;
        break;
    default:
        return false;
    }
    undo_predictor(scratch, out, n_out);
    return true;
}

static bool read_bytes(const struct image_input *input, uint8_t *to, size_t n,
                       uint64_t offset)
{
    return os_file_read_at(input->fd, to, n, offset) == n;
}

/*
 * Samples are stored as they are where that is no longer. Of a table only compression
 * that fails says so: OpenEXR compares with the size of a whole tile, and of a tile at
 * the border that is stored as it is writes the size of a whole one, its end unused.
 */
static bool unpack(const uint8_t *packed, size_t n_packed, bool is_table,
                   int compression, uint8_t *scratch, uint8_t *out, size_t n_out)
{
    bool is_plain = n_packed == n_out && !is_table;
    if (!is_plain && undo(compression, packed, n_packed, scratch, out, n_out))
        return true;
    if (!is_plain && !(is_table && n_packed >= n_out))
        return false;
    memcpy(out, packed, n_out);
    return true;
}

/* Reads and undoes one piece of a chunk; NULL where it is damaged. The caller frees. */
static uint8_t *read_piece(const struct reader *r, const exr_chunk_info_t *chunk,
                           bool is_table, uint64_t offset, uint64_t n_packed,
                           uint64_t n_unpacked)
{
    uint64_t size = (uint64_t)r->input->size_bytes;
    uint64_t ratio = image_max_ratio(chunk->compression);
    if (offset > size || n_packed > size - offset ||
        n_unpacked / ratio > n_packed + 64 || (n_packed == 0 && n_unpacked > 0))
        return NULL;
    uint8_t *packed = malloc(n_packed + 1), *scratch = malloc(n_unpacked + 1);
    uint8_t *out = malloc(n_unpacked + 1);
    bool is_good = packed && scratch && out &&
                   read_bytes(r->input, packed, n_packed, offset) &&
                   unpack(packed, n_packed, is_table, chunk->compression, scratch, out,
                          n_unpacked);
    free(packed);
    free(scratch);
    if (is_good)
        return out;
    free(out);
    return NULL;
}

/* ---- chunks -------------------------------------------------------------------- */

/* Where a chunk lies in the picture; false where the file puts it outside. */
static bool place_chunk(const struct reader *r, const exr_chunk_info_t *chunk,
                        int32_t *x, int32_t *y)
{
    const struct image_box *box = &r->input->parts[r->part].data_window;
    bool is_tile = r->chunks.n_tiles_x > 0;
    *x = is_tile ? chunk->start_x * r->chunks.tile_width : 0;
    *y = is_tile ? chunk->start_y * r->chunks.tile_height : chunk->start_y - box->min_y;
    return *x >= 0 && *y >= 0 && chunk->width >= 0 && chunk->height >= 0 &&
           chunk->width <= r->deep->width - *x && chunk->height <= r->deep->height - *y;
}

/* Samples in line `line` of a chunk, -1 where its counts fall. */
static int64_t count_line(const uint8_t *table, int32_t width, int32_t line,
                          size_t *counts)
{
    int32_t before = 0;
    for (int32_t i = 0; i < width; i++) {
        int32_t now;
        memcpy(&now, table + 4 * ((size_t)line * (size_t)width + (size_t)i), 4);
        if (now < before)
            return -1;
        if (counts)
            counts[i] = (size_t)(now - before);
        before = now;
    }
    return before;
}

static uint8_t *read_table(const struct reader *r, const exr_chunk_info_t *chunk)
{
    uint64_t n = 4 * (uint64_t)chunk->width * (uint64_t)chunk->height;
    return read_piece(r, chunk, true, chunk->sample_count_data_offset,
                      chunk->sample_count_table_size, n);
}

/* Puts the counts of a chunk into deep->first, shifted by one. */
static bool read_counts(const struct reader *r, const exr_chunk_info_t *chunk)
{
    int32_t x, y;
    if (!place_chunk(r, chunk, &x, &y))
        return false;
    uint8_t *table = read_table(r, chunk);
    if (!table)
        return false;
    uint64_t n_samples = 0;
    bool is_good = true;
    for (int32_t line = 0; line < chunk->height && is_good; line++) {
        size_t at = (size_t)(y + line) * (size_t)r->deep->width + (size_t)x;
        int64_t n = count_line(table, chunk->width, line, r->deep->first + at + 1);
        is_good = n >= 0;
        n_samples += n > 0 ? (uint64_t)n : 0;
    }
    free(table);
    return is_good && n_samples * (uint64_t)r->sample_bytes == chunk->unpacked_size;
}

/* Hands the samples of one channel of one line to their pixels; returns the end. */
static const uint8_t *put_channel(const struct reader *r, int channel, size_t first,
                                  int64_t n_samples, const uint8_t *samples)
{
    enum image_sample_type type = r->input->channels[channel].type;
    for (int c = 0; c < r->n; c++)
        if (r->wanted[c] == channel)
            for (int64_t i = 0; i < n_samples; i += INT32_MAX / 8) {
                int64_t left = n_samples - i;
                int32_t n = left < INT32_MAX / 8 ? (int32_t)left : INT32_MAX / 8;
                image_convert_run(
                    r->deep->samples + (first + (size_t)i) * (size_t)r->n + (size_t)c,
                    (size_t)r->n, type, n, samples + i * image_sample_bytes(type));
            }
    return samples + n_samples * image_sample_bytes(type);
}

/* A line of a chunk is a run of whole pixels, and so of samples. */
static bool read_samples(const struct reader *r, const exr_chunk_info_t *chunk)
{
    int32_t x, y;
    if (!place_chunk(r, chunk, &x, &y))
        return false;
    /* Chunks that claim the same lines have left other counts than their own. */
    uint64_t n_samples = 0;
    for (int32_t line = 0; line < chunk->height; line++) {
        const size_t *first =
            r->deep->first + (size_t)(y + line) * (size_t)r->deep->width + (size_t)x;
        n_samples += first[chunk->width] - first[0];
    }
    if (n_samples * (uint64_t)r->sample_bytes != chunk->unpacked_size)
        return false;
    uint8_t *data = read_piece(r, chunk, false, chunk->data_offset, chunk->packed_size,
                               chunk->unpacked_size);
    if (!data)
        return false;
    const uint8_t *at = data;
    for (int32_t line = 0; line < chunk->height; line++) {
        size_t pixel = (size_t)(y + line) * (size_t)r->deep->width + (size_t)x;
        size_t first = r->deep->first[pixel];
        int64_t n = (int64_t)(r->deep->first[pixel + (size_t)chunk->width] - first);
        for (int c = r->input->first_channel[r->part];
             c < r->input->first_channel[r->part + 1]; c++)
            at = put_channel(r, c, first, n, at);
    }
    free(data);
    return true;
}

/* What the threads share that visit chunks. */
struct visiting {
    const struct reader *r;
    bool (*visit)(const struct reader *, const exr_chunk_info_t *);
    _Atomic int n_bad;
};

static void visit_chunks(void *data, int64_t begin, int64_t end, int thread)
{
    struct visiting *v = data;
    const struct reader *r = v->r;
    for (int i = (int)begin; i < (int)end; i++) {
        exr_chunk_info_t chunk;
        image_core_clear();
        if (image_find_chunk(r->input, r->part, &r->chunks, i, &chunk) !=
                EXR_ERR_SUCCESS ||
            !v->visit(r, &chunk))
            v->n_bad++;
    }
}

static bool each_chunk(const struct reader *r, int n_threads,
                       bool (*visit)(const struct reader *, const exr_chunk_info_t *),
                       struct image_error *error)
{
    struct visiting v = {.r = r, .visit = visit};
    os_parallel(n_threads < 1 ? 1 : n_threads, r->chunks.n_chunks, 1, visit_chunks, &v);
    return v.n_bad == 0 ||
           image_fail(error, r->input->path,
                      "damaged: %d of %d chunks of deep samples cannot be read",
                      v.n_bad, r->chunks.n_chunks);
}

static bool check_channels(struct reader *r, struct image_error *error)
{
    const struct image_input *input = r->input;
    for (int c = 0; c < r->n; c++)
        if (r->wanted[c] >= 0 && (r->wanted[c] >= input->n_channels ||
                                  input->channels[r->wanted[c]].part != r->part))
            return image_fail(error, input->path,
                              "colour and depth of deep samples must be in one part");
    for (int c = input->first_channel[r->part]; c < input->first_channel[r->part + 1];
         c++) {
        const struct image_channel_info *info = &input->channels[c];
        if (info->x_sampling != 1 || info->y_sampling != 1)
            return image_fail(error, input->path,
                              "channel %s of deep samples is sub-sampled", info->name);
        r->sample_bytes += image_sample_bytes(info->type);
    }
    return true;
}

static bool allocate_samples(const struct reader *r, struct image_error *error)
{
    struct image_deep *deep = r->deep;
    size_t n_pixels = (size_t)deep->width * (size_t)deep->height;
    deep->first[0] = 0;
    for (size_t i = 0; i < n_pixels; i++)
        deep->first[i + 1] += deep->first[i];
    size_t n = deep->first[n_pixels];
    const struct image_input *input = r->input;
    /* The counts are the file's word; what it cannot hold takes no memory. */
    const uint64_t most_bytes =
        (uint64_t)input->size_bytes *
        image_max_ratio(image_compression_number(input->parts[r->part].compression));
    if (n > most_bytes / (uint64_t)r->sample_bytes)
        return image_fail(error, input->path,
                          "damaged: %zu deep samples do not fit into %lld bytes", n,
                          (long long)input->size_bytes);
    if (n > SIZE_MAX / sizeof(float) / (size_t)r->n - 1)
        return image_fail(error, r->input->path, "damaged: %zu deep samples", n);
    deep->samples = calloc(n * (size_t)r->n + 1, sizeof *deep->samples);
    if (deep->samples)
        return true;
    image_fail(error, r->input->path, "out of memory for %zu deep samples", n);
    error->code = IMAGE_NO_MEMORY;
    return false;
}

bool image_read_deep(struct image_input *input, const int *channels, int n,
                     struct image_deep *deep, int n_threads, struct image_error *error)
{
    struct reader r = {.input = input, .wanted = channels, .n = n, .deep = deep};
    *deep = (struct image_deep){0};
    r.part = -1;
    for (int c = 0; c < n && r.part < 0; c++)
        if (channels[c] >= 0 && channels[c] < input->n_channels)
            r.part = input->channels[channels[c]].part;
    if (r.part < 0 || !input->parts[r.part].is_deep)
        return image_fail(error, input->path, "has no deep samples there");
    const struct image_box *box = &input->parts[r.part].data_window;
    deep->width = box->max_x - box->min_x + 1;
    deep->height = box->max_y - box->min_y + 1;
    if (!check_channels(&r, error) ||
        !image_plan_chunks(input, r.part, &r.chunks, error))
        return false;
    size_t n_pixels = (size_t)deep->width * (size_t)deep->height;
    /* Each chunk has at least its own header, and each pixel its share of a table. */
    if (n_pixels * 4 / 1200 > (uint64_t)input->size_bytes)
        return image_fail(
            error, input->path,
            "damaged or cut off: %d x %d deep pixels do not fit into %lld "
            "bytes",
            deep->width, deep->height, (long long)input->size_bytes);
    deep->first = calloc(n_pixels + 1, sizeof *deep->first);
    if (!deep->first)
        return image_lacks_memory(error, input->path);
    if (each_chunk(&r, n_threads, read_counts, error) && allocate_samples(&r, error) &&
        each_chunk(&r, n_threads, read_samples, error))
        return true;
    image_deep_free(deep);
    return false;
}

void image_deep_free(struct image_deep *deep)
{
    free(deep->first);
    free(deep->samples);
    *deep = (struct image_deep){0};
}

int image_find_z_back(const struct image_input *input, int z)
{
    const struct image_channel_info *depth = &input->channels[z];
    const char *dot = strrchr(depth->name, '.');
    size_t n = dot ? (size_t)(dot + 1 - depth->name) : 0;
    for (int c = input->first_channel[depth->part];
         c < input->first_channel[depth->part + 1]; c++) {
        const char *name = input->channels[c].name;
        if (strncmp(name, depth->name, n) == 0 && strcasecmp(name + n, "ZBack") == 0)
            return c;
    }
    return -1;
}
