/* SPDX-License-Identifier: Apache-2.0 */
#include "lexer.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "text.h"

static bool is_word_start(char c)
{
    return isalpha((unsigned char)c) || c == '_';
}

static bool is_word_part(char c)
{
    return isalnum((unsigned char)c) || c == '_';
}

/* Position after blanks and comments; block comments nest. */
static size_t skip_blank(const char *text, size_t at, size_t n)
{
    while (at < n) {
        if (isspace((unsigned char)text[at]) || (unsigned char)text[at] >= 0x80 ||
            text[at] == 0x1a) {
            at++;
        } else if (text[at] == '/' && at + 1 < n && text[at + 1] == '/') {
            while (at < n && text[at] != '\n' && text[at] != '\r')
                at++;
        } else if (text[at] == '/' && at + 1 < n && text[at + 1] == '*') {
            int depth = 1;
            for (at += 2; at < n && depth > 0; at++) {
                char next = at + 1 < n ? text[at + 1] : 0;
                if (text[at] == '/' && next == '*') {
                    depth++;
                    at++;
                } else if (text[at] == '*' && next == '/') {
                    depth--;
                    at++;
                }
            }
        } else {
            break;
        }
    }
    return at;
}

static size_t skip_string(const char *text, size_t at, size_t n)
{
    for (at++; at < n && text[at] != '"'; at++)
        if (text[at] == '\\' && at + 1 < n)
            at++;
    return at < n ? at + 1 : n;
}

static size_t skip_number(const char *text, size_t at, size_t n)
{
    while (at < n && isdigit((unsigned char)text[at]))
        at++;
    if (at < n && text[at] == '.')
        at++;
    while (at < n && isdigit((unsigned char)text[at]))
        at++;
    if (at < n && (text[at] == 'e' || text[at] == 'E')) {
        size_t digits = at + 1;
        if (digits < n && (text[digits] == '+' || text[digits] == '-'))
            digits++;
        if (digits < n && isdigit((unsigned char)text[digits])) {
            at = digits;
            while (at < n && isdigit((unsigned char)text[at]))
                at++;
        }
    }
    return at;
}

static struct token scan_token(const char *text, size_t at, size_t n)
{
    struct token token = {TOKEN_SIGN, at, at + 1};
    char c = text[at], next = at + 1 < n ? text[at + 1] : 0;
    if (is_word_start(c)) {
        token.kind = TOKEN_WORD;
        while (token.end < n && is_word_part(text[token.end]))
            token.end++;
    } else if (isdigit((unsigned char)c) ||
               (c == '.' && isdigit((unsigned char)next))) {
        token.kind = TOKEN_NUMBER;
        token.end = skip_number(text, at, n);
    } else if (c == '"') {
        token.kind = TOKEN_STRING;
        token.end = skip_string(text, at, n);
    } else if (c == '#') {
        size_t word = skip_blank(text, at + 1, n);
        if (word < n && is_word_start(text[word])) {
            token.kind = TOKEN_DIRECTIVE;
            while (word < n && is_word_part(text[word]))
                word++;
            token.end = word;
        }
    }
    return token;
}

void tokens_scan(struct tokens *tokens, const char *text, size_t n_bytes)
{
    int capacity = 256;
    *tokens =
        (struct tokens){text, glue_alloc((size_t)capacity, sizeof(struct token)), 0};
    if (!tokens->items)
        return;
    size_t at = skip_blank(text, 0, n_bytes);
    while (at < n_bytes) {
        struct token token = scan_token(text, at, n_bytes);
        tokens->items[tokens->n++] = token;
        if (tokens->n == capacity) {
            struct token *items =
                glue_grow(tokens->items, 2 * (size_t)capacity, sizeof *items);
            if (!items) {
                tokens->n--;
                break;
            }
            tokens->items = items;
            capacity *= 2;
        }
        at = skip_blank(text, token.end, n_bytes);
    }
    tokens->items[tokens->n] = (struct token){TOKEN_END, n_bytes, n_bytes};
}

void tokens_free(struct tokens *tokens)
{
    free(tokens->items);
    *tokens = (struct tokens){0};
}

bool token_is_sign(const struct tokens *tokens, int i, char sign)
{
    return i >= 0 && i < tokens->n && tokens->items[i].kind == TOKEN_SIGN &&
           tokens->text[tokens->items[i].begin] == sign;
}

bool token_is_word(const struct tokens *tokens, int i, const char *word)
{
    if (i < 0 || i >= tokens->n || tokens->items[i].kind != TOKEN_WORD)
        return false;
    size_t n = tokens->items[i].end - tokens->items[i].begin;
    return strlen(word) == n &&
           memcmp(tokens->text + tokens->items[i].begin, word, n) == 0;
}

bool token_is_directive(const struct tokens *tokens, int i, const char *name)
{
    if (i < 0 || i >= tokens->n || tokens->items[i].kind != TOKEN_DIRECTIVE)
        return false;
    /* "# /" "* why not *" "/ if" is possible: compare from the end. */
    size_t n = strlen(name), end = tokens->items[i].end;
    return end - tokens->items[i].begin > n &&
           memcmp(tokens->text + end - n, name, n) == 0 &&
           !is_word_part(tokens->text[end - n - 1]);
}

static bool is_any_directive(const struct tokens *tokens, int i,
                             const char *const *names)
{
    for (; *names; names++)
        if (token_is_directive(tokens, i, *names))
            return true;
    return false;
}

static const char *const openers[] = {"if",  "ifdef",  "ifndef", "while",
                                      "for", "switch", "macro",  NULL};
static const char *const branches[] = {"else", "elseif", "case", "range", NULL};

bool token_is_opener(const struct tokens *tokens, int i)
{
    return is_any_directive(tokens, i, openers);
}

#define MAX_BRANCHES 64

int token_skip_group(const struct tokens *tokens, int i)
{
    int at_branch[MAX_BRANCHES], n_branches = 0, depth = 0;
    bool is_brace = token_is_sign(tokens, i, '{');
    bool is_angle = token_is_sign(tokens, i, '<');
    for (; i < tokens->n; i++) {
        if (is_any_directive(tokens, i, openers)) {
            if (n_branches < MAX_BRANCHES)
                at_branch[n_branches] = depth;
            n_branches++;
        } else if (n_branches > 0 && n_branches <= MAX_BRANCHES &&
                   is_any_directive(tokens, i, branches)) {
            depth = at_branch[n_branches - 1];
        } else if (n_branches > 0 && token_is_directive(tokens, i, "end")) {
            n_branches--;
        }
        if (tokens->items[i].kind != TOKEN_SIGN)
            continue;
        char c = tokens->text[tokens->items[i].begin];
        if (is_angle && c == '(') {
            i = token_skip_group(tokens, i) - 1; /* < may compare inside */
            continue;
        }
        if (c == '{' || (!is_brace && (c == '(' || c == '[')) || (is_angle && c == '<'))
            depth++;
        if (c == '}' || (!is_brace && (c == ')' || c == ']')) || (is_angle && c == '>'))
            depth--;
        if (depth <= 0)
            return i + 1;
    }
    return tokens->n;
}

int token_find_end(const struct tokens *tokens, int i)
{
    int depth = 0;
    for (; i < tokens->n; i++) {
        if (is_any_directive(tokens, i, openers))
            depth++;
        else if (token_is_directive(tokens, i, "end") && --depth <= 0)
            return i;
    }
    return tokens->n;
}

bool token_is_binary(const struct tokens *tokens, int i)
{
    return token_is_sign(tokens, i, '+') || token_is_sign(tokens, i, '-') ||
           token_is_sign(tokens, i, '*') || token_is_sign(tokens, i, '/');
}

/* Token after a name and what may follow it: arguments, indices, members, a block. */
static int skip_name(const struct tokens *tokens, int i, bool with_block)
{
    for (i++;;) {
        if (token_is_sign(tokens, i, '(') || token_is_sign(tokens, i, '['))
            i = token_skip_group(tokens, i);
        else if (token_is_sign(tokens, i, '.') && i + 1 < tokens->n)
            i += 2;
        else if (with_block && token_is_sign(tokens, i, '{'))
            return token_skip_group(tokens, i);
        else
            return i;
    }
}

static int skip_directive(const struct tokens *tokens, int i, bool goes_beyond);

/* Token after the directives at i. Their own values end before the next directive: did
 * each look beyond its own, n of them without semicolons would take 2^n steps. */
static int skip_directives(const struct tokens *tokens, int i)
{
    while (i < tokens->n && tokens->items[i].kind == TOKEN_DIRECTIVE)
        i = skip_directive(tokens, i, false);
    return i;
}

static int skip_operand(const struct tokens *tokens, int i, bool with_block)
{
    while (token_is_sign(tokens, i, '-') || token_is_sign(tokens, i, '+') ||
           token_is_sign(tokens, i, '!'))
        i++;
    i = skip_directives(tokens, i);
    if (i >= tokens->n)
        return i;
    enum token_kind kind = tokens->items[i].kind;
    if (kind == TOKEN_WORD)
        return skip_name(tokens, i, with_block);
    if (kind == TOKEN_NUMBER || kind == TOKEN_STRING)
        return i + 1;
    if (token_is_sign(tokens, i, '(') || token_is_sign(tokens, i, '<') ||
        token_is_sign(tokens, i, '{')) {
        i = token_skip_group(tokens, i);
        while (token_is_sign(tokens, i, '.') && i + 1 < tokens->n)
            i += 2;
    }
    return i;
}

/* GOES_BEYOND: directives that follow may hold more of the expression. */
static int skip_terms(const struct tokens *tokens, int i, bool with_block,
                      bool goes_beyond)
{
    for (;;) {
        int after = skip_operand(tokens, i, with_block);
        if (after == i)
            return i;
        i = after;
        /* "A #if (B) + C #end": the expression goes on within the directive. */
        int beyond = goes_beyond ? skip_directives(tokens, i) : i;
        if (token_is_binary(tokens, beyond))
            i = beyond + 1;
        else
            return i;
    }
}

int token_skip_expression(const struct tokens *tokens, int i)
{
    return skip_terms(tokens, i, false, true);
}

/* Value of a #declare or #local: an expression or an item with its block. */
static int skip_value(const struct tokens *tokens, int i, bool goes_beyond)
{
    i = skip_name(tokens, i, false);
    if (!token_is_sign(tokens, i, '='))
        return i;
    i = skip_terms(tokens, i + 1, true, goes_beyond);
    if (token_is_sign(tokens, i, '{'))
        i = token_skip_group(tokens, i); /* array[2] {1, 2} */
    return token_is_sign(tokens, i, ';') ? i + 1 : i;
}

static int skip_directive(const struct tokens *tokens, int i, bool goes_beyond)
{
    static const char *const with_condition[] = {"if",    "ifdef", "ifndef", "elseif",
                                                 "while", "for",   "switch", "case",
                                                 "range", NULL};
    static const char *const with_expression[] = {
        "debug",   "warning", "error", "render", "statistics",
        "include", "version", "undef", "fclose", NULL};
    int next = i + 1;
    if (is_any_directive(tokens, i, with_condition))
        return token_is_sign(tokens, next, '(') ? token_skip_group(tokens, next) : next;
    if (token_is_directive(tokens, i, "declare") ||
        token_is_directive(tokens, i, "local"))
        return skip_value(tokens, next, goes_beyond);
    if (token_is_directive(tokens, i, "macro"))
        return skip_name(tokens, next, false);
    if (token_is_directive(tokens, i, "default"))
        return token_is_sign(tokens, next, '{') ? token_skip_group(tokens, next) : next;
    if (is_any_directive(tokens, i, with_expression)) {
        next = skip_terms(tokens, next, false, goes_beyond);
        return token_is_sign(tokens, next, ';') ? next + 1 : next;
    }
    return next;
}

int token_skip_directive(const struct tokens *tokens, int i)
{
    return skip_directive(tokens, i, true);
}
