/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Initialisation files: a setting `Name = value` on a line of its own, or switches and
 * names of files, parted by blanks. A semicolon or # outside quotes begins a comment.
 * `[Section]` begins what is read only where the file was named as "file.ini[Section]".
 */
#include "ini.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "text.h"

/* Files that name each other end here. */
#define MAX_DEPTH 8

struct walk {
    ini_option_fn receive;
    void *user;
    int depth;
};

static void walk_file(struct walk *walk, const char *name);

bool ini_is_name(const char *name)
{
    size_t n = strlen(name);
    return n > 4 && strcasecmp(name + n - 4, ".ini") == 0;
}

char *ini_standard_file(void)
{
    const char *named = getenv("POVINI"), *home = getenv("HOME");
    char *own = text_format("%s/.povray/3.7/povray.ini", home ? home : "");
    const char *const places[] = {named ? named : "", "povray.ini", own ? own : "",
                                  "/etc/povray/3.7/povray.ini"};
    char *found = NULL;
    for (size_t i = 0; i < sizeof places / sizeof *places && !found; i++)
        if (places[i][0] && path_is_file(places[i]))
            found = text_format("%s", places[i]);
    free(own);
    return found;
}

const char *ini_value(const char *option, const char *name, const char *letters)
{
    size_t n = strlen(name);
    if (strncasecmp(option, name, n) == 0) {
        const char *at = option + n + strspn(option + n, " \t");
        return *at == '=' ? at + 1 + strspn(at + 1, " \t") : NULL;
    }
    n = strlen(letters);
    if (n > 0 && (option[0] == '+' || option[0] == '-') &&
        strncasecmp(option + 1, letters, n) == 0)
        return option + 1 + n;
    return NULL;
}

bool ini_is_on(const char *option, const char *value)
{
    static const char *const words[] = {"off", "no", "false", "0"};
    if (option[0] == '+' || option[0] == '-')
        return option[0] == '+';
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strcasecmp(value, words[i]) == 0)
            return false;
    return true;
}

char *ini_unquoted(const char *value)
{
    size_t n = strlen(value);
    const bool is_quoted =
        n >= 2 && (value[0] == '"' || value[0] == '\'') && value[n - 1] == value[0];
    return text_format("%.*s", (int)(n - 2 * is_quoted), value + is_quoted);
}

static void take_option(struct walk *walk, const char *option, const char *file)
{
    walk->receive(walk->user, option, file);
    const char *included = ini_value(option, "Include_Ini", "");
    if (!included && option[0] != '+' && option[0] != '-' && !strchr(option, '='))
        included = option;
    char *name = included ? ini_unquoted(included) : NULL;
    if (name)
        walk_file(walk, name);
    free(name);
}

/* Switches and names of a line. */
static void take_words(struct walk *walk, const char *line, const char *file)
{
    while (*line) {
        line += strspn(line, " \t");
        const char *end = line;
        for (char quote = 0; *end && (quote || (*end != ' ' && *end != '\t')); end++)
            if (quote ? *end == quote : *end == '"' || *end == '\'')
                quote = quote ? 0 : *end;
        if (end > line) {
            char *word = text_format("%.*s", (int)(end - line), line);
            if (word)
                take_option(walk, word, file);
            free(word);
        }
        line = end;
    }
}

/* Cuts the line's comment off. A quote that is not closed is a letter. */
static void cut_comment(char *line)
{
    char quote = 0;
    for (; *line && (quote || (*line != ';' && *line != '#')); line++) {
        if (quote ? *line == quote : *line == '"' || *line == '\'')
            quote = quote || !strchr(line + 1, *line) ? 0 : *line;
    }
    *line = 0;
}

static void take_line(struct walk *walk, char *line, const char *file)
{
    cut_comment(line);
    line += strspn(line, " \t");
    for (size_t n = strlen(line); n > 0 && isspace((unsigned char)line[n - 1]);)
        line[--n] = 0;
    if (isalpha((unsigned char)line[0]) && strchr(line, '='))
        take_option(walk, line, file);
    else
        take_words(walk, line, file);
}

/* Is the line "[...]" the head of the wanted section? */
static bool is_section(const char *line, const char *wanted)
{
    line += 1 + strspn(line + 1, " \t");
    size_t n = strcspn(line, "]");
    while (n > 0 && isspace((unsigned char)line[n - 1]))
        n--;
    return strlen(wanted) == n && strncasecmp(line, wanted, n) == 0;
}

char *ini_file(const char *name)
{
    const char *bracket = strchr(name, '[');
    const bool has_section =
        bracket && name[strlen(name) - 1] == ']' && !path_is_file(name);
    return text_format("%.*s", (int)(has_section ? bracket - name : (long)strlen(name)),
                       name);
}

bool ini_has_section(const char *name)
{
    char *path = ini_file(name), *state = NULL;
    const char *bracket =
        path && strlen(path) < strlen(name) ? strchr(name, '[') : NULL;
    char *section = text_format("%.*s", (int)strcspn(bracket ? bracket + 1 : "", "]"),
                                bracket ? bracket + 1 : "");
    struct text text = {0};
    bool is_found = !bracket;
    if (!is_found && section && text_read_file(&text, path))
        for (char *line = strtok_r(text.data, "\r\n", &state); line && !is_found;
             line = strtok_r(NULL, "\r\n", &state)) {
            const char *begin = line + strspn(line, " \t");
            is_found = *begin == '[' && is_section(begin, section);
        }
    text_free(&text);
    free(section);
    free(path);
    return is_found;
}

/* `name` may end with a section; nothing happens where it is no initialisation file. */
static void walk_file(struct walk *walk, const char *name)
{
    const size_t n = strcspn(name, "[");
    char *path = text_format("%.*s", (int)n, name);
    char *section = text_format("%.*s", (int)strcspn(name + n + (name[n] == '['), "]"),
                                name + n + (name[n] == '['));
    struct text text = {0};
    if (path && !ini_is_name(path) && !path_is_file(path)) {
        char *longer = text_format("%s.ini", path);
        free(path);
        path = longer;
    }
    if (walk->depth < MAX_DEPTH && path && section && ini_is_name(path) &&
        text_read_file(&text, path)) {
        bool is_read = true;
        char *state = NULL;
        walk->depth++;
        for (char *line = strtok_r(text.data, "\r\n", &state); line;
             line = strtok_r(NULL, "\r\n", &state)) {
            const char *begin = line + strspn(line, " \t");
            if (*begin == '[')
                is_read = is_section(begin, section);
            else if (is_read)
                take_line(walk, line, path);
        }
        walk->depth--;
    }
    text_free(&text);
    free(section);
    free(path);
}

void ini_walk(char *const *args, int n_args, ini_option_fn receive, void *user)
{
    struct walk walk = {.receive = receive, .user = user};
    char *standard = ini_standard_file();
    if (standard)
        walk_file(&walk, standard);
    free(standard);
    for (int i = 0; i < n_args; i++)
        take_option(&walk, args[i], NULL);
}
