/* SPDX-License-Identifier: Apache-2.0 */
/* What a run of the filter is asked for. */
#ifndef APP_FILTER_OPTIONS_H
#define APP_FILTER_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct app_host;
struct frame_list;
struct temporal_frames;

/* The order of the table in filter_run.c. */
#define FILTER_COMPRESSIONS "input|none|rle|zips|zip|piz|pxr24|b44|b44a"

enum filter_type { FILTER_TYPE_HALF, FILTER_TYPE_FLOAT };
enum filter_png_bits { FILTER_PNG_8, FILTER_PNG_16 };

/*
 * X(kind, type, name): every option of a run and what it has to do with the result, so
 * that whoever adds one says it, and a sequence that is taken up again (sequence.h)
 * cannot forget it. The kinds:
 *
 *   OUTPUT  a file that is written, or NULL; its name has a place for the frame; these
 *           come first, the picture before all others (filter_check_files())
 *   INPUT   a file that is read, or NULL; another file is another result
 *   INPUTS  the same of several files, separated by commas
 *   INPUT_OR_TEXT  the same of a file or a name within the input
 *   TEXT    a text or NULL, part of the result
 *   NUMBER  likewise a number
 *   ASIDE   the same bits come out whatever it is
 */
#define FILTER_OPTIONS(X)                                                              \
    X(OUTPUT, const char *, output)                                                    \
    X(OUTPUT, const char *, output_coc)                                                \
    X(OUTPUT, const char *, flattened) /* deep input only */                           \
    X(INPUT, const char *, holdout)    /* deep input only */                           \
    X(INPUT, const char *, distribution_image)                                         \
    X(INPUT, const char *, aperture_image)                                             \
    X(INPUT, const char *, depth_file)                                                 \
    X(INPUT, const char *, albedo_file) /* for denoise */                              \
    X(INPUT, const char *, normal_file) /* likewise */                                 \
    X(INPUTS, const char *, reflections_from)                                          \
    X(TEXT, const char *, reflections_at) /* "X,Y[,X,Y ..]" */                         \
    X(INPUT_OR_TEXT, const char *, reflection_depth)                                   \
    X(INPUT_OR_TEXT, const char *, transmission_depth)                                 \
    X(TEXT, const char *, reflection_layers)   /* separated by commas */               \
    X(TEXT, const char *, transmission_layers) /* likewise */                          \
    X(TEXT, const char *, view) /* the one to filter of a multi-view file */           \
    X(TEXT, const char *, depth_channel)                                               \
    X(TEXT, const char *, layer)                                                       \
    X(TEXT, const char *, filter_layers) /* separated by commas */                     \
    X(TEXT, const char *, aperture_at)   /* "X,Y" */                                   \
    X(NUMBER, int32_t, depth_repair)     /* as in depth_repair.h */                    \
    X(NUMBER, int32_t, mist_falloff)     /* likewise */                                \
    X(NUMBER, int32_t, type)             /* enum filter_type */                        \
    X(NUMBER, int32_t, compression)      /* index in FILTER_COMPRESSIONS */            \
    X(NUMBER, int32_t, png_bits)         /* enum filter_png_bits */                    \
    X(NUMBER, bool, is_over)             /* see filter_many.h */                       \
    X(NUMBER, bool, is_stereo)           /* likewise */                                \
    X(NUMBER, bool, pass_through)                                                      \
    X(NUMBER, bool, denoise)            /* see denoise.h */                            \
    X(NUMBER, int32_t, denoise_quality) /* likewise */                                 \
    X(NUMBER, int32_t, supersample)     /* the input is N times larger; 0: 1 */        \
    X(NUMBER, int32_t, pixel_filter)    /* enum filter_pixels, of the supersampled */  \
    X(NUMBER, double, pixel_filter_width) /* px as Cycles has it; 0: its usual one */  \
    X(NUMBER, int32_t, temporal)          /* frames on each side; see temporal.h */    \
    X(ASIDE, const struct temporal_frames *,                                           \
      beside)                            /* those; sequence.c counts them */           \
    X(ASIDE, struct filter_kept *, kept) /* from run to run, or NULL */                \
    X(ASIDE, const char *, params)       /* its values are in the settings */          \
    X(ASIDE, const char *, look)         /* likewise */                                \
    X(ASIDE, const char *, shown_output) /* its name for the user; NULL: output */     \
    X(ASIDE, const char *, scene)        /* whose depth it is, or NULL: its unit and \
                                               kind are known; warnings name it */ \
    X(ASIDE, int32_t, scene_samples)     /* along a side of a pixel of it; 0: 1 */     \
    X(ASIDE, int32_t, n_threads)         /* 0: one per processor */                    \
    X(ASIDE, int32_t, max_memory_mib)    /* 0: no bound */                             \
    X(ASIDE, const struct app_host *, host) /* who asked, or NULL */

struct filter_options {
#define FILTER_MEMBER(kind, type, name) type name;
    FILTER_OPTIONS(FILTER_MEMBER)
#undef FILTER_MEMBER
};

/*
 * The core's context, which runs of one thread hand on to the next: its threads, the
 * memory and the footprints stay. Begins as zeros.
 */
struct filter_kept {
    struct rf_context *context;
    size_t max_bytes; /* of the context */
    struct run *run;  /* whose remarks it makes */
    /* Of the last input's display window, px; 0: there was none. */
    int32_t width, height;
};

#endif
