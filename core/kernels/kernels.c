/* SPDX-License-Identifier: Apache-2.0 */
/* Chooses the instruction set. */
#include "kernels.h"

extern const struct rf_kernels rf_kernels_generic;
#ifdef RF_HAVE_AVX2
extern const struct rf_kernels rf_kernels_avx2;
#endif

const struct rf_kernels *rf_kernels_best(void)
{
#ifdef RF_HAVE_AVX2
    if (__builtin_cpu_supports("avx2"))
        return &rf_kernels_avx2;
#endif
    return &rf_kernels_generic;
}
