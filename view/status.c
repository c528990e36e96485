/* SPDX-License-Identifier: Apache-2.0 */
/* The line at the bottom. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "app.h"
#include "clock.h"

/* How long it stays, and letters that are read in a second. */
#define STATUS_S 6.0
#define LETTERS_S 15.0

void view_say(struct app *app, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(app->status, sizeof(app->status), format, arguments);
    va_end(arguments);
    app->status_until_s =
        os_clock_s() + STATUS_S + (double)strlen(app->status) / LETTERS_S;
    app->state.problem[0] = 0;
    app->is_redraw_due = true;
    trace_text(app, "said", app->status);
}
