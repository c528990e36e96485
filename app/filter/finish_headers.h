/* SPDX-License-Identifier: Apache-2.0 */
/* What the headers of the own picture and of the guide of finish say of their renders. */
#ifndef APP_FINISH_HEADERS_H
#define APP_FINISH_HEADERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct image_input;
struct settings;

enum { FINISH_MOST_SAMPLES = 1000000 };

/* Do both headers give the lens, and is it another? `text` says which and how. */
bool finish_lens_headers_differ(const struct settings *own, const struct settings *ours,
                                char *text, size_t n_text);

/* Samples of a pixel, as Cycles writes them: the most of any view layer; 0: not known. */
int32_t finish_samples_of(const struct image_input *input, int part);

#endif
