/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parameters of a run and where each value came from.
 *
 * The command line wins over the header, the header over the default. Two parameters
 * can say the same thing (f-stop and lens radius; focal length in mm and in px): where
 * the command line gives one and the header the other, the header's is recomputed, so
 * that what the user typed takes effect.
 */
#ifndef APP_SETTINGS_H
#define APP_SETTINGS_H

#include <stdbool.h>

#include "image.h"
#include "rackfocus/rackfocus.h"

enum origin {
    ORIGIN_DEFAULT,
    ORIGIN_HEADER,
    ORIGIN_COMMAND_LINE,
    ORIGIN_DERIVED, /* recomputed from a value of the command line */
};

#define SETTINGS_MAX_PARAMS 128

struct settings {
    struct rf_params params;
    enum origin origins[SETTINGS_MAX_PARAMS]; /* in the order of rf_param_list */
    char sources[SETTINGS_MAX_PARAMS][96]; /* attribute or how it was derived; or "" */
    double seen_width; /* of what is seen at a distance of 1, by a header; 0: unknown */
    char seen_by[96];  /* the attribute that says so */
};

void settings_init(struct settings *settings);

/* Where the parameter came from; `field` or key. */
enum origin settings_origin(const struct settings *settings, const char *name);

/* Did this attribute of the header give it? */
bool settings_is_by(const struct settings *settings, const char *name,
                    const char *attribute);

/* Was a fact of the header recomputed from this typed value, which acts through it? */
bool settings_acts(const struct settings *settings, const char *key);

/* "command line", "header rackfocus:fStop", "default", ... */
void settings_describe_origin(const struct settings *settings, const char *name,
                              char *text, size_t n_bytes);

/* Sets a value from the command line. */
rf_result settings_set(struct settings *settings, const char *name, const char *text,
                       struct rf_error *error);

/* Takes one value of others, with where it came from. `name`: key or field, known. */
void settings_take(struct settings *settings, const struct settings *from,
                   const char *name);

/* What some of the typed values say beside themselves: --ortho-scale that the camera is
 * orthographic. settings_read_header() does it too. */
void settings_imply(struct settings *settings);

/* Sets a value as a program recovered it; it ranks as a header's does. */
rf_result settings_set_header(struct settings *settings, const char *name, double value,
                              const char *source, struct rf_error *error);

/*
 * Takes every parameter that is still open from the header: rackfocus:* first, then the
 * standard attributes, then what the part says (pixel aspect). Returns false with a
 * message where the header holds nonsense or conflicts with an option.
 */
bool settings_read_header(struct settings *settings, const struct image_input *input,
                          int part, char *text, size_t n_bytes);

/*
 * Parameters for the data window of a picture whose camera sees the display window:
 * focal length in px, scale and shift are such that every pixel keeps its ray, and looks
 * are as in the display window where settings_fit_looks() can do that.
 */
rf_result settings_fit_window(const struct settings *settings,
                              const struct image_part_info *part,
                              struct rf_params *params, struct rf_error *error);

/*
 * Scales the looks that are measured in the picture, from the display window to the data
 * window. False: the windows have different middles, or a look would leave its range;
 * then nothing is changed.
 */
bool settings_fit_looks(const struct image_part_info *part, struct rf_params *params);

/* "--focus-distance 8 --f-stop 1.4": whatever is not the default. */
void settings_print_options(const struct rf_params *params, char *text, size_t n_bytes);

#endif
