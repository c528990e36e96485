/* SPDX-License-Identifier: Apache-2.0 */
/* The window's program: everything that its parts share. The main thread's alone, but
 * for what is named otherwise. */
#ifndef VIEW_APP_H
#define VIEW_APP_H

#include <SDL.h>
#include <stdbool.h>
#include <stdio.h>

#include "common/operands.h"
#include "common/view_options.h"
#include "controls/font.h"
#include "controls/ui.h"
#include "accumulation.h"
#include "demo/demo.h"
#include "controls/gl.h"
#include "model/browser.h"
#include "model/dialog.h"
#include "model/frames.h"
#include "model/pull.h"
#include "model/remembered.h"
#include "model/state.h"
#include "model/undo.h"
#include "pixels/colour.h"
#include "pixels/scopes.h"
#include "pixels/stats.h"
#include "sources/picture.h"
#include "thread.h"
#include "filtering/stage.h"
#include "filtering/worker.h"

#define MAX_PATH 4096

/* X(NAME, "subject in help", key, modifiers, "key as help shows it", "what it does") */
#define ACTIONS(X)                                                                     \
    X(CENTRE, "Lens", SDLK_SPACE, 0, "Space", "focus on the middle of the window")     \
    X(NEARER, "Lens", SDLK_LEFTBRACKET, 0, "[", "focus nearer")                        \
    X(FARTHER, "Lens", SDLK_RIGHTBRACKET, 0, "]", "focus farther")                     \
    X(NEAREST, "Lens", SDLK_n, 0, "N", "focus on the nearest thing")                   \
    X(INFINITY, "Lens", SDLK_i, 0, "I", "focus at infinity")                           \
    X(WIDER, "Lens", SDLK_COMMA, 0, ",", "open the aperture by a third of a stop")     \
    X(NARROWER, "Lens", SDLK_PERIOD, 0, ".",                                           \
      "close the aperture by a third of a stop")                                       \
    X(FILTER, "Show", SDLK_f, 0, "F", "filter off and on")                             \
    X(SPLIT, "Show", SDLK_s, 0, "S", "split: pinhole left, filtered right")            \
    X(DEPTH, "Show", SDLK_d, 0, "D", "depth map, lighter = farther")                   \
    X(COC, "Show", SDLK_c, 0, "C", "circle of confusion, orange before, blue behind")  \
    X(BAND, "Show", SDLK_b, 0, "B", "what is in focus, in colour")                     \
    X(DIFFERENCE, "Show", SDLK_x, 0, "X", "difference to the reference")               \
    X(EXPOSURE, "Show", SDLK_g, 0, "G", "false colours of exposure, in stops")         \
    X(SCOPES, "Show", SDLK_h, 0, "H", "histogram and waveform")                        \
    X(GRAPHS, "Show", SDLK_y, 0, "Y", "graphs of the circle of confusion (Yu 2004)")   \
    X(VIEWS, "Show", SDLK_v, 0, "V", "demo: accumulate views as the reference")        \
    X(COMPARE, "Show", SDLK_a, 0, "A",                                                 \
      "F and S compare with the reference, the pinhole")                               \
    X(KEEP, "Show", SDLK_k, 0, "K", "keep what is shown as the reference")             \
    X(BRIGHTER, "Show", SDLK_e, 0, "E", "brighter view, half a stop")                  \
    X(DARKER, "Show", SDLK_e, KMOD_SHIFT, "Shift+E", "darker view, half a stop")       \
    X(FIT, "Place", SDLK_0, 0, "0", "fit the picture to the window")                   \
    X(ACTUAL, "Place", SDLK_1, 0, "1", "one picture px is one of the screen")          \
    X(ZOOM_IN, "Place", SDLK_PLUS, 0, "+", "larger")                                   \
    X(ZOOM_OUT, "Place", SDLK_MINUS, 0, "-", "smaller")                                \
    X(LEFT, "Place", SDLK_LEFT, 0, "arrows", "pan; turn the demo's scene")             \
    X(RIGHT, "Place", SDLK_RIGHT, 0, "", "")                                           \
    X(UP, "Place", SDLK_UP, 0, "", "")                                                 \
    X(DOWN, "Place", SDLK_DOWN, 0, "", "")                                             \
    X(EYE_LEFT, "Place", SDLK_LEFT, KMOD_SHIFT, "Shift+arrows",                        \
      "move the eye on the lens")                                                      \
    X(EYE_RIGHT, "Place", SDLK_RIGHT, KMOD_SHIFT, "", "")                              \
    X(EYE_UP, "Place", SDLK_UP, KMOD_SHIFT, "", "")                                    \
    X(EYE_DOWN, "Place", SDLK_DOWN, KMOD_SHIFT, "", "")                                \
    X(HOME, "Place", SDLK_HOME, 0, "Home", "eye, scene and picture in their places")   \
    X(UNDO, "Settings", SDLK_z, KMOD_CTRL, "Ctrl+Z", "take the last change back")      \
    X(REDO, "Settings", SDLK_y, KMOD_CTRL, "Ctrl+Y",                                   \
      "make it again; Ctrl+Shift+Z too")                                               \
    X(REDO_SHIFT, "Settings", SDLK_z, KMOD_CTRL | KMOD_SHIFT, "", "")                  \
    X(SAVE_PARAMS, "Settings", SDLK_p, KMOD_CTRL, "Ctrl+P", "save the parameters")     \
    X(COPY, "Settings", SDLK_c, KMOD_CTRL, "Ctrl+C", "copy the command line")          \
    X(OPEN, "Files", SDLK_o, KMOD_CTRL, "Ctrl+O",                                      \
      "open a file; files can be dropped, too")                                        \
    X(OPEN_LIST, "Files", SDLK_o, KMOD_CTRL | KMOD_SHIFT, "Ctrl+Shift+O",              \
      "list of the files opened last and of the folder")                               \
    X(SAVE, "Files", SDLK_s, KMOD_CTRL, "Ctrl+S", "save the picture")                  \
    X(SAVE_PASSES, "Files", SDLK_e, KMOD_CTRL, "Ctrl+E",                               \
      "demo: save colour and depth")                                                   \
    X(NEXT, "Files", SDLK_PAGEDOWN, 0, "Page Down", "next picture of the folder")      \
    X(PREVIOUS, "Files", SDLK_PAGEUP, 0, "Page Up", "previous picture of the folder")  \
    X(PLAY, "Files", SDLK_l, 0, "L", "play the frames of the folder, stop")            \
    X(SET_KEY, "Files", SDLK_m, 0, "M", "key frame of focus and aperture here")        \
    X(RELOAD, "Files", SDLK_r, 0, "R", "read the files again")                         \
    X(HELP, "Window", SDLK_F1, 0, "F1", "show or hide the keys")                       \
    X(STATS, "Window", SDLK_F2, 0, "F2", "show or hide how long things take")          \
    X(PANEL, "Window", SDLK_p, 0, "P", "show or hide the controls")                    \
    X(FULL, "Window", SDLK_F11, 0, "F11", "full screen and back")                      \
    X(QUIT, "Window", SDLK_q, KMOD_CTRL, "Ctrl+Q", "quit")
#define ACTION_ENUM(name, subject, key, modifiers, shown, help) ACTION_##name,
enum action { ACTIONS(ACTION_ENUM) N_ACTIONS };
#undef ACTION_ENUM

/* What a mouse button that went down on the picture is doing. */
enum drag { DRAG_NONE, DRAG_CLICK, DRAG_PAN, DRAG_TURN, DRAG_SPLIT, DRAG_EYE };

/* A stage that is being read on a thread of its own. */
struct loader {
    bool is_running;
    struct os_thread thread;
    struct stage *stage;
    struct settings typed;
    bool is_good; /* valid once the thread has ended */
    struct image_error error;
};

/* Frames that are played. */
struct play {
    bool is_on;
    int at;       /* the picture that is shown */
    int wanted;   /* the one to go to when what is read now is there */
    double rate;  /* frames a second */
    double due_s; /* when the next one is to be shown */
    /* What is shown comes from memory, and app->shot and app->stage are another frame's. */
    bool is_ahead;
    void (*then)(struct app *app); /* what waits until the one shown is read; or NULL */
};

/* A run of --benchmark. */
struct bench {
    double ready_s, started_s, moved_s, cpu_s, wall_s;
    double released_s; /* when the mouse was let go; 0: not yet */
    double best_ms;    /* from there to the best picture */
    bool is_over;
    struct stats stats; /* while the mouse was held */
};

struct app {
    const struct view_options *options;
    const struct operands *operands;
    struct settings typed; /* the command line */
    int exit_code;
    bool is_ending;

    SDL_Window *window;
    SDL_GLContext context;
    Uint32 event_type;     /* from other threads: see enum app_event */
    int32_t width, height; /* drawable, px */
    int window_size[2];    /* before it was made as large as the screen; 0: it is not */
    double density;        /* drawable px per px of the mouse */
    double scale;          /* of the controls */
    char font_path[MAX_PATH];
    struct font font;
    unsigned mask;
    struct ui ui;
    struct ui_input input;
    bool has_panel, has_help, has_stats;
    int help_scroll, help_height; /* px */
    uint32_t traced_place;
    uint32_t traced_tip; /* what was written of tips and errors */
    uint32_t traced_graphs, traced_cut;

    struct playlist playlist;
    struct play play;
    struct frames frames;
    struct pull pull;
    struct playlist opening; /* takes its place when its first picture is read */
    bool is_opening;
    struct remembered remembered;
    int fitted_size[2];     /* of the window as the program chose it; 0: it did not */
    struct browser browser; /* of files to open */
    bool has_browser;
    double typed_s;       /* when a letter was last typed into it */
    struct dialog dialog; /* of the desktop, to open a file */
    char **dropped;       /* paths that are being dropped */
    int n_dropped;
    int picture; /* of the playlist */
    struct loader loader;
    struct stage *stage;
    bool has_stage; /* or the demo: there is something to show */
    struct demo demo;
    struct input *source;          /* what is filtered, held */
    struct reference *reference;   /* held; NULL: none */
    char reference_path[MAX_PATH]; /* as shown in its field; "": none */
    struct accumulation accumulation;
    struct picture light_picture; /* of --distribution-image */
    struct rf_image light;

    struct state state;
    struct undo undo;       /* of struct look */
    struct look *looks[10]; /* kept with Ctrl+1 to 9; NULL: not */
    char look_name[64];     /* that a look of one's own is to have */
    const char *misplaced;  /* the look that is not as in the whole picture; NULL */
    struct colour_list colours;
    int colour_index;
    bool has_scopes, has_graphs;
    double graph_distance; /* of the thing that the graphs are of; 0: none yet */
    int eyes;              /* of a stereo pair, enum stack_eyes */
    struct scopes scopes;  /* of what is shown */
    struct {
        bool is_set;
        int32_t x, y;   /* px of the picture that was clicked to be in focus */
        double focus;   /* the distance that it gave */
        double until_s; /* shown so long */
    } mark;
    uint64_t asked_id;  /* of the newest job */
    double radius_base; /* lens radius when the picture was opened */
    bool is_demo_due;   /* the scene was turned */
    struct worker *worker;
    struct shot *shot; /* what `after` shows, without its pixels; NULL: nothing */
    uint64_t pinhole_id;
    struct gl_picture after, before;

    enum drag drag;
    double drag_x, drag_y; /* where the mouse was, window px */
    bool is_let_go;        /* the mouse, since the last job: nothing more is coming */
    bool is_input;         /* something came from the user since the last job */
    int sample_type;       /* of EXR files that are saved, enum filter_type */
    char output[MAX_PATH], status[2400];
    char replacing[MAX_PATH]; /* a file that is replaced if it is saved once more */
    double replacing_until_s;
    double status_until_s;
    bool is_missing;   /* a file has gone */
    char unshown[400]; /* the picture that the slider stands at, and why; "": shown */
    uint32_t traced_unshown;
    double looked_s; /* when it was last looked for */
    struct stats stats;
    struct bench bench;
    char renderer[256]; /* of OpenGL */
    FILE *trace;
    uint32_t traced_layout;
    bool is_redraw_due;
    double drawn_s; /* when the window was last drawn */
};

/* Codes of event_type; data1 of SAVED is a text to free. */
enum app_event { APP_SHOT, APP_LOADED, APP_SAVED };

/* Where the picture lies, the controls and the line of text at the bottom. */
struct area view_picture_area(const struct app *app);
struct area view_panel_area(const struct app *app);
int view_panel_width(const struct app *app); /* where there is room for it */
struct area view_status_area(const struct app *app);
void view_measure(struct app *app); /* after a change of the window's size */

/* Shows a line at the bottom for some seconds. */
void view_say(struct app *app, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void view_act(struct app *app, enum action action);

/* A step of undo, where something has changed and nothing is held. */
void view_note_change(struct app *app);

/* The job that makes what is set; `reference` may be NULL. `problem` says why layers or
 * an eye are left out; "": none is. */
void view_job(const struct app *app, struct reference *reference, struct job *job,
              char *problem, size_t n_bytes);

/* Are there two eyes? */
bool view_is_stereo(const struct app *app);

/* Asks the worker for the picture, where anything has changed. */
void view_ask(struct app *app);

/* Makes of an event of SDL what the program does. */
void events_take(struct app *app, const SDL_Event *event);

/* window.c: the window itself. False with a message. */
bool window_open(struct app *app);
void window_close(struct app *app);
void window_draw(struct app *app);

/* load.c: reading in the background. */
void load_begin(struct app *app);
void load_end(struct app *app); /* on APP_LOADED */
void load_cancel(struct app *app);
bool load_demo(struct app *app);
void load_look_for_files(struct app *app);

/* legend.c: what the colours mean, histogram, waveform, the mark of the focus. */
void legend_draw(struct app *app);

/* graphs_show.c: the circle of confusion over what it depends on. */
void graphs_draw(struct app *app);

/* Ctrl+1 to 9 keep the settings, Shift+1 to 9 set them again. */
void view_keep_look(struct app *app, int i);
void view_set_look(struct app *app, int i);

/* open.c: what the user opens, drops or chooses from the list of files. */
/* EXR files and scenes are shown, a PNG becomes the reference, .params are set. */
void open_files(struct app *app, char *const *paths, int n);
bool open_reference(struct app *app, const char *path); /* false: said why */
/* What is compared with from now on; takes the samples over. "": it is of no file. */
void view_set_reference(struct app *app, const struct picture *picture,
                        const char *path);
void open_drop(struct app *app, const SDL_DropEvent *event);
void open_forget(struct app *app); /* what was dropped and not yet opened */
void open_any(struct app *app);    /* by the desktop's dialog, else by the list */
void open_step(struct app *app);   /* of the main loop: takes what was chosen */
void open_list(struct app *app);   /* shows or hides it */
bool open_list_key(struct app *app, SDL_Keycode key); /* true: it took the key */
void open_list_type(struct app *app, const char *text);
bool open_list_click(struct app *app, double x, double y);
void open_list_draw(struct app *app);

/* play.c: sequences. */
void play_go(struct app *app, int picture); /* shows a picture of the playlist */
void play_toggle(struct app *app);
void play_step(struct app *app);                          /* of the main loop */
double play_waits_s(const struct app *app);               /* until it is called again */
bool play_keep(struct app *app, const struct shot *shot); /* true: it took the rgba */
/* Where frames are played, playing stops, and the action comes when the one that is shown
 * has been read: then true. */
bool play_defer(struct app *app, void (*action)(struct app *app));
/* For what needs the pixels: true, and playing stops, where they are another frame's. */
bool play_lacks_pixels(struct app *app);
void play_set_key(struct app *app);
void play_take_frame(struct app *app); /* when a frame has been read */
void play_rows(struct app *app);       /* of the panel */

/* The depth at a place of the window, scene units; false where there is no picture. */
bool view_depth_at(const struct app *app, double x, double y, double *depth,
                   int32_t *px, int32_t *py);

/* panel.c */
/* One pass of the controls over what was put into `input`, which is then used up; does
 * what they ask, and asks the worker for what changed. */
void panel_pass(struct app *app);

/* looks_menu.c: looks of lenses. */
void looks_menu_row(struct app *app);       /* of the panel: the menu */
void looks_menu_keep_rows(struct app *app); /* and how one of one's own is kept */
/* Which look is not as in the whole picture, in a sentence, "" where none is. What
 * rackfocus filter warns of is said when it begins. */
void looks_menu_describe_place(struct app *app, char *text, size_t n_bytes);

/* overlay.c: help, statistics, the line at the bottom. */
void overlay_draw(struct app *app);
void overlay_scroll_help(struct app *app, double lines);

/* save.c */
void save_picture(struct app *app);
void save_params(struct app *app);
void save_passes(struct app *app);
void save_command(struct app *app); /* to the clipboard and to stdout */
void save_default_name(struct app *app);
/* A name like that of the picture, MAX_PATH bytes, and whether a file may be replaced:
 * when it is saved a second time at once. */
void save_name_beside(const struct app *app, const char *ending, char *path);
bool save_may_replace(struct app *app, const char *path);

/* trace.c: lines of JSON for tests; nothing where there is no --trace. */
bool trace_open(struct app *app); /* false with a message */
void trace_layout(struct app *app);
void trace_shown(struct app *app, bool is_pinhole);
void trace_text(struct app *app, const char *event, const char *text);
/* Writes a text when it is another than before; `traced` remembers it. */
void trace_once(struct app *app, uint32_t *traced, const char *event, const char *text);
void trace_place(struct app *app, const char *text); /* what lies below the mouse */
void trace_tip(struct app *app); /* the tip or the error that is shown at a control */

/* bench.c */
void bench_step(struct app *app); /* moves the mouse for --benchmark */
void bench_print(const struct app *app);

#endif
