/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads and writes OpenEXR files through OpenEXRCore, and writes PNG. The core never
 * links this; the command and the POV-Ray glue do.
 *
 * Memory holds float samples, rows from the top, the data window only. Every function
 * that can fail returns false and fills `error` with one sentence that names the file.
 */
#ifndef RF_IMAGE_H
#define RF_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum image_code {
    IMAGE_OK,
    IMAGE_FAILED,    /* the file, or what was asked for */
    IMAGE_NO_MEMORY, /* the same call may work later */
};

/* Valid after a failure only. */
struct image_error {
    char message[1024]; /* "FILE: what is wrong; the way out" */
    enum image_code code;
};

/* Inclusive pixel ranges as in EXR headers. */
struct image_box {
    int32_t min_x, min_y, max_x, max_y;
};

enum image_sample_type { IMAGE_SAMPLE_HALF, IMAGE_SAMPLE_FLOAT, IMAGE_SAMPLE_UINT };

struct image_channel_info {
    const char *name; /* as stored: "ViewLayer.Combined.R", "R", "depth.Z" */
    enum image_sample_type type;
    int32_t x_sampling, y_sampling;
    int32_t part;
};

struct image_part_info {
    const char *name;        /* "" where the part has none */
    const char *view;        /* "" where it has none */
    const char *compression; /* "zip", "dwaa", ... */
    bool is_tiled, is_deep;
    struct image_box data_window, display_window;
    float pixel_aspect;
    const char *environment; /* "latlong" or "cube" of an environment map, else NULL */
};

/* An opened file: headers read, pixels not yet. */
struct image_input;

bool image_open(struct image_input **input, const char *path,
                struct image_error *error);
void image_close(struct image_input *input);
const char *image_path(const struct image_input *input);
const struct image_part_info *image_parts(const struct image_input *input, int *n);
/* Channels of all parts, in file order. */
const struct image_channel_info *image_channels(const struct image_input *input,
                                                int *n);

/* Does it hold numbers of objects or materials, such as Cryptomatte's, by its type or its
 * name? A mean of two is a third. */
bool image_is_identifier(const struct image_channel_info *channel);

/* The i-th attribute of a part, in file order; NULL behind the last. */
const char *image_attribute_name(const struct image_input *input, int part, int i);

/* Header attributes (part 0 first, then the others). False where absent or of another
 * type; ints, floats and doubles convert to each other. The string belongs to input. */
bool image_attribute_number(const struct image_input *input, const char *name,
                            double *v);
bool image_attribute_string(const struct image_input *input, const char *name,
                            const char **text);
bool image_attribute_v2f(const struct image_input *input, const char *name,
                         double v[2]);
extern const float image_rec709[8];
/* x and y of red, green, blue and white of a part; Rec. 709's where it says none. */
void image_read_chromaticities(const struct image_input *input, int part, float xy[8]);
/* Do the chromaticities of a part say other primaries than Rec. 709's? */
bool image_has_other_primaries(const struct image_input *input, int part);
/* Of 4 x 4 numbers, by rows. */
bool image_attribute_matrix(const struct image_input *input, const char *name,
                            double m[16]);

/*
 * The views of a file after OpenEXR's multi-view convention, the first being the one to
 * show: the strings of `multiView`, whose channels are named LAYER.VIEW.BASE (those of
 * the first view also LAYER.BASE), or else the attribute `view` of the parts. NULL from
 * i = image_view_count() on; a file without views has 0.
 */
const char *image_view_name(const struct image_input *input, int i);
int image_view_count(const struct image_input *input);
/* The view that a channel is of; NULL in a file without views. */
const char *image_view_of(const struct image_input *input, int channel);

/*
 * An attribute of one view: `name` in the header of a part of that view, else
 * "NAME.VIEW" in any part (files whose views share a part). As image_attribute_number.
 */
bool image_view_number(const struct image_input *input, const char *view,
                       const char *name, double *v);
bool image_view_v2f(const struct image_input *input, const char *view, const char *name,
                    double v[2]);

/* What a picture is made of; -1 where the file has none. Indices into image_channels.
 */
struct image_layer {
    int r, g, b, a; /* grey pictures: r = g = b = the Y channel */
    int z;
    int z_rival;        /* another depth that fits as well as z; -1: none */
    bool is_rival_weak; /* but for its spelling: often a copy for viewing */
    char name[256];     /* layer as found, "" for the plain R G B A */
    char
        fitting[256]; /* "key, fill": layers that fit equally well, the one taken first;
                          "" where it is the only one */
    bool is_data;   /* nobody named it, and all that there are hold data, no picture */
    bool is_chroma; /* r, g and b are Y, RY and BY: image_read_layer makes R G B of them
                     */
};

/*
 * Finds the colour and depth of a layer. `layer` (may be NULL) is matched against whole
 * dotted components: "ViewLayer", "ViewLayer.Combined", "Composite"; the name of a view takes that. NULL takes the
 * first of: plain R G B; *.Combined.*; Composite.*; other names that mean the picture
 * ("beauty", "rgba"); any other layer with R G B; one of data, such as albedo, normals
 * and Cryptomatte (layer_names.c has the names).
 * Alpha: beside the colours, else as the only colour of a layer "alpha" or of a part with
 * the same data window.
 * Depth: `depth_channel` where given (exact name; the picture's own alpha is then none), else in the same layer or view layer
 * Z, Depth.Z, depth.Z, *.Depth.Z, *.V/Depth variants that Blender, Arnold, RenderMan,
 * Nuke and V-Ray write. A missing depth is not an error here (z = -1), a missing colour
 * is (the message lists the layers of the file) unless `depth_only`.
 */
bool image_find_layer(const struct image_input *input, const char *layer,
                      const char *depth_channel, bool depth_only,
                      struct image_layer *found, struct image_error *error);

/* The same within one view (a name of image_view_name); NULL as above. */
bool image_find_view_layer(const struct image_input *input, const char *view,
                           const char *layer, const char *depth_channel,
                           bool depth_only, struct image_layer *found,
                           struct image_error *error);

/*
 * Reads channels (indices into image_channels, all of one data window) into `samples`,
 * interleaved: sample c of pixel (x, y) is samples[(y * width + x) * n + c]. An index
 * of -1 gives 1.0. A sub-sampled channel fills the block of pixels that each of its
 * samples stands for. Decodes on n_threads.
 */
bool image_read(struct image_input *input, const int *channels, int n, float *samples,
                int n_threads, struct image_error *error);

/* Rows of the data window, counted from its top. */
struct image_rows {
    int32_t first, n;
};

/*
 * The same for some rows only: samples begins with row rows.first. Only the chunks that
 * hold those rows are decoded, so a picture of any size is read in strips; rows that
 * begin and end at multiples of image_row_step() decode no chunk twice. Memory: the
 * compressed and decoded bytes of one chunk per thread.
 */
bool image_read_rows(struct image_input *input, const int *channels, int n,
                     struct image_rows rows, float *samples, int n_threads,
                     struct image_error *error);
/* Rows of a chunk or tile of a part; 1 where the header is damaged. */
int32_t image_row_step(const struct image_input *input, int part);

/*
 * The first n of R G B A of a layer, as image_read gives them; from luminance and
 * chroma where the layer has those. n is 1 (grey), 3 or 4.
 */
bool image_read_layer(struct image_input *input, const struct image_layer *layer, int n,
                      float *samples, int n_threads, struct image_error *error);

/* The samples of a deep part, in file order within each pixel. */
struct image_deep {
    int32_t width, height; /* of the data window */
    size_t *first;         /* width * height + 1: where each pixel's samples start */
    float *samples;        /* n per sample, interleaved */
};

/*
 * Reads channels (indices, all of one deep part, scan-line or tiled) of every sample.
 * An index of -1 gives 0. Decodes on n_threads; release with image_deep_free. A file
 * that would hold more samples than its bytes can be is refused.
 */
bool image_read_deep(struct image_input *input, const int *channels, int n,
                     struct image_deep *deep, int n_threads, struct image_error *error);
void image_deep_free(struct image_deep *deep);

/* The ZBack that belongs to depth channel z (same part and layer), -1: none. */
int image_find_z_back(const struct image_input *input, int z);

struct image_attribute { /* a number, a string, a v2f or an m44f for a header */
    const char *name;
    enum {
        IMAGE_ATTRIBUTE_FLOAT,
        IMAGE_ATTRIBUTE_INT,
        IMAGE_ATTRIBUTE_STRING,
        IMAGE_ATTRIBUTE_V2F,
        IMAGE_ATTRIBUTE_M44F
    } type;
    double number[2];
    const char *text;
    const double *matrix; /* 16, by rows */
};

/* One picture to write. */
struct image_output {
    int32_t width, height; /* of the data window */
    /* All zero: {0, 0, width - 1, height - 1}. */
    struct image_box data_window, display_window;
    float pixel_aspect; /* 0: 1 */
    int n_channels;
    const char *const *channel_names; /* n_channels */
    const enum image_sample_type *types;
    const float *samples;    /* interleaved */
    const char *compression; /* NULL: that of `like`, else "zip" (exr_write_plan.c) */
    const struct image_attribute *attributes; /* win over those taken from `like` */
    int n_attributes;
    /* Attributes of like_part not to take ("name": its name), ended by NULL; "X*" drops
     * all that begin with X. NULL: none. */
    const char *const *dropped;
    /* Windows, aspect, compression and all custom and standard attributes are copied
     * from part `like_part` of this input where not NULL. */
    struct image_input *like;
    int like_part;
    /* The windows are those above, not those of `like`: of another size, without
     * pass_through. */
    bool has_own_windows;
    /* Also write every other channel of `like` unchanged (bit for bit), in its parts;
     * channels of like_part with the names in channel_names are replaced. Parts other
     * than like_part are copied as compressed, tiled and deep ones included. */
    bool pass_through;
    /* Side of square tiles, px; 0: scan lines. Tiles hold no sub-sampled channel. */
    int32_t tile_size;
};

/* Writes beside `path` and renames, so that an old file is kept on any failure. */
bool image_write(const char *path, const struct image_output *output, int n_threads,
                 struct image_error *error);

/*
 * Can what is in two files stand in one? EXR wants display window, pixel aspect and
 * chromaticities (Rec. 709 where there are none) alike in all parts of a file. The error
 * names b, the attribute and both values; there is no way out in it.
 */
bool image_check_alike(const struct image_input *a, const struct image_input *b,
                       struct image_error *error);

/*
 * Joins n files of one flat part each to a multi-view file: part i is that of
 * inputs[i], as compressed, with all its attributes; its name and its view are
 * views[i], which are all different. Time code and chromaticities are those of the first
 * that has them; files that image_check_alike() refuses are not joined, but where one
 * has no chromaticities. Beside `path` and renamed.
 */
bool image_join_views(const char *path, struct image_input *const *inputs,
                      const char *const *views, int n, struct image_error *error);

/*
 * The same, strip by strip, for pictures larger than memory: begin writes the header
 * and the parts before the picture's, rows the next rows from the top, finish the other
 * parts, and renames. Memory: one strip of the kept channels, the strip as compressed,
 * a chunk per thread. output->samples is not looked at; `path`, `output` and what it
 * points to must stay until finish or abort, one of which must be called and frees the
 * writer. `n_rows` is a multiple of image_write_step() but for the last strip. After a
 * failure of image_write_rows only abort is of use; an old file is then still there.
 */
struct image_writer;
bool image_write_begin(struct image_writer **writer, const char *path,
                       const struct image_output *output, int n_threads,
                       struct image_error *error);
int32_t image_write_step(const struct image_writer *writer);
bool image_write_rows(struct image_writer *writer, int32_t n_rows, const float *samples,
                      struct image_error *error);
bool image_write_finish(struct image_writer *writer, struct image_error *error);
void image_write_abort(struct image_writer *writer);

/*
 * Writes a PNG beside `path` and renames. Samples are interleaved, n_channels 1, 3 or
 * 4, scene-linear and premultiplied: they are unpremultiplied, clipped to [0, 1] and
 * sRGB encoded; with is_encoded they are written as they are. bits is 8 or 16.
 */
bool image_write_png(const char *path, const float *samples, int32_t width,
                     int32_t height, int n_channels, int bits, bool is_encoded,
                     struct image_error *error);

/*
 * Reads a PNG of any kind, taken as sRGB encoded, to linear premultiplied floats, RGBA.
 * The caller frees *samples.
 */
bool image_read_png(const char *path, float **samples, int32_t *width, int32_t *height,
                    struct image_error *error);

/* Largest picture that readers accept, px; guards against damaged headers. */
#define IMAGE_MAX_SIDE 65535

#endif
