/* SPDX-License-Identifier: Apache-2.0 */
/*
 * With c the merge of views without grain, r that of views with their grain and f that
 * of views with their grain and the same again with random signs, and B_k one of three
 * bands of a picture, finer than 1.4 px, from there to 4.5 px, and coarser:
 *
 *   e_k = G[|B_k(r - c)|^2]   grain of the merge, and what the denoiser did wrong, squared
 *   g_k = G[|B_k(f - r)|^2]   grain of the merge alone, squared
 *   w_k = (e_k - g_k) / e_k, less where e_k < 1.7 g_k, 0 where e_k < 1.3 g_k
 *   out = c + sum of min(w_k, w'_k) B_k(r - c)    w'_k with G' in place of G
 *
 * and out lies between c and r, or at most half of the finer bands' grain beyond, and is
 * no brighter than the brightest of c and r over 3 x 3 px: what is left of one band alone
 * rings, a disc of light had a dark ring, and black beside things in grain glowed. What
 * the coarse band adds, a, is given to the light that is there: c is multiplied by
 * q = 1 + a / C, C being c without its finer bands and q in 0 to MOST_GAIN, and
 * a - C (q - 1) is added. Added whole, it made black beside glints grey.
 *
 * |d|^2 is the sum of the squares over red, green and blue, of d as far as c + d or c - d
 * lies in 0 to white, which is 1 here: lamps would rule otherwise, and flipped grain of
 * dark things, below 0, counts. What d has beyond that is in no band and gets the least
 * w_k. Views are merged for f with 0.25 added, since merges cut what is below 0. Signs of
 * the grain alone (f with c + s d, d the grain) lost half of all glints below it, passed
 * for half of what they are, and glints came back as grain of the picture. G and G'
 * are means over three boxes of 17 x 17 and 7 x 7 px, nearly Gaussians of sigma 8.5 and
 * 3.5 px; by G alone, what is wrong in one place would bring grain back beside it. The
 * coarse band has no G'.
 *
 * With an error b of c that is independent of the grain of r, w = b^2 / (b^2 + grain^2)
 * leaves the least error of all mixtures; less is taken where e may be grain alone. Grain
 * that the lens has blurred is coarse, and what a denoiser smears is fine, or the other way
 * round: so each band has its own w. f has the grain of r as merging spreads it, for any
 * lens. Ours; flipped signs as the wild bootstrap of Wu (1986) has them. Worth:
 * docs/notebook/rivals.md.
 */
#include "denoise/denoise_mix.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "parallel.h"

/* REACH_PX: on 25 pictures 4 to 32 px of sigma differ by 0.1 dB on average. NEAR_PX: grain
 * shows beside bright blurred things without it; costs 0.01 dB on average. */
enum { REACH_PX = 8, NEAR_PX = 3, N_BOXES = 3 };

/* The boxes that part the bands: 3 and 9 px. 4 and 11 px lose 0.1 dB on a tree. */
enum { FINE_PX = 1, COARSE_PX = 4, N_BANDS = 3 };

/* Ratios of e and g, which are means of few pixels: with 1.15 and 1.5 an eighth of the grain of
 * few bright samples on black came back. 1.6 and 2 lose up to 0.24 dB (night). */
static const float DOUBTFUL = 1.3f, CERTAIN = 1.7f;

/* Times the grain of all colours. 0 keeps what is coarse from coming back in fine grain. */
static const float SLACK = 0.5f;

/* Merges cut what is below 0, where the doubled grain of dark things lies; it is merged as
 * much brighter. 1 in place of a quarter changes 0.1 dB, either way. */
static const float LIFT = 0.25f;

/* What is missing where next to nothing is left is added: of wires before the sky. */
static const float MOST_GAIN = 4;

/* Correlation of the grain side by side, within LIMIT of 0: at most 0.09 in Cycles'
 * scenes, 0.37 of Mitsuba's Gaussian. Signs of single pixels would make finer grain of it,
 * and the coarse one would come back as no grain. */
static const double SMEARED = 0.2;
static const float LIMIT = 0.2f;

static int n_colours(int n_channels)
{
    return n_channels >= 3 ? 3 : 1;
}

/* ---- signs -------------------------------------------------------------------------
 */

/* The finalizer of SplitMix64 (Steele, Lea and Flood 2014): bits that look random. */
static uint64_t scramble(uint64_t v)
{
    v += 0x9e3779b97f4a7c15u;
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9u;
    v = (v ^ v >> 27) * 0x94d049bb133111ebu;
    return v ^ v >> 31;
}

/* Of a pixel and all its colours, within LIMIT of 0. */
static float grain_of(const struct denoise_picture *grainy, const float *clean,
                      size_t at)
{
    float sum = 0;
    for (size_t c = 0; c < (size_t)n_colours(grainy->n_channels); c++)
        sum += grainy->samples[at + c] - clean[at + c];
    return fminf(fmaxf(sum / grainy->white, -LIMIT), LIMIT);
}

/* Is the grain of pixels side by side alike? */
static bool is_smeared(const struct denoise_picture *grainy, const float *clean)
{
    const size_t width = (size_t)grainy->width, height = (size_t)grainy->height;
    double products = 0, squares = 0;
    for (size_t y = 0; y < height; y++) {
        float last = 0;
        for (size_t x = 0; x < width; x++) {
            const size_t at = (y * width + x) * (size_t)grainy->n_channels;
            const float grain = grain_of(grainy, clean, at);
            products += (double)(grain * last);
            squares += (double)(grain * grain);
            last = grain;
        }
    }
    return products > SMEARED * squares;
}

void denoise_flip(const struct denoise_picture *grainy, const float *clean, int index)
{
    const size_t row = (size_t)grainy->width, n = row * (size_t)grainy->height;
    const size_t n_channels = (size_t)grainy->n_channels;
    const size_t side = is_smeared(grainy, clean) ? 4 : 1;
    for (size_t i = 0; i < n; i++) {
        const size_t block = i / row / side * row + i % row / side;
        const bool is_kept = scramble((uint64_t)index << 48 ^ (uint64_t)block) & 1;
        for (size_t c = 0; c < (size_t)n_colours(grainy->n_channels); c++) {
            float *to = &grainy->samples[i * n_channels + c];
            const float grain = *to - clean[i * n_channels + c];
            const float v = *to + (is_kept ? grain : -grain);
            *to = fminf(fmaxf(v + LIFT * grainy->white, 0), FLT_MAX);
        }
    }
}

/* ---- means -------------------------------------------------------------------------
 */

static int clamp(int v, int most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

struct planes {
    float *values, *room;
    int width, height, reach;
};

/* Means of 2 reach + 1 values each of a line of n whose ends are repeated. */
static void mean_of_line(const float *from, float *to, int n, size_t step, int reach)
{
    double sum = 0;
    for (int i = -reach; i <= reach; i++)
        sum += (double)from[(size_t)clamp(i, n - 1) * step];
    for (int i = 0; i < n; i++) {
        to[(size_t)i * step] = (float)(sum / (2 * reach + 1));
        sum += (double)from[(size_t)clamp(i + reach + 1, n - 1) * step] -
               (double)from[(size_t)clamp(i - reach, n - 1) * step];
    }
}

static void mean_of_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct planes *p = data;
    (void)thread;
    for (int64_t y = begin; y < end; y++)
        mean_of_line(p->values + y * p->width, p->room + y * p->width, p->width, 1,
                     p->reach);
}

static void mean_of_columns(void *data, int64_t begin, int64_t end, int thread)
{
    const struct planes *p = data;
    (void)thread;
    for (int64_t x = begin; x < end; x++)
        mean_of_line(p->room + x, p->values + x, p->height, (size_t)p->width, p->reach);
}

/* Means of `values` in place; `room` is as large. */
static void smooth(const struct denoise_merges *m, int reach, float *values,
                   float *room)
{
    struct planes planes = {values, room, m->width, m->height, reach};
    for (int k = 0; k < N_BOXES; k++) {
        os_parallel(m->n_threads, m->height, 0, mean_of_rows, &planes);
        os_parallel(m->n_threads, m->width, 0, mean_of_columns, &planes);
    }
}

/* ---- mixing ------------------------------------------------------------------------
 */

static float in_display(float v)
{
    return fminf(fmaxf(v, 0), 1);
}

/* v less a clean value on a display, or the other way, by which it shows more. */
static float difference(float clean, float v)
{
    const float d = fabsf(v - clean), shown = in_display(clean);
    const float more =
        fmaxf(in_display(clean + d) - shown, shown - in_display(clean - d));
    return v < clean ? -more : more;
}

/* Planes of all pixels. */
struct rooms {
    float *bands[N_BANDS]; /* of one colour */
    float *all[N_BANDS], *grain[N_BANDS], *weights[N_BANDS];
    float *mean_all, *mean_grain, *line;
    size_t n; /* pixels */
};

enum { N_ROOMS = 4 * N_BANDS + 3 };

static void share_rooms(struct rooms *rooms, float *memory)
{
    const size_t n = rooms->n;
    for (size_t b = 0; b < N_BANDS; b++) {
        rooms->bands[b] = memory + b * n;
        rooms->all[b] = memory + (N_BANDS + b) * n;
        rooms->grain[b] = memory + (2 * N_BANDS + b) * n;
        rooms->weights[b] = memory + (3 * N_BANDS + b) * n;
    }
    rooms->mean_all = memory + (N_ROOMS - 3) * n;
    rooms->mean_grain = memory + (N_ROOMS - 2) * n;
    rooms->line = memory + (N_ROOMS - 1) * n;
}

/* Bands of colour c of how far one merge differs from another that is darker by `lift`,
 * as it shows in the clean one. */
static void find_bands(const struct denoise_merges *m, const float *other,
                       const float *from, float lift, int c, const struct rooms *rooms)
{
    float *const *bands = rooms->bands;
    for (size_t i = 0; i < rooms->n; i++) {
        const size_t k = i * (size_t)m->n_channels + (size_t)c;
        const float clean = m->clean[k] / m->white;
        const float d = (other[k] - from[k]) / m->white - lift;
        bands[0][i] = difference(clean, clean + d);
    }
    memcpy(bands[1], bands[0], rooms->n * sizeof(float));
    smooth(m, FINE_PX, bands[1], rooms->line);
    memcpy(bands[2], bands[1], rooms->n * sizeof(float));
    smooth(m, COARSE_PX, bands[2], rooms->line);
    for (size_t i = 0; i < rooms->n; i++) {
        bands[0][i] -= bands[1][i];
        bands[1][i] -= bands[2][i];
    }
}

static void find_squares(const struct denoise_merges *m, const float *other,
                         const float *from, float lift, const struct rooms *rooms,
                         float *const squares[N_BANDS])
{
    for (int b = 0; b < N_BANDS; b++)
        memset(squares[b], 0, rooms->n * sizeof(float));
    for (int c = 0; c < n_colours(m->n_channels); c++) {
        find_bands(m, other, from, lift, c, rooms);
        for (int b = 0; b < N_BANDS; b++)
            for (size_t i = 0; i < rooms->n; i++)
                squares[b][i] += rooms->bands[b][i] * rooms->bands[b][i];
    }
}

/* w of e and g. */
static float weight_of(float all, float grain)
{
    if (!(all > DOUBTFUL * grain))
        return 0;
    const float certain = (CERTAIN - DOUBTFUL) / CERTAIN * all;
    return (all - grain) / all * fminf((all - DOUBTFUL * grain) / certain, 1);
}

/* Lowers the weights of a band to those of means of this reach. */
static void lower_weights(const struct denoise_merges *m, int reach, int band,
                          const struct rooms *rooms)
{
    const size_t size = rooms->n * sizeof(float);
    memcpy(rooms->mean_all, rooms->all[band], size);
    memcpy(rooms->mean_grain, rooms->grain[band], size);
    smooth(m, reach, rooms->mean_all, rooms->line);
    smooth(m, reach, rooms->mean_grain, rooms->line);
    for (size_t i = 0; i < rooms->n; i++)
        rooms->weights[band][i] =
            fminf(rooms->weights[band][i], weight_of(fmaxf(rooms->mean_all[i], 0),
                                                     fmaxf(rooms->mean_grain[i], 0)));
}

static void find_weights(const struct denoise_merges *m, const struct rooms *rooms)
{
    find_squares(m, m->grainy, m->clean, 0, rooms, rooms->all);
    find_squares(m, m->flipped, m->grainy, LIFT, rooms, rooms->grain);
    for (int b = 0; b < N_BANDS; b++) {
        for (size_t i = 0; i < rooms->n; i++)
            rooms->weights[b][i] = 1;
        lower_weights(m, REACH_PX, b, rooms);
        if (b < N_BANDS - 1)
            lower_weights(m, NEAR_PX, b, rooms);
    }
}

/* How far the mixture may lie beyond both merges. */
static void find_slack(const struct denoise_merges *m, const struct rooms *rooms,
                       float *slack)
{
    for (size_t i = 0; i < rooms->n; i++) {
        slack[i] = 0;
        for (int b = 0; b < N_BANDS - 1; b++)
            slack[i] += rooms->grain[b][i];
    }
    smooth(m, FINE_PX, slack, rooms->line);
    for (size_t i = 0; i < rooms->n; i++)
        slack[i] = SLACK * sqrtf(fmaxf(slack[i], 0));
}

/* Colour c of the clean merge without its finer bands. */
static void find_light(const struct denoise_merges *m, int c, const struct rooms *rooms,
                       float *light)
{
    for (size_t i = 0; i < rooms->n; i++)
        light[i] =
            in_display(m->clean[i * (size_t)m->n_channels + (size_t)c] / m->white);
    smooth(m, FINE_PX, light, rooms->line);
    smooth(m, COARSE_PX, light, rooms->line);
}

/* What a pixel gets of what is to be added around it, by the light that is there. */
static float share_light(float clean, float light, float added)
{
    if (!(light > 0))
        return added;
    const float more = fminf(fmaxf(added / light, -1), MOST_GAIN - 1);
    return in_display(clean) * more + (added - light * more);
}

/* The most of colour c of both merges in the 3 x 3 px around each. */
static void find_most(const struct denoise_merges *m, int c, size_t n, float *most)
{
    const int width = m->width, height = m->height;
    for (size_t i = 0; i < n; i++) {
        const int x = (int)(i % (size_t)width), y = (int)(i / (size_t)width);
        most[i] = 0;
        for (int v = clamp(y - 1, height - 1); v <= clamp(y + 1, height - 1); v++)
            for (int u = clamp(x - 1, width - 1); u <= clamp(x + 1, width - 1); u++) {
                const size_t at = (size_t)v * (size_t)width + (size_t)u;
                const size_t k = at * (size_t)m->n_channels + (size_t)c;
                most[i] = fmaxf(most[i], fmaxf(m->clean[k], m->grainy[k]) / m->white);
            }
    }
}

static void mix(const struct denoise_merges *m, const struct rooms *rooms)
{
    float *slack = rooms->mean_grain, *light = rooms->mean_all, *most = rooms->line;
    find_slack(m, rooms, slack);
    for (int c = 0; c < n_colours(m->n_channels); c++) {
        find_light(m, c, rooms, light);
        find_bands(m, m->grainy, m->clean, 0, c, rooms);
        find_most(m, c, rooms->n, most);
        for (size_t i = 0; i < rooms->n; i++) {
            const size_t k = i * (size_t)m->n_channels + (size_t)c;
            const float clean = m->clean[k] / m->white;
            float beyond = m->grainy[k] / m->white - clean;
            float whole = 0, sum = 0, least = 1;
            for (int b = 0; b < N_BANDS; b++) {
                const float w = rooms->weights[b][i], part = w * rooms->bands[b][i];
                sum += b < N_BANDS - 1 ? part : share_light(clean, light[i], part);
                whole += rooms->bands[b][i];
                least = fminf(least, w);
            }
            beyond -= whole;
            sum = fminf(sum, fmaxf(whole, 0) + slack[i]);
            sum = fmaxf(sum, fminf(whole, 0) - slack[i]);
            sum = fminf(sum, fmaxf(most[i] - clean, 0));
            m->clean[k] += m->white * (sum + least * beyond);
        }
    }
}

bool denoise_mix(const struct denoise_merges *m, struct image_error *error)
{
    struct rooms rooms = {.n = (size_t)m->width * (size_t)m->height};
    float *memory = app_memory(N_ROOMS, rooms.n * sizeof(float), error);
    if (!memory)
        return false;
    share_rooms(&rooms, memory);
    find_weights(m, &rooms);
    mix(m, &rooms);
    free(memory);
    return true;
}
