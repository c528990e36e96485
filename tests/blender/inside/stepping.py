# SPDX-License-Identifier: GPL-3.0-or-later
"""Sessions with a window: steps of a timer, with someone who presses keys and looks.

    blender -P SCRIPT -- DIST OUT

A step is what a generator does until it yields the seconds to wait; renders are jobs
beside the window's own loop. Writes OUT/found.json: {what: value}, OUT/*.png.
"""

import faulthandler
import json
import os
import sys
import threading
import time
import traceback
from pathlib import Path

import bpy
import common

DIST, OUT = (Path(a) for a in sys.argv[sys.argv.index("--") + 1 :][:2])
IS_FOR_DOCS = "RACKFOCUS_SHOTS" in os.environ
FOUND = {"version": bpy.app.version_string}
LONGEST_S = 400  # for what takes a second on an idle machine; shaders take a minute
SCROLL = ("--repeat", 60, "--delay", 4)  # a click of the wheel: to the end
STUCK_S = 500  # without a step: every thread then says where it is


def window():
    """The main window."""
    return bpy.context.window_manager.windows[0]


def area_of(kind):
    """The first area of a kind in the window's screen."""
    return next(a for a in window().screen.areas if a.type == kind)


def region_of(area):
    """The main region of an area."""
    return next(r for r in area.regions if r.type == "WINDOW")


def override(area):
    """A context for operators: that area."""
    return bpy.context.temp_override(window=window(), area=area, region=region_of(area))


def until(test, what, pause_s=0.05):
    """Waits until test() holds; fails when it never does."""
    begun = time.monotonic()
    while not test():
        assert time.monotonic() < begun + LONGEST_S, f"{what} never came"
        yield pause_s
    print(f"{what}: came after {time.monotonic() - begun:.1f} s", flush=True)


def ask(path, what, pause_s):
    """Has the test see to a file, which then is gone."""
    with (OUT / "asked").open("w") as pipe:
        print(path.name, file=pipe)
    yield from until(lambda: not path.exists(), what, pause_s)


def screenshot(name):
    """The window as a file: the test takes it, since 5.x returns black here."""
    asked = OUT / f"{name}.shot"
    asked.touch()
    yield from ask(asked, f"the screenshot {name}", 0.02)


def hands(*words):
    """The test's xdotool does this, on the real mouse and keyboard."""
    (OUT / "hands").write_text(" ".join(map(str, words)))
    yield from ask(OUT / "hands", f"xdotool {words}", 0.005)


def on_display(region, x, y):
    """The display's px, rows downwards, of a region's, rows upwards."""
    return round(region.x + x), round(window().height - 1 - (region.y + y))


def forbid_writing():
    """Leaves Blender's switch against writing while it draws set, for good.

    So does Blender itself when a call of a render engine begins in the middle of a draw
    and ends after it (3.4; 5.2 has a switch for each thread). Only operators and
    callbacks of properties can write then.
    """
    writing = common.addon("writing")
    inside, drawn = threading.Event(), threading.Event()

    def outlast():
        inside.set()
        drawn.wait()

    def draw(_header, _context):
        if not inside.is_set():
            threads.append(threading.Thread(target=writing.write, args=[outlast]))
            threads[0].start()
            inside.wait()

    def try_to_write():  # a timer of its own: the steps run in the gate
        try:
            bpy.context.scene.frame_end = bpy.context.scene.frame_end
            FOUND["is_forbidden"] = False
        except AttributeError:
            FOUND["is_forbidden"] = True

    threads = []
    bpy.types.VIEW3D_HT_header.append(draw)
    for region in area_of("VIEW_3D").regions:
        region.tag_redraw()
    yield from until(inside.is_set, "a draw", 0.02)
    drawn.set()
    threads[0].join()
    bpy.types.VIEW3D_HT_header.remove(draw)
    bpy.app.timers.register(try_to_write)
    yield from until(lambda: "is_forbidden" in FOUND, "the attempt", 0.02)


def picture_size(scene, width, height):
    """Sets it: a half of that where no pictures are kept for the docs."""
    part = 1 if IS_FOR_DOCS else 2
    scene.render.resolution_x = width // part
    scene.render.resolution_y = height // part


def play(steps, is_smooth=IS_FOR_DOCS):
    """Runs the generator; at its end or a failure Blender closes.

    is_smooth: are lines in 3D views? OpenGL is drawn by the processor here: a window in
    0.8 s and not in 2 without.
    """

    def advance():
        faulthandler.dump_traceback_later(STUCK_S, repeat=True)
        try:
            waits = []
            if "rack_focus" in dir(bpy.context.scene):
                writing = common.addon("writing")
                writing.write(lambda: waits.append(next(steps)))
            else:
                waits.append(next(steps))
            return waits[0]
        except StopIteration:
            FOUND["done"] = True
        except Exception:
            FOUND["failure"] = traceback.format_exc()
            print(FOUND["failure"], flush=True)
        (OUT / "found.json").write_text(json.dumps(FOUND, indent=1))
        common.leave()

    bpy.context.preferences.view.show_splash = False
    if not is_smooth:
        bpy.context.preferences.system.viewport_aa = "OFF"
    bpy.app.timers.register(advance, first_interval=1.5, persistent=True)
