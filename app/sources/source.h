/* SPDX-License-Identifier: Apache-2.0 */
/* The colour and depth that a run works on, from one file or two. */
#ifndef APP_SOURCE_H
#define APP_SOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "image.h"
#include "sources/header_facts.h"

/* What the command line says about the input. */
struct source_request {
    char *const *paths; /* colour first, then files that may supply the depth */
    int n_paths;
    const char *layer;         /* --layer or NULL */
    const char *depth_file;    /* --depth-file or NULL */
    const char *depth_channel; /* --depth-channel or NULL */
    const char *depth_option;  /* that names depth_file; NULL: depth-file */
    const char *view;          /* of a multi-view file; NULL: its first, or --layer's */
};

struct settings;

struct source {
    struct image_input *colour;
    struct image_input *depth; /* may be the same as colour; NULL where there is none */
    struct image_layer layer;  /* in `colour`; r is -1 where it has no colour */
    int z;                     /* channel of `depth`, -1: none */
    int z_rival;               /* another that may be meant as well, -1: none */
    bool is_rival_weak;        /* as of image_layer */
    bool is_red;      /* z is the red of a --depth-file whose colours are equal */
    bool is_of_other; /* z is of another layer than the colour, with its own picture */
    bool is_of_no_view; /* z, and the colour is of another view than the first */
    const char *view;   /* that was asked for; NULL: none */
    int part;           /* of the colour, else of the depth */
    struct image_part_info info; /* of that part */
    int32_t width, height;       /* of its data window */
    int n_channels;              /* of the colour: 1 grey, 3 RGB, 4 RGBA */
    bool is_grey;
};

/*
 * Opens the files and finds the channels. Neither missing colour nor missing depth is
 * an error here, but layers and channels that were asked for by name must exist.
 */
bool source_open(struct source *source, const struct source_request *request,
                 struct image_error *error);
void source_close(struct source *source);

/* Takes the camera's facts from the header of the colour, then from that of the depth.
 * False with a message; see settings_read_header. */
bool source_read_facts(const struct source *source, struct settings *settings,
                       char *text, size_t n_bytes);

/* Is there a depth, of all of the colour where there is one? */
bool source_check_depth(const struct source *source, struct image_error *error);

/* Is there all that a filter needs, in one size? */
bool source_check(const struct source *source, struct image_error *error);

/* Are all colours data, such as normals? Says so into `text`. */
bool source_has_only_data(const struct source *source, char *text, size_t n_bytes);

/* Why the colour may not be what is meant, into `text`; false: there is no doubt. */
bool source_is_doubtful(const struct source *source, char *text, size_t n_bytes);

/* Does the colour have its blur already? Says so into `text`. */
bool source_was_filtered(const struct source *source, char *text, size_t n_bytes);

/* Is the colour an environment map, which no lens takes? Says so into `text`. */
bool source_is_environment(const struct source *source, char *text, size_t n_bytes);

/* Is the colour coded for a screen or a film, by its header? Says so into `text`. */
bool source_is_coded(const struct source *source, char *text, size_t n_bytes);

/* Says all of these four that hold, "the picture is ...". */
void source_say_doubts(const struct source *source,
                       void (*say)(void *user, const char *text), void *user);

/* How the depth was found where its name does not say so, into `text`; false: it does. */
bool source_explains_depth(const struct source *source, char *text, size_t n_bytes);

/* Do colour and depth cover the same pixels? */
bool source_has_one_window(const struct source *source);

/* Is there another depth that may be meant, with other numbers? Reads both. One whose
 * name is less usual and whose numbers are within 0 to 1 is a copy for viewing. */
bool source_has_rival(const struct source *source);

/* Interleaved samples, n_channels each; grey with alpha is spread to RGBA. To be freed
 * by the caller; NULL on failure. */
float *source_read_colour(const struct source *source, int n_threads,
                          struct image_error *error);
float *source_read_depth(const struct source *source, int n_threads,
                         struct image_error *error);

/* Name for channel i of the colour (0 to 3, A last; grey: 0 and 3) in a file like the
 * source: as it is there, R G B in place of luminance and chroma. */
void source_channel_name(const struct source *source, int i, char *text,
                         size_t n_bytes);

enum { TOOL_FILE_BYTES = 440 };

/* What oiiotool is to read in a command for messages, TOOL_FILE_BYTES long: the name of the
 * file, with " --subimage 2" behind it where channel i is in one of several parts. */
void source_tool_file(const struct image_input *input, int i, char *text);

/* "R, G, B, A" for messages; ends in ", ..." where there are many. */
void source_list_channels(const struct image_input *input, char *text, size_t n_bytes);

/* How to write a picture that was made of a source. */
struct source_output {
    enum image_sample_type type;
    const char *compression; /* NULL: the source's */
    const char *made;        /* for the attribute rackfocus:filtered; NULL: none */
    const struct settings *settings; /* with which it was made; NULL: its lens is as the
                                        attributes of the source say */
    int n_threads;
};

/* A picture like a source, for image_write. */
struct source_description {
    char own_names[4][256];
    const char *names[4];
    enum image_sample_type types[4];
    struct header_facts facts;
    struct image_output output;
};

/* Names, windows and attributes of `like`; the description must stay where it is. Grey
 * with alpha has two channels. */
void source_describe(const struct source *like, const struct source_output *how,
                     struct source_description *description);

/* What parts colours does nothing to grey, whose light would be that of red alone where it
 * was spread to four channels. */
void source_settle_grey(const struct source *source, struct rf_params *params);

/* Grey with alpha was spread to four channels; packs n pixels to two, in place. */
void source_pack_grey_alpha(float *samples, size_t n);

/* Writes samples as source_read_colour gives them, with the names, windows and
 * attributes of `like`; they are packed in place. */
bool source_write_colour(const struct source *like, const char *path, float *samples,
                         const struct source_output *how, struct image_error *error);
/* The same with a description of it, in which more may stand. */
bool source_write_described(const struct source *like, const char *path, float *samples,
                            struct source_description *description, int n_threads,
                            struct image_error *error);

#endif
