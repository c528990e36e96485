/* SPDX-License-Identifier: Apache-2.0 */
#include "looks.h"

#include <ctype.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "folder.h"
#include "params_file.h"
#include "report.h"

struct look_value {
    const char *key, *value;
};

enum { MOST_VALUES = 6 };

#define ENDING ".params"

/* Kinds of lenses, none of them one that is sold; docs/looks.md shows them. */
static const struct look {
    const char *name, *about;
    struct look_value values[MOST_VALUES];
} looks[] = {
    {"vintage",
     "a portrait lens of the nineteenth century: swirl, lemons",
     {{"cat-eye", "0.6"}, {"swirl", "0.35"}, {"astigmatism", "-0.15"}}},
    {"anamorphic",
     "a scope lens: upright ovals, cut above and below",
     {{"aperture-ratio", "1.8"},
      {"barn-top", "0.6"},
      {"barn-bottom", "0.6"},
      {"lateral-chroma", "0.0008"}}},
    {"fast",
     "wide open: lemons towards the corners, coloured rims",
     {{"cat-eye", "0.8"}, {"axial-chroma", "0.7"}}},
    {"bubble",
     "a triplet: bright rims behind the focus",
     {{"spherical", "3"}, {"cat-eye", "0.4"}}},
    {"miniature", "a tilted lens, which makes a town a toy", {{"tilt-y", "8"}}},
};

#define N_LOOKS (sizeof(looks) / sizeof(looks[0]))

/* Applies a look that comes with the program; false: there is none of that name. */
static bool apply(const char *name, struct settings *settings)
{
    struct rf_error unused;
    for (size_t i = 0; i < N_LOOKS; i++) {
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

/* The folder of the user's looks, with its slash; false where there is none. */
static bool find_folder(char *path, size_t n_bytes)
{
    const char *home = getenv("XDG_CONFIG_HOME"), *below = "";
    if (!home || !*home) {
        home = getenv("HOME");
        below = "/.config";
    }
    if (!home || !*home)
        return false;
    const int n = snprintf(path, n_bytes, "%s%s/rackfocus/looks/", home, below);
    return n > 0 && (size_t)n < n_bytes;
}

/* The file of a look of the user's; false where there is no folder for it. */
static bool file_of(const char *name, char *path, size_t n_bytes)
{
    if (!find_folder(path, n_bytes) || strchr(name, '/'))
        return false;
    const size_t n = strlen(path);
    const int n_name = snprintf(path + n, n_bytes - n, "%s" ENDING, name);
    return n_name > 0 && (size_t)n_name < n_bytes - n;
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

/* ---- the list -------------------------------------------------------------------- */

struct listing {
    struct look_about *list;
    int n, most;
};

static bool add_own(void *user, const char *file)
{
    struct listing *listing = user;
    const size_t n = strlen(file), n_ending = strlen(ENDING);
    struct look_about own = {.about = "your own", .is_own = true};
    if (n <= n_ending || n - n_ending >= sizeof(own.name) ||
        strcmp(file + n - n_ending, ENDING) != 0)
        return true;
    memcpy(own.name, file, n - n_ending);
    for (int i = 0; i < listing->n; i++)
        if (strcmp(listing->list[i].name, own.name) == 0) {
            listing->list[i] = own;
            return true;
        }
    if (listing->n < listing->most)
        listing->list[listing->n++] = own;
    return true;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const struct look_about *)a)->name,
                  ((const struct look_about *)b)->name);
}

int look_list(struct look_about *list, int most)
{
    char folder[4096];
    struct listing listing = {.list = list, .most = most};
    for (size_t i = 0; i < N_LOOKS && listing.n < most; i++) {
        struct look_about *about = &list[listing.n++];
        *about = (struct look_about){.about = looks[i].about};
        snprintf(about->name, sizeof(about->name), "%s", looks[i].name);
    }
    const int n_given = listing.n;
    if (find_folder(folder, sizeof(folder)))
        os_folder_list(folder, add_own, &listing);
    qsort(list + n_given, (size_t)(listing.n - n_given), sizeof(*list), compare_names);
    return listing.n;
}

/* ---- one's own ------------------------------------------------------------------- */

static bool is_good_name(const char *name)
{
    if (!*name || strlen(name) >= sizeof(((struct look_about *)0)->name))
        return false;
    for (; *name; name++)
        if (!isalnum((unsigned char)*name) && !strchr("-_", *name))
            return false;
    return true;
}

/* Makes the folders of a path; what is wrong shows where the file is written. */
static void make_folders(char *path)
{
    for (char *at = strchr(path + 1, '/'); at; at = strchr(at + 1, '/')) {
        *at = 0;
        os_folder_make(path, OS_FOLDER_PRIVATE);
        *at = '/';
    }
}

bool look_save(const char *name, const struct settings *settings,
               struct image_error *error)
{
    char path[4096];
    if (!is_good_name(name))
        return set_error(
            error, "'%s' is no name of a look; take letters, digits, - and _", name);
    if (!file_of(name, path, sizeof(path)))
        return set_error(error, "neither XDG_CONFIG_HOME nor HOME says where looks "
                                "are kept; set one of them");
    make_folders(path);
    return params_file_write(path, settings, error);
}
