# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of what files of others hold and the scenes of the other checks do not.

file_checks.py DIST OUT [CHECK ...]    writes OUT/file_results.json
"""

import contextlib
import shutil
import sys
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import (  # noqa: E402
    OUT,
    Checks,
    heard,
    refocused,
    shot,
    tree_with_output,
    update,
)
from common import (  # noqa: E402
    V,
    addon,
    kept,
    last_message,
    read,
    render,
    result,
    rgba,
    same,
    start,
    tpsnr,
)

check = Checks()


@contextlib.contextmanager
def rendered_scenes():
    """Names of the scenes that are evaluated for a render meanwhile."""
    seen = []

    def note(scene, depsgraph=None):
        if depsgraph is not None and depsgraph.mode == "RENDER":
            seen.append(scene.name)

    bpy.app.handlers.frame_change_post.append(note)
    try:
        yield seen
    finally:
        bpy.app.handlers.frame_change_post.remove(note)


# ---- nodes ------------------------------------------------------------------------


class OldNode(bpy.types.CompositorNode):
    """A node of a type that a later Blender lacks."""

    bl_idname = "CompositorNodeOld"
    bl_label = "Old"

    def init(self, _context):
        """It passes a picture through."""
        self.inputs.new("NodeSocketColor", "Image")
        self.outputs.new("NodeSocketColor", "Image")


@check
def a_node_that_this_blender_lacks():
    """4.4 to 5.0 composite nothing then: one view, sharp, and a message; not a crash."""
    scene = bpy.context.scene
    tree, *_ = tree_with_output(scene)
    bpy.utils.register_class(OldNode)
    node, path = tree.nodes.new(OldNode.bl_idname), str(OUT / "old_node.blend")
    node.name = "Old One"
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    tree.nodes.remove(node)
    bpy.utils.unregister_class(OldNode)
    bpy.ops.wm.open_mainfile(filepath=path)
    sharp = shot(bpy.context.scene, "old0.exr")
    scene, data = start(views=3)
    made = shot(scene, "old1.exr")
    if not addon("compat").UNKNOWN_NODES_STOP:
        assert not last_message(scene) and not np.array_equal(made, sharp)
        return
    same(made, sharp)
    assert "“Old One”: delete that" in last_message(scene), last_message(scene)
    assert len(bpy.data.scenes) == 2
    data.dof.use_dof = True
    assert not np.array_equal(shot(scene, "old2.exr"), sharp)  # the camera's own lens


def add_matte(scene, tree, source):
    """A Cryptomatte node of a near cube behind a Render Layers node."""
    scene.view_layers[0].use_pass_cryptomatte_object = True
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.scene = scene
    near = min(
        (o for o in scene.objects if o.type == "MESH"), key=lambda o: o.location.y
    )
    node.matte_id = near.name
    if source is not None:
        tree.links.new(source.outputs["Image"], node.inputs["Image"])
    return node


@check
def a_cryptomatte_node():
    """Its matte is there with one view, after a refocus and with several views."""
    scene = bpy.context.scene
    tree, layers, output = tree_with_output(scene)
    node = add_matte(scene, tree, layers)
    tree.links.new(node.outputs["Matte"], output)
    before = node.layer_name
    plain = shot(scene, "matte0.exr")[..., 0]
    assert 0.001 < plain.mean() < 0.5
    _, data = start()
    update()
    same(shot(scene, "matte1.exr")[..., 0], plain)
    assert not addon("setup").can_mute_sources(scene)
    assert bpy.ops.rack_focus.refocus() == {"FINISHED"}
    same(result(scene, OUT / "matte2.exr")[..., 0], plain)
    data.rack_focus.views = 3
    with rendered_scenes() as seen:
        seen_with_views = shot(scene, "matte3.exr")[..., 0]
    assert scene.name not in seen, seen
    assert np.abs(seen_with_views - plain).mean() < 0.03
    assert abs(seen_with_views.mean() / plain.mean() - 1) < 0.3
    assert (node.scene, node.layer_name) == (scene, before)
    assert not last_message(scene), last_message(scene)
    assert len(node.keys()) == 0 and not node.mute


@check
def a_cryptomatte_node_in_a_group():
    """The same with one view, after a refocus and with several; from 5.0 on."""
    if not addon("compat").HAS_NODE_GROUPS:
        return
    scene = bpy.context.scene
    tree, _, output = tree_with_output(scene)
    inner = bpy.data.node_groups.new("Mattes", "CompositorNodeTree")
    addon("compat").new_socket(inner, "Matte", "OUTPUT", "NodeSocketFloat")
    node = add_matte(scene, inner, None)
    end = inner.nodes.new("NodeGroupOutput")
    inner.links.new(node.outputs["Matte"], end.inputs["Matte"])
    outer = tree.nodes.new("CompositorNodeGroup")
    outer.node_tree = inner
    tree.links.new(outer.outputs["Matte"], output)
    plain = shot(scene, "group0.exr")[..., 0]
    assert 0.001 < plain.mean() < 0.5
    _, data = start()
    update()
    same(shot(scene, "group1.exr")[..., 0], plain)
    assert bpy.ops.rack_focus.refocus() == {"FINISHED"}
    same(result(scene, OUT / "group2.exr")[..., 0], plain)
    data.rack_focus.views = 3
    with_views = shot(scene, "group3.exr")[..., 0]
    assert abs(with_views.mean() / plain.mean() - 1) < 0.3
    assert node.scene == scene and len(node.keys()) == 0


@check
def a_cryptomatte_node_that_leads_nowhere():
    """A refocus renders nothing."""
    scene = bpy.context.scene
    tree, layers, output = tree_with_output(scene)
    tree.links.new(layers.outputs["Image"], output)
    node = add_matte(scene, tree, None)
    start()
    update()
    made = shot(scene, "matte4.exr")
    assert addon("setup").can_mute_sources(scene)
    with rendered_scenes() as seen:
        bpy.ops.rack_focus.refocus()
    assert scene.name not in seen, seen
    same(result(scene, OUT / "matte5.exr"), made)
    assert not node.mute


def add_back(scene, tree):
    """(scene, node) of another scene that the nodes of one show."""
    back = bpy.data.scenes.new("Back")
    common.set_up_cycles(back)
    back.render.resolution_x, back.render.resolution_y = 72, 48
    for item in scene.objects:  # the camera too
        back.collection.objects.link(item)
    back.camera = scene.camera
    return back, addon("compat").new_layer_node(tree, back)


@check
def another_scene_in_the_compositor():
    """It has its own lens there, though its own nodes would filter it."""
    scene = bpy.context.scene
    data = scene.camera.data
    data.dof.use_dof = True
    tree, _, output = tree_with_output(scene)
    back, shown = add_back(scene, tree)
    tree.links.new(shown.outputs["Image"], output)
    lens = shot(scene, "back0.exr")
    data.rack_focus.enabled = True
    update()
    assert addon("setup").filter_scene_of(back) is not None
    tree.links.new(shown.outputs["Image"], output)
    same(shot(scene, "back1.exr"), lens)
    alone = shot(back, "back2.exr")
    assert not np.array_equal(alone, lens) and tpsnr(alone, lens) > 15
    assert not last_message(back), last_message(back)


@check
def another_scene_that_is_filtered():
    """By a node of its second scene beside its own; what was kept of it is old then."""
    scene = bpy.context.scene
    tree, _, output = tree_with_output(scene)
    back, _ = add_back(scene, tree)
    _, data = start(views=2)
    update()
    alone = shot(back, "back3.exr")
    ours = addon("compat").new_layer_node(tree, addon("setup").filter_scene_of(back))
    tree.links.new(ours.outputs["Image"], output)
    data.rack_focus.views = 1
    made = shot(scene, "back4.exr")
    assert not np.array_equal(made, alone)
    same(made, shot(back, "back5.exr"))


# ---- view layers ------------------------------------------------------------------


def three_layers(scene):
    """Layers A, B and C with other cubes each; C is the picture. Returns the tree."""
    scene.view_layers[0].name = "A"
    for name in "BC":
        scene.view_layers.new(name)
    cubes = [o for o in scene.objects if o.type == "MESH"]
    for index in range(3):
        group = bpy.data.collections.new(f"Part {index}")
        scene.collection.children.link(group)
        for cube in cubes[index::3]:
            scene.collection.objects.unlink(cube)
            group.objects.link(cube)
    for at, layer in enumerate(scene.view_layers):
        for index in range(3):
            part = layer.layer_collection.children[f"Part {index}"]
            part.exclude = index != at
    tree, layers, output = tree_with_output(scene)
    layers.layer = "C"
    tree.links.new(layers.outputs["Image"], output)
    other = addon("compat").new_layer_node(tree, scene)
    other.layer = "B"
    viewer = tree.nodes.new("CompositorNodeViewer")
    tree.links.new(other.outputs["Image"], viewer.inputs["Image"])
    return tree


def looks(tree):
    """What the Render Layers nodes look at."""
    nodes = [n for n in tree.nodes if n.type == "R_LAYERS"]
    return sorted((node.scene.name, node.layer) for node in nodes)


@check
def a_view_layer_is_removed():
    """The nodes keep theirs; unticking gives each its own link back."""
    scene = bpy.context.scene
    tree = three_layers(scene)
    _, data = start()
    update()
    before, made = looks(tree), shot(scene, "removed0.exr")
    scene.view_layers.remove(scene.view_layers["A"])
    update()
    assert looks(tree) == before, looks(tree)
    same(shot(scene, "removed1.exr"), made)
    scene.view_layers.remove(scene.view_layers["B"])
    scene.view_layers.new("N")  # as many as before, in one step of a script
    update()
    assert (scene.name, "C") in looks(tree), looks(tree)
    same(shot(scene, "removed2.exr"), made)
    data.rack_focus.enabled = False
    feed = addon("compat").output_socket(tree).links[0].from_node
    assert (feed.scene, feed.layer) == (scene, "C"), (feed.name, feed.layer)
    data.rack_focus.enabled = True
    same(shot(scene, "removed3.exr"), made)


@check
def renamed_and_moved_view_layers():
    """Names stay in step, and unticking switches off what ticking switched on."""
    scene = bpy.context.scene
    three_layers(scene)
    _, data = start()
    first, second = scene.view_layers[0], scene.view_layers[1]
    first.name, second.name = "X", "A"  # the other's name, and a new one
    if hasattr(scene.view_layers, "move"):
        scene.view_layers.move(2, 0)
    update()
    names = [layer.name for layer in scene.view_layers]
    ours = addon("setup").filter_scene_of(scene)
    assert [layer.name for layer in ours.view_layers] == names
    assert all(layer.use_pass_z for layer in scene.view_layers)
    scene.view_layers["X"].name = "Y"  # without an update before unticking
    data.rack_focus.enabled = False
    on = [layer.name for layer in scene.view_layers if layer.use_pass_z]
    assert not on, on


# ---- cameras ----------------------------------------------------------------------


@check
def a_marker_camera_that_is_not_rendered():
    """Blender skips one with Disable in Renders: the views are of the camera before."""
    scene = bpy.context.scene
    hidden = scene.camera.copy()
    hidden.data = hidden.data.copy()
    hidden.location = (0.4, -0.5, 0.2)
    scene.collection.objects.link(hidden)
    for frame, camera in ((1, scene.camera), (2, hidden)):
        scene.timeline_markers.new("camera", frame=frame).camera = camera
    hidden.hide_render = True
    scene.frame_set(3)
    pinhole = shot(scene, "marker0.exr")
    hidden.hide_render = False
    assert not np.array_equal(shot(scene, "marker1.exr"), pinhole)
    hidden.hide_render = True
    scene.timeline_markers.clear()
    scene.camera = bpy.data.objects["Camera"]
    same(shot(scene, "marker2.exr"), pinhole)  # so Blender skips it
    for frame, camera in ((1, scene.camera), (2, hidden)):
        scene.timeline_markers.new("camera", frame=frame).camera = camera
    for camera in (hidden, scene.camera):
        camera.data.rack_focus.enabled = True
        camera.data.rack_focus.views = 3
    update()
    made = shot(scene, "marker3.exr")
    assert addon("camera_objects").camera_at(scene, 3) == bpy.data.objects["Camera"]
    scene.timeline_markers.clear()
    scene.camera = bpy.data.objects["Camera"]
    update()
    same(made, shot(scene, "marker4.exr"))


@check
def a_collection_is_kept_sharp():
    """By its objects, and by what shows it."""
    scene = bpy.context.scene
    near = [o for o in scene.objects if o.type == "MESH" and o.location.y < 2.5]
    group = bpy.data.collections.new("Near")
    for item in near:
        scene.collection.objects.unlink(item)
        group.objects.link(item)
    shown = bpy.data.objects.new("Shown", None)
    shown.instance_type, shown.instance_collection = "COLLECTION", group
    scene.collection.objects.link(shown)
    start()
    update()
    blurred = shot(scene, "instances0.exr")
    shown.rack_focus_keep_sharp = True
    made = shot(scene, "instances1.exr")
    assert {o.name for o in near} < set(addon("sharp").names_of(scene))
    assert (np.abs(made - blurred).max(-1) > 0.05).mean() > 0.05
    shown.rack_focus_keep_sharp = False
    for item in near:
        item.rack_focus_keep_sharp = True
    same(shot(scene, "instances2.exr"), made)


@check
def the_node_on_an_image_has_the_scenes_white():
    """As the other node and a crop of it: the scene's exposure."""
    scene, data = start()
    scene.view_settings.exposure = 3
    wanted = addon("lens").white_of(scene)
    assert wanted == 0.125
    size = addon("lens").picture_size(scene.render)
    made = addon("nodes").parameters(scene, scene.camera, size)
    of_frame = addon("lens").frame_parameters(
        scene.camera, data.rack_focus, scene.render, size
    )
    assert made == of_frame and made["white"] == wanted, made


# ---- kept passes ------------------------------------------------------------------


def keep_in(name):
    """(scene, camera data) with an empty folder of the file for passes."""
    folder = OUT / name
    shutil.rmtree(folder, ignore_errors=True)
    scene, data = start(passes_folder=f"//{name}")
    return scene, data, folder


def reopen():
    """Saves the file and opens it; returns the scene."""
    path = str(OUT / "kept.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    return bpy.context.scene


@check
def kept_passes_are_those_of_the_frame():
    """A refocus in another frame takes its own; without them it says so."""
    scene, data, _ = keep_in("kept_frames")
    cube = min(
        (o for o in scene.objects if o.type == "MESH"), key=lambda o: o.location.y
    )
    for frame, move in ((1, 0), (2, 0.3)):
        cube.location.x += move
        cube.keyframe_insert("location", frame=frame)
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "kept.blend"))
    made = {}
    for frame in (1, 2):
        scene.frame_set(frame)
        made[frame] = shot(scene, f"kept_frame{frame}.exr")
    assert not np.array_equal(made[1], made[2])
    scene.frame_set(1)
    same(refocused(scene, "kept1.exr"), made[1])
    assert not last_message(scene), last_message(scene)
    scene = reopen()
    for frame in (1, 2, 1):
        scene.frame_set(frame)
        same(refocused(scene, "kept2.exr"), made[frame])
        assert not last_message(scene), last_message(scene)
    scene.frame_set(3)
    try:
        bpy.ops.rack_focus.refocus()
        raise AssertionError("frame 3 has no passes")
    except RuntimeError as error:
        assert "passes of frame 3" in str(error), error


@check
def a_refocus_in_another_frame():
    """Without kept passes: the last render, and a word on it."""
    scene, _ = start()
    scene.frame_set(4)
    made = shot(scene, "frame4.exr")
    scene.frame_set(7)
    same(refocused(scene, "frame7.exr"), made)
    assert "render of frame 4: press F12" in last_message(scene), last_message(scene)
    scene.frame_set(4)
    refocused(scene, "frame7.exr")
    assert not last_message(scene), last_message(scene)


@check
def kept_passes_of_fewer_views():
    """What an earlier render of the frame left goes once the new ones are there."""
    scene, data, folder = keep_in("kept_fewer")
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "kept.blend"))
    other = folder / "passes0001_v2x.exr"
    for views in (4, 2, 1, 3):
        data.rack_focus.views = views
        scene.camera.location.x += 0.02
        made = shot(scene, f"fewer{views}.exr")
        names = [f"passes0001_v{i:02d}.exr" for i in range(views)]
        wanted = names if views > 1 else ["passes0001.exr"]
        assert sorted(p.name for p in folder.iterdir() if p != other) == wanted
        other.touch()  # nobody's
    scene = reopen()
    same(refocused(scene, "fewer.exr"), made)
    assert other.exists()


# ---- messages ---------------------------------------------------------------------


@check
def a_render_in_views_is_stopped():
    """The message after Esc, and that where there is no render."""
    engine, rendered = addon("engine").RackFocusEngine, addon("passes").RenderedPasses
    scene, _ = start(views=2)
    try:
        rendered(scene)
        raise AssertionError("nothing was rendered")
    except addon("passes").PassesError as error:
        assert str(error).endswith("press F12 first"), error
    save, is_stopped = rendered._save, engine._is_stopped

    def fail(*_):
        raise addon("passes").PassesError("there is none")

    rendered._save = fail
    engine._is_stopped = lambda _self: True
    try:
        with contextlib.suppress(RuntimeError):
            bpy.ops.render.render()
    finally:
        rendered._save, engine._is_stopped = save, is_stopped
    assert last_message(scene).startswith("stopped;"), last_message(scene)


@check
def a_view_layer_with_a_long_name():
    """Up to 4.5 names of channels are cut: the message says so."""
    scene, _ = start()
    scene.view_layers[0].name = "L" * 52
    shot(scene, "long0.exr")
    assert not last_message(scene), last_message(scene)
    scene.view_layers[0].name = "L" * 60
    shot(scene, "long1.exr")
    if V < (5, 0, 0):
        assert "too long for this Blender: at most 52" in last_message(scene)
    else:
        assert not last_message(scene), last_message(scene)


@check
def files_of_another_colour_space():
    """The passes are read as the scene has them, and the file is as the artist chose."""
    scene, data = start()
    settings = scene.render.image_settings
    for n_views in (1, 3):
        data.rack_focus.method, data.rack_focus.views = "views", n_views
        made = shot(scene, "space.exr")
        settings.color_management = "OVERRIDE"
        for name in ("ACEScg", "Linear ACES"):  # as versions call it
            with contextlib.suppress(TypeError):
                settings.linear_colorspace_settings.name = name
        name = settings.linear_colorspace_settings.name
        assert "ACES" in name, name
        scene.render.filepath = str(OUT / "other.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)
        assert settings.color_management == "OVERRIDE"
        assert settings.linear_colorspace_settings.name == name
        other = rgba(read(OUT / "other.exr"))
        assert 20 < tpsnr(other, made) < 50, tpsnr(other, made)
        settings.color_management = "FOLLOW_SCENE"
        same(common.result(scene, OUT / "space.exr"), made)


@check
def a_comparison():
    """It prints no error: see test_files.py."""
    scene, _ = start()
    update()
    tree = common.tree_of(scene)
    tree.links.new(tree.nodes.new("CompositorNodeBlur").outputs[0], add_viewer(tree))
    bpy.ops.rack_focus.compare(percentage=50, samples=1)


def add_viewer(tree):
    """The input of a new Viewer node."""
    return tree.nodes.new("CompositorNodeViewer").inputs["Image"]


# ---- lights that the camera sees --------------------------------------------------


def own_lens(scene, data):
    """What the camera's own depth of field makes of a scene, of 128 samples."""
    samples, scene.cycles.samples = scene.cycles.samples, 128
    data.rack_focus.enabled, data.dof.use_dof = False, True
    made = shot(scene, "own.exr")
    data.dof.use_dof, scene.cycles.samples = False, samples
    return made


def gain(made, own):
    """What the depth of lights brings to the last picture, dB."""
    lamps, scene = addon("lamps"), bpy.context.scene
    kept, lamps.placed = lamps.placed, lambda found, *_: found
    try:
        without = refocused(scene, "without.exr")
    finally:
        lamps.placed = kept
    print("gain", tpsnr(made, own), tpsnr(without, own))
    return tpsnr(made, own) - tpsnr(without, own)


def seen_lamp(kind, place, energy, **settings):
    """A light that the camera sees, which shines towards it."""
    scene = bpy.context.scene
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", kind))
    scene.collection.objects.link(lamp)
    lamp.location, lamp.rotation_euler = place, (-np.pi / 2, 0, 0)
    lamp.visible_camera, lamp.data.energy = True, energy
    for name, value in settings.items():
        setattr(lamp.data, name, value)
    return lamp


def three_lamps():
    """A square, a ball and a disc, near and far, on a larger picture."""
    lamps = [
        seen_lamp("AREA", (-0.5, 3, 0.2), 2, size=0.5),
        seen_lamp("POINT", (0.4, 3, -0.2), 3, shadow_soft_size=0.15),
        seen_lamp("AREA", (0.9, 8, 0.9), 30, size=0.8, shape="DISK"),
    ]
    lamps[1].data.use_nodes, lamps[1].data.energy = True, 1
    lamps[1].data.node_tree.nodes["Emission"].inputs["Strength"].default_value = 3
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = 120, 80
    bpy.context.scene.cycles.samples = 32
    return lamps


@check
def lights_that_the_camera_sees():
    """They get the depth of their shapes: one view, several, a region, orthographic."""
    scene, data = bpy.context.scene, bpy.context.scene.camera.data
    lamps = three_lamps()
    data.shift_x, data.dof.aperture_fstop = 0.05, 0.4
    own = own_lens(scene, data)
    start()
    made = shot(scene, "lamp.exr")
    same(refocused(scene, "lamp.exr"), made)
    assert gain(made, own) > 6
    data.rack_focus.method, data.rack_focus.views = "views", 4
    assert gain(shot(scene, "lamp.exr"), own) > 6
    data.rack_focus.views, data.rack_focus.method = 1, "layered"
    depth = addon("lamps").placed(kept(scene), scene, "ViewLayer", scene.camera)
    depth = depth[0][0].depth
    assert {3.0} < set(np.round(depth[depth < 1e9], 4).tolist())
    place = world_to_camera_view(scene, scene.camera, lamps[0].location)
    data.dof.focus_distance = 9
    bpy.ops.rack_focus.pick_focus(x=place.x, y=place.y)
    assert abs(data.dof.focus_distance - 3) < 1e-3, data.dof.focus_distance
    data.dof.focus_distance = 3
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_y = 0.2, 0.9
    part = shot(scene, "lamp.exr")
    part[part[..., 3] == 0] = made[part[..., 3] == 0]
    assert tpsnr(part, made) > 40, tpsnr(part, made)
    scene.render.use_border = False
    lamps[0].matrix_world @= Matrix.Rotation(np.pi, 4, "X")  # its back is not seen
    update()
    own = own_lens(scene, data)
    start()
    assert gain(shot(scene, "lamp.exr"), own) > 6


@check
def moving_and_instanced_lights():
    """Of an animation each frame has its own, those of an instanced collection too."""
    scene = bpy.context.scene
    three_lamps()
    group = bpy.data.collections.new("lamps")
    for item in [o for o in scene.objects if o.type == "LIGHT"]:
        scene.collection.objects.unlink(item)
        group.objects.link(item)
    empty = bpy.data.objects.new("empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    scene.collection.objects.link(empty)
    for frame, x in ((1, 0.0), (2, 0.3)):
        empty.location.x = x
        empty.keyframe_insert("location", frame=frame)
    start()
    scene.frame_start, scene.frame_end = 1, 2
    common.set_output(scene, OUT / "lamp_#.exr")
    bpy.ops.render.render(animation=True, scene=scene.name)
    for number in (1, 2):
        scene.frame_set(number)
        own = own_lens(scene, scene.camera.data)
        start()
        same(shot(scene, "lamp.exr"), rgba(read(OUT / f"lamp_{number}.exr")))
        assert gain(refocused(scene, "lamp.exr"), own) > 6


@check
def clamped_and_exposed_lights():
    """What of a light comes into the picture counts, not what it shines."""
    scene = bpy.context.scene
    three_lamps()
    scene.cycles.sample_clamp_direct, scene.cycles.film_exposure = 0.8, 3
    own = own_lens(scene, scene.camera.data)
    start()
    assert gain(shot(scene, "lamp.exr"), own) > 6


@check
def lights_with_a_spread():
    """Areas that shine forwards have the depth of their shape where they are seen."""
    scene, data = bpy.context.scene, bpy.context.scene.camera.data
    square, ball, disc = three_lamps()
    scene.collection.objects.unlink(ball)
    square.data.spread, square.rotation_euler.z = 1.2, 0.3
    disc.data.spread, scene.cycles.sample_clamp_direct = 0.8, 2
    own = own_lens(scene, data)
    start()
    assert not addon("lamps").describe(scene, scene.camera)
    assert gain(shot(scene, "lamp.exr"), own) > 6
    scene.cycles.sample_clamp_direct = 0  # what a Spread lets through is seen
    shot(scene, "lamp.exr")
    plain, place = kept(scene)[0]
    camera = scene.camera
    found = addon("lamps").placed([(plain, place)], scene, "ViewLayer", camera)[0][0]
    is_lamp = np.array(plain.colour)[..., :3].max(-1) > 10
    is_nearer = np.array(found.depth) < np.array(plain.depth)
    assert is_lamp.sum() > 20 and is_nearer[is_lamp].mean() > 0.9, (
        is_lamp.sum(),
        is_nearer[is_lamp].mean(),
    )
    scene.cycles.sample_clamp_direct = 2
    data.rack_focus.method, data.rack_focus.views = "views", 4
    assert gain(shot(scene, "lamp.exr"), own) > 6


@check
def a_lamp_that_is_not_seen_takes_no_depth():
    """A spot that shines elsewhere leaves what is behind it its depth."""
    spot = seen_lamp("SPOT", (0, 2, 0), 30, shadow_soft_size=0.2)
    spot.rotation_euler = (np.pi / 2, 0, 0)
    scene, _ = start()
    shot(scene, "lamp.exr")
    plain = kept(scene)[0][0]
    assert addon("lamps")._lamps[scene.name]["ViewLayer"]
    depth = addon("lamps").placed(
        [(plain, kept(scene)[0][1])], scene, "ViewLayer", scene.camera
    )
    same(depth[0][0].depth, np.array(plain.depth))


@check
def lights_whose_depth_is_not_known():
    """Box and console say so of those with nodes, where they are seen."""
    scene, data = start()
    describe = addon("lamps").describe
    lamp = seen_lamp("AREA", (0, 3, 0), 3, size=0.4)
    update()
    assert not describe(scene, scene.camera)
    lamp.data.use_nodes = True
    nodes = lamp.data.node_tree.nodes
    assert not describe(scene, scene.camera)
    glow, ray = nodes["Emission"], nodes.new("ShaderNodeLightPath")
    lamp.data.node_tree.links.new(ray.outputs[0], glow.inputs["Strength"])
    assert "nodes" in describe(scene, scene.camera)[1]
    with heard() as said:
        shot(scene, "lamp.exr")
    assert "no depth" in said.getvalue(), said.getvalue()
    for place in ((0, -3, 0), (9, 3, 0), (0, 3, -9)):
        lamp.location = place
        update()
        assert not describe(scene, scene.camera), place
    lamp.location = (0, 3, 0)
    update()
    assert describe(scene, scene.camera)
    data.rack_focus.method = "accumulate"
    assert not describe(scene, scene.camera)
    data.rack_focus.method = "layered"
    lamp.data.energy = 0
    assert not describe(scene, scene.camera)
    lamp.data.energy, lamp.hide_render = 3, True
    update()
    assert not describe(scene, scene.camera)
    lamp.hide_render, lamp.visible_camera = False, False  # as Blender makes them
    update()
    assert not describe(scene, scene.camera)


@check
def a_folder_being_made_is_none_of_a_dead_blender():
    """Another Blender looks at it between the making of its file and the lock."""
    passes, parent = addon("passes"), OUT / "being_made"
    shutil.rmtree(parent, ignore_errors=True)
    parent.mkdir()
    lock, judged = passes._lock, []

    def late(file):
        passes._lock = lock
        judged.append(Path(file.name).parent)
        passes.clear_dead_folders(parent)
        lock(file)

    passes._lock = late
    with passes.own_folder(parent) as alive:
        assert judged and alive not in judged
        passes.clear_dead_folders(parent)
        assert list(parent.iterdir()) == [alive]
    assert not list(parent.iterdir())


checking.run(check, "file_results.json")
