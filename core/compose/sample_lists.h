/* SPDX-License-Identifier: Apache-2.0 */
/* Samples sorted into the lists of tiles. */
#ifndef RF_COMPOSE_SAMPLE_LISTS_H
#define RF_COMPOSE_SAMPLE_LISTS_H

#include "base/context.h"
#include "compose/composer.h"
#include "compose/scene.h"
#include "rackfocus/rackfocus.h"

/*
 * Sorts samples into the lists of `groups` and notes in c->needed what they need; steps
 * the task once per tile of full resolution. They come from the source where that
 * emits. rf_groups_free() in any case, and c->needed is to be freed.
 */
rf_result rf_groups_build(struct rf_groups *groups, struct rf_composer *c,
                          const struct rf_samples *samples,
                          const struct rf_source *source, double progress_to,
                          struct rf_error *error);

void rf_groups_free(struct rf_groups *groups, const struct rf_context *context);

/* Frees both lists, which are as at first then. */
void rf_lists_free(struct rf_lists *lists, const struct rf_context *context);

#endif
