/* SPDX-License-Identifier: Apache-2.0 */
/* What was typed of the lens, as POV-Ray's driver takes it: one rule for the command and
 * the window. */
#ifndef APP_POVRAY_LENS_H
#define APP_POVRAY_LENS_H

#include "povray.h"
#include "sources/settings.h"

/* An f-stop is the lens' radius for POV-Ray, whose camera has its own field of view.
 * Gives both and drops the f-stop from what was typed; false where none was, or where
 * other optics need the focal length itself. */
bool povray_lens_take_stop(struct settings *typed, struct povray_stop *stop);

/* Drops the f-stop and what says another field of view than the scene's. */
void povray_lens_drop_stop(struct settings *typed);

/* A focal length or a sensor that was typed, as a tilt goes by, is no other lens and no
 * other field of view than the passes of a perspective camera have: `radius` in scene
 * units, `focal_px` in pixels of the passes. */
void povray_lens_keep(struct settings *typed, double radius, double focal_px);

/* A tilted lens (docs/looks.md): what 1 / the distance in focus grows by per unit of the
 * tangent to the right and up, 1 / scene units. */
void povray_lens_tilt(const struct rf_params *params, double tilt[2]);

/* The lens and the focus that were typed; *stop is what povray_lens_take_stop() gave,
 * else zeros. */
void povray_lens_options(struct povray_options *options, const struct settings *typed,
                         const struct povray_stop *stop);

#endif
