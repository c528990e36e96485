/* SPDX-License-Identifier: Apache-2.0 */
/* Is the colour of a picture multiplied by alpha, as that of EXR files should be? */
#ifndef APP_ALPHA_H
#define APP_ALPHA_H

#include <stdbool.h>
#include <stddef.h>

/* Pixels without alpha, those of them with light; pairs of pixels beside each other with
 * clearly different alphas, those of them that speak for either. All zeros at first. */
struct alpha_tally {
    size_t n_empty, n_lit, n_pairs, n_straight, n_multiplied;
};

/* Counts a row of packed pixels of red, green, blue and alpha. */
void alpha_tally_add(struct alpha_tally *tally, const float *row, size_t width);

/* Does the colour know nothing of alpha? What is then said of it follows. */
bool alpha_is_straight(const struct alpha_tally *tally);

extern const char alpha_straight_words[];

#endif
