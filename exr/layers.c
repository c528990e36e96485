/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the layers of a file, and the colour of one. channel_name.c takes the names of the
 * channels apart, layers_depth.c finds the depth.
 */
#include "layers.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

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

/* "ViewLayer.left" matches ViewLayer.Combined.left.R: whole components, in order. What
 * has no view is of the first. */
static bool is_asked_for(const struct image_input *input, const struct layer_name *name,
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
                    const struct layer_name *name)
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
static int rank_of(const struct layer_name *name)
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
static void format_layer(const struct layer_name *name, int n_components, char *text,
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

/* Which of r g b a (0 to 3) is it in the layer of `first`; -1: none. An alpha may have a
 * layer of its own: alpha.A. */
static int colour_of(const struct layer_name *name, const struct layer_name *first)
{
    const int index = colour_index(name->base);
    if (!layer_is_same_view(name, first))
        return -1;
    if (layer_is_same(name, name->n, first, first->n))
        return index;
    return index == 3 && name->n > 0 &&
                   strcasecmp(name->component[name->n - 1], "alpha") == 0 &&
                   layer_is_same(name, name->n - 1, first, first->n)
               ? 3
               : -1;
}

/* An alpha of the same pixels in a part without a picture; -1: none. */
static int find_lone_alpha(const struct image_input *input,
                           const struct layer_name *first)
{
    const struct image_part_info *own = &input->parts[first->part];
    for (int c = 0; c < input->n_channels && !own->is_deep; c++) {
        const struct image_part_info *part = &input->parts[input->channels[c].part];
        struct layer_name name;
        if (part == own || part->is_deep ||
            memcmp(&part->data_window, &own->data_window, sizeof own->data_window) != 0)
            continue;
        layer_parse(input, c, &name);
        if (colour_of(&name, first) == 3 && !layer_has_sibling(input, &name, "R") &&
            !layer_has_sibling(input, &name, "red"))
            return c;
    }
    return -1;
}

/* Fills r g b a from the layer of `first`; false if one of r g b is missing. */
static bool collect_colour(const struct image_input *input,
                           const struct layer_name *first, struct image_layer *layer)
{
    int found[4] = {-1, -1, -1, -1};
    int begin = input->first_channel[first->part];
    int end = input->first_channel[first->part + 1];
    for (int c = begin; c < end; c++) {
        struct layer_name name;
        layer_parse(input, c, &name);
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
static bool collect_grey(const struct image_input *input,
                         const struct layer_name *first, int channel,
                         struct image_layer *layer)
{
    if (strcmp(first->base, "Y") != 0)
        return false;
    int ry = -1, by = -1;
    layer->r = layer->g = layer->b = channel;
    layer->a = -1;
    for (int c = input->first_channel[first->part];
         c < input->first_channel[first->part + 1]; c++) {
        struct layer_name name;
        layer_parse(input, c, &name);
        if (!layer_is_same_view(&name, first) ||
            !layer_is_same(&name, name.n, first, first->n))
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
                       int channel, const struct layer_name *name)
{
    const bool is_red = colour_index(name->base) == 0;
    if (!is_red &&
        (strcmp(name->base, "Y") != 0 || layer_has_sibling(input, name, "X")))
        return RANK_NONE;
    if ((wanted->layer && !is_asked_for(input, name, wanted->layer)) ||
        (wanted->view && !layer_is_of_view(input, name->view, wanted->view)))
        return RANK_NONE;
    /* "ZDepth.R" is depth in all of R G B. */
    if (name->n > 0 && layer_is_depth_word(name->component[name->n - 1]))
        return RANK_NONE;
    return 2 * rank_of(name) + (is_red ? 0 : RANK_GREY) +
           (is_data(input, channel, name) ? RANK_DATA : 0) +
           !layer_is_of_view(input, name->view, NULL);
}

/* The layer that a red or a grey is of; false where one of its colours is missing. */
static bool collect(const struct image_input *input, const struct layer_name *name,
                    int channel, struct image_layer *layer)
{
    *layer = (struct image_layer){.z = -1, .z_rival = -1};
    return colour_index(name->base) == 0 ? collect_colour(input, name, layer)
                                         : collect_grey(input, name, channel, layer);
}

/* False where there is no room for more; it then ends in ", ...". */
static bool append_layer(const struct layer_name *name, char *text, size_t size)
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
    struct layer_name first, name;
    struct image_layer layer;
    char text[sizeof found->fitting] = "", own[256];
    int n = 0;
    layer_parse(input, found->r, &first);
    format_layer(&first, first.n_named, own, sizeof own);
    for (int c = found->r; c < input->n_channels; c++) {
        layer_parse(input, c, &name);
        const bool is_same = layer_is_same(&name, name.n_named, &first, first.n_named);
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
        struct layer_name name;
        struct image_layer layer;
        layer_parse(input, c, &name);
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

static void list_layers(const struct image_input *input, char *text, size_t size)
{
    size_t n = 0;
    text[0] = '\0';
    for (int c = 0; c < input->n_channels && n + 1 < size; c++) {
        struct layer_name name;
        char layer[256];
        layer_parse(input, c, &name);
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
        layer_full_name(input, c, name, sizeof name);
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
        layer_full_name(input, c, name, sizeof name);
        if (strcmp(name, wanted) == 0)
            return c;
    }
    return -1;
}

/* In a file that is nothing but depth, the first channel of the picture is it. */
static int find_depth_only(const struct image_input *input, const char *view,
                           const struct image_layer *found)
{
    int z = layer_find_depth(input, view, -1);
    if (z < 0)
        z = layer_find_depth_like(input, view, -1);
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
        found->z = layer_find_depth(input, view, found->r);
        found->z_rival =
            layer_find_rival(input, view, found->r, found->z, &found->is_rival_weak);
        if (found->z < 0)
            found->z = layer_find_depth_like(input, view, found->r);
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
