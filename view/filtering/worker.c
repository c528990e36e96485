/* SPDX-License-Identifier: Apache-2.0 */
#include "filtering/worker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "common/report.h"
#include "pixels/lamps.h"
#include "pixels/means.h"
#include "pixels/shrink.h"
#include "sources/deep.h"
#include "filtering/quick.h"
#include "filtering/worker_parts.h"

enum {
    SETTLE_MS = 120, /* without anything new before the best picture is begun */
    PREVIEW_MS = 24, /* what a preview may take; pictures are made smaller for it */
    MAX_SHRINK = 16,
    WAKE_MS = 80, /* between two reports of progress */
};

static rf_result fail_memory(struct rf_error *error)
{
    *error = (struct rf_error){.code = RF_ERROR_MEMORY, .message = "out of memory"};
    return RF_ERROR_MEMORY;
}

/* What a job points to, held as long as somebody works for it. */
static void hold_job(const struct job *job)
{
    input_hold(job->input);
    reference_hold(job->reference);
}

static void drop_job(const struct job *job)
{
    input_drop(job->input);
    reference_drop(job->reference);
}

/* ---- filtering ------------------------------------------------------------------- */

static bool is_newer_asked(struct worker *w)
{
    os_lock_take(&w->lock);
    const bool is_newer = w->is_new || w->is_ending || w->is_draining;
    os_lock_release(&w->lock);
    return is_newer;
}

static bool is_ending(struct worker *w)
{
    os_lock_take(&w->lock);
    const bool is_over = w->is_ending;
    os_lock_release(&w->lock);
    return is_over;
}

/* For struct rf_progress. */
static bool report_best(void *user, double fraction)
{
    struct worker *w = user;
    const double now_s = os_clock_s();
    os_lock_take(&w->lock);
    w->state.fraction = fraction;
    os_lock_release(&w->lock);
    if (1000 * (now_s - w->woken_s) > WAKE_MS) {
        w->woken_s = now_s;
        w->wake(w->user);
    }
    return w->is_saving ? !is_ending(w) : !is_newer_asked(w);
}

/* What is filtered; `out` may be one of the views. */
struct filtering {
    const struct rf_params *params;
    const struct rf_image *light;
    const struct rf_view *views;
    int n_views;
    const struct deep_frame *deep; /* in place of the views; or NULL */
    const struct rf_image *out;
    const struct rf_progress *progress;
};

/* Runs the filter and measures it. */
static rf_result run_filter(struct worker *w, const struct filtering *f, double *ms,
                            struct rf_error *error)
{
    const struct rf_params *params = f->params;
    const struct rf_image *out = f->out;
    const double start_s = os_clock_s();
    struct rf_filter *filter;
    const bool has_light = f->light && params->method == RF_METHOD_SCATTER &&
                           params->distribution == RF_DISTRIBUTION_IMAGE;
    rf_result result =
        rf_filter_create_with(&filter, w->context, params, out->width, out->height,
                              has_light ? f->light : NULL, error);
    if (result != RF_OK)
        return result;
    if (f->deep)
        result =
            rf_filter_process_deep(filter, &f->deep->frame, out, f->progress, error);
    else
        result =
            rf_filter_process(filter, f->views, f->n_views, out, f->progress, error);
    rf_filter_destroy(filter);
    *ms = 1000 * (os_clock_s() - start_s);
    return result;
}

static void forget(struct kept *kept)
{
    input_drop(kept->input);
    pixels_drop(kept->pixels);
    *kept = (struct kept){0};
}

static void forget_small(struct small *small)
{
    input_drop(small->input);
    free(small->colour);
    free(small->depth);
    *small = (struct small){0};
}

static void forget_all(struct worker *w)
{
    for (int i = 0; i <= STACK_MOST; i++)
        forget_small(&w->small[i]);
    forget(&w->preview);
    forget(&w->best);
    input_drop(w->pinhole_input);
    w->pinhole_input = NULL;
    reference_drop(w->pinhole_job.reference);
    w->pinhole_job.reference = NULL;
}

/* Is that picture still what is asked for? */
static bool is_kept(const struct kept *kept, const struct job *job)
{
    return kept->input == job->input && kept->has_eye == job->has_eye &&
           memcmp(kept->eye, job->eye, sizeof(kept->eye)) == 0 &&
           memcmp(&kept->stack, &job->stack, sizeof(kept->stack)) == 0 &&
           memcmp(&kept->params, &job->params, sizeof(kept->params)) == 0;
}

static bool begin_kept(struct kept *kept, const struct job *job, int times)
{
    forget(kept);
    const size_t n = (size_t)shrink_side(job->input->width, times) *
                     (size_t)shrink_side(job->input->height, times);
    *kept = (struct kept){.input = input_hold(job->input),
                          .params = job->params,
                          .stack = job->stack,
                          .has_eye = job->has_eye,
                          .eye = {job->eye[0], job->eye[1]},
                          .times = times};
    kept->pixels = pixels_create(n, job->input->n_channels);
    if (!kept->pixels)
        forget(kept);
    return kept->pixels != NULL;
}

/* How much smaller the preview must be to come in time. */
static int choose_shrink(const struct worker *w, const struct input *input)
{
    const double n = (double)input->width * input->height;
    const double ns_px = w->preview_ns_px > 0 ? w->preview_ns_px : 40;
    int times = 1;
    while (times < MAX_SHRINK && n * ns_px / (times * times) > PREVIEW_MS * 1e6)
        times++;
    return times;
}

/* The job of one of the others, on its own. */
static struct job job_of_other(const struct job *job, int i)
{
    struct job other = *job;
    other.input = job->input->others[i];
    other.params = job->stack.params[i];
    other.stack = (struct stack){0};
    return other;
}

/* The input `times` smaller, as a view, kept as `small`. False without memory. */
static bool small_view(struct small *small, const struct job *job, int times,
                       struct rf_view *view)
{
    const struct input *input = job->input;
    const int32_t width = shrink_side(input->width, times);
    const int32_t height = shrink_side(input->height, times);
    const size_t n = (size_t)width * (size_t)height;
    const bool is_planar = !input->raw || job->params.optics == RF_OPTICS_BUFFER;
    const float *depth = is_planar ? input->planar : input->raw;
    float *colour = (float *)input->colour;
    if (times > 1 && (small->input != input || small->times != times ||
                      small->is_planar != is_planar)) {
        forget_small(small);
        *small = (struct small){
            .input = input_hold(job->input), .times = times, .is_planar = is_planar};
        small->colour = app_memory(n, (size_t)input->n_channels * sizeof(float), NULL);
        small->depth = app_memory(n, sizeof(float), NULL);
        if (!small->colour || !small->depth) {
            forget_small(small);
            return false;
        }
        shrink_colour(colour, input->width, input->height, input->n_channels, times,
                      small->colour);
        shrink_depth(depth, input->width, input->height, times, small->depth);
    }
    *view = (struct rf_view){
        .colour = rf_image_packed(times > 1 ? small->colour : colour, width, height,
                                  input->n_channels),
        .depth = rf_image_packed(times > 1 ? small->depth : (float *)depth, width,
                                 height, 1)};
    return true;
}

/* The preview of scatter with its lamps as discs. Without memory it has none. */
struct bright {
    struct lamps lamps;
    float *colour; /* without them; NULL: there are none */
};

/* `lens` and view are of the small picture. */
static void take_lamps(const struct job *job, const struct rf_lens *lens, int times,
                       const struct rf_view *view, struct bright *bright)
{
    const struct input *input = job->input;
    const int32_t width = view->colour.width, height = view->colour.height;
    const size_t n = (size_t)width * (size_t)height;
    const size_t n_bytes = n * (size_t)input->n_channels * sizeof(float);
    *bright = (struct bright){.lamps = {.distribution = job->params.distribution}};
    if (job->params.method != RF_METHOD_SCATTER || input->n_channels < 3)
        return;
    float *colour = app_memory(n_bytes, 1, NULL);
    float *radius = app_memory(n, sizeof(float), NULL);
    if (colour && radius) {
        memcpy(colour, view->colour.data, n_bytes);
        shrink_depth(input->planar, input->width, input->height, times, radius);
        for (size_t i = 0; i < n; i++)
            radius[i] = (float)rf_lens_radius_px(lens, radius[i]);
        lamps_take(&bright->lamps, colour, input->n_channels, radius, width, height);
    }
    free(radius);
    if (bright->lamps.n > 0)
        bright->colour = colour;
    else
        free(colour);
}

/* A preview of one input, `times` smaller, into `out`, which is the small picture's. */
static rf_result preview_one(struct worker *w, const struct job *job, int times,
                             struct small *small, struct rf_image *out,
                             struct rf_error *error)
{
    const struct input *input = job->input;
    struct rf_params params = quick_params(job);
    struct rf_lens lens;
    struct rf_view view;
    struct bright bright;
    double unused_ms;
    rf_result result = rf_lens_init(&lens, &params, input->width, input->height, error);
    if (result != RF_OK)
        return result;
    if (times > 1)
        shrink_params(&params, &lens, times);
    if (!small_view(small, job, times, &view))
        return fail_memory(error);
    result = times > 1 ? rf_lens_init(&lens, &params, view.colour.width,
                                      view.colour.height, error)
                       : RF_OK;
    if (result != RF_OK)
        return result;
    void *pixels = out->data;
    *out = view.colour;
    out->data = pixels;
    take_lamps(job, &lens, times, &view, &bright);
    if (bright.colour)
        view.colour.data = bright.colour;
    const struct filtering filtering = {.params = &params,
                                        .light = job->light,
                                        .views = &view,
                                        .n_views = 1,
                                        .out = out};
    result = run_filter(w, &filtering, &unused_ms, error);
    if (result == RF_OK)
        lamps_add(&bright.lamps, out->data, input->n_channels, out->width, out->height);
    free(bright.colour);
    lamps_free(&bright.lamps);
    return result;
}

static rf_result best_one(struct worker *w, const struct job *job, float *pixels,
                          struct rf_error *error)
{
    const struct input *input = job->input;
    const struct rf_progress progress = {report_best, w};
    const struct rf_image out =
        rf_image_packed(pixels, input->width, input->height, input->n_channels);
    double unused_ms;
    struct means means;
    rf_result result = means_open(&means, input, &job->params, error);
    if (result != RF_OK)
        return result;
    const struct filtering filtering = {.params = &job->params,
                                        .light = job->light,
                                        .views = means.views,
                                        .n_views = means.n,
                                        .deep = input->deep,
                                        .out = &out,
                                        .progress = &progress};
    result = run_filter(w, &filtering, &unused_ms, error);
    means_close(&means);
    return result;
}

/* The others of a stack, put over what is in `pixels` or joined with it; previews where
 * `times` is not 0. */
static rf_result add_others(struct worker *w, const struct job *job, int times,
                            float *pixels, struct rf_error *error)
{
    const struct stack *stack = &job->stack;
    const int side = times > 0 ? times : 1;
    const int32_t width = shrink_side(job->input->width, side);
    const int32_t height = shrink_side(job->input->height, side);
    const size_t n = (size_t)width * (size_t)height;
    rf_result result = RF_OK;
    for (int i = 0; i < stack->n && result == RF_OK; i++) {
        const struct job other = job_of_other(job, i);
        float *own =
            app_memory(n, (size_t)other.input->n_channels * sizeof(float), NULL);
        struct rf_image out = {.data = own};
        if (!own)
            return fail_memory(error);
        result = times > 0
                     ? preview_one(w, &other, times, &w->small[1 + i], &out, error)
                     : best_one(w, &other, own, error);
        if (result == RF_OK && stack->kind == STACK_OVER)
            stack_put_over(own, pixels, n, job->input->n_channels);
        else if (result == RF_OK)
            stack_join_eyes(pixels, own, width, height, job->input->n_channels,
                            stack->eyes);
        free(own);
    }
    return result;
}

static rf_result make_preview(struct worker *w, const struct job *job,
                              struct rf_error *error)
{
    const double start_s = os_clock_s();
    const struct input *input = job->input;
    const int times = job->mode == MODE_DIFFERENCE ? 1 : choose_shrink(w, input);
    if (!begin_kept(&w->preview, job, times)) {
        forget(&w->preview);
        return fail_memory(error);
    }
    struct rf_image out = {.data = w->preview.pixels->values};
    rf_result result = preview_one(w, job, times, &w->small[0], &out, error);
    if (result == RF_OK)
        result = add_others(w, job, times, w->preview.pixels->values, error);
    if (result != RF_OK) {
        forget(&w->preview);
        return result;
    }
    w->preview.filter_ms = 1000 * (os_clock_s() - start_s);
    w->preview_ns_px =
        1e6 * w->preview.filter_ms / ((double)out.width * (double)out.height);
    snprintf(w->preview.method, sizeof(w->preview.method), "%s",
             rf_method_list(NULL)[quick_params(job).method].name);
    return RF_OK;
}

/* The picture itself, or what the eye sees. */
static rf_result make_best(struct worker *w, const struct job *job,
                           struct rf_error *error)
{
    const struct input *input = job->input;
    const double start_s = os_clock_s();
    if (!begin_kept(&w->best, job, 1))
        return fail_memory(error);
    os_lock_take(&w->lock);
    w->state.is_best = true;
    w->state.fraction = 0;
    os_lock_release(&w->lock);
    rf_result result = best_one(w, job, w->best.pixels->values, error);
    if (result == RF_OK)
        result = add_others(w, job, 0, w->best.pixels->values, error);
    w->best.filter_ms = 1000 * (os_clock_s() - start_s);
    os_lock_take(&w->lock);
    w->state.is_best = false;
    if (result == RF_ERROR_CANCELLED) {
        const double ms = 1000 * (os_clock_s() - w->asked_s);
        w->state.n_cancelled++;
        if (w->is_new)
            w->state.cancel_ms = fmax(w->state.cancel_ms, ms);
    }
    os_lock_release(&w->lock);
    snprintf(w->best.method, sizeof(w->best.method), "%s",
             rf_method_list(NULL)[job->params.method].name);
    if (result == RF_OK) {
        w->best_ns_px =
            1e6 * w->best.filter_ms / ((double)input->width * input->height);
        w->best_method = job->params.method;
    } else {
        forget(&w->best);
    }
    return result;
}

static rf_result see(struct worker *w, const struct job *job, struct rf_error *error)
{
    const double start_s = os_clock_s();
    struct rf_lens lens;
    const rf_result result =
        rf_lens_init(&lens, &job->params, job->input->width, job->input->height, error);
    if (result != RF_OK)
        return result;
    if (!begin_kept(&w->best, job, 1))
        return fail_memory(error);
    if (!input_see(job->input, &lens, job->eye, w->best.pixels->values,
                   &w->best.eye_view)) {
        forget(&w->best);
        return fail_memory(error);
    }
    w->best.filter_ms = 1000 * (os_clock_s() - start_s);
    snprintf(w->best.method, sizeof(w->best.method), "eye");
    return RF_OK;
}

/* ---- the thread ------------------------------------------------------------------ */

/* Nothing new for a moment? */
static bool has_settled(struct worker *w)
{
    const double until_s = os_clock_s() + 1e-3 * SETTLE_MS;
    os_lock_take(&w->lock);
    bool is_over = false;
    while (!is_over && !w->is_settled && !w->is_new && !w->is_ending &&
           !w->is_draining && w->n_saves == 0)
        is_over = !os_condition_wait_until(&w->changed, &w->lock, until_s);
    const bool is_still = !w->is_new && !w->is_ending && !w->is_draining;
    w->state.n_settled += is_still && !is_over && w->is_settled;
    os_lock_release(&w->lock);
    return is_still;
}

/* Is the picture itself made as fast as a preview? */
static bool is_best_fast(const struct worker *w, const struct job *job)
{
    const double n = (double)job->input->width * job->input->height;
    return job->mode != MODE_DIFFERENCE && w->best_ns_px > 0 &&
           w->best_method == job->params.method && n * w->best_ns_px < PREVIEW_MS * 1e6;
}

static rf_result show_filtered(struct worker *w, const struct job *job,
                               struct rf_error *error)
{
    rf_result result = RF_OK;
    if (!is_kept(&w->best, job) && job->has_eye)
        result = see(w, job, error);
    if (!is_kept(&w->best, job) && !job->has_eye && !is_best_fast(w, job)) {
        if (!is_kept(&w->preview, job))
            result = make_preview(w, job, error);
        if (result != RF_OK)
            return result;
        show_kept(w, job, &w->preview, SHOT_PREVIEW);
        if (!has_settled(w))
            return RF_ERROR_CANCELLED;
    }
    if (!is_kept(&w->best, job) && !job->has_eye)
        result = make_best(w, job, error);
    if (result == RF_OK)
        show_kept(w, job, &w->best, SHOT_BEST);
    return result;
}

static bool prepare(struct worker *w, const struct job *job, struct rf_error *error)
{
    bool is_good = input_prepare(job->input, w->context, &job->params, error);
    for (int i = 0; i < job->stack.n && is_good; i++)
        is_good = input_prepare(job->input->others[i], w->context,
                                &job->stack.params[i], error);
    return is_good;
}

static void do_job(struct worker *w, const struct job *job)
{
    struct rf_error error;
    if (!prepare(w, job, &error)) {
        show_error(w, job, error.message);
        return;
    }
    rf_result result = RF_OK;
    if (job->wants_pinhole)
        show_before(w, job);
    if (!job->wants_filter)
        return;
    const bool is_map =
        job->mode == MODE_DEPTH || job->mode == MODE_COC || job->mode == MODE_BAND;
    if (is_map)
        result = show_map(w, job, &error) ? RF_OK : error.code;
    else
        result = show_filtered(w, job, &error);
    if (result != RF_OK && result != RF_ERROR_CANCELLED)
        show_error(w, job, error.message);
}

static void do_save(struct worker *w, const struct save *save)
{
    struct rf_error error = {0};
    const struct job *job = &save->job;
    rf_result result = RF_OK;
    w->is_saving = true;
    if (!prepare(w, job, &error))
        result = error.code;
    else if (!is_kept(&w->best, job))
        result = make_best(w, job, &error);
    w->is_saving = false;
    const size_t n = (size_t)job->input->width * (size_t)job->input->height *
                     (size_t)job->input->n_channels;
    float *pixels = NULL;
    if (result == RF_OK) {
        pixels = app_memory(n, sizeof(float), NULL);
        if (pixels)
            memcpy(pixels, w->best.pixels->values, n * sizeof(float));
        else
            result = fail_memory(&error);
    }
    save->write(save->user, pixels, result == RF_OK ? NULL : error.message);
    free(pixels);
    w->wake(w->user);
}

/* Waits for something to do; false at the end. What is returned is held. */
static bool next_task(struct worker *w, struct job *job, struct save *save,
                      bool *is_save)
{
    os_lock_take(&w->lock);
    w->is_working = false;
    w->state.is_busy = false;
    os_condition_wake_all(&w->changed);
    while (!w->is_ending && !w->is_new && w->n_saves == 0)
        os_condition_wait(&w->changed, &w->lock);
    const bool goes_on = !w->is_ending;
    *is_save = w->n_saves > 0;
    if (goes_on && *is_save) {
        *save = w->saves[0];
        w->n_saves--;
        memmove(w->saves, w->saves + 1, (size_t)w->n_saves * sizeof(*w->saves));
    } else if (goes_on) {
        *job = w->asked;
        hold_job(job);
        w->is_new = false;
    }
    w->is_working = goes_on;
    w->state.is_busy = goes_on;
    os_lock_release(&w->lock);
    return goes_on;
}

static void work(void *user)
{
    struct worker *w = user;
    struct job job;
    struct save save;
    bool is_save;
    while (next_task(w, &job, &save, &is_save)) {
        if (is_save) {
            do_save(w, &save);
            drop_job(&save.job);
        } else {
            do_job(w, &job);
            drop_job(&job);
        }
    }
}

/* ---- for the window -------------------------------------------------------------- */

static void worker_free(struct worker *w)
{
    forget_all(w);
    rf_context_destroy(w->context);
    tone_destroy(w->tone);
    os_condition_destroy(&w->changed);
    os_lock_destroy(&w->lock);
    free(w);
}

struct worker *worker_start(int n_threads, void (*wake)(void *user), void *user)
{
    struct worker *w = app_memory(1, sizeof(*w), NULL);
    struct rf_error error;
    if (!w)
        return NULL;
    const struct rf_context_params context = {.size = sizeof(context),
                                              .n_threads = n_threads};
    w->wake = wake;
    w->user = user;
    w->tone = tone_create();
    os_lock_init(&w->lock);
    os_condition_init(&w->changed);
    if (w->tone && rf_context_create(&w->context, &context, &error) == RF_OK &&
        os_thread_start(&w->thread, work, w) == 0)
        return w;
    worker_free(w);
    return NULL;
}

void worker_stop(struct worker *w)
{
    os_lock_take(&w->lock);
    w->is_ending = true;
    os_condition_wake_all(&w->changed);
    os_lock_release(&w->lock);
    os_thread_join(&w->thread);
    for (int i = 0; i < w->n_saves; i++)
        drop_job(&w->saves[i].job);
    drop_job(&w->asked);
    shot_free(w->shots[0]);
    shot_free(w->shots[1]);
    worker_free(w);
}

void worker_ask(struct worker *w, const struct job *job)
{
    os_lock_take(&w->lock);
    const struct job old = w->asked;
    w->asked = *job;
    hold_job(job);
    w->is_new = true;
    w->is_settled = false;
    w->asked_s = os_clock_s();
    os_condition_wake_all(&w->changed);
    os_lock_release(&w->lock);
    drop_job(&old);
}

void worker_settle(struct worker *w)
{
    os_lock_take(&w->lock);
    w->is_settled = true;
    os_condition_wake_all(&w->changed);
    os_lock_release(&w->lock);
}

struct shot *worker_take(struct worker *w, bool is_pinhole)
{
    os_lock_take(&w->lock);
    struct shot *shot = w->shots[is_pinhole];
    w->shots[is_pinhole] = NULL;
    os_lock_release(&w->lock);
    return shot;
}

void worker_drain(struct worker *w)
{
    os_lock_take(&w->lock);
    w->is_draining = true;
    w->is_new = false;
    os_condition_wake_all(&w->changed);
    while (w->is_working || w->n_saves > 0)
        os_condition_wait(&w->changed, &w->lock);
    w->is_draining = false;
    struct shot *old[2] = {w->shots[0], w->shots[1]};
    w->shots[0] = w->shots[1] = NULL;
    const struct job asked = w->asked;
    w->asked.input = NULL;
    w->asked.reference = NULL;
    os_lock_release(&w->lock);
    forget_all(w); /* the thread is idle */
    shot_free(old[0]);
    shot_free(old[1]);
    drop_job(&asked);
}

void worker_save(struct worker *w, const struct save *save)
{
    os_lock_take(&w->lock);
    const bool is_full = w->n_saves == MAX_SAVES;
    if (!is_full) {
        w->saves[w->n_saves++] = *save;
        hold_job(&save->job);
        os_condition_wake_all(&w->changed);
    }
    os_lock_release(&w->lock);
    if (is_full)
        save->write(save->user, NULL, "eight pictures are being saved already; wait");
}

void worker_state(struct worker *w, struct worker_state *state)
{
    os_lock_take(&w->lock);
    *state = w->state;
    os_lock_release(&w->lock);
}
