# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of Grease Pencil, which Blender draws over a finished render.

stroke_checks.py DIST OUT [CHECK ...]    writes OUT/stroke_results.json

It needs a display: without one Blender draws no strokes.
"""

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import (
    OUT,
    Checks,
    heard,
    refocused,
    shot,
    tree_with_output,
    update,
)  # noqa: E402
from common import addon, last_message, render, rgba, same, start  # noqa: E402

check = Checks()
BLURRED = "Grease Pencil is blurred"
IS_SEPARATE = "use_pass_grease_pencil" in bpy.types.ViewLayer.bl_rna.properties


def draw(name, points, radius):
    """A stroke of one colour through points."""
    is_new = bpy.app.version >= (4, 3, 0)
    kinds = ("grease_pencils_v3", "grease_pencils")
    owner = next(getattr(bpy.data, k) for k in kinds if hasattr(bpy.data, k))
    data = owner.new(name)
    frame = data.layers.new("lines").frames.new(1)
    if is_new:
        frame.drawing.add_strokes([len(points)])
        (stroke,) = frame.drawing.strokes
    else:
        stroke = frame.strokes.new()
        stroke.line_width = round(2000 * radius)
        stroke.points.add(len(points))
    for point, place in zip(stroke.points, points, strict=True):
        if is_new:
            point.position, point.radius, point.opacity = place, radius, 1
        else:
            point.co, point.pressure, point.strength = place, 1, 1
    material = bpy.data.materials.new(name)
    bpy.data.materials.create_gpencil_data(material)
    material.grease_pencil.color = (0.8, 0.1, 0.1, 1)
    data.materials.append(material)
    found = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(found)
    return found


def near_and_far():
    """Strokes before and behind the focus; the scene."""
    draw("near", [(-0.3 + 0.1 * i, 1.4, 0.1 - 0.04 * i) for i in range(7)], 0.02)
    draw("far", [(-2 + 0.5 * i, 8, -1 + 0.2 * i) for i in range(9)], 0.15)
    update()
    return bpy.context.scene


def strokes_of(scene):
    """(height, width, 4) of the strokes as Blender draws them, premultiplied."""
    layer = scene.view_layers[0]
    layer.use_pass_grease_pencil = True
    channels = render(scene, OUT / "pen.exr", True)
    layer.use_pass_grease_pencil = False
    name = "GreasePencil" if bpy.app.version < (5, 0, 0) else "Grease Pencil"
    return np.stack([channels[f"ViewLayer.{name}.{c}"] for c in "RGBA"], -1)


@check
def strokes_stay_sharp():
    """One view, several, supersampled, refocused, kept: strokes as Blender draws them."""
    if not IS_SEPARATE:
        return
    scene = near_and_far()
    layer, settings = scene.view_layers[0], scene.camera.data.rack_focus
    for has_depth, about in (
        (False, {}),
        (True, {}),
        (True, {"views": 2}),
        (False, {"supersample": 2}),
    ):
        settings.enabled, layer.use_pass_z = False, has_depth
        pen = strokes_of(scene)
        assert (pen[..., 3] > 0.9).mean() > 0.02
        start(method="layered", **{"views": 1, "supersample": 1} | about)
        if "views" in about:
            settings.method = "views"
        layer.use_grease_pencil = False
        without = shot(scene, "without.exr")
        layer.use_grease_pencil = True
        settings.passes_folder = str(OUT / "pen_kept")
        made = shot(scene, "strokes.exr")
        settings.passes_folder = ""
        assert not last_message(scene), last_message(scene)
        expected = without * (1 - pen[..., 3:]) + pen
        assert np.abs(made - expected).max() < 1e-5, np.abs(made - expected).max()
        same(refocused(scene, "strokes.exr"), made)
        assert layer.use_grease_pencil and not layer.use_pass_grease_pencil
        assert len(bpy.data.scenes) == 2
        files = addon("keep").KeptFiles(scene, OUT / "pen_kept", scene.frame_current)
        lines = files.views("ViewLayer")[0][0].lines
        scale = len(lines) // len(pen)
        same(lines[::scale, ::scale], pen)
    assert not addon("strokes").describe(scene)


@check
def a_pass_of_another_name_is_told():
    """A Blender that calls it otherwise would leave the strokes out, without a word."""
    if not IS_SEPARATE:
        return
    scene, strokes = near_and_far(), addon("strokes")
    start()
    known, strokes.CHANNELS = strokes.CHANNELS, ("Pen",)
    try:
        with heard() as said:
            shot(scene, "strokes.exr")
    finally:
        strokes.CHANNELS = known
    assert "Grease Pencil is missing" in said.getvalue(), said.getvalue()


@check
def strokes_of_an_animation():
    """Each frame has its own."""
    if not IS_SEPARATE:
        return
    scene = near_and_far()
    near = bpy.data.objects["near"]
    for frame, x in ((1, 0.0), (2, 0.2)):
        near.location.x = x
        near.keyframe_insert("location", frame=frame)
    start()
    scene.frame_start, scene.frame_end = 1, 2
    common.set_output(scene, OUT / "stroke_#.exr")
    bpy.ops.render.render(animation=True, scene=scene.name)
    frames = [rgba(common.read(OUT / f"stroke_{i}.exr")) for i in (1, 2)]
    for number, made in enumerate(frames, 1):
        scene.frame_set(number)
        same(shot(scene, "strokes.exr"), made)
    assert np.abs(frames[0] - frames[1]).max() > 0.3


@check
def strokes_that_are_blurred_are_told():
    """Before Blender 4.5, and where the artist has the pass; not of a layer aside."""
    scene = near_and_far()
    if IS_SEPARATE:
        scene.view_layers[0].use_pass_grease_pencil = True
    start()
    update()
    assert any(BLURRED in line for line in addon("strokes").describe(scene))
    with heard() as said:
        shot(scene, "strokes.exr")
    assert BLURRED in said.getvalue(), said.getvalue()
    for item in (bpy.data.objects["near"], bpy.data.objects["far"]):
        item.hide_render = True
    assert not addon("strokes").describe(scene)


@check
def strokes_in_a_layer_of_their_own():
    """What the artist lays over by a node of the scene's own stays as it is."""
    scene = near_and_far()
    layers = [scene.view_layers[0], scene.view_layers.new("pen")]
    for number, (layer, name) in enumerate(zip(layers, ("cubes", "pen"), strict=True)):
        group = bpy.data.collections.new(name)
        scene.collection.children.link(group)
        for item in list(scene.collection.objects):
            is_pen = item.type in ("GPENCIL", "GREASEPENCIL")
            if is_pen == bool(number) and item.type != "CAMERA":
                group.objects.link(item)
                scene.collection.objects.unlink(item)
    layers[0].layer_collection.children["pen"].exclude = True
    layers[1].layer_collection.children["cubes"].exclude = True
    scene.render.film_transparent = True
    tree, node, output = tree_with_output(scene)
    start()
    plain = next(n for n in tree.nodes if n.type == "R_LAYERS" and n.scene == scene)
    plain.layer = "pen"
    tree.links.new(plain.outputs["Image"], output)
    made = shot(scene, "strokes.exr")
    assert (made[..., 3] == 1).mean() > 0.02
    assert not addon("strokes").are_taken(scene)


checking.run(check, "stroke_results.json")
