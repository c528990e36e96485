/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The EXR reader: any bytes as a file. Whatever opens is searched for layers, read, and
 * written again with everything else passed through.
 */
#include <sys/mman.h>
#include <unistd.h>

#include "bytes.h"
#include "exr.h"

enum { MAX_PIXELS = 1 << 20 };

static bool is_small(const struct exr_input *input, int channel)
{
    int n;
    const struct exr_channel_info *channels = exr_channels(input, &n);
    PROMISE(channel >= 0 && channel < n);
    const struct exr_part_info *parts = exr_parts(input, &n);
    const struct exr_box *box = &parts[channels[channel].part].data_window;
    return ((int64_t)box->max_x - box->min_x + 1) *
               ((int64_t)box->max_y - box->min_y + 1) <=
           MAX_PIXELS;
}

static float *read_layer(struct exr_input *input, const struct exr_layer *layer)
{
    const int wanted[5] = {layer->r, layer->g, layer->b, layer->a, layer->z};
    int n;
    struct exr_error error = {""};
    const struct exr_part_info *parts = exr_parts(input, &n);
    const struct exr_box *box =
        &parts[exr_channels(input, &n)[layer->r].part].data_window;
    size_t size = (size_t)(box->max_x - box->min_x + 1) *
                  (size_t)(box->max_y - box->min_y + 1) * 5;
    float *samples = calloc(size, sizeof *samples);
    if (!exr_read(input, wanted, 5, samples, 1, &error)) {
        PROMISE(error.message[0]);
        free(samples);
        return NULL;
    }
    return samples;
}

static void write_again(struct exr_input *input, const struct exr_layer *layer,
                        const float *samples, const char *path)
{
    static const char *const names[] = {"R", "G", "B", "A", "Z"};
    static const enum exr_sample_type types[5] = {0};
    int n, part = exr_channels(input, &n)[layer->r].part;
    struct exr_error error = {""};
    const struct exr_part_info *info = &exr_parts(input, &n)[part];
    const struct exr_box *box = &info->data_window;
    const struct exr_output output = {
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
    if (!exr_write(path, &output, 1, &error))
        PROMISE(error.message[0]);
}

/* Samples of a deep part: offsets that rise, and as many samples as they say. */
static bool read_deep(struct exr_input *input, const struct exr_layer *layer)
{
    int n;
    struct exr_deep deep;
    struct exr_error error = {""};
    if (layer->z < 0 ||
        !exr_parts(input, &n)[exr_channels(input, &n)[layer->z].part].is_deep)
        return false;
    const int wanted[] = {layer->r, layer->a, layer->z,
                          exr_find_z_back(input, layer->z)};
    if (!exr_read_deep(input, wanted, 4, &deep, 1, &error)) {
        PROMISE(error.message[0]);
        return true;
    }
    size_t n_pixels = (size_t)deep.width * (size_t)deep.height;
    volatile float sum = 0;
    for (size_t i = 0; i < n_pixels; i++)
        PROMISE(deep.first[i] <= deep.first[i + 1]);
    for (size_t i = 0; i < deep.first[n_pixels] * 4; i++)
        sum = sum + deep.samples[i];
    exr_deep_free(&deep);
    return true;
}

static void visit(struct exr_input *input)
{
    int n;
    double v[2];
    const char *text;
    struct exr_layer layer;
    struct exr_error error = {""};
    const struct exr_channel_info *channels = exr_channels(input, &n);
    for (int i = 0; i < n; i++)
        PROMISE(channels[i].name && channels[i].x_sampling > 0 &&
                channels[i].y_sampling > 0);
    exr_attribute_number(input, "rackfocus:focusDistance", v);
    exr_attribute_string(input, "rackfocus:filtered", &text);
    exr_attribute_v2f(input, "rackfocus:lensOffset", v);
    exr_find_layer(input, "ViewLayer.Combined", NULL, false, &layer, &error);
    exr_find_layer(input, NULL, "Z", true, &layer, &error);
    if (!exr_find_layer(input, NULL, NULL, false, &layer, &error)) {
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
    struct exr_input *input;
    struct exr_error error = {""};
    PROMISE(fd >= 0 && write(fd, data, size) == (ssize_t)size);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    if (exr_open(&input, path, &error)) {
        visit(input);
        exr_close(input);
    } else {
        PROMISE(error.message[0]);
    }
    close(fd);
    return 0;
}
