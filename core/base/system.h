/* SPDX-License-Identifier: Apache-2.0 */
/* What systems do each in its own way. */
#ifndef RF_BASE_SYSTEM_H
#define RF_BASE_SYSTEM_H

#include <stddef.h>

/* Which printf() a format is checked for: MinGW's own knows %zu, the system's did not. */
#ifdef __MINGW32__
#define RF_PRINTF gnu_printf
#else
#define RF_PRINTF printf
#endif

/*
 * Memory of n_bytes, a multiple of alignment (a power of two, in bytes). To be given back
 * with rf_system_release(), which takes NULL too. NULL: there is none.
 */
void *rf_system_allocate(size_t alignment, size_t n_bytes);
void rf_system_release(void *memory);

/* strtod() in the C locale, so that a German desktop reads "2.8" too. */
double rf_system_strtod(const char *text, char **end);

#endif
