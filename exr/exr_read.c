/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens and decodes OpenEXR files.
 *
 * OpenEXRCore parses the header and undoes the compression of a chunk; finding the
 * chunks, unpacking them and converting samples is done here, because the unpackers of
 * the core depend on the channels in ways that 3.1 gets wrong for mixed types. Reading
 * through our own pread lets all threads share one context.
 *
 * A damaged header must not make us allocate more than the file can hold: every part is
 * held against the best ratio that its compression can reach.
 */
#include "exr_private.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Far beyond what renderers write, and small enough for searches by name. */
enum { MAX_CHANNELS = 8192, MAX_PARTS = 2048 };

static const struct {
    const char *name;
    bool is_lossy;
    /* No file of this kind is smaller than its pixels by more than this. */
    uint32_t max_ratio;
} compressions[] = {
    [EXR_COMPRESSION_NONE] = {"none", false, 1},
    [EXR_COMPRESSION_RLE] = {"rle", false, 128},
    [EXR_COMPRESSION_ZIPS] = {"zips", false, 1200},
    [EXR_COMPRESSION_ZIP] = {"zip", false, 1200},
    [EXR_COMPRESSION_PIZ] = {"piz", false, 1200},
    [EXR_COMPRESSION_PXR24] = {"pxr24", true, 1600},
    [EXR_COMPRESSION_B44] = {"b44", true, 32},
    [EXR_COMPRESSION_B44A] = {"b44a", true, 32},
    [EXR_COMPRESSION_DWAA] = {"dwaa", true, 1 << 18},
    [EXR_COMPRESSION_DWAB] = {"dwab", true, 1 << 18},
};

/* Scan lines per chunk. */
static const uint64_t lines_of[EXR_COMPRESSION_LAST_TYPE] = {
    [EXR_COMPRESSION_NONE] = 1,  [EXR_COMPRESSION_RLE] = 1,
    [EXR_COMPRESSION_ZIPS] = 1,  [EXR_COMPRESSION_ZIP] = 16,
    [EXR_COMPRESSION_PIZ] = 32,  [EXR_COMPRESSION_PXR24] = 16,
    [EXR_COMPRESSION_B44] = 32,  [EXR_COMPRESSION_B44A] = 32,
    [EXR_COMPRESSION_DWAA] = 32, [EXR_COMPRESSION_DWAB] = 256,
};

/* Length of the UTF-8 sequence at `text`; 0 for what is none or controls terminals. */
static size_t printable_length(const char *text)
{
    const unsigned char *c = (const unsigned char *)text;
    if (*c < 0x80)
        return *c >= 0x20 && *c != 0x7f;
    size_t n = *c >= 0xf0 ? 4 : *c >= 0xe0 ? 3 : 2;
    if (*c < 0xc2 || *c > 0xf4)
        return 0;
    for (size_t i = 1; i < n; i++)
        if ((c[i] & 0xc0) != 0x80)
            return 0;
    return n;
}

/* Names in a damaged file may be anything; messages are text. */
static void make_printable(char *text)
{
    while (*text) {
        size_t n = printable_length(text);
        if (n == 0)
            *text = '?';
        text += n ? n : 1;
    }
}

bool exr_fail(struct exr_error *error, const char *path, const char *format, ...)
{
    if (!error)
        return false;
    int n = snprintf(error->message, sizeof error->message, "%s: ", path);
    if (n < 0 || (size_t)n >= sizeof error->message)
        return false;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message + n, sizeof error->message - (size_t)n, format, arguments);
    va_end(arguments);
    make_printable(error->message + n);
    return false;
}

static _Thread_local char core_message[400];
static _Thread_local bool core_lacked_memory;

void exr_core_clear(void)
{
    core_message[0] = '\0';
    core_lacked_memory = false;
}

bool exr_core_lacked_memory(void)
{
    return core_lacked_memory;
}

void exr_core_on_error(exr_const_context_t context, exr_result_t code,
                       const char *message)
{
    core_lacked_memory |= code == EXR_ERR_OUT_OF_MEMORY;
    if (core_message[0] == '\0' && message)
        snprintf(core_message, sizeof core_message, "%s", message);
}

const char *exr_core_message(exr_result_t fallback)
{
    if (core_message[0])
        return core_message;
    /* read_at reports other failures; a short read is none in a header. */
    if (fallback == EXR_ERR_READ_IO)
        return "the file ends too early";
    return exr_get_default_error_message(fallback);
}

const char *exr_compression_name(int compression)
{
    if (compression < 0 || compression >= EXR_COMPRESSION_LAST_TYPE)
        return NULL;
    return compressions[compression].name;
}

int exr_compression_number(const char *name)
{
    for (int i = 0; i < EXR_COMPRESSION_LAST_TYPE; i++)
        if (strcmp(name, compressions[i].name) == 0)
            return i;
    return -1;
}

bool exr_is_lossy(int compression)
{
    return compressions[compression].is_lossy;
}

uint32_t exr_max_ratio(int compression)
{
    return compressions[compression].max_ratio;
}

int exr_sample_bytes(enum exr_sample_type type)
{
    return type == EXR_SAMPLE_HALF ? 2 : 4;
}

static int64_t read_at(exr_const_context_t context, void *user, void *buffer,
                       uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t report)
{
    const struct exr_input *input = user;
    uint64_t done = 0;
    while (done < size) {
        ssize_t n = pread(input->fd, (char *)buffer + done, size - done,
                          (off_t)(offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            report(context, EXR_ERR_READ_IO, "%s", strerror(errno));
        if (n <= 0)
            break;
        done += (uint64_t)n;
    }
    return (int64_t)done;
}

static int64_t query_size(exr_const_context_t context, void *user)
{
    return ((const struct exr_input *)user)->size_bytes;
}

static bool open_file(struct exr_input *input, struct exr_error *error)
{
    struct stat status;
    unsigned char magic[4] = {0};

    input->fd = open(input->path, O_RDONLY | O_CLOEXEC);
    if (input->fd < 0 || fstat(input->fd, &status) != 0)
        return exr_fail(error, input->path, "%s", strerror(errno));
    if (S_ISDIR(status.st_mode))
        return exr_fail(error, input->path, "is a folder, not an OpenEXR file");
    if (!S_ISREG(status.st_mode))
        return exr_fail(error, input->path,
                        "is not a regular file; OpenEXR files cannot be piped");
    input->size_bytes = status.st_size;
    if (status.st_size == 0)
        return exr_fail(error, input->path, "is empty");
    ssize_t n = pread(input->fd, magic, sizeof magic, 0);
    if (n < 0)
        return exr_fail(error, input->path, "%s", strerror(errno));
    if (memcmp(magic, "\x76\x2f\x31\x01", 4) != 0)
        return exr_fail(error, input->path, "is not an OpenEXR file");
    return true;
}

static bool open_context(struct exr_input *input, struct exr_error *error)
{
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = exr_core_on_error;
    settings.user_data = input;
    settings.read_fn = read_at;
    settings.size_fn = query_size;
    settings.max_image_width = settings.max_image_height = EXR_MAX_SIDE;
    settings.max_tile_width = settings.max_tile_height = EXR_MAX_SIDE;
    /* A table of chunks that does not fit means damage; guessing hides it. */
    settings.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;

    exr_core_clear();
    exr_result_t result = exr_start_read(&input->context, input->path, &settings);
    if (exr_core_lacked_memory())
        return exr_fail(error, input->path, "out of memory for the header");
    if (result != EXR_ERR_SUCCESS)
        return exr_fail(error, input->path, "damaged header: %s",
                        exr_core_message(result));
    return true;
}

static const char *part_text(const struct exr_input *input, int part, const char *name)
{
    const exr_attribute_t *attribute;
    if (exr_get_attribute_by_name(input->context, part, name, &attribute) !=
            EXR_ERR_SUCCESS ||
        attribute->type != EXR_ATTR_STRING || !attribute->string->str)
        return "";
    return attribute->string->str;
}

static struct exr_box to_box(exr_attr_box2i_t box)
{
    return (struct exr_box){box.min.x, box.min.y, box.max.x, box.max.y};
}

/* Refuses sizes that the file cannot hold. */
static bool check_part_size(const struct exr_input *input, int part,
                            const exr_attr_chlist_t *list, int compression,
                            struct exr_error *error)
{
    const struct exr_box *box = &input->parts[part].data_window;
    int64_t width = (int64_t)box->max_x - box->min_x + 1;
    int64_t height = (int64_t)box->max_y - box->min_y + 1;
    if (width < 1 || height < 1 || width > EXR_MAX_SIDE || height > EXR_MAX_SIDE)
        return exr_fail(error, input->path, "damaged header: size %lld x %lld px",
                        (long long)width, (long long)height);

    uint64_t n_bytes = 0;
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        n_bytes += (uint64_t)(width / entry->x_sampling) *
                   (uint64_t)(height / entry->y_sampling) *
                   (entry->pixel_type == EXR_PIXEL_HALF ? 2 : 4);
    }
    /* Each chunk has an entry in the table, a head, and some bytes of its own. */
    if (!input->parts[part].is_tiled &&
        (uint64_t)height / lines_of[compression] * 17 > (uint64_t)input->size_bytes)
        return exr_fail(error, input->path,
                        "damaged or cut off: %lld lines do not fit into %lld bytes",
                        (long long)height, (long long)input->size_bytes);
    if (!input->parts[part].is_deep && n_bytes / compressions[compression].max_ratio >
                                           (uint64_t)input->size_bytes + 4096)
        return exr_fail(error, input->path,
                        "damaged or cut off: %lld x %lld px do not fit into %lld bytes",
                        (long long)width, (long long)height,
                        (long long)input->size_bytes);
    return true;
}

static bool read_part_info(struct exr_input *input, int part,
                           const exr_attr_chlist_t **list, struct exr_error *error)
{
    struct exr_part_info *info = &input->parts[part];
    exr_attr_box2i_t data_window, display_window;
    exr_storage_t storage;
    exr_compression_t compression;

    exr_core_clear();
    exr_result_t result =
        exr_get_data_window(input->context, part, &data_window) |
        exr_get_display_window(input->context, part, &display_window) |
        exr_get_storage(input->context, part, &storage) |
        exr_get_compression(input->context, part, &compression) |
        exr_get_pixel_aspect_ratio(input->context, part, &info->pixel_aspect) |
        exr_get_channels(input->context, part, list);
    if (result != EXR_ERR_SUCCESS)
        return exr_fail(error, input->path, "damaged header: %s",
                        exr_core_message(EXR_ERR_MISSING_REQ_ATTR));
    info->name = part_text(input, part, "name");
    info->view = part_text(input, part, "view");
    info->is_tiled = storage == EXR_STORAGE_TILED || storage == EXR_STORAGE_DEEP_TILED;
    info->is_deep =
        storage == EXR_STORAGE_DEEP_SCANLINE || storage == EXR_STORAGE_DEEP_TILED;
    info->data_window = to_box(data_window);
    info->display_window = to_box(display_window);
    info->compression = exr_compression_name((int)compression);
    if (!info->compression)
        return exr_fail(error, input->path,
                        "compression number %d is not known to this version",
                        (int)compression);
    return check_part_size(input, part, *list, (int)compression, error);
}

static enum exr_sample_type to_sample_type(exr_pixel_type_t type)
{
    switch (type) {
    case EXR_PIXEL_HALF:
        return EXR_SAMPLE_HALF;
    case EXR_PIXEL_FLOAT:
        return EXR_SAMPLE_FLOAT;
    default:
        return EXR_SAMPLE_UINT;
    }
}

static bool append_channels(struct exr_input *input, int part,
                            const exr_attr_chlist_t *list, struct exr_error *error)
{
    size_t n = (size_t)input->n_channels + (size_t)list->num_channels;
    if (n > MAX_CHANNELS)
        return exr_fail(error, input->path, "damaged header: more than %d channels",
                        MAX_CHANNELS);
    struct exr_channel_info *channels =
        realloc(input->channels, n * sizeof *input->channels);
    if (!channels)
        return exr_fail(error, input->path, "out of memory");
    input->channels = channels;
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        channels[input->n_channels++] = (struct exr_channel_info){
            .name = entry->name.str,
            .type = to_sample_type(entry->pixel_type),
            .x_sampling = entry->x_sampling,
            .y_sampling = entry->y_sampling,
            .part = part,
        };
    }
    input->first_channel[part + 1] = input->n_channels;
    return true;
}

static bool read_headers(struct exr_input *input, struct exr_error *error)
{
    if (exr_get_count(input->context, &input->n_parts) != EXR_ERR_SUCCESS ||
        input->n_parts < 1 || input->n_parts > MAX_PARTS)
        return exr_fail(error, input->path, "damaged header: %d parts", input->n_parts);
    input->parts = calloc((size_t)input->n_parts, sizeof *input->parts);
    input->first_channel =
        calloc((size_t)input->n_parts + 1, sizeof *input->first_channel);
    if (!input->parts || !input->first_channel)
        return exr_fail(error, input->path, "out of memory");
    for (int part = 0; part < input->n_parts; part++) {
        const exr_attr_chlist_t *list;
        if (!read_part_info(input, part, &list, error) ||
            !append_channels(input, part, list, error))
            return false;
    }
    return true;
}

bool exr_open(struct exr_input **input, const char *path, struct exr_error *error)
{
    *input = NULL;
    struct exr_input *in = calloc(1, sizeof *in);
    if (!in)
        return exr_fail(error, path, "out of memory");
    in->fd = -1;
    in->path = strdup(path);
    if (!in->path)
        exr_fail(error, path, "out of memory");
    if (!in->path || !open_file(in, error) || !open_context(in, error) ||
        !read_headers(in, error)) {
        exr_close(in);
        return false;
    }
    *input = in;
    return true;
}

void exr_close(struct exr_input *input)
{
    if (!input)
        return;
    if (input->context)
        exr_finish(&input->context);
    if (input->fd >= 0)
        close(input->fd);
    free(input->path);
    free(input->parts);
    free(input->channels);
    free(input->first_channel);
    free(input);
}

const char *exr_path(const struct exr_input *input)
{
    return input->path;
}

const struct exr_part_info *exr_parts(const struct exr_input *input, int *n)
{
    if (n)
        *n = input->n_parts;
    return input->parts;
}

const struct exr_channel_info *exr_channels(const struct exr_input *input, int *n)
{
    if (n)
        *n = input->n_channels;
    return input->channels;
}

static const exr_attribute_t *attribute_of(const struct exr_input *input, int part,
                                           const char *name)
{
    const exr_attribute_t *attribute;
    exr_result_t result =
        exr_get_attribute_by_name(input->context, part, name, &attribute);
    return result == EXR_ERR_SUCCESS ? attribute : NULL;
}

static bool number_of(const exr_attribute_t *a, double *v)
{
    if (!a)
        return false;
    if (a->type == EXR_ATTR_FLOAT)
        *v = (double)a->f;
    else if (a->type == EXR_ATTR_DOUBLE)
        *v = a->d;
    else if (a->type == EXR_ATTR_INT)
        *v = a->i;
    else
        return false;
    return true;
}

static bool v2f_of(const exr_attribute_t *a, double v[2])
{
    if (!a)
        return false;
    if (a->type == EXR_ATTR_V2F) {
        v[0] = (double)a->v2f->x;
        v[1] = (double)a->v2f->y;
    } else if (a->type == EXR_ATTR_V2D) {
        v[0] = a->v2d->x;
        v[1] = a->v2d->y;
    } else if (a->type == EXR_ATTR_V2I) {
        v[0] = a->v2i->x;
        v[1] = a->v2i->y;
    } else {
        return false;
    }
    return true;
}

bool exr_attribute_number(const struct exr_input *input, const char *name, double *v)
{
    for (int part = 0; part < input->n_parts; part++)
        if (number_of(attribute_of(input, part, name), v))
            return true;
    return false;
}

bool exr_view_number(const struct exr_input *input, const char *view, const char *name,
                     double *v)
{
    char own_name[256];
    for (int part = 0; part < input->n_parts; part++)
        if (strcmp(input->parts[part].view, view) == 0 &&
            number_of(attribute_of(input, part, name), v))
            return true;
    snprintf(own_name, sizeof own_name, "%s.%s", name, view);
    return exr_attribute_number(input, own_name, v);
}

bool exr_view_v2f(const struct exr_input *input, const char *view, const char *name,
                  double v[2])
{
    char own_name[256];
    for (int part = 0; part < input->n_parts; part++)
        if (strcmp(input->parts[part].view, view) == 0 &&
            v2f_of(attribute_of(input, part, name), v))
            return true;
    snprintf(own_name, sizeof own_name, "%s.%s", name, view);
    return exr_attribute_v2f(input, own_name, v);
}

bool exr_attribute_string(const struct exr_input *input, const char *name,
                          const char **text)
{
    for (int part = 0; part < input->n_parts; part++) {
        const exr_attribute_t *a = attribute_of(input, part, name);
        if (!a || a->type != EXR_ATTR_STRING || !a->string->str)
            continue;
        *text = a->string->str;
        return true;
    }
    return false;
}

bool exr_attribute_v2f(const struct exr_input *input, const char *name, double v[2])
{
    for (int part = 0; part < input->n_parts; part++)
        if (v2f_of(attribute_of(input, part, name), v))
            return true;
    return false;
}

/* Decoding */

struct decoder {
    struct exr_input *input;
    int part;
    exr_run_fn run;
    void *user;
    struct exr_chunks chunks;
    exr_result_t (*undo)(exr_decode_pipeline_t *); /* of the core, or ours */
};

bool exr_plan_chunks(const struct exr_input *input, int part, struct exr_chunks *c,
                     struct exr_error *error)
{
    const struct exr_part_info *info = &input->parts[part];
    exr_const_context_t context = input->context;
    int32_t width = info->data_window.max_x - info->data_window.min_x + 1;
    int32_t height = info->data_window.max_y - info->data_window.min_y + 1;
    exr_result_t result;

    exr_core_clear();
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
    return exr_fail(error, input->path, "damaged header: %s", exr_core_message(result));
}

exr_result_t exr_find_chunk(const struct exr_input *input, int part,
                            const struct exr_chunks *c, int index,
                            exr_chunk_info_t *chunk)
{
    const struct exr_part_info *info = &input->parts[part];
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
    const struct exr_box *box = &d->input->parts[d->part].data_window;
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
static bool choose_undo(struct decoder *d, struct exr_error *error)
{
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    exr_const_context_t context = d->input->context;

    exr_core_clear();
    exr_result_t result = exr_find_chunk(d->input, d->part, &d->chunks, 0, &chunk);
    if (result == EXR_ERR_SUCCESS)
        result = exr_decoding_initialize(context, d->part, &chunk, &pipeline);
    if (result == EXR_ERR_SUCCESS)
        result = exr_decoding_choose_default_routines(context, d->part, &pipeline);
    d->undo = pipeline.decompress_fn;
    exr_decoding_destroy(context, &pipeline);
    if (chunk.compression == EXR_COMPRESSION_DWAA ||
        chunk.compression == EXR_COMPRESSION_DWAB)
        d->undo = exr_undo_dwa;
    return result == EXR_ERR_SUCCESS ||
           exr_fail(error, d->input->path, "damaged: %s", exr_core_message(result));
}

static exr_result_t decode_chunk(struct decoder *d, int index,
                                 exr_decode_pipeline_t *pipeline, bool *is_started)
{
    exr_chunk_info_t chunk;
    exr_result_t result = exr_find_chunk(d->input, d->part, &d->chunks, index, &chunk);
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

bool exr_decode_part(struct exr_input *input, int part, exr_run_fn run, void *user,
                     int n_threads, struct exr_error *error)
{
    const struct exr_box *box = &input->parts[part].data_window;
    const struct exr_rows all = {0, box->max_y - box->min_y + 1};
    return exr_decode_rows(input, part, all, run, user, n_threads, error);
}

/* The first chunk of these rows, and the one after the last. */
static void find_range(const struct exr_chunks *c, struct exr_rows rows, int range[2])
{
    int32_t step = c->n_tiles_x > 0 ? c->tile_height : c->lines_per_chunk;
    int per_row = c->n_tiles_x > 0 ? c->n_tiles_x : 1;
    range[0] = rows.first / step * per_row;
    range[1] = (rows.first + rows.n - 1) / step * per_row + per_row;
}

bool exr_decode_rows(struct exr_input *input, int part, struct exr_rows rows,
                     exr_run_fn run, void *user, int n_threads, struct exr_error *error)
{
    struct decoder d = {.input = input, .part = part, .run = run, .user = user};
    if (input->parts[part].is_deep)
        return exr_fail(
            error, input->path,
            "part %d (\"%s\") holds deep samples, and here a flat picture is needed; "
            "rackfocus filter --flattened makes one",
            part, input->parts[part].name);
    if (!exr_plan_chunks(input, part, &d.chunks, error) || !choose_undo(&d, error))
        return false;

    int range[2];
    find_range(&d.chunks, rows, range);
    _Atomic bool is_failed = false;
    char message[sizeof core_message] = "";
    if (n_threads < 1)
        n_threads = 1;
#pragma omp parallel num_threads(n_threads)
    {
        exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
        bool is_started = false;
#pragma omp for schedule(dynamic)
        for (int i = range[0]; i < range[1]; i++) {
            if (is_failed)
                continue;
            exr_core_clear();
            exr_result_t result = decode_chunk(&d, i, &pipeline, &is_started);
            if (result == EXR_ERR_SUCCESS)
                continue;
#pragma omp critical(exr_decode_message)
            {
                if (!is_failed)
                    snprintf(message, sizeof message, "%s", exr_core_message(result));
                is_failed = true;
            }
        }
        exr_decoding_destroy(input->context, &pipeline);
    }
    return !is_failed || exr_fail(error, input->path, "damaged: %s", message);
}

/* exr_read */

struct interleaver {
    const struct exr_input *input;
    int part;
    const int *wanted; /* indices into input->channels */
    int n;
    float *samples; /* of the first of the rows */
    size_t width;
    struct exr_rows rows;
};

void exr_convert_run(float *out, size_t stride, enum exr_sample_type type, int32_t n,
                     const uint8_t *samples)
{
    if (type == EXR_SAMPLE_HALF) {
        exr_halves_to_floats(out, stride, samples, (size_t)n);
        return;
    }
    for (int32_t i = 0; i < n; i++, out += stride) {
        uint32_t whole;
        if (type == EXR_SAMPLE_FLOAT) {
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
    const struct exr_channel_info *info = &to->input->channels[channel];
    const struct exr_box *box = &to->input->parts[to->part].data_window;
    int32_t width = (int32_t)to->width, height = box->max_y - box->min_y + 1;
    int32_t step_x = info->x_sampling, step_y = info->y_sampling;
    int32_t y0 = y * step_y, y1 = height - y0 < step_y ? height : y0 + step_y;
    int32_t end = to->rows.first + to->rows.n;
    y0 = y0 < to->rows.first ? to->rows.first : y0;
    y1 = y1 > end ? end : y1;
    /* Without the samples of its rest the last block of a cut window has none. */
    for (int32_t i = 0; i < n; i++) {
        float v;
        exr_convert_run(&v, 1, info->type, 1,
                        samples + (size_t)i * (size_t)exr_sample_bytes(info->type));
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
    const struct exr_channel_info *info = &to->input->channels[channel];
    for (int c = 0; c < to->n; c++) {
        if (to->wanted[c] != channel)
            continue;
        int32_t row = y - to->rows.first;
        size_t pixel = (size_t)row * to->width + (size_t)x;
        if (info->x_sampling != 1 || info->y_sampling != 1)
            spread_run(to, channel, c, x, y, n, samples);
        else if (row >= 0 && row < to->rows.n)
            exr_convert_run(to->samples + pixel * (size_t)to->n + c, (size_t)to->n,
                            info->type, n, samples);
    }
}

static bool check_wanted(const struct exr_input *input, const int *channels, int n,
                         struct exr_error *error)
{
    const struct exr_box *box = NULL;
    for (int c = 0; c < n; c++) {
        if (channels[c] == -1)
            continue;
        if (channels[c] < -1 || channels[c] >= input->n_channels)
            return exr_fail(error, input->path, "there is no channel number %d",
                            channels[c]);
        const struct exr_channel_info *info = &input->channels[channels[c]];
        const struct exr_box *other = &input->parts[info->part].data_window;
        if (box && memcmp(box, other, sizeof *box) != 0)
            return exr_fail(error, input->path,
                            "channel %s has another data window than the first",
                            info->name);
        box = other;
    }
    if (!box)
        return exr_fail(error, input->path, "no channel is asked for");
    return true;
}

static bool is_wanted_part(const struct exr_input *input, int part, const int *channels,
                           int n)
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
static struct exr_rows with_blocks(const struct exr_input *input, int part,
                                   struct exr_rows rows)
{
    int32_t step = 1;
    for (int c = input->first_channel[part]; c < input->first_channel[part + 1]; c++)
        if (input->channels[c].y_sampling > step)
            step = input->channels[c].y_sampling;
    int32_t more = rows.first < step - 1 ? rows.first : step - 1;
    return (struct exr_rows){rows.first - more, rows.n + more};
}

/* Of the data window that all wanted channels have; one of them is not -1. */
static int32_t wanted_height(const struct exr_input *input, const int *channels)
{
    while (*channels < 0)
        channels++;
    const struct exr_box *box =
        &input->parts[input->channels[*channels].part].data_window;
    return box->max_y - box->min_y + 1;
}

static bool check_rows(const struct exr_input *input, const int *channels,
                       struct exr_rows rows, struct exr_error *error)
{
    int32_t height = wanted_height(input, channels);
    if (rows.first >= 0 && rows.n > 0 && rows.n <= height &&
        rows.first <= height - rows.n)
        return true;
    return exr_fail(
        error, input->path, "rows %d to %lld are asked for, but there are only 0 to %d",
        (int)rows.first, (long long)rows.first + rows.n - 1, (int)height - 1);
}

bool exr_read_rows(struct exr_input *input, const int *channels, int n,
                   struct exr_rows rows, float *samples, int n_threads,
                   struct exr_error *error)
{
    if (!check_wanted(input, channels, n, error) ||
        !check_rows(input, channels, rows, error))
        return false;
    for (int part = 0; part < input->n_parts; part++) {
        if (!is_wanted_part(input, part, channels, n))
            continue;
        const struct exr_box *box = &input->parts[part].data_window;
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
        if (!exr_decode_rows(input, part, with_blocks(input, part, rows),
                             interleave_run, &to, n_threads, error))
            return false;
    }
    return true;
}

bool exr_read(struct exr_input *input, const int *channels, int n, float *samples,
              int n_threads, struct exr_error *error)
{
    if (!check_wanted(input, channels, n, error))
        return false;
    const struct exr_rows all = {0, wanted_height(input, channels)};
    return exr_read_rows(input, channels, n, all, samples, n_threads, error);
}

int32_t exr_row_step(const struct exr_input *input, int part)
{
    struct exr_chunks chunks = {0};
    if (!exr_plan_chunks(input, part, &chunks, NULL))
        return 1;
    return chunks.n_tiles_x > 0 ? chunks.tile_height : chunks.lines_per_chunk;
}
