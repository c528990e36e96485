/* SPDX-License-Identifier: Apache-2.0 */
/* Things that hold media (smoke, clouds, fire) and bend no light. */
#ifndef POVRAY_MEDIA_H
#define POVRAY_MEDIA_H

#include "lexer.h"

/* Token after the group of an interior or a material at i that has media in it and no ior
 * but 1; 0 where there is none. */
int media_skip_held(const struct tokens *tokens, int i);

/* The same of `interior { NAME` and `material { NAME`, NAME being one of the names. */
int media_skip_named(const struct tokens *tokens, int i, char *const *names, int n);

/* NAME of `#declare NAME = interior { media ... }`, or material, with the directive at i, as
 * a new string; NULL where it is no such. */
char *media_declared_name(const struct tokens *tokens, int i);

#endif
