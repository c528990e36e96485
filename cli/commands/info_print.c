/* SPDX-License-Identifier: Apache-2.0 */
#include "commands/info_print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "console/cli.h"
#include "console/json.h"
#include "sources/views.h"

void info_count_radii(struct info *info, const float *radii)
{
    const size_t n = (size_t)info->source.width * (size_t)info->source.height;
    size_t n_sharp = 0;
    info->min_radius_px = INFINITY;
    info->max_radius_px = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        info->min_radius_px = fmin(info->min_radius_px, radii[i]);
        info->max_radius_px = fmax(info->max_radius_px, radii[i]);
        n_sharp += fabs((double)radii[i]) <= info->lens.coc_limit_px;
    }
    info->sharp_share = (double)n_sharp / (double)n;
    info->has_radii = true;
}

/* Samples of one pixel that an opaque one hides; depths must grow with distance. */
static size_t count_hidden(const struct rf_deep_sample *samples, size_t n)
{
    float opaque = INFINITY;
    size_t n_hidden = 0;
    for (size_t i = 0; i < n; i++)
        if (samples[i].opacity >= 0.999f)
            opaque = fminf(opaque, samples[i].depth);
    for (size_t i = 0; i < n; i++)
        n_hidden += samples[i].depth > opaque;
    return n_hidden;
}

void info_count_deep(struct info *info, const struct rf_deep *frame)
{
    const size_t n_pixels = (size_t)frame->width * (size_t)frame->height;
    info->deep.n_samples = frame->first[n_pixels];
    for (size_t i = 0; i < n_pixels; i++) {
        const struct rf_deep_sample *samples = frame->samples + frame->first[i];
        const size_t n = frame->first[i + 1] - frame->first[i];
        info->deep.n_empty += n == 0;
        if (n > info->deep.most_samples)
            info->deep.most_samples = n;
        info->deep.n_hidden += count_hidden(samples, n);
        for (size_t k = 0; k < n; k++)
            info->deep.n_volumes += samples[k].depth_back > samples[k].depth;
    }
}

static const char *type_name(enum image_sample_type type)
{
    return ((const char *const[]){"half", "float", "uint"})[type];
}

static bool filtered_by(const struct info *info, const char **text)
{
    return image_attribute_string(info->source.colour, "rackfocus:filtered", text);
}

static double share(const struct info *info, size_t n)
{
    return (double)n / (double)info->depth.stats.n_pixels;
}

/* ---- text ----------------------------------------------------------------------- */

static void print_box(const char *name, const struct image_box *box)
{
    printf("  %-16s %d x %d at (%d, %d)\n", name, box->max_x - box->min_x + 1,
           box->max_y - box->min_y + 1, box->min_x, box->min_y);
}

static const char *part_kind(const struct image_part_info *part)
{
    if (part->is_deep)
        return part->is_tiled ? "deep tiles" : "deep scan lines";
    return part->is_tiled ? "tiles" : "scan lines";
}

static void print_file(const struct image_input *input)
{
    int n_parts, n_channels;
    const struct image_part_info *parts = image_parts(input, &n_parts);
    const struct image_channel_info *channels = image_channels(input, &n_channels);
    printf("%s\n", message_shown(image_path(input)));
    for (int p = 0; p < n_parts; p++) {
        printf("  part %d%s%s: %s, %s%s%s\n", p, *parts[p].name ? " " : "",
               parts[p].name, part_kind(&parts[p]), parts[p].compression,
               *parts[p].view ? ", view " : "", parts[p].view);
        print_box("data window", &parts[p].data_window);
        print_box("display window", &parts[p].display_window);
        printf("  %-16s %g\n", "pixel aspect", parts[p].pixel_aspect);
        if (parts[p].environment)
            printf("  %-16s %s\n", "environment map", parts[p].environment);
        printf("  %-16s", "channels");
        for (int c = 0; c < n_channels; c++)
            if (channels[c].part == p)
                printf(" %s (%s)", channels[c].name, type_name(channels[c].type));
        putchar('\n');
    }
}

static void print_point(const struct info *info, const char *name, const double at[2],
                        double shear)
{
    printf("  %-16s (%g, %g) on the lens, scene units right and up", name, at[0],
           at[1]);
    if (info->has_lens && info->lens.lens_radius > 0)
        printf(", at %.0f %% of its radius",
               100 * hypot(at[0], at[1]) / info->lens.lens_radius);
    if (shear > 0)
        printf("; sheared at distance %g\n", shear);
    else
        printf("; parallel to the axis\n");
}

/* Where on the lens the view, or each view of a multi-view file, was taken. */
static void print_place(const struct info *info)
{
    char label[80];
    double at[2], shear;
    const struct image_input *input = info->source.colour;
    const int n_views = image_view_count(input);
    for (int i = 0; i < n_views && n_views > 1; i++) {
        const char *name = image_view_name(input, i);
        snprintf(label, sizeof(label), "view %.60s", name);
        if (views_find_place(input, name, at, &shear))
            print_point(info, label, at, shear);
        else
            printf("  %-16s the header has no place on the lens\n", label);
    }
    if (n_views < 2 && views_find_place(input, NULL, at, &shear))
        print_point(info, "view from", at, shear);
}

static void print_choice_of_channels(const struct info *info)
{
    int n;
    const struct source *source = &info->source;
    const struct image_layer *layer = &source->layer;
    printf("\nUsed\n");
    if (layer->r >= 0)
        printf("  %-16s %s%s%s\n", "colour",
               *layer->name       ? layer->name
               : source->is_grey  ? "Y"
               : layer->is_chroma ? "Y RY BY"
                                  : "R G B",
               layer->a >= 0 ? ", with alpha" : "", source->is_grey ? ", grey" : "");
    else
        printf("  %-16s none\n", "colour");
    char doubt[500];
    if (source_has_only_data(source, doubt, sizeof(doubt)))
        printf("  %-16s %s\n", "filter refuses", doubt);
    else if (source_is_doubtful(source, doubt, sizeof(doubt)))
        printf("  %-16s the picture %s\n", "filter warns", doubt);
    if (info->is_straight)
        printf("  %-16s colour is not multiplied by alpha (straight, unassociated)\n",
               "filter warns");
    if (source->z >= 0)
        printf("  %-16s %s of %s\n", "depth",
               image_channels(source->depth, &n)[source->z].name,
               message_shown(image_path(source->depth)));
    else
        printf("  %-16s none; name it with --depth-channel or --depth-file\n", "depth");
    const char *text;
    if (filtered_by(info, &text))
        printf("  %-16s by %s\n", "already filtered", text);
    print_place(info);
}

/* The parameter that takes the effect of `key` away, or NULL. */
static const char *overruled_by(const struct rf_params *params, const char *key)
{
    const bool is_sensor =
        strcmp(key, "sensor-width") == 0 || strcmp(key, "sensor-height") == 0;
    if (strcmp(key, "f-stop") == 0 && params->lens_radius > 0)
        return "lens-radius";
    if (is_sensor && params->focal_length_px > 0)
        return "focal-length-px";
    return NULL;
}

static double param_number(const struct rf_params *params,
                           const struct rf_param_info *info)
{
    const char *member = (const char *)params + info->offset;
    return info->type == RF_TYPE_FLOAT ? *(const double *)member
                                       : *(const int32_t *)member;
}

/* A float of a header in decimals that read back to that float: 2.2, not 2.2000000477.
 */
static void shorten_float(double number, char *text, size_t n_bytes)
{
    if ((double)(float)number != number)
        return;
    for (int digits = 6; digits <= 9; digits++) {
        snprintf(text, n_bytes, "%.*g", digits, number);
        if (strtof(text, NULL) == (float)number)
            break;
    }
    for (char *comma = strchr(text, ','); comma; comma = NULL)
        *comma = '.';
}

static void print_param(const struct info *info, const struct rf_param_info *param)
{
    char value[64], origin[160], both[128];
    const char *why_not;
    const struct rf_params *params = &info->settings.params;
    rf_params_get(params, param->key, value, sizeof(value));
    if (param->type == RF_TYPE_FLOAT)
        shorten_float(param_number(params, param), value, sizeof(value));
    settings_describe_origin(&info->settings, param->key, origin, sizeof(origin));
    const bool has_unit = param->unit[0] && param->unit[0] != '1';
    snprintf(both, sizeof(both), "%s%s%s", value, has_unit ? " " : "",
             has_unit ? param->unit : "");
    const char *by = overruled_by(params, param->key);
    printf("  %-20s %-28s %s", param->key, both, origin);
    if (by)
        printf(" (overruled by %s)", by);
    else if (!rf_param_is_read(params, param->key, &why_not) &&
             settings_origin(&info->settings, param->key) != ORIGIN_DEFAULT)
        printf(" (%s)", why_not);
    putchar('\n');
}

static void print_params(const struct info *info)
{
    static const char *const titles[] = {"Lens", "Aperture", "Depth", "Method",
                                         "Highlights"};
    size_t n;
    const struct rf_param_info *params = rf_param_list(&n);
    for (int group = 0; group < (int)(sizeof(titles) / sizeof(titles[0])); group++) {
        printf("\n%s\n", titles[group]);
        for (size_t i = 0; i < n; i++)
            if ((int)params[i].group == group)
                print_param(info, &params[i]);
    }
}

/* Without these there is no lens, whoever gave them. */
static bool is_of_lens(const char *key)
{
    static const char *const keys[] = {"focus-distance", "f-stop", "focal-length",
                                       "method"};
    for (size_t i = 0; i < sizeof(keys) / sizeof(keys[0]); i++)
        if (strcmp(keys[i], key) == 0)
            return true;
    return false;
}

/* What somebody gave, and what a lens cannot do without. */
static void print_main_params(const struct info *info)
{
    size_t n, n_left = 0;
    const struct rf_param_info *params = rf_param_list(&n);
    printf("\nParameters\n");
    for (size_t i = 0; i < n; i++) {
        const char *key = params[i].key;
        const bool is_given = settings_origin(&info->settings, key) != ORIGIN_DEFAULT;
        const bool is_read = rf_param_is_read(&info->settings.params, key, NULL);
        if (is_given || (is_of_lens(key) && is_read))
            print_param(info, &params[i]);
        else
            n_left++;
    }
    printf("  %zu others have their defaults; --all shows them\n", n_left);
}

static void print_depth(const struct info *info)
{
    const struct rf_depth_stats *stats = &info->depth.stats;
    const char *reason = stats->kind_reason;
    const char *guess = rf_param_find("depth")->choices[stats->kind].name;
    printf("\nDepth channel\n");
    if (info->source.info.is_deep)
        printf("  %-20s %zu, at most %zu in a pixel, %zu volumes, %zu behind opaque "
               "ones; %zu pixels are empty\n",
               "deep samples", info->deep.n_samples, info->deep.most_samples,
               info->deep.n_volumes, info->deep.n_hidden, info->deep.n_empty);
    if (stats->min <= stats->max)
        printf("  %-20s %g to %g, median %g\n", "range", stats->min, stats->max,
               stats->median);
    printf("  %-20s %.2f %% of the pixels\n", "nothing hit",
           100 * share(info, stats->n_no_hit + info->depth.numbers.n_far));
    if (stats->n_nan)
        printf("  %-20s %zu pixels\n", "NaN", stats->n_nan);
    if (stats->n_negative)
        printf("  %-20s %zu pixels\n", "negative", stats->n_negative);
    printf("  %-20s %s: %s\n", "looks like", guess, reason);
    if (stats->n_zero && info->settings.params.depth <= RF_DEPTH_RADIAL)
        printf("  %-20s %.2f %% of the pixels, taken as nothing hit\n", "exactly 0",
               100 * share(info, stats->n_zero));
    if (stats->is_mixed)
        printf("  %-20s anti-aliased: %.0f %% of the pixels at depth steps lie between "
               "both sides; filter gives them the depth of one\n",
               "suspicion", 100 * stats->mixed_share);
    if (stats->is_premultiplied)
        printf("  %-20s premultiplied by alpha: %.0f %% of the part-covered pixels; "
               "filter divides by it\n",
               "suspicion", 100 * stats->premultiplied_share);
    if (info->depth.is_widened)
        printf("  %-20s wider than what is seen: the last pixels of near things show "
               "%.0f %% of them; filter gives such pixels the depth behind\n",
               "suspicion", 100 * stats->near_shares[0]);
    if (info->depth.is_speckled)
        printf(
            "  %-20s holes in %.0f %% of surfaces, scattered as fog has them; filter "
            "gives them the depth around them\n",
            "suspicion", 100 * stats->hole_share);
    if (info->depth.is_half)
        printf("  %-20s 16 bit: radii come in steps of up to %.2g px\n", "precision",
               info->depth.half_step_px);
    char text[700];
    if (depth_is_refused(&info->depth, text, sizeof(text)))
        printf("  %-20s the depth %s\n", "filter refuses", text);
    else if (depth_is_doubtful(&info->depth, text, sizeof(text)))
        printf("  %-20s the depth %s\n", "filter warns", text);
    if (source_explains_depth(&info->source, text, sizeof(text)))
        printf("  %-20s the depth %s\n", "filter warns", text);
}

static void print_lens(const struct info *info)
{
    double near_limit, far_limit;
    const struct rf_lens *lens = &info->lens;
    printf("\nBlur\n");
    if (!info->has_lens) {
        printf("  none: %s\n", info->lens_problem);
        return;
    }
    printf("  %-20s %g scene units\n", "lens radius", lens->lens_radius);
    if (lens->projection == RF_PROJECTION_ORTHOGRAPHIC)
        printf("  %-20s %g px per scene unit\n", "scale", lens->px_per_unit);
    else
        printf("  %-20s %g px\n", "focal length", lens->focal_length_px);
    rf_lens_depth_of_field(lens, &near_limit, &far_limit);
    printf("  %-20s %g scene units\n", "focus distance", lens->focus_distance);
    printf("  %-20s %g to %g scene units (radius up to %g px)\n", "depth of field",
           near_limit, far_limit, lens->coc_limit_px);
    printf("  %-20s %g scene units\n", "hyperfocal distance", rf_lens_hyperfocal(lens));
    if (info->has_radii)
        printf("  %-20s %.2f to %.2f px, %.1f %% of the pixels sharp\n", "radius",
               info->min_radius_px, info->max_radius_px, 100 * info->sharp_share);
    else if (*info->radius_problem)
        printf("  %-20s unknown: %s\n", "radius", info->radius_problem);
}

void info_print_text(const struct info *info, bool is_all)
{
    print_file(info->source.colour);
    if (info->source.depth && info->source.depth != info->source.colour)
        print_file(info->source.depth);
    print_choice_of_channels(info);
    print_lens(info);
    if (info->has_stats)
        print_depth(info);
    if (is_all)
        print_params(info);
    else
        print_main_params(info);
}

/* ---- JSON ----------------------------------------------------------------------- */

static void json_box(struct json *json, const char *name, const struct image_box *box)
{
    const int32_t values[4] = {box->min_x, box->min_y, box->max_x, box->max_y};
    json_open(json, name, '[');
    for (int i = 0; i < 4; i++)
        json_number(json, NULL, values[i]);
    json_close(json, ']');
}

static void json_file(struct json *json, const struct image_input *input)
{
    int n_parts, n_channels;
    const struct image_part_info *parts = image_parts(input, &n_parts);
    const struct image_channel_info *channels = image_channels(input, &n_channels);
    json_open(json, NULL, '{');
    json_text(json, "path", message_shown(image_path(input)));
    json_open(json, "parts", '[');
    for (int p = 0; p < n_parts; p++) {
        json_open(json, NULL, '{');
        json_text(json, "name", parts[p].name);
        json_text(json, "view", parts[p].view);
        json_text(json, "compression", parts[p].compression);
        json_bool(json, "tiled", parts[p].is_tiled);
        json_bool(json, "deep", parts[p].is_deep);
        json_box(json, "data_window", &parts[p].data_window);
        json_box(json, "display_window", &parts[p].display_window);
        json_number(json, "pixel_aspect", parts[p].pixel_aspect);
        json_text(json, "environment",
                  parts[p].environment ? parts[p].environment : "");
        json_open(json, "channels", '[');
        for (int c = 0; c < n_channels; c++) {
            if (channels[c].part != p)
                continue;
            json_open(json, NULL, '{');
            json_text(json, "name", channels[c].name);
            json_text(json, "type", type_name(channels[c].type));
            json_close(json, '}');
        }
        json_close(json, ']');
        json_close(json, '}');
    }
    json_close(json, ']');
    json_close(json, '}');
}

static void json_params(struct json *json, const struct settings *settings)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    json_open(json, "parameters", '{');
    for (size_t i = 0; i < n; i++) {
        char value[64], origin[160];
        const double number = param_number(&settings->params, &list[i]);
        rf_params_get(&settings->params, list[i].key, value, sizeof(value));
        settings_describe_origin(settings, list[i].key, origin, sizeof(origin));
        json_open(json, list[i].key, '{');
        if (list[i].choices)
            json_text(json, "value", value);
        else if (list[i].type == RF_TYPE_BOOL)
            json_bool(json, "value", number != 0);
        else
            json_number(json, "value", number);
        json_text(json, "origin", origin);
        json_close(json, '}');
    }
    json_close(json, '}');
}

static void json_depth(struct json *json, const struct info *info)
{
    const struct rf_depth_stats *stats = &info->depth.stats;
    const char *reason = stats->kind_reason;
    const char *guess = rf_param_find("depth")->choices[stats->kind].name;
    const bool has_range = stats->min <= stats->max;
    json_open(json, "depth", '{');
    json_number(json, "min", has_range ? stats->min : NAN);
    json_number(json, "max", has_range ? stats->max : NAN);
    json_number(json, "median", stats->median);
    json_number(json, "no_hit_share",
                share(info, stats->n_no_hit + info->depth.numbers.n_far));
    json_number(json, "n_nan", (double)stats->n_nan);
    json_number(json, "n_negative", (double)stats->n_negative);
    json_text(json, "guess", guess);
    json_text(json, "reason", reason);
    json_bool(json, "anti_aliased", stats->is_mixed);
    json_bool(json, "premultiplied", stats->is_premultiplied);
    json_bool(json, "widened", info->depth.is_widened);
    json_bool(json, "speckled", info->depth.is_speckled);
    json_number(json, "zero_share", share(info, stats->n_zero));
    json_bool(json, "half", info->depth.is_half);
    json_number(json, "half_step_px", info->depth.half_step_px);
    json_bool(json, "mist", info->depth.is_mist);
    char text[700];
    if (depth_is_refused(&info->depth, text, sizeof(text)))
        json_text(json, "refused", text);
    json_close(json, '}');
}

static void json_deep(struct json *json, const struct info *info)
{
    json_open(json, "deep", '{');
    json_number(json, "n_samples", (double)info->deep.n_samples);
    json_number(json, "most_samples", (double)info->deep.most_samples);
    json_number(json, "n_volumes", (double)info->deep.n_volumes);
    json_number(json, "n_hidden", (double)info->deep.n_hidden);
    json_number(json, "n_empty", (double)info->deep.n_empty);
    json_close(json, '}');
}

static void json_lens(struct json *json, const struct info *info)
{
    double near_limit, far_limit;
    const struct rf_lens *lens = &info->lens;
    rf_lens_depth_of_field(lens, &near_limit, &far_limit);
    json_open(json, "lens", '{');
    json_number(json, "lens_radius", lens->lens_radius);
    json_number(json, "focal_length_px", lens->focal_length_px);
    json_number(json, "px_per_unit", lens->px_per_unit);
    json_number(json, "focus_distance", lens->focus_distance);
    json_number(json, "near_limit", near_limit);
    json_number(json, "far_limit", far_limit);
    json_number(json, "hyperfocal_distance", rf_lens_hyperfocal(lens));
    json_number(json, "min_radius_px", info->has_radii ? info->min_radius_px : NAN);
    json_number(json, "max_radius_px", info->has_radii ? info->max_radius_px : NAN);
    json_number(json, "sharp_share", info->has_radii ? info->sharp_share : NAN);
    json_close(json, '}');
}

static void json_point(struct json *json, const double at[2], double shear)
{
    json_open(json, "lens_offset", '[');
    json_number(json, NULL, at[0]);
    json_number(json, NULL, at[1]);
    json_close(json, ']');
    json_number(json, "shear_distance", shear);
}

/* The views of a multi-view file, and where on the lens the picture was taken. */
static void json_place(struct json *json, const struct info *info)
{
    double at[2], shear;
    const struct image_input *input = info->source.colour;
    const int n_views = image_view_count(input);
    if (n_views > 0) {
        json_open(json, "views", '[');
        for (int i = 0; i < n_views; i++) {
            json_open(json, NULL, '{');
            json_text(json, "name", image_view_name(input, i));
            if (views_find_place(input, image_view_name(input, i), at, &shear))
                json_point(json, at, shear);
            json_close(json, '}');
        }
        json_close(json, ']');
    }
    if (n_views > 1 || !views_find_place(input, NULL, at, &shear))
        return;
    json_open(json, "view", '{');
    json_point(json, at, shear);
    json_close(json, '}');
}

void info_print_json(const struct info *info)
{
    int n;
    struct json json = {0};
    const struct source *source = &info->source;
    const char *text;
    json_open(&json, NULL, '{');
    json_open(&json, "files", '[');
    json_file(&json, source->colour);
    if (source->depth && source->depth != source->colour)
        json_file(&json, source->depth);
    json_close(&json, ']');
    json_number(&json, "width", source->width);
    json_number(&json, "height", source->height);
    json_bool(&json, "has_colour", source->layer.r >= 0);
    json_text(&json, "layer", source->layer.name);
    json_bool(&json, "has_alpha", source->layer.a >= 0);
    if (source->z >= 0)
        json_text(&json, "depth_channel",
                  image_channels(source->depth, &n)[source->z].name);
    json_bool(&json, "filtered", filtered_by(info, &text));
    json_place(&json, info);
    json_params(&json, &info->settings);
    if (info->source.info.is_deep && info->has_stats)
        json_deep(&json, info);
    if (info->has_stats)
        json_depth(&json, info);
    if (info->has_lens)
        json_lens(&json, info);
    else
        json_text(&json, "lens_problem", info->lens_problem);
    if (*info->radius_problem)
        json_text(&json, "radius_problem", info->radius_problem);
    json_close(&json, '}');
}
