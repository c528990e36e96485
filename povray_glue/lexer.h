/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Splits a scene description into tokens: enough of POV-Ray's language to tell camera
 * blocks from comments and strings, and to see where an expression ends.
 */
#ifndef POVRAY_LEXER_H
#define POVRAY_LEXER_H

#include <stdbool.h>
#include <stddef.h>

enum token_kind {
    TOKEN_WORD, /* keyword or identifier */
    TOKEN_NUMBER,
    TOKEN_STRING,    /* with its quotes */
    TOKEN_DIRECTIVE, /* "#if", "# declare" */
    TOKEN_SIGN,      /* one character */
    TOKEN_END,       /* of the file; the last token */
};

struct token {
    enum token_kind kind;
    size_t begin, end; /* bytes in the text */
};

struct tokens {
    const char *text; /* not owned */
    struct token *items;
    int n; /* without the TOKEN_END that follows */
};

/* Without memory there are fewer tokens (text.h). */
void tokens_scan(struct tokens *tokens, const char *text, size_t n_bytes);
void tokens_free(struct tokens *tokens);

/* Is token i this sign, word, or directive ("if")? False beyond the end. */
bool token_is_sign(const struct tokens *tokens, int i, char sign);
bool token_is_word(const struct tokens *tokens, int i, const char *word);
bool token_is_directive(const struct tokens *tokens, int i, const char *name);
/* Is it + - * or /? */
bool token_is_binary(const struct tokens *tokens, int i);
/* Is it a directive that an #end closes? */
bool token_is_opener(const struct tokens *tokens, int i);

/* Token after the one that closes the ( [ < or { at i; the end where none does. Braces
 * that stand in both branches of an #if count once. */
int token_skip_group(const struct tokens *tokens, int i);

/* Token after the expression that begins at i; i itself where there is none. */
int token_skip_expression(const struct tokens *tokens, int i);

/* Token after the directive at i and what belongs to it: condition, name and value. For
 * #macro only its name and parameters. */
int token_skip_directive(const struct tokens *tokens, int i);

/* Index of the #end that closes the #macro, #if, ... at i; the end where none does. */
int token_find_end(const struct tokens *tokens, int i);

#endif
