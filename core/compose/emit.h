/* SPDX-License-Identifier: Apache-2.0 */
/* The samples of a picture of surfaces. */
#ifndef RF_COMPOSE_EMIT_H
#define RF_COMPOSE_EMIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "compose/scene.h"
#include "kernels/data.h"
#include "surfaces/picture.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

/* Calls `visit` for every visible piece of surface of a row. */
typedef void (*rf_visit_fn)(void *user, struct rf_surface *surface, int x, int y,
                            float w);

void rf_picture_visit_row(struct rf_picture *picture, int y, rf_visit_fn visit,
                          void *user);

/* A surface as a sample on its pixel's centre. */
struct rf_sample rf_sample_make(const struct rf_surface *surface, int x, int y,
                                float w);

/*
 * Moves all but the fraction `keep` of a colour into `light`. Coverage stays with the
 * surface.
 */
void rf_take_light(float surface[4], float light[4], float keep);

/* Appends a sample; with out->at NULL only counts. */
void rf_samples_put(struct rf_samples *out, const struct rf_sample *s);

/*
 * Puts the sample of pixel (x, y) into `out` as it is, or as two where it is bright:
 * see enum rf_footprint_kind. With out->at NULL only counts.
 */
void rf_picture_emit(const struct rf_picture *picture, struct rf_sample sample, int x,
                     int y, struct rf_samples *out);

/* Puts the samples of pixel (x, y) into `out`: at most four. */
void rf_picture_emit_pixel(const struct rf_picture *picture, int x, int y,
                           struct rf_samples *out);

/* Does rf_picture_emit() put two samples for a surface of pixel (x, y)? */
bool rf_picture_is_bright(const struct rf_picture *picture,
                          const struct rf_surface *surface, int x, int y);

/* May it, for the near surface of a pixel that is not mixed? At a glance. */
static inline bool rf_picture_may_be_bright(const struct rf_picture *picture, int x,
                                            int y)
{
    const uint64_t *row = picture->others + rf_row_words(picture->width) * (size_t)y;
    return picture->has_alpha || (row[x / 64] >> x % 64 & 1);
}

/* What n <= 64 pixels from (x, y) on have as a source of samples. */
struct rf_emission rf_picture_emission(const struct rf_picture *picture, int x, int y,
                                       int n);

/*
 * Row i of a scene's samples: puts them at `at` and returns how many they are; with
 * `at` NULL how many at the most. Called twice for each row, from any thread.
 */
typedef size_t (*rf_row_fn)(void *user, int i, struct rf_sample *at);

/*
 * Collects rows in their order, the first n_visible to scene->visible, the others to
 * scene->hidden; both lie in *memory, which the caller frees. After a cancel they are
 * incomplete and RF_OK comes back.
 */
rf_result rf_collect_rows(struct rf_scene *scene, int n_visible, int n_rows,
                          rf_row_fn row, void *user, struct rf_sample **memory,
                          struct rf_error *error);

#endif
