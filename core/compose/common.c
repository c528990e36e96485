/* SPDX-License-Identifier: Apache-2.0 */
#include "compose/common.h"

#include "base/context.h"
#include "compose/occluder_layers.h"
#include "compose/sample_lists.h"

void rf_common_free(struct rf_common *common, const struct rf_context *context)
{
    rf_lists_free(&common->lists, context);
    rf_occluder_layers_free(&common->layers, context);
}
