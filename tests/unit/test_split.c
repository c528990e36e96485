/* SPDX-License-Identifier: Apache-2.0 */
/* Splitting mixed pixels: which may be fringes of a highlight, and what is noted. */
#include "api/filter.h"
#include "base/context.h"
#include "base/math.h"
#include "base/pool.h"
#include "input/frame.h"
#include "kernels/data.h"
#include "surfaces/split.h"
#include "surfaces/surfaces.h"
#include "testing.h"

enum { MOST_W = 72, MOST_H = 9, STRIDE = MOST_W + 2 * RF_ROW_MARGIN };
enum { N = MOST_W * MOST_H, N_WORDS = (MOST_W + 63) / 64 * MOST_H };

/* A picture of grey surfaces, and what becomes of it. */
static struct rf_surface pixels[N], near[N], far[N];
static float luminance[STRIDE * MOST_H], radius[STRIDE * MOST_H];
static float darkest[STRIDE * MOST_H], share[N];
static uint64_t possible_highlights[N_WORDS];
static bool is_alone;      /* the only view */
static const float *means; /* mean distances; NULL: none */

static void put(int width, int x, int y, float v, float r)
{
    pixels[y * width + x] = (struct rf_surface){{v, v, v, 1}, r};
}

static void fill_planes(const struct rf_pixels *p)
{
    for (int y = 0; y < p->height; y++)
        for (int x = -RF_ROW_MARGIN; x < STRIDE - RF_ROW_MARGIN; x++) {
            const struct rf_surface *s =
                &pixels[y * p->width + rf_min_int(rf_max_int(x, 0), p->width - 1)];
            rf_plane_row(p, p->luminance, y)[x] =
                rf_luminance(s->c[0], s->c[1], s->c[2]);
            rf_plane_row(p, p->radius, y)[x] = s->r;
        }
}

static double f_stop = 0.1; /* radii of px in so small a picture */
static int projection = RF_PROJECTION_PERSPECTIVE;

/* Splits width x height pixels; `far` has a place for each of them. */
static void split(int width, int height, float bright)
{
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_pixels p = {.width = width,
                          .height = height,
                          .at = memcpy(near, pixels, sizeof near),
                          .stride = STRIDE,
                          .luminance = luminance,
                          .radius = radius};
    struct rf_surfaces out = {.width = width, .height = height, .share = share};
    struct rf_splitter s = {.keeps_radii = true,
                            .is_alone = is_alone,
                            .pixels = &p,
                            .out = &out,
                            .darkest = darkest,
                            .possible_highlights = possible_highlights,
                            .bright = bright};
    const struct rf_image mean = rf_image_input(means, width, height, 1);
    s.mean_depth = means ? &mean : NULL;
    rf_params_init(&params);
    params.split_edges = 1;
    params.projection = projection;
    params.f_stop = f_stop;
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &params, width, height, NULL) == RF_OK);
    s.frame = &filter->frame;
    fill_planes(&p);
    REQUIRE(rf_split_begin(&s, NULL) == RF_OK);
    for (int y = 0; y < height; y++)
        CHECK(rf_split_row(&s, y, 0));
    REQUIRE(rf_split_end(&s, NULL) == RF_OK);
    CHECK(out.near == near && !p.at);
    for (int i = 0; i < width * height; i++)
        CHECK(rf_split_radius_at(&p, i % width, i / width) == pixels[i].r);
    for (int i = 0; i < width * height; i++)
        if (share[i] < 1)
            far[i] = *rf_far_at(&out, (size_t)i);
    rf_split_free(&s);
    rf_free(context, p.split);
    rf_free(context, p.split_row);
    rf_far_free(&out, context);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

/* ---- fringes ------------------------------------------------------------------- */

static const float DARK = 0.01f, GREY = 0.4f, FRINGE = 0.5f, LAMP = 10;
static float around_r = 5; /* radius of all but the lamp */

/*
 * A pixel in the middle of 5 x 5, of which the picture has width x height, that is a
 * fringe of a lamp at their rim, if n_dark of the others let both stand out. Those of a
 * column, or of a row, are dark first.
 */
static bool is_fringe(int width, int height, int n_dark, int first, bool is_row)
{
    bool is_end = first == (is_row ? height : width) - 1;
    int lamp_x = is_end || is_row ? 0 : width - 1;
    int lamp_y = is_end || !is_row ? 0 : height - 1, n = 0;
    for (int i = 0; i < width * height; i++)
        put(width, i % width, i / width, GREY, around_r);
    for (int pass = 0; pass < 2; pass++)
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++) {
                bool is_first = (is_row ? y : x) == first;
                bool is_free = !(x == 2 && y == 2) && !(x == lamp_x && y == lamp_y);
                if (is_free && is_first == (pass == 0) && n < n_dark) {
                    put(width, x, y, DARK, around_r);
                    n++;
                }
            }
    put(width, 2, 2, FRINGE, around_r);
    put(width, lamp_x, lamp_y, LAMP, around_r - 10);
    split(width, height, 1e9f);
    return share[2 * width + 2] < 1;
}

/* More than a third of them, wherever they are. */
static void a_third_dark_pixels_make_a_fringe(void)
{
    for (int width = 3; width <= 5; width++)
        for (int height = 3; height <= 5; height++)
            for (int first = 0; first < rf_max_int(width, height); first++) {
                int third = width * height / 3;
                if (first < width) {
                    CHECK(is_fringe(width, height, third + 1, first, false));
                    CHECK(!is_fringe(width, height, third, first, false));
                }
                if (first < height) {
                    CHECK(is_fringe(width, height, third + 1, first, true));
                    CHECK(!is_fringe(width, height, third, first, true));
                }
            }
}

/* Of several views: their blur hides who has which share. */
static void fringes_far_before_the_focus_stay_whole(void)
{
    around_r = -7;
    CHECK(is_fringe(5, 5, 9, 0, false));
    around_r = -9;
    CHECK(!is_fringe(5, 5, 9, 0, false));
    is_alone = true;
    CHECK(is_fringe(5, 5, 9, 0, false));
    is_alone = false;
    around_r = 5;
}

/* ---- what may be a highlight ----------------------------------------------------- */

static bool is_bright(const struct rf_surface *s, float bright)
{
    return rf_luminance(s->c[0], s->c[1], s->c[2]) > bright;
}

/* Which part of a split pixel is bright, while the pixel is not. */
struct bright_parts {
    int n_near, n_far;
};

/* A lamp left of a mixed column, a wall right of it. */
static struct bright_parts split_edge_of(float lamp_r, float wall_r, float bright)
{
    enum { EDGE = 66 };
    struct bright_parts found = {0, 0};
    for (int i = 0; i < N; i++) {
        int x = i % MOST_W;
        bool is_lamp = x < EDGE && x > EDGE - 40;
        float v = x == EDGE ? 2 : is_lamp ? LAMP : 0.1f;
        put(MOST_W, x, i / MOST_W, v, is_lamp ? lamp_r : wall_r);
    }
    memset(possible_highlights, 0, sizeof possible_highlights);
    split(MOST_W, MOST_H, bright);
    for (int i = 0; i < N; i++) {
        int x = i % MOST_W;
        bool is_whole = is_bright(&pixels[i], bright);
        bool is_near = share[i] > 0 && is_bright(&near[i], bright);
        bool is_far = share[i] < 1 && is_bright(&far[i], bright);
        uint64_t bits = possible_highlights[i / MOST_W * ((MOST_W + 63) / 64) + x / 64];
        CHECK((bits >> x % 64 & 1) == (is_whole || is_near || is_far));
        found.n_near += is_near && !is_whole;
        found.n_far += is_far && !is_whole;
    }
    return found;
}

/* Its light is in one part, of which the pixel shows a fifth. */
static void parts_that_shine_are_noted(void)
{
    CHECK(split_edge_of(-5, 5, 4).n_near >= MOST_H);
    CHECK(split_edge_of(5, -5, 4).n_far >= MOST_H);
    struct bright_parts none = split_edge_of(-5, 5, 20);
    CHECK(none.n_near == 0 && none.n_far == 0);
}

/* ---- texture --------------------------------------------------------------------- */

/* Is a pixel whole that lies beside a dark thing, its depth that of a wall behind, its
 * colour between? The wall has stripes. */
static bool is_whole_beside(float stripe, bool is_lone)
{
    enum { EDGE = 30 };
    const int i = MOST_H / 2 * MOST_W + EDGE;
    for (int k = 0; k < N; k++) {
        bool is_wall = k % MOST_W >= EDGE, is_stripe = k / MOST_W / 2 % 2;
        float v = !is_wall ? 0.02f : is_stripe ? stripe : 0.5f;
        put(MOST_W, k % MOST_W, k / MOST_W, k == i ? 0.2f : v, is_wall ? 0 : -9);
    }
    is_alone = is_lone;
    split(MOST_W, MOST_H, 1e9f);
    is_alone = false;
    CHECK(share[i] > 0);
    return share[i] == 1;
}

/* It may be a dark stripe; several views know better. */
static void a_textured_surface_keeps_its_pixels(void)
{
    CHECK(is_whole_beside(0.02f, true));
    CHECK(is_whole_beside(0.15f, true));
    CHECK(!is_whole_beside(0.45f, true));
    CHECK(!is_whole_beside(0.5f, true));
    CHECK(!is_whole_beside(0.02f, false));
}

/* ---- thin things ----------------------------------------------------------------- */

/* Radius of the middle pixel of a wire before a wall, where the depth shows the wall;
 * INFINITY: it has been split. */
static float missed_radius(float wire, bool is_lone)
{
    for (int i = 0; i < N; i++) {
        bool is_wire = i % MOST_W == 30, is_missed = i / MOST_W == MOST_H / 2;
        put(MOST_W, i % MOST_W, i / MOST_W, is_wire ? wire : 0.5f,
            is_wire && !is_missed ? -9 : 0);
    }
    is_alone = is_lone;
    split(MOST_W, MOST_H, 1e9f);
    is_alone = false;
    int i = MOST_H / 2 * MOST_W + 30;
    return share[i] == 1 ? near[i].r : INFINITY;
}

/* It would stay sharp. Among views others show what is behind; a lamp may be farther.
 */
static void what_a_wire_fills_is_the_wire(void)
{
    CHECK(missed_radius(0.02f, true) == -9);
    CHECK(missed_radius(0.02f, false) == 0);
    CHECK(missed_radius(1.5f, true) == 0);
    CHECK(missed_radius(0.9f, true) == -9);
}

/* Its neighbours are to the right and below to the left. */
static void so_is_what_a_slanting_wire_fills(void)
{
    enum { Y = MOST_H / 2, AT = Y * MOST_W + 30 };
    for (int i = 0; i < N; i++) {
        int along = i % MOST_W - 30 + 2 * (i / MOST_W - Y);
        bool is_wire = along == 0 || along == 1;
        put(MOST_W, i % MOST_W, i / MOST_W, is_wire ? 0.02f : 0.5f,
            is_wire && i != AT ? -9 : 0);
    }
    is_alone = true;
    split(MOST_W, MOST_H, 1e9f);
    is_alone = false;
    CHECK(share[AT] == 1);
    CHECK_NEAR(near[AT].r, -9, 1e-5);
}

/* What is of its colour beside it is not. */
static void what_is_beside_a_wire_is_not_the_wire(void)
{
    enum { AT = MOST_H / 2 * MOST_W + 31 };
    for (int i = 0; i < N; i++) {
        bool is_wire = i % MOST_W == 30, is_dark = is_wire || i == AT;
        put(MOST_W, i % MOST_W, i / MOST_W, is_dark ? 0.02f : 0.5f, is_wire ? -9 : 0);
    }
    is_alone = true;
    split(MOST_W, MOST_H, 1e9f);
    is_alone = false;
    CHECK(share[AT] == 1 && near[AT].r == 0);
}

static float edge_colour = 0.5f;  /* between 0.4 and 0.8 */
static float lower_colour = 0.8f; /* of the far half, below the middle */
static float fog = 1; /* by which mean distances of whole pixels are nearer */

/* Share of the near half in the pixels of its edge, of whose colours it seems to have
 * 0.75; their mean distance is `mean`, their sample `own_z`. */
static float measured_share(double near_z, double far_z, double own_z, float mean)
{
    enum { WIDTH = 16, EDGE = 8 };
    static float z[N];
    struct rf_params params;
    struct rf_lens lens;
    rf_params_init(&params);
    params.projection = projection;
    params.f_stop = f_stop;
    CHECK(rf_lens_init(&lens, &params, WIDTH, MOST_H, NULL) == RF_OK);
    const float near_r = (float)rf_lens_radius_px(&lens, near_z);
    const float far_r = (float)rf_lens_radius_px(&lens, far_z);
    const float own_r = (float)rf_lens_radius_px(&lens, own_z);
    for (int i = 0; i < WIDTH * MOST_H; i++) {
        int x = i % WIDTH;
        put(WIDTH, x, i / WIDTH,
            x < EDGE                 ? 0.4f
            : x == EDGE              ? edge_colour
            : i / WIDTH > MOST_H / 2 ? lower_colour
                                     : 0.8f,
            x < EDGE    ? near_r
            : x == EDGE ? own_r
                        : far_r);
        z[i] = x == EDGE ? mean : fog * (float)(x < EDGE ? near_z : far_z);
    }
    means = z;
    split(WIDTH, MOST_H, INFINITY);
    means = NULL;
    return share[MOST_H / 2 * WIDTH + EDGE];
}

static void mean_distances_tell_shares(void)
{
    is_alone = true;
    CHECK_NEAR(measured_share(2, 8, 8, NAN), 0.75f, 1e-4);
    CHECK_NEAR(measured_share(2, 8, 8, 0.3f * 2 + 0.7f * 8), 0.3f, 1e-4);
    CHECK_NEAR(measured_share(2, 8, 9, 0.3f * 2 + 0.7f * 9), 0.3f, 1e-4); /* slanted */
    CHECK_NEAR(measured_share(2, INFINITY, INFINITY, 0.3f * 2), 0.3f, 1e-4);
    CHECK(measured_share(2, 8, 8, 7.99f) == 1);           /* of the far side alone */
    CHECK_NEAR(measured_share(2, 8, 8, 20), 0.75f, 1e-4); /* beyond both */
    CHECK_NEAR(measured_share(8, 8.01, 8.01, 8.004f), 1, 1e-4); /* one surface */
}

static void so_they_do_without_perspective(void)
{
    projection = RF_PROJECTION_ORTHOGRAPHIC;
    f_stop = 0.2;
    CHECK_NEAR(measured_share(2, 8, 8, 0.3f * 2 + 0.7f * 8), 0.3f, 1e-4);
    projection = RF_PROJECTION_PERSPECTIVE;
    f_stop = 0.1;
}

/* Where the far side has two colours, of one of which the pixel has 0.7; but not in fog,
 * where all means are too near. */
static void so_they_do_where_colours_say_whole(void)
{
    const float mean = 0.3f * 2 + 0.7f * 8;
    lower_colour = 0.2f;
    for (int i = 0; i < 2; i++) {
        edge_colour = 0.3f * 0.4f + 0.7f * (i ? 0.2f : 0.8f);
        is_alone = true;
        CHECK_NEAR(measured_share(2, 8, 8, mean), 0.3f, 1e-4);
        is_alone = false;
        CHECK_NEAR(measured_share(2, 8, 8, mean), 0.3f, 1e-4);
        CHECK_NEAR(measured_share(2, 8, 2, mean), 0.3f, 1e-4);
        CHECK(measured_share(2, 8, 8, NAN) == 1);
        fog = 0.85f;
        CHECK(measured_share(2, 8, 8, mean) == 1);
        fog = 1;
        edge_colour += i ? -0.05f : 0.05f; /* of neither colour */
        CHECK(measured_share(2, 8, 8, mean) == 1);
    }
    lower_colour = 3; /* a lamp's light is told by colours alone */
    edge_colour = 0.3f * 0.4f + 0.7f * 3;
    CHECK(measured_share(2, 8, 8, mean) == 1);
    edge_colour = 0.5f;
    lower_colour = 0.8f;
}

enum { OF_SHARES = -1 }; /* a mean */

/*
 * A dark thing at distance 2 covers 0.3 of the pixels of its edge; behind it are twigs as
 * dark at 8 and a bright sky, which hits nothing. Colours cannot tell thing and twigs apart.
 */
struct twigs {
    float twig;            /* of the pixel in the middle of the edge */
    float beside;          /* of the purest pixel of the sky */
    bool is_pure_below;    /* at the edge, below the middle, the sky alone is seen */
    float light;           /* times which all colours are taken */
    float mean;            /* of the middle; OF_SHARES: that of its shares */
    struct rf_surface far; /* what becomes of its far part */
};

static float share_before_twigs(struct twigs *t)
{
    enum { WIDTH = 16, EDGE = 8, MIDDLE = MOST_H / 2 };
    static float z[N];
    struct rf_params params;
    struct rf_lens lens;
    rf_params_init(&params);
    params.f_stop = f_stop;
    CHECK(rf_lens_init(&lens, &params, WIDTH, MOST_H, NULL) == RF_OK);
    const float near_r = (float)rf_lens_radius_px(&lens, 2);
    const float twig_r = (float)rf_lens_radius_px(&lens, 8);
    const float sky_r = (float)rf_lens_radius_px(&lens, INFINITY);
    for (int i = 0; i < WIDTH * MOST_H; i++) {
        int x = i % WIDTH, y = i / WIDTH;
        bool is_pure = t->is_pure_below && x == EDGE && y == MIDDLE + 1;
        float near_part = x < EDGE ? 1 : x == EDGE && !is_pure ? 0.3f : 0;
        float twig = near_part == 1 || is_pure ? 0
                     : y < MIDDLE              ? 1 - near_part
                     : y == MIDDLE             ? t->twig
                     : x == EDGE               ? 0.4f
                     : x == EDGE + 1           ? t->beside
                                               : t->beside + 0.1f;
        float sky = 1 - near_part - twig;
        put(WIDTH, x, y, t->light * (0.1f * (near_part + twig) + 1.3f * sky),
            near_part == 1 ? near_r
            : y < MIDDLE   ? twig_r
                           : sky_r);
        z[i] = near_part * 2 + twig * 8;
    }
    if (t->mean != OF_SHARES)
        z[MIDDLE * WIDTH + EDGE] = t->mean;
    means = z;
    split(WIDTH, MOST_H, INFINITY);
    means = NULL;
    t->far = far[MIDDLE * WIDTH + EDGE];
    return share[MIDDLE * WIDTH + EDGE];
}

static void so_they_do_where_a_twig_is_before_the_sky(void)
{
    for (int i = 0; i < 2; i++) {
        is_alone = i > 0;
        for (int k = 1; k < 4; k++) {
            struct twigs t = {.twig = 0.15f * (float)k, .light = 1, .mean = OF_SHARES};
            float twig = t.twig / 0.7f, seen = 0.1f * twig + 1.3f * (1 - twig);
            CHECK_NEAR(share_before_twigs(&t), 0.3f, 1e-3);
            CHECK_NEAR(t.far.c[1], seen, 0.01f);
            t.beside = 0.2f; /* no pixel shows the sky alone */
            CHECK_NEAR(share_before_twigs(&t), 0.3f, 1e-3);
            CHECK_NEAR(t.far.c[1], seen, 0.01f);
        }
    }
    is_alone = false;
}

/* The sky's colour is taken from no pixel of which a twig has more than a quarter, and a
 * mean that no three such shares have is left to the colours. */
static void what_no_three_shares_have_is_left_to_colours(void)
{
    struct twigs t = {.twig = 0.3f, .beside = 0.3f, .light = 1, .mean = OF_SHARES};
    CHECK(fabsf(share_before_twigs(&t) - 0.3f) > 0.05f);
    struct twigs beyond = {.twig = 0.2f, .light = 1, .mean = 9};
    struct twigs unknown = {.twig = 0.2f, .light = 1, .mean = NAN};
    const float by_colour = share_before_twigs(&unknown);
    CHECK(share_before_twigs(&beyond) == by_colour);
    /* Nor are three told where squares of colours overflow. */
    struct twigs lit = {.twig = 0.2f, .light = 5, .mean = NAN};
    struct twigs blinding = {.twig = 0.2f, .light = 1e25f, .mean = OF_SHARES};
    CHECK_NEAR(share_before_twigs(&blinding), share_before_twigs(&lit), 1e-4);
}

/* Between twigs a pixel that shows the sky alone counts, but no fringe of a lamp does. */
static void what_shows_the_sky_alone_counts(void)
{
    struct twigs t = {.twig = 0.2f, .beside = 0.2f, .light = 1, .mean = NAN};
    const float by_colour = share_before_twigs(&t);
    t.is_pure_below = true;
    const float with_pure = share_before_twigs(&t);
    CHECK(with_pure > by_colour + 0.02f);
    t.light = 5;
    CHECK(share_before_twigs(&t) < with_pure - 0.02f);
}

/* A dark bush before a bright sky, and before the bush a wall's edge: a pixel whose depth
 * is the sky's shows no bush. Of several views. */
static void of_two_surfaces_behind_the_pixels_own_counts(void)
{
    enum { WIDTH = 16, EDGE = 8, MIDDLE = MOST_H / 2 };
    for (int i = 0; i < WIDTH * MOST_H; i++) {
        bool is_sky = i / WIDTH >= MIDDLE;
        put(WIDTH, i % WIDTH, i / WIDTH, is_sky ? 0.8f : 0.05f, is_sky ? 9 : 4);
        if (i % WIDTH < EDGE)
            put(WIDTH, i % WIDTH, i / WIDTH, 0.02f, -9);
    }
    put(WIDTH, EDGE, MIDDLE, 0.41f, 9);
    split(WIDTH, MOST_H, INFINITY);
    CHECK_NEAR(share[MIDDLE * WIDTH + EDGE], 0.5f, 1e-3);
    put(WIDTH, EDGE, MIDDLE, 0.04f, 4);
    split(WIDTH, MOST_H, INFINITY);
    CHECK_NEAR(share[MIDDLE * WIDTH + EDGE], 1.0f / 3, 1e-3);
    is_alone = true; /* a lone view takes the mean of both */
    split(WIDTH, MOST_H, INFINITY);
    is_alone = false;
    CHECK(fabsf(share[MIDDLE * WIDTH + EDGE] - 1.0f / 3) > 0.1f);
}

/* Share of the near half in the pixels of its edge, halves of both colours. */
static float edge_share(float near_r, float far_r, float light, bool is_lone)
{
    enum { WIDTH = 16, EDGE = 8, MIDDLE = MOST_H / 2 };
    for (int i = 0; i < WIDTH * MOST_H; i++) {
        int x = i % WIDTH;
        put(WIDTH, x, i / WIDTH,
            light * (x < EDGE   ? 0.2f
                     : x > EDGE ? 0.8f
                                : 0.5f),
            x < EDGE ? near_r : far_r);
    }
    is_alone = is_lone;
    split(WIDTH, MOST_H, INFINITY);
    is_alone = false;
    return share[MIDDLE * WIDTH + EDGE];
}

/* Near parts, and such as differ by less than they are blurred: of several views. */
static void blurred_parts_stay_whole(void)
{
    CHECK(edge_share(-20, -9, 1, false) == 1);
    CHECK(edge_share(-20, -9, 5, false) == 1);
    CHECK_NEAR(edge_share(-20, -9, 1, true), 0.5f, 1e-3);
    CHECK_NEAR(edge_share(-20, -3, 1, false), 0.5f, 1e-3);
    CHECK(edge_share(20, 26, 1, false) == 1);
    CHECK_NEAR(edge_share(20, 26, 5, false), 0.5f, 1e-3);
    CHECK_NEAR(edge_share(20, 26, 1, true), 0.5f, 1e-3);
    CHECK_NEAR(edge_share(4, 9, 1, false), 0.5f, 1e-3);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_third_dark_pixels_make_a_fringe);
    TEST(fringes_far_before_the_focus_stay_whole);
    TEST(parts_that_shine_are_noted);
    TEST(a_textured_surface_keeps_its_pixels);
    TEST(what_a_wire_fills_is_the_wire);
    TEST(so_is_what_a_slanting_wire_fills);
    TEST(what_is_beside_a_wire_is_not_the_wire);
    TEST(mean_distances_tell_shares);
    TEST(so_they_do_without_perspective);
    TEST(so_they_do_where_colours_say_whole);
    TEST(so_they_do_where_a_twig_is_before_the_sky);
    TEST(what_no_three_shares_have_is_left_to_colours);
    TEST(what_shows_the_sky_alone_counts);
    TEST(of_two_surfaces_behind_the_pixels_own_counts);
    TEST(blurred_parts_stay_whole);
    return testing_end();
}
