/* SPDX-License-Identifier: Apache-2.0 */
/* One view on its way to samples: border, surfaces, highlights. */
#ifndef RF_PICTURE_H
#define RF_PICTURE_H

#include "composite.h"
#include "survey.h"

/*
 * A view, continued beyond its border where that is the whole picture's; width and
 * height with it.
 */
struct rf_picture {
    const struct rf_filter *filter;
    int border; /* px, where there is one */
    int x0, y0; /* the view's first pixel: the border, or 0 within a picture */
    int width, height;
    struct rf_pixels pixels;
    struct rf_surfaces surfaces;
    float *darkest; /* plane: least luminance of 5 x 5, premultiplication undone */
    /* A bit for each pixel that is mixed or bright, rows in whole words. */
    uint64_t *others;
    uint64_t *shining; /* the same for those that may be highlights */
    bool has_alpha;    /* some pixel is not opaque */
    bool is_refused;   /* the view's image needs planes: there are no surfaces */
    struct rf_areas areas;
    struct rf_samples highlights;
};

/*
 * Loads a view and splits its edges (if the parameters say so); steps `task` once per
 * row of the padded picture. `border` is what rf_picture_border() says for the largest
 * radius in use. Of the pixels their radii stay, which are those of the near parts by
 * then, with `keeps_pixels` also luminances and rf_split_radius_at(). After a cancel
 * RF_OK comes back and there are no surfaces.
 */
rf_result rf_picture_load(struct rf_picture *picture, const struct rf_filter *filter,
                          const struct rf_work_view *view, int n_planes, int border,
                          bool keeps_pixels, struct rf_task *task,
                          struct rf_error *error);
void rf_picture_free(struct rf_picture *picture);
/*
 * Frees what is kept of the pixels as they came, once edges are split and highlights
 * taken; the radii of the near parts stay.
 */
void rf_picture_drop_pixels(struct rf_picture *picture);

int rf_picture_border(float largest_radius);

/*
 * Takes the light of the highlights out of their surfaces, which keep the usual
 * luminance of the place: what is left can be blended, normalised and continued behind
 * things like any other surface, without doubling a lamp.
 */
rf_result rf_picture_take_highlights(struct rf_picture *picture,
                                     const struct rf_work_view *view, int n_planes,
                                     struct rf_error *error);

/* Calls `visit` for every visible piece of surface of a row. */
typedef void (*rf_visit_fn)(void *user, struct rf_surface *surface, int x, int y,
                            float w);
void rf_picture_visit_row(struct rf_picture *picture, int y, rf_visit_fn visit,
                          void *user);

/* A surface as a sample on its pixel's centre. */
struct rf_sample rf_sample_make(const struct rf_surface *surface, int x, int y,
                                float w);

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
static inline bool rf_picture_may_be_bright(const struct rf_picture *l, int x, int y)
{
    const uint64_t *row = l->others + rf_row_words(l->width) * (size_t)y;
    return l->has_alpha || (row[x / 64] >> x % 64 & 1);
}

/* What n <= 64 pixels from (x, y) on have as a source of samples. */
struct rf_emission rf_picture_survey(const struct rf_picture *picture, int x, int y,
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
