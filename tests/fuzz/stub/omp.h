/* SPDX-License-Identifier: Apache-2.0 */
/* OpenMP of one thread: the fuzzed code is built without it, so that runs repeat. */
#ifndef STUB_OMP_H
#define STUB_OMP_H

static inline int omp_get_thread_num(void)
{
    return 0;
}

static inline int omp_get_max_threads(void)
{
    return 1;
}

static inline int omp_get_num_procs(void)
{
    return 1;
}

static inline int omp_get_num_threads(void)
{
    return 1;
}

static inline int omp_get_thread_limit(void)
{
    return 1;
}

#endif
