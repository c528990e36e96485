/* SPDX-License-Identifier: Apache-2.0 */
/* What systems do each in its own way. */
#include "base/system.h"

#include <locale.h>
#include <stdlib.h>

#ifdef _WIN32

#include <malloc.h>

void *rf_system_allocate(size_t alignment, size_t n_bytes)
{
    return _aligned_malloc(n_bytes, alignment);
}

void rf_system_release(void *memory)
{
    _aligned_free(memory);
}

double rf_system_strtod(const char *text, char **end)
{
    _locale_t c_locale = _create_locale(LC_ALL, "C");
    double value = c_locale ? _strtod_l(text, end, c_locale) : strtod(text, end);
    if (c_locale)
        _free_locale(c_locale);
    return value;
}

#else

#ifndef __wasi__
#include <sys/mman.h>
#endif
#ifdef __APPLE__
#include <xlocale.h>
#endif

/*
 * Buffers of a picture are touched once and given back: with pages of 4 kB a third of
 * the filter's time goes into the faults, so large blocks ask for huge ones.
 */
void *rf_system_allocate(size_t alignment, size_t n_bytes)
{
#ifdef MADV_HUGEPAGE
    enum { HUGE_PAGE = 2 << 20 };
    if (n_bytes >= 2 * HUGE_PAGE) {
        n_bytes = (n_bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
        void *memory = aligned_alloc(HUGE_PAGE, n_bytes);
        if (memory)
            madvise(memory, n_bytes, MADV_HUGEPAGE); /* only advice: may fail */
        return memory;
    }
#endif
    return aligned_alloc(alignment, n_bytes);
}

void rf_system_release(void *memory)
{
    free(memory);
}

double rf_system_strtod(const char *text, char **end)
{
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    double value = c_locale ? strtod_l(text, end, c_locale) : strtod(text, end);
    if (c_locale)
        freelocale(c_locale);
    return value;
}

#endif
