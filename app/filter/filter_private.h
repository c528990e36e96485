/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of a run of the filter share. */
#ifndef APP_FILTER_PRIVATE_H
#define APP_FILTER_PRIVATE_H

#include "filter/filter_options.h"
#include "filter/seen.h"
#include "filter/temporal.h"
#include "filter/temporal_border.h"
#include "sources/aov.h"
#include "sources/deep.h"
#include "sources/alpha.h"
#include "sources/depth_doubts.h"
#include "sources/depth_fit.h"
#include "sources/depth_repair.h"
#include "sources/settings.h"
#include "sources/source.h"
#include "sources/views.h"
#include "sources/white.h"

/* Everything that one run holds. */
struct run {
    const struct filter_options *tool;
    struct image_error *error;
    int remark; /* APP_DONE, or an error that the core's remarks were to the host */
    struct settings *settings;
    struct rf_params params; /* for the data window: what was given is in settings */
    bool is_of_own_lens; /* the picture was rendered with a lens: of what is written */
    struct source_request request;
    struct source source; /* of the first view where there are several */
    bool has_views;
    struct view_list list;
    struct views views;
    double aperture_at[2]; /* scene units right and up on the lens of the views */
    struct aovs aovs;
    struct seen seen;
    bool is_deep;
    struct deep_frame deep;
    float *colour, *depth;          /* of the first view; colour becomes the result */
    struct rf_image mean_depth;     /* of the only view; data NULL: not known */
    struct temporal_behind *behind; /* of each view; NULL: not asked for */
    struct temporal_border *border; /* NULL: nothing is known beyond it */
    struct filter_kept own;         /* where no other is handed on */
    struct rf_context *context;     /* of that */
    struct rf_filter *filter;
    struct windows *windows; /* NULL: the picture is in memory as a whole (windows.h) */
    int n_threads;
    /* Of the first view, px, negative before the focus; of a picture in windows its
     * largest_radius alone. */
    double least_radius, most_radius, largest_radius;
    double largest_hit; /* where the depth is finite; 0 in windows */
    bool has_radii;
    struct depth_numbers numbers; /* of the first view */
    struct doubts_tally *doubts;  /* NULL: nobody hears of them, or they were told */
    struct alpha_tally alpha;     /* of the first view, where there are doubts */
    struct depth_fit fit;         /* likewise, of a picture in memory */
    double shared_views; /* that show a pixel the same, on average; 0: nobody asked */
};

/* ---- filter_core.c ---------------------------------------------------------------- */

/* The code of what the core said, its words in run->error. */
int filter_fail_core(const struct run *run, const struct rf_error *error);

/* The same of a view that is known, as where the pixels of the others are not at hand.
 */
int filter_fail_view(const struct run *run, int view, const struct rf_error *error);

/* Makes the filter, in place of the one before, and a context where none with that
 * bound was handed on; max_bytes 0: no bound. An enum app_code. */
int filter_make(struct run *run, size_t max_bytes);

/* Is white to be told by the picture? Nobody gave it, and it is read. */
bool filter_needs_white(const struct run *run);

/* Takes the white of a picture of which the pixels were counted; where it is not 1, makes
 * the filter anew. An enum app_code. */
int filter_take_white(struct run *run, const struct white_tally *tally);

static inline int filter_n_views(const struct run *run)
{
    return run->has_views ? run->views.n : 1;
}

/* ---- filter_depth.c: looks at the depth and undoes what can be --------------------
 */

/* Is it looked at? Not where --depth-repair is off, nor where the method needs none. */
bool filter_needs_depth(const struct run *run);

/* What was measured, judged: refused, or remarked on. */
int filter_judge_depth(const struct run *run, const struct rf_depth_stats *stats,
                       struct depth_findings *found);

/* Says what was undone; `repaired` NULL: nobody counted. */
int filter_say_repaired(const struct run *run, const struct depth_findings *found,
                        const struct depth_repaired *repaired);

/* All of it, on pictures in memory. */
int filter_repair_depth(struct run *run);

/* ---- filter_deep.c ---------------------------------------------------------------- */

/* Is the input deep, and is what was asked for possible then? */
int filter_check_deep(struct run *run);

/* Samples, what is told of them, and the flat picture, whose colour makes room for the
 * result. */
int filter_read_deep(struct run *run);

/* ---- filter_remarks.c: nothing silent ---------------------------------------------
 */

/* Parameters that were given and that nothing reads. */
int filter_warn_unread(const struct run *run);

/* Attributes rackfocus:* of the header that nothing reads: misspelt ones. */
int filter_warn_attributes(const struct run *run);

/* A gain or saturation of highlights, of which the picture has none. */
int filter_warn_highlights(const struct run *run);

/* Several layers that may be the picture. */
int filter_warn_choice(const struct run *run);

/* One view of several, without that having been asked for; others that are copied. */
int filter_warn_eyes(const struct run *run);

/* An environment map, which no lens takes. */
int filter_warn_environment(const struct run *run);

/* Warns where discs are round in stored pixels and pixels are not square. */
int filter_warn_aspect(const struct run *run);

/* Of looks that depend on the place, in a picture that is a part of its frame. */
int filter_warn_window(const struct run *run);

/* Other layers of which something is left out that the picture has. */
int filter_warn_layers(const struct run *run);

/* From run->depth, as read. */
void filter_measure_radii(struct run *run);

/* A focus or an aperture that nobody gave: says what was taken and what it does. */
int filter_warn_defaults(const struct run *run);

/* A picture that is no linear light, by its header. */
int filter_warn_coded(const struct run *run);

/* V-Ray's focus distance is that of the camera's target: a guess. */
int filter_warn_target(const struct run *run);

/* An angle of view that is not the one of the header. */
int filter_warn_view(const struct run *run);

/* A unit that nobody gave, with which nothing is blurred. */
int filter_warn_unit_scale(const struct run *run);

/* Depth between ends whose distances nobody gave. */
int filter_warn_ends(const struct run *run);

/* Radii that the largest one cuts, which nobody gave. */
int filter_warn_cut(const struct run *run);

/* A preview of several views, of which none was taken from the aperture's middle. */
int filter_warn_shown_view(const struct run *run);

/* One line: focus, aperture, radii, method. */
void filter_say_done(const struct run *run);

/* ---- filter_doubts.c: depth and alpha that can hardly be what they are taken for --- */

/* Makes run->doubts, where there is somebody to hear of them. */
void filter_begin_doubts(struct run *run);

/* Counts rows of the first view, if there are doubts. */
void filter_count_doubts(struct run *run, const struct doubts_rows *rows,
                         const float *colour);

/* Warns of them; of pictures in windows, whose rows were counted by then. */
int filter_warn_doubts(struct run *run);

/* ---- filter_views_doubts.c: views of other places, or of another exposure --------- */

/* Of pictures in windows, reads rows of all views for it. */
int filter_warn_views(const struct run *run);

/* ---- filter_denoise.c ------------------------------------------------------------ */

/* The lens's picture without grain, in run->colour; `make_picture` makes one of the
 * pixels at hand. */
int denoise_and_filter(struct run *run,
                       int (*make_picture)(struct run *run, float *samples));

/* ---- filter_shrink.c ------------------------------------------------------------- */

/* Does --supersample divide the picture? Before anything is read. */
int filter_check_supersample(const struct run *run);
/* Brings the filtered colour, and what the source says of its size, to the output's. */
int filter_shrink(struct run *run);

/* ---- filter_output.c ------------------------------------------------------------- */

/* Takes from a description what the lens's picture does not have: it is no view, and
 * has no name among others. Adds what the header says of the lens. */
void filter_drop_view(const struct run *run, struct source_description *to);

/* What the filter did, for the header. */
void filter_describe(const struct run *run, char *text, size_t n_bytes);
/* Of the output, where one was asked for; NULL: that of the input. */
const char *filter_compression(const struct run *run);
/* The picture and, from the depth, which holds radii by then, the radii. */
bool filter_write_files(const struct run *run, struct image_error *error);
/* Colour and depth of a deep input, flat: float, as other filters would want them. */
bool filter_write_flattened(const struct run *run, struct image_error *error);

#endif
