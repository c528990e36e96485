/* SPDX-License-Identifier: Apache-2.0 */
/* The files that a run of the filter writes. */
#ifndef APP_FILTER_OUTPUT_H
#define APP_FILTER_OUTPUT_H

#include "filter/filter_options.h"

struct image_error;
struct settings;
struct source;

/* Refuses outputs that are each other or an input: the picture has no depth, which would
 * be lost. `frames` NULL: no sequence. An enum app_code. */
int filter_check_files(const struct filter_options *tool, char *const *paths,
                       int n_paths, const struct frame_list *frames,
                       struct image_error *error);

/*
 * Writes a filtered picture as filter_run does: windows, channel names and attributes
 * of `source`, and `settings` as what the filter did; with is_of_own_lens the lens is
 * that of `source`. `pixels` are those of source_read_colour in layout; they may be
 * changed.
 */
bool filter_write(const struct filter_options *tool, struct settings *settings,
                  const struct source *source, bool is_of_own_lens, float *pixels,
                  struct image_error *error);

#endif
