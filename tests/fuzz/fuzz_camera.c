/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The rewriter of POV-Ray scenes, and the reader of what the rewritten scene reports.
 * A copy must keep every line break, so that messages name the user's lines.
 */
#include "bytes.h"
#include "camera.h"
#include "lexer.h"
#include "media.h"
#include "rewrite.h"
#include "text.h"

static const char *include_path(void *user, const char *name)
{
    return strlen(name) % 2 ? "/private/copy.inc" : NULL;
}

static bool makes_transform(void *user, const char *macro)
{
    return rewrite_makes_transform(user, macro);
}

static size_t count_lines(const char *text, size_t n)
{
    size_t lines = 0;
    for (size_t i = 0; i < n; i++)
        lines += text[i] == '\n';
    return lines;
}

static void rewrite(const char *text, size_t size)
{
    struct tokens tokens;
    tokens_scan(&tokens, text, size);
    for (int i = 0; i < tokens.n; i++) {
        PROMISE(tokens.items[i].begin <= tokens.items[i].end);
        PROMISE(tokens.items[i].end <= size);
        if (token_is_directive(&tokens, i, "include"))
            free(rewrite_include_name(&tokens, i));
        free(media_declared_name(&tokens, i));
    }
    char *holders[] = {"Smoke"};
    for (int mode = REWRITE_RECORD; mode < REWRITE_N_MODES; mode++) {
        struct text out = {0};
        struct rewrite how = {.mode = mode,
                              .head = "#declare RF_=0; ",
                              .include_path = include_path,
                              .makes_transform = makes_transform,
                              .user = &tokens,
                              .holders = holders,
                              .n_holders = 1};
        rewrite_file(&out, &tokens, size, &how);
        PROMISE(count_lines(out.data ? out.data : "", out.n) ==
                count_lines(text, size));
        text_free(&out);
    }
    rewrite_has_camera(&tokens);
    tokens_free(&tokens);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1);
    memcpy(text, data, size);
    text[size] = '\0';
    if (size > 0 && text[0] == '@') {
        struct povray_camera camera;
        struct povray_error error;
        double number;
        int n_guesses = 0;
        for (int guess = 0; guess < 3; guess++)
            camera_replay(&camera, text, guess, &n_guesses, &error);
        records_find_number(text, "version", &number);
    } else {
        rewrite(text, size);
    }
    free(text);
    return 0;
}
