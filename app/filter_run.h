/* SPDX-License-Identifier: Apache-2.0 */
/* One run of the filter, from files to files. */
#ifndef APP_FILTER_RUN_H
#define APP_FILTER_RUN_H

#include <stdbool.h>
#include <stdint.h>

struct image_error;
struct settings;
struct source;

/* The order of the table in filter_run.c. */
#define FILTER_COMPRESSIONS "input|none|rle|zips|zip|piz|pxr24|b44|b44a|dwaa|dwab"

enum filter_type { FILTER_TYPE_HALF, FILTER_TYPE_FLOAT };
enum filter_png_bits { FILTER_PNG_8, FILTER_PNG_16 };

struct filter_options {
    const char *output, *output_coc;
    const char *flattened, *holdout; /* deep input only */
    const char *distribution_image;  /* NULL: none */
    const char *view; /* the one to filter of a multi-view file; NULL: any */
    const char *depth_file, *depth_channel, *layer;
    const char *filter_layers;           /* separated by commas */
    int32_t depth_repair, mist_falloff;  /* as in depth_repair.h */
    const char *params;                  /* file of parameters, or NULL */
    int32_t type, compression, png_bits; /* indices of choices */
    int32_t n_threads;
    int32_t max_memory_mib;  /* 0: no bound */
    const char *aperture_at; /* "X,Y" or NULL */
    bool is_over, is_stereo; /* see filter_many.h */
    bool pass_through, is_quiet;
    bool is_in_sequence; /* other frames are made meanwhile: no bar */
};

/* `settings` holds the command line and receives the header's facts. Messages have been
 * printed; returns an exit code. */
int filter_run(const struct filter_options *tool, struct settings *settings,
               char *const *paths, int n_paths);

/*
 * Writes a filtered picture as filter_run does: windows, channel names and attributes
 * of `source`, and `settings` as what the filter did. `pixels` are those of
 * source_read_colour in layout; they may be changed.
 */
bool filter_write(const struct filter_options *tool, struct settings *settings,
                  const struct source *source, float *pixels,
                  struct image_error *error);

#endif
