/* SPDX-License-Identifier: Apache-2.0 */
/* What goes wrong, said to the caller. */
#ifndef RF_BASE_ERROR_H
#define RF_BASE_ERROR_H

#include <stddef.h>

#include "base/system.h"
#include "rackfocus/rackfocus.h"

/* Fills `error` where it is not NULL and returns `code`. */
rf_result rf_fail(struct rf_error *error, rf_result code, const char *field,
                  const char *format, ...) __attribute__((format(RF_PRINTF, 4, 5)));

rf_result rf_fail_memory(struct rf_error *error, size_t count, size_t size);

#endif
