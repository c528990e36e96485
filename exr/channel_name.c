/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Takes the names of channels apart.
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
 */
#include "layers.h"

#include <stdio.h>
#include <string.h>

bool layer_is_depth_word(const char *word)
{
    static const char *const words[] = {"depth",   "z",          "zdepth", "vrayzdepth",
                                        "zbuffer", "depthlayer", NULL};
    return image_is_one_of(word, words);
}

/* The strings of part p's `multiView`; NULL where it has none. */
const exr_attr_string_vector_t *layer_views(const struct image_input *input, int p)
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
        const exr_attr_string_vector_t *views = layer_views(input, p);
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
    const exr_attr_string_vector_t *views = layer_views(input, 0);
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
bool layer_is_of_view(const struct image_input *input, const char *view,
                      const char *wanted)
{
    const char *first = image_view_name(input, 0);
    if (!wanted)
        return view[0] == '\0' || (first && strcmp(first, view) == 0);
    return strcmp(view[0] || !first ? view : first, wanted) == 0;
}

/* Stored name, with the part's name in front where it says more. */
void layer_full_name(const struct image_input *input, int channel, char *text,
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

void layer_parse(const struct image_input *input, int channel, struct layer_name *name)
{
    memset(name, 0, sizeof *name);
    name->part = input->channels[channel].part;
    name->view = input->parts[name->part].view;
    layer_full_name(input, channel, name->text, sizeof name->text);

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
    struct layer_name name;
    const char *view;
    layer_parse(input, channel, &name);
    for (int i = 0; (view = image_view_name(input, i)) != NULL; i++)
        if (!name.view[0] || strcmp(view, name.view) == 0)
            return view;
    return NULL;
}

bool layer_is_same(const struct layer_name *a, int n_a, const struct layer_name *b,
                   int n_b)
{
    if (n_a != n_b)
        return false;
    for (int i = 0; i < n_a; i++)
        if (strcmp(a->component[i], b->component[i]) != 0)
            return false;
    return true;
}

bool layer_is_same_view(const struct layer_name *a, const struct layer_name *b)
{
    return strcmp(a->view, b->view) == 0;
}

/* Layers of vectors (normals, positions) end in X Y Z: their Y is no luminance. */
bool layer_has_sibling(const struct image_input *input, const struct layer_name *of,
                       const char *base)
{
    for (int c = input->first_channel[of->part]; c < input->first_channel[of->part + 1];
         c++) {
        struct layer_name name;
        layer_parse(input, c, &name);
        if (strcmp(name.base, base) == 0 && layer_is_same_view(&name, of) &&
            layer_is_same(&name, name.n, of, of->n))
            return true;
    }
    return false;
}
