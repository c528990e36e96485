/* SPDX-License-Identifier: Apache-2.0 */
#include "commands/frames_print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/text_file.h"
#include "console/cli.h"
#include "console/json.h"
#include "folder.h"
#include "interrupt.h"
#include "pages/html.h"
#include "path.h"
#include "rackfocus/rackfocus.h"
#include "sources/picture.h"

/* ---- text ----------------------------------------------------------------------- */

static void print_sum(const struct frames_report *report)
{
    printf("%d frame%s:", report->n, report->n == 1 ? "" : "s");
    for (int i = 0; i < FRAME_N_VERDICTS; i++) {
        const int n = frames_report_count(report, (enum frame_verdict)i);
        if (n > 0 || i == FRAME_FINISHED)
            printf("%s %d %s", i > 0 ? "," : "", n,
                   frame_verdict_word((enum frame_verdict)i));
    }
    printf("\n");
}

void frames_print_text(const struct frames_report *report,
                       const struct command_line *line, bool is_quiet)
{
    for (int i = 0; i < report->n; i++) {
        const struct frame_check *frame = &report->frames[i];
        if (frame->verdict != FRAME_FINISHED)
            message("frame %d: %s: %s; %s", (int)frame->number,
                    frame_verdict_word(frame->verdict), frame->path ? frame->path : "",
                    frame->why);
    }
    if (is_quiet)
        return;
    print_sum(report);
    char *open = frames_report_open_list(report);
    if (open && *open && line->command) {
        const size_t n_bytes = strlen(open) + sizeof("--frames ");
        char *added = app_memory(n_bytes, 1, NULL);
        if (added) {
            snprintf(added, n_bytes, "--frames %s", open);
            printf("to make them: rackfocus");
            command_line_print(stdout, line, "frames", added);
            printf("\n");
        }
        free(added);
    }
    free(open);
}

/* ---- JSON ----------------------------------------------------------------------- */

static void print_frame(struct json *json, const struct frame_check *frame)
{
    json_open(json, NULL, '{');
    json_number(json, "frame", frame->number);
    json_text(json, "verdict", frame_verdict_word(frame->verdict));
    json_text(json, "file", frame->path ? frame->path : "");
    if (frame->why[0])
        json_text(json, "why", frame->why);
    if (frame->host[0]) {
        json_text(json, "host", frame->host);
        json_number(json, "process", (double)frame->process);
        json_number(json, "date", frame->date_s);
        json_number(json, "seconds", frame->seconds);
    }
    if (frame->made[0])
        json_text(json, "made", frame->made);
    if (frame->has_radii) {
        json_open(json, "radii_px", '[');
        json_number(json, NULL, frame->least_radius_px);
        json_number(json, NULL, frame->most_radius_px);
        json_close(json, ']');
    }
    json_number(json, "warnings", frame->n_warnings);
    if (frame->warning[0])
        json_text(json, "warning", frame->warning);
    json_close(json, '}');
}

void frames_print_json(const struct frames_report *report)
{
    struct json json = {0};
    json_open(&json, NULL, '{');
    json_number(&json, "n_frames", report->n);
    for (int i = 0; i < FRAME_N_VERDICTS; i++)
        json_number(&json, frame_verdict_word((enum frame_verdict)i),
                    frames_report_count(report, (enum frame_verdict)i));
    json_open(&json, "frames", '[');
    for (int i = 0; i < report->n; i++)
        print_frame(&json, &report->frames[i]);
    json_close(&json, ']');
    json_close(&json, '}');
}

/* ---- the page ------------------------------------------------------------------- */

/* The mean of blocks of `step` x `step` pixels, in place. */
static void shrink(struct picture *picture, int32_t step)
{
    const int32_t width = picture->width / step, height = picture->height / step;
    for (int32_t y = 0; y < height; y++)
        for (int32_t i = 0; i < 3 * width; i++) {
            double sum = 0;
            for (int32_t k = 0; k < step * step; k++) {
                const size_t row = (size_t)y * (size_t)step + (size_t)(k / step);
                const size_t column =
                    (size_t)(i / 3) * (size_t)step + (size_t)(k % step);
                sum += picture->samples[3 * (row * (size_t)picture->width + column) +
                                        (size_t)(i % 3)];
            }
            /* Rows that are read stand behind those that are written. */
            picture->samples[3 * (size_t)y * (size_t)width + (size_t)i] =
                (float)(sum / (step * step));
        }
    picture->width = width;
    picture->height = height;
}

/* Writes a frame's picture, small, if it can be read; `is_there` says whether. False
 * where it cannot be written. */
static bool write_small(const struct frame_check *frame, const char *path,
                        bool *is_there, struct image_error *error)
{
    enum { SMALL_WIDTH = 240 };
    struct picture picture;
    *is_there = picture_read(frame->path, NULL, 1, &picture, error);
    if (!*is_there)
        return app_code_of(error) != APP_NO_MEMORY;
    const int32_t longest =
        picture.width > picture.height ? picture.width : picture.height;
    const int32_t step = longest / SMALL_WIDTH, least = picture.width < picture.height
                                                            ? picture.width
                                                            : picture.height;
    if (step > 1 && step <= least)
        shrink(&picture, step);
    const bool is_written = image_write_png(path, picture.samples, picture.width,
                                            picture.height, 3, 8, false, error);
    picture_free(&picture);
    return is_written;
}

static void print_cell(FILE *file, const struct frame_check *frame, const char *folder,
                       const char *small)
{
    fprintf(file, "<figure class=\"%s\">", frame_verdict_word(frame->verdict));
    if (small) {
        fputs("<img loading=\"lazy\" alt=\"\" src=\"", file);
        html_print_address(file, os_path_name(folder));
        fprintf(file, "/%s\">", small);
    }
    fprintf(file, "<figcaption><b>%d</b> %s", (int)frame->number,
            frame_verdict_word(frame->verdict));
    if (frame->seconds > 0)
        fprintf(file, ", %.2f s", frame->seconds);
    if (frame->host[0]) {
        fputs(" on ", file);
        html_print(file, frame->host);
    }
    if (frame->has_radii)
        fprintf(file, "<br>radii %.1f to %.1f px", frame->least_radius_px,
                frame->most_radius_px);
    if (frame->why[0]) {
        fputs("<br>", file);
        html_print(file, frame->why);
    }
    if (frame->n_warnings) {
        fprintf(file, "<br>%d warning%s: ", (int)frame->n_warnings,
                frame->n_warnings == 1 ? "" : "s");
        html_print(file, frame->warning);
    }
    fputs("</figcaption></figure>\n", file);
}

static void print_head(FILE *file, const struct frames_report *report)
{
    double total_s = 0, longest_s = 0;
    for (int i = 0; i < report->n; i++) {
        total_s += report->frames[i].seconds;
        longest_s = fmax(longest_s, report->frames[i].seconds);
    }
    fprintf(file,
            "<!DOCTYPE html>\n<meta charset=\"utf-8\"><title>%d frames</title>\n"
            "<style>body{font:14px sans-serif;background:#222;color:#ddd}"
            "figure{display:inline-block;width:250px;margin:4px;vertical-align:top}"
            "img{max-width:240px}figure:not(.finished){outline:2px solid #c33}"
            "figcaption{overflow-wrap:anywhere}</style>\n<h1>",
            report->n);
    for (int i = 0; i < FRAME_N_VERDICTS; i++) {
        const int n = frames_report_count(report, (enum frame_verdict)i);
        if (n > 0 || i == FRAME_FINISHED)
            fprintf(file, "%s%d %s", i > 0 ? ", " : "", n,
                    frame_verdict_word((enum frame_verdict)i));
    }
    fprintf(file,
            "</h1>\n<p>%.1f s of all frames, the longest %.2f s. rackfocus %s</p>\n",
            total_s, longest_s, rf_version());
}

struct page {
    const struct frames_report *report;
    char *folder;      /* of the small pictures */
    bool *has_picture; /* for each frame */
};

/* "12.png". */
struct small_name {
    char text[32];
};

static struct small_name name_small(const struct frame_check *frame)
{
    struct small_name name;
    snprintf(name.text, sizeof name.text, "%d.png", (int)frame->number);
    return name;
}

/* A picture that cannot be read has no place in the sheet; its words say why. False where one
 * cannot be written, or when interrupted. */
static bool write_pictures(const struct page *page, struct image_error *error)
{
    const size_t n_path = strlen(page->folder) + sizeof(struct small_name) + 1;
    char *path = app_memory(n_path, 1, error);
    bool is_good = path != NULL;
    for (int i = 0; i < page->report->n && is_good && !os_is_interrupted(); i++) {
        const struct frame_check *frame = &page->report->frames[i];
        if (frame->path && frame->verdict != FRAME_MISSING) {
            snprintf(path, n_path, "%s/%s", page->folder, name_small(frame).text);
            is_good = write_small(frame, path, &page->has_picture[i], error);
        }
    }
    free(path);
    return is_good && !os_is_interrupted();
}

static void print_page(FILE *file, const void *data)
{
    const struct page *page = data;
    print_head(file, page->report);
    for (int i = 0; i < page->report->n; i++) {
        const struct frame_check *frame = &page->report->frames[i];
        print_cell(file, frame, page->folder,
                   page->has_picture[i] ? name_small(frame).text : NULL);
    }
}

bool frames_write_html(const struct frames_report *report, const char *path,
                       struct image_error *error)
{
    struct page page = {report, html_make_folder(path, "_frames", error), NULL};
    if (page.folder)
        page.has_picture =
            app_memory((size_t)report->n, sizeof(*page.has_picture), error);
    const bool is_good = page.has_picture && write_pictures(&page, error) &&
                         text_file_write(path, print_page, &page, error);
    if (is_good)
        os_folder_keep(page.folder);
    free(page.has_picture);
    free(page.folder);
    return is_good;
}
