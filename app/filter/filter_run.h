/* SPDX-License-Identifier: Apache-2.0 */
/* One run of the filter, from files to files. */
#ifndef APP_FILTER_RUN_H
#define APP_FILTER_RUN_H

#include "filter/filter_options.h"

struct image_error;
struct settings;

void filter_kept_free(struct filter_kept *kept);

/* `settings` holds the command line and receives the header's facts. An enum app_code.
 */
int filter_run(const struct filter_options *tool, struct settings *settings,
               char *const *paths, int n_paths, struct image_error *error);

#endif
