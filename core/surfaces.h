/* SPDX-License-Identifier: Apache-2.0 */
/* From a picture with depth to surfaces: edge pixels split, hidden background found. */
#ifndef RF_SURFACES_H
#define RF_SURFACES_H

#include "arena.h"
#include "internal.h"

enum { RF_ROW_MARGIN = 8 };

/* Of a pixel, for its near part to count as something that stands before others. */
static const float RF_OCCLUDER_SHARE = 0.02f;

/* A piece of surface in one pixel. */
struct rf_surface {
    float c[4]; /* colour, premultiplied; c[3] is alpha, 1 where the picture has none */
    float r;    /* signed radius, px */
};

/* Which of 64 pixels in turn have something that others lack. */
struct rf_marks {
    uint64_t bits;
    size_t n_before; /* pixels before them that have it */
};

/* A picture of surfaces, width x height, packed. */
struct rf_surfaces {
    int width, height;
    int x, y; /* of the first pixel, in the whole picture with its border */
    struct rf_surface *near; /* the nearer part of each pixel */
    struct rf_surface *far;  /* the farther parts of mixed ones: rf_far_at() */
    struct rf_marks *mixed;  /* of the whole picture: 64 pixels, the next 64, .. */
    float *share;            /* of the near part, 0 to 1; 1 marks a pure pixel */
};

/* The farther part of pixel i, which is mixed. */
static inline struct rf_surface *rf_far_at(const struct rf_surfaces *s, size_t i)
{
    const struct rf_marks *m = &s->mixed[i / 64];
    uint64_t before = m->bits & (((uint64_t)1 << i % 64) - 1);
    return s->far + m->n_before + __builtin_popcountll(before);
}

/* Has pixel i a farther part? */
static inline bool rf_is_mixed(const struct rf_surfaces *s, size_t i)
{
    return s->mixed[i / 64].bits >> i % 64 & 1;
}

/* What pixel i shows behind others: its farther part where it has one. */
static inline const struct rf_surface *rf_shown_at(const struct rf_surfaces *s,
                                                   size_t i)
{
    return rf_is_mixed(s, i) && s->share[i] < 1 ? rf_far_at(s, i) : &s->near[i];
}

/*
 * The farther parts of a picture have room once all mixed pixels are marked, which any
 * thread does: rf_far_begin(), rf_far_mark(), rf_far_allocate().
 */
rf_result rf_far_begin(struct rf_surfaces *s, const struct rf_context *context,
                       struct rf_error *error);

static inline void rf_far_mark(struct rf_surfaces *s, size_t i)
{
    __atomic_fetch_or(&s->mixed[i / 64].bits, (uint64_t)1 << i % 64, __ATOMIC_RELAXED);
}

rf_result rf_far_allocate(struct rf_surfaces *s, const struct rf_context *context,
                          struct rf_error *error);
void rf_far_free(struct rf_surfaces *s, const struct rf_context *context);

/*
 * What the edges of the picture are split from: pixels as they came. The planes repeat
 * the edge of the picture for RF_ROW_MARGIN floats before each row of `stride`, and at
 * least as many after it.
 */
struct rf_pixels {
    int width, height;
    struct rf_surface *at; /* packed */
    size_t stride;
    float *luminance;
    float *radius;
    /* Where edges are split: the radii of split pixels as they came, or NULL. */
    struct rf_split_radius *split;
    size_t *split_row; /* where each row's begin, height + 1 */
};

/* Of a row these lie from left to right. */
struct rf_split_radius {
    int x;
    float r;
};

/* First pixel of a row of a plane. */
static inline float *rf_plane_row(const struct rf_pixels *p, float *plane, int y)
{
    return plane + p->stride * (size_t)y + RF_ROW_MARGIN;
}

/* The rows y - reach to y + reach of a plane, those outside repeating its edge. */
static inline void rf_plane_rows(const struct rf_pixels *p, float *plane, int y,
                                 int reach, const float *rows[])
{
    for (int k = -reach; k <= reach; k++)
        rows[k + reach] =
            rf_plane_row(p, plane, rf_min_int(rf_max_int(y + k, 0), p->height - 1));
}

enum { RF_SPLIT_REACH = 3, RF_SPLIT_STEPS = 5 * 5 };

/*
 * Splits mixed pixels into their two surfaces (split.c), if the parameters say so, row
 * by row: a row may be split once the RF_SPLIT_REACH rows to both sides of it are
 * loaded. rf_split_begin(), rf_split_row() for each row, any thread, rf_split_end();
 * rf_split_free() in any case. The pixels stay as they are until the end.
 */
struct rf_splitter {
    const struct rf_filter *filter;
    bool keeps_radii; /* as they came */
    bool is_alone;    /* the only view: others do not show what a thin thing hides */
    struct rf_pixels *pixels;
    struct rf_surfaces *out;
    /*
     * Receives the least luminance of the 5 x 5 pixels around each, as a plane like
     * that of the luminance, without its margins; if edges are split.
     */
    float *darkest;
    /* Receives a bit for each pixel that shows more luminance than `bright`. */
    uint64_t *shining;
    float bright;
    /* Its own: */
    int32_t steps[RF_SPLIT_STEPS]; /* from a pixel to the 5 x 5 around it */
    float *rows;
    struct rf_split_row *splits;
    struct rf_arena arena;
    struct rf_room *rooms;
};

rf_result rf_split_begin(struct rf_splitter *s, struct rf_error *error);
/* False: out of memory. */
bool rf_split_row(struct rf_splitter *s, int y);
/*
 * The plane of radii becomes that of the near parts, INFINITY where their share is not
 * above RF_OCCLUDER_SHARE. The pixels become the near parts, and pixels->at is lost.
 */
rf_result rf_split_end(struct rf_splitter *s, struct rf_error *error);
/* The radius of pixel (x, y) as it came, which the splitter has kept. */
float rf_split_radius_at(const struct rf_pixels *p, int x, int y);
void rf_split_free(struct rf_splitter *s);

/* A bit for each pixel of a row, in whole words: how many. */
static inline size_t rf_row_words(int width)
{
    return ((size_t)width + 63) / 64;
}

/*
 * Who knows better than an estimate: does anyone show what lies behind pixel (x, y), if
 * it is of radius r? Any thread asks.
 */
struct rf_known {
    bool (*is_shown)(void *user, int x, int y, float r);
    void *user;
};

/* What lies behind the near surfaces of a picture, where that was found. */
struct rf_estimates {
    int width;             /* of the picture */
    struct rf_surface *at; /* packed */
    uint8_t *found;        /* a bit for each pixel, rows in whole bytes and some more */
};

static inline size_t rf_found_stride(int width)
{
    return (size_t)width / 8 + 10;
}

/* A bit for each of n <= 64 pixels from (x, y) on: was anything found? */
static inline uint64_t rf_found_at(const struct rf_estimates *e, int x, int y, int n)
{
    const uint8_t *at = e->found + rf_found_stride(e->width) * (size_t)y + x / 8;
    uint64_t bits = 0;
    for (int i = 0; i < 8; i++)
        bits |= (uint64_t)at[i] << 8 * i;
    bits >>= x % 8;
    if (x % 8)
        bits |= (uint64_t)at[8] << (64 - x % 8);
    return bits & UINT64_MAX >> (64 - n);
}

/*
 * The radii of the near surfaces as a plane, INFINITY where their share is not above
 * RF_OCCLUDER_SHARE. RF_ROW_MARGIN floats after each row repeat its last one.
 */
struct rf_radii {
    float *at; /* of the first pixel */
    size_t stride;
};

/*
 * Estimates what lies behind the near surface of each pixel (hidden.c). `radii` (or
 * NULL: not at hand) change while it works. Around pixels for which `known` (or NULL)
 * shows what lies behind nothing is estimated. Afterwards, and when it fails, the
 * estimates are to be freed.
 */
rf_result rf_find_hidden(const struct rf_filter *filter,
                         const struct rf_surfaces *surfaces,
                         const struct rf_radii *radii, const struct rf_known *known,
                         struct rf_estimates *estimates, struct rf_task *task,
                         struct rf_error *error);
void rf_estimates_free(struct rf_estimates *e, const struct rf_context *context);

/* How often rf_find_hidden() steps its task for a picture of that height. */
int rf_hidden_steps(int height);

#endif
