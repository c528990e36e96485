/* SPDX-License-Identifier: Apache-2.0 */
/* The renders for the depth: the scene without and with fogs (decode.c). */
#include "fogs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "camera.h"
#include "sparse.h"
#include "text.h"

/* Below 65504^(1 / gamma) for a gamma up to 2.4, as half floats need. */
#define FOG_LIGHT 100.0
/* Distances of the two fogs, in focus distances. */
#define NEAR_FOG 0.7
#define FAR_FOG 40.0
/* The same for rays that go on behind the first surface, and how often they may. */
static const double through_fogs[FOGS_MOST] = {3, 12, 60};
#define THROUGH_LEVELS 8
/* And for a glance at what is seen through things; half floats end at 65504. */
static const double glance_fog = 0.5;
#define GLANCE_LIGHT 1e4
/* More than this share of pixels without fog is worth a second try and a warning. */
#define INSIDE_LIMIT 1e-3

static bool start_fog(struct povray_scene *scene, const struct shot *shot,
                      const struct fog_runs *fogs, struct run *run, const char *name,
                      double distance, double light, struct povray_error *error)
{
    struct text tail = {0};
    shot_add_camera(&tail, shot);
    text_addf(&tail, "global_settings{max_trace_level %d",
              fogs->is_through && distance > 0 ? THROUGH_LEVELS : 1);
    /* Indirect light would cost time, and the fogs would light things differently; the
     * last setting wins. POV-Ray takes a max_sample of 0 for none. */
    if (scene->sources.has_radiosity)
        text_addf(&tail, " radiosity{pretrace_start 1 pretrace_end 1 count 1 "
                         "nearest_count 1 recursion_limit 1 max_sample 1e-12}");
    if (scene->sources.has_photons)
        text_addf(&tail, " photons{count 1}");
    text_addf(&tail, "}\n");
    if (distance > 0)
        text_addf(&tail, "fog{fog_type 1 distance %.17g color rgb %.17g}\n", distance,
                  light);
    char *full_name = shot_name(shot, name);
    char *options = shot_options(shot, "-A -UA +Q9");
    /* The first assumed_gamma is the one that counts. */
    const char *head = fogs->is_linear ? " global_settings{assumed_gamma 1} " : "";
    const struct scene_render render = {.name = full_name,
                                        .mode = fogs->mode,
                                        .head = head,
                                        .tail = tail.data,
                                        .after = options};
    bool is_started = scene_start_render(scene, run, &render, error);
    free(options);
    free(full_name);
    text_free(&tail);
    return is_started;
}

bool fogs_start(struct povray_scene *scene, const struct shot *shot,
                struct fog_runs *fogs, struct povray_error *error)
{
    const double focus = scene->camera.focus_distance;
    const bool is_dark = scene->sources.has_fog || fogs->is_through;
    const double usual[2] = {NEAR_FOG, FAR_FOG};
    const double *distances = fogs->is_glance    ? &glance_fog
                              : fogs->is_through ? through_fogs
                                                 : usual;
    const int n = fogs->is_glance ? 1 : fogs->is_through ? FOGS_MOST : 2;
    fogs->light = fogs->is_glance ? GLANCE_LIGHT : FOG_LIGHT;
    if (scene->space.gamma > FOGS_MAX_GAMMA && !fogs->is_linear)
        fogs->light =
            pow(60000, 1 / scene->space.gamma); /* known on a second try only */
    for (int i = 0; i < n; i++) {
        const char base[] = {'b', 'a', 's', 'e', (char)('0' + i), '\0'};
        const char fog[] = {'f', 'o', 'g', (char)('0' + i), '\0'};
        fogs->distances[i] = distances[i] * focus;
        if (!fogs->is_glance && (i == 0 || is_dark) &&
            !start_fog(scene, shot, fogs, &fogs->bases[i], base,
                       is_dark ? fogs->distances[i] : 0, 0, error))
            return false;
        if (!start_fog(scene, shot, fogs, &fogs->fogged[i], fog, fogs->distances[i],
                       fogs->light, error))
            return false;
    }
    /* Without indirect light they would be too dark. */
    return !fogs->is_through || scene->sources.has_radiosity ||
           scene->sources.has_photons ||
           start_fog(scene, shot, fogs, &fogs->own, "own", 0, 0, error);
}

void fogs_stop(struct fog_runs *fogs)
{
    for (int i = 0; i < FOGS_MOST; i++) {
        run_stop(&fogs->bases[i]);
        run_stop(&fogs->fogged[i]);
    }
    for (int i = 0; i < 2; i++)
        run_stop(&fogs->dark[i]);
    run_stop(&fogs->own);
}

/* Pictures of the fogs as they are read: without fog, near and far lit, near and far
 * black. */
struct fog_pictures {
    struct decode_picture bases[2], fogged[2], dark[2];
};

static void free_pictures(struct fog_pictures *pictures)
{
    for (int i = 0; i < 2; i++) {
        free(pictures->bases[i].rgba);
        free(pictures->fogged[i].rgba);
        free(pictures->dark[i].rgba);
    }
}

static bool read_one(struct povray_scene *scene, const struct run *run,
                     const struct povray_passes *passes, struct decode_picture *picture,
                     struct povray_error *error)
{
    return !run->folder || (scene_read(scene, run, picture, error) &&
                            scene_same_size(scene, passes, picture, error));
}

static struct decode_counts decode(const struct povray_scene *scene,
                                   const struct shot *shot, const struct fog_runs *runs,
                                   const struct fog_pictures *pictures,
                                   struct povray_passes *passes)
{
    const bool is_dark = scene->sources.has_fog;
    const struct decode_space linear = {1, false};
    struct decode_fog fogs[2];
    for (int i = 0; i < 2; i++)
        fogs[i] = (struct decode_fog){.distance = runs->distances[i],
                                      .light = {runs->light, runs->light, runs->light},
                                      .base = pictures->bases[is_dark ? i : 0].rgba,
                                      .fogged = pictures->fogged[i].rgba,
                                      .dark = pictures->dark[i].rgba,
                                      .is_dark = is_dark};
    return decode_depth(fogs, runs->is_linear ? &linear : &scene->space, &shot->camera,
                        vector_length(scene->camera.direction), passes->width,
                        passes->height, passes->depth);
}

/* Black fogs for what is as bright as the lit ones: lamps, skies, suns. */
static bool add_dark(struct povray_scene *scene, const struct shot *shot,
                     struct fog_runs *runs, struct fog_pictures *pictures,
                     const struct povray_passes *passes, struct povray_error *error)
{
    struct run *list[2] = {&runs->dark[0], &runs->dark[1]};
    bool is_good = true;
    for (int i = 0; i < 2 && is_good; i++)
        is_good = start_fog(scene, shot, runs, list[i], i ? "dark1" : "dark0",
                            runs->distances[i], 0, error);
    is_good = is_good && scene_wait(scene, list, 2, error);
    for (int i = 0; i < 2 && is_good; i++)
        is_good = read_one(scene, list[i], passes, &pictures->dark[i], error);
    return is_good;
}

/* Once, of a colour that shows the same as the render without fog: the fogs of a scene
 * that has some are black, and our renders have no radiosity and no alpha. */
static void weigh_light(struct povray_scene *scene, const struct fog_runs *runs,
                        const struct fog_pictures *pictures,
                        struct povray_passes *passes)
{
    if (!scene->options.warns_by_look || scene->has_weighed || scene->sources.has_fog ||
        scene->sources.has_radiosity || runs->is_linear ||
        runs->mode != REWRITE_PINHOLE || passes->has_alpha)
        return;
    scene->has_weighed = true;
    sparse_look(passes, pictures->bases[0].rgba, &scene->space);
}

bool fogs_read(struct povray_scene *scene, const struct shot *shot,
               struct fog_runs *runs, struct povray_passes *passes,
               struct povray_error *error)
{
    bool is_good = true;
    struct fog_pictures pictures = {0};
    for (int i = 0; i < 2 && is_good; i++)
        is_good = read_one(scene, &runs->bases[i], passes, &pictures.bases[i], error) &&
                  read_one(scene, &runs->fogged[i], passes, &pictures.fogged[i], error);
    if (is_good) {
        const size_t n_pixels = (size_t)passes->width * (size_t)passes->height;
        if (!passes->depth)
            passes->depth = glue_alloc(n_pixels, sizeof(float));
        if (!passes->depth) {
            free_pictures(&pictures);
            return false;
        }
        struct decode_counts counts = decode(scene, shot, runs, &pictures, passes);
        if (counts.n_beyond > 0 && scene->space.gamma > 1 && !runs->is_linear) {
            free_pictures(&pictures);
            return fogs_repeat(scene, shot, runs->mode, true, passes, error);
        }
        if (counts.n_bright > 0 && !scene->sources.has_fog) {
            is_good = add_dark(scene, shot, runs, &pictures, passes, error);
            if (is_good)
                counts = decode(scene, shot, runs, &pictures, passes);
        }
        passes->n_inside = (double)counts.n_inside / (double)n_pixels;
        weigh_light(scene, runs, &pictures, passes);
    }
    free_pictures(&pictures);
    return is_good;
}

int fogs_list(struct fog_runs *fogs, struct run **list, int n)
{
    for (int i = 0; i < FOGS_MOST; i++) {
        if (fogs->bases[i].folder)
            list[n++] = &fogs->bases[i];
        if (fogs->fogged[i].folder)
            list[n++] = &fogs->fogged[i];
    }
    if (fogs->own.folder)
        list[n++] = &fogs->own;
    return n;
}

bool fogs_repeat(struct povray_scene *scene, const struct shot *shot,
                 enum rewrite_mode mode, bool is_linear, struct povray_passes *passes,
                 struct povray_error *error)
{
    struct fog_runs fogs = {.mode = mode, .is_linear = is_linear};
    struct run *list[FOGS_RUNS];
    bool is_good = fogs_start(scene, shot, &fogs, error) &&
                   scene_wait(scene, list, fogs_list(&fogs, list, 0), error) &&
                   fogs_read(scene, shot, &fogs, passes, error);
    fogs_stop(&fogs);
    return is_good;
}

/* Takes the depth of a copy with hollow things where it knows more; false where the
 * user ended the work. */
static bool try_hollow(struct povray_scene *scene, const struct shot *shot,
                       enum rewrite_mode mode, struct povray_passes *passes,
                       struct povray_error *error)
{
    struct povray_error ignored = {.message = ""};
    struct povray_passes second = *passes;
    second.depth = NULL;
    if (fogs_repeat(scene, shot, mode, false, &second, &ignored) &&
        second.n_inside < passes->n_inside) {
        free(passes->depth);
        passes->depth = second.depth;
        passes->n_inside = second.n_inside;
    } else {
        free(second.depth);
    }
    if (ignored.is_interrupted)
        *error = ignored;
    return !ignored.is_interrupted;
}

bool fogs_look_inside(struct povray_scene *scene, const struct shot *shot,
                      struct povray_passes *passes, enum rewrite_mode *best,
                      struct povray_error *error)
{
    *best = REWRITE_PINHOLE;
    if (passes->n_inside <= INSIDE_LIMIT)
        return true;
    for (int mode = REWRITE_HOLLOW_PLANES;
         mode <= REWRITE_HOLLOW_DECLARED && passes->n_inside > INSIDE_LIMIT; mode++) {
        const double n_before = passes->n_inside;
        if (!try_hollow(scene, shot, (enum rewrite_mode)mode, passes, error))
            return false;
        if (passes->n_inside < n_before)
            *best = (enum rewrite_mode)mode;
    }
    if (passes->n_inside > 0.5) {
        snprintf(
            error->message, sizeof error->message,
            "%s: no depth in %.0f %% of the picture: the camera is inside a solid "
            "object, or right behind a transparent one; add the word hollow to the "
            "first, take the second away",
            scene->options.scene, 100 * passes->n_inside);
        return false;
    }
    if (passes->n_inside > INSIDE_LIMIT)
        scene_add_warning(
            passes,
            "no depth in %.1f %% of the picture, which lies inside solid objects; "
            "add the word hollow to them",
            100 * passes->n_inside);
    return true;
}
