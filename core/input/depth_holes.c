/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depth with holes where a volume was: a renderer that takes the depth of a pixel's first
 * sample (Cycles) has none where that sample is scattered by fog, although a surface lies
 * behind. Such pixels would be blurred like the sky.
 *
 * Measuring. In a row, a pixel between two of one surface is of this surface or a hole.
 * With h holes among the n pixels of this kind in a square of 32 x 32 px, what lies
 * above a hole is a hole, too, in a share of
 *
 *   q = sum h^2 / n / sum h      where chance throws them, as in fog
 *
 * Gaps before a sky go on from row to row: leaves have 2 to 25 q, gaps of meshes none or
 * all. Fog has 0.8 to 1.0 q. And holes of fog show what is beside them, while gaps show
 * the sky: with c the colour of a hole, m that of the pixels beside it and s that of all
 * where 5 px in a row have no depth,
 *
 *   f = sum (c - m) . (s - m) / sum |s - m|^2
 *
 * which is 0.01 in fog (64 samples; 0.12 with 8), and 0.2 to 1.5 of leaves of a pixel or
 * two, hair and fine wires. Where |s - m| is small it does not matter which is which.
 *
 * Filling. Of the pixels q around a hole p, weighted by colour and distance,
 *
 *   w(q) = 1 / |p - q|^2  0.01 / (0.01 + |c(p) - c(q)|^2)
 *
 * a tenth must have depth, and on every side one, else it is the sky beside a surface.
 * The hole gets the depth that most of w agrees on, the mean of 1/z, which is linear on
 * a plane. Colours are square roots of light up to 1.
 *
 * Ours. Against Cycles' own lens, one view and 8: cubes in thin fog 27.3 to 37.4 and 34.9
 * to 43.6 dB (without fog 37.0 and 46.7), in fog three times as dense 27.2 to 37.0 and
 * 34.9 to 40.8. docs/notebook/depth.md has more. Cost: measuring 1.4 ns per
 * pixel, filling 0.5 us per hole, 0.3 where no surface is around.
 */
#include "input/depth_holes.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "input/depth_steps.h"
#include "input/image.h"
#include "rackfocus/rackfocus.h"

/* Depths of one surface differ by less than this factor. */
static const float SAME = 1.1f;

/* Of |c(p) - c(q)|^2: what counts half. 0.003 to 0.03 differ by 0.1 dB with one view;
 * with 8 views 0.003 loses 0.9. */
static const float UNLIKE = 0.01f;

/* Of w: 0.05 to 0.15 differ by 0.1 dB, 0.3 loses 0.5 to 2.6. */
static const float LEAST_SHARE = 0.1f;

/* Rings of pixels are looked at up to this one, then until so many have depth: 3 loses
 * 0.5 dB, 6 0.2. */
enum { FIRST_RING = 2, ENOUGH = 12 };

enum {
    PLACE_PX = 32,
    FEWEST_OF_PLACE = 64, /* pixels of surfaces, else a place tells nothing */
    SKY_PX = 5            /* without depth in a row: fog of 0.5 leaves 3 % so */
};

/* Places that tell something: fewer are wires or a small thing, not a surface. */
enum { FEWEST_PLACES = 4 };

/* Of pixels of surfaces; of places that have a hole. The thinnest fog that is seen in a
 * picture (0.3 dB) has 0.02; a tree that stands in a corner is no fog. */
static const double LEAST_HOLES = 0.02, LEAST_PLACES = 0.75;

/* Of q, beside two and three standard deviations of chance: holes of a plate are as rare
 * above holes as they are in thin fog. */
static const double LEAST_PAIRS = 0.5, MOST_PAIRS = 1.5;

/* f, where the sky is so unlike what is before it that it is seen: |s - m|^2. */
static const double MOST_SKY = 0.15, SEEN_SKY = 0.03;

/* Mean of |c - m|^2: 0.001 to 0.004 in fog, 0.015 with 6 samples; white before black
 * is 3. */
static const double MOST_UNLIKE = 0.05;

enum { NO_SURFACE, SURFACE, HOLE };

struct place {
    uint32_t n_surface, n_holes;
};

struct tone {
    float c[3];
};

/* Sums of what f is made of, with the sky unknown until the end. */
struct colour_sums {
    double change[3], mean[3]; /* c - m, m */
    double change_change, change_mean, mean_mean;
    double sky[3];
    size_t n_sky, n_holes;
};

struct rf_hole_count {
    const struct rf_context *context;
    int32_t width, n_places;
    float infinity;
    int64_t n_rows;
    uint8_t *above, *here; /* SURFACE, HOLE: of the row before, of this one */
    struct place *places;
    size_t n_surface, n_holes;
    size_t n_pairs, n_both;    /* holes below a surface or a hole; below a hole */
    size_t n_wide, n_speckled; /* places that tell something; those with a hole */
    double expected;           /* sum h^2 / n */
    struct colour_sums sums;
};

static bool is_hit(float z, float infinity)
{
    return z > 0 && z < infinity;
}

static struct tone tone_at(const struct rf_image *colour, int32_t x, int32_t y)
{
    struct tone tone;
    for (int i = 0; i < 3; i++) {
        const float light = *rf_image_at(colour, x, y, colour->channels >= 3 ? i : 0);
        tone.c[i] = sqrtf(fminf(fmaxf(light, 0), 1));
    }
    return tone;
}

/* ---- measuring ------------------------------------------------------------------- */

struct rf_hole_count *rf_hole_count_create(const struct rf_context *context,
                                           int32_t width, double infinity)
{
    const size_t n = (size_t)width, n_places = n / PLACE_PX + 1;
    const size_t n_bytes =
        sizeof(struct rf_hole_count) + n_places * sizeof(struct place) + 2 * n;
    struct rf_hole_count *count = rf_depth_take(context, 1, n_bytes);
    if (!count)
        return NULL;
    memset(count, 0, n_bytes);
    count->context = context;
    count->width = width;
    count->n_places = (int32_t)n_places;
    count->infinity = (float)infinity;
    count->places = (struct place *)(count + 1);
    count->above = (uint8_t *)(count->places + n_places);
    count->here = count->above + n;
    return count;
}

/* Without branches, so that compilers vectorise it. */
static void classify(const float *row, int32_t width, float infinity, uint8_t *what)
{
    for (int32_t x = 1; x + 1 < width; x++) {
        const float a = row[x - 1], z = row[x], b = row[x + 1];
        const bool is_between = (a > 0) & (b > 0) & (a < infinity) & (b < infinity) &
                                (a <= SAME * b) & (b <= SAME * a);
        const bool is_known = (z > 0) & (z < infinity);
        const bool is_same = (z <= SAME * a) & (a <= SAME * z);
        const bool is_hole = (z >= infinity) | (z == 0);
        what[x] =
            (uint8_t)(is_between * (is_known * is_same * SURFACE + is_hole * HOLE));
    }
}

static void add_hole(struct colour_sums *sums, const struct rf_image *colour, int32_t x,
                     int32_t y)
{
    const struct tone a = tone_at(colour, x - 1, y), c = tone_at(colour, x, y);
    const struct tone b = tone_at(colour, x + 1, y);
    for (int i = 0; i < 3; i++) {
        const double mean = (double)(a.c[i] + b.c[i]) / 2;
        const double change = (double)c.c[i] - mean;
        sums->change[i] += change;
        sums->mean[i] += mean;
        sums->change_change += change * change;
        sums->change_mean += change * mean;
        sums->mean_mean += mean * mean;
    }
    sums->n_holes++;
}

/* The colours of a row that has holes. */
static void add_colours(struct rf_hole_count *count, const float *row,
                        const struct rf_image *colour, int32_t y)
{
    struct colour_sums *sums = &count->sums;
    int n_without = 0;
    for (int32_t x = 0; x < count->width; x++) {
        n_without = is_hit(row[x], count->infinity) ? 0 : n_without + 1;
        if (count->here[x] == HOLE)
            add_hole(sums, colour, x, y);
        if (n_without < SKY_PX)
            continue;
        const struct tone sky = tone_at(colour, x - SKY_PX / 2, y);
        for (int i = 0; i < 3; i++)
            sums->sky[i] += (double)sky.c[i];
        sums->n_sky++;
    }
}

/* Ends a row of places. */
static void end_places(struct rf_hole_count *count)
{
    for (int32_t i = 0; i < count->n_places; i++) {
        const struct place *place = &count->places[i];
        const size_t n = (size_t)place->n_surface + place->n_holes;
        count->n_surface += place->n_surface;
        count->n_holes += place->n_holes;
        if (place->n_holes > 0)
            count->expected +=
                (double)place->n_holes * (double)place->n_holes / (double)n;
        count->n_wide += n >= FEWEST_OF_PLACE;
        count->n_speckled += n >= FEWEST_OF_PLACE && place->n_holes > 0;
    }
    memset(count->places, 0, (size_t)count->n_places * sizeof *count->places);
}

static void count_place(struct rf_hole_count *count, int32_t i)
{
    const uint8_t *here = count->here, *above = count->above;
    const int32_t end = rf_min_int((i + 1) * PLACE_PX, count->width);
    uint32_t n_surface = 0, n_holes = 0, n_pairs = 0, n_both = 0;
    for (int32_t x = i * PLACE_PX; x < end; x++) {
        const bool is_hole = here[x] == HOLE;
        n_surface += here[x] == SURFACE;
        n_holes += is_hole;
        n_pairs += is_hole & (above[x] != NO_SURFACE);
        n_both += is_hole & (above[x] == HOLE);
    }
    count->places[i].n_surface += n_surface;
    count->places[i].n_holes += n_holes;
    count->n_pairs += n_pairs;
    count->n_both += n_both;
}

void rf_hole_count_add(struct rf_hole_count *count,
                       const struct rf_depth_channel *strip)
{
    for (int32_t y = 0; y < strip->height; y++) {
        const float *row = strip->depth + (size_t)y * (size_t)strip->width;
        classify(row, count->width, count->infinity, count->here);
        if (strip->colour.data && memchr(count->here, HOLE, (size_t)count->width))
            add_colours(count, row, &strip->colour, y);
        for (int32_t i = 0; i < count->n_places; i++)
            count_place(count, i);
        uint8_t *above = count->above;
        count->above = count->here;
        count->here = above;
        if (++count->n_rows % PLACE_PX == 0)
            end_places(count);
    }
}

/* Are holes above holes as often as chance has it? */
static bool is_chance(const struct rf_hole_count *count)
{
    const double q = count->expected / fmax((double)count->n_holes, 1);
    const double expected = q * (double)count->n_pairs, both = (double)count->n_both;
    const double deviation = sqrt(expected);
    return count->n_pairs >= RF_DEPTH_FEWEST &&
           both >= LEAST_PAIRS * expected - 2 * deviation &&
           both <= MOST_PAIRS * expected + 3 * deviation;
}

/* Do holes show the sky, or something else that is not beside them? */
static bool is_sky_seen(const struct colour_sums *sums)
{
    double along = -sums->change_mean, square = sums->mean_mean;
    if (sums->change_change > MOST_UNLIKE * (double)sums->n_holes)
        return true;
    if (sums->n_sky == 0)
        return false;
    for (int i = 0; i < 3; i++) {
        const double sky = sums->sky[i] / (double)sums->n_sky;
        along += sky * sums->change[i];
        square += sky * (sky * (double)sums->n_holes - 2 * sums->mean[i]);
    }
    return square > SEEN_SKY * (double)sums->n_holes && along > MOST_SKY * square;
}

void rf_hole_count_judge(struct rf_hole_count *count, struct rf_depth_stats *stats)
{
    end_places(count);
    const size_t n = count->n_surface + count->n_holes;
    stats->n_holes = count->n_holes;
    stats->hole_share = n > 0 ? (double)count->n_holes / (double)n : 0;
    stats->is_speckled =
        count->n_holes >= RF_DEPTH_FEWEST && stats->hole_share >= LEAST_HOLES &&
        count->n_wide >= FEWEST_PLACES &&
        (double)count->n_speckled >= LEAST_PLACES * (double)count->n_wide &&
        count->sums.n_holes == count->n_holes && is_chance(count) &&
        !is_sky_seen(&count->sums);
    rf_depth_give_back(count->context, count);
}

/* ---- filling --------------------------------------------------------------------- */

enum { SIDE_PX = 2 * RF_DEPTH_FILL_REACH + 1, ALL_SIDES = 0xff };

struct around {
    int n_hits;
    float depth[SIDE_PX * SIDE_PX], weight[SIDE_PX * SIDE_PX];
    float of_hits, of_all; /* weight */
    unsigned sides;        /* of eight half planes, those with a hit */
};

static float square_between(struct tone a, struct tone b)
{
    float sum = 0;
    for (int i = 0; i < 3; i++)
        sum += (a.c[i] - b.c[i]) * (a.c[i] - b.c[i]);
    return sum;
}

/* The half planes that a step lies in, or on the border of: the last pixels of a surface
 * have it on three sides and beside them. */
static unsigned sides_of(int32_t dx, int32_t dy)
{
    const int32_t along[4] = {dx, dx + dy, dy, dy - dx};
    unsigned sides = 0;
    for (unsigned i = 0; i < 4; i++)
        sides |= (along[i] >= 0) << i | (along[i] <= 0) << (i + 4);
    return sides;
}

static void look_at(const struct rf_depth_channel *from, int32_t x, int32_t y,
                    const int32_t step[2], struct around *around)
{
    const int32_t i = x + step[0], j = y + step[1];
    if (i < 0 || j < 0 || i >= from->width || j >= from->height)
        return;
    const float z = from->depth[(size_t)j * (size_t)from->width + (size_t)i];
    float weight = 1 / (float)(step[0] * step[0] + step[1] * step[1]);
    if (from->colour.data)
        weight *= UNLIKE / (UNLIKE + square_between(tone_at(&from->colour, x, y),
                                                    tone_at(&from->colour, i, j)));
    around->of_all += weight;
    if (!is_hit(z, (float)from->infinity))
        return;
    around->of_hits += weight;
    around->sides |= sides_of(step[0], step[1]);
    around->depth[around->n_hits] = z;
    around->weight[around->n_hits++] = weight;
}

/* Can the pixels that look_around() takes have hits on all sides? Without colours, which
 * cost most, so that a sky is left soon. */
static bool is_surrounded(const struct rf_depth_channel *from, int32_t x, int32_t y)
{
    const int32_t reach = RF_DEPTH_FILL_REACH;
    const int32_t left = rf_max_int(x - reach, 0), top = rf_max_int(y - reach, 0);
    const int32_t right = rf_min_int(x + reach, from->width - 1);
    const int32_t bottom = rf_min_int(y + reach, from->height - 1);
    unsigned sides = 0;
    for (int32_t j = top; j <= bottom; j++) {
        const float *row = from->depth + (size_t)j * (size_t)from->width;
        for (int32_t i = left; i <= right; i++)
            if (is_hit(row[i], (float)from->infinity))
                sides |= sides_of(i - x, j - y);
        if (sides == ALL_SIDES)
            return true;
    }
    return false;
}

static void look_around(const struct rf_depth_channel *from, int32_t x, int32_t y,
                        struct around *around)
{
    around->n_hits = 0;
    around->of_hits = around->of_all = 0;
    around->sides = 0;
    for (int32_t r = 1; r <= RF_DEPTH_FILL_REACH; r++) {
        if (r > FIRST_RING && around->n_hits >= ENOUGH)
            return;
        for (int32_t dy = -r; dy <= r; dy++)
            for (int32_t dx = -r; dx <= r; dx += abs(dy) == r ? 1 : 2 * r)
                look_at(from, x, y, (const int32_t[2]){dx, dy}, around);
    }
}

/* The depth that most of the weight agrees on. */
static float agreed_depth(const struct around *around)
{
    float most = 0, found = 0;
    for (int k = 0; k < around->n_hits; k++) {
        const float z = around->depth[k], least = z / SAME, greatest = z * SAME;
        float sum = 0, inverse = 0;
        for (int l = 0; l < around->n_hits; l++)
            if (around->depth[l] >= least && around->depth[l] <= greatest) {
                sum += around->weight[l];
                inverse += around->weight[l] / around->depth[l];
            }
        if (sum > most) {
            most = sum;
            found = sum / inverse;
        }
    }
    return found;
}

/* The depth that a pixel gets. */
static float fill_pixel(const struct rf_depth_channel *from, int32_t x, int32_t y,
                        const void *data)
{
    const float own = from->depth[(size_t)y * (size_t)from->width + (size_t)x];
    struct around around;
    (void)data;
    if (is_hit(own, (float)from->infinity) || !(own >= 0))
        return own;
    if (!is_surrounded(from, x, y))
        return own;
    look_around(from, x, y, &around);
    if (around.sides != ALL_SIDES || !(around.of_hits > LEAST_SHARE * around.of_all))
        return own;
    return agreed_depth(&around);
}

rf_result rf_depth_fill(const struct rf_context *context,
                        struct rf_depth_channel *channel, size_t *n_changed,
                        struct rf_error *error)
{
    return rf_depth_change_all(context, channel, fill_pixel, NULL, n_changed, error);
}
