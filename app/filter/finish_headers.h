/* SPDX-License-Identifier: Apache-2.0 */
/* What the headers of the own picture and of the guide of finish say of their lenses. */
#ifndef APP_FINISH_HEADERS_H
#define APP_FINISH_HEADERS_H

#include <stdbool.h>
#include <stddef.h>

struct settings;

/* Do both headers give the lens, and is it another? `text` says which and how. */
bool finish_lens_headers_differ(const struct settings *own, const struct settings *ours,
                                char *text, size_t n_text);

#endif
