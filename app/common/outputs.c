/* SPDX-License-Identifier: Apache-2.0 */
#include "common/outputs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "file.h"

/* "--output-coc" of "output_coc"; "the input". */
static void print_option(const struct output_file *file, char *text, size_t n_bytes)
{
    snprintf(text, n_bytes, "%s%s", file->option ? "--" : "the input",
             file->option ? file->option : "");
    for (char *at = text; *at; at++)
        if (*at == '_')
            *at = '-';
}

/* The paths are those of the files, or of a frame. */
static void check_paths(struct outputs *outputs, const struct output_file *output,
                        const char *output_path, const struct output_file *other,
                        const char *other_path)
{
    char name[64], other_name[64];
    if (!os_file_is_same(output_path, other_path))
        return;
    print_option(output, name, sizeof(name));
    print_option(other, other_name, sizeof(other_name));
    outputs->code =
        app_fail(outputs->error, APP_USAGE,
                 "%s: '%s' is also %s '%s', which it would replace; give it another "
                 "name",
                 name, output_path, other_name, other_path);
}

static void check_frame(struct outputs *outputs, const struct output_file *output,
                        const struct output_file *other, int32_t number)
{
    char *output_path = frame_name(output->path, number, outputs->error);
    char *other_path = frame_name(other->path, number, outputs->error);
    if (output_path && other_path)
        check_paths(outputs, output, output_path, other, other_path);
    else
        outputs->code = APP_NO_MEMORY;
    free(output_path);
    free(other_path);
}

static void check_pair(struct outputs *outputs, const struct output_file *output,
                       const struct output_file *other)
{
    const struct frame_list *frames = outputs->frames;
    if (outputs->code == APP_DONE)
        check_paths(outputs, output, output->path, other, other->path);
    for (int i = 0; frames && i < frames->n && outputs->code == APP_DONE; i++)
        check_frame(outputs, output, other, frames->numbers[i]);
}

void outputs_add(struct outputs *outputs, const char *option, const char *path)
{
    const struct output_file file = {option, path};
    if (!path)
        return;
    for (int i = 0; i < outputs->n; i++)
        check_pair(outputs, &file, &outputs->files[i]);
    outputs->files[outputs->n++] = file;
}

void outputs_spare(struct outputs *outputs, const char *option, const char *path)
{
    const struct output_file file = {option, path};
    for (int i = 0; path && i < outputs->n; i++)
        check_pair(outputs, &outputs->files[i], &file);
}

void outputs_spare_list(struct outputs *outputs, const char *option, const char *paths)
{
    char path[4096];
    for (const char *at = paths; at && *at;) {
        const size_t length = strcspn(at, ",");
        snprintf(path, sizeof(path), "%.*s", (int)length, at);
        outputs_spare(outputs, option, path);
        at += length + (at[length] == ',');
    }
}
