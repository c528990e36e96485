/* SPDX-License-Identifier: Apache-2.0 */
/* Chooses the instruction set. */
#include "kernels/kernels.h"

#include <stdbool.h>
#include <string.h>

extern const struct rf_kernels rf_kernels_generic;
#ifdef RF_HAVE_X86
extern const struct rf_kernels rf_kernels_sse4, rf_kernels_avx2, rf_kernels_avx512;
#elif defined RF_HAVE_NEON
extern const struct rf_kernels rf_kernels_neon;
#endif

/* From the plainest to the best; AVX-512 is last and only taken when asked for. */
static const struct rf_kernels *const levels[] = {
    &rf_kernels_generic,
#ifdef RF_HAVE_X86
    &rf_kernels_sse4,
    &rf_kernels_avx2,
    &rf_kernels_avx512,
#elif defined RF_HAVE_NEON
    &rf_kernels_neon,
#endif
};

enum { N_LEVELS = sizeof levels / sizeof *levels };

static bool is_supported(int i)
{
    switch (i) {
#ifdef RF_HAVE_X86
    case 1:
        return __builtin_cpu_supports("sse4.1");
    case 2:
        return __builtin_cpu_supports("avx2");
    case 3:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl");
#elif defined RF_HAVE_NEON
    case 1:
        return true; /* every processor of 64 bits has it */
#endif
    default:
        return i == 0;
    }
}

const struct rf_kernels *rf_kernels_at(int i)
{
    for (int k = 0; k < N_LEVELS; k++)
        if (is_supported(k) && i-- == 0)
            return levels[k];
    return NULL;
}

const struct rf_kernels *rf_kernels_find(const char *name)
{
    const struct rf_kernels *best = &rf_kernels_generic;
    for (int i = 0; i < N_LEVELS; i++) {
        if (!is_supported(i))
            continue;
        if (name && strcmp(levels[i]->name, name) == 0)
            return levels[i];
        if (strcmp(levels[i]->name, "avx512") != 0)
            best = levels[i];
    }
    return name ? NULL : best;
}
