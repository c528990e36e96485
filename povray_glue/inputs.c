/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a scene is made of, as far as its text says: POV-Ray's options, those of its
 * initialisation files among them; the scene and its includes; and whatever else a
 * string in one of its own files names that is there (pictures, fonts, height fields).
 * Which frames are made is no part of it.
 */
#include <stdlib.h>
#include <string.h>

#include "ini.h"
#include "povray.h"
#include "sources.h"
#include "text.h"

struct listing {
    povray_input_fn receive;
    void *user;
};

/* Does the option only say which frames are made? */
static bool is_of_frames(const char *option)
{
    static const char *const names[][2] = {{"Initial_Frame", "KFI"},
                                           {"Final_Frame", "KFF"},
                                           {"Subset_Start_Frame", "SF"},
                                           {"Subset_End_Frame", "EF"},
                                           {"Frame_Step", "STP"}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (ini_value(option, names[i][0], names[i][1]))
            return true;
    return false;
}

static void list_option(void *user, const char *option, const char *file)
{
    const struct listing *listing = user;
    (void)file;
    if (!is_of_frames(option))
        listing->receive(listing->user, option, false);
}

static void list_strings(const struct sources *sources, const struct tokens *tokens,
                         const struct listing *listing)
{
    for (int i = 0; i < tokens->n; i++) {
        const struct token *token = &tokens->items[i];
        if (token->kind != TOKEN_STRING || token->end - token->begin < 3)
            continue;
        char *name = text_format("%.*s", (int)(token->end - token->begin - 2),
                                 tokens->text + token->begin + 1);
        char *path = name ? sources_find(sources, name) : NULL;
        if (path)
            listing->receive(listing->user, path, true);
        free(path);
        free(name);
    }
}

bool povray_list_inputs(const struct povray_plan *plan, povray_input_fn receive,
                        void *user, bool *has_computed)
{
    const struct listing listing = {receive, user};
    struct sources sources;
    *has_computed = false;
    if (!sources_load(&sources, plan->scene, plan->args, plan->n_args, ""))
        return false;
    ini_walk(plan->args, plan->n_args, list_option, (void *)&listing);
    for (int i = 0; i < sources.n; i++) {
        const struct source *source = &sources.items[i];
        receive(user, source->path, true);
        if (!source->is_own)
            continue;
        list_strings(&sources, &source->tokens, &listing);
        for (int k = 0; k < source->tokens.n; k++)
            *has_computed |= token_is_word(&source->tokens, k, "concat");
    }
    sources_free(&sources);
    return true;
}
