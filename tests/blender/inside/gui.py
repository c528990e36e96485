# SPDX-License-Identifier: GPL-3.0-or-later
"""A session with a window: enable, render, refocus, pick, cancel, with screenshots.

See stepping.py.
"""

import functools
import os
import sys
import threading
import time
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
import stepping  # noqa: E402
from common import addon, rgba  # noqa: E402
from stepping import (  # noqa: E402
    DIST,
    FOUND,
    OUT,
    area_of,
    forbid_writing,
    hands,
    override,
    screenshot,
    until,
    window,
)

ESCAPE = ("mousemove", 600, 400, "key", "Escape")
ENDS = []  # times at which renders ended
THREADS = {}  # what changes or saves Blender's data: in the main thread, each time?


def on_end(*_):
    """A render ended."""
    ENDS.append(time.monotonic())


def watch_threads():
    """Notes the threads of what must not run beside the window's drawing."""

    def watch(owner, name):
        function = getattr(owner, name)

        @functools.wraps(function)
        def watched(*args):
            is_main = threading.current_thread() is threading.main_thread()
            THREADS.setdefault(name, []).append(is_main)
            return function(*args)

        setattr(owner, name, staticmethod(watched) if owner is saver else watched)

    saver = addon("passes").RenderedPasses
    watch(saver, "_write_file")
    for module, name in (
        ("views", "prepare_frame"),
        ("views", "follow"),
    ):
        watch(addon(module), name)


def result(name):
    """The picture as it stands, (height, width, 4)."""
    scene = bpy.context.scene
    addon("writing").write(common.set_output, scene, OUT / f"{name}.exr")
    bpy.data.images["Render Result"].save_render(str(OUT / f"{name}.exr"), scene=scene)
    return rgba(common.read(OUT / f"{name}.exr"))


def wait_for_job():
    """Until the render and what follows it is over."""
    yield from until(has_ended, "the end of the render")
    yield 0.4
    ENDS.clear()


def has_ended():
    """Did a render end, and does none run?"""
    return ENDS and not bpy.app.is_job_running("RENDER")


def escape():
    """Esc until the render is over: a window that is busy may miss a key."""
    ends = time.monotonic() + stepping.LONGEST_S
    while not has_ended():
        assert time.monotonic() < ends, "Esc did not end the render"
        yield 1.5
        yield from hands(*ESCAPE)


def show_camera():
    """The Properties editor on the camera's own tab, tall."""
    scene = bpy.context.scene
    with override(area_of("VIEW_3D")):
        bpy.context.view_layer.objects.active = scene.camera
        scene.camera.select_set(True)
    yield 0.5
    area_of("PROPERTIES").spaces.active.context = "DATA"


def steps():
    """The session; yields the seconds to wait."""
    bpy.context.preferences.view.render_display_type = "AREA"
    bpy.context.preferences.view.ui_scale = 0.9
    common.install(DIST)
    watch_threads()
    common.make_base(OUT / "base.blend")
    yield from forbid_writing()
    scene = bpy.context.scene
    stepping.picture_size(scene, 720, 480)
    scene.cycles.samples = 16
    data = scene.camera.data
    yield 0.5
    yield from show_camera()
    yield 0.5
    data.dof.use_dof = True
    data.rack_focus.clean_edges, data.rack_focus.supersample = False, 1  # as filtered()
    data.rack_focus.enabled = True
    bpy.ops.ed.undo_push(message="Rack Focus")
    FOUND["scenes"] = len(bpy.data.scenes)
    yield 0.7
    yield from screenshot("layout")
    bpy.ops.render.render("INVOKE_DEFAULT")
    yield from wait_for_job()
    first = result("first")
    yield from screenshot("render")
    FOUND["dof_is_back"] = data.dof.use_dof
    data.dof.focus_distance = 1.5
    FOUND["filters_beside"] = refocus_beside_a_busy_window()
    yield from wait_for_job()
    second = result("second")
    yield from screenshot("refocus")
    FOUND["refocus_changes"] = float(np.abs(first - second).max())
    FOUND["muted_left"] = any(n.mute for n in common.tree_of(scene).nodes)
    yield from pick()
    yield from several_views()
    yield from compositor()
    yield from cancel()
    FOUND["threads"] = THREADS


def refocus_beside_a_busy_window():
    """Starts a refocus; does it filter while the main thread does something else?"""
    engine = addon("engine").RackFocusEngine
    kept, begun = engine._filter, threading.Event()

    def begin(*args):
        begun.set()
        return kept(*args)

    engine._filter = begin
    bpy.ops.rack_focus.refocus("INVOKE_DEFAULT")
    is_begun = begun.wait(10)
    engine._filter = kept
    return is_begun


def pick():
    """A click in the Image Editor, by the operator's own coordinates."""
    scene = bpy.context.scene
    area = area_of("IMAGE_EDITOR")
    panel = addon("ui").ImagePanel  # into the tab that is open: scripts cannot switch
    bpy.utils.unregister_class(panel)
    panel.bl_category = "Tool"
    bpy.utils.register_class(panel)
    area.spaces.active.show_region_ui = True
    depth = addon("passes").rendered(scene).layer("ViewLayer").depth
    height, width = depth.shape
    hits = np.argwhere((depth > 5) & (depth < 1e9))
    row, column = hits[len(hits) // 2]
    with override(area):
        bpy.ops.rack_focus.pick_focus(
            x=(column + 0.5) / width, y=1 - (row + 0.5) / height
        )
    yield from wait_for_job()
    FOUND["picked_elsewhere"] = pick_elsewhere(area)
    FOUND["picked"] = scene.camera.data.dof.focus_distance
    FOUND["picked_depth"] = float(depth[row, column])
    yield 0.4
    yield from screenshot("pick")


def pick_elsewhere(area):
    """What is said where the editor shows a texture, and where it shows nothing."""
    space, said = area.spaces.active, []
    shown = space.image
    for image in (bpy.data.images.new("Texture", 8, 8), None):
        space.image = image
        with override(area):
            try:
                bpy.ops.rack_focus.pick_focus(x=0.5, y=0.5)
            except RuntimeError as error:
                said.append(str(error))
    space.image = shown
    bpy.data.images.remove(bpy.data.images["Texture"])
    return said


def several_views():
    """Views as a job, refocused, and a render stopped by Esc while they are made."""
    scene = bpy.context.scene
    data = scene.camera.data
    before = common.snapshot(scene)
    data.rack_focus.views = 4
    bpy.ops.render.render("INVOKE_DEFAULT")
    yield from wait_for_job()
    FOUND["views_message"] = addon("engine").last_run[scene.name]["message"]
    FOUND["views"] = len(addon("passes").rendered(scene).views("ViewLayer"))
    first = result("views_first")
    data.dof.focus_distance = 5
    bpy.ops.rack_focus.refocus("INVOKE_DEFAULT")
    yield from wait_for_job()
    FOUND["views_change"] = float(np.abs(first - result("views_second")).max())
    FOUND["views_leave_nothing"] = common.snapshot(scene) == before
    scene.cycles.samples = 40000
    bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(lambda: addon("views").is_active(scene), "the views")
    yield from escape()
    yield from wait_for_job()
    FOUND["views_after_escape"] = common.snapshot(scene) == before
    FOUND["escape_message"] = addon("engine").last_run[scene.name]["message"]
    scene.cycles.samples = 32 * os.cpu_count()  # a second or two
    bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(lambda: addon("views").is_active(scene), "the views")
    yield 0.3
    FOUND["is_unticked_meanwhile"] = addon("views").is_active(scene)
    data.rack_focus.enabled = False
    yield from wait_for_job()
    yield from until(lambda: len(bpy.data.scenes) == 1, "the end of the set-up")
    data.rack_focus.enabled = True
    yield 0.5
    FOUND["views_after_unticking"] = common.snapshot(scene) == before
    scene.cycles.samples = 16
    data.rack_focus.views = 1
    bpy.ops.render.render("INVOKE_DEFAULT")
    yield from wait_for_job()


def compositor():
    """The node in its editor; the node's own render button."""
    scene = bpy.context.scene
    window().workspace = bpy.data.workspaces["Compositing"]
    yield 0.8
    area = area_of("NODE_EDITOR")
    with override(area):
        area.spaces.active.show_backdrop = True
        bpy.ops.node.view_all()
    yield 0.8
    yield from screenshot("compositor")
    ours = scene.rack_focus.filter_scene
    bpy.context.preferences.view.render_display_type = "NONE"  # keeps the editor
    scene.camera.data.dof.focus_distance = 2
    bpy.ops.render.render(
        "INVOKE_DEFAULT", layer=ours.view_layers[0].name, scene=ours.name
    )
    yield from wait_for_job()
    found = addon("passes").rendered(scene).layer("ViewLayer")
    expected = common.filtered(scene, found.colour, found.depth)

    def is_filtered():  # the refocus that follows is a job of its own
        if bpy.app.is_job_running("RENDER"):
            return False
        try:
            picture = result("button")
        except RuntimeError:  # a job began meanwhile and holds the Render Result
            return False
        FOUND["button_difference"] = float(np.abs(picture - expected).max())
        return FOUND["button_difference"] < 0.01

    yield from until(is_filtered, "the filtered picture", 0.1)
    yield from screenshot("button")


def cancel():
    """Esc while the filter runs: how long until it ends, and what is shown."""
    scene = bpy.context.scene
    yield 1.0
    yield from until(lambda: not bpy.app.is_job_running("RENDER"), "quiet")
    ENDS.clear()
    stepping.picture_size(scene, 1920, 1280)
    scene.cycles.samples = 1
    scene.camera.data.dof.aperture_fstop = 0.06
    engine = addon("engine").RackFocusEngine
    begun = []
    kept = engine._report

    def report(self, fraction):
        if fraction > 0.02 and not begun:  # waits for the key, a minute at most
            begun.append(time.monotonic())
            while not self.test_break() and time.monotonic() < begun[0] + 60:
                time.sleep(0.005)
        return kept(self, fraction)

    engine._report = report
    bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(lambda: begun or ENDS, "the filter", 0.02)
    yield from hands(*ESCAPE)
    pressed = time.monotonic()
    yield from wait_for_cancel(pressed)
    engine._report = kept
    FOUND["is_dof_hidden"] = scene.camera.data.rack_focus.is_dof_hidden
    FOUND["message"] = addon("engine").last_run[scene.name]["message"]


def wait_for_cancel(pressed):
    """Notes the seconds from the key to the end of the job."""
    yield from until(has_ended, "the end of the filter", 0.02)
    FOUND["cancel_s"] = ENDS[-1] - pressed
    yield 0.5
    yield from screenshot("cancel")


for _list in ("render_complete", "render_cancel"):
    getattr(bpy.app.handlers, _list).append(on_end)
stepping.play(steps())
