/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sphere shows at its point p the colour
 *
 *     v = 1/2 + (p - c) / (2.2 r),
 *
 *     c  where the middle of the picture meets it    r  from there to its corners
 *
 * in the space in which POV-Ray computes, which a little card of known colour in the
 * top left corner tells. Orthographic cameras see a wall just before them, coloured in
 * the same way.
 */
#include "probe.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"

#define REACH 2.2
#define CARD 0.1     /* where the card is, of the picture's sides */
#define SKIPPED 0.25 /* left out around it */
#define N_BLOCKS 6
#define TOLERANCE_PX 0.25

static const double card_colour[3] = {0.5, 0.1, 0.03};

struct geometry {
    double reach;     /* from the camera to the sphere or the wall */
    double centre[3]; /* c */
    double radius;    /* r */
};

/* Where the ray through (x, y) px is after `step`. */
static void walk_ray(const struct povray_camera *camera, double x, double y,
                     int32_t width, int32_t height, double step, double point[3])
{
    double start[3], direction[3];
    camera_ray(camera, x, y, width, height, start, direction);
    step /= vector_length(direction);
    for (int i = 0; i < 3; i++)
        point[i] = start[i] + step * direction[i];
}

static struct geometry geometry_of(const struct povray_camera *camera, double scale,
                                   int32_t width, int32_t height)
{
    struct geometry geometry = {
        .reach = 2.9e-4 * fmax(1, 0.01 * vector_length(camera->location))};
    if (camera->is_orthographic)
        geometry.reach =
            1e-3 * fmax(vector_length(camera->right), vector_length(camera->up));
    geometry.reach *= scale;
    walk_ray(camera, 0.5 * width, 0.5 * height, width, height, geometry.reach,
             geometry.centre);
    for (int k = 0; k < 4; k++) {
        double corner[3];
        walk_ray(camera, k & 1 ? width : 0, k & 2 ? height : 0, width, height,
                 geometry.reach, corner);
        for (int i = 0; i < 3; i++)
            corner[i] -= geometry.centre[i];
        geometry.radius = fmax(geometry.radius, vector_length(corner));
    }
    return geometry;
}

/* A disc across the ray through (x, y) px, after `reach`. */
static void write_disc(struct text *out, const struct povray_camera *camera, double x,
                       double y, int32_t width, int32_t height, double reach,
                       double radius)
{
    double c[3];
    const double *n = camera->direction;
    walk_ray(camera, x, y, width, height, reach, c);
    text_addf(out,
              "disc{<%.17g,%.17g,%.17g>,<%.17g,%.17g,%.17g>,%.17g no_shadow "
              "texture{RF_TEXTURE}}\n",
              c[0], c[1], c[2], n[0], n[1], n[2], radius);
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

void probe_write(struct text *out, const struct povray_camera *camera, double scale,
                 int32_t width, int32_t height)
{
    const struct geometry geometry = geometry_of(camera, scale, width, height);
    const double *c = camera->location;
    text_addf(out, "\n"
                   "global_settings{ambient_light 1}\n");
    write_coordinates(out, geometry.centre, geometry.radius);
    if (camera->is_orthographic)
        write_disc(out, camera, 0.5 * width, 0.5 * height, width, height,
                   geometry.reach, 1.1 * geometry.radius);
    else
        text_addf(out,
                  "sphere{<%.17g,%.17g,%.17g>,%.17g hollow no_shadow "
                  "texture{RF_TEXTURE}}\n",
                  c[0], c[1], c[2], geometry.reach);
    text_addf(
        out,
        "#declare RF_TEXTURE=texture{RF_CLEAN pigment{RF_PIGMENT rgb <%g,%g,%g>}}\n",
        card_colour[0], card_colour[1], card_colour[2]);
    write_disc(out, camera, CARD * width, CARD * height, width, height,
               0.5 * geometry.reach, 0.5 * CARD * geometry.radius);
}

/* What the rays of one part of the picture missed by, on average. */
struct block {
    double error[3];
    double n;
};

/* Adds what pixel (x, y) shows to its block. */
static void measure_pixel(const struct decode_picture *picture,
                          const struct povray_camera *camera,
                          const struct geometry *geometry,
                          const struct decode_space *space, int32_t x, int32_t y,
                          struct block *block)
{
    const float *rgba =
        picture->rgba + ((size_t)y * (size_t)picture->width + (size_t)x) * 4;
    double expected[3];
    walk_ray(camera, x + 0.5, y + 0.5, picture->width, picture->height, geometry->reach,
             expected);
    for (int i = 0; i < 3; i++) {
        double v = decode_value(space, (double)rgba[i]);
        block->error[i] +=
            (v - 0.5) * REACH * geometry->radius + geometry->centre[i] - expected[i];
    }
    block->n++;
}

static bool find_space(const struct decode_picture *picture, struct decode_space *space)
{
    int32_t x = (int32_t)(CARD * picture->width);
    int32_t y = (int32_t)(CARD * picture->height);
    const float *rgba =
        picture->rgba + ((size_t)y * (size_t)picture->width + (size_t)x) * 4;
    const double seen[3] = {(double)rgba[0], (double)rgba[1], (double)rgba[2]};
    return decode_find_space(space, seen, card_colour);
}

/* The largest error of a block, in px of the picture's width. */
static double worst_error_px(const struct block *blocks,
                             const struct povray_camera *camera,
                             const struct geometry *geometry, int32_t width)
{
    double unit_px = width / vector_length(camera->right);
    if (!camera->is_orthographic)
        unit_px *= vector_length(camera->direction) / geometry->reach;
    double worst = 0;
    for (int k = 0; k < N_BLOCKS * N_BLOCKS; k++)
        if (blocks[k].n > 0)
            worst = fmax(worst, vector_length(blocks[k].error) / blocks[k].n * unit_px);
    return worst;
}

bool probe_check(const struct decode_picture *picture, int32_t n_rows,
                 const struct povray_camera *camera, double scale,
                 struct decode_space *space, struct povray_error *error)
{
    struct block blocks[N_BLOCKS * N_BLOCKS] = {0};
    int32_t width = picture->width, height = picture->height;
    const struct geometry geometry = geometry_of(camera, scale, width, height);
    double worst_px = INFINITY;
    if (find_space(picture, space)) {
        for (int32_t y = 0; y < n_rows && y < height; y++)
            for (int32_t x = 0; x < width; x++)
                if (x > SKIPPED * width || y > SKIPPED * height)
                    measure_pixel(picture, camera, &geometry, space, x, y,
                                  &blocks[y * N_BLOCKS / height * N_BLOCKS +
                                          x * N_BLOCKS / width]);
        worst_px = worst_error_px(blocks, camera, &geometry, width);
    }
    /* What rounding to half floats may leave in a block, of the picture's width. */
    if (worst_px <= TOLERANCE_PX + 2e-4 * width)
        return true;
    if (isinf(worst_px))
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
