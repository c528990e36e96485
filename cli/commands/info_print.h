/* SPDX-License-Identifier: Apache-2.0 */
/* What `rackfocus info` found out, and its two ways of printing it. */
#ifndef CLI_INFO_PRINT_H
#define CLI_INFO_PRINT_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"
#include "sources/depth_repair.h"
#include "sources/settings.h"
#include "sources/source.h"

struct info {
    struct source source;
    struct settings settings;
    struct rf_lens lens;
    bool has_lens, has_stats, has_radii;
    bool is_straight;       /* colour is not multiplied by alpha */
    char lens_problem[256]; /* why there is no lens */
    char radius_problem[1024];
    struct depth_findings depth;
    struct { /* of a deep file */
        size_t n_samples, most_samples, n_volumes;
        size_t n_empty;  /* pixels */
        size_t n_hidden; /* samples behind an opaque one */
    } deep;
    double min_radius_px, max_radius_px; /* signed */
    double sharp_share; /* of the pixels, within the limit of the depth of field */
};

/* Range and share from the radius of every pixel. */
void info_count_radii(struct info *info, const float *radii);

/* The counts of a deep file. */
void info_count_deep(struct info *info, const struct rf_deep *frame);

/* `is_all`: also the parameters that nobody gave. */
void info_print_text(const struct info *info, bool is_all);
void info_print_json(const struct info *info);

#endif
