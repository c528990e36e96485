/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Numbers as they are typed: "2*3", "1/4", "(1 + 2) / 3", "85mm", "3 m", "inf", "f/2.8".
 *
 *   sum     = product { ("+" | "-") product }
 *   product = factor { ("*" | "/") factor }
 *   factor  = ["+" | "-"] ( number [unit] | "(" sum ")" [unit] )
 *
 * A comma is a decimal point. A number without a unit is in that of the field.
 */
#ifndef VIEW_EXPRESSION_H
#define VIEW_EXPRESSION_H

#include <stdbool.h>
#include <stddef.h>

/* What the numbers of a field are. */
struct expression_field {
    double per_mm;   /* how many of the field's units a millimetre is; 0: no length */
    bool is_angle;   /* degrees; "°", "deg" and "rad" are read */
    bool is_f_stop;  /* "f/2.8" is 2.8 */
    const char *own; /* a unit that the field shows, such as "px"; "" or NULL: none */
};

/* The value in the field's unit, INFINITY for "inf". False with a reason that says what
 * to type, at most n_bytes with the final zero. */
bool expression_read(const char *text, const struct expression_field *field,
                     double *value, char *reason, size_t n_bytes);

#endif
