# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the user's own nodes with ours: File Output, node groups."""

import contextlib
import shutil

import bpy
import common
import numpy as np
from checking import OUT, Checks, heard
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


def expected(scene):
    """What the filter makes of the passes of the scene."""
    sharp = pinhole(scene, OUT / "n_passes.exr")
    return filtered(scene, rgba(sharp, "ViewLayer"), common.depth_of(sharp))


def our_node(tree, scene):
    """The node that Rack Focus put into a tree."""
    return addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]


def add_file_output(tree, folder):
    """A File Output node that writes an EXR of full precision; returns its input."""
    node = tree.nodes.new("CompositorNodeOutputFile")
    settings = node.format
    if hasattr(node, "file_output_items"):  # 5.x
        node.directory, node.file_name = str(folder), "file"
        settings.media_type = "IMAGE"
        node.file_output_items.clear()
        node.file_output_items.new("RGBA", "picture")
    else:
        node.base_path = str(folder)
        node.file_slots[0].path = "picture"
    settings.file_format = "OPEN_EXR"
    settings.color_mode, settings.color_depth = "RGBA", "32"
    settings.exr_codec = "NONE"
    return node.inputs[0]


@check
def file_output_nodes():
    """They write the filtered picture, after a render and after a refocus."""
    folder = OUT / "file_output"
    scene, data = start()
    tree = common.tree_of(scene)
    target = add_file_output(tree, folder)
    tree.links.new(our_node(tree, scene).outputs["Image"], target)
    for distance, call in (
        (3, bpy.ops.render.render),
        (1.5, bpy.ops.rack_focus.refocus),
    ):
        for old in folder.glob("*.exr"):
            old.unlink()
        data.dof.focus_distance = distance
        call()
        assert not last_message(scene), last_message(scene)
        written = list(folder.glob("*.exr"))
        assert len(written) == 1, written
        made = rgba(common.read(written[0]))
        kept = addon("passes").rendered(scene).layer("ViewLayer")
        same(made, filtered(scene, kept.colour, kept.depth))


@check
def file_output_nodes_of_other_pictures():
    """A refocus that shows another frame, another view, or the CoC writes no files.

    Nodes in groups neither; muted ones stay so. Then a refocus writes again.
    """
    folder = OUT / "other_pictures"
    scene, data = start()
    tree = common.tree_of(scene)
    group = group_of(scene, 1)
    inner = next(n for n in group.nodes if n.type == "GROUP_INPUT").outputs[0]
    group.links.new(inner, add_file_output(group, folder / "inner"))
    off = add_file_output(tree, folder / "off").node
    off.mute = True
    holder = tree.nodes.new("CompositorNodeGroup")
    holder.node_tree = group
    picture = our_node(tree, scene).outputs["Image"]
    for end in (holder.inputs[0], add_file_output(tree, folder)):
        tree.links.new(picture, end)
    scene.frame_set(3)
    bpy.ops.render.render()

    def written(call=bpy.ops.rack_focus.refocus, **about):
        for old in folder.rglob("*.exr"):
            old.unlink()
        assert call(**about) == {"FINISHED"}
        muted = [n for one in (tree, group) for n in one.nodes if n.mute]
        assert muted == [off], muted
        return sorted(path.parent.name for path in folder.rglob("*.exr"))

    both = ["inner", "other_pictures"]
    assert written() == both
    assert written(bpy.ops.rack_focus.show, show="coc") == []
    assert written(bpy.ops.rack_focus.show, show="picture") == both
    scene.frame_set(1)
    with heard() as said:
        assert written() == []
    assert "press F12 for frame 1. File Output nodes write nothing" in said.getvalue()
    scene.frame_set(3)
    assert written() == both
    scene.camera.location.x += 0.1
    assert written() == []
    assert "File Output" in last_message(scene)
    scene.camera.location.x -= 0.1
    assert written() == both
    check_a_file_saved_meanwhile(scene)


def check_a_file_saved_meanwhile(scene):
    """File Output nodes that a refocus had muted write again where it is opened."""
    path, n_muted = OUT / "saved_meanwhile.blend", []

    def outputs():
        return [
            node
            for tree in {common.tree_of(bpy.context.scene), *bpy.data.node_groups}
            for node in tree.nodes
            if node.type == "OUTPUT_FILE"
        ]

    def save(*_):
        n_muted.append(sum(node.mute for node in outputs()))
        bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)

    scene.frame_set(1)
    bpy.app.handlers.render_pre.append(save)
    bpy.ops.rack_focus.refocus()
    bpy.app.handlers.render_pre.remove(save)
    assert max(n_muted) == 3, n_muted
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert [node.mute for node in outputs()].count(True) == 1
    assert len(outputs()) == 3


def group_of(scene, depth):
    """A group that mirrors its input, inside `depth` - 1 others; its innermost."""
    inner = None
    for level in range(depth):
        group = bpy.data.node_groups.new(f"level{level}", "CompositorNodeTree")
        if hasattr(group, "interface"):
            for side in ("INPUT", "OUTPUT"):
                group.interface.new_socket(
                    "Image", in_out=side, socket_type="NodeSocketColor"
                )
        else:
            group.inputs.new("NodeSocketColor", "Image")
            group.outputs.new("NodeSocketColor", "Image")
        begin, end = (group.nodes.new(f"NodeGroup{x}") for x in ("Input", "Output"))
        if inner is None:
            node = group.nodes.new("CompositorNodeFlip")
            if "Flip X" in node.inputs:  # 4.5 and later
                node.inputs["Flip X"].default_value = True
                node.inputs["Flip Y"].default_value = False
        else:
            node = group.nodes.new("CompositorNodeGroup")
            node.node_tree = inner
        group.links.new(begin.outputs[0], node.inputs[0])
        group.links.new(node.outputs[0], end.inputs[0])
        inner = group
    return inner


@check
def our_picture_through_groups():
    """A group in a group between our node and the output; off again, it stays."""
    scene = bpy.context.scene
    tree, _ = addon("compat").start_compositor(scene)
    source = addon("setup").layer_nodes(tree, scene)[0]
    node = tree.nodes.new("CompositorNodeGroup")
    node.node_tree = group_of(scene, 2)
    out = addon("compat").output_socket(tree)
    tree.links.new(source.outputs["Image"], node.inputs[0])
    tree.links.new(node.outputs[0], out)
    before = common.snapshot(scene)
    _, data = start()
    made = rgba(render(scene, OUT / "n_groups.exr"))
    same(made, expected(scene)[:, ::-1])
    data.rack_focus.enabled = False
    assert common.snapshot(scene)[1:] == before[1:]


@check
def render_layers_in_a_group():
    """The group's node shows the filtered picture, and is as before when off.

    Up to 4.5 there are none in groups; later Blender renders only what a node outside
    of groups looks at, so one is there as well.
    """
    scene = bpy.context.scene
    if not addon("compat").HAS_NODE_GROUPS:
        return
    tree, _ = addon("compat").start_compositor(scene)
    group = bpy.data.node_groups.new("layers", "CompositorNodeTree")
    inner = group.nodes.new("CompositorNodeRLayers")
    inner.scene = scene
    group.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    end = group.nodes.new("NodeGroupOutput")
    group.links.new(inner.outputs["Image"], end.inputs[0])
    node = tree.nodes.new("CompositorNodeGroup")
    node.node_tree = group
    tree.links.new(node.outputs[0], addon("compat").output_socket(tree))
    before = sorted(node.name for node in group.nodes)
    _, data = start()
    same(rgba(render(scene, OUT / "n_inner.exr")), expected(scene))
    render(scene, OUT / "n_inner.exr")
    data.dof.focus_distance = 1.5
    bpy.ops.rack_focus.refocus()
    image = bpy.data.images["Render Result"]
    image.save_render(str(OUT / "n_inner.exr"), scene=scene)
    same(rgba(common.read(OUT / "n_inner.exr")), expected(scene))
    for views in (1, 2):  # with no other node of ours: it comes back
        data.rack_focus.views = views
        made = rgba(render(scene, OUT / "n_inner.exr"))
        tree.nodes.remove(our_node(tree, scene))
        same(rgba(render(scene, OUT / "n_inner.exr")), made)
        assert not last_message(scene), last_message(scene)
    data.rack_focus.enabled = False
    assert sorted(node.name for node in group.nodes) == before
    assert inner.outputs["Image"].is_linked


@check
def scatter_spreads_light_by_an_image():
    """The same as with the array; without an image the box and the node say so."""
    scene, data = start(method="scatter", quality="custom", distribution="image")
    sharp = pinhole(scene, OUT / "n_passes.exr")
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    try:
        common.set_output(scene, OUT / "n_light.exr")
        bpy.ops.render.render(write_still=True)
    except RuntimeError as error:
        assert "Picture of the Aperture" in str(error), error
    assert "Picture of the Aperture" in last_message(scene), last_message(scene)
    light = np.zeros((12, 10, 4), np.float32)
    light[2:9, 1:4] = light[7:9, 1:8] = (1, 0.5, 0.25, 1)
    image = bpy.data.images.new("light", 10, 12, float_buffer=True)
    image.pixels.foreach_set(np.ascontiguousarray(light[::-1]).ravel())
    data.rack_focus.distribution_image = image
    made = rgba(render(scene, OUT / "n_light.exr"))
    assert not last_message(scene), last_message(scene)
    params = addon("lens").frame_parameters(
        scene.camera, data.rack_focus, scene.render, depth.shape[::-1]
    )
    picture = np.ascontiguousarray(light[..., :3])
    wanted = addon("library").rackfocus.apply(
        np.ascontiguousarray(colour), depth, distribution_image=picture, **params
    )
    same(made, wanted)
    data.rack_focus.distribution = "uniform"
    assert np.abs(made - rgba(render(scene, OUT / "n_light.exr"))).max() > 0.01


@check
def an_aperture_of_an_image():
    """Final, Views and Scatter take its shape; what is missing is said."""
    scene, data = start()
    settings = data.rack_focus
    sharp = pinhole(scene, OUT / "n_passes.exr")
    colour = np.ascontiguousarray(rgba(sharp, "ViewLayer"))
    depth, library = common.depth_of(sharp), addon("library").rackfocus
    plain = rgba(render(scene, OUT / "n.exr"))
    assert settings.light_keywords() == {}
    settings.use_aperture_image = True
    common.set_output(scene, OUT / "n.exr")
    with contextlib.suppress(RuntimeError):  # of some Blenders, for the report
        bpy.ops.render.render()
    assert "choose a Picture" in last_message(scene)
    pixels = np.ones((16, 16, 4), np.float32)
    pixels[:, 6:10, :3], pixels[:, 10:, :3], pixels[:, :6, :3] = 1, 0, 0
    image = bpy.data.images.new("slit", 16, 16, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    settings.distribution_image = image
    for method in ("layered", "scatter"):
        settings.method = method
        made = rgba(render(scene, OUT / "n.exr"))
        assert not last_message(scene), last_message(scene)
        params = addon("lens").frame_parameters(
            scene.camera, settings, scene.render, (72, 48)
        )
        picture = np.ascontiguousarray(pixels[..., :3])
        about = {"distribution_image": picture}
        about |= {"aperture": "image"} if method == "layered" else {}
        same(made, library.apply(colour, depth, **params, **about))
        assert np.abs(made - plain).max() > 0.05
    settings.method = "box"
    assert settings.light_keywords() == {}


@check
def images_of_bytes_are_decoded():
    """A PNG of 8 bits is sRGB, as for the command."""
    image = bpy.data.images.new("bytes", 3, 2)
    image.pixels.foreach_set(np.repeat(np.float32([0, 0.5, 1] * 2), 4))
    found = addon("pictures").read(image)
    assert found.shape == (2, 3, 3)
    assert np.allclose(found[0, :, 1], [0, 0.2140, 1], atol=3e-3), found[0, :, 1]


@check
def soft_edges_of_a_view():
    """What a view adds up to is the picture over its background, in linear light."""
    pictures = addon("pictures")
    behind, colour = np.float32([0.2, 0.3, 0.4]), np.float32([0.5, 0.6, 2.0])
    for alpha, before in ((0.2, 0), (0.5, 1), (0.9, 0.3), (1, 1)):
        pixel = np.float32([[[*(colour * alpha), alpha]]])
        made = pictures.for_view(pixel, np.float32([[before]]), behind)
        seen = made[0, 0, :3] + (1 - before) * behind
        wanted = alpha * colour + (1 - alpha) * behind
        assert np.allclose(seen, wanted, atol=1e-6), (alpha, before, seen, wanted)
        assert made[0, 0, 3] == np.float32(alpha)
    black = np.float32([[[0, 0, 0, 1]]])
    assert not pictures.for_view(black, np.float32([[0]]), behind)[..., :3].any()


# ---- objects that stay sharp -------------------------------------------------------


@check
def objects_that_stay_sharp():
    """Cryptomatte's ids and coverage; refocused, kept, supersampled; no pass is left."""
    scene = bpy.context.scene
    module, look = addon("sharp"), addon("look")
    assert module.murmur3(b"hello") == 0x248BFA47  # of the reference implementation
    assert module.murmur3(b"hello, world") == 0x149BBB7F
    # Nothing else before the focus, which would be blurred over it.
    near = [o for o in scene.objects if o.type == "MESH" and o.location.y < 2.9]
    item, *others = sorted(near, key=lambda o: o.location.y)
    for other in others:
        bpy.data.objects.remove(other)
    item.name, item.scale = "Ä near object", (2, 2, 2)
    item.location.x = item.location.z = 0
    before = snapshot(scene)[1:4]
    layer = scene.view_layers[0]
    sharp = pinhole(scene, OUT / "s_passes.exr")
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    folder = OUT / "sharp"
    shutil.rmtree(folder, ignore_errors=True)
    _, data = start(passes_folder=str(folder))
    plain = rgba(render(scene, OUT / "s.exr"))
    assert not getattr(layer, module.SWITCH.name)
    item.rack_focus_keep_sharp = True
    made = rgba(render(scene, OUT / "s.exr"))
    assert not common.last_message(scene), common.last_message(scene)
    found = addon("passes").rendered(scene).layer("ViewLayer")
    covered = module.coverage(found.mattes, [item.name])
    assert 0.005 < (covered == 1).mean() < 0.5 and ((covered > 0) & (covered < 1)).any()
    focus = data.dof.focus_distance
    wanted = look.with_mask(depth, 1 - covered, focus, False)
    same(made, filtered(scene, colour, wanted))
    inside = covered == 1
    away = np.abs(made - colour)[inside].mean(), np.abs(plain - colour)[inside].mean()
    assert away[0] < 0.3 * away[1], away
    data.dof.aperture_fstop = 0.3
    bpy.ops.rack_focus.refocus()
    again = common.result(scene, OUT / "s_result.exr")
    same(again, filtered(scene, colour, wanted))
    path = str(OUT / "sharp.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    bpy.ops.rack_focus.refocus()  # from the files
    same(common.result(scene, OUT / "s_result.exr"), again)
    data = scene.camera.data
    data.rack_focus.supersample = 2
    large = rgba(render(scene, OUT / "s.exr"))
    assert not common.last_message(scene), common.last_message(scene)
    assert np.abs(large - again).mean() < 0.05
    data.rack_focus.supersample = 1
    for item in scene.objects:
        item.rack_focus_keep_sharp = False
    render(scene, OUT / "s.exr")
    assert not getattr(scene.view_layers[0], module.SWITCH.name)
    scene.objects[-1].rack_focus_keep_sharp = True
    render(scene, OUT / "s.exr")
    assert getattr(scene.view_layers[0], module.SWITCH.name)
    data.rack_focus.enabled = False
    assert not getattr(scene.view_layers[0], module.SWITCH.name)
    assert snapshot(scene)[1:4] == before  # meshes without users were not saved


@check
def our_engine_chosen_for_a_scene():
    """The scene stays, however it is saved and opened; what to choose is said."""
    scene, _ = start()
    wanted = rgba(render(scene, OUT / "engine0.exr"))
    scene.render.engine = scene.name = "RACK_FOCUS"
    bpy.data.scenes.new("Other")
    path = str(OUT / "engine.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    addon("setup").remove_orphans()  # as with a newer version of the add-on
    assert len(bpy.data.scenes) == 3, list(bpy.data.scenes)
    scene = bpy.data.scenes["RACK_FOCUS"]
    with heard() as said, contextlib.suppress(RuntimeError):
        render(scene, OUT / "engine1.exr")
    assert "choose Cycles or EEVEE" in said.getvalue(), said.getvalue()
    assert "choose Cycles or EEVEE" in addon("setup").why_not(scene)
    scene.render.engine = "CYCLES"
    addon("setup").filter_scene_of(scene).render.engine = "CYCLES"  # is set back
    same(rgba(render(scene, OUT / "engine1.exr")), wanted)
    for name in ("Other", "RACK_FOCUS"):
        bpy.data.scenes.remove(bpy.data.scenes[name])
    addon("setup").remove_orphans()  # Blender keeps the last one
    assert len(bpy.data.scenes) == 1


@check
def what_is_said_of_the_compositor_helps():
    """Where it is off, or our node muted or deleted, ticking again filters."""
    scene, data = start()
    wanted = rgba(render(scene, OUT / "off0.exr"))
    for what in ("off", "muted", "deleted"):
        tree, node = common.tree_of(scene), None
        if what == "off" and hasattr(scene, "compositing_node_group"):
            scene.compositing_node_group = None
        elif what == "off":
            scene.use_nodes = False
        else:
            node = our_node(tree, scene)
            node.mute = True
        if what == "deleted":
            tree.nodes.remove(node)
        with heard() as said:
            render(scene, OUT / "off1.exr")
        assert "untick Rack Focus and tick it again" in said.getvalue(), said.getvalue()
        data.rack_focus.enabled = False
        data.rack_focus.enabled = True
        same(rgba(render(scene, OUT / "off2.exr")), wanted)
