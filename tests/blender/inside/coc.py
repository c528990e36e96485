# SPDX-License-Identifier: GPL-3.0-or-later
"""Radius of the blur of a bright square: Cycles' own lens beside ours.

    coc.py DIST OUT    writes OUT/coc.json: [{case, predicted, cycles, filtered}, ...]

A square before a black plate at the same depth, all parallel to the picture. Its light
spreads over an ellipse with the half-axes a and b; the variances of the blurred picture
exceed those of the sharp one by a^2/4 and b^2/4, whatever the shape of the square.
`predicted` is what the add-on reads from the camera (half-axes in px, x and y), the
other two are measured in the pictures; ours as the mean over places of the square: at
reduced resolution its place in the blocks of up to 8 px changes the half-axis of a
narrow ellipse by up to 5 %.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
from common import addon, rgba  # noqa: E402

DIST, OUT = (Path(a) for a in sys.argv[sys.argv.index("--") + 1 :][:2])
FOCUS, DEPTH = 1.0, 2.0
SAMPLES = 256  # of the blur of Cycles itself
SHARP_SAMPLES = 32  # of what has no blur but of its edges, and is filtered
N_PLACES = 8

CASES = {}


def case(function):
    """Registers a case: a function that changes (scene, camera object)."""
    CASES[function.__name__] = function
    return function


@case
def landscape(scene, camera):
    """96 x 64."""


@case
def portrait(scene, camera):
    """64 x 96: the sensor's width lies along the height."""
    scene.render.resolution_x, scene.render.resolution_y = 64, 96


@case
def fit_horizontal_in_portrait(scene, camera):
    """The sensor's width along the width."""
    portrait(scene, camera)
    camera.data.sensor_fit = "HORIZONTAL"


@case
def fit_vertical(scene, camera):
    """The sensor's height along the height."""
    camera.data.sensor_fit = "VERTICAL"
    camera.data.sensor_height = 20


@case
def shift(scene, camera):
    """Lens shift in both directions."""
    camera.data.shift_x, camera.data.shift_y = 0.2, 0.1


@case
def ratio_half(scene, camera):
    """Twice as wide."""
    camera.data.dof.aperture_ratio = 0.5


@case
def ratio_two(scene, camera):
    """Half as wide."""
    camera.data.dof.aperture_ratio = 2.0


@case
def orthographic(scene, camera):
    """The lens of an orthographic camera has the radius 1 / (2 N)."""
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = 6
    camera.data.dof.aperture_fstop = 0.8


@case
def orthographic_portrait(scene, camera):
    """The scale lies along the longer side."""
    portrait(scene, camera)
    orthographic(scene, camera)


@case
def percentage_75(scene, camera):
    """The blur shrinks with the picture."""
    scene.render.resolution_percentage = 75


@case
def focus_object(scene, camera):
    """The planar distance of an object off the axis; the stored one is ignored."""
    target = bpy.data.objects.new("target", None)
    scene.collection.objects.link(target)
    target.location = (0.5, FOCUS, 0.3)
    camera.data.dof.focus_object = target
    camera.data.dof.focus_distance = 5


@case
def unit_scale_hundredth(scene, camera):
    """Cycles does not apply the scene's unit scale."""
    scene.unit_settings.scale_length = 0.01


@case
def camera_scaled(scene, camera):
    """The scale of the object counts for nothing."""
    camera.scale = (3, 3, 3)


@case
def camera_parented(scene, camera):
    """A turned, scaled parent."""
    parent = bpy.data.objects.new("parent", None)
    scene.collection.objects.link(parent)
    parent.scale = (2, 2, 2)
    parent.rotation_euler = (0.3, 0.2, 1.2)
    parent.location = (3, -2, 1)
    camera.parent = parent


@case
def telephoto(scene, camera):
    """Another focal length and sensor."""
    camera.data.lens, camera.data.sensor_width = 120, 50
    camera.data.dof.aperture_fstop = 0.6


@case
def in_millimetres(scene, camera):
    """Scenes in large units have f-stops below the filter's own least."""
    camera["units"] = 1000
    camera.data.dof.focus_distance = 1000 * FOCUS
    camera.data.dof.aperture_fstop = 0.16 / 1000
    camera.data.clip_end = 1e6


@case
def beyond_cycles_least(scene, camera):
    """Cycles takes 1e-5 for what is below it."""
    camera["units"] = 16000
    camera.data.dof.focus_distance = 16000 * FOCUS
    camera.data.dof.aperture_fstop = 1e-6
    camera.data.clip_end = 1e6


# ---- measuring --------------------------------------------------------------------


def quad(name, size, strength):
    """A square in the x-y plane that glows with a strength."""
    mesh = bpy.data.meshes.new(name)
    h = size / 2
    mesh.from_pydata(
        [(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)], [], [(0, 1, 2, 3)]
    )
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    glow, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    glow.inputs["Strength"].default_value = strength
    material.node_tree.links.new(glow.outputs[0], out.inputs["Surface"])
    mesh.materials.append(material)
    found = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(found)
    return found


def build(change):
    """The scene of a case; returns (scene, camera object)."""
    bpy.ops.wm.open_mainfile(filepath=str(OUT / "empty.blend"))
    scene = bpy.context.scene
    camera = scene.camera
    change(scene, camera)
    bpy.context.view_layer.update()
    turn, units = camera.matrix_world.normalized(), camera.get("units", 1)
    for name, size, strength, depth in (
        ("dot", 0.5 if camera.data.type == "ORTHO" else 0.12, 1, DEPTH),
        ("plate", 50, 0, DEPTH * 1.0001),
    ):
        item = quad(name, units * size, strength)
        item.matrix_world = turn @ Matrix.Translation((0, 0, -units * depth))
    return scene, camera


def variances(picture):
    """Variances of the light along x and y, px^2."""
    light = np.maximum(picture[..., 0].astype(np.float64), 0)
    found = []
    for axis in (0, 1):
        line = light.sum(axis)
        place = np.arange(len(line))
        mean = (line * place).sum() / line.sum()
        found.append((line * (place - mean) ** 2).sum() / line.sum())
    return np.array(found)


def filtered_variances(scene, channels):
    """What our filter adds to the variances, the mean over places in its blocks."""
    colour, depth = rgba(channels, "ViewLayer"), common.depth_of(channels)
    added = []
    for step in range(N_PLACES):
        moved, moved_depth = (np.roll(p, (step, step), (0, 1)) for p in (colour, depth))
        ours = common.filtered(scene, moved, moved_depth)
        added.append(variances(ours) - variances(moved))
    return np.mean(added, 0)


def measure(name):
    """One line of the table."""
    scene, camera = build(CASES[name])
    data = camera.data
    scene.cycles.samples = SHARP_SAMPLES
    channels = common.pinhole(scene, OUT / "c.exr")
    sharp = rgba(channels, "ViewLayer")
    data.dof.use_dof = True
    scene.cycles.samples = SAMPLES
    physical = variances(rgba(common.render(scene, OUT / "c.exr"))) - variances(sharp)
    data.rack_focus.enabled, data.rack_focus.supersample = True, 1
    scene.cycles.samples = SHARP_SAMPLES
    node = rgba(common.render(scene, OUT / "c.exr"))
    expected = common.filtered(scene, sharp, common.depth_of(channels))
    assert np.array_equal(node, expected), name
    ours = filtered_variances(scene, channels)
    lens_module = addon("lens")
    size = lens_module.picture_size(scene.render)
    params = lens_module.frame_parameters(camera, data.rack_focus, scene.render, size)
    depth = DEPTH * camera.get("units", 1)
    radius = addon("library").rackfocus.Lens(*size, **params).radius_px(depth)
    return {
        "case": name,
        "predicted": [radius / data.dof.aperture_ratio, radius],
        "cycles": list(2 * np.sqrt(np.maximum(physical, 0))),
        "filtered": list(2 * np.sqrt(np.maximum(ours, 0))),
    }


def make_empty():
    """A black world and the camera; saved."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    scene = bpy.context.scene
    scene.world = None
    common.set_up_cycles(scene, SAMPLES)
    scene.render.resolution_x, scene.render.resolution_y = 96, 64
    scene.render.resolution_percentage = 100
    data = bpy.data.cameras.new("Camera")
    data.lens, data.sensor_width = 50, 36
    data.dof.focus_distance, data.dof.aperture_fstop = FOCUS, 0.16
    camera = bpy.data.objects.new("Camera", data)
    camera.rotation_euler = (np.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "empty.blend"))


def main():
    """Measures all cases."""
    common.install(DIST)
    make_empty()
    table = []
    for name in CASES:
        table.append(measure(name))
        print("COC", table[-1], flush=True)
        (OUT / "coc.json").write_text(json.dumps(table, indent=1))
    common.leave()


main()
