/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens OpenEXR files: headers, parts, channels.
 *
 * A damaged header must not make us allocate more than the file can hold: every part is
 * held against the best ratio that its compression can reach. Reading through our own
 * pread lets all threads share one context.
 */
#include "exr_private.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"

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

/* OpenEXR 3.4 knows more; open_context() refuses them. */
enum { N_COMPRESSIONS = sizeof compressions / sizeof *compressions };

/* Scan lines per chunk. */
static const uint64_t lines_of[N_COMPRESSIONS] = {
    [EXR_COMPRESSION_NONE] = 1,  [EXR_COMPRESSION_RLE] = 1,
    [EXR_COMPRESSION_ZIPS] = 1,  [EXR_COMPRESSION_ZIP] = 16,
    [EXR_COMPRESSION_PIZ] = 32,  [EXR_COMPRESSION_PXR24] = 16,
    [EXR_COMPRESSION_B44] = 32,  [EXR_COMPRESSION_B44A] = 32,
    [EXR_COMPRESSION_DWAA] = 32, [EXR_COMPRESSION_DWAB] = 256,
};

const char *image_compression_name(int compression)
{
    if (compression < 0 || compression >= N_COMPRESSIONS)
        return NULL;
    return compressions[compression].name;
}

int image_compression_number(const char *name)
{
    for (int i = 0; i < N_COMPRESSIONS; i++)
        if (strcmp(name, compressions[i].name) == 0)
            return i;
    return -1;
}

bool image_is_lossy(int compression)
{
    return compressions[compression].is_lossy;
}

uint32_t image_max_ratio(int compression)
{
    return compressions[compression].max_ratio;
}

static int64_t read_at(exr_const_context_t context, void *user, void *buffer,
                       uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t report)
{
    const struct image_input *input = user;
    const size_t n = os_file_read_at(input->fd, buffer, size, offset);
    if (n < size && errno != 0)
        report(context, EXR_ERR_READ_IO, "%s", strerror(errno));
    return (int64_t)n;
}

static int64_t query_size(exr_const_context_t context, void *user)
{
    return ((const struct image_input *)user)->size_bytes;
}

/* What people have instead of an EXR file, by its first bytes. */
static bool fail_kind(const struct image_input *input, const unsigned char magic[4],
                      struct image_error *error)
{
    static const struct {
        const char *bytes, *name;
        bool is_plain; /* numbers that no other program of pictures reads */
    } others[] = {{"\x89PNG", "a PNG file", false},
                  {"\xff\xd8\xff", "a JPEG file", false},
                  {"II*", "a TIFF file", false},
                  {"MM", "a TIFF file", false},
                  {"#?RA", "a Radiance HDR file", false},
                  {"8BPS", "a Photoshop file", false},
                  {"RIFF", "a WebP file", false},
                  {"PF\n", "a PFM file", false},
                  {"Pf\n", "a PFM file", false},
                  {"P5", "a PGM file", false},
                  {"\x93NUM", "a NumPy array", true},
                  {"PIEH", "a depth file of Middlebury's or Sintel's kind", true}};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        if (memcmp(magic, others[i].bytes, strlen(others[i].bytes)) != 0)
            continue;
        if (others[i].is_plain)
            return image_fail(error, input->path,
                              "is %s; colour and depth are read from OpenEXR files; "
                              "four lines of Python make one of it: docs/files.md, "
                              "'Depth in other files'",
                              others[i].name);
        return image_fail(
            error, input->path,
            "is %s; colour and depth are read from OpenEXR files, as renderers write "
            "them; of a depth map make one: oiiotool FILE -d float -o depth.exr, of a "
            "picture: oiiotool FILE --colorconvert sRGB linear -d half -o colour.exr",
            others[i].name);
    }
    return image_fail(error, input->path, "is not an OpenEXR file");
}

static bool open_file(struct image_input *input, struct image_error *error)
{
    struct os_file_facts facts;
    unsigned char magic[4] = {0};

    int number = os_file_open(input->path, &input->fd, &facts);
    if (number != 0)
        return image_fail(error, input->path, "%s", strerror(number));
    if (facts.kind == OS_FILE_FOLDER)
        return image_fail(error, input->path, "is a folder, not an OpenEXR file");
    if (facts.kind != OS_FILE_REGULAR)
        return image_fail(error, input->path,
                          "is not a regular file but a pipe or device; save it as a "
                          "file, or send it as the standard input and name it -, which "
                          "filter, info and compare take");
    input->size_bytes = facts.n_bytes;
    if (facts.n_bytes == 0)
        return image_fail(error, input->path, "is empty");
    if (os_file_read_at(input->fd, magic, sizeof magic, 0) == 0 && errno != 0)
        return image_fail(error, input->path, "%s", strerror(errno));
    if (memcmp(magic, "\x76\x2f\x31\x01", 4) != 0)
        return fail_kind(input, magic, error);
    return true;
}

static bool fail_at_compression(const struct image_input *input, int number,
                                struct image_error *error)
{
    return image_fail(
        error, input->path,
        "its compression, number %d, is newer than this program; write the "
        "file with zip, piz or another of up to number %d (dwab)",
        number, EXR_COMPRESSION_DWAB);
}

static bool open_context(struct image_input *input, struct image_error *error)
{
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = image_core_on_error;
    settings.user_data = input;
    settings.read_fn = read_at;
    settings.size_fn = query_size;
    settings.max_image_width = settings.max_image_height = IMAGE_MAX_SIDE;
    settings.max_tile_width = settings.max_tile_height = IMAGE_MAX_SIDE;
    /* A table of chunks that does not fit means damage; guessing hides it. */
    settings.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;

    image_core_clear();
    exr_result_t result = exr_start_read(&input->context, input->path, &settings);
    if (image_core_lacked_memory())
        return image_lacks_memory(error, input->path);
    if (result != EXR_ERR_SUCCESS)
        return image_fail(error, input->path, "damaged header: %s",
                          image_core_message(result));
    int unknown = image_core_unknown_compression();
    return unknown < 0 || fail_at_compression(input, unknown, error);
}

static const char *part_text(const struct image_input *input, int part,
                             const char *name)
{
    const exr_attribute_t *attribute;
    if (exr_get_attribute_by_name(input->context, part, name, &attribute) !=
            EXR_ERR_SUCCESS ||
        attribute->type != EXR_ATTR_STRING || !attribute->string->str)
        return "";
    return attribute->string->str;
}

static struct image_box to_box(exr_attr_box2i_t box)
{
    return (struct image_box){box.min.x, box.min.y, box.max.x, box.max.y};
}

/* Refuses sizes that the file cannot hold. */
static bool check_part_size(const struct image_input *input, int part,
                            const exr_attr_chlist_t *list, int compression,
                            struct image_error *error)
{
    const struct image_box *box = &input->parts[part].data_window;
    int64_t width = (int64_t)box->max_x - box->min_x + 1;
    int64_t height = (int64_t)box->max_y - box->min_y + 1;
    if (width < 1 || height < 1 || width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE)
        return image_fail(error, input->path, "damaged header: size %lld x %lld px",
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
        return image_fail(error, input->path,
                          "damaged or cut off: %lld lines do not fit into %lld bytes",
                          (long long)height, (long long)input->size_bytes);
    if (!input->parts[part].is_deep && n_bytes / compressions[compression].max_ratio >
                                           (uint64_t)input->size_bytes + 4096)
        return image_fail(
            error, input->path,
            "damaged or cut off: %lld x %lld px do not fit into %lld bytes",
            (long long)width, (long long)height, (long long)input->size_bytes);
    return true;
}

/* What kind of an environment map the part says that it is; NULL: none. */
static const char *environment_of(const struct image_input *input, int part)
{
    exr_envmap_t kind;
    if (exr_attr_get_envmap(input->context, part, "envmap", &kind) != EXR_ERR_SUCCESS)
        return NULL;
    return kind == EXR_ENVMAP_CUBE ? "cube" : "latlong";
}

static bool read_part_info(struct image_input *input, int part,
                           const exr_attr_chlist_t **list, struct image_error *error)
{
    struct image_part_info *info = &input->parts[part];
    exr_attr_box2i_t data_window, display_window;
    exr_storage_t storage;
    exr_compression_t compression;

    image_core_clear();
    exr_result_t result =
        exr_get_data_window(input->context, part, &data_window) |
        exr_get_display_window(input->context, part, &display_window) |
        exr_get_storage(input->context, part, &storage) |
        exr_get_compression(input->context, part, &compression) |
        exr_get_pixel_aspect_ratio(input->context, part, &info->pixel_aspect) |
        exr_get_channels(input->context, part, list);
    if (result != EXR_ERR_SUCCESS)
        return image_fail(error, input->path, "damaged header: %s",
                          image_core_message(EXR_ERR_MISSING_REQ_ATTR));
    info->name = part_text(input, part, "name");
    info->view = part_text(input, part, "view");
    info->environment = environment_of(input, part);
    info->is_tiled = storage == EXR_STORAGE_TILED || storage == EXR_STORAGE_DEEP_TILED;
    info->is_deep =
        storage == EXR_STORAGE_DEEP_SCANLINE || storage == EXR_STORAGE_DEEP_TILED;
    info->data_window = to_box(data_window);
    info->display_window = to_box(display_window);
    info->compression = image_compression_name((int)compression);
    if (!info->compression)
        return fail_at_compression(input, (int)compression, error);
    return check_part_size(input, part, *list, (int)compression, error);
}

static enum image_sample_type to_sample_type(exr_pixel_type_t type)
{
    switch (type) {
    case EXR_PIXEL_HALF:
        return IMAGE_SAMPLE_HALF;
    case EXR_PIXEL_FLOAT:
        return IMAGE_SAMPLE_FLOAT;
    default:
        return IMAGE_SAMPLE_UINT;
    }
}

static bool append_channels(struct image_input *input, int part,
                            const exr_attr_chlist_t *list, struct image_error *error)
{
    size_t n = (size_t)input->n_channels + (size_t)list->num_channels;
    if (n > MAX_CHANNELS)
        return image_fail(error, input->path, "damaged header: more than %d channels",
                          MAX_CHANNELS);
    struct image_channel_info *channels =
        realloc(input->channels, n * sizeof *input->channels);
    if (!channels)
        return image_lacks_memory(error, input->path);
    input->channels = channels;
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        channels[input->n_channels++] = (struct image_channel_info){
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

static bool read_headers(struct image_input *input, struct image_error *error)
{
    if (exr_get_count(input->context, &input->n_parts) != EXR_ERR_SUCCESS ||
        input->n_parts < 1 || input->n_parts > MAX_PARTS)
        return image_fail(error, input->path, "damaged header: %d parts",
                          input->n_parts);
    input->parts = calloc((size_t)input->n_parts, sizeof *input->parts);
    input->first_channel =
        calloc((size_t)input->n_parts + 1, sizeof *input->first_channel);
    if (!input->parts || !input->first_channel)
        return image_lacks_memory(error, input->path);
    for (int part = 0; part < input->n_parts; part++) {
        const exr_attr_chlist_t *list;
        if (!read_part_info(input, part, &list, error) ||
            !append_channels(input, part, list, error))
            return false;
    }
    return true;
}

bool image_open(struct image_input **input, const char *path, struct image_error *error)
{
    *input = NULL;
    struct image_input *in = calloc(1, sizeof *in);
    if (!in)
        return image_lacks_memory(error, path);
    in->fd = -1;
    in->path = strdup(path);
    if (!in->path)
        image_lacks_memory(error, path);
    if (!in->path || !open_file(in, error) || !image_scan_header(in, error) ||
        !open_context(in, error) || !read_headers(in, error)) {
        image_close(in);
        return false;
    }
    *input = in;
    return true;
}

void image_close(struct image_input *input)
{
    if (!input)
        return;
    if (input->context)
        exr_finish(&input->context);
    if (input->fd >= 0)
        os_file_close(input->fd);
    free(input->path);
    free(input->parts);
    free(input->channels);
    free(input->first_channel);
    free(input);
}

const char *image_path(const struct image_input *input)
{
    return input->path;
}

const struct image_part_info *image_parts(const struct image_input *input, int *n)
{
    if (n)
        *n = input->n_parts;
    return input->parts;
}

const struct image_channel_info *image_channels(const struct image_input *input, int *n)
{
    if (n)
        *n = input->n_channels;
    return input->channels;
}
