/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/primaries.h"

#include <math.h>
#include <string.h>

/* Names of spaces by OpenEXR (lin_ap1_scene) and OpenImageIO (ACEScg). */
static const char *find_by_name(const struct image_input *input)
{
    static const char *const names[] = {"colorInteropID", "oiio:ColorSpace"};
    static const char *const words[] = {"aces", "ap0", "ap1", "p3", "2020"};
    const char *space;
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++)
        for (size_t k = 0; k < sizeof(words) / sizeof(words[0]); k++)
            if (image_attribute_string(input, names[i], &space) &&
                strcasestr(space, words[k]))
                return names[i];
    return NULL;
}

static const char chromaticities[] = "chromaticities";

void primaries_read(const struct image_input *input, int part, struct primaries *found)
{
    image_read_chromaticities(input, part, found->xy);
    found->by =
        image_has_other_primaries(input, part) ? chromaticities : find_by_name(input);
}

bool primaries_differ(const struct primaries *a, const struct primaries *b)
{
    static const float MOST_OFF = 0.015f; /* written with two digits, D60 for D65 */
    bool is_off = false;
    for (int i = 0; i < 8; i++)
        is_off |= fabsf(a->xy[i] - b->xy[i]) > MOST_OFF;
    /* Names of spaces tell no more than that they are not Rec. 709. */
    return (a->by == NULL) != (b->by == NULL) ||
           (is_off && a->by == b->by && a->by == chromaticities);
}

int primaries_warn(const struct app_host *host, const char *path,
                   const struct primaries *own, const char *other_path,
                   const struct primaries *other, const char *what,
                   struct image_error *error)
{
    const bool is_own = own->by != NULL;
    if (!primaries_differ(own, other))
        return APP_DONE;
    return app_warn(host, error,
                    "%.300s: its colours have other primaries than those of %.300s, by "
                    "%s in the header of %s, and %s as if they were alike; bring all "
                    "into one space first, of ACEScg: oiiotool FILE --colorconvert "
                    "ACEScg lin_rec709 --eraseattrib chromaticities -o rec709.exr",
                    path, other_path, is_own ? own->by : other->by,
                    is_own ? "the first" : "the second", what);
}
