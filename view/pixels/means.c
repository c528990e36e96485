/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/means.h"

#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "sources/mean_depth.h"

static rf_result fail_memory(struct rf_error *error)
{
    *error = (struct rf_error){.code = RF_ERROR_MEMORY, .message = "out of memory"};
    return RF_ERROR_MEMORY;
}

rf_result means_open(struct means *means, const struct input *input,
                     const struct rf_params *params, struct rf_error *error)
{
    struct rf_lens lens;
    *means = (struct means){
        .n = input->n_views,
        .views = app_memory((size_t)input->n_views, sizeof(*means->views), NULL)};
    if (!means->views)
        return fail_memory(error);
    memcpy(means->views, input->views, (size_t)means->n * sizeof(*means->views));
    rf_result result = rf_lens_init(&lens, params, input->width, input->height, error);
    for (int i = 0; i < means->n && result == RF_OK && mean_depth_is_used(params); i++)
        if (input->rays[i] &&
            !mean_depth_make(&lens, params, input->rays[i], &means->views[i], NULL))
            result = fail_memory(error);
    if (result != RF_OK)
        means_close(means);
    return result;
}

void means_close(struct means *means)
{
    for (int i = 0; i < means->n && means->views; i++)
        free(means->views[i].mean_depth.data);
    free(means->views);
    *means = (struct means){0};
}
