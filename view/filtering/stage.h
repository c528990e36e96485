/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the window shows: files, or the demo's scene. It is opened and read on a thread
 * of its own, since POV-Ray may have to render first.
 */
#ifndef VIEW_STAGE_H
#define VIEW_STAGE_H

#include <stdbool.h>
#include <stdint.h>

#include "common/view_options.h"
#include "pixels/input.h"
#include "povray.h"
#include "sources/source.h"
#include "sources/views.h"

/* A picture that can be opened: one or two files, or several views. */
struct picture_files {
    char **paths;
    int n_paths;
};

/* What the command line named, as pictures to step through. */
struct playlist {
    struct picture_files *pictures;
    int n;
    char remark[400]; /* frames that a folder lacks; "": none */
};

/* Finds the pictures; scenes count as one picture of one path. False with a message in
 * `error`. */
bool playlist_open(struct playlist *playlist, char *const *paths, int n_paths,
                   struct image_error *error);
void playlist_close(struct playlist *playlist);

struct stage {
    const struct view_options *options;
    const struct picture_files *files;
    char *const *povray_args;
    int n_povray_args;
    bool is_scene; /* of POV-Ray */
    struct povray_scene *scene;
    struct povray_options povray_options;
    struct povray_camera camera;     /* of the scene's passes */
    double focal_px;                 /* their focal length */
    bool has_stop;                   /* their lens radius is that of a typed f-stop */
    char *scene_paths[RF_MAX_VIEWS]; /* passes that were rendered */
    int n_scene_paths;
    bool is_open, has_views;
    struct source source; /* of the first view; of the lowest layer, of the left eye */
    struct source others[STACK_MOST]; /* of the layers above, of the right eye */
    int n_others;
    struct input *input;
    /* Of the light of the source and of the others, as rackfocus filter tells it. */
    double whites[1 + STACK_MOST];
    /* For other threads. */
    volatile double fraction; /* of rendering */
    volatile bool is_cancelled;
    char label[256];   /* what is being done, "rendering scene.pov" */
    char remark[2400]; /* what the user should know of scene and depth; "": nothing */
    char way_out[900]; /* of refused numbers, behind the core's error; "": none */
};

/* Opens and reads; `typed` is the command line. False with a message. */
bool stage_load(struct stage *stage, const struct settings *typed,
                struct image_error *error);
void stage_close(struct stage *stage);

/*
 * The parameters that `rackfocus filter` would use with these files and what was typed:
 * *settings receives them with their origins, *params fitted to the data window. False
 * with a message.
 */
bool stage_resolve(const struct stage *stage, const struct settings *typed,
                   struct settings *settings, struct rf_params *params, char *text,
                   size_t n_bytes);

/* The others of --over and --stereo with their parameters; `params` are the first's.
 * False with a message. */
bool stage_stack(const struct stage *stage, const struct settings *typed,
                 const struct rf_params *params, struct stack *stack, char *text,
                 size_t n_bytes);

/* Is the picture of --distribution-image used with these parameters? */
bool stage_uses_light(const struct rf_params *params);

/* A file that is written. */
struct stage_output {
    const char *path;
    int32_t type; /* samples of an EXR file, enum filter_type */
};

/* The command line that makes the picture. */
void stage_command(const struct stage *stage, const struct settings *typed,
                   const struct stage_output *output, char *text, size_t n_bytes);

/* Writes filtered pixels as `rackfocus filter` would; they may be changed. `remarks`
 * becomes what `filter` would warn of, "" for nothing. */
bool stage_save(const struct stage *stage, const struct settings *settings,
                const struct stage_output *output, float *pixels, char *remarks,
                size_t n_bytes, struct image_error *error);

/* Would a file of this name, whatever it is called here, take the place of one that the
 * stage was read from? */
bool stage_reads(const struct stage *stage, const char *path);

/* Is a file of the stage gone, or another than was read? Names it. */
const char *stage_find_missing(const struct stage *stage);

#endif
