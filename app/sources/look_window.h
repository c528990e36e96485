/* SPDX-License-Identifier: Apache-2.0 */
/* Looks that depend on the place in the picture, in a file that shows a part of it. */
#ifndef APP_LOOK_WINDOW_H
#define APP_LOOK_WINDOW_H

#include <stdbool.h>
#include <stddef.h>

#include "sources/settings.h"
#include "sources/source.h"

struct look_window {
    const struct source *source;
    const struct settings *settings; /* with the header's facts */
    bool is_scene;                   /* passes that POV-Ray renders with a border */
    /* Has the parameter an effect, if it is set? */
    bool (*is_read)(const void *user, const struct rf_param_info *info);
    const void *user;
};

/*
 * The first look that is measured in the data window, not in the display window, since
 * settings_fit_looks() cannot scale it; NULL: none. `text` receives what is wrong and the
 * way out, a line that begins with the option.
 */
const char *look_window_explain(const struct look_window *given, char *text,
                                size_t n_bytes);

#endif
