/* SPDX-License-Identifier: Apache-2.0 */
/* The files of finish; finish_mix.c has the method. */
#include "filter/finish.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/outputs.h"
#include "common/report.h"
#include "denoise/denoise.h"
#include "filter/filter_many.h"
#include "filter/filter_output.h"
#include "filter/filter_run.h"
#include "filter/filter_shrink.h"
#include "filter/finish_headers.h"
#include "filter/finish_lens.h"
#include "filter/finish_light.h"
#include "filter/finish_mix.h"
#include "folder.h"
#include "interrupt.h"
#include "leftovers.h"
#include "sources/alpha.h"
#include "sources/camera_facts.h"
#include "sources/choice.h"
#include "sources/picture.h"
#include "sources/primaries.h"
#include "sources/settings.h"
#include "sources/source.h"
#include "sources/white.h"

/* What one run holds; pictures are packed RGB of width x height. */
struct finish {
    const struct finish_options *tool;
    struct image_error *error;
    struct settings *settings;
    struct source own;
    float *samples;    /* of the own picture, as source_read_colour() gives them */
    float *rgb, *ours; /* `ours` ends up as the result */
    float *apart;      /* half the difference of two halves of the samples, or NULL */
    float *estimate;   /* of the error, a channel */
    struct denoise_guides guides;
    struct denoiser *denoiser;
    float white; /* luminance that is shown as white, a power of two */
    int n_threads;
    bool is_lens_told; /* by the headers */
};

static size_t n_pixels(const struct finish *f)
{
    return (size_t)f->own.width * (size_t)f->own.height;
}

/* ---- our picture ------------------------------------------------------------------ */

/* What is held against the own picture; `window` is NULL where it has none. */
struct shown {
    const char *name;
    int32_t width, height;
    const struct image_box *window;
};

static int check_size(const struct finish *f, const struct shown *other)
{
    const char *own = image_path(f->own.colour);
    if (other->width != f->own.width || other->height != f->own.height)
        return app_fail(f->error, APP_FAILED,
                        "%s: is %d x %d px and %s %d x %d; render both in one size",
                        other->name, other->width, other->height, own, f->own.width,
                        f->own.height);
    return !other->window || picture_check_place(other->name, other->window, own,
                                                 &f->own.info.data_window, f->error)
               ? APP_DONE
               : APP_FAILED;
}

/* How many times as large passes are as the own picture; 0: no whole number. */
static int32_t times_of(const struct finish *f, const struct source *source)
{
    const int32_t n = source->width / f->own.width;
    return source->width == n * f->own.width && source->height == n * f->own.height ? n
                                                                                    : 0;
}

static int refuse_size(struct finish *f, const char *guide, const struct source *source)
{
    const int32_t times = times_of(f, source), scale = f->tool->supersample;
    const char *own = image_path(f->own.colour);
    if (times > 1 && times <= FILTER_MOST_SUPERSAMPLE)
        return app_fail(f->error, APP_FAILED,
                        "%s: is %d times as large as %s; give --supersample %d for "
                        "passes of supersampled pixels, or render both in one size",
                        guide, times, own, times);
    return app_fail(f->error, APP_FAILED,
                    "%s: is %d x %d px and %s %d x %d, so that --supersample %d takes "
                    "passes of %d x %d; render them so, or leave it out",
                    guide, source->width, source->height, own, f->own.width,
                    f->own.height, scale, scale * f->own.width, scale * f->own.height);
}

/* Have passes the size of the own picture, or as many times that as was asked? Before
 * they are filtered. */
static int check_passes(struct finish *f, char *const *guides)
{
    const struct source_request request = {.paths = guides, .n_paths = 1};
    struct source source;
    const int32_t scale = f->tool->supersample > 1 ? f->tool->supersample : 1;
    if (!source_open(&source, &request, f->error))
        return app_code_of(f->error);
    const struct image_box window = filter_shrunk_box(&source.info.data_window, scale);
    const struct shown passes = {guides[0], source.width / scale, source.height / scale,
                                 &window};
    const int32_t times = times_of(f, &source);
    const bool is_told = times == scale || (times == 0 && scale == 1);
    const int code =
        is_told ? check_size(f, &passes) : refuse_size(f, guides[0], &source);
    source_close(&source);
    return code;
}

/* Do the guides have a depth, so that our picture is to be made of them? */
static int find_passes(struct finish *f, char *const *guides, int n, bool *are_passes)
{
    const struct source_request request = {.paths = guides, .n_paths = 1};
    struct source source;
    const char *by;
    int code = APP_DONE;
    *are_passes = n > 1;
    if (*are_passes || picture_kind(guides[0]) != PICTURE_EXR)
        return APP_DONE;
    if (!source_open(&source, &request, f->error))
        return app_code_of(f->error);
    *are_passes = source.z >= 0;
    if (!*are_passes &&
        !image_attribute_string(source.colour, "rackfocus:filtered", &by))
        code =
            app_warn(f->tool->host, f->error,
                     "%s: has no depth that is known, and is taken for a picture that "
                     "has its lens already, though its header does not say so; "
                     "passes whose depth has an unusual name are for rackfocus filter "
                     "with --depth-channel first",
                     guides[0]);
    source_close(&source);
    return code;
}

/* Filters passes to a temporary file. */
static int filter_passes(struct finish *f, char *const *guides, int n, const char *path)
{
    const struct filter_options how = {.output = path,
                                       .shown_output = guides[0],
                                       .type = FILTER_TYPE_FLOAT,
                                       .denoise = true,
                                       .denoise_quality = f->tool->quality,
                                       .supersample = f->tool->supersample,
                                       .pixel_filter = f->tool->pixel_filter,
                                       .pixel_filter_width =
                                           f->tool->pixel_filter_width,
                                       .n_threads = f->tool->n_threads,
                                       .host = f->tool->host};
    return filter_any(&how, f->settings, guides, n, f->error);
}

/* What a header says of the lens; false where it cannot be read. */
static bool read_lens(const struct image_input *input, int part,
                      struct settings *settings)
{
    char text[500];
    settings_init(settings);
    return settings_read_header(settings, input, part, text, sizeof(text)) &&
           !settings_is_by(settings, "focus-distance", camera_facts_target) &&
           !settings_is_by(settings, "focus-distance", camera_facts_redshift);
}

/* The lens of both, where both headers have it. */
static int compare_lenses(struct finish *f, const char *path, const char *shown)
{
    char *paths[] = {(char *)path};
    const struct source_request request = {.paths = paths, .n_paths = 1};
    struct source ours = {0};
    struct settings own_lens, our_lens;
    struct image_error unread;
    char text[160];
    if (picture_kind(path) != PICTURE_EXR || !source_open(&ours, &request, &unread))
        return APP_DONE; /* read_ours() says why */
    f->is_lens_told =
        read_lens(f->own.colour, f->own.part, &own_lens) &&
        read_lens(ours.colour, ours.part, &our_lens) &&
        finish_lens_headers_differ(&own_lens, &our_lens, text, sizeof(text));
    source_close(&ours);
    if (!f->is_lens_told)
        return APP_DONE;
    return app_warn(f->tool->host, f->error,
                    "%s: was rendered with %s (%s); give it the same lens, else it may "
                    "come out worse than without a guide",
                    image_path(f->own.colour), text, shown);
}

/* Of a picture whose numbers are held against those of the own one. */
static int warn_primaries(const struct finish *f, const char *path,
                          const struct primaries *other)
{
    struct primaries own;
    primaries_read(f->own.colour, f->own.part, &own);
    return primaries_warn(f->tool->host, path, other, image_path(f->own.colour), &own,
                          "one is mended by the other", f->error);
}

static int warn_choice(const struct finish *f, const char *path, const char *doubt)
{
    return app_warn(
        f->tool->host, f->error,
        "%s: %s; write the one that is meant to a file of its own: oiiotool "
        "%s --ch LAYER.R,LAYER.G,LAYER.B -o one.exr",
        path, doubt, path);
}

/* Reads our picture; `shown` is its name for errors. */
static int read_ours(struct finish *f, const char *path, const char *shown)
{
    struct picture picture;
    const int code = compare_lenses(f, path, shown);
    if (code != APP_DONE)
        return code;
    if (!picture_read(path, NULL, f->n_threads, &picture, f->error))
        return app_code_of(f->error);
    f->ours = picture.samples;
    if (warn_primaries(f, shown, &picture.primaries) != APP_DONE ||
        (picture.doubt[0] && warn_choice(f, shown, picture.doubt) != APP_DONE))
        return APP_FAILED;
    return check_size(f, &(struct shown){shown, picture.width, picture.height,
                                         picture.has_window ? &picture.window : NULL});
}

static int make_ours(struct finish *f, char *const *guides, int n)
{
    char folder[1024], path[1100];
    bool are_passes;
    int code = find_passes(f, guides, n, &are_passes);
    if (code != APP_DONE)
        return code;
    if (!are_passes && f->tool->supersample > 1)
        code = app_warn(f->tool->host, f->error,
                        "--supersample: has no effect: %s is a filtered picture",
                        guides[0]);
    if (!are_passes)
        return code == APP_DONE ? read_ours(f, guides[0], guides[0]) : code;
    code = check_passes(f, guides);
    if (code != APP_DONE)
        return code;
    snprintf(path, sizeof(path), "%.900s/rackfocus-", os_folder_for_temporary());
    os_leftovers_remove(path);
    if (os_folder_make_temporary(path, folder, sizeof(folder)) != 0)
        return app_fail(f->error, APP_FAILED,
                        "%s: no temporary folder can be made there; name another in "
                        "TMPDIR",
                        os_folder_for_temporary());
    snprintf(path, sizeof(path), "%s/guide.exr", folder);
    code = filter_passes(f, guides, n, path);
    if (code == APP_DONE)
        code = read_ours(f, path, guides[0]);
    os_folder_remove(folder);
    return code;
}

/* ---- the own picture --------------------------------------------------------------- */

/* A render with the lens, as a file has it. */
struct render {
    struct source *source;
    float *samples;             /* as source_read_colour() gives them */
    struct denoise_files files; /* of its guides */
    struct denoise_guides guides;
};

/* Opens and reads a render; its parts are to be freed in any case. */
static int read_render(struct finish *f, const char *path, struct render *render)
{
    char *paths[] = {(char *)path};
    const struct source_request request = {.paths = paths, .n_paths = 1};
    char text[400];
    if (!source_open(render->source, &request, f->error))
        return app_code_of(f->error);
    if (render->source->layer.r < 0)
        return app_fail(f->error, APP_FAILED, "%s: has no colour", path);
    if (render->source->layer.is_data)
        return app_fail(f->error, APP_FAILED,
                        "%s: there is no picture: by its name %s holds data; give the "
                        "render that has its lens",
                        path, render->source->layer.name);
    if (choice_is_doubtful(render->source->colour, &render->source->layer, NULL, text,
                           sizeof(text)) &&
        warn_choice(f, path, text) != APP_DONE)
        return APP_FAILED;
    render->samples = source_read_colour(render->source, f->n_threads, f->error);
    if (!render->samples ||
        !denoise_read_guides(render->source, &render->files, f->n_threads,
                             &render->guides, f->error))
        return app_code_of(f->error);
    return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
}

/* RGB of the samples of a file. */
static int find_rgb(struct finish *f, const char *path, const float *samples, float *to)
{
    const size_t n_channels = (size_t)f->own.n_channels;
    for (size_t i = 0; i < n_pixels(f); i++)
        for (size_t c = 0; c < 3; c++) {
            const float v = samples[n_channels * i + (n_channels >= 3 ? c : 0)];
            if (!isfinite(v))
                return app_fail(f->error, APP_FAILED,
                                "%s: pixel (%zu, %zu) is NaN or infinite; render it "
                                "again",
                                path, i % (size_t)f->own.width,
                                i / (size_t)f->own.width);
            to[3 * i + c] = v;
        }
    return APP_DONE;
}

/* Of n values: the mean of both in `to`. */
static void take_mean(float *to, const float *other, size_t n)
{
    for (size_t i = 0; i < n; i++)
        to[i] = (to[i] + other[i]) / 2;
}

/* Makes the own picture the mean of two halves, and f->apart of what they differ by. */
static int take_half(struct finish *f, const char *path, const struct render *half)
{
    const size_t n = n_pixels(f), n_channels = (size_t)f->own.n_channels;
    f->apart = app_memory(n, 3 * sizeof(float), f->error);
    if (!f->apart)
        return APP_NO_MEMORY;
    const int code = find_rgb(f, path, half->samples, f->apart);
    if (code != APP_DONE)
        return code;
    if (!finish_join_halves(f->rgb, f->apart, 3 * n))
        return app_fail(f->error, APP_FAILED,
                        "%s: has the same samples as %s; render it with another seed",
                        path, image_path(f->own.colour));
    take_mean(f->samples, half->samples, n_channels * n);
    if (f->guides.albedo && half->guides.albedo)
        take_mean(f->guides.albedo, half->guides.albedo, 3 * n);
    if (f->guides.normal && half->guides.normal)
        take_mean(f->guides.normal, half->guides.normal, 3 * n);
    return APP_DONE;
}

static int read_half(struct finish *f, const char *path)
{
    struct source source = {0};
    struct render half = {.source = &source};
    int code = read_render(f, path, &half);
    if (code == APP_FAILED)
        app_missing(f->error, "half", path);
    if (code == APP_DONE &&
        (source.width != f->own.width || source.height != f->own.height ||
         source.n_channels != f->own.n_channels))
        code = app_fail(f->error, APP_FAILED,
                        "%s: is %d x %d px of %d channels and %s %d x %d of %d; "
                        "--half takes a second render of the same, with another seed",
                        path, source.width, source.height, source.n_channels,
                        image_path(f->own.colour), f->own.width, f->own.height,
                        f->own.n_channels);
    if (code == APP_DONE &&
        !picture_check_place(path, &source.info.data_window, image_path(f->own.colour),
                             &f->own.info.data_window, f->error))
        code = APP_FAILED;
    if (code == APP_DONE) {
        struct primaries primaries;
        primaries_read(source.colour, source.part, &primaries);
        code = warn_primaries(f, path, &primaries);
    }
    if (code == APP_DONE)
        code = take_half(f, path, &half);
    denoise_free_guides(&half.guides);
    free(half.samples);
    source_close(&source);
    return code;
}

/* The white that was given, else that of the own picture. */
static void find_white(struct finish *f)
{
    f->white =
        (float)(white_is_open(f->settings) ? white_of_pixels(f->rgb, n_pixels(f), 3)
                                           : white_round(f->settings->params.white));
}

/* An own picture that is no light, or whose soft rims are as bright as its things. */
static int warn_own(struct finish *f)
{
    char text[500];
    const char *path = image_path(f->own.colour);
    const size_t width = (size_t)f->own.width;
    struct alpha_tally tally = {0};
    int code = source_is_coded(&f->own, text, sizeof(text))
                   ? app_warn(f->tool->host, f->error, "%s: %s", path, text)
                   : APP_DONE;
    for (size_t y = 0; f->own.n_channels == 4 && y < (size_t)f->own.height; y++)
        alpha_tally_add(&tally, f->samples + 4 * width * y, width);
    if (code == APP_DONE && alpha_is_straight(&tally))
        code = app_warn(f->tool->host, f->error,
                        "%s: %s: oiiotool FILE --ch R,G,B,A --premult -o colour.exr",
                        path, alpha_straight_words);
    return code;
}

static int read_own(struct finish *f, const char *path)
{
    struct render own = {.source = &f->own,
                         .files = {f->tool->albedo_file, f->tool->normal_file}};
    int code = read_render(f, path, &own);
    f->samples = own.samples;
    f->guides = own.guides;
    if (code != APP_DONE)
        return code;
    f->rgb = app_memory(n_pixels(f), 3 * sizeof(float), f->error);
    if (!f->rgb)
        return APP_NO_MEMORY;
    code = find_rgb(f, path, f->samples, f->rgb);
    if (code == APP_DONE)
        code = warn_own(f);
    if (code == APP_DONE)
        find_white(f);
    return code == APP_DONE && f->tool->half ? read_half(f, f->tool->half) : code;
}

/* Denoises the own picture by its own albedo and normals, into f->ours. */
static int denoise_by_own(struct finish *f)
{
    const struct denoise_picture picture = {
        f->rgb, f->own.width, f->own.height, 3, image_path(f->own.colour), f->white};
    denoise_judge_grain(f->denoiser, &picture, &f->guides);
    if (!denoise_clean_guides(f->denoiser, &picture, &f->guides, f->error) ||
        !denoise_picture(f->denoiser, &picture, &f->guides, f->error))
        return app_code_of(f->error);
    f->ours = f->rgb;
    f->rgb = NULL;
    return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
}

/* A guide of another exposure, with a tone curve or of another lens is contradicted
 * everywhere, or where not all is in focus in both. */
static int warn_guide(const struct finish *f, const struct finish_picture *picture)
{
    static const char guide[] = "the guide";
    char text[500];
    int code = APP_DONE;
    if (finish_light_is_other(picture, guide, text, sizeof(text)))
        code = app_warn(f->tool->host, f->error, "%s: %s", picture->name, text);
    if (code == APP_DONE && !f->is_lens_told &&
        finish_lens_is_other(picture, guide, text, sizeof(text)))
        code = app_warn(f->tool->host, f->error, "%s: %s", picture->name, text);
    return code;
}

/* Samples of a pixel, of both halves; 0: not known. */
static int32_t samples_of(const struct finish *f)
{
    const int32_t given = f->tool->samples;
    const int32_t one =
        given > 0 ? given : finish_samples_of(f->own.colour, f->own.part);
    return f->apart ? 2 * one : one;
}

static int finish_by_ours(struct finish *f)
{
    f->estimate = app_memory(n_pixels(f), sizeof(float), f->error);
    if (!f->estimate)
        return APP_NO_MEMORY;
    const struct finish_picture picture = {.own = f->rgb,
                                           .ours = f->ours,
                                           .albedo = f->guides.albedo,
                                           .normal = f->guides.normal,
                                           .apart = f->apart,
                                           .estimate = f->estimate,
                                           .width = f->own.width,
                                           .height = f->own.height,
                                           .n_samples = samples_of(f),
                                           .white = f->white,
                                           .name = image_path(f->own.colour)};
    const int code = warn_guide(f, &picture);
    if (code != APP_DONE)
        return code;
    if (!finish_mix(f->denoiser, &picture, f->error))
        return app_code_of(f->error);
    return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
}

/* ---- output ------------------------------------------------------------------------ */

static int write_estimate(const struct finish *f)
{
    static const char *const names[] = {"Y"};
    static const enum image_sample_type types[] = {IMAGE_SAMPLE_FLOAT};
    const struct image_output output = {.width = f->own.width,
                                        .height = f->own.height,
                                        .n_channels = 1,
                                        .channel_names = names,
                                        .types = types,
                                        .samples = f->estimate,
                                        .like = f->own.colour,
                                        .like_part = f->own.part};
    return image_write(f->tool->output_error, &output, f->n_threads, f->error)
               ? APP_DONE
               : app_code_of(f->error);
}

static int write_output(struct finish *f)
{
    const size_t n_channels = (size_t)f->own.n_channels;
    const size_t n_colours = n_channels >= 3 ? 3 : 1;
    const struct filter_options how = {.output = f->tool->output,
                                       .type = f->tool->type,
                                       .png_bits = f->tool->png_bits,
                                       .n_threads = f->tool->n_threads,
                                       .host = f->tool->host};
    for (size_t i = 0; f->ours && i < n_pixels(f); i++)
        for (size_t c = 0; c < n_colours; c++)
            f->samples[n_channels * i + c] = f->ours[3 * i + c];
    if (!filter_write(&how, f->settings, &f->own, true, f->samples, f->error))
        return app_code_of(f->error);
    return f->tool->output_error ? write_estimate(f) : APP_DONE;
}

static int run(struct finish *f, const char *own, char *const *guides, int n)
{
    int code = read_own(f, own);
    if (code == APP_DONE && n > 0)
        code = make_ours(f, guides, n);
    if (code == APP_DONE && n == 0 && !f->guides.albedo)
        code =
            app_warn(f->tool->host, f->error,
                     "%s: has no albedo and no guide is given: it is denoised by its "
                     "colours alone; give its passes or a filtered picture after it",
                     own);
    if (code != APP_DONE)
        return code;
    f->denoiser = denoiser_open(NULL, (enum denoise_quality)f->tool->quality,
                                f->n_threads, f->error);
    if (!f->denoiser)
        return app_code_of(f->error);
    app_begin(f->tool->host, "denoising");
    code = f->ours ? finish_by_ours(f) : denoise_by_own(f);
    app_end(f->tool->host);
    return code == APP_DONE ? write_output(f) : code;
}

static int check_files(const struct finish_options *tool, const char *own,
                       char *const *guides, int n_guides, struct image_error *error)
{
    struct outputs outputs = {.error = error};
    outputs_add(&outputs, "output", tool->output);
    outputs_add(&outputs, "output-error", tool->output_error);
    outputs_spare(&outputs, NULL, own);
    outputs_spare(&outputs, "half", tool->half);
    outputs_spare(&outputs, "albedo-file", tool->albedo_file);
    outputs_spare(&outputs, "normal-file", tool->normal_file);
    for (int i = 0; i < n_guides; i++)
        outputs_spare(&outputs, NULL, guides[i]);
    return outputs.code;
}

int finish_run(const struct finish_options *tool, struct settings *settings,
               const char *own, char *const *guides, int n_guides,
               struct image_error *error)
{
    struct finish f = {.tool = tool,
                       .error = error,
                       .settings = settings,
                       .n_threads = thread_count(tool->n_threads)};
    if (tool->output_error && n_guides == 0)
        return app_fail(error, APP_USAGE,
                        "--output-error: is told by our picture; give passes or a "
                        "filtered picture after the own one");
    int code = check_files(tool, own, guides, n_guides, error);
    if (code == APP_DONE)
        code = run(&f, own, guides, n_guides);
    denoiser_close(f.denoiser);
    denoise_free_guides(&f.guides);
    free(f.estimate);
    free(f.ours);
    free(f.apart);
    free(f.rgb);
    free(f.samples);
    source_close(&f.own);
    return code;
}
