/* SPDX-License-Identifier: Apache-2.0 */
/* Plain pixels that methods read by themselves: the same bits as by planes, and errors.
 */
#include "physics/frames.h"
#include "testing.h"

enum { LOOSE = 5 }; /* floats per pixel of a picture that is not packed */

enum kind { OPAQUE, TRANSLUCENT, FILM_WITHOUT_DEPTH, N_KINDS };

/* Who reads plain pixels by itself: of several views the last one is the frame. */
struct reader {
    enum rf_method method;
    enum rf_quality quality;
    int n_views;
};

enum { MOST_VIEWS = 3 };

static const struct reader readers[] = {
    {RF_METHOD_LAYERED, RF_QUALITY_PREVIEW, 1},
    {RF_METHOD_LAYERED, RF_QUALITY_BEST, 1},
    {RF_METHOD_VIEWS, RF_QUALITY_BEST, MOST_VIEWS},
};

static struct rf_image image_of(float *data, const struct frame *f, int pixel)
{
    struct rf_image image = rf_image_packed(data, f->width, f->height, 4);
    image.pixel_bytes = pixel * (ptrdiff_t)sizeof(float);
    image.row_bytes = image.pixel_bytes * f->width;
    return image;
}

/* A frame's pixels, `pixel` floats apart. */
static float *pixels_of(const struct frame *f, int pixel)
{
    float *at = calloc(frame_pixels(f) * (size_t)pixel, sizeof *at);
    for (size_t i = 0; i < frame_pixels(f); i++)
        memcpy(at + i * (size_t)pixel, f->colour + 4 * i, 4 * sizeof *at);
    return at;
}

static rf_result process(const struct reader *reader, const struct rf_view *views,
                         const struct rf_image *out, struct rf_error *error)
{
    struct rf_params params;
    struct rf_filter *made;
    scene_params(&params, reader->method);
    params.quality = reader->quality;
    struct rf_context *context;
    rf_result result = rf_context_create(&context, NULL, error);
    if (result == RF_OK)
        result =
            rf_filter_create(&made, context, &params, out->width, out->height, error);
    if (result == RF_OK) {
        result = rf_filter_process(made, views, reader->n_views, out, NULL, error);
        rf_filter_destroy(made);
    }
    rf_context_destroy(context);
    return result;
}

/* Filters a frame; its pixels `pixel` floats apart, perhaps in place. */
static rf_result filter(const struct reader *reader, const struct frame *f, int pixel,
                        bool is_in_place, float *out, struct rf_error *error)
{
    struct frame other = frame_make(f->width, f->height, 4);
    if (reader->n_views > 1)
        frame_fill_scene(&other, 12);
    float *from = pixels_of(f, pixel), *beside = pixels_of(&other, pixel);
    float *to = is_in_place ? from : pixels_of(f, pixel);
    struct rf_view views[MOST_VIEWS];
    for (int j = 0; j < reader->n_views; j++) {
        bool is_last = j == reader->n_views - 1;
        views[j] =
            (struct rf_view){.colour = image_of(is_last ? from : beside, f, pixel),
                             .depth = rf_image_packed(is_last ? f->depth : other.depth,
                                                      f->width, f->height, 1)};
        views[j].lens_offset[j % 2] = reader->n_views > 1 ? 0.02 * (j - 1) : 0;
    }
    struct rf_image to_image = image_of(to, f, pixel);
    rf_result result = process(reader, views, &to_image, error);
    for (size_t i = 0; i < frame_pixels(f); i++)
        memcpy(out + 4 * i, to + i * (size_t)pixel, 4 * sizeof *out);
    free(from);
    free(beside);
    if (!is_in_place)
        free(to);
    frame_free(&other);
    return result;
}

static void set_kind(struct frame *f, enum kind kind)
{
    for (int y = 0; y < f->height && kind != OPAQUE; y++)
        for (int x = 0; x < f->width; x += 11) {
            float *c = frame_at(f, f->colour, x, y);
            c[3] = 0.75f;
            if (kind == FILM_WITHOUT_DEPTH && x % 3 == 0)
                f->depth[(size_t)y * (size_t)f->width + (size_t)x] = 1e10f;
        }
}

static void check_the_same(const struct reader *reader, int width, int height,
                           enum kind kind)
{
    struct frame f = frame_make(width, height, 4);
    frame_fill_scene(&f, 12);
    set_kind(&f, kind);
    float *out = malloc(frame_bytes(&f));
    CHECK(filter(reader, &f, LOOSE, false, f.out, NULL) == RF_OK);
    CHECK(filter(reader, &f, 4, false, out, NULL) == RF_OK);
    CHECK(memcmp(out, f.out, frame_bytes(&f)) == 0);
    CHECK(filter(reader, &f, 4, true, out, NULL) == RF_OK);
    CHECK(memcmp(out, f.out, frame_bytes(&f)) == 0);
    CHECK(memcmp(out, f.colour, frame_bytes(&f)) != 0);
    free(out);
    frame_free(&f);
}

static void is_the_same_as_by_planes(void)
{
    for (int k = 0; k < 3; k++)
        for (int kind = 0; kind < N_KINDS; kind++)
            check_the_same(&readers[k], 37, 26, (enum kind)kind);
}

/* These have more pixels than layered's preview leaves as they are: it halves them, and
 * those of odd size have rest columns and rows. */
static void is_the_same_where_pixels_are_halved(void)
{
    for (int kind = 0; kind < N_KINDS; kind++)
        check_the_same(&readers[0], 403, 399, (enum kind)kind);
}

static void is_the_same_where_halves_are_whole(void)
{
    for (int kind = 0; kind < N_KINDS; kind++)
        check_the_same(&readers[0], 640, 252, (enum kind)kind);
}

static void bad_pixels_are_named(void)
{
    for (int k = 0; k < 3; k++) {
        struct frame f = frame_make(643, 403, 4);
        struct rf_error error = {0};
        frame_fill_scene(&f, 12);
        frame_at(&f, f.colour, 640, 402)[1] = INFINITY;
        CHECK(filter(&readers[k], &f, 4, false, f.out, &error) == RF_ERROR_PIXEL);
        CHECK_CONTAINS(error.message, "(640, 402)");
        frame_at(&f, f.colour, 640, 402)[1] = 1;
        f.depth[643 * 5 + 642] = -1;
        CHECK(filter(&readers[k], &f, 4, false, f.out, &error) == RF_ERROR_DEPTH);
        CHECK_CONTAINS(error.message, "(642, 5)");
        frame_free(&f);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(is_the_same_as_by_planes);
    TEST(is_the_same_where_pixels_are_halved);
    TEST(is_the_same_where_halves_are_whole);
    TEST(bad_pixels_are_named);
    return testing_end();
}
