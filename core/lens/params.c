/* SPDX-License-Identifier: Apache-2.0 */
/* The table of parameters at run time: params.def turned into defaults, checks, text.
 */
#include "lens/params.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/error.h"
#include "base/system.h"
#include "rackfocus/rackfocus.h"

#define RF_X_CHOICE(constant, name, help) {name, help},
#define RF_CHOICES(list) ((const struct rf_choice[]){list(RF_X_CHOICE)})
#define RF_N_CHOICES(list) ((int)(sizeof RF_CHOICES(list) / sizeof(struct rf_choice)))

static const struct rf_param_info table[] = {
#define RF_FLOAT(k, f, a, u, lo, hi, d, g, r, h)                                       \
    {k,                                                                                \
     #f,                                                                               \
     "rackfocus:" #a,                                                                  \
     u,                                                                                \
     h,                                                                                \
     RF_TYPE_FLOAT,                                                                    \
     RF_GROUP_##g,                                                                     \
     offsetof(struct rf_params, f),                                                    \
     lo,                                                                               \
     hi,                                                                               \
     d,                                                                                \
     NULL,                                                                             \
     0},
#define RF_INT(k, f, a, u, lo, hi, d, g, r, h)                                         \
    {k,                                                                                \
     #f,                                                                               \
     "rackfocus:" #a,                                                                  \
     u,                                                                                \
     h,                                                                                \
     RF_TYPE_INT,                                                                      \
     RF_GROUP_##g,                                                                     \
     offsetof(struct rf_params, f),                                                    \
     lo,                                                                               \
     hi,                                                                               \
     d,                                                                                \
     NULL,                                                                             \
     0},
#define RF_BOOL(k, f, a, d, g, r, h)                                                   \
    {k,                                                                                \
     #f,                                                                               \
     "rackfocus:" #a,                                                                  \
     "",                                                                               \
     h,                                                                                \
     RF_TYPE_BOOL,                                                                     \
     RF_GROUP_##g,                                                                     \
     offsetof(struct rf_params, f),                                                    \
     0,                                                                                \
     1,                                                                                \
     d,                                                                                \
     NULL,                                                                             \
     0},
#define RF_ENUM(k, f, a, list, d, g, r, h)                                             \
    {k,                                                                                \
     #f,                                                                               \
     "rackfocus:" #a,                                                                  \
     "",                                                                               \
     h,                                                                                \
     RF_TYPE_ENUM,                                                                     \
     RF_GROUP_##g,                                                                     \
     offsetof(struct rf_params, f),                                                    \
     0,                                                                                \
     RF_N_CHOICES(list) - 1,                                                           \
     d,                                                                                \
     RF_CHOICES(list),                                                                 \
     RF_N_CHOICES(list)},
#include "rackfocus/params.def"
#undef RF_FLOAT
#undef RF_INT
#undef RF_BOOL
#undef RF_ENUM
};

enum { N_PARAMS = sizeof table / sizeof table[0] };

const struct rf_param_info *rf_param_list(size_t *n)
{
    if (n)
        *n = N_PARAMS;
    return table;
}

const struct rf_param_info *rf_param_at(size_t i)
{
    return i < N_PARAMS ? &table[i] : NULL;
}

/* What lens makers call a parameter; its own name is written. */
static const struct {
    const char *name, *key;
} other_names[] = {{"squeeze", "pixel-aspect"}};

enum { N_OTHER_NAMES = sizeof other_names / sizeof other_names[0] };

const struct rf_param_info *rf_param_find(const char *name)
{
    for (size_t i = 0; name && i < N_OTHER_NAMES; i++)
        if (!strcmp(name, other_names[i].name))
            name = other_names[i].key;
    for (size_t i = 0; name && i < N_PARAMS; i++)
        if (!strcmp(name, table[i].key) || !strcmp(name, table[i].field))
            return &table[i];
    return NULL;
}

/*
 * The members of version 0.1, which is the oldest: once there are more, up to the last of
 * them. A struct that says less was not begun with rf_params_init(); of one that says
 * more, from a newer header, this library would leave parameters out.
 */
enum { LEAST_PARAMS_SIZE = sizeof(struct rf_params) };

bool rf_params_have_size(const struct rf_params *params)
{
    return params->size >= LEAST_PARAMS_SIZE && params->size <= sizeof *params;
}

rf_result rf_lens_check_size(int32_t width, int32_t height, struct rf_error *error)
{
    const bool is_width = width < 1 || width > UINT16_MAX;
    if (!is_width && height >= 1 && height <= UINT16_MAX)
        return RF_OK;
    return rf_fail(error, RF_ERROR_ARGUMENT, is_width ? "width" : "height",
                   "%d x %d px: each side must lie in 1 to 65535", width, height);
}

static rf_result check_size(const struct rf_params *params, struct rf_error *error)
{
    if (!params)
        return rf_fail(error, RF_ERROR_ARGUMENT, "params", "params is NULL");
    if (params->size > sizeof *params)
        return rf_fail(error, RF_ERROR_ARGUMENT, "size",
                       "rf_params.size is %zu, but this library knows %zu bytes: start "
                       "with rf_params_init(), or use a library as new as the header",
                       params->size, sizeof *params);
    if (params->size < LEAST_PARAMS_SIZE)
        return rf_fail(error, RF_ERROR_ARGUMENT, "size",
                       "rf_params.size is %zu, less than any version had: start with "
                       "rf_params_init()",
                       params->size);
    return RF_OK;
}

/* Is the parameter within the struct of a caller who may be older? */
static bool has_member(const struct rf_params *params, const struct rf_param_info *p)
{
    const bool is_float = p->type == RF_TYPE_FLOAT;
    return p->offset + (is_float ? sizeof(double) : sizeof(int32_t)) <= params->size;
}

static double get_number(const struct rf_params *params, const struct rf_param_info *p)
{
    const char *member = (const char *)params + p->offset;
    return p->type == RF_TYPE_FLOAT ? *(const double *)member
                                    : *(const int32_t *)member;
}

static void put_number(struct rf_params *params, const struct rf_param_info *p,
                       double v)
{
    char *member = (char *)params + p->offset;
    if (p->type == RF_TYPE_FLOAT)
        *(double *)member = v;
    else
        *(int32_t *)member = (int32_t)v;
}

void rf_params_init_sized(struct rf_params *params, size_t size)
{
    if (!params)
        return;
    memset(params, 0, size);
    for (size_t i = 0; i < N_PARAMS; i++) {
        bool is_float = table[i].type == RF_TYPE_FLOAT;
        if (table[i].offset + (is_float ? sizeof(double) : sizeof(int32_t)) <= size)
            put_number(params, &table[i], table[i].def);
    }
    params->size = size;
}

/* Behind a number: " px"; nothing for plain numbers, whose unit is "1". */
static const char *space_before(const char *unit)
{
    return *unit && strcmp(unit, "1") != 0 ? " " : "";
}

static const char *unit_of(const struct rf_param_info *p)
{
    return *space_before(p->unit) ? p->unit : "";
}

static rf_result check_range(const struct rf_param_info *p, double v,
                             struct rf_error *error)
{
    if (p->type != RF_TYPE_FLOAT && v != floor(v))
        return rf_fail(error, RF_ERROR_PARAMETER, p->field,
                       "%s is %g, but it takes whole numbers from %g to %g", p->key, v,
                       p->min, p->max);
    if (!(v >= p->min && v <= p->max))
        return rf_fail(error, RF_ERROR_PARAMETER, p->field,
                       "%s is %g; its range is %g to %g%s%s", p->key, v, p->min, p->max,
                       space_before(p->unit), unit_of(p));
    return RF_OK;
}

static rf_result find(const struct rf_params *params, const char *name,
                      const struct rf_param_info **found, struct rf_error *error)
{
    const rf_result result = check_size(params, error);
    if (result != RF_OK)
        return result;
    *found = rf_param_find(name);
    if (*found && has_member(params, *found))
        return RF_OK;
    return rf_fail(error, RF_ERROR_PARAMETER, name ? name : "",
                   "there is no parameter %s", name ? name : "NULL");
}

rf_result rf_params_set_number(struct rf_params *params, const char *name, double value,
                               struct rf_error *error)
{
    const struct rf_param_info *p;
    rf_result result = find(params, name, &p, error);
    if (result == RF_OK)
        result = check_range(p, value, error);
    if (result == RF_OK)
        put_number(params, p, value);
    return result;
}

static rf_result fail_choice(const struct rf_param_info *p, const char *text,
                             struct rf_error *error)
{
    char list[160] = "";
    size_t used = 0;
    for (int i = 0; i < p->n_choices && used < sizeof list; i++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "",
                                 p->choices[i].name);
    return rf_fail(error, RF_ERROR_PARAMETER, p->field,
                   "%s cannot be '%.40s'; it is one of %s", p->key, text, list);
}

static bool parse_number(const char *text, double *value)
{
    char *end;
    *value = rf_system_strtod(text, &end);
    /* 0x10 is more likely half of a mistake than 16. */
    return end != text && *end == '\0' && !strpbrk(text, "xX");
}

static bool parse_bool(const char *text, double *value)
{
    static const char *const names[2][4] = {{"0", "false", "no", "off"},
                                            {"1", "true", "yes", "on"}};
    for (int v = 0; v < 2; v++)
        for (int i = 0; i < 4; i++)
            if (!strcasecmp(text, names[v][i])) {
                *value = v;
                return true;
            }
    return false;
}

rf_result rf_params_set(struct rf_params *params, const char *name, const char *text,
                        struct rf_error *error)
{
    const struct rf_param_info *p;
    const rf_result result = find(params, name, &p, error);
    if (result != RF_OK)
        return result;
    if (!text)
        return rf_fail(error, RF_ERROR_PARAMETER, p->field,
                       "%s has no text: it is NULL", p->key);
    double value;
    if (p->type == RF_TYPE_ENUM) {
        for (int i = 0; i < p->n_choices; i++)
            if (!strcmp(text, p->choices[i].name)) {
                put_number(params, p, i);
                return RF_OK;
            }
        return fail_choice(p, text, error);
    }
    if (p->type == RF_TYPE_BOOL && !parse_bool(text, &value))
        return rf_fail(error, RF_ERROR_PARAMETER, p->field,
                       "%s cannot be '%.40s'; it is true or false", p->key, text);
    if (p->type != RF_TYPE_BOOL && !parse_number(text, &value))
        return rf_fail(error, RF_ERROR_PARAMETER, p->field,
                       "%s cannot be '%.40s'; it is a number from %g to %g%s%s", p->key,
                       text, p->min, p->max, space_before(p->unit), unit_of(p));
    return rf_params_set_number(params, name, value, error);
}

/* The shortest decimals that read back to the same double. */
static void print_number(double value, char text[RF_PARAM_TEXT_BYTES])
{
    for (int digits = 6; digits <= 17; digits++) {
        double back;
        snprintf(text, RF_PARAM_TEXT_BYTES, "%.*g", digits, value);
        for (char *comma = strchr(text, ','); comma; comma = NULL)
            *comma = '.';
        if (parse_number(text, &back) && back == value)
            break;
    }
}

rf_result rf_params_get(const struct rf_params *params, const char *name, char *text,
                        size_t n_bytes)
{
    const struct rf_param_info *p;
    const rf_result result = find(params, name, &p, NULL);
    if (result != RF_OK)
        return result;
    char number[RF_PARAM_TEXT_BYTES];
    const char *whole = number;
    const double value = get_number(params, p);
    if (p->type == RF_TYPE_ENUM)
        whole = value >= 0 && value < p->n_choices ? p->choices[(int)value].name : "?";
    else if (p->type == RF_TYPE_BOOL)
        whole = value != 0 ? "true" : "false";
    else
        print_number(value, number);
    if (!text || strlen(whole) >= n_bytes) {
        if (text && n_bytes > 0)
            text[0] = '\0';
        return RF_ERROR_ARGUMENT;
    }
    strcpy(text, whole);
    return RF_OK;
}

void rf_params_complete(struct rf_params *full, const struct rf_params *params)
{
    rf_params_init(full);
    memcpy(full, params, params->size < sizeof *full ? params->size : sizeof *full);
    full->size = sizeof *full;
}

/* At -1 three arcs meet in the middle, and nothing is open. */
static const double LEAST_OF_THREE = -0.9;

rf_result rf_params_check_ranges(const struct rf_params *params, struct rf_error *error)
{
    const rf_result size_result = check_size(params, error);
    if (size_result != RF_OK)
        return size_result;
    struct rf_params full;
    rf_params_complete(&full, params);
    params = &full;
    for (size_t i = 0; i < N_PARAMS; i++) {
        rf_result result = check_range(&table[i], get_number(params, &table[i]), error);
        if (result != RF_OK)
            return result;
    }
    bool is_polygon = params->aperture == RF_APERTURE_POLYGON;
    if (params->blades == 1 || params->blades == 2 ||
        (is_polygon && params->blades == 0))
        return rf_fail(error, RF_ERROR_PARAMETER, "blades",
                       "a polygon of %d blades: give 3 to 16%s", params->blades,
                       is_polygon ? "" : ", or 0 for a disc");
    if (params->blades == 3 && params->blade_curvature < LEAST_OF_THREE)
        return rf_fail(error, RF_ERROR_PARAMETER, "blade_curvature",
                       "blade-curvature is %g, but the edges of 3 blades meet in the "
                       "middle below %g: give more, or 4 blades and more",
                       params->blade_curvature, LEAST_OF_THREE);
    return RF_OK;
}
