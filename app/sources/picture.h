/* SPDX-License-Identifier: Apache-2.0 */
/* A whole picture in memory, from an EXR or a PNG file. */
#ifndef APP_PICTURE_H
#define APP_PICTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/report.h"
#include "folder.h"
#include "image.h"
#include "sources/primaries.h"

/* Packed RGB floats, scene-linear, alpha multiplied in. */
struct picture {
    float *samples; /* width * height * 3; free with picture_free */
    int32_t width, height;
    struct image_box window;  /* its data window; all 0 for PNG, which has none */
    struct image_box display; /* the display window, with the same exception */
    bool has_window;
    float pixel_aspect;         /* that of the file; 0 for PNG, which says none */
    struct primaries primaries; /* Rec. 709's for PNG */
    char doubt[400]; /* why another layer may be meant (choice.h); empty: it is not */
};

/* Reads the picture; `layer` may be NULL. NaN and infinity are errors. */
bool picture_read(const char *path, const char *layer, int n_threads,
                  struct picture *picture, struct image_error *error);
void picture_free(struct picture *picture);

/*
 * The samples of another window, packed as those of `own`: 0 where these have none. The
 * caller frees; NULL without memory.
 */
float *picture_show_window(const float *samples, size_t n_channels,
                           const struct image_box *own, const struct image_box *other,
                           struct image_error *error);

/* What two windows have in common; false: nothing. */
bool picture_windows_meet(const struct image_box *a, const struct image_box *b,
                          struct image_box *both);

/* Do two pictures of one size lie at one place? False with both data windows. */
bool picture_check_place(const char *path, const struct image_box *window,
                         const char *other, const struct image_box *other_window,
                         struct image_error *error);

enum picture_kind { PICTURE_EXR, PICTURE_PNG, PICTURE_UNKNOWN };

/* What the end of the name asks for: .exr or .png in any case. */
enum picture_kind picture_kind(const char *path);

/* Does the name end as a picture does that can be written? False with a message that
 * says how to come to what it asks for. */
bool picture_check_kind(const char *path, struct image_error *error);

/* Is this the name of a POV-Ray scene? */
bool picture_is_scene(const char *path);

/* Can a file of this name be made? False with a message, before the work begins. */
bool picture_check_writable(const char *path, struct image_error *error);

/* Makes a folder for pictures if it is not there; `end` says when a new one goes again
 * with the process. False with a message. */
bool picture_need_folder(const char *path, enum os_folder_end end,
                         struct image_error *error);

/* Half floats end at 65504; beyond they would turn into infinity. Clips; returns how
 * many were beyond. */
size_t picture_clip_to_half(float *samples, size_t n);

/* Says that so many were clipped, where any were; see app_warn. */
int picture_warn_clipped(const struct app_host *host, const char *path,
                         size_t n_clipped, struct image_error *error);

#endif
