/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Steps back and forth between copies of one struct. Pure memory; the newest UNDO_MAX
 * copies are kept, older ones are forgotten.
 */
#ifndef VIEW_UNDO_H
#define VIEW_UNDO_H

#include <stdbool.h>
#include <stddef.h>

#define UNDO_MAX 100

struct undo {
    size_t n_bytes;        /* of a copy */
    void *items[UNDO_MAX]; /* the oldest first */
    int n, at;             /* copies; which of them holds now */
};

/* Begins anew with the only copy `item`. False without memory: nothing can be undone. */
bool undo_start(struct undo *undo, const void *item, size_t n_bytes);
void undo_free(struct undo *undo);

/* The struct is this now: a step, unless nothing has changed since the last one. What
 * could be redone is forgotten. Without memory the step is joined with the next one. */
void undo_note(struct undo *undo, const void *item);

/* What was before, or after, the copy that holds; NULL at the end. */
const void *undo_back(struct undo *undo);
const void *undo_forth(struct undo *undo);

#endif
