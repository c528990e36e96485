/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds colour and depth among the channels of a file.
 *
 * Programs write the same picture under many names. Each channel is brought into one
 * form first: dotted components of the layer, a view, and the last component ("base").
 *
 *     stored                                       layer                 view   base
 *     R, Z                                         (none)                       R, Z
 *     ViewLayer.Combined.R         Blender 3, 4    ViewLayer Combined           R
 *     ViewLayer.Combined.left.R    its multi-view  ViewLayer Combined    left   R
 *     R in part ViewLayer.Combined Blender 5       ViewLayer Combined           R
 *     right.R                      multiView       (none)                right  R
 *     depth.Z, ZDepth.R            Nuke, V-Ray     depth, ZDepth                Z, R
 *
 * A depth under a name of the program's own (WorldDepth.R, "Z depth.X") serves where it
 * is the only one.
 */
#include "exr_private.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { MAX_COMPONENTS = 12, NAME_SIZE = 512 };

struct name {
    char text[NAME_SIZE]; /* the components, each ended by 0 */
    const char *component[MAX_COMPONENTS];
    int n;       /* of the layer: without view and base */
    int n_named; /* the same with a part's name that says no more than plain R G B */
    const char *view;
    const char *base;
    int part;
};

/* The word that ends with `word`, as "VRayZDepth" does with "zdepth". */
static bool is_depth_word(const char *word)
{
    static const char *const words[] = {"depth",   "z",          "zdepth", "vrayzdepth",
                                        "zbuffer", "depthlayer", NULL};
    return image_is_one_of(word, words);
}

static int colour_index(const char *base)
{
    static const char *const names[4][3] = {
        {"R", "red", NULL}, {"G", "green", NULL}, {"B", "blue", NULL}, {"A", "alpha"}};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 2; k++)
            if (strcasecmp(base, names[i][k]) == 0)
                return i;
    return -1;
}

/* The strings of part p's `multiView`; NULL where it has none. */
static const exr_attr_string_vector_t *multi_view(const struct image_input *input,
                                                  int p)
{
    const exr_attribute_t *a;
    bool is_found = exr_get_attribute_by_name(input->context, p, "multiView", &a) ==
                        EXR_ERR_SUCCESS &&
                    a->type == EXR_ATTR_STRING_VECTOR;
    return is_found ? a->stringvector : NULL;
}

/* Is `word` a view of the file: in `multiView`, or the view of its part? */
static bool is_view(const struct image_input *input, int part, const char *word)
{
    if (strcmp(input->parts[part].view, word) == 0)
        return true;
    for (int p = 0; p < input->n_parts; p++) {
        const exr_attr_string_vector_t *views = multi_view(input, p);
        for (int i = 0; views && i < views->n_strings; i++)
            if (views->strings[i].str && strcmp(views->strings[i].str, word) == 0)
                return true;
    }
    return false;
}

/* Does an earlier part have the same view? */
static bool is_repeated_view(const struct image_input *input, int part)
{
    for (int p = 0; p < part; p++)
        if (strcmp(input->parts[p].view, input->parts[part].view) == 0)
            return true;
    return false;
}

const char *image_view_name(const struct image_input *input, int i)
{
    const exr_attr_string_vector_t *views = multi_view(input, 0);
    if (i < 0)
        return NULL;
    if (views)
        return i < views->n_strings ? views->strings[i].str : NULL;
    for (int p = 0; p < input->n_parts; p++)
        if (input->parts[p].view[0] && !is_repeated_view(input, p) && i-- == 0)
            return input->parts[p].view;
    return NULL;
}

int image_view_count(const struct image_input *input)
{
    int n = 0;
    while (image_view_name(input, n))
        n++;
    return n;
}

/* What has no view belongs to the first, which is also the one to show. */
static bool is_of_view(const struct image_input *input, const char *view,
                       const char *wanted)
{
    const char *first = image_view_name(input, 0);
    if (!wanted)
        return view[0] == '\0' || (first && strcmp(first, view) == 0);
    return strcmp(view[0] || !first ? view : first, wanted) == 0;
}

/* Stored name, with the part's name in front where it says more. */
static void full_name(const struct image_input *input, int channel, char *text,
                      size_t size)
{
    const struct image_channel_info *info = &input->channels[channel];
    const char *part = input->parts[info->part].name;
    size_t n = strlen(part);
    bool is_repeated = strncmp(info->name, part, n) == 0 && info->name[n] == '.';
    if (input->n_parts == 1 || n == 0 || is_repeated)
        snprintf(text, size, "%s", info->name);
    else
        snprintf(text, size, "%s.%s", part, info->name);
}

static void parse_name(const struct image_input *input, int channel, struct name *name)
{
    memset(name, 0, sizeof *name);
    name->part = input->channels[channel].part;
    name->view = input->parts[name->part].view;
    full_name(input, channel, name->text, sizeof name->text);

    char *word = name->text;
    name->base = word;
    for (;;) {
        char *dot = strchr(word, '.');
        if (!dot || name->n == MAX_COMPONENTS)
            break;
        *dot = '\0';
        if (is_view(input, name->part, word))
            name->view = word;
        else
            name->component[name->n++] = word;
        word = dot + 1;
        name->base = word;
    }
    /* The views of a plain file are parts or prefixes like "left": no layer at all. */
    name->n_named = name->n;
    if (name->n == 1 && image_means_plain(name->component[0]) && input->n_parts > 1)
        name->n = 0;
}

const char *image_view_of(const struct image_input *input, int channel)
{
    struct name name;
    const char *view;
    parse_name(input, channel, &name);
    for (int i = 0; (view = image_view_name(input, i)) != NULL; i++)
        if (!name.view[0] || strcmp(view, name.view) == 0)
            return view;
    return NULL;
}

static bool is_same_layer(const struct name *a, int n_a, const struct name *b, int n_b)
{
    if (n_a != n_b)
        return false;
    for (int i = 0; i < n_a; i++)
        if (strcmp(a->component[i], b->component[i]) != 0)
            return false;
    return true;
}

static bool is_same_view(const struct name *a, const struct name *b)
{
    return strcmp(a->view, b->view) == 0;
}

/* "ViewLayer.left" matches ViewLayer.Combined.left.R: whole components, in order. What
 * has no view is of the first. */
static bool is_asked_for(const struct image_input *input, const struct name *name,
                         const char *layer)
{
    const char *first = image_view_name(input, 0);
    const char *view = name->view[0] || !first ? name->view : first;
    const char *words[MAX_COMPONENTS + 1];
    int n = 0;
    for (int i = 0; i < name->n_named; i++)
        words[n++] = name->component[i];
    if (view[0])
        words[n++] = view;

    for (int i = 0; *layer;) {
        size_t length = strcspn(layer, ".");
        while (i < n &&
               (strncmp(words[i], layer, length) != 0 || words[i][length] != '\0'))
            i++;
        if (i++ == n)
            return false;
        layer += length + (layer[length] == '.');
    }
    return true;
}

/* Identifiers are told by all of the name, as of the part "Cryptomatte". */
static bool is_data(const struct image_input *input, int channel,
                    const struct name *name)
{
    if (name->n == 0 || image_means_picture(name->component[name->n - 1]))
        return false;
    for (int i = 0; i < name->n; i++)
        if (image_means_identifiers(name->component[i]))
            return true;
    return image_means_data(name->component[name->n - 1]) ||
           input->channels[channel].type == IMAGE_SAMPLE_UINT;
}

/* Lower is better; the order that the header promises. */
static int rank_of(const struct name *name)
{
    bool is_combined =
        name->n > 0 && strcmp(name->component[name->n - 1], "Combined") == 0;
    bool is_composite = name->n > 0 && strcmp(name->component[0], "Composite") == 0;
    if (name->n == 0)
        return 0;
    if (is_combined && !is_composite)
        return 1;
    if (is_composite)
        return 2;
    return image_means_picture(name->component[name->n - 1]) ? 3 : 4;
}

/* The first n components and the view. */
static void format_layer(const struct name *name, int n_components, char *text,
                         size_t size)
{
    size_t n = 0;
    text[0] = '\0';
    for (int i = 0; i <= n_components; i++) {
        const char *word = i < n_components ? name->component[i] : name->view;
        if (word[0] && n < size)
            n += (size_t)snprintf(text + n, size - n, "%s%s", n ? "." : "", word);
    }
}

/* Layers of vectors (normals, positions) end in X Y Z: their Y is no luminance. */
static bool has_sibling(const struct image_input *input, const struct name *of,
                        const char *base)
{
    for (int c = input->first_channel[of->part]; c < input->first_channel[of->part + 1];
         c++) {
        struct name name;
        parse_name(input, c, &name);
        if (strcmp(name.base, base) == 0 && is_same_view(&name, of) &&
            is_same_layer(&name, name.n, of, of->n))
            return true;
    }
    return false;
}

/* Which of r g b a (0 to 3) is it in the layer of `first`; -1: none. An alpha may have a
 * layer of its own: alpha.A. */
static int colour_of(const struct name *name, const struct name *first)
{
    const int index = colour_index(name->base);
    if (!is_same_view(name, first))
        return -1;
    if (is_same_layer(name, name->n, first, first->n))
        return index;
    return index == 3 && name->n > 0 &&
                   strcasecmp(name->component[name->n - 1], "alpha") == 0 &&
                   is_same_layer(name, name->n - 1, first, first->n)
               ? 3
               : -1;
}

/* An alpha of the same pixels in a part without a picture; -1: none. */
static int find_lone_alpha(const struct image_input *input, const struct name *first)
{
    const struct image_part_info *own = &input->parts[first->part];
    for (int c = 0; c < input->n_channels && !own->is_deep; c++) {
        const struct image_part_info *part = &input->parts[input->channels[c].part];
        struct name name;
        if (part == own || part->is_deep ||
            memcmp(&part->data_window, &own->data_window, sizeof own->data_window) != 0)
            continue;
        parse_name(input, c, &name);
        if (colour_of(&name, first) == 3 && !has_sibling(input, &name, "R") &&
            !has_sibling(input, &name, "red"))
            return c;
    }
    return -1;
}

/* Fills r g b a from the layer of `first`; false if one of r g b is missing. */
static bool collect_colour(const struct image_input *input, const struct name *first,
                           struct image_layer *layer)
{
    int found[4] = {-1, -1, -1, -1};
    int begin = input->first_channel[first->part];
    int end = input->first_channel[first->part + 1];
    for (int c = begin; c < end; c++) {
        struct name name;
        parse_name(input, c, &name);
        int index = colour_of(&name, first);
        if (index >= 0 && found[index] < 0)
            found[index] = c;
    }
    if (found[0] < 0 || found[1] < 0 || found[2] < 0)
        return false;
    layer->r = found[0];
    layer->g = found[1];
    layer->b = found[2];
    layer->a = found[3] >= 0 ? found[3] : find_lone_alpha(input, first);
    return true;
}

/* Grey: a Y alone. Y with RY and BY is a colour picture in other terms. */
static bool collect_grey(const struct image_input *input, const struct name *first,
                         int channel, struct image_layer *layer)
{
    if (strcmp(first->base, "Y") != 0)
        return false;
    int ry = -1, by = -1;
    layer->r = layer->g = layer->b = channel;
    layer->a = -1;
    for (int c = input->first_channel[first->part];
         c < input->first_channel[first->part + 1]; c++) {
        struct name name;
        parse_name(input, c, &name);
        if (!is_same_view(&name, first) ||
            !is_same_layer(&name, name.n, first, first->n))
            continue;
        if (strcmp(name.base, "RY") == 0)
            ry = c;
        if (strcmp(name.base, "BY") == 0)
            by = c;
        if (strcmp(name.base, "A") == 0)
            layer->a = c;
    }
    layer->is_chroma = ry >= 0 && by >= 0;
    if (layer->is_chroma) {
        layer->g = ry;
        layer->b = by;
    }
    return true;
}

enum { RANK_GREY = 20, RANK_DATA = 100, RANK_NONE = 1000 };

/* What is asked of a colour; each may be NULL. */
struct wanted {
    const char *view, *layer;
};

/* Lower is better; RANK_NONE: a channel that is neither a red nor a grey, or not of what
 * is wanted. */
static int colour_rank(const struct image_input *input, const struct wanted *wanted,
                       int channel, const struct name *name)
{
    const bool is_red = colour_index(name->base) == 0;
    if (!is_red && (strcmp(name->base, "Y") != 0 || has_sibling(input, name, "X")))
        return RANK_NONE;
    if ((wanted->layer && !is_asked_for(input, name, wanted->layer)) ||
        (wanted->view && !is_of_view(input, name->view, wanted->view)))
        return RANK_NONE;
    /* "ZDepth.R" is depth in all of R G B. */
    if (name->n > 0 && is_depth_word(name->component[name->n - 1]))
        return RANK_NONE;
    return 2 * rank_of(name) + (is_red ? 0 : RANK_GREY) +
           (is_data(input, channel, name) ? RANK_DATA : 0) +
           !is_of_view(input, name->view, NULL);
}

/* The layer that a red or a grey is of; false where one of its colours is missing. */
static bool collect(const struct image_input *input, const struct name *name,
                    int channel, struct image_layer *layer)
{
    *layer = (struct image_layer){.z = -1, .z_rival = -1};
    return colour_index(name->base) == 0 ? collect_colour(input, name, layer)
                                         : collect_grey(input, name, channel, layer);
}

/* False where there is no room for more; it then ends in ", ...". */
static bool append_layer(const struct name *name, char *text, size_t size)
{
    char layer[256];
    const size_t n = strlen(text);
    format_layer(name, name->n_named, layer, sizeof layer);
    const char *word = layer[0] ? layer : "(plain R G B)";
    const bool has_room = n + strlen(word) + sizeof ", , ..." < size;
    snprintf(text + n, size - n, "%s%s", n ? ", " : "", has_room ? word : "...");
    return has_room;
}

/* Lists the layers that rank as high as the one found, which is the first of them. */
static void list_fitting(const struct image_input *input, const struct wanted *wanted,
                         int rank, struct image_layer *found)
{
    struct name first, name;
    struct image_layer layer;
    char text[sizeof found->fitting] = "", own[256];
    int n = 0;
    parse_name(input, found->r, &first);
    format_layer(&first, first.n_named, own, sizeof own);
    for (int c = found->r; c < input->n_channels; c++) {
        parse_name(input, c, &name);
        const bool is_same = is_same_layer(&name, name.n_named, &first, first.n_named);
        if (is_same && c != found->r)
            continue;
        if (colour_rank(input, wanted, c, &name) != rank ||
            !collect(input, &name, c, &layer))
            continue;
        n++;
        if (!append_layer(&name, text, sizeof text))
            break;
    }
    const bool is_named = wanted->layer && strcmp(wanted->layer, own) == 0;
    if (n > 1 && !is_named)
        memcpy(found->fitting, text, sizeof text);
}

static bool find_colour(const struct image_input *input, const struct wanted *wanted,
                        struct image_layer *found)
{
    int best = RANK_NONE;
    for (int c = 0; c < input->n_channels; c++) {
        struct name name;
        struct image_layer layer;
        parse_name(input, c, &name);
        const int rank = colour_rank(input, wanted, c, &name);
        if (rank >= best || !collect(input, &name, c, &layer))
            continue;
        format_layer(&name, name.n, layer.name, sizeof layer.name);
        layer.is_data = !wanted->layer && rank >= RANK_DATA;
        *found = layer;
        best = rank;
    }
    if (best < RANK_NONE)
        list_fitting(input, wanted, best, found);
    return best < RANK_NONE;
}

/*
 * Number of components that name the layer a depth belongs to (0: the plain one), or -1
 * for a channel that is no depth. "ViewLayer.Depth.Z" belongs to "ViewLayer"; the Z of
 * "ViewLayer.Normal" is refused because of its sibling X.
 */
static int depth_owner(const struct image_input *input, const struct name *name)
{
    static const char *const bases[] = {"Z", "V", "Y", "R", "depth", "distance", NULL};
    if (name->n > 0 && image_means_no_depth(name->component[name->n - 1]))
        return -1;
    if (name->n > 0 && is_depth_word(name->component[name->n - 1]))
        return image_is_one_of(name->base, bases) ? name->n - 1 : -1;
    if (strcasecmp(name->base, "Z") == 0)
        return has_sibling(input, name, "X") || has_sibling(input, name, "x") ? -1
                                                                              : name->n;
    return strcasecmp(name->base, "Z") != 0 && is_depth_word(name->base) ? name->n : -1;
}

/* A flat picture has no use for the depths of deep samples, nor these for a flat depth. */
static bool is_as_deep(const struct image_input *input, const struct name *depth,
                       const struct name *colour)
{
    return input->parts[depth->part].is_deep == input->parts[colour->part].is_deep;
}

/* How well a depth fits a colour; 0: not at all. */
static int depth_score(const struct image_input *input, const struct name *depth,
                       const struct name *colour)
{
    int n = depth_owner(input, depth);
    if (n < 0)
        return 0;
    if (colour && !is_same_view(depth, colour) && depth->view[0])
        return 0;
    if (colour && !is_as_deep(input, depth, colour))
        return 0;
    /* A Z in float is the depth; other spellings are often copies for viewing. */
    bool is_plain_z = strcasecmp(depth->base, "Z") == 0;
    if (!colour)
        return is_plain_z ? 2 : 1;
    if (is_same_layer(depth, n, colour, colour->n))
        return is_plain_z ? 8 : 7;
    if (colour->n > 0 && is_same_layer(depth, n, colour, colour->n - 1))
        return is_plain_z ? 6 : 5;
    return 1;
}

/* Is a plain Z, without a layer, that of another view? Beside `multiView` what has neither
 * layer nor view is the first view's (OpenEXR, "Multi-View OpenEXR"). */
static bool is_plain_of_other_view(const struct image_input *input, const char *view,
                                   const struct name *name)
{
    return !name->view[0] && name->n == 0 && multi_view(input, name->part) &&
           !is_of_view(input, "", view);
}

/* 2 depth_score() and one more for depth of the same view. `view` may be NULL: any. Where
 * colour and depth have one, depth without serves last. */
static int depth_rank(const struct image_input *input, const char *view,
                      const struct name *depth, const struct name *colour)
{
    if (view && depth->view[0] && !is_of_view(input, depth->view, view))
        return 0;
    const char *own = view || !colour || !colour->view[0] ? view : colour->view;
    if (own && is_plain_of_other_view(input, own, depth))
        return 0;
    const int score = depth_score(input, depth, colour);
    return score > 0 ? 2 * score + (colour && is_same_view(depth, colour)) : 0;
}

static int find_depth(const struct image_input *input, const char *view,
                      int colour_channel)
{
    struct name colour, name;
    int best = 0, found = -1;
    bool is_ambiguous = false;

    if (colour_channel >= 0)
        parse_name(input, colour_channel, &colour);
    for (int c = 0; c < input->n_channels; c++) {
        parse_name(input, c, &name);
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
static bool is_one_depth(const struct image_input *input, const struct name *a,
                         const struct name *b)
{
    return is_same_layer(a, a->n, b, b->n) && depth_owner(input, a) < a->n;
}

/* The first channel that find_depth() ranks as high as z, else the first that only its
 * spelling ranks lower; -1: none. */
static int find_rival(const struct image_input *input, const char *view,
                      int colour_channel, int z, bool *is_weak)
{
    struct name colour, depth, name;
    int found = -1;
    if (z < 0)
        return -1;
    parse_name(input, colour_channel, &colour);
    parse_name(input, z, &depth);
    const int rank = depth_rank(input, view, &depth, &colour);
    const bool has_spellings = depth_score(input, &depth, &colour) % 2 == 0;
    for (int c = 0; c < input->n_channels && rank > 0; c++) {
        parse_name(input, c, &name);
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
static bool is_along_ray(const struct name *name)
{
    return strcasestr(name->base, "hitdist") ||
           (name->n && strcasestr(name->component[name->n - 1], "hitdist"));
}

/* Names that speak of depth without being one of the usual ones. */
static bool is_depth_like(const struct image_input *input, const struct name *name)
{
    static const char *const bases[] = {"Z", "V", "Y", "R", "X", "T", "red", NULL};
    static const char *const words[] = {"distance", "Pz",          "hitPz", "ray:hitPz",
                                        "hitdist",  "ray:hitdist", NULL};
    const char *base = name->base, *layer = name->n ? name->component[name->n - 1] : "";
    const bool is_vector =
        (has_sibling(input, name, "X") && has_sibling(input, name, "Z")) ||
        (has_sibling(input, name, "x") && has_sibling(input, name, "z"));
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
static int find_depth_like(const struct image_input *input, const char *view,
                           int colour_channel)
{
    struct name name, first, colour;
    int found = -1;
    if (colour_channel >= 0)
        parse_name(input, colour_channel, &colour);
    for (int c = 0; c < input->n_channels; c++) {
        parse_name(input, c, &name);
        if (colour_channel >= 0 && !is_as_deep(input, &name, &colour))
            continue;
        if (depth_owner(input, &name) >= 0)
            return -1;
        if (!is_depth_like(input, &name) || !is_of_view(input, name.view, view))
            continue;
        if (found < 0 || (is_along_ray(&first) && !is_along_ray(&name))) {
            parse_name(input, c, &first);
            found = c;
        } else if ((name.n == 0 || !is_same_layer(&name, name.n, &first, first.n)) &&
                   is_along_ray(&name) == is_along_ray(&first)) {
            return -1;
        }
    }
    return found;
}

static void list_layers(const struct image_input *input, char *text, size_t size)
{
    size_t n = 0;
    text[0] = '\0';
    for (int c = 0; c < input->n_channels && n + 1 < size; c++) {
        struct name name;
        char layer[256];
        parse_name(input, c, &name);
        if (colour_index(name.base) != 0 && strcmp(name.base, "Y") != 0)
            continue;
        format_layer(&name, name.n, layer, sizeof layer);
        n += (size_t)snprintf(text + n, size - n, "%s%s", n ? ", " : "",
                              layer[0] ? layer : "(plain R G B)");
    }
    if (n == 0)
        snprintf(text, size, "none");
}

static void list_channels(const struct image_input *input, char *text, size_t size)
{
    size_t n = 0;
    text[0] = '\0';
    for (int c = 0; c < input->n_channels && n + 1 < size; c++) {
        char name[NAME_SIZE];
        full_name(input, c, name, sizeof name);
        n += (size_t)snprintf(text + n, size - n, "%s%s", n ? ", " : "", name);
    }
}

static int channel_by_name(const struct image_input *input, const char *wanted)
{
    char name[NAME_SIZE];
    for (int c = 0; c < input->n_channels; c++)
        if (strcmp(input->channels[c].name, wanted) == 0)
            return c;
    for (int c = 0; c < input->n_channels; c++) {
        full_name(input, c, name, sizeof name);
        if (strcmp(name, wanted) == 0)
            return c;
    }
    return -1;
}

/* In a file that is nothing but depth, the first channel of the picture is it. */
static int find_depth_only(const struct image_input *input, const char *view,
                           const struct image_layer *found)
{
    int z = find_depth(input, view, -1);
    if (z < 0)
        z = find_depth_like(input, view, -1);
    if (z >= 0)
        return z;
    if (found->r >= 0)
        return found->r;
    return input->n_channels == 1 ? 0 : -1;
}

static bool fail_without_colour(const struct image_input *input, const char *layer,
                                struct image_error *error)
{
    char list[600];
    if (!layer) {
        list_channels(input, list, sizeof list);
        return image_fail(error, input->path,
                          "no R G B channels; channels of the file: %s", list);
    }
    list_layers(input, list, sizeof list);
    return image_fail(error, input->path,
                      "no layer \"%s\" with R G B; layers of the file: %s", layer,
                      list);
}

bool image_find_layer(const struct image_input *input, const char *layer,
                      const char *depth_channel, bool depth_only,
                      struct image_layer *found, struct image_error *error)
{
    return image_find_view_layer(input, NULL, layer, depth_channel, depth_only, found,
                                 error);
}

bool image_find_view_layer(const struct image_input *input, const char *view,
                           const char *layer, const char *depth_channel,
                           bool depth_only, struct image_layer *found,
                           struct image_error *error)
{
    char list[600];
    *found = (struct image_layer){
        .r = -1, .g = -1, .b = -1, .a = -1, .z = -1, .z_rival = -1};
    const struct wanted wanted = {view, layer};
    bool has_colour = find_colour(input, &wanted, found);
    if (!has_colour && !depth_only)
        return fail_without_colour(input, layer, error);

    if (depth_channel) {
        found->z = channel_by_name(input, depth_channel);
        if (found->z >= 0 && found->z == found->a)
            found->a = -1; /* Unreal's captures have the depth there */
        if (found->z >= 0)
            return true;
        list_channels(input, list, sizeof list);
        return image_fail(error, input->path,
                          "no channel \"%s\"; channels of the file: %s", depth_channel,
                          list);
    }
    if (has_colour) {
        found->z = find_depth(input, view, found->r);
        found->z_rival =
            find_rival(input, view, found->r, found->z, &found->is_rival_weak);
        if (found->z < 0)
            found->z = find_depth_like(input, view, found->r);
    }
    if (!depth_only || found->z >= 0)
        return true;
    found->z = find_depth_only(input, view, found);
    if (found->z >= 0)
        return true;
    list_channels(input, list, sizeof list);
    return image_fail(error, input->path,
                      "no depth channel; name it with --depth-channel; channels of "
                      "the file: %s",
                      list);
}
