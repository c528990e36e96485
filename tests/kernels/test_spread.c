/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What spreading leaves, however samples are told: as splats, places or runs of them,
 * cut or whole, with mirrored footprints or others.
 */
#include "../testing.h"

#include "kernel_calls.h"

static struct workspace first, other;

/* What a splat leaves does not depend on how it is told. */
static void places_spread_as_splats_do(void)
{
    static struct rf_splat splats[N_SPLATS];
    static struct rf_surface surfaces[32 * 64];
    static rf_packed places[N_SPLATS];
    const struct rf_tile_surfaces tile = {surfaces + 5, -5, 64, given.splats, 100, 50};
    const struct rf_kernels *k = rf_kernels_at(0);
    for (int i = 0; i < N_SPLATS; i++) {
        int x = 2 + i % 16 / 4 * 14 + i % 4, y = 3 + i / 16 * 5;
        int slot = i / 7 % N_FOOTPRINTS;
        bool is_other = i % 13 == 4;
        struct rf_surface *at = &surfaces[64 * y + x];
        *at = (struct rf_surface){{noise(), noise(), noise(), noise()}, noise()};
        int slant = i % 5 ? 0 : 3 * i - RF_MOST_SLANT;
        splats[i] = (struct rf_splat){
            .x = 100 + x, .y = 50 + y, .slant = slant, .slot = slot, .cover = 1};
        memcpy(splats[i].c, at->c, sizeof at->c);
        if (is_other) {
            splats[i].slant = given.splats[i].slant;
            splats[i].cover = given.splats[i].cover;
            memcpy(splats[i].c, given.splats[i].c, sizeof splats[i].c);
        }
        places[i] =
            rf_packed_make(slot, x, y, is_other ? i + 1 : rf_packed_run(1, slant));
    }
    for (int i = 0; i < 6; i++) { /* a tile to the left, about them, to the right */
        int n_planes = 4 + i % 2, x0 = (const int[]){40, 90, 127}[i / 2];
        memset(&first, 0, sizeof first);
        memset(&other, 0, sizeof other);
        k->spread(make_accumulator(&first, n_planes), splats, N_SPLATS, given.pointers,
                  x0, 48);
        k->spread_places(make_accumulator(&other, n_planes), places, N_SPLATS, &tile,
                         given.pointers, x0, 48);
        /* The rest of a run is spread in other groups. */
        for (int n = 0; n < ACC_FLOATS; n++)
            CHECK_NEAR(first.at[n], other.at[n], 1e-5 + 1e-5 * fabsf(first.at[n]));
    }
}

enum { N_RUN = 33, RUN_X = 20, N_SHORT = 7 /* no convolution */ };

/* Row of the tile that the runs are in. */
static int run_y = 10;

/* Spreads a part of a run of one footprint over the tile from column x0 on, as splats
 * or as one place. */
static void spread_run_at(struct workspace *w, int x0, int slot, int start, int end,
                          bool as_place)
{
    static struct rf_surface surfaces[32 * 64];
    const struct rf_tile_surfaces tile = {surfaces, 0, 64, given.splats, 100, 50};
    struct rf_splat splats[N_RUN];
    int n = end - start, slant = slot % 2 ? 70 * slot - 100 : 0; /* the others mirror */
    memset(w, 0, sizeof *w);
    for (int i = 0; i < n; i++) {
        int x = RUN_X + start + i;
        struct rf_surface *at = &surfaces[64 * 10 + x];
        memcpy(at->c, given.splats[start + i].c, sizeof at->c);
        splats[i] = (struct rf_splat){
            .x = 100 + x, .y = 50 + 10, .slant = slant, .slot = slot, .cover = 1};
        memcpy(splats[i].c, at->c, sizeof at->c);
    }
    const rf_packed place =
        rf_packed_make(slot, RUN_X + start, 10, rf_packed_run(n, slant));
    struct rf_spread_sums *acc = make_accumulator(w, 5);
    const struct rf_kernels *k = rf_kernels_at(0);
    if (as_place)
        k->spread_places(acc, &place, 1, &tile, given.pointers, x0, 60 - run_y);
    else
        k->spread(acc, splats, n, given.pointers, x0, 60 - run_y);
}

static void spread_run(struct workspace *w, int slot, int start, int end, bool as_place)
{
    spread_run_at(w, 100, slot, start, end, as_place);
}

/* Have both the same bits in the columns from x to end - 1, and something there? */
static bool are_same_columns(int x, int end)
{
    int n = 0;
    for (int a = 0; a < ACC_FLOATS; a++) {
        int column = a % RF_ACC_STRIDE - RF_ACC_LEFT;
        if (column < x || column >= end)
            continue;
        n += first.at[a] != 0;
        if (memcmp(&first.at[a], &other.at[a], sizeof(float)) != 0)
            return false;
    }
    return n > 0;
}

/* So windows have the bits of the whole, whose runs may be longer. */
static void splats_that_do_not_reach_do_not_matter(void)
{
    for (int i = 0; i < 2 * N_FOOTPRINTS * (N_RUN - N_SHORT); i++) {
        int slot = i / 2 % N_FOOTPRINTS, n = N_RUN - i / 2 / N_FOOTPRINTS;
        const struct rf_footprint *f = given.pointers[slot];
        spread_run(&first, slot, 0, N_RUN, i % 2);
        spread_run(&other, slot, 0, n, i % 2);
        CHECK(are_same_columns(RUN_X + f->min_dx,
                               n < N_RUN ? RUN_X + n + f->min_dx : RF_TILE_W));
        int from = RUN_X + N_RUN - n; /* one that begins later */
        spread_run(&other, slot, N_RUN - n, N_RUN, i % 2);
        CHECK(from + f->max_dx >= RF_TILE_W ||
              are_same_columns(from + f->max_dx, RF_TILE_W));
    }
}

static void check_near(void)
{
    for (int i = 0; i < ACC_FLOATS; i++)
        CHECK_NEAR(first.at[i], other.at[i], 1e-5 + 1e-5 * fabsf(first.at[i]));
}

/* Convolutions are the sums of what is spread one by one. */
static void long_runs_are_as_many_short_ones(void)
{
    static struct workspace one;
    for (int i = 0; i < 2 * N_FOOTPRINTS; i++)
        for (int n = N_SHORT; n <= N_RUN; n += 2) {
            spread_run(&first, i / 2, 0, n, i % 2);
            memset(&other, 0, sizeof other);
            for (int k = 0; k < n; k++) {
                spread_run(&one, i / 2, k, k + 1, i % 2);
                for (int a = 0; a < ACC_FLOATS; a++)
                    other.at[a] += one.at[a];
            }
            check_near();
        }
}

/* Of a run that begins before the tile or ends after it the part that reaches counts.
 */
static void runs_are_cut_where_the_tile_ends(void)
{
    for (int i = 0; i < 16 * N_FOOTPRINTS; i++) {
        int x0 = 100 + 8 * (i % 16) - 60, slot = i / 16; /* the run at 80 to -40 */
        spread_run_at(&first, x0, slot, 0, N_RUN, false);
        spread_run_at(&other, x0, slot, 0, N_RUN, true);
        check_near();
        CHECK(first.acc.first_row == other.acc.first_row &&
              first.acc.last_row == other.acc.last_row);
    }
}

/* A whole tile of runs, over itself and the tiles around it. */
static void places_of_runs_spread_as_their_splats_do(void)
{
    static struct rf_surface surfaces[RF_TILE_H * RF_TILE_W];
    static struct rf_splat splats[RF_TILE_H * RF_TILE_W];
    static rf_packed places[RF_TILE_H * RF_TILE_W];
    const struct rf_tile_surfaces tile = {surfaces, 0, RF_TILE_W, NULL, 64, 32};
    const struct rf_kernels *k = rf_kernels_at(0);
    int n_places = 0, n_splats = 0;
    seed = 11;
    for (int y = 0; y < RF_TILE_H; y++)
        for (int x = 0, n; x < RF_TILE_W; x += n, n_places++) {
            n = rf_min_int(1 + (int)(noise() * 40), RF_TILE_W - x);
            int slot = n_places % N_FOOTPRINTS;
            places[n_places] = rf_packed_make(
                slot, x, y, rf_packed_run(n, slot % 2 ? n_places % 400 - 200 : 0));
            for (int i = x; i < x + n; i++) {
                struct rf_surface *at = &surfaces[y * RF_TILE_W + i];
                *at = (struct rf_surface){{noise(), noise(), noise(), 1}, 0};
                splats[n_splats++] = rf_packed_splat(&tile, places[n_places], i - x);
            }
        }
    for (int i = 0; i < 9; i++) {
        int x0 = 64 * (i % 3), y0 = 32 * (i / 3);
        memset(&first, 0, sizeof first);
        memset(&other, 0, sizeof other);
        k->spread(make_accumulator(&first, 4), splats, n_splats, given.pointers, x0,
                  y0);
        k->spread_places(make_accumulator(&other, 4), places, n_places, &tile,
                         given.pointers, x0, y0);
        check_near();
        CHECK(first.acc.last_row >= 0 && first.acc.last_row == other.acc.last_row);
    }
}

/* What is known of a footprint's weights does not change what it leaves, also where
 * rows, or all that mirror others, are beyond the tile. */
static void mirrored_footprints_spread_as_others_do(void)
{
    static const int ROWS[] = {-2, 4, 10, 16, 29, 33};
    for (int i = 0; i < 2 * 6 * N_FOOTPRINTS; i++) {
        int slot = i / 2 % N_FOOTPRINTS;
        run_y = ROWS[i / 2 / N_FOOTPRINTS];
        struct rf_footprint *f = &given.footprints[slot], kept = *f;
        spread_run(&first, slot, 0, N_SHORT, i % 2);
        f->is_even = false;
        f->n_mirrored = 0;
        spread_run(&other, slot, 0, N_SHORT, i % 2);
        CHECK(memcmp(first.at, other.at, sizeof first.at) == 0);
        *f = kept;
        spread_run(&first, slot, 0, N_RUN, i % 2);
        f->is_even = false;
        spread_run(&other, slot, 0, N_RUN, i % 2);
        *f = kept;
        check_near();
    }
    run_y = 10;
}

int main(int argc, char **argv)
{
    make_given();
    testing_begin(argc, argv);
    TEST(places_spread_as_splats_do);
    TEST(splats_that_do_not_reach_do_not_matter);
    TEST(long_runs_are_as_many_short_ones);
    TEST(runs_are_cut_where_the_tile_ends);
    TEST(places_of_runs_spread_as_their_splats_do);
    TEST(mirrored_footprints_spread_as_others_do);
    return testing_end();
}
