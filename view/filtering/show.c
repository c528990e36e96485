/* SPDX-License-Identifier: Apache-2.0 */
/* Shots: from filtered pixels, depth and radii to what the window draws. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "common/report.h"
#include "pixels/colour.h"
#include "pixels/difference.h"
#include "pixels/maps.h"
#include "pixels/shrink.h"
#include "filtering/worker_parts.h"

struct pixels *pixels_create(size_t n, int n_channels)
{
    struct pixels *pixels = app_memory(1, sizeof(*pixels), NULL);
    float *values = app_memory(n, (size_t)n_channels * sizeof(float), NULL);
    if (!pixels || !values) {
        free(pixels);
        free(values);
        return NULL;
    }
    *pixels = (struct pixels){1, n_channels, values};
    return pixels;
}

struct pixels *pixels_hold(struct pixels *pixels)
{
    __atomic_add_fetch(&pixels->n_holders, 1, __ATOMIC_RELAXED);
    return pixels;
}

void pixels_drop(struct pixels *pixels)
{
    if (!pixels || __atomic_sub_fetch(&pixels->n_holders, 1, __ATOMIC_ACQ_REL) > 0)
        return;
    free(pixels->values);
    free(pixels);
}

void shot_free(struct shot *shot)
{
    if (!shot)
        return;
    input_drop(shot->input);
    pixels_drop(shot->pixels);
    free(shot->rgba);
    free(shot);
}

/* ---- what has been made ---------------------------------------------------------- */

static void publish(struct worker *w, struct shot *shot)
{
    os_lock_take(&w->lock);
    struct shot *old = w->shots[shot->is_pinhole];
    w->shots[shot->is_pinhole] = shot;
    os_lock_release(&w->lock);
    shot_free(old);
    w->wake(w->user);
}

void show_error(struct worker *w, const struct job *job, const char *text)
{
    struct shot *shot = app_memory(1, sizeof(*shot), NULL);
    if (!shot)
        return; /* what is shown stays */
    shot->id = job->id;
    shot->quality = SHOT_BEST;
    shot->input = input_hold(job->input);
    snprintf(shot->error, sizeof(shot->error), "%s", text);
    publish(w, shot);
}

/* NULL without memory, which is then what is shown. */
static struct shot *new_shot(struct worker *w, const struct job *job, int times)
{
    const int32_t width = shrink_side(job->input->width, times);
    const int32_t height = shrink_side(job->input->height, times);
    struct shot *shot = app_memory(1, sizeof(*shot), NULL);
    uint8_t *rgba = app_memory((size_t)width * (size_t)height, 4, NULL);
    if (!shot || !rgba) {
        free(shot);
        free(rgba);
        show_error(w, job, "out of memory");
        return NULL;
    }
    *shot = (struct shot){.id = job->id,
                          .mode = job->mode,
                          .times = times,
                          .width = width,
                          .height = height,
                          .tpsnr_db = NAN,
                          .input = input_hold(job->input),
                          .rgba = rgba};
    return shot;
}

/* ---- showing --------------------------------------------------------------------- */

/* Colours as they are looked at. */
static void paint(struct worker *w, const struct job *job, const float *pixels,
                  int n_channels, size_t n, uint8_t *rgba)
{
    if (job->colour)
        colour_show(job->colour, pixels, n_channels, n, job->exposure, rgba);
    else
        display_picture(w->tone, pixels, n_channels, n, job->exposure, rgba);
}

void show_kept(struct worker *w, const struct job *job, const struct kept *kept,
               enum shot_quality quality)
{
    const double start_s = os_clock_s();
    struct shot *shot = new_shot(w, job, kept->times);
    if (!shot)
        return;
    const float *pixels = kept->pixels->values;
    const int n_channels = job->input->n_channels;
    const size_t n = (size_t)shot->width * (size_t)shot->height;
    shot->quality = quality;
    shot->filter_ms = kept->filter_ms;
    shot->eye_view = kept->eye_view;
    if (quality == SHOT_BEST)
        shot->pixels = pixels_hold(kept->pixels);
    snprintf(shot->method, sizeof(shot->method), "%s", kept->method);
    const bool is_compared =
        kept->times == 1 && reference_fits(job->reference, shot->width, shot->height);
    if (job->mode == MODE_DIFFERENCE && is_compared)
        difference_show(job, pixels, shot);
    else if (job->mode == MODE_EXPOSURE)
        display_exposure(pixels, n_channels, n, job->exposure, shot->rgba);
    else
        paint(w, job, pixels, n_channels, n, shot->rgba);
    /* A scene's own reference follows every change: what is shown is always measured. */
    if (is_compared && (job->mode == MODE_DIFFERENCE ||
                        (quality == SHOT_BEST && job->reference->n_views > 0)))
        difference_measure(job, pixels, shot);
    shot->display_ms = 1000 * (os_clock_s() - start_s);
    publish(w, shot);
}

/* Depth, radii, what is in focus: no filter is needed. */
bool show_map(struct worker *w, const struct job *job, struct rf_error *error)
{
    const struct input *input = job->input;
    const double start_s = os_clock_s();
    struct shot *shot = new_shot(w, job, 1);
    if (!shot)
        return true;
    const size_t n = (size_t)shot->width * (size_t)shot->height;
    shot->quality = SHOT_BEST;
    snprintf(shot->method, sizeof(shot->method), "none");
    if (job->mode == MODE_DEPTH) {
        display_depth(input->planar, n, input->nearest, input->farthest, shot->rgba);
    } else {
        float *radius = app_memory(n, sizeof(float), NULL);
        if (!radius)
            *error =
                (struct rf_error){.code = RF_ERROR_MEMORY, .message = "out of memory"};
        if (!radius || !maps_radius(w->context, job, radius, error)) {
            free(radius);
            shot_free(shot);
            return false;
        }
        if (job->mode == MODE_COC)
            display_coc(radius, n, shot->full_px = maps_full_radius(radius, n),
                        shot->rgba);
        else
            display_band(w->tone, input->colour, input->n_channels, radius, n,
                         job->exposure, job->params.coc_limit, shot->rgba);
        free(radius);
    }
    shot->display_ms = 1000 * (os_clock_s() - start_s);
    publish(w, shot);
    return true;
}

/* Would it look as the last one that was shown? */
static bool is_before_shown(const struct worker *w, const struct job *job)
{
    const struct job *last = &w->pinhole_job;
    return w->pinhole_input == job->input && last->exposure == job->exposure &&
           last->colour == job->colour &&
           last->compares_reference == job->compares_reference &&
           (!job->compares_reference || last->reference == job->reference);
}

void show_before(struct worker *w, const struct job *job)
{
    const struct input *input = job->input;
    const struct reference *reference = job->reference;
    if (is_before_shown(w, job))
        return;
    const double start_s = os_clock_s();
    struct shot *shot = new_shot(w, job, 1);
    if (!shot)
        return;
    const size_t n = (size_t)input->width * (size_t)input->height;
    shot->is_pinhole = true;
    shot->quality = SHOT_BEST;
    if (job->compares_reference &&
        reference_fits(reference, input->width, input->height))
        paint(w, job, reference->picture.samples, 3, n, shot->rgba);
    else
        paint(w, job, input->colour, input->n_channels, n, shot->rgba);
    shot->display_ms = 1000 * (os_clock_s() - start_s);
    input_drop(w->pinhole_input);
    w->pinhole_input = input_hold(job->input);
    reference_drop(w->pinhole_job.reference);
    reference_hold(job->reference);
    w->pinhole_job = *job;
    publish(w, shot);
}
