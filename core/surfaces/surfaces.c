/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The farther parts of mixed pixels: few pixels have one, so they lie packed, in the
 * order of the pixels, and bits tell which pixels those are.
 */
#include "surfaces/surfaces.h"

#include <stddef.h>

#include "base/context.h"
#include "base/error.h"
#include "base/pool.h"
#include "kernels/data.h"
#include "rackfocus/rackfocus.h"

static size_t n_marks(const struct rf_surfaces *s)
{
    return ((size_t)s->width * (size_t)s->height + 63) / 64;
}

rf_result rf_far_begin(struct rf_surfaces *s, const struct rf_context *context,
                       struct rf_error *error)
{
    s->mixed = rf_calloc(context, n_marks(s), sizeof *s->mixed);
    return s->mixed ? RF_OK : rf_fail_memory(error, n_marks(s), sizeof *s->mixed);
}

rf_result rf_far_allocate(struct rf_surfaces *s, const struct rf_context *context,
                          struct rf_error *error)
{
    size_t n = 0;
    for (size_t k = 0; k < n_marks(s); k++) {
        s->mixed[k].n_before = n;
        n += (size_t)__builtin_popcountll(s->mixed[k].bits);
    }
    s->far = rf_alloc(context, n, sizeof *s->far);
    return s->far ? RF_OK : rf_fail_memory(error, n, sizeof *s->far);
}

void rf_far_free(struct rf_surfaces *s, const struct rf_context *context)
{
    rf_free(context, s->mixed);
    rf_free(context, s->far);
    s->mixed = NULL;
    s->far = NULL;
}
