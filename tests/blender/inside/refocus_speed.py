# SPDX-License-Identifier: GPL-3.0-or-later
"""From a changed f-stop to the new composite at 1920 x 1080; docs/measure_refocus.py.

    refocus_speed.py DIST OUT    (after -- where Blender is a program)

In the background prints one line as JSON. With a window (stepping.py) the refocus is a
job, and what the window's loop waits for at most is found too.
"""

import contextlib
import json
import sys
import threading
import time
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
from common import addon  # noqa: E402

DIST, OUT = (Path(a) for a in sys.argv[sys.argv.index("--") + 1 :][:2])
N_TIMES = 10
TICKS = []


def hurry():
    """The session's programs, the display too, before others where the system allows it.

    Not real-time: there the filter would not let the window draw for 0.1 s at a time.
    """
    with contextlib.suppress(OSError):
        Path("/proc/self/autogroup").write_text("-20")


def prepare():
    """(scene, camera data): the cubes, large, 1 sample; rendered once."""
    common.install(DIST)
    common.make_base(OUT / "base.blend")
    scene, data = common.start(quality="normal")
    scene.cycles.samples = 1
    scene.render.resolution_x, scene.render.resolution_y = 1920, 1080
    data.dof.aperture_fstop = 1
    return scene, data


def seconds_of(scene):
    """{step: seconds} of the last refocus."""
    return dict(addon("engine").last_run[scene.name]["seconds"])


def least(rows):
    """The shortest row, and its time beside the filter."""
    best = min(rows, key=lambda row: row["whole"])
    return {**best, "beside": best["whole"] - best["filter"]}


def in_background():
    """Prints what was found."""
    scene, data = prepare()
    bpy.ops.render.render()
    rows = []
    hurry()
    for index in range(N_TIMES):
        data.dof.aperture_fstop = 1 + 0.01 * index
        begun = time.perf_counter()
        bpy.ops.rack_focus.refocus()
        rows.append({"whole": time.perf_counter() - begun, **seconds_of(scene)})
    print("SPEED", json.dumps({"version": bpy.app.version_string, **least(rows)}))
    common.leave()


def tick():
    """A timer that notes when the window's loop came to it."""
    TICKS.append(time.perf_counter())
    return 0.001


OURS = (
    ("handlers", "_begin"),
    ("handlers", "_finish"),
    ("handlers", "_follow"),
    ("operators", "keep_passes"),
    ("setup", "mute_sources"),
)


def watch_main_thread():
    """List of the seconds of each call of what the add-on does in the main thread."""
    seconds = []

    def watch(module, name):
        kept = getattr(module, name)

        def watched(*args):
            begun = time.perf_counter()
            try:
                return kept(*args)
            finally:
                if threading.current_thread() is threading.main_thread():
                    seconds.append(time.perf_counter() - begun)

        setattr(module, name, watched)

    for module, name in OURS:
        watch(addon(module), name)
    return seconds


def watch_picture():
    """{"composite": , "drawn": } the moments of the last picture's, filled as they come.

    drawn: the first time that the Image Editor is drawn from begin to end with it.
    """
    at = {}

    def composite(*_):
        at["composite"] = time.perf_counter()

    def begin_draw():
        at["draws_it"] = "composite" in at

    def end_draw():
        if at.get("draws_it"):
            at.setdefault("drawn", time.perf_counter())

    bpy.app.handlers.render_complete.insert(0, composite)
    add = bpy.types.SpaceImageEditor.draw_handler_add
    add(begin_draw, (), "WINDOW", "PRE_VIEW")
    add(end_draw, (), "WINDOW", "POST_PIXEL")
    return at


def with_a_window():
    """Steps of a session."""
    import stepping

    scene, data = prepare()
    ours, at = watch_main_thread(), watch_picture()
    yield 0.5
    bpy.context.preferences.view.render_display_type = "AREA"
    bpy.ops.render.render("INVOKE_DEFAULT")
    yield 0.5
    yield from stepping.until(is_quiet, "the render")
    yield 1.0
    bpy.app.timers.register(tick, persistent=True)
    rows, pauses, of_blender = [], [], []
    ours.clear()
    hurry()
    for _ in range(N_TIMES):  # the picture, drawn again, and nothing else
        begun = time.perf_counter()
        bpy.data.images["Render Result"].update_tag()
        for area in stepping.window().screen.areas:
            area.tag_redraw()
        yield 0.5
        of_blender.append(longest_pause(begun))
    for index in range(N_TIMES):
        data.dof.aperture_fstop = 1 + 0.01 * index
        yield 0.3
        at.clear()
        begun = time.perf_counter()
        bpy.ops.rack_focus.refocus("INVOKE_DEFAULT")
        yield 0.001
        yield from stepping.until(is_quiet, "the refocus", 0.001)
        yield from stepping.until(lambda: "drawn" in at, "the picture", 0.001)
        row = {"whole": at["composite"] - begun, "drawn": at["drawn"] - begun}
        rows.append({**row, **seconds_of(scene)})
        yield 0.3
        pauses.append(longest_pause(begun))
    stepping.FOUND["ours"] = sorted(ours)
    stepping.FOUND["of_blender"] = sorted(of_blender)
    stepping.FOUND["speed"] = least(rows)
    stepping.FOUND["pauses"] = sorted(pauses)


def is_quiet():
    """No render runs."""
    return not bpy.app.is_job_running("RENDER")


def longest_pause(since):
    """Seconds for which the window's loop did not turn."""
    times = np.array([t for t in TICKS if t >= since])
    return float(np.diff(times).max())


if bpy.app.background:
    in_background()
else:
    import stepping

    stepping.play(with_a_window(), is_smooth=True)
