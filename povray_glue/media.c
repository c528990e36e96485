/* SPDX-License-Identifier: Apache-2.0 */
#include "media.h"

#include <stdlib.h>
#include <string.h>

#include "text.h"

static bool is_holder(const struct tokens *tokens, int i)
{
    return (token_is_word(tokens, i, "interior") ||
            token_is_word(tokens, i, "material")) &&
           token_is_sign(tokens, i + 1, '{');
}

/* Is it an ior that bends light, or one that is computed? */
static bool bends_light(const struct tokens *tokens, int i)
{
    if (!token_is_word(tokens, i, "ior"))
        return false;
    return i + 1 >= tokens->n || tokens->items[i + 1].kind != TOKEN_NUMBER ||
           strtod(tokens->text + tokens->items[i + 1].begin, NULL) != 1;
}

int media_skip_held(const struct tokens *tokens, int i)
{
    if (!is_holder(tokens, i))
        return 0;
    const int end = token_skip_group(tokens, i + 1);
    bool has_media = false;
    for (int k = i + 2; k < end; k++) {
        has_media |= token_is_word(tokens, k, "media");
        if (bends_light(tokens, k))
            return 0;
    }
    return has_media ? end : 0;
}

int media_skip_named(const struct tokens *tokens, int i, char *const *names, int n)
{
    if (!is_holder(tokens, i) || i + 2 >= tokens->n ||
        tokens->items[i + 2].kind != TOKEN_WORD)
        return 0;
    const int end = token_skip_group(tokens, i + 1);
    for (int k = i + 3; k < end; k++)
        if (bends_light(tokens, k))
            return 0;
    for (int k = 0; k < n; k++)
        if (token_is_word(tokens, i + 2, names[k]))
            return end;
    return 0;
}

char *media_declared_name(const struct tokens *tokens, int i)
{
    if ((!token_is_directive(tokens, i, "declare") &&
         !token_is_directive(tokens, i, "local")) ||
        !token_is_sign(tokens, i + 2, '=') || media_skip_held(tokens, i + 3) == 0)
        return NULL;
    const struct token *name = &tokens->items[i + 1];
    return text_format("%.*s", (int)(name->end - name->begin),
                       tokens->text + name->begin);
}
