/* SPDX-License-Identifier: Apache-2.0 */
/* Where Blender keeps its colours. */
#ifndef VIEW_COLOUR_FIND_H
#define VIEW_COLOUR_FIND_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Its config.ocio: of the `blender` in the search path, of an installation by Debian's
 * packages. False where there is none. */
bool colour_find_blender(char *path, size_t n_bytes);

#ifdef __cplusplus
}
#endif

#endif
