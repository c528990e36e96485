/* SPDX-License-Identifier: Apache-2.0 */
#include "povray/povray_average.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "povray/povray_files.h"
#include "povray/povray_lens.h"
#include "sources/picture.h"

/* A view without anti-aliasing of its own: the mean smooths the edges. */
#define SUBPIXEL_OPTIONS "-A"

struct work {
    const struct povray_average *how;
    struct povray_passes facts;
    struct rf_context *context;
    struct rf_accumulator *accumulator;
};

/* ---- points --------------------------------------------------------------------- */

static double fraction(double v)
{
    return v - floor(v);
}

/* The sequence R2 over the pixel (Roberts 2018); it goes with no pattern of the lens.
 */
static void place_in_pixel(int i, struct povray_view *view)
{
    view->x_px = fraction(0.5 + 0.75487766624669276 * i) - 0.5;
    view->y_px = fraction(0.5 + 0.56984029099805327 * i) - 0.5;
}

static struct povray_view *make_views(const struct povray_average *how,
                                      struct rf_error *error)
{
    struct rf_lens_point *points =
        app_memory(RF_MAX_LENS_POINTS, sizeof(*points), NULL);
    struct povray_view *views = app_memory((size_t)how->n_views, sizeof(*views), NULL);
    if (!points || !views)
        snprintf(error->message, sizeof(error->message), "out of memory");
    if (!points || !views ||
        rf_lens_points(&how->settings->params, how->n_views, how->frame, points,
                       error) != RF_OK) {
        free(views);
        views = NULL;
    }
    for (int i = 0; views && i < how->n_views; i++) {
        views[i] = (struct povray_view){
            .u = points[i].u, .v = points[i].v, .time = points[i].time};
        if (how->has_subpixel)
            place_in_pixel(i, &views[i]);
    }
    free(points);
    return views;
}

/* ---- the sum -------------------------------------------------------------------- */

static struct rf_image image_of(const struct povray_passes *passes)
{
    struct rf_image image =
        rf_image_packed(passes->colour, passes->width, passes->height, 4);
    image.channels = passes->has_alpha ? 4 : 3;
    return image;
}

static rf_result start_sum(struct work *work, const struct povray_passes *passes,
                           struct rf_error *error)
{
    const struct rf_context_params run = {.size = sizeof(run),
                                          .cpu = getenv("RACKFOCUS_CPU"),
                                          .n_threads = work->how->n_threads};
    struct rf_params params = work->how->settings->params;
    if (settings_origin(work->how->settings, "blend-gamma") != ORIGIN_COMMAND_LINE)
        params.blend_gamma = passes->gamma;
    rf_result result = rf_context_create(&work->context, &run, error);
    if (result == RF_OK)
        result = rf_accumulator_create(&work->accumulator, work->context, &params,
                                       passes->width, passes->height,
                                       passes->has_alpha ? 4 : 3, error);
    return result;
}

static bool keep_view(const struct work *work, int view,
                      const struct povray_passes *passes, struct povray_error *error)
{
    char path[4096];
    struct image_error image_error;
    snprintf(path, sizeof(path), "%s_%04d.exr", work->how->keep, view);
    if (povray_file_write(path, passes, POVRAY_FILE_COLOUR, NULL, work->how->n_threads,
                          &image_error))
        return true;
    snprintf(error->message, sizeof(error->message), "%s", image_error.message);
    return false;
}

static bool receive_view(void *user, int view, const struct povray_passes *passes,
                         struct povray_error *error)
{
    struct work *work = user;
    struct rf_error core_error;
    rf_result result = RF_OK;
    if (!work->accumulator) {
        result = start_sum(work, passes, &core_error);
        work->facts = *passes;
        work->facts.colour = NULL;
        if (passes->warning[0] && work->how->warn &&
            !work->how->warn(work->how->user, passes->warning, error))
            return false;
    }
    const struct rf_image image = image_of(passes);
    if (result == RF_OK)
        result = rf_accumulator_add(work->accumulator, &image, &core_error);
    if (result == RF_OK)
        return !work->how->keep || keep_view(work, view, passes, error);
    snprintf(error->message, sizeof(error->message), "view %d: %s", view,
             core_error.message);
    return false;
}

/* Red, green and blue alone, in place. */
static int drop_alpha(float *samples, size_t n_pixels)
{
    for (size_t i = 0; i < n_pixels; i++)
        memmove(samples + 3 * i, samples + 4 * i, 3 * sizeof(float));
    return 3;
}

/* ---- the result ----------------------------------------------------------------- */

static bool write_picture(const struct povray_average *how,
                          const struct povray_passes *mean, struct image_error *error)
{
    char used[1000], made[1100];
    if (picture_kind(how->output) == PICTURE_EXR) {
        settings_print_options(&how->settings->params, used, sizeof(used));
        snprintf(made, sizeof(made), "rackfocus %s povray %s, %d views", rf_version(),
                 used, how->n_views);
        return povray_file_write(how->output, mean, POVRAY_FILE_RESULT, made,
                                 how->n_threads, error);
    }
    const size_t n_pixels = (size_t)mean->width * (size_t)mean->height;
    const int n_channels = mean->has_alpha ? 4 : drop_alpha(mean->colour, n_pixels);
    return image_write_png(how->output, mean->colour, mean->width, mean->height,
                           n_channels, 8, false, error);
}

static bool write_mean(struct work *work, struct povray_error *error)
{
    struct povray_passes mean = work->facts;
    struct rf_error core_error;
    struct image_error image_error;
    mean.colour = app_memory((size_t)mean.width * (size_t)mean.height * 4,
                             sizeof(*mean.colour), &image_error);
    const struct rf_image image = image_of(&mean);
    const char *what = NULL;
    if (!mean.colour)
        what = image_error.message;
    else if (rf_accumulator_mean(work->accumulator, &image, &core_error) != RF_OK)
        what = core_error.message;
    else if (!write_picture(work->how, &mean, &image_error))
        what = image_error.message;
    if (what)
        snprintf(error->message, sizeof(error->message), "%s", what);
    free(mean.colour);
    return !what;
}

bool povray_average_render(const struct povray_average *how,
                           struct povray_passes *facts, struct povray_error *error)
{
    struct work work = {.how = how};
    struct rf_error core_error;
    double total_s = 0;
    struct povray_view *views = make_views(how, &core_error);
    *error = (struct povray_error){.message = ""};
    if (!views)
        snprintf(error->message, sizeof(error->message), "%s", core_error.message);
    struct povray_lens lens = {.views = views,
                               .n_views = how->n_views,
                               .move = how->move,
                               .shutter = how->shutter,
                               .before = how->has_subpixel ? SUBPIXEL_OPTIONS : NULL};
    povray_lens_tilt(&how->settings->params, lens.tilt);
    bool is_good = views && povray_render_lens(how->scene, &lens, receive_view, &work,
                                               &total_s, error);
    is_good = is_good && write_mean(&work, error);
    *facts = work.facts;
    facts->total_s = total_s;
    rf_accumulator_destroy(work.accumulator);
    rf_context_destroy(work.context);
    free(views);
    return is_good;
}
