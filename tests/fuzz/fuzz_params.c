/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parameter parser: lines "KEY=TEXT". Whatever is accepted must be within the
 * table's range and must come back from its own print.
 */
#include <math.h>

#include "bytes.h"
#include "rackfocus/rackfocus.h"

static double value_of(const struct rf_params *params, const struct rf_param_info *p)
{
    const char *member = (const char *)params + p->offset;
    return p->type == RF_TYPE_FLOAT ? *(const double *)member
                                    : *(const int32_t *)member;
}

static void set(struct rf_params *params, const char *key, const char *text)
{
    struct rf_error error = {RF_OK, "", ""};
    struct rf_params before = *params;
    if (rf_params_set(params, key, text, &error) != RF_OK) {
        PROMISE(error.code == RF_ERROR_PARAMETER && error.message[0]);
        PROMISE(memcmp(&before, params, sizeof before) == 0);
        return;
    }
    const struct rf_param_info *p = rf_param_find(key);
    PROMISE(p && value_of(params, p) >= p->min && value_of(params, p) <= p->max);
    char printed[64];
    struct rf_params again;
    rf_params_init(&again);
    PROMISE(rf_params_get(params, key, printed, sizeof printed) == RF_OK);
    PROMISE(rf_params_set(&again, key, printed, &error) == RF_OK);
    PROMISE(value_of(&again, p) == value_of(params, p));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1);
    struct rf_params params;
    rf_params_init(&params);
    memcpy(text, data, size);
    text[size] = '\0';
    for (char *line = text, *end; line; line = end) {
        end = strchr(line, '\n');
        if (end)
            *end++ = '\0';
        char *value = strchr(line, '=');
        if (value)
            *value++ = '\0';
        set(&params, line, value ? value : "");
    }
    struct rf_lens lens;
    struct rf_error error;
    if (rf_params_check(&params, &error) == RF_OK &&
        rf_lens_init(&lens, &params, 640, 480, &error) == RF_OK)
        for (double z = 1e-12; z < 1e13; z *= 1000) {
            double r = rf_lens_radius_px(&lens, z);
            PROMISE(fabs(r) <= lens.max_radius_px);
        }
    free(text);
    return 0;
}
