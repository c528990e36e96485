/* SPDX-License-Identifier: Apache-2.0 */
/* The name of a channel, taken apart (channel_name.c), and the depth of a layer
 * (layers_depth.c). */
#ifndef EXR_LAYERS_H
#define EXR_LAYERS_H

#include "exr_private.h"

enum { MAX_COMPONENTS = 12, NAME_SIZE = 512 };

struct layer_name {
    char text[NAME_SIZE]; /* the components, each ended by 0 */
    const char *component[MAX_COMPONENTS];
    int n;       /* of the layer: without view and base */
    int n_named; /* the same with a part's name that says no more than plain R G B */
    const char *view;
    const char *base;
    int part;
};

/* Stored name, with the part's name in front where it says more. */
void layer_full_name(const struct image_input *input, int channel, char *text,
                     size_t size);
void layer_parse(const struct image_input *input, int channel, struct layer_name *name);

/* Are the first n_a components of a the first n_b of b? */
bool layer_is_same(const struct layer_name *a, int n_a, const struct layer_name *b,
                   int n_b);
bool layer_is_same_view(const struct layer_name *a, const struct layer_name *b);

/* Has the layer of a channel, in its part, another channel that ends in `base`? */
bool layer_has_sibling(const struct image_input *input, const struct layer_name *of,
                       const char *base);

/* Is `view` the wanted one (NULL: the first)? What has no view belongs to the first, which
 * is also the one to show. */
bool layer_is_of_view(const struct image_input *input, const char *view,
                      const char *wanted);

/* The strings of part p's `multiView`; NULL where it has none. */
const exr_attr_string_vector_t *layer_views(const struct image_input *input, int p);

/* Is it a word, in any case, by which renderers call a depth? */
bool layer_is_depth_word(const char *word);

/* The depth that fits a colour best, of a view (NULL: any); -1: none, or several that fit
 * but badly. `colour_channel` is its red, -1 in a file without a picture. */
int layer_find_depth(const struct image_input *input, const char *view,
                     int colour_channel);

/* The first channel that fits as well as z, else the first that fits worse by its spelling
 * alone (*is_weak); -1: none. */
int layer_find_rival(const struct image_input *input, const char *view,
                     int colour_channel, int z, bool *is_weak);

/* The only layer, or channel, that speaks of depth by an unusual name; -1: none, several,
 * or there are usual ones. */
int layer_find_depth_like(const struct image_input *input, const char *view,
                          int colour_channel);

#endif
