/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus view: checks the command line and hands over to the window's program. */
#include "commands/cmd_view.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "console/cli.h"
#include "file.h"
#include "process.h"
#include "rackfocus/rackfocus.h"
#include "sources/depth_repair.h"
#include "sources/looks.h"
#include "sources/params_file.h"
#include "sources/picture.h"

#define AT(member) offsetof(struct view_options, member)

static const struct option options[] = {
    {.name = "output",
     .letter = 'o',
     .kind = OPTION_FILE,
     .offset = AT(output),
     .value = "FILE",
     .help =
         "Where Ctrl+S saves: .exr or .png. [default the input's name with _focus]"},
    OPTION_CHOICE_ROW("type", AT(type), "TYPE", "half|float",
                      "Samples of the EXR file that Ctrl+S saves: half or float. "
                      "[default half]"),
    {.name = "reference",
     .kind = OPTION_FILE,
     .offset = AT(reference),
     .value = "FILE",
     .help = "Picture (EXR or PNG) that the difference view compares with."},
    {.name = "params",
     .kind = OPTION_FILE,
     .offset = AT(params),
     .value = "FILE",
     .help = "Parameters as the window saves them; options win over them."},
    OPTION_TEXT_ROW("look", AT(look), "NAME",
                    "Look of a kind of lens: " LOOK_NAMES
                    ", your own, or a FILE.params; options "
                    "and --params win over it."),
    {.name = "depth-file",
     .kind = OPTION_FILE,
     .offset = AT(depth_file),
     .value = "FILE.exr",
     .help = "File that has the depth."},
    {.name = "depth-channel",
     .kind = OPTION_TEXT,
     .offset = AT(depth_channel),
     .value = "NAME",
     .help = "Channel that has the depth, by its full name."},
    {.name = "layer",
     .kind = OPTION_TEXT,
     .offset = AT(layer),
     .value = "NAME",
     .help = "Layer to show where a file has several."},
    {.name = "depth-repair",
     .kind = OPTION_CHOICE,
     .offset = AT(depth_repair),
     .value = "WHEN",
     .choices = DEPTH_REPAIR_CHOICES,
     .help = "Depth that was multiplied by alpha, anti-aliased or wider than what is "
             "seen: auto undoes it, off "
             "takes the depth as it is. [default auto]"},
    {.name = "mist-falloff",
     .kind = OPTION_CHOICE,
     .offset = AT(mist_falloff),
     .value = "KIND",
     .choices = MIST_CHOICES,
     .help =
         "Blender's Mist pass as depth: how it grows from start to end; with --depth "
         "normalised. [default none]"},
    OPTION_DISTRIBUTION_ROW(AT(distribution_image)),
    {.name = "exposure",
     .kind = OPTION_NUMBER,
     .offset = AT(exposure),
     .value = "STOPS",
     .min = -20,
     .max = 20,
     .help = "Brightness of the view; saved pictures do not change. [default 0]"},
    OPTION_FLAG_ROW("over", AT(is_over),
                    "The inputs are layers with a depth each: filter each and put "
                    "them over each other, the first on top."),
    OPTION_FLAG_ROW("stereo", AT(is_stereo),
                    "Filter both eyes of a multi-view file, or of two files, and show "
                    "them for red and cyan glasses or side by side."),
    {.name = "ocio",
     .kind = OPTION_FILE,
     .offset = AT(ocio),
     .value = "FILE.ocio",
     .help = "View transforms of this configuration of OpenColorIO. [default that of "
             "$OCIO]"},
    {.name = "views",
     .kind = OPTION_INT,
     .offset = AT(n_views),
     .value = "COUNT",
     .min = 1,
     .max = RF_MAX_VIEWS,
     .help = "POV-Ray scenes: render so many views from points of the lens. [default "
             "1]"},
    {.name = "keep",
     .kind = OPTION_FILE,
     .offset = AT(keep),
     .value = "DIR",
     .help = "POV-Ray scenes: keep the passes in this folder."},
    {.name = "povray",
     .kind = OPTION_FILE,
     .offset = AT(povray),
     .value = "PROGRAM",
     .help = "POV-Ray to start for a scene. [default as rackfocus povray finds it]"},
    {.name = "demo",
     .kind = OPTION_FLAG,
     .offset = AT(is_demo),
     .help = "Show three pictures at different distances, drawn with OpenGL and "
             "filtered live."},
    {.name = "demo-width",
     .kind = OPTION_INT,
     .offset = AT(demo_width),
     .value = "PX",
     .min = 64,
     .max = 8192,
     .help = "Width of the demo's picture. [default 960]"},
    {.name = "demo-height",
     .kind = OPTION_INT,
     .offset = AT(demo_height),
     .value = "PX",
     .min = 64,
     .max = 8192,
     .help = "Height of the demo's picture. [default 9/16 of the width]"},
    {.name = "demo-views",
     .kind = OPTION_INT,
     .offset = AT(demo_views),
     .value = "COUNT",
     .min = 1,
     .max = 256,
     .help = "Demo: accumulate so many views of the lens, drawn by OpenGL, as the "
             "reference; with --benchmark they are what is shown. [default none]"},
    {.name = "scale",
     .kind = OPTION_NUMBER,
     .offset = AT(scale),
     .value = "FACTOR",
     .min = 0.5,
     .max = 8,
     .help = "Size of letters and controls. [default from the display's density]"},
    {.name = "font",
     .kind = OPTION_FILE,
     .offset = AT(font),
     .value = "FILE.ttf",
     .help = "Font of the controls. [default DejaVu Sans or a like one]"},
    {.name = "benchmark",
     .kind = OPTION_NUMBER,
     .offset = AT(benchmark_s),
     .value = "SECONDS",
     .min = 0.1,
     .max = 600,
     .help = "Drag the focus to and fro for so long, print how fast that was, end."},
    OPTION_FLAG_ROW("benchmark-turn", AT(is_benchmark_turn),
                    "With --benchmark and --demo: turn the scene instead."),
    {.name = "trace",
     .kind = OPTION_FILE,
     .offset = AT(trace),
     .value = "FILE",
     .help = "For tests: write what is shown, a line each time."},
    OPTION_THREADS_ROW(AT(n_threads)),
    OPTION_QUIET_ROW(AT(is_quiet)),
    OPTION_HELP_ROW,
};

/* ---- the command line ----------------------------------------------------------- */

static bool fail_usage(const char *text)
{
    message("%s; see rackfocus view --help", text);
    return false;
}

/* Layers and eyes, as rackfocus filter takes them. */
static bool check_stack(const struct view_options *tool, int n)
{
    if (!tool->is_over && !tool->is_stereo)
        return true;
    if (tool->is_over && tool->is_stereo)
        return fail_usage("--over and --stereo do not go together");
    if (tool->is_over && (n < 2 || n > 8))
        return fail_usage("--over takes two to eight layers, the first on top");
    if (tool->is_stereo && n > 2)
        return fail_usage("--stereo takes one multi-view file or two files");
    if (tool->is_demo && tool->demo_views > 0)
        return fail_usage("--demo-views is of one eye; leave out --stereo");
    if (tool->is_demo && tool->is_stereo)
        return true;
    if (tool->is_demo || tool->depth_file || tool->depth_channel || tool->layer)
        return fail_usage("--over and --stereo take the depth from each input; leave "
                          "out --demo, --depth-file, --depth-channel and --layer");
    return true;
}

/* The picture of the light goes with the method scatter and says the distribution. */
static bool check_distribution(struct view_call *call)
{
    struct settings *settings = &call->settings;
    const struct rf_params *params = &settings->params;
    const bool is_image = params->distribution == RF_DISTRIBUTION_IMAGE;
    const bool is_scatter =
        params->method == RF_METHOD_SCATTER || call->options.is_demo;
    if (!call->options.distribution_image)
        return !is_image || !is_scatter ||
               fail_usage("--distribution image needs its picture, "
                          "--distribution-image FILE");
    if (!is_scatter)
        return fail_usage("--distribution-image is for the method scatter; add "
                          "--method scatter");
    if (settings_origin(settings, "distribution") == ORIGIN_COMMAND_LINE && !is_image)
        return fail_usage("--distribution-image goes with --distribution image, which "
                          "can be left out");
    settings_set(settings, "distribution", "image", NULL);
    return true;
}

static bool check_usage(const struct view_options *tool,
                        const struct operands *operands)
{
    if (!tool->is_demo && operands->n == 0)
        return fail_usage("view needs something to show: an EXR file with colour and "
                          "depth, a folder of kept passes, views, a POV-Ray scene, or "
                          "--demo");
    if (!check_stack(tool, operands->n))
        return false;
    if (tool->is_benchmark_turn && !(tool->is_demo && tool->benchmark_s > 0))
        return fail_usage("--benchmark-turn goes with --benchmark and --demo");
    if ((tool->demo_views > 0 || tool->demo_height > 0) && !tool->is_demo)
        return fail_usage(
            "--demo-views and --demo-height go with --demo; views of files "
            "are averaged by rackfocus accumulate");
    if (tool->demo_views > 0 && tool->reference)
        return fail_usage("--demo-views makes the reference: leave out --reference");
    if (tool->is_demo && operands->n > 1)
        return fail_usage("--demo takes one picture at most, an EXR or a PNG");
    if (operands->n > RF_MAX_VIEWS)
        return fail_usage("view takes 64 views at most");
    struct image_error error;
    if (tool->output && !picture_check_kind(tool->output, &error)) {
        message("%s", error.message);
        return false;
    }
    for (int i = 0; i < operands->n && operands->n > 1; i++)
        if (picture_is_scene(operands->items[i]))
            return fail_usage("view takes one POV-Ray scene; options for POV-Ray "
                              "follow --");
    const bool is_scene = operands->n == 1 && picture_is_scene(operands->items[0]);
    if (!is_scene && (tool->n_views > 1 || tool->keep))
        return fail_usage("--views and --keep are for POV-Ray scenes");
    if (tool->keep && picture_kind(tool->keep) == PICTURE_EXR)
        return fail_usage("--keep takes a folder here");
    if (operands->n_rest > 0 && !is_scene)
        return fail_usage("options after -- are for POV-Ray, and here is no scene");
    return true;
}

int view_parse(int argc, char **argv, struct view_call *call)
{
    struct image_error error;
    int n_named = 0;
    *call = (struct view_call){.options = {.n_views = 1, .demo_width = 960}};
    int code = options_parse(&command_view, argc, argv, &call->options, &call->settings,
                             &call->operands);
    if (code != OPTIONS_GO_ON)
        return code;
    code = check_usage(&call->options, &call->operands) ? OPTIONS_GO_ON : EXIT_USAGE;
    if (code == OPTIONS_GO_ON && call->options.params &&
        !params_file_read(call->options.params, &call->settings, &n_named, &error)) {
        app_missing(&error, "params", call->options.params);
        code = exit_code(app_code_of(&error), &error);
    }
    if (code == OPTIONS_GO_ON && call->options.params && n_named == 0)
        message("warning: --params " PARAMS_FILE_IS_EMPTY, call->options.params);
    call->below_look = call->settings;
    if (code == OPTIONS_GO_ON && call->options.look &&
        !look_read(call->options.look, &call->settings, &error)) {
        message("%s", error.message);
        code = EXIT_USAGE;
    }
    if (code == OPTIONS_GO_ON && !check_distribution(call))
        code = EXIT_USAGE;
    if (code != OPTIONS_GO_ON)
        operands_free(&call->operands);
    return code;
}

/* ---- the window's program ------------------------------------------------------- */

/* rackfocus-view beside this program, in ../libexec, or where the build puts it. */
static bool find_window(char *path, size_t n_bytes)
{
    static const char *const places[] = {"", "../libexec/", "../view/"};
    char folder[4096];
    if (!os_program_folder(folder, sizeof(folder)))
        return false;
    for (size_t i = 0; i < sizeof(places) / sizeof(places[0]); i++) {
        snprintf(path, n_bytes, "%s%srackfocus-view", folder, places[i]);
        if (os_file_is_program(path))
            return true;
    }
    return false;
}

static int cmd_view(int argc, char **argv)
{
    struct view_call call;
    const int code = view_parse(argc, argv, &call);
    if (code != OPTIONS_GO_ON)
        return code;
    options_warn_twice(&call.operands);
    operands_free(&call.operands);
    char path[4096 + 64];
    if (!find_window(path, sizeof(path))) {
        message("view: this build has no window, since SDL2, OpenGL or FreeType was "
                "not found; install libsdl2-dev, libgl-dev and libfreetype-dev, and "
                "build again (./dev build does both)");
        return EXIT_FAILED;
    }
    const int number = os_process_become(path, argv);
    message("%s: cannot be started: %s", path, strerror(number));
    return EXIT_FAILED;
}

const struct command command_view = {
    .name = "view",
    .is_handed_over = true,
    .summary = "pull focus with the mouse, in a window",
    .usage = "IN.exr [DEPTH.exr] [options]\n"
             "       rackfocus view FOLDER [options]\n"
             "       rackfocus view VIEW.exr VIEW.exr ... [options]\n"
             "       rackfocus view TOP.exr ... BOTTOM.exr --over [options]\n"
             "       rackfocus view LEFT.exr RIGHT.exr --stereo [options]\n"
             "       rackfocus view SCENE.pov [options] [-- POV-Ray's options]\n"
             "       rackfocus view --demo [PICTURE] [options]",
    .description =
        "Opens a window on a pinhole render and its depth: click on what is to be "
        "sharp, drag the aperture, look at depth and blur, save the picture or the "
        "command line that makes it. F1 in the window lists the keys.\n\n"
        "A folder is one that rackfocus povray --keep filled; Page Up and Page Down "
        "step through its frames. Views are files that say in their headers where on "
        "the lens they were taken. A POV-Ray scene is rendered first.",
    .examples = "rackfocus view passes.exr --f-stop 1.4\n"
                "rackfocus view passes/ --reference lens.exr\n"
                "rackfocus view scene.pov --views 8 -- +W640 +H360\n"
                "rackfocus view --demo",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .takes_params = true,
    .keeps_rest = true,
    .run = cmd_view,
};
