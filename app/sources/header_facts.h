/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the header of a picture that was made of a source says of its lens. All attributes
 * of the source are copied; these win over them, so that nothing is left of what was
 * overruled: a filtered picture as a guide is judged by its header.
 */
#ifndef APP_HEADER_FACTS_H
#define APP_HEADER_FACTS_H

#include <stdbool.h>

#include "image.h"
#include "sources/settings.h"

struct source;

/* All zeros at first; texts and names must stay. */
struct header_facts {
    struct image_attribute items[SETTINGS_MAX_PARAMS + 2];
    int n;
};

void header_facts_add_text(struct header_facts *facts, const char *name,
                           const char *text);
void header_facts_add_number(struct header_facts *facts, const char *name,
                             double number);

/* Adds the focus of a mean of views, the distance of the plane that stays in place in
 * them; 0: none does. */
void header_facts_add_focus(struct header_facts *facts, double shear_distance);

/*
 * Adds rackfocus:* of every parameter whose value is another than the part of `like`
 * says that is written: of those that are there, and of lens and aperture. With
 * is_of_other_size without the focal length in px, which counts those of `like`.
 */
void header_facts_add_params(struct header_facts *facts,
                             const struct settings *settings, const struct source *like,
                             bool is_of_other_size);

#endif
