/* SPDX-License-Identifier: Apache-2.0 */
#include "povray/povray_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "parallel.h"
#include "rackfocus/rackfocus.h"
#include "sources/picture.h"
#include "sources/views.h"

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static struct image_attribute number_attribute(const char *key, double number)
{
    return (struct image_attribute){.name = rf_param_find(key)->attribute,
                                    .type = IMAGE_ATTRIBUTE_FLOAT,
                                    .number = {number, 0}};
}

static struct image_attribute text_attribute(const char *key, const char *text)
{
    return (struct image_attribute){.name = rf_param_find(key)->attribute,
                                    .type = IMAGE_ATTRIBUTE_STRING,
                                    .text = text};
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/*
 * The camera's place as worldToCamera, by rows: x to the right, y up, z along the axis.
 * False where its axes are not at right angles, which no matrix of turns says.
 */
static bool find_matrix(const struct povray_camera *camera, double matrix[16])
{
    const double *const axes[3] = {camera->right, camera->up, camera->direction};
    for (int k = 0; k < 3; k++) {
        const double *axis = axes[k], *next = axes[(k + 1) % 3];
        if (!(length(axis) > 0) ||
            fabs(dot(axis, next)) > 1e-6 * length(axis) * length(next))
            return false;
        for (int row = 0; row < 3; row++)
            matrix[4 * row + k] = axis[row] / length(axis);
        matrix[12 + k] = -dot(camera->location, axis) / length(axis);
        matrix[4 * k + 3] = 0;
    }
    matrix[15] = 1;
    return true;
}

double povray_file_focal_px(const struct povray_passes *passes)
{
    return passes->supersample * povray_picture_width(passes) *
           length(passes->camera.direction) / length(passes->camera.right);
}

enum { MAX_FACTS = 14 };

/* The facts of the camera for the header; returns their number. `matrix` is for one of
 * them. */
static int list_facts(const struct povray_passes *passes, enum povray_file kind,
                      const char *made, double matrix[16], struct image_attribute *list)
{
    const struct povray_camera *camera = &passes->camera;
    int n = 0;
    list[n++] = number_attribute("focus-distance", camera->focus_distance);
    list[n++] = number_attribute("lens-radius", camera->aperture / 4);
    if (camera->f_stop > 0)
        list[n++] = number_attribute("f-stop", camera->f_stop);
    list[n++] = number_attribute("blend-gamma", passes->gamma);
    list[n++] = text_attribute("depth", "planar");
    list[n++] = text_attribute("projection", camera->is_orthographic ? "orthographic"
                                                                     : "perspective");
    if (camera->is_orthographic) {
        list[n++] = text_attribute("sensor-fit", "horizontal");
        list[n++] = number_attribute("ortho-scale", length(camera->right));
    } else {
        list[n++] = number_attribute("focal-length-px", povray_file_focal_px(passes));
    }
    if (find_matrix(camera, matrix))
        list[n++] = (struct image_attribute){
            .name = "worldToCamera", .type = IMAGE_ATTRIBUTE_M44F, .matrix = matrix};
    if (kind == POVRAY_FILE_VIEW || kind == POVRAY_FILE_COLOUR)
        list[n++] = (struct image_attribute){
            .name = VIEWS_OFFSET,
            .type = IMAGE_ATTRIBUTE_V2F,
            .number = {passes->lens_offset[0], passes->lens_offset[1]}};
    if (kind == POVRAY_FILE_VIEW)
        list[n++] = (struct image_attribute){.name = VIEWS_SHEAR,
                                             .type = IMAGE_ATTRIBUTE_FLOAT,
                                             .number = {camera->focus_distance, 0}};
    if (made)
        list[n++] = (struct image_attribute){
            .name = "rackfocus:filtered", .type = IMAGE_ATTRIBUTE_STRING, .text = made};
    return n;
}

/* The samples as they go into the file, interleaved: R G B, A where there is one, Z. */
static float *pack(const struct povray_passes *passes, bool has_depth,
                   struct image_error *error)
{
    const size_t n_pixels = (size_t)passes->width * (size_t)passes->height;
    const size_t n_colours = passes->has_alpha ? 4 : 3, n = n_colours + has_depth;
    float *samples = app_memory(n_pixels * n, sizeof(float), error);
    for (size_t i = 0; samples && i < n_pixels; i++) {
        memcpy(samples + n * i, passes->colour + 4 * i, n_colours * sizeof(float));
        if (has_depth)
            samples[n * i + n_colours] = passes->depth[i];
    }
    return samples;
}

/* The picture begins at 0, 0; the passes' border lies around it. */
static struct image_box data_window(const struct povray_passes *passes)
{
    const int32_t border = passes->supersample * passes->border_px;
    return (struct image_box){-border, -border, passes->width - border - 1,
                              passes->height - border - 1};
}

static struct image_box display_window(const struct povray_passes *passes)
{
    return (struct image_box){0, 0,
                              passes->supersample * povray_picture_width(passes) - 1,
                              passes->supersample * povray_picture_height(passes) - 1};
}

bool povray_file_write(const char *path, const struct povray_passes *passes,
                       enum povray_file kind, const char *made, int n_threads,
                       struct image_error *error)
{
    static const char *const names[] = {"R", "G", "B", "A", "Z"};
    static const char *const opaque_names[] = {"R", "G", "B", "Z"};
    const bool has_depth = kind == POVRAY_FILE_PASSES || kind == POVRAY_FILE_VIEW;
    const int n_colours = passes->has_alpha ? 4 : 3;
    enum image_sample_type types[5];
    /* Half is what POV-Ray gave. */
    for (int c = 0; c < 5; c++)
        types[c] = c < n_colours && kind != POVRAY_FILE_RESULT ? IMAGE_SAMPLE_HALF
                                                               : IMAGE_SAMPLE_FLOAT;
    struct image_attribute facts[MAX_FACTS];
    double matrix[16];
    const double pixel_width =
        length(passes->camera.right) / povray_picture_width(passes);
    const double pixel_height =
        length(passes->camera.up) / povray_picture_height(passes);
    float *samples = pack(passes, has_depth, error);
    const struct image_output output = {
        .width = passes->width,
        .height = passes->height,
        .data_window = data_window(passes),
        .display_window = display_window(passes),
        .pixel_aspect = (float)(pixel_width / pixel_height),
        .n_channels = n_colours + has_depth,
        .channel_names = passes->has_alpha ? names : opaque_names,
        .types = types,
        .samples = samples,
        .attributes = facts,
        .n_attributes = list_facts(passes, kind, made, matrix, facts)};
    const bool is_written = samples && image_write(path, &output, n_threads, error);
    free(samples);
    return is_written;
}

/* ---- the picture of larger passes --------------------------------------------------
 */

/* A picture as RGBA; the caller frees. */
static float *read_rgba(const char *path, const struct povray_passes *passes,
                        int n_threads, struct image_error *error)
{
    struct image_input *input = NULL;
    struct image_layer layer;
    float *rgba = app_memory((size_t)passes->width * (size_t)passes->height * 4,
                             sizeof(*rgba), error);
    const bool is_read =
        rgba && image_open(&input, path, error) &&
        image_find_layer(input, NULL, NULL, false, &layer, error) &&
        image_read(input, (const int[]){layer.r, layer.g, layer.b, layer.a}, 4, rgba,
                   n_threads, error);
    if (input)
        image_close(input);
    if (is_read)
        return rgba;
    free(rgba);
    return NULL;
}

/* The mean of n x n samples, taken of values^(1 / gamma), as POV-Ray's anti-aliasing
 * does. */
static void reduce_pixel(const float *from, size_t stride, int n, double gamma,
                         float *to)
{
    double sums[4] = {0};
    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++)
            for (int c = 0; c < 4; c++) {
                const double v = (double)from[((size_t)y * stride + (size_t)x) * 4 + c];
                sums[c] += c == 3 || gamma == 1 || v <= 0 ? v : pow(v, 1 / gamma);
            }
    for (int c = 0; c < 4; c++) {
        const double mean = sums[c] / (n * n);
        to[c] = (float)(c == 3 || gamma == 1 || mean <= 0 ? mean : pow(mean, gamma));
    }
}

/* What the threads share that reduce a picture. */
struct reducing {
    const float *rgba;
    const struct povray_passes *passes;
    double gamma;
    int32_t width; /* of `small` */
    float *small;
};

static void reduce_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct reducing *r = data;
    const int n = r->passes->supersample;
    const size_t border = (size_t)(n * r->passes->border_px);
    const size_t stride = (size_t)r->passes->width;
    for (int64_t y = begin; y < end; y++)
        for (int32_t x = 0; x < r->width; x++) {
            const float *from =
                r->rgba +
                ((border + (size_t)(y * n)) * stride + border + (size_t)(x * n)) * 4;
            float *to = r->small + ((size_t)y * (size_t)r->width + (size_t)x) * 4;
            if (n == 1)
                memcpy(to, from, 4 * sizeof(*to));
            else
                reduce_pixel(from, stride, n, r->gamma, to);
        }
}

static float *reduce(const float *rgba, const struct povray_passes *passes,
                     double gamma, struct image_error *error)
{
    const int32_t width = povray_picture_width(passes);
    const int32_t height = povray_picture_height(passes);
    float *small =
        app_memory((size_t)width * (size_t)height * 4, sizeof(*small), error);
    if (!small)
        return NULL;
    struct reducing r = {rgba, passes, gamma, width, small};
    os_parallel(0, height, 0, reduce_rows, &r);
    return small;
}

bool povray_file_is_whole(const struct povray_passes *passes)
{
    return passes->supersample == 1 && passes->border_px == 0;
}

bool povray_file_reduce(const char *from, const char *to,
                        const struct povray_passes *passes, double gamma,
                        const char *made, int n_threads, struct image_error *error)
{
    float *rgba = read_rgba(from, passes, n_threads, error);
    if (!rgba)
        return false;
    struct povray_passes small = *passes;
    small.width = povray_picture_width(passes);
    small.height = povray_picture_height(passes);
    small.supersample = 1;
    small.border_px = 0;
    small.colour = reduce(rgba, passes, gamma, error);
    free(rgba);
    if (!small.colour)
        return false;
    const bool is_exr = picture_kind(to) == PICTURE_EXR;
    bool is_written;
    if (is_exr) {
        is_written =
            povray_file_write(to, &small, POVRAY_FILE_FILTERED, made, n_threads, error);
    } else {
        float *samples = pack(&small, false, error);
        is_written =
            samples && image_write_png(to, samples, small.width, small.height,
                                       small.has_alpha ? 4 : 3, 8, false, error);
        free(samples);
    }
    free(small.colour);
    return is_written;
}

bool povray_files_views(struct povray_scene *scene, int n_views, povray_view_fn receive,
                        void *user, double *total_s, struct povray_error *error)
{
    struct rf_lens_point points[RF_MAX_VIEWS];
    double places[RF_MAX_VIEWS][2];
    struct rf_params disc;
    struct rf_error rf_error;
    rf_params_init(&disc);
    *total_s = 0;
    if (rf_lens_points(&disc, n_views, 0, points, &rf_error) != RF_OK) {
        snprintf(error->message, sizeof(error->message), "%s", rf_error.message);
        return false;
    }
    for (int i = 0; i < n_views; i++) {
        places[i][0] = points[i].u;
        places[i][1] = points[i].v;
    }
    return povray_render_views(scene, (const double(*)[2])places, n_views, receive,
                               user, total_s, error);
}
