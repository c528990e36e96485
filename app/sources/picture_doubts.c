/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/picture_doubts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "sources/alpha.h"
#include "sources/depth_grid.h"

/* How a depth is turned, and the command that turns it back. */
static bool is_turned(const struct depth_fit *fit, const char *file, char *text,
                      size_t n_bytes)
{
    static const char *const words[] = {"", "upside down", "mirrored",
                                        "upside down and mirrored"};
    static const char *const ways[] = {"", "--flip", "--flop", "--rotate180"};
    const enum depth_turn turn = depth_fit_turn(fit);
    const double n = (double)fit->n / 100;
    if (turn == DEPTH_UPRIGHT)
        return false;
    snprintf(text, n_bytes,
             "the depth lies %s: of its steps %.0f %% are at edges of the picture, "
             "turned back %.0f %%; turn it: oiiotool %s %s -d float -o depth.exr, "
             "and say --depth-file depth.exr",
             words[turn], (double)fit->n_edges[DEPTH_UPRIGHT] / n,
             (double)fit->n_edges[turn] / n, file, ways[turn]);
    return true;
}

/* How a depth lies beside its picture, and the command that moves it. */
static bool is_beside(const struct depth_fit *fit, const char *file, char *text,
                      size_t n_bytes)
{
    struct depth_move move;
    char right[40], down[40];
    if (!depth_fit_move(fit, &move))
        return false;
    snprintf(right, sizeof(right), "%d px to the %s", abs(move.right),
             move.right < 0 ? "right" : "left");
    snprintf(down, sizeof(down), "%d px %s", abs(move.down),
             move.down < 0 ? "below" : "above");
    snprintf(
        text, n_bytes,
        "the depth lies beside the picture, %s%s%s: of its steps %.0f %% are at edges "
        "of "
        "the picture, moved back %.0f %%; render both with one camera, frame and "
        "window, or move it: oiiotool %s --cshift %+d%+d -d float -o depth.exr, "
        "and say --depth-file depth.exr",
        move.right ? right : "", move.right && move.down ? ", " : "",
        move.down ? down : "", 100 * move.share, 100 * move.share_there, file,
        move.right, move.down);
    return true;
}

bool place_is_doubtful(const struct depth_fit *fit, const struct source *source,
                       char *text, size_t n_bytes)
{
    char file[TOOL_FILE_BYTES];
    source_tool_file(source->depth, source->z, file);
    return is_beside(fit, file, text, n_bytes) || is_turned(fit, file, text, n_bytes);
}

void explain_size(int32_t width, int32_t height, char *text, size_t n_bytes)
{
    snprintf(
        text, n_bytes,
        "the depth was rendered in about %d x %d and enlarged, as whole columns and "
        "rows "
        "of it are repeated; its steps lie beside the edges of the picture: render "
        "it in the size of the picture",
        width, height);
}

/* Are all colours in the part that oiiotool would read? */
static bool is_of_one_part(const struct source *source)
{
    int n;
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    const struct image_layer *layer = &source->layer;
    return layer->a < 0 || channels[layer->a].part == channels[layer->r].part;
}

void explain_straight(const struct source *source, char *text, size_t n_bytes)
{
    static const char plain[4][2] = {"R", "G", "B", "A"};
    char name[80], channels[4 * (sizeof(name) + 4)];
    char file[TOOL_FILE_BYTES];
    size_t n = 0;
    *text = 0;
    if (!is_of_one_part(source) || source->is_grey || source->layer.is_chroma)
        return;
    source_tool_file(source->colour, source->layer.r, file);
    /* Of a layer's names oiiotool knows no alpha, and multiplies by none. */
    for (int i = 0; i < 4; i++) {
        source_channel_name(source, i, name, sizeof(name));
        const bool is_plain = strcmp(name, plain[i]) == 0;
        n += (size_t)snprintf(channels + n, sizeof(channels) - n, "%s%s%s%s",
                              i ? "," : "", plain[i], is_plain ? "" : "=",
                              is_plain ? "" : name);
    }
    snprintf(text, n_bytes,
             ": oiiotool %s --ch %s --premult -o colour.exr, and filter colour.exr "
             "--depth-file %.150s",
             file, channels, image_path(source->depth));
}

/* Radii of all pixels. False without memory, and of depth that no filter takes. */
static bool find_radii(const struct depth_picture *picture,
                       const struct rf_image *radii)
{
    const struct rf_context_params about = {.size = sizeof(about), .n_threads = 1};
    struct rf_context *context = NULL;
    struct rf_filter *filter = NULL;
    bool is_good = rf_context_create(&context, &about, NULL) == RF_OK &&
                   rf_filter_create(&filter, context, picture->params, radii->width,
                                    radii->height, NULL) == RF_OK;
    is_good =
        is_good && rf_filter_coc(filter, &picture->views->depth, radii, NULL) == RF_OK;
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return is_good;
}

static bool is_misplaced(const struct depth_picture *picture, char *text,
                         size_t n_bytes)
{
    const struct rf_image *colour = &picture->views->colour;
    const int32_t width = colour->width, height = colour->height;
    struct depth_fit fit = {0};
    float *radii = app_memory((size_t)width * (size_t)height, sizeof(*radii), NULL);
    if (!radii)
        return false;
    const struct rf_image image = rf_image_packed(radii, width, height, 1);
    if (find_radii(picture, &image))
        depth_fit_find(&fit, &(struct depth_fit_picture){
                                 colour->data, radii, colour->channels, width, height});
    free(radii);
    return place_is_doubtful(&fit, picture->source, text, n_bytes);
}

static bool is_enlarged(const struct depth_picture *picture, char *text, size_t n_bytes)
{
    const struct rf_image *depth = &picture->views->depth;
    struct depth_grid *grid = depth_grid_create(depth->width, depth->height);
    int32_t width = 0, height = 0;
    if (grid)
        depth_grid_add(grid, depth->data, depth->height);
    const bool is_found = grid && depth_grid_find(grid, &width, &height);
    depth_grid_free(grid);
    if (is_found)
        explain_size(width, height, text, n_bytes);
    return is_found;
}

static bool is_straight(const struct depth_picture *picture, char *text, size_t n_bytes)
{
    const struct rf_image *colour = &picture->views->colour;
    const size_t width = (size_t)colour->width;
    struct alpha_tally tally = {0};
    char way_out[700];
    for (size_t y = 0; colour->channels == 4 && y < (size_t)colour->height; y++)
        alpha_tally_add(&tally, (const float *)colour->data + 4 * width * y, width);
    if (!alpha_is_straight(&tally))
        return false;
    explain_straight(picture->source, way_out, sizeof(way_out));
    snprintf(text, n_bytes, "%s%s", alpha_straight_words, way_out);
    return true;
}

void picture_say_doubts(const struct depth_picture *picture,
                        void (*say)(void *user, const char *text), void *user)
{
    char text[900];
    if (is_enlarged(picture, text, sizeof(text)) ||
        is_misplaced(picture, text, sizeof(text)))
        say(user, text);
    if (is_straight(picture, text, sizeof(text)))
        say(user, text);
}

void picture_explain_pixels(const struct source *source, char *text, size_t n_bytes)
{
    int n;
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    const struct image_layer *layer = &source->layer;
    char file[TOOL_FILE_BYTES];
    *text = 0;
    if (!is_of_one_part(source) || source->is_grey || layer->is_chroma)
        return;
    source_tool_file(source->colour, layer->r, file);
    snprintf(
        text, n_bytes,
        "; or give them the mean around: oiiotool %s --ch %.50s,%.50s,%.50s%s%.50s "
        "--fixnan box3 -o colour.exr, and filter colour.exr --depth-file %.150s",
        file, channels[layer->r].name, channels[layer->g].name, channels[layer->b].name,
        layer->a >= 0 ? "," : "", layer->a >= 0 ? channels[layer->a].name : "",
        image_path(source->depth ? source->depth : source->colour));
}
