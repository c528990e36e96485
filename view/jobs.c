/* SPDX-License-Identifier: Apache-2.0 */
/* What the worker is asked for. */
#include "app.h"

/* Tells the worker what is looked at now. */
void view_job(const struct app *app, const struct picture *reference, struct job *job)
{
    state_job(&app->state, app->source, reference, job);
    char text[512];
    job->stack.eyes = app->eyes;
    if (app->stage && !stage_stack(app->stage, &app->state.typed, &job->params,
                                   &job->stack, text, sizeof(text)))
        job->stack = (struct stack){0}; /* the first alone */
    if (!app->stage)
        job->stack = (struct stack){0};
    job->light = app->light.data ? &app->light : NULL;
}

void view_ask(struct app *app)
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
    view_job(app, app->has_reference ? &app->reference : NULL, &job);
    worker_ask(app->worker, &job);
}
