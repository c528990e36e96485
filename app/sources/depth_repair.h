/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depth as renderers write it, made fit for use: what can be undone is undone and said,
 * what cannot be known is refused with the reason.
 */
#ifndef APP_DEPTH_REPAIR_H
#define APP_DEPTH_REPAIR_H

#include <stdbool.h>

#include "sources/depth_numbers.h"
#include "sources/depth_ratio.h"
#include "sources/settings.h"
#include "sources/source.h"

enum depth_repair { DEPTH_REPAIR_AUTO, DEPTH_REPAIR_OFF };

#define DEPTH_REPAIR_CHOICES "auto|off"
#define MIST_CHOICES "none|linear|quadratic|inverse-quadratic"

/* What is seen in a depth, and what filter would do about it. */
struct depth_findings {
    struct rf_depth_stats stats;
    struct depth_numbers numbers;
    /* And is a distance. */
    bool is_premultiplied, is_mixed, is_widened, is_speckled;
    bool is_half;        /* 16 bit */
    double half_step_px; /* largest step of the radius that 16 bit make, 0: unknown */
    bool is_mist;        /* the channel's name says so */
    bool is_kind_open;   /* nobody said which kind of depth it is */
    bool is_negative;    /* all of it, and no --depth-scale that makes it positive */
    bool is_turned;      /* measured and mended with the other sign, by depth_turn() */
    struct depth_ratio ratio; /* in which averages were measured and are mended */
    bool is_named_other;      /* the channel's name says that it holds no distances */
    bool is_position;         /* the third of Px, Py, Pz */
    bool is_of_ray;           /* NAME.T, hitdist, distance: along the ray */
    bool is_whole; /* whole numbers that nobody said the meaning or the scale of */
    bool is_uint;  /* the channel's type */
    /* How a range that goes on beyond 1 becomes one within it, as options; "": it is. */
    char rescaled[160];
    char channel[256], rival[256]; /* names; "": no other may be meant as well */
};

/* Are distances below 0, with a scale that makes them positive? */
bool depth_is_turned(const struct rf_params *params);

/* Numbers before `infinity` with the other sign, so that near is less than far; twice is
 * the same again, but that no hit of -1e10 becomes one of 1e10. */
void depth_turn(float *depth, size_t n, double infinity);

/* What a depth looks like, turned where it is to be, and its averages in numbers whose
 * ratios are those of distances. False without memory. */
bool depth_measure(const struct rf_params *params,
                   const struct rf_depth_channel *channel,
                   struct rf_depth_stats *stats);

/* Into what was measured in the values: what was in depth_ratio_of() them. */
void depth_take_ratios(struct rf_depth_stats *stats,
                       const struct rf_depth_stats *ratios);

/* `channel` has the depth, and the colours where they are known. False without memory.
 */
bool depth_find(struct depth_findings *found, const struct source *source,
                const struct settings *settings, const struct rf_lens *lens,
                const struct rf_depth_channel *channel);

/* The same from what was measured, of depth that was turned where it is to be. */
void depth_judge(struct depth_findings *found, const struct source *source,
                 const struct settings *settings, const struct rf_lens *lens,
                 const struct rf_depth_stats *stats,
                 const struct depth_numbers *numbers);

/* What was done to a depth that is undone, as "the depth was ..."; NULL: nothing. */
const char *depth_fault(const struct depth_findings *found);

/* Why the depth cannot be used as it is, into `text`; false: it can. */
bool depth_is_refused(const struct depth_findings *found, char *text, size_t n_bytes);

/* Why the depth may not be what is meant, into `text`; false: there is no doubt. */
bool depth_is_doubtful(const struct depth_findings *found, char *text, size_t n_bytes);

/* What depth_numbers_explain() says of the numbers of this depth. */
void depth_explain(const struct depth_numbers *numbers, const struct source *source,
                   const struct rf_params *params, char *text, size_t n_bytes);

/* Pixels that were divided by alpha, given the depth of one side, of what they show, and
 * of the surface that they are holes in. */
struct depth_repaired {
    size_t n_divided, n_snapped, n_narrowed, n_filled;
};

/* Fills holes of a depth and moves its edges to those of what is seen, where these were
 * found to differ. Adds to *repaired. False without memory. */
bool depth_move_edges(const struct depth_findings *found,
                      struct rf_depth_channel *channel,
                      struct depth_repaired *repaired);

/*
 * Undoes in the depths of n views what was found in the first of them; `infinity` is
 * params.depth_infinity. What is divided by alpha has colour of four channels. Adds to
 * *repaired. False without memory.
 */
bool depth_undo(const struct depth_findings *found, double infinity,
                const struct rf_view *views, int n, struct depth_repaired *repaired);

/* Views in memory as they were read, and what is known of them. */
struct depth_picture {
    const struct source *source; /* of the first */
    const struct settings *settings;
    const struct rf_params *params; /* fitted to its window */
    const struct rf_view *views;
    int n_views;
};

/* Whom doubts of a depth are told. */
struct depth_listener {
    void (*say)(void *user, const char *text);
    void *user;
};

/* Does with their depth what `rackfocus filter` does: refuses what cannot be meant, says
 * what may not be, undoes what can be and says so in `remark`, "" for nothing. */
bool depth_mend(const struct depth_picture *picture, char *remark, size_t n_bytes,
                struct depth_listener listener, struct image_error *error);

#endif
