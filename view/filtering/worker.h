/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The background thread: takes the newest thing asked for, shows a preview of it at
 * once, and the best picture when nothing newer came for a moment. Work on a best
 * picture is cancelled, within one tile, as soon as something newer is asked for.
 *
 * Results are shots: 8 bit pictures ready for the screen. The window takes them when it
 * is told that there is one; it never waits.
 */
#ifndef VIEW_WORKER_H
#define VIEW_WORKER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "model/reference.h"
#include "pixels/input.h"
#include "rackfocus/rackfocus.h"

/* X(NAME, "name", "what it shows") */
#define VIEW_MODES(X)                                                                  \
    X(PICTURE, "picture", "the picture")                                               \
    X(DEPTH, "depth", "depth, lighter = farther")                                      \
    X(COC, "blur", "circle of confusion: orange before, blue behind the focus")        \
    X(BAND, "in focus", "what is in focus in colour")                                  \
    X(DIFFERENCE, "difference", "difference to the reference")                         \
    X(EXPOSURE, "exposure", "false colours: how many stops from middle grey")
#define MODE_ENUM(constant, name, help) MODE_##constant,
enum view_mode { VIEW_MODES(MODE_ENUM) N_MODES };
#undef MODE_ENUM

/* Filtered pixels that several hold; never changed. */
struct pixels {
    int n_holders; /* changes with pixels_hold and pixels_drop only */
    int n_channels;
    float *values; /* packed, rows from the top */
};
struct pixels *pixels_create(size_t n, int n_channels); /* NULL: no memory */
struct pixels *pixels_hold(struct pixels *pixels);
void pixels_drop(struct pixels *pixels); /* may be NULL */

struct job {
    uint64_t id; /* grows */
    struct input *input;
    struct rf_params params;
    enum view_mode mode;
    double exposure;                  /* stops */
    double gain;                      /* of the difference; 0: 1 */
    bool has_eye;                     /* the pinhole picture from a point of the lens */
    double eye[2];                    /* lens radii, right and up */
    bool wants_filter, wants_pinhole; /* which of the two pictures is looked at */
    struct reference *reference;      /* NULL: none */
    bool compares_reference;          /* in place of the pinhole, if it has the size */
    const struct colour *colour;      /* view transform; NULL: that of sRGB; the same */
    struct stack stack;               /* with input->others */
    const struct rf_image *light;     /* for distribution = image; the same */
};

enum shot_quality { SHOT_PREVIEW, SHOT_BEST };

struct shot {
    uint64_t id; /* of the job */
    bool is_pinhole;
    enum shot_quality quality;
    enum view_mode mode;
    char method[32];
    int32_t width, height; /* of rgba */
    int times;             /* the input's px per px of rgba */
    uint8_t *rgba;
    struct input *input;   /* what it shows, held */
    struct pixels *pixels; /* where it is the best picture, held; else NULL */
    double full_px;        /* MODE_COC: the radius that has the full colour */
    double filter_ms, display_ms;
    double tpsnr_db; /* to the reference; NAN: it was not measured */
    int n_views;     /* of the reference that this is to; 0: of a file */
    int eye_view;    /* the view that the eye's picture came from */
    char error[320]; /* instead of pixels; "" for none */
};

void shot_free(struct shot *shot); /* may be NULL */

/* What to do with the pixels of the best picture. Called on the worker's thread. */
struct save {
    struct job job;
    void (*write)(void *user, float *pixels, const char *error);
    void *user;
};

struct worker;

/* NULL without memory or a thread. `wake` is called on the worker's thread when there
 * is something to take. */
struct worker *worker_start(int n_threads, void (*wake)(void *user), void *user);
void worker_stop(struct worker *worker); /* cancels; frees all */

/* Takes a hold of what the job points to. */
void worker_ask(struct worker *worker, const struct job *job);

/* Nothing more is coming, the mouse was let go: the best picture of what was asked for
 * last is begun at once, without the pause that shows that nothing moves. */
void worker_settle(struct worker *worker);

/* The newest shot, of the filter or of the pinhole, or NULL; the caller frees it. */
struct shot *worker_take(struct worker *worker, bool is_pinhole);

/* Waits until nothing is under way, after cancelling it; saves are finished. */
void worker_drain(struct worker *worker);

void worker_save(struct worker *worker, const struct save *save);

struct worker_state {
    bool is_busy, is_best; /* at work; on a best picture */
    double fraction;       /* of the best picture */
    uint64_t n_cancelled;
    uint64_t n_settled; /* best pictures that were begun without a pause */
    double cancel_ms;   /* longest time from asking to the end of cancelled work */
};
void worker_state(struct worker *worker, struct worker_state *state);

#endif
