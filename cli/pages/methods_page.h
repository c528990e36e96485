/* SPDX-License-Identifier: Apache-2.0 */
/* The page of compare-methods: any two pictures under a slider, and all figures. */
#ifndef CLI_METHODS_PAGE_H
#define CLI_METHODS_PAGE_H

#include "image.h"
#include "pages/methods_entry.h"

/* PNGs of an entry and of its error (encoded; NULL: none) in the page's folder. A NULL
 * entry is the reference. */
bool methods_page_put(const char *folder, const struct methods_subject *subject,
                      const struct methods_entry *entry, const float *picture,
                      const float *error_map, struct image_error *error);

/* The page itself, whose pictures are in the folder beside it. */
bool methods_page_write(const char *path, const char *folder,
                        const struct methods_subject *subject,
                        const struct methods_entry *entries, int n_entries,
                        struct image_error *error);

#endif
