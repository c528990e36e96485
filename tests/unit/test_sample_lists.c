/* SPDX-License-Identifier: Apache-2.0 */
/* The lists of tiles: a source's pixels are listed as samples of an array are. */
#include "api/filter.h"
#include "base/context.h"
#include "base/math.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/composer.h"
#include "compose/footprint.h"
#include "compose/levels.h"
#include "compose/sample_lists.h"
#include "compose/scene.h"
#include "input/frame.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "testing.h"

enum { WIDTH = 150, HEIGHT = 70, N = WIDTH * HEIGHT };

/* Surfaces, of which pixels `other_every` apart emit theirs as samples. */
static struct rf_surface surfaces[N];
static struct rf_sample samples[N];
static float radii[N];
static int other_every;
static double aperture_ratio;

static struct rf_sample sample_at(int x, int y)
{
    const struct rf_surface *s = &surfaces[y * WIDTH + x];
    struct rf_sample p = {
        .x = (float)x + 0.5f, .y = (float)y + 0.5f, .r = s->r, .w = 1};
    memcpy(p.c, s->c, sizeof p.c);
    return p;
}

static struct rf_emission emission(void *user, int x, int y, int n)
{
    (void)user;
    struct rf_emission e = {0, 0};
    for (int i = 0; i < n; i++)
        if (other_every && (y * WIDTH + x + i) % other_every == 0)
            e.other |= (uint64_t)1 << i;
        else
            e.plain |= (uint64_t)1 << i;
    return e;
}

static int emit(void *user, int x, int y, struct rf_sample *at)
{
    (void)user;
    *at = sample_at(x, y);
    return 1;
}

/* Radii that rise in steps, three pixels wide, and fall again. */
static void fill(float largest, float step)
{
    int rise = (int)(2 * largest / step);
    for (int i = 0; i < N; i++) {
        int k = (i / 3 + i / WIDTH * 7) % (2 * rise), up = k < rise ? k : 2 * rise - k;
        for (int n = 0; n < 4; n++)
            surfaces[i].c[n] = (float)(1 + (i * 7 + n * 3) % 11);
        surfaces[i].r = radii[i] = (float)up * step - largest;
        samples[i] = sample_at(i % WIDTH, i / WIDTH);
    }
}

enum { MOST_SPLATS = 8 * RF_TILE_W * RF_TILE_H };

/* The splats of bin k of a list, which may be one of places; returns how many. */
static int splats_of(const struct rf_tile_list *list, int k, struct rf_splat *out)
{
    int n = 0;
    for (int i = list->bin[k]; i < list->bin[k + 1]; i++) {
        if (!list->places) {
            out[n++] = list->at[i];
            continue;
        }
        int n_place = rf_max_int(rf_packed_n(list->places[i]), 1);
        for (int m = 0; m < n_place; m++)
            out[n++] = rf_packed_splat(&list->surfaces, list->places[i], m);
    }
    return n;
}

static bool is_same_list(const struct rf_group *g, const struct rf_tile_list *a,
                         const struct rf_tile_list *b)
{
    static struct rf_splat p[MOST_SPLATS], q[MOST_SPLATS];
    if (a->n == 0 || b->n == 0)
        return a->n == b->n;
    for (int k = 0; k < g->n_bins; k++) {
        int n = splats_of(a, k, p);
        if (n != splats_of(b, k, q) || memcmp(p, q, (size_t)n * sizeof *p) != 0)
            return false;
    }
    return true;
}

static void compare(const struct rf_groups *a, const struct rf_groups *b)
{
    REQUIRE(a->n == b->n);
    for (int k = 0; k < a->n; k++) {
        const struct rf_group *g = &a->at[k];
        int n = 0, n_same = 0;
        for (int i = 0; i < g->n_x * g->n_y; i++) {
            n += g->tiles[i].n;
            n_same += is_same_list(g, &g->tiles[i], &b->at[k].tiles[i]);
        }
        CHECK(n > 0 && n_same == g->n_x * g->n_y);
    }
}

/* Lists of the surfaces from a source, their radii at hand or not, and an array. */
static void check_lists(float largest, bool has_radii)
{
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_task task = {.last = -1};
    struct rf_scene scene = {.width = WIDTH, .height = HEIGHT, .task = &task};
    struct rf_footprints footprints;
    rf_params_init(&params);
    params.aperture_ratio = aperture_ratio;
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &params, WIDTH, HEIGHT, NULL) == RF_OK);
    struct rf_composer c = {.scene = &scene,
                            .context = context,
                            .footprints = &footprints,
                            .levels = rf_levels_of(&filter->frame.shape),
                            .n_threads = context->n_threads};
    const struct rf_footprint_use use = {.shape = &filter->frame.shape,
                                         .n_cells = 1,
                                         .max_radius = rf_levels_most(&c.levels) + 1,
                                         .n_phases = 1};
    REQUIRE(rf_footprints_init(&footprints, context, &use, NULL) == RF_OK);
    const struct rf_source source = {.emission = emission,
                                     .emit = emit,
                                     .surfaces = surfaces,
                                     .radius = has_radii ? radii : NULL,
                                     .radius_stride = WIDTH,
                                     .most_per_pixel = 1,
                                     .largest_radius = largest};
    const struct rf_source none = {.emission = NULL};
    const struct rf_samples all = {samples, N}, nothing = {NULL, 0};
    struct rf_groups from_source = {.n = 0}, from_array = {.n = 0};
    REQUIRE(rf_groups_build(&from_source, &c, &nothing, &source, 1, NULL) == RF_OK);
    rf_free(context, c.needed);
    REQUIRE(rf_groups_build(&from_array, &c, &all, &none, 1, NULL) == RF_OK);
    rf_free(context, c.needed);
    compare(&from_source, &from_array);
    rf_groups_free(&from_array, context);
    rf_groups_free(&from_source, context);
    rf_footprints_free(&footprints);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

/* Rows of them pass the limits of bins and levels, on them and between them. */
static void check_steps(void)
{
    static const float steps[] = {0.0625f, 0.3f, 1, 2};
    for (int i = 0; i < 4; i++) {
        fill(40, steps[i]);
        check_lists(40, true);
        check_lists(40, false);
    }
}

static void runs_of_pixels_end_with_their_bin(void)
{
    aperture_ratio = 1;
    other_every = 0;
    check_steps();
}

/* For a wide lens that is not where a bin does. */
static void and_with_their_level(void)
{
    aperture_ratio = 0.7;
    other_every = 0;
    check_steps();
}

static void and_at_pixels_with_samples_of_their_own(void)
{
    aperture_ratio = 1;
    other_every = 7;
    check_steps();
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(runs_of_pixels_end_with_their_bin);
    TEST(and_with_their_level);
    TEST(and_at_pixels_with_samples_of_their_own);
    return testing_end();
}
