/* SPDX-License-Identifier: Apache-2.0 */
/* Loops on threads. */
#include "base/parallel.h"

#include <omp.h>

int rf_thread_num(void)
{
    return omp_get_thread_num();
}
