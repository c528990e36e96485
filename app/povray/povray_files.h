/* SPDX-License-Identifier: Apache-2.0 */
/* What POV-Ray rendered, as EXR files with the camera's facts in the header. */
#ifndef APP_POVRAY_FILES_H
#define APP_POVRAY_FILES_H

#include "image.h"
#include "povray.h"

/* What a file holds beside the camera's facts. */
enum povray_file {
    POVRAY_FILE_PASSES,   /* colour as half and depth as float */
    POVRAY_FILE_VIEW,     /* the same from a point of the lens, and where that is */
    POVRAY_FILE_COLOUR,   /* colour alone, from a point of the lens */
    POVRAY_FILE_FILTERED, /* colour alone as half; `made` says how it was made */
    POVRAY_FILE_RESULT,   /* colour alone as float; `made` says how it was made */
};

/* Focal length of a perspective camera, px of the passes. */
double povray_file_focal_px(const struct povray_passes *passes);

/* Writes the passes, R G B (A) (Z). `made` may be NULL. */
bool povray_file_write(const char *path, const struct povray_passes *passes,
                       enum povray_file kind, const char *made, int n_threads,
                       struct image_error *error);

/* Is the picture as large as its passes? */
bool povray_file_is_whole(const struct povray_passes *passes);

/*
 * From the filtered passes in the file `from` to the picture: without the border, and
 * with the mean of the samples in each pixel, taken of values^(1 / gamma). `passes`
 * tells of the size and the camera; `to` ends with .exr or .png.
 */
bool povray_file_reduce(const char *from, const char *to,
                        const struct povray_passes *passes, double gamma,
                        const char *made, int n_threads, struct image_error *error);

/*
 * povray_render_views() of 2 to RF_MAX_VIEWS views from rf_lens_points() of a disc,
 * which POV-Ray's lens is, whatever aperture the filter has.
 */
bool povray_files_views(struct povray_scene *scene, int n_views, povray_view_fn receive,
                        void *user, double *total_s, struct povray_error *error);

#endif
