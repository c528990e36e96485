/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How POV-Ray 3.7 makes a camera of its items (all found by rendering; `#version` is
 * the one in force at the camera).
 *
 * From 3.5 on the order of the items does not matter, but for transformations:
 *   1. angle a:  |direction| = |right| / (2 tan(a / 2))
 *   2. look_at:  direction, right and up turn, lengths and handedness are kept
 *   3. orthographic, angle (0, too) or neither right nor up given: right and up are
 *      scaled by |look_at - location| / |direction|, where look_at is z by default
 *   4. focus distance = |focal_point - location|; without focal_point the length that
 *      angle or look_at left direction with, 1 where neither is given
 *   5. transformations, in their order; they do not change 4
 * Before 3.5 every item takes effect where it stands; the word orthographic scales as
 * in 3 with what is known by then.
 */
#include "camera.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_TRANSFORMS 64
#define MAX_NAME 128

struct matrix {
    double images[4][3]; /* of 0, x, y and z */
};

struct state {
    struct povray_camera camera;
    double sky[3], look_at[3], focal_point[3];
    double aim[3]; /* look_at, with the transformations so far */
    double angle;
    bool has_angle, has_look_at, has_right, has_up, has_focal_point, is_copy;
    /* POV-Ray's variable of this name: what angle or look_at left direction with. */
    double direction_length;
    double version;
    struct matrix transforms[MAX_TRANSFORMS];
    int n_transforms;
    char unsupported[MAX_NAME]; /* the feature, or "" */
    char name[MAX_NAME];        /* "" where the camera is used, not declared */
};

struct replay {
    struct state *declared;
    int n_declared;
    struct state current, used;
    int guess;
};

static const double axis_x[3] = {1, 0, 0}, axis_y[3] = {0, 1, 0}, axis_z[3] = {0, 0, 1};

/* ---- vectors ------------------------------------------------------------------- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double vector_length(const double v[3])
{
    return sqrt(dot(v, v));
}

static void cross(double out[3], const double a[3], const double b[3])
{
    double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                   a[0] * b[1] - a[1] * b[0]};
    memcpy(out, c, sizeof c);
}

static void scale(double v[3], double factor)
{
    for (int i = 0; i < 3; i++)
        v[i] *= factor;
}

static void set_length(double v[3], double wanted)
{
    double length = vector_length(v);
    if (length > 0)
        scale(v, wanted / length);
}

static double distance(const double a[3], const double b[3])
{
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return vector_length(d);
}

/* ---- items --------------------------------------------------------------------- */

static void state_init(struct state *state)
{
    *state = (struct state){.version = 3.7, .direction_length = 1};
    struct povray_camera *camera = &state->camera;
    camera->focus_distance = 1;
    memcpy(camera->direction, axis_z, sizeof axis_z);
    memcpy(camera->up, axis_y, sizeof axis_y);
    memcpy(camera->right, axis_x, sizeof axis_x);
    scale(camera->right, 1.33);
    memcpy(state->sky, axis_y, sizeof axis_y);
    memcpy(state->look_at, axis_z, sizeof axis_z);
}

static void apply_angle(struct state *state)
{
    struct povray_camera *camera = &state->camera;
    if (!(state->angle > 0 && state->angle < 180))
        return;
    state->direction_length =
        vector_length(camera->right) / (2 * tan(state->angle * M_PI / 360));
    set_length(camera->direction, state->direction_length);
}

static void apply_look_at(struct state *state)
{
    struct povray_camera *camera = &state->camera;
    double n_direction = vector_length(camera->direction);
    double n_right = vector_length(camera->right), n_up = vector_length(camera->up);
    state->direction_length = n_direction;
    double side[3], hand[3], old_right[3];
    cross(hand, camera->up, camera->direction);
    bool is_left = dot(hand, camera->right) <= 0; /* 0: up along direction */
    memcpy(old_right, camera->right, sizeof old_right);
    for (int i = 0; i < 3; i++)
        camera->direction[i] = state->look_at[i] - camera->location[i];
    set_length(camera->direction, 1);
    cross(side, state->sky, camera->direction);
    if (fabs(side[0]) < 1e-10 && fabs(side[1]) < 1e-10 && fabs(side[2]) < 1e-10)
        memcpy(side, old_right, sizeof side); /* straight up or down */
    set_length(side, 1);
    cross(camera->up, camera->direction, side);
    memcpy(camera->right, side, sizeof side);
    scale(camera->direction, n_direction);
    scale(camera->up, n_up);
    scale(camera->right, is_left ? -n_right : n_right);
}

static void apply_orthographic(struct state *state)
{
    struct povray_camera *camera = &state->camera;
    double factor = distance(state->look_at, camera->location) /
                    fmax(vector_length(camera->direction), 1e-300);
    scale(camera->right, factor);
    scale(camera->up, factor);
}

static void apply_transform(struct state *state, const struct matrix *matrix)
{
    const double(*m)[3] = matrix->images;
    struct povray_camera *camera = &state->camera;
    double *vectors[5] = {camera->location, state->aim, camera->direction,
                          camera->right, camera->up};
    for (int k = 0; k < 5; k++) {
        double v[3], shift = k < 2 ? 1 : 0;
        memcpy(v, vectors[k], sizeof v);
        for (int i = 0; i < 3; i++)
            vectors[k][i] = shift * m[0][i] + v[0] * (m[1][i] - m[0][i]) +
                            v[1] * (m[2][i] - m[0][i]) + v[2] * (m[3][i] - m[0][i]);
    }
}

static void apply_focus(struct state *state)
{
    if (state->has_focal_point)
        state->camera.focus_distance =
            distance(state->focal_point, state->camera.location);
}

/* What POV-Ray does at a camera's closing brace. */
static void settle_focus(struct state *state)
{
    struct povray_camera *camera = &state->camera;
    if (!state->has_focal_point && !state->is_copy)
        camera->focus_distance = state->direction_length;
    if (camera->focus_distance == 0)
        camera->focus_distance = 1;
    camera->has_focal_point |= state->has_focal_point;
    if (state->has_look_at)
        camera->look_at_distance = distance(state->aim, camera->location);
}

static void finish(struct state *state)
{
    if (state->version >= 3.5 && !state->is_copy) {
        memcpy(state->aim, state->look_at, sizeof state->aim);
        apply_angle(state);
        if (state->has_look_at)
            apply_look_at(state);
        if (state->camera.is_orthographic &&
            (state->has_angle || (!state->has_right && !state->has_up)))
            apply_orthographic(state);
        apply_focus(state);
    }
    for (int i = 0; i < state->n_transforms; i++)
        apply_transform(state, &state->transforms[i]);
    state->n_transforms = 0;
    settle_focus(state);
}

/* ---- records ------------------------------------------------------------------- */

struct record {
    char key[32];
    const char *value; /* within the stream, ends at ';' */
    int n;
};

/* Finds the next record at or after *at, which moves behind it. */
static bool next_record(const char **at, struct record *record)
{
    const char tag[] = "@rf~";
    const char *begin = *at ? strstr(*at, tag) : NULL;
    if (!begin)
        return false;
    begin += sizeof tag - 1;
    const char *tilde = strchr(begin, '~'), *end = strchr(begin, ';');
    if (!tilde || !end || tilde > end)
        return false;
    snprintf(record->key, sizeof record->key, "%.*s", (int)(tilde - begin), begin);
    record->value = tilde + 1;
    record->n = (int)(end - tilde - 1);
    *at = end + 1;
    return true;
}

/* The stream without what wrapping put in; NULL without memory. */
static char *without_blanks(const char *records)
{
    char *clean = glue_alloc(records ? strlen(records) + 1 : 1, 1), *out = clean;
    for (; clean && records && *records; records++)
        if (!isspace((unsigned char)*records))
            *out++ = *records;
    return clean;
}

static int read_numbers(const struct record *record, double *numbers, int n)
{
    const char *at = record->value;
    for (int i = 0; i < n; i++) {
        char *end;
        numbers[i] = strtod(at, &end);
        if (end == at || end > record->value + record->n)
            return i;
        at = *end == ',' ? end + 1 : end;
    }
    return n;
}

static void set_type(struct state *state, const char *type, int n)
{
    if (n == 11 && memcmp(type, "perspective", 11) == 0) {
        state->camera.is_orthographic = false;
    } else if (n == 12 && memcmp(type, "orthographic", 12) == 0) {
        state->camera.is_orthographic = true;
        if (state->version < 3.5)
            apply_orthographic(state);
    } else {
        snprintf(state->unsupported, sizeof state->unsupported, "%.*s", n, type);
    }
}

static void begin_camera(struct replay *replay, const struct record *record)
{
    state_init(&replay->current);
    double version;
    if (read_numbers(record, &version, 1) == 1)
        replay->current.version = version;
    const char *name = memchr(record->value, '~', (size_t)record->n);
    if (name)
        snprintf(replay->current.name, MAX_NAME, "%.*s",
                 (int)(record->value + record->n - name - 1), name + 1);
}

/* The declared camera that a record names, NULL where there is none. */
static const struct state *find_declared(const struct replay *replay,
                                         const struct record *record)
{
    if (replay->guess > 0 && !replay->current.name[0])
        return replay->guess <= replay->n_declared
                   ? &replay->declared[replay->n_declared - replay->guess]
                   : NULL;
    for (int i = replay->n_declared - 1; i >= 0; i--) {
        const char *name = replay->declared[i].name;
        if ((int)strlen(name) == record->n &&
            memcmp(name, record->value, strlen(name)) == 0)
            return &replay->declared[i];
    }
    return NULL;
}

static void copy_camera(struct replay *replay, const struct record *record)
{
    struct state *current = &replay->current;
    const struct state *original = find_declared(replay, record);
    struct state copy = original ? *original : *current;
    if (!original)
        snprintf(copy.unsupported, MAX_NAME, "=%.*s", record->n, record->value);
    memcpy(copy.name, current->name, MAX_NAME);
    copy.version = current->version;
    copy.is_copy = true;
    copy.has_focal_point = false;
    *current = copy;
}

static void end_camera(struct replay *replay)
{
    finish(&replay->current);
    if (replay->current.name[0]) {
        struct state *declared = glue_grow(
            replay->declared, (size_t)replay->n_declared + 1, sizeof *declared);
        if (declared) {
            replay->declared = declared;
            declared[replay->n_declared++] = replay->current;
        }
    } else {
        replay->used = replay->current;
    }
    state_init(&replay->current);
}

static void set_vector(struct state *state, const char *key, const double v[3])
{
    const struct {
        const char *key;
        double *vector;
        bool *flag;
    } items[] = {
        {"location", state->camera.location, NULL},
        {"direction", state->camera.direction, NULL},
        {"right", state->camera.right, &state->has_right},
        {"up", state->camera.up, &state->has_up},
        {"sky", state->sky, NULL},
        {"look_at", state->look_at, &state->has_look_at},
        {"focal_point", state->focal_point, &state->has_focal_point},
    };
    for (size_t i = 0; i < sizeof items / sizeof *items; i++) {
        if (strcmp(items[i].key, key) == 0) {
            memcpy(items[i].vector, v, 3 * sizeof *v);
            if (items[i].flag)
                *items[i].flag = true;
        }
    }
    if (state->version < 3.5 && strcmp(key, "look_at") == 0) {
        memcpy(state->aim, v, sizeof state->aim);
        apply_look_at(state);
    }
    if (state->version < 3.5 && strcmp(key, "focal_point") == 0)
        apply_focus(state);
}

static void set_number(struct state *state, const char *key, double v)
{
    if (strcmp(key, "aperture") == 0)
        state->camera.aperture = v;
    if (strcmp(key, "blur_samples") == 0)
        state->camera.blur_samples = (int32_t)fmin(fmax(v, 0), INT32_MAX);
    if (strcmp(key, "angle") == 0) {
        state->angle = v;
        state->has_angle = true;
        if (state->version < 3.5)
            apply_angle(state);
    }
}

static void replay_item(struct state *state, const struct record *record)
{
    struct matrix matrix;
    if (strcmp(record->key, "type") == 0) {
        set_type(state, record->value, record->n);
    } else if (strcmp(record->key, "transform") == 0) {
        if (read_numbers(record, &matrix.images[0][0], 12) != 12)
            return;
        if (state->version < 3.5)
            apply_transform(state, &matrix);
        else if (state->n_transforms < MAX_TRANSFORMS)
            state->transforms[state->n_transforms++] = matrix;
    } else {
        int n = read_numbers(record, &matrix.images[0][0], 3);
        if (n == 3)
            set_vector(state, record->key, matrix.images[0]);
        else if (n == 1)
            set_number(state, record->key, matrix.images[0][0]);
    }
}

static bool refuse(const struct state *state, struct povray_error *error)
{
    const char *what = state->unsupported;
    if (what[0] == '=')
        snprintf(
            error->message, sizeof error->message,
            "the camera is a copy of \"%s\", whose declaration was not found; write "
            "the camera out in full",
            what + 1);
    else if (strcmp(what, "normal") == 0)
        snprintf(
            error->message, sizeof error->message,
            "the camera has a normal that bends its rays, which no lens filter can "
            "follow; remove the normal from the camera");
    else if (strcmp(what, "bokeh") == 0)
        snprintf(
            error->message, sizeof error->message,
            "the camera's bokeh { }, the light over its lens, cannot be read; remove "
            "it from the camera, and give a picture of it with "
            "--distribution-image FILE, or a shape such as --blades 6");
    else
        snprintf(error->message, sizeof error->message,
                 "the camera is of type %s, whose pictures have no lens that a filter "
                 "could follow; use a perspective or orthographic camera",
                 what);
    return false;
}

bool camera_replay(struct povray_camera *camera, const char *records, int guess,
                   int *n_guesses, struct povray_error *error)
{
    struct replay replay = {.guess = guess};
    struct record record;
    char *clean = without_blanks(records);
    const char *at = clean;
    state_init(&replay.current);
    state_init(&replay.used);
    while (next_record(&at, &record)) {
        if (strcmp(record.key, "camera") == 0)
            begin_camera(&replay, &record);
        else if (strcmp(record.key, "copy") == 0)
            copy_camera(&replay, &record);
        else if (strcmp(record.key, "end") == 0)
            end_camera(&replay);
        else
            replay_item(&replay.current, &record);
    }
    *camera = replay.used.camera;
    *n_guesses = replay.used.is_copy ? replay.n_declared : 0;
    free(replay.declared);
    free(clean);
    if (replay.used.unsupported[0])
        return refuse(&replay.used, error);
    return true;
}

bool records_find_number(const char *records, const char *key, double *number)
{
    struct record record;
    char *clean = without_blanks(records);
    const char *at = clean;
    bool is_found = false;
    while (next_record(&at, &record))
        if (strcmp(record.key, key) == 0 && read_numbers(&record, number, 1) == 1)
            is_found = true;
    free(clean);
    return is_found;
}

char **records_list(const char *records, const char *key, int *n)
{
    struct record record;
    char *clean = without_blanks(records), **list = NULL;
    const char *at = clean;
    *n = 0;
    while (next_record(&at, &record))
        if (strcmp(record.key, key) == 0) {
            char **longer = glue_grow(list, (size_t)*n + 1, sizeof *list);
            char *value = text_format("%.*s", record.n, record.value);
            list = longer ? longer : list;
            if (longer && value)
                list[(*n)++] = value;
            else
                free(value);
        }
    free(clean);
    return list;
}

/* ---- use ----------------------------------------------------------------------- */

static void write_vector(struct text *out, const char *key, const double v[3])
{
    text_addf(out, " %s <%.17g,%.17g,%.17g>", key, v[0], v[1], v[2]);
}

void camera_write(struct text *out, const struct povray_camera *camera, int n_samples)
{
    /* A #version where the scene has none would change its gamma. */
    text_addf(out, "#declare RF_=version; #if(RF_<3.5) #version 3.5; #end camera{%s",
              camera->is_orthographic ? "orthographic" : "perspective");
    write_vector(out, "location", camera->location);
    write_vector(out, "direction", camera->direction);
    write_vector(out, "right", camera->right);
    write_vector(out, "up", camera->up);
    if (n_samples > 0) {
        double focal_point[3];
        double reach = camera->focus_distance / vector_length(camera->direction);
        for (int i = 0; i < 3; i++)
            focal_point[i] = camera->location[i] + reach * camera->direction[i];
        write_vector(out, "focal_point", focal_point);
        text_addf(out,
                  " aperture %.17g blur_samples %d,%d variance 0 confidence 0.99999",
                  camera->aperture, n_samples, n_samples);
    }
    text_addf(out, "} #if(RF_<3.5) #version RF_; #end\n");
}

bool camera_is_same(const struct povray_camera *a, const struct povray_camera *b)
{
    bool is_same = a->is_orthographic == b->is_orthographic &&
                   a->aperture == b->aperture && a->focus_distance == b->focus_distance;
    for (int i = 0; i < 3; i++)
        is_same &= a->location[i] == b->location[i] &&
                   a->direction[i] == b->direction[i] && a->right[i] == b->right[i] &&
                   a->up[i] == b->up[i];
    return is_same;
}

void camera_ray(const struct povray_camera *camera, double x, double y, int32_t width,
                int32_t height, double start[3], double direction[3])
{
    double u = x / width - 0.5, v = 0.5 - y / height;
    for (int i = 0; i < 3; i++) {
        double across = u * camera->right[i] + v * camera->up[i];
        start[i] = camera->location[i] + (camera->is_orthographic ? across : 0);
        direction[i] = camera->direction[i] + (camera->is_orthographic ? 0 : across);
    }
}
