/* SPDX-License-Identifier: Apache-2.0 */
/* Pages that commands write, with a folder of pictures beside them. */
#ifndef CLI_HTML_H
#define CLI_HTML_H

#include <stdbool.h>
#include <stdio.h>

#include "image.h"

/* Does a name end in .html or .htm? Else a message says so: another kind of file would
 * be lost. NULL, no page, is one. */
bool html_check_name(const char *page);

/* Text with its <, & and " escaped. */
void html_print(FILE *file, const char *text);

/* The name of a file or folder beside the page as an address, also within a string of
 * JavaScript: a # or % of its own would mean something else there. */
void html_print_address(FILE *file, const char *name);

/*
 * The folder of the page's pictures, "shot_frames" for "shot.html" and "_frames", made
 * if it is not there. A new one is removed with what is in it when the process ends, if
 * os_folder_keep() was not called: without its page nobody looks for the pictures. NULL
 * with an error; the caller frees it.
 */
char *html_make_folder(const char *page, const char *ending, struct image_error *error);

#endif
