/* SPDX-License-Identifier: Apache-2.0 */
#include "../internal.h"
rf_result rf_layered_run(struct rf_work *work, struct rf_error *error)
{
    return rf_scatter_run(work, error);
}
