/* SPDX-License-Identifier: Apache-2.0 */
/* What is to be rendered: the scene, and the frames that options and files ask for. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "ini.h"
#include "path.h"
#include "povray.h"
#include "text.h"

/* Of frames; POV-Ray makes the first alone where a step leads beyond the last. */
#define MOST_STEP 1e6

struct found {
    char *scene;
    double first, last, from, to, step; /* NAN: not said */
    enum { ANTIALIASING_UNSAID, ANTIALIASING_ON, ANTIALIASING_OFF } antialiasing;
    char *part;             /* an option that asks for a part of the picture */
    char *missing, *naming; /* an initialisation file that is not there, and the one
                             * that names it, NULL for the options */
};

static bool is_scene_name(const char *option)
{
    char *name = ini_unquoted(option);
    const size_t n = name ? strlen(name) : 0;
    const bool is_scene = n > 4 && name[0] != '+' && name[0] != '-' &&
                          !strchr(name, '=') && strcasecmp(name + n - 4, ".pov") == 0;
    free(name);
    return is_scene;
}

/* Does the option ask for some columns or rows? The first is 1 or 0, a last one of 1
 * (as a share) all. */
static bool is_partial(const char *option)
{
    static const char *const sides[][2] = {{"Start_Column", "SC"},
                                           {"End_Column", "EC"},
                                           {"Start_Row", "SR"},
                                           {"End_Row", "ER"}};
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
        const char *value = ini_value(option, sides[i][0], sides[i][1]);
        const double side = value && *value ? strtod(value, NULL) : 1;
        if (value && *value && side != 1 && !(side == 0 && i % 2 == 0))
            return true;
    }
    return false;
}

/* The last switch counts; a threshold or a method says how, which is a wish, too. */
static void note_antialiasing(struct found *found, const char *option)
{
    const char *value = ini_value(option, "Antialias", "A");
    const bool is_letter = option[0] == '+' || option[0] == '-';
    const bool is_switch = value && (!is_letter || !isalpha((unsigned char)*value));
    if (is_switch)
        found->antialiasing =
            ini_is_on(option, value) ? ANTIALIASING_ON : ANTIALIASING_OFF;
    else if (found->antialiasing == ANTIALIASING_UNSAID &&
             (value || ini_value(option, "Antialias_Threshold", "")))
        found->antialiasing = ANTIALIASING_ON;
}

/* Notes the first initialisation file that is named and not there: POV-Ray, which looks
 * in the current folder alone, refuses all its options then. */
static void note_missing(struct found *found, const char *option, const char *file)
{
    const char *value = ini_value(option, "Include_Ini", "");
    char *name = ini_unquoted(value ? value : option);
    char *path = name ? ini_file(name) : NULL;
    const bool is_word = option[0] != '+' && option[0] != '-' && !strchr(option, '=');
    if ((value || is_word) && path && ini_is_name(path) && !path_is_file(path) &&
        !found->missing) {
        found->missing = text_format("%s", path);
        found->naming = file ? text_format("%s", file) : NULL;
    }
    free(path);
    free(name);
}

static void note_option(void *user, const char *option, const char *file)
{
    struct found *found = user;
    struct {
        const char *name, *letters;
        double *number;
    } numbers[] = {
        {"Initial_Frame", "KFI", &found->first},
        {"Final_Frame", "KFF", &found->last},
        {"Subset_Start_Frame", "SF", &found->from},
        {"Subset_End_Frame", "EF", &found->to},
        {"Frame_Step", "STP", &found->step},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        const char *value = ini_value(option, numbers[i].name, numbers[i].letters);
        if (value && *value)
            *numbers[i].number = strtod(value, NULL);
    }
    /* A file has what its author, or an exporter, wanted of POV-Ray itself. */
    if (!file)
        note_antialiasing(found, option);
    note_missing(found, option, file);
    if (is_partial(option)) {
        free(found->part);
        found->part = text_format("%s", option);
    }
    const char *scene = ini_value(option, "Input_File_Name", "I");
    if (!scene && is_scene_name(option))
        scene = option;
    if (scene && *scene) {
        free(found->scene);
        found->scene = ini_unquoted(scene);
    }
}

/* The scene's file: as named, with POV-Ray's ending, or beside `beside`. */
static char *find_scene(const char *name, const char *beside)
{
    char *folder = beside ? path_folder(beside) : text_format("%s", "");
    const char *const folders[] = {"",
                                   os_path_is_absolute(name) || !folder ? "" : folder};
    char *found = NULL;
    for (int i = 0; i < 4 && !found; i++) {
        char *path = text_format("%s%s%s", folders[i / 2], name, i % 2 ? ".pov" : "");
        if (path_is_file(path))
            found = path;
        else
            free(path);
    }
    free(folder);
    return found ? found : text_format("%s", name);
}

/* Frames of a subset: POV-Ray takes a part of 1 as a share of their number, counted from
 * 0 whatever the first one is. A subset may go beyond the last frame, and the clock with
 * it, but not before the first. */
static int32_t subset_frame(double frame, const struct povray_plan *plan, bool is_end)
{
    if (isnan(frame))
        return is_end ? plan->last : plan->first;
    if (frame > 0 && frame < 1)
        frame = floor(frame * (plan->last - plan->first + 1));
    return (int32_t)fmin(fmax(frame, plan->first), INT32_MAX);
}

/* The options, behind the initialisation file. False without memory. */
static bool copy_args(struct povray_plan *plan, const char *ini, char *const *args,
                      int n_args)
{
    plan->args = glue_alloc((size_t)n_args + 2, sizeof *plan->args);
    if (plan->args && ini)
        plan->args[plan->n_args++] = text_format("%s", ini);
    for (int i = 0; plan->args && i < n_args; i++)
        plan->args[plan->n_args++] = text_format("%s", args[i]);
    return !glue_is_lost();
}

static bool fail_found(const struct found *found, const char *operand,
                       struct povray_error *error)
{
    if (found->missing)
        snprintf(error->message, sizeof error->message,
                 "%s: names the initialisation file %s, which is not there; POV-Ray "
                 "looks for it in the current folder: write its path from here, or "
                 "start in the folder that has it",
                 found->naming ? found->naming : operand, found->missing);
    else if (found->part)
        snprintf(error->message, sizeof error->message,
                 "%s: a part of the picture cannot be made, because its lens needs "
                 "what is around; render all of it and crop the result",
                 found->part);
    else
        snprintf(error->message, sizeof error->message,
                 "%s: names no scene; add the line Input_File_Name=SCENE.pov, or give "
                 "the scene: rackfocus povray SCENE.pov -- %s",
                 operand, operand);
    return false;
}

static bool choose_frames(struct povray_plan *plan, const struct found *found,
                          const char *operand, struct povray_error *error)
{
    plan->first = isnan(found->first) ? 1 : (int32_t)found->first;
    plan->last = isnan(found->last) ? plan->first : (int32_t)found->last;
    /* Without a frame above 0 POV-Ray makes a still. */
    plan->is_animation =
        (plan->first != 1 || plan->last != 1) && (plan->last > 0 || plan->first > 1);
    plan->step = found->step >= 1 ? (int32_t)fmin(found->step, MOST_STEP) : 1;
    if (!plan->is_animation)
        return true;
    plan->from = subset_frame(found->from, plan, false);
    plan->to = subset_frame(found->to, plan, true);
    if (plan->last >= plan->first && plan->to >= plan->from)
        return true;
    snprintf(error->message, sizeof error->message,
             "%s: POV-Ray's options ask for frames %d to %d, which are none; check "
             "Initial_Frame, Final_Frame, Subset_Start_Frame and Subset_End_Frame",
             operand, plan->from, plan->to);
    return false;
}

/* `ini` is the file that the operand names; NULL where that is the scene. */
static bool use_found(struct povray_plan *plan, const struct found *found,
                      const char *operand, const char *ini, struct povray_error *error)
{
    if (glue_is_lost())
        return false;
    if ((ini && !found->scene) || found->part || found->missing)
        return fail_found(found, operand, error);
    plan->scene = find_scene(ini ? found->scene : operand, ini);
    plan->has_antialiasing = found->antialiasing == ANTIALIASING_ON;
    return choose_frames(plan, found, operand, error);
}

/* The mark at the beginning of a file that POV-Ray cannot read with it; NULL: none. */
static const char *unreadable_mark(const char *path)
{
    struct text text = {0};
    const char *mark = NULL;
    if (text_read_file(&text, path) && text.n >= 3) {
        if (memcmp(text.data, "\xff\xfe", 2) == 0 ||
            memcmp(text.data, "\xfe\xff", 2) == 0)
            mark = "is in UTF-16";
        else if (memcmp(text.data, "\xef\xbb\xbf", 3) == 0)
            mark = "begins with a byte order mark";
    }
    text_free(&text);
    return mark;
}

static bool check_ini(const char *ini, const char *operand, struct povray_error *error)
{
    const bool is_there = path_is_file(ini);
    const char *mark = is_there ? unreadable_mark(ini) : NULL;
    if (mark) {
        snprintf(error->message, sizeof error->message,
                 "%s: %s, which POV-Ray cannot read; save it as plain text (UTF-8 "
                 "without a byte order mark, ANSI)",
                 ini, mark);
        return false;
    }
    if (is_there && ini_has_section(operand))
        return true;
    snprintf(error->message, sizeof error->message,
             is_there ? "%s: the file has no such section; name one that it has"
                      : "%s: no such file",
             is_there ? operand : ini);
    return false;
}

/* POV-Ray has no options that begin with two signs but those of its help. */
static bool check_args(char *const *args, int n_args, struct povray_error *error)
{
    for (int i = 0; i < n_args; i++)
        if (strncmp(args[i], "--", 2) == 0) {
            snprintf(error->message, sizeof error->message,
                     "%s: options of rackfocus go before --; behind it stand those of "
                     "POV-Ray, as +W640 or Width=640",
                     args[i]);
            return false;
        }
    return true;
}

bool povray_plan_make(struct povray_plan *plan, const char *operand, char *const *args,
                      int n_args, struct povray_error *error)
{
    struct found found = {
        .first = NAN, .last = NAN, .from = NAN, .to = NAN, .step = NAN};
    char *ini = ini_file(operand);
    if (ini && !ini_is_name(ini)) {
        free(ini);
        ini = NULL;
    }
    *error = (struct povray_error){.message = ""};
    *plan = (struct povray_plan){.first = 1, .last = 1};
    bool is_good = check_args(args, n_args, error) &&
                   copy_args(plan, ini ? operand : NULL, args, n_args) &&
                   (!ini || check_ini(ini, operand, error));
    if (is_good) {
        ini_walk(plan->args, plan->n_args, note_option, &found);
        is_good = use_found(plan, &found, operand, ini, error);
    }
    free(ini);
    free(found.part);
    free(found.missing);
    free(found.naming);
    free(found.scene);
    return glue_settle(is_good, error);
}

void povray_plan_free(struct povray_plan *plan)
{
    for (int i = 0; i < plan->n_args; i++)
        free(plan->args[i]);
    free(plan->args);
    free(plan->scene);
    *plan = (struct povray_plan){0};
}
