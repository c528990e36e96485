/* SPDX-License-Identifier: Apache-2.0 */
/*
 * View transforms of OpenColorIO: how scene-linear light is looked at. The first one,
 * NULL, is that of sRGB and always there; without OpenColorIO there is no other. Pictures
 * that are saved do not change.
 *
 * Where they come from: the configuration that is given or that $OCIO names; that of
 * Blender, whose AgX and Filmic it has, where `blender` is found; the output transform
 * of ACES 1.0 for sRGB that the library itself has. Pixels are in the role scene_linear
 * of a configuration; for ACES they have the primaries of Rec. 709.
 */
#ifndef VIEW_COLOUR_H
#define VIEW_COLOUR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { COLOUR_MAX_VIEWS = 24 };

struct colour;

/* The transforms that there are; names as menus show them, the first "sRGB". */
struct colour_list {
    int n;
    char names[COLOUR_MAX_VIEWS][64];
    struct colour *views[COLOUR_MAX_VIEWS]; /* views[0] is NULL */
};

/* `config`: file, NULL: none was given. False with a message where it cannot be read;
 * the list has then what there is without it. */
bool colour_list_make(struct colour_list *list, const char *config, char *text,
                      size_t n_bytes);
void colour_list_free(struct colour_list *list);

/* Gets a transform ready, which takes a moment, before colour_show() has it; NULL is. False
 * with a message where its files are missing. */
bool colour_prepare(struct colour *colour, char *text, size_t n_bytes);

/* n px of 1, 3 or 4 channels times 2^exposure to opaque 8 bit RGBA. Any thread. */
void colour_show(const struct colour *colour, const float *pixels, int n_channels,
                 size_t n, double exposure, uint8_t *rgba);

#ifdef __cplusplus
}
#endif

#endif
