/* SPDX-License-Identifier: Apache-2.0 */
/* What OpenEXR's CMake makes of OpenEXRConfig.h.in, as far as its C library reads it. */
#pragma once
#define OPENEXR_VERSION_STRING "3.4.17"
#define OPENEXR_PACKAGE_STRING "OpenEXR 3.4.17"
#define OPENEXR_VERSION_EXTRA ""
#define OPENEXR_LIB_VERSION_STRING "33.3.4.17"
#define OPENEXR_HIDDEN
#define OPENEXR_EXPORT
