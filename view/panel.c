/* SPDX-License-Identifier: Apache-2.0 */
/* The column of controls. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app.h"
#include "clock.h"
#include "model/fields.h"

/* ---- parameters ----------------------------------------------------------------- */

static double number_of(const struct app *app, const struct rf_param_info *info)
{
    const char *member = (const char *)&app->state.settings.params + info->offset;
    return info->type == RF_TYPE_FLOAT ? *(const double *)member
                                       : *(const int32_t *)member;
}

/* Where a value comes from: the file, the command line or who set it in the window. A
 * sentence, "" of a default. */
static void describe_origin(const struct state *state, const char *key, char *text,
                            size_t n_bytes)
{
    char origin[160];
    const enum origin kind = settings_origin(&state->settings, key);
    const enum setter setter =
        kind == ORIGIN_COMMAND_LINE ? state_setter(state, key) : SETTER_COMMAND_LINE;
    settings_describe_origin(&state->settings, key, origin, sizeof(origin));
    if (kind == ORIGIN_DEFAULT)
        *text = 0;
    else if (kind == ORIGIN_DERIVED)
        snprintf(text, n_bytes, "\nFrom the header and what is set %s.",
                 origin + strcspn(origin, "("));
    else if (setter == SETTER_USER)
        snprintf(text, n_bytes, "\nFrom you.");
    else if (setter == SETTER_LOOK)
        snprintf(text, n_bytes, "\nFrom the look %s.", state->setters.look);
    else
        snprintf(text, n_bytes, "\nFrom the %s.", origin);
}

/* What is said about a parameter; `tip` is room for its text. */
static struct ui_about about_of(const struct app *app, const struct rf_param_info *info,
                                char *tip, size_t n_bytes)
{
    char fallback[64];
    const struct state *state = &app->state;
    const bool is_guess = state_is_guess(state, info->key);
    ui_format(info->def, fallback, sizeof(fallback));
    if (info->choices)
        snprintf(fallback, sizeof(fallback), "%s", info->choices[(int)info->def].name);
    else if (info->type == RF_TYPE_BOOL)
        snprintf(fallback, sizeof(fallback), "%s", info->def != 0 ? "on" : "off");
    const bool has_unit = *info->unit && strcmp(info->unit, "1") != 0;
    snprintf(tip, n_bytes, "%s\n--%s, default %s%s%s%s", info->help, info->key,
             fallback, has_unit ? " " : "", has_unit ? info->unit : "",
             is_guess ? "\nThe file does not say it: this is a guess." : "");
    const size_t n = strlen(tip);
    if (!is_guess)
        describe_origin(state, info->key, tip + n, n_bytes - n);
    return (struct ui_about){.tip = tip,
                             .why_off = state_why_off(state, info->key),
                             .mark = is_guess ? "guess" : NULL};
}

/* What the user did with the last control, which is that of a parameter. */
static void take_change(struct app *app, const char *key, bool is_changed, double value)
{
    bool is_good = true;
    if (ui_was_reset(&app->ui))
        is_good = state_reset(&app->state, key);
    else if (is_changed)
        is_good = state_set(&app->state, key, value);
    if (is_good)
        return;
    ui_fail(&app->ui, app->state.problem);
    trace_text(app, "refused", app->state.problem);
}

/* How many scene units a millimetre is. */
static double units_per_mm(const struct app *app)
{
    return app->state.settings.params.unit_scale / 1000;
}

static void choice_row(struct app *app, const struct rf_param_info *info,
                       const char *label, const struct ui_about *about)
{
    const char *names[32], *tips[32];
    for (int i = 0; i < info->n_choices && i < 32; i++) {
        names[i] = info->choices[i].name;
        tips[i] = info->choices[i].help;
    }
    struct ui_about with_tips = *about;
    with_tips.choice_tips = tips; /* the control has used them when this returns */
    ui_about(&app->ui, &with_tips);
    int index = (int)number_of(app, info);
    const bool is_changed = ui_choice(&app->ui, label, names, info->n_choices, &index);
    take_change(app, info->key, is_changed, index);
}

/* The row of a parameter, whatever it is, with the slider's range. */
static void row_between(struct app *app, const char *key, double min, double max)
{
    char tip[512];
    struct field field;
    const struct rf_param_info *info = rf_param_find(key);
    const struct ui_about about = about_of(app, info, tip, sizeof(tip));
    field_of(info, &field);
    if (max > min) {
        field.min = min;
        field.max = max;
    }
    if (info->choices) {
        choice_row(app, info, field.label, &about);
        return;
    }
    ui_about(&app->ui, &about);
    if (info->type == RF_TYPE_BOOL) {
        bool is_on = number_of(app, info) != 0;
        const bool is_changed = ui_toggle(&app->ui, field.label, &is_on);
        take_change(app, key, is_changed, is_on);
        return;
    }
    struct ui_number number;
    field_number(info, &field, units_per_mm(app), &number);
    double value = number_of(app, info);
    const bool is_changed = ui_number(&app->ui, &number, &value);
    take_change(app, key, is_changed, value);
}

static void row(struct app *app, const char *key)
{
    row_between(app, key, 0, 0);
}

/* All parameters of a section, in the order of params.def; of two kinds: those that are
 * read, or those that are not. */
static void rows_of(struct app *app, enum field_section section, bool wants_read,
                    bool wants_unread)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++) {
        struct field field;
        field_of(&list[i], &field);
        if (field.section != section)
            continue;
        if (state_why_off(&app->state, list[i].key) ? wants_unread : wants_read)
            row(app, list[i].key);
    }
}

static void section(struct app *app, const char *label, enum field_section section,
                    bool is_open_at_first)
{
    if (ui_section(&app->ui, label, is_open_at_first))
        rows_of(app, section, true, true);
}

/* ---- the lens -------------------------------------------------------------------- */

/* From somewhat before the nearest thing to beyond the farthest. */
static void focus_row(struct app *app)
{
    const struct input *input = app->shot ? app->shot->input : NULL;
    const double near = input ? input->nearest : 1, far = input ? input->farthest : 100;
    row_between(app, "focus-distance", near * 0.7, fmin(far, near * 1e5) * 1.4);
}

static void screen_row(struct app *app)
{
    double position = state_screen(&app->state);
    const bool is_known = !isnan(position);
    const double f = is_known ? app->state.lens.focal_length : 1;
    const struct ui_number number = {.label = "Screen position",
                                     .unit = "",
                                     .min = f * (1 + 1e-6),
                                     .max = f * 1.1,
                                     .min_limit = f * (1 + 1e-9),
                                     .max_limit = 1e9,
                                     .field = {.per_mm = units_per_mm(app)}};
    ui_about(&app->ui,
             &(struct ui_about){
                 .tip = "Where the screen of a real lens stands for this focus "
                        "distance, in scene units (Yu 2004); it sets the focus.",
                 .why_off = is_known ? NULL : "it needs a focal length"});
    const bool is_changed = ui_number(&app->ui, &number, &position);
    if (ui_was_reset(&app->ui))
        take_change(app, "focus-distance", false, 0);
    else if (is_changed && !state_set_screen(&app->state, position))
        ui_fail(&app->ui, app->state.problem);
}

/* Holds also where the lens was given by its radius. */
static void f_stop_row(struct app *app)
{
    char tip[512];
    struct field field;
    struct ui_number number;
    double f_stop = state_f_stop(&app->state);
    const struct rf_param_info *info = rf_param_find("f-stop");
    const struct ui_about about = about_of(app, info, tip, sizeof(tip));
    field_of(info, &field);
    field_number(info, &field, 0, &number);
    ui_about(&app->ui, &about);
    const bool is_changed = ui_number(&app->ui, &number, &f_stop);
    take_change(app, "f-stop", is_changed, f_stop);
}

static void radius_row(struct app *app)
{
    char tip[512];
    double radius = app->state.lens.lens_radius;
    const double base = fmax(app->radius_base, 1e-9);
    const struct rf_param_info *info = rf_param_find("lens-radius");
    const struct ui_about about = about_of(app, info, tip, sizeof(tip));
    const struct ui_number number = {.label = "Lens radius",
                                     .unit = "",
                                     .min = base / 32,
                                     .max = base * 32,
                                     .min_limit = info->min,
                                     .max_limit = info->max,
                                     .is_log = true,
                                     .field = {.per_mm = units_per_mm(app)}};
    ui_about(&app->ui, &about);
    const bool is_changed = ui_number(&app->ui, &number, &radius);
    take_change(app, "lens-radius", is_changed, radius);
}

/* Is the focal length shown in its field invented? Then nothing is shown. */
static void focal_length_row(struct app *app)
{
    if (!state_why_off(&app->state, "focal-length") ||
        settings_origin(&app->state.settings, "focal-length") != ORIGIN_DEFAULT) {
        row(app, "focal-length");
        return;
    }
    double unknown = NAN;
    const struct ui_number number = {
        .label = "Focal length", .unit = "mm", .min = 8, .max = 400, .is_log = true};
    ui_about(&app->ui,
             &(struct ui_about){.tip = rf_param_find("focal-length")->help,
                                .why_off = state_why_off(&app->state, "focal-length")});
    ui_number(&app->ui, &number, &unknown);
}

static void limits_rows(struct app *app)
{
    const struct rf_lens *lens = &app->state.lens;
    double near, far;
    char text[128], a[32], b[32];
    rf_lens_depth_of_field(lens, &near, &far);
    ui_format(near, a, sizeof(a));
    ui_format(far, b, sizeof(b));
    snprintf(text, sizeof(text), "%s to %s", a, b);
    ui_about(&app->ui, &(struct ui_about){.tip = "Where the radius of the blur stays "
                                                 "below the sharpness limit."});
    ui_readout(&app->ui, "In focus", text);
    ui_format(rf_lens_hyperfocal(lens), text, sizeof(text));
    ui_about(&app->ui, &(struct ui_about){.tip = "The focus distance that brings "
                                                 "infinity just into focus."});
    ui_readout(&app->ui, "Hyperfocal", text);
    ui_format(rf_lens_radius_px(lens, INFINITY), a, sizeof(a));
    snprintf(text, sizeof(text), "%s px at infinity", a);
    ui_readout(&app->ui, "Radius", text);
}

/* Says what `rackfocus filter` warns of: wider than half the longer side nothing gets,
 * however far the aperture is opened. "" where the nearest and the farthest thing are
 * below it, and where somebody set the largest radius. */
static void describe_cut(const struct app *app, char *text, size_t n_bytes)
{
    const struct input *input = app->shot ? app->shot->input : NULL;
    const struct rf_lens *lens = &app->state.lens;
    const double most = lens->max_radius_px;
    *text = 0;
    if (!input || app->state.settings.params.max_radius > 0 ||
        state_why_off(&app->state, "max-radius") ||
        (fabs(rf_lens_radius_px(lens, input->nearest)) < most &&
         fabs(rf_lens_radius_px(lens, input->farthest)) < most))
        return;
    snprintf(text, n_bytes,
             "The blur is cut at a radius of %.4g px, half the longer side; Max radius "
             "allows more.",
             most);
}

/* Which parameters are guesses, in a sentence; false where none is. */
static bool describe_guesses(const struct app *app, char *text, size_t n_bytes)
{
    static const char *const keys[] = {"focus-distance", "f-stop", "focal-length",
                                       "sensor-width"};
    size_t n = 0;
    *text = 0;
    for (size_t i = 0; i < sizeof(keys) / sizeof(keys[0]) && n < n_bytes; i++)
        if (state_is_guess(&app->state, keys[i]))
            n += (size_t)snprintf(text + n, n_bytes - n, "%s%s",
                                  n ? ", " : "The file says no ", keys[i]);
    if (n > 0 && n < n_bytes)
        snprintf(text + n, n_bytes - n, ": these are guesses.");
    return n > 0;
}

static void lens_rows(struct app *app)
{
    char guesses[160], cut[160], place[160];
    describe_cut(app, cut, sizeof(cut));
    trace_once(app, &app->traced_cut, "cut", cut);
    looks_menu_describe_place(app, place, sizeof(place));
    if (!ui_section(&app->ui, "Lens", true))
        return;
    focus_row(app);
    screen_row(app);
    f_stop_row(app);
    radius_row(app);
    focal_length_row(app);
    row(app, "optics");
    limits_rows(app);
    if (*cut)
        ui_note(&app->ui, cut);
    if (*place)
        ui_note(&app->ui, place);
    if (describe_guesses(app, guesses, sizeof(guesses)))
        ui_note(&app->ui, guesses);
}

/* ---- method and looks ------------------------------------------------------------- */

static void method_rows(struct app *app)
{
    if (!ui_section(&app->ui, "Method", true))
        return;
    row(app, "method");
    rows_of(app, FIELD_METHOD, true, false);
    if (ui_section(&app->ui, "Not read by this method", false))
        rows_of(app, FIELD_METHOD, false, true);
}

static void character_rows(struct app *app)
{
    if (!ui_section(&app->ui, "Character", false))
        return;
    looks_menu_row(app);
    rows_of(app, FIELD_CHARACTER, true, true);
    looks_menu_keep_rows(app);
}

/* ---- the view ------------------------------------------------------------------- */

/* The view transform: saved pictures do not change. */
static void colour_row(struct app *app)
{
    const char *names[COLOUR_MAX_VIEWS];
    const struct colour_list *list = &app->colours;
    for (int i = 0; i < list->n; i++)
        names[i] = list->names[i];
    ui_about(&app->ui,
             &(struct ui_about){
                 .tip = "How the colours are looked at (OpenColorIO); saved pictures "
                        "do not change.",
                 .why_off = list->n > 1 ? NULL : "this build has no OpenColorIO"});
    char problem[400];
    int index = app->colour_index;
    if (!ui_choice(&app->ui, "Colours", names, list->n, &index))
        return;
    if (!colour_prepare(list->views[index], problem, sizeof(problem))) {
        ui_fail(&app->ui, problem);
        return;
    }
    app->colour_index = index;
    app->state.colour = list->views[index];
    app->state.id++;
}

static void eyes_row(struct app *app)
{
    static const char *const names[] = {"left", "right", "red and cyan",
                                        "side by side"};
    ui_about(&app->ui, &(struct ui_about){.tip = "Which eye of the pair is shown, or "
                                                 "both: for red and cyan glasses, or "
                                                 "side by side, half as wide."});
    if (ui_choice(&app->ui, "Eyes", names, 4, &app->eyes))
        app->state.id++;
}

static void view_rows(struct app *app)
{
    struct ui *ui = &app->ui;
    struct state *state = &app->state;
#define MODE_NAME(constant, name, help) name,
    static const char *const names[] = {VIEW_MODES(MODE_NAME)};
#undef MODE_NAME
    if (!ui_section(ui, "View", true))
        return;
    bool is_on = state->is_filter_on;
    bool is_split = state->is_split;
    ui_columns(ui, 2);
    if (ui_toggle(ui, "Filter (F)", &is_on))
        state_toggle_filter(state);
    if (ui_toggle(ui, "Split (S)", &is_split))
        state_toggle_split(state);
    int mode = (int)state->mode;
    if (ui_choice(ui, "Show", names, N_MODES, &mode)) {
        static const enum action actions[] = {ACTION_HELP,       ACTION_DEPTH,
                                              ACTION_COC,        ACTION_BAND,
                                              ACTION_DIFFERENCE, ACTION_EXPOSURE};
        if (mode == MODE_PICTURE)
            state_toggle_mode(state, state->mode);
        else
            view_act(app, actions[mode]);
    }
    const struct ui_number exposure = {.label = "Exposure",
                                       .unit = "stops",
                                       .min = -6,
                                       .max = 6,
                                       .min_limit = -20,
                                       .max_limit = 20};
    double stops = state->exposure;
    if (ui_number(ui, &exposure, &stops))
        state_set_exposure(state, stops);
    if (ui_was_reset(ui))
        state_set_exposure(state, app->options->exposure);
    colour_row(app);
    if (view_is_stereo(app))
        eyes_row(app);
}

/* How much the difference is magnified. */
static void gain_row(struct app *app)
{
    struct ui *ui = &app->ui;
    const struct ui_number number = {.label = "Gain",
                                     .unit = "x",
                                     .min = 1,
                                     .max = 64,
                                     .min_limit = 1,
                                     .max_limit = 64,
                                     .is_log = true};
    double gain = app->state.gain;
    ui_about(ui, &(struct ui_about){.tip = "Magnifies the difference that X shows; the "
                                           "legend has its scale.",
                                    .why_off = app->state.mode == MODE_DIFFERENCE
                                                   ? NULL
                                                   : "X shows the difference"});
    if (ui_number(ui, &number, &gain))
        state_set_gain(&app->state, gain);
    if (ui_was_reset(ui))
        state_set_gain(&app->state, 1);
}

/* What F, S and X compare with, and the kept settings. */
static void compare_rows(struct app *app)
{
    static const char *const names[] = {"pinhole", "reference"};
    struct ui *ui = &app->ui;
    if (!ui_section(ui, "Compare", false))
        return;
    ui_about(ui, &(struct ui_about){.tip = "A picture of the same size, EXR or PNG."});
    if (ui_text_field(ui, "Reference", app->reference_path,
                      sizeof(app->reference_path)) &&
        app->reference_path[0])
        open_reference(app, app->reference_path);
    int index = app->state.compares_reference;
    ui_about(ui, &(struct ui_about){.tip = "What F flips to and S wipes with.",
                                    .why_off = app->reference || app->accumulation.is_on
                                                   ? NULL
                                                   : "there is no reference"});
    if (ui_choice(ui, "Compare with", names, 2, &index))
        view_act(app, ACTION_COMPARE);
    gain_row(app);
    if (ui_button(ui, "Keep as reference (K)"))
        view_act(app, ACTION_KEEP);
    for (int i = 1; i <= 9; i++) {
        char label[8], why[48];
        snprintf(label, sizeof(label), "%d", i);
        snprintf(why, sizeof(why), "Ctrl+%d keeps the settings here", i);
        if (i == 1)
            ui_columns(ui, 9);
        ui_about(ui, &(struct ui_about){.tip = "Sets the settings that were kept.",
                                        .why_off = app->looks[i] ? NULL : why});
        if (ui_button(ui, label))
            view_set_look(app, i);
    }
}

static void set_stereo(struct app *app, bool is_stereo)
{
    if (is_stereo)
        accumulation_switch(app, false); /* its views are of one eye */
    app->demo.is_stereo = is_stereo;
    app->eyes = is_stereo ? EYES_ANAGLYPH : EYES_LEFT;
    app->is_demo_due = true;
}

static void demo_rows(struct app *app)
{
    struct ui *ui = &app->ui;
    if (!ui_section(ui, "Demo", true))
        return;
    ui_columns(ui, 2);
    if (ui_button(ui, "Focus near (N)"))
        view_act(app, ACTION_NEAREST);
    if (ui_button(ui, "At infinity (I)"))
        view_act(app, ACTION_INFINITY);
    if (ui_button(ui, "Save colour and depth (Ctrl+E)"))
        view_act(app, ACTION_SAVE_PASSES);
    bool is_stereo = app->demo.is_stereo;
    ui_about(ui,
             &(struct ui_about){.tip = "Draws the scene for both eyes, 65 mm apart; "
                                       "Eyes, below View, says which are shown."});
    if (ui_toggle(ui, "Both eyes", &is_stereo))
        set_stereo(app, is_stereo);
    accumulation_rows(app);
}

/* Half floats hold no light above 65504. */
static void samples_row(struct app *app)
{
    static const char *const names[] = {"half", "float"};
    const char *why_off = NULL;
    if (!app->stage)
        why_off = "the demo saves floats";
    else if (picture_kind(app->output) == PICTURE_PNG)
        why_off = "a PNG has 8 bits";
    ui_about(&app->ui, &(struct ui_about){.tip = "Samples of the EXR file that is "
                                                 "saved: half holds three digits and "
                                                 "light up to 65504.\n--type",
                                          .why_off = why_off});
    ui_choice(&app->ui, "Samples", names, 2, &app->sample_type);
}

static void save_rows(struct app *app)
{
    struct ui *ui = &app->ui;
    if (!ui_section(ui, "Files", true))
        return;
    if (ui_button(ui, "Open (Ctrl+O)"))
        view_act(app, ACTION_OPEN);
    ui_text_field(ui, "File", app->output, sizeof(app->output));
    samples_row(app);
    if (ui_button(ui, "Save picture (Ctrl+S)"))
        view_act(app, ACTION_SAVE);
    if (ui_button(ui, "Save parameters (Ctrl+P)"))
        view_act(app, ACTION_SAVE_PARAMS);
    if (ui_button(ui, "Copy command line (Ctrl+C)"))
        view_act(app, ACTION_COPY);
    ui_space(ui);
    if (ui_button(ui, "Keys (F1)"))
        view_act(app, ACTION_HELP);
}

/* Names the controls, does what they ask. */
static void panel_build(struct app *app)
{
    const struct area panel = view_panel_area(app);
    ui_begin(&app->ui, &app->input, &panel);
    if (panel.width > 0 && app->has_stage && app->state.is_valid) {
        play_rows(app);
        lens_rows(app);
        section(app, "Aperture", FIELD_APERTURE, true);
        method_rows(app);
        view_rows(app);
        compare_rows(app);
        if (app->options->is_demo)
            demo_rows(app);
        save_rows(app);
        character_rows(app);
        section(app, "Focus surface", FIELD_FOCUS_SURFACE, false);
        section(app, "Camera", FIELD_CAMERA, false);
        section(app, "Depth", FIELD_DEPTH, false);
    }
    ui_end(&app->ui);
}

void panel_pass(struct app *app)
{
    app->input.now_s = os_clock_s();
    panel_build(app);
    struct ui_input *input = &app->input;
    input->is_pressed = input->is_released = input->is_double = false;
    input->key = UI_KEY_NONE;
    input->text[0] = 0;
    input->wheel = 0;
    app->is_redraw_due = true;
}
