/* SPDX-License-Identifier: Apache-2.0 */
/* How the panel shows each parameter of params.def. */
#ifndef VIEW_FIELDS_H
#define VIEW_FIELDS_H

#include <stdbool.h>

#include "controls/ui.h"
#include "rackfocus/rackfocus.h"

/* Where a parameter stands. Those of FIELD_OWN have rows of their own making. */
enum field_section {
    FIELD_OWN,
    FIELD_CAMERA,
    FIELD_FOCUS_SURFACE,
    FIELD_APERTURE,
    FIELD_CHARACTER,
    FIELD_DEPTH,
    FIELD_METHOD,
};

struct field {
    enum field_section section;
    char label[48];
    const char *unit; /* short; "": none */
    double min, max;  /* of the slider */
    bool is_log;
};

/* A parameter that is in no list of this file stands in the section of its group, with a
 * label and a range made from its row. */
void field_of(const struct rf_param_info *info, struct field *field);

/* The number's control; `units_per_mm` of the scene. */
void field_number(const struct rf_param_info *info, const struct field *field,
                  double units_per_mm, struct ui_number *number);

#endif
