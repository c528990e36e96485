# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the pictures: layers, views, scenes, the camera's own depth of field."""

import contextlib
import json
import math

import bpy
import common
import numpy as np
from checking import OUT, Checks, key_focus
from common import (
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

check = Checks()


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
def denoising_data_tells_shares():
    """Its depth is read at edges; the pass comes and goes with Clean Edges."""
    scene, data = start()
    settings, owner = data.rack_focus, scene.view_layers[0].cycles
    assert settings.bl_rna.properties["clean_edges"].default
    without = rgba(render(scene, OUT / "d.exr"))
    assert not owner.denoising_store_passes
    settings.clean_edges = True
    made = rgba(render(scene, OUT / "d.exr"))
    assert owner.denoising_store_passes
    sharp = pinhole(scene, OUT / "d.exr")
    assert not owner.denoising_store_passes  # without the tick
    owner.denoising_store_passes = True
    sharp = pinhole(scene, OUT / "d.exr")
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    height, width = depth.shape
    params = addon("lens").frame_parameters(
        scene.camera, settings, scene.render, (width, height)
    )
    by_hand = addon("library").rackfocus.Filter(width, height, **params)
    mean, out = np.empty_like(depth), np.empty_like(colour)
    assert by_hand.mean_depth(sharp["ViewLayer.Denoising Depth.Z"], depth, mean)
    by_hand.process(np.ascontiguousarray(colour), depth, out, mean_depth=mean)
    same(made, out)
    assert (made != without).any()
    settings.clean_edges = False
    same(rgba(render(scene, OUT / "d.exr")), out)  # the artist's own stays, and is read
    assert owner.denoising_store_passes


@check
def clean_edges_take_nothing_for_others():
    """Means, other methods and engines get no pass for it; mirrors have theirs."""
    scene, data = start()
    settings, module = data.rack_focus, addon("shares")
    layer = scene.view_layers[0]
    settings.clean_edges = True
    module.need_pass(scene)
    assert layer.cycles.denoising_store_passes
    layer.name = "renamed"
    addon("setup").sync(scene)
    settings.views = 2
    module.need_pass(scene)
    assert layer.cycles.denoising_store_passes
    settings.method = "accumulate"
    module.need_pass(scene)
    assert not layer.cycles.denoising_store_passes
    settings.views, settings.method = 1, "scatter"
    assert not module.is_wanted(scene) and not module.is_offered(scene, settings)
    settings.method = "layered"
    assert module.is_wanted(scene) and module.is_offered(scene, settings)
    scene.render.engine = scene.render.engine.replace("CYCLES", "BLENDER_WORKBENCH")
    assert not module.is_wanted(scene) and not module.is_offered(scene, settings)
    scene.render.engine = "CYCLES"
    settings.clean_edges, settings.mirrors = False, True
    module.need_pass(scene)
    assert layer.cycles.denoising_store_passes
    settings.enabled = False
    assert not layer.cycles.denoising_store_passes


@check
def every_method_of_the_list():
    """Each renders what the filter makes."""
    scene, data = start()
    sharp = pinhole(scene, OUT / "m.exr")
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    methods = addon("library").rackfocus.methods()
    menu = data.rack_focus.bl_rna.properties["method"].enum_items
    assert {item.identifier for item in menu} == {method.name for method in methods}
    for method in methods:
        data.rack_focus.method, data.rack_focus.views = method.name, 1
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
def white_is_that_of_the_exposure():
    """A scene that is shown brighter has lamps that are as much darker."""
    scene, data = start()
    size = addon("lens").picture_size(scene.render)
    for exposure, white in ((0, 1), (5, 1 / 32), (-2.4, 4), (32, 1e-6)):
        with contextlib.suppress(TypeError, ValueError):  # 10 at the most, once
            scene.view_settings.exposure = exposure
        if scene.view_settings.exposure < exposure:
            continue
        params = addon("lens").frame_parameters(
            scene.camera, data.rack_focus, scene.render, size
        )
        assert params["white"] == white, (exposure, params["white"])
    scene.view_settings.exposure = 5
    key = addon("refocusing").key_of(scene)
    made = rgba(render(scene, OUT / "w.exr"))
    sharp = pinhole(scene, OUT / "p.exr")
    same(made, filtered(scene, rgba(sharp, "ViewLayer"), common.depth_of(sharp)))
    scene.view_settings.exposure = 0
    assert addon("refocusing").key_of(scene) == key  # no reason to filter anew


@check
def animated_focus():
    """Three frames, each with its own focus; the stored value does not matter."""
    scene, data = start()
    key_focus(data, {1: 1.5, 3: 6.0})
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


class Sizes(bpy.types.RenderEngine):
    """For the tests: what Blender makes of the size of a render."""

    bl_idname, bl_label, seen = "RACK_FOCUS_SIZES", "Sizes", []

    def render(self, depsgraph):
        """Asks for more than there is."""
        result = self.begin_result(0, 0, 99999, 99999)
        self.seen.append((result.resolution_x, result.resolution_y))
        self.end_result(result)


@check
def sizes_are_rounded_as_blender_does():
    """Percentages, and render regions at all hundredths (4.2 and 4.5: some)."""
    step = 7 if common.IS_BETWEEN else 1
    lens, scene = addon("lens"), bpy.context.scene
    bpy.utils.register_class(Sizes)
    render_, scene.render.engine = scene.render, Sizes.bl_idname

    def size():
        bpy.ops.render.render()
        return Sizes.seen[-1]

    render_.resolution_x, render_.resolution_y = 100, 300
    for percentage in (*range(10, 100, step), 100):
        render_.resolution_percentage = percentage
        assert size() == lens.picture_size(render_), percentage
    render_.use_border = True
    for whole in ((1920, 1080), (1000, 1000)):
        render_.resolution_x, render_.resolution_y = whole
        for i in range(1, 99, step):
            render_.border_min_x, render_.border_max_x = i / 100, 1
            render_.border_min_y, render_.border_max_y = 0, i / 100
            found = tuple(b - a for a, b in lens.region_of(render_, *whole))
            assert size() == found, (whole, i, found)
    bpy.utils.unregister_class(Sizes)


@check
def a_size_that_is_not_blenders_costs_no_picture():
    """What differs by a row or column is there, and the console says so."""
    scene, _ = start()
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.25, 1.0
    expected = rgba(render(scene, OUT / "b.exr"))
    lens = addon("lens")
    kept = lens.region_of
    for right, high in ((53, 48), (55, 47)):
        lens.region_of = lambda *_, r=right, h=high: ((18, r), (12, h))
        try:
            made = rgba(render(scene, OUT / "b.exr"))
        finally:
            lens.region_of = kept
        assert "px" in last_message(scene), last_message(scene)
        assert np.abs(made - expected)[:36, 18:54].mean() < 0.02
        assert made[:36, 18:54, 3].min() > 0.3


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
    for choice in ("keep", "solid", "all", "edges"):
        data.rack_focus.film_depth = choice
        pictures.append(rgba(render(scene, OUT / "f.exr")))
        same(pictures[-1], filtered(scene, colour, depth))
    assert np.abs(pictures[0] - pictures[2]).max() > 0.01
    data.rack_focus.front_blur = 0.5  # what has no depth has none still
    data.dof.focus_distance = 9
    with_look = rgba(render(scene, OUT / "f.exr"))
    data.rack_focus.film_depth = "keep"
    assert np.abs(rgba(render(scene, OUT / "f.exr")) - with_look).max() > 0.01


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


@check
def pixels_that_are_not_square():
    """With border and crop too: 5.0 saves no passes then, unless it is helped."""
    scene, _ = start()
    render_ = scene.render
    for is_cut in (False, True):
        for aspect in (1.0, 1.5):
            render_.use_border = render_.use_crop_to_border = is_cut
            render_.border_min_x, render_.border_max_x = 0.2, 0.9
            render_.pixel_aspect_x = aspect
            common.set_output(scene, OUT / "aspect.exr")
            bpy.ops.render.render()
            assert not last_message(scene), (is_cut, aspect, last_message(scene))
            assert render_.pixel_aspect_x == aspect
            kept = addon("passes").rendered(scene).layer("ViewLayer")
            params = addon("lens").frame_parameters(
                scene.camera,
                scene.camera.data.rack_focus,
                render_,
                kept.depth.shape[::-1],
            )
            assert params["pixel_aspect"] == aspect


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
    """A file that an earlier version saved in the middle of a render."""
    scene, data = start()
    data.dof.use_dof, data.rack_focus.is_dof_hidden = False, True
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
def a_focus_that_was_never_set():
    """Distance 0, as in files of 2.7x: the sharp picture and a message; views too."""
    scene, data = start()
    sharp = rgba(pinhole(scene, OUT / "p_passes.exr"), "ViewLayer")
    data.dof.focus_distance = 0
    for views in (1, 3):
        data.rack_focus.views = views
        common.set_output(scene, OUT / "p.exr")
        with contextlib.suppress(RuntimeError):  # of some Blenders, for the report
            bpy.ops.render.render(write_still=True)
        assert "set its focus distance" in last_message(scene), data.dof.focus_distance
        made = rgba(common.read(OUT / "p.exr"))
        if views == 1:
            same(made, sharp)
        else:  # one of the views, with fewer samples
            assert np.abs(made - sharp).mean() < 0.02


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


def _add_fog(density):
    """A cube of fog around everything."""
    mesh = bpy.data.meshes.new("fog")
    corners = [(x, y, z) for x in (-40, 40) for y in (-40, 40) for z in (-40, 40)]
    faces = [
        (0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4),
        (1, 5, 7, 3),
    ]  # fmt: skip
    mesh.from_pydata(corners, [], faces)
    material = bpy.data.materials.new("fog")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    scatter = nodes.new("ShaderNodeVolumeScatter")
    scatter.inputs["Density"].default_value = density
    out = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(scatter.outputs[0], out.inputs["Volume"])
    mesh.materials.append(material)
    item = bpy.data.objects.new("fog", mesh)
    bpy.context.scene.collection.objects.link(item)
    return item


@check
def fog_leaves_no_holes():
    """Where Cycles' first sample was scattered, the depth is that of the surface; in one
    view and in several; the user is told of fog that hides too much."""
    scene, data = start()
    scene.cycles.samples = 16
    scene.render.resolution_x, scene.render.resolution_y = 144, 96
    floor = common.emitter("floor", (0.3, 0.3, 0.3), 80, (0, 20, -40.4))
    fog = _add_fog(0.05)
    has_volume = addon("fog").has_volume
    for views in (1, 3):
        data.rack_focus.views = views
        data.rack_focus.method = "layered" if views == 1 else "views"
        fog.hide_render = True
        assert not has_volume(scene)
        render(scene, OUT / "fog.exr")
        clear = [layer.depth for layer, _ in common.kept(scene)]
        fog.hide_render = False
        assert has_volume(scene)
        data.rack_focus.passes_folder = str(OUT / f"fog{views}")
        made = rgba(render(scene, OUT / "fog.exr"))
        assert not last_message(scene), last_message(scene)
        raw = [layer.depth for layer, _ in common.kept(scene)]
        files = addon("keep").KeptFiles(scene, OUT / f"fog{views}", scene.frame_current)
        filled = [layer.depth for layer, _ in files.views("ViewLayer")]
        data.rack_focus.passes_folder = ""
        for want, holes, got in zip(clear, raw, filled, strict=True):
            is_hit = (want < 1e9) & (want < 15)
            assert (holes[is_hit] > 1e9).mean() > 0.1
            wrong = np.abs(got / want - 1)[is_hit] > 0.1
            assert wrong.mean() < 0.03, wrong.mean()
            assert (got[want > 1e9] < 1e9).mean() < 0.04  # corners of the sky
        bpy.ops.rack_focus.refocus()
        same(common.result(scene, OUT / "fog_result.exr"), made)
    dense = np.full_like(want, 1e10)
    dense[::4, ::4] = 5
    found = [
        (kept_layer._replace(depth=dense), place)
        for kept_layer, place in common.kept(scene)
    ]
    assert "hides the depth" in addon("fog").why_wrong(found, scene)
    assert not addon("fog").why_wrong(common.kept(scene)[:0], scene)
    bpy.data.objects.remove(fog)
    bpy.data.objects.remove(floor)
    assert not has_volume(scene)
    scene.world = bpy.data.worlds.new("fog")
    scene.world.use_nodes = True
    nodes = scene.world.node_tree.nodes
    out = next(n for n in nodes if n.type == "OUTPUT_WORLD")
    scatter = nodes.new("ShaderNodeVolumeScatter")
    scene.world.node_tree.links.new(scatter.outputs[0], out.inputs["Volume"])
    assert has_volume(scene)


def _lines_of(layer):
    """Switches Freestyle on for a view layer; its settings."""
    bpy.context.scene.render.use_freestyle = layer.use_freestyle = True
    settings = layer.freestyle_settings
    if not settings.linesets:
        settings.linesets.new("lines")
    return settings


@check
def freestyle_lines_stay_sharp():
    """Blender's own depth of field has them sharp too; the pass comes and goes."""
    scene, data = start(views=4)
    layer = scene.view_layers[0]
    data.rack_focus.views = 1
    blurred = rgba(render(scene, OUT / "fs.exr"))
    data.rack_focus.views = 4
    settings = _lines_of(layer)
    made = rgba(render(scene, OUT / "fs.exr"))
    assert settings.as_render_pass and not last_message(scene), last_message(scene)
    assert any(
        "one view" in t for t in addon("views").describe(data.rack_focus, scene, 4)
    )
    assert "Freestyle" in addon("parts").why_not(scene)
    ((found, _),) = common.kept(scene)
    alpha = found.lines[..., 3:]
    assert (alpha == 1).mean() > 0.02, (alpha == 1).mean()
    assert np.allclose(made, blurred * (1 - alpha) + found.lines, atol=1e-6)
    bpy.ops.rack_focus.refocus()
    same(common.result(scene, OUT / "fs_result.exr"), made)
    data.rack_focus.enabled, data.dof.use_dof = False, True
    assert not settings.as_render_pass
    own = rgba(render(scene, OUT / "fs.exr"))
    is_line = np.repeat(alpha == 1, 4, -1)
    assert np.abs(own - made)[is_line].max() < 0.01
    data.rack_focus.enabled = True
    data.rack_focus.passes_folder = str(OUT / "fs_kept")
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_y = 0.25, 0.75
    part = rgba(render(scene, OUT / "fs.exr"))
    addon("passes").forget(scene)
    files = addon("keep").KeptFiles(scene, OUT / "fs_kept", scene.frame_current)
    ((seen, _),) = files.views("ViewLayer")
    assert seen.lines.shape == seen.colour.shape and seen.lines[..., 3].max() == 1
    data.rack_focus.enabled = False
    own, inside = rgba(render(scene, OUT / "fs.exr")), np.s_[12:48, 18:72]
    is_line = np.repeat(seen.lines[..., 3:] == 1, 4, -1)
    assert np.abs(own - part)[inside][is_line].max() < 0.01
    scene.render.use_border, data.rack_focus.passes_folder = False, ""
    assert not settings.as_render_pass
    settings.as_render_pass = data.rack_focus.enabled = True  # the user's own
    same(rgba(render(scene, OUT / "fs.exr")), blurred)
    scene.render.use_freestyle = False
    render(scene, OUT / "fs.exr")
    assert settings.as_render_pass
