/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Views from points of the lens, colour only, to be averaged.
 *
 *   shift     eye E + x R + y U, direction D - (|D| / F) (x R + y U)
 *             right width - |right| a (x R + y U), up height likewise by b, where the plane
 *             in focus is tilted: 1 / F + a t_x + b t_y at the tangents t_x and t_y
 *   look-at   eye the same, the axes turned as gluLookAt(eye, E + F D / |D|, up) does
 *
 *   x y   scene units right and up on the lens       R U   unit vectors right and up
 *   E D   the camera's location and direction        F     focus distance
 *
 * Sources: OpenGL programming guide, "depth of field": glFrustum(left - x n / F, right
 * - x n / F, bottom - y n / F, top - y n / F, n, far). POV-Ray's frustum is D +- right
 * / 2
 * +- up / 2, with |D| for n, so a shift of all edges is one of D. OpenGL wikibook,
 * "depth of field": views on a circle that look at one point.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"
#include "clock.h"
#include "scene.h"
#include "text.h"

/* ---- the camera ---------------------------------------------------------------- */

static void cross(const double a[3], const double b[3], double product[3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        product[i] = a[j] * b[k] - a[k] * b[j];
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void make_unit(double v[3])
{
    double length = vector_length(v);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

/* gluLookAt's side, up and forward for a camera that looks along `forward`. */
static void look_along(const double forward[3], const double up[3], double axes[3][3])
{
    memcpy(axes[2], forward, sizeof axes[2]);
    make_unit(axes[2]);
    cross(axes[2], up, axes[0]);
    make_unit(axes[0]);
    cross(axes[0], axes[2], axes[1]);
}

static void turn(double v[3], double from[3][3], double to[3][3])
{
    double parts[3] = {dot(v, from[0]), dot(v, from[1]), dot(v, from[2])};
    for (int i = 0; i < 3; i++)
        v[i] = parts[0] * to[0][i] + parts[1] * to[1][i] + parts[2] * to[2][i];
}

static void turn_to(struct povray_camera *camera, const double target[3])
{
    double from[3][3], to[3][3], forward[3], up[3];
    memcpy(up, camera->up, sizeof up);
    for (int i = 0; i < 3; i++)
        forward[i] = target[i] - camera->location[i];
    look_along(camera->direction, up, from);
    look_along(forward, up, to);
    turn(camera->direction, from, to);
    turn(camera->right, from, to);
    turn(camera->up, from, to);
}

/* Moves what is seen by a part of a pixel. */
static void shift_pixels(struct povray_camera *camera, const struct povray_view *view,
                         int32_t width, int32_t height)
{
    double *at = camera->is_orthographic ? camera->location : camera->direction;
    for (int i = 0; i < 3; i++)
        at[i] +=
            view->x_px / width * camera->right[i] + view->y_px / height * camera->up[i];
}

static void move_camera(struct povray_camera *camera, const double offset[2],
                        const struct povray_lens *lens)
{
    double width = vector_length(camera->right), height = vector_length(camera->up);
    double right = offset[0] / width, up = offset[1] / height;
    double reach = camera->focus_distance / vector_length(camera->direction);
    double target[3];
    for (int i = 0; i < 3; i++) {
        double moved = right * camera->right[i] + up * camera->up[i];
        target[i] = camera->location[i] + reach * camera->direction[i];
        camera->location[i] += moved;
        if (lens->move != POVRAY_MOVE_SHIFT)
            continue;
        camera->direction[i] -= moved / reach;
        camera->right[i] -= width * lens->tilt[0] * moved;
        camera->up[i] -= height * lens->tilt[1] * moved;
    }
    if (lens->move == POVRAY_MOVE_LOOK_AT)
        turn_to(camera, target);
}

/* ---- moments ------------------------------------------------------------------- */

/* The clock as the scene was parsed with it last. */
struct clock {
    double now, step, first, last;
};

static struct clock read_clock(const struct povray_scene *scene)
{
    struct clock clock = {0};
    records_find_number(scene->records, "clock", &clock.now);
    records_find_number(scene->records, "delta", &clock.step);
    records_find_number(scene->records, "first", &clock.first);
    records_find_number(scene->records, "last", &clock.last);
    return clock;
}

/* An animation keeps its frames: both ends of its clock move. */
static void set_clock(struct povray_scene *scene, const struct clock *clock,
                      double frames)
{
    double by = frames * clock->step;
    if (scene->options.frame >= 0)
        snprintf(scene->clock_words, sizeof scene->clock_words, "+KI%.12g +KF%.12g",
                 clock->first + by, clock->last + by);
    else
        snprintf(scene->clock_words, sizeof scene->clock_words, "+K%.12g",
                 clock->now + frames);
}

/* ---- renders ------------------------------------------------------------------- */

/* A view on its way. */
struct lens_job {
    struct run colour;
    double offset[2];
};

struct lens_work {
    struct povray_scene *scene;
    const struct povray_lens *lens;
    struct povray_camera middle; /* of the lens and of the shutter */
    struct clock clock;
};

static bool start_view(struct lens_work *work, struct lens_job *job, int i,
                       struct povray_error *error)
{
    struct povray_scene *scene = work->scene;
    const struct povray_lens *lens = work->lens;
    const struct povray_view *view = &lens->views[i];
    if (lens->shutter > 0) {
        set_clock(scene, &work->clock, lens->shutter * (view->time - 0.5));
        if (!scene_find_items(scene, error) || !scene_choose_camera(scene, error))
            return false;
    }
    struct povray_camera camera = scene->camera;
    *job = (struct lens_job){
        .offset = {view->u * camera.aperture / 4, view->v * camera.aperture / 4}};
    move_camera(&camera, job->offset, lens);
    shift_pixels(&camera, view, scene->width, scene->height);
    struct text tail = {0};
    text_addf(&tail, "\n");
    camera_write(&tail, &camera, 0);
    char *name = text_format("lens%d", i % VIEWS_AT_ONCE);
    const struct scene_render render = {.name = name,
                                        .mode = REWRITE_PINHOLE,
                                        .tail = tail.data,
                                        .before =
                                            lens->before ? lens->before : MEAN_OPTIONS,
                                        .is_picture = true,
                                        .light = SCENE_LIGHT_READ};
    bool is_started = scene_start_render(scene, &job->colour, &render, error);
    free(name);
    text_free(&tail);
    return is_started;
}

static bool finish_view(struct lens_work *work, struct lens_job *job,
                        struct povray_passes *passes, struct povray_error *error)
{
    const struct povray_scene *scene = work->scene;
    struct run *list[] = {&job->colour};
    struct decode_picture picture = {0};
    *passes = (struct povray_passes){.camera = work->middle,
                                     .gamma = scene->space.gamma,
                                     .is_srgb = scene->space.is_srgb,
                                     .supersample = 1,
                                     .lens_offset = {job->offset[0], job->offset[1]}};
    if (!scene_wait(scene, list, 1, error) ||
        !scene_read(work->scene, &job->colour, &picture, error))
        return false;
    scene_take_colour(passes, &picture, &job->colour);
    return true;
}

static bool run_views(struct lens_work *work, povray_view_fn receive, void *user,
                      struct povray_error *error)
{
    const struct povray_options *options = &work->scene->options;
    struct lens_job jobs[VIEWS_AT_ONCE] = {0};
    bool is_good = true;
    int n_views = work->lens->n_views;
    for (int i = 0; i < n_views + VIEWS_AT_ONCE - 1 && is_good; i++) {
        int done = i - (VIEWS_AT_ONCE - 1);
        if (i < n_views)
            is_good = start_view(work, &jobs[i % VIEWS_AT_ONCE], i, error);
        if (done < 0 || !is_good)
            continue;
        struct lens_job *job = &jobs[done % VIEWS_AT_ONCE];
        struct povray_passes passes;
        is_good = finish_view(work, job, &passes, error) && !glue_is_lost() &&
                  receive(user, done, &passes, error);
        povray_passes_free(&passes);
        run_stop(&job->colour);
        if (options->progress)
            options->progress(options->user, (done + 1.0) / n_views);
    }
    for (int i = 0; i < VIEWS_AT_ONCE; i++)
        run_stop(&jobs[i].colour);
    return is_good;
}

bool povray_render_lens(struct povray_scene *scene, const struct povray_lens *lens,
                        povray_view_fn receive, void *user, double *total_s,
                        struct povray_error *error)
{
    struct lens_work work = {.scene = scene, .lens = lens};
    double started_s = os_clock_s(), gamma;
    bool is_good = povray_find_camera(scene, &work.middle, &gamma, error);
    if (is_good) {
        work.clock = read_clock(scene);
        is_good = run_views(&work, receive, user, error);
        scene->clock_words[0] = 0;
        scene->camera = work.middle;
    }
    *total_s = os_clock_s() - started_s;
    return glue_settle(is_good, error);
}
