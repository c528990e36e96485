/* SPDX-License-Identifier: Apache-2.0 */
#include "clear.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "text.h"

/* What mirrors less is seldom so dark that it shows little else (through.c). */
#define LEAST_MIRRORED 0.1
/* Components of a colour from which on it says how much it lets through. */
#define CLEAR_COMPONENTS 4

static bool is_any_word(const struct tokens *tokens, int i, const char *const *words)
{
    for (; *words; words++)
        if (token_is_word(tokens, i, *words))
            return true;
    return false;
}

/* A vector of four or five components at i, the last of them not all 0? */
static bool is_clear_vector(const struct tokens *tokens, int i)
{
    if (!token_is_sign(tokens, i, '<'))
        return false;
    bool lets_through = false;
    int n = 1;
    for (i++; i < tokens->n; i++) {
        if (token_is_sign(tokens, i, '>'))
            return n >= CLEAR_COMPONENTS && n <= 5 && lets_through;
        if (token_is_sign(tokens, i, '(') || token_is_sign(tokens, i, '<')) {
            lets_through |= n >= CLEAR_COMPONENTS;
            i = token_skip_group(tokens, i) - 1;
        } else if (token_is_sign(tokens, i, ',')) {
            n++;
        } else if (tokens->items[i].kind == TOKEN_DIRECTIVE ||
                   token_is_sign(tokens, i, '{') || token_is_sign(tokens, i, '}')) {
            return false; /* "less than" */
        } else if (n >= CLEAR_COMPONENTS) {
            lets_through |= tokens->items[i].kind != TOKEN_NUMBER ||
                            strtod(tokens->text + tokens->items[i].begin, NULL) > 0;
        }
    }
    return false;
}

/* Does the `reflection` at i mirror enough, or an unknown share? */
static bool is_mirror(const struct tokens *tokens, int i)
{
    static const char *const colours[] = {"rgb", "srgb", "color", "colour", NULL};
    static const char *const rest[] = {"fresnel", "falloff", "exponent", "metallic",
                                       NULL};
    int at = i + 1;
    while (is_any_word(tokens, at, colours))
        at++;
    const int end = token_is_sign(tokens, at, '{') ? token_skip_group(tokens, at)
                                                   : token_skip_expression(tokens, at);
    for (i = at; i < end && !is_any_word(tokens, i, rest); i++) {
        const struct token *token = &tokens->items[i];
        if (token->kind == TOKEN_WORD && !is_any_word(tokens, i, colours))
            return true;
        if (token->kind == TOKEN_NUMBER &&
            strtod(tokens->text + token->begin, NULL) >= LEAST_MIRRORED)
            return true;
    }
    return false;
}

/* Does token i say that something is clear or a mirror, without a name? */
static bool is_said_at(const struct tokens *tokens, int i)
{
    static const char *const words[] = {"rgbt",  "rgbf",   "rgbft",  "srgbt",
                                        "srgbf", "srgbft", "filter", "transmit",
                                        "alpha", "png",    NULL};
    return is_any_word(tokens, i, words) || is_clear_vector(tokens, i) ||
           (token_is_word(tokens, i, "reflection") && is_mirror(tokens, i));
}

static int compare(const char *a, size_t n_a, const char *b, size_t n_b)
{
    return n_a != n_b ? (n_a < n_b ? -1 : 1) : memcmp(a, b, n_a);
}

/* Place of a name in the sorted list, or of the first that follows it. */
static int place_of(const struct clear_names *names, const char *name, size_t n)
{
    int low = 0, high = names->n;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (compare(names->names[middle], names->lengths[middle], name, n) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool is_name(const struct clear_names *names, const struct tokens *tokens, int i)
{
    const struct token *token = &tokens->items[i];
    const size_t n = token->end - token->begin;
    const int at = place_of(names, tokens->text + token->begin, n);
    return token->kind == TOKEN_WORD && at < names->n &&
           compare(names->names[at], names->lengths[at], tokens->text + token->begin,
                   n) == 0;
}

static void add_name(struct clear_names *names, const struct tokens *tokens, int i)
{
    const struct token *token = &tokens->items[i];
    const char *name = tokens->text + token->begin;
    const size_t n = token->end - token->begin;
    const int at = place_of(names, name, n);
    const char **longer =
        glue_grow(names->names, (size_t)names->n + 1, sizeof *names->names);
    names->names = longer ? longer : names->names;
    size_t *lengths =
        glue_grow(names->lengths, (size_t)names->n + 1, sizeof *names->lengths);
    names->lengths = lengths ? lengths : names->lengths;
    if (!longer || !lengths)
        return;
    memmove(longer + at + 1, longer + at, (size_t)(names->n - at) * sizeof *longer);
    memmove(lengths + at + 1, lengths + at, (size_t)(names->n - at) * sizeof *lengths);
    longer[at] = name;
    lengths[at] = n;
    names->n++;
}

void clear_note_declared(struct clear_names *names, const struct tokens *tokens)
{
    for (int i = 0; i < tokens->n; i++) {
        const bool is_declared = token_is_directive(tokens, i, "declare") ||
                                 token_is_directive(tokens, i, "local");
        if (!is_declared || !token_is_sign(tokens, i + 2, '=') ||
            is_name(names, tokens, i + 1))
            continue;
        /* Without #if and #macro around them the next directive ends a value. */
        for (int k = i + 3; k < tokens->n && tokens->items[k].kind != TOKEN_DIRECTIVE;
             k++)
            if (is_said_at(tokens, k) || is_name(names, tokens, k)) {
                add_name(names, tokens, i + 1);
                break;
            }
    }
}

static bool has_glass(const struct tokens *tokens, int i)
{
    const struct token *token = &tokens->items[i];
    for (size_t at = token->begin; at + 5 <= token->end; at++)
        if (strncasecmp(tokens->text + at, "glass", 5) == 0)
            return true;
    return false;
}

bool clear_is_spoken_of(const struct clear_names *names, const struct tokens *tokens)
{
    for (int i = 0; i < tokens->n; i++)
        if (is_said_at(tokens, i) ||
            (tokens->items[i].kind == TOKEN_WORD &&
             (has_glass(tokens, i) || is_name(names, tokens, i))))
            return true;
    return false;
}

void clear_free(struct clear_names *names)
{
    free(names->names);
    free(names->lengths);
    *names = (struct clear_names){0};
}
