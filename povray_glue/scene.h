/* SPDX-License-Identifier: Apache-2.0 */
/* An opened scene and its renders, for the parts of the glue that make pictures. */
#ifndef POVRAY_SCENE_H
#define POVRAY_SCENE_H

#include "decode.h"
#include "povray.h"
#include "run.h"
#include "sources.h"

/* A view is one of many: docs/views.md has times and scores. All show what is in focus at the
 * same places of their pixels, so that the merge takes no grain of fine textures out: with
 * +A0.1 a wall of bumps had 39.7 dB (51.5), others 0 to 0.2 less, for up to half the time. */
#define VIEW_OPTIONS "+A0.02 +AM1 +R3 -J"
/* And one of very many, of which the plain mean is taken. */
#define MEAN_OPTIONS "+A0.1 +AM1 +R2 -J"
/* Views that render side by side. */
#define VIEWS_AT_ONCE 2

struct povray_scene {
    struct povray_options options;
    char *temp_folder;
    struct sources sources;
    char *records; /* of the camera's items */
    int guess, n_guesses;
    struct povray_camera camera;
    double probe_scale; /* of PROBE_SCALES */
    struct decode_space space;
    int32_t width, height;          /* of the picture */
    int32_t supersample, border_px; /* as in struct povray_passes */
    char *copies;         /* folder of files that the scene writes to, as they were */
    bool has_glanced;     /* at what is seen through clear things */
    bool has_weighed;     /* the light of the colour against that of single rays */
    bool has_written;     /* a render has written the scene's files where it should */
    char clock_words[96]; /* options that shift the clock, "" or with blanks between */
};

/* What is rendered at once: the scene from a camera, with what is beyond the border, in
 * the samples wanted. */
struct shot {
    struct povray_camera camera; /* as wide as the border makes it */
    int view;                    /* -1: the picture's own camera */
    int32_t width, height;       /* rendered, px */
    bool is_scenes; /* the scene's own camera and size: POV-Ray needs no words */
};

/* The shot from a camera, in the scene's window. */
struct shot shot_make(const struct povray_scene *scene,
                      const struct povray_camera *camera, int view);

/* The name of a render's folder; the caller frees. */
char *shot_name(const struct shot *shot, const char *name);

/* The shot's camera in POV-Ray's words, and the options of its size after `options`. */
void shot_add_camera(struct text *tail, const struct shot *shot);
char *shot_options(const struct shot *shot, const char *options);

/* Chooses the samples and the border of the passes, once the camera is known. False
 * where the user's own border is wider than any picture needs. */
bool scene_choose_window(struct povray_scene *scene, bool is_one_view,
                         struct povray_error *error);

/* Radius of the blur of what is infinitely far (orthographic: twice as far as the
 * focus), px of the picture. */
double scene_far_radius_px(const struct povray_scene *scene);

/* Parses the scene, at the clock that clock_words say, for the items of its cameras. */
bool scene_find_items(struct povray_scene *scene, struct povray_error *error);

/* Starts a small render that checks the camera, and looks at it once it has ended; run
 * does all of it. */
bool scene_start_probe(struct povray_scene *scene, struct run *run,
                       struct povray_error *error);
bool scene_check_probe(struct povray_scene *scene, const struct run *run,
                       struct povray_error *error);
bool scene_run_probe(struct povray_scene *scene, struct povray_error *error);

/* After a probe that did not fit: tries spheres of other sizes, then the declared
 * cameras that the scene's may be a copy of. */
bool scene_probe_again(struct povray_scene *scene, struct povray_error *error);

/* Messages: "PATH: errno's text", "SCENE: what error says", and why a render failed.
 * Those that return a bool return false. */
bool scene_fail_file(struct povray_error *error, const char *path);
bool scene_fail(const struct povray_scene *scene, struct povray_error *error);
void scene_explain(struct povray_scene *scene, const struct run *run,
                   struct povray_error *error);

/* Adds a sentence to the warning of the passes. */
void scene_add_warning(struct povray_passes *passes, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The picture becomes the colour of the passes, with its size and time, and a warning
 * where it is too bright for POV-Ray's files. */
void scene_take_colour(struct povray_passes *passes,
                       const struct decode_picture *picture, const struct run *run);

/* False with a message where a picture has not the size of the passes. */
bool scene_same_size(const struct povray_scene *scene,
                     const struct povray_passes *passes,
                     const struct decode_picture *picture, struct povray_error *error);

/* Why there is no reference. */
#define GLUE_NO_ORTHOGRAPHIC_BLUR                                                      \
    "POV-Ray 3.7 has no working focal blur for orthographic cameras; leave out "       \
    "--reference"

/* The camera of the items, with the user's lens in place of the scene's. */
bool scene_choose_camera(struct povray_scene *scene, struct povray_error *error);

/* What a render does with the file of radiosity's light that options name (+RF). Renders
 * at once, and of a scene with our fogs in it, would spoil it for all that read it. */
enum scene_light { SCENE_LIGHT_NONE, SCENE_LIGHT_READ, SCENE_LIGHT_KEPT };

/* A render of a copy of the scene. Texts may be NULL. */
struct scene_render {
    const char *name; /* of its folder in the scene's own */
    enum rewrite_mode mode;
    const char *head, *tail;    /* around the scene; the head goes behind a #version */
    const char *before, *after; /* POV-Ray's options before the user's, and after */
    bool is_picture; /* what the user asked for: the first writes the scene's files */
    enum scene_light light;
};

bool scene_start_render(struct povray_scene *scene, struct run *run,
                        const struct scene_render *render, struct povray_error *error);

/* Starts POV-Ray on a file of the private folder; the same without writing a copy. */
bool scene_start_run(struct povray_scene *scene, struct run *run, const char *file,
                     const struct scene_render *render, struct povray_error *error);

/* Waits without moving the progress bar, which is the colour's. */
bool scene_wait(const struct povray_scene *scene, struct run *const *runs, int n,
                struct povray_error *error);

/* Reads the picture of a run that has ended; explains why where there is none. */
bool scene_read(struct povray_scene *scene, const struct run *run,
                struct decode_picture *picture, struct povray_error *error);

#endif
