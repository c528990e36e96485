/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the debug stream receives, one record per camera item that POV-Ray parses:
 *
 *     @rf~KEY~VALUE;
 *
 * An item such as `location EXPR` becomes
 *
 *     location #declare RF_=EXPR; RF_ #debug concat("@rf~location~",...)
 *
 * so that POV-Ray evaluates the expression once, where it stands. POV-Ray wraps the
 * stream at 80 columns; records hold no blanks, so that wrapping can be undone.
 */
#include "rewrite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "media.h"

static const char *const vector_items[] = {
    "location", "direction", "right", "up", "sky", "look_at", "focal_point", NULL};
static const char *const number_items[] = {"angle",    "aperture",   "blur_samples",
                                           "variance", "confidence", "h_angle",
                                           "v_angle",  NULL};
static const char *const transform_items[] = {"translate", "rotate", "scale", "matrix",
                                              NULL};
static const char *const type_items[] = {
    "perspective",  "orthographic", "fisheye",   "ultra_wide_angle", "omnimax",
    "panoramic",    "cylinder",     "spherical", "mesh_camera",      "normal",
    "user_defined", "bokeh",        NULL};
/* Words that stand, outside all braces, nowhere but in a camera. */
static const char *const camera_only[] = {
    "location",     "look_at",     "focal_point", "blur_samples", "aperture",
    "orthographic", "perspective", "angle",       "right",        "up",
    "sky",          "direction",   NULL};
static const char *const shapes[] = {"sphere",
                                     "box",
                                     "cone",
                                     "cylinder",
                                     "torus",
                                     "plane",
                                     "union",
                                     "intersection",
                                     "difference",
                                     "merge",
                                     "object",
                                     "blob",
                                     "superellipsoid",
                                     "isosurface",
                                     "quadric",
                                     "cubic",
                                     "quartic",
                                     "poly",
                                     "polynomial",
                                     "prism",
                                     "lathe",
                                     "sor",
                                     "height_field",
                                     "julia_fractal",
                                     "text",
                                     "sphere_sweep",
                                     "parametric",
                                     "mesh",
                                     "mesh2",
                                     "ovus",
                                     NULL};

struct writer {
    struct text *out;
    const struct tokens *tokens;
    const struct rewrite *how;
    size_t copied; /* bytes of the source that are in out */
};

static bool is_hollow_mode(const struct writer *w)
{
    return w->how->mode >= REWRITE_HOLLOW_PLANES &&
           w->how->mode <= REWRITE_HOLLOW_DECLARED;
}

static bool is_any_word(const struct tokens *tokens, int i, const char *const *words)
{
    for (; *words; words++)
        if (token_is_word(tokens, i, *words))
            return true;
    return false;
}

/* An expression that is not closed may have reached beyond `at`. */
static void copy_to(struct writer *w, size_t at)
{
    if (at <= w->copied)
        return;
    text_add(w->out, w->tokens->text + w->copied, at - w->copied);
    w->copied = at;
}

/* Leaves out what comes before `at`, but for its line breaks. */
static void skip_to(struct writer *w, size_t at)
{
    for (; w->copied < at; w->copied++)
        if (w->tokens->text[w->copied] == '\n')
            text_add(w->out, "\n", 1);
}

static const char *or_nothing(const char *text)
{
    return text ? text : "";
}

static size_t begin_of(const struct writer *w, int i)
{
    return w->tokens->items[i].begin;
}

/* End of the last token before i. */
static size_t end_before(const struct writer *w, int i)
{
    return w->tokens->items[i - 1].end;
}

/* NULL without memory, as what else is a name here; or_nothing() is for those. */
static char *token_text(const struct tokens *tokens, int i)
{
    const struct token *token = &tokens->items[i];
    return text_format("%.*s", (int)(token->end - token->begin),
                       tokens->text + token->begin);
}

char *rewrite_include_name(const struct tokens *tokens, int i)
{
    if (i + 1 >= tokens->n || tokens->items[i + 1].kind != TOKEN_STRING)
        return NULL;
    const struct token *token = &tokens->items[i + 1];
    if (token->end - token->begin < 2)
        return NULL;
    return text_format("%.*s", (int)(token->end - token->begin - 2),
                       tokens->text + token->begin + 1);
}

/* Are there camera items outside all blocks, as in a macro that sets up a camera? */
static bool has_loose_items(const struct tokens *tokens, int i, int end)
{
    while (i < end) {
        if (token_is_directive(tokens, i, "macro"))
            i = token_find_end(tokens, i) + 1;
        else if (token_is_sign(tokens, i, '{'))
            i = token_skip_group(tokens, i);
        else if (is_any_word(tokens, i, camera_only))
            return true;
        else
            i++;
    }
    return false;
}

static bool is_item(const struct tokens *tokens, int i)
{
    return is_any_word(tokens, i, vector_items) ||
           is_any_word(tokens, i, number_items) ||
           is_any_word(tokens, i, transform_items) ||
           is_any_word(tokens, i, type_items) || token_is_word(tokens, i, "transform");
}

bool rewrite_makes_transform(const struct tokens *tokens, const char *macro)
{
    bool is_found = false;
    for (int i = 0; i < tokens->n; i++) {
        if (!token_is_directive(tokens, i, "macro") ||
            !token_is_word(tokens, i + 1, macro))
            continue;
        const int end = token_find_end(tokens, i);
        for (int k = token_skip_directive(tokens, i); k < end;) {
            const bool is_transform = is_any_word(tokens, k, transform_items) ||
                                      token_is_word(tokens, k, "transform");
            const int from = k;
            if (is_item(tokens, k) && !is_transform)
                return false;
            is_found |= is_transform;
            if (tokens->items[k].kind == TOKEN_DIRECTIVE)
                k = token_skip_directive(tokens, k);
            else if (token_is_sign(tokens, k, '{'))
                k = token_skip_group(tokens, k);
            k = k > from ? k : from + 1;
        }
    }
    return is_found;
}

static bool is_computed_include(const struct tokens *tokens, int i)
{
    return token_is_directive(tokens, i, "include") && i + 1 < tokens->n &&
           tokens->items[i + 1].kind != TOKEN_STRING;
}

bool rewrite_has_camera(const struct tokens *tokens)
{
    for (int i = 0; i < tokens->n; i++)
        if (token_is_word(tokens, i, "camera") || is_any_word(tokens, i, camera_only) ||
            is_computed_include(tokens, i) || token_is_word(tokens, i, "image_width") ||
            token_is_word(tokens, i, "image_height") ||
            token_is_word(tokens, i, "input_file_name") ||
            token_is_word(tokens, i, "now"))
            return true;
    return false;
}

static void record_text(struct writer *w, const char *key, const char *value)
{
    text_addf(w->out, " #debug \"@rf~%s~%s;\\n\" ", key, or_nothing(value));
}

/* Token after the value at i: an expression, or directives with one in each branch, as
 * in `location #if (A) <0,1,2> #else <3,4,5> #end + x`. */
static int skip_value(const struct tokens *tokens, int i)
{
    if (!token_is_opener(tokens, i))
        return token_skip_expression(tokens, i);
    int end = token_find_end(tokens, i) + 1;
    for (int k = i; k < end && k < tokens->n; k++)
        if (is_item(tokens, k)) /* more than a value */
            return token_skip_expression(tokens, i);
    while (token_is_binary(tokens, end))
        end = skip_value(tokens, end + 1);
    return end < tokens->n ? end : tokens->n;
}

/* `key EXPR` at i; returns the token after it. */
static int write_value_item(struct writer *w, int i, bool is_vector)
{
    int end = skip_value(w->tokens, i + 1);
    if (end == i + 1)
        return end;
    bool is_aperture = token_is_word(w->tokens, i, "aperture");
    if (w->how->mode == REWRITE_RECORD) {
        char *key = token_text(w->tokens, i);
        copy_to(w, w->tokens->items[i].end);
        /* An #end before the semicolon would end the #declare, but for brackets. */
        text_addf(w->out, " #declare RF_=(");
        copy_to(w, end_before(w, end));
        if (is_vector)
            text_addf(w->out,
                      "); RF_ #debug concat(\"@rf~%s~\",vstr(3,RF_*<1,1,1>,\",\",0,20),"
                      "\";\\n\") ",
                      or_nothing(key));
        else
            text_addf(w->out,
                      "); RF_ #debug concat(\"@rf~%s~\",str(RF_,0,20),\";\\n\") ",
                      or_nothing(key));
        free(key);
    } else if (is_aperture) {
        copy_to(w, w->tokens->items[i].end);
        text_addf(w->out, " 0*(");
        copy_to(w, end_before(w, end));
        text_addf(w->out, ") ");
    }
    return end;
}

/* The declared RT_ takes effect and its images of 0, x, y and z are written, each on
 * its own: POV-Ray cuts strings off after some 250 bytes. */
static void write_transform(struct writer *w)
{
    static const char *const points[] = {"0,0,0", "1,0,0", "0,1,0", "0,0,1"};
    text_addf(w->out,
              " #declare RV_=function{transform{RT_}} #debug \"@rf~transform~\"");
    for (int k = 0; k < 4; k++)
        text_addf(w->out, " #debug concat(vstr(3,RV_(%s),\",\",0,20),\"%s\") ",
                  points[k], k < 3 ? "," : ";\\n");
    text_addf(w->out, "#undef RV_ transform{RT_} ");
}

static int write_transform_item(struct writer *w, int i)
{
    bool is_block = token_is_word(w->tokens, i, "transform");
    int end = is_block && token_is_sign(w->tokens, i + 1, '{')
                  ? token_skip_group(w->tokens, i + 1)
                  : skip_value(w->tokens, i + 1);
    if (end == i + 1 || w->how->mode != REWRITE_RECORD)
        return end;
    copy_to(w, begin_of(w, i));
    text_addf(w->out, " #declare RT_=transform{");
    if (is_block) /* the word itself is not wanted twice */
        skip_to(w, begin_of(w, i + 1));
    copy_to(w, end_before(w, end));
    text_addf(w->out, "} ");
    write_transform(w);
    return end;
}

/* transform{...} within transform{} needs its word. */
static int write_transform_block(struct writer *w, int i)
{
    if (!token_is_sign(w->tokens, i + 1, '{') || w->how->mode != REWRITE_RECORD)
        return write_transform_item(w, i);
    int end = token_skip_group(w->tokens, i + 1);
    copy_to(w, begin_of(w, i));
    text_addf(w->out, " #declare RT_=");
    copy_to(w, end_before(w, end));
    write_transform(w);
    return end;
}

static bool calls_transform(const struct writer *w, int i)
{
    if (w->how->mode != REWRITE_RECORD || !w->how->makes_transform ||
        !token_is_sign(w->tokens, i + 1, '('))
        return false;
    char *name = token_text(w->tokens, i);
    const bool is_one = name && w->how->makes_transform(w->how->user, name);
    free(name);
    return is_one;
}

/* `Spline_Trans(...)`: what the macro makes is declared before it takes effect. */
static int write_transform_call(struct writer *w, int i)
{
    const int end = token_skip_group(w->tokens, i + 1);
    copy_to(w, begin_of(w, i));
    text_addf(w->out, " #declare RT_=transform{");
    copy_to(w, end_before(w, end));
    text_addf(w->out, "} ");
    write_transform(w);
    return end;
}

static int write_type_item(struct writer *w, int i)
{
    if (w->how->mode == REWRITE_RECORD) {
        char *key = token_text(w->tokens, i);
        copy_to(w, begin_of(w, i));
        record_text(w, "type", key);
        free(key);
    }
    i++;
    return token_is_sign(w->tokens, i, '{') ? token_skip_group(w->tokens, i) : i;
}

static int write_item(struct writer *w, int i)
{
    const struct tokens *tokens = w->tokens;
    if (is_any_word(tokens, i, vector_items))
        return write_value_item(w, i, true);
    if (token_is_word(tokens, i, "blur_samples")) {
        int end = write_value_item(w, i, false);
        /* "blur_samples 4, 100": the second number is part of it. */
        return token_is_sign(tokens, end, ',') ? token_skip_expression(tokens, end + 1)
                                               : end;
    }
    if (is_any_word(tokens, i, number_items))
        return write_value_item(w, i, false);
    if (is_any_word(tokens, i, transform_items))
        return write_transform_item(w, i);
    if (token_is_word(tokens, i, "transform"))
        return write_transform_block(w, i);
    if (is_any_word(tokens, i, type_items))
        return write_type_item(w, i);
    if (calls_transform(w, i))
        return write_transform_call(w, i);
    return token_skip_expression(tokens, i); /* a macro's call */
}

/* "NAME" of `#declare NAME = camera` with the word camera at i, else "". */
static char *declared_name(const struct tokens *tokens, int i)
{
    if (!token_is_sign(tokens, i - 1, '='))
        return text_format("%s", "");
    int k = i - 2;
    while (k > 0 && tokens->items[k].kind != TOKEN_DIRECTIVE)
        k--;
    if (tokens->items[k + 1].kind != TOKEN_WORD)
        return text_format("%s", "");
    return token_text(tokens, k + 1);
}

static void walk(struct writer *w, int i, int end, bool is_camera);

/* The camera at i; NAME is what is declared as it, "" for none. */
static int write_named_camera(struct writer *w, int i, const char *camera_name)
{
    const struct tokens *tokens = w->tokens;
    int after = token_skip_group(tokens, i + 1), first = i + 2;
    copy_to(w, tokens->items[i + 1].end);
    if (w->how->mode == REWRITE_RECORD) {
        text_addf(w->out,
                  " #debug concat(\"@rf~camera~\",str(version,0,4),\"~%s;\\n\") ",
                  camera_name);
        /* A name that calls nothing is a declared camera. */
        if (first < after - 1 && tokens->items[first].kind == TOKEN_WORD &&
            !token_is_sign(tokens, first + 1, '(') && !is_item(tokens, first)) {
            char *name = token_text(tokens, first);
            record_text(w, "copy", name);
            free(name);
        }
    }
    walk(w, first, after - 1, true);
    if (w->how->mode == REWRITE_RECORD && token_is_sign(tokens, after - 1, '}')) {
        copy_to(w, begin_of(w, after - 1));
        record_text(w, "end", "");
    }
    return after;
}

static int write_camera(struct writer *w, int i)
{
    char *name = declared_name(w->tokens, i);
    int after = write_named_camera(w, i, or_nothing(name));
    free(name);
    return after;
}

static bool is_camera_block(const struct tokens *tokens, int i)
{
    return token_is_word(tokens, i, "camera") && token_is_sign(tokens, i + 1, '{');
}

/* The brace of `#declare NAME = array[N] { camera {...} ... }` with the directive at i; 0
 * where it is another. */
static int find_camera_array(const struct tokens *tokens, int i)
{
    if ((!token_is_directive(tokens, i, "declare") &&
         !token_is_directive(tokens, i, "local")) ||
        !token_is_sign(tokens, i + 2, '=') || !token_is_word(tokens, i + 3, "array"))
        return 0;
    int brace = i + 4;
    while (token_is_sign(tokens, brace, '['))
        brace = token_skip_group(tokens, brace);
    const int after =
        token_is_sign(tokens, brace, '{') ? token_skip_group(tokens, brace) : 0;
    for (int k = brace; k < after; k++)
        if (is_camera_block(tokens, k))
            return brace;
    return 0;
}

/* POV-Ray takes no directives in an array's braces, which the records need: each camera
 * becomes a declared one before it, RA_ and its token's number, and the array holds
 * copies of these. */
static int write_camera_array(struct writer *w, int i, int brace)
{
    const struct tokens *tokens = w->tokens;
    const int after = token_skip_group(tokens, brace);
    copy_to(w, begin_of(w, i));
    for (int k = brace; k < after;) {
        char name[16];
        if (!is_camera_block(tokens, k)) {
            k++;
            continue;
        }
        snprintf(name, sizeof name, "RA_%d", k);
        skip_to(w, begin_of(w, k));
        text_addf(w->out, " #declare %s=", name);
        k = write_named_camera(w, k, name);
        copy_to(w, end_before(w, k));
    }
    skip_to(w, end_before(w, after));
    for (int k = i; k < after;) {
        const bool is_camera = is_camera_block(tokens, k);
        char *word =
            is_camera ? text_format("camera{RA_%d}", k) : token_text(tokens, k);
        text_addf(w->out, " %s", or_nothing(word));
        free(word);
        k = is_camera ? token_skip_group(tokens, k + 1) : k + 1;
    }
    text_addf(w->out, " ");
    return after;
}

/* `#include EXPR`: POV-Ray says which file it is, and takes our copy of those known. */
static int write_computed_include(struct writer *w, int i)
{
    int end = token_skip_expression(w->tokens, i + 1);
    if (end == i + 1)
        return end;
    copy_to(w, begin_of(w, i));
    text_addf(w->out, " #declare RI_=");
    w->copied = begin_of(w, i + 1);
    copy_to(w, end_before(w, end));
    text_addf(w->out, ";");
    if (w->how->mode == REWRITE_RECORD)
        text_addf(w->out, " #debug concat(\"@rf~include~\",RI_,\";\\n\")");
    for (int k = 0; k < w->how->n_computed; k++) {
        const char *name = w->how->computed[k];
        const char *path = w->how->include_path(w->how->user, name);
        if (path)
            text_addf(w->out, " #if(strcmp(RI_,\"%s\")=0) #declare RI_=\"%s\"; #end",
                      name, path);
    }
    text_addf(w->out, " #include RI_ ");
    return end;
}

static int write_include(struct writer *w, int i)
{
    char *name = rewrite_include_name(w->tokens, i);
    if (!name)
        return write_computed_include(w, i);
    const char *path =
        w->how->include_path ? w->how->include_path(w->how->user, name) : NULL;
    if (path) {
        copy_to(w, begin_of(w, i + 1));
        text_addf(w->out, "\"%s\"", path);
        skip_to(w, w->tokens->items[i + 1].end);
    }
    free(name);
    return i + 2;
}

/* A shape at i that stands outside all others, or that is declared. */
static int write_hollow(struct writer *w, int i)
{
    int after = token_skip_group(w->tokens, i + 1);
    bool is_meant =
        w->how->mode != REWRITE_HOLLOW_PLANES || token_is_word(w->tokens, i, "plane");
    if (is_meant && token_is_sign(w->tokens, after - 1, '}') &&
        (w->how->mode == REWRITE_HOLLOW_DECLARED ||
         !token_is_sign(w->tokens, i - 1, '='))) {
        copy_to(w, begin_of(w, after - 1));
        text_addf(w->out, " hollow ");
    }
    return after;
}

/* The word before the brace that is open at i; -1: none is. */
static int word_around(const struct tokens *tokens, int i)
{
    int n_closed = 0;
    for (i--; i >= 0; i--) {
        n_closed += token_is_sign(tokens, i, '}');
        if (token_is_sign(tokens, i, '{') && n_closed-- == 0)
            return i - 1;
    }
    return -1;
}

/* Token after the media's interior or material at i that a thing has; 0: there is none. */
static int skip_holder(const struct writer *w, int i)
{
    const int held = media_skip_held(w->tokens, i);
    const int after =
        held ? held
             : media_skip_named(w->tokens, i, w->how->holders, w->how->n_holders);
    return after > 0 && is_any_word(w->tokens, word_around(w->tokens, i), shapes)
               ? after
               : 0;
}

static int write_bare(struct writer *w, int after)
{
    copy_to(w, end_before(w, after));
    text_addf(w->out, " no_image ");
    return after;
}

static int write_directive(struct writer *w, int i, bool is_camera)
{
    const struct tokens *tokens = w->tokens;
    if (token_is_directive(tokens, i, "macro")) {
        int body = token_skip_directive(tokens, i), end = token_find_end(tokens, i);
        if ((w->how->mode == REWRITE_HOLLOW_PLANES ||
             w->how->mode == REWRITE_HOLLOW_TOP) &&
            !has_loose_items(tokens, body, end))
            return end + 1;
        walk(w, body, end, has_loose_items(tokens, body, end));
        return end + 1;
    }
    if (token_is_directive(tokens, i, "include"))
        return write_include(w, i);
    const int brace = w->how->mode == REWRITE_RECORD ? find_camera_array(tokens, i) : 0;
    if (brace > 0)
        return write_camera_array(w, i, brace);
    return is_camera ? token_skip_directive(tokens, i) : i + 1;
}

static void walk(struct writer *w, int i, int end, bool is_camera)
{
    const struct tokens *tokens = w->tokens;
    while (i < end) {
        int from = i, after;
        bool opens = token_is_sign(tokens, i + 1, '{');
        if (tokens->items[i].kind == TOKEN_DIRECTIVE)
            i = write_directive(w, i, is_camera);
        else if (opens && token_is_word(tokens, i, "camera"))
            i = write_camera(w, i);
        else if (is_camera && tokens->items[i].kind == TOKEN_WORD)
            i = write_item(w, i);
        else if (is_hollow_mode(w) && opens && !is_camera &&
                 is_any_word(tokens, i, shapes))
            i = write_hollow(w, i);
        else if (w->how->mode == REWRITE_BARE && opens && (after = skip_holder(w, i)))
            i = write_bare(w, after);
        else if ((is_camera || is_hollow_mode(w)) && token_is_sign(tokens, i, '{'))
            i = token_skip_group(tokens, i);
        if (i <= from)
            i = from + 1;
    }
}

void rewrite_file(struct text *out, const struct tokens *tokens, size_t n_bytes,
                  const struct rewrite *how)
{
    struct writer w = {out, tokens, how, 0};
    int first = 0;
    if (token_is_directive(tokens, 0, "version")) {
        first = token_skip_directive(tokens, 0);
        copy_to(&w, tokens->items[first - 1].end);
    }
    text_addf(out, "%s", how->head);
    walk(&w, first, tokens->n, has_loose_items(tokens, 0, tokens->n));
    copy_to(&w, n_bytes);
}
