/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of exr/ share. */
#ifndef RF_EXR_PRIVATE_H
#define RF_EXR_PRIVATE_H

#include <stddef.h>

#include <openexr.h>

#include "image.h"
#include "replace.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "EXR stores little-endian samples and this code copies them as they are"
#endif

/* An input is opened once and only read from then on; threads may share it. */
struct image_input {
    exr_context_t context;
    char *path;
    int fd;
    int64_t size_bytes;
    int n_parts, n_channels;
    struct image_part_info *parts;
    struct image_channel_info *channels;
    int *first_channel; /* of each part, n_parts + 1: where the next part's start */
};

/* Always false, so that `return image_fail(...)` reads as what it does. */
__attribute__((format(printf, 3, 4))) bool
image_fail(struct image_error *error, const char *path, const char *format, ...);

/* The same where memory lacks. */
bool image_lacks_memory(struct image_error *error, const char *path);

/*
 * OpenEXRCore reports through a callback. It runs on the thread that called the core,
 * so the text is kept per thread: clear, call, and ask for the first message (later
 * ones only say that the caller of the caller failed too). `fallback` is the result.
 */
void image_core_clear(void);
const char *image_core_message(exr_result_t fallback);
/*
 * Did it say since the last clear that it had no memory? OpenEXRCore 3.1 may return
 * success all the same and give its own values for what it did not keep.
 */
bool image_core_lacked_memory(void);
/* Number of a compression that OpenEXRCore did not know since then, or -1: it reports
 * such a one and goes on as if it were ZIP. */
int image_core_unknown_compression(void);
/* For exr_context_initializer_t. */
void image_core_on_error(exr_const_context_t context, exr_result_t code,
                         const char *message);

/* The name that the file format documents use: "zip"; NULL for an unknown number. */
const char *image_compression_name(int compression);
/* -1 for an unknown name. */
int image_compression_number(const char *name);
bool image_is_lossy(int compression);

/* Is the word in the list, which NULL ends? Case does not matter. */
bool image_is_one_of(const char *word, const char *const *list);

/* What the name of a layer says of it (layer_names.c): the picture itself; that and, for
 * a part, nothing more than a plain R G B; data, such as albedo, normals, identifiers. */
bool image_means_picture(const char *name);
bool image_means_plain(const char *name);
bool image_means_data(const char *name);
bool image_means_identifiers(const char *name);
/* Speaks of a depth, but of its variance, of numbers of things, of depth of field. */
bool image_means_no_depth(const char *name);

/*
 * A run of samples of one channel as stored, little-endian, unaligned: `n` samples from
 * column x of row y of the channel, both counted from the data window's corner, in
 * samples (so in steps of the sampling for sub-sampled channels). May be called on
 * several threads at once, for different places.
 */
typedef void (*image_run_fn)(void *user, int channel_in_part, int32_t x, int32_t y,
                             int32_t n, const uint8_t *samples);

/*
 * Decodes the chunks of a part (of its full level) that hold these rows; `run` gets all
 * rows of those chunks. Deep parts fail.
 */
bool image_decode_rows(struct image_input *input, int part, struct image_rows rows,
                       image_run_fn run, void *user, int n_threads,
                       struct image_error *error);

/* Refuses headers with more attributes, channels or parts than can be read in time. */
bool image_scan_header(const struct image_input *input, struct image_error *error);

/* How a part is cut into chunks: those of the full level where it is tiled. */
struct image_chunks {
    int n_chunks;
    int lines_per_chunk;         /* scan lines */
    int tile_width, tile_height; /* tiles */
    int n_tiles_x;               /* 0: scan lines */
};

bool image_plan_chunks(const struct image_input *input, int part,
                       struct image_chunks *chunks, struct image_error *error);
/* Sets all fields; those that mean nothing for this kind of part to 0. */
exr_result_t image_find_chunk(const struct image_input *input, int part,
                              const struct image_chunks *chunks, int index,
                              exr_chunk_info_t *chunk);

/* No chunk of this compression is smaller than its pixels by more than this. */
uint32_t image_max_ratio(int compression);

/* Undoes DWAA and DWAB, which OpenEXRCore does not before 3.2 (IMAGE_UNDO_DWA); a
 * decompress_fn. */
exr_result_t image_undo_dwa(exr_decode_pipeline_t *pipeline);

/* Sets output->attributes on a part. */
exr_result_t image_set_attributes(exr_context_t to, int part,
                                  const struct image_output *output);
/*
 * Copies what is not structure (channels, windows, ...) from a part of output->like.
 * Names in output->attributes are skipped for like_part, where image_set_attributes
 * sets them, and get the new value in the others, so that no stale one is left to be
 * found.
 */
exr_result_t image_copy_attributes(exr_context_t to, int part,
                                   const struct image_output *output, int like_part);

/* One attribute, under its own name. */
exr_result_t image_copy_attribute(exr_context_t to, int part, const exr_attribute_t *a);

/* ---- exr_alike.c ----------------------------------------------------------------- */

/* False, with nothing filled, where the part has none. */
bool image_find_chromaticities(const struct image_input *input, int part,
                               float values[8]);

/* Are the parts of a file alike? OpenEXRCore refuses others since 3.3 only. */
bool image_check_parts(const struct image_input *input, struct image_error *error);

/* Attributes that are alike in all parts of a file, without those of the structure. */
enum { IMAGE_N_ALIKE = 3 };
extern const char *const image_alike_names[IMAGE_N_ALIKE + 1]; /* NULL at its end */

/* Their values for files that are joined to one; NULL: none has it. */
struct image_alike {
    const exr_attribute_t *values[IMAGE_N_ALIKE];
};

/*
 * Can the first parts of n files stand in one file? Then the values that count for all:
 * those of the first that has them.
 */
bool image_plan_alike(struct image_input *const *inputs, int n,
                      struct image_alike *alike, struct image_error *error);
exr_result_t image_set_alike(exr_context_t to, int part,
                             const struct image_alike *alike);

/* Is `name` in output->dropped? */
bool image_is_dropped(const struct image_output *output, const char *name);

/* Fills exactly n_out values; false for damaged data. */
bool image_undo_huffman(const uint8_t *in, size_t n_in, uint16_t *out, size_t n_out);

int image_sample_bytes(enum image_sample_type type);
float image_half_to_float(uint16_t half);
/* To nearest even; finite values beyond the range become +-65504, not infinity. */
uint16_t image_float_to_half(float value);
/* Runs of halves as stored, unaligned; the floats lie `stride` floats apart. */
void image_halves_to_floats(float *out, size_t stride, const uint8_t *halves, size_t n);
void image_floats_to_halves(uint8_t *halves, const float *in, size_t stride, size_t n);
/* Does this processor convert halves itself? */
bool image_has_f16c(void);

/* n stored samples to floats, `stride` floats apart. */
void image_convert_run(float *out, size_t stride, enum image_sample_type type,
                       int32_t n, const uint8_t *samples);

/* os_replace_*() with words in place of numbers; messages name `path`. */
bool partial_open(struct os_replace *file, const char *path, struct image_error *error);
bool partial_commit(struct os_replace *file, const char *path,
                    struct image_error *error);
/* The words for an errno; always false. */
bool partial_fail(const char *path, int number, struct image_error *error);

#endif
