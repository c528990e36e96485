/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/look_window.h"

#include <stdio.h>
#include <stdlib.h>

/* The first parameter that is measured in the picture and has an effect; NULL: none. */
static const char *find_look(const struct look_window *given)
{
    static const char *const keys[] = {
        "cat-eye",       "astigmatism",   "swirl",       "barn-left",
        "barn-right",    "barn-top",      "barn-bottom", "field-curvature",
        "split-diopter", "lateral-chroma"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        char text[RF_PARAM_TEXT_BYTES];
        if (rf_params_get(&given->settings->params, keys[i], text, sizeof text) ==
                RF_OK &&
            strtod(text, NULL) != 0 &&
            given->is_read(given->user, rf_param_find(keys[i])))
            return keys[i];
    }
    return NULL;
}

const char *look_window_explain(const struct look_window *given, char *text,
                                size_t n_bytes)
{
    const struct source *source = given->source;
    const struct image_box *display = &source->info.display_window;
    const int width = (int)(display->max_x - display->min_x + 1);
    const int height = (int)(display->max_y - display->min_y + 1);
    struct rf_params fitted = given->settings->params;
    const char *key =
        settings_fit_looks(&source->info, &fitted) ? NULL : find_look(given);
    if (key && given->is_scene) {
        snprintf(
            text, n_bytes,
            "--%s: is measured in the picture with the border beyond it, %.3g times "
            "as wide; --overscan 0 leaves the border out",
            key, (double)source->width / width);
    } else if (key) {
        const char *path = image_path(source->colour);
        snprintf(
            text, n_bytes,
            "--%s: is measured in the data window of %s, %d x %d px, not in its "
            "display window, %d x %d px: the result is not as in the whole picture; "
            "fill that up: oiiotool -a %s --croptofull -o whole.exr",
            key, path, (int)source->width, (int)source->height, width, height, path);
    }
    return key;
}
