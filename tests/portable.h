/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests take from POSIX and GNU, where the system is neither. */
#ifndef RF_TESTS_PORTABLE_H
#define RF_TESTS_PORTABLE_H

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32

#include <malloc.h>

/* GCC knows the name, and would warn. */
#define aligned_alloc portable_aligned_alloc

static inline void *aligned_alloc(size_t alignment, size_t n_bytes)
{
    return _aligned_malloc(n_bytes, alignment);
}

/* Gives back what aligned_alloc() gave. */
static inline void aligned_release(void *memory)
{
    _aligned_free(memory);
}

static inline char *strsep(char **rest, const char *separators)
{
    char *word = *rest;
    if (!word)
        return NULL;
    char *end = word + strcspn(word, separators);
    *rest = *end ? end + 1 : NULL;
    *end = '\0';
    return word;
}

#else

static inline void aligned_release(void *memory)
{
    free(memory);
}

#endif

#endif
