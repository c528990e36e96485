/* SPDX-License-Identifier: Apache-2.0 */
#include "model/expression.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_DEPTH = 32 /* of parentheses within each other */ };

struct reader {
    const char *at;
    const struct expression_field *field;
    char *reason;
    size_t n_bytes;
    int depth;
};

static const struct unit {
    const char *name;
    double mm; /* length; 0: an angle */
    double degrees;
} units[] = {
    {"mm", 1, 0},      {"cm", 10, 0},   {"km", 1e6, 0},
    {"m", 1000, 0},    {"in", 25.4, 0}, {"ft", 304.8, 0},
    {"deg", 0, 1},     {"°", 0, 1},     {"rad", 0, 57.295779513082320877},
    {"degrees", 0, 1},
};

static bool fail(struct reader *r, const char *format, const char *what)
{
    if (!*r->reason)
        snprintf(r->reason, r->n_bytes, format, what);
    return false;
}

static void skip_space(struct reader *r)
{
    while (*r->at == ' ' || *r->at == '\t')
        r->at++;
}

static bool take(struct reader *r, char sign)
{
    skip_space(r);
    if (*r->at != sign)
        return false;
    r->at++;
    return true;
}

/* Length of the word that begins here: letters and signs beyond ASCII. */
static size_t word_length(const char *text)
{
    size_t n = 0;
    while (isalpha((unsigned char)text[n]) || (unsigned char)text[n] >= 0x80)
        n++;
    return n;
}

static bool is_word(const char *word, size_t n, const char *name)
{
    return strlen(name) == n && strncmp(word, name, n) == 0;
}

static bool apply_unit(struct reader *r, const char *word, size_t n, double *value)
{
    const struct expression_field *field = r->field;
    char name[24];
    snprintf(name, sizeof(name), "%.*s", (int)(n < 20 ? n : 20), word);
    if (field->own && *field->own && is_word(word, n, field->own))
        return true;
    for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); i++) {
        if (!is_word(word, n, units[i].name))
            continue;
        if (units[i].mm > 0 && field->per_mm <= 0)
            return fail(r, "%s: this is no length here; type a number", name);
        if (units[i].degrees > 0 && !field->is_angle)
            return fail(r, "%s: this is no angle; type a number", name);
        *value *= units[i].mm > 0 ? units[i].mm * field->per_mm : units[i].degrees;
        return true;
    }
    return fail(r, "%s: no unit that is known; mm, cm, m, km, in and ft are", name);
}

/* The unit after a value, where there is one. */
static bool read_unit(struct reader *r, double *value)
{
    skip_space(r);
    const char *word = r->at;
    const size_t n = word_length(word);
    if (n == 0)
        return true;
    r->at += n;
    return apply_unit(r, word, n, value);
}

static bool read_infinity(struct reader *r, double *value)
{
    static const char *const names[] = {"inf", "infinity", "∞"};
    char word[24];
    const size_t n = word_length(r->at);
    snprintf(word, sizeof(word), "%.*s", (int)(n < 20 ? n : 20), r->at);
    for (char *c = word; *c; c++)
        *c = (char)tolower((unsigned char)*c);
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++)
        if (strcmp(word, names[i]) == 0) {
            r->at += n;
            *value = INFINITY;
            return true;
        }
    return false;
}

/* Digits, a point and an exponent; nothing else that strtod would take. */
static bool read_number(struct reader *r, double *value)
{
    char *end;
    if (!isdigit((unsigned char)*r->at) && *r->at != '.') {
        char found[24];
        const size_t n = word_length(r->at);
        snprintf(found, sizeof(found), "%.*s", n > 0 ? (int)(n < 20 ? n : 20) : 1,
                 r->at);
        return fail(r, *found ? "%s: is no number" : "a number is missing", found);
    }
    if (r->at[0] == '0' && (r->at[1] == 'x' || r->at[1] == 'X'))
        return fail(r, "%s: is no number", "0x");
    *value = strtod(r->at, &end);
    if (end == r->at)
        return fail(r, "%s: is no number", ".");
    r->at = end;
    return true;
}

static bool read_sum(struct reader *r, double *value);

static bool read_factor(struct reader *r, double *value)
{
    bool is_negative = false;
    for (;;) {
        if (take(r, '-'))
            is_negative = !is_negative;
        else if (!take(r, '+'))
            break;
    }
    bool is_good = true;
    if (read_infinity(r, value)) {
        /* there is no unit of it */
    } else if (take(r, '(')) {
        if (++r->depth > MOST_DEPTH)
            return fail(r, "%s", "too many parentheses");
        is_good = read_sum(r, value) &&
                  (take(r, ')') || fail(r, "%s", "a ) is missing")) &&
                  read_unit(r, value);
        r->depth--;
    } else {
        is_good = read_number(r, value) && read_unit(r, value);
    }
    if (is_negative)
        *value = -*value;
    return is_good;
}

static bool read_product(struct reader *r, double *value)
{
    if (!read_factor(r, value))
        return false;
    for (;;) {
        double other;
        const bool is_times = take(r, '*');
        if (!is_times && !take(r, '/'))
            return true;
        if (!read_factor(r, &other))
            return false;
        if (!is_times && other == 0)
            return fail(r, "%s", "division by zero");
        *value = is_times ? *value * other : *value / other;
    }
}

static bool read_sum(struct reader *r, double *value)
{
    if (!read_product(r, value))
        return false;
    for (;;) {
        double other;
        const bool is_plus = take(r, '+');
        if (!is_plus && !take(r, '-'))
            return true;
        if (!read_product(r, &other))
            return false;
        *value = is_plus ? *value + other : *value - other;
    }
}

bool expression_read(const char *text, const struct expression_field *field,
                     double *value, char *reason, size_t n_bytes)
{
    char copy[256];
    if ((size_t)snprintf(copy, sizeof(copy), "%s", text) >= sizeof(copy)) {
        snprintf(reason, n_bytes, "too long");
        return false;
    }
    for (char *c = copy; *c; c++)
        *c = *c == ',' ? '.' : *c;
    *reason = 0;
    struct reader reader = {copy, field, reason, n_bytes, 0};
    struct reader *r = &reader;
    skip_space(r);
    if (field->is_f_stop && (r->at[0] == 'f' || r->at[0] == 'F') && r->at[1] == '/')
        r->at += 2;
    double result = 0;
    if (!read_sum(r, &result))
        return false;
    skip_space(r);
    if (*r->at)
        return fail(r, "%s: cannot be read; type a number such as 2*3 or 1/4", r->at);
    if (isnan(result))
        return fail(r, "%s", "has no value");
    *value = result;
    return true;
}
