/* SPDX-License-Identifier: Apache-2.0 */
/* The scale of a number's field. */
#ifndef VIEW_NUMBER_H
#define VIEW_NUMBER_H

#include "controls/ui.h"

/* Where on the slider a value is, 0 to 1, and the value there. */
double number_position(const struct ui_number *n, double value);
double number_at(const struct ui_number *n, double position);

/* Five digits, so that what the field shows is what is set. */
double number_round(double value);

/* The nearest value that may be typed. */
double number_limit(const struct ui_number *n, double value);

#endif
