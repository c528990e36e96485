# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of what several views show of the artist's camera, run inside Blender.

camera_checks.py DIST OUT [CHECK ...]    writes OUT/camera_results.json
"""

import math
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import Checks, heard, key_focus, shot  # noqa: E402
from common import (  # noqa: E402
    V,
    addon,
    kept,
    last_message,
    same,
    settings_of,
    start,
    tpsnr,
    unchanged,
)

KEEP_SHARP = "Objects are kept sharp with one view only."
SPREAD = {"views": 3, "method": "accumulate", "shutter_spread": True}
# Together, with the tiny lens of few samples, parts of pixels, one after another.
WAYS = (
    ({"views": 3}, 30),
    ({"views": 3}, 6),
    ({"views": 1, "supersample": 2}, 8),
    (SPREAD, 6),
)


def prepare():
    """Views rendered together; the camera is not where those of views would be."""
    addon("one_by_one").multiview_works = True
    bpy.context.scene.camera.location = 0.25, 0, 0.1


check = Checks(prepare)


def meshes(scene):
    """Its cubes, those that are farther than the nearest ones."""
    return [o for o in scene.objects if o.type == "MESH"][8:]


def cull(scene):
    """Lets Cycles leave out cubes that are far; the views come one after another."""
    scene.render.use_simplify = scene.cycles.use_distance_cull = True
    scene.cycles.distance_cull_margin = 5
    for cube in meshes(scene):
        cube.cycles.use_distance_cull = True


def drive(cube, path):
    """Adds a value of the scene that is evaluated to the place of a cube."""
    driver = cube.driver_add("location", 0).driver
    variable = driver.variables.new()
    variable.name, variable.type = "read", "CONTEXT_PROP"
    variable.targets[0].context_property = "ACTIVE_SCENE"
    variable.targets[0].data_path = path
    driver.expression = f"{cube.location.x} + read"


def add_mover(item, *kinds):
    """Geometry Nodes that move a mesh, and more of these kinds.

    Returns the links of their tree, these nodes, and the input that the mesh moves by.
    """
    tree = bpy.data.node_groups.new("move", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        kind = "NodeSocketGeometry"
        tree.interface.new_socket("Geometry", in_out=way, socket_type=kind)
    first, last = (tree.nodes.new(f"NodeGroup{kind}") for kind in ("Input", "Output"))
    move = tree.nodes.new("GeometryNodeSetPosition")
    tree.links.new(first.outputs[0], move.inputs[0])
    tree.links.new(move.outputs[0], last.inputs[0])
    item.modifiers.new("move", "NODES").node_group = tree
    return tree.links, [tree.nodes.new(kind) for kind in kinds], move.inputs["Offset"]


def follow_camera(cube, camera):
    """Moves a cube by what Geometry Nodes know of the active camera."""
    kinds = ("GeometryNodeInputActiveCamera", "GeometryNodeObjectInfo")
    links, (active, info), offset = add_mover(cube, *kinds)
    links.new(active.outputs[0], info.inputs["Object"])
    links.new(info.outputs["Location"], offset)


# ---- what reads the scene's camera ------------------------------------------------


@check
def the_scenes_camera_is_the_artists():
    """In every evaluation of every way to render views, culling included."""
    scene, data = start()
    found = set()

    def look(seen, depsgraph=None):
        if depsgraph is not None and depsgraph.mode == "RENDER":
            is_view = seen.rack_focus.viewed == scene
            found.add((is_view, depsgraph.scene_eval.camera.original.name))

    bpy.app.handlers.frame_change_post.append(look)
    try:
        for settings, samples in (*WAYS, ({"views": 3, "method": "layered"}, 6)):
            for name, value in settings.items():
                setattr(data.rack_focus, name, value)
            scene.cycles.samples = samples
            before = settings_of(scene)
            bpy.ops.render.render()
            assert not last_message(scene), (settings, last_message(scene))
            unchanged(scene, before)
            assert (True, scene.camera.name) in found, (settings, found)
            assert {name for _, name in found} == {scene.camera.name}, (settings, found)
            data.rack_focus.supersample = 1
            data.rack_focus.shutter_spread = False
            found.clear()
            if settings == SPREAD:
                cull(scene)
    finally:
        bpy.app.handlers.frame_change_post.remove(look)


@check
def drivers_of_the_scenes_camera():
    """As with what they read written down; its focus distance too."""
    if V < (4, 0, 0):
        return  # no driver reads the scene that is evaluated
    ways = {"camera.location[0]": WAYS, "camera.data.dof.focus_distance": WAYS[1:2]}
    for path in ways:
        for settings, samples in ways[path]:
            pictures = []
            for is_driven in (True, False):
                bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
                prepare()
                scene, _ = start(**settings)
                scene.cycles.samples = samples
                for cube in meshes(scene):
                    if is_driven:
                        drive(cube, path)
                    else:
                        cube.location.x += scene.path_resolve(path)
                pictures.append(shot(scene, "driven.exr"))
                assert not last_message(scene), last_message(scene)
            off = np.abs(pictures[0] - pictures[1]).max()
            assert off < 1e-6, (path, settings, off)


@check
def few_samples_with_a_focus_object():
    """The tiny lens and the plane are those of the same focus distance; with a camera
    that no view can be told (5.0), and beside a driver that reads the scene's, too."""
    scene, data = start(views=3)
    scene.cycles.samples = 6
    camera, target = scene.camera, bpy.data.objects.new("focus", None)
    scene.collection.objects.link(target)
    bpy.context.view_layer.update()
    target.location = camera.matrix_world @ Vector((0, 0, -data.dof.focus_distance))
    wanted = shot(scene, "object.exr")
    assert all(place.spread_px > 0 for _, place in kept(scene))
    for aim, name in ((target, "Camera"), (None, "C" * 250), (target, "C" * 250)):
        data.dof.focus_object, camera.name = aim, name
        found = tpsnr(shot(scene, "object.exr"), wanted)
        assert not last_message(scene), last_message(scene)
        assert found > 60, (aim, len(camera.name), found)
    if V < (4, 0, 0):
        return  # no driver reads the scene that is evaluated
    camera.name = "Camera"
    for cube in meshes(scene):
        cube.location.x -= camera.location.x
        drive(cube, "camera.location[0]")
    found = tpsnr(shot(scene, "object.exr"), wanted)
    assert found > 60, found


@check
def the_active_camera_of_geometry_nodes():
    """The same bits as of cubes that were moved by hand."""
    if V < (4, 1, 0):
        return  # there is no such node
    pictures = []
    for is_node in (True, False):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        prepare()
        scene, _ = start(views=3)
        for cube in meshes(scene):
            if is_node:
                follow_camera(cube, scene.camera)
            else:
                for vertex in cube.data.vertices:
                    vertex.co += scene.camera.location
        pictures.append(shot(scene, "nodes.exr"))
        assert not last_message(scene), last_message(scene)
    same(*pictures)


@check
def a_camera_with_a_long_name():
    """5.0 has names that are longer than a suffix of a view: the picture is the same.

    As long as Blender finds the views' cameras, scripts and drivers find the artist's.
    """
    scene, data = start(views=3)
    found = set()

    def look(seen, depsgraph=None):
        if depsgraph is not None and depsgraph.mode == "RENDER":
            found.add(depsgraph.scene_eval.camera.original.name == scene.camera.name)

    bpy.app.handlers.frame_change_post.append(look)
    try:
        for settings, _ in WAYS:
            for name, value in settings.items():
                setattr(data.rack_focus, name, value)
            wanted = shot(scene, "name.exr")
            for name in ("C" * 250, "é" * 40 + "C" * 31, "é" * 31 + "C"):
                scene.camera.name = name
                found.clear()
                same(shot(scene, "name.exr"), wanted)
                assert not last_message(scene), last_message(scene)
                is_too_long = len(scene.camera.name) > 112
                assert is_too_long or found == {True}, (name, settings)
            data.rack_focus.supersample, data.rack_focus.shutter_spread = 1, False
    finally:
        bpy.app.handlers.frame_change_post.remove(look)


@check
def other_objects_of_these_names():
    """Cameras of the artist are called as those of views are."""
    scene, _ = start(views=3)
    wanted = shot(scene, "taken.exr")
    for name in ("Rack Focus_v01", "Rack Focus_v02.001"):
        other = bpy.data.objects.new(name, bpy.data.cameras.new(name))
        scene.collection.objects.link(other)
    scene.camera.name = "Rack Focus_v00"
    same(shot(scene, "taken.exr"), wanted)
    assert not last_message(scene), last_message(scene)


# ---- evaluated more than once -----------------------------------------------------


@check
def a_lens_that_moves_leaves_views_where_they_are():
    """With Motion Blur 3.4 lost the parents of their cameras, and they showed nothing."""
    scene, data = start(views=3)
    scene.cycles.samples = 24
    for owner, name in ((data.dof, "focus_distance"), (data, "shift_x")):
        middle, shown = getattr(owner, name), []
        for frame, step in ((1, -0.04), (3, 0.04)):
            setattr(owner, name, middle + step)
            owner.keyframe_insert(name, frame=frame)
        scene.frame_set(2)
        for scene.render.use_motion_blur in (False, True):
            bpy.ops.render.render()
            assert not last_message(scene), last_message(scene)
            shown.append([(layer.depth < 1e9).mean() for layer, _ in kept(scene)])
        assert min(shown[0]) > 0.2, (name, shown)
        assert np.allclose(*shown, atol=0.05), (name, shown)


@check
def frames_of_a_camera_that_is_not_ticked():
    """As the scene says, with its own lens, whatever another frame's camera asks for."""
    scene, data = start(views=2, supersample=2)
    other = scene.camera.copy()
    other.data = data.copy()
    scene.collection.objects.link(other)
    other.data.rack_focus.enabled, other.data.dof.use_dof = False, True
    for frame, camera in ((1, scene.camera), (2, other)):
        scene.timeline_markers.new("m", frame=frame).camera = camera
    scene.cycles.use_denoising = V >= (4, 2, 0)  # 3.4 has none
    scene.frame_set(2)
    made = shot(scene, "nt.exr")
    assert len(kept(scene)) == 1 and not last_message(scene), last_message(scene)
    data.rack_focus.enabled = False
    same(made, shot(scene, "nt.exr"))
    other.data.dof.use_dof = scene.cycles.use_denoising = False
    assert tpsnr(made, shot(scene, "nt.exr")) < 30


@check
def motion_blur_reads_the_artists_lens():
    """In each of its evaluations, not the tiny lens that few samples are taken with."""
    scene, data = start(views=3)
    scene.cycles.samples = 6
    data.dof.aperture_blades, data.dof.aperture_ratio = 5, 1.5
    key_focus(data, {1: 3, 5: 2})
    scene.frame_set(3)
    for target in (None, meshes(scene)[0]):
        data.dof.focus_object = target
        found = []
        for is_blurred in (False, True):
            scene.render.use_motion_blur = is_blurred
            bpy.ops.render.render()
            assert not last_message(scene), last_message(scene)
            found.append([place for _, place in kept(scene)])
        assert found[0] == found[1], (target, found)


@check
def views_one_after_another_with_motion_blur_and_layers():
    """Each is evaluated several times."""
    scene, data = start(**SPREAD)
    scene.view_layers.new("Front")
    bpy.ops.render.render()
    assert not last_message(scene), last_message(scene)
    found = addon("passes").rendered(scene)
    assert [len(found.views(name)) for name in ("ViewLayer", "Front")] == [3, 3]
    data.rack_focus.shutter_spread, data.rack_focus.method = False, "layered"
    scene.render.use_motion_blur = True
    cull(scene)
    bpy.ops.render.render()
    assert not last_message(scene), last_message(scene)
    assert len({place.offset for _, place in kept(scene)}) == 3


def strips_of_new_scene():
    """(a scene of one frame, its strips)."""
    edit = bpy.data.scenes.new("Edit")
    edit.render.resolution_x, edit.render.resolution_y = 72, 48
    edit.view_settings.view_transform = "Raw"
    edit.frame_start = edit.frame_end = edit.frame_current = 1
    editor = edit.sequence_editor_create()
    return edit, editor.strips if hasattr(editor, "strips") else editor.sequences


@check
def a_scene_strip():
    """As by F12, through the camera of the strip; of several in one frame it is told."""
    scene, data = start(supersample=2)
    other, first = scene.camera.copy(), scene.camera
    other.data = data.copy()
    other.location.x, other.data.dof.focus_distance = 0.5, 8
    scene.collection.objects.link(other)
    min(meshes(scene), key=lambda o: o.location.y).rack_focus_keep_sharp = True
    data.rack_focus.enabled = False  # the strip's camera alone has it
    edit, strips = strips_of_new_scene()
    strips.new_scene("A", scene, 1, 1).scene_camera = other
    bpy.context.view_layer.update()
    for settings in ({}, {"views": 3, "supersample": 1}):
        for name, value in settings.items():
            setattr(other.data.rack_focus, name, value)
        scene.camera = other
        wanted = shot(scene, "strip0.exr")
        scene.camera = first
        made = shot(edit, "strip1.exr")
        assert tpsnr(made, wanted) > 60, (settings, tpsnr(made, wanted))
        assert last_message(scene) in ("", KEEP_SHARP), last_message(scene)
    if V >= (5, 2, 0):
        layer = scene.view_layers.new("Other")
        strips[0].view_layer = layer
        with heard() as said:
            shot(edit, "strip1.exr")
        assert "has view layer “Other”" in said.getvalue(), said.getvalue()
        scene.view_layers.remove(layer)
    strips.new_scene("B", scene, 2, 1).scene_camera = first
    with heard() as said:
        made = shot(edit, "strip1.exr")
    assert "through several cameras" in said.getvalue(), said.getvalue()
    data.rack_focus.enabled = other.data.rack_focus.enabled = False
    assert tpsnr(made, shot(edit, "strip0.exr")) > 60  # without Rack Focus


def solve(scene):
    """Solves the camera of a clip, the scene's active one, that moves sideways."""
    image = bpy.data.images.new("clip", 72, 48)
    image.filepath_raw, image.file_format = str(checking.OUT / "clip.png"), "PNG"
    image.save()
    clip = scene.active_clip = bpy.data.movieclips.load(image.filepath_raw)
    tracked = clip.tracking.objects[0]
    rng = np.random.default_rng(1)
    for x, y, depth in rng.uniform((-1, -0.6, 3), (1, 0.6, 8), (16, 3)):
        track = tracked.tracks.new(name="t", frame=1)
        for frame in range(1, 21):
            right, up = x - 0.05 * frame, y - 0.02 * math.sin(frame)
            at = np.array((right, 1.5 * up)) / (depth + 0.03 * frame)
            track.markers.insert_frame(frame, co=at * 50 / 36 + 0.5)
    clip.tracking.camera.sensor_width, clip.tracking.camera.focal_length = 36, 50
    tracked.keyframe_a, tracked.keyframe_b = 1, 20
    window = bpy.context.window_manager.windows[0]
    area = window.screen.areas[0]
    area.type = "CLIP_EDITOR"
    area.spaces[0].clip = clip
    about = {"area": area, "region": area.regions[-1], "space_data": area.spaces[0]}
    with bpy.context.temp_override(window=window, **about):
        assert bpy.ops.clip.solve_camera() == {"FINISHED"}


def go_by_seconds(item):
    """Geometry Nodes move a mesh by 1 a second along y."""
    kinds = ("GeometryNodeInputSceneTime", "ShaderNodeCombineXYZ")
    links, (time, offset), moved = add_mover(item, *kinds)
    links.new(time.outputs["Seconds"], offset.inputs[1])
    links.new(offset.outputs[0], moved)


@check
def a_focus_that_hangs_on_the_scene():
    """By a camera that was solved, which follows the active clip; by seconds."""
    scene, data = start()
    target = bpy.data.objects.new("Target", None)
    scene.collection.objects.link(target)
    scene.frame_set(15)

    def is_right(distance):
        data.dof.focus_object = target
        made = shot(scene, "hang0.exr")
        data.dof.focus_object, data.dof.focus_distance = None, distance
        found = tpsnr(made, shot(scene, "hang1.exr"))
        assert found > 60, (distance, found)

    if V >= (4, 2, 0):  # with other sockets of groups before
        target.parent, target.parent_type = meshes(scene)[0], "VERTEX"
        go_by_seconds(target.parent)
        scene.render.fps = 5  # 3 s
        bpy.context.view_layer.update()
        is_right(target.matrix_world.translation.y - scene.camera.location.y)
        target.parent = None
    solve(scene)
    target.location = 0, 3, 0
    scene.camera.constraints.new("CAMERA_SOLVER").use_active_clip = True
    data.dof.focus_object = target
    scene.frame_set(15)
    away = target.matrix_world.translation - scene.camera.matrix_world.translation
    back = scene.camera.matrix_world.to_3x3().col[2]
    assert away.dot(back) < -0.1, (away, back)
    is_right(-away.dot(back))


@check
def settings_with_keyframes():
    """Each frame has its own, in whatever frame the file stands when a render begins."""
    scene, data = start()
    settings = data.rack_focus
    keyed = {"enabled": (False, True), "views": (1, 3), "clean_edges": (False, True)}
    wanted = []
    for settings.enabled, settings.views in zip(keyed["enabled"], keyed["views"]):
        settings.clean_edges = True  # of all frames
        wanted.append(shot(scene, "keys0.exr"))
    for name, values in keyed.items():
        for frame, value in zip((1, 3), values):
            setattr(settings, name, value)
            settings.keyframe_insert(name, frame=frame)
    for curve in common.curves_of(data):
        for key in curve.keyframe_points:
            key.interpolation = "CONSTANT"
    for first in (1, 3):
        scene.frame_set(first)
        bpy.context.view_layer.update()
        scene.frame_start, scene.frame_end = 1, 3
        common.set_output(scene, checking.OUT / "keys#.exr")
        bpy.ops.render.render(animation=True)
        for frame, picture in ((1, wanted[0]), (2, wanted[0]), (3, wanted[1])):
            made = common.read(checking.OUT / f"keys{frame}.exr")
            same(common.rgba(made), picture)
    if hasattr(data.animation_data, "action_slot"):  # 4.4; an action that plays nothing
        data.animation_data.action_slot = None
        assert addon("keyed").values(settings, "views") == {settings.views}


checking.run(check, "camera_results.json")
