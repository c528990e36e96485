/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sphere shows at its point p the colour
 *
 *     v = 1/2 + (p - c) / (2.2 r),
 *
 *     c  where the middle of the picture meets it    r  from there to its corners
 *
 * in the space in which POV-Ray computes, which a little card of known colour in the
 * top left corner tells. The card's pixels are left out; its size follows the shorter
 * side, so that it stays small in panoramas and banners. Orthographic cameras see a wall
 * just before them, coloured in the same way.
 */
#include "probe.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"

#define REACH 2.2
#define CARD_PLACE 0.1   /* where the card is, of the sides of what is rendered */
#define CARD_RADIUS 0.08 /* of the shorter of them */
#define CARD_LEAST_PX 0.4
#define CARD_MARGIN_PX 0.5 /* left out around it */
#define N_BLOCKS 6
#define TOLERANCE_PX 0.25
/* What rounding to half floats may leave in a block, of the picture's longer side. */
#define ROUNDING 2e-4

static const double card_colour[3] = {0.5, 0.1, 0.03};

/* Lengths as those of the camera's right and up. */
struct card {
    int32_t x, y; /* the pixel that its middle is in the middle of */
    double radius;
    double left_out; /* radius of what is not measured */
};

struct geometry {
    double reach;     /* from the camera to the sphere or the wall */
    double centre[3]; /* c */
    double radius;    /* r */
    struct card card;
};

static struct card card_of(const struct probe *probe)
{
    const double width = vector_length(probe->camera->right);
    const double height = vector_length(probe->camera->up);
    const double pixel[2] = {width / probe->width, height / probe->height};
    const double shorter = fmin(width, height);
    struct card card = {.x = (int32_t)(CARD_PLACE * probe->width),
                        .y = (int32_t)(CARD_PLACE * probe->height)};
    card.radius = fmax(CARD_RADIUS * shorter, CARD_LEAST_PX * fmin(pixel[0], pixel[1]));
    card.left_out = card.radius + CARD_MARGIN_PX * fmax(pixel[0], pixel[1]);
    return card;
}

/* Is the card at pixel (x, y), or so near that it may be? */
static bool is_card(const struct probe *probe, const struct card *card, int32_t x,
                    int32_t y)
{
    const double u = (double)(x - card->x) / probe->width;
    const double v = (double)(card->y - y) / probe->height;
    double offset[3];
    for (int i = 0; i < 3; i++)
        offset[i] = u * probe->camera->right[i] + v * probe->camera->up[i];
    return vector_length(offset) <= card->left_out;
}

/* Where the ray through (x, y) px is after `step`; gives its share of the way to the
 * plane at the distance of the camera's direction. */
static double walk_ray(const struct probe *probe, double x, double y, double step,
                       double point[3])
{
    double start[3], direction[3];
    camera_ray(probe->camera, x, y, probe->width, probe->height, start, direction);
    step /= vector_length(direction);
    for (int i = 0; i < 3; i++)
        point[i] = start[i] + step * direction[i];
    return step;
}

static struct geometry geometry_of(const struct probe *probe)
{
    const struct povray_camera *camera = probe->camera;
    struct geometry geometry = {
        .reach = 2.9e-4 * fmax(1, 0.01 * vector_length(camera->location)),
        .card = card_of(probe)};
    if (camera->is_orthographic)
        geometry.reach =
            1e-3 * fmax(vector_length(camera->right), vector_length(camera->up));
    geometry.reach *= probe->scale;
    walk_ray(probe, 0.5 * probe->width, 0.5 * probe->height, geometry.reach,
             geometry.centre);
    for (int k = 0; k < 4; k++) {
        double corner[3];
        walk_ray(probe, k & 1 ? probe->width : 0, k & 2 ? probe->height : 0,
                 geometry.reach, corner);
        for (int i = 0; i < 3; i++)
            corner[i] -= geometry.centre[i];
        geometry.radius = fmax(geometry.radius, vector_length(corner));
    }
    return geometry;
}

/* A disc along the camera's right and up. */
static void write_disc(struct text *out, const struct povray_camera *camera,
                       const double middle[3], double radius)
{
    const double *right = camera->right, *up = camera->up;
    double normal[3];
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        normal[i] = right[j] * up[k] - right[k] * up[j];
    }
    const double length = vector_length(normal);
    text_addf(out,
              "disc{<%.17g,%.17g,%.17g>,<%.17g,%.17g,%.17g>,%.17g no_shadow "
              "texture{RF_TEXTURE}}\n",
              middle[0], middle[1], middle[2], normal[0] / length, normal[1] / length,
              normal[2] / length, radius);
}

static void write_card(struct text *out, const struct probe *probe,
                       const struct geometry *geometry)
{
    const struct card *card = &geometry->card;
    double middle[3];
    const double share =
        walk_ray(probe, card->x + 0.5, card->y + 0.5, 0.5 * geometry->reach, middle);
    text_addf(
        out,
        "#declare RF_TEXTURE=texture{RF_CLEAN pigment{RF_PIGMENT rgb <%g,%g,%g>}}\n",
        card_colour[0], card_colour[1], card_colour[2]);
    write_disc(out, probe->camera, middle,
               card->radius * (probe->camera->is_orthographic ? 1 : share));
}

static void write_coordinates(struct text *out, const double centre[3], double radius)
{
    text_addf(
        out,
        "#declare RF_TEXTURE=texture{RF_CLEAN pigment{RF_PIGMENT average pigment_map{");
    for (int i = 0; i < 3; i++) {
        const char *colours[3] = {"<3,0,0>", "<0,3,0>", "<0,0,3>"};
        double low[3];
        for (int k = 0; k < 3; k++)
            low[k] = centre[k] - REACH / 2 * radius;
        text_addf(
            out,
            "[1 RF_PIGMENT gradient %c color_map{[0 rgb 0][1 rgb %s]} scale %.17g "
            "translate <%.17g,%.17g,%.17g>]",
            "xyz"[i], colours[i], REACH * radius, low[0], low[1], low[2]);
    }
    text_addf(out, "}}}\n");
}

/* The scene's #default would turn, scale and bump our textures as well. */
const char *const probe_head =
    " #declare RF_PIGMENT=pigment{rgb 1} #declare RF_CLEAN=texture{pigment{rgb 1} "
    "finish{ambient 1 diffuse 0 phong 0 specular 0 reflection 0 crand 0}} ";

void probe_write(struct text *out, const struct probe *probe)
{
    const struct geometry geometry = geometry_of(probe);
    const double *c = probe->camera->location;
    text_addf(out, "\n"
                   "global_settings{ambient_light 1}\n");
    write_coordinates(out, geometry.centre, geometry.radius);
    if (probe->camera->is_orthographic)
        write_disc(out, probe->camera, geometry.centre, 1.1 * geometry.radius);
    else
        text_addf(out,
                  "sphere{<%.17g,%.17g,%.17g>,%.17g hollow no_shadow "
                  "texture{RF_TEXTURE}}\n",
                  c[0], c[1], c[2], geometry.reach);
    write_card(out, probe, &geometry);
}

/* What the rays of one part of the picture missed by, on average. */
struct block {
    double error[3];
    double n;
};

static const float *pixel_at(const struct decode_picture *picture, int32_t x, int32_t y)
{
    return picture->rgba + ((size_t)y * (size_t)picture->width + (size_t)x) * 4;
}

/* Adds what pixel (x, y) shows to its block. */
static void measure_pixel(const struct probe *probe, const struct geometry *geometry,
                          const float *rgba, const struct decode_space *space,
                          int32_t x, int32_t y, struct block *block)
{
    double expected[3];
    walk_ray(probe, x + 0.5, y + 0.5, geometry->reach, expected);
    for (int i = 0; i < 3; i++) {
        double v = decode_value(space, (double)rgba[i]);
        block->error[i] +=
            (v - 0.5) * REACH * geometry->radius + geometry->centre[i] - expected[i];
    }
    block->n++;
}

static bool find_space(const struct decode_picture *picture, const struct card *card,
                       struct decode_space *space)
{
    const float *rgba = pixel_at(picture, card->x, card->y);
    const double seen[3] = {(double)rgba[0], (double)rgba[1], (double)rgba[2]};
    return decode_find_space(space, seen, card_colour);
}

/* Pixels of the picture's width in a unit, where the probe is. */
static double px_per_unit(const struct probe *probe, const struct geometry *geometry)
{
    const struct povray_camera *camera = probe->camera;
    const double px = probe->picture_width / vector_length(camera->right);
    return camera->is_orthographic
               ? px
               : px * vector_length(camera->direction) / geometry->reach;
}

/* The largest mean error of a block, in px of the picture's width. */
static double worst_error_px(const struct probe *probe, const struct geometry *geometry,
                             const struct decode_picture *picture,
                             const struct decode_space *space)
{
    struct block blocks[N_BLOCKS * N_BLOCKS] = {0};
    for (int32_t y = 0; y < probe->height; y++)
        for (int32_t x = 0; x < probe->width; x++)
            if (!is_card(probe, &geometry->card, x, y))
                measure_pixel(probe, geometry, pixel_at(picture, x, y), space, x, y,
                              &blocks[y * N_BLOCKS / probe->height * N_BLOCKS +
                                      x * N_BLOCKS / probe->width]);
    double worst = 0;
    for (int k = 0; k < N_BLOCKS * N_BLOCKS; k++)
        if (blocks[k].n > 0)
            worst = fmax(worst, vector_length(blocks[k].error) / blocks[k].n);
    return worst * px_per_unit(probe, geometry);
}

static double tolerance_px(const struct probe *probe)
{
    const struct povray_camera *camera = probe->camera;
    const double tall = vector_length(camera->up) / vector_length(camera->right);
    return TOLERANCE_PX + ROUNDING * probe->picture_width * fmax(1, tall);
}

bool probe_check(const struct probe *probe, const struct decode_picture *picture,
                 struct decode_space *space, struct povray_error *error)
{
    const struct geometry geometry = geometry_of(probe);
    const bool is_there = picture->width == probe->width &&
                          picture->height == probe->height &&
                          find_space(picture, &geometry.card, space);
    const double worst_px =
        is_there ? worst_error_px(probe, &geometry, picture, space) : INFINITY;
    if (worst_px <= tolerance_px(probe))
        return true;
    if (!is_there)
        snprintf(
            error->message, sizeof error->message,
            "the camera could not be recovered: the scene's camera is not where its "
            "items say; write the camera out in full in the scene");
    else
        snprintf(error->message, sizeof error->message,
                 "the camera could not be recovered: its rays are up to %.1f px off; "
                 "write the camera out in full in the scene",
                 worst_px);
    return false;
}
