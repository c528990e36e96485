# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the installed add-on, run inside Blender in the order of this file.

    checks.py DIST OUT    (after -- where Blender is a program)

DIST has the zips, OUT receives results.json: {check: "" or what went wrong}, and the
files that the tests look at.
"""

import json
import math
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
from common import (  # noqa: E402
    V,
    addon,
    filtered,
    last_message,
    pinhole,
    render,
    rgba,
    same,
    snapshot,
    start,
)

DIST, OUT = (Path(a) for a in sys.argv[sys.argv.index("--") + 1 :][:2])
BASE = OUT / "base.blend"
CHECKS = {}
DRAFT = {"quality": "custom", "sub_apertures": 1, "exact_highlights": False}


def check(function):
    """Registers a check; each starts with the base file."""

    def run():
        bpy.ops.wm.open_mainfile(filepath=str(BASE))
        function()

    CHECKS[function.__name__] = run
    return function


# ---- the picture ------------------------------------------------------------------


@check
def f12_is_the_filter_on_the_passes():
    """Bit for bit; the tests compare the files with the command as well."""
    scene, data = start(quality="custom")
    data.dof.aperture_blades = 6
    data.dof.aperture_rotation = 0.3
    data.dof.aperture_ratio = 1.5
    sharp = pinhole(scene, OUT / "passes.exr")
    made = rgba(render(scene, OUT / "filtered.exr"))
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    same(made, filtered(scene, colour, depth))
    assert np.abs(made - colour).max() > 0.05
    lens = addon("lens").camera_parameters(scene.camera, scene.render)
    (OUT / "lens.json").write_text(json.dumps(lens))


@check
def every_method_of_the_list():
    """Each renders what the filter makes."""
    scene, data = start()
    sharp = pinhole(scene, OUT / "m.exr")
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    methods = addon("library").rackfocus.methods()
    menu = data.rack_focus.bl_rna.properties["method"].enum_items
    assert [item.identifier for item in menu] == [method.name for method in methods]
    for method in methods:
        data.rack_focus.method = method.name
        made = rgba(render(scene, OUT / "m.exr"))
        same(made, filtered(scene, colour, depth))


@check
def sockets():
    """CoC and depth come out as numbers, the overlay marks the band."""
    scene, data = start(coc_limit=1.0)
    sharp = pinhole(scene, OUT / "s.exr")
    depth = common.depth_of(sharp)
    tree, ours = common.tree_of(scene), scene.rack_focus.filter_scene
    node = addon("setup").layer_nodes(tree, ours)[0]
    out = addon("compat").output_socket(tree)
    names = [o.name for o in node.outputs if o.enabled]
    assert names == ["Image", "Alpha", "Depth", "CoC", "Focus"], names
    tree.links.new(node.outputs["CoC"], out)
    coc = rgba(render(scene, OUT / "s.exr"))[..., 0]
    params = addon("lens").frame_parameters(
        scene.camera, data.rack_focus, scene.render, depth.shape[::-1]
    )
    lens = addon("library").rackfocus.Lens(*depth.shape[::-1], **params)
    expected = np.vectorize(lens.radius_px)(np.where(depth > 1e9, np.inf, depth))
    assert np.allclose(coc, expected, atol=1e-4), np.abs(coc - expected).max()
    tree.links.new(node.outputs["Depth"], out)
    same(rgba(render(scene, OUT / "s.exr"))[..., 0], depth)
    tree.links.new(node.outputs["Focus"], out)
    shown = rgba(render(scene, OUT / "s.exr"))
    band = np.abs(coc) <= 1.0
    assert band.any() and shown[band][:, 1].min() >= 0.5


@check
def animated_focus():
    """Three frames, each with its own focus; the stored value does not matter."""
    scene, data = start()
    for frame, distance in ((1, 1.5), (3, 6.0)):
        data.dof.focus_distance = distance
        data.dof.keyframe_insert("focus_distance", frame=frame)
    scene.frame_start, scene.frame_end = 1, 3
    common.set_output(scene, OUT / "anim_####.exr")
    bpy.ops.render.render(animation=True)
    made = [rgba(common.read(OUT / f"anim_{f:04d}.exr")) for f in (1, 2, 3)]
    data.animation_data_clear()
    sharp = pinhole(scene, OUT / "p.exr")
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    for distance, picture in zip((1.5, None, 6.0), made, strict=True):
        if distance:
            data.dof.focus_distance = distance
            same(picture, filtered(scene, colour, depth))
    assert np.abs(made[0] - made[1]).max() > 0.01
    assert np.abs(made[1] - made[2]).max() > 0.01


@check
def focus_object_follows_parents():
    """The planar distance of an animated child; the camera is scaled and parented."""
    scene, data = start()
    holder = bpy.data.objects.new("holder", None)
    target = bpy.data.objects.new("target", None)
    for item in (holder, target):
        scene.collection.objects.link(item)
    target.parent = holder
    target.location = (0.4, 1, 0)
    holder.location = (0, 1, 0.2)
    holder.scale = (1, 2, 1)
    scene.camera.scale = (3, 3, 3)
    data.dof.focus_object = target
    data.dof.focus_distance = 77
    bpy.context.view_layer.update()
    assert math.isclose(addon("lens").focus_distance(scene.camera), 3, rel_tol=1e-6)
    sharp = pinhole(scene, OUT / "o.exr")
    made = rgba(render(scene, OUT / "o.exr"))
    data.dof.focus_object = None
    data.dof.focus_distance = 3
    expected = filtered(scene, rgba(sharp, "ViewLayer"), common.depth_of(sharp))
    # The distance differs by a few parts in 1e7.
    assert np.abs(made - expected).mean() < 1e-4


@check
def border_crop_percentage():
    """A part of the frame is blurred like the whole."""
    scene, data = start(method="scatter")
    whole = rgba(render(scene, OUT / "w.exr"))
    size = (whole.shape[1], whole.shape[0])
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.25, 1.0
    for is_cropped in (True, False):
        scene.render.use_crop_to_border = is_cropped
        sharp = pinhole(scene, OUT / "b.exr")
        made = rgba(render(scene, OUT / "b.exr"))
        assert not last_message(scene), last_message(scene)
        expected_size = (36, 36) if is_cropped else size
        assert made.shape[1::-1] == expected_size, made.shape
        if is_cropped:
            colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
            same(made, filtered(scene, colour, depth))
            cropped = made
            # Far from the border of the crop nothing differs from the whole frame.
            part = whole[0:36, 18:54]
            inner = np.abs(made - part)[0:12, 12:24].max()
            assert inner < 0.3, inner
        else:
            assert np.all(made[-12:] == 0) and np.all(made[:, :18] == 0)
            same(made[:36, 18:54], cropped)
    scene.render.use_border = False
    scene.render.resolution_percentage = 50
    sharp = pinhole(scene, OUT / "h.exr")
    made = rgba(render(scene, OUT / "h.exr"))
    assert made.shape == (24, 36, 4)
    same(made, filtered(scene, rgba(sharp, "ViewLayer"), common.depth_of(sharp)))


# ---- layers, views, scenes --------------------------------------------------------


@check
def film_depth_reaches_the_filter():
    """What is partly transparent and has no depth: the choice changes it."""
    scene, data = start(quality=addon("props").DEFAULT_QUALITY)
    scene.render.film_transparent = True
    sharp = pinhole(scene, OUT / "f.exr")
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    assert ((colour[..., 3] > 0) & (colour[..., 3] < 1) & (depth > 1e9)).any()
    pictures = []
    for choice in ("keep", "solid", "all"):
        data.rack_focus.film_depth = choice
        pictures.append(rgba(render(scene, OUT / "f.exr")))
        same(pictures[-1], filtered(scene, colour, depth))
    assert np.abs(pictures[0] - pictures[2]).max() > 0.01


@check
def a_quality_of_the_table_is_that_of_the_panel():
    """The core may bring choices of its own: they become the property's."""
    props, library = addon("props"), addon("library").rackfocus
    method = next(p for p in library.parameters() if p.field == "method")
    table = method._replace(field="quality", key="quality", default="box")
    items, default, presets = props._qualities(table)
    names = [item[0] for item in items]
    assert names == [*(c.name for c in method.choices), "custom"]
    assert default == "box" and presets["box"] == {"quality": "box"}
    assert presets["custom"] is None


@check
def transparent_film_and_two_layers():
    """Each layer is filtered on its own; the second is put over the first."""
    scene = bpy.context.scene
    scene.render.film_transparent = True
    front = bpy.data.collections.new("front")
    scene.collection.children.link(front)
    for item in [o for o in scene.objects if o.location.y < 2.5 and o.type == "MESH"]:
        scene.collection.objects.unlink(item)
        front.objects.link(item)
    second = scene.view_layers.new("Front")
    for child in scene.view_layers["ViewLayer"].layer_collection.children:
        child.exclude = child.name == "front"
    second.layer_collection.children["front"].holdout = False
    before = snapshot(scene)
    _, data = start()
    nodes = addon("setup").layer_nodes(
        common.tree_of(scene), scene.rack_focus.filter_scene
    )
    assert sorted(n.layer for n in nodes) == ["Front", "ViewLayer"]
    made = rgba(render(scene, OUT / "l.exr"))
    assert not last_message(scene), last_message(scene)
    sharp = pinhole(scene, OUT / "l2.exr")
    layers = []
    for name in ("ViewLayer", "Front"):
        colour, depth = rgba(sharp, name), common.depth_of(sharp, name)
        layers.append(filtered(scene, colour, depth))
    back, over = layers
    expected = over + back * np.maximum(1 - over[..., 3:], 0)
    assert np.abs(made - expected).max() < 1e-4, np.abs(made - expected).max()
    data.rack_focus.enabled = False
    after = snapshot(scene)
    assert after[0] == before[0] and after[3:] == before[3:]


@check
def stereo():
    """Both views are filtered, each from its own passes."""
    scene, data = start()
    scene.render.use_multiview = True
    scene.render.views_format = "STEREO_3D"
    data.stereo.interocular_distance = 0.3
    data.stereo.convergence_distance = 5
    scene.render.image_settings.views_format = "INDIVIDUAL"
    common.set_output(scene, OUT / "st.exr")
    bpy.ops.render.render(write_still=True)
    assert not last_message(scene), last_message(scene)
    made = {s: rgba(common.read(OUT / f"st{s}.exr")) for s in ("_L", "_R")}
    common.set_output(scene, OUT / "st0.exr", multilayer=True)
    data.rack_focus.enabled = False
    scene.view_layers[0].use_pass_z = True
    bpy.ops.render.render(write_still=True)
    for side in ("_L", "_R"):
        sharp = common.read(OUT / f"st0{side}.exr")
        expected = filtered(scene, rgba(sharp), common.depth_of(sharp))
        same(made[side], expected)
    assert np.abs(made["_L"] - made["_R"]).max() > 0.05


@check
def views_with_cameras_of_their_own():
    """Multi-view: each view is filtered with the lens of its camera."""
    scene, data = start()
    first = scene.camera
    second = first.copy()
    second.data = data.copy()
    second.data.dof.focus_distance = 6
    second.location.x = 0.2
    scene.collection.objects.link(second)
    first.name, second.name = "cam_a", "cam_b"
    scene.render.use_multiview = True
    scene.render.views_format = "MULTIVIEW"
    for name, suffix in (("left", "_a"), ("right", "_b")):
        scene.render.views[name].camera_suffix = suffix
        scene.render.views[name].file_suffix = suffix
    scene.render.image_settings.views_format = "INDIVIDUAL"
    common.set_output(scene, OUT / "mv.exr")
    bpy.ops.render.render(write_still=True)
    assert not last_message(scene), last_message(scene)
    scene.render.use_multiview = False
    for camera in (first, second):
        made = rgba(common.read(OUT / f"mv{camera.name[-2:]}.exr"))
        scene.camera = camera
        sharp = pinhole(scene, OUT / "mv0.exr")
        colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
        right = np.abs(made - filtered(scene, colour, depth)).mean()
        camera.data.dof.focus_distance = 9 - camera.data.dof.focus_distance
        wrong = np.abs(made - filtered(scene, colour, depth)).mean()
        # The second view has noise of its own.
        assert right < 0.005 and right < wrong / 3, (camera.name, right, wrong)


@check
def cameras_bound_to_markers():
    """The camera of the frame counts, and one that is not enabled is left alone."""
    scene, data = start()
    other = scene.camera.copy()
    other.data = data.copy()
    other.data.rack_focus.enabled = False
    other.data.dof.use_dof = False
    scene.collection.objects.link(other)
    third = scene.camera.copy()
    third.data = data.copy()
    third.data.dof.focus_distance = 8
    scene.collection.objects.link(third)
    first = scene.camera
    for frame, camera in ((1, first), (2, other), (3, third)):
        scene.timeline_markers.new("m", frame=frame).camera = camera
    scene.frame_start, scene.frame_end = 1, 3
    common.set_output(scene, OUT / "mark_####.exr")
    bpy.ops.render.render(animation=True)
    made = [rgba(common.read(OUT / f"mark_{f:04d}.exr")) for f in (1, 2, 3)]
    scene.timeline_markers.clear()
    scene.frame_set(1)
    scene.camera = first
    sharp = pinhole(scene, OUT / "mk.exr")
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    same(made[0], filtered(scene, colour, depth))
    same(made[1], colour)
    scene.camera = third
    same(made[2], filtered(scene, colour, depth))


@check
def several_scenes():
    """Two scenes of a file, each with its own set-up."""
    scene, data = start()
    other = scene.copy()
    other.name = "Other"
    other.camera = scene.camera.copy()
    other.camera.data = data.copy()
    other.camera.data.dof.focus_distance = 1.5
    # What Blender does at the next change of the file.
    addon("handlers").on_change()
    assert len(bpy.data.scenes) == 4, [s.name for s in bpy.data.scenes]
    first = rgba(render(scene, OUT / "s1.exr"))
    second = rgba(render(other, OUT / "s2.exr"))
    assert np.abs(first - second).max() > 0.05
    other.camera.data.rack_focus.enabled = False
    assert len(bpy.data.scenes) == 3
    same(rgba(render(scene, OUT / "s1.exr")), first)


# ---- the camera's own depth of field ----------------------------------------------


@check
def own_dof_is_off_for_the_beauty_render():
    """And on again afterwards; the picture is the same as without it."""
    scene, data = start()
    data.dof.use_dof = False
    without = rgba(render(scene, OUT / "d0.exr"))
    data.dof.use_dof = True
    same(rgba(render(scene, OUT / "d1.exr")), without)
    assert data.dof.use_dof and not data.rack_focus.is_dof_hidden


@check
def own_dof_comes_back_after_a_crash():
    """A file saved in the middle of a render."""
    scene, data = start()
    data.dof.use_dof = True
    addon("setup").hide_dof(scene)
    assert not data.dof.use_dof
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "crash.blend"), copy=True)
    bpy.ops.wm.open_mainfile(filepath=str(OUT / "crash.blend"))
    data = bpy.context.scene.camera.data
    assert data.dof.use_dof and not data.rack_focus.is_dof_hidden


@check
def own_dof_comes_back_after_an_error():
    """The engine fails; picture and camera are as they were."""
    scene, data = start()
    data.dof.use_dof = True
    engine = addon("engine").RackFocusEngine
    kept = engine._filter

    def fail(self, *_):
        raise addon("engine").Problem("a test")

    engine._filter = fail
    try:
        render(scene, OUT / "e.exr")
    except RuntimeError as error:
        assert "a test" in str(error)
    finally:
        engine._filter = kept
    assert data.dof.use_dof and "a test" in last_message(scene)


@check
def failure_leaves_the_picture():
    """Never black: a camera that cannot be filtered, and one cancelled half-way."""
    scene, data = start()
    expected = rgba(pinhole(scene, OUT / "f0.exr"), "ViewLayer")
    engine = addon("engine").RackFocusEngine
    kept = engine._report
    engine._report = lambda self, fraction: False
    try:
        common.set_output(scene, OUT / "f1.exr")
        bpy.ops.render.render(write_still=True)
    except RuntimeError as error:
        assert "stopped" in str(error), error
    finally:
        engine._report = kept
    assert "not filtered" in last_message(scene)
    bpy.data.images["Render Result"].save_render(str(OUT / "f1.exr"), scene=scene)
    same(rgba(common.read(OUT / "f1.exr")), expected)


@check
def faults_and_missing_depth_leave_the_picture():
    """A fault in our own code, and a render whose passes lack the depth."""
    scene, data = start()
    expected = rgba(pinhole(scene, OUT / "n0.exr"), "ViewLayer")
    engine, setup = addon("engine"), addon("setup")

    def fail(*_):
        raise KeyError("a test")

    kept = {"frame_parameters": addon("lens").frame_parameters}
    kept["_need_depth"] = setup._need_depth
    for module, name, text in (
        (addon("lens"), "frame_parameters", "a fault of Rack Focus"),
        (setup, "_need_depth", "has no depth"),
    ):
        setattr(module, name, fail if module is not setup else lambda _: None)
        scene.view_layers[0].use_pass_z = module is not setup
        common.set_output(scene, OUT / "n1.exr")
        try:
            bpy.ops.render.render(write_still=True)
        except RuntimeError as error:
            assert text in str(error), error
        setattr(module, name, kept[name])
        assert text in engine.last_run[scene.name]["message"]
        bpy.data.images["Render Result"].save_render(str(OUT / "n1.exr"), scene=scene)
        same(rgba(common.read(OUT / "n1.exr")), expected)


@check
def new_view_layers_get_their_depth():
    """A layer made after enabling is filtered too, and disabling takes its Z back."""
    scene, data = start()
    layer = scene.view_layers.new("Second")
    layer.use_pass_z = False
    render(scene, OUT / "nl.exr")
    ours = scene.rack_focus.filter_scene
    assert layer.use_pass_z and ours.view_layers[1].name == "Second"
    data.rack_focus.enabled = False
    assert not layer.use_pass_z


# ---- refocus, picker, comparison --------------------------------------------------


@check
def refocus_does_not_render():
    """The same picture as rendering again, without rendering again."""
    scene, data = start()
    render(scene, OUT / "r0.exr")
    data.dof.focus_distance = 1.6
    data.dof.aperture_blades = 5
    scene.cycles.seed = 99  # a new render would differ
    for _ in range(2):
        assert bpy.ops.rack_focus.refocus() == {"FINISHED"}
    assert not any(node.mute for node in common.tree_of(scene).nodes)
    bpy.data.images["Render Result"].save_render(str(OUT / "r1.exr"), scene=scene)
    made = rgba(common.read(OUT / "r1.exr"))
    scene.cycles.seed = 0
    same(made, rgba(render(scene, OUT / "r2.exr")))


@check
def pick_focus():
    """A point of the picture, an object, the empty sky."""
    scene, data = start()
    sharp = render(scene, OUT / "k.exr")
    sharp = pinhole(scene, OUT / "k0.exr")
    depth = common.depth_of(sharp)
    render(scene, OUT / "k.exr")
    height, width = depth.shape
    row, column = np.argwhere(depth < 2)[3]
    x, y = (column + 0.5) / width, 1 - (row + 0.5) / height
    bpy.ops.rack_focus.pick_focus(x=x, y=y)
    assert math.isclose(data.dof.focus_distance, depth[row, column], rel_tol=1e-6)
    row, column = np.argwhere(depth > 1e9)[0]
    x, y = (column + 0.5) / width, 1 - (row + 0.5) / height
    assert bpy.ops.rack_focus.pick_focus(x=x, y=y) == {"CANCELLED"}
    cube = next(o for o in scene.objects if o.type == "MESH")
    bpy.ops.rack_focus.pick_focus(object=cube.name)
    assert data.dof.focus_object == cube


@check
def compare_with_physical():
    """Scores and three images; nothing else is left."""
    scene, data = start()
    before = counts_without_images()
    bpy.ops.rack_focus.compare(percentage=100, samples=64)
    assert counts_without_images() == before
    sizes = [tuple(bpy.data.images[n].size) for n in addon("compare").NAMES]
    assert sizes == [(72, 48)] * 3
    read = {}
    for name in addon("compare").NAMES[:2]:
        flat = np.empty(72 * 48 * 4, np.float32)
        bpy.data.images[name].pixels.foreach_get(flat)
        read[name] = flat.reshape(48, 72, 4)
    # Blender's images have their rows upwards.
    pictures = (np.ascontiguousarray(p[::-1]) for p in read.values())
    scores = addon("library").rackfocus.compare(*pictures)
    assert addon("compare").last_scores == scores
    assert 24 < scores["tpsnr"] < 60, scores
    (OUT / "scores.json").write_text(json.dumps(scores))


def counts_without_images():
    """Datablocks but for images."""
    return {k: n for k, n in common.counts().items() if k != "images"}


# ---- set-up and its end -----------------------------------------------------------


@check
def disable_leaves_nothing():
    """Fresh compositor: the same datablocks, nodes, links and switches as before."""
    scene = bpy.context.scene
    before = snapshot(scene)
    start()
    assert snapshot(scene) != before
    render(scene, OUT / "x.exr")
    scene.camera.data.rack_focus.enabled = False
    after = snapshot(scene)
    images = bpy.data.images.get("Render Result") is not None
    after[0]["images"] -= images and before[0]["images"] != after[0]["images"]
    assert after == before, (before, after)


@check
def the_users_nodes_stay():
    """A compositor in use: ours goes in between and out again."""
    scene = bpy.context.scene
    tree, _ = addon("compat").start_compositor(scene)
    source = addon("setup").layer_nodes(tree, scene)[0]
    flip = tree.nodes.new("CompositorNodeFlip")
    if "Flip X" in flip.inputs:  # 4.5 and later
        flip.inputs["Flip X"].default_value = True
        flip.inputs["Flip Y"].default_value = False
    out = addon("compat").output_socket(tree)
    tree.links.new(source.outputs["Image"], flip.inputs[0])
    tree.links.new(flip.outputs[0], out)
    before = snapshot(scene)
    _, data = start()
    flipped = rgba(render(scene, OUT / "u.exr"))
    node = addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]
    assert any(k.from_node == node and k.to_node == flip for k in tree.links)
    tree.links.new(node.outputs["Image"], out)
    plain = rgba(render(scene, OUT / "u.exr"))
    same(flipped, plain[:, ::-1])
    tree.links.new(flip.outputs[0], out)
    data.rack_focus.enabled = False
    after = snapshot(scene)
    assert after[1:] == before[1:], (before, after)


@check
def a_camera_from_a_library():
    """A linked camera, enabled in its own file: read, never changed for good."""
    scene, data = start(method="scatter")
    data.dof.use_dof = True
    library = str(OUT / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=library, copy=True)
    bpy.ops.wm.open_mainfile(filepath=str(BASE))
    scene = bpy.context.scene
    bpy.data.objects.remove(scene.camera)
    with bpy.data.libraries.load(library, link=True) as (_, linked):
        linked.objects = ["Camera"]
    camera = linked.objects[0]
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.context.view_layer.update()
    assert camera.data.library is not None and camera.data.rack_focus.enabled
    assert addon("setup").filter_scene_of(scene) is not None
    made = rgba(render(scene, OUT / "l.exr"))
    assert camera.data.dof.use_dof and not camera.data.rack_focus.is_dof_hidden
    sharp = pinhole(scene, OUT / "l.exr")
    expected = filtered(scene, rgba(sharp, "ViewLayer"), common.depth_of(sharp))
    same(made, expected)


@check
def a_scene_that_loses_its_camera():
    """The set-up goes with the camera and comes back with it; nothing raises."""
    scene, _ = start()
    camera = scene.camera
    scene.camera = None
    bpy.context.view_layer.update()
    addon("handlers").on_change()
    assert addon("setup").filter_scene_of(scene) is None
    assert len(bpy.data.scenes) == 1
    for name in ("add_node", "refocus", "pick_focus", "compare"):
        assert not getattr(bpy.ops.rack_focus, name).poll(), name
    try:
        bpy.ops.render.render()
        raise AssertionError("rendered without a camera")
    except RuntimeError as error:
        assert "camera" in str(error).lower()
    scene.camera = camera
    addon("handlers").on_change()
    assert addon("setup").filter_scene_of(scene) is not None
    render(scene, OUT / "n.exr")


@check
def undo():
    """Enabling is one step back."""
    scene = bpy.context.scene
    if bpy.app.background and not hasattr(bpy.context, "window"):
        return
    bpy.ops.ed.undo_push(message="before")
    start()
    bpy.ops.ed.undo_push(message="enabled")
    assert len(bpy.data.scenes) == 2
    bpy.ops.ed.undo()
    assert len(bpy.data.scenes) == 1, [s.name for s in bpy.data.scenes]
    scene = bpy.context.scene
    assert not scene.camera.data.rack_focus.enabled
    assert addon("setup").filter_scene_of(scene) is None
    bpy.ops.ed.redo()
    scene = bpy.context.scene
    assert addon("setup").filter_scene_of(scene) is not None
    render(scene, OUT / "undo.exr")


@check
def save_and_reload():
    """The set-up lives in the file."""
    scene, data = start(method="scatter", max_radius=9)
    first = rgba(render(scene, OUT / "v0.exr"))
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "saved.blend"), copy=True)
    bpy.ops.wm.open_mainfile(filepath=str(OUT / "saved.blend"))
    scene = bpy.context.scene
    settings = scene.camera.data.rack_focus
    assert settings.enabled and settings.method == "scatter"
    assert settings.max_radius == 9
    same(rgba(render(scene, OUT / "v1.exr")), first)
    settings.enabled = False
    assert len(bpy.data.scenes) == 1


@check
def properties_come_from_the_table():
    """Every parameter of the methods, with range, default and help."""
    settings = bpy.context.scene.camera.data.rack_focus
    for p in addon("props").method_table():
        about = settings.bl_rna.properties[p.field]
        assert about.description == p.help.rstrip("."), p.field
        value = getattr(settings, p.field)
        if p.type == "float":
            assert math.isclose(value, p.default, rel_tol=1e-6)
            assert math.isclose(about.hard_max, p.max, rel_tol=1e-6)
        else:
            assert value == p.default
        if p.type == "enum":
            names = [item.identifier for item in about.enum_items]
            assert names == [choice.name for choice in p.choices]


@check
def preferences_show_version_and_cpu_level():
    """What the panel of the preferences draws."""
    drawn = []

    class Column:
        """Takes down what is drawn."""

        def prop(self, _, name):
            drawn.append(name)

        def label(self, text):
            drawn.append(text)

    class Shown:
        """Stands for the preferences; Blender lets none be made."""

        class layout:
            column = Column

    addon("ui").Preferences.draw(Shown, bpy.context)
    library = addon("library").rackfocus
    assert library.cpu_level() in ("avx2", "sse4", "generic")
    assert drawn == [
        "threads",
        f"Version {library.version()}",
        f"CPU level in use: {library.cpu_level()}",
    ], drawn


@check
def add_node():
    """Once sets up, twice adds another node."""
    scene = bpy.context.scene
    bpy.ops.rack_focus.add_node()
    assert scene.camera.data.rack_focus.enabled
    bpy.ops.rack_focus.add_node()
    ours = scene.rack_focus.filter_scene
    assert len(addon("setup").layer_nodes(common.tree_of(scene), ours)) == 2


# ---- cost -------------------------------------------------------------------------


@check
def a_hundred_renders():
    """Memory does not grow; nothing stays in the memory folder."""
    scene, data = start(**DRAFT)
    scene.cycles.samples = 1
    folder = Path("/dev/shm")
    for count in range(130):
        bpy.ops.render.render()
        if count == 30:
            before = common.resident_bytes()
    grown = (common.resident_bytes() - before) / 2**20
    assert grown < 12, f"{grown:.1f} MiB in 100 renders"
    assert not list(folder.glob("rack_focus_*"))


def refocus():
    """The operator."""
    bpy.ops.rack_focus.refocus()


@check
def overhead_at_1080p():
    """What the node costs beside the filter's own time; the figures go to a file."""
    scene, data = start(method="scatter", **DRAFT)
    data.dof.aperture_fstop = 500  # nearly no blur: the filter itself is quick
    scene.render.resolution_x, scene.render.resolution_y = 1920, 1080
    scene.cycles.samples = 1
    best = {}
    for what, call in (("f12", bpy.ops.render.render), ("refocus", refocus)):
        for _ in range(3):
            call()
            seconds = dict(addon("engine").last_run[scene.name]["seconds"])
            seconds["overhead"] = seconds["total"] - seconds["filter"]
            kept = best.setdefault(what, seconds)
            best[what] = min(kept, seconds, key=lambda s: s["overhead"])
    (OUT / "overhead.json").write_text(json.dumps(best))


def main():
    """Installs, runs all checks or those named, uninstalls."""
    names = sys.argv[sys.argv.index("--") + 3 :] or list(CHECKS)
    results = {}

    def report(name, problem):
        results[name] = problem
        print("CHECK", name, problem or "ok", flush=True)
        (OUT / "results.json").write_text(json.dumps(results, indent=1))

    common.install(DIST)
    common.make_base(BASE)
    common.run(CHECKS, names, report)
    bpy.ops.wm.open_mainfile(filepath=str(BASE))
    before = common.counts()
    start()
    common.uninstall()
    left = common.user_files()
    after = common.counts()
    is_clean = after == before and not left
    report("uninstall_leaves_nothing", "" if is_clean else f"{before}, {after}, {left}")
    print(V)
    common.leave()


main()
