/* SPDX-License-Identifier: Apache-2.0 */
#include "filter/finish_headers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

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
