/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The EXR reader: any bytes as a file. Whatever opens is searched for layers, read, and
 * written again with everything else passed through.
 */
#include <sys/mman.h>
#include <unistd.h>

#include "bytes.h"
#include "image.h"

enum { MAX_PIXELS = 1 << 20 };

static bool is_small(const struct image_input *input, int channel)
{
    int n;
    const struct image_channel_info *channels = image_channels(input, &n);
    PROMISE(channel >= 0 && channel < n);
    const struct image_part_info *parts = image_parts(input, &n);
    const struct image_box *box = &parts[channels[channel].part].data_window;
    return ((int64_t)box->max_x - box->min_x + 1) *
               ((int64_t)box->max_y - box->min_y + 1) <=
           MAX_PIXELS;
}

static float *read_layer(struct image_input *input, const struct image_layer *layer)
{
    const int wanted[5] = {layer->r, layer->g, layer->b, layer->a, layer->z};
    int n;
    struct image_error error = {.message = ""};
    const struct image_part_info *parts = image_parts(input, &n);
    const struct image_box *box =
        &parts[image_channels(input, &n)[layer->r].part].data_window;
    size_t size = (size_t)(box->max_x - box->min_x + 1) *
                  (size_t)(box->max_y - box->min_y + 1) * 5;
    float *samples = calloc(size, sizeof *samples);
    if (!image_read(input, wanted, 5, samples, 1, &error)) {
        PROMISE(error.message[0]);
        free(samples);
        return NULL;
    }
    return samples;
}

static void write_again(struct image_input *input, const struct image_layer *layer,
                        const float *samples, const char *path)
{
    static const char *const names[] = {"R", "G", "B", "A", "Z"};
    static const enum image_sample_type types[5] = {0};
    int n, part = image_channels(input, &n)[layer->r].part;
    struct image_error error = {.message = ""};
    const struct image_part_info *info = &image_parts(input, &n)[part];
    const struct image_box *box = &info->data_window;
    const struct image_output output = {
        .width = box->max_x - box->min_x + 1,
        .height = box->max_y - box->min_y + 1,
        .data_window = *box,
        .display_window = info->display_window,
        .pixel_aspect = info->pixel_aspect,
        .n_channels = 5,
        .channel_names = names,
        .types = types,
        .samples = samples,
        .compression = "none",
        .like = input,
        .like_part = part,
        .pass_through = true,
    };
    if (!image_write(path, &output, 1, &error))
        PROMISE(error.message[0]);
}

/* Samples of a deep part: offsets that rise, and as many samples as they say. */
static bool read_deep(struct image_input *input, const struct image_layer *layer)
{
    int n;
    struct image_deep deep;
    struct image_error error = {.message = ""};
    if (layer->z < 0 ||
        !image_parts(input, &n)[image_channels(input, &n)[layer->z].part].is_deep)
        return false;
    const int wanted[] = {layer->r, layer->a, layer->z,
                          image_find_z_back(input, layer->z)};
    if (!image_read_deep(input, wanted, 4, &deep, 1, &error)) {
        PROMISE(error.message[0]);
        return true;
    }
    size_t n_pixels = (size_t)deep.width * (size_t)deep.height;
    volatile float sum = 0;
    for (size_t i = 0; i < n_pixels; i++)
        PROMISE(deep.first[i] <= deep.first[i + 1]);
    for (size_t i = 0; i < deep.first[n_pixels] * 4; i++)
        sum = sum + deep.samples[i];
    image_deep_free(&deep);
    return true;
}

static void visit(struct image_input *input)
{
    int n;
    double v[2];
    const char *text;
    struct image_layer layer;
    struct image_error error = {.message = ""};
    const struct image_channel_info *channels = image_channels(input, &n);
    for (int i = 0; i < n; i++)
        PROMISE(channels[i].name && channels[i].x_sampling > 0 &&
                channels[i].y_sampling > 0);
    image_attribute_number(input, "rackfocus:focusDistance", v);
    image_attribute_string(input, "rackfocus:filtered", &text);
    image_attribute_v2f(input, "rackfocus:lensOffset", v);
    image_find_layer(input, "ViewLayer.Combined", NULL, false, &layer, &error);
    image_find_layer(input, NULL, "Z", true, &layer, &error);
    if (!image_find_layer(input, NULL, NULL, false, &layer, &error)) {
        PROMISE(error.message[0]);
        return;
    }
    if (!is_small(input, layer.r) || !is_small(input, layer.g) ||
        !is_small(input, layer.b))
        return;
    if (read_deep(input, &layer))
        return;
    float *samples = read_layer(input, &layer);
    char path[64];
    snprintf(path, sizeof path, "/dev/shm/rf_fuzz_%d.exr", (int)getpid());
    if (samples)
        write_again(input, &layer, samples, path);
    unlink(path);
    free(samples);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    int fd = memfd_create("fuzz", MFD_CLOEXEC);
    char path[64];
    struct image_input *input;
    struct image_error error = {.message = ""};
    PROMISE(fd >= 0 && write(fd, data, size) == (ssize_t)size);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    if (image_open(&input, path, &error)) {
        visit(input);
        image_close(input);
    } else {
        PROMISE(error.message[0]);
    }
    close(fd);
    return 0;
}
