/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PNG: for looking at, and for `compare`. libpng jumps out of its functions on errors,
 * so everything it needs to free lies in one struct that outlives the jump.
 */
#include "exr_private.h"

#include <errno.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <png.h>

#include "file.h"
#include "png_rows.h"

/* zlib cannot shrink by more than this; a header that claims more is damaged. */
enum { MAX_ZLIB_RATIO = 1040 };

struct png_work {
    png_structp png;
    png_infop info;
    FILE *stream;
    png_bytep row;
    char message[256];
    bool lacks_memory;
    jmp_buf on_error;
};

static void keep_error(png_structp png, png_const_charp message)
{
    struct png_work *work = png_get_error_ptr(png);
    snprintf(work->message, sizeof work->message, "%s", message);
    longjmp(work->on_error, 1);
}

static void ignore_warning(png_structp png, png_const_charp message)
{
}

static bool write_stream(struct png_work *work, const float *samples, int32_t width,
                         int32_t height, int n_channels, int bits, bool is_encoded)
{
    static const int color_types[] = {0, PNG_COLOR_TYPE_GRAY, 0, PNG_COLOR_TYPE_RGB,
                                      PNG_COLOR_TYPE_RGBA};
    work->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, work, keep_error,
                                        ignore_warning);
    work->info = work->png ? png_create_info_struct(work->png) : NULL;
    work->row = malloc((size_t)width * (size_t)n_channels * (size_t)bits / 8);
    if (!work->info || !work->row) {
        errno = ENOMEM;
        return false;
    }
    if (setjmp(work->on_error))
        return false;
    png_init_io(work->png, work->stream);
    png_set_IHDR(work->png, work->info, (png_uint_32)width, (png_uint_32)height, bits,
                 color_types[n_channels], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_BASE,
                 PNG_FILTER_TYPE_BASE);
    if (!is_encoded)
        png_set_sRGB(work->png, work->info, PNG_sRGB_INTENT_RELATIVE);
    png_write_info(work->png, work->info);
    for (int32_t y = 0; y < height; y++) {
        const float *in = samples + (size_t)y * (size_t)width * (size_t)n_channels;
        png_encode_row(in, width, n_channels, bits, is_encoded, work->row);
        png_write_row(work->png, work->row);
    }
    png_write_end(work->png, work->info);
    return true;
}

bool image_write_png(const char *path, const float *samples, int32_t width,
                     int32_t height, int n_channels, int bits, bool is_encoded,
                     struct image_error *error)
{
    struct os_replace file;
    struct png_work work = {0};
    if (width < 1 || height < 1 || n_channels < 1 || n_channels > 4 ||
        n_channels == 2 || (bits != 8 && bits != 16))
        return image_fail(error, path,
                          "cannot write a PNG of %d x %d px, %d channels, %d bits",
                          (int)width, (int)height, n_channels, bits);
    if (!partial_open(&file, path, error))
        return false;
    work.stream = os_replace_stream(&file);
    bool is_good = work.stream && write_stream(&work, samples, width, height,
                                               n_channels, bits, is_encoded);
    int write_errno = errno;
    png_destroy_write_struct(&work.png, &work.info);
    free(work.row);
    if (work.stream && fclose(work.stream) != 0 && is_good) {
        is_good = false;
        write_errno = errno;
    }
    if (is_good)
        return partial_commit(&file, path, error);
    os_replace_abort(&file);
    return partial_fail(path, write_errno ? write_errno : EIO, error);
}

/* Header, checks and the transformations to 8 or 16 bit RGBA. */
static void read_header(struct png_work *work, int64_t file_bytes)
{
    png_init_io(work->png, work->stream);
    png_set_user_limits(work->png, IMAGE_MAX_SIDE, IMAGE_MAX_SIDE);
    png_read_info(work->png, work->info);
    uint64_t n_bytes = (uint64_t)png_get_rowbytes(work->png, work->info) *
                       png_get_image_height(work->png, work->info);
    if (n_bytes / MAX_ZLIB_RATIO > (uint64_t)file_bytes)
        png_error(work->png, "the picture does not fit into the file");
    png_set_expand(work->png);
    png_set_gray_to_rgb(work->png);
    png_set_add_alpha(work->png, 0xffff, PNG_FILLER_AFTER);
    png_set_interlace_handling(work->png);
    png_read_update_info(work->png, work->info);
}

/* The picture as bytes, because interlaced files come in several passes. */
static bool read_stream(struct png_work *work, int64_t file_bytes, float **samples,
                        int32_t *width, int32_t *height)
{
    work->png =
        png_create_read_struct(PNG_LIBPNG_VER_STRING, work, keep_error, ignore_warning);
    work->info = work->png ? png_create_info_struct(work->png) : NULL;
    if (!work->info) {
        work->lacks_memory = true;
        return false;
    }
    if (setjmp(work->on_error))
        return false;
    read_header(work, file_bytes);
    *width = (int32_t)png_get_image_width(work->png, work->info);
    *height = (int32_t)png_get_image_height(work->png, work->info);
    int bits = png_get_bit_depth(work->png, work->info);
    size_t n_row_bytes = png_get_rowbytes(work->png, work->info);
    size_t n_rows = (size_t)*height;
    work->row = calloc(n_rows, n_row_bytes);
    *samples = malloc(n_rows * (size_t)*width * 4 * sizeof **samples);
    work->lacks_memory = !work->row || !*samples;
    if (work->lacks_memory)
        return false;
    int n_passes = png_set_interlace_handling(work->png);
    for (int pass = 0; pass < n_passes; pass++)
        for (size_t y = 0; y < n_rows; y++)
            png_read_row(work->png, work->row + y * n_row_bytes, NULL);
    png_read_end(work->png, NULL);
    for (size_t y = 0; y < n_rows; y++)
        png_decode_row(work->row + y * n_row_bytes, *width, bits,
                       *samples + y * (size_t)*width * 4);
    return true;
}

bool image_read_png(const char *path, float **samples, int32_t *width, int32_t *height,
                    struct image_error *error)
{
    struct png_work work = {0};
    unsigned char signature[8];
    *samples = NULL;
    const struct os_file_facts facts = os_file_facts(path);
    if (facts.kind == OS_FILE_OTHER)
        return image_fail(error, path, "is no regular file");
    work.stream = fopen(path, "rb");
    if (!work.stream)
        return image_fail(error, path, "%s", strerror(errno));
    bool is_png =
        fread(signature, 1, 8, work.stream) == 8 && png_sig_cmp(signature, 0, 8) == 0;
    rewind(work.stream);
    bool is_good = is_png && read_stream(&work, facts.n_bytes, samples, width, height);
    png_destroy_read_struct(&work.png, &work.info, NULL);
    free(work.row);
    fclose(work.stream);
    if (is_good)
        return true;
    free(*samples);
    *samples = NULL;
    if (!is_png)
        return image_fail(error, path, "is not a PNG file");
    if (work.lacks_memory)
        return image_lacks_memory(error, path);
    return image_fail(error, path, "damaged: %s", work.message);
}
