/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A depth that is the nearest of all samples of a pixel filter (Arnold's closest,
 * LuxCore's DEPTH) makes near things wider than their colours are: a rim of what is
 * behind them would be sharp where they are in focus, and blurred with them elsewhere.
 *
 * At a step of the depth, with f and b the colours within the near and the far side,
 * e = f - b, and c_k that of a pixel beside the step,
 *
 *   a_k = clamp((c_k - b) . e / |e|^2)     share of the near side in pixel k
 *
 * Colours are square roots of light, of 0 to the brighter side's or to 1, which is what
 * shows as white here. Means over all steps that lie between
 * flat sides of plain colours, in rows (ours; checkered boxes, balls and posts):
 *
 *                                  last near pixel   that before   first far pixel
 *   one sample of a pixel                     0.74          0.95              0.23
 *   nearest of a pixel                        0.46          0.87              0.07
 *   nearest of 2 x 2 px                       0.16          0.64              0.02
 *   LuxCore 2.11, boxes                       0.24          0.60              0.04
 *
 * Depth of the first two is good as it is (43.1 dB against the lens); that of the third
 * has 42.7 dB, and 43.0 where pixels with less than half of the near side get the depth
 * behind it.
 */
#include "input/depth_edges.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/error.h"
#include "input/depth_steps.h"
#include "input/image.h"

/* Of the first and third mean above together: 0.97, 0.53, 0.18, 0.28. */
static const double WIDENED_SHARES = 0.4;

/* The same of either side, where it has steps: depth that is too wide has 0.08 to 0.26,
 * that which lies some pixels beside its picture 0.65 to 2 on one side. */
static const double SIDE_SHARES = 0.6;

/*
 * Pixels 5 and 6 px within near sides have this share of the near colour at least, on
 * average, unless the near side's texture has the colours of what is behind it, which
 * looks like a rim: 0.74 of checks of 4 px in focus (20.6 dB for 29.9 with the depth as
 * it is), 0.85 to 0.97 of the scenes of tests/quality, 0.99 of LuxCore's boxes.
 */
static const double PLAIN_INSIDE = 0.8;

/* What two pixels show is told by |e|^2 of more than this; else by the mean a_k, the more
 * the less it is: 0.003 loses 0.03 dB. Steps whose sides differ less are not counted. */
static const float UNSURE = 0.03f, CLEAR = 0.02f;

/* Of |e|^2, within a side and of what a_k leaves: less is plain. */
static const float PLAIN = 0.1f;

/* Depth of one surface, from pixel to pixel; of a flat side 3 px apart. */
static const float SAME = 1.1f, FLAT = 0.03f;

enum {
    N_NEAR = 2,  /* pixels within a step that may show what is behind */
    INNER_PX = 4 /* from the step to where a side has its own colour */
};

_Static_assert((int)N_NEAR + (int)INNER_PX <= (int)RF_DEPTH_SNAP_REACH,
               "the reach of a pixel's depth");

struct map {
    const float *depth;
    const struct rf_image *colour;
    int32_t width, height;
    double infinity;
};

static struct map map_of(const struct rf_depth_channel *channel)
{
    return (struct map){channel->depth, &channel->colour, channel->width,
                        channel->height, channel->infinity};
}

static bool is_inside(const struct map *map, int32_t x, int32_t y)
{
    return x >= 0 && y >= 0 && x < map->width && y < map->height;
}

/* INFINITY where nothing was hit, which 0 means as well; NAN what is no depth, and on no
 * side of a step. */
static float depth_at(const struct map *map, int32_t x, int32_t y)
{
    const float z = map->depth[(size_t)y * (size_t)map->width + (size_t)x];
    if (!(z >= 0))
        return NAN;
    return z > 0 && z < map->infinity ? z : INFINITY;
}

struct tone {
    float c[3];
};

static float light_at(const struct map *map, int32_t x, int32_t y, int i)
{
    return *rf_image_at(map->colour, x, y, map->colour->channels >= 3 ? i : 0);
}

/* The largest channel of a pixel, or `white`, which is no less than 1. */
static float brighter(const struct map *map, int32_t x, int32_t y, float white)
{
    for (int i = 0; i < 3; i++)
        white = fmaxf(white, light_at(map, x, y, i));
    return white;
}

/* Of light from 0 to `white`. */
static struct tone tone_at(const struct map *map, int32_t x, int32_t y, float white)
{
    struct tone tone;
    for (int i = 0; i < 3; i++)
        tone.c[i] = sqrtf(fminf(fmaxf(light_at(map, x, y, i) / white, 0), 1));
    return tone;
}

/* t = 0 is a, 1 is b. */
static struct tone between(struct tone a, struct tone b, float t)
{
    for (int i = 0; i < 3; i++)
        a.c[i] += t * (b.c[i] - a.c[i]);
    return a;
}

static float square_between(struct tone a, struct tone b)
{
    float sum = 0;
    for (int i = 0; i < 3; i++)
        sum += (a.c[i] - b.c[i]) * (a.c[i] - b.c[i]);
    return sum;
}

/* a of colour c; |e|^2 > 0. */
static float share_of_near(struct tone c, struct tone near, struct tone far,
                           float square)
{
    float sum = 0;
    for (int i = 0; i < 3; i++)
        sum += (c.c[i] - far.c[i]) * (near.c[i] - far.c[i]);
    return fminf(fmaxf(sum / square, 0), 1);
}

/* ---- measuring ------------------------------------------------------------------- */

static bool are_flat(float a, float b)
{
    return a == b || fabsf(a - b) < FLAT * a;
}

/* The step between x, the last near pixel, and x + side, the first far one. */
static void count_step(const struct map *map, int32_t x, int32_t y, int32_t side,
                       struct rf_edge_sums *sums)
{
    const int32_t inner = x - INNER_PX * side, outer = x + INNER_PX * side;
    if (!is_inside(map, inner, y) || !is_inside(map, outer, y) ||
        !are_flat(depth_at(map, x, y), depth_at(map, inner, y)) ||
        !are_flat(depth_at(map, x + side, y), depth_at(map, outer, y)))
        return;
    const float white = brighter(map, outer, y, brighter(map, inner, y, 1));
    const struct tone near[2] = {tone_at(map, inner, y, white),
                                 tone_at(map, inner + side, y, white)};
    const struct tone far[2] = {tone_at(map, outer - side, y, white),
                                tone_at(map, outer, y, white)};
    const struct tone f = between(near[0], near[1], 0.5f),
                      b = between(far[0], far[1], 0.5f);
    const float square = square_between(f, b);
    if (!(square > CLEAR) || !(square_between(near[0], near[1]) < PLAIN * square) ||
        !(square_between(far[0], far[1]) < PLAIN * square))
        return;
    const int32_t at[3] = {x, x - side, x + side};
    double shares[3];
    for (int k = 0; k < 3; k++) {
        const struct tone c = tone_at(map, at[k], y, white);
        const float share = share_of_near(c, f, b, square);
        if (!(square_between(c, between(b, f, share)) < PLAIN * square))
            return;
        shares[k] = (double)share;
    }
    for (int k = 0; k < 3; k++)
        sums->shares[k] += shares[k];
    sums->n++;
    sums->side_shares[side > 0] += shares[0] + shares[2];
    sums->n_sides[side > 0]++;
    for (int32_t k = INNER_PX + 1; k <= INNER_PX + 2; k++) {
        const int32_t within = x - k * side;
        if (!is_inside(map, within, y) ||
            !are_flat(depth_at(map, x, y), depth_at(map, within, y)))
            break;
        sums->inside +=
            (double)share_of_near(tone_at(map, within, y, white), f, b, square);
        sums->n_inside++;
    }
}

void rf_depth_count_edges(const struct rf_depth_channel *strip,
                          struct rf_edge_sums *sums)
{
    const struct map map = map_of(strip);
    const float ratio = (float)RF_DEPTH_STEP_RATIO;
    for (int32_t y = 0; y < map.height; y++) {
        float last = depth_at(&map, 0, y);
        for (int32_t x = 1; x < map.width; x++) {
            const float z = depth_at(&map, x, y);
            if (z > ratio * last)
                count_step(&map, x - 1, y, 1, sums);
            else if (last > ratio * z)
                count_step(&map, x, y, -1, sums);
            last = z;
        }
    }
}

/* Do near things reach over what is behind them on one side alone? A depth that lies
 * beside its picture looks so. */
static bool is_one_side(const struct rf_edge_sums *sums)
{
    for (int i = 0; i < 2; i++)
        if (sums->side_shares[i] > SIDE_SHARES * (double)sums->n_sides[i])
            return true;
    return false;
}

void rf_depth_judge_edges(const struct rf_edge_sums *sums, struct rf_depth_stats *stats)
{
    const bool are_enough = sums->n >= RF_DEPTH_FEWEST;
    for (int k = 0; k < 3; k++)
        stats->near_shares[k] =
            are_enough ? sums->shares[k] / (double)sums->n : (double)NAN;
    stats->is_widened =
        stats->near_shares[0] + stats->near_shares[2] < WIDENED_SHARES &&
        !is_one_side(sums) &&
        (sums->n_inside < RF_DEPTH_FEWEST ||
         sums->inside > PLAIN_INSIDE * (double)sums->n_inside);
}

/* ---- mending --------------------------------------------------------------------- */

static bool are_same(float a, float b)
{
    return a < SAME * b && b < SAME * a;
}

/* What the steps around a pixel say of it. */
struct verdict {
    int32_t n; /* px to the nearest step, 1: the pixel is the last before it */
    float shares, squares, far;
    size_t from; /* the pixel whose depth is that behind */
};

/* How many pixels back from one the colour is the near side's, INNER_PX from a step that
 * is n px away; that of the middle of what is thinner. */
static int32_t near_side(const struct map *map, int32_t x, int32_t y, int32_t dx,
                         int32_t dy, int32_t n)
{
    const float z = depth_at(map, x, y);
    int32_t length = n; /* px from the step to the end of the near side */
    for (; length < INNER_PX; length++) {
        const int32_t k = length + 1 - n;
        if (!is_inside(map, x - k * dx, y - k * dy) ||
            !are_same(z, depth_at(map, x - k * dx, y - k * dy)))
            break;
    }
    return (length < INNER_PX ? (length + 2) / 2 : length) - n;
}

/* Does the depth grow towards the step as it does there? It is no step then. */
static bool is_slant(const struct map *map, int32_t x, int32_t y, int32_t dx,
                     int32_t dy, float far)
{
    const float z = depth_at(map, x, y);
    return is_inside(map, x - dx, y - dy) &&
           z - depth_at(map, x - dx, y - dy) > 0.25f * (far - z);
}

/* Adds the share of the near side in a pixel: of the colours behind it, up to INNER_PX
 * from the step, that which explains the pixel best is the far side's. */
static void add_share(const struct map *map, int32_t x, int32_t y, int32_t dx,
                      int32_t dy, struct verdict *verdict)
{
    const float z = depth_at(map, x, y);
    const int32_t back = near_side(map, x, y, dx, dy, verdict->n);
    const int32_t near_x = x - back * dx, near_y = y - back * dy;
    const float near_white = brighter(map, near_x, near_y, 1);
    float least = INFINITY, best_share = 0, best_square = 0;
    for (int32_t k = verdict->n; k < verdict->n + INNER_PX; k++) {
        if (!is_inside(map, x + k * dx, y + k * dy) ||
            !(depth_at(map, x + k * dx, y + k * dy) > SAME * z))
            break;
        const float white = brighter(map, x + k * dx, y + k * dy, near_white);
        const struct tone own = tone_at(map, x, y, white);
        const struct tone f = tone_at(map, near_x, near_y, white);
        const struct tone b = tone_at(map, x + k * dx, y + k * dy, white);
        const float square = square_between(f, b);
        const float share = square > 0 ? share_of_near(own, f, b, square) : 0;
        const float left = square_between(own, between(b, f, share));
        if (left < least) {
            least = left;
            best_share = share;
            best_square = square;
        }
    }
    verdict->shares += best_square * best_share;
    verdict->squares += best_square;
}

/* Looks for a step along one direction and adds what it says. */
static void look_along(const struct map *map, int32_t x, int32_t y, int32_t dx,
                       int32_t dy, struct verdict *verdict)
{
    const float z = depth_at(map, x, y);
    for (int32_t n = 1; n <= N_NEAR && n <= verdict->n; n++) {
        const int32_t far_x = x + n * dx, far_y = y + n * dy;
        if (!is_inside(map, far_x, far_y))
            return;
        const float far = depth_at(map, far_x, far_y);
        if (!(far > SAME * z))
            continue;
        if (is_slant(map, x, y, dx, dy, far))
            return;
        if (n < verdict->n)
            *verdict = (struct verdict){.n = n, .far = INFINITY};
        if (far <= verdict->far) {
            verdict->far = far;
            verdict->from = (size_t)far_y * (size_t)map->width + (size_t)far_x;
        }
        add_share(map, x, y, dx, dy, verdict);
        return;
    }
}

/* The depth that a pixel gets; `data`: the shares that near pixels have on average. */
static float narrow_pixel(const struct rf_depth_channel *from, int32_t x, int32_t y,
                          const void *data)
{
    static const int32_t along[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    const double *near_shares = data;
    const struct map map = map_of(from);
    struct verdict verdict = {.n = N_NEAR + 1};
    const float own = from->depth[(size_t)y * (size_t)from->width + (size_t)x];
    if (!isfinite(depth_at(&map, x, y)))
        return own;
    for (int i = 0; i < 4; i++)
        look_along(&map, x, y, along[i][0], along[i][1], &verdict);
    if (verdict.n > N_NEAR)
        return own;
    const float usual = (float)near_shares[verdict.n - 1];
    const float share = (verdict.shares + UNSURE * usual) / (verdict.squares + UNSURE);
    return share < 0.5f ? from->depth[verdict.from] : own;
}

rf_result rf_depth_narrow(const struct rf_context *context,
                          struct rf_depth_channel *channel,
                          const struct rf_depth_stats *stats, size_t *n_changed,
                          struct rf_error *error)
{
    if (!stats || (channel && !channel->colour.data))
        return rf_fail(error, RF_ERROR_ARGUMENT, stats ? "channel" : "stats",
                       "a pointer is NULL");
    return rf_depth_change_all(context, channel, narrow_pixel, stats->near_shares,
                               n_changed, error);
}
