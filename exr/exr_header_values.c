/* SPDX-License-Identifier: Apache-2.0 */
/* Values of the header by name, of the file or of one view. */
#include "exr_private.h"

#include <stdio.h>
#include <string.h>

static const exr_attribute_t *attribute_of(const struct image_input *input, int part,
                                           const char *name)
{
    const exr_attribute_t *attribute;
    exr_result_t result =
        exr_get_attribute_by_name(input->context, part, name, &attribute);
    return result == EXR_ERR_SUCCESS ? attribute : NULL;
}

const char *image_attribute_name(const struct image_input *input, int part, int i)
{
    int32_t n = 0;
    const exr_attribute_t *a;
    if (exr_get_attribute_count(input->context, part, &n) != EXR_ERR_SUCCESS || i < 0 ||
        i >= n ||
        exr_get_attribute_by_index(input->context, part, EXR_ATTR_LIST_FILE_ORDER, i,
                                   &a) != EXR_ERR_SUCCESS)
        return NULL;
    return a->name;
}

static bool number_of(const exr_attribute_t *a, double *v)
{
    if (!a)
        return false;
    if (a->type == EXR_ATTR_FLOAT)
        *v = (double)a->f;
    else if (a->type == EXR_ATTR_DOUBLE)
        *v = a->d;
    else if (a->type == EXR_ATTR_INT)
        *v = a->i;
    else
        return false;
    return true;
}

static bool v2f_of(const exr_attribute_t *a, double v[2])
{
    if (!a)
        return false;
    if (a->type == EXR_ATTR_V2F) {
        v[0] = (double)a->v2f->x;
        v[1] = (double)a->v2f->y;
    } else if (a->type == EXR_ATTR_V2D) {
        v[0] = a->v2d->x;
        v[1] = a->v2d->y;
    } else if (a->type == EXR_ATTR_V2I) {
        v[0] = a->v2i->x;
        v[1] = a->v2i->y;
    } else {
        return false;
    }
    return true;
}

bool image_attribute_number(const struct image_input *input, const char *name,
                            double *v)
{
    for (int part = 0; part < input->n_parts; part++)
        if (number_of(attribute_of(input, part, name), v))
            return true;
    return false;
}

bool image_view_number(const struct image_input *input, const char *view,
                       const char *name, double *v)
{
    char own_name[256];
    for (int part = 0; part < input->n_parts; part++)
        if (strcmp(input->parts[part].view, view) == 0 &&
            number_of(attribute_of(input, part, name), v))
            return true;
    snprintf(own_name, sizeof own_name, "%s.%s", name, view);
    return image_attribute_number(input, own_name, v);
}

bool image_view_v2f(const struct image_input *input, const char *view, const char *name,
                    double v[2])
{
    char own_name[256];
    for (int part = 0; part < input->n_parts; part++)
        if (strcmp(input->parts[part].view, view) == 0 &&
            v2f_of(attribute_of(input, part, name), v))
            return true;
    snprintf(own_name, sizeof own_name, "%s.%s", name, view);
    return image_attribute_v2f(input, own_name, v);
}

bool image_attribute_string(const struct image_input *input, const char *name,
                            const char **text)
{
    for (int part = 0; part < input->n_parts; part++) {
        const exr_attribute_t *a = attribute_of(input, part, name);
        if (!a || a->type != EXR_ATTR_STRING || !a->string->str)
            continue;
        *text = a->string->str;
        return true;
    }
    return false;
}

bool image_attribute_v2f(const struct image_input *input, const char *name, double v[2])
{
    for (int part = 0; part < input->n_parts; part++)
        if (v2f_of(attribute_of(input, part, name), v))
            return true;
    return false;
}

bool image_attribute_matrix(const struct image_input *input, const char *name,
                            double m[16])
{
    for (int part = 0; part < input->n_parts; part++) {
        const exr_attribute_t *a = attribute_of(input, part, name);
        if (!a || (a->type != EXR_ATTR_M44F && a->type != EXR_ATTR_M44D))
            continue;
        for (int i = 0; i < 16; i++)
            m[i] = a->type == EXR_ATTR_M44F ? (double)a->m44f->m[i] : a->m44d->m[i];
        return true;
    }
    return false;
}
