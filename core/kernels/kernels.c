/* SPDX-License-Identifier: Apache-2.0 */
/* Chooses the instruction set. */
#include "kernels/kernels.h"

#include <stdbool.h>
#include <string.h>
#ifdef RF_HAVE_X86
#include <cpuid.h>
#endif

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

#ifdef RF_HAVE_X86
/*
 * Asked of the processor itself: __builtin_cpu_supports() wants the compiler's own
 * library, and says no to everything where another one is linked (zig). Intel's manual,
 * volume 1, chapter 14.3: the system must also keep the registers (XCR0).
 */
static bool has_x86(int level)
{
    enum { OSXSAVE = 1 << 27, YMM_STATE = 0x06, ZMM_STATE = 0xe6 };
    unsigned a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d))
        return false;
    if (level == 1)
        return c & bit_SSE4_1;
    if (!(c & OSXSAVE) || !(c & bit_AVX))
        return false;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return false;
    if (level == 2)
        return (low & YMM_STATE) == YMM_STATE && b & bit_AVX2;
    return (low & ZMM_STATE) == ZMM_STATE && b & bit_AVX512F && b & bit_AVX512VL;
}
#endif

static bool is_supported(int i)
{
    switch (i) {
#ifdef RF_HAVE_X86
    case 1:
    case 2:
    case 3: {
        /* Asked once: CPUID takes microseconds in a virtual machine. */
        static _Atomic int known[N_LEVELS]; /* 0: not yet, 1: no, 2: yes */
        if (known[i] == 0)
            known[i] = has_x86(i) ? 2 : 1;
        return known[i] == 2;
    }
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
