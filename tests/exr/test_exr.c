/* SPDX-License-Identifier: Apache-2.0 */
/* Unit tests of exr/: what needs no other program to make files. */
#include "../testing.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "exr_private.h"

static char folder[] = "/tmp/rf_test_exr_XXXXXX";

static const char *in_folder(const char *name)
{
    static char paths[4][200];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static int count_files(const char *path)
{
    DIR *stream = opendir(path);
    int n = 0;
    for (struct dirent *entry; stream && (entry = readdir(stream));)
        n += entry->d_name[0] != '.';
    if (stream)
        closedir(stream);
    return n;
}

static void fill(float *samples, size_t n)
{
    for (size_t i = 0; i < n; i++)
        samples[i] = (float)(i % 251) / 64.0f;
}

enum { WIDTH = 37, HEIGHT = 29 };

/* A picture with the given channels, all of one type. */
static bool write_channels(const char *path, const char *const *names, int n,
                           enum exr_sample_type type, struct exr_error *error)
{
    float *samples = malloc(sizeof *samples * WIDTH * HEIGHT * (size_t)n);
    enum exr_sample_type types[64];
    for (int i = 0; i < n; i++)
        types[i] = type;
    fill(samples, (size_t)(WIDTH * HEIGHT * n));
    const struct exr_output output = {
        .width = WIDTH,
        .height = HEIGHT,
        .data_window = {0, 0, WIDTH - 1, HEIGHT - 1},
        .display_window = {0, 0, WIDTH - 1, HEIGHT - 1},
        .n_channels = n,
        .channel_names = names,
        .types = types,
        .samples = samples,
    };
    bool is_good = exr_write(path, &output, 2, error);
    free(samples);
    return is_good;
}

static void half_of_every_value(void)
{
    for (uint32_t i = 0; i < 65536; i++) {
        float value = exr_half_to_float((uint16_t)i);
        if (isnan(value)) {
            CHECK(isnan(exr_half_to_float(exr_float_to_half(value))));
            continue;
        }
        if (exr_float_to_half(value) != i) {
            CHECK(exr_float_to_half(value) == i);
            return;
        }
    }
    CHECK_NEAR(exr_half_to_float(0x3c00), 1.0, 0);
    CHECK_NEAR(exr_half_to_float(0x0001), 0x1p-24, 0);
    CHECK_NEAR(exr_half_to_float(0x7bff), 65504.0, 0);
    CHECK(signbit(exr_half_to_float(0x8000)));
}

/* Midway between two neighbours the even one wins; beside it the nearer. */
static void half_rounds_to_nearest_even(void)
{
    for (uint32_t i = 0; i < 0x7bff; i++) {
        float low = exr_half_to_float((uint16_t)i);
        float high = exr_half_to_float((uint16_t)(i + 1));
        float middle = low + (high - low) / 2;
        uint32_t even = i % 2 ? i + 1 : i;
        bool is_good = exr_float_to_half(middle) == even &&
                       exr_float_to_half(nextafterf(middle, 0)) == i &&
                       exr_float_to_half(nextafterf(middle, 1e9f)) == i + 1 &&
                       exr_float_to_half(-middle) == (even | 0x8000);
        if (!is_good) {
            CHECK(is_good);
            printf("#     at %u\n", (unsigned)i);
            return;
        }
    }
    CHECK(true);
}

static void half_does_not_overflow(void)
{
    CHECK(exr_float_to_half(65519.996f) == 0x7bff);
    CHECK(exr_float_to_half(65520.0f) == 0x7bff);
    CHECK(exr_float_to_half(1e10f) == 0x7bff);
    CHECK(exr_float_to_half(-3e38f) == 0xfbff);
    CHECK(exr_float_to_half(INFINITY) == 0x7c00);
    CHECK(exr_float_to_half(-INFINITY) == 0xfc00);
    CHECK(exr_float_to_half(1e-10f) == 0);
}

/* Runs give the bits of single values, whatever instructions they take. */
static void runs_of_halves_have_the_same_bits(void)
{
    enum { N = 65536, MOST_STRIDE = 5 };
    static uint16_t halves[N + 3], back[N + 3];
    static float floats[MOST_STRIDE * (N + 3)];
    for (uint32_t i = 0; i < N + 3; i++)
        halves[i] = (uint16_t)(i * 40503u);
    for (size_t stride = 1; stride <= MOST_STRIDE; stride++) {
        size_t n_bad = 0, n = N + 3 - stride % 2;
        memset(floats, 0x55, sizeof floats);
        exr_halves_to_floats(floats, stride, (const uint8_t *)halves, n);
        for (size_t i = 0; i < n; i++) {
            float want = exr_half_to_float(halves[i]);
            n_bad += memcmp(&floats[i * stride], &want, 4) != 0;
        }
        exr_floats_to_halves((uint8_t *)back, floats, stride, n);
        for (size_t i = 0; i < n; i++)
            n_bad += back[i] != exr_float_to_half(floats[i * stride]);
        CHECK(n_bad == 0);
        if (stride > 1) /* what lies between is left alone */
            CHECK(memcmp(floats + 1, "UUUU", 4) == 0);
    }
    printf("# F16C: %s\n", exr_has_f16c() ? "yes" : "no");
}

/* All exponents, both signs, mantissas around every rounding border. */
static void rounding_of_runs_is_that_of_single_values(void)
{
    static const uint32_t mantissas[] = {
        0,      1,      0xfff,    0x1000,   0x1001,   0x1fff,   0x2000,
        0x3000, 0x2fff, 0x7fefff, 0x7ff000, 0x7ff001, 0x7fffff, 0x400000};
    enum { N_MANTISSAS = sizeof mantissas / sizeof *mantissas };
    static uint32_t bits[512 * N_MANTISSAS];
    static float floats[512 * N_MANTISSAS];
    static uint16_t got[512 * N_MANTISSAS];
    size_t n = 0, n_bad = 0;
    for (uint32_t top = 0; top < 512; top++)
        for (size_t m = 0; m < N_MANTISSAS; m++)
            bits[n++] = top << 23 | mantissas[m];
    memcpy(floats, bits, sizeof bits);
    exr_floats_to_halves((uint8_t *)got, floats, 1, n);
    for (size_t i = 0; i < n; i++)
        n_bad += got[i] != exr_float_to_half(floats[i]);
    CHECK(n_bad == 0);
}

static void writes_and_reads_back(void)
{
    static const char *const names[] = {"R", "G", "B", "A", "Z"};
    struct exr_error error = {""};
    struct exr_input *input;
    const char *path = in_folder("plain.exr");
    REQUIRE(write_channels(path, names, 5, EXR_SAMPLE_FLOAT, &error));
    REQUIRE(exr_open(&input, path, &error));
    int n_parts, n;
    const struct exr_part_info *parts = exr_parts(input, &n_parts);
    exr_channels(input, &n);
    CHECK(n_parts == 1 && n == 5);
    CHECK_STR(parts[0].compression, "zip");
    CHECK(parts[0].data_window.max_x == WIDTH - 1);
    CHECK_STR(exr_path(input), path);

    struct exr_layer layer;
    REQUIRE(exr_find_layer(input, NULL, NULL, false, &layer, &error));
    int wanted[] = {layer.r, layer.g, layer.b, layer.a, layer.z, -1};
    static float got[WIDTH * HEIGHT * 6], want[WIDTH * HEIGHT * 5];
    fill(want, WIDTH * HEIGHT * 5);
    REQUIRE(exr_read(input, wanted, 6, got, 3, &error));
    bool is_same = true;
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        is_same &= memcmp(got + 6 * i, want + 5 * i, 5 * sizeof *got) == 0;
        is_same &= got[6 * i + 5] == 1.0f;
    }
    CHECK(is_same);
    int wrong[] = {99};
    CHECK(!exr_read(input, wrong, 1, got, 1, &error));
    CHECK_CONTAINS(error.message, "no channel number 99");
    exr_close(input);
}

/* Layer finding, one line per kind of file: channels, the layer asked for, what comes
 * out as "layer r z". */
struct layer_case {
    const char *channels, *layer, *depth;
    bool depth_only;
    const char *want;
};

static const struct layer_case layer_cases[] = {
    {"R G B", NULL, NULL, false, " R -"},
    {"R G B A Z", NULL, NULL, false, " R Z"},
    {"Y", NULL, NULL, false, " Y -"},
    {"Y A", NULL, NULL, false, " Y -"},
    {"Y", NULL, NULL, true, " Y Y"},
    {"Depth", NULL, NULL, true, " - Depth"},
    {"R G B", NULL, NULL, true, " R R"},
    {"Z", NULL, NULL, true, " - Z"},
    {"R G B depth.Z", NULL, NULL, false, " R depth.Z"},
    {"R G B Depth.Z", NULL, NULL, false, " R Depth.Z"},
    {"R G B z", NULL, NULL, false, " R z"},
    {"R G B depth", NULL, NULL, false, " R depth"},
    {"R G B ZDepth.R ZDepth.G ZDepth.B", NULL, NULL, false, " R ZDepth.R"},
    {"R G B VRayZDepth.R VRayZDepth.G", NULL, NULL, false, " R VRayZDepth.R"},
    {"R G B Z.R", NULL, NULL, false, " R Z.R"},
    {"R G B depth.Y", NULL, NULL, false, " R depth.Y"},
    {"R G B Depth.V", NULL, NULL, false, " R Depth.V"},
    {"R G B N.X N.Y N.Z", NULL, NULL, false, " R -"},
    {"R G B P.X P.Y P.Z mydepth.T", NULL, "mydepth.T", false, " R mydepth.T"},
    {"ViewLayer.Combined.R ViewLayer.Combined.G ViewLayer.Combined.B "
     "ViewLayer.Combined.A ViewLayer.Depth.Z ViewLayer.Normal.X ViewLayer.Normal.Y "
     "ViewLayer.Normal.Z Composite.Combined.R Composite.Combined.G "
     "Composite.Combined.B Composite.Combined.A",
     NULL, NULL, false, "ViewLayer.Combined ViewLayer.Combined.R ViewLayer.Depth.Z"},
    {"ViewLayer.Combined.R ViewLayer.Combined.G ViewLayer.Combined.B ViewLayer.Depth.Z "
     "Composite.Combined.R Composite.Combined.G Composite.Combined.B",
     "Composite", NULL, false,
     "Composite.Combined Composite.Combined.R ViewLayer.Depth.Z"},
    {"View Layer.Combined.R View Layer.Combined.G View Layer.Combined.B "
     "View Layer.Depth.Z",
     "View Layer", NULL, false,
     "View Layer.Combined View Layer.Combined.R View Layer.Depth.Z"},
    {"a.Combined.R a.Combined.G a.Combined.B a.Depth.Z b.Combined.R b.Combined.G "
     "b.Combined.B b.Depth.Z",
     "b", NULL, false, "b.Combined b.Combined.R b.Depth.Z"},
    {"a.Combined.R a.Combined.G a.Combined.B b.Depth.Z c.Depth.Z", NULL, NULL, false,
     "a.Combined a.Combined.R -"},
    {"diffuse.R diffuse.G diffuse.B Z", NULL, NULL, false, "diffuse diffuse.R Z"},
    {"diffuse.R diffuse.G diffuse.B diffuse.Z Z", NULL, NULL, false,
     "diffuse diffuse.R diffuse.Z"},
    {"a.red a.green a.blue", NULL, NULL, false, "a a.red -"},
    {"R G B v.Z v.X", NULL, NULL, false, " R -"},
    {"ViewLayer.Normal.X ViewLayer.Normal.Y ViewLayer.Normal.Z", NULL, NULL, false,
     "FAIL no R G B"},
    {"R G B", "nothing", NULL, false, "FAIL (plain R G B)"},
    {"R G B", NULL, "Q", false, "FAIL no channel \"Q\"; channels of the file: B, G, R"},
    {"N.X N.Y N.Z", NULL, NULL, true, "FAIL no depth channel"},
};

static int split(const char *text, char *buffer, const char **words)
{
    int n = 0;
    strcpy(buffer, text);
    /* "View Layer" has a blank in its name: one that follows no channel's end. */
    for (char *word = buffer; *word;) {
        char *end = word;
        while (*end && !(*end == ' ' && strncmp(end, " Layer.", 7) != 0))
            end++;
        words[n++] = word;
        word = end;
        while (*word == ' ')
            *word++ = '\0';
    }
    return n;
}

static const char *name_of(const struct exr_input *input, int channel)
{
    return channel < 0 ? "-" : exr_channels(input, NULL)[channel].name;
}

static void find_one(const struct layer_case *c)
{
    char buffer[600], got[800];
    const char *names[64];
    struct exr_error error = {""};
    struct exr_input *input;
    struct exr_layer layer;
    int n = split(c->channels, buffer, names);
    REQUIRE(write_channels(in_folder("layers.exr"), names, n, EXR_SAMPLE_HALF, &error));
    REQUIRE(exr_open(&input, in_folder("layers.exr"), &error));
    if (exr_find_layer(input, c->layer, c->depth, c->depth_only, &layer, &error)) {
        snprintf(got, sizeof got, "%s %s %s", layer.name, name_of(input, layer.r),
                 name_of(input, layer.z));
        CHECK_STR(got, c->want);
        CHECK(layer.r < 0 || layer.g >= 0);
    } else if (strncmp(c->want, "FAIL ", 5) == 0) {
        CHECK_CONTAINS(error.message, c->want + 5);
    } else {
        CHECK_STR(error.message, c->want);
    }
    exr_close(input);
}

static void finds_layers(void)
{
    for (size_t i = 0; i < sizeof layer_cases / sizeof layer_cases[0]; i++)
        find_one(&layer_cases[i]);
}

static void keeps_old_file_on_failure(void)
{
    static const char *const names[] = {"R", "G", "B"};
    static const char *const twice[] = {"R", "R"};
    struct exr_error error = {""};
    struct stat before, after;
    const char *path = in_folder("old.exr");
    REQUIRE(write_channels(path, names, 3, EXR_SAMPLE_HALF, &error));
    REQUIRE(chmod(path, 0640) == 0);
    REQUIRE(stat(path, &before) == 0);
    int n = count_files(folder);
    CHECK(!write_channels(path, twice, 2, EXR_SAMPLE_HALF, &error));
    CHECK_CONTAINS(error.message, "given twice");
    REQUIRE(stat(path, &after) == 0);
    CHECK(before.st_ino == after.st_ino);
    CHECK(count_files(folder) == n);
    REQUIRE(write_channels(path, names, 3, EXR_SAMPLE_HALF, &error));
    REQUIRE(stat(path, &after) == 0);
    CHECK((after.st_mode & 0777) == 0640);
    CHECK(count_files(folder) == n);
}

static void follows_links(void)
{
    static const char *const names[] = {"Y"};
    struct exr_error error = {""};
    struct stat status;
    REQUIRE(write_channels(in_folder("target.exr"), names, 1, EXR_SAMPLE_HALF, &error));
    REQUIRE(symlink(in_folder("target.exr"), in_folder("link.exr")) == 0);
    CHECK(write_channels(in_folder("link.exr"), names, 1, EXR_SAMPLE_FLOAT, &error));
    REQUIRE(lstat(in_folder("link.exr"), &status) == 0);
    CHECK(S_ISLNK(status.st_mode));
}

static void says_why_it_cannot_write(void)
{
    static const char *const names[] = {"Y"};
    struct exr_error error = {""};
    CHECK(!write_channels(in_folder("none/x.exr"), names, 1, EXR_SAMPLE_HALF, &error));
    CHECK_CONTAINS(error.message, "No such file or directory");
    CHECK(!write_channels(folder, names, 1, EXR_SAMPLE_HALF, &error));
    CHECK_CONTAINS(error.message, "not a regular file");
    CHECK(!write_channels("/dev/null", names, 1, EXR_SAMPLE_HALF, &error));
    CHECK_CONTAINS(error.message, "not a regular file");
}

static void says_why_it_cannot_read(void)
{
    struct exr_error error = {""};
    struct exr_input *input;
    CHECK(!exr_open(&input, in_folder("missing.exr"), &error));
    CHECK(input == NULL);
    CHECK_CONTAINS(error.message, "missing.exr: No such file or directory");
    CHECK(!exr_open(&input, folder, &error));
    CHECK_CONTAINS(error.message, "is a folder");
    CHECK(!exr_open(&input, "/dev/null", &error));
    CHECK_CONTAINS(error.message, "not a regular file");
    FILE *file = fopen(in_folder("text.exr"), "w");
    REQUIRE(file != NULL);
    fclose(file);
    CHECK(!exr_open(&input, in_folder("text.exr"), &error));
    CHECK_CONTAINS(error.message, "is empty");
    file = fopen(in_folder("text.exr"), "w");
    REQUIRE(file != NULL);
    fputs("hello", file);
    fclose(file);
    CHECK(!exr_open(&input, in_folder("text.exr"), &error));
    CHECK_CONTAINS(error.message, "is not an OpenEXR file");
    file = fopen(in_folder("text.exr"), "w");
    REQUIRE(file != NULL);
    fwrite("\x76\x2f\x31\x01\x02\0\0\0", 1, 8, file);
    fclose(file);
    CHECK(!exr_open(&input, in_folder("text.exr"), &error));
    CHECK_CONTAINS(error.message, "damaged header");
}

static void says_when_the_disk_is_full(void)
{
    static const char *const names[] = {"Y"};
    char mount_point[200];
    struct exr_error error = {""};
    snprintf(mount_point, sizeof mount_point, "%s/full", folder);
    REQUIRE(mkdir(mount_point, 0700) == 0);
    if (mount("tmpfs", mount_point, "tmpfs", 0, "size=4k") != 0)
        SKIP("needs the right to mount");
    static float samples[200 * 200];
    uint32_t noise = 1;
    for (size_t i = 0; i < 200 * 200; i++) {
        noise = noise * 1664525u + 1013904223u;
        samples[i] = (float)(noise >> 8) * 0x1p-24f;
    }
    const struct exr_output output = {.width = 200,
                                      .height = 200,
                                      .data_window = {0, 0, 199, 199},
                                      .display_window = {0, 0, 199, 199},
                                      .n_channels = 1,
                                      .channel_names = names,
                                      .samples = samples};
    CHECK(!exr_write(in_folder("full/x.exr"), &output, 2, &error));
    CHECK_CONTAINS(error.message, "no space left on the disk");
    CHECK(count_files(mount_point) == 0);
    error.message[0] = '\0';
    CHECK(!png_write(in_folder("full/x.png"), samples, 200, 200, 1, 16, false, &error));
    CHECK_CONTAINS(error.message, "no space left on the disk");
    CHECK(count_files(mount_point) == 0);
    umount(mount_point);
}

static void removes_partial_files(void)
{
    struct exr_error error = {""};
    struct partial_file file;
    int n = count_files(folder);
    REQUIRE(partial_open(&file, in_folder("partial.exr"), &error));
    CHECK(count_files(folder) == n + 1);
    errno = 77;
    exr_remove_partial();
    CHECK(errno == 77);
    CHECK(count_files(folder) == n);
    CHECK(!partial_commit(&file, &error));
    CHECK(count_files(folder) == n);
}

/* The result must not depend on the number of threads. */
static void same_file_from_any_threads(void)
{
    static float samples[200 * 300 * 3];
    static const char *const names[] = {"R", "G", "B"};
    struct exr_error error = {""};
    fill(samples, 200 * 300 * 3);
    struct exr_output output = {.width = 200,
                                .height = 300,
                                .data_window = {-7, -9, 192, 290},
                                .display_window = {0, 0, 99, 99},
                                .pixel_aspect = 2,
                                .n_channels = 3,
                                .channel_names = names,
                                .samples = samples};
    static char bytes[2][1000000];
    size_t n[2] = {0};
    for (int i = 0; i < 2; i++) {
        REQUIRE(exr_write(in_folder("threads.exr"), &output, i ? 7 : 1, &error));
        FILE *file = fopen(in_folder("threads.exr"), "rb");
        REQUIRE(file != NULL);
        n[i] = fread(bytes[i], 1, sizeof bytes[i], file);
        fclose(file);
    }
    CHECK(n[0] > 1000 && n[0] == n[1] && memcmp(bytes[0], bytes[1], n[0]) == 0);
}

/* ---- strips ---------------------------------------------------------------------- */

enum { STRIP_W = 150, STRIP_H = 131 };

static const char *const strip_names[] = {"R", "G", "B", "Z"};

static struct exr_output strip_output(int32_t tile_size, const char *compression)
{
    static const enum exr_sample_type types[] = {EXR_SAMPLE_HALF, EXR_SAMPLE_HALF,
                                                 EXR_SAMPLE_HALF, EXR_SAMPLE_FLOAT};
    const struct exr_box box = {-7, 5, STRIP_W - 8, STRIP_H + 4};
    return (struct exr_output){.width = STRIP_W,
                               .height = STRIP_H,
                               .data_window = box,
                               .display_window = box,
                               .n_channels = 4,
                               .channel_names = strip_names,
                               .types = types,
                               .compression = compression,
                               .tile_size = tile_size};
}

/* Writes samples in strips of n_steps steps. */
static bool write_strips(const char *path, const struct exr_output *output,
                         const float *samples, int n_steps, struct exr_error *error)
{
    struct exr_writer *writer;
    if (!exr_write_begin(&writer, path, output, 2, error))
        return false;
    int32_t strip = n_steps * exr_write_step(writer);
    for (int32_t y = 0; y < output->height; y += strip) {
        int32_t n = strip < output->height - y ? strip : output->height - y;
        const float *at =
            samples + (size_t)y * (size_t)(output->width * output->n_channels);
        if (!exr_write_rows(writer, n, at, error)) {
            exr_write_abort(writer);
            return false;
        }
    }
    return exr_write_finish(writer, error);
}

/* Any rows of the file are those of the whole. */
static bool rows_agree(const char *path, const float *whole)
{
    static float rows[STRIP_W * STRIP_H * 4];
    static const int heights[] = {1, 16, 33, 64, STRIP_H};
    struct exr_error error;
    struct exr_input *input;
    struct exr_layer layer;
    bool is_good = exr_open(&input, path, &error) &&
                   exr_find_layer(input, NULL, NULL, false, &layer, &error);
    const int channels[] = {layer.r, layer.g, layer.b, layer.z};
    for (size_t k = 0; is_good && k < sizeof heights / sizeof *heights; k++)
        for (int32_t y = 0; is_good && y < STRIP_H; y += 13) {
            int32_t n = heights[k] < STRIP_H - y ? heights[k] : STRIP_H - y;
            is_good = exr_read_rows(input, channels, 4, (struct exr_rows){y, n}, rows,
                                    2, &error) &&
                      memcmp(rows, whole + (size_t)y * STRIP_W * 4,
                             sizeof *rows * (size_t)(n * STRIP_W * 4)) == 0;
        }
    exr_close(input);
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
    struct exr_error error = {""};
    fill(samples, STRIP_W * STRIP_H * 4);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct exr_output output =
            strip_output(cases[i].tile_size, cases[i].compression);
        const char *path = in_folder("strips.exr"), *whole = in_folder("whole.exr");
        bool is_good = write_strips(path, &output, samples, 1 + (int)i % 3, &error);
        output.samples = samples;
        is_good = is_good && exr_write(whole, &output, 2, &error) &&
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
    struct exr_input *input;
    REQUIRE(exr_open(&input, in_folder("strips.exr"), &error));
    CHECK(exr_parts(input, &n)->is_tiled && exr_row_step(input, 0) == 32);
    CHECK(exr_parts(input, &n)->data_window.min_x == -7);
    exr_close(input);
}

/* Kept channels pass through strips as they pass through whole pictures. */
static void strips_keep_other_channels(void)
{
    static float samples[STRIP_W * STRIP_H * 4];
    struct exr_error error = {""};
    struct exr_input *input;
    struct exr_output output = strip_output(0, "zip");
    fill(samples, STRIP_W * STRIP_H * 4);
    output.samples = samples;
    REQUIRE(exr_write(in_folder("like.exr"), &output, 2, &error));
    REQUIRE(exr_open(&input, in_folder("like.exr"), &error));
    output.like = input;
    output.pass_through = true;
    output.n_channels = 2; /* B and Z stay */
    REQUIRE(exr_write(in_folder("whole.exr"), &output, 2, &error));
    CHECK(write_strips(in_folder("kept.exr"), &output, samples, 2, &error));
    exr_close(input);
    char command[450];
    snprintf(command, sizeof command, "cmp -s %s %s", in_folder("whole.exr"),
             in_folder("kept.exr"));
    CHECK(system(command) == 0);
}

static void strips_say_what_is_wrong(void)
{
    static float samples[STRIP_W * STRIP_H * 4];
    struct exr_error error = {""};
    struct exr_writer *writer;
    struct exr_input *input;
    struct exr_output output = strip_output(0, "zip");
    const char *path = in_folder("wrong.exr");
    int before = count_files(folder);
    REQUIRE(exr_write_begin(&writer, path, &output, 2, &error));
    CHECK(!exr_write_rows(writer, 17, samples, &error));
    CHECK_CONTAINS(error.message, "wrong.exr: a strip of 17 rows");
    CHECK(!exr_write_rows(writer, STRIP_H + 1, samples, &error));
    REQUIRE(exr_write_rows(writer, 16, samples, &error));
    CHECK(!exr_write_finish(writer, &error));
    CHECK_CONTAINS(error.message, "the last 115 rows are missing");
    CHECK(count_files(folder) == before); /* nothing stays */
    REQUIRE(exr_write_begin(&writer, path, &output, 2, &error));
    exr_write_abort(writer);
    CHECK(count_files(folder) == before);
    output.tile_size = -1;
    CHECK(!exr_write_begin(&writer, path, &output, 2, &error) && !writer);
    CHECK_CONTAINS(error.message, "tiles of -1 px");

    output = strip_output(0, "zip");
    REQUIRE(write_strips(path, &output, samples, 1, &error));
    REQUIRE(exr_open(&input, path, &error));
    const int z = 3;
    const struct exr_rows wrong[] = {
        {-1, 2}, {STRIP_H - 1, 2}, {0, 0}, {2147483647, 1}};
    for (int i = 0; i < 4; i++) {
        CHECK(!exr_read_rows(input, &z, 1, wrong[i], samples, 2, &error));
        CHECK_CONTAINS(error.message, "there are only 0 to 130");
    }
    exr_close(input);
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
    struct exr_error error = {""};
    struct exr_writer *writer;
    struct exr_input *input;
    long before = peak_kb();
    float *samples = calloc((size_t)LARGE_W * STRIP * 4, sizeof *samples);
    REQUIRE(samples);
    struct exr_output output = strip_output(64, "rle");
    output.width = LARGE_W;
    output.height = LARGE_H;
    output.data_window = output.display_window =
        (struct exr_box){0, 0, LARGE_W - 1, LARGE_H - 1};
    REQUIRE(exr_write_begin(&writer, in_folder("large.exr"), &output, 2, &error));
    for (int32_t y = 0; y < LARGE_H; y += STRIP) {
        samples[0] = (float)y;
        REQUIRE(exr_write_rows(writer, STRIP, samples, &error));
    }
    REQUIRE(exr_write_finish(writer, &error));
    REQUIRE(exr_open(&input, in_folder("large.exr"), &error));
    const int channels[] = {2, 1, 0, 3}; /* sorted by name in the file */
    bool is_good = true;
    for (int32_t y = 0; is_good && y < LARGE_H; y += STRIP)
        is_good = exr_read_rows(input, channels, 4, (struct exr_rows){y, STRIP},
                                samples, 2, &error) &&
                  samples[0] == (float)y;
    CHECK(is_good);
    exr_close(input);
    free(samples);
    printf("#     %ld kB more\n", peak_kb() - before);
    CHECK(peak_kb() - before < 30000);
}

static void attributes_come_back(void)
{
    static const char *const names[] = {"Y"};
    static const float samples[4] = {0};
    struct exr_error error = {""};
    const struct exr_attribute attributes[] = {
        {.name = "aperture", .type = EXR_ATTRIBUTE_FLOAT, .number = {2.8}},
        {.name = "rackfocus:blades", .type = EXR_ATTRIBUTE_INT, .number = {7}},
        {.name = "rackfocus:a-name-longer-than-31-characters",
         .type = EXR_ATTRIBUTE_STRING,
         .text = "radial"},
        {.name = "rackfocus:lensOffset",
         .type = EXR_ATTRIBUTE_V2F,
         .number = {0.25, -0.5}},
    };
    const struct exr_output output = {.width = 2,
                                      .height = 2,
                                      .data_window = {0, 0, 1, 1},
                                      .display_window = {0, 0, 1, 1},
                                      .n_channels = 1,
                                      .channel_names = names,
                                      .samples = samples,
                                      .attributes = attributes,
                                      .n_attributes = 4};
    REQUIRE(exr_write(in_folder("attributes.exr"), &output, 1, &error));
    struct exr_input *input;
    REQUIRE(exr_open(&input, in_folder("attributes.exr"), &error));
    double v[2];
    const char *text;
    REQUIRE(exr_attribute_number(input, "aperture", &v[0]));
    CHECK_NEAR(v[0], 2.8, 1e-6);
    REQUIRE(exr_attribute_number(input, "rackfocus:blades", &v[0]));
    CHECK_NEAR(v[0], 7, 0);
    REQUIRE(exr_attribute_string(input, "rackfocus:a-name-longer-than-31-characters",
                                 &text));
    CHECK_STR(text, "radial");
    REQUIRE(exr_attribute_v2f(input, "rackfocus:lensOffset", v));
    CHECK_NEAR(v[0], 0.25, 0);
    CHECK_NEAR(v[1], -0.5, 0);
    CHECK(!exr_attribute_number(input, "rackfocus:lensOffset", v));
    CHECK(!exr_attribute_number(input, "nothing", v));
    CHECK(!exr_attribute_string(input, "aperture", &text));
    CHECK(!exr_attribute_v2f(input, "aperture", v));
    exr_close(input);
}

static void refuses_bad_output(void)
{
    static const char *const names[] = {"Y"};
    static const float samples[4] = {0};
    struct exr_error error = {""};
    struct exr_output output = {.width = 2,
                                .height = 2,
                                .data_window = {0, 0, 1, 1},
                                .display_window = {0, 0, 1, 1},
                                .n_channels = 1,
                                .channel_names = names,
                                .samples = samples,
                                .compression = "lzma"};
    CHECK(!exr_write(in_folder("bad.exr"), &output, 1, &error));
    CHECK_CONTAINS(error.message, "unknown compression \"lzma\"");
    output.compression = "dwaa";
    CHECK(!exr_write(in_folder("bad.exr"), &output, 1, &error));
    CHECK_CONTAINS(error.message, "dwaa cannot be written");
    output.compression = NULL;
    output.width = 3;
    CHECK(!exr_write(in_folder("bad.exr"), &output, 1, &error));
    CHECK_CONTAINS(error.message, "does not fit its data window");
    output.width = 2;
    output.n_channels = 0;
    CHECK(!exr_write(in_folder("bad.exr"), &output, 1, &error));
    CHECK_CONTAINS(error.message, "no channel");
    CHECK(access(in_folder("bad.exr"), F_OK) != 0);
}

static void png_comes_back(void)
{
    struct exr_error error = {""};
    static float samples[5 * 3 * 4];
    for (size_t i = 0; i < 5 * 3; i++) {
        float alpha = (float)(i % 5) / 4.0f;
        for (size_t c = 0; c < 3; c++)
            samples[4 * i + c] = alpha * (float)((i + c) % 15) / 14.0f;
        samples[4 * i + 3] = alpha;
    }
    for (int bits = 8; bits <= 16; bits += 8) {
        float *got = NULL;
        int32_t width, height;
        REQUIRE(png_write(in_folder("x.png"), samples, 5, 3, 4, bits, false, &error));
        REQUIRE(png_read(in_folder("x.png"), &got, &width, &height, &error));
        CHECK(width == 5 && height == 3);
        double tolerance = bits == 8 ? 0.6 / 255 * 2.3 : 0.6 / 65535 * 2.3;
        for (size_t i = 0; i < 5 * 3 * 4; i++)
            CHECK_NEAR(got[i], samples[i], tolerance);
        free(got);
    }
}

static void png_clips_and_encodes(void)
{
    static const float samples[] = {-1, 0, 0.5f, 1, 20, NAN};
    struct exr_error error = {""};
    float *got = NULL;
    int32_t width, height;
    REQUIRE(png_write(in_folder("g.png"), samples, 6, 1, 1, 8, false, &error));
    REQUIRE(png_read(in_folder("g.png"), &got, &width, &height, &error));
    static const float want[] = {0, 0, 0.5f, 1, 1, 0};
    for (size_t i = 0; i < 6; i++) {
        CHECK_NEAR(got[4 * i], want[i], 0.004);
        CHECK_NEAR(got[4 * i + 3], 1, 0);
    }
    free(got);
    /* As it is: 0.5 is 128 of 255 and reads as the linear light of that. */
    REQUIRE(png_write(in_folder("g.png"), samples, 6, 1, 1, 8, true, &error));
    REQUIRE(png_read(in_folder("g.png"), &got, &width, &height, &error));
    CHECK_NEAR(got[4 * 2], 0.2158605, 1e-4);
    free(got);
}

static void png_says_why(void)
{
    struct exr_error error = {""};
    float *got, pixel[3] = {0};
    int32_t width, height;
    CHECK(!png_read(in_folder("missing.png"), &got, &width, &height, &error));
    CHECK_CONTAINS(error.message, "No such file");
    CHECK(!png_read(in_folder("text.exr"), &got, &width, &height, &error));
    CHECK_CONTAINS(error.message, "is not a PNG file");
    CHECK(!png_write(in_folder("y.png"), pixel, 1, 1, 3, 12, false, &error));
    CHECK_CONTAINS(error.message, "12 bits");
    static float noise[64 * 64];
    for (size_t i = 0; i < 64 * 64; i++)
        noise[i] = (float)(i * 7919 % 97) / 97;
    REQUIRE(png_write(in_folder("cut.png"), noise, 64, 64, 1, 8, false, &error));
    REQUIRE(truncate(in_folder("cut.png"), 500) == 0);
    CHECK(!png_read(in_folder("cut.png"), &got, &width, &height, &error));
    CHECK_CONTAINS(error.message, "cut.png: damaged");
    CHECK(got == NULL);
}

static void remove_folder(void)
{
    char command[100];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    if (system(command) != 0)
        printf("# %s stays\n", folder);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    if (!mkdtemp(folder))
        return 1;
    TEST(half_of_every_value);
    TEST(half_rounds_to_nearest_even);
    TEST(half_does_not_overflow);
    TEST(runs_of_halves_have_the_same_bits);
    TEST(rounding_of_runs_is_that_of_single_values);
    TEST(writes_and_reads_back);
    TEST(finds_layers);
    TEST(keeps_old_file_on_failure);
    TEST(follows_links);
    TEST(says_why_it_cannot_write);
    TEST(says_why_it_cannot_read);
    TEST(says_when_the_disk_is_full);
    TEST(removes_partial_files);
    TEST(same_file_from_any_threads);
    TEST(strips_are_the_whole);
    TEST(strips_keep_other_channels);
    TEST(strips_say_what_is_wrong);
    TEST(large_pictures_need_little_memory);
    TEST(attributes_come_back);
    TEST(refuses_bad_output);
    TEST(png_comes_back);
    TEST(png_clips_and_encodes);
    TEST(png_says_why);
    remove_folder();
    return testing_end();
}
