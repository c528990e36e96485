/* SPDX-License-Identifier: Apache-2.0 */
#include "model/undo.h"

#include <stdlib.h>
#include <string.h>

#include "common/report.h"

static void forget_from(struct undo *undo, int first)
{
    for (int i = first; i < undo->n; i++)
        free(undo->items[i]);
    undo->n = first;
}

void undo_free(struct undo *undo)
{
    forget_from(undo, 0);
    *undo = (struct undo){0};
}

static bool add(struct undo *undo, const void *item)
{
    void *copy = app_memory(undo->n_bytes, 1, NULL);
    if (!copy)
        return false;
    memcpy(copy, item, undo->n_bytes);
    if (undo->n == UNDO_MAX) {
        free(undo->items[0]);
        memmove(undo->items, undo->items + 1, (UNDO_MAX - 1) * sizeof(undo->items[0]));
        undo->n--;
    }
    undo->items[undo->n++] = copy;
    undo->at = undo->n - 1;
    return true;
}

bool undo_start(struct undo *undo, const void *item, size_t n_bytes)
{
    undo_free(undo);
    undo->n_bytes = n_bytes;
    return add(undo, item);
}

void undo_note(struct undo *undo, const void *item)
{
    if (undo->n == 0 || memcmp(undo->items[undo->at], item, undo->n_bytes) == 0)
        return;
    forget_from(undo, undo->at + 1);
    add(undo, item);
}

const void *undo_back(struct undo *undo)
{
    return undo->at > 0 ? undo->items[--undo->at] : NULL;
}

const void *undo_forth(struct undo *undo)
{
    return undo->at + 1 < undo->n ? undo->items[++undo->at] : NULL;
}
