/* SPDX-License-Identifier: Apache-2.0 */
/* Which program POV-Ray is. */
#ifndef POVRAY_PROGRAM_H
#define POVRAY_PROGRAM_H

#include <stdbool.h>

/* The i-th to try, from 0 on; NULL after the last. `chosen`: the user's, or NULL. */
const char *program_name(const char *chosen, int i);

/* POV-Ray for Windows opens a window, and ends after the picture only by "/EXIT". */
bool program_has_window(const char *name);

#endif
