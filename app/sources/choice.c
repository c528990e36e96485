/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/choice.h"

#include <stdio.h>
#include <string.h>

bool eye_is_named(const char *layer, const char *eye)
{
    const size_t n = strlen(eye);
    for (const char *at = layer; at; at = strchr(at, '.') ? strchr(at, '.') + 1 : NULL)
        if (strncmp(at, eye, n) == 0 && (at[n] == 0 || at[n] == '.'))
            return true;
    return false;
}

static void append(char text[256], const char *word)
{
    const size_t n = strlen(text);
    snprintf(text + n, 256 - n, "%s%s", n > 0 ? ", " : "", word);
}

bool eyes_are_several(const struct image_input *input, const struct image_layer *layer,
                      struct eyes *eyes)
{
    const char *view;
    *eyes = (struct eyes){.taken = image_view_of(input, layer->r)};
    for (int i = 0; eyes->taken && (view = image_view_name(input, i)) != NULL; i++) {
        struct image_layer found;
        struct image_error ignored;
        const bool is_other = strcmp(view, eyes->taken) != 0;
        if (is_other &&
            !image_find_view_layer(input, view, NULL, NULL, false, &found, &ignored))
            continue;
        append(eyes->all, view);
        if (is_other)
            append(eyes->others, view);
    }
    return eyes->others[0] != '\0';
}

bool choice_is_doubtful(const struct image_input *input,
                        const struct image_layer *found, const char *asked, char *text,
                        size_t n_bytes)
{
    struct eyes eyes;
    if (found->fitting[0])
        snprintf(text, n_bytes,
                 "the picture is the first of the layers %s, which fit equally well",
                 found->fitting);
    else if (eyes_are_several(input, found, &eyes) && !eye_is_named(asked, eyes.taken))
        snprintf(text, n_bytes, "holds the views %s; only %s is taken", eyes.all,
                 eyes.taken);
    else
        return false;
    return true;
}
