/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the writer share: the plan of a file, and what is done with it. */
#ifndef RF_EXR_WRITER_H
#define RF_EXR_WRITER_H

#include "exr_private.h"

struct out_channel {
    const char *name;
    exr_pixel_type_t type;
    int32_t x_sampling, y_sampling;
    uint8_t is_linear;
    int sample;       /* index into the new samples, or -1 */
    int like_channel; /* else: index in the part of the input */
    uint8_t *plane;   /* its samples as stored, of the rows in memory */
};

struct out_part {
    const struct image_output *output;
    int like_part;                   /* of output->like; -1: none */
    const char *name;                /* NULL: as there */
    const struct image_alike *alike; /* of a joined file; NULL: what `like` has */
    bool is_copied;
    int compression;
    exr_attr_box2i_t data_window, display_window;
    float pixel_aspect;
    int n_channels;
    struct out_channel *channels; /* of parts that are not copied */
    const struct out_channel **in_file_order;
    int32_t tile_size;      /* of parts that are not copied; 0: scan lines */
    struct image_rows rows; /* those in memory */
    const float *samples;   /* new ones, from the first of those rows */
};

struct writer {
    const struct image_output
        *output; /* of all parts; of a joined file, of the first */
    const char *path;
    int n_threads;
    exr_context_t context;
    struct os_replace file;
    int write_errno;
    int n_parts;
    struct out_part *parts;
    struct image_error *error;
};

/* ---- exr_write_plan.c ------------------------------------------------------------ */

/* Always false, with the words for what the core or the system said. */
bool writer_fail(struct writer *w, exr_result_t result);
bool writer_check(const struct image_output *output, const char *path,
                  struct image_error *error);
/* Fills parts from w->output. */
bool writer_plan(struct writer *w);
/* Windows and aspect of a part, from its input or else its output. */
void writer_plan_windows(const struct image_output *output, struct out_part *part);
bool writer_write_header(struct writer *w);
void writer_free_plan(struct writer *w);

/* ---- exr_write_chunks.c ---------------------------------------------------------- */

/* Parts first to end - 1, copied or made of output->samples. */
bool writer_write_parts(struct writer *w, int first, int end);
/* To be called once for a part before its rows are made. */
bool writer_find_file_order(struct writer *w, int index);
/* Rows of a part, from the first row of a chunk; samples are those of the rows. */
bool writer_make_rows(struct writer *w, int index, struct image_rows rows,
                      const float *samples);
/* Rows of a chunk; 0 on failure. */
int32_t writer_row_step(const struct writer *w, int index);
int32_t writer_height(const struct out_part *part);

#endif
