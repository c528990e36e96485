/* SPDX-License-Identifier: Apache-2.0 */
/* What rackfocus povray says of its result, and POV-Ray's own beside it. */
#include "commands/povray_job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/frame_list.h"
#include "console/cli.h"
#include "console/progress.h"
#include "image.h"
#include "interrupt.h"
#include "measure/measure.h"
#include "povray/povray_files.h"
#include "sources/picture.h"

char *povray_picture_name(const char *name, int32_t frame)
{
    struct image_error ignored;
    const char *dot = strrchr(name, '.');
    const size_t n = strlen(name) + 16;
    const int n_stem = frame < 0 || !dot ? (int)strlen(name) : (int)(dot - name);
    char number[16] = "";
    if (frame >= 0 && frame_is_pattern(name))
        return frame_name(name, frame, &ignored);
    if (frame >= 0)
        snprintf(number, sizeof(number), "%04d", frame);
    char *text = app_memory(n, 1, NULL);
    if (text)
        snprintf(text, n, "%.*s%s%s", n_stem, name, number, name + n_stem);
    return text;
}

int povray_fail(const struct povray_error *error)
{
    if (error->is_interrupted || os_is_interrupted())
        return os_interrupt_code();
    message("%s", error->message);
    return EXIT_FAILED;
}

static void print_vector(const char *name, const double v[3])
{
    printf("%s %.10g %.10g %.10g\n", name, v[0], v[1], v[2]);
}

int povray_print_camera(struct povray_job *job)
{
    struct povray_error error = {.is_interrupted = false};
    struct povray_camera camera;
    double gamma;
    if (!povray_find_camera(job->scene, &camera, &gamma, &error))
        return povray_fail(&error);
    printf("projection %s\n", camera.is_orthographic ? "orthographic" : "perspective");
    print_vector("location", camera.location);
    print_vector("direction", camera.direction);
    print_vector("right", camera.right);
    print_vector("up", camera.up);
    printf("aperture %.10g\n", camera.aperture);
    printf("focus_distance %.10g\n", camera.focus_distance);
    printf("blur_samples %d\n", camera.blur_samples);
    printf("gamma %.10g\n", gamma);
    return EXIT_DONE;
}

static const char *focus_source(const struct povray_camera *camera)
{
    switch (camera->focus) {
    case POVRAY_FOCUS_LOOK_AT:
        return " (on the camera's look_at; --focal-point or --focus-distance change "
               "it)";
    case POVRAY_FOCUS_DIRECTION:
        return " (without focal_point POV-Ray takes the length of the camera's "
               "direction; --focal-point or --focus-distance change it)";
    default:
        return "";
    }
}

void povray_print_lens(const struct povray_job *job)
{
    const struct povray_camera *camera = &job->passes.camera;
    struct rf_lens lens;
    struct rf_error error;
    double radius = camera->aperture / 4;
    if (camera->aperture == 0 && rf_lens_init(&lens, &job->used, job->passes.width,
                                              job->passes.height, &error) == RF_OK)
        radius = lens.lens_radius;
    printf("lens radius %g, focus distance %g%s, light summed in %s\n", radius,
           camera->focus_distance, focus_source(camera),
           job->tool->is_linear     ? "linear light"
           : job->passes.is_srgb    ? "the curve of sRGB (gamma 2.2)"
           : job->passes.gamma == 1 ? "linear light"
                                    : "the scene's assumed_gamma");
    if (*povray_lens_remark(camera))
        printf("%s: %s\n", job->options.scene, povray_lens_remark(camera));
}

/* Writes POV-Ray's own focal blur, RGBA, where that is asked for. */
static bool write_reference(const struct povray_job *job, float *rgba,
                            struct image_error *error)
{
    if (!job->tool->reference)
        return true;
    struct povray_passes passes = job->passes;
    passes.width = povray_picture_width(&job->passes);
    passes.height = povray_picture_height(&job->passes);
    passes.supersample = 1;
    passes.border_px = 0;
    passes.colour = rgba;
    char made[64];
    snprintf(made, sizeof(made), "POV-Ray's focal blur, %d samples",
             job->tool->n_reference);
    char *path = povray_picture_name(job->tool->reference, job->options.frame);
    if (!path)
        return set_error(error, "out of memory");
    const bool is_good = povray_file_write(path, &passes, POVRAY_FILE_RESULT, made,
                                           job->options.n_threads, error);
    free(path);
    return is_good;
}

int povray_compare_reference(struct povray_job *job, const char *output, double own_s)
{
    struct povray_error error = {.is_interrupted = false};
    struct image_error file_error;
    struct picture picture;
    struct progress bar;
    float *rgba = NULL;
    double seconds = 0;
    progress_start(&bar, "rendering the reference", job->tool->is_quiet);
    const bool is_rendered = povray_render_reference(
        job->scene, &job->passes, job->tool->n_reference, &rgba, &seconds, &error);
    progress_end(&bar);
    if (!is_rendered)
        return povray_fail(&error);
    if (!write_reference(job, rgba, &file_error) ||
        !picture_read(output, NULL, job->options.n_threads, &picture, &file_error)) {
        message("%s", file_error.message);
        free(rgba);
        return EXIT_FAILED;
    }
    const size_t n_pixels = (size_t)picture.width * (size_t)picture.height;
    for (size_t i = 0; i < n_pixels; i++)
        memmove(rgba + 3 * i, rgba + 4 * i, 3 * sizeof(float));
    struct measures measures;
    const bool is_measured = measure_pictures(picture.samples, rgba, picture.width,
                                              picture.height, &measures, NULL);
    printf("POV-Ray's focal blur, %d samples: %.2f s\n", job->tool->n_reference,
           seconds);
    const bool is_faster = own_s <= seconds;
    printf("rackfocus: %.2f s, %.1f times %s\n", own_s,
           is_faster ? seconds / own_s : own_s / seconds,
           is_faster ? "faster" : "slower");
    if (is_measured)
        printf("tPSNR %.2f dB\n", measures.tpsnr_db);
    picture_free(&picture);
    free(rgba);
    return is_measured ? EXIT_DONE : exit_without_memory();
}

void povray_explain_time(const struct povray_job *job)
{
    enum { LONG_S = 20 };
    const struct povray_passes *passes = &job->passes;
    if (passes->total_s < LONG_S || passes->colour_s < 0.5 * passes->total_s)
        return;
    printf("%.0f s of it rendered the anti-aliased colour%s\n", passes->colour_s,
           passes->supersample > 1
               ? " with several samples in each pixel; --supersample 1 is faster"
               : "; a milder anti-aliasing such as -- +A0.3 is faster");
}
