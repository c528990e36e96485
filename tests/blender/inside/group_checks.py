# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the node with sockets, run inside Blender in the order of this file.

group_checks.py DIST OUT [CHECK ...]    writes OUT/group_results.json
"""

import contextlib
import json
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import OUT, Checks, heard  # noqa: E402
from common import (  # noqa: E402
    addon,
    filtered,
    last_message,
    pinhole,
    render,
    rgba,
    same,
)

check = Checks()


def bare():
    """(scene, tree, its Render Layers node, the output socket), without Rack Focus."""
    scene = bpy.context.scene
    tree, _ = addon("compat").start_compositor(scene)
    source = addon("setup").layer_nodes(tree, scene)[0]
    return scene, tree, source, addon("compat").output_socket(tree)


def new_node(tree):
    """A node with sockets, not linked."""
    node = tree.nodes.new("CompositorNodeGroup")
    node.node_tree = addon("group").new_group()
    return node


def passes_of(scene):
    """(colour, depth) of the scene's render through a pinhole."""
    channels = pinhole(scene, OUT / "g_passes.exr")
    return rgba(channels, "ViewLayer"), common.depth_of(channels)


def start(scene):
    """Ticks the camera; the nodes are there."""
    scene.camera.data.rack_focus.enabled = True
    addon("handlers").on_change()


def made_by(scene, name="g"):
    """The composite of a render without a message."""
    made = rgba(render(scene, OUT / f"{name}.exr"))
    assert not last_message(scene), last_message(scene)
    return made


@check
def the_picture_of_the_node():
    """Image from the render: what the one-tick node makes, bit for bit."""
    scene, tree, source, out = bare()
    colour, depth = passes_of(scene)
    wanted = filtered(scene, colour, depth)
    node = new_node(tree)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    same(made_by(scene), wanted)
    tree.links.new(source.outputs["Depth"], node.inputs["Depth"])
    same(made_by(scene), wanted)
    seconds = addon("engine").last_run[scene.name]["seconds"]
    print("SECONDS", json.dumps(seconds))


@check
def pixels_that_are_not_square():
    """The node has the same picture as the one tick."""
    scene, tree, source, out = bare()
    scene.render.pixel_aspect_x = 1.5
    node = new_node(tree)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    common.set_output(scene, OUT / "g.png")
    bpy.ops.render.render()
    assert not last_message(scene), last_message(scene)
    given, depth = addon("nodes")._kept[scene.name][node.name]
    wanted = filtered(scene, given.colour, depth)
    flat = np.empty(wanted.size, np.float32)
    node.node_tree.nodes["Picture"].image.pixels.foreach_get(flat)
    same(flat.reshape(wanted.shape)[::-1], wanted)


def add_gain(tree, source, factor):
    """A colour node that multiplies; returns its output."""
    node = tree.nodes.new("CompositorNodeExposure")
    node.inputs["Exposure"].default_value = np.log2(factor)
    tree.links.new(source, node.inputs["Image"])
    return node.outputs["Image"]


@check
def after_other_nodes():
    """What comes in is filtered, not the render; what follows works on the result."""
    scene, tree, source, out = bare()
    colour, depth = passes_of(scene)
    node = new_node(tree)
    tree.links.new(add_gain(tree, source.outputs["Image"], 4), node.inputs["Image"])
    tree.links.new(add_gain(tree, node.outputs["Image"], 0.5), out)
    start(scene)
    brighter = colour * np.float32([4, 4, 4, 1])
    wanted = filtered(scene, brighter, depth) * np.float32([0.5, 0.5, 0.5, 1])
    assert np.allclose(made_by(scene), wanted, rtol=1e-4, atol=1e-5)


@check
def film_depth_reaches_the_node():
    """What is partly transparent and has no depth: the choice changes it."""
    scene, tree, source, out = bare()
    scene.render.film_transparent = True
    scene.camera.data.dof.focus_distance = 9  # nearer, 1e8 is as good as infinity
    colour, depth = passes_of(scene)
    assert ((colour[..., 3] > 0) & (colour[..., 3] < 1) & (depth > 1e9)).any()
    node = new_node(tree)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    pictures = []
    for choice in ("keep", "solid", "all", "edges"):
        scene.camera.data.rack_focus.film_depth = choice
        pictures.append(made_by(scene))
        same(pictures[-1], filtered(scene, colour, depth))
    assert np.abs(pictures[0] - pictures[2]).max() > 0.01


def masks_of(scene, tree, source):
    """What nodes can mask by, {name that is said: socket}."""
    layer = scene.view_layers[0]
    layer.use_pass_object_index = True
    aov = layer.aovs.add()
    aov.name, aov.type = "Masked", "VALUE"
    layer.update()
    matte = tree.nodes.new("CompositorNodeCryptomatteV2")
    matte.source, matte.scene = "RENDER", scene
    index = next(o for o in source.outputs if o.name in ("Object Index", "IndexOB"))
    sockets = {index.name: index, "Masked": source.outputs["Masked"]}
    return {**sockets, "Cryptomatte": matte.outputs["Matte"]}


@check
def passes_that_are_not_blurred_are_named():
    """Box and console name passes of light that lead to the output past Rack Focus."""
    scene, tree, source, out = bare()
    layer = scene.view_layers[0]
    layer.use_pass_emit = layer.use_pass_mist = True
    layer.cycles.denoising_store_passes = True
    start(scene)
    unblurred = addon("unblurred")
    assert not unblurred.describe(scene)
    emission = next(o for o in source.outputs if o.name.startswith("Emi"))
    tree.links.new(source.outputs["Denoising Albedo"], out)
    assert not unblurred.names_of(scene)
    light = add_gain(tree, emission, 2)
    assert not unblurred.names_of(scene)  # it leads nowhere
    tree.links.new(light, out)
    assert unblurred.names_of(scene) == [emission.name]
    with heard() as said:
        sharp = made_by(scene)
    assert f"that are not blurred: {emission.name}" in said.getvalue(), said.getvalue()
    tree.links.new(source.outputs["Mist"], light.node.inputs["Exposure"])
    assert set(unblurred.names_of(scene)) == {emission.name, "Mist"}
    tree.links.remove(light.node.inputs["Exposure"].links[0])
    for name, socket in masks_of(scene, tree, source).items():
        link = tree.links.new(socket, light.node.inputs["Exposure"])
        assert set(unblurred.names_of(scene)) == {emission.name, name}
        tree.links.remove(link)
    node = new_node(tree)  # what the box tells to do
    tree.links.new(light, node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    assert not unblurred.describe(scene)
    _, depth = passes_of(scene)
    assert np.allclose(made_by(scene), filtered(scene, sharp, depth), atol=1e-5)


@check
def after_a_denoise_node():
    """The one tick puts the node after Denoise, whose guides are sharp."""
    scene, tree, source, out = bare()
    denoise = tree.nodes.new("CompositorNodeDenoise")
    tree.links.new(source.outputs["Image"], denoise.inputs["Image"])
    tree.links.new(denoise.outputs["Image"], out)
    colour = rgba(render(scene, OUT / "g_denoised.exr"))
    _, depth = passes_of(scene)
    before = common.snapshot(scene)
    start(scene)
    node = next(n for n in tree.nodes if addon("group").is_ours(n))
    assert node.inputs["Image"].links[0].from_node == denoise
    assert out.links[0].from_node == node
    assert denoise.inputs["Image"].links[0].from_node == source
    same(made_by(scene), filtered(scene, colour, depth))
    scene.camera.data.rack_focus.enabled = False
    after = common.snapshot(scene)
    before[0]["images"] = after[0]["images"]
    assert after == before, (before, after)


@check
def one_node_after_a_denoise_node():
    """Where the artist adds one, before the tick or after it, there is no second."""
    scene, tree, source, out = bare()
    denoise = tree.nodes.new("CompositorNodeDenoise")
    tree.links.new(source.outputs["Image"], denoise.inputs["Image"])
    tree.links.new(denoise.outputs["Image"], out)
    start(scene)
    wanted = made_by(scene)
    for is_ticked, is_behind in ((False, False), (True, False), (True, True)):
        scene.camera.data.rack_focus.enabled = is_ticked
        addon("handlers").on_change()
        ours = [n for n in tree.nodes if addon("group").is_ours(n)]
        assert len(ours) == int(is_ticked)
        tree.nodes.active = ours[0] if is_behind else denoise
        bpy.ops.rack_focus.add_picture_node()
        ours = [n for n in tree.nodes if addon("group").is_ours(n)]
        assert len(ours) == 1, [n.name for n in ours]
        assert ours[0].inputs["Image"].links[0].from_node == denoise
        assert out.links[0].from_node == ours[0]
        same(made_by(scene), wanted)
        scene.camera.data.rack_focus.enabled = False
        addon("handlers").on_change()
        tree.nodes.remove(ours[0])
        tree.links.new(denoise.outputs["Image"], out)
        addon("handlers").on_change()


@check
def two_lenses_and_a_chain():
    """Each node has the lens of its own camera; one may follow the other."""
    scene, tree, source, out = bare()
    colour, depth = passes_of(scene)
    other = scene.camera.copy()
    other.data = scene.camera.data.copy()
    other.data.dof.focus_distance, other.data.dof.aperture_fstop = 6, 0.4
    scene.collection.objects.link(other)
    first, second = new_node(tree), new_node(tree)
    tree.links.new(source.outputs["Image"], second.inputs["Image"])
    tree.links.new(second.outputs["Image"], first.inputs["Image"])
    tree.links.new(first.outputs["Image"], out)
    second.node_tree.rack_focus.camera = other
    start(scene)
    own, scene.camera = scene.camera, other
    once = filtered(scene, colour, depth)
    scene.camera = own
    same(made_by(scene), filtered(scene, once, depth))


def put_image(tree, name, pixels):
    """An Image node with a picture of (height, width, 4), rows downwards."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
    image.alpha_mode = "PREMUL"
    image.pixels.foreach_set(np.ascontiguousarray(pixels[::-1], np.float32).ravel())
    image.update()
    node = tree.nodes.new("CompositorNodeImage")
    node.image = image
    return node


def plate(scene, size=(72, 48)):
    """A picture and depths that no scene has."""
    rng = np.random.default_rng(3)
    width, height = size
    colour = np.ones((height, width, 4), np.float32)
    colour[..., :3] = rng.random((height, width, 3))
    depth = np.full((height, width), 8, np.float32)
    depth[:, : width // 2] = 2
    return colour, depth


@check
def plates_are_filtered_without_rendering():
    """Image and depth from files; the scene is not rendered."""
    for size in ((72, 48), (36, 24)):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        scene, tree, source, out = bare()
        colour, depth = plate(scene, size)
        tree.nodes.remove(source)
        node = new_node(tree)
        shown = put_image(tree, "plate", colour)
        channels = np.repeat(depth[..., None], 4, -1)
        far = put_image(tree, "depth", channels)
        split = tree.nodes.new("CompositorNodeSeparateColor")
        tree.links.new(far.outputs["Image"], split.inputs[0])
        tree.links.new(shown.outputs["Image"], node.inputs["Image"])
        tree.links.new(split.outputs[0], node.inputs["Depth"])
        tree.links.new(node.outputs["Image"], out)
        start(scene)
        scene.render.resolution_x, scene.render.resolution_y = size
        wanted = filtered(scene, colour, depth)
        scene.cycles.samples = 4096  # would be seen in the time
        same(made_by(scene), wanted)
        assert not addon("setup").layer_nodes(tree, scene)


@check
def the_mask_scales_the_blur():
    """0: sharp, 1: the lens; between, the CoC is a part of the lens's."""
    scene, tree, source, out = bare()
    colour, depth = passes_of(scene)
    node = new_node(tree)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    wanted = filtered(scene, colour, depth)
    node.inputs["Mask"].default_value = 0
    made = made_by(scene)
    assert np.abs(made - colour).max() < 1e-5, np.abs(made - colour).max()
    mask = np.ones((48, 72, 4), np.float32)
    mask[:, :36] = 0
    shown = put_image(tree, "mask", mask)
    tree.links.new(shown.outputs["Image"], node.inputs["Mask"])
    made = made_by(scene)
    assert np.abs(made[:, :10] - colour[:, :10]).max() < 1e-5
    assert np.abs(made[:, 36:] - wanted[:, 36:]).mean() < 0.05
    look, focus = addon("look"), 3.0
    values = np.float32([[0.5, 1, 2, 3, 5, 50, 1e10]])
    for part in (0.25, 0.5):
        new = look.with_mask(values, part, focus, False)
        assert np.allclose(1 / focus - 1 / new, part * (1 / focus - 1 / values), 1e-4)
        flat = look.with_mask(values[:, :6], part, focus, True)
        assert np.allclose(flat - focus, part * (values[:, :6] - focus), 1e-4)


@check
def every_output():
    """Alpha, CoC, Depth and Focus as of the layer node."""
    scene, tree, source, out = bare()
    colour, depth = passes_of(scene)
    node = new_node(tree)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    start(scene)
    wanted = filtered(scene, colour, depth)
    params = addon("lens").frame_parameters(
        scene.camera, scene.camera.data.rack_focus, scene.render, (72, 48)
    )
    library = addon("library").rackfocus
    made = library.Filter(72, 48, **params)
    coc = np.empty((48, 72), np.float32)
    made.coc(np.minimum(depth, np.float32(1e8)), coc)
    found = {}
    for name in ("Alpha", "CoC", "Depth", "Focus"):
        tree.links.new(node.outputs[name], out)
        found[name] = made_by(scene)
    assert np.allclose(found["CoC"][..., 0], coc, rtol=1e-5), "CoC"
    assert np.array_equal(found["Depth"][..., 0], depth), "Depth"
    assert np.allclose(found["Alpha"][..., 0], wanted[..., 3]), "Alpha"
    limit = made.lens.coc_limit_px
    overlay = addon("nodes").overlay(wanted, coc[..., None], limit)
    assert np.allclose(found["Focus"], overlay, atol=1e-6), "Focus"


@check
def refocus_takes_what_was_given():
    """Neither rendered nor tapped again; the picture is that of a new render."""
    scene, tree, source, out = bare()
    node = new_node(tree)
    gain = add_gain(tree, source.outputs["Image"], 2)
    tree.links.new(gain, node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    made_by(scene)
    scene.camera.data.dof.focus_distance = 1.7
    scene.cycles.seed = 5
    assert addon("setup").can_mute_sources(scene)
    bpy.ops.rack_focus.refocus()
    common.set_output(scene, OUT / "g_refocus.exr")
    bpy.data.images["Render Result"].save_render(
        str(OUT / "g_refocus.exr"), scene=scene
    )
    assert "tap" not in addon("engine").last_run[scene.name]["seconds"]
    made = rgba(common.read(OUT / "g_refocus.exr"))
    scene.cycles.seed = 0
    same(made, made_by(scene))
    # A way past the node: the render is needed again.
    mix = tree.nodes.new("CompositorNodeAlphaOver")
    tree.links.new(
        source.outputs["Image"], [s for s in mix.inputs if s.type == "RGBA"][0]
    )
    tree.links.new(mix.outputs[0], out)
    assert not addon("setup").can_mute_sources(scene)


@check
def an_animation():
    """Every frame is that of a render alone: images and taps are of the frame."""
    scene, tree, source, out = bare()
    node = new_node(tree)
    exposure = add_gain(tree, source.outputs["Image"], 1).node
    tree.links.new(exposure.outputs[0], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    data = scene.camera.data
    for frame, focus, gain in ((1, 2, 0), (3, 5, 2)):
        data.dof.focus_distance = focus
        data.dof.keyframe_insert("focus_distance", frame=frame)
        exposure.inputs["Exposure"].default_value = gain
        exposure.inputs["Exposure"].keyframe_insert("default_value", frame=frame)
    scene.frame_start, scene.frame_end = 1, 3
    common.set_output(scene, OUT / "g_anim_####.exr")
    bpy.ops.render.render(animation=True)
    frames = [rgba(common.read(OUT / f"g_anim_{i:04}.exr")) for i in (1, 2, 3)]
    for number, picture in zip((1, 2, 3), frames, strict=True):
        scene.frame_set(number)
        same(made_by(scene, "g_alone"), picture)
    assert np.abs(frames[0] - frames[2]).max() > 0.1


def message_of(scene):
    """Of a render that fails; some Blenders raise then."""
    with contextlib.suppress(RuntimeError):
        bpy.ops.render.render(write_still=True)
    return last_message(scene)


@check
def a_node_for_each_view_layer():
    """Each takes the depth of its own layer where none is linked."""
    scene, tree, source, out = bare()
    far = bpy.data.collections.new("far")
    scene.collection.children.link(far)
    for item in [o for o in scene.objects if o.type == "MESH" and o.location.y > 3.5]:
        scene.collection.objects.unlink(item)
        far.objects.link(item)
    back = scene.view_layers.new("Back")
    first = scene.view_layers[0]
    first.layer_collection.children["far"].exclude = True
    for one in (first, back):
        one.use_pass_z = True
    channels = pinhole(scene, OUT / "g_layers.exr")
    second = addon("compat").new_layer_node(tree, scene)
    second.layer = back.name
    found = {}
    for layer, from_node in ((first, source), (back, second)):
        node = new_node(tree)
        node.node_tree.rack_focus.layer = layer.name
        tree.links.new(from_node.outputs["Image"], node.inputs["Image"])
        tree.links.new(node.outputs["Image"], out)
        found[layer.name] = node
    start(scene)
    for name, node in found.items():
        tree.links.new(node.outputs["Image"], out)
        colour, depth = rgba(channels, name), common.depth_of(channels, name)
        same(made_by(scene), filtered(scene, colour, depth))
    # Renamed, the layer is the first one's again rather than none.
    assert addon("group").layer_of(scene, found["Back"]) == "Back"
    back.name = "Behind"
    assert addon("group").layer_of(scene, found["Back"]) == first.name


def load_sequence(tree, path, n_frames):
    """An Image node that shows a sequence of files from frame 1 on."""
    node = tree.nodes.new("CompositorNodeImage")
    node.image = bpy.data.images.load(str(path))
    node.image.source = "SEQUENCE"
    node.image.alpha_mode = "PREMUL"
    node.frame_duration, node.frame_start = n_frames, 1
    node.use_auto_refresh = True
    return node


@check
def a_sequence_of_files():
    """Colour and depth from EXR files on disk: each frame is that of its files."""
    scene, tree, source, out = bare()
    tree.nodes.remove(source)
    frames, folder = [], OUT / "sequence"
    folder.mkdir(exist_ok=True)
    for number in (1, 2, 3):
        colour, depth = plate(scene)
        colour[..., :3] = np.roll(colour[..., :3], 7 * number, 1)
        depth += number
        planes = {c: colour[..., i] for i, c in enumerate("RGBA")}
        addon("exr").write_exr(folder / f"colour_{number:04}.exr", planes, b"")
        flat = {c: depth for c in "RGB"} | {"A": np.ones_like(depth)}
        addon("exr").write_exr(folder / f"depth_{number:04}.exr", flat, b"")
        frames.append((colour, depth))
    node = new_node(tree)
    shown = load_sequence(tree, folder / "colour_0001.exr", 3)
    far = load_sequence(tree, folder / "depth_0001.exr", 3)
    split = tree.nodes.new("CompositorNodeSeparateColor")
    tree.links.new(far.outputs["Image"], split.inputs[0])
    tree.links.new(shown.outputs["Image"], node.inputs["Image"])
    tree.links.new(split.outputs[0], node.inputs["Depth"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    scene.frame_start, scene.frame_end = 1, 3
    common.set_output(scene, OUT / "g_files_####.exr")
    bpy.ops.render.render(animation=True)
    assert not last_message(scene), last_message(scene)
    for number, (colour, depth) in enumerate(frames, 1):
        made = rgba(common.read(OUT / f"g_files_{number:04}.exr"))
        same(made, filtered(scene, colour, depth))


@check
def what_cannot_be_had():
    """Nothing linked, another size: a message with the way out, a sharp picture."""
    scene, tree, source, out = bare()
    colour, _ = passes_of(scene)
    node = new_node(tree)
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    common.set_output(scene, OUT / "g_bad.exr")
    assert "nothing is linked to Image" in message_of(scene)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    small = put_image(tree, "small", np.ones((4, 4, 4)))
    tree.links.new(small.outputs["Image"], node.inputs["Depth"])
    assert "of the same size" in message_of(scene)
    same(rgba(common.read(OUT / "g_bad.exr")), colour)


@check
def the_node_leaves_nothing():
    """Deleted, its group and images go; renders leave no scene, image or file."""
    scene, tree, source, out = bare()
    render(scene, OUT / "g.exr")  # makes the Render Result
    before = common.counts()
    node = new_node(tree)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    made_by(scene)
    counted = common.counts()
    made_by(scene)
    assert common.counts() == counted
    tree.nodes.remove(node)
    scene.camera.data.rack_focus.enabled = False
    addon("group").remove_unused()
    after = common.counts()
    assert after == before, (before, after)
    assert not common.own_memory_folders()


@check
def the_menu_puts_it_behind_the_active_node():
    """Behind it and before what follows; our layer node does not blur before it."""
    scene, tree, source, out = bare()
    colour, depth = passes_of(scene)
    gain = add_gain(tree, source.outputs["Image"], 2).node
    tree.links.new(gain.outputs[0], out)
    start(scene)
    ours = addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]
    assert gain.inputs["Image"].links[0].from_node == ours
    tree.nodes.active = gain
    assert bpy.ops.rack_focus.add_picture_node() == {"FINISHED"}
    node = addon("group").nodes_of(scene)[0]
    assert out.links[0].from_node == node
    assert node.inputs["Image"].links[0].from_node == gain
    assert gain.inputs["Image"].links[0].from_node == source
    wanted = filtered(scene, colour * np.float32([2, 2, 2, 1]), depth)
    assert np.allclose(made_by(scene), wanted, rtol=1e-4, atol=1e-5)
    # Without Rack Focus before: the camera is ticked by it.
    bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
    scene, tree, source, out = bare()
    tree.nodes.active = source
    bpy.ops.rack_focus.add_picture_node()
    assert scene.camera.data.rack_focus.enabled
    same(made_by(scene), filtered(scene, colour, depth))
    assert tree.nodes.active.type == "GROUP"


@check
def copied_nodes_have_groups_of_their_own():
    """And pictures."""
    scene, tree, source, out = bare()
    first, second = new_node(tree), tree.nodes.new("CompositorNodeGroup")
    second.node_tree = first.node_tree
    addon("group").separate([scene])
    assert first.node_tree != second.node_tree
    assert second.node_tree.rack_focus.is_node


@check
def an_asset_from_another_file():
    """The group marked as an asset and appended: it filters with the file's camera."""
    scene, tree, source, out = bare()
    node = new_node(tree)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    wanted = made_by(scene)
    node.node_tree.asset_mark()
    name, path = node.node_tree.name, str(OUT / "g_asset.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
    scene, tree, source, out = bare()
    with bpy.data.libraries.load(path, link=False) as (_, found):
        found.node_groups = [name]
    node = tree.nodes.new("CompositorNodeGroup")
    node.node_tree = found.node_groups[0]
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    same(made_by(scene), wanted)


@check
def an_id_mask_keeps_an_object_sharp():
    """Its matte as the Mask, while the nodes before ours are composited by themselves."""
    scene, tree, source, out = bare()
    colour, _ = passes_of(scene)
    scene.view_layers[0].use_pass_object_index = True
    cubes = [o for o in scene.objects if o.type == "MESH"]
    for cube in cubes:
        cube.pass_index = 1
    node = new_node(tree)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    matte = tree.nodes.new("CompositorNodeIDMask")
    if "Index" in matte.inputs:  # 5.x
        matte.inputs["Index"].default_value = 1
    else:
        matte.index = 1
    index = next(o for o in source.outputs if o.name in ("IndexOB", "Object Index"))
    tree.links.new(index, matte.inputs[0])
    invert = tree.nodes.new("CompositorNodeInvert")
    tree.links.new(matte.outputs[0], [s for s in invert.inputs if s.type == "RGBA"][0])
    tree.links.new(invert.outputs[0], node.inputs["Mask"])
    start(scene)
    made = made_by(scene)
    given, _ = addon("nodes")._kept[scene.name][node.name]
    inside = given.mask < 0.5
    assert 0.01 < inside.mean() < 0.9, inside.mean()
    assert np.abs(made - colour)[inside].max() < 0.5
    node.inputs["Mask"].links[0].from_node.mute = True
    unmasked = made_by(scene)
    error = [np.abs(p - colour)[inside].mean() for p in (made, unmasked)]
    assert error[0] < 0.3 * error[1] or error[1] < 1e-6, error


@check
def files_with_the_node():
    """Saved, they pass the picture through; opened, a render filters."""
    scene, tree, source, out = bare()
    node = new_node(tree)
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    tree.links.new(node.outputs["Image"], out)
    start(scene)
    wanted = made_by(scene)
    group = node.node_tree
    assert group.rack_focus.is_filtered
    path = str(OUT / "g_file.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    assert group.rack_focus.is_filtered
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    node = addon("group").nodes_of(scene)[0]
    assert not node.node_tree.rack_focus.is_filtered
    same(made_by(scene), wanted)


@check
def the_denoiser_of_cycles_comes_first():
    """With it on, what is filtered is the denoised picture."""
    scene, _ = common.start()
    scene.cycles.samples = 2
    scene.cycles.max_bounces = 4
    scene.cycles.use_denoising = True
    light = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    scene.collection.objects.link(light)
    try:
        sharp = pinhole(scene, OUT / "g_denoised.exr")
    except RuntimeError as error:
        assert "without OpenImageDenoiser" in str(error), error  # Debian's 3.4
        return
    noisy = [n for n in sharp if "Noisy Image" in n]
    colour = rgba(sharp, "ViewLayer")
    if noisy and common.V < (5, 1, 0):  # Debian's newest has no denoiser either
        before = np.stack([sharp[f"ViewLayer.Noisy Image.{c}"] for c in "RGB"], -1)
        assert np.abs(before - colour[..., :3]).max() > 1e-3
    made = rgba(render(scene, OUT / "g_denoised.exr"))
    same(made, filtered(scene, colour, common.depth_of(sharp)))


checking.run(check, "group_results.json")
