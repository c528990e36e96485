# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of what scenes of others do that a filter behind the render does not see.

scene_checks.py DIST OUT [CHECK ...]    writes OUT/scene_results.json
"""

import contextlib
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import (  # noqa: E402
    OUT,
    Checks,
    heard,
    key_focus,
    refocused,
    shot,
    tree_with_output,
    update,
)
from common import addon, last_message, rgba, same, start, tpsnr  # noqa: E402

check = Checks()


def refusal():
    """What a refocus says that is refused; "" where it is not."""
    try:
        bpy.ops.rack_focus.refocus()
    except RuntimeError as error:
        return str(error)
    return ""


# ---- nodes ------------------------------------------------------------------------


@check
def nodes_that_show_no_picture():
    """A composite of the depth, of another scene, of no render: box and console say so."""
    for name in ("depth", "scene", "colour"):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        scene = bpy.context.scene
        tree, layers, output = tree_with_output(scene)
        if name == "depth":
            scene.view_layers[0].use_pass_z = True
            tree.links.new(layers.outputs["Depth"], output)
        elif name == "scene":
            layers.scene = other = bpy.data.scenes.new("Other")
            other.camera = bpy.data.objects.new("Other", scene.camera.data.copy())
            common.set_up_cycles(other)
        else:
            colour = tree.nodes.new("CompositorNodeRGB")
            tree.links.new(colour.outputs[0], output)
        plain = shot(scene, "nothing0.exr")
        start()
        with heard() as said:
            same(shot(scene, "nothing1.exr"), plain)
        said = said.getvalue()
        assert "show nothing of the Rack Focus node" in said, (name, said)
        assert "press F12" not in said and not last_message(scene), said
        assert addon("unblurred").describe(scene)
        settings = scene.camera.data.rack_focus
        settings.views = 3  # not the depth of one of them, in a part of the samples
        same(shot(scene, "nothing1.exr"), plain)
        settings.views = 1
        ours = addon("setup").filter_scene_of(scene)
        node = next(n for n in tree.nodes if getattr(n, "scene", None) == ours)
        tree.links.new(node.outputs["Image"], output)
        assert not addon("unblurred").describe(scene)
        assert not np.array_equal(shot(scene, "nothing2.exr"), plain)
        assert not last_message(scene), last_message(scene)


@check
def an_output_that_is_no_colour():
    """5.x shows the plain render then, and crashed with several views: it is said."""
    if not addon("compat").HAS_NODE_GROUPS:
        return
    scene = bpy.context.scene
    tree, layers, output = tree_with_output(scene)
    interface = tree.interface
    number = interface.new_socket(
        "Number", in_out="OUTPUT", socket_type="NodeSocketFloat"
    )
    interface.move(number, 0)
    scene.camera.data.dof.use_dof = True
    plain = shot(scene, "number0.exr")
    scene, data = start()
    with heard() as said:
        same(shot(scene, "number1.exr"), plain)
    assert "first output is no colour" in said.getvalue(), said.getvalue()
    data.rack_focus.views = 3
    same(shot(scene, "number2.exr"), plain)
    interface.move(number, len(interface.items_tree))
    assert not addon("setup").why_not(scene)
    assert not np.array_equal(shot(scene, "number3.exr"), plain)


@check
def the_active_one_of_two_outputs():
    """5.x: what Blender shows is filtered."""
    if not addon("compat").HAS_NODE_GROUPS:
        return
    scene = bpy.context.scene
    tree, layers, output = tree_with_output(scene)
    other = tree.nodes.new("NodeGroupOutput")
    other.is_active_output = True
    assert addon("compat").output_socket(tree) == other.inputs[0]
    tree.nodes.remove(layers)
    sharp = shot(scene, "active0.exr")
    start()
    assert other.inputs[0].is_linked and not output.is_linked
    assert not np.array_equal(shot(scene, "active1.exr"), sharp)


@check
def a_linked_compositor():
    """5.x: nothing is written into the other file's group, and what to do is said."""
    if not addon("compat").HAS_NODE_GROUPS:
        return
    tree, layers, _ = tree_with_output(bpy.context.scene)
    tree.nodes.remove(layers)
    tree.name = "Shared"
    library = str(OUT / "shared.blend")
    bpy.ops.wm.save_as_mainfile(filepath=library, copy=True)
    bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
    scene = bpy.context.scene
    sharp = shot(scene, "linked0.exr")
    with bpy.data.libraries.load(library, link=True) as (_, found):
        found.node_groups = ["Shared"]
    scene.compositing_node_group = tree = found.node_groups[0]
    plain = shot(scene, "linked1.exr")
    _, data = start()
    with heard() as said:
        same(shot(scene, "linked2.exr"), plain)
    assert "is linked from another file" in said.getvalue(), said.getvalue()
    assert len(tree.nodes) == 1 and "linked" in refusal()
    tree.make_local()
    update()
    addon("handlers").on_change()
    assert tree.library is None and len(tree.nodes) == 2
    made = shot(scene, "linked3.exr")
    assert not last_message(scene), last_message(scene)
    assert not np.array_equal(made, sharp) and tpsnr(made, sharp) > 20
    data.rack_focus.enabled = False
    assert addon("setup").filter_scene_of(scene) is None


@check
def a_linked_scene_that_nodes_show():
    """It is not filtered, though its camera is ticked, and that is said."""
    start()
    library = str(OUT / "ticked.blend")
    bpy.ops.wm.save_as_mainfile(filepath=library, copy=True)
    for is_ticked in (True, False):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        scene = bpy.context.scene
        path = library if is_ticked else str(checking.BASE)
        if not is_ticked:
            bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "shows.blend"))
        with bpy.data.libraries.load(path, link=True) as (_, found):
            found.scenes = ["Scene"]
        _, layers, _ = tree_with_output(scene)
        layers.scene = found.scenes[0]
        with heard() as said:
            shot(scene, "shows.exr")
        assert ("is linked from" in said.getvalue()) == is_ticked, said.getvalue()


@check
def the_filter_scene_is_deleted():
    """Its nodes looked at nothing, and every picture was black; they get a new one."""
    scene = bpy.context.scene
    sharp = shot(scene, "deleted0.exr")
    for views in (1, 3):
        scene, data = start(views=views)
        wanted = shot(scene, "deleted1.exr")
        bpy.data.scenes.remove(scene.rack_focus.filter_scene)
        if views == 1:
            update()
            addon("handlers").on_change()
        same(shot(scene, "deleted2.exr"), wanted)
        assert not last_message(scene), last_message(scene)
        same(refocused(scene, "deleted3.exr"), wanted)
        data.rack_focus.enabled = False
        assert len(bpy.data.scenes) == 1 and common.tree_of(scene) is None
        same(shot(scene, "deleted4.exr"), sharp)


@check
def a_defocus_node_of_the_artists():
    """Files for its depth of field have one, which would blur the picture once more."""
    scene = bpy.context.scene
    tree, layers, output = tree_with_output(scene)
    node = tree.nodes.new("CompositorNodeDefocus")
    describe = addon("unblurred").describe
    tree.links.new(layers.outputs["Image"], node.inputs[0])
    start()
    update()
    assert not describe(scene)  # it leads nowhere
    tree.links.new(node.outputs[0], output)
    assert not describe(scene)[1:] and node.name in describe(scene)[0], describe(scene)
    with heard() as said:
        shot(scene, "defocus.exr")
    assert "once more: mute it" in said.getvalue(), said.getvalue()
    node.mute = True
    assert not describe(scene)


# ---- holes and halos -----------------------------------------------------------


def hold_out_an_object(cubes):
    """Object Properties > Visibility > Holdout."""
    for cube in cubes:
        cube.is_holdout = True


def hold_out_a_collection(cubes):
    """A collection's Holdout in the view layer."""
    found = bpy.data.collections.new("Held")
    scene = bpy.context.scene
    scene.collection.children.link(found)
    for cube in cubes:
        scene.collection.objects.unlink(cube)
        found.objects.link(cube)
    bpy.context.view_layer.layer_collection.children["Held"].holdout = True


def hold_out_a_material(cubes):
    """A Holdout shader."""
    for cube in cubes:
        tree = cube.data.materials[0].node_tree
        node = tree.nodes.new("ShaderNodeHoldout")
        output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
        tree.links.new(node.outputs[0], output.inputs["Surface"])


@check
def holdouts():
    """Cycles gives them no depth: with one view box and console say what to do."""
    describe = addon("holdouts").describe
    for hold_out in (hold_out_an_object, hold_out_a_collection, hold_out_a_material):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        scene = bpy.context.scene
        assert not describe(scene, scene.camera)
        hold_out([o for o in scene.objects if o.type == "MESH"][:8])
        update()
        assert describe(scene, scene.camera), hold_out
    scene.render.film_transparent = True
    scene.cycles.samples, scene.camera.data.dof.use_dof = 256, True
    own = shot(scene, "hole0.exr")
    scene, data = start()
    with heard() as said:
        made = shot(scene, "hole1.exr")
    assert "take several Views" in said.getvalue(), said.getvalue()
    data.rack_focus.views = 4
    assert not describe(scene, scene.camera)
    assert tpsnr(shot(scene, "hole4.exr"), own) > tpsnr(made, own) + 4


@check
def a_halo_over_a_transparent_film():
    """Rims without depth before a large far blur: a message, but with Edges."""
    scene = bpy.context.scene
    scene.render.film_transparent = True
    scene.cycles.samples = 64
    scene, data = start()
    shot(scene, "halo0.exr")
    assert not last_message(scene), last_message(scene)
    data.dof.aperture_fstop = 0.05
    made = {}
    for choice in ("solid", "edges"):
        data.rack_focus.film_depth = choice
        made[choice] = shot(scene, "halo1.exr")
        is_said = "set Film Depth to Edges" in last_message(scene)
        assert is_said == (choice == "solid"), (choice, last_message(scene))
    data.rack_focus.enabled, data.dof.use_dof = False, True
    update()
    scene.cycles.samples = 512
    own = shot(scene, "halo2.exr")
    scores = {choice: tpsnr(picture, own) for choice, picture in made.items()}
    assert scores["edges"] > scores["solid"], scores
    print("HALO", scores)


# ---- background sets and nodes on pictures ------------------------------------------


@check
def what_a_background_set_holds():
    """Its camera, objects that stay sharp, holdouts, fog and flames count."""
    behind = bpy.context.scene
    scene = bpy.data.scenes.new("Main")
    common.set_up_cycles(scene)
    scene.render.resolution_x, scene.render.resolution_y = 72, 48
    scene.background_set, scene.world, scene.camera = (
        behind,
        behind.world,
        behind.camera,
    )
    wanted = scene.camera.data.rack_focus
    wanted.mirrors = wanted.enabled = True
    addon("handlers").on_change()
    assert addon("mirrors").is_wanted(scene)
    wanted.mirrors = False
    plain = shot(scene, "set0.exr")
    assert not last_message(scene), last_message(scene)
    cubes = [o for o in behind.objects if o.type == "MESH"]
    cubes[0].rack_focus_keep_sharp = True
    assert not np.array_equal(shot(scene, "set1.exr"), plain)
    assert not addon("holdouts").describe(scene, scene.camera)
    hold_out_a_material(cubes[:1])
    update()
    assert addon("holdouts").describe(scene, scene.camera)
    assert not addon("fog").has_volume(scene)
    tree = cubes[1].data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeVolumeScatter")
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(node.outputs[0], output.inputs["Volume"])
    assert addon("fog").has_volume(scene)


@check
def a_camera_that_is_not_the_scenes():
    """Views are cleaned together, and mirrors rendered, as the scene's own one wants."""
    scene, data = start(views=4)
    scene.cycles.use_denoising = True
    other = scene.camera.copy()
    other.data = data.copy()
    other.data.rack_focus.denoise_together = False
    other.data.rack_focus.mirrors = True
    scene.collection.objects.link(other)
    assert addon("denoising").is_asked(scene)
    assert not addon("mirrors").is_wanted(scene)


@check
def a_node_on_a_picture_after_redo():
    """Redone, its group has lost its images: a refocus said that it was at fault."""
    scene, data = start()
    shot(scene, "redo0.exr")
    bpy.ops.ed.undo_push(message="rendered")
    tree, layers, _ = tree_with_output(scene)
    tree.nodes.active = layers
    bpy.ops.rack_focus.add_picture_node()
    bpy.ops.ed.undo_push(message="added")
    wanted = shot(bpy.context.scene, "redo1.exr")
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()
    scene = bpy.context.scene
    with contextlib.suppress(RuntimeError):
        bpy.ops.rack_focus.refocus()
    assert "a fault" not in last_message(scene), last_message(scene)
    same(shot(scene, "redo2.exr"), wanted)


# ---- rigid bodies -----------------------------------------------------------------


def fall(is_baked):
    """A rigid body that has fallen away from the camera until frame 15; returns it."""
    scene = bpy.context.scene
    bpy.ops.rigidbody.world_add()
    scene.rigidbody_world.collection = bpy.data.collections.new("Bodies")
    body = common.emitter("Body", (1, 0.2, 0.1), 0.6, (0.2, 2, -0.3))
    update()
    scene.rigidbody_world.collection.objects.link(body)
    update()
    scene.gravity = 0, 30, 2
    scene.frame_end = 30
    for frame in range(1, 16):
        scene.frame_set(frame)
    if is_baked:
        bpy.ops.ptcache.bake_all(bake=True)
        scene.frame_set(15)
    assert body.matrix_world.translation.y > 6
    return body


@check
def a_focus_object_that_is_a_rigid_body():
    """The lens is focused where it fell to; the filter scene has it where it started."""
    body = fall(is_baked=True)
    scene = bpy.context.scene
    scene.camera.data.dof.focus_object = body
    scene.camera.data.dof.use_dof = True
    scene.cycles.samples = 256
    own = shot(scene, "body0.exr")
    scene, data = start()
    made = shot(scene, "body1.exr")
    assert tpsnr(made, own) > 32, tpsnr(made, own)  # else 21.7 from 4.2 on
    same(refocused(scene, "body2.exr"), made)
    data.rack_focus.views = 4
    made = shot(scene, "body3.exr")
    assert tpsnr(made, own) > 32, tpsnr(made, own)
    assert not last_message(scene), last_message(scene)


@check
def rigid_bodies_that_are_not_baked():
    """A copy of the scene has them where they started: one view, and a message."""
    fall(is_baked=False)
    scene, data = start()
    one = shot(scene, "bodies1.exr")
    assert not last_message(scene), last_message(scene)
    for name, value in (("views", 3), ("supersample", 2)):
        setattr(data.rack_focus, name, value)
        same(shot(scene, "bodies2.exr"), one)
    assert "baked" in addon("finishing").why_not(scene)
    data.rack_focus.supersample = 1
    same(shot(scene, "bodies3.exr"), one)
    assert "are not baked" in last_message(scene), last_message(scene)
    assert "Bake" in addon("views").describe(data.rack_focus, scene, 3)[-1]
    bpy.ops.ptcache.bake_all(bake=True)
    scene.frame_set(15)
    assert not np.array_equal(shot(scene, "bodies4.exr"), one)
    assert not last_message(scene), last_message(scene)


@check
def one_view_layer_is_rendered():
    """The button on a Render Layers node: Blender shows an old picture, or none."""
    scene, _ = start()
    with heard() as said:
        shot(scene, "layer0.exr")
        bpy.ops.rack_focus.refocus()
    assert not said.getvalue(), said.getvalue()
    layer = scene.view_layers[0].name
    with heard() as said:
        bpy.ops.render.render(layer=layer, scene=scene.name)
    assert "Press F12" in said.getvalue() and "Press F12" in last_message(scene)
    shot(scene, "layer1.exr")
    assert not last_message(scene), last_message(scene)
    scene.frame_start = scene.frame_end = scene.frame_current
    for _ in range(2):  # the second one finds the file, and renders nothing
        scene.render.filepath, scene.render.use_overwrite = str(OUT / "layer2_"), False
        bpy.ops.render.render(animation=True)
        assert not last_message(scene), last_message(scene)


# ---- refocus after changes ----------------------------------------------------------


@check
def a_refocus_after_names_changed():
    """Of the scene, its view layer and its camera, also undone."""
    # Of a renamed scene older ones have no Render Result.
    for views in (1, 3) if bpy.app.version >= (5, 0, 0) else (3,):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        bpy.ops.ed.undo_push(message="before")
        scene, _ = start(views=views)
        wanted = shot(scene, "names0.exr")
        bpy.ops.ed.undo_push(message="rendered")
        scene.name, scene.camera.name, scene.view_layers[0].name = "S", "C", "L"
        update()
        same(refocused(scene, "names1.exr"), wanted)
        other = scene.copy()
        other.name = "Scene"
        addon("handlers").on_change()
        same(refocused(scene, "names2.exr"), wanted)
        scene.view_layers[0].name = "L2"
        same(refocused(scene, "names3.exr"), wanted)
        bpy.ops.ed.undo_push(message="renamed")
        bpy.ops.ed.undo()
        scene = bpy.context.scene
        assert scene.name == "Scene" and scene.view_layers[0].name != "L2"
        same(refocused(scene, "names4.exr"), wanted)
        assert not last_message(scene), last_message(scene)


@check
def a_refocus_of_a_layer_that_was_not_rendered():
    """It is refused, and the picture stays; it was black."""
    for views in (1, 3):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        scene, _ = start(views=views)
        wanted = shot(scene, "layerless0.exr")
        scene.view_layers.new("Second")
        addon("handlers").on_change()
        same(refocused(scene, "layerless1.exr"), wanted)  # its node is not shown
        scene.view_layers.remove(scene.view_layers[0])
        addon("handlers").on_change()
        assert "“Second” was not rendered: press F12" in refusal()
        same(checking.result(scene, OUT / "layerless2.exr"), wanted)
        same(shot(scene, "layerless3.exr"), wanted)


@check
def a_refocus_after_the_size_changed():
    """It is refused, and the picture stays; half the size is the picture made small."""
    for views in (1, 3):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        scene, _ = start(views=views)
        wanted, settings = shot(scene, "size0.exr"), scene.render
        settings.resolution_x = 100
        assert "72 x 48 px" in refusal() and "press F12" in refusal()
        same(checking.result(scene, OUT / "size1.exr"), wanted)
        settings.resolution_x = 72
        settings.use_border, settings.border_min_x = True, 0.25
        settings.use_crop_to_border = True
        assert "press F12" in refusal()
        settings.use_crop_to_border = False
        refocused(scene, "size2.exr")
        shot(scene, "size3.exr")
        for least in (0, 0.25, 0.5):
            settings.border_min_x = least
            assert ("another render region" in refusal()) == (least == 0), least
        settings.use_border = False
        assert "another render region" in refusal()


@check
def a_refocus_after_the_camera_changed():
    """Another one, or one that moved: it is filtered, and the render says what it is of."""
    scene, data = start()
    shot(scene, "other0.exr")
    first, second = scene.camera, scene.camera.copy()
    second.data = data.copy()
    second.data.dof.focus_distance = 9
    scene.collection.objects.link(second)
    scene.camera = second  # at the same place: a lens to compare
    update()
    refocused(scene, "other1.exr")
    assert not last_message(scene), last_message(scene)
    second.location.x = 1
    update()
    with heard() as said:
        refocused(scene, "other2.exr")
    assert f"the render of camera “{first.name}”" in said.getvalue(), said.getvalue()
    scene.camera = first
    update()
    refocused(scene, "other3.exr")
    assert not last_message(scene), last_message(scene)
    data.lens = 35
    update()
    refocused(scene, "other4.exr")
    assert "has moved, or sees another part" in last_message(scene)
    shot(scene, "other5.exr")
    assert not last_message(scene), last_message(scene)


@check
def kept_passes_of_a_region():
    """Files have the part alone; it was cut out of them once more."""
    for views in (1, 3):
        bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
        scene, _ = start(passes_folder=str(OUT / f"region{views}"), views=views)
        settings = scene.render
        settings.use_border, settings.use_crop_to_border = True, False
        settings.border_min_x, settings.border_max_y = 0.25, 0.9
        wanted = shot(scene, "region0.exr")
        path = str(OUT / "region.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        scene = bpy.context.scene
        same(refocused(scene, "region1.exr"), wanted)
        assert not last_message(scene), last_message(scene)


@check
def stereo_is_picked_and_kept():
    """A click takes the depth of the first view; files of both are found again."""
    scene, data = start(passes_folder=str(OUT / "stereo"))
    scene.render.use_multiview = True
    common.set_output(scene, OUT / "stereo.exr")
    bpy.ops.render.render(write_still=True)
    wanted = {s: rgba(common.read(OUT / f"stereo{s}.exr")) for s in ("_L", "_R")}
    depth = common.read(OUT / "stereo" / "passes0001_L.exr")["Z"]
    row, column = np.argwhere(depth == depth.min())[0]
    x, y = (column + 0.5) / depth.shape[1], 1 - (row + 0.5) / depth.shape[0]
    focus = data.dof.focus_distance
    assert bpy.ops.rack_focus.pick_focus(x=x, y=y) == {"FINISHED"}
    assert np.isclose(data.dof.focus_distance, depth.min())
    data.dof.focus_distance = focus
    path = str(OUT / "stereo.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    assert bpy.ops.rack_focus.refocus() == {"FINISHED"}
    found = addon("passes").RenderedPasses(scene.rack_focus.filter_scene)
    for side, view in (("_L", "left"), ("_R", "right")):
        same(found.layer(scene.view_layers[0].name, side, view).colour, wanted[side])


# ---- cameras and frames -----------------------------------------------------------


@check
def what_is_bound_to_a_marker_is_no_camera():
    """Blender renders through a lamp too: plain, and the other frames are filtered.

    Not an empty: with that 5.2 crashes by itself.
    """
    scene = bpy.context.scene
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    scene.collection.objects.link(lamp)
    lamp.matrix_world = scene.camera.matrix_world
    for frame, seen in ((1, scene.camera), (5, lamp)):
        scene.timeline_markers.new("marker", frame=frame).camera = seen
    scene.frame_set(5)
    assert scene.camera == lamp
    plain = shot(scene, "lamp0.exr")
    scene.frame_set(1)
    scene, data = start()
    first = shot(scene, "lamp1.exr")
    scene.frame_set(5)
    assert not bpy.ops.rack_focus.pick_focus.poll()
    for views in (1, 3):
        data.rack_focus.views = views
        with heard() as said:
            same(shot(scene, "lamp2.exr"), plain)
        assert not last_message(scene) and not said.getvalue(), said.getvalue()
    scene.frame_set(1)
    assert not np.array_equal(shot(scene, "lamp3.exr"), first)  # three views
    data.rack_focus.views = 1
    same(shot(scene, "lamp3.exr"), first)


@check
def a_script_switches_the_camera():
    """Its handler gets the scene, or a copy that renders views, or takes Blender's."""
    scene, data = start()
    first, second = scene.camera, scene.camera.copy()
    second.data = data.copy()
    second.data.dof.focus_distance, second.location.x = 9, 0.3
    scene.collection.objects.link(second)
    scene.frame_start, scene.frame_end = 1, 3
    taken = {1: first.name, 2: second.name, 3: second.name}

    def switch(given, *_):
        given.camera = bpy.data.objects[taken[given.frame_current]]

    def switch_context(*_):
        switch(bpy.context.scene)

    for views in (1, 3):
        wanted = {}
        for camera in (second, first):
            scene.camera, camera.data.rack_focus.views = camera, views
            update()
            wanted[camera.name] = shot(scene, "switch0.exr")
        assert tpsnr(*wanted.values()) < 20
        for where in ("render_pre", "frame_change_pre", "frame_change_post"):
            for script in (switch, switch_context):
                getattr(bpy.app.handlers, where).append(script)
                common.set_output(scene, OUT / "switch_")
                bpy.ops.render.render(animation=True)
                getattr(bpy.app.handlers, where).remove(script)
                for frame, name in taken.items():
                    made = rgba(common.read(OUT / f"switch_{frame:04d}"))
                    same(made, wanted[name])
                assert not last_message(scene), last_message(scene)
                scene.camera = first
                update()


@check
def between_frames():
    """The lens is that of the subframe; in an animation, which has none, of the frame."""
    scene, data = start()
    key_focus(data, {1: 1.5, 3: 9})
    render_settings = scene.render
    scene.frame_set(1)
    first = shot(scene, "between0.exr")
    scene.frame_set(1, subframe=0.75)
    distance = data.dof.focus_distance
    assert distance > 2
    made = shot(scene, "between1.exr")
    same(refocused(scene, "between2.exr"), made)
    scene.frame_start = scene.frame_end = 1
    render_settings.filepath = str(OUT / "between3_")
    bpy.ops.render.render(animation=True)
    same(rgba(common.read(OUT / "between3_0001")), first)
    data.animation_data_clear()
    data.dof.focus_distance = distance
    scene.frame_set(1)
    same(shot(scene, "between4.exr"), made)


@check
def things_that_simplify_leaves_out():
    """Cycles leaves nothing out in multi-view: far cubes, lamps behind the camera."""
    scene, _ = start(views=3)
    scene.cycles.samples = 48
    far = [o for o in scene.objects if o.type == "MESH" and o.location.y > 5]
    scene.render.use_simplify = scene.cycles.use_distance_cull = True
    scene.cycles.distance_cull_margin = 5
    whole = shot(scene, "culled0.exr")
    for thing in far:
        thing.cycles.use_distance_cull = True
    made = shot(scene, "culled1.exr")
    assert not last_message(scene), last_message(scene)
    for thing in far:
        thing.hide_render = True
    wanted = shot(scene, "culled2.exr")
    assert tpsnr(made, wanted) > 40 > 35 > tpsnr(whole, wanted)


def view_3d():
    """The first 3D view of a window."""
    windows = bpy.context.window_manager.windows
    areas = [area for window in windows for area in window.screen.areas]
    return next(area for area in areas if area.type == "VIEW_3D").spaces.active


@check
def a_local_camera():
    """F12 over its 3D view renders through it, which no handler is told."""
    scene, space = bpy.context.scene, view_3d()
    start()
    describe = addon("local_cameras").describe
    other = scene.camera.copy()
    scene.collection.objects.link(other)
    assert not describe(scene)
    space.use_local_camera, space.camera = True, other
    assert other.name in describe(scene)[0]
    space.camera = scene.camera
    assert not describe(scene)
    space.use_local_camera = False
    assert not describe(scene)


@check
def composited_3d_views():
    """They show nothing of other scenes, and were empty without a word."""
    scene = bpy.context.scene
    is_empty = addon("view_compositor").is_empty
    shading = view_3d().shading
    if bpy.app.version < (3, 5, 0):
        start()
        assert not is_empty(scene)
        return
    shading.type, shading.use_compositor = "RENDERED", "ALWAYS"
    assert not is_empty(scene)
    start()
    assert is_empty(scene)
    tree = common.tree_of(scene)
    output = addon("compat").output_socket(tree)
    picture = output.links[0].from_socket
    tree.links.remove(output.links[0])
    assert not is_empty(scene)
    shading.use_compositor = "DISABLED"
    tree.links.new(picture, output)
    assert not is_empty(scene)
    shading.type, shading.use_compositor = "SOLID", "CAMERA"
    assert not is_empty(scene)
    shading.type = "RENDERED"
    assert is_empty(scene)
    bpy.ops.rack_focus.views_uncomposited()
    assert shading.use_compositor == "DISABLED" and not is_empty(scene)


@check
def blended_materials_of_eevee():
    """EEVEE gives them no depth (28.1 dB for 36.4): box and console name one."""
    scene, data = start()
    cube = next(o for o in scene.objects if o.type == "MESH")
    material = cube.data.materials[0]
    describe = addon("blended").describe
    kinds = bpy.types.RenderSettings.bl_rna.properties["engine"].enum_items.keys()
    scene.render.engine = next(k for k in kinds if k.startswith("BLENDER_EEVEE"))
    update()
    assert not describe(scene, scene.camera)
    is_old = bpy.app.version < (4, 2, 0)
    field = "blend_method" if is_old else "surface_render_method"
    setattr(material, field, "BLEND" if is_old else "BLENDED")
    with heard() as said:
        addon("handlers")._prepare(scene)
    assert f"“{material.name}” is blended" in said.getvalue(), said.getvalue()
    assert ("Hashed" if is_old else "Dithered") in describe(scene, scene.camera)[1]
    data.rack_focus.method = "accumulate"
    assert not describe(scene, scene.camera)
    data.rack_focus.method = "layered"
    scene.render.engine = "CYCLES"
    assert not describe(scene, scene.camera)


checking.run(check, "scene_results.json")
