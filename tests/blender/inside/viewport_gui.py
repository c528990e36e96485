# SPDX-License-Identifier: GPL-3.0-or-later
"""A session with 3D views: the switch, orbiting, playback, click to focus, the maps.

    blender -P viewport_gui.py -- DIST OUT

Runs as steps of a timer. Writes OUT/viewport.json: {what: value} and OUT/*.png.
"""

import json
import math
import os
import sys
import time
import traceback
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
from common import addon  # noqa: E402

DIST, OUT = (Path(a) for a in sys.argv[sys.argv.index("--") + 1 :][:2])
FOUND = {"version": bpy.app.version_string}
LONGEST_S = 100


def window():
    """The main window."""
    return bpy.context.window_manager.windows[0]


def area():
    """The 3D view."""
    return next(a for a in window().screen.areas if a.type == "VIEW_3D")


def region():
    """Its main region."""
    return next(r for r in area().regions if r.type == "WINDOW")


def settings():
    """The settings of the views."""
    return bpy.context.window_manager.rack_focus_view


def view():
    """What the add-on keeps of the region."""
    return addon("viewport").view_of(region())


def screenshot(name):
    """The window as a file: the test takes it."""
    asked = OUT / f"{name}.shot"
    asked.touch()
    while asked.exists():
        yield 0.05


def settle():
    """Until the picture of the view is the final one."""
    area().tag_redraw()
    yield 0.4
    ends = time.monotonic() + LONGEST_S
    while view() is None or not view().is_final:
        assert time.monotonic() < ends, "no picture came"
        area().tag_redraw()
        yield 0.1
    yield 0.2


def shown():
    """The picture on the view, (height, width, 4), rows upwards."""
    data = view().texture.read()
    width, height = view().texture.width, view().texture.height
    data.dimensions = width * height * 4
    return np.array(data).reshape(height, width, 4).copy()


def make_scene():
    """The cubes of the other tests, some textured floor, an animated camera's focus."""
    common.make_base(OUT / "base.blend")
    scene = bpy.context.scene
    for name, item in enumerate(o for o in scene.objects if o.type == "MESH"):
        item.color = (*np.random.default_rng(name).random(3), 1)
        item.scale = (2, 2, 2)
    data = scene.camera.data
    data.dof.aperture_fstop = 0.15
    data.dof.focus_distance = 2
    shading = area().spaces.active.shading
    shading.type = "SOLID"
    shading.color_type = "OBJECT"
    return scene


def steps():
    """The session; yields the seconds to wait."""
    common.install(DIST)
    scene = make_scene()
    space = area().spaces.active
    data = space.region_3d
    yield 0.5
    data.view_perspective = "CAMERA"
    yield 1
    FOUND["handlers_before"] = addon("viewport")._handler is None
    yield from screenshot("off")
    settings().percentage = 100
    settings().enabled = True
    yield from settle()
    FOUND["camera_seconds"] = view().seconds
    near = shown()
    yield from screenshot("camera_near")
    FOUND["message"] = view().message
    depth = np.array(view().depth)
    seen = addon("viewport_lens").planar_depth(data.window_matrix, depth)
    hits = np.isfinite(seen)
    FOUND["nearest"], FOUND["farthest"] = float(seen[hits].min()), float(
        seen[hits].max()
    )
    FOUND["background"] = near[5, 5].tolist()
    # Another lens.
    scene.camera.data.dof.focus_distance = 9
    bpy.context.view_layer.update()
    yield from settle()
    far = shown()
    FOUND["focus_changes"] = float(np.abs(near - far).max())
    yield from screenshot("camera_far")
    # A click: the depth there is that of a ray.
    rows = np.argwhere(hits & (seen < 2.5))
    row, column = rows[len(rows) // 2]
    height, width = depth.shape
    x, y = (column + 0.5) / width, 1 - (row + 0.5) / height
    with bpy.context.temp_override(window=window(), area=area(), region=region()):
        bpy.ops.rack_focus.view_focus(x=x, y=y)
    FOUND["clicked"] = scene.camera.data.dof.focus_distance
    FOUND["clicked_depth"] = float(seen[row, column])
    yield from settle()
    for name in ("DEPTH", "COC", "FOCUS"):
        settings().show = name
        yield from settle()
        yield from screenshot(name.lower())
        FOUND[f"std_{name}"] = float(shown()[..., :3].std())
    settings().show = "PICTURE"
    yield from playback(scene)
    yield from freely(scene, data)
    yield from modes(scene, space)
    yield from off()


def playback(scene):
    """The picture follows the animation of the focus."""
    dof = scene.camera.data.dof
    for frame, distance in ((1, 1.5), (10, 9)):
        dof.focus_distance = distance
        dof.keyframe_insert("focus_distance", frame=frame)
    pictures = []
    for frame in (1, 10):
        scene.frame_set(frame)
        yield from settle()
        pictures.append(shown())
    FOUND["playback_changes"] = float(np.abs(pictures[0] - pictures[1]).max())
    scene.camera.data.animation_data_clear()
    dof.focus_distance = 2


def freely(scene, data):
    """Seen freely: orbiting redraws, a click stays in focus from elsewhere."""
    data.view_perspective = "PERSP"
    data.view_location = (0, 3, 0)
    data.view_distance = 4
    pictures = []
    for angle in (0.2, 0.6):
        data.view_rotation = _looking(angle)
        yield from settle()
        pictures.append(shown())
    FOUND["orbit_changes"] = float(np.abs(pictures[0] - pictures[1]).max())
    yield from screenshot("free")
    depth = np.array(view().depth)
    rows = np.argwhere(depth < 1)
    row, column = rows[len(rows) // 3]
    height, width = depth.shape
    with bpy.context.temp_override(window=window(), area=area(), region=region()):
        bpy.ops.rack_focus.view_focus(
            x=(column + 0.5) / width, y=1 - (row + 0.5) / height
        )
    point = settings().point.copy()
    planar = addon("viewport_lens").planar_depth(data.window_matrix, depth)
    FOUND["point_error"] = abs(
        -(data.view_matrix @ point).z / float(planar[row, column]) - 1
    )
    data.view_perspective = "ORTHO"
    yield from settle()
    FOUND["ortho_message"] = view().message
    FOUND["ortho_std"] = float(shown()[..., :3].std())
    yield from screenshot("ortho")
    data.view_perspective = "CAMERA"
    settings().has_point = False


def _looking(angle):
    """A rotation that looks along +y, turned by an angle about z."""
    from mathutils import Euler

    return Euler((math.pi / 2, 0, angle)).to_quaternion()


def modes(scene, space):
    """Material preview and rendered; what Cycles shows cannot be had."""
    scene.render.engine = (
        "BLENDER_EEVEE_NEXT"
        if (4, 2, 0) <= bpy.app.version < (5, 0, 0)
        else "BLENDER_EEVEE"
    )
    settings().percentage = 15
    for kind in ("MATERIAL", "RENDERED"):
        space.shading.type = kind
        try:
            yield from settle()
        except AssertionError:  # shaders that are still being made
            FOUND[f"{kind}_message"] = view().message
            yield from screenshot(kind.lower())
            continue
        FOUND[f"{kind}_message"] = view().message
        FOUND[f"{kind}_std"] = float(shown()[..., :3].std())
        yield from screenshot(kind.lower())
    scene.render.engine = "CYCLES"
    yield from settle()
    FOUND["cycles_message"] = view().message
    FOUND["cycles_has_picture"] = view().texture is not None
    space.shading.type = "SOLID"


def off():
    """No handler is left, and the view is as before."""
    settings().enabled = False
    yield 1
    FOUND["handlers_after"] = addon("viewport")._handler is None
    FOUND["views_after"] = len(addon("viewport")._views)
    FOUND["overlays"] = area().spaces.active.overlay.show_overlays
    yield from screenshot("off_again")


_session = steps()


def advance():
    """One step; at the end or after a failure Blender closes."""
    try:
        return next(_session)
    except StopIteration:
        FOUND["done"] = True
    except Exception:
        FOUND["failure"] = traceback.format_exc()
        print(FOUND["failure"], flush=True)
    (OUT / "viewport.json").write_text(json.dumps(FOUND, indent=1))
    sys.stdout.flush()
    os._exit(0)


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(advance, first_interval=1.5, persistent=True)
