/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Drives POV-Ray 3.7: renders an unmodified scene as a pinhole picture with depth, and
 * finds its camera and lens. Nothing is written but a private folder, which is removed.
 */
#ifndef POVRAY_H
#define POVRAY_H

#include <stdbool.h>
#include <stdint.h>

struct povray_error {
    char message[4096]; /* "FILE:LINE: what is wrong; the way out" */
    bool is_interrupted;
};

enum povray_focus {
    POVRAY_FOCUS_SCENE,     /* focal_point */
    POVRAY_FOCUS_DIRECTION, /* none: POV-Ray takes the length of direction */
    POVRAY_FOCUS_LOOK_AT,   /* none and no lens in the scene: look_at */
    POVRAY_FOCUS_OPTION,    /* the user's */
};

struct povray_camera {
    bool is_orthographic;
    /* As in the scene's language, after all transformations. Scene units. */
    double location[3], direction[3], right[3], up[3];
    double aperture;         /* 0: the scene's camera has no lens */
    double focus_distance;   /* as POV-Ray takes it; scene units along the axis */
    bool has_focal_point;    /* that distance was asked for */
    double look_at_distance; /* 0: the camera has no look_at */
    int32_t blur_samples;    /* 0: POV-Ray draws no blur, whatever the aperture */
    enum povray_focus focus; /* where focus_distance comes from */
    bool is_sharp;           /* the lens is the scene's, and POV-Ray draws none of it */
    double f_stop;           /* the user's, of which the aperture is; 0: none */
};

/* What is to be rendered, as POV-Ray's options and initialisation files have it. */
struct povray_plan {
    char *scene; /* path */
    char **args; /* options for POV-Ray */
    int n_args;
    bool is_animation;
    int32_t first, last;   /* frames of the animation */
    int32_t from, to;      /* those to make */
    int32_t step;          /* each so many of them */
    bool has_antialiasing; /* options that no file holds ask for it, and say how */
};

/*
 * Makes a plan of what the user named, a scene (".pov" may be missing) or an
 * initialisation file ("file.ini[Section]", too) that names one, and of options for POV-Ray. False with a message
 * where the file is not there or names no scene. povray_plan_free() in any case.
 */
bool povray_plan_make(struct povray_plan *plan, const char *operand, char *const *args,
                      int n_args, struct povray_error *error);
void povray_plan_free(struct povray_plan *plan);

/* An input of a plan: a file, or an option of POV-Ray. */
typedef void (*povray_input_fn)(void *user, const char *text, bool is_file);

/*
 * Hands over what the pictures of a plan depend on, but which frames are made, in an
 * order that stays. *has_computed: the scene puts names together (concat), and files
 * that it so names are not among them. False where the scene cannot be read.
 */
bool povray_list_inputs(const struct povray_plan *plan, povray_input_fn receive,
                        void *user, bool *has_computed);

/* An f-stop, and the lens radius that it is for a perspective and for an orthographic
 * camera; 0: not known here. */
struct povray_stop {
    double f_stop, radius[2];
};

struct povray_options {
    const char *scene;
    const char *program; /* POV-Ray; NULL: povray on the PATH, or Windows' pvengine */
    char *const *args;   /* options for POV-Ray */
    int n_args;
    int32_t frame;                   /* of an animation; -1 for a still */
    int32_t first_frame, last_frame; /* of the whole animation, which set the clock */
    /* The lens, where it is not to be the scene's. */
    bool has_aperture, has_focal_point, has_focus_distance;
    double aperture, focal_point[3], focus_distance;
    bool has_f_stop; /* the user gave one: the scene's lens is off */
    struct povray_stop stop;
    /* Samples of the passes along a side of each pixel, 1 to 4; 0: as many as the
     * picture needs (povray_render), 1 (views). */
    int32_t supersample;
    /* What the passes show beyond the picture's border, px; -1: as far as blur reaches.
     */
    int32_t overscan_px;
    /* A surface in focus that is no plane across the axis, as far as that border needs
     * it: what 1 / its distance grows by per unit of the tangent to the right and up and,
     * at most, by its curvature, 1 / scene units; and another distance that is in focus
     * somewhere, 0: none. */
    double tilt[2], curvature, split_distance;
    /* What is seen through flat clear glass and in flat mirrors has its own depth: six
     * renders more. */
    bool is_through_glass;
    /* Warnings that a look at the picture gives: how much of it is seen through clear
     * things, where the scene speaks of such (a small render more), and light that
     * anti-aliasing loses. */
    bool warns_by_look;
    bool wants_lens; /* false: passes only, a missing aperture is no error */
    /* povray_render_reference() follows: a camera for which POV-Ray has no working blur
     * is refused before anything is rendered. */
    bool wants_reference;
    bool (*is_cancelled)(void *user);              /* may be NULL; asked every few ms */
    void (*progress)(void *user, double fraction); /* may be NULL */
    void *user;
    int32_t n_threads; /* for the work outside POV-Ray */
    /* Of povray_render_views: which views are there already, and not rendered; NULL:
     * none. */
    const bool *has_view;
};

struct povray_passes {
    /* Of the passes: the picture and a border of border_px on all sides, supersample
     * times as large. */
    int32_t width, height;
    int32_t supersample, border_px;
    bool has_alpha;
    float *colour;         /* RGBA, scene-linear, premultiplied */
    float *depth;          /* planar, scene units, INFINITY where nothing was hit */
    double lens_offset[2]; /* of a view, scene units right and up */
    struct povray_camera camera;
    double gamma;    /* of the space POV-Ray computes in: pixel = value^gamma */
    bool is_srgb;    /* that space is sRGB's curve; gamma is 2.2 then */
    double n_inside; /* share of pixels whose depth is unknown (see warning) */
    double colour_s, total_s; /* time of the colour render and of all of it */
    char warning[512];        /* "" or sentences, parted by a semicolon */
};

/* Opened scene: files read, private folder made. */
struct povray_scene;

bool povray_open(struct povray_scene **scene, const struct povray_options *options,
                 struct povray_error *error);
void povray_close(struct povray_scene *scene);

/* A sentence that the user should read before the render, or "". */
const char *povray_remark(const struct povray_scene *scene);

/* Does the scene read the time (now)? All its renders find the same, those of another
 * opened scene a later one. */
bool povray_reads_time(const struct povray_scene *scene);

/* Do options want radiosity's light in a file (Radiosity_To_File)? Views write none. */
bool povray_keeps_light(const struct povray_scene *scene);

/* What POV-Ray itself makes of the scene's lens, where that is another picture than ours,
 * with the ways out; else "". */
const char *povray_lens_remark(const struct povray_camera *camera);

/* The private folder, with its slash; what is put there goes with the scene. */
const char *povray_folder(const struct povray_scene *scene);

/* Renders the passes; release with povray_passes_free. */
bool povray_render(struct povray_scene *scene, struct povray_passes *passes,
                   struct povray_error *error);
void povray_passes_free(struct povray_passes *passes);

/* What passes say beside their pixels: size, camera, space. After povray_render_views,
 * which may have had nothing to render. */
void povray_describe(const struct povray_scene *scene, struct povray_passes *passes);

/* Size of the picture that the passes are for, px. */
int32_t povray_picture_width(const struct povray_passes *passes);
int32_t povray_picture_height(const struct povray_passes *passes);

/* What povray_render_views hands each view to; false with a message ends the work. */
typedef bool (*povray_view_fn)(void *user, int view, const struct povray_passes *passes,
                               struct povray_error *error);

/*
 * Renders n_views views from `places` on the lens, lens radii right and up, each
 * sheared so that the plane in focus stays; passes->camera is the one in the middle.
 * `receive` gets them in order, one at a time, and owns nothing of them. *total_s is
 * the time of all.
 */
bool povray_render_views(struct povray_scene *scene, const double (*places)[2],
                         int n_views, povray_view_fn receive, void *user,
                         double *total_s, struct povray_error *error);

/* A view to render: lens radii right and up of the middle, a part of a pixel right and
 * up, and the moment within the shutter's time, 0 to 1. */
struct povray_view {
    double u, v;
    double x_px, y_px;
    double time;
};

/* How the camera goes to a point of the lens. */
enum povray_move {
    /* Moved, its frustum sheared: the plane in focus stays (OpenGL programming guide:
     * the edges of the frustum move by -x n / F). */
    POVRAY_MOVE_SHIFT,
    /* Moved, then turned to the point in the middle of the plane in focus, as gluLookAt
     * does with the camera's up (OpenGL wikibook): that point stays, its plane not. */
    POVRAY_MOVE_LOOK_AT,
};

struct povray_lens {
    const struct povray_view *views;
    int n_views;
    enum povray_move move;
    /* A plane in focus that is tilted, with POVRAY_MOVE_SHIFT: what 1 / its distance
     * grows by per unit of the tangent to the right and up, 1 / scene units. */
    double tilt[2];
    /* Time that the shutter is open about the clock of the picture: in frames of an
     * animation, in units of the clock for a still. 0: no motion. */
    double shutter;
    const char
        *before; /* options for POV-Ray that the user's win over; NULL: the usual */
};

/*
 * Renders the colour of many views, of which few are in memory and on the disk at any
 * time. passes->depth is NULL, passes->camera the scene's at the middle of the shutter,
 * passes->lens_offset in scene units. With a shutter the scene is parsed for the
 * camera of each moment. Else as povray_render_views.
 */
bool povray_render_lens(struct povray_scene *scene, const struct povray_lens *lens,
                        povray_view_fn receive, void *user, double *total_s,
                        struct povray_error *error);

/* Recovers and verifies the camera, renders no pass. */
bool povray_find_camera(struct povray_scene *scene, struct povray_camera *camera,
                        double *gamma, struct povray_error *error);

/*
 * POV-Ray's own focal blur of the same camera and lens with n_samples per pixel.
 * *rgba is width * height * 4, the caller frees; *seconds is the time it took.
 */
bool povray_render_reference(struct povray_scene *scene,
                             const struct povray_passes *passes, int32_t n_samples,
                             float **rgba, double *seconds, struct povray_error *error);

#endif
