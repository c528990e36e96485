/* SPDX-License-Identifier: Apache-2.0 */
/* Memory asked for ahead of its use. */
#ifndef RF_BASE_FETCH_H
#define RF_BASE_FETCH_H

/*
 * Asks for n > 0 floats which are read soon, so that nobody waits for them then. GCC
 * leaves out calls of functions that do nothing else: they are to be always inline.
 */
static inline __attribute__((always_inline)) void rf_fetch(const float *at, int n)
{
    for (int i = 0; i < n; i += 64 / (int)sizeof *at)
        __builtin_prefetch(at + i);
    __builtin_prefetch(at + n - 1);
}

#endif
