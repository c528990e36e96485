/* SPDX-License-Identifier: Apache-2.0 */
#include "model/reference.h"

#include <stdlib.h>

#include "common/report.h"

struct reference *reference_create(const struct picture *picture, int n_views)
{
    struct reference *reference = app_memory(1, sizeof(*reference), NULL);
    struct picture taken = *picture;
    if (!reference) {
        picture_free(&taken);
        return NULL;
    }
    *reference =
        (struct reference){.n_holders = 1, .n_views = n_views, .picture = taken};
    return reference;
}

struct reference *reference_hold(struct reference *reference)
{
    if (reference)
        __atomic_add_fetch(&reference->n_holders, 1, __ATOMIC_RELAXED);
    return reference;
}

void reference_drop(struct reference *reference)
{
    if (!reference ||
        __atomic_sub_fetch(&reference->n_holders, 1, __ATOMIC_ACQ_REL) > 0)
        return;
    picture_free(&reference->picture);
    free(reference);
}

bool reference_fits(const struct reference *reference, int32_t width, int32_t height)
{
    return reference && reference->picture.width == width &&
           reference->picture.height == height;
}
