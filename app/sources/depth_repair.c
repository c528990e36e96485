/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/depth_repair.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/report.h"

/* Half floats have 11 bits: neighbours differ by up to 2^-10 of their value. */
#define HALF_STEP (1.0 / 1024)

/* Words in names of channels whose numbers are no distances, as 3ds Max's VRayZDepth_Invert,
 * a copy for viewing. */
static bool names_other(const char *channel)
{
    static const char *const words[] = {"invert",   "inverse",  "disparity",
                                        "normalis", "normaliz", NULL};
    for (int i = 0; words[i]; i++)
        if (strcasestr(channel, words[i]))
            return true;
    return false;
}

/* Px, Py and Pz are a position, of the camera's space (pbrt's default) or of the world's. */
static bool is_position(const struct source *source, const char *channel)
{
    int n;
    char first[256];
    const struct image_channel_info *channels = image_channels(source->depth, &n);
    const size_t length = strlen(channel);
    if (length < 2 || strcmp(channel + length - 2, "Pz") != 0)
        return false;
    snprintf(first, sizeof(first), "%.*sx", (int)length - 1, channel);
    for (int i = 0; i < n; i++)
        if (strcmp(channels[i].name, first) == 0)
            return true;
    return false;
}

/* Who names depth along the ray like this: Mitsuba LAYER.T, Karma hitdist, Iray Distance
 * or Distance.X; NULL: nobody. */
static const char *names_of_ray(const char *channel)
{
    static const char word[] = "distance";
    const size_t length = strlen(channel), n = sizeof(word) - 1;
    if (length > 2 && strcmp(channel + length - 2, ".T") == 0)
        return "Mitsuba";
    if (strcasestr(channel, "hitdist"))
        return "Karma";
    for (const char *at = channel; (at = strcasestr(at, word)); at++) {
        const char *end = at + n, *dot = strchr(end, '.');
        if ((at == channel || at[-1] == '.') &&
            (*end == '\0' || (dot == end && !strchr(dot + 1, '.'))))
            return "Iray";
    }
    return NULL;
}

/* What the names of the channels say. */
static void judge_names(struct depth_findings *found, const struct source *source,
                        const struct settings *settings)
{
    int n;
    const struct image_channel_info *channels = image_channels(source->depth, &n);
    const char *name = channels[source->z].name;
    const char *rival = source_has_rival(source) ? channels[source->z_rival].name : "";
    snprintf(found->channel, sizeof(found->channel), "%s", name);
    snprintf(found->rival, sizeof(found->rival), "%s", rival);
    found->is_half = channels[source->z].type == IMAGE_SAMPLE_HALF;
    found->is_uint = channels[source->z].type == IMAGE_SAMPLE_UINT;
    found->is_mist = strcasestr(name, "mist") != NULL;
    found->is_kind_open = settings_origin(settings, "depth") == ORIGIN_DEFAULT;
    found->is_named_other = found->is_kind_open && names_other(name);
    found->is_position = found->is_kind_open && is_position(source, name);
    found->is_of_ray = found->is_kind_open && names_of_ray(name);
}

/* Distances only: of other kinds 16 bit are coarse in their own way. */
static double half_step_px(const struct rf_lens *lens,
                           const struct rf_depth_stats *stats)
{
    double most = 0;
    const double ends[2] = {stats->min, stats->max};
    for (int i = 0; i < 2; i++)
        if (ends[i] > 0 && isfinite(ends[i]))
            most = fmax(most, fabs(rf_lens_radius_px(lens, ends[i] * (1 + HALF_STEP)) -
                                   rf_lens_radius_px(lens, ends[i])));
    return most;
}

/* Nobody scaled them: where somebody did, he knows them. Maps of 16 bit reach their end;
 * what does not is counted in millimetres, as depth cameras do, which is a distance.
 * Numbers that were 16 bit floats are whole from 1024 on: smaller ones must be there. */
static bool is_whole(const struct depth_findings *found,
                     const struct settings *settings)
{
    const struct rf_depth_stats *stats = &found->stats;
    const bool is_scaled = settings->params.depth_scale != 1 ||
                           settings->params.depth_offset != 0 ||
                           settings_origin(settings, "depth-scale") != ORIGIN_DEFAULT;
    return found->is_kind_open && !is_scaled &&
           (stats->max <= 255 || stats->max == 65535) &&
           (found->is_uint || stats->min < 512) &&
           depth_numbers_are_whole(&found->numbers);
}

/* The same distances with a range that is ten times as long, or a hundred times ...; the
 * values that are sky then lie at its end. */
static void rescale(struct depth_findings *found, const struct rf_params *params)
{
    const double times = pow(10, ceil(log10(found->numbers.beyond)));
    int n = snprintf(
        found->rescaled, sizeof(found->rescaled), "--depth-far %.9g --depth-scale %.9g",
        params->depth_near + times * (params->depth_far - params->depth_near),
        params->depth_scale / times);
    if (params->depth_offset != 0)
        snprintf(found->rescaled + n, sizeof(found->rescaled) - (size_t)n,
                 " --depth-offset %.9g", params->depth_offset / times);
}

bool depth_is_turned(const struct rf_params *params)
{
    return params->depth_scale < 0 &&
           (params->depth == RF_DEPTH_PLANAR || params->depth == RF_DEPTH_RADIAL);
}

void depth_turn(float *depth, size_t n, double infinity)
{
    for (size_t i = 0; i < n; i++)
        depth[i] = (double)depth[i] < infinity ? -depth[i] : depth[i];
}

void depth_judge(struct depth_findings *found, const struct source *source,
                 const struct settings *settings, const struct rf_lens *lens,
                 const struct rf_depth_stats *stats,
                 const struct depth_numbers *numbers)
{
    const struct rf_params *params = &settings->params;
    const bool is_distance =
        params->depth == RF_DEPTH_PLANAR || params->depth == RF_DEPTH_RADIAL;
    *found = (struct depth_findings){
        .stats = *stats,
        .numbers = *numbers,
        .is_mixed = stats->is_mixed,
        .is_premultiplied = stats->is_premultiplied,
        .is_speckled = is_distance && stats->is_speckled,
        .is_widened = is_distance && stats->is_widened && !stats->is_mixed,
        .is_negative = (is_distance || params->depth_offset == 0) &&
                       params->depth_scale > 0 && stats->n_negative > 0 &&
                       !(stats->max > 0),
        .is_turned = depth_is_turned(params),
        .ratio = depth_ratio_of(params),
    };
    judge_names(found, source, settings);
    found->is_whole = is_whole(found, settings);
    if (numbers->n_beyond > 0)
        rescale(found, params);
    if (found->is_half && is_distance && lens)
        found->half_step_px = half_step_px(lens, stats);
}

/* Are there averages, in numbers whose ratios tell steps? False without memory. */
static bool measure_ratios(const struct depth_ratio *ratio,
                           const struct rf_depth_channel *channel,
                           struct rf_depth_stats *stats)
{
    const size_t n = (size_t)channel->width * (size_t)channel->height;
    struct rf_depth_stats found = {.size = sizeof(found)};
    struct rf_depth_channel other = *channel;
    other.depth = app_memory(n, sizeof(float), NULL);
    if (!other.depth)
        return false;
    memcpy(other.depth, channel->depth, n * sizeof(float));
    depth_ratio_make(ratio, other.depth, n);
    const bool is_measured = rf_depth_measure(NULL, &other, &found, NULL) == RF_OK;
    free(other.depth);
    depth_take_ratios(stats, &found);
    return is_measured;
}

void depth_take_ratios(struct rf_depth_stats *stats,
                       const struct rf_depth_stats *ratios)
{
    stats->is_mixed = ratios->is_mixed;
    stats->mixed_share = ratios->mixed_share;
}

bool depth_measure(const struct rf_params *params,
                   const struct rf_depth_channel *channel, struct rf_depth_stats *stats)
{
    const size_t n = (size_t)channel->width * (size_t)channel->height;
    const struct depth_ratio ratio = depth_ratio_of(params);
    const bool is_turned = depth_is_turned(params);
    *stats = (struct rf_depth_stats){.size = sizeof(*stats)};
    if (is_turned)
        depth_turn(channel->depth, n, channel->infinity);
    const bool is_measured = rf_depth_measure(NULL, channel, stats, NULL) == RF_OK;
    if (is_turned)
        depth_turn(channel->depth, n, channel->infinity);
    return is_measured && (ratio.factor == 0 || measure_ratios(&ratio, channel, stats));
}

bool depth_find(struct depth_findings *found, const struct source *source,
                const struct settings *settings, const struct rf_lens *lens,
                const struct rf_depth_channel *channel)
{
    struct rf_depth_stats stats;
    struct depth_numbers numbers = {0};
    const size_t n = (size_t)channel->width * (size_t)channel->height;
    depth_numbers_add(&numbers, &settings->params, channel->depth, n);
    if (!depth_measure(&settings->params, channel, &stats))
        return false;
    depth_judge(found, source, settings, lens, &stats, &numbers);
    return true;
}

const char *depth_fault(const struct depth_findings *found)
{
    if (found->is_premultiplied)
        return "multiplied by alpha";
    if (found->is_mixed)
        return "anti-aliased";
    if (found->is_widened)
        return "wider than what is seen";
    return found->is_speckled ? "missing in pixels scattered as fog has them" : NULL;
}

/* 3ds Max, Corona, Maxwell. */
static const char *white_near(const struct depth_findings *found)
{
    return found->is_turned
               ? "where near is white, --depth-scale 1 --depth-offset 1 in place of "
                 "--depth-scale -1"
               : "where near is white, also --depth-scale -1 --depth-offset 1";
}

/* From this share on of normalised depth above 1 it is no overshoot of a pixel filter. */
static const double MOST_BEYOND = 0.01;

static double beyond_share(const struct depth_findings *found)
{
    const struct depth_numbers *numbers = &found->numbers;
    return numbers->n > 0 ? (double)numbers->n_beyond / (double)numbers->n : 0;
}

bool depth_is_refused(const struct depth_findings *found, char *text, size_t n_bytes)
{
    const char *guess = rf_param_find("depth")->choices[found->stats.kind].name;
    if (found->is_negative) {
        snprintf(text, n_bytes,
                 "is negative everywhere, as the z of a camera that looks along -z is; "
                 "say --depth-scale -1");
        return true;
    }
    if (beyond_share(found) >= MOST_BEYOND) {
        snprintf(
            text, n_bytes,
            "goes on beyond 1 in %.3g %% of the pixels, up to %.4g, where normalised "
            "depth has its end; say %s if it goes on so, or --depth planar if it "
            "holds distances",
            100 * beyond_share(found), found->numbers.beyond, found->rescaled);
        return true;
    }
    if (!found->is_kind_open)
        return false;
    if (found->is_mist) {
        snprintf(text, n_bytes,
                 "is Blender's Mist pass, which holds no distances; say --depth "
                 "normalised --depth-near START --depth-far END (start, and start + "
                 "depth of the world's Mist) and --mist-falloff quadratic, linear or "
                 "inverse-quadratic, or render the Depth pass");
        return true;
    }
    if (found->stats.kind == RF_DEPTH_INVERSE) {
        snprintf(
            text, n_bytes,
            "does not look like distances but like 1 / distance (%s); say --depth "
            "inverse, --depth buffer-reversed-infinite with --depth-near if it is a "
            "reversed z-buffer without far plane (games), or --depth planar if they "
            "are",
            found->stats.kind_reason);
        return true;
    }
    if (strcmp(guess, "normalised") != 0 && strncmp(guess, "buffer", 6) != 0)
        return false;
    const bool is_buffer = strncmp(guess, "buffer", 6) == 0;
    snprintf(text, n_bytes,
             "does not look like distances but %s (%s); say --depth %s with "
             "--depth-near and --depth-far, --depth %s with both if it %s (%s), %sor "
             "--depth planar if they are",
             is_buffer ? "like a depth buffer" : "like normalised depth",
             found->stats.kind_reason, guess, is_buffer ? "normalised" : "buffer",
             is_buffer ? "grows evenly with distance" : "is a z-buffer",
             white_near(found),
             found->stats.n_zero > 0
                 ? "--depth inverse if it is 1 / distance (Nuke), --depth "
                   "buffer-reversed-infinite with --depth-near if it is a reversed "
                   "z-buffer without far plane (games), "
                 : "");
    return true;
}

static bool say_whole(const struct depth_findings *found, char *text, size_t n_bytes)
{
    const struct rf_depth_stats *stats = &found->stats;
    const bool is_byte = stats->max <= 255;
    snprintf(
        text, n_bytes,
        "holds whole numbers from %g to %g, as maps of %d bit do: those are no "
        "distances but normalised (say --depth normalised --depth-scale %s with "
        "--depth-near and --depth-far) or 1 / distance (--depth disparity and its "
        "--depth-scale); %sif all is right, say --depth planar",
        stats->min, stats->max, is_byte ? 8 : 16, is_byte ? "0.00392157" : "1.5259e-05",
        is_byte ? "" : "where 65535 means nothing hit, say --depth-infinity 65535; ");
    return true;
}

bool depth_is_doubtful(const struct depth_findings *found, char *text, size_t n_bytes)
{
    const struct rf_depth_stats *stats = &found->stats;
    if (found->rival[0])
        snprintf(text, n_bytes,
                 "is taken from %s, but %s may be meant as well; name one with "
                 "--depth-channel",
                 found->channel, found->rival);
    else if (found->is_named_other)
        snprintf(
            text, n_bytes,
            "is taken for distances, but the name of its channel, %s, says that it "
            "is something else; say --depth planar if not",
            found->channel);
    else if (found->is_position)
        snprintf(
            text, n_bytes,
            "is %s, the third number of a position; that is right if positions are "
            "those in the camera's space, which --depth planar says",
            found->channel);
    else if (found->is_of_ray)
        snprintf(text, n_bytes,
                 "is %s, taken for distances along the axis; %s names those along the "
                 "ray so: say --depth radial, or --depth planar if they are not",
                 found->channel, names_of_ray(found->channel));
    else if (found->is_whole)
        return say_whole(found, text, n_bytes);
    else if (found->numbers.n_beyond > 0)
        snprintf(text, n_bytes,
                 "is above 1 in %zu pixels, up to %.4g, and normalised: they are taken "
                 "for nothing hit; say %s if they are farther than --depth-far",
                 found->numbers.n_beyond, found->numbers.beyond, found->rescaled);
    else if (found->is_kind_open && stats->kind == RF_DEPTH_PLANAR && stats->max > 0 &&
             stats->max <= 1 && stats->n_no_hit == 0)
        snprintf(text, n_bytes,
                 "is %g to %g, taken for distances; normalised and inverse depth may "
                 "look so, too: say --depth planar, normalised (with --depth-near and "
                 "--depth-far; %s) or inverse",
                 stats->min, stats->max, white_near(found));
    else
        return false;
    return true;
}

void depth_explain(const struct depth_numbers *numbers, const struct source *source,
                   const struct rf_params *params, char *text, size_t n_bytes)
{
    int n;
    char file[TOOL_FILE_BYTES];
    source_tool_file(source->depth, source->z, file);
    depth_numbers_explain(numbers, params, file,
                          image_channels(source->depth, &n)[source->z].name, text,
                          n_bytes);
}

bool depth_move_edges(const struct depth_findings *found,
                      struct rf_depth_channel *channel, struct depth_repaired *repaired)
{
    if (found->is_speckled &&
        rf_depth_fill(NULL, channel, &repaired->n_filled, NULL) != RF_OK)
        return false;
    if (found->is_mixed)
        return depth_ratio_snap(&found->ratio, channel, &repaired->n_snapped);
    return !found->is_widened || rf_depth_narrow(NULL, channel, &found->stats,
                                                 &repaired->n_narrowed, NULL) == RF_OK;
}

bool depth_undo(const struct depth_findings *found, double infinity,
                const struct rf_view *views, int n, struct depth_repaired *repaired)
{
    for (int i = 0; i < n; i++) {
        const struct rf_image *depth = &views[i].depth;
        struct rf_depth_channel channel = {depth->data, views[i].colour, depth->width,
                                           depth->height, infinity};
        const size_t n_pixels = (size_t)depth->width * (size_t)depth->height;
        const bool is_turned = found->is_turned && depth_fault(found);
        if (is_turned)
            depth_turn(channel.depth, n_pixels, infinity);
        if (found->is_premultiplied)
            repaired->n_divided += rf_depth_divide_by_alpha(&channel);
        const bool is_done = depth_move_edges(found, &channel, repaired);
        if (is_turned)
            depth_turn(channel.depth, n_pixels, infinity);
        if (!is_done)
            return false;
    }
    return true;
}

static void say_of_depth(const struct depth_listener *listener, const char *text)
{
    char whole[720];
    snprintf(whole, sizeof(whole), "the depth %s", text);
    listener->say(listener->user, whole);
}

bool depth_mend(const struct depth_picture *picture, char *remark, size_t n_bytes,
                struct depth_listener listener, struct image_error *error)
{
    const struct source *source = picture->source;
    const struct rf_depth_channel channel = {
        picture->views->depth.data, picture->views->colour, source->width,
        source->height, picture->settings->params.depth_infinity};
    struct depth_findings found;
    struct depth_repaired repaired = {0};
    struct rf_lens lens;
    struct rf_error core_error;
    char text[700];
    remark[0] = 0;
    if (!rf_method_find(picture->params->method)->needs_depth)
        return true;
    if (rf_lens_init(&lens, picture->params, source->width, source->height,
                     &core_error) != RF_OK)
        return set_error(error, "%s: %s", image_path(source->colour),
                         core_error.message);
    if (!depth_find(&found, source, picture->settings, &lens, &channel))
        return set_error(error, "%s: out of memory", image_path(source->depth));
    if (depth_is_refused(&found, text, sizeof(text)))
        return set_error(error, "%s: the depth %s", image_path(source->depth), text);
    if (source_explains_depth(source, text, sizeof(text)))
        say_of_depth(&listener, text);
    if (depth_is_doubtful(&found, text, sizeof(text)))
        say_of_depth(&listener, text);
    if (!depth_undo(&found, picture->params->depth_infinity, picture->views,
                    picture->n_views, &repaired))
        return set_error(error, "%s: out of memory", image_path(source->depth));
    const size_t n = repaired.n_divided + repaired.n_snapped + repaired.n_narrowed +
                     repaired.n_filled;
    if (n > 0)
        snprintf(remark, n_bytes, "the depth was %s; %zu pixels were mended",
                 depth_fault(&found), n);
    return true;
}
