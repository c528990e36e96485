/* SPDX-License-Identifier: Apache-2.0 */
#include "model/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

double number_position(const struct ui_number *n, double value)
{
    const double at = n->is_log
                          ? log(fmax(value, 1e-300) / n->min) / log(n->max / n->min)
                          : (value - n->min) / (n->max - n->min);
    return fmin(fmax(at, 0), 1);
}

double number_at(const struct ui_number *n, double position)
{
    const double at = fmin(fmax(position, 0), 1);
    const double value =
        n->is_log ? n->min * pow(n->max / n->min, at) : n->min + at * (n->max - n->min);
    return n->is_whole ? round(value) : value;
}

double number_round(double value)
{
    char text[32];
    snprintf(text, sizeof(text), "%.5g", value);
    return strtod(text, NULL);
}

double number_limit(const struct ui_number *n, double value)
{
    return fmin(fmax(value, n->min_limit), n->max_limit);
}
