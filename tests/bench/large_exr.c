/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a picture of any size in strips, as a render of a lens that its header
 * describes: a textured floor that recedes through the focus, thin posts before it, a
 * wall behind, lamps on it. Half floats for the colour, float for the depth.
 *
 *     large_exr FILE WIDTH HEIGHT TILE COMPRESSION RADIUS
 *
 * TILE is the side of the tiles, 0 for scan lines; RADIUS the largest of the blur, px.
 */
#include <stdio.h>
#include <stdlib.h>

#include "../exr/rgbz.h"

enum { FOCUS = 100, N_CHANNELS = 4 };

struct scene {
    int32_t width, height;
    double radius;
};

static uint32_t hash(uint32_t x, uint32_t y)
{
    uint32_t v = x * 2654435761u ^ y * 2246822519u;
    v = (v ^ v >> 15) * 2654435769u;
    return v ^ v >> 13;
}

/* R, G, B and Z of a pixel; the lens blurs depth z by 400 - 40000 / z px. */
static void fill_pixel(const struct scene *s, int32_t x, int32_t y, float *out)
{
    const double down = (double)y / s->height;
    const double light = (hash((uint32_t)x, (uint32_t)y) & 255) / 255.0;
    double r = s->radius * (0.9 - 1.6 * down);
    double value = ((x / 8 + y / 8) % 2 ? 0.6 : 0.15) + 0.15 * light;
    if (down < 0.25) {
        r = s->radius;
        value = 0.2 + 0.1 * light;
        if (hash((uint32_t)x / 3, (uint32_t)y / 3) % 20011 == 0)
            value = 300;
    }
    const bool is_post = x % 211 < 4 && down > 0.1;
    if (is_post) {
        r = -0.7 * s->radius;
        value = 0.05 + 0.1 * light;
    }
    out[0] = (float)value;
    out[1] = (float)(value * (is_post ? 0.5 : 0.9));
    out[2] = (float)(value * (0.4 + 0.5 * down));
    out[3] = (float)(40000 / (400 - r));
}

static int fail(const struct image_error *error)
{
    fprintf(stderr, "large_exr: %s\n", error->message);
    return 1;
}

static int write_scene(const char *path, const struct scene *s, int32_t tile,
                       const char *compression)
{
    static const struct image_attribute lens[] = {
        {.name = "rackfocus:lensRadius", .number = {40}},
        {.name = "rackfocus:focalLengthPx", .number = {1000}},
        {.name = "rackfocus:focusDistance", .number = {FOCUS}}};
    const struct image_box box = {0, 0, s->width - 1, s->height - 1};
    struct image_output output = rgbz_output(box, compression, tile);
    output.attributes = lens;
    output.n_attributes = 3;
    struct image_writer *writer;
    struct image_error error;
    if (!image_write_begin(&writer, path, &output, 2, &error))
        return fail(&error);
    const int32_t step = image_write_step(writer);
    float *rows = malloc((size_t)step * (size_t)s->width * N_CHANNELS * sizeof(*rows));
    bool is_good = rows != NULL;
    for (int32_t y = 0; is_good && y < s->height; y += step) {
        const int32_t n = s->height - y < step ? s->height - y : step;
        for (int32_t j = 0; j < n; j++)
            for (int32_t x = 0; x < s->width; x++)
                fill_pixel(s, x, y + j,
                           rows +
                               ((size_t)j * (size_t)s->width + (size_t)x) * N_CHANNELS);
        is_good = image_write_rows(writer, n, rows, &error);
    }
    free(rows);
    if (is_good)
        return image_write_finish(writer, &error) ? 0 : fail(&error);
    image_write_abort(writer);
    return fail(&error);
}

int main(int argc, char **argv)
{
    if (argc != 7) {
        fprintf(stderr, "Usage: large_exr FILE WIDTH HEIGHT TILE COMPRESSION RADIUS\n");
        return 2;
    }
    const struct scene s = {atoi(argv[2]), atoi(argv[3]), atof(argv[6])};
    return write_scene(argv[1], &s, atoi(argv[4]), argv[5]);
}
