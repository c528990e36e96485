/* SPDX-License-Identifier: Apache-2.0 */
/* The demo's accumulated views as what the window compares with. */
#ifndef VIEW_ACCUMULATION_H
#define VIEW_ACCUMULATION_H

#include <stdbool.h>

#include "demo/demo_views.h"
#include "controls/gl.h"
#include "pixels/display.h"

struct app;

struct accumulation {
    bool is_on;
    int n; /* views that are wanted, 1 to DEMO_MOST_VIEWS */
    enum demo_move move;
    struct demo_views views;
    int n_published;           /* views of the reference that the worker has */
    struct gl_picture picture; /* the mean so far, as it is looked at */
    bool is_picture_good;      /* of the scene and the lens as they are now */
    float *mean;
    uint8_t *rgba; /* of the picture */
    struct tone *tone;
    char problem[320]; /* why no views can be drawn; "": they can */
    int n_complete;    /* means of all views that were made, for --benchmark */
    int n_drawn;       /* views */
};

/* On with the reference that F and S show, off without it. */
void accumulation_switch(struct app *app, bool is_on);
void accumulation_toggle(struct app *app);

/* Part of the main loop: draws some views where it is time for that. */
void accumulation_step(struct app *app);

/* Milliseconds until it has something to do; INFINITY: nothing. */
double accumulation_waits_ms(const struct app *app);

/* What is shown in place of the pinhole; NULL: the pinhole or another reference. */
const struct gl_picture *accumulation_picture(const struct app *app);

/* Needs the OpenGL context. */
void accumulation_close(struct app *app);

/* The controls of the panel. */
void accumulation_rows(struct app *app);

#endif
