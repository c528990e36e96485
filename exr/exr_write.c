/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes OpenEXR files.
 *
 * The file is planned as a list of parts. A part is either copied, chunk by chunk as
 * compressed in the input (this keeps tiles, mip-map levels, deep data and lossy
 * compression bit for bit), or made anew as scan lines or tiles of one level, from new
 * samples and from channels of the input that are kept as stored. Either all rows of a
 * made part are in memory, or a strip of them at a time.
 *
 * OpenEXRCore 3.1 cannot compress DWAA and DWAB; where that is inherited from the
 * input, zip takes its place. So does it for every lossy compression when channels of
 * the input are kept in the part, which a second compression would change. The pipeline
 * of the core holds a lock while it packs and takes a chunk that compressed to exactly
 * its own size for an uncompressed one, so packing and that choice are made here.
 */
#include "exr_private.h"

#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Columns of a row. */
struct span {
    size_t x, n;
};

struct out_channel {
    const char *name;
    exr_pixel_type_t type;
    int32_t x_sampling, y_sampling;
    uint8_t is_linear;
    int sample;       /* index into the new samples, or -1 */
    int like_channel; /* else: index in the part of the input */
    uint8_t *plane;   /* its samples as stored, of the rows in memory */
};

struct out_part {
    const struct exr_output *output;
    int like_part;    /* of output->like; -1: none */
    const char *name; /* NULL: as there */
    bool is_copied;
    int compression;
    exr_attr_box2i_t data_window, display_window;
    float pixel_aspect;
    int n_channels;
    struct out_channel *channels; /* of parts that are not copied */
    const struct out_channel **in_file_order;
    int32_t tile_size;    /* of parts that are not copied; 0: scan lines */
    struct exr_rows rows; /* those in memory */
    const float *samples; /* new ones, from the first of those rows */
};

struct writer {
    const struct exr_output *output; /* of all parts; of a joined file, of the first */
    const char *path;
    int n_threads;
    exr_context_t context;
    struct partial_file file;
    int write_errno;
    int n_parts;
    struct out_part *parts;
    struct exr_error *error;
};

static uint32_t float_to_uint(float value)
{
    if (!(value > 0.0f))
        return 0;
    return value >= 4294967296.0f ? UINT32_MAX : (uint32_t)llrintf(value);
}

static int64_t write_at(exr_const_context_t context, void *user, const void *buffer,
                        uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t report)
{
    struct writer *w = user;
    uint64_t done = 0;
    while (done < size) {
        ssize_t n = pwrite(w->file.fd, (const char *)buffer + done, size - done,
                           (off_t)(offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0) {
            w->write_errno = n < 0 ? errno : EIO;
            return -1;
        }
        done += (uint64_t)n;
    }
    return (int64_t)done;
}

static bool fail_core(struct writer *w, exr_result_t result)
{
    if (w->write_errno != 0)
        return partial_fail(&w->file, w->write_errno, w->error);
    return exr_fail(w->error, w->path, "cannot write: %s", exr_core_message(result));
}

/* The plan */

static exr_pixel_type_t to_pixel_type(enum exr_sample_type type)
{
    switch (type) {
    case EXR_SAMPLE_HALF:
        return EXR_PIXEL_HALF;
    case EXR_SAMPLE_FLOAT:
        return EXR_PIXEL_FLOAT;
    default:
        return EXR_PIXEL_UINT;
    }
}

static bool is_replaced(const struct exr_output *output, const char *name)
{
    for (int i = 0; i < output->n_channels; i++)
        if (strcmp(output->channel_names[i], name) == 0)
            return true;
    return false;
}

static exr_attr_box2i_t from_box(const struct exr_box *box)
{
    exr_attr_box2i_t out;
    out.min.x = box->min_x;
    out.min.y = box->min_y;
    out.max.x = box->max_x;
    out.max.y = box->max_y;
    return out;
}

static void add_new_channels(struct out_part *part, const struct exr_output *output)
{
    for (int i = 0; i < output->n_channels; i++)
        part->channels[part->n_channels++] = (struct out_channel){
            .name = output->channel_names[i],
            .type = to_pixel_type(output->types ? output->types[i] : EXR_SAMPLE_HALF),
            .x_sampling = 1,
            .y_sampling = 1,
            .sample = i,
        };
}

static bool add_kept_channels(struct writer *w, struct out_part *part, bool is_target)
{
    const exr_attr_chlist_t *list;
    if (exr_get_channels(w->output->like->context, part->like_part, &list) !=
        EXR_ERR_SUCCESS)
        return false;
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        if (is_target && is_replaced(w->output, entry->name.str))
            continue;
        part->channels[part->n_channels++] = (struct out_channel){
            .name = entry->name.str,
            .type = entry->pixel_type,
            .x_sampling = entry->x_sampling,
            .y_sampling = entry->y_sampling,
            .is_linear = entry->p_linear,
            .sample = -1,
            .like_channel = i,
        };
    }
    return true;
}

static void choose_compression(const struct exr_output *output, struct out_part *part,
                               bool is_target)
{
    const char *name = is_target ? output->compression : NULL;
    if (!name && output->like)
        name = output->like->parts[part->like_part].compression;
    part->compression = exr_compression_number(name ? name : "zip");
    bool is_inherited = !(is_target && output->compression);
    bool is_dwa = part->compression == EXR_COMPRESSION_DWAA ||
                  part->compression == EXR_COMPRESSION_DWAB;
    bool has_kept = false;
    for (int i = 0; i < part->n_channels; i++)
        has_kept |= part->channels[i].sample < 0;
    if (is_inherited && (is_dwa || (has_kept && exr_is_lossy(part->compression))))
        part->compression = EXR_COMPRESSION_ZIP;
}

/* A part made anew: the target with the new samples, or another that cannot be copied.
 */
static bool plan_made(struct writer *w, struct out_part *part, bool is_target)
{
    const struct exr_output *output = w->output;
    size_t n = is_target ? (size_t)output->n_channels : 0;
    if (output->like)
        n += (size_t)(output->like->first_channel[part->like_part + 1] -
                      output->like->first_channel[part->like_part]);
    part->channels = calloc(n, sizeof *part->channels);
    part->in_file_order = calloc(n, sizeof *part->in_file_order);
    if (!part->channels || !part->in_file_order)
        return exr_fail(w->error, w->path, "out of memory");
    if (is_target)
        add_new_channels(part, output);
    if (output->like && (output->pass_through || !is_target) &&
        !add_kept_channels(w, part, is_target))
        return exr_fail(w->error, w->path, "cannot read the channels of %s",
                        exr_path(output->like));
    part->tile_size = is_target ? output->tile_size : 0;
    for (int i = 0; part->tile_size > 0 && i < part->n_channels; i++)
        if (part->channels[i].x_sampling != 1 || part->channels[i].y_sampling != 1)
            return exr_fail(w->error, w->path,
                            "channel \"%s\" is sub-sampled, which tiles cannot hold; "
                            "write scan lines",
                            part->channels[i].name);
    choose_compression(output, part, is_target);
    return true;
}

static void plan_windows(const struct exr_output *output, struct out_part *part)
{
    if (output->like) {
        const struct exr_part_info *info = &output->like->parts[part->like_part];
        part->data_window = from_box(&info->data_window);
        part->display_window = from_box(&info->display_window);
        part->pixel_aspect = info->pixel_aspect;
    } else {
        part->data_window = from_box(&output->data_window);
        part->display_window = from_box(&output->display_window);
        part->pixel_aspect = output->pixel_aspect > 0 ? output->pixel_aspect : 1.0f;
    }
}

/* Rip-maps are made anew, as one level: 3.1 counts their tiles wrongly. */
static bool is_ripmap(const struct exr_input *input, int part)
{
    uint32_t width, height;
    exr_tile_level_mode_t levels;
    exr_tile_round_mode_t rounding;
    return input->parts[part].is_tiled &&
           exr_get_tile_descriptor(input->context, part, &width, &height, &levels,
                                   &rounding) == EXR_ERR_SUCCESS &&
           levels == EXR_TILE_RIPMAP_LEVELS;
}

static bool plan(struct writer *w)
{
    const struct exr_output *output = w->output;
    bool is_whole = output->like && output->pass_through;
    w->n_parts = is_whole ? output->like->n_parts : 1;
    w->parts = calloc((size_t)w->n_parts, sizeof *w->parts);
    if (!w->parts)
        return exr_fail(w->error, w->path, "out of memory");
    for (int i = 0; i < w->n_parts; i++) {
        struct out_part *part = &w->parts[i];
        part->output = output;
        part->like_part = is_whole ? i : output->like ? output->like_part : -1;
        bool is_target = part->like_part < 0 || part->like_part == output->like_part;
        plan_windows(output, part);
        part->is_copied = !is_target && !is_ripmap(output->like, i);
        if (part->is_copied)
            part->compression =
                exr_compression_number(output->like->parts[i].compression);
        else if (!plan_made(w, part, is_target))
            return false;
    }
    return true;
}

static bool check_output(const struct exr_output *output, const char *path,
                         struct exr_error *error)
{
    const struct exr_box *box = &output->data_window;
    if (output->like) {
        if (output->like_part < 0 || output->like_part >= output->like->n_parts)
            return exr_fail(error, path, "%s has no part %d", exr_path(output->like),
                            output->like_part);
        box = &output->like->parts[output->like_part].data_window;
        if (output->pass_through && output->like->parts[output->like_part].is_deep)
            return exr_fail(error, path,
                            "the deep samples of %s cannot be kept beside the flat "
                            "picture made of them",
                            exr_path(output->like));
    }
    if (output->n_channels < 1)
        return exr_fail(error, path, "no channel to write");
    if (output->tile_size < 0 || output->tile_size > EXR_MAX_SIDE)
        return exr_fail(error, path, "tiles of %d px; take 16 to 4096",
                        (int)output->tile_size);
    if ((int64_t)box->max_x - box->min_x + 1 != output->width ||
        (int64_t)box->max_y - box->min_y + 1 != output->height)
        return exr_fail(error, path,
                        "the picture of %d x %d px does not fit its data window",
                        (int)output->width, (int)output->height);
    int compression = output->compression ? exr_compression_number(output->compression)
                                          : EXR_COMPRESSION_ZIP;
    if (compression < 0)
        return exr_fail(error, path,
                        "unknown compression \"%s\"; known are none, rle, zips, zip, "
                        "piz, pxr24, b44, b44a",
                        output->compression);
    if (compression >= EXR_COMPRESSION_DWAA)
        return exr_fail(error, path,
                        "%s cannot be written by this version of OpenEXR; take zip",
                        output->compression);
    for (int i = 0; i < output->n_channels; i++)
        for (int k = 0; k < i; k++)
            if (strcmp(output->channel_names[i], output->channel_names[k]) == 0)
                return exr_fail(error, path, "channel \"%s\" is given twice",
                                output->channel_names[i]);
    return true;
}

/* The header */

static exr_storage_t storage_of(const struct out_part *part)
{
    exr_storage_t storage =
        part->tile_size > 0 ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE;
    if (part->is_copied)
        exr_get_storage(part->output->like->context, part->like_part, &storage);
    return storage;
}

static void lengthen(size_t *longest, const char *name)
{
    size_t length = strlen(name);
    if (length > *longest)
        *longest = length;
}

/* Longest of all names in the file; beyond 31 the file must say so up front. */
static size_t longest_name(const struct exr_output *output)
{
    const struct exr_input *like = output->like;
    size_t longest = 0;
    for (int i = 0; i < output->n_channels; i++)
        lengthen(&longest, output->channel_names[i]);
    for (int i = 0; i < output->n_attributes; i++)
        lengthen(&longest, output->attributes[i].name);
    for (int i = 0; like && i < like->n_channels; i++)
        lengthen(&longest, like->channels[i].name);
    for (int part = 0; like && part < like->n_parts; part++) {
        int32_t n = 0;
        const exr_attribute_t *a;
        exr_get_attribute_count(like->context, part, &n);
        for (int32_t i = 0; i < n; i++) {
            if (exr_get_attribute_by_index(like->context, part,
                                           EXR_ATTR_LIST_FILE_ORDER, i,
                                           &a) != EXR_ERR_SUCCESS)
                continue;
            lengthen(&longest, a->name);
            lengthen(&longest, a->type_name);
        }
    }
    return longest;
}

static exr_result_t set_structure(struct writer *w, int index)
{
    const struct out_part *part = &w->parts[index];
    const struct exr_input *like = part->output->like;
    exr_attr_v2f_t center;
    float width = 1.0f;
    center.x = center.y = 0.0f;
    if (like) {
        exr_get_screen_window_center(like->context, part->like_part, &center);
        exr_get_screen_window_width(like->context, part->like_part, &width);
    }
    return exr_initialize_required_attr(w->context, index, &part->display_window,
                                        &part->data_window, part->pixel_aspect, &center,
                                        width, EXR_LINEORDER_INCREASING_Y,
                                        (exr_compression_t)part->compression);
}

static bool is_deep(const struct out_part *part)
{
    return part->output->like->parts[part->like_part].is_deep;
}

/* The core asks every part of a file with deep parts for a version. */
static exr_result_t set_version(struct writer *w, int index)
{
    bool has_deep = false;
    for (int i = 0; w->n_parts > 1 && i < w->n_parts; i++)
        has_deep |= is_deep(&w->parts[i]);
    return has_deep ? exr_set_version(w->context, index, 1) : EXR_ERR_SUCCESS;
}

static exr_result_t set_tiles(struct writer *w, int index)
{
    const struct out_part *part = &w->parts[index];
    uint32_t width, height;
    exr_tile_level_mode_t levels;
    exr_tile_round_mode_t rounding;
    if (part->tile_size > 0)
        return exr_set_tile_descriptor(w->context, index, (uint32_t)part->tile_size,
                                       (uint32_t)part->tile_size, EXR_TILE_ONE_LEVEL,
                                       EXR_TILE_ROUND_DOWN);
    if (!part->is_copied || !part->output->like->parts[part->like_part].is_tiled)
        return EXR_ERR_SUCCESS;
    exr_result_t result =
        exr_get_tile_descriptor(part->output->like->context, part->like_part, &width,
                                &height, &levels, &rounding);
    if (result == EXR_ERR_SUCCESS)
        result =
            exr_set_tile_descriptor(w->context, index, width, height, levels, rounding);
    return result;
}

static exr_result_t set_channels(struct writer *w, int index)
{
    const struct out_part *part = &w->parts[index];
    exr_result_t result = EXR_ERR_SUCCESS;
    if (part->is_copied) {
        const exr_attr_chlist_t *list;
        result = exr_get_channels(part->output->like->context, part->like_part, &list);
        if (result == EXR_ERR_SUCCESS)
            result = exr_set_channels(w->context, index, list);
    }
    for (int i = 0; i < part->n_channels && result == EXR_ERR_SUCCESS; i++) {
        const struct out_channel *channel = &part->channels[i];
        result = exr_add_channel(w->context, index, channel->name, channel->type,
                                 channel->is_linear ? EXR_PERCEPTUALLY_LINEAR
                                                    : EXR_PERCEPTUALLY_LOGARITHMIC,
                                 channel->x_sampling, channel->y_sampling);
    }
    return result;
}

static exr_result_t add_part(struct writer *w, int index)
{
    const struct out_part *part = &w->parts[index];
    const struct exr_input *like = part->output->like;
    bool is_named = like && !exr_is_dropped(part->output, "name");
    const char *name = part->name ? part->name
                       : is_named ? like->parts[part->like_part].name
                                  : "";
    int made;
    exr_result_t result =
        exr_add_part(w->context, name[0] ? name : NULL, storage_of(part), &made);
    if (result == EXR_ERR_SUCCESS)
        result = set_structure(w, index);
    if (result == EXR_ERR_SUCCESS)
        result = set_channels(w, index);
    if (result == EXR_ERR_SUCCESS)
        result = set_tiles(w, index);
    if (result == EXR_ERR_SUCCESS)
        result = set_version(w, index);
    bool is_target = part->like_part < 0 || part->like_part == part->output->like_part;
    if (result == EXR_ERR_SUCCESS && is_target)
        result = exr_set_attributes(w->context, index, part->output);
    if (result == EXR_ERR_SUCCESS && like)
        result = exr_copy_attributes(w->context, index, part->output, part->like_part);
    return result;
}

static bool write_header(struct writer *w)
{
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = exr_core_on_error;
    settings.user_data = w;
    settings.write_fn = write_at;
    settings.alloc_fn = malloc; /* known, for free_pipeline */
    settings.zip_level = 4; /* as the C++ library; 6 takes 30 % more time for 0.7 % */
    settings.free_fn = free;

    exr_core_clear();
    exr_result_t result =
        exr_start_write(&w->context, w->path, EXR_WRITE_FILE_DIRECTLY, &settings);
    bool has_long_name = false;
    for (int i = 0; i < w->n_parts; i++)
        has_long_name |= longest_name(w->parts[i].output) > 31;
    if (result == EXR_ERR_SUCCESS && has_long_name)
        result = exr_set_longname_support(w->context, 1);
    for (int i = 0; i < w->n_parts && result == EXR_ERR_SUCCESS; i++)
        result = add_part(w, i);
    if (exr_core_lacked_memory())
        result = EXR_ERR_OUT_OF_MEMORY;
    if (result == EXR_ERR_SUCCESS)
        result = exr_write_header(w->context);
    return result == EXR_ERR_SUCCESS || fail_core(w, result);
}

/* Parts that are copied */

static exr_result_t copy_chunk(struct writer *w, int part,
                               const exr_chunk_info_t *chunk, bool is_tiled)
{
    const struct exr_input *like = w->parts[part].output->like;
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
    const struct exr_input *like = w->parts[part].output->like;
    int from = w->parts[part].like_part;
    const struct exr_box *box = &like->parts[from].data_window;
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
    const struct exr_input *like = w->parts[part].output->like;
    int from = w->parts[part].like_part;
    exr_result_t result;
    exr_core_clear();
    if (like->parts[from].is_tiled) {
        int32_t n_levels = 0;
        result = exr_get_tile_levels(like->context, from, &n_levels, NULL);
        for (int level = 0; level < n_levels && result == EXR_ERR_SUCCESS; level++)
            result = copy_level(w, part, level);
    } else {
        result = copy_lines(w, part);
    }
    if (result != EXR_ERR_SUCCESS && w->write_errno == 0)
        return exr_fail(w->error, exr_path(like), "damaged: %s",
                        exr_core_message(result));
    return result == EXR_ERR_SUCCESS || fail_core(w, result);
}

/* Parts that are made anew */

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
            return exr_fail(w->error, w->path, "out of memory");
    }
    return !has_kept || exr_decode_rows(part->output->like, part->like_part, part->rows,
                                        keep_run, part, w->n_threads, w->error);
}

static void free_planes(struct out_part *part)
{
    for (int i = 0; i < part->n_channels; i++) {
        free(part->channels[i].plane);
        part->channels[i].plane = NULL;
    }
}

/* The core sorts channels by name. */
static bool find_file_order(struct writer *w, int index)
{
    struct out_part *part = &w->parts[index];
    const exr_attr_chlist_t *list;
    exr_result_t result = exr_get_channels(w->context, index, &list);
    if (result != EXR_ERR_SUCCESS || list->num_channels != part->n_channels)
        return fail_core(w, EXR_ERR_UNKNOWN);
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
        exr_floats_to_halves(out, in, stride, span.n);
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
static int32_t row_step(const struct writer *w, int index)
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
        w->context, index, part->data_window.min.y + i * row_step(w, index), chunk);
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
};

static void encode_one(struct encoder *e, int i)
{
    static const exr_encode_pipeline_t empty = EXR_ENCODE_PIPELINE_INITIALIZER;
    struct encoded *c = &e->chunks[i];
    c->pipeline = empty;
    exr_core_clear();
    c->result = find_out_chunk(e->w, e->index, e->first + i, &c->chunk);
    if (c->result == EXR_ERR_SUCCESS)
        c->result =
            encode_chunk(e->w, e->index, &c->chunk, &c->pipeline, &c->data, &c->size);
}

static void note_failure(struct encoder *e, exr_result_t result)
{
    if (!e->is_failed)
        snprintf(e->message, sizeof e->message, "%s", exr_core_message(result));
    e->is_failed = true;
}

/* Stores what is next in the file, as far as it is encoded. One thread at a time. */
static void store_ready(struct encoder *e)
{
    while (e->n_stored < e->n_chunks && e->chunks[e->n_stored].is_ready) {
        struct encoded *c = &e->chunks[e->n_stored++];
        exr_core_clear();
        exr_result_t result = c->result;
        if (!e->is_failed && result == EXR_ERR_SUCCESS)
            result = store_chunk(e->w, e->index, &c->chunk, c->data, c->size);
        if (result != EXR_ERR_SUCCESS)
            note_failure(e, result);
        free_pipeline(&c->pipeline);
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
    int32_t step = row_step(w, index);
    if (step < 1)
        return fail_core(w, EXR_ERR_UNKNOWN);
    struct encoder e = {.w = w, .index = index};
    e.first = part->rows.first / step * tiles_per_row(part);
    int end = ((part->rows.first + part->rows.n - 1) / step + 1) * tiles_per_row(part);
    e.n_chunks = end - e.first;
    e.chunks = calloc((size_t)e.n_chunks, sizeof *e.chunks);
    if (!e.chunks)
        return exr_fail(w->error, w->path, "out of memory");

#pragma omp parallel for schedule(dynamic, 1) num_threads(w->n_threads)
    for (int i = 0; i < e.n_chunks; i++) {
        e.chunks[i].result = EXR_ERR_UNKNOWN;
        if (!e.is_failed)
            encode_one(&e, i);
#pragma omp critical(exr_store)
        {
            if (e.chunks[i].result != EXR_ERR_SUCCESS)
                note_failure(&e, e.chunks[i].result);
            e.chunks[i].is_ready = true;
            store_ready(&e);
        }
    }
    free(e.chunks);
    if (!e.is_failed)
        return true;
    exr_core_clear();
    exr_core_on_error(NULL, EXR_ERR_UNKNOWN, e.message);
    return fail_core(w, EXR_ERR_UNKNOWN);
}

static bool make_rows(struct writer *w, int index, struct exr_rows rows,
                      const float *samples)
{
    struct out_part *part = &w->parts[index];
    part->rows = rows;
    part->samples = samples;
    bool is_good = load_kept_channels(w, part) && encode_rows(w, index);
    free_planes(part);
    return is_good;
}

static int32_t height_of(const struct out_part *part)
{
    return part->data_window.max.y - part->data_window.min.y + 1;
}

static bool make_part(struct writer *w, int index)
{
    const struct out_part *part = &w->parts[index];
    return find_file_order(w, index) &&
           make_rows(w, index, (struct exr_rows){0, height_of(part)},
                     part->output->samples);
}

/* Parts first to end - 1. */
static bool write_range(struct writer *w, int first, int end)
{
    for (int i = first; i < end; i++)
        if (!(w->parts[i].is_copied ? copy_part(w, i) : make_part(w, i)))
            return false;
    return true;
}

static void free_plan(struct writer *w)
{
    for (int i = 0; w->parts && i < w->n_parts; i++) {
        free(w->parts[i].channels);
        free(w->parts[i].in_file_order);
    }
    free(w->parts);
}

static bool finish_context(struct writer *w, bool is_good)
{
    if (!w->context)
        return is_good;
    exr_core_clear();
    exr_result_t result = exr_finish(&w->context);
    return is_good && (result == EXR_ERR_SUCCESS || fail_core(w, result));
}

static bool write_planned(struct writer *w)
{
    bool is_good = write_header(w) && write_range(w, 0, w->n_parts);
    return finish_context(w, is_good);
}

static bool end_file(struct writer *w, bool is_good)
{
    free_plan(w);
    if (is_good)
        return partial_commit(&w->file, w->error);
    partial_abort(&w->file);
    return false;
}

bool exr_write(const char *path, const struct exr_output *output, int n_threads,
               struct exr_error *error)
{
    struct writer w = {
        .output = output,
        .path = path,
        .n_threads = n_threads < 1 ? 1 : n_threads,
        .error = error,
    };
    if (!output->samples)
        return exr_fail(error, path, "no channel to write");
    if (!check_output(output, path, error) || !partial_open(&w.file, path, error))
        return false;
    return end_file(&w, plan(&w) && write_planned(&w));
}

/* Strip by strip */

struct exr_writer {
    struct writer w;
    int target; /* the part that the strips belong to */
    int32_t next_row;
};

/* Header and parts before the target. */
static bool begin_file(struct exr_writer *writer)
{
    struct writer *w = &writer->w;
    if (!plan(w))
        return false;
    while (w->parts[writer->target].like_part >= 0 &&
           w->parts[writer->target].like_part != w->output->like_part)
        writer->target++;
    return write_header(w) && write_range(w, 0, writer->target) &&
           find_file_order(w, writer->target);
}

bool exr_write_begin(struct exr_writer **writer, const char *path,
                     const struct exr_output *output, int n_threads,
                     struct exr_error *error)
{
    *writer = NULL;
    if (!check_output(output, path, error))
        return false;
    struct exr_writer *new = calloc(1, sizeof *new);
    if (!new)
        return exr_fail(error, path, "out of memory");
    new->w = (struct writer){
        .output = output,
        .path = path,
        .n_threads = n_threads < 1 ? 1 : n_threads,
        .error = error,
    };
    if (!partial_open(&new->w.file, path, error)) {
        free(new);
        return false;
    }
    if (!begin_file(new)) {
        exr_write_abort(new);
        return false;
    }
    *writer = new;
    return true;
}

int32_t exr_write_step(const struct exr_writer *writer)
{
    return row_step(&writer->w, writer->target);
}

bool exr_write_rows(struct exr_writer *writer, int32_t n_rows, const float *samples,
                    struct exr_error *error)
{
    struct writer *w = &writer->w;
    const int32_t left = height_of(&w->parts[writer->target]) - writer->next_row;
    w->error = error;
    if (n_rows < 1 || n_rows > left ||
        (n_rows < left && n_rows % exr_write_step(writer) != 0))
        return exr_fail(error, w->path,
                        "a strip of %d rows with %d left; strips are multiples of %d "
                        "rows, but for the last",
                        (int)n_rows, (int)left, (int)exr_write_step(writer));
    if (!make_rows(w, writer->target, (struct exr_rows){writer->next_row, n_rows},
                   samples))
        return false;
    writer->next_row += n_rows;
    return true;
}

bool exr_write_finish(struct exr_writer *writer, struct exr_error *error)
{
    struct writer *w = &writer->w;
    const int32_t left = height_of(&w->parts[writer->target]) - writer->next_row;
    w->error = error;
    bool is_good = left == 0;
    if (!is_good)
        exr_fail(error, w->path, "the last %d rows are missing", (int)left);
    is_good = is_good && write_range(w, writer->target + 1, w->n_parts);
    is_good = end_file(w, finish_context(w, is_good));
    free(writer);
    return is_good;
}

void exr_write_abort(struct exr_writer *writer)
{
    struct exr_error ignored;
    if (!writer)
        return;
    writer->w.error = &ignored;
    finish_context(&writer->w, false);
    end_file(&writer->w, false);
    free(writer);
}

/* Several files joined to one */

/* Part i of the file is the first of input i. */
static bool plan_joined(struct writer *w, struct exr_input *const *inputs,
                        const char *const *views, struct exr_output *outputs,
                        struct exr_attribute *attributes)
{
    for (int i = 0; i < w->n_parts; i++) {
        if (inputs[i]->n_parts != 1 || inputs[i]->parts[0].is_deep)
            return exr_fail(w->error, w->path,
                            "%s has several parts or deep data; a view is one flat one",
                            exr_path(inputs[i]));
        attributes[i] = (struct exr_attribute){
            .name = "view", .type = EXR_ATTRIBUTE_STRING, .text = views[i]};
        outputs[i] = (struct exr_output){
            .like = inputs[i], .attributes = &attributes[i], .n_attributes = 1};
        struct out_part *part = &w->parts[i];
        *part = (struct out_part){
            .output = &outputs[i], .name = views[i], .is_copied = true};
        plan_windows(&outputs[i], part);
        part->compression = exr_compression_number(inputs[i]->parts[0].compression);
    }
    return true;
}

bool exr_join_views(const char *path, struct exr_input *const *inputs,
                    const char *const *views, int n, struct exr_error *error)
{
    struct writer w = {.path = path, .n_threads = 1, .error = error, .n_parts = n};
    struct exr_output *outputs = calloc((size_t)n, sizeof *outputs);
    struct exr_attribute *attributes = calloc((size_t)n, sizeof *attributes);
    w.parts = calloc((size_t)n, sizeof *w.parts);
    bool is_good = outputs && attributes && w.parts;
    if (!is_good)
        exr_fail(error, path, "out of memory");
    if (is_good && partial_open(&w.file, path, error))
        is_good = end_file(&w, plan_joined(&w, inputs, views, outputs, attributes) &&
                                   write_planned(&w));
    else {
        is_good = false;
        free_plan(&w);
    }
    free(attributes);
    free(outputs);
    return is_good;
}
