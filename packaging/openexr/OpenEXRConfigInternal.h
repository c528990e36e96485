/* SPDX-License-Identifier: Apache-2.0 */
/* What OpenEXR's CMake makes of OpenEXRConfigInternal.h.in. */
#pragma once
#define OPENEXR_USE_INTERNAL_DEFLATE 1
