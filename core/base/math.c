/* SPDX-License-Identifier: Apache-2.0 */
/* Elementary functions with the same bits on every machine. */
#include "base/math.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/*
 * exp(v) = 2^n e^f, n = round(v / ln 2), |f| <= ln 2 / 2, with the Taylor polynomial of
 * degree 7 (remainder below 6e-9).
 */
float rf_expf(float v)
{
    v = v < -80 ? -80 : v > 88 ? 88 : v;
    float n = rintf(v * 1.44269504f);
    float f = v - n * 0.693145752f;
    f -= n * 1.42860677e-6f; /* ln 2 in two parts */
    float p = 1.0f / 5040;
    p = p * f + 1.0f / 720;
    p = p * f + 1.0f / 120;
    p = p * f + 1.0f / 24;
    p = p * f + 1.0f / 6;
    p = p * f + 0.5f;
    p = p * f + 1;
    p = p * f + 1;
    uint32_t bits = (uint32_t)((int32_t)n + 127) << 23;
    float scale;
    memcpy(&scale, &bits, sizeof scale);
    return p * scale;
}
