/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus.Filter: one size and one set of parameters, any number of frames. */
#include "module.h"

#include "sources/white.h"

/* ---- making and ending --------------------------------------------------------- */

/* Takes the keyword `distribution_image` out of `keywords`; *picture is a new reference
 * or NULL. -1 with an exception set. */
static int take_picture(PyObject *keywords, PyObject **picture)
{
    *picture = PyDict_GetItemString(keywords, "distribution_image");
    if (!*picture)
        return 0;
    Py_INCREF(*picture);
    if (PyDict_DelItemString(keywords, "distribution_image") == 0)
        return 0;
    Py_CLEAR(*picture);
    return -1;
}

/* A picture of the aperture that the other parameters leave without effect is said. */
static int warn_of_picture(const struct module_state *state,
                           const struct rf_params *params)
{
    if (params->method == RF_METHOD_SCATTER || params->aperture == RF_APERTURE_IMAGE)
        return 0;
    return PyErr_WarnFormat(state->unread_warning, 1,
                            "distribution_image: has no effect: it is for "
                            "aperture=\"image\" or method=\"scatter\"");
}

/* Makes the filter, with the picture of its distribution where that is not NULL. */
static int make_filter(const struct module_state *state, struct plugin_filter *self,
                       const struct rf_params *params, PyObject *picture)
{
    struct plugin_image image;
    struct rf_error error;
    if (picture && plugin_open_image(&image, picture, "distribution_image", false) < 0)
        return -1;
    rf_result result = rf_filter_create_with(
        &self->filter, plugin_context_of(self->context), params, self->size_px[0],
        self->size_px[1], picture ? &image.image : NULL, &error);
    if (picture)
        plugin_close_image(&image);
    if (result != RF_OK)
        plugin_raise(state, &error);
    return result == RF_OK ? 0 : -1;
}

static PyObject *filter_create(PyTypeObject *type, PyObject *args, PyObject *keywords)
{
    const struct module_state *state = PyType_GetModuleState(type);
    int size_px[2];
    struct rf_params params;
    PyObject *picture = NULL, *context = NULL;
    if (!state || !PyArg_ParseTuple(args, "O&O&:Filter", plugin_take_int, &size_px[0],
                                    plugin_take_int, &size_px[1]))
        return NULL;
    PyObject *rest = keywords ? PyDict_Copy(keywords) : PyDict_New();
    bool is_read = rest && plugin_take_context(state, rest, &context) == 0 &&
                   take_picture(rest, &picture) == 0 &&
                   plugin_read_params(state, rest, &params) == 0;
    if (is_read && picture)
        params.distribution = RF_DISTRIBUTION_IMAGE;
    is_read = is_read && plugin_warn_unread(state, rest, &params, false) == 0 &&
              (!picture || warn_of_picture(state, &params) == 0);
    Py_XDECREF(rest);
    if (!is_read) {
        Py_XDECREF(picture);
        Py_XDECREF(context);
        return NULL;
    }
    allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
    struct plugin_filter *self = (struct plugin_filter *)allocate(type, 0);
    if (self) {
        self->context = Py_NewRef(context);
        self->size_px[0] = size_px[0];
        self->size_px[1] = size_px[1];
        self->white = (float)white_round(params.white);
        self->params = params;
    }
    if (self && make_filter(state, self, &params, picture) < 0)
        Py_CLEAR(self);
    Py_XDECREF(picture);
    Py_DECREF(context);
    return (PyObject *)self;
}

static void filter_dealloc(PyObject *object)
{
    struct plugin_filter *self = (struct plugin_filter *)object;
    rf_filter_destroy(self->filter);
    Py_XDECREF(self->context);
    PyTypeObject *type = Py_TYPE(object);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(object);
    Py_DECREF(type);
}

/* ---- one frame ----------------------------------------------------------------- */

/* What is filtered: views, all of them or a window of one; or a deep frame. */
struct work {
    const struct rf_view *views;
    int n_views;
    const struct rf_deep *deep;      /* else NULL */
    const struct rf_survey *surveys; /* of windows, else NULL */
    struct rf_window given, kept;
};

static rf_result run_work(const struct rf_filter *filter, const struct work *work,
                          const struct rf_image *out,
                          const struct rf_progress *progress, struct rf_error *error)
{
    if (work->deep)
        return rf_filter_process_deep(filter, work->deep, out, progress, error);
    if (work->surveys)
        return rf_filter_process_window(filter, work->surveys, work->views,
                                        work->n_views, &work->given, &work->kept, out,
                                        progress, error);
    return rf_filter_process(filter, work->views, work->n_views, out, progress, error);
}

/* Filters without the lock; None, or NULL with an exception set. */
static PyObject *process(PyObject *object, const struct work *work,
                         const struct rf_image *out, PyObject *function)
{
    const struct plugin_filter *self = (struct plugin_filter *)object;
    struct plugin_progress progress;
    const struct rf_progress callback = {plugin_report, &progress};
    struct rf_error error;
    if (plugin_start_progress(&progress, function) < 0)
        return NULL;
    rf_result result = run_work(self->filter, work, out, &callback, &error);
    plugin_end_progress(&progress);
    if (progress.has_raised)
        return NULL;
    if (result != RF_OK)
        return plugin_raise(PyType_GetModuleState(Py_TYPE(object)), &error);
    return Py_NewRef(Py_None);
}

/* What the view hides: None, or a tuple (colour, depth). 0, or -1 with an exception. */
static int open_behind(PyObject *behind, struct plugin_image images[2], int *n_open,
                       struct rf_view *view)
{
    static const char *const names[] = {"behind[0]", "behind[1]"};
    if (behind == Py_None)
        return 0;
    if (!PyTuple_Check(behind) || PyTuple_Size(behind) != 2) {
        PyErr_SetString(PyExc_TypeError, "behind: must be a tuple (colour, depth)");
        return -1;
    }
    for (*n_open = 0; *n_open < 2; (*n_open)++)
        if (plugin_open_image(&images[*n_open], PyTuple_GetItem(behind, *n_open),
                              names[*n_open], false) < 0)
            return -1;
    view->behind_colour = images[0].image;
    view->behind_depth = images[1].image;
    return 0;
}

static PyObject *filter_process(PyObject *object, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"colour", "depth", "out",        "progress",
                            "behind", "seen",  "mean_depth", NULL};
    PyObject *objects[3], *function = Py_None, *behind = Py_None, *lights = Py_None;
    PyObject *mean = Py_None, *answer = NULL;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOO|OOOO:process", names,
                                     &objects[0], &objects[1], &objects[2], &function,
                                     &behind, &lights, &mean))
        return NULL;
    struct plugin_image images[3], hidden[2], means;
    bool has_mean = false;
    struct plugin_seen seen = {.n_images = 0};
    struct rf_view view = {.size = sizeof view};
    int n_open = 0, n_hidden = 0;
    while (n_open < 3 && plugin_open_image(&images[n_open], objects[n_open],
                                           names[n_open], n_open == 2) == 0)
        n_open++;
    if (n_open == 3 && mean != Py_None)
        has_mean = plugin_open_image(&means, mean, "mean_depth", false) == 0;
    if (has_mean)
        view.mean_depth = means.image;
    if (n_open == 3 && has_mean == (mean != Py_None) &&
        open_behind(behind, hidden, &n_hidden, &view) == 0 &&
        plugin_open_seen(&seen, lights, &view) == 0) {
        view.colour = images[0].image;
        view.depth = images[1].image;
        const struct work work = {.views = &view, .n_views = 1};
        answer = process(object, &work, &images[2].image, function);
    }
    plugin_close_seen(&seen);
    if (has_mean)
        plugin_close_image(&means);
    while (n_hidden > 0)
        plugin_close_image(&hidden[--n_hidden]);
    while (n_open > 0)
        plugin_close_image(&images[--n_open]);
    return answer;
}

/* ---- several views of one frame ------------------------------------------------- */

static PyObject *filter_process_views(PyObject *object, PyObject *args,
                                      PyObject *keywords)
{
    static char *names[] = {"views", "out", "progress", "seen", "check", NULL};
    PyObject *sequence, *target, *function = Py_None, *lights = Py_None;
    PyObject *answer = NULL;
    int is_checked = 1;
    struct plugin_image out;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OO|OOp:process_views", names,
                                     &sequence, &target, &function, &lights,
                                     &is_checked))
        return NULL;
    struct plugin_views *open = plugin_open_views(sequence);
    if (!open)
        return NULL;
    struct plugin_view_lights *seen = plugin_open_view_lights(lights, open);
    if (seen && plugin_open_image(&out, target, "out", true) == 0) {
        const struct work work = {.views = open->views, .n_views = open->n};
        const struct module_state *state = PyType_GetModuleState(Py_TYPE(object));
        if (!is_checked ||
            plugin_warn_views(state, (struct plugin_filter *)object, open) == 0)
            answer = process(object, &work, &out.image, function);
        plugin_close_image(&out);
    }
    plugin_close_view_lights(seen);
    plugin_close_views(open);
    return answer;
}

/* ---- deep frames ---------------------------------------------------------------- */

static PyObject *filter_process_deep(PyObject *object, PyObject *args,
                                     PyObject *keywords)
{
    static char *names[] = {"first", "samples", "out", "progress", NULL};
    PyObject *first, *samples, *target, *function = Py_None, *answer = NULL;
    struct plugin_deep deep;
    struct plugin_image out;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOO|O:process_deep", names,
                                     &first, &samples, &target, &function) ||
        plugin_open_deep(&deep, first, samples,
                         ((struct plugin_filter *)object)->size_px) < 0)
        return NULL;
    if (plugin_open_image(&out, target, "out", true) == 0) {
        const struct work work = {.deep = &deep.deep};
        answer = process(object, &work, &out.image, function);
        plugin_close_image(&out);
    }
    plugin_close_deep(&deep);
    return answer;
}

static PyObject *filter_flatten(PyObject *object, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"first", "samples", "colour", "depth", NULL};
    PyObject *first, *samples, *targets[2];
    const struct plugin_filter *self = (struct plugin_filter *)object;
    struct plugin_deep deep;
    struct plugin_image images[2];
    struct rf_error error;
    rf_result result = RF_OK;
    int n_open = 0;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOOO:flatten", names, &first,
                                     &samples, &targets[0], &targets[1]) ||
        plugin_open_deep(&deep, first, samples, self->size_px) < 0)
        return NULL;
    while (n_open < 2 && plugin_open_image(&images[n_open], targets[n_open],
                                           names[2 + n_open], true) == 0)
        n_open++;
    const bool is_open = n_open == 2;
    if (is_open) {
        Py_BEGIN_ALLOW_THREADS;
        result = rf_deep_flatten(self->filter, &deep.deep, &images[0].image,
                                 &images[1].image, &error);
        Py_END_ALLOW_THREADS;
    }
    while (n_open > 0)
        plugin_close_image(&images[--n_open]);
    plugin_close_deep(&deep);
    if (!is_open)
        return NULL;
    if (result != RF_OK)
        return plugin_raise(PyType_GetModuleState(Py_TYPE(object)), &error);
    return Py_NewRef(Py_None);
}

/* ---- windows of a picture larger than memory ------------------------------------- */

#define SURVEY_NAME "rackfocus.survey"

/* A window among the arguments of PyArg_Parse...(). */
#define WINDOW "(O&O&O&O&)"
#define TAKE_WINDOW(w)                                                                 \
    plugin_take_int, &(w)->x, plugin_take_int, &(w)->y, plugin_take_int, &(w)->width,  \
        plugin_take_int, &(w)->height

static void free_survey(PyObject *capsule)
{
    PyMem_Free(PyCapsule_GetPointer(capsule, SURVEY_NAME));
}

static PyObject *filter_new_survey(PyObject *object, PyObject *unused)
{
    struct rf_survey *survey = PyMem_Calloc(1, sizeof *survey);
    if (!survey)
        return PyErr_NoMemory();
    survey->size = sizeof *survey;
    PyObject *capsule = PyCapsule_New(survey, SURVEY_NAME, free_survey);
    if (!capsule)
        PyMem_Free(survey);
    return capsule;
}

static struct rf_survey *survey_of(PyObject *capsule)
{
    if (!PyCapsule_IsValid(capsule, SURVEY_NAME)) {
        PyErr_SetString(PyExc_TypeError, "survey: what new_survey() gave is needed");
        return NULL;
    }
    return PyCapsule_GetPointer(capsule, SURVEY_NAME);
}

static PyObject *filter_survey(PyObject *object, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"survey", "colour", "depth", "given", "counted", NULL};
    PyObject *capsule, *objects[2];
    struct rf_window given, counted;
    struct plugin_image images[2];
    struct rf_error error;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOO" WINDOW WINDOW ":count",
                                     names, &capsule, &objects[0], &objects[1],
                                     TAKE_WINDOW(&given), TAKE_WINDOW(&counted)))
        return NULL;
    struct rf_survey *survey = survey_of(capsule);
    if (!survey || plugin_open_image(&images[0], objects[0], names[1], false) < 0)
        return NULL;
    if (plugin_open_image(&images[1], objects[1], names[2], false) < 0) {
        plugin_close_image(&images[0]);
        return NULL;
    }
    const struct rf_view view = {.colour = images[0].image, .depth = images[1].image};
    const rf_result result = rf_filter_survey(((struct plugin_filter *)object)->filter,
                                              &view, &given, &counted, survey, &error);
    plugin_close_image(&images[0]);
    plugin_close_image(&images[1]);
    if (result != RF_OK)
        return plugin_raise(PyType_GetModuleState(Py_TYPE(object)), &error);
    return Py_NewRef(Py_None);
}

static PyObject *filter_window(PyObject *object, PyObject *args, PyObject *keywords)
{
    static char *names[] = {"survey", "kept", NULL};
    PyObject *capsule;
    struct rf_window kept, given;
    struct rf_error error;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "O" WINDOW ":window", names,
                                     &capsule, TAKE_WINDOW(&kept)))
        return NULL;
    const struct rf_survey *survey = survey_of(capsule);
    if (!survey)
        return NULL;
    if (rf_filter_window(((struct plugin_filter *)object)->filter, survey, 1, &kept,
                         &given, &error) != RF_OK)
        return plugin_raise(PyType_GetModuleState(Py_TYPE(object)), &error);
    return Py_BuildValue("(iiii)", given.x, given.y, given.width, given.height);
}

static PyObject *filter_process_window(PyObject *object, PyObject *args,
                                       PyObject *keywords)
{
    static char *names[] = {"survey", "colour", "depth",    "given",
                            "kept",   "out",    "progress", NULL};
    static const char *const image_names[] = {"colour", "depth", "out"};
    PyObject *capsule, *objects[3], *function = Py_None, *answer = NULL;
    struct work work = {.n_views = 1};
    struct rf_window *given = &work.given, *kept = &work.kept;
    if (!PyArg_ParseTupleAndKeywords(
            args, keywords, "OOO" WINDOW WINDOW "O|O:process_window", names, &capsule,
            &objects[0], &objects[1], TAKE_WINDOW(given), TAKE_WINDOW(kept),
            &objects[2], &function))
        return NULL;
    struct plugin_image images[3];
    int n_open = 0;
    work.surveys = survey_of(capsule);
    while (work.surveys && n_open < 3 &&
           plugin_open_image(&images[n_open], objects[n_open], image_names[n_open],
                             n_open == 2) == 0)
        n_open++;
    if (n_open == 3) {
        const struct rf_view view = {.colour = images[0].image,
                                     .depth = images[1].image};
        work.views = &view;
        answer = process(object, &work, &images[2].image, function);
    }
    while (n_open > 0)
        plugin_close_image(&images[--n_open]);
    return answer;
}

/* ---- depth to other things ------------------------------------------------------- */

typedef rf_result convert_function(const struct rf_filter *, const struct rf_image *,
                                   const struct rf_image *, struct rf_error *);

static PyObject *convert(PyObject *object, PyObject *args, PyObject *keywords,
                         convert_function *function)
{
    static char *names[] = {"depth", "out", NULL};
    PyObject *depth, *out;
    struct plugin_image from, to;
    if (!PyArg_ParseTupleAndKeywords(args, keywords, "OO", names, &depth, &out) ||
        plugin_open_image(&from, depth, "depth", false) < 0)
        return NULL;
    if (plugin_open_image(&to, out, "out", true) < 0) {
        plugin_close_image(&from);
        return NULL;
    }
    const struct plugin_filter *self = (struct plugin_filter *)object;
    struct rf_error error;
    rf_result result;
    Py_BEGIN_ALLOW_THREADS;
    result = function(self->filter, &from.image, &to.image, &error);
    Py_END_ALLOW_THREADS;
    plugin_close_image(&from);
    plugin_close_image(&to);
    if (result != RF_OK)
        return plugin_raise(PyType_GetModuleState(Py_TYPE(object)), &error);
    return Py_NewRef(Py_None);
}

static PyObject *filter_coc(PyObject *self, PyObject *args, PyObject *keywords)
{
    return convert(self, args, keywords, rf_filter_coc);
}

static PyObject *filter_planar_depth(PyObject *self, PyObject *args, PyObject *keywords)
{
    return convert(self, args, keywords, rf_filter_planar_depth);
}

/* ---- the type ------------------------------------------------------------------ */

static PyObject *get_lens(PyObject *object, void *unused)
{
    const struct module_state *state = PyType_GetModuleState(Py_TYPE(object));
    return plugin_lens_new(state,
                           rf_filter_lens(((struct plugin_filter *)object)->filter));
}

static PyObject *get_threads(PyObject *object, void *unused)
{
    return PyLong_FromLong(rf_context_threads(
        plugin_context_of(((struct plugin_filter *)object)->context)));
}

static PyGetSetDef filter_getset[] = {
    {"lens", get_lens, NULL, "The Lens that the filter uses.", NULL},
    {"threads", get_threads, NULL, "Threads that a frame is filtered on.", NULL},
    {0},
};

#define KEYWORDS(function) (PyCFunction)(void (*)(void)) function

static PyMethodDef filter_methods[] = {
    {"process", KEYWORDS(filter_process), METH_VARARGS | METH_KEYWORDS,
     "process($self, /, colour, depth, out, progress=None, behind=None, "
     "seen=None, mean_depth=None)\n--\n\n"
     "Filters one frame.\n\n"
     "colour: (height, width, 1, 3 or 4) or (height, width) float32, scene-linear, "
     "alpha premultiplied.\n"
     "depth: (height, width) float32 in the convention of the parameter depth.\n"
     "out: writable, same shape as colour; may be the same memory.\n"
     "progress: called with a fraction from 0 to 1; False cancels.\n"
     "behind: (colour, depth) of what lies behind the visible surfaces, as other "
     "frames "
     "or a second layer show it; depth is planar distance, NaN where nothing is known. "
     "It takes the place of what layered and views estimate.\n"
     "seen: a sequence of tuples (light, depth) of what is seen in mirrors or through "
     "glass, a part of the colour, (height, width, 3) or (height, width), and its "
     "planar distance, NaN where it is that of the surface; see seen_depth().\n"
     "mean_depth: (height, width) float32, the mean planar distance over the samples "
     "of "
     "each pixel, 0 for those that hit nothing, NaN where it is not known. It tells "
     "how "
     "large the parts of a pixel at an edge are; see mean_depth()."},
    {"mean_depth", KEYWORDS(plugin_filter_mean_depth), METH_VARARGS | METH_KEYWORDS,
     "mean_depth($self, /, rays, depth, out, lens_offset=(0, 0), "
     "shear_distance=0)\n--\n\n"
     "Makes what process() takes as mean_depth from mean lengths of rays, as Cycles' "
     "Denoising Depth has them. Returns False where these are of something else: out "
     "is "
     "of no use then.\n\n"
     "rays: (height, width) float32, scene units.\n"
     "depth: of the frame, planar distances.\n"
     "out: writable, (height, width) float32.\n"
     "lens_offset, shear_distance: of a view, as in process_views()."},
    {"seen_depth", KEYWORDS(plugin_filter_seen_depth), METH_VARARGS | METH_KEYWORDS,
     "seen_depth($self, /, colour, depth, lights, out)\n--\n\n"
     "Finds the depth of what is seen in flat mirrors or panes from several points of "
     "the lens, for the argument seen of process().\n\n"
     "colour, depth: of the frame.\n"
     "lights: two tuples or more (light, (u, v), shear_distance), the first that of "
     "the frame; u, v and shear_distance as in process_views().\n"
     "out: (height, width) float32, gets planar distances, NaN where the depth of the "
     "surface holds."},
    {"seen_way", KEYWORDS(plugin_filter_seen_way), METH_VARARGS | METH_KEYWORDS,
     "seen_way($self, /, colour, depth, light, way, out)\n--\n\n"
     "The same from one frame that knows the way of its rays, as Cycles' Denoising "
     "Depth does.\n\n"
     "way: (height, width) float32, planar distance of what rays end at.\n"
     "out: gets it where the surface of light is flat and it lies behind that, else "
     "NaN; may be way."},
    {"process_views", KEYWORDS(filter_process_views), METH_VARARGS | METH_KEYWORDS,
     "process_views($self, /, views, out, progress=None, seen=None, check=True)\n"
     "--\n\n"
     "Filters one frame from several pinhole views; for the methods that take them "
     "(views, 1 to 64).\n\n"
     "views: a sequence of tuples (colour, depth, (u, v), shear_distance[, "
     "mean_depth]); "
     "colour, depth and mean_depth as in process(), u and v where on the lens the view "
     "was taken, scene units "
     "right and up, shear_distance that of the plane that stays where it is in all "
     "views, scene units, 0 for parallel cameras.\n"
     "out, progress: as in process().\n"
     "seen: for each view, in order, what process() takes as seen.\n"
     "check: whether views that lie elsewhere than lens_offset says, or have another "
     "exposure, are warned of (ViewsWarning); the picture is the same."},
#ifdef PLUGIN_HAS_DENOISER
    {"denoise_views", KEYWORDS(plugin_filter_denoise_views),
     METH_VARARGS | METH_KEYWORDS,
     "denoise_views($self, /, views, outs, guides=None, progress=None, *, "
     "library=None, quality=\"high\", "
     "threads=0)\n--\n\n"
     "Takes the grain out of several views with Open Image Denoise, before they are "
     "merged: each is told what the others show of the same points in the same "
     "colours. "
     "Returns how many views show a pixel the same, on average.\n\n"
     "views: as in process_views().\n"
     "outs: of each view a writable array of the shape of its colour, which may be "
     "that; "
     "alpha is kept.\n"
     "guides: of each view a tuple (albedo, normal), (height, width, 3) float32, of "
     "the "
     "same samples; either may be None. They are worth most with few samples.\n"
     "progress: as in process().\n"
     "library: Open Image Denoise's file or folder, where the environment's "
     "RACKFOCUS_OIDN names none; None lets the system look.\n"
     "quality: of its filters, \"high\", \"balanced\" or \"fast\", as Cycles names "
     "them; "
     "they take about 1, 0.5 and 0.4 of the time.\n"
     "threads: of the denoiser; 0 takes all processors.\n\n"
     "Error where there is no Open Image Denoise."},
    {"merge_denoised", KEYWORDS(plugin_filter_merge_denoised),
     METH_VARARGS | METH_KEYWORDS,
     "merge_denoised($self, /, views, clean, out, progress=None, check=True)\n"
     "--\n\n"
     "process_views() of views that denoise_views() cleaned: merges them with and "
     "without their grain, and takes the latter but where the former differ by more "
     "than grain. Takes three times as long. Needs no Open Image Denoise.\n\n"
     "views: as in process_views(), with their grain.\n"
     "clean: of each view an array of the shape of its colour, without grain.\n"
     "out, progress: as in process(); out has the shape of a view's colour.\n"
     "check: as in process_views()."},
#endif
    {"process_deep", KEYWORDS(filter_process_deep), METH_VARARGS | METH_KEYWORDS,
     "process_deep($self, /, first, samples, out, progress=None)\n--\n\n"
     "Filters one deep frame; for the method layered.\n\n"
     "first: width * height + 1 whole numbers of 64 bit, where each pixel's samples "
     "begin, row by row.\n"
     "samples: (n, 7) float32, C order: depth, depth_back, r, g, b, a, opacity.\n"
     "out: writable, (height, width, 1, 3 or 4) float32."},
    {"flatten", KEYWORDS(filter_flatten), METH_VARARGS | METH_KEYWORDS,
     "flatten($self, /, first, samples, colour, depth)\n--\n\n"
     "The flat picture of a deep frame, as in process_deep(); colour and depth are "
     "written to."},
    {"new_survey", filter_new_survey, METH_NOARGS,
     "new_survey($self, /)\n--\n\n"
     "What the windows of a picture must know of the whole: first every pixel is "
     "counted once by count(), then windows are filtered by process_window(). For one "
     "view and the methods layered and views."},
    {"count", KEYWORDS(filter_survey), METH_VARARGS | METH_KEYWORDS,
     "count($self, /, survey, colour, depth, given, counted)\n--\n\n"
     "Counts the pixels of the window counted, (x, y, width, height) in px. colour and "
     "depth show the window given, with SURVEY_MARGIN px around it where the picture "
     "goes on."},
    {"window", KEYWORDS(filter_window), METH_VARARGS | METH_KEYWORDS,
     "window($self, /, survey, kept)\n--\n\n"
     "The window (x, y, width, height) that must be given for the window kept to come "
     "out with the bits of the whole picture."},
    {"process_window", KEYWORDS(filter_process_window), METH_VARARGS | METH_KEYWORDS,
     "process_window($self, /, survey, colour, depth, given, kept, out, "
     "progress=None)\n--\n\n"
     "Filters the window kept; colour and depth show the window given that window() "
     "names, out has the size of kept."},
    {"coc", KEYWORDS(filter_coc), METH_VARARGS | METH_KEYWORDS,
     "coc($self, /, depth, out)\n--\n\nSigned radius of every pixel in px; both "
     "(height, width) "
     "float32, out may be the same memory."},
    {"planar_depth", KEYWORDS(filter_planar_depth), METH_VARARGS | METH_KEYWORDS,
     "planar_depth($self, /, depth, out)\n--\n\nPlanar distance of every pixel in "
     "scene units, "
     "inf where nothing was hit; shapes as in coc()."},
    {0},
};

static PyType_Slot filter_slots[] = {
    {Py_tp_doc,
     "Filter(width, height, /, *, context=None, threads=0, distribution_image=None, "
     "**parameters)\n--\n\nA filter for pictures of width x height px. context: a "
     "Context to share; else it has its own, with threads (0 takes all processors). "
     "Parameters as in "
     "parameters(), by field name; enumerated ones by name. distribution_image: "
     "picture of the aperture, (height, width) or (height, width, 1, 3 or 4) float32, "
     "for the method scatter, and for others with aperture=\"image\"; its light is "
     "normalised to 1. Immutable; may be shared by threads, and process() releases the "
     "lock of the interpreter."},
    {Py_tp_new, filter_create},
    {Py_tp_dealloc, filter_dealloc},
    {Py_tp_methods, filter_methods},
    {Py_tp_getset, filter_getset},
    {0, NULL},
};

PyType_Spec plugin_filter_spec = {
    .name = "rackfocus.Filter",
    .basicsize = sizeof(struct plugin_filter),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE,
    .slots = filter_slots,
};
