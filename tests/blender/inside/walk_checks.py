# SPDX-License-Identifier: GPL-3.0-or-later
"""Random walks over Blender's features; each file goes through a round trip.

walk_checks.py DIST OUT [CHECK ...]    writes OUT/walk_results.json
"""

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import round_trip  # noqa: E402
from checking import OUT, Checks  # noqa: E402
from common import addon  # noqa: E402

check = Checks()

# ---- steps of a walk --------------------------------------------------------------


def add_layer(scene, rng):
    """A view layer; one of them may be off."""
    layer = scene.view_layers.new(f"layer {rng.integers(100)}")
    layer.use = bool(rng.integers(2))
    scene.render.film_transparent = bool(rng.integers(2))


def add_nodes(scene, rng):
    """A chain of nodes between the render and the output."""
    tree, _ = addon("compat").start_compositor(scene)
    out = addon("compat").output_socket(tree)
    last = out.links[0].from_socket if out.is_linked else None
    kinds = ("Blur", "Exposure", "Denoise", "Flip")
    for kind in rng.choice(kinds, rng.integers(1, 4)) if last is not None else ():
        node = tree.nodes.new(f"CompositorNode{kind}")
        node.location = rng.uniform(-400, 800, 2)
        node.mute = bool(rng.integers(4) == 0)
        tree.links.new(last, node.inputs["Image"])
        last = node.outputs["Image"]
    if last is not None:
        tree.links.new(last, out)


def add_viewer(scene, _rng):
    """A Viewer on the depth."""
    tree, _ = addon("compat").start_compositor(scene)
    node = tree.nodes.new("CompositorNodeViewer")
    sources = [n for n in tree.nodes if n.type == "R_LAYERS"]
    if sources:
        tree.links.new(sources[0].outputs["Alpha"], node.inputs["Image"])


def add_group(scene, _rng):
    """The render goes through a group that does nothing."""
    tree, _ = addon("compat").start_compositor(scene)
    out = addon("compat").output_socket(tree)
    group = bpy.data.node_groups.new("pass", "CompositorNodeTree")
    for side in ("INPUT", "OUTPUT"):
        addon("compat").new_socket(group, "Image", side, "NodeSocketColor")
    begin, end = (group.nodes.new(f"NodeGroup{x}") for x in ("Input", "Output"))
    group.links.new(begin.outputs[0], end.inputs[0])
    node = tree.nodes.new("CompositorNodeGroup")
    node.node_tree = group
    if out.is_linked:
        tree.links.new(out.links[0].from_socket, node.inputs[0])
    tree.links.new(node.outputs[0], out)


def add_scene(scene, rng):
    """Another scene, new or a copy, that shares the camera."""
    if rng.integers(2):
        other = scene.copy()
    else:
        other = bpy.data.scenes.new("other")
        other.collection.objects.link(scene.camera)
    other.camera = scene.camera
    bpy.context.view_layer.update()


def add_markers(scene, rng):
    """Cameras bound to markers."""
    for frame in (1, 20):
        camera = scene.camera.copy()
        camera.data = scene.camera.data.copy()
        camera.location.x += rng.uniform(-0.1, 0.1)
        scene.collection.objects.link(camera)
        scene.timeline_markers.new("bound", frame=frame).camera = camera
    scene.camera = camera_at(scene, 1)


def camera_at(scene, frame):
    """The camera bound to a frame."""
    return next(m.camera for m in scene.timeline_markers if m.frame == frame)


def change_camera(scene, rng):
    """Orthographic, shifted, with another sensor or with blades."""
    data = scene.camera.data
    data.type = "ORTHO" if rng.integers(3) == 0 else "PERSP"
    data.ortho_scale = 3
    data.shift_x, data.shift_y = rng.uniform(-0.1, 0.1, 2)
    data.sensor_fit = str(rng.choice(("AUTO", "HORIZONTAL", "VERTICAL")))
    data.dof.aperture_blades = int(rng.choice((0, 5, 8)))


def focus_on_object(scene, rng):
    """A focus object that moves with a driver."""
    meshes = [o for o in scene.objects if o.type == "MESH"]
    scene.camera.data.dof.focus_object = meshes[rng.integers(len(meshes))]
    curve = scene.camera.data.dof.driver_add("aperture_fstop")
    curve.driver.expression = "0.3 + frame * 0"


def animate(scene, rng):
    """Keyframes on the focus, the lens and the camera."""
    data = scene.camera.data
    for frame, part in ((1, 0), (10, 1)):
        data.dof.focus_distance = 2 + part * rng.uniform(1, 3)
        data.dof.keyframe_insert("focus_distance", frame=frame)
        scene.camera.keyframe_insert("location", frame=frame)
    scene.frame_set(4)


def change_frame(scene, rng):
    """Border, crop, aspect."""
    render = scene.render
    render.use_border = True
    render.use_crop_to_border = bool(rng.integers(2))
    render.border_min_x, render.border_max_x = 0.2, 0.9
    render.border_min_y, render.border_max_y = 0.1, 0.8
    render.pixel_aspect_x = float(rng.choice((1, 1.5)))


def add_strip(scene, _rng):
    """A sequencer that is not used for the render."""
    scene.render.use_sequencer = False
    editor = scene.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    about = {"name": "colour", "type": "COLOR", "channel": 1, "frame_start": 1}
    try:
        strips.new_effect(**about, frame_end=20)
    except TypeError:  # 5.x
        strips.new_effect(**about, length=20)


def add_views(scene, rng):
    """More than one view of the lens."""
    scene.camera.data.rack_focus.views = int(rng.integers(2, 5))


def switch_passes(scene, rng):
    """Passes on and off."""
    for layer in scene.view_layers:
        layer.use_pass_z = bool(rng.integers(2))
        layer.use_pass_normal = bool(rng.integers(2))
        layer.use_pass_mist = bool(rng.integers(2))


def override_camera(scene, rng):
    """The camera comes from a library, as an override, with or without its data's."""
    path = str(checking.OUT / "walk_library.blend")
    bpy.data.libraries.write(path, {scene.camera}, fake_user=True)
    with bpy.data.libraries.load(path, link=True) as (_, found):
        found.objects = [scene.camera.name]
    linked = found.objects[0]
    scene.collection.objects.link(linked)
    camera = linked.override_create(remap_local_usages=True)
    data = camera.data
    if data.override_library is None:
        camera.data = data.override_create(remap_local_usages=True)
    scene.camera = camera


STEPS = (
    add_layer,
    add_nodes,
    add_viewer,
    add_group,
    add_scene,
    add_markers,
    change_camera,
    focus_on_object,
    animate,
    change_frame,
    add_strip,
    add_views,
    switch_passes,
)


def walk(seed, first=()):
    """A file from some steps in a random order, and its round trip.

    first: steps that come before the others.
    """
    rng = np.random.default_rng(seed)
    scene = bpy.context.scene
    scene.cycles.samples = 1
    taken = [STEPS[i] for i in rng.permutation(len(STEPS))[: rng.integers(3, 8)]]
    taken = [*first, *(step for step in taken if step not in first)]
    for step in taken:
        step(scene, rng)
    taken = [step.__name__ for step in taken]
    bpy.context.view_layer.update()
    found = round_trip.trip(scene, OUT)
    assert not found, (taken, found)


@check
def walks_0():
    """Four walks."""
    walks(range(4))


@check
def walks_4():
    """Four more."""
    walks(range(4, 8))


@check
def walks_8():
    """Four more."""
    walks(range(8, 12))


@check
def walks_12():
    """Four more."""
    walks(range(12, 16))


@check
def walks_with_an_override():
    """A linked camera, overridden, and some steps after it."""
    found = []
    for seed in range(100, 104):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        try:
            walk(seed, first=(override_camera,))
        except AssertionError as problem:
            found.append((seed, *problem.args))
    assert not found, found


def walks(seeds):
    """Walks from the base file; all are made, then what went wrong is said."""
    found = []
    for seed in seeds:
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        try:
            walk(seed)
        except AssertionError as problem:
            found.append((seed, *problem.args))
    assert not found, found


checking.run(check, "walk_results.json")
