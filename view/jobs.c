/* SPDX-License-Identifier: Apache-2.0 */
/* What the worker is asked for. */
#include "app.h"

bool view_is_stereo(const struct app *app)
{
    return app->options->is_demo ? app->demo.is_stereo : app->options->is_stereo;
}

/* Tells the worker what is looked at now. */
void view_job(const struct app *app, struct reference *reference, struct job *job,
              char *problem, size_t n_bytes)
{
    state_job(&app->state, app->source, reference, job);
    job->stack.eyes = app->eyes;
    *problem = 0;
    if (app->options->is_demo && app->source && app->source->n_others > 0) {
        job->stack = (struct stack){.kind = STACK_STEREO, .eyes = app->eyes, .n = 1};
        job->stack.params[0] = job->params;
    } else if (!app->stage || !stage_stack(app->stage, &app->state.typed, &job->params,
                                           &job->stack, problem, n_bytes))
        job->stack = (struct stack){0}; /* the first alone */
    job->light = app->light.data ? &app->light : NULL;
}

static void ask(struct app *app)
{
    struct job job;
    if (app->is_demo_due) {
        struct input *drawn = demo_draw(&app->demo);
        app->is_demo_due = false;
        if (drawn) {
            input_drop(app->source);
            app->source = drawn;
            app->state.id++;
        } else {
            view_say(app, "out of memory for the scene");
        }
    }
    if (!app->has_stage || !app->state.is_valid || app->state.id == app->asked_id) {
        stats_no_change(&app->stats);
        return;
    }
    app->asked_id = app->state.id;
    stats_change(&app->stats, app->state.id);
    char problem[512];
    view_job(app, app->reference, &job, problem, sizeof(problem));
    if (problem[0])
        view_say(app, "%s", problem);
    worker_ask(app->worker, &job);
}

void view_ask(struct app *app)
{
    ask(app);
    if (app->is_let_go)
        worker_settle(app->worker);
    app->is_let_go = false;
}
