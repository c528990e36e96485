/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/looks.h"

#include <ctype.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "file.h"
#include "folder.h"
#include "looks_given.h"
#include "path.h"
#include "sources/params_file.h"

#define ENDING ".params"

/* A look that comes with the program; NULL: there is none of that name. */
static const struct look_given *find_given(const char *name)
{
    for (const struct look_given *look = looks_given; look->name; look++)
        if (strcmp(look->name, name) == 0)
            return look;
    return NULL;
}

/* The folder of the user's looks, with its slash; false where there is none. */
static bool find_folder(char *path, size_t n_bytes)
{
    static const struct {
        const char *variable, *below;
    } places[] = {{"XDG_CONFIG_HOME", ""}, {"APPDATA", ""}, {"HOME", "/.config"}};
    for (size_t i = 0; i < sizeof(places) / sizeof(places[0]); i++) {
        const char *home = getenv(places[i].variable);
        if (!home || !os_path_is_absolute(home)) /* as the XDG specification says */
            continue;
        const int n =
            snprintf(path, n_bytes, "%s%s/rackfocus/looks/", home, places[i].below);
        return n > 0 && (size_t)n < n_bytes;
    }
    return false;
}

bool look_is_given(const char *name)
{
    return find_given(name) != NULL;
}

bool look_path(const char *name, char *path, size_t n_bytes)
{
    if (!find_folder(path, n_bytes) || strchr(name, '/'))
        return false;
    const size_t n = strlen(path);
    const int n_name = snprintf(path + n, n_bytes - n, "%s" ENDING, name);
    return n_name > 0 && (size_t)n_name < n_bytes - n;
}

/* The comment that a look's text begins with, and ends its line. */
static void copy_about(const char *text, char *about, size_t n_bytes)
{
    text += strspn(text, "# ");
    snprintf(about, n_bytes, "%.*s", (int)strcspn(text, "\n"), text);
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
    const struct look_given *look = looks_given;
    for (; look->name && listing.n < most; look++) {
        struct look_about *about = &list[listing.n++];
        *about = (struct look_about){.is_own = false};
        snprintf(about->name, sizeof(about->name), "%s", look->name);
        copy_about(look->text, about->about, sizeof(about->about));
    }
    const int n_given = listing.n;
    if (find_folder(folder, sizeof(folder)))
        os_folder_list(folder, add_own, &listing);
    qsort(list + n_given, (size_t)(listing.n - n_given), sizeof(*list), compare_names);
    return listing.n;
}

/* ---- one look -------------------------------------------------------------------- */

static bool is_good_name(const char *name)
{
    if (!*name || strlen(name) >= sizeof(((struct look_about *)0)->name))
        return false;
    for (; *name; name++)
        if (!isalnum((unsigned char)*name) && !strchr("-_", *name))
            return false;
    return true;
}

/* Is it the path of a file? Names of looks have neither a folder nor an ending. */
static bool is_path(const char *name)
{
    const size_t n = strlen(name), n_ending = strlen(ENDING);
    return strpbrk(name, "/\\") ||
           (n > n_ending && strcmp(name + n - n_ending, ENDING) == 0);
}

/* The looks of the user's by name, as many as there is room for, or where they go. */
static void describe_own(const char *name, char *text, size_t n_bytes)
{
    enum { MOST = 64 };
    struct look_about list[MOST];
    const int n = look_list(list, MOST);
    size_t n_text = 0;
    *text = 0;
    for (int i = 0; i < n; i++) {
        const size_t room = n_bytes - n_text;
        if (!list[i].is_own || look_is_given(list[i].name))
            continue;
        const int n_more =
            snprintf(text + n_text, room, "%s%s", n_text ? ", " : "", list[i].name);
        if (n_more < 0 || (size_t)n_more >= room) {
            text[n_text] = 0;
            return;
        }
        n_text += (size_t)n_more;
    }
    if (n_text == 0)
        snprintf(text, n_bytes, "rackfocus looks --save %s --cat-eye 0.5 keeps one",
                 is_good_name(name) ? name : "NAME");
}

bool look_read(const char *name, struct settings *settings, struct image_error *error)
{
    char path[4096], own[256];
    int n_named = 0;
    if (is_path(name) && !params_file_read(name, settings, &n_named, error))
        return app_missing(error, "look", name);
    if (is_path(name))
        return n_named > 0 || set_error(error, "--look " PARAMS_FILE_IS_EMPTY, name);
    if (look_path(name, path, sizeof(path)) && os_file_facts(path).kind != OS_FILE_NONE)
        return params_file_read(path, settings, NULL, error);
    const struct look_given *given = find_given(name);
    if (given)
        return params_text_read(name, given->text, settings, error);
    describe_own(name, own, sizeof(own));
    return set_error(error,
                     "--look %s: there is no such look; there are " LOOK_NAMES
                     ", and your own: %s",
                     name, own);
}

/* ---- one's own ------------------------------------------------------------------- */

/* Makes the folders of a path; what is wrong shows where the file is written. */
static void make_folders(char *path)
{
    for (char *at = strchr(path + 1, '/'); at; at = strchr(at + 1, '/')) {
        *at = 0;
        os_folder_make(path, OS_FOLDER_PRIVATE);
        *at = '/';
    }
}

/* Does Windows take a file of this name, whatever its ending, for a device? What was
 * written would be lost there, and so would looks that come from other machines. */
static bool is_device(const char *name)
{
    static const char *const devices[] = {"con", "prn", "aux", "nul", "com", "lpt"};
    enum { N_DEVICES = 6, FIRST_NUMBERED = 4, N_LETTERS = 3 };
    char lower[N_LETTERS + 2] = ""; /* a digit more, and the zero */
    size_t n = strlen(name);
    if (n >= sizeof lower)
        return false;
    for (size_t i = 0; i < n; i++)
        lower[i] = (char)tolower((unsigned char)name[i]);
    for (size_t i = 0; i < N_DEVICES; i++)
        if (strncmp(lower, devices[i], N_LETTERS) == 0)
            return i < FIRST_NUMBERED
                       ? n == N_LETTERS
                       : n > N_LETTERS && isdigit((unsigned char)lower[N_LETTERS]);
    return false;
}

bool look_save(const char *name, const struct settings *settings,
               struct image_error *error)
{
    char path[4096];
    if (!is_good_name(name))
        return set_error(
            error, "'%s' is no name of a look; take letters, digits, - and _", name);
    if (is_device(name))
        return set_error(error,
                         "'%s' is the name of a device on Windows, where such a file "
                         "cannot be kept; take another one, such as my-%s",
                         name, name);
    if (!look_path(name, path, sizeof(path)))
        return set_error(error, "none of XDG_CONFIG_HOME, APPDATA and HOME says where "
                                "looks are kept; set one of them");
    make_folders(path);
    return params_file_write(path, settings, error);
}
