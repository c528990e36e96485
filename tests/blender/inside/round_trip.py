# SPDX-License-Identifier: GPL-3.0-or-later
"""Ticked, rendered, refocused, saved, opened and unticked: what is left of a file.

For files that walk_checks.py makes, and for those of others:

    round_trip.py DIST OUT FILE.blend ...    (after -- where Blender is a program)

with the settings that ROUND_TRIP has as JSON, {"views": 3}, prints a line for each file, ok or what went wrong.
"""

import json
import os
import sys
import traceback
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
from common import addon, rgba  # noqa: E402

# What rendering itself changes, or what is counted in this session only.
PASSING = ("session_u", "is_", "bl_", "frame_float", "tag", "last_")


LEFT_OUT = ["users", "rna_type", "filepath", "use_extra_user"]
if common.V < (5, 0, 0):
    LEFT_OUT.append("node_tree")  # once made, Blender lets no script take it away


def plain_values(owner):
    """[(name, value)] of an RNA struct's own plain properties."""
    found = []
    for about in owner.bl_rna.properties:
        name = about.identifier
        if name.startswith(PASSING) or name in LEFT_OUT:
            continue
        value = getattr(owner, name, None)
        if isinstance(value, bool | int | float | str):
            found.append((name, value))
        elif getattr(about, "is_array", False):
            found.append((name, tuple(np.ravel(value))))
        elif isinstance(value, bpy.types.ID):
            found.append((name, value.name_full))
    return sorted(found)


def state_of_tree(tree):
    """Nodes with their values and links of a compositor tree and its groups."""
    found = []
    for node in sorted(tree.nodes, key=lambda n: n.name):
        # Blender keeps those of passes that are off again, unseen.
        sockets = [s.name for s in (*node.inputs, *node.outputs) if s.enabled]
        found.append((node.name, plain_values(node), sockets))
    ends = [
        (k.from_node.name, k.from_socket.name, k.to_node.name, k.to_socket.name)
        for k in tree.links
    ]
    return found, sorted(ends)


def state_of_file():
    """Everything that Rack Focus could change: {what: values}."""
    found = {"counts": {k: n for k, n in common.counts().items() if k != "images"}}
    for scene in bpy.data.scenes:
        name = f"scene {scene.name}"
        owners = [scene, scene.render, scene.render.image_settings]
        owners += [scene.cycles] if hasattr(scene, "cycles") else []
        owners += list(scene.render.views) + list(scene.timeline_markers)
        found[name] = [plain_values(owner) for owner in owners]
        for layer in scene.view_layers:
            found[f"{name} {layer.name}"] = plain_values(layer)
        tree = common.tree_of(scene)
        found[f"{name} nodes"] = state_of_tree(tree) if tree is not None else None
    for data in bpy.data.cameras:
        owners = (data, data.dof)
        found[f"camera {data.name_full}"] = [plain_values(owner) for owner in owners]
    for item in [o for o in bpy.data.objects if o.users]:  # others are not saved
        places = tuple(np.ravel(item.matrix_basis)), item.parent and item.parent.name
        found[f"object {item.name_full}"] = places
    return found


def differences(before, after):
    """What differs, in words."""
    keys = sorted({*before, *after})
    found = [k for k in keys if before.get(k) != after.get(k)]
    return [f"{k}: {first_difference(before.get(k), after.get(k))}" for k in found]


def is_named(values):
    """Are they pairs of a name and a value?"""
    pairs = [v for v in values if isinstance(v, tuple) and len(v) == 2]
    return len(pairs) == len(values) and all(isinstance(v[0], str) for v in pairs)


def first_difference(a, b):
    """The innermost first pair that differs."""
    if type(a) is type(b) and isinstance(a, list | tuple):
        names = [
            dict(x) if isinstance(x, list) and is_named(x) else None for x in (a, b)
        ]
        if None not in names and a != b:
            keys = sorted({*names[0], *names[1]})
            other = [(k, names[0].get(k), names[1].get(k)) for k in keys]
            return str([o for o in other if o[1] != o[2]])[:400]
        for one, other in zip(a, b, strict=False):
            if one != other:
                return first_difference(one, other)
    return f"{a!r:.200} -> {b!r:.200}"


def render_of(scene, path):
    """(height, width, 4) of a render; None where Blender itself renders nothing."""
    common.set_output(scene, path)
    Path(path).unlink(missing_ok=True)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return rgba(common.read(path)) if Path(path).exists() else None


def make_small(scene):
    """Quick and the same every time."""
    render = scene.render
    common.set_up_cycles(scene, samples=1)
    factor = 64 / max(render.resolution_x, render.resolution_y)
    render.resolution_x = max(int(render.resolution_x * factor), 8)
    render.resolution_y = max(int(render.resolution_y * factor), 8)
    render.resolution_percentage = 100
    render.use_simplify, render.simplify_subdivision_render = True, 0
    render.use_motion_blur = False
    if scene.camera is None or scene.camera.type != "CAMERA":
        data = bpy.data.cameras.new("added")
        scene.camera = bpy.data.objects.new("added", data)
        scene.camera.location = (0, -10, 2)
        scene.camera.rotation_euler = (1.4, 0, 0)
        scene.collection.objects.link(scene.camera)
    if scene.camera.data.dof.focus_distance < 1e-3:  # never set, in files of 2.7x
        scene.camera.data.dof.focus_distance = 5


def problems_of_picture(scene, made, plain):
    """What is wrong with a filtered picture beside the plain one."""
    found = []
    message = addon("engine").last_run.get(scene.name, {}).get("message", "")
    if message:
        found.append(f"message: {message}")
    if made is None or not np.isfinite(made[np.isfinite(plain)]).all():
        return [*found, "no picture, or not finite"]
    a, b = made[..., :3].mean(), plain[np.isfinite(plain)].mean()
    if not found and b > 0.01 and a < 0.3 * plain[..., :3].mean():
        found.append(f"dark: {a} against {b}")
    return found


def trip(scene, folder, reopen=True):
    """All steps with a scene of the open file; returns what went wrong."""
    name, found = scene.name, []
    scene.camera.data.dof.use_dof = False
    for data in bpy.data.cameras:
        data.rack_focus.enabled = False
    bpy.context.view_layer.update()
    plain = render_of(scene, folder / "plain.exr")
    if plain is None:
        return ["Blender renders nothing"]
    again = render_of(scene, folder / "plain.exr")
    before = state_of_file()
    for key, value in json.loads(os.environ.get("ROUND_TRIP", "{}")).items():
        setattr(scene.camera.data.rack_focus, key, value)
    scene.camera.data.rack_focus.enabled = True
    if scene.camera.data.type == "PERSP":
        scene.camera.data.dof.aperture_fstop = 0.5
    made = render_of(scene, folder / "made.exr")
    found += problems_of_picture(scene, made, plain)
    if made is not None and not found and addon("setup").can_mute_sources(scene):
        bpy.ops.rack_focus.refocus()
        message = addon("engine").last_run[name]["message"]
        found += [f"refocus: {message}"] if message else []
    if reopen:
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / "trip.blend"), copy=True)
        bpy.ops.wm.open_mainfile(filepath=str(folder / "trip.blend"))
        scene = bpy.data.scenes[name]
        opened = render_of(scene, folder / "made.exr")
        if not found and np.array_equal(plain, again):
            if not np.array_equal(opened, made, equal_nan=True):
                found.append("the opened file renders another picture")
    scene.camera.data.rack_focus.enabled = False
    bpy.context.view_layer.update()
    after = state_of_file()
    for state in (before, after):  # set by the trip itself
        state.pop(f"camera {scene.camera.data.name_full}", None)
    if reopen:  # what had no user is not saved
        before.pop("counts"), after.pop("counts")
    found += differences(before, after)
    last = render_of(scene, folder / "plain.exr")
    if np.array_equal(plain, again, equal_nan=True):
        if not np.array_equal(plain, last, equal_nan=True):
            found.append("unticked, the picture is another one")
    return found


def main():
    """Every scene with a render of each file."""
    dist, out, *files = sys.argv[sys.argv.index("--") + 1 :]
    common.install(dist)
    for file in files:
        try:
            bpy.ops.wm.open_mainfile(filepath=file)
            scene = bpy.context.scene
            make_small(scene)
            found = trip(scene, Path(out))
        except Exception:
            found = [traceback.format_exc()]
        print("TRIP", Path(file).name, "; ".join(found) or "ok", flush=True)
    common.leave()


if __name__ == "__main__":
    main()
