/* SPDX-License-Identifier: Apache-2.0 */
/* Unit tests of exr/: what needs no other program to make files. */
#include "exr_testing.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include "exr_private.h"

enum { WIDTH = 37, HEIGHT = 29 };

/* A picture with the given channels, all of one type. */
static bool write_channels(const char *path, const char *const *names, int n,
                           enum image_sample_type type, struct image_error *error)
{
    float *samples = malloc(sizeof *samples * WIDTH * HEIGHT * (size_t)n);
    enum image_sample_type types[64];
    for (int i = 0; i < n; i++)
        types[i] = type;
    fill(samples, (size_t)(WIDTH * HEIGHT * n));
    const struct image_output output = {
        .width = WIDTH,
        .height = HEIGHT,
        .n_channels = n,
        .channel_names = names,
        .types = types,
        .samples = samples,
    };
    bool is_good = image_write(path, &output, 2, error);
    free(samples);
    return is_good;
}

static void writes_and_reads_back(void)
{
    static const char *const names[] = {"R", "G", "B", "A", "Z"};
    struct image_error error = {.message = ""};
    struct image_input *input;
    const char *path = in_folder("plain.exr");
    REQUIRE(write_channels(path, names, 5, IMAGE_SAMPLE_FLOAT, &error));
    REQUIRE(image_open(&input, path, &error));
    int n_parts, n;
    const struct image_part_info *parts = image_parts(input, &n_parts);
    image_channels(input, &n);
    CHECK(n_parts == 1 && n == 5);
    const struct image_box *boxes[] = {&parts[0].data_window, &parts[0].display_window};
    for (int i = 0; i < 2; i++) /* neither was named */
        CHECK(boxes[i]->min_x == 0 && boxes[i]->min_y == 0 &&
              boxes[i]->max_x == WIDTH - 1 && boxes[i]->max_y == HEIGHT - 1);
    CHECK(parts[0].pixel_aspect == 1);
    CHECK_STR(parts[0].compression, "zip");
    CHECK(parts[0].data_window.max_x == WIDTH - 1);
    CHECK_STR(image_path(input), path);

    struct image_layer layer;
    REQUIRE(image_find_layer(input, NULL, NULL, false, &layer, &error));
    int wanted[] = {layer.r, layer.g, layer.b, layer.a, layer.z, -1};
    static float got[WIDTH * HEIGHT * 6], want[WIDTH * HEIGHT * 5];
    fill(want, WIDTH * HEIGHT * 5);
    REQUIRE(image_read(input, wanted, 6, got, 3, &error));
    bool is_same = true;
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        is_same &= memcmp(got + 6 * i, want + 5 * i, 5 * sizeof *got) == 0;
        is_same &= got[6 * i + 5] == 1.0f;
    }
    CHECK(is_same);
    int wrong[] = {99};
    CHECK(!image_read(input, wrong, 1, got, 1, &error));
    CHECK_CONTAINS(error.message, "no channel number 99");
    image_close(input);
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
    {"RGBA.R RGBA.G RGBA.B crypto.R crypto.G crypto.B crypto00.red crypto00.green "
     "crypto00.blue Z",
     NULL, NULL, false, "RGBA RGBA.R Z"},
    {"albedo.R albedo.G albedo.B uCryptoAsset.R uCryptoAsset.G uCryptoAsset.B key.R "
     "key.G key.B",
     NULL, NULL, false, "key key.R -"},
    {"N.R N.G N.B composition.R composition.G composition.B", NULL, NULL, false,
     "composition composition.R -"},
    {"Albedo.R Albedo.G Albedo.B lit.Y", NULL, NULL, false, "lit lit.Y -"},
    {"ids.Combined.R ids.Combined.G ids.Combined.B ids.Emit.R ids.Emit.G ids.Emit.B",
     NULL, NULL, false, "ids.Combined ids.Combined.R -"},
    {"albedo.R albedo.G albedo.B", NULL, NULL, false, "albedo albedo.R -"},
    {"albedo.R albedo.G albedo.B key.R key.G key.B", "albedo", NULL, false,
     "albedo albedo.R -"},
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

static const char *name_of(const struct image_input *input, int channel)
{
    return channel < 0 ? "-" : image_channels(input, NULL)[channel].name;
}

static void find_one(const struct layer_case *c)
{
    char buffer[600], got[800];
    const char *names[64];
    struct image_error error = {.message = ""};
    struct image_input *input;
    struct image_layer layer;
    int n = split(c->channels, buffer, names);
    REQUIRE(
        write_channels(in_folder("layers.exr"), names, n, IMAGE_SAMPLE_HALF, &error));
    REQUIRE(image_open(&input, in_folder("layers.exr"), &error));
    if (image_find_layer(input, c->layer, c->depth, c->depth_only, &layer, &error)) {
        snprintf(got, sizeof got, "%s %s %s", layer.name, name_of(input, layer.r),
                 name_of(input, layer.z));
        CHECK_STR(got, c->want);
        CHECK(layer.r < 0 || layer.g >= 0);
    } else if (strncmp(c->want, "FAIL ", 5) == 0) {
        CHECK_CONTAINS(error.message, c->want + 5);
    } else {
        CHECK_STR(error.message, c->want);
    }
    image_close(input);
}

/* Which layers fit as well as the one that is found, and whether it holds data. */
static const struct {
    const char *channels, *layer, *fitting;
    bool is_data;
} fitting_cases[] = {
    {"key.R key.G key.B fill.R fill.G fill.B rim.R rim.G", NULL, "fill, key", false},
    {"key.R key.G key.B fill.R fill.G fill.B", "key", "", false},
    {"key.R key.G key.B fill.R fill.G fill.B N.R N.G N.B R G B", NULL, "", false},
    {"key.R key.G key.B N.R N.G N.B", NULL, "", false},
    {"beauty.R beauty.G beauty.B final.R final.G final.B", NULL, "beauty, final",
     false},
    {"N.R N.G N.B P.R P.G P.B", NULL, "N, P", true},
    {"N.R N.G N.B P.R P.G P.B", "P", "", false},
};

static void finds_what_fits_as_well(void)
{
    for (size_t i = 0; i < sizeof fitting_cases / sizeof fitting_cases[0]; i++) {
        char buffer[600];
        const char *names[64];
        struct image_error error = {.message = ""};
        struct image_input *input;
        struct image_layer layer;
        const int n = split(fitting_cases[i].channels, buffer, names);
        REQUIRE(write_channels(in_folder("layers.exr"), names, n, IMAGE_SAMPLE_HALF,
                               &error));
        REQUIRE(image_open(&input, in_folder("layers.exr"), &error));
        CHECK(image_find_layer(input, fitting_cases[i].layer, NULL, false, &layer,
                               &error));
        CHECK_STR(layer.fitting, fitting_cases[i].fitting);
        CHECK(layer.is_data == fitting_cases[i].is_data);
        image_close(input);
    }
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
    struct image_error error = {.message = ""};
    struct stat before, after;
    const char *path = in_folder("old.exr");
    REQUIRE(write_channels(path, names, 3, IMAGE_SAMPLE_HALF, &error));
    REQUIRE(chmod(path, 0640) == 0);
    REQUIRE(stat(path, &before) == 0);
    int n = count_files(folder);
    CHECK(!write_channels(path, twice, 2, IMAGE_SAMPLE_HALF, &error));
    CHECK_CONTAINS(error.message, "given twice");
    REQUIRE(stat(path, &after) == 0);
    CHECK(before.st_ino == after.st_ino);
    CHECK(count_files(folder) == n);
    REQUIRE(write_channels(path, names, 3, IMAGE_SAMPLE_HALF, &error));
    REQUIRE(stat(path, &after) == 0);
    CHECK((after.st_mode & 0777) == 0640);
    CHECK(count_files(folder) == n);
}

static void follows_links(void)
{
    static const char *const names[] = {"Y"};
    struct image_error error = {.message = ""};
    struct stat status;
    REQUIRE(
        write_channels(in_folder("target.exr"), names, 1, IMAGE_SAMPLE_HALF, &error));
    REQUIRE(symlink(in_folder("target.exr"), in_folder("link.exr")) == 0);
    CHECK(write_channels(in_folder("link.exr"), names, 1, IMAGE_SAMPLE_FLOAT, &error));
    REQUIRE(lstat(in_folder("link.exr"), &status) == 0);
    CHECK(S_ISLNK(status.st_mode));
}

static void says_why_it_cannot_write(void)
{
    static const char *const names[] = {"Y"};
    struct image_error error = {.message = ""};
    CHECK(
        !write_channels(in_folder("none/x.exr"), names, 1, IMAGE_SAMPLE_HALF, &error));
    CHECK_CONTAINS(error.message, "No such file or directory");
    CHECK(!write_channels(folder, names, 1, IMAGE_SAMPLE_HALF, &error));
    CHECK_CONTAINS(error.message, "not a regular file");
    CHECK(!write_channels("/dev/null", names, 1, IMAGE_SAMPLE_HALF, &error));
    CHECK_CONTAINS(error.message, "not a regular file");
}

static void says_why_it_cannot_read(void)
{
    struct image_error error = {.message = ""};
    struct image_input *input;
    CHECK(!image_open(&input, in_folder("missing.exr"), &error));
    CHECK(input == NULL);
    CHECK_CONTAINS(error.message, "missing.exr: No such file or directory");
    CHECK(!image_open(&input, folder, &error));
    CHECK_CONTAINS(error.message, "is a folder");
    CHECK(!image_open(&input, "/dev/null", &error));
    CHECK_CONTAINS(error.message, "not a regular file");
    FILE *file = fopen(in_folder("text.exr"), "w");
    REQUIRE(file != NULL);
    fclose(file);
    CHECK(!image_open(&input, in_folder("text.exr"), &error));
    CHECK_CONTAINS(error.message, "is empty");
    file = fopen(in_folder("text.exr"), "w");
    REQUIRE(file != NULL);
    fputs("hello", file);
    fclose(file);
    CHECK(!image_open(&input, in_folder("text.exr"), &error));
    CHECK_CONTAINS(error.message, "is not an OpenEXR file");
    file = fopen(in_folder("text.exr"), "w");
    REQUIRE(file != NULL);
    fwrite("\x76\x2f\x31\x01\x02\0\0\0", 1, 8, file);
    fclose(file);
    CHECK(!image_open(&input, in_folder("text.exr"), &error));
    CHECK_CONTAINS(error.message, "damaged header");
}

static void says_when_the_disk_is_full(void)
{
    static const char *const names[] = {"Y"};
    char mount_point[200];
    struct image_error error = {.message = ""};
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
    const struct image_output output = {.width = 200,
                                        .height = 200,
                                        .n_channels = 1,
                                        .channel_names = names,
                                        .samples = samples};
    CHECK(!image_write(in_folder("full/x.exr"), &output, 2, &error));
    CHECK_CONTAINS(error.message, "no space left on the disk");
    CHECK(count_files(mount_point) == 0);
    error.message[0] = '\0';
    CHECK(!image_write_png(in_folder("full/x.png"), samples, 200, 200, 1, 16, false,
                           &error));
    CHECK_CONTAINS(error.message, "no space left on the disk");
    CHECK(count_files(mount_point) == 0);
    umount(mount_point);
}

static void removes_partial_files(void)
{
    struct image_error error = {.message = ""};
    struct os_replace file;
    int n = count_files(folder);
    REQUIRE(partial_open(&file, in_folder("partial.exr"), &error));
    CHECK(count_files(folder) == n + 1);
    errno = 77;
    os_replace_remove_all();
    CHECK(errno == 77);
    CHECK(count_files(folder) == n);
    CHECK(!partial_commit(&file, "partial.exr", &error));
    CHECK(count_files(folder) == n);
}

/* The result must not depend on the number of threads. */
static void same_file_from_any_threads(void)
{
    static float samples[200 * 300 * 3];
    static const char *const names[] = {"R", "G", "B"};
    struct image_error error = {.message = ""};
    fill(samples, 200 * 300 * 3);
    struct image_output output = {.width = 200,
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
        REQUIRE(image_write(in_folder("threads.exr"), &output, i ? 7 : 1, &error));
        FILE *file = fopen(in_folder("threads.exr"), "rb");
        REQUIRE(file != NULL);
        n[i] = fread(bytes[i], 1, sizeof bytes[i], file);
        fclose(file);
    }
    CHECK(n[0] > 1000 && n[0] == n[1] && memcmp(bytes[0], bytes[1], n[0]) == 0);
}

static void attributes_come_back(void)
{
    static const char *const names[] = {"Y"};
    static const float samples[4] = {0};
    struct image_error error = {.message = ""};
    const struct image_attribute attributes[] = {
        {.name = "aperture", .type = IMAGE_ATTRIBUTE_FLOAT, .number = {2.8}},
        {.name = "rackfocus:blades", .type = IMAGE_ATTRIBUTE_INT, .number = {7}},
        {.name = "rackfocus:a-name-longer-than-31-characters",
         .type = IMAGE_ATTRIBUTE_STRING,
         .text = "radial"},
        {.name = "rackfocus:lensOffset",
         .type = IMAGE_ATTRIBUTE_V2F,
         .number = {0.25, -0.5}},
    };
    const struct image_output output = {.width = 2,
                                        .height = 2,
                                        .n_channels = 1,
                                        .channel_names = names,
                                        .samples = samples,
                                        .attributes = attributes,
                                        .n_attributes = 4};
    REQUIRE(image_write(in_folder("attributes.exr"), &output, 1, &error));
    struct image_input *input;
    REQUIRE(image_open(&input, in_folder("attributes.exr"), &error));
    double v[2];
    const char *text;
    REQUIRE(image_attribute_number(input, "aperture", &v[0]));
    CHECK_NEAR(v[0], 2.8, 1e-6);
    REQUIRE(image_attribute_number(input, "rackfocus:blades", &v[0]));
    CHECK_NEAR(v[0], 7, 0);
    REQUIRE(image_attribute_string(input, "rackfocus:a-name-longer-than-31-characters",
                                   &text));
    CHECK_STR(text, "radial");
    REQUIRE(image_attribute_v2f(input, "rackfocus:lensOffset", v));
    CHECK_NEAR(v[0], 0.25, 0);
    CHECK_NEAR(v[1], -0.5, 0);
    CHECK(!image_attribute_number(input, "rackfocus:lensOffset", v));
    CHECK(!image_attribute_number(input, "nothing", v));
    CHECK(!image_attribute_string(input, "aperture", &text));
    CHECK(!image_attribute_v2f(input, "aperture", v));
    image_close(input);
}

/* What a file may hold beside what we set, written with OpenEXRCore itself. */
static exr_result_t declare_all(exr_context_t file)
{
    static const char *const texts[] = {"one", "", "three"};
    static const float floats[] = {1, 2.5f, -3};
    static const uint8_t pixels[2 * 2 * 4] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    const exr_attr_preview_t preview = {
        .width = 2, .height = 2, .alloc_size = sizeof pixels, .rgba = pixels};
    exr_attribute_t *made;
    exr_result_t result = exr_attr_set_preview(file, 0, "preview", &preview);
    result |= exr_attr_set_string_vector(file, 0, "texts", 3, (const char **)texts);
    result |= exr_attr_set_float_vector(file, 0, "floats", 3, floats);
    result |= exr_attr_set_string(file, 0, "text", "");
    result |= exr_attr_set_double(file, 0, "double", 1.25);
    result |= exr_attr_set_envmap(file, 0, "envmap", EXR_ENVMAP_CUBE);
    result |= exr_attr_set_user(file, 0, "own", "ownType", sizeof pixels, pixels);
    static const struct {
        exr_attribute_type_t type;
        size_t n_bytes;
    } blocks[] = {
        {EXR_ATTR_BOX2I, 16},   {EXR_ATTR_BOX2F, 16}, {EXR_ATTR_CHROMATICITIES, 32},
        {EXR_ATTR_KEYCODE, 28}, {EXR_ATTR_M33F, 36},  {EXR_ATTR_M33D, 72},
        {EXR_ATTR_M44F, 64},    {EXR_ATTR_M44D, 128}, {EXR_ATTR_RATIONAL, 8},
        {EXR_ATTR_TIMECODE, 8}, {EXR_ATTR_V2I, 8},    {EXR_ATTR_V2F, 8},
        {EXR_ATTR_V2D, 16},     {EXR_ATTR_V3I, 12},   {EXR_ATTR_V3F, 12},
        {EXR_ATTR_V3D, 24}};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) {
        char name[20];
        snprintf(name, sizeof name, "block%zu", i);
        result |= exr_attr_declare(file, 0, name, blocks[i].type, &made);
        if (result != EXR_ERR_SUCCESS)
            return result;
        for (size_t k = 0; k < blocks[i].n_bytes; k++)
            ((uint8_t *)made->rawptr)[k] = (uint8_t)(i + k);
    }
    return result;
}

/* A plane of zeros whose header has everything. */
static exr_result_t write_with_all(const char *path)
{
    static const uint8_t lines[4 * 4 * 2];
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file;
    int part;
    exr_result_t result =
        exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, &settings);
    if (result != EXR_ERR_SUCCESS)
        return result;
    result |= exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part);
    result |= exr_initialize_required_attr_simple(file, 0, 4, 4, EXR_COMPRESSION_NONE);
    result |= exr_add_channel(file, 0, "Y", EXR_PIXEL_HALF,
                              EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    result |= declare_all(file);
    result |= exr_write_header(file);
    for (int y = 0; y < 4 && result == EXR_ERR_SUCCESS; y++)
        result |= exr_write_scanline_chunk(file, 0, y, lines + 8 * y, 8);
    return result | exr_finish(&file);
}

/* The bytes of an attribute, from its name on, as the header has them. */
static bool has_same_attribute(const char *a, size_t n_a, const char *b, size_t n_b,
                               const char *name)
{
    const size_t n_name = strlen(name) + 1;
    const char *in_a = memmem(a, n_a, name, n_name);
    const char *in_b = memmem(b, n_b, name, n_name);
    if (!in_a || !in_b)
        return false;
    int32_t size;
    const size_t n_head = n_name + strlen(in_a + n_name) + 1;
    memcpy(&size, in_a + n_head, sizeof size);
    return memcmp(in_a, in_b, n_head + 4 + (size_t)size) == 0;
}

static size_t read_bytes(const char *path, char *bytes, size_t n_most)
{
    FILE *file = fopen(path, "rb");
    size_t n = file ? fread(bytes, 1, n_most, file) : 0;
    if (file)
        fclose(file);
    return n;
}

/* Every type of attribute that the format has, and one of somebody's own. */
static void copies_attributes_of_every_type(void)
{
    static const char *const names[] = {"Y"};
    static const float samples[16];
    static char before[8192], after[8192];
    struct image_error error = {.message = ""};
    struct image_input *input;
    const char *path = in_folder("all.exr"), *copy = in_folder("copy.exr");
    REQUIRE(write_with_all(path) == EXR_ERR_SUCCESS);
    REQUIRE(image_open(&input, path, &error));
    const struct image_output output = {.width = 4,
                                        .height = 4,
                                        .like = input,
                                        .n_channels = 1,
                                        .channel_names = names,
                                        .samples = samples};
    CHECK(image_write(copy, &output, 1, &error));
    image_close(input);
    const size_t n_before = read_bytes(path, before, sizeof before);
    const size_t n_after = read_bytes(copy, after, sizeof after);
    static const char *const kept[] = {"preview", "texts",  "floats", "text",
                                       "double",  "envmap", "own"};
    for (size_t i = 0; i < sizeof kept / sizeof *kept; i++)
        CHECK(has_same_attribute(before, n_before, after, n_after, kept[i]));
    for (int i = 0; i < 16; i++) {
        char name[20];
        snprintf(name, sizeof name, "block%d", i);
        CHECK(has_same_attribute(before, n_before, after, n_after, name));
    }
    double v[2];
    REQUIRE(image_open(&input, copy, &error));
    CHECK(image_attribute_number(input, "double", v) && v[0] == 1.25);
    CHECK(image_attribute_v2f(input, "block10", v)); /* whole numbers, and doubles */
    CHECK(image_attribute_v2f(input, "block12", v));
    image_close(input);
}

static void refuses_bad_output(void)
{
    static const char *const names[] = {"Y"};
    static const float samples[4] = {0};
    struct image_error error = {.message = ""};
    struct image_output output = {.width = 2,
                                  .height = 2,
                                  .data_window = {0, 0, 1, 1},
                                  .n_channels = 1,
                                  .channel_names = names,
                                  .samples = samples,
                                  .compression = "lzma"};
    CHECK(!image_write(in_folder("bad.exr"), &output, 1, &error));
    CHECK_CONTAINS(error.message, "unknown compression \"lzma\"");
    output.compression = "dwaa";
    CHECK(!image_write(in_folder("bad.exr"), &output, 1, &error));
    CHECK_CONTAINS(error.message, "dwaa can be read, but not written");
    output.compression = NULL;
    output.width = 3;
    CHECK(!image_write(in_folder("bad.exr"), &output, 1, &error));
    CHECK_CONTAINS(error.message, "does not fit its data window");
    output.width = 2;
    output.n_channels = 0;
    CHECK(!image_write(in_folder("bad.exr"), &output, 1, &error));
    CHECK_CONTAINS(error.message, "no channel");
    CHECK(access(in_folder("bad.exr"), F_OK) != 0);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    if (!make_folder())
        return 1;
    TEST(writes_and_reads_back);
    TEST(finds_layers);
    TEST(finds_what_fits_as_well);
    TEST(keeps_old_file_on_failure);
    TEST(follows_links);
    TEST(says_why_it_cannot_write);
    TEST(says_why_it_cannot_read);
    TEST(says_when_the_disk_is_full);
    TEST(removes_partial_files);
    TEST(same_file_from_any_threads);
    TEST(attributes_come_back);
    TEST(copies_attributes_of_every_type);
    TEST(refuses_bad_output);
    remove_folder();
    return testing_end();
}
