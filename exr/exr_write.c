/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes OpenEXR files.
 *
 * The file is planned as a list of parts. A part is either copied, chunk by chunk as
 * compressed in the input (this keeps tiles, mip-map levels, deep data and lossy
 * compression bit for bit), or made anew as scan lines or tiles of one level, from new
 * samples and from channels of the input that are kept as stored. Either all rows of a
 * made part are in memory, or a strip of them at a time.
 */
#include "exr_writer.h"

#include <stdlib.h>

static bool finish_context(struct writer *w, bool is_good)
{
    if (!w->context)
        return is_good;
    image_core_clear();
    exr_result_t result = exr_finish(&w->context);
    return is_good && (result == EXR_ERR_SUCCESS || writer_fail(w, result));
}

static bool write_planned(struct writer *w)
{
    bool is_good = writer_write_header(w) && writer_write_parts(w, 0, w->n_parts);
    return finish_context(w, is_good);
}

static bool end_file(struct writer *w, bool is_good)
{
    writer_free_plan(w);
    if (is_good)
        return partial_commit(&w->file, w->path, w->error);
    os_replace_abort(&w->file);
    return false;
}

bool image_write(const char *path, const struct image_output *output, int n_threads,
                 struct image_error *error)
{
    struct writer w = {
        .output = output,
        .path = path,
        .n_threads = n_threads < 1 ? 1 : n_threads,
        .error = error,
    };
    if (!output->samples)
        return image_fail(error, path, "no channel to write");
    if (!writer_check(output, path, error) || !partial_open(&w.file, path, error))
        return false;
    return end_file(&w, writer_plan(&w) && write_planned(&w));
}

/* ---- strip by strip ------------------------------------------------------------- */

struct image_writer {
    struct writer w;
    int target; /* the part that the strips belong to */
    int32_t next_row;
};

/* Header and parts before the target. */
static bool begin_file(struct image_writer *writer)
{
    struct writer *w = &writer->w;
    if (!writer_plan(w))
        return false;
    while (w->parts[writer->target].like_part >= 0 &&
           w->parts[writer->target].like_part != w->output->like_part)
        writer->target++;
    return writer_write_header(w) && writer_write_parts(w, 0, writer->target) &&
           writer_find_file_order(w, writer->target);
}

bool image_write_begin(struct image_writer **writer, const char *path,
                       const struct image_output *output, int n_threads,
                       struct image_error *error)
{
    *writer = NULL;
    if (!writer_check(output, path, error))
        return false;
    struct image_writer *new = calloc(1, sizeof *new);
    if (!new)
        return image_lacks_memory(error, path);
    new->w = (struct writer){
        .output = output,
        .path = path,
        .n_threads = n_threads < 1 ? 1 : n_threads,
        .error = error,
    };
    if (!partial_open(&new->w.file, path, error)) {
        free(new);
        return false;
    }
    if (!begin_file(new)) {
        image_write_abort(new);
        return false;
    }
    *writer = new;
    return true;
}

int32_t image_write_step(const struct image_writer *writer)
{
    return writer_row_step(&writer->w, writer->target);
}

bool image_write_rows(struct image_writer *writer, int32_t n_rows, const float *samples,
                      struct image_error *error)
{
    struct writer *w = &writer->w;
    const int32_t left = writer_height(&w->parts[writer->target]) - writer->next_row;
    w->error = error;
    if (n_rows < 1 || n_rows > left ||
        (n_rows < left && n_rows % image_write_step(writer) != 0))
        return image_fail(error, w->path,
                          "a strip of %d rows with %d left; strips are multiples of %d "
                          "rows, but for the last",
                          (int)n_rows, (int)left, (int)image_write_step(writer));
    if (!writer_make_rows(w, writer->target,
                          (struct image_rows){writer->next_row, n_rows}, samples))
        return false;
    writer->next_row += n_rows;
    return true;
}

bool image_write_finish(struct image_writer *writer, struct image_error *error)
{
    struct writer *w = &writer->w;
    const int32_t left = writer_height(&w->parts[writer->target]) - writer->next_row;
    w->error = error;
    bool is_good = left == 0;
    if (!is_good)
        image_fail(error, w->path, "the last %d rows are missing", (int)left);
    is_good = is_good && writer_write_parts(w, writer->target + 1, w->n_parts);
    is_good = end_file(w, finish_context(w, is_good));
    free(writer);
    return is_good;
}

void image_write_abort(struct image_writer *writer)
{
    struct image_error ignored;
    if (!writer)
        return;
    writer->w.error = &ignored;
    finish_context(&writer->w, false);
    end_file(&writer->w, false);
    free(writer);
}

/* ---- several files joined to one ------------------------------------------------ */

/* Part i of the file is the first of input i. */
static bool plan_joined(struct writer *w, struct image_input *const *inputs,
                        const char *const *views, struct image_output *outputs,
                        struct image_attribute *attributes, struct image_alike *alike)
{
    for (int i = 0; i < w->n_parts; i++) {
        if (inputs[i]->n_parts != 1 || inputs[i]->parts[0].is_deep)
            return image_fail(
                w->error, w->path,
                "%s has several parts or deep data; a view is one flat one",
                image_path(inputs[i]));
        attributes[i] = (struct image_attribute){
            .name = "view", .type = IMAGE_ATTRIBUTE_STRING, .text = views[i]};
        outputs[i] = (struct image_output){.like = inputs[i],
                                           .attributes = &attributes[i],
                                           .n_attributes = 1,
                                           .dropped = image_alike_names};
        struct out_part *part = &w->parts[i];
        *part = (struct out_part){
            .output = &outputs[i], .name = views[i], .alike = alike, .is_copied = true};
        writer_plan_windows(&outputs[i], part);
        part->compression = image_compression_number(inputs[i]->parts[0].compression);
    }
    return image_plan_alike(inputs, w->n_parts, alike, w->error);
}

bool image_join_views(const char *path, struct image_input *const *inputs,
                      const char *const *views, int n, struct image_error *error)
{
    struct writer w = {.path = path, .n_threads = 1, .error = error, .n_parts = n};
    struct image_output *outputs = calloc((size_t)n, sizeof *outputs);
    struct image_attribute *attributes = calloc((size_t)n, sizeof *attributes);
    struct image_alike alike;
    w.parts = calloc((size_t)n, sizeof *w.parts);
    bool is_good = outputs && attributes && w.parts;
    if (!is_good)
        image_lacks_memory(error, path);
    if (is_good && partial_open(&w.file, path, error))
        is_good =
            end_file(&w, plan_joined(&w, inputs, views, outputs, attributes, &alike) &&
                             write_planned(&w));
    else {
        is_good = false;
        writer_free_plan(&w);
    }
    free(attributes);
    free(outputs);
    return is_good;
}
