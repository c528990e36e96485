/* SPDX-License-Identifier: Apache-2.0 */
#include "looks.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "params_file.h"
#include "report.h"

struct look_value {
    const char *key, *value;
};

enum { MOST_VALUES = 6 };

/* Kinds of lenses, none of them one that is sold; docs/looks.md shows them. */
static const struct look {
    const char *name;
    struct look_value values[MOST_VALUES];
} looks[] = {
    {"vintage", /* a portrait lens of the nineteenth century: swirl, bent focus */
     {{"cat-eye", "0.6"}, {"swirl", "0.35"}, {"astigmatism", "-0.15"}}},
    {"anamorphic", /* a scope lens: upright ovals, straight cuts above and below */
     {{"aperture-ratio", "1.8"},
      {"barn-top", "0.6"},
      {"barn-bottom", "0.6"},
      {"lateral-chroma", "0.0008"}}},
    {"fast", /* wide open: lemons towards the corners, coloured rims */
     {{"cat-eye", "0.8"}, {"axial-chroma", "0.7"}}},
    {"bubble", /* a triplet: bright rims behind the focus */
     {{"spherical", "3"}, {"cat-eye", "0.4"}}},
    {"miniature", /* a tilted lens, that makes a town a toy */
     {{"tilt-y", "8"}}},
};

/* Applies a look that comes with the program; false: there is none of that name. */
static bool apply(const char *name, struct settings *settings)
{
    struct rf_error unused;
    for (size_t i = 0; i < sizeof(looks) / sizeof(looks[0]); i++) {
        if (strcmp(looks[i].name, name) != 0)
            continue;
        const struct look_value *v = looks[i].values;
        for (int k = 0; k < MOST_VALUES && v[k].key; k++)
            if (settings_origin(settings, v[k].key) != ORIGIN_COMMAND_LINE)
                settings_set(settings, v[k].key, v[k].value, &unused);
        return true;
    }
    return false;
}

/* The file of a look of the user's; false where there is no folder for it. */
static bool file_of(const char *name, char *path, size_t n_bytes)
{
    const char *home = getenv("XDG_CONFIG_HOME"), *below = "";
    if (!home || !*home) {
        home = getenv("HOME");
        below = "/.config";
    }
    if (!home || !*home || strchr(name, '/'))
        return false;
    const int n =
        snprintf(path, n_bytes, "%s%s/rackfocus/looks/%s.params", home, below, name);
    return n > 0 && (size_t)n < n_bytes;
}

bool look_read(const char *name, struct settings *settings, struct image_error *error)
{
    char path[4096];
    FILE *own = file_of(name, path, sizeof(path)) ? fopen(path, "r") : NULL;
    if (own) {
        fclose(own);
        return params_file_read(path, settings, error);
    }
    if (apply(name, settings))
        return true;
    return set_error(error,
                     "--look %s: there is no such look; there are " LOOK_NAMES
                     ", and your own as rackfocus/looks/%s.params in ~/.config",
                     name, name);
}
