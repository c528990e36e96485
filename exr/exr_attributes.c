/* SPDX-License-Identifier: Apache-2.0 */
/* Copies header attributes of any type from an input to a file being written. */
#include "exr_private.h"

#include <stdlib.h>
#include <string.h>

/* Set from the plan of the file, never copied; nor is the state of deep samples, which a
 * flat picture has none of. */
static bool is_structural(const char *name)
{
    static const char *const names[] = {"channels",
                                        "compression",
                                        "dataWindow",
                                        "displayWindow",
                                        "lineOrder",
                                        "pixelAspectRatio",
                                        "screenWindowCenter",
                                        "screenWindowWidth",
                                        "name",
                                        "type",
                                        "version",
                                        "chunkCount",
                                        "maxSamplesPerPixel",
                                        "deepImageState",
                                        "tiles"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (strcmp(name, names[i]) == 0)
            return true;
    return false;
}

/* Size of types that are a fixed block of memory behind a pointer; 0 for the others. */
static size_t block_size(exr_attribute_type_t type)
{
    switch (type) {
    case EXR_ATTR_BOX2I:
        return sizeof(exr_attr_box2i_t);
    case EXR_ATTR_BOX2F:
        return sizeof(exr_attr_box2f_t);
    case EXR_ATTR_CHROMATICITIES:
        return sizeof(exr_attr_chromaticities_t);
    case EXR_ATTR_KEYCODE:
        return sizeof(exr_attr_keycode_t);
    case EXR_ATTR_M33F:
        return sizeof(exr_attr_m33f_t);
    case EXR_ATTR_M33D:
        return sizeof(exr_attr_m33d_t);
    case EXR_ATTR_M44F:
        return sizeof(exr_attr_m44f_t);
    case EXR_ATTR_M44D:
        return sizeof(exr_attr_m44d_t);
    case EXR_ATTR_RATIONAL:
        return sizeof(exr_attr_rational_t);
    case EXR_ATTR_TILEDESC:
        return sizeof(exr_attr_tiledesc_t);
    case EXR_ATTR_TIMECODE:
        return sizeof(exr_attr_timecode_t);
    case EXR_ATTR_V2I:
        return sizeof(exr_attr_v2i_t);
    case EXR_ATTR_V2F:
        return sizeof(exr_attr_v2f_t);
    case EXR_ATTR_V2D:
        return sizeof(exr_attr_v2d_t);
    case EXR_ATTR_V3I:
        return sizeof(exr_attr_v3i_t);
    case EXR_ATTR_V3F:
        return sizeof(exr_attr_v3f_t);
    case EXR_ATTR_V3D:
        return sizeof(exr_attr_v3d_t);
    default:
        return 0;
    }
}

static exr_result_t copy_strings(exr_context_t to, int part, const exr_attribute_t *a)
{
    int n = a->stringvector->n_strings;
    const char **texts = calloc((size_t)n + 1, sizeof *texts);
    if (!texts)
        return EXR_ERR_OUT_OF_MEMORY;
    for (int i = 0; i < n; i++)
        texts[i] =
            a->stringvector->strings[i].str ? a->stringvector->strings[i].str : "";
    exr_result_t result = exr_attr_set_string_vector(to, part, a->name, n, texts);
    free(texts);
    return result;
}

/* Leaves out what OpenEXRCore reads and does not write: of 3.4 the types bytes, whose hint it
 * forgets, and deepImageState. */
exr_result_t image_copy_attribute(exr_context_t to, int part, const exr_attribute_t *a)
{
    static const float no_floats[1];
    exr_attribute_t *made = NULL;
    exr_result_t result;

    switch (a->type) {
    case EXR_ATTR_STRING:
        return exr_attr_set_string(to, part, a->name,
                                   a->string->str ? a->string->str : "");
    case EXR_ATTR_STRING_VECTOR:
        return copy_strings(to, part, a);
    case EXR_ATTR_FLOAT_VECTOR:
        return exr_attr_set_float_vector(to, part, a->name, a->floatvector->length,
                                         a->floatvector->arr ? a->floatvector->arr
                                                             : no_floats);
    case EXR_ATTR_PREVIEW:
        return exr_attr_set_preview(to, part, a->name, a->preview);
    case EXR_ATTR_OPAQUE:
        return exr_attr_set_user(to, part, a->name, a->type_name, a->opaque->size,
                                 a->opaque->packed_data);
    case EXR_ATTR_CHLIST:
        return exr_attr_set_channels(to, part, a->name, a->chlist);
    case EXR_ATTR_COMPRESSION:
    case EXR_ATTR_ENVMAP:
    case EXR_ATTR_LINEORDER:
    case EXR_ATTR_DOUBLE:
    case EXR_ATTR_FLOAT:
    case EXR_ATTR_INT:
        result = exr_attr_declare(to, part, a->name, a->type, &made);
        if (result == EXR_ERR_SUCCESS)
            made->d = a->d; /* the widest of the union's plain values */
        return result;
    default:
        if (block_size(a->type) == 0)
            return EXR_ERR_SUCCESS;
        result = exr_attr_declare(to, part, a->name, a->type, &made);
        if (result == EXR_ERR_SUCCESS)
            memcpy(made->rawptr, a->rawptr, block_size(a->type));
        return result;
    }
}

static exr_result_t set_attribute(exr_context_t to, int part,
                                  const struct image_attribute *a)
{
    switch (a->type) {
    case IMAGE_ATTRIBUTE_FLOAT:
        return exr_attr_set_float(to, part, a->name, (float)a->number[0]);
    case IMAGE_ATTRIBUTE_INT:
        return exr_attr_set_int(to, part, a->name, (int32_t)a->number[0]);
    case IMAGE_ATTRIBUTE_STRING:
        return exr_attr_set_string(to, part, a->name, a->text ? a->text : "");
    case IMAGE_ATTRIBUTE_V2F: {
        exr_attr_v2f_t v;
        v.x = (float)a->number[0];
        v.y = (float)a->number[1];
        return exr_attr_set_v2f(to, part, a->name, &v);
    }
    case IMAGE_ATTRIBUTE_M44F: {
        exr_attr_m44f_t m;
        for (int i = 0; i < 16; i++)
            m.m[i] = (float)a->matrix[i];
        return exr_attr_set_m44f(to, part, a->name, &m);
    }
    }
    return EXR_ERR_INVALID_ARGUMENT;
}

static const struct image_attribute *find_new(const struct image_output *output,
                                              const char *name)
{
    for (int i = 0; i < output->n_attributes; i++)
        if (strcmp(output->attributes[i].name, name) == 0)
            return &output->attributes[i];
    return NULL;
}

exr_result_t image_set_attributes(exr_context_t to, int part,
                                  const struct image_output *output)
{
    exr_result_t result = EXR_ERR_SUCCESS;
    for (int i = 0; i < output->n_attributes && result == EXR_ERR_SUCCESS; i++)
        result = set_attribute(to, part, &output->attributes[i]);
    return result;
}

bool image_is_dropped(const struct image_output *output, const char *name)
{
    for (const char *const *at = output->dropped; at && *at; at++) {
        size_t n = strlen(*at);
        bool is_prefix = n > 0 && (*at)[n - 1] == '*';
        if (is_prefix ? strncmp(name, *at, n - 1) == 0 : strcmp(name, *at) == 0)
            return true;
    }
    return false;
}

exr_result_t image_copy_attributes(exr_context_t to, int part,
                                   const struct image_output *output, int like_part)
{
    exr_const_context_t from = output->like->context;
    int32_t n = 0;
    exr_result_t result = exr_get_attribute_count(from, like_part, &n);
    for (int32_t i = 0; i < n && result == EXR_ERR_SUCCESS; i++) {
        const exr_attribute_t *a;
        result = exr_get_attribute_by_index(from, like_part, EXR_ATTR_LIST_FILE_ORDER,
                                            i, &a);
        if (result != EXR_ERR_SUCCESS || is_structural(a->name) ||
            (like_part == output->like_part && image_is_dropped(output, a->name)))
            continue;
        const struct image_attribute *new_value = find_new(output, a->name);
        if (!new_value)
            result = image_copy_attribute(to, part, a);
        else if (like_part != output->like_part)
            result = set_attribute(to, part, new_value);
    }
    return result;
}
