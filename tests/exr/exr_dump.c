/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What test_exr_files.py talks to: shows a file as lines of text, dumps samples as raw
 * floats, copies through image_write. Exits with 1 and the message on stderr.
 *
 *     exr_dump info FILE
 *     exr_dump layer FILE [LAYER|-] [DEPTH_CHANNEL|-] [depth_only]
 *     exr_dump view FILE VIEW
 *     exr_dump views FILE                     their names
 *     exr_dump number FILE VIEW NAME          an attribute of a view
 *     exr_dump join OUT FILE ...              views named after the files
 *     exr_dump read FILE PART OUT [THREADS]   all full-size channels, interleaved
 *     exr_dump copy FILE OUT [pass] [half|float] [compression=X] [layer=X] [scale=F]
 *         [threads=N] [attribute]       the colours of a layer, times F, to a new file
 */
#include "image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct image_error error;

static int fail(void)
{
    fprintf(stderr, "%s\n", error.message);
    return 1;
}

static void print_box(const struct image_box *box)
{
    printf(" %d %d %d %d", (int)box->min_x, (int)box->min_y, (int)box->max_x,
           (int)box->max_y);
}

static int info(const char *path)
{
    static const char *const types[] = {"half", "float", "uint"};
    struct image_input *input;
    if (!image_open(&input, path, &error))
        return fail();
    int n_parts, n;
    const struct image_part_info *parts = image_parts(input, &n_parts);
    const struct image_channel_info *channels = image_channels(input, &n);
    for (int i = 0; i < n_parts; i++) {
        printf("part '%s' '%s' %s %s", parts[i].name, parts[i].view,
               parts[i].compression, parts[i].is_tiled ? "tiled" : "lines");
        print_box(&parts[i].data_window);
        print_box(&parts[i].display_window);
        printf(" %g\n", (double)parts[i].pixel_aspect);
    }
    for (int i = 0; i < n; i++)
        printf("channel %d %s %s %d %d\n", (int)channels[i].part, channels[i].name,
               types[channels[i].type], (int)channels[i].x_sampling,
               (int)channels[i].y_sampling);
    image_close(input);
    return 0;
}

static const char *channel_name(const struct image_input *input, int index)
{
    return index < 0 ? "-" : image_channels(input, NULL)[index].name;
}

static void print_layer(const struct image_input *input,
                        const struct image_layer *found)
{
    printf("'%s' %s %s %s %s %s\n", found->name, channel_name(input, found->r),
           channel_name(input, found->g), channel_name(input, found->b),
           channel_name(input, found->a), channel_name(input, found->z));
}

static int layer(int n, char **arguments)
{
    struct image_input *input;
    struct image_layer found;
    const char *name = n > 1 && strcmp(arguments[1], "-") ? arguments[1] : NULL;
    const char *depth = n > 2 && strcmp(arguments[2], "-") ? arguments[2] : NULL;
    if (!image_open(&input, arguments[0], &error))
        return fail();
    bool is_good = image_find_layer(input, name, depth, n > 3, &found, &error);
    if (is_good)
        print_layer(input, &found);
    image_close(input);
    return is_good ? 0 : fail();
}

static int view(const char *path, const char *name)
{
    struct image_input *input;
    struct image_layer found;
    if (!image_open(&input, path, &error))
        return fail();
    bool is_good =
        image_find_view_layer(input, name, NULL, NULL, false, &found, &error);
    if (is_good)
        print_layer(input, &found);
    image_close(input);
    return is_good ? 0 : fail();
}

static int views(const char *path)
{
    struct image_input *input;
    if (!image_open(&input, path, &error))
        return fail();
    for (int i = 0; i < image_view_count(input); i++)
        printf("%s\n", image_view_name(input, i));
    image_close(input);
    return 0;
}

static int number(const char *path, const char *name, const char *attribute)
{
    struct image_input *input;
    double v;
    if (!image_open(&input, path, &error))
        return fail();
    bool is_found = image_view_number(input, name, attribute, &v);
    if (is_found)
        printf("%g\n", v);
    image_close(input);
    return is_found ? 0 : 1;
}

/* "folder/v00.exr" becomes "v00". */
static void base_name(const char *path, char name[64])
{
    const char *slash = strrchr(path, '/');
    snprintf(name, 64, "%s", slash ? slash + 1 : path);
    char *dot = strrchr(name, '.');
    if (dot)
        *dot = 0;
}

enum { MAX_JOINED = 8 };

static int join(const char *out, int n, char **paths)
{
    struct image_input *inputs[MAX_JOINED] = {NULL};
    char names[MAX_JOINED][64];
    const char *views[MAX_JOINED] = {NULL};
    bool is_good = n <= MAX_JOINED;
    int n_open = 0;
    while (is_good && n_open < n) {
        base_name(paths[n_open], names[n_open]);
        views[n_open] = names[n_open];
        is_good = image_open(&inputs[n_open], paths[n_open], &error);
        n_open += is_good;
    }
    is_good = is_good && image_join_views(out, inputs, views, n, &error);
    for (int i = 0; i < n_open; i++)
        image_close(inputs[i]);
    return is_good ? 0 : fail();
}

static bool write_raw(const char *path, const void *data, size_t n_bytes)
{
    FILE *file = fopen(path, "wb");
    bool is_good = file && fwrite(data, 1, n_bytes, file) == n_bytes;
    return file && fclose(file) == 0 && is_good;
}

static int read_part(int n_arguments, char **arguments)
{
    struct image_input *input;
    if (!image_open(&input, arguments[0], &error))
        return fail();
    int part = atoi(arguments[1]), n, n_wanted = 0;
    const struct image_box box = image_parts(input, NULL)[part].data_window;
    const struct image_channel_info *channels = image_channels(input, &n);
    int *wanted = malloc((size_t)n * sizeof *wanted);
    for (int i = 0; i < n; i++)
        if (channels[i].part == part)
            wanted[n_wanted++] = i;
    size_t n_samples = (size_t)(box.max_x - box.min_x + 1) *
                       (size_t)(box.max_y - box.min_y + 1) * (size_t)n_wanted;
    float *samples = malloc(n_samples * sizeof *samples);
    int n_threads = n_arguments > 3 ? atoi(arguments[3]) : 2;
    bool is_good =
        samples && image_read(input, wanted, n_wanted, samples, n_threads, &error);
    if (is_good && !write_raw(arguments[2], samples, n_samples * sizeof *samples)) {
        snprintf(error.message, sizeof error.message, "%s: cannot write", arguments[2]);
        is_good = false;
    }
    free(samples);
    free(wanted);
    image_close(input);
    return is_good ? 0 : fail();
}

struct copy_options {
    const char *layer, *compression;
    float scale;
    int n_threads;
    bool pass_through, has_attribute;
    enum image_sample_type type;
};

static struct copy_options parse_options(int n, char **words)
{
    struct copy_options o = {.scale = 1, .n_threads = 2, .type = IMAGE_SAMPLE_HALF};
    for (int i = 0; i < n; i++) {
        if (strcmp(words[i], "pass") == 0)
            o.pass_through = true;
        else if (strcmp(words[i], "float") == 0)
            o.type = IMAGE_SAMPLE_FLOAT;
        else if (strcmp(words[i], "attribute") == 0)
            o.has_attribute = true;
        else if (strncmp(words[i], "compression=", 12) == 0)
            o.compression = words[i] + 12;
        else if (strncmp(words[i], "layer=", 6) == 0)
            o.layer = words[i] + 6;
        else if (strncmp(words[i], "scale=", 6) == 0)
            o.scale = (float)atof(words[i] + 6);
        else if (strncmp(words[i], "threads=", 8) == 0)
            o.n_threads = atoi(words[i] + 8);
    }
    return o;
}

static bool write_copy(struct image_input *input, const struct image_layer *layer,
                       const char *path, const struct copy_options *o)
{
    const struct image_channel_info *channels = image_channels(input, NULL);
    int part = channels[layer->r].part;
    const struct image_box box = image_parts(input, NULL)[part].data_window;
    int32_t width = box.max_x - box.min_x + 1, height = box.max_y - box.min_y + 1;
    int wanted[] = {layer->r, layer->g, layer->b, layer->a};
    int n = layer->r == layer->g ? 1 : layer->a >= 0 ? 4 : 3;
    const char *names[4];
    enum image_sample_type types[4] = {o->type, o->type, o->type, o->type};
    for (int i = 0; i < n; i++)
        names[i] = channels[wanted[i]].name;
    size_t n_samples = (size_t)width * (size_t)height * (size_t)n;
    float *samples = malloc(n_samples * sizeof *samples);
    bool is_good =
        samples && image_read(input, wanted, n, samples, o->n_threads, &error);
    for (size_t i = 0; is_good && i < n_samples; i++)
        samples[i] *= o->scale;
    const struct image_attribute attributes[] = {
        {.name = "rackfocus:lensRadius",
         .type = IMAGE_ATTRIBUTE_FLOAT,
         .number = {0.5}},
        {.name = "rackfocus:blades", .type = IMAGE_ATTRIBUTE_INT, .number = {6}},
        {.name = "rackfocus:depth", .type = IMAGE_ATTRIBUTE_STRING, .text = "planar"},
        {.name = "rackfocus:lensOffset",
         .type = IMAGE_ATTRIBUTE_V2F,
         .number = {1, -2}},
        {.name = "owner", .type = IMAGE_ATTRIBUTE_STRING, .text = "replaced"},
    };
    const struct image_output output = {.width = width,
                                        .height = height,
                                        .n_channels = n,
                                        .channel_names = names,
                                        .types = types,
                                        .samples = samples,
                                        .compression = o->compression,
                                        .attributes = attributes,
                                        .n_attributes = o->has_attribute ? 5 : 0,
                                        .like = input,
                                        .like_part = part,
                                        .pass_through = o->pass_through};
    is_good = is_good && image_write(path, &output, o->n_threads, &error);
    free(samples);
    return is_good;
}

static int copy(int n, char **arguments)
{
    struct copy_options options = parse_options(n - 2, arguments + 2);
    struct image_input *input;
    struct image_layer found;
    if (!image_open(&input, arguments[0], &error))
        return fail();
    bool is_good =
        image_find_layer(input, options.layer, NULL, false, &found, &error) &&
        write_copy(input, &found, arguments[1], &options);
    image_close(input);
    return is_good ? 0 : fail();
}

int main(int argc, char **argv)
{
    if (argc == 3 && strcmp(argv[1], "info") == 0)
        return info(argv[2]);
    if (argc >= 3 && strcmp(argv[1], "layer") == 0)
        return layer(argc - 2, argv + 2);
    if (argc == 4 && strcmp(argv[1], "view") == 0)
        return view(argv[2], argv[3]);
    if (argc == 3 && strcmp(argv[1], "views") == 0)
        return views(argv[2]);
    if (argc == 5 && strcmp(argv[1], "number") == 0)
        return number(argv[2], argv[3], argv[4]);
    if (argc >= 4 && strcmp(argv[1], "join") == 0)
        return join(argv[2], argc - 3, argv + 3);
    if (argc >= 5 && strcmp(argv[1], "read") == 0)
        return read_part(argc - 2, argv + 2);
    if (argc >= 4 && strcmp(argv[1], "copy") == 0)
        return copy(argc - 2, argv + 2);
    fprintf(stderr,
            "usage: exr_dump info|layer|view|views|number|join|read|copy ...\n");
    return 2;
}
