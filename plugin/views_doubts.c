/* SPDX-License-Identifier: Apache-2.0 */
/* Warnings of views that are hardly of one lens and exposure, as Python's. */
#include "module.h"

#include <stdio.h>

#include "sources/views_fit.h"
#include "sources/views_light.h"

/* Others the core refuses, in words of its own. */
static bool are_alike(const struct plugin_filter *filter,
                      const struct plugin_views *open)
{
    for (int i = 0; i < open->n; i++) {
        const struct rf_image *colour = &open->views[i].colour;
        const struct rf_image *depth = &open->views[i].depth;
        if (colour->width != filter->size_px[0] || depth->width != colour->width ||
            colour->height != filter->size_px[1] || depth->height != colour->height)
            return false;
    }
    return true;
}

/* Is their exposure another? Without the lock. */
static bool find_light(const struct plugin_views *open, char *text, size_t n_text)
{
    struct views_light_found found;
    char what[300];
    if (!views_light_is_other(open->views, open->n, &found))
        return false;
    views_light_explain(&found, what, sizeof(what));
    snprintf(text, n_text, "views: view %d %s", found.view, what);
    return true;
}

/* Do they lie elsewhere? Without the lock. */
static bool find_fit(const struct plugin_filter *filter,
                     const struct plugin_views *open, char *text, size_t n_text)
{
    static const struct views_words words = {"its lens_offset", "lens_offset",
                                             "lens_offset", "shear_distance"};
    const struct views_fit_given given = {
        open->views, open->n, 0, &filter->params, rf_filter_lens(filter->filter),
        &words};
    struct views_fit found;
    char what[500], view[24] = "";
    if (!rf_method_find(filter->params.method)->needs_depth ||
        !views_fit_is_wrong(&given, &found))
        return false;
    views_fit_explain(&found, &words, what, sizeof(what));
    if (found.wrong_view >= 0)
        snprintf(view, sizeof(view), "view %d ", found.wrong_view);
    snprintf(text, n_text, "views: %s%s", view, what);
    return true;
}

int plugin_warn_views(const struct module_state *state,
                      const struct plugin_filter *filter,
                      const struct plugin_views *open)
{
    char light[400], fit[600];
    bool has_light = false, has_fit = false;
    if (open->n < 2 || !are_alike(filter, open))
        return 0;
    Py_BEGIN_ALLOW_THREADS;
    has_light = find_light(open, light, sizeof(light));
    has_fit = find_fit(filter, open, fit, sizeof(fit));
    Py_END_ALLOW_THREADS;
    if (has_light && PyErr_WarnFormat(state->views_warning, 1, "%s", light) < 0)
        return -1;
    return has_fit ? PyErr_WarnFormat(state->views_warning, 1, "%s", fit) : 0;
}
