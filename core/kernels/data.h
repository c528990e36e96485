/* SPDX-License-Identifier: Apache-2.0 */
/* The plain structs that the kernels work on. */
#ifndef RF_KERNELS_DATA_H
#define RF_KERNELS_DATA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { RF_ROW_MARGIN = 8 };

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

enum {
    RF_MAX_CELLS = 16,
    RF_FOOTPRINT_LANES = 8, /* segments are padded with zeros to a multiple of this */
    RF_MAX_SIDE_BY_SIDE = 4,
};

/* A run of pixels in one row that belong to one sub-aperture. */
struct rf_segment {
    int16_t dx, dy; /* first pixel, relative to the sample's pixel */
    int16_t n;      /* multiple of RF_FOOTPRINT_LANES */
    int16_t n_used; /* weights, of which nothing but zeros follow */
    int16_t cell;
    int32_t row;    /* of an accumulator: dy after all rows of the cells before */
    int32_t weight; /* index of the first weight */
    float sum;      /* of the weights, see rf_segment_sum() */
};

/*
 * The sum of a segment's weights in the order in which a convolution adds what they
 * weigh: from left to right or, of an even footprint, both sides at once from the
 * middle.
 */
static inline float rf_segment_sum(const struct rf_segment *g, const float *weights,
                                   bool is_even)
{
    const float *w = weights + g->weight - (is_even ? g->dx : 0);
    int n = is_even ? 1 - g->dx : g->n;
    float sum = w[0];
    for (int i = 1; i < n; i++)
        sum += is_even ? w[i] * 2 : w[i];
    return sum;
}

/*
 * Where there are several sub-apertures, a footprint of a radius below this is one for
 * all of them: the parts of the lens differ by a fraction of a pixel there. Its
 * segments are of the cell n_cells.
 */
#define RF_COMMON_PX 0.25

struct rf_footprint {
    int n_segments;
    /* So many at the beginning have the weights of as many at the end, the other way
     * round: a row above the sample those of the row as far below it. */
    int n_mirrored;
    bool is_common;
    bool is_even; /* mirrored, and each row the same both ways: segments from -dx to dx
                   */
    /*
     * So many samples side by side can be spread at once: segments end with as many
     * zeros, but one, and as many stand before the first. 1 to RF_MAX_SIDE_BY_SIDE.
     */
    int n_side_by_side;
    bool is_shut; /* looks leave nothing of it: it is as if they took nothing */
    int min_dx, max_dx, min_dy, max_dy; /* of the weights above zero */
    struct rf_segment *segments;        /* by rows */
    float *weights;
};

/*
 * What is built in a slot. Another picture that was late with the same one may still
 * try to put its own there (and fail): so the read is atomic, too, which costs nothing.
 */
static inline const struct rf_footprint *
rf_footprint_at(struct rf_footprint *const *table, size_t slot)
{
    return __atomic_load_n(&table[slot], __ATOMIC_RELAXED);
}

enum {
    RF_TILE_W = 64,
    RF_TILE_H = 32,
    RF_TILE_HALO = 12, /* how far a footprint reaches from its middle at the most, px */
    RF_ACC_LEFT = 24,  /* columns before the tile that footprints may write to */
    RF_ACC_STRIDE = RF_ACC_LEFT + RF_TILE_W + 32,
    RF_MAX_PLANES = 5,  /* r g b a and coverage */
    RF_LONE_PLANES = 2, /* of one colour alone */
};

/* Transmittance that counts as none. */
#define RF_USED_UP 1e-6f

/* Four floats in turn, such as a colour, on every instruction set. */
typedef float rf_quad __attribute__((vector_size(16), aligned(4)));

/*
 * The slope of a surface's radius, px per px, rounded: x' + RF_SLANT_ROW y' with the
 * steps x' to the right and y' down, from -RF_SLANT_STEPS to RF_SLANT_STEPS; 0: it is
 * flat. The slope of step i is RF_SLANT_HALF t / (1 - |t|) with t = i RF_SLANT_STEP:
 * 0.02 of the first, 1 of the last.
 */
enum {
    RF_SLANT_STEPS = 10,
    RF_SLANT_ROW = 2 * RF_SLANT_STEPS + 1,
    RF_N_SLANTS = RF_SLANT_ROW * RF_SLANT_ROW,
    RF_MOST_SLANT = RF_N_SLANTS / 2, /* and -RF_MOST_SLANT is the least */
};
#define RF_SLANT_HALF 0.24f
#define RF_SLANT_STEP 0.08f

/*
 * A sample ready to be spread: pixel of its level, slant, footprint, coverage, light.
 */
struct rf_splat {
    int32_t x;
    int32_t y : 22;
    int32_t slant : 10;
    int32_t slot;
    float cover; /* 0 for light that belongs to another splat's surface */
    float c[4];  /* colour times weight */
};

/*
 * Splats of the surfaces of pixels side by side as they are: where the first lies in
 * its tile. 64 bits: slot << 16 | x << 48 | y << 56 | other, where the last is 0 for
 * one flat surface, rf_packed_run() for n of one slant, or, for a splat of another
 * kind, 1 + its index.
 */
typedef uint64_t rf_packed;

static inline rf_packed rf_packed_make(int32_t slot, int x, int y, int other)
{
    return (uint64_t)(uint32_t)slot << 16 | (uint64_t)x << 48 | (uint64_t)y << 56 |
           (uint64_t)other;
}

static inline int32_t rf_packed_slot(rf_packed p)
{
    return (int32_t)(p >> 16);
}

static inline int rf_packed_x(rf_packed p)
{
    return (int)(p >> 48 & 0xff);
}

static inline int rf_packed_y(rf_packed p)
{
    return (int)(p >> 56);
}

static inline int rf_packed_other(rf_packed p)
{
    return (int)(p & 0xffff);
}

enum { RF_PACKED_RUN = 0x8000, RF_PACKED_N = RF_TILE_W - 1, RF_PACKED_SLANT = 6 };

/* What stands for n surfaces of one slant. */
static inline int rf_packed_run(int n, int slant)
{
    return n == 1 && slant == 0
               ? 0
               : RF_PACKED_RUN | (slant & 0x1ff) << RF_PACKED_SLANT | (n - 1);
}

/* How many surfaces a place stands for; 0: a splat of another kind. */
static inline int rf_packed_n(rf_packed p)
{
    int other = rf_packed_other(p);
    return other >= RF_PACKED_RUN ? (other & RF_PACKED_N) + 1 : other == 0;
}

/* The slant of the surfaces that a place stands for. */
static inline int rf_packed_slant(rf_packed p)
{
    int slant = rf_packed_other(p) >> RF_PACKED_SLANT & 0x1ff;
    return slant > RF_MOST_SLANT ? slant - 0x200 : slant;
}

/* What the places of a tile stand for. */
struct rf_tile_surfaces {
    const struct rf_surface *at;
    ptrdiff_t first; /* of them, in the tile's first pixel */
    size_t width;    /* of a row of them */
    const struct rf_splat *others;
    int x, y; /* the tile's first pixel */
};

/* The surface of pixel (x, y) of the tile. */
static inline const struct rf_surface *rf_tile_surface(const struct rf_tile_surfaces *t,
                                                       int x, int y)
{
    return &t->at[t->first + (ptrdiff_t)t->width * y + x];
}

/* The splat that a place of the tile is, or the i-th of its surfaces. */
static inline struct rf_splat rf_packed_splat(const struct rf_tile_surfaces *t,
                                              rf_packed place, int i)
{
    if (rf_packed_n(place) == 0)
        return t->others[rf_packed_other(place) - 1];
    int x = rf_packed_x(place) + i, y = rf_packed_y(place);
    struct rf_splat splat = {.x = t->x + x,
                             .y = t->y + y,
                             .slant = rf_packed_slant(place),
                             .slot = rf_packed_slot(place),
                             .cover = 1};
    memcpy(splat.c, rf_tile_surface(t, x, y)->c, sizeof splat.c);
    return splat;
}

/* The share of T from which a bin covers more than it has: see kernels_tmpl.c. */
static const float RF_RAMP = 0.9f;

/*
 * Where samples of one bin gather: per cell and row, the colour planes and, last, the
 * coverage; RF_ACC_STRIDE columns each, of which the tile is the middle part.
 */
struct rf_spread_sums {
    int n_cells, n_planes; /* planes with coverage */
    int first_colour;      /* of the splats, in the first plane; 0 but for two planes */
    /*
     * [cell][row][plane][RF_ACC_STRIDE], zero between bins. With several cells there is
     * one more, for footprints that all have in common.
     */
    float *at;
    uint32_t
        common_rows; /* a bit for each row that the common one holds something of */
    float share[RF_MAX_CELLS]; /* of each cell in what is common */
    float least[4]; /* that light without coverage has, by plane: at most 0 */
    /*
     * [slant][cell], from -RF_MOST_SLANT on, of cells and what is common: what light
     * and coverage of a slanted surface are multiplied by.
     */
    const float *factors;
    int reach;  /* px that the footprints of the bin reach at the most */
    float ramp; /* RF_RAMP, or INFINITY: the bin covers what it has */
    int first_row,
        last_row; /* rows touched since the last flush; empty: first > last */
};

_Static_assert(RF_TILE_H == 32, "a bit for each row");

static inline int rf_spread_sums_slots(int n_cells)
{
    return n_cells > 1 ? n_cells + 1 : 1;
}

/* Of a slant: one for each cell, and 1 for what is common; NULL: all are 1. */
static inline const float *rf_slant_factors(const struct rf_spread_sums *acc, int slant)
{
    if (slant == 0)
        return NULL;
    return acc->factors + (acc->n_cells + 1) * (slant + RF_MOST_SLANT);
}

/* Transmittance per cell, and sums per cell or over all cells, of a tile of planes. */
struct rf_tile_state {
    float *t;                /* [cell][row][RF_TILE_W] */
    size_t t_row, t_plane;   /* floats from one to the next */
    float *sum;              /* [cell or one][plane][row][RF_TILE_W] */
    size_t row, plane, cell; /* cell 0 where all share the sums */
};

/* Rows of luminance and of what lies around each pixel, to n rounded up to eight. */
struct rf_around {
    const float *luminance, *darkest, *brightest; /* of 5 x 5 pixels */
    const float *nearest, *farthest;              /* radii of 3 x 3 */
};

enum { RF_SIDES_AROUND = 5 };

/*
 * The pixels around one, 5 x 5 of them: a bit for each, i + 5 j for column i of row j
 * from the top left.
 */
struct rf_sides {
    uint32_t far;      /* beyond the threshold */
    uint32_t interior; /* all neighbours are on its own side */
    uint32_t usual;    /* neither below `lowest` nor above `highest` */
};

/*
 * A highlight and what stands before it, as highlights_add.c has it. Places count from
 * the light's pixel: where the light lies must not decide how they are rounded.
 */
enum { RF_LENS_GRID = 64 }; /* cells per axis that say which view to ask */

enum { RF_SHADOW_MARGIN = 8 }; /* floats after a mask that are read and written back */

struct rf_shadows {
    float light_x, light_y, light_r; /* in its pixel; signed radius */
    float disc_r; /* of the disc that is drawn: another where a colour's radii are */
    int x, y;     /* the light's pixel */
    /* Where the view sees the light, and the half extent of the cone per px of r. */
    float seen_x, seen_y, extent_x, extent_y;
    /* From where the light of a lamp's rim comes: compose/lamp_rims.h. */
    float inward_x, inward_y;
    float beside; /* px beside the cone that occluders' middles may lie */
    float nearer; /* an occluder's radius is less by this much */
    float join;   /* pixels of one surface differ by less */
    /* The rows around the one that is cast, NULL where there is none; their length. */
    const float *above, *below;
    int row;
    /* What the view shows of radius q is moved by lens (shift_scale q + shift_bias). */
    float lens_x, lens_y, shift_scale, shift_bias;
    int left, top, width, height; /* the mask's box */
    float *blocked;               /* NULL: only asks */
    /*
     * With several views: which one the mask's columns ask, in rows of RF_SHADOW_MARGIN
     * more than its width, and which of these each row of the mask has; else NULL.
     */
    const unsigned char *views, *views_row;
    int view;
};

/* What pixels of a row have that others lack. */
enum rf_row_kind {
    RF_ROW_FILM = 1,     /* alpha other than 1 */
    RF_ROW_INFINITE = 2, /* values that are not finite */
    RF_ROW_NEGATIVE = 4  /* values below 0 */
};

/* Planar depth in a perspective: what makes a radius of it. */
struct rf_plain_depth {
    double factor, offset, infinity; /* params.depth_scale, _offset, _infinity */
    double bias, scale, most;        /* of the lens */
};

#endif
