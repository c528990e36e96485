/* SPDX-License-Identifier: Apache-2.0 */
#include "filter/finish_headers.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image.h"
#include "sources/settings.h"

/* How far numbers of two headers may be apart: they are written with three digits. */
static const double SAME = 0.01;

/* What is told of a lens. */
static const struct {
    const char *key, *name;
} facts[] = {{"focus-distance", "focus distance"},
             {"f-stop", "f-stop"},
             {"lens-radius", "lens radius"}};

bool finish_lens_headers_differ(const struct settings *own, const struct settings *ours,
                                char *text, size_t n_text)
{
    for (size_t i = 0; i < sizeof(facts) / sizeof(facts[0]); i++) {
        double a, b;
        if (settings_origin(own, facts[i].key) != ORIGIN_HEADER ||
            settings_origin(ours, facts[i].key) != ORIGIN_HEADER)
            continue;
        const struct rf_param_info *info = rf_param_find(facts[i].key);
        memcpy(&a, (const char *)&own->params + info->offset, sizeof(a));
        memcpy(&b, (const char *)&ours->params + info->offset, sizeof(b));
        if (fabs(a - b) <= SAME * fmax(fabs(a), fabs(b)))
            continue;
        snprintf(text, n_text, "%s %.4g, and the guide has %.4g", facts[i].name, a, b);
        return true;
    }
    return false;
}

int32_t finish_samples_of(const struct image_input *input, int part)
{
    static const char start[] = "cycles.", end[] = ".samples";
    const char *name, *value;
    long most = 0;
    for (int i = 0; (name = image_attribute_name(input, part, i)) != NULL; i++) {
        const size_t n = strlen(name);
        if (n < sizeof(start) + sizeof(end) ||
            strncmp(name, start, sizeof(start) - 1) != 0 ||
            strcmp(name + n - (sizeof(end) - 1), end) != 0 ||
            !image_attribute_string(input, name, &value))
            continue;
        const long found = strtol(value, NULL, 10);
        most = found > most ? found : most;
    }
    return (int32_t)(most < FINISH_MOST_SAMPLES ? most : FINISH_MOST_SAMPLES);
}
