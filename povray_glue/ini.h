/* SPDX-License-Identifier: Apache-2.0 */
/* POV-Ray's options: those of its command line and of its initialisation files. */
#ifndef POVRAY_INI_H
#define POVRAY_INI_H

#include <stdbool.h>

/* An option as it stands: "+W640", "Final_Frame = 5", "scene.pov". `file` is the
 * initialisation file that it stands in, NULL for the command line. */
typedef void (*ini_option_fn)(void *user, const char *option, const char *file);

/*
 * Hands all options that POV-Ray would take to `receive`, in its order: those of the
 * standard initialisation file (POVINI, povray.ini here, the user's, the system's),
 * then `args`, initialisation files among them with all they include replaced by what
 * is in them. The names of such files are handed over, too.
 */
void ini_walk(char *const *args, int n_args, ini_option_fn receive, void *user);

/* The value of an option where it is the named one, as "Final_Frame=5" (any case,
 * blanks about the sign) or as a switch, "+KFF5" ("" for none); NULL where it is
 * another. */
const char *ini_value(const char *option, const char *name, const char *letters);

/* Does the option with this value, of ini_value, turn something on? */
bool ini_is_on(const char *option, const char *value);

/* A name in quotes or not, without them; the caller frees. NULL without memory. */
char *ini_unquoted(const char *value);

/* Does the name end with .ini? */
bool ini_is_name(const char *name);

/* The file of "file.ini[Section]", or the name as it is; the caller frees. NULL without
 * memory. */
char *ini_file(const char *name);

/* Is the section that the name ends with in its file? True where it names none. */
bool ini_has_section(const char *name);

/* The standard initialisation file that POV-Ray reads, NULL where there is none. The
 * caller frees. */
char *ini_standard_file(void);

#endif
