/* SPDX-License-Identifier: Apache-2.0 */
/* The preview reads plain pixels by itself: the same bits as by planes, and its errors.
 */
#include "physics/frames.h"
#include "testing.h"

enum { LOOSE = 5 }; /* floats per pixel of a picture that is not packed */

enum kind { OPAQUE, TRANSLUCENT, FILM_WITHOUT_DEPTH, N_KINDS };

/* Filters a frame as a preview; its pixels `pixel` floats apart, perhaps in place. */
static rf_result filter(const struct frame *f, int pixel, bool is_in_place, float *out,
                        struct rf_error *error)
{
    size_t n = frame_pixels(f);
    float *from = calloc(n * (size_t)pixel, sizeof *from);
    float *to = is_in_place ? from : calloc(n * (size_t)pixel, sizeof *to);
    for (size_t i = 0; i < n; i++)
        memcpy(from + i * (size_t)pixel, f->colour + 4 * i, 4 * sizeof *from);
    struct rf_image images[2];
    for (int i = 0; i < 2; i++) {
        images[i] = rf_image_packed(i ? to : from, f->width, f->height, 4);
        images[i].pixel_bytes = pixel * (ptrdiff_t)sizeof(float);
        images[i].row_bytes = images[i].pixel_bytes * f->width;
    }
    struct rf_view view = {.colour = images[0],
                           .depth = rf_image_packed(f->depth, f->width, f->height, 1)};
    struct rf_params params;
    struct rf_filter *made;
    scene_params(&params, RF_METHOD_LAYERED);
    params.quality = RF_QUALITY_PREVIEW;
    struct rf_context *context;
    rf_result result = rf_context_create(&context, NULL, error);
    if (result == RF_OK)
        result = rf_filter_create(&made, context, &params, f->width, f->height, error);
    if (result == RF_OK) {
        result = rf_filter_process(made, &view, 1, &images[1], NULL, error);
        rf_filter_destroy(made);
    }
    rf_context_destroy(context);
    for (size_t i = 0; i < n; i++)
        memcpy(out + 4 * i, to + i * (size_t)pixel, 4 * sizeof *out);
    free(from);
    if (!is_in_place)
        free(to);
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

static void is_the_same_as_by_planes(void)
{
    static const int sizes[][2] = {{643, 403}, {800, 512}, {61, 40}};
    for (int i = 0; i < 3; i++)
        for (int kind = 0; kind < N_KINDS; kind++) {
            struct frame f = frame_make(sizes[i][0], sizes[i][1], 4);
            frame_fill_scene(&f, 12);
            set_kind(&f, (enum kind)kind);
            float *out = malloc(frame_bytes(&f));
            CHECK(filter(&f, LOOSE, false, f.out, NULL) == RF_OK);
            CHECK(filter(&f, 4, false, out, NULL) == RF_OK);
            CHECK(memcmp(out, f.out, frame_bytes(&f)) == 0);
            CHECK(filter(&f, 4, true, out, NULL) == RF_OK);
            CHECK(memcmp(out, f.out, frame_bytes(&f)) == 0);
            CHECK(memcmp(out, f.colour, frame_bytes(&f)) != 0);
            free(out);
            frame_free(&f);
        }
}

static void bad_pixels_are_named(void)
{
    struct frame f = frame_make(643, 403, 4);
    struct rf_error error = {0};
    frame_fill_scene(&f, 12);
    frame_at(&f, f.colour, 640, 402)[1] = INFINITY;
    CHECK(filter(&f, 4, false, f.out, &error) == RF_ERROR_PIXEL);
    CHECK_CONTAINS(error.message, "(640, 402)");
    frame_at(&f, f.colour, 640, 402)[1] = 1;
    f.depth[643 * 5 + 642] = -1;
    CHECK(filter(&f, 4, false, f.out, &error) == RF_ERROR_DEPTH);
    CHECK_CONTAINS(error.message, "(642, 5)");
    frame_free(&f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(is_the_same_as_by_planes);
    TEST(bad_pixels_are_named);
    return testing_end();
}
