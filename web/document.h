/* SPDX-License-Identifier: Apache-2.0 */
/* A picture that a web page has opened: EXR files, what their headers say of the lens,
 * what the reader of the page has set, and the filtered pixels. */
#ifndef WEB_DOCUMENT_H
#define WEB_DOCUMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "pixels/display.h"
#include "pixels/input.h"
#include "sources/settings.h"
#include "sources/source.h"

struct document {
    struct rf_context *context;
    struct tone *tone;
    struct source source; /* of the first view */
    bool is_open, has_views;
    struct input *input;
    struct settings typed;    /* what was set on the page */
    struct settings settings; /* that and the header's */
    struct rf_params params;  /* fitted to the picture */
    double white;             /* of its light, as rackfocus filter tells it */
    char remark[2400]; /* doubts of the file, what was done to its depth; or "" */
    /* The last picture made: width x height of it, which is `times` smaller. */
    float *pixels;
    int32_t width, height;
    int times;
    uint8_t *rgba; /* what is shown */
    char text[512];
};

/* The text is what the page shows: "FILE: what; way out". */
struct document *document_open(char *const *paths, int n_paths, int n_threads,
                               struct image_error *error);
void document_close(struct document *document); /* may be NULL */

/* Works out settings and params from the header and what was typed. */
bool document_resolve(struct document *document, struct image_error *error);

/* Filters: at best quality, or `times` smaller and quick. */
bool document_render(struct document *document, bool is_best, int times,
                     const struct rf_progress *progress, struct image_error *error);

enum document_show {
    SHOW_PICTURE, /* what document_render() made */
    SHOW_PINHOLE,
    SHOW_DEPTH,
    SHOW_COC,
    SHOW_BAND /* what is in focus in colour */
};

/* 8 bit RGBA of a whole picture; of SHOW_PICTURE width x height, else that of the
 * input. NULL with a message. Belongs to the document. */
const uint8_t *document_show(struct document *document, enum document_show what,
                             double exposure, struct image_error *error);

/* Writes the last picture at best quality as `rackfocus filter` does. */
bool document_save(struct document *document, const char *path,
                   struct image_error *error);

#endif
