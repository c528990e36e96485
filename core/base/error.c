/* SPDX-License-Identifier: Apache-2.0 */
#include "base/error.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include "rackfocus/rackfocus.h"

#define RF_TEXT(x) #x
#define RF_VERSION_TEXT(a, b, c) RF_TEXT(a) "." RF_TEXT(b) "." RF_TEXT(c)

const char *rf_version(void)
{
    return RF_VERSION_TEXT(RF_VERSION_MAJOR, RF_VERSION_MINOR, RF_VERSION_PATCH);
}

const char *rf_result_name(rf_result result)
{
    switch (result) {
    case RF_OK:
        return "done";
    case RF_ERROR_ARGUMENT:
        return "bad argument";
    case RF_ERROR_PARAMETER:
        return "bad parameter";
    case RF_ERROR_DEPTH:
        return "bad depth";
    case RF_ERROR_PIXEL:
        return "bad pixel";
    case RF_ERROR_MEMORY:
        return "out of memory";
    case RF_ERROR_CANCELLED:
        return "cancelled";
    }
    return "unknown result";
}

rf_result rf_fail(struct rf_error *error, rf_result code, const char *field,
                  const char *format, ...)
{
    if (error) {
        error->code = code;
        snprintf(error->field, sizeof error->field, "%s", field);
        va_list args;
        va_start(args, format);
        vsnprintf(error->message, sizeof error->message, format, args);
        va_end(args);
    }
    return code;
}

rf_result rf_fail_memory(struct rf_error *error, size_t count, size_t size)
{
    static const double MIB = 1024.0 * 1024.0;
    double n_bytes = (double)count * (double)size;
    if (n_bytes < MIB)
        return rf_fail(error, RF_ERROR_MEMORY, "",
                       "out of memory: %.0f bytes were needed", n_bytes);
    return rf_fail(error, RF_ERROR_MEMORY, "", "out of memory: %.1f MiB were needed",
                   n_bytes / MIB);
}
