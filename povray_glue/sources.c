/* SPDX-License-Identifier: Apache-2.0 */
#include "sources.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "clear.h"
#include "clock.h"
#include "ini.h"
#include "media.h"
#include "path.h"

#define MAX_SOURCES 400
/* Private copies are called by their mode and number. */
#define MODE_LETTERS "rplhtdb"
/* From 1970 to 2000, whence POV-Ray's `now` counts. */
#define S_TO_2000 946684800.0
#define DAY_S 86400.0

/* The list owns the name, which may be NULL where memory was missing. */
static void add_name(char ***names, int *n, char *name)
{
    char **longer = name ? glue_grow(*names, (size_t)*n + 1, sizeof **names) : NULL;
    if (longer) {
        *names = longer;
        longer[(*n)++] = name;
    } else {
        free(name);
    }
}

static void add_folder(struct sources *sources, const char *folder, size_t n)
{
    if (n >= 2 && (folder[0] == '"' || folder[0] == '\'') &&
        folder[n - 1] == folder[0]) {
        folder++;
        n -= 2;
    }
    const char *slash = n > 0 && !strchr("/\\", folder[n - 1]) ? "/" : "";
    add_name(&sources->folders, &sources->n_folders,
             text_format("%.*s%s", (int)n, folder, slash));
}

/* What options say of the scene's files. */
struct noted {
    struct sources *sources;
    char *header;
};

static void note_option(void *user, const char *option, const char *file)
{
    struct noted *noted = user;
    const char *folder = ini_value(option, "Library_Path", "L");
    const char *header = ini_value(option, "Include_Header", "HI");
    const char *light = ini_value(option, "Radiosity_To_File", "RFO");
    (void)file;
    if (folder && *folder)
        add_folder(noted->sources, folder, strlen(folder));
    if (header) {
        free(noted->header);
        noted->header = ini_unquoted(header);
    }
    if (light)
        noted->sources->keeps_light = ini_is_on(option, light);
}

/* Notes the options; returns the name of the header that they want before the scene, NULL
 * for none. The caller frees. */
static char *note_options(struct sources *sources, const char *scene, char *const *args,
                          int n_args)
{
    struct noted noted = {.sources = sources};
    add_folder(sources, "", 0);
    ini_walk(args, n_args, note_option, &noted);
    char *folder = path_folder(scene);
    if (folder)
        add_folder(sources, folder, strlen(folder));
    free(folder);
    return noted.header;
}

char *sources_find(const struct sources *sources, const char *name)
{
    for (int i = 0; i < sources->n_folders; i++) {
        char *path = text_format(
            "%s%s", os_path_is_absolute(name) ? "" : sources->folders[i], name);
        if (path_is_file(path))
            return path;
        free(path);
    }
    return NULL;
}

static int load_file(struct sources *sources, const char *path);

/* POV-Ray's own includes hold macros for everything, called or not. */
static bool is_library(const char *path)
{
    return strncmp(path, "/usr/share/povray", 17) == 0 ||
           strncmp(path, "/usr/local/share/povray", 23) == 0;
}

/* A file of this name is written; NULL: of one that is computed. Frees it. */
static void note_written(struct sources *sources, char *name)
{
    sources->writes_files = true;
    if (!name || os_path_name(name) > name) {
        sources->writes_elsewhere = true;
        free(name);
        return;
    }
    add_name(&sources->written, &sources->n_written, name);
}

/* `#fopen HANDLE NAME write` at i, or append. */
static void note_file(struct sources *sources, const struct tokens *tokens, int i)
{
    const int end = token_skip_expression(tokens, i + 2);
    if (token_is_word(tokens, end, "write") || token_is_word(tokens, end, "append"))
        note_written(sources,
                     end == i + 3 ? rewrite_include_name(tokens, i + 1) : NULL);
}

static bool is_same_word(const struct tokens *tokens, int i, int k)
{
    const struct token *a = &tokens->items[i], *b = &tokens->items[k];
    return a->kind == TOKEN_WORD && b->kind == TOKEN_WORD &&
           a->end - a->begin == b->end - b->begin &&
           memcmp(tokens->text + a->begin, tokens->text + b->begin,
                  a->end - a->begin) == 0;
}

/* The string at i, or that the word there is declared as in this file; NULL where it is
 * none. The caller frees. */
static char *string_at(const struct tokens *tokens, int i)
{
    for (int k = 0; k + 3 < tokens->n; k++)
        if ((token_is_directive(tokens, k, "declare") ||
             token_is_directive(tokens, k, "local")) &&
            is_same_word(tokens, k + 1, i) && token_is_sign(tokens, k + 2, '='))
            return rewrite_include_name(tokens, k + 2);
    return rewrite_include_name(tokens, i - 1);
}

/* Macros of POV-Ray's includes that write what they make, each time, to the file that
 * their only string names, unless that is "". */
static void note_macro(struct sources *sources, const struct tokens *tokens, int i)
{
    static const char *const writing[] = {"ARRAYS_WriteDF3", "HF_Cylinder",
                                          "HF_Sphere",       "HF_Square",
                                          "HF_Torus",        "MakeGrassPatch"};
    bool is_one = false;
    for (size_t k = 0; k < sizeof writing / sizeof *writing; k++)
        is_one |= token_is_word(tokens, i, writing[k]);
    if (!is_one || !token_is_sign(tokens, i + 1, '(') ||
        (i > 0 && token_is_directive(tokens, i - 1, "macro")))
        return;
    const int end = token_skip_group(tokens, i + 1);
    for (int k = i + 2; k < end; k++) {
        char *name = string_at(tokens, k);
        if (name && *name)
            note_written(sources, name);
        else
            free(name);
    }
}

static void note_words(struct sources *sources, const struct tokens *tokens)
{
    for (int i = 0; i < tokens->n; i++) {
        sources->has_fog |= token_is_word(tokens, i, "fog");
        sources->has_radiosity |= token_is_word(tokens, i, "radiosity");
        sources->has_photons |= token_is_word(tokens, i, "photons");
        sources->has_media |= token_is_word(tokens, i, "media");
        sources->has_bumps |=
            token_is_word(tokens, i, "normal") && token_is_sign(tokens, i + 1, '{');
        sources->has_now |= token_is_word(tokens, i, "now");
        sources->writes_files |= token_is_word(tokens, i, "Parse_String");
        if (token_is_directive(tokens, i, "fopen"))
            note_file(sources, tokens, i);
        note_macro(sources, tokens, i);
        sources->holds_media |= media_skip_held(tokens, i) > 0;
        char *holder = media_declared_name(tokens, i);
        if (holder)
            add_name(&sources->holders, &sources->n_holders, holder);
    }
}

/* Reads what file k includes; it needs a copy where one of them does. */
static void load_includes(struct sources *sources, int k)
{
    for (int i = 0; i < sources->items[k].tokens.n; i++) {
        const struct tokens *tokens = &sources->items[k].tokens;
        if (!token_is_directive(tokens, i, "include"))
            continue;
        char *name = rewrite_include_name(tokens, i);
        char *path = name ? sources_find(sources, name) : NULL;
        int child = path ? load_file(sources, path) : -1;
        if (child >= 0 && sources->items[child].needs_copy)
            sources->items[k].needs_copy = true;
        free(path);
        free(name);
    }
}

/* Index of the file, read if it is new; -1 where it cannot be. */
static int load_file(struct sources *sources, const char *path)
{
    for (int i = 0; i < sources->n; i++)
        if (strcmp(sources->items[i].path, path) == 0)
            return i;
    struct text content = {0};
    if (sources->n == MAX_SOURCES || !text_read_file(&content, path)) {
        text_free(&content);
        return -1;
    }
    struct source *items =
        glue_grow(sources->items, (size_t)sources->n + 1, sizeof *items);
    sources->items = items ? items : sources->items;
    char *own_path = items ? text_format("%s", path) : NULL;
    if (!own_path) {
        text_free(&content);
        return -1;
    }
    const int k = sources->n++;
    items[k] = (struct source){.path = own_path, .content = content};
    struct tokens *tokens = &sources->items[k].tokens;
    tokens_scan(tokens, content.data, content.n);
    sources->items[k].needs_copy = k == 0 || rewrite_has_camera(tokens);
    sources->items[k].is_own = !is_library(path);
    if (sources->items[k].is_own)
        note_words(sources, tokens);
    load_includes(sources, k);
    return k;
}

static void load_header(struct sources *sources, const char *name)
{
    char *path = name && *name ? sources_find(sources, name) : NULL;
    const int k = path ? load_file(sources, path) : -1;
    sources->header = k > 0 ? k : 0;
    free(path);
}

/* Includes stand behind the files that include them: what they use is declared later. */
static void note_clear(struct sources *sources)
{
    struct clear_names names = {0};
    sources->has_clear = false;
    for (int k = sources->n - 1; k >= 0; k--)
        if (!sources->items[k].is_own)
            clear_note_declared(&names, &sources->items[k].tokens);
    for (int k = 0; k < sources->n && !sources->has_clear; k++)
        sources->has_clear = sources->items[k].is_own &&
                             clear_is_spoken_of(&names, &sources->items[k].tokens);
    clear_free(&names);
}

bool sources_load(struct sources *sources, const char *scene, char *const *args,
                  int n_args, const char *temp_folder)
{
    *sources = (struct sources){.temp_folder = temp_folder,
                                .now_days = (os_clock_date_s() - S_TO_2000) / DAY_S};
    char *header = note_options(sources, scene, args, n_args);
    const bool is_loaded = load_file(sources, scene) >= 0;
    int code = errno;
    if (is_loaded)
        load_header(sources, header);
    else
        sources_free(sources);
    note_clear(sources);
    free(header);
    errno = code;
    return is_loaded;
}

/* Is the name new among the computed ones? It is then kept. */
static bool note_computed(struct sources *sources, const char *name)
{
    for (int i = 0; i < sources->n_computed; i++)
        if (strcmp(sources->computed[i], name) == 0)
            return false;
    add_name(&sources->computed, &sources->n_computed, text_format("%s", name));
    return true;
}

bool sources_add_computed(struct sources *sources, const char *name)
{
    char *path = sources_find(sources, name);
    int k = path ? load_file(sources, path) : -1;
    free(path);
    note_clear(sources);
    return k >= 0 && sources->items[k].needs_copy && note_computed(sources, name);
}

void sources_forget_copies(struct sources *sources)
{
    for (int i = 0; i < sources->n; i++)
        for (int m = 0; m < REWRITE_N_MODES; m++) {
            free(sources->items[i].copy[m]);
            sources->items[i].copy[m] = NULL;
        }
}

void sources_free(struct sources *sources)
{
    sources_forget_copies(sources);
    for (int i = 0; i < sources->n; i++) {
        struct source *source = &sources->items[i];
        free(source->path);
        tokens_free(&source->tokens);
        text_free(&source->content);
    }
    for (int i = 0; i < sources->n_folders; i++)
        free(sources->folders[i]);
    for (int i = 0; i < sources->n_computed; i++)
        free(sources->computed[i]);
    free(sources->computed);
    for (int i = 0; i < sources->n_written; i++)
        free(sources->written[i]);
    free(sources->written);
    for (int i = 0; i < sources->n_holders; i++)
        free(sources->holders[i]);
    free(sources->holders);
    free(sources->folders);
    free(sources->items);
    *sources = (struct sources){0};
}

static const char *copy_of_include(void *user, const char *name)
{
    struct sources *sources = user;
    char *path = sources_find(sources, name);
    const char *copy = NULL;
    for (int i = 0; path && i < sources->n; i++)
        if (strcmp(sources->items[i].path, path) == 0)
            copy = sources->items[i].copy[sources->mode];
    free(path);
    return copy;
}

static bool makes_transform(void *user, const char *macro)
{
    const struct sources *sources = user;
    for (int i = 0; i < sources->n; i++)
        if (rewrite_makes_transform(&sources->items[i].tokens, macro))
            return true;
    return false;
}

void sources_set_size(struct sources *sources, int32_t width, int32_t height)
{
    if (sources->width != width || sources->height != height)
        sources_forget_copies(sources);
    sources->width = width;
    sources->height = height;
}

/* The scene's name as a string of POV-Ray's. The caller frees. */
static char *quoted_name(const struct sources *sources)
{
    struct text text = {0};
    text_add(&text, "\"", 1);
    for (const char *c = os_path_name(sources->items[0].path); *c; c++) {
        if (strchr("\"\\", *c))
            text_add(&text, "\\", 1);
        text_add(&text, c, 1);
    }
    text_add(&text, "\"", 1);
    return text.data;
}

/* Does a directive give the word at i a value of the scene's own? */
static bool is_declared(const struct tokens *tokens, int i)
{
    return token_is_directive(tokens, i - 1, "declare") ||
           token_is_directive(tokens, i - 1, "local");
}

/* Is the word at i named alone, as in #undef W, #ifdef (W) and defined(W)? */
static bool is_named(const struct tokens *tokens, int i)
{
    return token_is_directive(tokens, i - 1, "undef") ||
           (token_is_sign(tokens, i - 1, '(') &&
            (token_is_directive(tokens, i - 2, "ifdef") ||
             token_is_directive(tokens, i - 2, "ifndef") ||
             token_is_word(tokens, i - 2, "defined")));
}

static bool declares_in(const struct tokens *tokens, const char *word)
{
    for (int i = 1; i < tokens->n; i++)
        if (token_is_word(tokens, i, word) && is_declared(tokens, i))
            return true;
    return false;
}

/* Does the scene declare the word, in any of its files? */
static bool declares(const struct sources *sources, const char *word)
{
    for (int k = 0; k < sources->n; k++)
        if (declares_in(&sources->items[k].tokens, word))
            return true;
    return false;
}

bool sources_declare_size(const struct sources *sources)
{
    return declares(sources, "image_width") || declares(sources, "image_height");
}

/* Puts values in place of words that POV-Ray would have another value for: the passes
 * have a size, a time and a name of their own. A scene that declares such a word has its own value from there on;
 * before it, in the same file, it has POV-Ray's. */
static void set_values(struct text *text, const struct sources *sources)
{
    const bool has_size = sources->width > 0 && sources->mode != REWRITE_RECORD;
    struct {
        const char *word;
        char *value;      /* NULL: as POV-Ray has it */
        bool is_declared; /* the scene's own from here on */
    } values[] = {{"image_width",
                   has_size ? text_format("%d", (int)sources->width) : NULL, false},
                  {"image_height",
                   has_size ? text_format("%d", (int)sources->height) : NULL, false},
                  {"now", text_format("%.15g", sources->now_days), false},
                  {"input_file_name", quoted_name(sources), false}};
    const size_t n_values = sizeof values / sizeof *values;
    struct tokens tokens;
    struct text out = {0};
    size_t copied = 0;
    text_add(text, "", 0);
    tokens_scan(&tokens, text->data, text->n);
    for (size_t k = 0; k < n_values; k++)
        values[k].is_declared =
            declares(sources, values[k].word) && !declares_in(&tokens, values[k].word);
    for (int i = 0; i < tokens.n; i++) {
        for (size_t k = 0; k < n_values; k++) {
            if (!values[k].value || !token_is_word(&tokens, i, values[k].word))
                continue;
            values[k].is_declared |= is_declared(&tokens, i);
            if (values[k].is_declared || is_named(&tokens, i))
                continue;
            text_add(&out, text->data + copied, tokens.items[i].begin - copied);
            text_addf(&out, "%s", values[k].value);
            copied = tokens.items[i].end;
        }
    }
    if (text->data)
        text_add(&out, text->data + copied, text->n - copied);
    for (size_t k = 0; k < n_values; k++)
        free(values[k].value);
    tokens_free(&tokens);
    text_free(text);
    *text = out;
}

static bool write_copy(struct sources *sources, int k, const char *path,
                       const char *head, const char *tail)
{
    struct rewrite how = {.mode = sources->mode,
                          .head = head,
                          .include_path = copy_of_include,
                          .makes_transform = makes_transform,
                          .user = sources,
                          .computed = sources->computed,
                          .n_computed = sources->n_computed,
                          .holders = sources->holders,
                          .n_holders = sources->n_holders};
    struct text text = {0};
    rewrite_file(&text, &sources->items[k].tokens, sources->items[k].content.n, &how);
    set_values(&text, sources);
    text_addf(&text, "%s", tail);
    bool is_written = text_write_file(&text, path);
    text_free(&text);
    return is_written;
}

bool sources_write(struct sources *sources, enum rewrite_mode mode, const char *name,
                   const char *head, const char *tail)
{
    sources->mode = mode;
    bool is_new = false;
    for (int k = 1; k < sources->n; k++) {
        struct source *source = &sources->items[k];
        /* In these modes every file of the scene's own may hold shapes. */
        const bool has_shapes = mode >= REWRITE_HOLLOW_PLANES && source->is_own;
        if ((source->needs_copy || has_shapes) && !source->copy[mode]) {
            source->copy[mode] =
                text_format("%s%c%d.inc", sources->temp_folder, MODE_LETTERS[mode], k);
            is_new = true;
        }
    }
    for (int k = 1; k < sources->n && is_new; k++)
        if (sources->items[k].copy[mode] &&
            !write_copy(sources, k, sources->items[k].copy[mode], "", ""))
            return false;
    char *path = text_format("%s%s", sources->temp_folder, name);
    bool is_written = write_copy(sources, 0, path, head, tail);
    free(path);
    return is_written;
}

const char *sources_header(const struct sources *sources, enum rewrite_mode mode)
{
    return sources->header > 0 ? sources->items[sources->header].copy[mode] : NULL;
}

/* Index of the file whose private copy is called `name` (without folder), or -1. */
static int source_of_copy(const char *name, size_t n)
{
    if (n > 4 && memcmp(name + n - 4, ".pov", 4) == 0)
        return 0;
    if (n > 5 && strchr(MODE_LETTERS, name[0]) && memcmp(name + n - 4, ".inc", 4) == 0)
        return atoi(name + 1);
    return -1;
}

char *sources_original_names(const struct sources *sources, const char *message)
{
    struct text text = {0};
    size_t n_folder = strlen(sources->temp_folder);
    text_add(&text, "", 0);
    while (*message) {
        const char *at = strstr(message, sources->temp_folder);
        if (!at) {
            text_addf(&text, "%s", message);
            break;
        }
        text_add(&text, message, (size_t)(at - message));
        const char *name = at + n_folder;
        size_t n = strcspn(name, "'\"\n ");
        int k = source_of_copy(name, n);
        if (k >= 0 && k < sources->n)
            text_addf(&text, "%s", sources->items[k].path);
        else
            text_add(&text, at, n_folder + n);
        message = name + n;
    }
    return text.data;
}
