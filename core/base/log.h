/* SPDX-License-Identifier: Apache-2.0 */
/* Messages to the host's log. */
#ifndef RF_BASE_LOG_H
#define RF_BASE_LOG_H

#include "base/context.h"
#include "base/system.h"
#include "rackfocus/rackfocus.h"

void rf_log(const struct rf_context *context, enum rf_log_level level,
            const char *format, ...) __attribute__((format(RF_PRINTF, 3, 4)));

#endif
