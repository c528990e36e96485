/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The camera of a scene: POV-Ray parses a copy that records its items, they are put
 * together, and a small render checks the result.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"
#include "image.h"
#include "ini.h"
#include "probe.h"
#include "scene.h"
#include "text.h"

/* Declared cameras that are tried where it is open which one is used. */
#define MAX_GUESSES 24
/* POV-Ray leaves out spheres and discs nearer than some 1e-6 to 1e-4. */
#define LEAST_SIZE 1e-3
/* Rounds in which files under computed names are looked for. */
#define MAX_COMPUTED 4
/* Of the focus distance, in place of an aperture of 0: blurs by less than 0.001 px. */
#define LEAST_APERTURE 1e-7
/* Side of the smallest picture that shows whether a camera is right, px. */
#define LEAST_SIDE 2
/* POV-Ray's size where no option gives one, px. */
#define USUAL_WIDTH 160
#define USUAL_HEIGHT 120
/* Side of the probe at most, px: its blocks' means are as exact as those of larger ones, and
 * POV-Ray looks for each ray at all that the scene has before the sphere. */
#define PROBE_SIDE 160

/* Parses a copy of the scene and no more; gives what it wrote to the debug stream, NULL
 * with a message where the scene has an error. */
static char *parse_scene(struct povray_scene *scene, enum rewrite_mode mode,
                         const char *name, struct povray_error *error)
{
    char *file = text_format("%s.pov", name), *records = NULL;
    const struct scene_render render = {.name = name, .mode = mode};
    struct run run = {0}, *runs[] = {&run};
    double is_done = 0;
    /* Before the scene, where it has an image_width of its own: but there it is before
     * what it says of its version, too. */
    const char *size = " #debug concat(\"@rf~width~\",str(image_width,0,0),"
                       "\";\\n@rf~height~\",str(image_height,0,0),\";\\n\") ";
    const bool is_declared = sources_declare_size(&scene->sources);
    const char *rest =
        "\n#debug concat(\"@rf~clock~\",str(clock,0,12),\";\\n\")\n"
        "#debug concat(\"@rf~delta~\",str(clock_delta,0,12),\";\\n\")\n"
        "#debug concat(\"@rf~first~\",str(initial_clock,0,12),\";\\n\")\n"
        "#debug concat(\"@rf~last~\",str(final_clock,0,12),\";\\n@rf~done~1;\\n\")"
        "\n#error \"rackfocus has what it needs\"\n";
    char *tail = text_format("\n%s%s", is_declared ? "" : size, rest);
    if (!tail ||
        !sources_write(&scene->sources, mode, file, is_declared ? size : "", tail)) {
        scene_fail_file(error, scene->temp_folder);
    } else if (scene_start_run(scene, &run, file, &render, error)) {
        /* POV-Ray takes its time to end: stop it as soon as all is said. */
        for (bool has_ended = false; !has_ended && !is_done;) {
            has_ended = run_has_ended(&run);
            free(records);
            records = run_stream(&run, "debug");
            records_find_number(records, "done", &is_done);
            if (!has_ended && !is_done && scene->options.is_cancelled &&
                scene->options.is_cancelled(scene->options.user))
                has_ended = !run_wait(runs, 1, &scene->options, error);
            else if (!has_ended && !is_done)
                run_pause();
        }
        if (!is_done && !error->is_interrupted)
            scene_explain(scene, &run, error);
    }
    run_stop(&run);
    free(file);
    free(tail);
    if (!is_done) {
        free(records);
        records = NULL;
    }
    return records;
}

/* Loads the files that computed #includes came to. Are there new ones with cameras? */
static bool add_computed(struct povray_scene *scene, const char *records)
{
    bool is_new = false;
    int n;
    char **names = records_list(records, "include", &n);
    for (int i = 0; i < n; i++) {
        is_new |= sources_add_computed(&scene->sources, names[i]);
        free(names[i]);
    }
    free(names);
    if (is_new)
        sources_forget_copies(&scene->sources);
    return is_new;
}

/* A file that a computed #include brings may include others in the same way. */
static char *record_items(struct povray_scene *scene, struct povray_error *error)
{
    char *records = parse_scene(scene, REWRITE_RECORD, "record", error);
    for (int i = 0; i < MAX_COMPUTED && records && add_computed(scene, records); i++) {
        free(records);
        records = parse_scene(scene, REWRITE_RECORD, "record", error);
    }
    return records;
}

/* A picture's size as options ask for it, px. */
struct size {
    double width, height;
};

/* The number of "+W640", but not of "+WL5", which is another option. */
static void note_side(double *side, const char *value)
{
    char *end;
    const double number = value ? strtod(value, &end) : 0;
    if (value && strchr("+-.0123456789", *value) && end > value)
        *side = trunc(number);
}

static void note_size(void *user, const char *option, const char *file)
{
    struct size *size = user;
    (void)file;
    note_side(&size->width, ini_value(option, "Width", "W"));
    note_side(&size->height, ini_value(option, "Height", "H"));
}

/* POV-Ray renders sizes below 1 without end, or divides by them. */
static bool check_size(const struct povray_scene *scene, struct size size,
                       struct povray_error *error)
{
    const double shorter = fmin(size.width, size.height);
    const double longer = fmax(size.width, size.height);
    if (shorter >= LEAST_SIDE && longer <= IMAGE_MAX_SIDE)
        return true;
    snprintf(error->message, sizeof error->message,
             "%s: the picture would be %.0fx%.0f px, which is too %s; give +W and +H, "
             "each from %d to %d, after --",
             scene->options.scene, size.width, size.height,
             shorter < LEAST_SIDE ? "small" : "large", LEAST_SIDE, IMAGE_MAX_SIDE);
    return false;
}

bool scene_find_items(struct povray_scene *scene, struct povray_error *error)
{
    const struct povray_options *options = &scene->options;
    struct size size = {USUAL_WIDTH, USUAL_HEIGHT};
    ini_walk(options->args, options->n_args, note_size, &size);
    if (!check_size(scene, size, error))
        return false;
    char *records = record_items(scene, error);
    if (!records) {
        /* Was it the scene or our writing between its lines? */
        struct povray_error own = {.message = ""};
        char *plain = error->is_interrupted
                          ? NULL
                          : parse_scene(scene, REWRITE_PINHOLE, "plain", &own);
        if (plain)
            snprintf(error->message, sizeof error->message,
                     "%s: the camera's items could not be followed; write the camera "
                     "out in full in the scene",
                     options->scene);
        else if (!error->is_interrupted)
            *error = own;
        free(plain);
        return false;
    }
    size = (struct size){0, 0};
    records_find_number(records, "width", &size.width);
    records_find_number(records, "height", &size.height);
    scene->width = (int32_t)size.width;
    scene->height = (int32_t)size.height;
    free(scene->records);
    scene->records = records;
    return check_size(scene, size, error) && !glue_is_lost();
}

/* Puts the scene's name before the message. */
bool scene_fail(const struct povray_scene *scene, struct povray_error *error)
{
    char *what = text_format("%s", error->message);
    snprintf(error->message, sizeof error->message, "%s: %s", scene->options.scene,
             what ? what : "");
    free(what);
    return false;
}

static double along_axis(const struct povray_camera *camera, const double point[3])
{
    double squared = 0;
    for (int i = 0; i < 3; i++)
        squared += (point[i] - camera->location[i]) * (point[i] - camera->location[i]);
    return sqrt(squared);
}

/* Where the scene has no lens, nobody chose its focus: what it looks at is in focus. A
 * scene with an aperture but no focal_point is in focus where POV-Ray puts it. */
static void choose_focus(struct povray_camera *camera,
                         const struct povray_options *options)
{
    camera->focus =
        camera->has_focal_point ? POVRAY_FOCUS_SCENE : POVRAY_FOCUS_DIRECTION;
    if (options->has_focus_distance || options->has_focal_point) {
        camera->focus = POVRAY_FOCUS_OPTION;
        camera->focus_distance = options->has_focus_distance
                                     ? options->focus_distance
                                     : along_axis(camera, options->focal_point);
    } else if (!camera->has_focal_point && camera->aperture == 0 &&
               camera->look_at_distance > 0) {
        camera->focus = POVRAY_FOCUS_LOOK_AT;
        camera->focus_distance = camera->look_at_distance;
    }
}

/* No file read so far has a camera. */
static bool is_without_camera(const struct povray_scene *scene)
{
    int n;
    char **list = records_list(scene->records, "camera", &n);
    for (int i = 0; i < n; i++)
        free(list[i]);
    free(list);
    return n == 0;
}

/* May the scene make its camera while it is parsed? */
static bool may_make_camera(const struct povray_scene *scene)
{
    return scene->sources.writes_files && is_without_camera(scene);
}

/* What is missing for POV-Ray's usual camera to have a lens. */
static const char *lens_of_usual_camera(const struct povray_scene *scene)
{
    return may_make_camera(scene)
               ? "the scene writes out no camera; give a lens for POV-Ray's usual one "
                 "with --aperture and --focal-point, or, where the scene makes a "
                 "camera while it is parsed (Parse_String, #fopen), write it out"
               : "the scene writes out no camera; give a lens for POV-Ray's usual one "
                 "with --aperture and --focal-point, or write a camera into the scene";
}

/* Has the camera an aperture that is 0 in this frame of an animation, as where it opens?
 * POV-Ray's picture of it is sharp. */
static bool is_closed(const struct povray_scene *scene)
{
    return scene->options.frame >= 0 && scene->camera.aperture == 0 &&
           scene->camera.focus_distance > 0 &&
           strstr(scene->records, "@rf~aperture~") != NULL;
}

/* The camera of the records, with the user's lens in place of the scene's. */
bool scene_choose_camera(struct povray_scene *scene, struct povray_error *error)
{
    const struct povray_options *options = &scene->options;
    struct povray_camera *camera = &scene->camera;
    if (!camera_replay(camera, scene->records, scene->guess, &scene->n_guesses,
                       error)) {
        /* A name that could not be resolved: the probe will say so, then guess. */
        return (scene->guess == 0 && scene->n_guesses > 0 && !glue_is_lost()) ||
               scene_fail(scene, error);
    }
    choose_focus(camera, options);
    if (is_closed(scene))
        camera->aperture = LEAST_APERTURE * camera->focus_distance;
    const bool has_lens = camera->aperture != 0;
    camera->is_sharp = has_lens && camera->blur_samples == 0 &&
                       !options->has_aperture && !options->has_f_stop;
    if (options->has_aperture)
        camera->aperture = options->aperture;
    const char *what = NULL;
    if (options->wants_lens && options->has_aperture && camera->aperture == 0)
        what = "an aperture of 0 blurs nothing, and POV-Ray itself makes that picture; "
               "give a larger --aperture, or leave it out for the scene's";
    else if (options->wants_lens && camera->aperture == 0)
        what = is_without_camera(scene)
                   ? lens_of_usual_camera(scene)
                   : "the scene's camera has no aperture; give one with --aperture";
    else if ((options->has_aperture || options->has_f_stop) && !has_lens &&
             camera->focus == POVRAY_FOCUS_DIRECTION)
        what = is_without_camera(scene)
                   ? lens_of_usual_camera(scene)
                   : "the camera has neither focal_point nor look_at to focus on; give "
                     "a point with --focal-point or a distance with --focus-distance";
    else if (!(camera->focus_distance > 0))
        what = "the focal point lies in the camera; give another with --focal-point or "
               "--focus-distance";
    else if (options->wants_reference && camera->is_orthographic &&
             scene->n_guesses == 0)
        what = GLUE_NO_ORTHOGRAPHIC_BLUR;
    if (what)
        snprintf(error->message, sizeof error->message, "%s: %s", options->scene, what);
    camera->f_stop = options->has_f_stop ? options->stop.f_stop : 0;
    camera->aperture = options->has_f_stop
                           ? 4 * options->stop.radius[camera->is_orthographic]
                           : fabs(camera->aperture);
    return !what && !glue_is_lost();
}

/* ---- the check ------------------------------------------------------------------ */

static struct probe probe_of(const struct povray_scene *scene)
{
    return (struct probe){
        .camera = &scene->camera,
        .scale = scene->probe_scale,
        .width = scene->width < PROBE_SIDE ? scene->width : PROBE_SIDE,
        .height = scene->height < PROBE_SIDE ? scene->height : PROBE_SIDE,
        .picture_width = scene->width};
}

bool scene_start_probe(struct povray_scene *scene, struct run *run,
                       struct povray_error *error)
{
    struct text tail = {0};
    const struct probe probe = probe_of(scene);
    sources_set_size(&scene->sources, scene->width, scene->height);
    probe_write(&tail, &probe);
    char *after = text_format("-A -UA +Q6 +W%d +H%d", probe.width, probe.height);
    const struct scene_render render = {.name = "probe",
                                        .mode = REWRITE_PINHOLE,
                                        .head = probe_head,
                                        .tail = tail.data,
                                        .after = after};
    bool is_started = scene_start_render(scene, run, &render, error);
    free(after);
    text_free(&tail);
    return is_started;
}

bool scene_check_probe(struct povray_scene *scene, const struct run *run,
                       struct povray_error *error)
{
    struct decode_picture picture = {0};
    const struct probe probe = probe_of(scene);
    bool is_good = scene_read(scene, run, &picture, error);
    if (is_good && !probe_check(&probe, &picture, &scene->space, error))
        is_good = scene_fail(scene, error);
    free(picture.rgba);
    return is_good;
}

bool scene_run_probe(struct povray_scene *scene, struct povray_error *error)
{
    struct run probe = {0}, *list[] = {&probe};
    bool is_good = scene_start_probe(scene, &probe, error) &&
                   scene_wait(scene, list, 1, error) &&
                   scene_check_probe(scene, &probe, error);
    run_stop(&probe);
    return is_good;
}

/* Tries the declared cameras that the scene's may be a copy of, after the first choice
 * was wrong. */
static bool try_guesses(struct povray_scene *scene, struct povray_error *error)
{
    int n = scene->n_guesses < MAX_GUESSES ? scene->n_guesses : MAX_GUESSES;
    for (scene->guess = 1; scene->guess <= n && !error->is_interrupted;
         scene->guess++) {
        struct povray_error ignored = {.message = ""};
        if (scene_choose_camera(scene, &ignored) && scene_run_probe(scene, &ignored))
            return true;
        error->is_interrupted = ignored.is_interrupted;
    }
    /* The feature that is not supported says more than the probe. */
    if (n > 0 && !error->is_interrupted &&
        !camera_replay(&scene->camera, scene->records, 0, &n, error))
        scene_fail(scene, error);
    return false;
}

bool scene_probe_again(struct povray_scene *scene, struct povray_error *error)
{
    static const double scales[PROBE_N_SCALES] = PROBE_SCALES;
    for (int i = 1; i < PROBE_N_SCALES && !error->is_interrupted; i++) {
        struct povray_error ignored = {.message = ""};
        scene->probe_scale = scales[i];
        if (scene_run_probe(scene, &ignored))
            return true;
        error->is_interrupted = ignored.is_interrupted;
    }
    scene->probe_scale = 1;
    if (error->is_interrupted || try_guesses(scene, error))
        return !error->is_interrupted;
    if (!error->is_interrupted && may_make_camera(scene)) {
        snprintf(error->message, sizeof error->message,
                 "%s: the scene makes its camera while it is parsed (Parse_String, "
                 "#fopen), where its items cannot be read; write the camera out in the "
                 "scene",
                 scene->options.scene);
        return false;
    }
    const double size = scene->camera.look_at_distance;
    if (!error->is_interrupted && size > 0 && size < LEAST_SIZE)
        snprintf(error->message, sizeof error->message,
                 "%s: the camera is %g units from what it looks at, which is less than "
                 "POV-Ray draws well; scale the scene and its camera up",
                 scene->options.scene, size);
    return false;
}
