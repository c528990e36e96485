# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of views of few samples and of setups that views have to mind, run inside
Blender.

sampling_checks.py DIST OUT [CHECK ...]    writes OUT/sampling_results.json
"""

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
from checking import OUT, Checks, key_focus, refocused, shot, update  # noqa: E402
from common import (  # noqa: E402
    Watch,
    addon,
    copy_of,
    kept,
    last_message,
    render,
    rgba,
    same,
    set_output,
    settings_of,
    start,
    tpsnr,
    unchanged,
)

check = Checks()


@check
def views_of_few_samples_are_moved_within_their_pixels():
    """By a tiny lens and a plane that is off the focus; the user's camera stays."""
    scene, data = start(views=4)

    def look():
        copy = copy_of(scene)
        own, dof = scene.cycles, bpy.data.objects["Rack Focus_v00"].data.dof
        assert copy.camera == scene.camera
        is_moved = copy.cycles.filter_width < 0.02
        assert is_moved or copy.cycles.filter_width == own.filter_width
        assert is_moved == dof.use_dof and (not is_moved or dof.focus_distance < 0.1)
        return is_moved

    for samples, method, is_moved in (
        (4, "views", True),
        (16, "layered", True),
        (20, "layered", False),
        (16, "accumulate", False),
        (16, "layered", True),
    ):
        scene.cycles.samples, data.rack_focus.method = samples, method
        with Watch(look) as seen:
            bpy.ops.render.render()
        assert seen == [is_moved] and not last_message(scene), (samples, method, seen)
        planes = {place.shear_distance for _, place in kept(scene)}
        is_off = {abs(plane / data.dof.focus_distance - 1) > 1e-3 for plane in planes}
        assert is_off == {is_moved}, planes
        lines = addon("views").describe(data.rack_focus, scene, 4)
        assert not any("does not smooth" in line for line in lines), lines
    assert data.dof.focus_distance == 3 and scene.cycles.filter_width == 1.5


def off_focus_px(scene):
    """Radius along the rows of the blur of the plane that stays in the last render."""
    lens = addon("lens").camera_parameters(scene.camera, scene.render)
    size = addon("lens").picture_size(scene.render)
    made = addon("library").rackfocus.Lens(*size, **lens)
    off_focus = 1 / made.focus_distance - 1 / kept(scene)[0][1].shear_distance
    return off_focus * made.lens_radius * made.focal_length_px


@check
def views_are_moved_within_parts_of_pixels():
    """Where the pixel filter is wide enough for it; kept files say so. Shrinking makes up
    for the disc and for placing views between parts."""
    scene, data = start(views=2, supersample=2)
    supersample, keep = addon("supersample"), addon("keep")
    data.rack_focus.passes_folder = str(OUT / "moved")
    taps_of, made_up_for = supersample.taps_of, []

    def watched(source, scale, spread_px=0.0):
        made_up_for.append(spread_px)
        return taps_of(source, scale, spread_px)

    def look():
        copy = copy_of(scene)
        is_open = bpy.data.objects["Rack Focus_v00"].data.dof.use_dof
        return is_open, round(copy.cycles.filter_width, 2)

    for samples, width, is_moved in ((32, 1.5, True), (40, 1.5, False), (32, 1, False)):
        scene.cycles.samples, scene.cycles.filter_width = samples, width
        supersample.taps_of = watched
        with Watch(look) as seen:
            bpy.ops.render.render()
        supersample.taps_of = taps_of
        narrow = 0.01 if is_moved else 0.52
        assert seen == [(is_moved, narrow)] and not last_message(scene), (width, seen)
        spread_px = 0.5 if is_moved else 0
        (_, place), _ = kept(scene)
        off_px = off_focus_px(scene)
        assert place.spread_px == spread_px, place
        assert np.isclose(abs(off_px), 1.5 / 2 if is_moved else 0, atol=1e-3), off_px
        assert made_up_for.pop() == spread_px and not made_up_for
        folder = OUT / "moved"
        files = keep.KeptFiles(scene, folder, scene.frame_current).views("ViewLayer")
        assert [one.spread_px for _, one in files] == [spread_px] * 2, files
    for scale in (2, 3, 4):
        taps = supersample.weights(scale, "BLACKMAN_HARRIS", 1.5, 0.5)
        at = (np.arange(len(taps)) - (len(taps) - 1) / 2) / scale
        of_views = 0.5**2 / 4 + 1 / (6 * scale**2)
        variance = (taps * at * at).sum() + supersample.MADE_UP_FOR * of_views
        assert np.isclose(variance, 1.5**2 * 0.07674, rtol=0.03), (scale, variance)


@check
def pixels_that_are_not_square_are_spread_alike():
    """Moved views of them are as near to the own lens as those of square ones."""
    scene = bpy.context.scene
    render_of, data = scene.render, scene.camera.data
    render_of.resolution_x, render_of.resolution_y = 120, 80
    data.dof.aperture_fstop = 0.33
    scores = {}
    for aspect in ((1, 1), (2, 1), (1, 2)):
        render_of.pixel_aspect_x, render_of.pixel_aspect_y = aspect
        data.rack_focus.enabled, data.dof.use_dof, scene.cycles.samples = (
            False,
            True,
            512,
        )
        wanted = rgba(render(scene, OUT / "pa.exr"))
        data.dof.use_dof, scene.cycles.samples = False, 32
        start(views=16)
        scores[aspect] = tpsnr(rgba(render(scene, OUT / "pa.exr")), wanted)
        assert abs(off_focus_px(scene) - 1.5 * (aspect[1] / aspect[0]) ** 0.5) < 1e-3
    print("PIXELS", scores)  # without: 44.2, 44.4, 42.3
    assert scores[2, 1] > scores[1, 1] + 0.5 < scores[1, 2] + 1.5, scores


@check
def a_view_of_one_sample_has_smooth_edges():
    """What is in focus is as smooth as one view of all the samples."""
    scene, data = start(views=8)
    data.dof.aperture_fstop = 1e3  # all of it is in focus
    data.rack_focus.views, scene.cycles.samples = 1, 512
    wanted = rgba(render(scene, OUT / "w.exr"))
    scores = {}
    for method in ("views", "accumulate"):  # moved or not
        data.rack_focus.method, data.rack_focus.views = method, 8
        scene.cycles.samples = 8
        scores[method] = tpsnr(rgba(render(scene, OUT / "w.exr")), wanted)
    print("ONE SAMPLE", scores)
    assert scores["views"] > scores["accumulate"] + 1, scores


@check
def no_view_of_few_samples_is_empty_with_motion_blur():
    """What was written in each evaluation left some empty, 4.2 to 5.0; animated too."""
    scene, data = start(views=4)
    scene.render.use_motion_blur, scene.cycles.samples = True, 16
    target = bpy.data.objects.new("target", None)
    scene.collection.objects.link(target)
    for focus in (None, target):
        data.dof.focus_object = focus
        for frame, y in ((0, 2), (4, 4)) if focus else ():
            target.location.y = y
            target.keyframe_insert("location", frame=frame)
        for _ in range(3):
            bpy.ops.render.render()
            assert not last_message(scene), last_message(scene)
            alphas = [float(layer.colour[..., 3].min()) for layer, _ in kept(scene)]
            assert len(alphas) == 4 and min(alphas) > 0.99, (focus, alphas)


def set_offset(scene, offset, length):
    """Leaves the first samples out, and from 4.5 on what is beyond a length."""
    scene.cycles.sample_offset = offset
    if hasattr(scene.cycles, "use_sample_subset"):
        scene.cycles.use_sample_subset = True
        scene.cycles.sample_subset_length = length
        scene.cycles.samples = 1024
    else:
        scene.cycles.samples = length


@check
def a_sample_offset_costs_no_depth():
    """Cycles writes it with the first sample; noise is another for each offset."""
    scene, data = start()
    for n in (1, 4):
        data.rack_focus.views = n
        made = []
        for offset in (0, 1, 65):
            set_offset(scene, offset, 64)
            set_output(scene, OUT / "o.exr")
            before = settings_of(scene)
            made.append(rgba(render(scene, OUT / "o.exr")))
            assert not last_message(scene), last_message(scene)
            unchanged(scene, before)
            assert len(kept(scene)) == n
            assert all(layer.depth.min() < 2 for layer, _ in kept(scene))
        scores = [tpsnr(a, b) for a, b in ((made[0], made[1]), (made[1], made[2]))]
        print("SAMPLE OFFSET", n, scores)
        assert 35 < min(scores) and max(scores) < 70, scores


@check
def samples_of_a_subset_are_shared_out():
    """4 views of a subset of 64 samples have 16 each."""
    scene, _ = start(views=4)
    set_offset(scene, 10, 64)
    assert addon("sampling").samples_of(scene) == 64
    with Watch(lambda: copy_of(scene).cycles.samples) as seen:
        bpy.ops.render.render()
    assert seen == [16], seen


@check
def where_a_sample_offset_leaves_no_depth_the_render_says_so():
    """With stereo nothing renders in the place of the scene: the sharp picture."""
    scene, _ = start()
    scene.render.use_multiview = True
    set_offset(scene, 2, 4)
    bpy.ops.render.render()
    assert "Sample Offset" in last_message(scene), last_message(scene)
    scene.cycles.sample_offset = 0
    bpy.ops.render.render()
    assert not last_message(scene), last_message(scene)


@check
def textures_of_the_view_are_named_where_there_are_views():
    """Window lies in the picture, Camera counts from it, and each view is another one."""
    scene, data = start(views=4)

    def said():
        update()
        lines = addon("views").describe(data.rack_focus, scene, 4)
        return " ".join(line for line in lines if " texture of " in line)

    def linked(owner, node_type, kind="Window"):
        """Such a texture in the nodes of a world or material, linked to a colour."""
        owner.use_nodes = True
        tree = owner.node_tree
        place = tree.nodes.new("ShaderNodeTexCoord")
        shown = next(n for n in tree.nodes if n.type == node_type)
        return tree.links.new(place.outputs[kind], shown.inputs["Color"])

    assert not said()
    scene.world = scene.world or bpy.data.worlds.new("World")
    link = linked(scene.world, "BACKGROUND")
    assert "the world" in said(), said()
    scene.world.node_tree.links.remove(link)
    assert not said(), said()
    link = linked(scene.world, "BACKGROUND", "Camera")  # infinity is the same in all
    assert not said(), said()
    scene.world.node_tree.links.remove(link)
    cube = bpy.data.objects["cube"]
    material = cube.material_slots[0].material
    linked(material, "EMISSION")
    assert f"The Window texture of “{material.name}”" in said(), said()
    other = bpy.data.objects["cube.001"].material_slots[0].material
    linked(other, "EMISSION", "Camera")
    assert f"The Camera texture of “{other.name}”" in said(), said()
    for views, is_told in ((4, True), (1, False)):
        data.rack_focus.views = views
        with checking.heard() as heard:
            bpy.ops.render.render()
        assert ("Window" in heard.getvalue()) == is_told, heard.getvalue()
    cube.hide_render = True
    assert "Window" not in said() and "Camera" in said(), said()


@check
def an_orthographic_camera_that_moves_has_one_view_with_motion_blur():
    """Cycles moves no sheared view: ghosts. A camera that stays has all of them."""
    scene, data = start(views=4)
    data.type, data.ortho_scale, data.dof.aperture_fstop = "ORTHO", 3, 5
    scene.render.use_motion_blur = True
    bpy.ops.render.render()
    assert len(kept(scene)) == 4 and not last_message(scene), last_message(scene)
    key_focus(data, {0: 2.9, 4: 3.1})
    scene.frame_set(2)
    before = settings_of(scene)
    bpy.ops.render.render()
    assert len(kept(scene)) == 1, len(kept(scene))
    assert "Motion Blur" in last_message(scene), last_message(scene)
    assert scene.frame_current == 2
    unchanged(scene, before)
    lines = addon("views").describe(data.rack_focus, scene, 4)
    assert any("one view where this camera moves" in line for line in lines), lines
    assert any("each view prepares" in line for line in lines), lines
    data.rack_focus.method, data.rack_focus.shutter_spread = "accumulate", True
    bpy.ops.render.render()
    assert len(kept(scene)) == 4 and not last_message(scene), last_message(scene)
    scene.render.use_motion_blur, data.rack_focus.method = False, "views"
    bpy.ops.render.render()
    assert len(kept(scene)) == 4 and not last_message(scene), last_message(scene)


@check
def clean_edges_of_several_views():
    """Denoising Depth of each is read, and what else came with it is let go."""
    scene, data = start(views=2)
    scene.cycles.samples = 16
    for supersample in (1, 2):
        data.rack_focus.supersample = supersample
        made = []
        for data.rack_focus.clean_edges in (False, True):
            made.append(shot(scene, "ce.exr"))
            views = kept(scene)
            assert not last_message(scene), last_message(scene)
            has_rays = [layer.rays is not None for layer, _ in views]
            assert has_rays == [data.rack_focus.clean_edges] * 2, has_rays
            found = addon("passes").rendered(scene)
            assert not any(found.guides("ViewLayer", j) for j in range(2))
            size = views[0][0].depth.shape
            assert size == (48 * supersample, 72 * supersample), size
        assert (made[0] != made[1]).any()
        same(refocused(scene, "ce.exr"), made[1])


@check
def memory_of_views_is_said():
    """What they take while they are merged and cleaned, not what is kept of them alone."""
    scene, data = start(views=8)
    scene.cycles.samples = 64
    data.rack_focus.supersample = 2
    said = "The views need some {} GB of memory"
    for width, is_denoised, is_clean, line in (
        (72, False, False, None),
        (1920, False, False, said.format(8)),  # 8 x 3840 x 2160 x 120 bytes
        (1920, False, True, said.format(10)),
        (1920, True, True, said.format(19)),
    ):
        data.rack_focus.clean_edges = is_clean
        scene.render.resolution_x, scene.render.resolution_y = width, width * 9 // 16
        scene.cycles.use_denoising = is_denoised
        lines = addon("views").describe(data.rack_focus, scene, 8)
        found = [text for text in lines if text.startswith("The views need")]
        assert found == ([line] if line else []), (width, is_denoised, lines)


@check
def views_of_another_plane_of_pixels_that_are_not_square():
    """Merged as those of the plane in focus are, up to what they show and do not."""
    scene, _ = start(views=4)
    scene.render.pixel_aspect_y, scene.cycles.samples = 1.6, 128
    sampling, pictures = addon("sampling"), []
    whole = sampling.plane_in_place

    def four_px_off(made, *_):
        return 1 / (
            1 / made.focus_distance - 4 / made.lens_radius / made.focal_length_px
        )

    for sampling.plane_in_place in (whole, four_px_off):
        pictures.append(rgba(render(scene, OUT / "aspect.exr")))
        assert not last_message(scene), last_message(scene)
    sampling.plane_in_place = whole
    found = tpsnr(*pictures)
    print("ASPECT", found)
    assert found > 35, found


@check
def persistent_data_that_is_dropped_is_said():
    """Blender prepares what stands still anew where its nodes show a second scene."""
    scene = bpy.context.scene
    describe = addon("persistent").describe
    assert not describe(scene)
    scene.render.use_persistent_data = True
    scene.frame_start, scene.frame_end = 1, 2
    set_output(scene, OUT / "persistent_####.exr")
    found = []

    def look(seen, depsgraph=None):
        if (
            depsgraph is not None
            and depsgraph.mode == "RENDER"
            and len(seen.objects) > 9
        ):
            found.append(any(one.is_updated_geometry for one in depsgraph.updates))

    bpy.app.handlers.frame_change_post.append(look)
    for views, is_dropped in ((0, False), (1, True), (2, True)):
        if views:
            start(views=views)
        bpy.ops.render.render(animation=True)
        assert found == [True, is_dropped], (views, found)
        found.clear()
    bpy.app.handlers.frame_change_post.remove(look)
    assert "no effect" in describe(scene)[0]


checking.run(check, "sampling_results.json")
