/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/header_facts.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "sources/source.h"

static void add(struct header_facts *facts, const struct image_attribute *attribute)
{
    const int n_most = (int)(sizeof(facts->items) / sizeof(facts->items[0]));
    if (facts->n < n_most)
        facts->items[facts->n++] = *attribute;
}

void header_facts_add_text(struct header_facts *facts, const char *name,
                           const char *text)
{
    add(facts, &(struct image_attribute){
                   .name = name, .type = IMAGE_ATTRIBUTE_STRING, .text = text});
}

void header_facts_add_number(struct header_facts *facts, const char *name,
                             double number)
{
    const double most = (double)FLT_MAX; /* of the infinity of a depth */
    add(facts, &(struct image_attribute){.name = name,
                                         .type = IMAGE_ATTRIBUTE_FLOAT,
                                         .number = {fmin(number, most), 0}});
}

void header_facts_add_focus(struct header_facts *facts, double shear_distance)
{
    if (shear_distance > 0)
        header_facts_add_number(facts, rf_param_find("focus-distance")->attribute,
                                shear_distance);
}

static double value_of(const struct rf_params *params, const struct rf_param_info *info)
{
    const char *member = (const char *)params + info->offset;
    return info->type == RF_TYPE_FLOAT ? *(const double *)member
                                       : *(const int32_t *)member;
}

static void add_param(struct header_facts *facts, const struct rf_param_info *info,
                      double value)
{
    if (info->type == RF_TYPE_ENUM)
        header_facts_add_text(facts, info->attribute, info->choices[(int)value].name);
    else if (info->type == RF_TYPE_FLOAT)
        header_facts_add_number(facts, info->attribute, value);
    else
        add(facts, &(struct image_attribute){.name = info->attribute,
                                             .type = IMAGE_ATTRIBUTE_INT,
                                             .number = {value, 0}});
}

/* Has the part that is written the attribute? */
static bool is_carried(const struct source *like, const char *name)
{
    const char *other;
    for (int i = 0; (other = image_attribute_name(like->colour, like->part, i)) != NULL;
         i++)
        if (strcmp(other, name) == 0)
            return true;
    return false;
}

/* Lengths that were given, and then follow from others, as they are in the end. */
static void resolve(const struct source *like, struct rf_params *params)
{
    struct rf_lens lens;
    const struct image_box *box = &like->info.display_window;
    if (rf_lens_init(&lens, params, box->max_x - box->min_x + 1,
                     box->max_y - box->min_y + 1, NULL) != RF_OK)
        return;
    if (params->lens_radius == 0 &&
        is_carried(like, rf_param_find("lens-radius")->attribute))
        params->lens_radius = lens.lens_radius;
    if (params->focal_length_px == 0 &&
        is_carried(like, rf_param_find("focal-length-px")->attribute))
        params->focal_length_px = lens.focal_length_px;
}

/* Does what is carried say another value, or none where one is needed? */
static bool is_wanted(const struct source *like, const struct rf_param_info *info,
                      double used, const struct settings *said)
{
    const bool is_same = used == value_of(&said->params, info);
    const bool is_shown =
        info->group == RF_GROUP_LENS || info->group == RF_GROUP_APERTURE;
    const size_t i = (size_t)(info - rf_param_list(NULL));
    if (is_carried(like, info->attribute))
        return !is_same;
    return is_shown && !(is_same && (said->origins[i] == ORIGIN_DEFAULT ||
                                     is_carried(like, said->sources[i])));
}

void header_facts_add_params(struct header_facts *facts,
                             const struct settings *settings, const struct source *like,
                             bool is_of_other_size)
{
    size_t n;
    char unread[1024];
    const struct rf_param_info *list = rf_param_list(&n);
    const struct rf_param_info *in_px = rf_param_find("focal-length-px");
    struct rf_params used = settings->params;
    struct settings said;
    settings_init(&said);
    if (!settings_read_header(&said, like->colour, like->part, unread, sizeof(unread)))
        settings_init(&said);
    resolve(like, &used);
    for (size_t i = 0; i < n; i++) {
        const double value = value_of(&used, &list[i]);
        if (!(is_of_other_size && &list[i] == in_px) &&
            is_wanted(like, &list[i], value, &said))
            add_param(facts, &list[i], value);
    }
}
