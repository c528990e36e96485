# SPDX-License-Identifier: GPL-3.0-or-later
"""A session with a window: panels, refocus by itself, the node with sockets as a job.

See stepping.py.
"""

import sys
import threading
import time
from pathlib import Path

import bpy
import bpy_extras.view3d_utils
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
import stepping  # noqa: E402
from common import addon, rgba  # noqa: E402
from stepping import (  # noqa: E402
    DIST,
    FOUND,
    OUT,
    SCROLL,
    area_of,
    hands,
    on_display,
    override,
    region_of,
    screenshot,
    until,
    window,
)

TICKS = []  # times at which the window's loop came to us
PASSES = ("_look", "_advanced")


def tick():
    """A timer that notes how long the main thread was away."""
    TICKS.append(time.monotonic())
    return 0.002


def longest_pause(since):
    """Seconds for which the window's loop did not turn, and the median of all."""
    times = np.array([t for t in TICKS if t >= since])
    gaps = np.diff(times)
    return float(gaps.max()), float(np.median(gaps))


def is_quiet():
    """No render runs."""
    return not bpy.app.is_job_running("RENDER")


def render():
    """F12, until it is over."""
    bpy.ops.render.render("INVOKE_DEFAULT")
    yield 0.3
    yield from until(is_quiet, "the end of the render")
    yield 0.3


def result(name):
    """The picture as it stands."""
    scene = bpy.context.scene
    common.set_output(scene, OUT / f"{name}.exr")
    bpy.data.images["Render Result"].save_render(str(OUT / f"{name}.exr"), scene=scene)
    return rgba(common.read(OUT / f"{name}.exr"))


def into_tab(name, tab):
    """Moves a panel into the tab that is open: scripts cannot switch."""
    panel = getattr(addon("ui"), name)
    bpy.utils.unregister_class(panel)
    panel.bl_category = tab
    bpy.utils.register_class(panel)


def open_parts():
    """The closed parts of the box, opened: scripts cannot click."""
    for name in dir(bpy.types):
        is_part = name.startswith(
            ("DATA_PT_rack_focus_", "CYCLES_CAMERA_PT_rack_focus_")
        )
        if is_part and name.endswith(PASSES):
            cls = getattr(bpy.types, name)
            bpy.utils.unregister_class(cls)
            cls.bl_options = set()
            cls.bl_idname = f"{name}_open"  # Blender remembers that the other is closed
            bpy.utils.register_class(cls)


def show_panels():
    """The box with its parts, in the largest area."""
    scene = bpy.context.scene
    with override(area_of("VIEW_3D")):
        bpy.context.view_layer.objects.active = scene.camera
        scene.camera.select_set(True)
    yield 0.4
    large = area_of("VIEW_3D")
    large.type = "PROPERTIES"
    yield 0.5
    large.spaces.active.context = "DATA"
    settings = scene.camera.data.rack_focus
    yield 0.6
    middle = (large.x + large.width // 2, 450)
    yield from hands("mousemove", *middle, "click", *SCROLL, "5")
    yield 0.6
    yield from screenshot("box")
    open_parts()
    settings.quality = "custom"
    settings.has_max_radius = True
    settings.has_highlight_clamp = True
    settings.views = 8
    large.tag_redraw()
    yield 0.4
    yield from hands("mousemove", *middle, "click", *SCROLL, "5")
    yield 0.6
    yield from screenshot("box_custom")
    settings.has_highlight_clamp, settings.views = False, 1
    settings.quality, settings.has_max_radius = "best", False
    large.type = "VIEW_3D"
    yield 0.4


def drag_the_focus():
    """The arrow in the 3D view, seen from above; its plane in a screenshot."""
    area, dof = area_of("VIEW_3D"), bpy.context.scene.camera.data.dof
    space = area.spaces.active
    view, region = space.region_3d, region_of(area)
    kept = view.view_perspective, view.view_distance, dof.focus_distance
    view.view_perspective, view.view_rotation = "ORTHO", (1, 0, 0, 0)
    view.view_location, view.view_distance = (0, 3, 0), 12
    yield 0.6
    for is_shown in (False, True):
        space.show_gizmo = is_shown
        area.tag_redraw()
        yield 0.4
        yield from screenshot("gizmo" if is_shown else "gizmo_off")
    place = bpy_extras.view3d_utils.location_3d_to_region_2d(
        region, view, (0, dof.focus_distance, 0)
    )
    x, y = on_display(region, *place)
    yield from hands("mousemove", x, y - 20, "sleep", 0.5, "mousedown", 1)
    for step in range(1, 5):
        yield from hands("mousemove", x, y - 20 - 16 * step)
        yield 0.05
    yield from hands("mouseup", 1)
    yield 0.5
    FOUND["dragged"] = kept[2], dof.focus_distance
    view.view_perspective, view.view_distance, dof.focus_distance = kept
    yield 0.3


def by_itself():
    """A change is followed without a button, once; the window goes on meanwhile."""
    scene = bpy.context.scene
    data, refocusing = scene.camera.data, addon("refocusing")
    stepping.picture_size(scene, 1920, 1080)
    data.dof.aperture_fstop = 2.0
    data.rack_focus.quality = "preview"
    yield from render()
    first = result("itself_first")
    data.dof.focus_distance = 2
    yield 1.0
    FOUND["old_without_the_toggle"] = refocusing.is_out_of_date(scene)
    into_tab("ImagePanel", "Tool")
    area_of("IMAGE_EDITOR").spaces.active.show_region_ui = True
    yield 0.6
    yield from screenshot("out_of_date")
    scene.rack_focus.is_automatic = True
    yield 0.3
    seconds = []
    for focus in (1.7, 4.0, 1.8):
        begun = time.monotonic()
        data.dof.focus_distance = focus
        yield from until(
            lambda: not refocusing.is_out_of_date(scene) and is_quiet(), "itself", 0.01
        )
        run = addon("engine").last_run[scene.name]["seconds"]
        seconds.append((time.monotonic() - begun, run.get("total", 0), run))
        FOUND["pause"] = longest_pause(begun)
        yield 0.4
    scene.rack_focus.is_automatic = False
    FOUND["itself_s"] = seconds
    FOUND["itself_changes"] = float(np.abs(first - result("itself_second")).max())


def finish():
    """As a job: another picture of the same lens, and nothing left."""
    scene = bpy.context.scene
    stepping.picture_size(scene, 360, 240)
    yield from render()
    first = result("finish_first")
    FOUND["finish_done"] = list(bpy.ops.rack_focus.finish("INVOKE_DEFAULT", samples=2))
    yield 0.3
    yield from until(is_quiet, "the finish")
    yield 0.5
    run = addon("engine").last_run[scene.name]
    FOUND["finish_message"], FOUND["finish_steps"] = run["message"], run["seconds"]
    FOUND["finish_changes"] = float(np.abs(first - result("finish_second")).max())
    FOUND["finish_scenes"] = sorted(s.name for s in bpy.data.scenes)
    FOUND["finish_muted"] = scene.rack_focus.muted


def node():
    """The node with sockets, behind a Denoise node, as a job; in its editor."""
    scene = bpy.context.scene
    stepping.picture_size(scene, 720, 480)
    scene.camera.data.rack_focus.quality = "best"
    window().workspace = bpy.data.workspaces["Compositing"]
    yield 0.8
    tree = common.tree_of(scene)
    ours = addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]
    exposure = tree.nodes.new("CompositorNodeExposure")
    exposure.inputs["Exposure"].default_value = 1
    exposure.location = (300, 300)
    addon("setup").put_behind(scene, tree, ours, exposure)
    tree.nodes.active = exposure
    with override(area_of("NODE_EDITOR")):
        bpy.ops.rack_focus.add_picture_node()
        area_of("NODE_EDITOR").spaces.active.show_region_ui = True
    yield 0.5
    bpy.context.preferences.view.render_display_type = "NONE"
    yield from render()
    FOUND["node_message"] = addon("engine").last_run[scene.name]["message"]
    made = result("node")
    one = addon("group").nodes_of(scene)[0]
    given, depth = addon("nodes")._kept[scene.name][one.name]
    wanted = common.filtered(scene, given.colour, depth)
    FOUND["node_difference"] = float(np.abs(made - wanted).max())
    into_tab("NodePanel", "Node")
    with override(area_of("NODE_EDITOR")):
        bpy.ops.node.view_all()
    yield 0.6
    yield from screenshot("node")
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "node.blend"), copy=True)
    yield 0.3
    scene.camera.data.dof.focus_distance = 5
    bpy.ops.rack_focus.refocus("INVOKE_DEFAULT")
    yield 0.3
    yield from until(is_quiet, "the refocus")
    yield 0.3
    wanted = common.filtered(scene, given.colour, depth)
    FOUND["node_refocus_difference"] = float(np.abs(result("node") - wanted).max())
    FOUND["scenes_left"] = sorted(s.name for s in bpy.data.scenes)


def set_box(is_on=True):
    """Ticks the box; an undo leaves other data."""
    bpy.context.scene.camera.data.rack_focus.enabled = is_on
    bpy.ops.ed.undo_push(message="box")


def ticked():
    """Blender 5.x composites again as the box is ticked; what is seen a moment later."""
    area_of("IMAGE_EDITOR").spaces.active.image = bpy.data.images["Render Result"]
    for name in ("without_depth", "with_depth"):
        set_box(False)
        yield 0.3
        bpy.context.view_layer.use_pass_z = name == "with_depth"
        yield from render()
        plain = result("plain")
        addon("engine").last_run.clear()
        set_box()
        yield from recomposited()
        shown, scene = result("ticked"), bpy.context.scene
        FOUND[f"ticked_{name}"] = (
            float(np.abs(shown - plain).max()),
            float(shown[..., :3].mean()),
            addon("engine").last_run.get(scene.name, {}).get("message"),
        )
    for step in (bpy.ops.ed.undo, bpy.ops.ed.redo):
        addon("engine").last_run.clear()
        with override(area_of("IMAGE_EDITOR")):
            step()
        yield from recomposited()
    FOUND["redone"] = float(np.abs(result("redone") - shown).max())
    if FOUND["version"] >= "5":
        yield from press_while_filtered()


def recomposited():
    """Until the picture after a tick is there; there is none to wait for up to 4.5."""
    if FOUND["version"] >= "5" and bpy.context.scene.camera.data.rack_focus.enabled:
        yield from until(lambda: addon("engine").last_run, "the picture", 0.1)
    yield 0.6


def press_while_filtered():
    """F12 on the keyboard while the window waits for the picture of a tick."""
    engine, begun = addon("engine").RackFocusEngine, []
    kept = engine._filter

    def press(*args):
        if not begun:
            words = "mousemove", *middle, "key", "F12"
            begun.append(True)
            for pause_s in hands(*words):
                time.sleep(pause_s)
        return kept(*args)

    def begin(scene, *_):
        if scene == bpy.context.scene:
            begins.append(bool(scene.rack_focus.muted))

    area, begins = area_of("IMAGE_EDITOR"), []
    middle = area.x + area.width // 2, 400
    bpy.app.handlers.render_init.append(begin)
    set_box(False)
    yield 0.3
    engine._filter = press
    set_box()
    yield from until(lambda: len(begins) > 1 and is_quiet(), "the render of F12")
    engine._filter = kept
    bpy.app.handlers.render_init.remove(begin)
    FOUND["refocus_then_render"] = begins
    yield 0.3


def undo_of_a_refocus():
    """A change while a refocus runs, and back to it once that is over."""
    engine, held = addon("engine").RackFocusEngine, threading.Event()
    kept = engine._filter

    def hold(*args):
        held.wait(60)
        return kept(*args)

    engine._filter = hold
    bpy.ops.rack_focus.refocus("INVOKE_DEFAULT")
    yield 0.3
    FOUND["muted_meanwhile"] = bool(bpy.context.scene.rack_focus.muted)
    dof = bpy.context.scene.camera.data.dof
    for focus in (2.2, 2.5):
        dof.focus_distance = focus
        bpy.ops.ed.undo_push(message="focus")
        held.set()
        yield from until(is_quiet, "the end of the refocus")
        yield 0.5
    engine._filter = kept
    with override(area_of("IMAGE_EDITOR")):
        bpy.ops.ed.undo()
    yield 0.6
    scene = bpy.context.scene
    FOUND["undone_focus"] = scene.camera.data.dof.focus_distance
    nodes = [node.name for node in common.tree_of(scene).nodes if node.mute]
    FOUND["undone_muted"] = nodes, scene.rack_focus.muted


def steps():
    """The session; yields the seconds to wait."""
    bpy.context.preferences.view.ui_scale = 0.9
    bpy.context.preferences.view.render_display_type = "AREA"
    common.install(DIST)
    common.make_base(OUT / "base.blend")
    scene = bpy.context.scene
    scene.cycles.samples = 1
    data = scene.camera.data
    data.dof.use_dof = data.rack_focus.enabled = True
    bpy.ops.ed.undo_push(message="Rack Focus")
    bpy.app.timers.register(tick, persistent=True)
    yield 0.5
    yield from show_panels()
    yield from drag_the_focus()
    yield from by_itself()
    yield from finish()
    yield from ticked()
    yield from undo_of_a_refocus()
    yield from node()


if __name__ == "__main__":
    stepping.play(steps())
