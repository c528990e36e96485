/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Slopes of the radius, rounded; part of kernels_tmpl.c. compose/slants.h says what
 * for.
 */
#include "kernels/kernels.h"
#include "kernels/vector.h"

typedef int16_t vs __attribute__((vector_size(16), aligned(2)));

/*
 * Two differences in turn are of one slope if they differ by less than ALIKE of the
 * larger and SLACK px, and that is below MOST px. Ours; ALIKE 0.25 and 1, SLACK 0.1:
 * within 0.05 dB. MOST: 0.25 loses 0.4 dB on a house, 0.7 on a bridge.
 */
#define SLANT_ALIKE SPLAT(0.5f)
#define SLANT_SLACK SPLAT(0.02f)
#define SLANT_MOST SPLAT(1)

/* A slope between two differences, where there is one; how much they differ. */
struct slope {
    vf mean, apart;
    vi is_one;
};

static inline __attribute__((always_inline)) struct slope slope_between(vf a, vf b)
{
    vf larger = vmax(vabs(a), vabs(b)), apart = vabs(a - b);
    return (struct slope){(a + b) * SPLAT(0.5f), apart,
                          (apart < larger * SLANT_ALIKE + SLANT_SLACK) &
                              (larger < SLANT_MOST)};
}

/*
 * The slope across the third of five radii or, where an edge passes beside it, on one
 * side of it; 0: there is none. Four differences of them.
 */
static inline __attribute__((always_inline)) vf slope_at(const vf d[4])
{
    const struct slope before = slope_between(d[0], d[1]);
    const struct slope across = slope_between(d[1], d[2]);
    const struct slope behind = slope_between(d[2], d[3]);
    vi is_behind = behind.is_one & (~before.is_one | (behind.apart < before.apart));
    vf one_sided =
        choose(is_behind, behind.mean, choose(before.is_one, before.mean, SPLAT(0)));
    return choose(across.is_one, across.mean, one_sided);
}

/* In steps, finer where it is small. */
static inline __attribute__((always_inline)) vi slope_steps(vf g)
{
    const vf whole = SPLAT(12582912); /* adding it rounds */
    vf t = g / (SPLAT(RF_SLANT_HALF) + vabs(g)) * SPLAT(1 / RF_SLANT_STEP);
    return (vi)(t + whole) - (vi)whole;
}

/* Eight slants from the differences along x and y; 0 of slopes of `least` and less. */
static inline __attribute__((always_inline)) vi slants_of(vf d[2][4], vf least)
{
    vf most = vabs(d[0][0]);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 4; i++)
            most = vmax(most, vabs(d[k][i]));
    if (!lane_bits(most > least))
        return (vi){0};
    vf right = slope_at(d[0]), down = slope_at(d[1]);
    vi is_slanted = vmax(vabs(right), vabs(down)) > least;
    return is_slanted & (slope_steps(down) * RF_SLANT_ROW + slope_steps(right));
}

/*
 * Radii of m pixels from x on in each of the five rows and of each of the five columns.
 */
static inline __attribute__((always_inline)) void
radius_steps(const float *const rows[5], int x, int m, vf d[2][4])
{
    vf r[2][5];
    for (int i = 0; i < 5; i++) {
        const float *column = rows[2] + x + i - 2, *row = rows[i] + x;
        r[0][i] = m < LANES ? load_part(column, m) : LOAD(column);
        r[1][i] = m < LANES ? load_part(row, m) : LOAD(row);
    }
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 4; i++)
            d[k][i] = r[k][i + 1] - r[k][i];
}

static bool find_slants(const float *const rows[5], float least, int n, int16_t *out)
{
    vi any = {0};
    for (int x = 0; x < n; x += LANES) {
        vf d[2][4];
        radius_steps(rows, x, n - x, d);
        vi found = slants_of(d, SPLAT(least));
        vs part = __builtin_convertvector(found, vs);
        memcpy(out + x, &part, sizeof part);
        any |= found;
    }
    return lane_bits(any != 0) != 0;
}
