/* SPDX-License-Identifier: Apache-2.0 */
/* Messages to the host's log. */
#include "base/log.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "base/context.h"
#include "rackfocus/rackfocus.h"

void rf_log(const struct rf_context *context, enum rf_log_level level,
            const char *format, ...)
{
    if (!context->params.log)
        return;
    char message[256];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    context->params.log(context->params.user, level, message);
}
