/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the user has set: the parameters, the view and its toggles. No window, no
 * thread: events become calls of these functions, and a job for the worker is made from
 * it.
 */
#ifndef VIEW_STATE_H
#define VIEW_STATE_H

#include <stdbool.h>
#include <stdint.h>

#include "pixels/zoom.h"
#include "sources/settings.h"
#include "filtering/worker.h"

/* Finds all parameters from what was typed, as struct stage or the demo does. */
struct resolver {
    bool (*resolve)(void *user, const struct settings *typed, struct settings *settings,
                    struct rf_params *params, char *text, size_t n_bytes);
    void *user;
};

/* Who set a value of state->typed. */
enum setter {
    SETTER_COMMAND_LINE, /* or nobody */
    SETTER_USER,         /* in the window */
    SETTER_LOOK,         /* the look that is set; taken back with it */
};

/* The same of all parameters, in the order of rf_param_list, and what the look that is
 * set lies over. */
struct setters {
    char look[64]; /* its name; "": none */
    struct settings below;
    unsigned char of_typed[SETTINGS_MAX_PARAMS], of_below[SETTINGS_MAX_PARAMS];
};

/* What the user can set and undo, and what a snapshot keeps. Compared byte by byte. */
struct look {
    struct settings typed;
    struct setters setters;
    double exposure; /* stops */
};

struct state {
    struct resolver resolver;
    struct settings started;  /* the command line */
    struct settings typed;    /* the command line and what was changed since */
    struct setters setters;   /* of `typed` */
    struct settings settings; /* with the header's facts */
    struct rf_params params;  /* for the data window */
    struct rf_lens lens;
    bool is_valid; /* settings, params and lens are */
    int32_t width, height;
    char problem[1024]; /* why the last change was refused, and the way out; "" */

    enum view_mode mode;
    bool is_filter_on, is_split, has_eye;
    bool draws_views;            /* of the lens, beside the method's picture */
    bool compares_reference;     /* `off` and `split` show it in place of the pinhole */
    const struct colour *colour; /* view transform; NULL: sRGB */
    double split;                /* share of the picture that shows the pinhole */
    double exposure;             /* stops */
    double gain;                 /* of the difference */
    double eye[2];               /* lens radii, right and up, within the lens */
    struct zoom zoom;
    uint64_t id; /* grows with every change of what the worker makes */
};

void state_init(struct state *state, const struct settings *typed, double exposure);

/* The command line named a look, which set what `below` lacks. */
void state_begin_look(struct state *state, const char *name,
                      const struct settings *below);

/* Another picture. False with `problem` where its facts and the options conflict. */
bool state_open(struct state *state, const struct resolver *resolver, int32_t width,
                int32_t height, double aspect);

/* Sets a parameter as if typed. Where that makes no lens nothing changes, `problem`
 * says why, and false is returned. */
bool state_set(struct state *state, const char *key, double value);

/* Puts a parameter, and what says the same, back to what command line, file or default
 * give. As state_set(). */
bool state_reset(struct state *state, const char *key);

/* Why the parameter has no effect with this file, lens and method, a sentence without a
 * full stop; NULL where it has, or would have if it were set. */
const char *state_why_off(const struct state *state, const char *key);

/* Has the parameter an effect though nobody gave it? Then the default is a guess. */
bool state_is_guess(const struct state *state, const char *key);

/* What is set now, and that again. state_apply(): false with `problem` where the file
 * does not go with it; then nothing has changed. */
void state_look(const struct state *state, struct look *look);
bool state_apply(struct state *state, const struct look *look);

/* Sets what `over` says as typed, over what was set before. As state_set(). */
bool state_merge(struct state *state, const struct settings *over);

/* Sets what a look of looks.h says in place of what the look before it set, which becomes
 * what it was before that; but what the user has set since stays. "": no look. As
 * state_set(). */
bool state_set_look(struct state *state, const char *name);

/* Who set it; `key` or field. */
enum setter state_setter(const struct state *state, const char *key);

/* Puts the depth in focus: any above 0, INFINITY too. */
bool state_focus(struct state *state, double depth);

/* Yu's lens: the focus that a screen at this distance behind the lens gives. */
bool state_set_screen(struct state *state, double position);

/* Where the screen stands for the focus distance, scene units; NAN where no focal length
 * is known or the focus lies inside it. */
double state_screen(const struct state *state);

/* The f-stop that holds, also where the lens was given by its radius; NAN if unknown.
 */
double state_f_stop(const struct state *state);

/* Shows the mode, or the picture again where it is shown already. */
void state_toggle_mode(struct state *state, enum view_mode mode);
void state_toggle_filter(struct state *state);
void state_toggle_split(struct state *state);
void state_set_exposure(struct state *state, double stops);
void state_set_gain(struct state *state, double gain); /* 1 to 64 */

/* The eye within the lens, in lens radii; `is_on` false shows the lens's picture. */
void state_set_eye(struct state *state, bool is_on, double right, double up);

/* What is looked at, as a job; `input` and `reference` are the caller's. */
void state_job(const struct state *state, struct input *input,
               struct reference *reference, struct job *job);

#endif
