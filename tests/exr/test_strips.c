/* SPDX-License-Identifier: Apache-2.0 */
/* Files written and read in strips, in little memory. */
#include "exr_testing.h"

#include <stdint.h>
#include <sys/resource.h>

#include "exr_private.h"
#include "rgbz.h"

enum { STRIP_W = 150, STRIP_H = 131 };

static struct image_output strip_output(int32_t tile_size, const char *compression)
{
    const struct image_box box = {-7, 5, STRIP_W - 8, STRIP_H + 4};
    return rgbz_output(box, compression, tile_size);
}

/* Writes samples in strips of n_steps steps. */
static bool write_strips(const char *path, const struct image_output *output,
                         const float *samples, int n_steps, struct image_error *error)
{
    struct image_writer *writer;
    if (!image_write_begin(&writer, path, output, 2, error))
        return false;
    int32_t strip = n_steps * image_write_step(writer);
    for (int32_t y = 0; y < output->height; y += strip) {
        int32_t n = strip < output->height - y ? strip : output->height - y;
        const float *at =
            samples + (size_t)y * (size_t)(output->width * output->n_channels);
        if (!image_write_rows(writer, n, at, error)) {
            image_write_abort(writer);
            return false;
        }
    }
    return image_write_finish(writer, error);
}

/* Any rows of the file are those of the whole. */
static bool rows_agree(const char *path, const float *whole)
{
    static float rows[STRIP_W * STRIP_H * 4];
    static const int heights[] = {1, 16, 33, 64, STRIP_H};
    struct image_error error;
    struct image_input *input;
    struct image_layer layer;
    bool is_good = image_open(&input, path, &error) &&
                   image_find_layer(input, NULL, NULL, false, &layer, &error);
    const int channels[] = {layer.r, layer.g, layer.b, layer.z};
    for (size_t k = 0; is_good && k < sizeof heights / sizeof *heights; k++)
        for (int32_t y = 0; is_good && y < STRIP_H; y += 13) {
            int32_t n = heights[k] < STRIP_H - y ? heights[k] : STRIP_H - y;
            is_good = image_read_rows(input, channels, 4, (struct image_rows){y, n},
                                      rows, 2, &error) &&
                      memcmp(rows, whole + (size_t)y * STRIP_W * 4,
                             sizeof *rows * (size_t)(n * STRIP_W * 4)) == 0;
        }
    image_close(input);
    return is_good;
}

static void strips_are_the_whole(void)
{
    static float samples[STRIP_W * STRIP_H * 4];
    static const struct {
        int32_t tile_size;
        const char *compression;
    } cases[] = {{0, "zip"}, {0, "zips"}, {0, "piz"},   {0, "none"},
                 {0, "rle"}, {64, "zip"}, {256, "piz"}, {32, "none"}};
    struct image_error error = {.message = ""};
    fill(samples, STRIP_W * STRIP_H * 4);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct image_output output =
            strip_output(cases[i].tile_size, cases[i].compression);
        const char *path = in_folder("strips.exr"), *whole = in_folder("whole.exr");
        bool is_good = write_strips(path, &output, samples, 1 + (int)i % 3, &error);
        output.samples = samples;
        is_good = is_good && image_write(whole, &output, 2, &error) &&
                  rows_agree(path, samples) && rows_agree(whole, samples);
        CHECK(is_good);
        if (!is_good)
            printf("#     tiles of %d, %s: %s\n", (int)cases[i].tile_size,
                   cases[i].compression, error.message);
        char command[450];
        snprintf(command, sizeof command, "cmp -s %s %s", path, whole);
        CHECK(system(command) == 0);
    }
    int n;
    struct image_input *input;
    REQUIRE(image_open(&input, in_folder("strips.exr"), &error));
    CHECK(image_parts(input, &n)->is_tiled && image_row_step(input, 0) == 32);
    CHECK(image_parts(input, &n)->data_window.min_x == -7);
    image_close(input);
}

/* Kept channels pass through strips as they pass through whole pictures. */
static void strips_keep_other_channels(void)
{
    static float samples[STRIP_W * STRIP_H * 4];
    struct image_error error = {.message = ""};
    struct image_input *input;
    struct image_output output = strip_output(0, "zip");
    fill(samples, STRIP_W * STRIP_H * 4);
    output.samples = samples;
    REQUIRE(image_write(in_folder("like.exr"), &output, 2, &error));
    REQUIRE(image_open(&input, in_folder("like.exr"), &error));
    output.like = input;
    output.pass_through = true;
    output.n_channels = 2; /* B and Z stay */
    REQUIRE(image_write(in_folder("whole.exr"), &output, 2, &error));
    CHECK(write_strips(in_folder("kept.exr"), &output, samples, 2, &error));
    image_close(input);
    char command[450];
    snprintf(command, sizeof command, "cmp -s %s %s", in_folder("whole.exr"),
             in_folder("kept.exr"));
    CHECK(system(command) == 0);
}

static void strips_say_what_is_wrong(void)
{
    static float samples[STRIP_W * STRIP_H * 4];
    struct image_error error = {.message = ""};
    struct image_writer *writer;
    struct image_input *input;
    struct image_output output = strip_output(0, "zip");
    const char *path = in_folder("wrong.exr");
    int before = count_files(folder);
    REQUIRE(image_write_begin(&writer, path, &output, 2, &error));
    CHECK(!image_write_rows(writer, 17, samples, &error));
    CHECK_CONTAINS(error.message, "wrong.exr: a strip of 17 rows");
    CHECK(!image_write_rows(writer, STRIP_H + 1, samples, &error));
    REQUIRE(image_write_rows(writer, 16, samples, &error));
    CHECK(!image_write_finish(writer, &error));
    CHECK_CONTAINS(error.message, "the last 115 rows are missing");
    CHECK(count_files(folder) == before); /* nothing stays */
    REQUIRE(image_write_begin(&writer, path, &output, 2, &error));
    image_write_abort(writer);
    CHECK(count_files(folder) == before);
    output.tile_size = -1;
    CHECK(!image_write_begin(&writer, path, &output, 2, &error) && !writer);
    CHECK_CONTAINS(error.message, "tiles of -1 px");

    output = strip_output(0, "zip");
    REQUIRE(write_strips(path, &output, samples, 1, &error));
    REQUIRE(image_open(&input, path, &error));
    const int z = 3;
    const struct image_rows wrong[] = {
        {-1, 2}, {STRIP_H - 1, 2}, {0, 0}, {2147483647, 1}};
    for (int i = 0; i < 4; i++) {
        CHECK(!image_read_rows(input, &z, 1, wrong[i], samples, 2, &error));
        CHECK_CONTAINS(error.message, "there are only 0 to 130");
    }
    image_close(input);
}

/*
 * 4096 x 2048, 134 MB decoded, written and read in strips: the peak of the process's
 * memory grows by less than 30 MB, about a strip, its chunks and their compression.
 */
static long peak_kb(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

static void large_pictures_need_little_memory(void)
{
    enum { LARGE_W = 4096, LARGE_H = 2048, STRIP = 64 };
    struct image_error error = {.message = ""};
    struct image_writer *writer;
    struct image_input *input;
    long before = peak_kb();
    float *samples = calloc((size_t)LARGE_W * STRIP * 4, sizeof *samples);
    REQUIRE(samples);
    struct image_output output = strip_output(64, "rle");
    output.width = LARGE_W;
    output.height = LARGE_H;
    output.data_window = output.display_window =
        (struct image_box){0, 0, LARGE_W - 1, LARGE_H - 1};
    REQUIRE(image_write_begin(&writer, in_folder("large.exr"), &output, 2, &error));
    for (int32_t y = 0; y < LARGE_H; y += STRIP) {
        samples[0] = (float)y;
        REQUIRE(image_write_rows(writer, STRIP, samples, &error));
    }
    REQUIRE(image_write_finish(writer, &error));
    REQUIRE(image_open(&input, in_folder("large.exr"), &error));
    const int channels[] = {2, 1, 0, 3}; /* sorted by name in the file */
    bool is_good = true;
    for (int32_t y = 0; is_good && y < LARGE_H; y += STRIP)
        is_good = image_read_rows(input, channels, 4, (struct image_rows){y, STRIP},
                                  samples, 2, &error) &&
                  samples[0] == (float)y;
    CHECK(is_good);
    image_close(input);
    free(samples);
    printf("#     %ld kB more\n", peak_kb() - before);
    CHECK(peak_kb() - before < 30000);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    if (!make_folder())
        return 1;
    TEST(strips_are_the_whole);
    TEST(strips_keep_other_channels);
    TEST(strips_say_what_is_wrong);
    TEST(large_pictures_need_little_memory);
    remove_folder();
    return testing_end();
}
