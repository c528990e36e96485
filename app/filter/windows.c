/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A picture larger than memory passes by three times: the depth is measured as a whole
 * one would be, rf_filter_survey() counts what windows must know of the whole, and then
 * strips of rows are read, filtered in windows and written.
 *
 * In memory are the rows that a strip's windows need, whole rows since files hold them
 * so; the strip's result; and one window on its way through the filter. Heights and
 * widths are chosen for the least work that fits: the smaller the windows, the more
 * pixels are filtered for the margins only.
 */
#include "filter/windows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "filter/filter_private.h"
#include "interrupt.h"
#include "sources/picture.h"

enum {
    SURVEY_ROWS = 64,         /* counted at a time */
    SURVEY_COLUMNS = 4096,    /* likewise */
    LEAST_SIDE = 32,          /* of what a window is kept of */
    MOST_ROWS = 4096,         /* of a strip */
    CHUNK_BYTES = 8 << 20,    /* of the file, per thread, coming or going */
    VIEW_BYTES = 2 << 20,     /* of each open file */
    PROGRAM_BYTES = 24 << 20, /* the rest of the program */
    REPAIR_REACH = RF_DEPTH_SNAP_REACH + RF_DEPTH_FILL_REACH /* px */
};

/* How often a pixel is filtered with the margins of windows, where that is quick; more
 * than SLOW is said. Ours: 12, 26 and 150 times take 9, 18 and 98 times as long as a
 * whole picture. */
static const double QUICK = 4, SLOW = 8;

struct rows {
    int32_t first, n, room;
};

struct windows {
    struct run *run;
    const struct source *sources; /* of the views */
    int n_views;
    size_t max_bytes;                        /* to hold at a time */
    struct depth_findings found;             /* of the depth of a lone view */
    char made[4096];                         /* what the filter did */
    struct source_description to;            /* the output but for its samples */
    struct image_writer *writer;             /* NULL: not begun, or ended */
    int32_t width, height, n_channels, step; /* strips end at multiples of step */
    struct rows rows;                        /* in memory, from the first on */
    float *colour[RF_MAX_VIEWS], *depth[RF_MAX_VIEWS]; /* of them, per view */
    float *repaired[RF_MAX_VIEWS]; /* depth of one window; room for n_repaired */
    size_t n_repaired[RF_MAX_VIEWS];
    float *out; /* of one strip */
    struct rf_survey surveys[RF_MAX_VIEWS];
    int32_t kept_width, kept_height; /* of a window */
    double work;                     /* how often a pixel is filtered */
    size_t quick_bytes;              /* for QUICK of that; at most for the whole */
    int64_t n_done, n_windows;
};

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t most(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static size_t least_size(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Bytes as MiB, rounded up. */
static size_t mib_of(size_t n_bytes)
{
    return (n_bytes + (1 << 20) - 1) >> 20;
}

/* Bytes that n views like a source take when they are filtered whole. */
static size_t whole_bytes(const struct source *source, int n_views)
{
    const size_t n = (size_t)n_views, n_more = n > 1 ? n : 0;
    return (size_t)source->width * (size_t)source->height *
               (RF_WINDOW_BYTES_PER_PIXEL + n_more * RF_WINDOW_BYTES_PER_VIEW +
                n * (size_t)(source->n_channels + 1) * sizeof(float)) +
           RF_WINDOW_BYTES;
}

static const struct source *sources_of(const struct run *run)
{
    return run->has_views ? run->views.sources : &run->source;
}

static bool is_possible(const struct source *source, const struct rf_params *params)
{
    return rf_method_find(params->method)->can_window &&
           params->quality != RF_QUALITY_PREVIEW && !source->layer.is_chroma &&
           !(source->is_grey && source->n_channels == 4) &&
           source_has_one_window(source);
}

bool windows_are_possible(const struct run *run)
{
    const struct filter_options *tool = run->tool;
    const bool is_read = !run->has_views || run->views.sources;
    const struct source *sources = is_read ? sources_of(run) : &run->source;
    const int n = is_read ? filter_n_views(run) : 1;
    bool can_be = !run->is_deep && !tool->view && !tool->output_coc && !tool->denoise &&
                  tool->supersample < 2 && !tool->filter_layers &&
                  !seen_is_asked(tool) && picture_kind(tool->output) == PICTURE_EXR;
    for (int i = 0; i < n && can_be; i++)
        can_be = is_possible(&sources[i], &run->settings->params);
    return can_be;
}

bool windows_are_needed(const struct run *run)
{
    const size_t most_bytes = (size_t)run->tool->max_memory_mib << 20;
    return most_bytes && windows_are_possible(run) &&
           whole_bytes(&run->source, filter_n_views(run)) > most_bytes;
}

static int fail_image(const struct windows *w)
{
    return app_code_of(w->run->error);
}

static int fail_core(const struct windows *w, int view, const struct rf_error *error)
{
    const char *path = image_path(w->sources[view].colour);
    if (error->code == RF_ERROR_MEMORY && w->kept_width == 0) /* while it is counted */
        return app_fail(w->run->error, APP_FAILED,
                        "--max-memory: %zu MiB are too few to read %s: %s; allow more",
                        w->max_bytes >> 20, path, error->message);
    if (error->code == RF_ERROR_MEMORY)
        return app_fail(w->run->error, APP_FAILED,
                        "--max-memory: %zu MiB are too few for windows of %d x %d px "
                        "of %s: %s; allow more",
                        w->max_bytes >> 20, (int)w->kept_width, (int)w->kept_height,
                        path, error->message);
    struct rf_error told = *error;
    const size_t n = strlen(told.message);
    if (error->code == RF_ERROR_PARAMETER)
        snprintf(told.message + n, sizeof(told.message) - n,
                 "; allow more by --max-memory, or leave it out");
    return filter_fail_view(w->run, view, &told);
}

/* ---- rows ------------------------------------------------------------------------ */

static int make_room(struct windows *w, int32_t n_rows)
{
    const size_t n = (size_t)w->width * (size_t)n_rows;
    w->rows = (struct rows){0, 0, n_rows};
    for (int j = 0; j < w->n_views; j++) {
        w->colour[j] =
            app_memory(n, (size_t)w->n_channels * sizeof(float), w->run->error);
        w->depth[j] = app_memory(n, sizeof(float), w->run->error);
        if (!w->colour[j] || !w->depth[j])
            return APP_NO_MEMORY;
    }
    return APP_DONE;
}

static void drop_rows(struct windows *w)
{
    for (int j = 0; j < w->n_views; j++) {
        free(w->colour[j]);
        free(w->depth[j]);
        w->colour[j] = w->depth[j] = NULL;
    }
    w->rows = (struct rows){0, 0, 0};
}

/* Reads rows of a view behind those in memory. */
static bool read_rows(struct windows *w, int view, int32_t n, struct image_error *error)
{
    const struct source *source = &w->sources[view];
    float *colour = w->colour[view], *depth = w->depth[view];
    const int channels[4] = {source->layer.r, source->layer.g, source->layer.b,
                             source->layer.a};
    const size_t at = (size_t)w->rows.n * (size_t)w->width;
    const struct image_rows rows = {w->rows.first + w->rows.n, n};
    if (n <= 0)
        return true;
    if (!image_read_rows(source->colour, channels, w->n_channels, rows,
                         colour + at * (size_t)w->n_channels, w->run->n_threads,
                         error) ||
        !image_read_rows(source->depth, &source->z, 1, rows, depth + at,
                         w->run->n_threads, error))
        return false;
    rf_depth_undo_mist(depth + at, (size_t)n * (size_t)w->width,
                       (enum rf_mist)w->run->tool->mist_falloff);
    return true;
}

/* Gets rows `first` to before `end` into memory; those that are there stay. */
static bool need_rows(struct windows *w, int32_t first, int32_t end,
                      struct image_error *error)
{
    const int32_t kept_end = w->rows.first + w->rows.n;
    const int32_t n_kept = first >= w->rows.first ? most(kept_end - first, 0) : 0;
    const size_t row = (size_t)w->width;
    const size_t n = (size_t)n_kept * row;
    const size_t from = n_kept ? (size_t)(first - w->rows.first) * row : 0;
    const size_t pixel = (size_t)w->n_channels;
    w->rows.first = first;
    w->rows.n = n_kept;
    for (int j = 0; j < w->n_views; j++) {
        if (n_kept) {
            memmove(w->colour[j], w->colour[j] + from * pixel,
                    n * pixel * sizeof(float));
            memmove(w->depth[j], w->depth[j] + from, n * sizeof(float));
        }
        if (!read_rows(w, j, end - first - n_kept, error))
            return false;
    }
    w->rows.n = most(end - first, n_kept);
    return true;
}

/* A window with the pixels around it that its depth's repair looks at. */
static struct rf_window with_margin(const struct windows *w,
                                    const struct rf_window *box)
{
    const bool are_moved = w->found.is_mixed || w->found.is_widened;
    const int32_t margin = (are_moved ? RF_DEPTH_SNAP_REACH : 0) +
                           (w->found.is_speckled ? RF_DEPTH_FILL_REACH : 0);
    const int32_t x = most(box->x - margin, 0), y = most(box->y - margin, 0);
    return (struct rf_window){x, y, least(box->x + box->width + margin, w->width) - x,
                              least(box->y + box->height + margin, w->height) - y};
}

/* Repairs the depth of a window with its margin, in memory of its own. False without.
 */
static bool repaired_depth(struct windows *w, int j, const struct rf_window *box,
                           struct rf_image *depth)
{
    struct depth_repaired done = {0};
    const struct rf_window whole = with_margin(w, box);
    const size_t row = (size_t)w->width, columns = (size_t)whole.width;
    const size_t n = columns * (size_t)whole.height;
    if (n > w->n_repaired[j]) {
        free(w->repaired[j]);
        w->repaired[j] = app_memory(n, sizeof(float), w->run->error);
        w->n_repaired[j] = w->repaired[j] ? n : 0;
    }
    float *repaired = w->repaired[j];
    const size_t first = (size_t)(whole.y - w->rows.first) * row + (size_t)whole.x;
    for (int32_t y = 0; repaired && y < whole.height; y++)
        memcpy(repaired + (size_t)y * columns, w->depth[j] + first + (size_t)y * row,
               columns * sizeof(float));
    struct rf_depth_channel channel = {
        repaired,
        rf_image_packed(w->colour[j] + first * (size_t)w->n_channels, w->width,
                        whole.height, w->n_channels),
        whole.width, whole.height, w->run->params.depth_infinity};
    channel.colour.width = whole.width;
    const bool is_turned = repaired && w->found.is_turned;
    if (is_turned)
        depth_turn(repaired, n, channel.infinity);
    if (repaired && w->found.is_premultiplied)
        rf_depth_divide_by_alpha(&channel);
    const bool is_done = repaired && depth_move_edges(&w->found, &channel, &done);
    if (is_turned)
        depth_turn(repaired, n, channel.infinity);
    if (!is_done) {
        app_fail(w->run->error, APP_NO_MEMORY, "out of memory for a window");
        return false;
    }
    *depth = rf_image_packed(repaired + (size_t)(box->y - whole.y) * columns +
                                 (size_t)(box->x - whole.x),
                             whole.width, box->height, 1);
    depth->width = box->width;
    return true;
}

/* The pixels of a window of a view's rows in memory, the depth repaired. False without
 * memory. */
static bool view_of(struct windows *w, int j, const struct rf_window *box,
                    struct rf_view *found)
{
    const size_t pixel = (size_t)w->n_channels, row = (size_t)w->width;
    const size_t at = (size_t)(box->y - w->rows.first) * row + (size_t)box->x;
    struct rf_view view = {
        .colour = rf_image_packed(w->colour[j] + at * pixel, w->width, box->height,
                                  w->n_channels),
        .depth = rf_image_packed(w->depth[j] + at, w->width, box->height, 1)};
    view.colour.width = view.depth.width = box->width;
    if (w->n_views > 1) {
        const struct rf_view *place = &w->run->views.views[j];
        memcpy(view.lens_offset, place->lens_offset, sizeof view.lens_offset);
        view.shear_distance = place->shear_distance;
    }
    *found = view;
    return !depth_fault(&w->found) || repaired_depth(w, j, box, &found->depth);
}

/* ---- passes over the whole ------------------------------------------------------- */

/* Of the depth as it is, and as numbers whose ratios are those of distances; NULL: it is
 * such. */
struct depth_tallies {
    struct rf_depth_tally *values, *ratios;
};

static bool create_tallies(const struct windows *w, struct depth_tallies *tallies)
{
    const struct rf_params *params = &w->run->settings->params;
    const struct rf_depth_channel whole = {
        .width = w->width, .height = w->height, .infinity = params->depth_infinity};
    struct rf_depth_stats unused = {.size = sizeof(unused)};
    *tallies = (struct depth_tallies){0};
    if (rf_depth_tally_create(&tallies->values, NULL, &whole, NULL) != RF_OK)
        return false;
    if (depth_ratio_of(params).factor == 0 ||
        rf_depth_tally_create(&tallies->ratios, NULL, &whole, NULL) == RF_OK)
        return true;
    rf_depth_tally_finish(tallies->values, &unused);
    return false;
}

static void finish_tallies(const struct depth_tallies *tallies,
                           struct rf_depth_stats *stats)
{
    struct rf_depth_stats ratios = {.size = sizeof(ratios)};
    rf_depth_tally_finish(tallies->values, stats);
    if (!tallies->ratios)
        return;
    rf_depth_tally_finish(tallies->ratios, &ratios);
    depth_take_ratios(stats, &ratios);
}

/* Counts the rows of the first view: its depth and its light. */
static int tally_rows(struct windows *w, struct depth_tallies *tallies,
                      struct white_tally *light)
{
    const struct depth_ratio ratio = depth_ratio_of(&w->run->settings->params);
    const int32_t n_rows = most(w->step, SURVEY_ROWS);
    int code = make_room(w, n_rows);
    for (int32_t y = 0; code == APP_DONE && y < w->height; y += n_rows) {
        const int32_t n = least(n_rows, w->height - y);
        if (os_is_interrupted())
            code = APP_INTERRUPTED;
        else if (!need_rows(w, y, y + n, w->run->error))
            code = fail_image(w);
        else {
            const size_t n_pixels = (size_t)w->width * (size_t)n;
            depth_numbers_add(&w->run->numbers, &w->run->settings->params, w->depth[0],
                              n_pixels);
            filter_count_doubts(w->run, &(struct doubts_rows){w->depth[0], y, n},
                                w->colour[0]);
            if (depth_is_turned(&w->run->params))
                depth_turn(w->depth[0], n_pixels, w->run->params.depth_infinity);
            const struct rf_depth_channel strip = {
                w->depth[0], rf_image_packed(w->colour[0], w->width, n, w->n_channels),
                w->width, n, w->run->params.depth_infinity};
            rf_depth_tally_add(tallies->values, &strip);
            if (tallies->ratios) { /* the rows are dropped at the end */
                depth_ratio_make(&ratio, w->depth[0], n_pixels);
                rf_depth_tally_add(tallies->ratios, &strip);
            }
            white_tally_add(light, w->colour[0], (size_t)w->width * (size_t)n,
                            w->n_channels);
        }
    }
    drop_rows(w);
    return code;
}

/* The repairs of the depth and the white, from a pass over the first view's file. */
static int judge_picture(struct windows *w)
{
    struct run *run = w->run;
    struct rf_depth_stats stats = {.size = sizeof(stats)};
    struct depth_tallies tallies;
    struct white_tally light = {.n_unlit = 0};
    const bool needs_depth = filter_needs_depth(run);
    const bool needs_white = filter_needs_white(run);
    filter_begin_doubts(run);
    if (!needs_depth && !needs_white && !run->doubts)
        return APP_DONE;
    if (!create_tallies(w, &tallies))
        return app_fail(run->error, APP_NO_MEMORY, "%s: out of memory",
                        image_path(run->source.depth));
    w->n_views = 1;
    int code = tally_rows(w, &tallies, &light);
    w->n_views = filter_n_views(run);
    finish_tallies(&tallies, &stats);
    if (code == APP_DONE && needs_depth)
        code = filter_judge_depth(run, &stats, &w->found);
    if (code == APP_DONE && needs_depth)
        code = filter_say_repaired(run, &w->found, NULL);
    return code == APP_DONE && needs_white ? filter_take_white(run, &light) : code;
}

static int survey_strip(struct windows *w, int32_t y, int32_t n)
{
    const int32_t first = most(y - RF_SURVEY_MARGIN, 0);
    const int32_t end = least(y + n + RF_SURVEY_MARGIN, w->height);
    struct rf_error core;
    const struct rf_window rows =
        with_margin(w, &(struct rf_window){0, first, w->width, end - first});
    if (!need_rows(w, rows.y, rows.y + rows.height, w->run->error))
        return fail_image(w);
    for (int32_t x = 0; x < w->width; x += SURVEY_COLUMNS) {
        const int32_t x0 = most(x - RF_SURVEY_MARGIN, 0);
        const int32_t columns = least(SURVEY_COLUMNS, w->width - x);
        const int32_t x1 = least(x + columns + RF_SURVEY_MARGIN, w->width);
        const struct rf_window counted = {x, y, columns, n};
        const struct rf_window given = {x0, first, x1 - x0, end - first};
        for (int j = 0; j < w->n_views; j++) {
            struct rf_view view;
            if (!view_of(w, j, &given, &view))
                return APP_NO_MEMORY;
            if (rf_filter_survey(w->run->filter, &view, &given, &counted,
                                 &w->surveys[j], &core) != RF_OK)
                return fail_core(w, j, &core);
        }
    }
    return APP_DONE;
}

static int survey_all(struct windows *w)
{
    app_begin(w->run->tool->host, "measuring");
    int code = make_room(w, SURVEY_ROWS + 2 * RF_SURVEY_MARGIN + 2 * REPAIR_REACH);
    for (int32_t y = 0; code == APP_DONE && y < w->height; y += SURVEY_ROWS) {
        code = survey_strip(w, y, least(SURVEY_ROWS, w->height - y));
        if (!app_progress((void *)w->run->tool->host, (double)y / w->height))
            code = APP_INTERRUPTED;
    }
    drop_rows(w);
    app_end(w->run->tool->host);
    for (int j = 0; j < w->n_views; j++)
        w->run->largest_radius =
            fmax(w->run->largest_radius, w->surveys[j].largest_radius);
    return code;
}

/* ---- the plan -------------------------------------------------------------------- */

/* Largest window needed, over all places, for windows of a size to be kept. */
struct needed {
    int32_t width, height;
    size_t n_bytes, window_bytes; /* of all, and of the filter alone */
};

static bool find_needed(const struct windows *w, int32_t kept_width,
                        int32_t kept_height, struct needed *needed,
                        struct rf_error *error)
{
    struct rf_window given;
    *needed = (struct needed){.width = 0};
    for (int32_t y = 0; y < w->height; y += kept_height)
        for (int32_t x = 0; x < w->width; x += kept_width) {
            const struct rf_window kept = {x, y, least(kept_width, w->width - x),
                                           least(kept_height, w->height - y)};
            if (x > 0 && y > 0) /* as wide as those above, as high as those left */
                break;
            if (rf_filter_window(w->run->filter, w->surveys, w->n_views, &kept, &given,
                                 error) != RF_OK)
                return false;
            needed->width = most(needed->width, given.width);
            needed->height = most(needed->height, given.height);
        }
    given = (struct rf_window){0, 0, needed->width, needed->height};
    const size_t pixel = (size_t)w->n_channels * sizeof(float), row = (size_t)w->width;
    const bool is_repaired = depth_fault(&w->found) != NULL;
    const size_t width = (size_t)needed->width + 2 * REPAIR_REACH;
    const size_t height = (size_t)needed->height + 2 * REPAIR_REACH;
    needed->window_bytes =
        rf_window_bytes(w->run->filter, w->surveys, w->n_views, &given);
    needed->n_bytes =
        needed->window_bytes +
        (size_t)w->n_views * height * row * (pixel + sizeof(float)) +
        (size_t)kept_height * row * 2 * pixel + /* and as it is compressed */
        (is_repaired ? (size_t)w->n_views + 1 : 0) * width * height * sizeof(float) +
        (size_t)w->run->n_threads * CHUNK_BYTES + (size_t)w->n_views * VIEW_BYTES +
        PROGRAM_BYTES;
    return true;
}

static int32_t round_up(int32_t n, int32_t step)
{
    return (n + step - 1) / step * step;
}

/* Chooses the size of the windows: the least pixels filtered for each that is kept. */
static int choose_size(struct windows *w, struct needed *chosen)
{
    size_t least_bytes = SIZE_MAX;
    w->work = INFINITY;
    w->quick_bytes = whole_bytes(&w->run->source, w->n_views);
    const int32_t end = least(w->height, MOST_ROWS) + w->step;
    for (int32_t height = round_up(least(LEAST_SIDE, w->height), w->step); height < end;
         height = round_up(height + height / 8, w->step))
        for (int32_t n = 1; n == 1 || w->width / n >= LEAST_SIDE; n += 1 + n / 8) {
            struct rf_error error;
            struct needed needed;
            const int32_t width = (w->width + n - 1) / n;
            if (!find_needed(w, width, height, &needed, &error))
                return fail_core(w, 0, &error);
            least_bytes = least_size(needed.n_bytes, least_bytes);
            const double work = (double)needed.width * needed.height /
                                ((double)width * least(height, w->height));
            if (work <= QUICK)
                w->quick_bytes = least_size(needed.n_bytes, w->quick_bytes);
            if (needed.n_bytes > w->max_bytes || work >= w->work)
                continue;
            w->work = work;
            w->kept_width = width;
            w->kept_height = height;
            *chosen = needed;
        }
    if (w->work < INFINITY)
        return APP_DONE;
    char way_out[96];
    snprintf(way_out, sizeof(way_out), "in windows it takes %zu MiB, and is quick with",
             mib_of(least_bytes));
    if (least_bytes >= w->quick_bytes) /* margins are more than what they spare */
        snprintf(way_out, sizeof(way_out), "windows take no less than the whole,");
    return app_fail(
        w->run->error, APP_FAILED,
        "--max-memory: %zu MiB are too few for %s, %d x %d px with radii of %.0f "
        "px; %s %zu MiB",
        w->max_bytes >> 20, image_path(w->sources->colour), (int)w->width,
        (int)w->height, ceil(w->run->largest_radius), way_out, mib_of(w->quick_bytes));
}

/* The margins of small windows take most of the time. */
static void say_slow(const struct windows *w)
{
    if (w->work > SLOW)
        app_say(w->run->tool->host,
                "%s: --max-memory %zu: with the margins of its windows each pixel is "
                "filtered %.0f times; with %zu MiB %.0f times at most",
                image_path(w->sources->colour), w->max_bytes >> 20, w->work,
                mib_of(w->quick_bytes), QUICK);
}

/* ---- filtering ------------------------------------------------------------------- */

static bool report_window(void *user, double fraction)
{
    struct windows *w = user;
    const double done = ((double)w->n_done + fraction) / (double)w->n_windows;
    return app_progress((void *)w->run->tool->host, done);
}

static int filter_window(struct windows *w, const struct rf_window *kept)
{
    struct rf_window given;
    struct rf_error core;
    const struct rf_progress progress = {report_window, w};
    const size_t pixel = (size_t)w->n_channels;
    struct rf_image out = rf_image_packed(w->out + (size_t)kept->x * pixel, w->width,
                                          kept->height, w->n_channels);
    out.width = kept->width;
    struct rf_view views[RF_MAX_VIEWS];
    const int n_views = w->n_views;
    if (rf_filter_window(w->run->filter, w->surveys, n_views, kept, &given, &core) !=
        RF_OK)
        return fail_core(w, 0, &core);
    const struct rf_window rows = with_margin(w, &given);
    if (!need_rows(w, rows.y, rows.y + rows.height, w->run->error))
        return fail_image(w);
    for (int j = 0; j < n_views; j++)
        if (!view_of(w, j, &given, &views[j]))
            return APP_NO_MEMORY;
    if (rf_filter_process_window(w->run->filter, w->surveys, views, n_views, &given,
                                 kept, &out, &progress, &core) != RF_OK)
        return fail_core(w, 0, &core);
    w->n_done++;
    return APP_DONE;
}

static int filter_strip(struct windows *w, int32_t y)
{
    int code = APP_DONE;
    const int32_t n = least(w->kept_height, w->height - y);
    const size_t n_samples = (size_t)n * (size_t)w->width * (size_t)w->n_channels;
    for (int32_t x = 0; code == APP_DONE && x < w->width; x += w->kept_width) {
        const struct rf_window kept = {x, y, least(w->kept_width, w->width - x), n};
        code = filter_window(w, &kept);
    }
    if (code != APP_DONE)
        return code;
    if (w->to.output.types[0] == IMAGE_SAMPLE_HALF)
        code = picture_warn_clipped(w->run->tool->host, w->run->tool->output,
                                    picture_clip_to_half(w->out, n_samples),
                                    w->run->error);
    if (code != APP_DONE)
        return code;
    return image_write_rows(w->writer, n, w->out, w->run->error) ? APP_DONE
                                                                 : fail_image(w);
}

static int filter_all(struct windows *w, const struct needed *needed)
{
    struct run *run = w->run;
    if (!image_write_begin(&w->writer, run->tool->output, &w->to.output, run->n_threads,
                           run->error))
        return fail_image(w);
    const int64_t n_columns = (w->width + w->kept_width - 1) / w->kept_width;
    w->n_windows = n_columns * ((w->height + w->kept_height - 1) / w->kept_height);
    int code = make_room(w, needed->height + 2 * REPAIR_REACH);
    w->out = app_memory((size_t)w->kept_height * (size_t)w->width,
                        (size_t)w->n_channels * sizeof(float), run->error);
    if (!w->out)
        code = APP_NO_MEMORY;
    app_begin(run->tool->host, "filtering");
    for (int32_t y = 0; code == APP_DONE && y < w->height; y += w->kept_height)
        code = filter_strip(w, y);
    app_end(run->tool->host);
    drop_rows(w);
    return code == APP_DONE && os_is_interrupted() ? APP_INTERRUPTED : code;
}

/* ---- steps of the run ------------------------------------------------------------ */

static void describe_output(struct windows *w)
{
    const struct run *run = w->run;
    filter_describe(run, w->made, sizeof(w->made));
    source_describe(&run->source,
                    &(struct source_output){.type = run->tool->type == FILTER_TYPE_HALF
                                                        ? IMAGE_SAMPLE_HALF
                                                        : IMAGE_SAMPLE_FLOAT,
                                            .compression = filter_compression(run),
                                            .made = w->made},
                    &w->to);
    filter_drop_view(run, &w->to);
    w->to.output.pass_through = run->tool->pass_through;
    if (run->source.info.is_tiled)
        w->to.output.tile_size = image_row_step(run->source.colour, run->source.part);
}

int windows_open(struct run *run)
{
    struct windows *w = app_memory(1, sizeof(*w), run->error);
    if (!w)
        return APP_NO_MEMORY;
#ifdef M_MMAP_THRESHOLD
    /* The C library else keeps ever larger freed blocks, in gaps of its heap. */
    mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
    run->windows = w;
    w->run = run;
    w->sources = sources_of(run);
    w->n_views = filter_n_views(run);
    w->max_bytes = (size_t)run->tool->max_memory_mib << 20;
    w->width = run->source.width;
    w->height = run->source.height;
    w->n_channels = run->source.n_channels;
    w->step = image_row_step(run->source.colour, run->source.part);
    for (int j = 0; j < w->n_views; j++)
        w->surveys[j].size = sizeof w->surveys[j];
    const int code = judge_picture(w);
    return code == APP_DONE ? survey_all(w) : code;
}

int windows_filter(struct run *run)
{
    struct windows *w = run->windows;
    struct needed needed = {0};
    int code = choose_size(w, &needed);
    if (code == APP_DONE)
        say_slow(w);
    if (code == APP_DONE)
        code = filter_make(run, w->max_bytes - (needed.n_bytes - needed.window_bytes));
    describe_output(w);
    return code == APP_DONE ? filter_all(w, &needed) : code;
}

int windows_finish(struct run *run)
{
    struct image_writer *writer = run->windows->writer;
    run->windows->writer = NULL;
    return image_write_finish(writer, run->error) ? APP_DONE : fail_image(run->windows);
}

void windows_free(struct run *run)
{
    struct windows *w = run->windows;
    if (!w)
        return;
    if (w->writer)
        image_write_abort(w->writer);
    drop_rows(w);
    free(w->out);
    for (int j = 0; j < RF_MAX_VIEWS; j++)
        free(w->repaired[j]);
    free(w);
    run->windows = NULL;
}
