/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The renders of a job. A run that only parses records the camera; then the colour, the
 * probe and the fogs render side by side. Where the passes are those of the scene's own
 * camera and size, the colour render starts at once.
 */
#include "povray.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "camera.h"
#include "clock.h"
#include "fogs.h"
#include "scene.h"
#include "text.h"
#include "through.h"

/* Fine enough for thin edges that the lens will enlarge; docs/povray.md has times. */
#define COLOUR_OPTIONS "+A0.05 +AM2 +R3"
/* With several samples along a side of each pixel. */
#define SAMPLES_OPTIONS "+A0.05 +AM1 +R2 -J"

void povray_passes_free(struct povray_passes *passes)
{
    free(passes->colour);
    free(passes->depth);
    *passes = (struct povray_passes){0};
}

static bool read_colour(struct povray_scene *scene, struct run *run,
                        struct povray_passes *passes, struct povray_error *error)
{
    struct decode_picture picture = {0};
    if (!scene_read(scene, run, &picture, error))
        return false;
    scene_take_colour(passes, &picture, run);
    return true;
}

struct job {
    struct run colour, probe;
    struct fog_runs fogs;
};

/* Colour of a shot; with several samples in each pixel the edges need few more. */
static bool start_colour(struct povray_scene *scene, const struct shot *shot,
                         struct run *run, const char *options,
                         struct povray_error *error)
{
    struct text tail = {0};
    shot_add_camera(&tail, shot);
    char *name = shot_name(shot, "colour"), *after = shot_options(shot, "");
    const struct scene_render render = {
        .name = name,
        .mode = REWRITE_PINHOLE,
        .tail = tail.data,
        .before = scene->supersample > 1 ? SAMPLES_OPTIONS : options,
        .after = after,
        .is_picture = true,
        .light = shot->view < 0 ? SCENE_LIGHT_KEPT : SCENE_LIGHT_READ};
    bool is_started = scene_start_render(scene, run, &render, error);
    free(name);
    free(after);
    text_free(&tail);
    return is_started;
}

/* Colour, probe and fogs are on their way. */
static bool start_job(struct povray_scene *scene, struct job *job, struct shot *shot,
                      struct povray_error *error)
{
    const bool is_early =
        scene->options.supersample == 1 && scene->options.overscan_px == 0;
    *shot = (struct shot){.view = -1, .is_scenes = true};
    scene->supersample = 1;
    if ((is_early && !start_colour(scene, shot, &job->colour, COLOUR_OPTIONS, error)) ||
        !scene_find_items(scene, error) || !scene_choose_camera(scene, error) ||
        !scene_choose_window(scene, true, error))
        return false;
    *shot = shot_make(scene, &scene->camera, -1);
    return scene_start_probe(scene, &job->probe, error) &&
           (is_early ||
            start_colour(scene, shot, &job->colour, COLOUR_OPTIONS, error)) &&
           fogs_start(scene, shot, &job->fogs, error);
}

static void stop_job(struct job *job)
{
    run_stop(&job->colour);
    run_stop(&job->probe);
    fogs_stop(&job->fogs);
}

/* The probe showed another camera than the one that the passes are rendered with. */
static bool restart_job(struct povray_scene *scene, struct job *job, struct shot *shot,
                        struct povray_error *error)
{
    if (shot->is_scenes)
        return true; /* POV-Ray knew its camera; only the depth is to be decoded anew */
    stop_job(job);
    *job = (struct job){.fogs.mode = REWRITE_PINHOLE};
    if (!scene_choose_window(scene, true, error))
        return false;
    *shot = shot_make(scene, &scene->camera, -1);
    return start_colour(scene, shot, &job->colour, COLOUR_OPTIONS, error) &&
           fogs_start(scene, shot, &job->fogs, error);
}

static bool run_job(struct povray_scene *scene, struct job *job,
                    struct povray_passes *passes, struct povray_error *error)
{
    struct run *list[1 + FOGS_RUNS] = {&job->colour}, *probe = &job->probe;
    struct shot shot;
    if (!start_job(scene, job, &shot, error))
        return false;
    /* A camera that is not ours is known long before the colour is ready. */
    if (!scene_wait(scene, &probe, 1, error))
        return false;
    const struct povray_camera first = scene->camera;
    if (!scene_check_probe(scene, probe, error) &&
        (!scene_probe_again(scene, error) || (!camera_is_same(&first, &scene->camera) &&
                                              !restart_job(scene, job, &shot, error))))
        return false;
    if (shot.is_scenes)
        shot.camera = scene->camera;
    if (!run_wait(list, fogs_list(&job->fogs, list, 1), &scene->options, error) ||
        !read_colour(scene, &job->colour, passes, error))
        return false;
    bool is_good =
        scene->space.gamma > FOGS_MAX_GAMMA
            ? fogs_repeat(scene, &shot, REWRITE_PINHOLE, false, passes, error)
            : fogs_read(scene, &shot, &job->fogs, passes, error);
    enum rewrite_mode mode;
    return is_good && fogs_look_inside(scene, &shot, passes, &mode, error) &&
           through_look(scene, &shot, mode, passes, error);
}

bool povray_render(struct povray_scene *scene, struct povray_passes *passes,
                   struct povray_error *error)
{
    struct job job = {.fogs.mode = REWRITE_PINHOLE};
    double started_s = os_clock_s();
    *passes = (struct povray_passes){0};
    *error = (struct povray_error){.message = ""};
    const bool is_good = glue_settle(run_job(scene, &job, passes, error), error);
    stop_job(&job);
    passes->supersample = scene->supersample;
    passes->border_px = scene->border_px;
    passes->camera = scene->camera;
    passes->gamma = scene->space.gamma;
    passes->is_srgb = scene->space.is_srgb;
    passes->total_s = os_clock_s() - started_s;
    if (!is_good)
        povray_passes_free(passes);
    return is_good;
}

void povray_describe(const struct povray_scene *scene, struct povray_passes *passes)
{
    const int32_t n = scene->supersample, border = scene->border_px;
    *passes = (struct povray_passes){.width = n * (scene->width + 2 * border),
                                     .height = n * (scene->height + 2 * border),
                                     .supersample = n,
                                     .border_px = border,
                                     .camera = scene->camera,
                                     .gamma = scene->space.gamma,
                                     .is_srgb = scene->space.is_srgb};
}

/* ---- views --------------------------------------------------------------------- */

/* A view on its way. */
struct view_job {
    struct shot shot;
    double offset[2];
    struct run colour;
    struct fog_runs fogs;
};

/* Moves the camera over its lens and shears it back to the plane in focus. */
static void move_camera(struct povray_camera *camera, const double offset[2])
{
    double right = offset[0] / vector_length(camera->right);
    double up = offset[1] / vector_length(camera->up);
    double shear = vector_length(camera->direction) / camera->focus_distance;
    for (int i = 0; i < 3; i++) {
        double moved = right * camera->right[i] + up * camera->up[i];
        camera->location[i] += moved;
        camera->direction[i] -= shear * moved;
    }
}

static bool start_view(struct povray_scene *scene, struct view_job *job, int view,
                       const double place[2], struct povray_error *error)
{
    struct povray_camera camera = scene->camera;
    *job = (struct view_job){.fogs.mode = REWRITE_PINHOLE};
    job->offset[0] = place[0] * scene->camera.aperture / 4;
    job->offset[1] = place[1] * scene->camera.aperture / 4;
    move_camera(&camera, job->offset);
    job->shot = shot_make(scene, &camera, view);
    return start_colour(scene, &job->shot, &job->colour, VIEW_OPTIONS, error) &&
           fogs_start(scene, &job->shot, &job->fogs, error);
}

static bool finish_view(struct povray_scene *scene, struct view_job *job,
                        struct povray_passes *passes, struct povray_error *error)
{
    struct run *list[1 + FOGS_RUNS] = {&job->colour};
    enum rewrite_mode mode;
    *passes = (struct povray_passes){.camera = scene->camera,
                                     .supersample = scene->supersample,
                                     .border_px = scene->border_px,
                                     .gamma = scene->space.gamma,
                                     .is_srgb = scene->space.is_srgb,
                                     .lens_offset = {job->offset[0], job->offset[1]}};
    return scene_wait(scene, list, fogs_list(&job->fogs, list, 1), error) &&
           read_colour(scene, &job->colour, passes, error) &&
           fogs_read(scene, &job->shot, &job->fogs, passes, error) &&
           fogs_look_inside(scene, &job->shot, passes, &mode, error) &&
           through_look(scene, &job->shot, mode, passes, error);
}

static void stop_view(struct view_job *job)
{
    run_stop(&job->colour);
    fogs_stop(&job->fogs);
}

/* The views that are wanted; returns how many. */
static int list_views(const struct povray_scene *scene, int n_views, int *wanted)
{
    const bool *has_view = scene->options.has_view;
    int n = 0;
    for (int i = 0; i < n_views; i++)
        if (!has_view || !has_view[i])
            wanted[n++] = i;
    return n;
}

static bool run_views(struct povray_scene *scene, const double (*places)[2],
                      const int *wanted, int n, povray_view_fn receive, void *user,
                      struct povray_error *error)
{
    struct view_job jobs[VIEWS_AT_ONCE] = {0};
    bool is_good = true;
    for (int i = 0; i < n + VIEWS_AT_ONCE - 1 && is_good; i++) {
        int done = i - (VIEWS_AT_ONCE - 1);
        if (i < n)
            is_good = start_view(scene, &jobs[i % VIEWS_AT_ONCE], wanted[i],
                                 places[wanted[i]], error);
        if (done < 0 || done >= n || !is_good)
            continue;
        struct view_job *job = &jobs[done % VIEWS_AT_ONCE];
        struct povray_passes passes;
        is_good = finish_view(scene, job, &passes, error) && !glue_is_lost() &&
                  receive(user, wanted[done], &passes, error);
        povray_passes_free(&passes);
        stop_view(job);
        if (scene->options.progress)
            scene->options.progress(scene->options.user, (done + 1.0) / n);
    }
    for (int i = 0; i < VIEWS_AT_ONCE; i++)
        stop_view(&jobs[i]);
    return is_good;
}

bool povray_render_views(struct povray_scene *scene, const double (*places)[2],
                         int n_views, povray_view_fn receive, void *user,
                         double *total_s, struct povray_error *error)
{
    struct povray_camera camera;
    double started_s = os_clock_s(), gamma;
    bool is_good = povray_find_camera(scene, &camera, &gamma, error);
    if (is_good) {
        int *wanted = calloc((size_t)n_views + 1, sizeof(*wanted));
        is_good = wanted && scene_choose_window(scene, false, error) &&
                  run_views(scene, places, wanted, list_views(scene, n_views, wanted),
                            receive, user, error);
        if (!wanted)
            snprintf(error->message, sizeof error->message, "out of memory");
        free(wanted);
    }
    *total_s = os_clock_s() - started_s;
    return glue_settle(is_good, error);
}

bool povray_find_camera(struct povray_scene *scene, struct povray_camera *camera,
                        double *gamma, struct povray_error *error)
{
    *error = (struct povray_error){.message = ""};
    bool is_found = scene_find_items(scene, error) &&
                    scene_choose_camera(scene, error) &&
                    (scene_run_probe(scene, error) || scene_probe_again(scene, error));
    *camera = scene->camera;
    *gamma = scene->space.gamma;
    return glue_settle(is_found, error);
}

bool povray_render_reference(struct povray_scene *scene,
                             const struct povray_passes *passes, int32_t n_samples,
                             float **rgba, double *seconds, struct povray_error *error)
{
    struct run run = {0}, *list[] = {&run};
    struct text tail = {0};
    struct decode_picture picture = {0};
    const struct povray_passes size = {.width = povray_picture_width(passes),
                                       .height = povray_picture_height(passes)};
    if (passes->camera.is_orthographic) {
        snprintf(error->message, sizeof error->message, "%s: %s", scene->options.scene,
                 GLUE_NO_ORTHOGRAPHIC_BLUR);
        return false;
    }
    text_addf(&tail, "\n");
    camera_write(&tail, &passes->camera, n_samples);
    const struct scene_render render = {.name = "reference",
                                        .mode = REWRITE_PINHOLE,
                                        .tail = tail.data,
                                        .light = SCENE_LIGHT_READ};
    bool is_good = scene_start_render(scene, &run, &render, error) &&
                   run_wait(list, 1, &scene->options, error) &&
                   scene_read(scene, &run, &picture, error) &&
                   scene_same_size(scene, &size, &picture, error);
    *seconds = run.ended_s - run.started_s;
    run_stop(&run);
    text_free(&tail);
    is_good = glue_settle(is_good, error);
    if (!is_good)
        free(picture.rgba);
    *rgba = is_good ? picture.rgba : NULL;
    return is_good;
}
