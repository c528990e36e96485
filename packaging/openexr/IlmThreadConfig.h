/* SPDX-License-Identifier: Apache-2.0 */
/* What OpenEXR's CMake makes of IlmThreadConfig.h.in; the C library only asks this. */
#pragma once
#ifdef __wasi__
#define ILMTHREAD_THREADING_ENABLED 0
#else
#define ILMTHREAD_THREADING_ENABLED 1
#endif
