# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of Finish, Supersample and denoised views, run inside Blender.

finish_checks.py DIST OUT [CHECK ...]    writes OUT/finish_results.json

RACKFOCUS_OIDN names Open Image Denoise, where a Blender has none of its own.
"""

import os
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import OUT, Checks, heard, key_focus  # noqa: E402
from common import (  # noqa: E402
    addon,
    filtered,
    last_message,
    pinhole,
    render,
    rgba,
    same,
    snapshot,
    start,
    tpsnr,
)


def prepare():
    """16 samples, so that a quarter of them is more than one."""
    bpy.context.scene.cycles.samples = 16


check = Checks(prepare)


def result(scene):
    """The picture as it stands."""
    return common.result(scene, OUT / "f_result.exr")


def own_lens(scene, samples):
    """The camera's own depth of field, without Rack Focus."""
    data = scene.camera.data
    kept = data.rack_focus.enabled, data.dof.use_dof, scene.cycles.samples
    data.rack_focus.enabled, data.dof.use_dof = False, True
    scene.cycles.samples = samples
    made = rgba(render(scene, OUT / "f_own.exr"))
    data.rack_focus.enabled, data.dof.use_dof, scene.cycles.samples = kept
    return made


def leaves_nothing(scene, before):
    """Unticked, the scene is as in an earlier snapshot()."""
    scene.camera.data.rack_focus.enabled = False
    after = snapshot(scene)
    before[0]["images"] = after[0]["images"]
    assert after == before, (before, after)
    assert not common.own_memory_folders()


# ---- supersample ------------------------------------------------------------------


@check
def weights_of_the_pixel_filter():
    """They sum to 1, are even, and spread light as the filter itself does."""
    supersample = addon("supersample")
    for kind, width in (("BLACKMAN_HARRIS", 1.5), ("GAUSSIAN", 1.5), ("BOX", 1.5)):
        wanted = None
        for scale in (2, 3, 4, 16):
            taps = supersample.weights(scale, kind, width)
            assert np.isclose(taps.sum(), 1) and np.allclose(taps, taps[::-1])
            at = (np.arange(len(taps)) - (len(taps) - 1) / 2) / scale
            variance = (taps * at * at).sum() + 1 / (12 * scale**2)
            wanted = wanted or variance
            assert np.isclose(variance, wanted, rtol=0.03), (kind, scale, variance)
    for kind, scale in (
        ("BLACKMAN_HARRIS", 2),
        ("GAUSSIAN", 3),
        ("BLACKMAN_HARRIS", 4),
    ):
        taps = supersample.weights(scale, kind, 0.01)  # the least that Cycles takes
        assert np.isclose(taps.sum(), 1) and (taps > 0).sum() == 2 - scale % 2, taps
    rng = np.random.default_rng(1)
    picture = rng.random((12, 18, 4), np.float32)
    taps = supersample.weights(3, "BOX", 1)
    blocks = picture.reshape(4, 3, 6, 3, 4).mean((1, 3))
    assert np.allclose(supersample.shrink(picture, 3, taps), blocks, atol=1e-6)
    flat = np.full((8, 8, 1), 0.5, np.float32)
    taps = supersample.weights(2, "BLACKMAN_HARRIS", 1.5)
    assert np.allclose(supersample.shrink(flat, 2, taps), 0.5, atol=1e-6)


@check
def the_supersampled_picture():
    """Larger passes with fewer samples, filtered and shrunk; nothing is left."""
    scene = bpy.context.scene
    before = snapshot(scene)
    _, data = start(supersample=2, max_radius=20)
    seen, kept = [], addon("views")._split_samples

    def watched(own, copy, index):
        kept(own, copy, index)
        seen.append((copy.cycles.samples, copy.cycles.pixel_filter_type))

    addon("views")._split_samples = watched
    try:
        made = rgba(render(scene, OUT / "f.exr"))
    finally:
        addon("views")._split_samples = kept
    assert not last_message(scene), last_message(scene)
    assert seen == [(4, "BLACKMAN_HARRIS")], seen
    assert made.shape == (48, 72, 4), made.shape
    layer = addon("passes").rendered(scene).layer("ViewLayer")
    assert layer.colour.shape == (96, 144, 4)
    params = addon("lens").frame_parameters(
        scene.camera, data.rack_focus, scene.render, (144, 96), 2
    )
    assert params["max_radius"] == 40 and params["coc_limit"] == 1
    supersample, library = addon("supersample"), addon("library").rackfocus
    large = library.apply(np.ascontiguousarray(layer.colour), layer.depth, **params)
    same(made, supersample.shrink(large, 2, supersample.taps_of(scene, 2)))
    data.dof.aperture_fstop = 0.4
    bpy.ops.rack_focus.refocus()
    again = result(scene)
    assert again.shape == made.shape and np.abs(again - made).max() > 0.05
    same(rgba(render(scene, OUT / "f.exr")), again)
    leaves_nothing(scene, before)


@check
def supersampling_is_sharper():
    """In focus as the scene's own render; out of focus nearer to the own lens."""
    scene, data = start(supersample=2)
    scores = {}
    reference = own_lens(scene, 512)
    for scale in (1, 2):
        data.rack_focus.supersample = scale
        scores[scale] = tpsnr(rgba(render(scene, OUT / "f.exr")), reference)
    print("SUPERSAMPLE", scores)
    assert scores[2] > scores[1] + 0.3, scores
    data.dof.aperture_fstop = 1000
    scene.cycles.samples = 512
    sharp = rgba(pinhole(scene, OUT / "f_passes.exr"), "ViewLayer")
    made = rgba(render(scene, OUT / "f.exr"))
    print("SHARP", tpsnr(made, sharp))
    assert tpsnr(made, sharp) > 40


@check
def supersampled_views_and_sockets():
    """Each view is larger; CoC and Depth have the asked size and its pixels."""
    scene, data = start(supersample=2, method="views", views=2)
    scene.cycles.samples = 32
    tree = common.tree_of(scene)
    ours = addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]
    output = addon("compat").output_socket(tree)
    shape = rgba(render(scene, OUT / "f.exr")).shape
    found = addon("passes").rendered(scene).views("ViewLayer")
    assert [layer.depth.shape for layer, _ in found] == [(96, 144)] * 2
    assert shape == (48, 72, 4)
    for name in ("CoC", "Depth"):
        seen = {}
        for scale in (1, 2):
            data.rack_focus.supersample = scale
            ours = addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]
            tree.links.new(ours.outputs[name], output)
            seen[scale] = rgba(render(scene, OUT / "f.exr"))[..., 0]
        near = np.isclose(seen[1], seen[2], rtol=0.02, atol=0.02).mean()
        assert near > 0.8, (name, near)


@check
def where_it_does_not_supersample():
    """The box says so, and the picture is that without."""
    scene, data = start()
    plain = rgba(render(scene, OUT / "f.exr"))
    parts, ui = addon("parts"), addon("ui")
    data.rack_focus.supersample = 2
    assert ui.describe_supersample(data.rack_focus, scene) == [
        "144 × 96 px, 4 samples each"
    ]
    scene.render.use_motion_blur = True
    assert "Motion Blur" in ui.describe_supersample(data.rack_focus, scene)[1]
    scene.render.use_motion_blur = False
    scene.render.use_border = True
    assert "region" in ui.describe_supersample(data.rack_focus, scene)[0]
    assert parts.factor(scene) == 1
    same(rgba(render(scene, OUT / "f.exr")), plain)


@check
def supersample_is_automatic():
    """With 0 it is 2, but where the renderer would take longer or something is lost."""
    scene, data = start()
    parts, ui = addon("parts"), addon("ui")
    settings, render_settings, layer = (
        data.rack_focus,
        scene.render,
        scene.view_layers[0],
    )
    settings.supersample = 2
    asked = rgba(render(scene, OUT / "f.exr"))
    settings.property_unset("supersample")
    assert settings.supersample == 0 and not settings.has_supersample
    assert ui.describe_supersample(settings, scene) == ["144 × 96 px, 4 samples each"]
    same(rgba(render(scene, OUT / "f.exr")), asked)
    cycles = scene.cycles
    scene.camera.data.dof.use_dof = True
    for owner, name, value, why in (
        (settings, "method", "box", "final pictures"),
        (settings, "quality", "preview", "final pictures"),
        (settings, "mirrors", True, "Mirrors"),
        (data, "type", "ORTHO", "orthographic"),
        (render_settings, "use_motion_blur", True, "moves"),
        (render_settings, "use_border", True, "region"),
        (cycles, "samples", 3, "3 samples"),
        (cycles, "samples", 7, "7 samples"),
        (settings, "views", 8, "2 samples"),
        (settings, "views", 4, "too few"),
        (addon("one_by_one"), "multiview_works", False, "anew"),
        (addon("memory"), "LOUD_BYTES", 144 * 96 * 250, "GB"),
        (layer, "use_pass_mist", True, "other passes"),
        (addon("compat"), "writes_passes", lambda _: True, "other passes"),
        (cycles, "use_guiding", True, "Guiding"),
    ):
        before = getattr(owner, name)
        setattr(owner, name, value)
        lines = ui.describe_supersample(settings, scene)
        assert parts.factor(scene) == 1 and len(lines) == 1, (name, lines)
        assert why in lines[0], (name, lines)
        setattr(owner, name, before)
        assert parts.factor(scene) == 2, name
    cycles.samples, settings.views = 64, 8
    assert parts.factor(scene) == 2
    cycles.samples, cycles.use_denoising = 32, True
    assert parts.factor(scene) == 2
    cycles.use_denoising = False
    assert parts.factor(scene) == 1
    render_settings.engine = "BLENDER_WORKBENCH"
    assert parts.factor(scene) == 1
    assert ui.describe_supersample(settings, scene) == []


# ---- overscan ---------------------------------------------------------------------


def lamps_beyond(scene, depth=6, size=(144, 96)):
    """Lit cubes just outside of each side, blurred by 11 px of 144."""
    render_of, data = scene.render, scene.camera.data
    render_of.resolution_x, render_of.resolution_y = size
    scene.cycles.samples = 64
    data.dof.focus_distance, data.dof.aperture_fstop = 2, 0.1
    frame = data.view_frame(scene=scene)
    far = 1 if data.type == "ORTHO" else depth / -frame[0].z
    middle, half = ((frame[0] + sign * frame[2]) / 2 for sign in (1, -1))
    for x, y in ((-1.06, 0.3), (1.05, -0.2), (0.1, 1.07), (0.4, -1.08)):
        at = (middle.x + x * half.x) * far, depth, (middle.y + y * half.y) * far
        common.emitter("lamp", (20, 15, 10), 0.06, at)


def scores_of(scene, data, reference, values=(0, 10)):
    """{Overscan in percent: tPSNR}, and the same without 16 px at the border."""
    found = {}
    for percent in values:
        data.rack_focus.overscan = percent
        made = rgba(render(scene, OUT / "f.exr"))
        assert not last_message(scene), last_message(scene)
        inner = (picture[16:-16, 16:-16] for picture in (made, reference))
        found[percent] = tpsnr(made, reference), tpsnr(*inner)
    return found


@check
def overscan_shows_what_is_beyond_the_border():
    """As the own lens does; elsewhere the picture is as good as without. Nothing is left."""
    scene = bpy.context.scene
    lamps_beyond(scene)
    before = snapshot(scene)
    _, data = start()
    reference = own_lens(scene, 512)
    for scale in (1, 2):
        data.rack_focus.supersample = scale
        scores = scores_of(scene, data, reference)
        print("OVERSCAN", scale, scores)
        assert scores[10][0] > scores[0][0] + 3, scores
        assert scores[10][1] > scores[0][1] - 0.5, scores
    made = result(scene)
    assert addon("ui").overscan.describe(scene, data.rack_focus, 1) == [
        "14 px beyond left and right, 10 above and below,",
        "in one more render of 8 samples",
    ]
    assert addon("memory").needed(scene, 1, 100) == 100 * 1.2**2 * 250
    bpy.ops.rack_focus.refocus()
    same(result(scene), made)
    data.dof.aperture_fstop = 0.2
    assert bpy.ops.rack_focus.refocus() == {"FINISHED"} and not last_message(scene)
    refocused = result(scene)
    same(rgba(render(scene, OUT / "f.exr")), refocused)
    leaves_nothing(scene, before)


@check
def overscan_of_all_kinds_of_frames():
    """Shifted, upright, measured on its height, orthographic, of pixels that are not square."""
    for kind in ("shift", "upright", "height", "flat", "aspect"):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        scene = bpy.context.scene
        render_of, data = scene.render, scene.camera.data
        if kind == "shift":
            data.shift_x, data.shift_y = 0.1, -0.07
        elif kind == "height":
            data.sensor_fit = "VERTICAL"
        elif kind == "aspect":
            render_of.pixel_aspect_x = 1.5
        elif kind == "flat":
            data.type, data.ortho_scale = "ORTHO", 3
        lamps_beyond(scene, size=(96, 144) if kind == "upright" else (144, 96))
        if kind == "flat":
            data.dof.aperture_fstop = 1.2
        start()
        scores = scores_of(scene, data, own_lens(scene, 256))
        print("OVERSCAN", kind, scores)
        assert scores[10][0] > scores[0][0] + 3, (kind, scores)


@check
def looks_are_the_same_with_overscan():
    """They depend on the place in the frame, not in the picture with its margin."""
    scene, data = start()
    settings, size, px = data.rack_focus, (480, 320), (48, 32)
    scene.render.resolution_x, scene.render.resolution_y = size
    data.dof.focus_distance, data.dof.aperture_fstop = 2, 0.4
    whole = tuple(n + 2 * more for n, more in zip(size, px, strict=True))
    inside = np.s_[px[1] : -px[1], px[0] : -px[0]]
    dots = np.random.default_rng(1).random(whole[::-1])
    wide = np.repeat(dots[..., None], 4, 2).astype(np.float32)
    depth = np.full(whole[::-1], 4, np.float32)
    lens, library = addon("lens"), addon("library").rackfocus
    differences = {}
    for field, value in (
        ("cat_eye", 0.7),
        ("barn_left", 0.5),
        ("swirl", 0.6),
        ("astigmatism", 0.6),
        ("field_curvature", 0.3),
        ("split_diopter", 4),
    ):
        setattr(settings, field, value)
        settings.split_offset = 0.3
        params = lens.frame_parameters(scene.camera, settings, scene.render, size)
        padded = lens.padded_parameters(params, size, whole)
        cut = (np.ascontiguousarray(plane[inside]) for plane in (wide, depth))
        wanted = library.apply(*cut, **params)[64:-64, 80:-80]
        same_numbers = {f: params[f] for f in lens.OF_PLACES if f in params}
        differences[field] = [
            float(
                np.abs(
                    library.apply(wide, depth, **one)[inside][64:-64, 80:-80] - wanted
                ).mean()
            )
            for one in (padded, {**padded, **same_numbers})
        ]
        settings.property_unset(field)
    print("LOOKS", differences)
    assert all(one < 0.9 * other for one, other in differences.values()), differences
    settings.overscan, settings.cat_eye = 10, 3.9
    why = addon("overscan").why_not(scene)
    assert "too wide for so much Cat" in why, why


@check
def holes_of_fog_in_the_margin_are_filled():
    """As those of the frame, in scenes with volumes alone."""
    scene, _ = start(overscan=10)
    common.emitter("wall", (0.3, 0.3, 0.3), 60, (0, 42, 0))
    rgba(render(scene, OUT / "f.exr"))
    overscan, fog = addon("overscan"), addon("fog")
    rendered, *about = overscan._kept[scene.name].found
    layer = rendered.layer("ViewLayer", *about)
    depth = np.array(layer.depth)
    depth[3, 3] = 1e10
    rendered.layer = lambda *_: layer._replace(depth=depth)
    frame, has_volume = (
        addon("engine").Frame("ViewLayer", "", "", scene.camera),
        fog.has_volume,
    )
    for is_foggy in (False, True):
        fog.has_volume = lambda _, found=is_foggy: found
        try:
            margin, _ = overscan.margin_of(scene, frame, (72, 48))
        finally:
            fog.has_volume = has_volume
        assert (margin.layer.depth[3, 3] < 100) == is_foggy, margin.layer.depth[3, 3]


@check
def where_overscan_is_not_rendered():
    """The box and the console say so, and the picture is that without."""
    scene, data = start()
    overscan, views = addon("overscan"), addon("views")
    plain = rgba(render(scene, OUT / "f.exr"))
    settings = data.rack_focus
    settings.overscan = 5
    for owner, name, value, why in (
        (scene.render, "use_border", True, "region"),
        (settings, "mirrors", True, "Mirrors"),
        (settings, "views", 2, "several see beyond"),
    ):
        before = getattr(owner, name)
        setattr(owner, name, value)
        lines = overscan.describe(scene, settings, views.view_count(settings))
        assert len(lines) == 1 and why in lines[0], lines
        assert any(why in line for line in views.in_vain(scene)), why
        setattr(owner, name, before)
    scene.render.use_border = True
    with heard() as said:
        same(rgba(render(scene, OUT / "f.exr")), plain)
    assert "region" in said.getvalue(), said.getvalue()
    scene.render.use_border = False
    settings.overscan = 0
    render(scene, OUT / "f.exr")
    settings.overscan = 5
    bpy.ops.rack_focus.refocus()
    assert last_message(scene) == overscan.MISSING
    same(result(scene), plain)


# ---- finish -----------------------------------------------------------------------


def kept_own(scene):
    """(colour, albedo and normals) of the render with the own lens."""
    layer, guides, samples = addon("finishing").own_of(scene, "ViewLayer")
    return layer.colour, guides, samples


@check
def finish():
    """The own lens rendered and cleaned: what the library makes of both."""
    scene, data = start()
    data.dof.use_dof = False
    colour = rgba(pinhole(scene, OUT / "f_passes.exr"), "ViewLayer")
    ours = rgba(render(scene, OUT / "f.exr"))
    before = snapshot(scene)
    scenes = sorted(s.name for s in bpy.data.scenes)
    assert bpy.ops.rack_focus.finish(samples=4) == {"FINISHED"}
    assert not last_message(scene), last_message(scene)
    assert sorted(s.name for s in bpy.data.scenes) == scenes
    after = snapshot(scene)
    before[0]["images"] = after[0]["images"]
    assert after == before, (before, after)
    made = result(scene)
    own, guides, samples = kept_own(scene)
    assert samples == 4
    assert np.abs(own - colour).max() > 0.1, "the own lens was not open"
    for name in ("albedo", "normal"):
        assert guides[name].shape == own.shape[:2] + (3,)
    wanted = ours.copy()
    addon("finishing").clean(scene, own, wanted, guides, samples)
    same(made, wanted)
    assert np.abs(made - ours).max() > 0
    assert not data.dof.use_dof and not addon("refocusing").is_out_of_date(scene)
    # By filters of the quality that Cycles is set to, since 4.2.
    if hasattr(scene.cycles, "denoising_quality"):
        scene.cycles.denoising_quality = "FAST"
        bpy.ops.rack_focus.refocus()
        assert np.abs(result(scene) - made).max() > 0
        scene.cycles.denoising_quality = "HIGH"
    # The same lens is finished again; another one is not, nor is a new render.
    bpy.ops.rack_focus.refocus()
    same(result(scene), made)
    data.dof.aperture_fstop = 0.3
    bpy.ops.rack_focus.refocus()
    sharp = pinhole(scene, OUT / "f_passes.exr")
    args = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    render(scene, OUT / "f.exr")
    same(result(scene), filtered(scene, *args))
    assert not addon("finishing").is_finished(scene)
    assert not common.own_memory_folders()


@check
def finish_is_nearer_to_the_own_lens():
    """Than our picture alone, and than the own lens denoised by itself."""
    scene, data = start()
    reference = own_lens(scene, 512)
    ours = rgba(render(scene, OUT / "f.exr"))
    bpy.ops.rack_focus.finish(samples=64)
    made = result(scene)
    own = kept_own(scene)[0]
    scores = {
        "ours": tpsnr(ours, reference),
        "own": tpsnr(np.array(own), reference),
        "finished": tpsnr(made, reference),
    }
    print("FINISH", scores)
    assert scores["finished"] > max(scores["ours"], scores["own"]), scores


@check
def every_render_is_finished():
    """With views and supersampled too; each frame of an animation has its own."""
    scene, data = start(use_finish=True, finish_samples=4, method="views", views=2)
    key_focus(data, {1: 2, 2: 5})
    for scale in (1, 2):
        data.rack_focus.supersample = scale
        scene.frame_start, scene.frame_end = 1, 2
        common.set_output(scene, OUT / "f_anim_####.exr")
        bpy.ops.render.render(animation=True)
        frames = [rgba(common.read(OUT / f"f_anim_{i:04}.exr")) for i in (1, 2)]
        assert not last_message(scene), last_message(scene)
        for number, picture in zip((1, 2), frames, strict=True):
            scene.frame_set(number)
            same(rgba(render(scene, OUT / "f.exr")), picture)
            assert "finish" in addon("engine").last_run[scene.name]["seconds"]
    data.rack_focus.use_finish = False
    assert np.abs(rgba(render(scene, OUT / "f.exr")) - frames[1]).max() > 0
    assert sorted(s.name for s in bpy.data.scenes) == ["Scene", "Scene Rack Focus"]


@check
def a_picture_that_does_not_fit_is_told():
    """What moved and lights that changed since F12; nothing of the right picture."""
    scene, data = start()
    scene.render.resolution_x, scene.render.resolution_y = 216, 144
    data.dof.aperture_fstop = 0.8  # so that there is detail
    ours = rgba(render(scene, OUT / "f.exr"))
    data.dof.focus_distance = 2.5  # the picture follows the lens
    bpy.ops.rack_focus.finish(samples=4)
    assert not last_message(scene), last_message(scene)
    data.dof.focus_distance = 3
    finishing = addon("finishing")
    cubes = [item for item in scene.objects if item.type == "MESH"]
    for item in cubes:
        item.location.z += 0.03 * item.location.y
    with heard() as said:
        bpy.ops.rack_focus.finish(samples=4)
    assert addon("taken").has_changed(scene)
    assert last_message(scene) == finishing.OTHER_THINGS, last_message(scene)
    assert "press F12, then Finish" in said.getvalue()
    own = np.array(kept_own(scene)[0])
    for item in cubes:
        item.data.materials[0].node_tree.nodes["Emission"].inputs[1].default_value = 3
    world = scene.world.node_tree.nodes["Background"]
    world.inputs["Strength"].default_value = 3
    bpy.ops.rack_focus.finish(samples=4)
    assert last_message(scene) == finishing.OTHER_LIGHT, last_message(scene)
    render(scene, OUT / "f.exr")
    bpy.ops.rack_focus.finish(samples=4)
    assert not last_message(scene), last_message(scene)
    # Fur and mirrors look as if something had changed.
    assert not finishing.clean(scene, own, ours.copy())
    # What is bright is told by what is shown as white.
    dark, bright = ours.copy(), 32 * ours
    finishing.clean(scene, own, dark)
    scene.view_settings.exposure = -5
    finishing.clean(scene, 32 * own, bright)
    assert np.allclose(bright / 32, dark, rtol=1e-3, atol=1e-4), tpsnr(
        bright / 32, dark
    )


def refusal(**about):
    """What Finish says where it does nothing; some Blenders raise."""
    said = []
    kind = addon("operators").RACK_FOCUS_OT_finish
    kept = kind._run

    def run(self, context, call):
        class Reporter:
            samples = 0

            def report(self, _, text):
                said.append(text)

        return kept(Reporter(), context, call)

    kind._run = run
    try:
        bpy.ops.rack_focus.finish(**about)
    finally:
        kind._run = kept
    return said[0] if said else ""


@check
def what_cannot_be_finished():
    """A sentence, and the picture stays: no render, a look, no denoiser."""
    scene, data = start()
    assert "press F12" in refusal()
    ours = rgba(render(scene, OUT / "f.exr"))
    data.rack_focus.highlight_gain = 2
    assert "Look" in refusal()
    data.rack_focus.highlight_gain = 1
    data.rack_focus.cat_eye = 0.5
    assert "Look" in refusal()
    data.rack_focus.cat_eye = 0
    # Its copy had no lens: the finished picture was the sharp one.
    engine, scene.render.engine = scene.render.engine, "BLENDER_WORKBENCH"
    assert "Workbench" in refusal()
    scene.render.engine = engine
    kept = os.environ.get("RACKFOCUS_OIDN")
    os.environ["RACKFOCUS_OIDN"] = "/nowhere"
    try:
        assert "Open Image Denoise" in refusal()
        same(result(scene), ours)
        data.rack_focus.use_finish, data.rack_focus.finish_samples = True, 2
        try:
            made = rgba(render(scene, OUT / "f.exr"))
        except RuntimeError:  # of some Blenders, for the report
            made = result(scene)
        assert "not finished" in last_message(scene)
        same(made, ours)
    finally:
        if kept is None:
            del os.environ["RACKFOCUS_OIDN"]
        else:
            os.environ["RACKFOCUS_OIDN"] = kept


# ---- denoised views ---------------------------------------------------------------


def _lit_floor():
    """A checked floor under a lamp, which has grain."""
    floor = common.emitter("floor", (1, 1, 1), 1, (0, 5, -0.6))
    floor.scale = (12, 12, 0.02)
    tree = floor.data.materials[0].node_tree
    diffuse, checks = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfDiffuse", "TexChecker")
    )
    checks.inputs["Scale"].default_value = 24
    out = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(checks.outputs["Color"], diffuse.inputs["Color"])
    tree.links.new(diffuse.outputs[0], out.inputs["Surface"])
    data = bpy.data.lights.new("lamp", "AREA")
    data.energy, data.size = 300, 3
    lamp = bpy.data.objects.new("lamp", data)
    lamp.location = (0, 4, 3)
    bpy.context.scene.collection.objects.link(lamp)


def _merged(scene, is_clean):
    """The kept views of the last render merged, with their grain or without."""
    kept, library = addon("passes").rendered(scene), addon("library").rackfocus
    kept._clean.clear()
    found = kept.views("ViewLayer")
    guides = [kept.guides("ViewLayer", j) for j in (0, 1)]
    height, width = found[0][0].depth.shape
    params = addon("lens").frame_parameters(
        scene.camera, scene.camera.data.rack_focus, scene.render, (width, height)
    )
    parts = addon("views").DENOISED_SUB_APERTURES
    made = library.Filter(width, height, **{"sub_apertures": parts, **params})
    means = [addon("passes").mean_depth(made, *one) for one in found]
    assert all(mean is not None for mean in means)
    views = [
        (np.ascontiguousarray(f.colour), f.depth, *place[:2], mean)
        for (f, place), mean in zip(found, means, strict=True)
    ]
    out = np.empty((height, width, 4), np.float32)
    if is_clean:
        known = [(one["albedo"], one["normal"]) for one in guides]
        outs = [np.empty_like(view[0]) for view in views]
        path = addon("denoising").library()[0]
        assert made.denoise_views(views, outs, known, library=path) > 1
        made.merge_denoised(views, outs, out)
    else:
        made.process_views(views, out)
    return out


@check
def views_are_denoised_together():
    """By what both show; the grain goes; a refocus takes what was made."""
    _lit_floor()
    scene, data = start(method="views", views=2)
    layer, cycles = scene.view_layers[0], scene.cycles
    cycles.samples = 256
    wanted = rgba(render(scene, OUT / "f.exr"))
    cycles.samples, cycles.use_denoising = 16, True
    data.rack_focus.denoise_together = False
    render(scene, OUT / "f.exr")
    assert "denoise" not in addon("engine").last_run[scene.name]["seconds"]
    data.rack_focus.denoise_together = True
    made = rgba(render(scene, OUT / "f.exr"))
    assert not last_message(scene), last_message(scene)
    assert "denoise" in addon("engine").last_run[scene.name]["seconds"]
    assert cycles.use_denoising and not layer.cycles.denoising_store_passes
    bpy.ops.rack_focus.refocus()
    same(result(scene), made)
    assert "denoise" not in addon("engine").last_run[scene.name]["seconds"]
    data.dof.aperture_fstop = 1
    bpy.ops.rack_focus.refocus()
    assert np.abs(result(scene) - made).max() > 0.01
    data.dof.aperture_fstop = 0.2
    assert not common.own_memory_folders()
    noisy = tpsnr(_merged(scene, is_clean=False), wanted)
    assert tpsnr(made, wanted) > noisy + 1, (tpsnr(made, wanted), noisy)
    if addon("denoising").library()[1]:  # else that ends this process
        same(made, _merged(scene, is_clean=True))


@check
def views_without_a_denoiser():
    """Cycles cleans each by itself, and the box says so."""
    scene, data = start(method="views", views=2)
    scene.cycles.use_denoising = True
    module = addon("denoising")
    has_own, chosen = module.library()[1], os.environ.get(module.DENOISER)
    assert not module.why_not(scene)
    os.environ[module.DENOISER] = "/nowhere"
    try:
        assert not module.is_possible(scene)
        assert "denoised by itself" in module.why_not(scene)
        if has_own:  # else Cycles renders nothing
            render(scene, OUT / "f.exr")
            assert not last_message(scene), last_message(scene)
        data.rack_focus.denoise_together = False
        assert not module.why_not(scene)
    finally:
        os.environ.pop(module.DENOISER)
        if chosen:
            os.environ[module.DENOISER] = chosen


checking.run(check, "finish_results.json")
