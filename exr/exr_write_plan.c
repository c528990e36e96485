/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a file will hold, part by part, and its header. What can be asked for is checked
 * before anything is written.
 *
 * DWAA and DWAB are only read: OpenEXRCore 3.1 cannot compress them, and no later one
 * promises the same bits on every processor. Where one is inherited from the input, zip
 * takes its place. So does it for every lossy compression when channels of the input
 * are kept in the part, which a second compression would change.
 */
#include "exr_writer.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"

static int64_t write_at(exr_const_context_t context, void *user, const void *buffer,
                        uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t report)
{
    struct writer *w = user;
    if (os_file_write_at(w->file.fd, buffer, size, offset) == size)
        return (int64_t)size;
    w->write_errno = errno;
    return -1;
}

bool writer_fail(struct writer *w, exr_result_t result)
{
    if (w->write_errno != 0)
        return partial_fail(w->path, w->write_errno, w->error);
    return image_fail(w->error, w->path, "cannot write: %s",
                      image_core_message(result));
}
/* ---- the plan ------------------------------------------------------------------- */

static exr_pixel_type_t to_pixel_type(enum image_sample_type type)
{
    switch (type) {
    case IMAGE_SAMPLE_HALF:
        return EXR_PIXEL_HALF;
    case IMAGE_SAMPLE_FLOAT:
        return EXR_PIXEL_FLOAT;
    default:
        return EXR_PIXEL_UINT;
    }
}

static bool is_replaced(const struct image_output *output, const char *name)
{
    for (int i = 0; i < output->n_channels; i++)
        if (strcmp(output->channel_names[i], name) == 0)
            return true;
    return false;
}

static exr_attr_box2i_t from_box(const struct image_box *box)
{
    exr_attr_box2i_t out;
    out.min.x = box->min_x;
    out.min.y = box->min_y;
    out.max.x = box->max_x;
    out.max.y = box->max_y;
    return out;
}

static void add_new_channels(struct out_part *part, const struct image_output *output)
{
    for (int i = 0; i < output->n_channels; i++)
        part->channels[part->n_channels++] = (struct out_channel){
            .name = output->channel_names[i],
            .type = to_pixel_type(output->types ? output->types[i] : IMAGE_SAMPLE_HALF),
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

static bool is_only_read(int compression)
{
    return compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB;
}

static void choose_compression(const struct image_output *output, struct out_part *part,
                               bool is_target)
{
    const char *name = is_target ? output->compression : NULL;
    if (!name && output->like)
        name = output->like->parts[part->like_part].compression;
    part->compression = image_compression_number(name ? name : "zip");
    bool is_inherited = !(is_target && output->compression);
    bool has_kept = false;
    for (int i = 0; i < part->n_channels; i++)
        has_kept |= part->channels[i].sample < 0;
    if (is_inherited && (is_only_read(part->compression) ||
                         (has_kept && image_is_lossy(part->compression))))
        part->compression = EXR_COMPRESSION_ZIP;
}

/* A part made anew: the target with the new samples, or another that cannot be copied.
 */
static bool plan_made(struct writer *w, struct out_part *part, bool is_target)
{
    const struct image_output *output = w->output;
    size_t n = is_target ? (size_t)output->n_channels : 0;
    if (output->like)
        n += (size_t)(output->like->first_channel[part->like_part + 1] -
                      output->like->first_channel[part->like_part]);
    part->channels = calloc(n, sizeof *part->channels);
    part->in_file_order = calloc(n, sizeof *part->in_file_order);
    if (!part->channels || !part->in_file_order)
        return image_lacks_memory(w->error, w->path);
    if (is_target)
        add_new_channels(part, output);
    if (output->like && (output->pass_through || !is_target) &&
        !add_kept_channels(w, part, is_target))
        return image_fail(w->error, w->path, "cannot read the channels of %s",
                          image_path(output->like));
    part->tile_size = is_target ? output->tile_size : 0;
    for (int i = 0; part->tile_size > 0 && i < part->n_channels; i++)
        if (part->channels[i].x_sampling != 1 || part->channels[i].y_sampling != 1)
            return image_fail(w->error, w->path,
                              "channel \"%s\" is sub-sampled, which tiles cannot hold; "
                              "write scan lines",
                              part->channels[i].name);
    choose_compression(output, part, is_target);
    return true;
}

/* A window of the output: its own, or the whole picture where it has none. */
static struct image_box window_of(const struct image_output *output,
                                  struct image_box own)
{
    const bool has_own = own.min_x || own.min_y || own.max_x || own.max_y;
    const struct image_box whole = {0, 0, output->width - 1, output->height - 1};
    return has_own ? own : whole;
}

void writer_plan_windows(const struct image_output *output, struct out_part *part)
{
    if (output->like) {
        const struct image_part_info *info = &output->like->parts[part->like_part];
        const bool is_own = output->has_own_windows;
        part->data_window =
            from_box(is_own ? &output->data_window : &info->data_window);
        part->display_window =
            from_box(is_own ? &output->display_window : &info->display_window);
        part->pixel_aspect = info->pixel_aspect;
    } else {
        const struct image_box data = window_of(output, output->data_window);
        const struct image_box display = window_of(output, output->display_window);
        part->data_window = from_box(&data);
        part->display_window = from_box(&display);
        part->pixel_aspect = output->pixel_aspect > 0 ? output->pixel_aspect : 1.0f;
    }
}

/* Rip-maps are made anew, as one level: 3.1 counts their tiles wrongly. */
static bool is_ripmap(const struct image_input *input, int part)
{
    uint32_t width, height;
    exr_tile_level_mode_t levels;
    exr_tile_round_mode_t rounding;
    return input->parts[part].is_tiled &&
           exr_get_tile_descriptor(input->context, part, &width, &height, &levels,
                                   &rounding) == EXR_ERR_SUCCESS &&
           levels == EXR_TILE_RIPMAP_LEVELS;
}

bool writer_plan(struct writer *w)
{
    const struct image_output *output = w->output;
    bool is_whole = output->like && output->pass_through;
    w->n_parts = is_whole ? output->like->n_parts : 1;
    w->parts = calloc((size_t)w->n_parts, sizeof *w->parts);
    if (!w->parts)
        return image_lacks_memory(w->error, w->path);
    for (int i = 0; i < w->n_parts; i++) {
        struct out_part *part = &w->parts[i];
        part->output = output;
        part->like_part = is_whole ? i : output->like ? output->like_part : -1;
        bool is_target = part->like_part < 0 || part->like_part == output->like_part;
        writer_plan_windows(output, part);
        part->is_copied = !is_target && !is_ripmap(output->like, i);
        if (part->is_copied)
            part->compression =
                image_compression_number(output->like->parts[i].compression);
        else if (!plan_made(w, part, is_target))
            return false;
    }
    return true;
}

bool writer_check(const struct image_output *output, const char *path,
                  struct image_error *error)
{
    struct image_box box = window_of(output, output->data_window);
    if (output->like) {
        if (output->like_part < 0 || output->like_part >= output->like->n_parts)
            return image_fail(error, path, "%s has no part %d",
                              image_path(output->like), output->like_part);
        if (!output->has_own_windows)
            box = output->like->parts[output->like_part].data_window;
        if (output->pass_through && output->like->parts[output->like_part].is_deep)
            return image_fail(error, path,
                              "the deep samples of %s cannot be kept beside the flat "
                              "picture made of them",
                              image_path(output->like));
    }
    if (output->like && output->pass_through && !image_check_parts(output->like, error))
        return false;
    if (output->n_channels < 1)
        return image_fail(error, path, "no channel to write");
    if (output->tile_size < 0 || output->tile_size > IMAGE_MAX_SIDE)
        return image_fail(error, path, "tiles of %d px; take 16 to 4096",
                          (int)output->tile_size);
    if ((int64_t)box.max_x - box.min_x + 1 != output->width ||
        (int64_t)box.max_y - box.min_y + 1 != output->height)
        return image_fail(error, path,
                          "the picture of %d x %d px does not fit its data window",
                          (int)output->width, (int)output->height);
    int compression = output->compression
                          ? image_compression_number(output->compression)
                          : EXR_COMPRESSION_ZIP;
    if (compression < 0)
        return image_fail(error, path,
                          "unknown compression \"%s\"; known are none, rle, zips, zip, "
                          "piz, pxr24, b44, b44a",
                          output->compression);
    if (is_only_read(compression))
        return image_fail(error, path, "%s can be read, but not written; take zip",
                          output->compression);
    for (int i = 0; i < output->n_channels; i++)
        for (int k = 0; k < i; k++)
            if (strcmp(output->channel_names[i], output->channel_names[k]) == 0)
                return image_fail(error, path, "channel \"%s\" is given twice",
                                  output->channel_names[i]);
    return true;
}

void writer_free_plan(struct writer *w)
{
    for (int i = 0; w->parts && i < w->n_parts; i++) {
        free(w->parts[i].channels);
        free(w->parts[i].in_file_order);
    }
    free(w->parts);
}

/* ---- the header ----------------------------------------------------------------- */

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
static size_t longest_name(const struct image_output *output)
{
    const struct image_input *like = output->like;
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
    const struct image_input *like = part->output->like;
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
    const struct image_input *like = part->output->like;
    bool is_named = like && !image_is_dropped(part->output, "name");
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
        result = image_set_attributes(w->context, index, part->output);
    if (result == EXR_ERR_SUCCESS && like)
        result =
            image_copy_attributes(w->context, index, part->output, part->like_part);
    if (result == EXR_ERR_SUCCESS && part->alike)
        result = image_set_alike(w->context, index, part->alike);
    return result;
}

bool writer_write_header(struct writer *w)
{
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = image_core_on_error;
    settings.user_data = w;
    settings.write_fn = write_at;
    settings.alloc_fn = malloc; /* known, for free_pipeline */
    settings.zip_level = 4; /* as the C++ library; 6 takes 30 % more time for 0.7 % */
    settings.free_fn = free;

    image_core_clear();
    exr_result_t result =
        exr_start_write(&w->context, w->path, EXR_WRITE_FILE_DIRECTLY, &settings);
    bool has_long_name = false;
    for (int i = 0; i < w->n_parts; i++)
        has_long_name |= longest_name(w->parts[i].output) > 31;
    if (result == EXR_ERR_SUCCESS && has_long_name)
        result = exr_set_longname_support(w->context, 1);
    for (int i = 0; i < w->n_parts && result == EXR_ERR_SUCCESS; i++)
        result = add_part(w, i);
    if (image_core_lacked_memory())
        result = EXR_ERR_OUT_OF_MEMORY;
    if (result == EXR_ERR_SUCCESS)
        result = exr_write_header(w->context);
    return result == EXR_ERR_SUCCESS || writer_fail(w, result);
}
