/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a user is told of a run: parameters that were given for nothing, values that
 * nobody gave and what they make of the picture, and what was done.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/report.h"
#include "filter/filter_private.h"
#include "sources/camera_facts.h"
#include "sources/choice.h"
#include "sources/depth_doubts.h"
#include "sources/look_window.h"

static void append(char *text, size_t n_bytes, const char *word)
{
    const size_t n = strlen(text);
    snprintf(text + n, n_bytes - n, "%s%s", n > 0 ? ", " : "", word);
}

/* ---- given for nothing ------------------------------------------------------------
 */

static const char *const MEAN_HAS_LENS =
    "the mean of views has the focus and the lens that they were rendered with; "
    "--method views can change those";

/* A mean of views, which are rendered with a lens. */
static bool is_mean(const struct run *run)
{
    return run->params.method == RF_METHOD_ACCUMULATE;
}

/* Does a mean's lens count beside the picture: for radii, or for grain? */
static bool has_lens_beside(const struct run *run)
{
    return run->tool->output_coc || run->tool->denoise;
}

/* Does it say where on the lens views are taken? */
static bool places_views(const char *key)
{
    return strcmp(key, "lens-pattern") == 0 || strcmp(key, "lens-random") == 0 ||
           strcmp(key, "lens-seed") == 0;
}

/* Is the picture less than its display window? Of a crop the other side of a line may lie
 * in the rest. */
static bool is_crop(const struct run *run)
{
    const struct image_box *data = &run->source.info.data_window,
                           *display = &run->source.info.display_window;
    return data->min_x > display->min_x || data->min_y > display->min_y ||
           data->max_x < display->max_x || data->max_y < display->max_y;
}

/* Why a split diopter changes nothing in this picture; NULL: it does. */
static const char *why_not_split(const struct run *run)
{
    static const double SAME = 1e-6; /* of a distance: no radius changes by 0.01 px */
    const struct rf_params *p = &run->params;
    const double w = run->source.width, h = run->source.height / p->pixel_aspect;
    const double angle = p->split_angle * acos(-1) / 180;
    const double corner = (fabs(cos(angle)) * w + fabs(sin(angle)) * h) / hypot(w, h);
    if (!(p->split_diopter > 0))
        return NULL;
    if (fabs(p->split_diopter - p->focus_distance) <= SAME * p->focus_distance)
        return "split-diopter is the focus-distance, which the other side of the line "
               "has; give it another distance";
    return !is_crop(run) && p->split_offset - p->split_softness / 2 >= corner
               ? "the line lies beyond the picture, where split-offset is too large "
                 "for it; bring it nearer to 0"
               : NULL;
}

static bool is_of_split(const char *key)
{
    return strncmp(key, "split-", 6) == 0 && strcmp(key, "split-edges") != 0;
}

/* What is sharp counts for the picture where the blend is made of it alone. */
static bool reads_limit(const struct rf_params *p)
{
    return rf_method_find(p->method)->has_blend && p->blend == RF_BLEND_REGION &&
           !(p->region_size > 0);
}

static bool is_default(const struct rf_params *params, const char *key)
{
    struct rf_params defaults;
    char value[64], usual[64];
    rf_params_init(&defaults);
    rf_params_get(params, key, value, sizeof(value));
    rf_params_get(&defaults, key, usual, sizeof(usual));
    return strcmp(value, usual) == 0;
}

/* Chroma and saturation: differences between red, green and blue. */
static bool is_of_colours(const char *key)
{
    return strcmp(key, "axial-chroma") == 0 || strcmp(key, "lateral-chroma") == 0 ||
           strcmp(key, "highlight-saturation") == 0;
}

/* Why this value of a parameter that is read does nothing here; NULL: it does. */
static const char *why_useless(const struct run *run, const char *key)
{
    const struct rf_params *p = &run->settings->params;
    if (is_of_split(key))
        return why_not_split(run);
    if (is_of_colours(key) && run->source.is_grey && !is_default(p, key))
        return "the picture is grey; give one with red, green and blue";
    if (strcmp(key, "coc-limit") == 0 && !reads_limit(p))
        return "read only with blend region and a region-size of 0; rackfocus info "
               "says the depth of field by it";
    if (strcmp(key, "film-depth") == 0 && run->source.n_channels != 4 && !run->is_deep)
        return "the picture has no alpha";
    if (strcmp(key, "depth") == 0 && p->depth == RF_DEPTH_RADIAL &&
        p->projection == RF_PROJECTION_ORTHOGRAPHIC)
        return "the rays of an orthographic camera lie along its axis, so that radial "
               "is planar";
    return NULL;
}

/* Is the picture that is made of the colour alone? */
static bool makes_levels(const struct run *run)
{
    return rf_method_find(run->params.method)->has_blend &&
           run->params.stage == RF_STAGE_LEVELS && !run->tool->output_coc;
}

/* Why nothing of this run reads a parameter; NULL: it does. */
static const char *why_unread(const struct run *run, const struct rf_param_info *info)
{
    const char *why_not;
    if (!rf_param_is_read(&run->settings->params, info->key, &why_not))
        return settings_acts(run->settings, info->key) ? NULL : why_not;
    if (is_mean(run) && ((info->group == RF_GROUP_LENS && !has_lens_beside(run)) ||
                         info->group == RF_GROUP_APERTURE))
        return MEAN_HAS_LENS;
    if (makes_levels(run) &&
        (info->group == RF_GROUP_LENS || info->group == RF_GROUP_DEPTH ||
         strcmp(info->key, "max-radius") == 0))
        return "stage levels shows the levels of detail of the picture, whatever its "
               "lens and depth are";
    return places_views(info->key) ? "read only where views are rendered, as by povray"
                                   : why_useless(run, info->key);
}

static int warn_no_effect(const struct run *run, const char *option, const char *why)
{
    return app_warn(run->tool->host, run->error, "--%s: has no effect: %s", option,
                    why);
}

/* Does a stage show weights, for which the light of no pixel counts? */
static bool shows_no_light(const struct run *run)
{
    return !rf_param_is_read(&run->settings->params, "highlight-clamp", NULL);
}

int filter_warn_unread(const struct run *run)
{
    if (run->tool->denoise && shows_no_light(run)) {
        const int code = warn_no_effect(
            run, "denoise", "the weights that --stage shows have no light, nor grain");
        if (code != APP_DONE)
            return code;
    }
    if (run->tool->aperture_at && is_mean(run) && !has_lens_beside(run)) {
        const int code = warn_no_effect(run, "aperture-at", MEAN_HAS_LENS);
        if (code != APP_DONE)
            return code;
    }
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++) {
        const char *why_not = why_unread(run, &list[i]);
        const bool is_denoisers =
            run->tool->denoise && strcmp(list[i].key, "white") == 0;
        if (settings_origin(run->settings, list[i].key) != ORIGIN_COMMAND_LINE ||
            is_denoisers || !why_not)
            continue;
        const int code = warn_no_effect(run, list[i].key, why_not);
        if (code != APP_DONE)
            return code;
    }
    return APP_DONE;
}

int filter_warn_highlights(const struct run *run)
{
    static const char *const keys[] = {"highlight-gain", "highlight-saturation"};
    const struct source *source = &run->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    const size_t n_colours = source->n_channels < 3 ? 1 : 3;
    float most = 0;
    char why[160];
    bool is_asked = false;
    for (int i = 0; i < 2; i++)
        is_asked |= settings_origin(run->settings, keys[i]) == ORIGIN_COMMAND_LINE &&
                    !is_default(&run->params, keys[i]) &&
                    rf_param_is_read(&run->params, keys[i], NULL);
    /* Of a sequence some frames may have none. */
    if (!is_asked || run->windows || run->is_deep || run->has_views || !run->colour ||
        run->tool->kept)
        return APP_DONE;
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < n_colours; c++)
            most = fmaxf(most, run->colour[i * (size_t)source->n_channels + c]);
    if (run->params.highlight_clamp > 0)
        most = fminf(most, (float)run->params.highlight_clamp);
    if ((double)most > run->params.highlight_threshold)
        return APP_DONE;
    snprintf(why, sizeof(why),
             "the brightest pixel is %.3g and none is above --highlight-threshold %g; "
             "give a smaller one",
             (double)most, run->params.highlight_threshold);
    return warn_no_effect(run, is_default(&run->params, keys[0]) ? keys[1] : keys[0],
                          why);
}

int filter_warn_choice(const struct run *run)
{
    char text[400];
    if (!source_is_doubtful(&run->source, text, sizeof(text)))
        return APP_DONE;
    return app_warn(run->tool->host, run->error, "%s: the picture %s",
                    image_path(run->source.colour), text);
}

/* ---- attributes that nothing reads -------------------------------------------------
 */

#define OWN_PREFIX "rackfocus:"

/* Is it `known`, or of a view, "known.VIEW"? */
static bool is_of(const char *name, const char *known)
{
    const size_t n = strlen(known);
    return strncmp(name, known, n) == 0 && (name[n] == '\0' || name[n] == '.');
}

static bool is_known(const char *name)
{
    static const char *const others[] = {
        VIEWS_OFFSET, VIEWS_SHEAR, OWN_PREFIX "filtered", OWN_PREFIX "shutterTime",
        OWN_PREFIX "pixelSpread"};
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++)
        if (is_of(name, list[i].attribute))
            return true;
    for (size_t i = 0; i < sizeof(others) / sizeof(others[0]); i++)
        if (is_of(name, others[i]))
            return true;
    return false;
}

/* The attribute that differs in capitals alone; NULL: there is none. */
static const char *meant_by(const char *name)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++)
        if (strcasecmp(name, list[i].attribute) == 0)
            return list[i].attribute;
    return NULL;
}

static int warn_attribute(const struct run *run, const struct image_input *input,
                          const char *name)
{
    const char *meant = meant_by(name);
    return meant ? app_warn(run->tool->host, run->error,
                            "%s: attribute %s of the header is not read; is %s meant?",
                            image_path(input), name, meant)
                 : app_warn(run->tool->host, run->error,
                            "%s: attribute %s of the header is not read: there is no "
                            "such parameter; rackfocus info --all lists them",
                            image_path(input), name);
}

/* Of the parts before, has one the attribute, too? */
static bool was_seen(const struct image_input *input, int part, const char *name)
{
    const char *other;
    for (int p = 0; p < part; p++)
        for (int i = 0; (other = image_attribute_name(input, p, i)) != NULL; i++)
            if (strcmp(other, name) == 0)
                return true;
    return false;
}

static int warn_attributes(const struct run *run, const struct image_input *input)
{
    int n_parts, code = APP_DONE;
    const char *name;
    image_parts(input, &n_parts);
    for (int part = 0; part < n_parts; part++)
        for (int i = 0;
             code == APP_DONE && (name = image_attribute_name(input, part, i)) != NULL;
             i++)
            if (strncmp(name, OWN_PREFIX, strlen(OWN_PREFIX)) == 0 && !is_known(name) &&
                !was_seen(input, part, name))
                code = warn_attribute(run, input, name);
    return code;
}

int filter_warn_attributes(const struct run *run)
{
    const struct source *source = &run->source;
    const int code = warn_attributes(run, source->colour);
    return code == APP_DONE && source->depth && source->depth != source->colour
               ? warn_attributes(run, source->depth)
               : code;
}

/* ---- one eye of several --------------------------------------------------------- */

int filter_warn_eyes(const struct run *run)
{
    const struct source *source = &run->source;
    const char *layer = run->tool->layer, *path = image_path(source->colour);
    struct eyes eyes;
    if (run->has_views || run->tool->view ||
        !eyes_are_several(source->colour, &source->layer, &eyes))
        return APP_DONE;
    const bool is_copied = run->tool->pass_through;
    const bool is_named = eye_is_named(layer, eyes.taken);
    if (is_named && !is_copied)
        return APP_DONE;
    if (is_named)
        return app_warn(run->tool->host, run->error,
                        "%s: --pass-through copies the view %s without blur; leave it "
                        "out, or filter all views with --stereo in its place",
                        path, eyes.others);
    return app_warn(
        run->tool->host, run->error,
        "%s: holds the views %s; only %s is filtered%s%s%s; say --stereo "
        "for all of them, or name one (%s) with --layer",
        path, eyes.all, eyes.taken, is_copied ? ", and --pass-through copies " : "",
        is_copied ? eyes.others : "", is_copied ? " without blur" : "", eyes.all);
}

static int warn_of_colour(const struct run *run, const char *text)
{
    return app_warn(run->tool->host, run->error, "%s: %s",
                    image_path(run->source.colour), text);
}

int filter_warn_environment(const struct run *run)
{
    char text[400];
    if (!rf_method_find(run->params.method)->needs_depth ||
        !source_is_environment(&run->source, text, sizeof(text)))
        return APP_DONE;
    return warn_of_colour(run, text);
}

int filter_warn_coded(const struct run *run)
{
    char text[500];
    return source_is_coded(&run->source, text, sizeof(text)) ? warn_of_colour(run, text)
                                                             : APP_DONE;
}

/* Methods whose steps are as long along columns as along rows. */
static bool is_blind_to_aspect(int32_t method)
{
    return method == RF_METHOD_MIPMAP || method == RF_METHOD_MIPMAP_OFFSET ||
           method == RF_METHOD_RECURSIVE_OFFSET;
}

int filter_warn_aspect(const struct run *run)
{
    const struct rf_params *params = &run->params;
    if (params->pixel_aspect == 1 || !is_blind_to_aspect(params->method))
        return APP_DONE;
    return app_warn(run->tool->host, run->error,
                    "--pixel-aspect: the method %s blurs as if pixels were square, not "
                    "%g times as wide as high; box, lowres and offset know better",
                    rf_method_find(params->method)->name, params->pixel_aspect);
}

static bool is_read(const void *user, const struct rf_param_info *info)
{
    return !why_unread(user, info);
}

int filter_warn_window(const struct run *run)
{
    char text[2400]; /* the path is in it twice */
    const struct look_window given = {.source = &run->source,
                                      .settings = run->settings,
                                      .is_scene = run->tool->scene != NULL,
                                      .is_read = is_read,
                                      .user = run};
    return look_window_explain(&given, text, sizeof(text))
               ? app_warn(run->tool->host, run->error, "%s", text)
               : APP_DONE;
}

/* ---- radii ------------------------------------------------------------------------
 */

static bool is_missing(const struct run *run, const char *key)
{
    return settings_origin(run->settings, key) == ORIGIN_DEFAULT &&
           !why_unread(run, rf_param_find(key));
}

/* Without these a lens is a guess; the others are, with them, often right. */
static bool is_lens_missing(const struct run *run)
{
    return is_missing(run, "focus-distance") || is_missing(run, "f-stop");
}

/* Is there anybody to hear of it? Quiet and strict is a warning that ends the run. */
static bool is_heard(const struct run *run)
{
    const struct app_host *host = run->tool->host;
    return host && (host->say || host->warn);
}

void filter_measure_radii(struct run *run)
{
    if (!is_heard(run) || (is_mean(run) && !run->tool->output_coc))
        return;
    const struct source *source = &run->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    /* A remark: without memory for it there is none. */
    float *radii = app_memory(n, sizeof(float), NULL);
    if (!radii)
        return;
    const struct rf_image depth =
        rf_image_packed(run->depth, source->width, source->height, 1);
    const struct rf_image out =
        rf_image_packed(radii, source->width, source->height, 1);
    if (rf_filter_coc(run->filter, &depth, &out, NULL) == RF_OK) {
        run->has_radii = true;
        run->least_radius = INFINITY;
        run->most_radius = -INFINITY;
        run->largest_hit = 0;
        for (size_t i = 0; i < n; i++) {
            run->least_radius = fmin(run->least_radius, radii[i]);
            run->most_radius = fmax(run->most_radius, radii[i]);
            if (isfinite(run->depth[i]))
                run->largest_hit = fmax(run->largest_hit, fabs((double)radii[i]));
        }
        run->largest_radius = fmax(fabs(run->least_radius), fabs(run->most_radius));
        if (!run->is_deep && run->colour)
            depth_fit_find(&run->fit, &(struct depth_fit_picture){
                                          run->colour, radii, source->n_channels,
                                          source->width, source->height});
    }
    free(radii);
}

/* ---- values that nobody gave ------------------------------------------------------
 */

/* Lists of values that nobody gave, and of the options for them. */
struct missing {
    char taken[256], give[160];
};

/* Adds a parameter that nobody gave, its value between two texts. */
static void add_missing(struct missing *missing, const struct run *run, const char *key,
                        const char *before, const char *after)
{
    char value[64], word[128];
    if (!is_missing(run, key))
        return;
    rf_params_get(&run->settings->params, key, value, sizeof(value));
    snprintf(word, sizeof(word), "%s%s%s", before, value, after);
    append(missing->taken, sizeof(missing->taken), word);
    snprintf(word, sizeof(word), "--%s", key);
    append(missing->give, sizeof(missing->give), word);
}

int filter_warn_defaults(const struct run *run)
{
    static const struct {
        const char *key, *before, *after;
    } facts[] = {{"focus-distance", "focus distance ", ""},
                 {"f-stop", "f/", ""},
                 {"focal-length", "focal length ", " mm"},
                 {"sensor-width", "sensor ", " mm wide"},
                 {"unit-scale", "", " units per metre"}};
    struct missing missing = {"", ""};
    if (!is_lens_missing(run) || !(run->has_radii || run->windows))
        return APP_DONE;
    for (size_t i = 0; i < sizeof(facts) / sizeof(facts[0]); i++)
        add_missing(&missing, run, facts[i].key, facts[i].before, facts[i].after);
    return app_warn(run->tool->host, run->error,
                    "%s: its header does not say all of the camera; taken are %s; the "
                    "largest radius is %.1f px; give %s where that is not meant",
                    image_path(run->source.colour), missing.taken, run->largest_radius,
                    missing.give);
}

int filter_warn_target(const struct run *run)
{
    const struct settings *settings = run->settings;
    const double focus = settings->params.focus_distance;
    if (why_unread(run, rf_param_find("focus-distance")))
        return APP_DONE;
    if (settings_is_by(settings, "focus-distance", camera_facts_redshift))
        return app_warn(run->tool->host, run->error,
                        "%s: the focus is %g away, by %s of its header; give "
                        "--focus-distance where something else is to be sharp",
                        image_path(run->source.colour), focus, camera_facts_redshift);
    if (!settings_is_by(settings, "focus-distance", camera_facts_target))
        return APP_DONE;
    return app_warn(
        run->tool->host, run->error,
        "%s: the focus is at the camera's target, %g away, since its header "
        "says nothing else of it; give --focus-distance where something "
        "else is to be sharp",
        image_path(run->source.colour), focus);
}

/* Whole pixels and rounded numbers of a header are nearer to each other. */
static const double SAME_VIEW = 0.02;

int filter_warn_view(const struct run *run)
{
    const struct settings *settings = run->settings;
    const struct image_box *display = &run->source.info.display_window;
    const double width_px = (double)display->max_x - display->min_x + 1;
    const double focal_px = rf_filter_lens(run->filter)->focal_length_px;
    const double seen_width = width_px / focal_px;
    if (settings->seen_width == 0 ||
        settings->params.projection == RF_PROJECTION_ORTHOGRAPHIC ||
        fabs(seen_width - settings->seen_width) <= SAME_VIEW * settings->seen_width)
        return APP_DONE;
    return app_warn(run->tool->host, run->error,
                    "%s: by the options %.4g units are seen side by side at a distance "
                    "of 1, by %s of its header %.4g; with --focal-length %g say "
                    "--sensor-width %.4g, or neither",
                    image_path(run->source.colour), seen_width, settings->seen_by,
                    settings->seen_width, settings->params.focal_length,
                    settings->seen_width * settings->params.focal_length);
}

/* Radii below it are those of a picture that is sharp all over; they grow with the unit
 * scale, up to a thousand units of a metre. */
static const double LEAST_SEEN_PX = 0.5, MOST_UNITS = 1000;

int filter_warn_unit_scale(const struct run *run)
{
    if (is_lens_missing(run) || !is_missing(run, "unit-scale") || run->tool->scene ||
        !(run->has_radii || run->windows) || run->largest_radius >= LEAST_SEEN_PX ||
        MOST_UNITS * run->largest_radius < LEAST_SEEN_PX)
        return APP_DONE;
    return app_warn(run->tool->host, run->error,
                    "%s: next to nothing is blurred, by %.2g px at most, with scene "
                    "units of a metre; say --unit-scale 100 where they are "
                    "centimetres, 1000 where millimetres, 39.37 where inches, or "
                    "--unit-scale 1 if it is meant so",
                    image_path(run->source.colour), run->largest_radius);
}

int filter_warn_ends(const struct run *run)
{
    struct missing missing = {"", ""};
    char kind[40];
    if (!rf_method_find(run->params.method)->needs_depth)
        return APP_DONE;
    add_missing(&missing, run, "depth-near", "depth-near ", "");
    add_missing(&missing, run, "depth-far", "depth-far ", "");
    if (!*missing.give)
        return APP_DONE;
    rf_params_get(&run->settings->params, "depth", kind, sizeof(kind));
    return app_warn(run->tool->host, run->error,
                    "%s: nobody said which distances the ends of the %s depth stand "
                    "for; taken are %s; give %s",
                    image_path(run->source.depth), kind, missing.taken, missing.give);
}

/* Does the blur of something that has a depth reach the largest radius? What is
 * infinitely far has an infinite blur before an orthographic camera, and looks the same
 * from all over the lens. */
static bool is_cut(const struct run *run)
{
    const struct rf_lens *lens = rf_filter_lens(run->filter);
    const double most = lens->max_radius_px;
    if (!(run->has_radii || run->windows) || run->largest_radius < most)
        return false;
    if (run->params.projection != RF_PROJECTION_ORTHOGRAPHIC)
        return true;
    if (run->has_radii)
        return run->largest_hit >= most;
    struct doubts_range range = {.n_hits = 0};
    if (run->doubts)
        doubts_find_range(run->doubts, &range);
    return range.n_hits > 0 && (fabs(rf_lens_radius_px(lens, range.nearest)) >= most ||
                                fabs(rf_lens_radius_px(lens, range.farthest)) >= most);
}

int filter_warn_cut(const struct run *run)
{
    const struct filter_options *tool = run->tool;
    const double most = rf_filter_lens(run->filter)->max_radius_px;
    if (run->settings->params.max_radius > 0 || !is_cut(run))
        return APP_DONE;
    return app_warn(tool->host, run->error,
                    "%s: the blur is cut at a radius of %.4g px, half the longer side; "
                    "--max-radius allows more, up to 16384",
                    tool->scene ? tool->scene : image_path(run->source.colour),
                    tool->scene_samples > 1 ? most / tool->scene_samples : most);
}

/* Half a pixel of parallax beside the views' merge is seen. The preview of eight views
 * that begin at a quarter of the lens has 25 dB where one view of its middle has 37. */
static const double LEAST_PARALLAX_PX = 0.5;

int filter_warn_shown_view(const struct run *run)
{
    const double lens_radius = rf_filter_lens(run->filter)->lens_radius;
    double least = INFINITY;
    for (int i = 0; i < run->views.n; i++) {
        const double *offset = run->views.views[i].lens_offset;
        least = fmin(least, hypot(offset[0], offset[1]));
    }
    const double samples = run->tool->scene_samples > 1 ? run->tool->scene_samples : 1;
    const double parallax_px = least / lens_radius * run->largest_radius / samples;
    if (!run->has_views || run->params.quality != RF_QUALITY_PREVIEW ||
        run->params.method != RF_METHOD_VIEWS || !(run->has_radii || run->windows) ||
        !(parallax_px >= LEAST_PARALLAX_PX))
        return APP_DONE;
    return app_warn(run->tool->host, run->error,
                    "--quality preview: shows the nearest of the views alone, taken "
                    "%.3g beside the middle of the aperture: things lie up to %.3g px "
                    "beside their places; --quality normal merges the views",
                    least, parallax_px);
}

/* ---- other layers -----------------------------------------------------------------
 */

int filter_warn_layers(const struct run *run)
{
    static const char *const of_picture[] = {"blend-gamma", "highlight-clamp",
                                             "highlight-threshold", "highlight-gain",
                                             "highlight-saturation"};
    char names[160] = "";
    if (!run->tool->filter_layers)
        return APP_DONE;
    for (size_t i = 0; i < sizeof(of_picture) / sizeof(of_picture[0]); i++) {
        char name[40];
        snprintf(name, sizeof(name), "--%s", of_picture[i]);
        if (!is_default(&run->params, of_picture[i]) &&
            rf_param_is_read(&run->params, of_picture[i], NULL))
            append(names, sizeof(names), name);
    }
    if (!*names)
        return APP_DONE;
    return app_warn(run->tool->host, run->error,
                    "--filter-layers: the layers are filtered in plain linear light, "
                    "without what %s made of the picture: they do not add up to it",
                    names);
}

/* ---- what was done ----------------------------------------------------------------
 */

static void describe_aperture(const struct run *run, char *text, size_t n_bytes)
{
    const struct rf_params *params = &run->settings->params;
    if (rf_param_is_read(params, "f-stop", NULL))
        snprintf(text, n_bytes, "f/%g, %g mm", params->f_stop, params->focal_length);
    else
        snprintf(text, n_bytes, "lens radius %g",
                 rf_filter_lens(run->filter)->lens_radius);
}

/* From such a radius on a blur is seen. */
static const double SEEN_PX = 1;

/* What the lens made of the picture. */
static void describe_lens(const struct run *run, char *text, size_t n_bytes)
{
    char aperture[80], radii[80] = "";
    if (is_mean(run)) {
        const int n = filter_n_views(run);
        snprintf(text, n_bytes, "mean of %d view%s", n, n == 1 ? "" : "s");
        return;
    }
    describe_aperture(run, aperture, sizeof(aperture));
    if (run->has_radii)
        snprintf(radii, sizeof(radii), ", radii %.1f to %.1f px%s", run->least_radius,
                 run->most_radius,
                 run->least_radius > SEEN_PX || run->most_radius < -SEEN_PX
                     ? ", nothing in focus"
                     : "");
    else if (run->largest_radius > 0)
        snprintf(radii, sizeof(radii), ", radii up to %.1f px", run->largest_radius);
    snprintf(text, n_bytes, "focus %g, %s%s",
             rf_filter_lens(run->filter)->focus_distance, aperture, radii);
}

void filter_say_done(const struct run *run)
{
    const struct rf_params *params = &run->settings->params;
    char lens[240], method[40];
    describe_lens(run, lens, sizeof(lens));
    rf_params_get(params, "method", method, sizeof(method));
    const struct filter_options *tool = run->tool;
    char shared[80] = "";
    if (run->shared_views > 0)
        snprintf(shared, sizeof(shared), ", grain: %.1f of %d views share a pixel",
                 run->shared_views, run->views.n);
    char seen[160], white[40] = "";
    if (params->white != 1)
        snprintf(white, sizeof(white), ", white %g", params->white);
    seen_describe(&run->seen, seen, sizeof(seen));
    app_say(tool->host, "%s: %s, method %s%s%s%s",
            tool->shown_output ? tool->shown_output : tool->output, lens, method, white,
            shared, seen);
}
