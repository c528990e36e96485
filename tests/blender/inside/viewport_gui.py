# SPDX-License-Identifier: GPL-3.0-or-later
"""A session with 3D views: the switch, the mouse, playback, the maps, every mode.

See stepping.py.
"""

import math
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
import stepping  # noqa: E402
from common import addon  # noqa: E402
from stepping import (  # noqa: E402
    DIST,
    FOUND,
    OUT,
    area_of,
    forbid_writing,
    hands,
    on_display,
    override,
    region_of,
    screenshot,
    until,
)

_drawn_at = 0.0  # when is_settled() asked for it last


def area():
    """The 3D view."""
    return area_of("VIEW_3D")


def region():
    """Its main region."""
    return region_of(area())


def settings():
    """The settings of the views."""
    return bpy.context.window_manager.rack_focus_view


def view():
    """What the add-on keeps of the region."""
    return addon("viewport").view_of(region())


def is_settled():
    """Is the picture of the view the final one, of what is there?

    Draws once a second: more is what the processor would have less for shaders.
    """
    global _drawn_at
    if time.monotonic() > _drawn_at + 1:
        area().tag_redraw()
        _drawn_at = time.monotonic()
    return view() and view().is_final and (view().texture or view().message)


def settle():
    """Until the picture of the view is the final one, and shown."""
    if view():
        view().is_final = False
    area().tag_redraw()
    yield 0.4
    yield from until(is_settled, "the final picture", 0.1)
    yield 0.2


def shown():
    """The picture on the view, (height, width, 4), rows downwards."""
    return np.array(view().picture)


def change(a, b):
    """The largest difference of two pictures."""
    return float(np.abs(a - b).max())


def planar():
    """Planar distances that the view shows, (height, width), rows downwards."""
    matrix = area().spaces.active.region_3d.window_matrix
    return addon("viewport_lens").planar_depth(matrix, np.array(view().depth))


def make_scene():
    """The cubes of the other tests, larger, one much brighter than white."""
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
    yield from forbid_writing()
    scene = make_scene()
    space = area().spaces.active
    data = space.region_3d
    yield 0.5
    data.view_perspective = "CAMERA"
    yield 1
    FOUND["handlers_before"] = len(addon("viewport")._handlers)
    yield from screenshot("off")
    settings().percentage = 100
    settings().enabled = True
    yield from settle()
    near = shown()
    yield from screenshot("camera_near")
    FOUND["place"] = [*on_display(region(), 0, region().height - 1)]
    FOUND["message"] = view().message
    distances = planar()
    hits = distances[np.isfinite(distances)]
    FOUND["nearest"], FOUND["farthest"] = float(hits.min()), float(hits.max())
    keep("solid")
    # Another lens.
    scene.camera.data.dof.focus_distance = 9
    bpy.context.view_layer.update()
    yield from settle()
    FOUND["focus_changes"] = change(near, shown())
    yield from screenshot("camera_far")
    yield from early(scene.camera.data.dof)
    yield from click(scene)
    for name in ("DEPTH", "COC", "FOCUS"):
        settings().show = name
        yield from settle()
        yield from screenshot(name.lower())
        FOUND[f"std_{name}"] = float(shown()[..., :3].std())
    settings().show = "PICTURE"
    yield from playback(scene)
    yield from freely(data)
    yield from modes(scene, space)
    yield from off()


def keep(name):
    """What was filtered and what came of it, for the command: OUT/NAME.npz."""
    seen = view()
    np.savez(OUT / f"{name}.npz", colour=seen.colour, depth=seen.depth, picture=shown())
    FOUND[f"{name}_params"] = seen.params


def click(scene):
    """A click of the mouse: the focus is on the depth that is seen there."""
    yield from settle()
    distances = planar()
    places = np.argwhere(distances < 2.5)
    row, column = places[len(places) // 2]
    height, width = distances.shape
    x, y = column + 0.5, height - row - 0.5
    dof = scene.camera.data.dof
    before = dof.focus_distance
    with override(area()):
        bpy.ops.rack_focus.view_focus("INVOKE_DEFAULT")
    yield 0.3
    yield from hands("mousemove", *on_display(region(), x, y), "sleep", 0.3, "click", 1)
    yield from until(lambda: dof.focus_distance != before, "the focus of the click")
    around = distances[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
    FOUND["clicked"] = dof.focus_distance
    FOUND["clicked_range"] = [float(around.min()), float(around.max())]
    yield from settle()


def playback(scene):
    """Frames that are played are shown; each is what it is when frames are set."""
    dof = scene.camera.data.dof
    scene.frame_start, scene.frame_end = 1, 10
    for frame, distance in ((1, 1.5), (10, 9)):
        dof.focus_distance = distance
        dof.keyframe_insert("focus_distance", frame=frame)
    pictures = []
    for frame in (1, 10):
        scene.frame_set(frame)
        yield from settle()
        pictures.append(shown())
    FOUND["frames_change"] = change(*pictures)
    focus_of = {}  # frame: focus of the picture that was shown with it

    def has_seen_enough():
        focus_of[view().frame_shown] = view().params["focus_distance"]
        return len(focus_of) > 5

    with override(area()):
        bpy.ops.screen.animation_play()
    yield from until(has_seen_enough, "the frames that play", 0.02)
    bpy.ops.screen.animation_cancel(restore_frame=False)
    errors = []
    for frame, focus in focus_of.items():
        scene.frame_set(frame)
        errors.append(abs(dof.focus_distance - focus))
    FOUND["frames_played"], FOUND["playback_error"] = len(errors), max(errors)
    scene.camera.data.animation_data_clear()
    dof.focus_distance = 2


def watch_depth():
    """{is final: the depth that was found last}, filled from now on."""
    found = {}
    kind = type(view())
    find = kind.find_depth

    def find_and_note(self, context, size, is_final):
        find(self, context, size, is_final)
        found[is_final] = np.array(self.depth)

    kind.find_depth = find_and_note
    return found


def early(dof):
    """A depth that the engine has not drawn yet is none, and is looked for again."""
    kind, focus, depths = type(view()), dof.focus_distance, []
    find, left = kind.find_depth, [2]  # until the exact one came so often

    def find_late(self, context, size, is_final):
        find(self, context, size, is_final)
        if left[0] > 0:
            self.depth = np.zeros_like(self.depth)
            left[0] -= self.is_exact

    for found in (find_late, find):
        kind.find_depth = found
        for distance in (focus, focus + 1)[found is find_late :]:
            dof.focus_distance = distance
            bpy.context.view_layer.update()
            yield from settle()
        depths.append(np.array(view().depth))
    FOUND["early_left"], FOUND["early_off"] = left[0], change(*depths)
    dof.focus_distance = focus


def check_depth(found):
    """While it moved and at rest, against what was drawn, where alpha tells of it."""
    moving, final = found[False], found[True]
    is_drawn = np.array(view().colour)[..., 3] > 0
    FOUND["depth_of_nothing"] = float(((final < 1) & ~is_drawn).mean())
    FOUND["moving_depth_of_nothing"] = float(((moving < 1) & ~is_drawn).mean())
    FOUND["moving_depth_same"] = float((abs(moving - final) < 1e-5)[is_drawn].mean())
    FOUND["share_drawn"] = float(is_drawn.mean())


def freely(data):
    """Seen freely: the mouse turns the view, a point stays in focus from elsewhere."""
    data.view_perspective = "PERSP"
    data.view_location = (0, 3, 0)
    data.view_distance = 4
    data.view_rotation = Euler((1.3, 0, 0.2)).to_quaternion()
    found = watch_depth()
    yield from settle()
    before, turned = shown(), data.view_rotation.copy()
    x, y = on_display(region(), region().width / 2, region().height / 2)
    yield from hands("mousemove", x, y, "sleep", 0.3, "mousedown", 2)
    for i in range(1, 9):
        yield from hands("mousemove", x + 8 * i, y)
        yield 0.05
    yield from hands("mouseup", 2)
    yield from until(lambda: data.view_rotation != turned, "the turn of the view")
    yield from settle()
    FOUND["orbit_changes"] = change(before, shown())
    check_depth(found)
    yield from screenshot("free")
    depth = np.array(view().depth)
    rows = np.argwhere(depth < 1)
    row, column = rows[len(rows) // 3]
    height, width = depth.shape
    with override(area()):
        bpy.ops.rack_focus.view_focus(
            x=(column + 0.5) / width, y=1 - (row + 0.5) / height
        )
    point = settings().point.copy()
    FOUND["point_error"] = abs(
        -(data.view_matrix @ point).z / float(planar()[row, column]) - 1
    )
    data.view_perspective = "ORTHO"
    yield from settle()
    FOUND["ortho_message"] = view().message
    yield from screenshot("ortho")
    data.view_perspective = "CAMERA"
    settings().has_point = False


def modes(scene, space):
    """Material Preview and Rendered, by EEVEE and by Cycles."""
    is_next = (4, 2, 0) <= bpy.app.version < (5, 0, 0)
    eevee = "BLENDER_EEVEE_NEXT" if is_next else "BLENDER_EEVEE"
    settings().percentage = 50
    scene.cycles.preview_samples = 8
    scene.eevee.taa_samples = 3  # each is drawn by the processor
    if hasattr(scene.eevee, "use_shadows"):  # since 4.2, where nothing throws one
        scene.eevee.use_shadows = False
    for name, kind, engine in (
        ("material", "MATERIAL", eevee),
        ("rendered", "RENDERED", eevee),
        ("cycles", "RENDERED", "CYCLES"),
    ):
        scene.render.engine = engine
        space.shading.type = kind
        pictures = []
        for distance in (1.5, 9):
            scene.camera.data.dof.focus_distance = distance
            bpy.context.view_layer.update()
            yield from settle()
            pictures.append(shown())
        FOUND[f"{name}_message"] = view().message
        FOUND[f"{name}_std"] = float(pictures[1][..., :3].std())
        FOUND[f"{name}_changes"] = change(*pictures)
        FOUND[f"{name}_brightest"] = float(view().colour[..., :3].max())
        keep(name)
        yield from screenshot(name)
        for overlays in (False, True):  # a depth also where overlays are off
            space.overlay.show_overlays = overlays
            yield from settle()
        FOUND[f"{name}_same"] = change(
            view().depth, np.load(OUT / f"{name}.npz")["depth"]
        )
    space.shading.type = "SOLID"


def off():
    """No handler is left, and the view is as before."""
    FOUND["contexts"] = len(addon("viewport")._contexts)
    settings().enabled = False
    yield 1
    FOUND["contexts_after"] = len(addon("viewport")._contexts)
    FOUND["handlers_after"] = len(addon("viewport")._handlers)
    FOUND["views_after"] = len(addon("viewport")._views)
    FOUND["overlays"] = area().spaces.active.overlay.show_overlays
    yield from screenshot("off_again")


stepping.play(steps(), is_smooth=True)
