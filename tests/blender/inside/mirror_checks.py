# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of what mirrors and panes show, by its own distance."""

import math

import bpy
import common
import numpy as np
from checking import OUT, Checks, heard, shot
from common import addon, last_message, start, tpsnr

check = Checks()


FAR = 1e6  # sky


def _mirror_before_cubes(scene):
    """A mirror in focus that fills the frame, and cubes behind the camera."""
    for item in [o for o in scene.objects if o.type == "MESH"]:
        bpy.data.objects.remove(item)
    mirror = common.emitter("mirror", (0, 0, 0), 1, (0, 3.01, 0))
    mirror.scale = (6, 0.02, 6)
    nodes = mirror.data.materials[0].node_tree
    glossy = nodes.nodes.new("ShaderNodeBsdfGlossy")
    glossy.inputs["Roughness"].default_value = 0
    out = next(n for n in nodes.nodes if n.type == "OUTPUT_MATERIAL")
    nodes.links.new(glossy.outputs[0], out.inputs["Surface"])
    rng = np.random.default_rng(3)
    for _ in range(60):
        x, z = rng.uniform(-3, 3, 2)
        common.emitter("cube", rng.random(3), 0.5, (x, -3, z))
    scene.cycles.max_bounces = scene.cycles.glossy_bounces = 2


@check
def what_mirrors_show():
    """By its own distance where that is asked for; the passes come and go."""
    scene, data = start(mirrors=True)
    layer, module = scene.view_layers[0], addon("mirrors")
    _mirror_before_cubes(scene)
    data.rack_focus.mirrors, data.dof.aperture_fstop = False, 0.08
    plain = shot(scene, "mi.exr")
    assert not any(getattr(layer, p) for p in module.PASSES)
    data.rack_focus.mirrors = True
    bpy.ops.rack_focus.refocus()
    assert "press F12" in last_message(scene), last_message(scene)
    layer.use_pass_glossy_color = True  # the user's own
    made = shot(scene, "mi.exr")
    assert not last_message(scene), last_message(scene)
    assert all(getattr(layer, p) for p in module.PASSES)
    assert layer.cycles.denoising_store_passes
    inner = np.s_[10:-10, 10:-10, :3]
    assert made[inner].std() < 0.85 * plain[inner].std(), (
        made[inner].std(),
        plain[inner].std(),
    )
    assert abs(made[inner].mean() / plain[inner].mean() - 1) < 0.1
    data.dof.aperture_fstop = 20
    bpy.ops.rack_focus.refocus()
    assert not last_message(scene), last_message(scene)
    sharp = common.result(scene, OUT / "mi_result.exr")
    assert sharp[inner].std() > 1.15 * made[inner].std()
    data.rack_focus.method = "accumulate"
    assert "Accumulate" in module.why_not(scene, data.rack_focus)
    data.rack_focus.method, data.rack_focus.supersample = "layered", 2
    assert "Supersample" in module.why_not(scene, data.rack_focus)
    data.rack_focus.supersample = 1
    assert not module.why_not(scene, data.rack_focus)
    data.rack_focus.mirrors = False
    shot(scene, "mi.exr")
    assert [p for p in module.PASSES if getattr(layer, p)] == ["use_pass_glossy_color"]
    assert not layer.cycles.denoising_store_passes
    data.rack_focus.mirrors = True
    shot(scene, "mi.exr")
    data.rack_focus.enabled = False
    assert [p for p in module.PASSES if getattr(layer, p)] == ["use_pass_glossy_color"]


@check
def the_way_in_mirrors_counts_from_the_camera():
    """Cycles counts it from the near clip on."""
    scene, data = start(mirrors=True)
    _mirror_before_cubes(scene)
    module, distances = addon("mirrors"), []
    lights_of = module.lights_of

    def watched(*about):
        found = lights_of(*about)
        distance = found[0][1]
        distances.append(np.nanmedian(distance[distance < FAR]))
        return found

    module.lights_of = watched
    try:
        for data.clip_start in (0.1, 2.5):
            shot(scene, "mi.exr")
            assert not last_message(scene), last_message(scene)
    finally:
        module.lights_of = lights_of
    # 3 to the mirror, and 5.75 from there to the cubes times its colour, 0.8.
    assert np.allclose(distances, 7.6, atol=0.05), distances


@check
def sky_in_mirrors_is_far():
    """Rays that hit nothing add nothing to their way (before 5.2)."""
    scene, data = start(mirrors=True)
    _mirror_before_cubes(scene)
    for item in [o for o in scene.objects if o.name.startswith("cube")]:
        bpy.data.objects.remove(item)
    scene.world = scene.world or bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1,) * 4
    module, distances = addon("mirrors"), []
    lights_of = module.lights_of

    def watched(*about):
        found = lights_of(*about)
        distances.append(found[0][1])
        return found

    module.lights_of = watched
    try:
        shot(scene, "mi.exr")
    finally:
        module.lights_of = lights_of
    assert (distances[0][10:-10, 10:-10] > FAR).all(), distances[0]


@check
def what_mirrors_show_in_several_views():
    """Each view's by its own distance, with and without Cycles' denoiser."""
    scene, data = start(views=2)
    _mirror_before_cubes(scene)
    data.dof.aperture_fstop, data.dof.use_dof = 0.1, True
    inner = np.s_[10:-10, 10:-10, :3]
    data.rack_focus.enabled, scene.cycles.samples = False, 128
    own = shot(scene, "mv.exr")[inner]
    data.rack_focus.enabled, scene.cycles.samples = True, 32
    has_denoiser = common.V >= (4, 2, 0)  # Debian's 3.4 has none
    for is_denoised in (False, True) if has_denoiser else (False,):
        scene.cycles.use_denoising, apart = is_denoised, []
        if is_denoised:  # four tell each other's distances
            data.rack_focus.views, scene.cycles.samples = 4, 16
        for data.rack_focus.mirrors in (False, True):
            made = shot(scene, "mv.exr")[inner]
            assert not last_message(scene), last_message(scene)
            apart.append(np.abs(made - own).mean())
        assert apart[1] < 0.75 * apart[0], apart


@check
def distances_in_mirrors_are_found_once():
    """Of each view from the two farthest from it, and not again for another focus."""
    module, passes, library = addon("mirrors"), addon("passes"), addon("library")
    one = np.ones((4, 6), np.float32)
    seen = module.Seen(((one,) * 9, (one,) * 9), (), one)
    layer = passes.Layer(np.ones((4, 6, 4), np.float32), one, seen=seen)
    offsets = (0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 0.5)
    found = [(layer, passes.MIDDLE._replace(offset=offset)) for offset in offsets]
    rendered, asked, goes_on = common, [], True

    class Made:
        def seen_depth(self, _, __, lights, out):
            asked.append([offset for _, offset, _ in lights])
            out[:] = len(asked)

    def lights_of(part):
        key = rendered, part
        return module.lights_of_views(Made(), found, key, lambda _: goes_on)

    goes_on = False
    try:
        lights_of("a")
        raise AssertionError("was not cancelled")
    except library.rackfocus.CancelledError:
        assert not asked
    goes_on = True
    first = lights_of("a")
    assert len(asked) == 8, asked
    assert asked[0] == asked[1] == [offsets[0], offsets[1], offsets[2]], asked
    assert asked[6] == [offsets[3], offsets[1], offsets[2]], asked
    assert [[d[0, 0] for _, d in view] for view in first] == [
        [1, 2],
        [3, 4],
        [5, 6],
        [7, 8],
    ]
    assert [d[0, 0] for _, d in lights_of("a")[3]] == [7, 8]
    assert len(asked) == 8, asked
    lights_of("b")
    assert len(asked) == 16, asked


@check
def mirrored_light_loses_the_grain_that_the_picture_lost():
    """Half of the picture is mirrored: with grain, and once a denoiser made it even."""
    module, passes, library = addon("mirrors"), addon("passes"), addon("library")
    params = {"focus_distance": 3.0, "lens_radius": 0.1, "focal_length_px": 100.0}
    made = library.rackfocus.Filter(30, 20, **params)
    noisy = np.random.default_rng(1).uniform(0.1, 0.9, (20, 30, 3)).astype(np.float32)
    none, one = (np.full((20, 30), value, np.float32) for value in (0, 1))
    planes = tuple(noisy[..., i] for i in range(3))
    mirrored = (none,) * 3 + tuple(plane / 2 for plane in planes) + (one,) * 3
    for kept, grainy, way in ((planes, None, one), ((), noisy, none)):
        seen = module.Seen((mirrored, (none,) * 9), kept, way)
        clean = np.full_like(noisy, 0.4)
        layer = passes.Layer(clean, one, seen=seen, grainy=grainy)
        light, _ = module.lights_of(made, layer, params, 0, 1)[0]
        assert np.allclose(light, 0.2), np.abs(light - 0.2).max()
    layer = passes.Layer(noisy, one, seen=module.Seen((mirrored,) * 2, (), none))
    light, _ = module.lights_of(made, layer, params, 0, 1)[0]
    assert np.array_equal(light, noisy / 2)


@check
def rays_in_stereo_have_the_shift_of_their_view():
    """Their lengths tell the depth of a wall, in both views and about each pivot."""
    scene, data = start(clean_edges=True)
    common.emitter("wall", (0.3, 0.3, 0.3), 60, (0, 42, 0))
    scene.render.use_multiview, scene.render.views_format = True, "STEREO_3D"
    stereo = data.stereo
    stereo.interocular_distance, stereo.convergence_distance = 0.4, 3
    module, ratios = addon("passes"), []
    mean_depth = module.mean_depth

    def watched(made, layer, place):
        mean = mean_depth(made, layer, place)
        is_known = (layer.depth > 11) & np.isfinite(mean)
        ratio = np.where(is_known, mean / layer.depth, np.nan)
        ratios.append(np.nanmedian(ratio[:, [2, -3]], 0))
        return mean

    module.mean_depth = watched
    try:
        for mode, pivot in (
            ("OFFAXIS", "LEFT"),
            ("OFFAXIS", "CENTER"),
            ("OFFAXIS", "RIGHT"),
            ("TOE", "LEFT"),
        ):
            stereo.convergence_mode, stereo.pivot = mode, pivot
            bpy.ops.render.render()
    finally:
        module.mean_depth = mean_depth
    assert len(ratios) == 8, len(ratios)
    assert np.allclose(ratios, 1, atol=0.003), ratios  # 0.964 to 1.041 without


@check
def rays_in_a_region_count_from_the_middle_of_the_frame():
    """Their lengths tell the depth of a wall, with a shift and pixels that are not square too."""
    scene, data = start(clean_edges=True)
    for item in [o for o in bpy.data.objects if o.type == "MESH"]:
        bpy.data.objects.remove(item)
    common.emitter("wall", (0.3, 0.3, 0.3), 60, (0, 42, 0))
    render_of, module, ratios = scene.render, addon("passes"), []
    render_of.use_border, render_of.border_min_x, render_of.border_max_x = True, 0, 0.3
    render_of.border_min_y, render_of.border_max_y = 0.6, 1
    mean_depth = module.mean_depth

    def watched(made, layer, place):
        mean = mean_depth(made, layer, place)
        is_known = (layer.depth > 11) & np.isfinite(mean)
        ratio = np.where(is_known, mean / layer.depth, np.nan)
        sides = ratio[:, [2, -3]].T, ratio[[2, -3]]
        ratios.append([np.nanmedian(line) for side in sides for line in side])
        return mean

    module.mean_depth = watched
    try:
        for shift, aspect, is_cut in ((0, 1, False), (0.2, 1.5, True)):
            data.shift_x, data.shift_y = shift, -shift
            render_of.pixel_aspect_y, render_of.use_crop_to_border = aspect, is_cut
            bpy.ops.render.render()
    finally:
        module.mean_depth = mean_depth
    print("REGION", ratios)
    assert len(ratios) == 2 and np.allclose(ratios, 1, atol=0.002), ratios


@check
def a_tilted_lens_is_that_of_the_frame_in_a_region():
    """The surface in focus leans about the middle of the frame."""
    scene, _ = start(tilt_x=math.radians(8))
    scene.cycles.samples, render_of = 16, scene.render
    render_of.resolution_x, render_of.resolution_y = 288, 192
    wanted = shot(scene, "a.exr")[:96, 144:]
    render_of.use_border = render_of.use_crop_to_border = True
    render_of.border_min_x, render_of.border_max_x = 0.5, 1
    render_of.border_min_y, render_of.border_max_y = 0.5, 1
    made = shot(scene, "a.exr")
    score = tpsnr(*(picture[20:-20, 20:-20] for picture in (made, wanted)))
    print("TILT", score)
    assert score > 35, score  # 20.6 about the middle of the region


@check
def looks_that_count_from_the_middle_of_a_region_are_told():
    """In the box and on the console; not without a region, nor where no look is on."""
    scene, data = start(cat_eye=0.5)
    module, settings = addon("regions"), data.rack_focus
    assert module.describe(scene, settings) == []
    scene.render.use_border, scene.render.border_max_x = True, 0.5
    assert "Cat" in module.describe(scene, settings)[0]
    with heard() as said:
        shot(scene, "a.exr")
    assert "counts from its middle" in said.getvalue(), said.getvalue()
    settings.cat_eye = 0
    assert module.describe(scene, settings) == []


# ---- what is partly transparent ---------------------------------------------------


def _pane(material, alpha):
    """Makes a material a lit surface of an alpha; returns its Principled BSDF."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    pane, out = nodes.new("ShaderNodeBsdfPrincipled"), "ShaderNodeOutputMaterial"
    links.new(pane.outputs[0], nodes.new(out).inputs["Surface"])
    pane.inputs["Alpha"].default_value = alpha
    pane.inputs["Base Color"].default_value = (0.8, 0.4, 0.1, 1)
    return pane


def _sun(scene):
    """Light for what does not glow by itself."""
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 4, (0.6, 0.3, 0.2)
    scene.collection.objects.link(sun)


def _said_of_veils(scene):
    """Was it told that something before the sky has no depth?"""
    return "partly transparent" in last_message(scene)


def _rays_tell(scene):
    """Does Denoising Depth tell holes from the sky? Not in 5.2, where both are endless."""
    return addon("veils").NOTHING_HIT > common.kept(scene)[0][0].rays.max()


@check
def veils_before_the_sky_are_told():
    """Told where the depth leaves them out, and what is said helps; opaque ones are not."""
    scene, data = start(clean_edges=True)
    _sun(scene)
    veils = [o for o in scene.objects if o.type == "MESH"][::2]
    panes = [_pane(o.material_slots[0].material, 1) for o in veils]
    shot(scene, "veil.exr")
    assert not _said_of_veils(scene), last_message(scene)
    for pane in panes:
        pane.inputs["Alpha"].default_value = 0.3
    scene.cycles.samples, data.dof.use_dof = 256, True
    data.rack_focus.enabled = False
    own = shot(scene, "veil.exr")[..., :3]
    data.dof.use_dof, scene.cycles.seed = False, 7
    data.rack_focus.enabled = True
    scores = {}
    for threshold in (0.5, 0.01):
        scene.view_layers[0].pass_alpha_threshold = threshold
        scores[threshold] = common.tpsnr(shot(scene, "veil.exr")[..., :3], own)
        assert _said_of_veils(scene) == (threshold == 0.5), last_message(scene)
    assert scores[0.01] > scores[0.5] + 2, scores  # 4.4 in 5.0, 2.7 in 5.2
    scene.view_layers[0].pass_alpha_threshold = 0.5
    wall = common.emitter("wall", (0.2, 0.3, 0.4), 60, (0, 50, 0))
    shot(scene, "veil.exr")
    assert not _said_of_veils(scene), last_message(scene)
    bpy.data.objects.remove(wall)
    shot(scene, "veil.exr")
    assert _said_of_veils(scene), last_message(scene)
    data.rack_focus.method, data.rack_focus.views = "views", 2
    for scale in (1, 2):
        data.rack_focus.supersample = scale
        shot(scene, "veil.exr")
        assert _said_of_veils(scene), (scale, last_message(scene))
    scene.render.use_border, scene.render.border_min_x = True, 0.2
    shot(scene, "veil.exr")
    assert _said_of_veils(scene), last_message(scene)
    scene.render.use_border = False
    for pane in panes:  # as hair does, what is opaque may cover little of its pixels
        pane.inputs["Alpha"].default_value = 1
    bpy.context.view_layer.update()
    assert not addon("veils").why_wrong(common.kept(scene)[0][0], scene)


@check
def holes_of_soft_pictures_are_told():
    """A picture on a plane whose alpha lies around the threshold; not one that is opaque."""
    scene, _ = start(clean_edges=True)
    for item in [o for o in scene.objects if o.type == "MESH"]:
        bpy.data.objects.remove(item)
    _sun(scene)
    picture = common.emitter("picture", (1, 1, 1), 1, (0, 3, 0))
    picture.scale = (0.9, 0.01, 0.9)
    material = picture.material_slots[0].material
    pane, tree = _pane(material, 1), material.node_tree
    noise = tree.nodes.new("ShaderNodeTexNoise")
    soft = tree.nodes.new("ShaderNodeMapRange")
    noise.inputs["Scale"].default_value = 90
    for name, value in {"From Min": 0.3, "From Max": 0.6, "To Min": 0.3}.items():
        soft.inputs[name].default_value = value
    tree.links.new(noise.outputs[0], soft.inputs[0])
    shot(scene, "soft.exr")
    assert not _said_of_veils(scene), last_message(scene)
    tree.links.new(soft.outputs[0], pane.inputs["Alpha"])
    scene.cycles.samples = 16
    shot(scene, "soft.exr")
    assert _said_of_veils(scene) == _rays_tell(scene), last_message(scene)
    scene.view_layers[0].pass_alpha_threshold = 0.01
    shot(scene, "soft.exr")
    assert not _said_of_veils(scene), last_message(scene)
