/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the background thread share; for no other file. */
#ifndef VIEW_WORKER_PARTS_H
#define VIEW_WORKER_PARTS_H

#include "pixels/display.h"
#include "thread.h"
#include "filtering/worker.h"

enum { MAX_SAVES = 8 };

/* The input made smaller for previews. */
struct small {
    struct input *input; /* NULL: none; held */
    int times;
    float *colour, *depth; /* depth as `is_planar` says */
    bool is_planar;
};

/* A filtered picture that is kept, since exposure and mode change without it. */
struct kept {
    struct input *input; /* NULL: none; held */
    struct rf_params params;
    struct stack stack;
    bool has_eye;
    double eye[2];
    int times, eye_view;
    char method[32];
    struct pixels *pixels; /* of shrink_side(width, times), ...; held */
    double filter_ms;
};

struct worker {
    struct os_thread thread;
    struct os_lock lock;
    struct os_condition changed;
    void (*wake)(void *user);
    void *user;
    /* Under the lock. */
    struct job asked; /* input NULL: nothing yet */
    bool is_new, is_ending, is_draining, is_working;
    bool is_settled; /* nothing newer is coming */
    struct save saves[MAX_SAVES];
    int n_saves;
    struct shot *shots[2];
    struct worker_state state;
    double asked_s; /* when the newest job came */
    /* Of the thread alone. */
    struct rf_context *context;
    struct tone *tone;
    struct small small[1 + STACK_MOST]; /* of the input, of the others */
    struct kept preview, best;
    double preview_ns_px, best_ns_px; /* measured; 0: not yet */
    int32_t best_method;              /* that best_ns_px is of */
    double woken_s;
    struct input *pinhole_input; /* what the last pinhole shot showed; held */
    struct job pinhole_job;      /* that showed it, its reference held */
    bool is_saving;
};

/* show.c: shots out of what was made; they go to the window. */
void show_error(struct worker *w, const struct job *job, const char *text);
void show_kept(struct worker *w, const struct job *job, const struct kept *kept,
               enum shot_quality quality);

/* Depth, radii, what is in focus: no filter is needed. False with the error. */
bool show_map(struct worker *w, const struct job *job, struct rf_error *error);

/* The picture to compare with: the pinhole's or the reference. */
void show_before(struct worker *w, const struct job *job);

#endif
