/* SPDX-License-Identifier: Apache-2.0 */
#include "pages/methods_sheet.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "console/cli.h"
#include "rackfocus/rackfocus.h"

/* px */
enum {
    MARGIN = 24,
    GAP = 6,
    HEADING_WIDTH = 220, /* of the column of the generators */
    TITLE_HEIGHT = 100,
    BLENDS_HEIGHT = 56, /* the line of the blends */
    NAMES_HEIGHT = 48,  /* name and figures over a picture */
    MAX_PICTURE = 480,  /* longest side of a picture */
    MIN_CELL = 400,     /* what the figures need */
    TITLE_PX = 32,
    NAME_PX = 20,
    TEXT_PX = 15,
};

#define PAPER 0.11f
#define INK 0.95f
#define PALE 0.68f

static const float detail_colours[N_DETAILS][3] = {{0.35f, 0.85f, 1}, {1, 0.75f, 0.2f}};

/* ---- the plan -------------------------------------------------------------------- */

static void set_sizes(struct methods_sheet *s, const struct methods_subject *subject)
{
    const int32_t width = subject->width, height = subject->height;
    const int32_t longest = width > height ? width : height;
    const double scale = longest > MAX_PICTURE ? (double)MAX_PICTURE / longest : 1;
    s->picture_width = (int32_t)fmax(lround(width * scale), 1);
    s->picture_height = (int32_t)fmax(lround(height * scale), 1);
    s->cell_width = s->picture_width > MIN_CELL ? s->picture_width : MIN_CELL;
    /* Below the picture: the error at half the size and two details. */
    s->strip_height = (s->picture_height + 1) / 2;
}

static int32_t detail_width(const struct methods_sheet *s)
{
    return (s->cell_width - (s->picture_width + 1) / 2 - N_DETAILS * GAP) / N_DETAILS;
}

void methods_sheet_detail_size(const struct methods_subject *subject, int32_t *width,
                               int32_t *height)
{
    struct methods_sheet sized = {0};
    set_sizes(&sized, subject);
    *width = detail_width(&sized);
    *height = sized.strip_height;
}

/* Does it stand in the row of its generator? With one blend all stand side by side. */
static bool has_row(const struct methods_sheet *s, const struct methods_entry *entry)
{
    return s->n_blends > 1 && entry->method >= 0 &&
           rf_method_find(entry->method)->has_blend;
}

static int count_blends(const struct methods_entry *entries, int n)
{
    unsigned seen = 0, n_seen = 0;
    for (int i = 0; i < n; i++)
        if (entries[i].method >= 0 && rf_method_find(entries[i].method)->has_blend)
            seen |= 1u << entries[i].blend;
    for (; seen; seen &= seen - 1)
        n_seen++;
    return (int)n_seen;
}

static int32_t row_height(const struct methods_sheet *s)
{
    return NAMES_HEIGHT + s->picture_height + GAP + s->strip_height + MARGIN;
}

/* Rows: the top, the methods without a blend, a generator each. */
static int plan_rows(struct methods_sheet *s, const struct methods_entry *entries,
                     int n)
{
    const struct rf_param_info *blends = rf_param_find("blend");
    int n_plain = 0, n_generators = 0;
    s->n_columns = blends->n_choices > 3 ? blends->n_choices : 3;
    s->n_blends = count_blends(entries, n);
    for (int i = 0; i < n; i++)
        n_plain += entries[i].method >= 0 && !has_row(s, &entries[i]);
    s->n_plain_rows = (n_plain + s->n_columns - 1) / s->n_columns;
    for (int i = 0; i < n; i++)
        if (has_row(s, &entries[i]) && !s->generator_rows[entries[i].method])
            s->generator_rows[entries[i].method] = 1 + s->n_plain_rows + n_generators++;
    return 1 + s->n_plain_rows + n_generators;
}

static int32_t row_top(const struct methods_sheet *s, int row)
{
    return TITLE_HEIGHT + row * row_height(s) +
           (row > s->n_plain_rows ? BLENDS_HEIGHT : 0);
}

static int32_t column_left(const struct methods_sheet *s, int column)
{
    return MARGIN + HEADING_WIDTH + column * (s->cell_width + MARGIN);
}

/* ---- headings -------------------------------------------------------------------- */

static void draw_heading(struct methods_sheet *s, int row, const char *name,
                         const char *about, const char *more)
{
    struct canvas_box box = {MARGIN, row_top(s, row) + NAME_PX, HEADING_WIDTH - MARGIN,
                             0};
    canvas_text(&s->canvas, box.x, box.y, NAME_PX, INK, name);
    box.y += NAMES_HEIGHT - NAME_PX + TEXT_PX;
    box.y = canvas_paragraph(&s->canvas, box, TEXT_PX, PALE, about) + GAP;
    canvas_paragraph(&s->canvas, box, TEXT_PX, PALE, more);
}

static void draw_blends(struct methods_sheet *s)
{
    const struct rf_param_info *blends = rf_param_find("blend");
    const int32_t y = row_top(s, s->n_plain_rows + 1) - BLENDS_HEIGHT + NAME_PX;
    for (int b = 0; b < blends->n_choices; b++) {
        const int32_t x = column_left(s, b);
        char name[96];
        snprintf(name, sizeof name, "blend %s", blends->choices[b].name);
        canvas_text(&s->canvas, x, y, NAME_PX, INK, name);
        canvas_text(&s->canvas, x, y + NAME_PX, TEXT_PX, PALE, blends->choices[b].help);
    }
}

/* The colours of the error with their values, in the third column of the top. */
static void draw_scale(struct methods_sheet *s)
{
    enum { BAR_HEIGHT = 24, N_STEPS = 256, N_TICKS = 5 };
    float error[3 * N_STEPS], none[3 * N_STEPS] = {0}, colours[3 * N_STEPS];
    for (int i = 0; i < 3 * N_STEPS; i++)
        error[i] = (float)pow(HEAT_FULL_SCALE * (i / 3) / (N_STEPS - 1), 2.2);
    measure_heatmap(error, none, N_STEPS, 1, colours);
    struct canvas_box box = {column_left(s, 2), row_top(s, 0) + NAMES_HEIGHT,
                             s->cell_width, BAR_HEIGHT};
    const struct canvas_picture bar = {colours, N_STEPS, 1, false};
    canvas_fit(&s->canvas, box, &bar);
    for (int i = 0; i <= N_TICKS; i++) {
        char value[16];
        snprintf(value, sizeof value, "%.2f", HEAT_FULL_SCALE * i / N_TICKS);
        const int32_t width = canvas_text_width(TEXT_PX, value);
        canvas_text(&s->canvas, box.x + i * (box.width - width) / N_TICKS,
                    box.y + BAR_HEIGHT + TEXT_PX + GAP, TEXT_PX, INK, value);
    }
    canvas_text(&s->canvas, box.x, box.y - GAP, TEXT_PX, INK,
                "Error, of the tone mapped values");
    static const char *const lines[] = {
        "Below each picture: its error, and two details one to one, framed in the "
        "reference: an edge of what is in focus, and where the lens changes most.",
        "dB: tPSNR, 40 and more can hardly be told from the reference. FLIP: what the "
        "eye sees when both are shown in turn, 0 is alike. Leak: mean error where "
        "sharp "
        "colours can run out. ms: the filter alone.",
    };
    box.y += BAR_HEIGHT + 3 * TEXT_PX + 2 * GAP;
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
        box.y = canvas_paragraph(&s->canvas, box, TEXT_PX, PALE, lines[i]) + GAP;
}

static void draw_headings(struct methods_sheet *s)
{
    canvas_text(&s->canvas, MARGIN, MARGIN + TITLE_PX, TITLE_PX, INK,
                s->subject->title);
    canvas_text(&s->canvas, MARGIN, MARGIN + 2 * TITLE_PX - GAP, NAME_PX, PALE,
                s->subject->about);
    draw_heading(s, 0, "Pinhole, reference", "what is filtered, and what it should be",
                 "");
    draw_scale(s);
    if (s->n_plain_rows > 0)
        draw_heading(s, 1, "Methods",
                     s->n_blends == 1 ? "all that can be applied, with one blend"
                                      : "that put the picture together themselves",
                     "");
    bool has_generators = false;
    for (size_t m = 0; m < sizeof s->generator_rows / sizeof *s->generator_rows; m++)
        if (s->generator_rows[m]) {
            const struct rf_method_info *method = rf_method_find((int32_t)m);
            char cost[128];
            snprintf(cost, sizeof cost, "Cost: %s", method->cost);
            draw_heading(s, s->generator_rows[m], method->name, method->help, cost);
            has_generators = true;
        }
    if (has_generators)
        draw_blends(s);
}

bool methods_sheet_make(struct methods_sheet *sheet,
                        const struct methods_subject *subject,
                        const struct canvas_box details[N_DETAILS],
                        const struct methods_entry *entries, int n_entries)
{
    *sheet = (struct methods_sheet){.subject = subject};
    set_sizes(sheet, subject);
    memcpy(sheet->details, details, sizeof sheet->details);
    const int n_rows = plan_rows(sheet, entries, n_entries);
    sheet->error = app_memory(3 * (size_t)subject->width * (size_t)subject->height,
                              sizeof *sheet->error, NULL);
    if (!sheet->error ||
        !canvas_make(&sheet->canvas, column_left(sheet, sheet->n_columns),
                     row_top(sheet, n_rows), PAPER))
        return false;
    draw_headings(sheet);
    return true;
}

void methods_sheet_free(struct methods_sheet *sheet)
{
    canvas_free(&sheet->canvas);
    free(sheet->error);
    sheet->error = NULL;
}

/* ---- pictures -------------------------------------------------------------------- */

static void draw_names(struct methods_sheet *s, int32_t x, int32_t y,
                       const struct methods_entry *entry)
{
    char figures[160], time[32] = "";
    canvas_text(&s->canvas, x, y + NAME_PX, NAME_PX, INK,
                entry ? entry->name : "reference");
    if (!entry)
        return;
    methods_time(entry, time, sizeof time);
    int n = snprintf(figures, sizeof figures, "%.1f dB   FLIP %.3f",
                     entry->measures.tpsnr_db, entry->flip);
    if (isfinite(entry->leak_percent))
        n += snprintf(figures + n, sizeof figures - (size_t)n, "   leak %.1f %%",
                      entry->leak_percent);
    snprintf(figures + n, sizeof figures - (size_t)n, "%s%s", *time ? "   " : "", time);
    canvas_text(&s->canvas, x, y + NAME_PX + TEXT_PX + GAP, TEXT_PX, PALE, figures);
}

/* Where the entry stands: row, and column. */
static void find_cell(struct methods_sheet *s, const struct methods_entry *entry,
                      int *row, int *column)
{
    if (!entry || entry->method < 0) {
        *row = 0;
        *column = entry ? 0 : 1;
    } else if (has_row(s, entry)) {
        *row = s->generator_rows[entry->method];
        *column = entry->blend;
    } else {
        *row = 1 + s->n_plain / s->n_columns;
        *column = s->n_plain++ % s->n_columns;
    }
}

/* The box of a detail in the picture as it is shown. */
static struct canvas_box shown_detail(const struct methods_sheet *s, int k,
                                      struct canvas_box picture)
{
    const struct canvas_box box = s->details[k];
    const double scale = (double)s->picture_width / s->subject->width;
    return (struct canvas_box){
        picture.x + (int32_t)(box.x * scale), picture.y + (int32_t)(box.y * scale),
        (int32_t)ceil(box.width * scale), (int32_t)ceil(box.height * scale)};
}

void methods_sheet_put(struct methods_sheet *s, const struct methods_entry *entry,
                       const float *samples, const float *reference)
{
    const int32_t width = s->subject->width, height = s->subject->height;
    const struct canvas_picture picture = {samples, width, height, true};
    const struct canvas_picture error = {s->error, width, height, false};
    int row, column;
    find_cell(s, entry, &row, &column);
    const int32_t x = column_left(s, column), y = row_top(s, row);
    struct canvas_box box = {x, y + NAMES_HEIGHT, s->picture_width, s->picture_height};
    draw_names(s, x, y, entry);
    canvas_fit(&s->canvas, box, &picture);
    for (int k = 0; !entry && k < N_DETAILS; k++)
        canvas_frame(&s->canvas, shown_detail(s, k, box), detail_colours[k]);
    box.y += box.height + GAP;
    box.width = (s->picture_width + 1) / 2;
    box.height = s->strip_height;
    if (entry) {
        measure_heatmap(samples, reference, width, height, s->error);
        canvas_fit(&s->canvas, box, &error);
    }
    box.x += box.width;
    for (int k = 0; k < N_DETAILS; k++) {
        const struct canvas_box *detail = &s->details[k];
        box.x += GAP;
        box.width = detail->width;
        box.height = detail->height;
        canvas_crop(&s->canvas, box, &picture, detail->x, detail->y);
        if (!entry)
            canvas_frame(&s->canvas, box, detail_colours[k]);
        box.x += detail_width(s);
    }
}

bool methods_sheet_write(const struct methods_sheet *sheet, const char *path,
                         struct image_error *error)
{
    return image_write_png(path, sheet->canvas.rgb, sheet->canvas.width,
                           sheet->canvas.height, 3, 8, true, error);
}
