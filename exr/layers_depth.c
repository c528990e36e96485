/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the depth of a picture among the channels of a file: by the layer and the view that
 * it belongs to, and by how it is spelled.
 *
 * A depth under a name of the program's own (WorldDepth.R, "Z depth.X") serves where it
 * is the only one.
 */
#include "layers.h"

#include <string.h>
#include <strings.h>

/*
 * Number of components that name the layer a depth belongs to (0: the plain one), or -1
 * for a channel that is no depth. "ViewLayer.Depth.Z" belongs to "ViewLayer"; the Z of
 * "ViewLayer.Normal" is refused because of its sibling X.
 */
static int depth_owner(const struct image_input *input, const struct layer_name *name)
{
    static const char *const bases[] = {"Z", "V", "Y", "R", "depth", "distance", NULL};
    if (name->n > 0 && image_means_no_depth(name->component[name->n - 1]))
        return -1;
    if (name->n > 0 && layer_is_depth_word(name->component[name->n - 1]))
        return image_is_one_of(name->base, bases) ? name->n - 1 : -1;
    if (strcasecmp(name->base, "Z") == 0)
        return layer_has_sibling(input, name, "X") ||
                       layer_has_sibling(input, name, "x")
                   ? -1
                   : name->n;
    return strcasecmp(name->base, "Z") != 0 && layer_is_depth_word(name->base) ? name->n
                                                                               : -1;
}

/* A flat picture has no use for the depths of deep samples, nor these for a flat depth. */
static bool is_as_deep(const struct image_input *input, const struct layer_name *depth,
                       const struct layer_name *colour)
{
    return input->parts[depth->part].is_deep == input->parts[colour->part].is_deep;
}

/* How well a depth fits a colour; 0: not at all. */
static int depth_score(const struct image_input *input, const struct layer_name *depth,
                       const struct layer_name *colour)
{
    int n = depth_owner(input, depth);
    if (n < 0)
        return 0;
    if (colour && !layer_is_same_view(depth, colour) && depth->view[0])
        return 0;
    if (colour && !is_as_deep(input, depth, colour))
        return 0;
    /* A Z in float is the depth; other spellings are often copies for viewing. */
    bool is_plain_z = strcasecmp(depth->base, "Z") == 0;
    if (!colour)
        return is_plain_z ? 2 : 1;
    if (layer_is_same(depth, n, colour, colour->n))
        return is_plain_z ? 8 : 7;
    if (colour->n > 0 && layer_is_same(depth, n, colour, colour->n - 1))
        return is_plain_z ? 6 : 5;
    return 1;
}

/* Is a plain Z, without a layer, that of another view? Beside `multiView` what has neither
 * layer nor view is the first view's (OpenEXR, "Multi-View OpenEXR"). */
static bool is_plain_of_other_view(const struct image_input *input, const char *view,
                                   const struct layer_name *name)
{
    return !name->view[0] && name->n == 0 && layer_views(input, name->part) &&
           !layer_is_of_view(input, "", view);
}

/* 2 depth_score() and one more for depth of the same view. `view` may be NULL: any. Where
 * colour and depth have one, depth without serves last. */
static int depth_rank(const struct image_input *input, const char *view,
                      const struct layer_name *depth, const struct layer_name *colour)
{
    if (view && depth->view[0] && !layer_is_of_view(input, depth->view, view))
        return 0;
    const char *own = view || !colour || !colour->view[0] ? view : colour->view;
    if (own && is_plain_of_other_view(input, own, depth))
        return 0;
    const int score = depth_score(input, depth, colour);
    return score > 0 ? 2 * score + (colour && layer_is_same_view(depth, colour)) : 0;
}

int layer_find_depth(const struct image_input *input, const char *view,
                     int colour_channel)
{
    struct layer_name colour, name;
    int best = 0, found = -1;
    bool is_ambiguous = false;

    if (colour_channel >= 0)
        layer_parse(input, colour_channel, &colour);
    for (int c = 0; c < input->n_channels; c++) {
        layer_parse(input, c, &name);
        int rank = depth_rank(input, view, &name, colour_channel >= 0 ? &colour : NULL);
        /* Depth of another layer serves only when there is no choice. */
        is_ambiguous |= rank / 2 == 1 && best / 2 == 1 && colour_channel >= 0;
        if (rank > best) {
            best = rank;
            found = c;
        }
    }
    return best / 2 == 1 && is_ambiguous ? -1 : found;
}

/* Are both channels of one layer that is depth as a whole, as ZDepth.R and ZDepth.V? */
static bool is_one_depth(const struct image_input *input, const struct layer_name *a,
                         const struct layer_name *b)
{
    return layer_is_same(a, a->n, b, b->n) && depth_owner(input, a) < a->n;
}

/* The first channel that layer_find_depth() ranks as high as z, else the first that only its
 * spelling ranks lower; -1: none. */
int layer_find_rival(const struct image_input *input, const char *view,
                     int colour_channel, int z, bool *is_weak)
{
    struct layer_name colour, depth, name;
    int found = -1;
    if (z < 0)
        return -1;
    layer_parse(input, colour_channel, &colour);
    layer_parse(input, z, &depth);
    const int rank = depth_rank(input, view, &depth, &colour);
    const bool has_spellings = depth_score(input, &depth, &colour) % 2 == 0;
    for (int c = 0; c < input->n_channels && rank > 0; c++) {
        layer_parse(input, c, &name);
        const int other = depth_rank(input, view, &name, &colour);
        if (c == z || is_one_depth(input, &name, &depth))
            continue;
        *is_weak = other != rank;
        if (other == rank)
            return c;
        if (found < 0 && has_spellings && other == rank - 2)
            found = c;
    }
    *is_weak = true;
    return found;
}

/* Karma's distance along the ray, which the depth along the axis is better than. */
static bool is_along_ray(const struct layer_name *name)
{
    return strcasestr(name->base, "hitdist") ||
           (name->n && strcasestr(name->component[name->n - 1], "hitdist"));
}

/* Names that speak of depth without being one of the usual ones. */
static bool is_depth_like(const struct image_input *input,
                          const struct layer_name *name)
{
    static const char *const bases[] = {"Z", "V", "Y", "R", "X", "T", "red", NULL};
    static const char *const words[] = {"distance", "Pz",          "hitPz", "ray:hitPz",
                                        "hitdist",  "ray:hitdist", NULL};
    const char *base = name->base, *layer = name->n ? name->component[name->n - 1] : "";
    const bool is_vector =
        (layer_has_sibling(input, name, "X") && layer_has_sibling(input, name, "Z")) ||
        (layer_has_sibling(input, name, "x") && layer_has_sibling(input, name, "z"));
    if (image_means_no_depth(base) || image_means_no_depth(layer) ||
        (name->n > 0 && is_vector))
        return false;
    /* Mitsuba's NAME.T of any name. */
    return strcasestr(base, "depth") || image_is_one_of(base, words) ||
           (name->n > 0 && strcmp(base, "T") == 0) ||
           ((strcasestr(layer, "depth") || image_is_one_of(layer, words)) &&
            image_is_one_of(base, bases));
}

/* The only layer, or channel, that is depth by such a name; -1: none, several, or there
 * are usual ones. Of a colour, if there is one (-1). */
int layer_find_depth_like(const struct image_input *input, const char *view,
                          int colour_channel)
{
    struct layer_name name, first, colour;
    int found = -1;
    if (colour_channel >= 0)
        layer_parse(input, colour_channel, &colour);
    for (int c = 0; c < input->n_channels; c++) {
        layer_parse(input, c, &name);
        if (colour_channel >= 0 && !is_as_deep(input, &name, &colour))
            continue;
        if (depth_owner(input, &name) >= 0)
            return -1;
        if (!is_depth_like(input, &name) || !layer_is_of_view(input, name.view, view))
            continue;
        if (found < 0 || (is_along_ray(&first) && !is_along_ray(&name))) {
            layer_parse(input, c, &first);
            found = c;
        } else if ((name.n == 0 || !layer_is_same(&name, name.n, &first, first.n)) &&
                   is_along_ray(&name) == is_along_ray(&first)) {
            return -1;
        }
    }
    return found;
}
