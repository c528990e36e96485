/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the passes show. A lens sees around the border of the picture as it sees around
 * things, and it needs to know to which thing each part of a pixel belongs: so the
 * passes are wider than the picture, and have several samples of colour and depth in
 * each pixel.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"
#include "scene.h"
#include "text.h"

/* Samples along a side of a pixel, where nobody says: with mild anti-aliasing 2 score 1 to
 * 6 dB more than 1 with the strongest, for the same time; 3 up to 10 dB more than 2 where
 * things are thin, for up to twice the time, which counts in pictures larger than this
 * (docs/notebook/povray.md). */
#define SUPERSAMPLE 2
#define SMALL_SUPERSAMPLE 3
#define SMALL_PX (800 * 600)
/* Of the radius of what is infinitely far: what is nearer than half the focus distance
 * has more. */
#define BORDER_RADII 1.5
/* Share of the picture's larger side that the border has at most. */
#define MOST_BORDER 0.1

int32_t povray_picture_width(const struct povray_passes *passes)
{
    return passes->width / passes->supersample - 2 * passes->border_px;
}

int32_t povray_picture_height(const struct povray_passes *passes)
{
    return passes->height / passes->supersample - 2 * passes->border_px;
}

double scene_far_radius_px(const struct povray_scene *scene)
{
    const struct povray_camera *camera = &scene->camera;
    double px_per_unit = scene->width / vector_length(camera->right);
    if (!camera->is_orthographic)
        px_per_unit *= vector_length(camera->direction) / camera->focus_distance;
    return px_per_unit * camera->aperture / 4;
}

/* The same where the surface in focus is nearest. A lens that is tilted by 10 degrees
 * beside things of a few metres blurs the sky at a side 12 times as far as the middle: 8
 * views 39.6 dB without, 43.0 with it. */
static double border_radius_px(const struct povray_scene *scene)
{
    const struct povray_options *options = &scene->options;
    const struct povray_camera *camera = &scene->camera;
    const double length = vector_length(camera->direction);
    const double sides[2] = {vector_length(camera->right), vector_length(camera->up)};
    double grows = fabs(options->curvature);
    if (camera->is_orthographic)
        return scene_far_radius_px(scene); /* where the filter knows planes only */
    for (int i = 0; i < 2; i++)
        grows += fabs(options->tilt[i]) * sides[i] / (2 * length);
    if (options->split_distance > 0)
        grows += fabs(1 / options->split_distance - 1 / camera->focus_distance);
    return scene_far_radius_px(scene) * (1 + camera->focus_distance * grows);
}

bool scene_choose_window(struct povray_scene *scene, bool is_one_view,
                         struct povray_error *error)
{
    const struct povray_options *options = &scene->options;
    const int32_t side = scene->width > scene->height ? scene->width : scene->height;
    const double radius_px = border_radius_px(scene);
    const bool is_small = (int64_t)scene->width * scene->height <= SMALL_PX;
    scene->supersample = options->supersample > 0 ? options->supersample
                         : !is_one_view           ? 1
                         : is_small               ? SMALL_SUPERSAMPLE
                                                  : SUPERSAMPLE;
    scene->border_px = options->overscan_px;
    if (scene->border_px < 0)
        scene->border_px =
            radius_px < 0.5
                ? 0
                : (int32_t)fmin(ceil(BORDER_RADII * radius_px), MOST_BORDER * side);
    sources_set_size(&scene->sources, scene->width, scene->height);
    if (scene->border_px <= side)
        return true;
    /* Nine times the pixels and more, of which no blur within the picture shows most. */
    snprintf(
        error->message, sizeof error->message,
        "--overscan: %d px are more than the picture's longer side, %d px, and would "
        "take very long; leave it out: what the lens sees beyond the border is then "
        "rendered by itself",
        (int)scene->border_px, (int)side);
    return false;
}

struct shot shot_make(const struct povray_scene *scene,
                      const struct povray_camera *camera, int view)
{
    const int32_t n = scene->supersample, border = scene->border_px;
    struct shot shot = {.camera = *camera,
                        .view = view,
                        .width = n * (scene->width + 2 * border),
                        .height = n * (scene->height + 2 * border)};
    shot.is_scenes = view < 0 && n == 1 && border == 0;
    for (int i = 0; i < 3; i++) {
        shot.camera.right[i] *= 1 + 2.0 * border / scene->width;
        shot.camera.up[i] *= 1 + 2.0 * border / scene->height;
    }
    return shot;
}

char *shot_name(const struct shot *shot, const char *name)
{
    return shot->view < 0 ? text_format("%s", name)
                          : text_format("v%02d_%s", shot->view, name);
}

void shot_add_camera(struct text *tail, const struct shot *shot)
{
    text_addf(tail, "\n");
    if (!shot->is_scenes)
        camera_write(tail, &shot->camera, 0);
}

char *shot_options(const struct shot *shot, const char *options)
{
    if (shot->is_scenes)
        return text_format("%s", options);
    return text_format("%s +W%d +H%d", options, shot->width, shot->height);
}
