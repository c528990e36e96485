/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What EXR wants alike in all parts of a file: display window, pixel aspect, time code
 * and chromaticities. A file whose parts differ there is opened by no reader. A header
 * without chromaticities means those of Rec. 709.
 */
#include "exr_private.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const float image_rec709[8] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};

/* Chromaticities that differ by less are the same, written with fewer digits. */
static const float SAME_COLOURS = 1e-4f;

/* OpenEXR's own readers look for the time code under the name of its type. */
const char *const image_alike_names[IMAGE_N_ALIKE + 1] = {"chromaticities", "timeCode",
                                                          "timecode", NULL};

bool image_find_chromaticities(const struct image_input *input, int part,
                               float values[8])
{
    const exr_attribute_t *a;
    if (exr_get_attribute_by_name(input->context, part, "chromaticities", &a) !=
            EXR_ERR_SUCCESS ||
        a->type != EXR_ATTR_CHROMATICITIES)
        return false;
    const exr_attr_chromaticities_t *p = a->chromaticities;
    const float given[8] = {p->red_x,  p->red_y,  p->green_x, p->green_y,
                            p->blue_x, p->blue_y, p->white_x, p->white_y};
    memcpy(values, given, sizeof given);
    return true;
}

void image_read_chromaticities(const struct image_input *input, int part, float xy[8])
{
    if (!image_find_chromaticities(input, part, xy))
        memcpy(xy, image_rec709, sizeof image_rec709);
}

bool image_has_other_primaries(const struct image_input *input, int part)
{
    enum { N_PRIMARIES = 6 };             /* x and y of red, green and blue */
    static const float MOST_OFF = 0.015f; /* written with two digits */
    float values[8];
    bool is_other = false;
    if (!image_find_chromaticities(input, part, values))
        return false;
    for (int i = 0; i < N_PRIMARIES; i++)
        is_other |= fabsf(values[i] - image_rec709[i]) > MOST_OFF;
    return is_other;
}

/* Those of the first part that has some, which count for the file. */
static bool chromaticities_of(const struct image_input *input, float values[8])
{
    for (int part = 0; part < input->n_parts; part++)
        if (image_find_chromaticities(input, part, values))
            return true;
    memcpy(values, image_rec709, sizeof image_rec709);
    return false;
}

static void print_chromaticities(bool is_given, const float v[8], char text[128])
{
    if (is_given)
        snprintf(text, 128, "%.4g %.4g %.4g %.4g %.4g %.4g %.4g %.4g", (double)v[0],
                 (double)v[1], (double)v[2], (double)v[3], (double)v[4], (double)v[5],
                 (double)v[6], (double)v[7]);
    else
        snprintf(text, 128, "none, which means Rec. 709");
}

static bool check_window(const struct image_input *a, const struct image_input *b,
                         struct image_error *error)
{
    const struct image_box *p = &a->parts[0].display_window;
    const struct image_box *q = &b->parts[0].display_window;
    return memcmp(p, q, sizeof *p) == 0 ||
           image_fail(error, b->path,
                      "its displayWindow is (%d, %d) to (%d, %d), that of %.300s "
                      "(%d, %d) to (%d, %d)",
                      (int)q->min_x, (int)q->min_y, (int)q->max_x, (int)q->max_y,
                      a->path, (int)p->min_x, (int)p->min_y, (int)p->max_x,
                      (int)p->max_y);
}

static bool check_aspect(const struct image_input *a, const struct image_input *b,
                         struct image_error *error)
{
    const float p = a->parts[0].pixel_aspect, q = b->parts[0].pixel_aspect;
    return p == q || image_fail(error, b->path,
                                "its pixelAspectRatio is %.9g, that of %.300s %.9g",
                                (double)q, a->path, (double)p);
}

/* Where `needs_both`, a file without chromaticities agrees with every other. */
static bool check_colours(const struct image_input *a, const struct image_input *b,
                          bool needs_both, struct image_error *error)
{
    float p[8], q[8], most = 0;
    const bool has_p = chromaticities_of(a, p), has_q = chromaticities_of(b, q);
    for (int i = 0; i < 8; i++)
        most = fmaxf(most, fabsf(p[i] - q[i]));
    if (most < SAME_COLOURS || (needs_both && !(has_p && has_q)))
        return true;
    char own[128], other[128];
    print_chromaticities(has_q, q, own);
    print_chromaticities(has_p, p, other);
    return image_fail(error, b->path, "its chromaticities are %s, those of %.300s %s",
                      own, a->path, other);
}

bool image_check_alike(const struct image_input *a, const struct image_input *b,
                       struct image_error *error)
{
    return check_window(a, b, error) && check_aspect(a, b, error) &&
           check_colours(a, b, false, error);
}

bool image_check_parts(const struct image_input *input, struct image_error *error)
{
    for (int i = 1; i < input->n_parts; i++) {
        const struct image_part_info *a = &input->parts[0], *b = &input->parts[i];
        const bool has_window = memcmp(&a->display_window, &b->display_window,
                                       sizeof a->display_window) == 0;
        if (!has_window || a->pixel_aspect != b->pixel_aspect)
            return image_fail(error, input->path,
                              "the %s of part %d is not that of part 0, as EXR wants "
                              "it: a copy of its parts would be refused by readers",
                              has_window ? "pixelAspectRatio" : "displayWindow", i);
    }
    return true;
}

/* The first of the inputs that has the attribute in its first part; NULL: none has. */
static const exr_attribute_t *first_of(struct image_input *const *inputs, int n,
                                       const char *name)
{
    const exr_attribute_t *a;
    for (int i = 0; i < n; i++)
        if (exr_get_attribute_by_name(inputs[i]->context, 0, name, &a) ==
            EXR_ERR_SUCCESS)
            return a;
    return NULL;
}

bool image_plan_alike(struct image_input *const *inputs, int n,
                      struct image_alike *alike, struct image_error *error)
{
    for (int i = 1; i < n; i++)
        for (int k = 0; k < i; k++)
            if (!check_window(inputs[k], inputs[i], error) ||
                !check_aspect(inputs[k], inputs[i], error) ||
                !check_colours(inputs[k], inputs[i], true, error))
                return false;
    for (int i = 0; i < IMAGE_N_ALIKE; i++)
        alike->values[i] = first_of(inputs, n, image_alike_names[i]);
    return true;
}

exr_result_t image_set_alike(exr_context_t to, int part,
                             const struct image_alike *alike)
{
    exr_result_t result = EXR_ERR_SUCCESS;
    for (int i = 0; i < IMAGE_N_ALIKE && result == EXR_ERR_SUCCESS; i++)
        if (alike->values[i])
            result = image_copy_attribute(to, part, alike->values[i]);
    return result;
}
