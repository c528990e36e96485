/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The renders of a job. The colour render starts at once, with the scene's own camera
 * but for the aperture; meanwhile a run that only parses records the camera; then the
 * probe and the fogs render side by side.
 */
#include "povray.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"
#include "decode.h"
#include "probe.h"
#include "run.h"
#include "scene.h"
#include "text.h"

/* Fine enough for thin edges that the lens will enlarge; docs/povray.md has times. */
#define COLOUR_OPTIONS "+A0.05 +AM2 +R3"
/* Below 65504^(1 / gamma) for a gamma up to 2.4, as half floats need. */
#define FOG_LIGHT 100.0
#define MAX_FOG_GAMMA 2.4
/* Distances of the two fogs, in focus distances. */
#define NEAR_FOG 0.7
#define FAR_FOG 40.0
/* Declared cameras that are tried where it is open which one is used. */
#define MAX_GUESSES 24
/* Pixels that the probe renders at most. */
#define PROBE_PIXELS 1000000
/* More than this share of pixels without fog is worth a second try and a warning. */
#define INSIDE_LIMIT 1e-3

static bool fail_file(struct povray_error *error, const char *path)
{
    snprintf(error->message, sizeof error->message, "%s: %s", path, strerror(errno));
    return false;
}

bool povray_open(struct povray_scene **scene, const struct povray_options *options,
                 struct povray_error *error)
{
    *scene = NULL;
    char *folder = temp_folder_make(error);
    if (!folder)
        return false;
    struct povray_scene *made = glue_alloc(1, sizeof *made);
    made->options = *options;
    made->temp_folder = folder;
    if (!sources_load(&made->sources, options->scene, options->args, options->n_args,
                      folder)) {
        fail_file(error, options->scene);
        povray_close(made);
        return false;
    }
    *scene = made;
    return true;
}

void povray_close(struct povray_scene *scene)
{
    if (!scene)
        return;
    temp_folder_remove(scene->temp_folder);
    sources_free(&scene->sources);
    free(scene->records);
    free(scene->temp_folder);
    free(scene);
}

const char *povray_folder(const struct povray_scene *scene)
{
    return scene->temp_folder;
}

void povray_passes_free(struct povray_passes *passes)
{
    free(passes->colour);
    free(passes->depth);
    *passes = (struct povray_passes){0};
}

/* ---- messages ------------------------------------------------------------------ */

/* Joins POV-Ray's wrapped lines from `from` on. */
static char *joined(const char *from)
{
    struct text text = {0};
    text_add(&text, "", 0);
    for (; *from; from++) {
        bool is_blank = *from == '\n' || *from == ' ' || *from == '\r';
        if (!is_blank)
            text_add(&text, from, 1);
        else if (text.n > 0 && text.data[text.n - 1] != ' ')
            text_add(&text, " ", 1);
    }
    while (text.n > 0 && text.data[text.n - 1] == ' ')
        text.data[--text.n] = 0;
    return text.data;
}

/* "File: X  Line: N ... Parse Error: what" becomes "X:N: Parse Error: what". */
static bool explain_parse_error(const struct povray_scene *scene, const char *fatal,
                                struct povray_error *error)
{
    const char *file = strstr(fatal, "File: "), *line = strstr(fatal, "Line: ");
    const char *what = strstr(fatal, "Error: ");
    if (!file || !line || !what || line < file)
        return false;
    while (what > fatal && what[-1] != '\n')
        what--;
    char *name = text_format("%.*s", (int)(line - file - 6), file + 6);
    char *tidy = joined(name),
         *original = sources_original_names(&scene->sources, tidy);
    char *renamed = sources_original_names(&scene->sources, what),
         *text = joined(renamed);
    snprintf(error->message, sizeof error->message, "%s:%d: %s", original,
             atoi(line + 6), text);
    free(name);
    free(tidy);
    free(original);
    free(renamed);
    free(text);
    return true;
}

/* What POV-Ray printed since its last heading, or at the end, where it gave no parse
 * error. */
static void explain_log(const struct povray_scene *scene, const char *log,
                        struct povray_error *error)
{
    const char *from = log, *at, *configuration = "user configuration file";
    while ((at = strstr(from, "====\n")))
        from = at + 5;
    if (from == log && (at = strstr(log, configuration)) && strchr(at, '\n'))
        from = strchr(at, '\n');
    char *renamed = sources_original_names(&scene->sources, from);
    char *text = joined(renamed);
    size_t n = strlen(text), n_shown = 500;
    snprintf(error->message, sizeof error->message, "%s: POV-Ray says: %s",
             scene->options.scene, n > n_shown ? text + n - n_shown : text);
    free(renamed);
    free(text);
}

static void explain_run(const struct povray_scene *scene, const struct run *run,
                        struct povray_error *error)
{
    char *fatal = run_stream(run, "fatal"), *log = run_stream(run, "log");
    if (!explain_parse_error(scene, fatal, error))
        explain_log(scene, log, error);
    free(fatal);
    free(log);
}

/* ---- the camera ---------------------------------------------------------------- */

/* Parses a copy of the scene and no more; gives what it wrote to the debug stream, NULL
 * with a message where the scene has an error. */
static char *parse_scene(struct povray_scene *scene, enum rewrite_mode mode,
                         const char *name, struct povray_error *error)
{
    char *file = text_format("%s.pov", name), *records = NULL;
    struct run run = {0}, *runs[] = {&run};
    double is_done = 0;
    const char *tail =
        "\n#debug concat(\"@rf~width~\",str(image_width,0,0),"
        "\";\\n@rf~height~\",str(image_height,0,0),\";\\n\")\n"
        "#debug concat(\"@rf~clock~\",str(clock,0,12),\";\\n\")\n"
        "#debug concat(\"@rf~delta~\",str(clock_delta,0,12),\";\\n\")\n"
        "#debug concat(\"@rf~first~\",str(initial_clock,0,12),\";\\n\")\n"
        "#debug concat(\"@rf~last~\",str(final_clock,0,12),\";\\n@rf~done~1;\\n\")"
        "\n#error \"rackfocus has what it needs\"\n";
    if (!sources_write(&scene->sources, mode, file, "", tail)) {
        fail_file(error, scene->temp_folder);
    } else if (run_start(&run, scene->temp_folder, name, file, "", scene->clock_words,
                         &scene->options, error)) {
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
            explain_run(scene, &run, error);
    }
    run_stop(&run);
    free(file);
    if (!is_done) {
        free(records);
        records = NULL;
    }
    return records;
}

bool scene_find_items(struct povray_scene *scene, struct povray_error *error)
{
    char *records = parse_scene(scene, REWRITE_RECORD, "record", error);
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
                     scene->options.scene);
        else if (!error->is_interrupted)
            *error = own;
        free(plain);
        return false;
    }
    double width = 0, height = 0;
    records_find_number(records, "width", &width);
    records_find_number(records, "height", &height);
    scene->width = (int32_t)width;
    scene->height = (int32_t)height;
    free(scene->records);
    scene->records = records;
    return true;
}

/* Puts the scene's name before the message. */
static bool fail_scene(const struct povray_scene *scene, struct povray_error *error)
{
    char *what = text_format("%s", error->message);
    snprintf(error->message, sizeof error->message, "%s: %s", scene->options.scene,
             what);
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

/* The camera of the records, with the user's lens in place of the scene's. */
bool scene_choose_camera(struct povray_scene *scene, struct povray_error *error)
{
    const struct povray_options *options = &scene->options;
    struct povray_camera *camera = &scene->camera;
    if (!camera_replay(camera, scene->records, scene->guess, &scene->n_guesses,
                       error)) {
        /* A name that could not be resolved: the probe will say so, then guess. */
        return (scene->guess == 0 && scene->n_guesses > 0) || fail_scene(scene, error);
    }
    if (options->has_focus_distance)
        camera->focus_distance = options->focus_distance;
    else if (options->has_focal_point)
        camera->focus_distance = along_axis(camera, options->focal_point);
    if (options->has_aperture)
        camera->aperture = options->aperture;
    const char *what = NULL;
    if (options->wants_lens && camera->aperture == 0)
        what = "the scene's camera has no aperture; give one with --aperture";
    else if (!(camera->focus_distance > 0))
        what = "the focal point lies in the camera; give another with --focal-point or "
               "--focus-distance";
    if (what)
        snprintf(error->message, sizeof error->message, "%s: %s", options->scene, what);
    camera->aperture = fabs(camera->aperture);
    return !what;
}

bool scene_wait(const struct povray_scene *scene, struct run *const *runs, int n,
                struct povray_error *error)
{
    struct povray_options options = scene->options;
    options.progress = NULL;
    return run_wait(runs, n, &options, error);
}

/* ---- renders ------------------------------------------------------------------- */

bool scene_start_render(struct povray_scene *scene, struct run *run, const char *name,
                        enum rewrite_mode mode, const char *head, const char *tail,
                        const char *before, const char *after,
                        struct povray_error *error)
{
    char *file = text_format("%s.pov", name);
    char *words = text_format("%s %s", after, scene->clock_words);
    bool is_started = sources_write(&scene->sources, mode, file, head, tail);
    if (!is_started)
        fail_file(error, scene->temp_folder);
    else
        is_started = run_start(run, scene->temp_folder, name, file, before, words,
                               &scene->options, error);
    free(file);
    free(words);
    /* Two runs that write the same file would read each other's halves. */
    if (is_started && scene->sources.writes_files)
        is_started = scene_wait(scene, &run, 1, error);
    return is_started;
}

bool scene_read(struct povray_scene *scene, const struct run *run,
                struct decode_picture *picture, struct povray_error *error)
{
    char *path = run_is_good(run) ? run_picture(run) : NULL;
    bool is_read = path && decode_read(picture, path, scene->options.n_threads, error);
    if (!path)
        explain_run(scene, run, error);
    free(path);
    return is_read;
}

static int32_t probe_rows(const struct povray_scene *scene)
{
    int32_t rows = PROBE_PIXELS / scene->width;
    rows = rows < 16 ? 16 : rows;
    return rows < scene->height ? rows : scene->height;
}

static bool start_probe(struct povray_scene *scene, struct run *run,
                        struct povray_error *error)
{
    struct text tail = {0};
    probe_write(&tail, &scene->camera, scene->width, scene->height);
    char *after = text_format("-A -UA +Q6 +SR1 +ER%d", probe_rows(scene));
    bool is_started = scene_start_render(scene, run, "probe", REWRITE_PINHOLE,
                                         probe_head, tail.data, "", after, error);
    free(after);
    text_free(&tail);
    return is_started;
}

static bool check_probe(struct povray_scene *scene, const struct run *run,
                        struct povray_error *error)
{
    struct decode_picture picture = {0};
    bool is_good = scene_read(scene, run, &picture, error);
    if (is_good &&
        !probe_check(&picture, probe_rows(scene), &scene->camera, &scene->space, error))
        is_good = fail_scene(scene, error);
    free(picture.rgba);
    return is_good;
}

static bool run_probe(struct povray_scene *scene, struct povray_error *error)
{
    struct run probe = {0}, *list[] = {&probe};
    bool is_good = start_probe(scene, &probe, error) &&
                   scene_wait(scene, list, 1, error) &&
                   check_probe(scene, &probe, error);
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
        if (scene_choose_camera(scene, &ignored) && run_probe(scene, &ignored))
            return true;
        error->is_interrupted = ignored.is_interrupted;
    }
    /* The feature that is not supported says more than the probe. */
    if (n > 0 && !error->is_interrupted &&
        !camera_replay(&scene->camera, scene->records, 0, &n, error))
        fail_scene(scene, error);
    return false;
}

/* The renders for the depth: bases[0] serves both fogs where the scene has none. */
struct fog_runs {
    struct run bases[2], fogged[2];
    double light, distances[2];
};

/* Whose passes are rendered: those of the scene's own camera, or of a view. */
struct shot {
    const struct povray_camera *camera;
    int view; /* -1: the scene's own camera, which needs no words */
};

static char *shot_name(const struct shot *shot, const char *name)
{
    return shot->view < 0 ? text_format("%s", name)
                          : text_format("v%02d_%s", shot->view, name);
}

static void add_camera(struct text *tail, const struct shot *shot)
{
    text_addf(tail, "\n");
    if (shot->view >= 0)
        camera_write(tail, shot->camera, 0);
}

static bool start_fog(struct povray_scene *scene, const struct shot *shot,
                      struct run *run, const char *name, enum rewrite_mode mode,
                      double distance, double light, struct povray_error *error)
{
    struct text tail = {0};
    add_camera(&tail, shot);
    text_addf(&tail, "global_settings{max_trace_level 1");
    /* Indirect light would cost time, and the fogs would light things differently; the
     * last setting wins. POV-Ray takes a max_sample of 0 for none. */
    if (scene->sources.has_radiosity)
        text_addf(&tail, " radiosity{pretrace_start 1 pretrace_end 1 count 1 "
                         "nearest_count 1 recursion_limit 1 max_sample 1e-12}");
    if (scene->sources.has_photons)
        text_addf(&tail, " photons{count 1}");
    text_addf(&tail, "}\n");
    if (distance > 0)
        text_addf(&tail, "fog{fog_type 1 distance %.17g color rgb %.17g}\n", distance,
                  light);
    char *full_name = shot_name(shot, name);
    bool is_started = scene_start_render(scene, run, full_name, mode, "", tail.data, "",
                                         "-A -UA +Q9", error);
    free(full_name);
    text_free(&tail);
    return is_started;
}

static bool start_fogs(struct povray_scene *scene, const struct shot *shot,
                       struct fog_runs *fogs, enum rewrite_mode mode,
                       struct povray_error *error)
{
    double focus = scene->camera.focus_distance;
    bool is_dark = scene->sources.has_fog;
    *fogs = (struct fog_runs){.light = FOG_LIGHT,
                              .distances = {NEAR_FOG * focus, FAR_FOG * focus}};
    if (scene->space.gamma > MAX_FOG_GAMMA) /* known on a second try only */
        fogs->light = pow(60000, 1 / scene->space.gamma);
    for (int i = 0; i < 2; i++) {
        if ((i == 0 || is_dark) &&
            !start_fog(scene, shot, &fogs->bases[i], i ? "base1" : "base0", mode,
                       is_dark ? fogs->distances[i] : 0, 0, error))
            return false;
        if (!start_fog(scene, shot, &fogs->fogged[i], i ? "fog1" : "fog0", mode,
                       fogs->distances[i], fogs->light, error))
            return false;
    }
    return true;
}

static void stop_fogs(struct fog_runs *fogs)
{
    for (int i = 0; i < 2; i++) {
        run_stop(&fogs->bases[i]);
        run_stop(&fogs->fogged[i]);
    }
}

static bool same_size(struct povray_scene *scene, const struct decode_picture *a,
                      const struct decode_picture *b, struct povray_error *error)
{
    if (a->width == b->width && a->height == b->height)
        return true;
    snprintf(
        error->message, sizeof error->message,
        "%s: POV-Ray rendered pictures of different sizes; give +W and +H after --",
        scene->options.scene);
    return false;
}

static bool read_fogs(struct povray_scene *scene, const struct shot *shot,
                      struct fog_runs *runs, struct povray_passes *passes,
                      struct povray_error *error)
{
    bool is_dark = scene->sources.has_fog, is_good = true;
    const struct decode_picture size = {.width = passes->width,
                                        .height = passes->height};
    struct decode_picture pictures[4] = {0};
    struct run *order[4] = {&runs->bases[0], &runs->fogged[0], &runs->bases[1],
                            &runs->fogged[1]};
    for (int i = 0; i < 4 && is_good; i++)
        if (i != 2 || is_dark)
            is_good = scene_read(scene, order[i], &pictures[i], error) &&
                      same_size(scene, &size, &pictures[i], error);
    if (is_good) {
        struct decode_fog fogs[2];
        for (int i = 0; i < 2; i++)
            fogs[i] = (struct decode_fog){(i ? FAR_FOG : NEAR_FOG) *
                                              scene->camera.focus_distance,
                                          {runs->light, runs->light, runs->light},
                                          pictures[is_dark ? 2 * i : 0].rgba,
                                          pictures[2 * i + 1].rgba,
                                          is_dark};
        size_t n_pixels = (size_t)passes->width * (size_t)passes->height;
        if (!passes->depth)
            passes->depth = glue_alloc(n_pixels, sizeof(float));
        passes->n_inside =
            (double)decode_depth(fogs, &scene->space, shot->camera,
                                 vector_length(scene->camera.direction), passes->width,
                                 passes->height, passes->depth) /
            (double)n_pixels;
    }
    for (int i = 0; i < 4; i++)
        free(pictures[i].rgba);
    return is_good;
}

static int list_fogs(struct fog_runs *fogs, struct run **list, int n)
{
    struct run *all[4] = {&fogs->bases[0], &fogs->bases[1], &fogs->fogged[0],
                          &fogs->fogged[1]};
    for (int i = 0; i < 4; i++)
        if (all[i]->folder)
            list[n++] = all[i];
    return n;
}

/* Another round of fogs, where the first one was too bright or did not reach. */
static bool repeat_fogs(struct povray_scene *scene, const struct shot *shot,
                        enum rewrite_mode mode, struct povray_passes *passes,
                        struct povray_error *error)
{
    struct fog_runs fogs = {0};
    struct run *list[4];
    bool is_good = start_fogs(scene, shot, &fogs, mode, error) &&
                   scene_wait(scene, list, list_fogs(&fogs, list, 0), error) &&
                   read_fogs(scene, shot, &fogs, passes, error);
    stop_fogs(&fogs);
    return is_good;
}

/* POV-Ray computes no fog inside solid things; where the camera is in one that is not
 * hollow, a copy of the scene in which all things are hollow may tell. */
static bool look_inside(struct povray_scene *scene, const struct shot *shot,
                        struct povray_passes *passes, struct povray_error *error)
{
    if (passes->n_inside <= INSIDE_LIMIT)
        return true;
    struct povray_error ignored = {.message = ""};
    struct povray_passes second = *passes;
    second.depth = NULL;
    if (repeat_fogs(scene, shot, REWRITE_HOLLOW, &second, &ignored) &&
        second.n_inside < passes->n_inside) {
        free(passes->depth);
        passes->depth = second.depth;
        passes->n_inside = second.n_inside;
    } else {
        free(second.depth);
    }
    if (ignored.is_interrupted) {
        *error = ignored;
        return false;
    }
    if (passes->n_inside > 0.5) {
        snprintf(error->message, sizeof error->message,
                 "%s: no depth in %.0f %% of the picture: the camera is inside a solid "
                 "object; add the word hollow to that object",
                 scene->options.scene, 100 * passes->n_inside);
        return false;
    }
    if (passes->n_inside > INSIDE_LIMIT)
        snprintf(passes->warning, sizeof passes->warning,
                 "no depth in %.1f %% of the picture, which lies inside solid objects; "
                 "add the word hollow to them",
                 100 * passes->n_inside);
    return true;
}

static bool read_colour(struct povray_scene *scene, struct run *run,
                        struct povray_passes *passes, struct povray_error *error)
{
    struct decode_picture picture = {0};
    if (!scene_read(scene, run, &picture, error))
        return false;
    passes->width = picture.width;
    passes->height = picture.height;
    passes->has_alpha = picture.has_alpha;
    passes->colour = picture.rgba;
    passes->colour_s = run->ended_s - run->started_s;
    return true;
}

struct job {
    struct run colour, probe;
    struct fog_runs fogs;
};

static bool run_job(struct povray_scene *scene, struct job *job,
                    struct povray_passes *passes, struct povray_error *error)
{
    struct run *list[6] = {&job->colour, &job->probe};
    const struct shot shot = {&scene->camera, -1};
    if (!scene_start_render(scene, &job->colour, "colour", REWRITE_PINHOLE, "", "",
                            COLOUR_OPTIONS, "", error) ||
        !scene_find_items(scene, error) || !scene_choose_camera(scene, error) ||
        !start_probe(scene, &job->probe, error) ||
        !start_fogs(scene, &shot, &job->fogs, REWRITE_PINHOLE, error))
        return false;
    /* A camera that is not ours is known long before the colour is ready. */
    if (!scene_wait(scene, list + 1, 1, error) ||
        (!check_probe(scene, &job->probe, error) && !try_guesses(scene, error)))
        return false;
    if (!run_wait(list, list_fogs(&job->fogs, list, 2), &scene->options, error) ||
        !read_colour(scene, &job->colour, passes, error))
        return false;
    bool is_good = scene->space.gamma > MAX_FOG_GAMMA
                       ? repeat_fogs(scene, &shot, REWRITE_PINHOLE, passes, error)
                       : read_fogs(scene, &shot, &job->fogs, passes, error);
    return is_good && look_inside(scene, &shot, passes, error);
}

bool povray_render(struct povray_scene *scene, struct povray_passes *passes,
                   struct povray_error *error)
{
    struct job job = {0};
    double started_s = seconds_now();
    *passes = (struct povray_passes){0};
    *error = (struct povray_error){.message = ""};
    bool is_good = run_job(scene, &job, passes, error);
    run_stop(&job.colour);
    run_stop(&job.probe);
    stop_fogs(&job.fogs);
    passes->camera = scene->camera;
    passes->gamma = scene->space.gamma;
    passes->is_srgb = scene->space.is_srgb;
    passes->total_s = seconds_now() - started_s;
    if (!is_good)
        povray_passes_free(passes);
    return is_good;
}

/* ---- views --------------------------------------------------------------------- */

/* A view on its way. */
struct view_job {
    struct shot shot;
    struct povray_camera camera;
    double offset[2];
    struct run colour;
    struct fog_runs fogs;
};

/* Moves the camera over its lens and shears it back to the plane in focus. */
static void move_camera(struct povray_camera *camera, const double offset[2])
{
    double right = offset[0] / vector_length(camera->right);
    double up = offset[1] / vector_length(camera->up);
    double shear = vector_length(camera->direction) / camera->focus_distance;
    for (int i = 0; i < 3; i++) {
        double moved = right * camera->right[i] + up * camera->up[i];
        camera->location[i] += moved;
        camera->direction[i] -= shear * moved;
    }
}

static bool start_view(struct povray_scene *scene, struct view_job *job, int view,
                       const double place[2], struct povray_error *error)
{
    *job = (struct view_job){.shot = {&job->camera, view}, .camera = scene->camera};
    job->offset[0] = place[0] * scene->camera.aperture / 4;
    job->offset[1] = place[1] * scene->camera.aperture / 4;
    move_camera(&job->camera, job->offset);
    struct text tail = {0};
    add_camera(&tail, &job->shot);
    char *name = shot_name(&job->shot, "colour");
    bool is_started = scene_start_render(scene, &job->colour, name, REWRITE_PINHOLE, "",
                                         tail.data, VIEW_OPTIONS, "", error) &&
                      start_fogs(scene, &job->shot, &job->fogs, REWRITE_PINHOLE, error);
    free(name);
    text_free(&tail);
    return is_started;
}

static bool finish_view(struct povray_scene *scene, struct view_job *job,
                        struct povray_passes *passes, struct povray_error *error)
{
    struct run *list[5] = {&job->colour};
    *passes = (struct povray_passes){.camera = scene->camera,
                                     .gamma = scene->space.gamma,
                                     .is_srgb = scene->space.is_srgb,
                                     .lens_offset = {job->offset[0], job->offset[1]}};
    return scene_wait(scene, list, list_fogs(&job->fogs, list, 1), error) &&
           read_colour(scene, &job->colour, passes, error) &&
           read_fogs(scene, &job->shot, &job->fogs, passes, error) &&
           look_inside(scene, &job->shot, passes, error);
}

static void stop_view(struct view_job *job)
{
    run_stop(&job->colour);
    stop_fogs(&job->fogs);
}

static bool run_views(struct povray_scene *scene, const double (*places)[2],
                      int n_views, povray_view_fn receive, void *user,
                      struct povray_error *error)
{
    struct view_job jobs[VIEWS_AT_ONCE] = {0};
    bool is_good = true;
    for (int i = 0; i < n_views + VIEWS_AT_ONCE - 1 && is_good; i++) {
        int done = i - (VIEWS_AT_ONCE - 1);
        if (i < n_views)
            is_good = start_view(scene, &jobs[i % VIEWS_AT_ONCE], i, places[i], error);
        if (done < 0 || !is_good)
            continue;
        struct view_job *job = &jobs[done % VIEWS_AT_ONCE];
        struct povray_passes passes;
        is_good = finish_view(scene, job, &passes, error) &&
                  receive(user, done, &passes, error);
        povray_passes_free(&passes);
        stop_view(job);
        if (scene->options.progress)
            scene->options.progress(scene->options.user, (done + 1.0) / n_views);
    }
    for (int i = 0; i < VIEWS_AT_ONCE; i++)
        stop_view(&jobs[i]);
    return is_good;
}

bool povray_render_views(struct povray_scene *scene, const double (*places)[2],
                         int n_views, povray_view_fn receive, void *user,
                         double *total_s, struct povray_error *error)
{
    struct povray_camera camera;
    double started_s = seconds_now(), gamma;
    bool is_good = povray_find_camera(scene, &camera, &gamma, error) &&
                   run_views(scene, places, n_views, receive, user, error);
    *total_s = seconds_now() - started_s;
    return is_good;
}

bool povray_find_camera(struct povray_scene *scene, struct povray_camera *camera,
                        double *gamma, struct povray_error *error)
{
    *error = (struct povray_error){.message = ""};
    bool is_found = scene_find_items(scene, error) &&
                    scene_choose_camera(scene, error) &&
                    (run_probe(scene, error) || try_guesses(scene, error));
    *camera = scene->camera;
    *gamma = scene->space.gamma;
    return is_found;
}

bool povray_render_reference(struct povray_scene *scene,
                             const struct povray_passes *passes, int32_t n_samples,
                             float **rgba, double *seconds, struct povray_error *error)
{
    struct run run = {0}, *list[] = {&run};
    struct text tail = {0};
    struct decode_picture picture = {0};
    const struct decode_picture size = {.width = passes->width,
                                        .height = passes->height};
    if (passes->camera.is_orthographic) {
        snprintf(error->message, sizeof error->message,
                 "%s: POV-Ray 3.7 has no working focal blur for orthographic cameras; "
                 "leave out --reference",
                 scene->options.scene);
        return false;
    }
    text_addf(&tail, "\n");
    camera_write(&tail, &passes->camera, n_samples);
    bool is_good = scene_start_render(scene, &run, "reference", REWRITE_PINHOLE, "",
                                      tail.data, "", "", error) &&
                   run_wait(list, 1, &scene->options, error) &&
                   scene_read(scene, &run, &picture, error) &&
                   same_size(scene, &size, &picture, error);
    *seconds = run.ended_s - run.started_s;
    run_stop(&run);
    text_free(&tail);
    *rgba = picture.rgba;
    return is_good;
}
