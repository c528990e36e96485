# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of several views and their mean, run inside Blender in the order of this file.

view_checks.py DIST OUT [CHECK ...]    writes OUT/view_results.json
"""

import json
import math
import shutil
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import BASE, OUT, Checks, heard, key_focus  # noqa: E402
from common import (  # noqa: E402
    Watch,
    addon,
    copy_of,
    emitter,
    kept,
    last_message,
    pinhole,
    render,
    rgba,
    same,
    settings_of,
    snapshot,
    start,
    tpsnr,
    unchanged,
)


def prepare():
    """Views rendered together, 16 samples."""
    addon("one_by_one").multiview_works = True
    bpy.context.scene.cycles.samples = 16


check = Checks(prepare)


def result(name):
    """The picture as it stands, (height, width, 4)."""
    path = OUT / f"{name}.exr"
    common.set_output(bpy.context.scene, path)
    bpy.data.images["Render Result"].save_render(str(path), scene=bpy.context.scene)
    return rgba(common.read(path))


def physical(scene, samples=256):
    """Cycles' own depth of field."""
    data, kept_samples = scene.camera.data, scene.cycles.samples
    data.rack_focus.enabled, data.dof.use_dof = False, True
    scene.cycles.samples = samples
    made = rgba(render(scene, OUT / "physical.exr"))
    data.rack_focus.enabled, data.dof.use_dof = True, False
    scene.cycles.samples = kept_samples
    return made


# ---- the pictures -----------------------------------------------------------------


def lens_options(scene):
    """The lens as options of the command."""
    params = addon("lens").camera_parameters(scene.camera, scene.render)
    names = ("focus_distance", "f_stop", "blades", "blade_rotation")
    return {name: params[name] for name in names}


@check
def f12_merges_what_it_keeps():
    """The tests compare node and command on the kept files, refocused too."""
    shutil.rmtree(OUT / "kept", ignore_errors=True)
    scene, data = start(views=4, clean_edges=True, passes_folder=str(OUT / "kept"))
    data.dof.aperture_blades = 6
    data.dof.aperture_ratio = 1.25
    data.shift_x = 0.1
    render(scene, OUT / "views4.exr")
    assert not last_message(scene), last_message(scene)
    files = sorted(path.name for path in (OUT / "kept").iterdir())
    assert files == [f"passes0001_v{i:02}.exr" for i in range(4)], files
    data.dof.focus_distance = 1.6
    data.dof.aperture_fstop = 0.3
    data.dof.aperture_blades = 5
    scene.cycles.seed = 99  # a new render would differ
    for _ in range(2):
        assert bpy.ops.rack_focus.refocus() == {"FINISHED"}
    result("views4_refocused")
    (OUT / "view_lens.json").write_text(json.dumps(lens_options(scene)))
    assert len(list((OUT / "kept").iterdir())) == 4


@check
def accumulate_is_the_mean():
    """Bit for bit what rackfocus.accumulate() makes of the views that it keeps."""
    shutil.rmtree(OUT / "kept_mean", ignore_errors=True)
    scene, data = start(
        views=5, method="accumulate", passes_folder=str(OUT / "kept_mean")
    )
    made = rgba(render(scene, OUT / "mean5.exr"))
    assert not last_message(scene), last_message(scene)
    views = kept(scene)
    assert len(views) == 5
    library = addon("library").rackfocus
    same(made, library.accumulate(layer.colour for layer, _ in views))
    # The same views can be merged, and then refocused.
    data.rack_focus.method = "views"
    bpy.ops.rack_focus.refocus()
    merged = result("merged5")
    assert np.abs(made - merged).max() > 0.01
    assert not last_message(scene), last_message(scene)


@check
def the_mean_converges_to_the_hosts_own():
    """More views come nearer to Cycles' own depth of field; 8 samples a view."""
    scene, data = start(method="accumulate")
    wanted = physical(scene, 1024)
    scores = {}
    for n in (8, 16, 32):
        data.rack_focus.views, scene.cycles.samples = n, 8 * n
        scores[n] = round(tpsnr(rgba(render(scene, OUT / "c.exr")), wanted), 2)
        assert not last_message(scene), last_message(scene)
    print("CONVERGES", json.dumps(scores))
    assert sorted(scores.values()) == list(scores.values()), scores
    assert scores[32] > scores[8] + 6, scores


@check
def views_beat_one_view():
    """Against Cycles' own depth of field, the samples the same."""
    scene, data = start(views=8)
    scene.cycles.samples = 64
    eight = rgba(render(scene, OUT / "w.exr"))
    data.rack_focus.views = 1
    one = rgba(render(scene, OUT / "w.exr"))
    wanted = physical(scene)
    scores = {"one": tpsnr(one, wanted), "eight": tpsnr(eight, wanted)}
    print("VIEWS", scores)
    assert scores["eight"] > scores["one"] + 0.3, scores


@check
def orthographic_views():
    """Blender has no sheared orthographic camera; the views are so all the same."""
    scene, data = start(views=8)
    data.type, data.ortho_scale, data.dof.aperture_fstop = "ORTHO", 4, 2
    scene.cycles.samples = 128
    eight = rgba(render(scene, OUT / "w.exr"))
    assert not last_message(scene), last_message(scene)
    data.rack_focus.method, data.rack_focus.views = "accumulate", 32
    mean = rgba(render(scene, OUT / "w.exr"))
    data.rack_focus.method, data.rack_focus.views = "layered", 1
    one = rgba(render(scene, OUT / "w.exr"))
    wanted = physical(scene)
    scores = [tpsnr(picture, wanted) for picture in (one, eight, mean)]
    print("ORTHO", scores)
    assert scores[1] > scores[0] + 1 and scores[2] > scores[0] + 4, scores


@check
def every_pattern_and_camera():
    """Patterns of the core; random ones differ per frame, fixed ones do not."""
    scene, data = start(views=6, method="accumulate")
    lens = addon("lens").camera_parameters(scene.camera, scene.render)
    radius = addon("library").rackfocus.Lens(72, 48, **lens).lens_radius
    menu = data.rack_focus.bl_rna.properties["lens_pattern"].enum_items
    assert {"disc", "circle", "polygon", "grid"} <= {i.identifier for i in menu}
    data.dof.aperture_blades = 5
    found = {}
    for item in menu:
        data.rack_focus.lens_pattern = item.identifier
        bpy.ops.render.render()
        assert not last_message(scene), last_message(scene)
        places = np.array([place.offset for _, place in kept(scene)]) / radius
        lengths = np.hypot(*places.T)
        assert lengths.max() < 1 + 1e-6
        if item.identifier == "circle":
            assert np.allclose(lengths, 1, atol=1e-6)
        found[item.identifier] = places
    assert np.array_equal(found["auto"], found["polygon"])
    assert not np.array_equal(found["disc"], found["polygon"])
    for is_random in (False, True):
        data.rack_focus.lens_random = is_random
        places = []
        for frame in (1, 2):
            scene.frame_set(frame)
            bpy.ops.render.render()
            places.append([place.offset for _, place in kept(scene)])
        assert (places[0] != places[1]) == is_random


@check
def every_method_with_views():
    """Those that take one view take the first, the others all of them."""
    scene, data = start(views=3)
    bpy.ops.render.render()
    views = kept(scene)
    library = addon("library").rackfocus
    for method in library.methods():
        data.rack_focus.method = method.name
        bpy.ops.rack_focus.refocus()
        assert not last_message(scene), (method.name, last_message(scene))
        made = result("method")
        height, width = made.shape[:2]
        params = addon("lens").frame_parameters(
            scene.camera, data.rack_focus, scene.render, (width, height)
        )
        expected = np.empty_like(made)
        if method.name in ("layered", "views"):
            merge = library.Filter(width, height, **{**params, "method": "views"})
            merge.process_views(
                [(v.colour, v.depth, p.offset, p.shear_distance) for v, p in views],
                expected,
            )
        elif method.name == "accumulate":
            library.accumulate((v.colour for v, _ in views), expected)
        else:
            one = library.Filter(width, height, **params)
            one.process(views[0][0].colour, views[0][0].depth, expected)
        same(made, expected)


# ---- the views --------------------------------------------------------------------


def render_from(scene, matrix, shift):
    """Depth of a render through a camera of its own; matrix: of its object."""
    camera = scene.camera.copy()
    camera.data = scene.camera.data.copy()
    camera.animation_data_clear()
    camera.parent = None
    camera.matrix_world = matrix
    camera.data.animation_data_clear()
    camera.data.shift_x, camera.data.shift_y = shift
    scene.collection.objects.link(camera)
    main, scene.camera = scene.camera, camera
    found = common.depth_of(pinhole(scene, OUT / "from.exr"))
    scene.camera = main
    bpy.data.objects.remove(camera)
    return found


@check
def views_are_taken_from_points_of_the_lens():
    """The depth of each view is that of a camera put there by hand, to the bit.

    The camera moves, is scaled and parented; its lens, shift and focus are animated.
    """
    scene, data = start(views=3)
    holder = bpy.data.objects.new("holder", None)
    scene.collection.objects.link(holder)
    camera = scene.camera
    camera.parent, camera.scale, holder.scale = holder, (2, 2, 2), (1.5, 1.5, 1.5)
    data.sensor_fit, data.sensor_height = "VERTICAL", 20
    for frame, x, focal, focus in ((1, 0, 50, 3), (5, 0.4, 70, 2)):
        holder.location = (x, 0, x / 2)
        holder.rotation_euler = (0, x / 3, x / 4)
        data.lens, data.dof.focus_distance, data.shift_x = focal, focus, x / 4
        holder.keyframe_insert("location", frame=frame)
        holder.keyframe_insert("rotation_euler", frame=frame)
        data.keyframe_insert("lens", frame=frame)
        data.keyframe_insert("shift_x", frame=frame)
        data.dof.keyframe_insert("focus_distance", frame=frame)
    scene.frame_set(4)
    bpy.ops.render.render()
    assert not last_message(scene), last_message(scene)
    views = kept(scene)
    radius = data.lens * 1e-3 / (2 * data.dof.aperture_fstop)
    unscaled = camera.matrix_world.normalized()
    data.rack_focus.views = 1
    for layer, place in views:
        (u, v), distance = place.offset, place.shear_distance
        assert 0 < math.hypot(u, v) < radius
        assert math.isclose(distance, data.dof.focus_distance, rel_tol=1e-6)
        to_shift = data.lens / (distance * data.sensor_height)
        shift = (data.shift_x - u * to_shift, data.shift_y - v * to_shift)
        moved = unscaled @ Matrix.Translation((u, v, 0))
        depth = render_from(scene, moved, shift)
        is_far = np.maximum(depth, layer.depth) > 1e9
        off = np.abs(layer.depth / depth - 1)
        # A ray that just grazes an edge may hit or miss.
        assert (off > 1e-4).mean() < 0.005, (off > 1e-4).mean()
        assert not is_far.all()


@check
def samples_are_divided_and_seeds_differ():
    """In the copy only; each view has noise of its own."""
    scene, data = start(views=4)
    data.dof.aperture_fstop = 1e5  # all views from nearly the same point
    scene.cycles.use_adaptive_sampling = True
    scene.cycles.adaptive_threshold = 0.01

    def look():
        cycles = copy_of(scene).cycles
        return cycles.samples, round(cycles.adaptive_threshold, 6), scene.cycles.samples

    with Watch(look) as seen:
        bpy.ops.render.render()
    assert seen == [(4, 0.02, 16)], seen
    pictures = [layer.colour for layer, _ in kept(scene)]
    noise = [picture - sum(pictures) / 4 for picture in pictures]
    for i, a in enumerate(noise):
        for b in noise[:i]:
            assert np.corrcoef(a.ravel(), b.ravel())[0, 1] < 0.2
    scene.cycles.samples = 2
    with Watch(look) as seen:
        bpy.ops.render.render()
    assert seen[0][0] == 1


def wall(scene, distance):
    """Small cubes of random colours whose fronts lie in the plane in focus."""
    for item in [o for o in scene.objects if o.type == "MESH"]:
        bpy.data.objects.remove(item)
    rng = np.random.default_rng(7)
    for x in np.arange(-2.7, 2.7, 0.3):
        for z in np.arange(-1.8, 1.8, 0.3):
            emitter("tile", rng.random(3), 0.3, (x, distance + 0.15, z))


@check
def the_plane_in_focus_stays():
    """Sheared views keep all of it as sharp as the pinhole, turned ones the middle."""
    scene, data = start(method="accumulate", views=8)
    wall(scene, 3)
    data.lens = 30
    scene.cycles.samples = 128
    sharp = rgba(pinhole(scene, OUT / "plane.exr"), "ViewLayer")
    scores, middle = {}, np.s_[20:28, 31:41]
    for name, move, f_stop in (
        ("noise", "shift", 1e6),  # pinholes with the same samples
        ("shift", "shift", 0.05),
        ("look at", "look_at", 0.05),
    ):
        data.rack_focus.camera_move, data.dof.aperture_fstop = move, f_stop
        made = rgba(render(scene, OUT / "plane.exr"))
        assert not last_message(scene), last_message(scene)
        scores[name] = tpsnr(made, sharp)
        scores[f"{name} middle"] = tpsnr(made[middle], sharp[middle])
    print("PLANE", scores)
    assert scores["shift"] > scores["noise"] - 0.5, scores
    assert scores["look at"] < scores["shift"] - 6, scores
    assert scores["look at middle"] > scores["look at"] + 6, scores
    data.rack_focus.method = "views"
    bpy.ops.rack_focus.refocus()
    assert "Look At" in last_message(scene)


@check
def spread_over_the_shutter():
    """Views at moments of their own: motion blur as Cycles makes it."""
    scene, data = start(method="accumulate", views=16, shutter_spread=True)
    for item in [o for o in scene.objects if o.type == "MESH"][1:]:
        bpy.data.objects.remove(item)
    cube = next(o for o in scene.objects if o.type == "MESH")
    for frame, x in ((1, -0.6), (5, 0.6)):
        cube.location = (x, 3, 0)
        cube.keyframe_insert("location", frame=frame)
    for curve in common.curves_of(cube):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    scene.frame_set(3)
    scene.render.motion_blur_shutter = 0.75
    scene.cycles.samples = 256
    common.set_output(scene, OUT / "m.exr")
    before = settings_of(scene)
    spread = rgba(render(scene, OUT / "m.exr"))
    assert not last_message(scene), last_message(scene)
    assert len(kept(scene)) == 16
    unchanged(scene, before)
    data.rack_focus.shutter_spread = False
    still = rgba(render(scene, OUT / "m.exr"))
    scene.render.use_motion_blur = True
    moved = physical(scene)
    scores = tpsnr(spread, moved), tpsnr(still, moved)
    print("SHUTTER", scores)
    assert scores[0] > scores[1] + 6 and scores[0] > 30, scores


def the_panel_says_what_views_cost(scene, settings):
    """Time against one render, and where one view is better; no advice that loses."""
    kept_samples = scene.cycles.samples
    for whole, n, each, cost, is_hinted in (
        (64, 8, 0, "8 views of 8 samples: 1 × the time of one render", True),
        (256, 8, 0, "8 views of 32 samples: 1 × the time of one render", False),
        (64, 4, 64, "4 views of 64 samples: 4 × the time of one render", False),
    ):
        scene.cycles.samples, settings.view_samples = whole, each
        lines = addon("views").describe(settings, scene, n)
        assert lines[0] == cost, lines
        assert any("one view may be" in line for line in lines) == is_hinted, lines
    scene.cycles.samples, settings.view_samples = kept_samples, 0


@check
def samples_of_a_view_are_those_of_the_panel():
    """Neither divided, nor the noise threshold changed; 0 shares them out."""
    scene, data = start(views=2, view_samples=7)
    found = []
    for each in (7, 0):
        data.rack_focus.view_samples = each
        with Watch(lambda: copy_of(scene).cycles.samples) as seen:
            bpy.ops.render.render()
        found += seen
    assert found == [7, 8], found


@check
def one_after_another():
    """Where multi-view fails, it says so, and the next render does without."""
    scene, data = start(views=3)
    bpy.ops.render.render()
    together = kept(scene)
    passes = addon("passes")
    whole = passes.RenderedPasses._save

    def lose_one(scene, path):
        whole(scene, path)
        path.with_name("passesRack Focus_v01.exr").unlink(missing_ok=True)

    passes.RenderedPasses._save = staticmethod(lose_one)
    try:
        common.set_output(scene, OUT / "lost.exr")
        bpy.ops.render.render(write_still=True)
    except RuntimeError as error:
        assert "2 of 3 views" in str(error), error
    finally:
        passes.RenderedPasses._save = whole
    assert "one after another" in last_message(scene)
    assert result("lost").max() > 0.1  # never black
    lines = addon("views").describe(data.rack_focus, scene, 3)
    at = lines.index("The views are rendered one after another")
    assert "anew" in lines[at + 1], lines
    the_panel_says_what_views_cost(scene, data.rack_focus)
    before = settings_of(scene)
    bpy.ops.render.render()
    assert not last_message(scene), last_message(scene)
    unchanged(scene, before)
    for (a, place), (b, other) in zip(together, kept(scene), strict=True):
        assert place == other
        assert (np.abs(a.depth / b.depth - 1) > 1e-4).mean() < 0.005
        assert np.abs(a.colour - b.colour).mean() < 0.02


# ---- nothing else changes ---------------------------------------------------------


@check
def the_scene_is_not_touched():
    """Not even while it renders, but for where its node looks."""
    scene, data = start(views=3)
    data.dof.use_dof = True
    before, state = settings_of(scene), snapshot(scene)

    def look():
        render = scene.render
        return render.use_multiview, scene.cycles.samples, len(render.views)

    with Watch(look) as seen:
        bpy.ops.render.render()
    assert seen == [(False, 16, 2)], seen
    unchanged(scene, before)
    assert snapshot(scene) == state


@check
def restored_after_cancel_and_error():
    """Esc in the filter, an error in it, an error before the views begin."""
    scene, data = start(views=3)
    engine, views = addon("engine"), addon("views")
    before, state = settings_of(scene), snapshot(scene)

    def fail(*_):
        raise KeyError("a test")

    for owner, name, do, text in (
        (engine.RackFocusEngine, "_report", lambda *_: False, "stopped"),
        (views, "process", fail, "a fault"),
        (views, "_take", fail, "a fault"),
        (views, "follow", fail, "not placed"),
        (addon("view_cameras"), "add", fail, "a test"),
        (addon("handover"), "begin", fail, "a test"),
    ):
        whole = getattr(owner, name)
        setattr(owner, name, do)
        try:
            bpy.ops.render.render()
        except RuntimeError:
            pass
        finally:
            setattr(owner, name, whole)
        unchanged(scene, before)
        assert snapshot(scene) == state, name
        assert text in last_message(scene), (name, last_message(scene))
    bpy.ops.render.render()
    assert len(kept(scene)) == 3 and not last_message(scene)


@check
def restored_when_a_crashed_file_opens():
    """A file saved in the middle of a render, together and one after another."""
    for is_spread in (False, True):
        bpy.ops.wm.open_mainfile(filepath=str(BASE))
        scene, data = start(views=3, method="accumulate", shutter_spread=is_spread)
        before = [x for x in settings_of(scene) if "scene" not in str(x)]
        state, names = snapshot(scene), sorted(s.name for s in bpy.data.scenes)
        addon("views").begin(scene)
        assert len(bpy.data.scenes) > 2
        assert settings_of(scene) != before
        path = str(OUT / "view_crash.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
        addon("views").end(scene)
        bpy.ops.wm.open_mainfile(filepath=path)
        scene = bpy.context.scene
        assert sorted(s.name for s in bpy.data.scenes) == names
        assert snapshot(scene)[1:] == state[1:]
        kinds = ("scenes", "objects", "cameras", "node_groups")
        assert [snapshot(scene)[0][k] for k in kinds] == [state[0][k] for k in kinds]
        after = [x for x in settings_of(scene) if "scene" not in str(x)]
        assert after == before, [
            x for x in zip(before, after, strict=True) if x[0] != x[1]
        ]
        bpy.ops.render.render()
        assert len(kept(scene)) == 3 and not last_message(scene)


@check
def nodes_in_any_order():
    """The filter's node first in the tree, none of the scene's own, one muted."""
    scene, data = start(views=3)
    tree, setup = common.tree_of(scene), addon("setup")
    wanted = rgba(render(scene, OUT / "w.exr"))
    source = setup.layer_nodes(tree, scene)[0]
    source.mute = True
    same(rgba(render(scene, OUT / "w.exr")), wanted)
    assert source.mute
    tree.nodes.remove(source)
    before = settings_of(scene)
    same(rgba(render(scene, OUT / "w.exr")), wanted)
    unchanged(scene, before)
    late = tree.nodes.new("CompositorNodeRLayers")
    late.scene = scene
    before = settings_of(scene)
    same(rgba(render(scene, OUT / "w.exr")), wanted)
    unchanged(scene, before)
    node = setup.layer_nodes(tree, scene.rack_focus.filter_scene)[0]
    out = addon("compat").output_socket(tree)
    tree.links.new(node.outputs["Depth"], out)
    depth = rgba(render(scene, OUT / "w.exr"))[..., 0]
    same(depth, kept(scene)[0][0].depth)


@check
def the_users_other_passes():
    """A pass that the nodes use comes from one of the views."""
    scene, data = start(views=3)
    tree = common.tree_of(scene)
    source = addon("setup").layer_nodes(tree, scene)[0]
    out = addon("compat").output_socket(tree)
    tree.links.new(source.outputs["Depth"], out)
    made = rgba(render(scene, OUT / "u.exr"))[..., 0]
    assert not last_message(scene), last_message(scene)
    assert any(np.array_equal(made, layer.depth) for layer, _ in kept(scene))
    assert source.scene == scene


@check
def cameras_bound_to_markers_with_views():
    """Three views, none, two: as the camera of the frame says."""
    scene, data = start(views=3)
    other = scene.camera.copy()
    other.data = data.copy()
    other.data.rack_focus.enabled = False
    third = scene.camera.copy()
    third.data = data.copy()
    third.data.rack_focus.views = 2
    third.location.x = 0.3
    for camera in (other, third):
        scene.collection.objects.link(camera)
    for frame, camera in ((1, scene.camera), (2, other), (3, third)):
        scene.timeline_markers.new("m", frame=frame).camera = camera
    scene.frame_start, scene.frame_end = 1, 3
    common.set_output(scene, OUT / "vmark_####.exr")
    counts = []
    with Watch(lambda: counts.append(len(kept(scene)))):
        bpy.ops.render.render(animation=True)
    assert counts == [3, 1, 2], counts
    made = [rgba(common.read(OUT / f"vmark_{f:04d}.exr")) for f in (1, 2, 3)]
    scene.timeline_markers.clear()
    for frame, camera, picture in zip(
        (1, 2, 3), (None, other, third), made, strict=True
    ):
        scene.frame_set(frame)
        scene.camera = camera or scene.camera
        same(rgba(render(scene, OUT / "vm.exr")), picture)


def open_panorama(data):
    """A panoramic camera with its own depth of field, which stays on."""
    data.type = "PANO"
    data.dof.use_dof, data.dof.aperture_fstop = True, 0.02


# What makes a camera one that cannot be filtered, and what the message says.
UNFILTERED = (
    ("another type", lambda data: setattr(data, "type", "PANO")),
    ("another type", open_panorama),
    ("focused on itself", lambda data: setattr(data.dof, "focus_distance", 0)),
)
MANY = (
    {"views": 4},
    {"views": 4, "view_samples": 3},
    {"supersample": 2},
    {"views": 2, "supersample": 2},
    {"views": 2, "method": "accumulate", "shutter_spread": True},
)


@check
def a_camera_that_cannot_be_filtered():
    """One view with all samples, bit for bit the plain one; and it is said."""
    for words, spoil in UNFILTERED:
        for settings in MANY:
            bpy.ops.wm.open_mainfile(filepath=str(BASE))
            scene = bpy.context.scene
            scene.cycles.samples = 16
            spoil(scene.camera.data)
            plain = rgba(render(scene, OUT / "unfiltered.exr"))
            _, data = start(**settings)
            before = settings_of(scene)
            try:
                made = rgba(render(scene, OUT / "unfiltered.exr"))
            except RuntimeError as error:
                assert words in str(error), error
                made = rgba(common.read(OUT / "unfiltered.exr"))
            assert words in last_message(scene), last_message(scene)
            same(made, plain)
            unchanged(scene, before)
            lines = addon("views").describe(data.rack_focus, scene, 4)
            assert lines == ["The picture is not filtered: one view is rendered"], lines
            lines = addon("ui").describe_supersample(data.rack_focus, scene)
            assert "without Supersample" in lines[0], lines


@check
def a_frame_that_cannot_be_filtered():
    """The first one only: its camera is focused on itself."""
    scene, data = start(views=3, supersample=2)
    key_focus(data, {1: 0, 2: 3})
    scene.frame_start, scene.frame_end = 1, 2
    counts = []

    def look():
        copy = copy_of(scene)
        cycles = copy.cycles.samples, copy.cycles.filter_width
        counts.append((len(kept(scene)), copy.render.use_multiview, *cycles))

    common.set_output(scene, OUT / "vfirst_####.exr")
    with Watch(look):
        try:
            bpy.ops.render.render(animation=True)
        except RuntimeError as error:
            assert "focused on itself" in str(error), error
    assert counts[0] == (1, False, 16, scene.cycles.filter_width), counts
    assert counts[1][:3] == (3, True, 1), counts
    assert counts[1][3] < scene.cycles.filter_width / 2, counts
    made = [rgba(common.read(OUT / f"vfirst_{f:04d}.exr")) for f in (1, 2)]
    scene.frame_set(2)
    same(rgba(render(scene, OUT / "vf.exr")), made[1])
    data.rack_focus.enabled = False
    scene.frame_set(1)
    same(rgba(render(scene, OUT / "vf.exr")), made[0])


@check
def border_and_layers_with_views():
    """A part of the frame; two view layers over transparent film."""
    scene, data = start(views=3)
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.25, 1.0
    for is_cropped in (True, False):
        scene.render.use_crop_to_border = is_cropped
        made = rgba(render(scene, OUT / "vb.exr"))
        assert not last_message(scene), last_message(scene)
        assert made.shape[:2] == ((36, 36) if is_cropped else (48, 72))
        if is_cropped:
            cropped = made
        else:
            same(made[:36, 18:54], cropped)
    scene.render.use_border = False
    data.rack_focus.enabled = False
    scene.render.film_transparent = True
    scene.view_layers.new("Front")
    data.rack_focus.enabled = True
    rgba(render(scene, OUT / "vl.exr"))
    assert not last_message(scene), last_message(scene)
    found = addon("passes").rendered(scene)
    assert [len(found.views(n)) for n in ("ViewLayer", "Front")] == [3, 3]


@check
def stereo_is_rendered_in_one_view():
    """And the panel and the console say so; nothing where views are rendered."""
    scene, data = start(views=4, supersample=2)
    with heard() as said:
        bpy.ops.render.render()
    assert not said.getvalue(), said.getvalue()
    scene.render.use_multiview = True
    scene.render.views_format = "STEREO_3D"
    with heard() as said:
        bpy.ops.render.render()
    words = "With stereo, one view is rendered. Supersample does not work with stereo."
    assert words in said.getvalue(), said.getvalue()
    assert not last_message(scene), last_message(scene)
    assert len(addon("passes").rendered(scene).views("ViewLayer", "_L", "left")) == 1
    lines = addon("views").describe(data.rack_focus, scene, 4)
    assert lines == ["With stereo, one view is rendered"]


# ---- kept files -------------------------------------------------------------------


@check
def refocus_from_files():
    """After the file was closed: the same picture from the folder."""
    folder = OUT / "kept_again"
    shutil.rmtree(folder, ignore_errors=True)
    scene, data = start(views=3, passes_folder=str(folder))
    made = rgba(render(scene, OUT / "ra.exr"))
    path = str(OUT / "kept.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    assert bpy.ops.rack_focus.refocus() == {"FINISHED"}
    assert not last_message(scene), last_message(scene)
    same(result("rb"), made)
    (folder / "passes0001_v01.exr").write_bytes(b"v/1\x01\x02\0\0\0channels\0")
    bpy.ops.wm.open_mainfile(filepath=path)
    try:
        bpy.ops.rack_focus.refocus()
    except RuntimeError as error:
        assert "damaged" in str(error), error
    assert "damaged" in last_message(bpy.context.scene)


@check
def a_folder_that_cannot_be_written():
    """The picture is filtered all the same, and the reason is told."""
    scene, data = start(views=2)
    wanted = rgba(render(scene, OUT / "rf.exr"))
    (OUT / "a_file").write_text("")
    data.rack_focus.passes_folder = str(OUT / "a_file" / "folder")
    try:
        common.set_output(scene, OUT / "rf.exr")
        bpy.ops.render.render(write_still=True)
    except RuntimeError as error:
        assert "cannot be written" in str(error)
    assert "cannot be written" in last_message(scene)
    assert "not filtered" not in last_message(scene)
    same(result("rf2"), wanted)


@check
def many_renders_with_views():
    """Memory does not grow, nothing stays behind."""
    scene, data = start(
        views=3, quality="custom", sub_apertures=1, exact_highlights=False
    )
    scene.cycles.samples = 3
    for count in range(90):
        bpy.ops.render.render()
        if count == 30:
            before = common.resident_bytes()
    grown = (common.resident_bytes() - before) / 2**20
    print("MEMORY", f"{grown:.1f} MiB in 60 renders")
    assert grown < 12, f"{grown:.1f} MiB in 60 renders"
    assert len(bpy.data.scenes) == 2 and len(bpy.data.cameras) == 1
    assert not common.own_memory_folders()


checking.run(check, "view_results.json")
