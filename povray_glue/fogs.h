/* SPDX-License-Identifier: Apache-2.0 */
/* Depth of a scene from renders with fogs. */
#ifndef POVRAY_FOGS_H
#define POVRAY_FOGS_H

#include "scene.h"

/* Above it the usual light of the fogs is too bright for half floats. */
#define FOGS_MAX_GAMMA 2.4

/* Distances of fogs: two, and three for what is seen through things. */
#define FOGS_MOST 3

/* Renders: bases[0] serves both fogs where the scene has none, dark where it has things
 * as bright as the fog. Begin with {0}; those without a folder are not used. */
struct fog_runs {
    struct run bases[FOGS_MOST], fogged[FOGS_MOST], dark[2];
    struct run own; /* with is_through: the light of the first surfaces alone */
    double light, distances[FOGS_MOST];
    /* For fogs_start to read. */
    enum rewrite_mode mode;
    bool
        is_linear; /* in an assumed_gamma of 1: half floats then hold brighter things */
    /* The rays go on behind the first surface, bases[] have black fog (through.c). */
    bool is_through;
    /* The same at a glance: one lit fog, so bright that the scene's own light is nothing
     * beside it. */
    bool is_glance;
};

/* Starts the renders of a copy of the scene. */
bool fogs_start(struct povray_scene *scene, const struct shot *shot,
                struct fog_runs *fogs, struct povray_error *error);
void fogs_stop(struct fog_runs *fogs);

/* Adds those that were started to a list of n; returns its new length, at most
 * n + FOGS_RUNS.
 */
enum { FOGS_RUNS = 2 * FOGS_MOST + 1 };
int fogs_list(struct fog_runs *fogs, struct run **list, int n);

/* Sets passes->depth, allocated where NULL, and n_inside from renders that have ended.
 * Renders more where things are too bright for these. */
bool fogs_read(struct povray_scene *scene, const struct shot *shot,
               struct fog_runs *fogs, struct povray_passes *passes,
               struct povray_error *error);

/* All of it at once: another round where the first was too bright or did not reach. */
bool fogs_repeat(struct povray_scene *scene, const struct shot *shot,
                 enum rewrite_mode mode, bool is_linear, struct povray_passes *passes,
                 struct povray_error *error);

/* POV-Ray computes no fog inside solid things; where the camera is in one that is not
 * hollow, copies of the scene in which things are hollow may tell. False with a message
 * where most of the depth stays unknown; a smaller part becomes a warning. *best is the
 * mode whose depth was taken. */
bool fogs_look_inside(struct povray_scene *scene, const struct shot *shot,
                      struct povray_passes *passes, enum rewrite_mode *best,
                      struct povray_error *error);

#endif
