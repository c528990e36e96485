/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What programs call the layers of a file: which names mean the picture, which mean data
 * that is none. Case does not matter. A name is taken apart into words where its letters
 * end and where a capital follows a small letter:
 *
 *     crypto_object00    crypto object        RenderMan, Arnold, ...
 *     VRayMtlID          VRay Mtl ID
 *     worldNormal        world Normal
 */
#include "exr_private.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

enum { WORD_SIZE = 64 };

bool image_is_one_of(const char *word, const char *const *list)
{
    for (; *list; list++)
        if (strcasecmp(word, *list) == 0)
            return true;
    return false;
}

/* Parts that only repeat what a single-part file says with plain R G B A. */
bool image_means_plain(const char *name)
{
    static const char *const names[] = {"rgba",  "rgb",    "beauty", "main",
                                        "color", "colour", NULL};
    return image_is_one_of(name, names);
}

bool image_means_picture(const char *name)
{
    static const char *const names[] = {"final",  "combined",   "composite", "primary",
                                        "render", "master",     "image",     "C",
                                        "Ci",     "FinalImage", NULL};
    return image_means_plain(name) || image_is_one_of(name, names);
}

/* ---- data ----------------------------------------------------------------------- */

/* Whole names, but for digits: as words of longer ones they mean all sorts of things. */
static const char *const data_names[] = {
    "N",       "Ng",         "Nn",          "Ns",       "Ncam",     "Nworld",
    "P",       "Pref",       "Pcam",        "Pworld",   "UV",       "ST",
    "mv",      "motion",     "DiffCol",     "GlossCol", "TransCol", "IndexOB",
    "IndexMA", "MultiMatte", "PuzzleMatte", "matte",    "mask",     NULL};

/* One of the words. "Composition" is no position. */
static const char *const identifier_words[] = {
    "id", "ids", "objectid", "materialid", "assetid", "instanceid", NULL};
static const char *const data_words[] = {"position", "positions", "worldposition",
                                         NULL};

/* What one of the words ends with. */
static const char *const data_endings[] = {"albedo",  "normal",   "normals", "vector",
                                           "vectors", "velocity", "depth",   NULL};

/* Takes the next word from *at; false: there is none. */
static bool next_word(const char **at, char word[WORD_SIZE])
{
    const char *c = *at;
    size_t n = 0;
    while (*c && !isalpha((unsigned char)*c))
        c++;
    for (; isalpha((unsigned char)*c); c++) {
        if (n > 0 && isupper((unsigned char)*c) && islower((unsigned char)c[-1]))
            break;
        if (n < WORD_SIZE - 1)
            word[n++] = *c;
    }
    word[n] = '\0';
    *at = c;
    return n > 0;
}

static bool ends_with_one_of(const char *word, const char *const *endings)
{
    const size_t n = strlen(word);
    for (; *endings; endings++) {
        const size_t length = strlen(*endings);
        if (n >= length && strcasecmp(word + n - length, *endings) == 0)
            return true;
    }
    return false;
}

/* Is the name one of those, but for what is no letter before and after it? */
static bool is_called(const char *name, const char *const *list)
{
    char text[WORD_SIZE];
    while (*name && !isalpha((unsigned char)*name))
        name++;
    size_t n = strlen(name);
    while (n > 0 && !isalpha((unsigned char)name[n - 1]))
        n--;
    if (n >= sizeof text)
        return false;
    memcpy(text, name, n);
    text[n] = '\0';
    return image_is_one_of(text, list);
}

bool image_means_identifiers(const char *name)
{
    char word[WORD_SIZE];
    if (strcasestr(name, "crypto"))
        return true;
    while (next_word(&name, word))
        if (image_is_one_of(word, identifier_words))
            return true;
    return false;
}

bool image_means_data(const char *name)
{
    char word[WORD_SIZE];
    if (image_means_identifiers(name) || is_called(name, data_names))
        return true;
    while (next_word(&name, word))
        if (image_is_one_of(word, data_words) || ends_with_one_of(word, data_endings))
            return true;
    return false;
}

/* What is told about a depth, or counted beside it. */
static const char *const beside_depth[] = {
    "variance", "var", "deviation", "error", "count", "samples", "mask", "field", NULL};

bool image_means_no_depth(const char *name)
{
    char word[WORD_SIZE];
    if (image_means_identifiers(name))
        return true;
    while (next_word(&name, word))
        if (image_is_one_of(word, beside_depth))
            return true;
    return false;
}

bool image_is_identifier(const struct image_channel_info *channel)
{
    return channel->type == IMAGE_SAMPLE_UINT || image_means_identifiers(channel->name);
}
