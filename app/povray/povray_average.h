/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus povray --method accumulate: many views, rendered and averaged. */
#ifndef APP_POVRAY_AVERAGE_H
#define APP_POVRAY_AVERAGE_H

#include "povray.h"
#include "sources/settings.h"

struct povray_average {
    struct povray_scene *scene;
    const struct settings *settings; /* pattern of the lens, blend gamma where typed */
    int32_t n_views;
    enum povray_move move;
    double shutter;    /* as in struct povray_lens */
    bool has_subpixel; /* each view looks through another part of the pixels */
    int32_t frame;     /* for lens-random */
    int n_threads;
    const char *keep; /* views become KEEP_0000.exr ...; NULL: not kept */
    const char *output;
    /* Of the first view's passes, a sentence for the user; false with the error ends
     * the work before anything is written. May be NULL. */
    bool (*warn)(void *user, const char *text, struct povray_error *error);
    void *user;
};

/* Renders, averages in the scene's working space and writes the output. *facts tells of
 * the camera and the time, without pixels. */
bool povray_average_render(const struct povray_average *how,
                           struct povray_passes *facts, struct povray_error *error);

#endif
