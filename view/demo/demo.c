/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pictures stand upright, facing the camera when the scene is not turned, at
 * distances of equal steps in 1/z, so that the steps of blur between them are equal.
 * The scene turns about the middle one.
 */
#include "demo/demo.h"

#include <SDL.h>
#include <SDL_opengl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "demo/demo_picture.h"
#include "pixels/display.h"
#include "sources/picture.h"

/* Metres: distance of the middle, offset from the axis, height of the picture. */
static const struct place {
    double z, x, y;
} places[DEMO_N_PICTURES] = {{2.0, -0.2, -0.04}, {3.0, 0.02, 0.0}, {6.0, 0.62, 0.08}};
#define PICTURE_HEIGHT 0.42
#define FLOOR_Y (-0.26)
#define MIN_PITCH (-0.35)
#define MAX_PITCH 1.05

/* Of a quad's corner: place in the camera's frame, of the texture, colour. */
struct demo_vertex {
    float place[3], texture[2], colour[3];
};

enum {
    FLOOR_ROWS = 44,
    FLOOR_COLUMNS = 24,
    N_FLOOR = 4 * FLOOR_ROWS * FLOOR_COLUMNS,
    N_VERTICES = N_FLOOR + 4 * DEMO_N_PICTURES
};

/* ---- the picture ---------------------------------------------------------------- */

/* A file's picture, as sRGB. */
static uint8_t *read_picture(const char *path, int32_t *width, int32_t *height,
                             struct image_error *error)
{
    struct picture picture;
    if (!picture_read(path, NULL, thread_count(0), &picture, error))
        return NULL;
    struct tone *tone = tone_create();
    const size_t n = (size_t)picture.width * (size_t)picture.height;
    uint8_t *rgba = app_memory(n, 4, error);
    if (tone && rgba)
        display_picture(tone, picture.samples, 3, n, 0, rgba);
    tone_destroy(tone);
    *width = picture.width;
    *height = picture.height;
    picture_free(&picture);
    return rgba;
}

static void make_texture(struct demo *demo, const uint8_t *rgba, int32_t width,
                         int32_t height)
{
    glGenTextures(1, &demo->texture);
    glBindTexture(GL_TEXTURE_2D, demo->texture);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexParameteri(GL_TEXTURE_2D, GL_GENERATE_MIPMAP, GL_TRUE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, rgba);
    demo->picture_aspect = (double)width / height;
}

static bool check_size(const char *path, int32_t width, int32_t height,
                       struct image_error *error)
{
    GLint most = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (width <= most && height <= most)
        return true;
    set_error(error,
              "%s: is %d x %d px, and this OpenGL takes %d px a side; give a smaller "
              "picture",
              path, width, height, most);
    return false;
}

bool demo_open(struct demo *demo, int32_t width, int32_t height, const char *path,
               struct image_error *error)
{
    int32_t w = DEMO_PICTURE_SIDE, h = DEMO_PICTURE_SIDE;
    *demo = (struct demo){.width = width,
                          .height = height > 0 ? height : (width * 9 + 8) / 16};
    demo->vertices = app_memory(N_VERTICES, sizeof(*demo->vertices), error);
    if (!demo->vertices)
        return false;
    uint8_t *rgba;
    if (path) {
        rgba = read_picture(path, &w, &h, error);
        if (!rgba || !check_size(path, w, h, error)) {
            free(rgba);
            return false;
        }
    } else {
        rgba = app_memory((size_t)w * (size_t)h, 4, error);
        if (!rgba)
            return false;
        demo_picture_paint(rgba);
    }
    make_texture(demo, rgba, w, h);
    free(rgba);
    if (gl_target_make(&demo->targets[0], demo->width, demo->height) &&
        gl_target_make(&demo->targets[1], demo->width, demo->height))
        return true;
    set_error(error,
              "view: this OpenGL makes no frame buffer of %d x %d px; give a smaller "
              "--demo-width",
              demo->width, demo->height);
    demo_close(demo);
    return false;
}

void demo_close(struct demo *demo)
{
    if (demo->texture)
        glDeleteTextures(1, &demo->texture);
    gl_target_free(&demo->targets[0]);
    gl_target_free(&demo->targets[1]);
    free(demo->vertices);
    *demo = (struct demo){0};
}

/* ---- the scene ------------------------------------------------------------------ */

void demo_turn(struct demo *demo, double dx, double dy)
{
    demo->yaw = remainder(demo->yaw + 0.005 * dx, 2 * acos(-1));
    demo->pitch = fmin(fmax(demo->pitch + 0.005 * dy, MIN_PITCH), MAX_PITCH);
}

/* A point of the scene in the camera's frame: x right, y up, z the distance. */
static void to_camera(const struct demo *demo, const double p[3], double out[3])
{
    const double middle = places[1].z;
    const double x = p[0], y = p[1], z = p[2] - middle;
    const double turned = z * cos(demo->yaw) - x * sin(demo->yaw);
    out[0] = x * cos(demo->yaw) + z * sin(demo->yaw);
    out[1] = y * cos(demo->pitch) + turned * sin(demo->pitch);
    out[2] = turned * cos(demo->pitch) - y * sin(demo->pitch) + middle;
}

double demo_distance(const struct demo *demo, int i)
{
    double distances[DEMO_N_PICTURES], point[3];
    for (int k = 0; k < DEMO_N_PICTURES; k++) {
        const double middle[3] = {places[k].x, places[k].y, places[k].z};
        to_camera(demo, middle, point);
        int at = k;
        for (; at > 0 && distances[at - 1] > point[2]; at--)
            distances[at] = distances[at - 1];
        distances[at] = point[2];
    }
    return distances[i];
}

static struct demo_vertex corner(const struct demo *demo, double x, double y, double z)
{
    double p[3];
    to_camera(demo, (const double[3]){x, y, z}, p);
    return (struct demo_vertex){.place = {(float)p[0], (float)p[1], (float)-p[2]}};
}

static void lay_picture(const struct demo *demo, const struct place *place,
                        struct demo_vertex *to)
{
    static const float sides[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const double h = PICTURE_HEIGHT / 2, w = h * demo->picture_aspect;
    for (int i = 0; i < 4; i++) {
        to[i] = corner(demo, place->x + w * (2 * sides[i][0] - 1),
                       place->y + h * (1 - 2 * sides[i][1]), place->z);
        memcpy(to[i].texture, sides[i], sizeof(sides[i]));
    }
}

/* A chequered floor that runs through all distances. */
static void lay_floor(const struct demo *demo, struct demo_vertex *to)
{
    static const int sides[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const double step = 0.25;
    for (int j = 0; j < FLOOR_ROWS; j++)
        for (int i = 0; i < FLOOR_COLUMNS; i++)
            for (int k = 0; k < 4; k++, to++) {
                const int x = i - FLOOR_COLUMNS / 2;
                const float grey = (x + j) % 2 ? 0.62f : 0.36f;
                const float colour[3] = {grey, grey * 0.97f, grey * 0.9f};
                *to = corner(demo, (x + sides[k][0]) * step, FLOOR_Y,
                             1 + (j + sides[k][1]) * step);
                memcpy(to->colour, colour, sizeof(colour));
            }
}

void demo_lay(struct demo *demo)
{
    lay_floor(demo, demo->vertices);
    for (int i = 0; i < DEMO_N_PICTURES; i++)
        lay_picture(demo, &places[i], demo->vertices + N_FLOOR + 4 * i);
}

static void draw_scene(const struct demo *demo)
{
    const struct demo_vertex *first = demo->vertices;
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glClearColor(0.18f, 0.22f, 0.30f, 1);
    glClearDepth(1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnableClientState(GL_VERTEX_ARRAY);
    glVertexPointer(3, GL_FLOAT, sizeof(*first), first->place);
    glDisable(GL_TEXTURE_2D);
    glEnableClientState(GL_COLOR_ARRAY);
    glColorPointer(3, GL_FLOAT, sizeof(*first), first->colour);
    /* Seen from above only: it must not hide the pictures from below. */
    glEnable(GL_CULL_FACE);
    glFrontFace(GL_CCW);
    glDrawArrays(GL_QUADS, 0, N_FLOOR);
    glDisable(GL_CULL_FACE);
    glDisableClientState(GL_COLOR_ARRAY);
    glColor3f(1, 1, 1);
    glEnable(GL_TEXTURE_2D);
    glBindTexture(GL_TEXTURE_2D, demo->texture);
    glTexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_REPLACE);
    glEnableClientState(GL_TEXTURE_COORD_ARRAY);
    glTexCoordPointer(2, GL_FLOAT, sizeof(*first), first->texture);
    glDrawArrays(GL_QUADS, N_FLOOR, N_VERTICES - N_FLOOR);
    glDisableClientState(GL_TEXTURE_COORD_ARRAY);
    glDisableClientState(GL_VERTEX_ARRAY);
    glDisable(GL_DEPTH_TEST);
}

double demo_focal_px(const struct demo *demo)
{
    return demo->width * DEMO_FOCAL_LENGTH_MM / DEMO_SENSOR_MM;
}

/* What gluLookAt makes: from the eye to (0, 0, -focus), up is up. */
static void look_at_middle(const struct demo_eye *eye)
{
    const double length =
        sqrt(eye->x * eye->x + eye->y * eye->y + eye->focus * eye->focus);
    const double back[3] = {eye->x / length, eye->y / length, eye->focus / length};
    const double across = hypot(back[2], back[0]);
    const double right[3] = {back[2] / across, 0, -back[0] / across};
    const double up[3] = {back[1] * right[2], back[2] * right[0] - back[0] * right[2],
                          -back[1] * right[0]};
    const double turn[16] = {right[0], up[0], back[0], 0, right[1], up[1], back[1], 0,
                             right[2], up[2], back[2], 0, 0,        0,     0,       1};
    glLoadMatrixd(turn);
}

/*
 * Image plane of the focal length and the sensor, so that the lens fits the camera. From
 * another point of the lens the frustum is sheared by -x n / F, which keeps the plane at
 * the distance F where it is, or the camera is turned.
 */
static void set_camera(const struct demo *demo, const struct demo_eye *eye)
{
    const double right = DEMO_NEAR * DEMO_SENSOR_MM / 2 / DEMO_FOCAL_LENGTH_MM;
    const double top = right * demo->height / demo->width;
    const bool is_sheared = eye->move == DEMO_SHIFT;
    const double x = is_sheared ? eye->x * DEMO_NEAR / eye->focus : 0;
    const double y = is_sheared ? eye->y * DEMO_NEAR / eye->focus : 0;
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glFrustum(-right - x, right - x, -top - y, top - y, DEMO_NEAR, DEMO_FAR);
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    if (!is_sheared)
        look_at_middle(eye);
    glTranslated(-eye->x, -eye->y, 0);
}

static struct input *draw_eye(const struct demo *demo, const struct demo_eye *eye)
{
    struct input *input = input_create(demo->width, demo->height, 3, 1);
    const size_t n = (size_t)demo->width * (size_t)demo->height;
    if (!input)
        return NULL;
    input->frame_rgba = app_memory(n, 4, NULL);
    input->frame_depth = app_memory(n, sizeof(float), NULL);
    if (!input->frame_rgba || !input->frame_depth) {
        input_drop(input);
        return NULL;
    }
    gl_target_begin(&demo->targets[0]);
    set_camera(demo, eye);
    draw_scene(demo);
    gl_target_read(&demo->targets[0], input->frame_rgba, input->frame_depth);
    return input;
}

struct input *demo_draw(struct demo *demo)
{
    /* The axes are parallel and the frusta sheared: nothing is moved up or down. */
    const double half = demo->is_stereo ? DEMO_EYES / 2 : 0;
    const double screen = places[1].z;
    demo_lay(demo);
    struct input *input =
        draw_eye(demo, &(struct demo_eye){-half, 0, screen, DEMO_SHIFT});
    if (!input || !demo->is_stereo)
        return input;
    input->others[0] = draw_eye(demo, &(struct demo_eye){half, 0, screen, DEMO_SHIFT});
    input->n_others = input->others[0] != NULL;
    if (input->n_others == 0) {
        input_drop(input);
        return NULL;
    }
    return input;
}

void demo_begin_view(const struct demo *demo, const struct demo_eye *eye, int buffer)
{
    gl_target_begin(&demo->targets[buffer]);
    set_camera(demo, eye);
    draw_scene(demo);
    glFlush();
}

void demo_read_view(const struct demo *demo, int buffer, uint8_t *rgba)
{
    gl_target_read(&demo->targets[buffer], rgba, NULL);
}

/* ---- facts and files ------------------------------------------------------------ */

static const struct {
    const char *key;
    double value;
} facts[] = {{"focus-distance", 3},
             {"f-stop", 1.4},
             {"focal-length", DEMO_FOCAL_LENGTH_MM},
             {"sensor-width", DEMO_SENSOR_MM},
             {"sensor-fit", RF_SENSOR_FIT_HORIZONTAL},
             {"optics", RF_OPTICS_YU},
             {"depth", RF_DEPTH_BUFFER},
             {"depth-near", DEMO_NEAR},
             {"depth-far", DEMO_FAR},
             {"method", RF_METHOD_SCATTER}};
enum { N_FACTS = sizeof(facts) / sizeof(facts[0]) };

void demo_facts(struct settings *settings)
{
    for (int i = 0; i < N_FACTS; i++)
        settings_set_header(settings, facts[i].key, facts[i].value, "(demo)", NULL);
}

static int list_attributes(struct image_attribute *list)
{
    int n = 0;
    for (int i = 0; i < N_FACTS; i++) {
        const struct rf_param_info *info = rf_param_find(facts[i].key);
        list[n++] =
            info->choices
                ? (struct image_attribute){.name = info->attribute,
                                           .type = IMAGE_ATTRIBUTE_STRING,
                                           .text =
                                               info->choices[(int)facts[i].value].name}
                : (struct image_attribute){.name = info->attribute,
                                           .type = IMAGE_ATTRIBUTE_FLOAT,
                                           .number = {facts[i].value, 0}};
    }
    return n;
}

bool demo_save_passes(const char *path, const struct input *input, int n_threads,
                      struct image_error *error)
{
    static const char *const names[] = {"R", "G", "B", "Z"};
    static const enum image_sample_type types[] = {
        IMAGE_SAMPLE_FLOAT, IMAGE_SAMPLE_FLOAT, IMAGE_SAMPLE_FLOAT, IMAGE_SAMPLE_FLOAT};
    const size_t n = (size_t)input->width * (size_t)input->height;
    const float *colour = input->views[0].colour.data;
    const float *depth = input->views[0].depth.data;
    float *samples = app_memory(n, 4 * sizeof(float), error);
    for (size_t i = 0; samples && i < n; i++) {
        memcpy(samples + 4 * i, colour + 3 * i, 3 * sizeof(float));
        samples[4 * i + 3] = depth[i];
    }
    struct image_attribute attributes[N_FACTS];
    const struct image_output output = {.width = input->width,
                                        .height = input->height,
                                        .n_channels = 4,
                                        .channel_names = names,
                                        .types = types,
                                        .samples = samples,
                                        .attributes = attributes,
                                        .n_attributes = list_attributes(attributes)};
    const bool is_written = samples && image_write(path, &output, n_threads, error);
    free(samples);
    return is_written;
}

/* Three channels with what made them. */
static bool write_rgb(const char *path, const float *pixels, int32_t width,
                      int32_t height, const char *made, int n_threads,
                      struct image_error *error)
{
    static const char *const names[] = {"R", "G", "B"};
    static const enum image_sample_type types[] = {
        IMAGE_SAMPLE_FLOAT, IMAGE_SAMPLE_FLOAT, IMAGE_SAMPLE_FLOAT};
    const struct image_attribute filtered = {
        .name = "rackfocus:filtered", .type = IMAGE_ATTRIBUTE_STRING, .text = made};
    const struct image_output output = {.width = width,
                                        .height = height,
                                        .n_channels = 3,
                                        .channel_names = names,
                                        .types = types,
                                        .samples = pixels,
                                        .attributes = &filtered,
                                        .n_attributes = 1};
    return image_write(path, &output, n_threads, error);
}

bool demo_save(const char *path, const float *pixels, int32_t width, int32_t height,
               const struct settings *settings, int n_threads,
               struct image_error *error)
{
    if (picture_kind(path) == PICTURE_PNG)
        return image_write_png(path, pixels, width, height, 3, 8, false, error);
    char used[4000], text[4096];
    settings_print_options(&settings->params, used, sizeof(used));
    snprintf(text, sizeof(text), "rackfocus %s %s", rf_version(), used);
    return write_rgb(path, pixels, width, height, text, n_threads, error);
}

bool demo_save_views(const char *path, const struct picture *mean, int n,
                     enum demo_move move, int n_threads, struct image_error *error)
{
    char text[128];
    snprintf(text, sizeof(text), "rackfocus %s view --demo, %d views, %s", rf_version(),
             n, move == DEMO_SHIFT ? "shift" : "look-at");
    return write_rgb(path, mean->samples, mean->width, mean->height, text, n_threads,
                     error);
}
