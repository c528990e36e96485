# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of what farms and studios meet: files, scenes, libraries, what is left behind.

farm_checks.py DIST OUT [CHECK ...]    writes OUT/farm_results.json
"""

import contextlib
import csv
import json
import os
import re
import shutil
import sys
import time
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import BASE, OUT, Checks  # noqa: E402
from common import (  # noqa: E402
    addon,
    emitter,
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
    """What the filter makes of the passes of a scene."""
    sharp = pinhole(scene, OUT / "farm_passes.exr")
    return filtered(scene, rgba(sharp, "ViewLayer"), common.depth_of(sharp))


def second_scene():
    """A scene that is not active, with the first one's camera and a cube of its own."""
    first = bpy.context.scene
    two = bpy.data.scenes.new("Two")
    common.set_up_cycles(two)
    for name in ("resolution_x", "resolution_y", "resolution_percentage"):
        setattr(two.render, name, getattr(first.render, name))
    two.collection.objects.link(first.camera)
    two.camera = first.camera
    for name, colour, place in (("near", (1, 0, 0), 2), ("far", (0, 1, 0), 7)):
        item = emitter(name, colour, 0.2 * place, (0.05 * place, place, 0))
        first.collection.objects.unlink(item)
        two.collection.objects.link(item)
    return two


def reopen(name):
    """Saves, and opens what was saved."""
    path = str(OUT / f"{name}.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.open_mainfile(filepath=path)


# ---- never a wrong or a black frame -----------------------------------------------


def scripts_of_the_page():
    """The text of passes.py and of lens.py in docs/blender-farm.md."""
    page = (Path(__file__).parents[3] / "docs/blender-farm.md").read_text()
    found = re.findall(r"^   ```python\n(.*?)^   ```", page, re.S | re.M)
    return [re.sub("^   ", "", text, flags=re.M) for text in found]


def filtered_later(scene, folder):
    """What the jobs of the page make of a frame, by their scripts."""
    passes, lens = scripts_of_the_page()
    exec(compile(passes.replace('"ZIP"', '"NONE"'), "passes.py", "exec"), {})
    scene.render.use_file_extension = True
    scene.render.filepath = str(folder / "passes.####")
    bpy.ops.render.render(animation=True, scene=scene.name)
    channels = common.read(folder / "passes.0001.exr")
    with contextlib.chdir(folder):
        exec(compile(lens, "lens.py", "exec"), {})
    names, values = csv.reader((folder / "lens.csv").read_text().splitlines())
    row = dict(zip(names, values, strict=True))
    words = {"sensor-fit", "projection"}
    params = {
        name.replace("-", "_"): value if name in words else float(value)
        for name, value in row.items()
        if name != "frame"
    }
    params["blades"] = int(params["blades"])
    colour = np.ascontiguousarray(rgba(channels, "ViewLayer"))
    library = addon("library").rackfocus
    return library.apply(colour, common.depth_of(channels), **params)


@check
def passes_that_are_filtered_later():
    """The scripts of the page have the lens of F12: blades, a bone, an orthographic one."""
    if bpy.app.version < (4, 2, 0):  # whose orthographic lens stands elsewhere
        return
    scene, data = start()
    bones = bpy.data.objects.new("bones", bpy.data.armatures.new("bones"))
    scene.collection.objects.link(bones)
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    bone = bones.data.edit_bones.new("eye")
    bone.head, bone.tail = (0, 2, 0), (0, 3, 0)
    bpy.ops.object.mode_set(mode="OBJECT")
    dof = data.dof
    dof.focus_object, dof.focus_subtarget = bones, "eye"
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 5, 0.4, 1.7
    scene.render.pixel_aspect_x, scene.frame_start, scene.frame_end = 1.3, 1, 1
    (OUT / "later").mkdir(exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "later.blend"))
    for kind, f_stop in (("PERSP", 0.2), ("ORTHO", 6)):
        bpy.ops.wm.open_mainfile(filepath=str(OUT / "later.blend"))
        scene = bpy.context.scene
        data = scene.camera.data
        data.type, data.ortho_scale, data.dof.aperture_fstop = kind, 3, f_stop
        made = rgba(render(scene, OUT / "later.exr"))
        data.rack_focus.enabled = False
        later = filtered_later(scene, OUT / "later")
        assert np.abs(later - made).max() < 1e-3, (kind, np.abs(later - made).max())


@check
def a_multilayer_file_of_several_views():
    """It has the passes of one of the views, as File Output nodes do."""
    scene, data = start()
    layer = scene.view_layers[0]
    layer.use_pass_mist = layer.use_pass_cryptomatte_object = True
    scene.world.mist_settings.depth = 12
    one = render(scene, OUT / "layers.exr", multilayer=True)
    outputs = addon("outputs")
    assert not outputs.describe(scene)
    data.rack_focus.method, data.rack_focus.views = "views", 3
    assert "one of the views" in outputs.describe(scene)[0]
    with checking.heard() as said:
        found = render(scene, OUT / "layers.exr", multilayer=True)
    assert not said.getvalue(), said.getvalue()
    assert set(one) | {"ViewLayer.Depth.Z"} == set(found), sorted(found)
    first = common.kept(scene)[0][0]
    same(rgba(found, "ViewLayer"), first.colour)
    same(common.depth_of(found), first.depth)
    for name in ("Mist.Z", "CryptoObject00.g"):
        planes = [some[f"ViewLayer.{name}"].ravel() for some in (found, one)]
        alike = np.corrcoef(*planes)[0, 1]
        assert alike > 0.6, (name, alike)  # seen from another point of the lens
    about = addon("exr").read_file(OUT / "layers.exr")[1]
    assert any(b"cube.001" in value for value in about.values()), list(about)
    # As artists have it: an animation, 16 bits, compressed.
    scene.frame_start = scene.frame_end = 7
    common.set_output(scene, OUT / "packed_##", multilayer=True)
    scene.render.image_settings.color_depth = "16"
    scene.render.image_settings.exr_codec = "ZIP"
    bpy.ops.render.render(animation=True)
    found = render(scene, OUT / "unpacked_07", multilayer=True)
    same(rgba(found, "Composite"), rgba(render(scene, OUT / "plain.exr")))


@check
def a_multilayer_file_with_a_space_of_its_own():
    """It lacks the passes, which is said."""
    scene, _ = start(method="views", views=3)
    common.set_output(scene, OUT / "space.exr", multilayer=True)
    scene.render.image_settings.color_management = "OVERRIDE"
    with checking.heard() as said:
        bpy.ops.render.render(write_still=True)
    assert "black view layers" in said.getvalue(), said.getvalue()
    assert "black view layers" in addon("outputs").describe(scene)[1]


@check
def a_scene_that_is_not_active():
    """It shows its own view, filtered: not the active scene's."""
    two = second_scene()
    start()
    made = rgba(render(two, OUT / "two.exr"))
    assert not last_message(two), last_message(two)
    same(made, expected(two))


@check
def a_file_that_an_earlier_version_damaged():
    """The nodes of its second scene look at the first one; they are mended once."""
    two = second_scene()
    _, data = start()
    setup, tree = addon("setup"), common.tree_of(two)
    source = setup.layer_nodes(tree, two)[0]
    ours = setup.layer_nodes(tree, two.rack_focus.filter_scene)[0]
    addon("links").move_links(tree, ours, source)
    source.scene = bpy.data.scenes["Scene"]
    record = json.loads(two.rack_focus.record)
    del record["version"]
    two.rack_focus.record = json.dumps(record)
    reopen("damaged")
    two = bpy.data.scenes["Two"]
    same(rgba(render(two, OUT / "two.exr")), expected(two))
    # What an artist chooses afterwards stays.
    tree = common.tree_of(two)
    render(two, OUT / "two.exr")
    source = setup.layer_nodes(tree, two)[0]
    source.scene = bpy.data.scenes["Scene"]
    reopen("damaged")
    assert not setup.layer_nodes(common.tree_of(bpy.data.scenes["Two"]), two)


def plain():
    """Nothing of the artist's own."""


def with_nodes():
    """A Flip behind the render, and the CoC and Focus shown."""
    scene = bpy.context.scene
    tree = common.tree_of(scene)
    ours = addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]
    flip = tree.nodes.new("CompositorNodeFlip")
    if "Flip X" in flip.inputs:  # 4.5 and later
        flip.inputs["Flip X"].default_value = True
        flip.inputs["Flip Y"].default_value = False
    out = addon("compat").output_socket(tree)
    tree.links.new(ours.outputs["Image"], flip.inputs[0])
    tree.links.new(flip.outputs[0], out)
    for name in ("CoC", "Focus"):
        reroute = tree.nodes.new("NodeReroute")
        tree.links.new(ours.outputs[name], reroute.inputs[0])


def without_own_node():
    """The scene's own Render Layers node was deleted."""
    scene = bpy.context.scene
    tree = common.tree_of(scene)
    for node in addon("setup").layer_nodes(tree, scene):
        tree.nodes.remove(node)


@check
def files_for_machines_without_the_add_on():
    """The open file stays as it was; the tests render the written one without us."""
    cases = {"plain": plain, "nodes": with_nodes, "no_own_node": without_own_node}
    for name, change in cases.items():
        bpy.ops.wm.open_mainfile(filepath=str(BASE))
        wanted = expected(start()[0])
        change()
        before = snapshot(bpy.context.scene)
        mutes = [node.mute for node in common.tree_of(bpy.context.scene).nodes]
        common.set_output(bpy.context.scene, OUT / f"farm_{name}.exr")
        reopen(f"farm_{name}")
        scene = bpy.context.scene
        after = snapshot(scene)
        before[0]["images"] = after[0]["images"]
        assert after == before, (name, before, after)
        nodes = common.tree_of(scene).nodes
        assert [node.mute for node in nodes] == mutes, name
        made = rgba(render(scene, OUT / "farm.exr"))
        same(made, wanted[:, ::-1] if name == "nodes" else wanted)
    bpy.ops.wm.open_mainfile(filepath=str(BASE))
    sharp = pinhole(bpy.context.scene, OUT / "farm_sharp.exr")
    np.save(OUT / "farm_sharp.npy", rgba(sharp, "ViewLayer"))


@check
def without_the_scenes_own_node():
    """The scene is rendered all the same."""
    scene, data = start()
    wanted = expected(scene)
    without_own_node()
    data.dof.focus_distance, kept = 2, data.dof.focus_distance
    render(scene, OUT / "own.exr")  # else the last render would do
    without_own_node()
    data.dof.focus_distance = kept
    scene.cycles.seed = 3
    made = rgba(render(scene, OUT / "own.exr"))
    assert not last_message(scene), last_message(scene)
    scene.cycles.seed = 0
    assert np.abs(made - wanted).max() > 0
    same(rgba(render(scene, OUT / "own.exr")), wanted)


@check
def a_notice_in_files():
    """If the preferences want it, the written file has a script; the open one not."""
    start()
    preferences = bpy.context.preferences.addons[common.MODULE].preferences
    preferences.has_notice = True
    try:
        path = str(OUT / "farm_notice.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    finally:
        preferences.has_notice = False
    assert not bpy.data.texts
    with bpy.data.libraries.load(path) as (found, _):
        assert found.texts == [addon("park").NOTICE], found.texts


@check
def a_compositor_that_leads_past_us():
    """Switched off, or with our node muted: the camera's own blur, and a message."""
    scene, data = start()
    data.dof.use_dof = True
    tree = common.tree_of(scene)
    ours = addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]
    assert not addon("setup").why_not(scene)
    ours.mute = True
    assert "no active" in addon("setup").why_not(scene)
    common.set_output(scene, OUT / "past.exr")
    before = common.settings_of(scene)
    muted = rgba(render(scene, OUT / "past.exr"))
    assert "no active" in addon("failures").told[scene.name]
    common.unchanged(scene, before)
    scene.render.use_compositing = False
    made = rgba(render(scene, OUT / "past.exr"))
    assert "Compositing is off" in addon("failures").told[scene.name]
    data.rack_focus.enabled = False
    scene.render.use_compositing = False
    same(made, rgba(render(scene, OUT / "past.exr")))
    same(made, muted)


@check
def render_single_layer_shows_the_sharp_picture():
    """Blender renders no scene of a node then; with several views neither, nor refocus."""
    scene, data = start()
    scene.render.use_single_layer = True
    common.set_output(scene, OUT / "single.exr")
    for n in (1, 4):
        data.rack_focus.views, data.rack_focus.enabled = n, True
        before = common.settings_of(scene)
        made = rgba(render(scene, OUT / "single.exr"))
        assert "Render Single Layer" in addon("failures").told[scene.name]
        common.unchanged(scene, before)
        try:
            bpy.ops.rack_focus.refocus()
            raise AssertionError("a refocus of nothing")
        except RuntimeError as error:
            assert "Render Single Layer" in str(error), error
        data.rack_focus.enabled = False
        same(made, rgba(render(scene, OUT / "single.exr")))
    data.rack_focus.enabled, scene.render.use_single_layer = True, False
    assert np.abs(rgba(render(scene, OUT / "single.exr")) - made).max() > 0.01


@check
def strips_in_the_place_of_the_camera():
    """Blender shows the strips: box and console say so; muted ones as Blender does."""
    scene, data = start()
    why_shown = addon("strips").why_shown
    edit = scene.sequence_editor_create()
    of_edit = edit.strips if hasattr(edit, "strips") else edit.sequences
    assert not why_shown(scene)
    end = {"length": 9} if common.V >= (5, 0, 0) else {"frame_end": 9}
    strip = of_edit.new_effect("c", "COLOR", 1, frame_start=1, **end)

    def is_camera_shown():
        made = rgba(render(scene, OUT / "strips.exr"))
        return np.ptp(made[..., :3]) > 0

    is_camera_shown()
    try:
        bpy.ops.rack_focus.refocus()
    except RuntimeError as error:
        assert "Sequencer is on" in str(error), error
    else:
        raise AssertionError("refocused")
    channel = edit.channels[strip.channel]
    for is_muted, is_channel_muted in ((0, 0), (1, 0), (0, 1)):
        strip.mute, channel.mute = bool(is_muted), bool(is_channel_muted)
        is_shown = is_camera_shown()
        assert bool(why_shown(scene)) != is_shown, (is_muted, is_channel_muted)
        assert ("strips" in addon("failures").told.get(scene.name, "")) != is_shown
    strip.mute = channel.mute = scene.render.use_sequencer = False
    assert is_camera_shown() and not why_shown(scene)


@check
def a_linked_cameras_tick_by_a_script_leaves_nothing():
    """It is not in the file, so neither is the set-up once that is opened again."""
    start()
    library = str(OUT / "ticked_library.blend")
    bpy.context.scene.camera.data.rack_focus.enabled = False
    bpy.ops.wm.save_as_mainfile(filepath=library)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.objects = ["Camera"]
    scene.collection.objects.link(wanted.objects[0])
    scene.camera = wanted.objects[0]
    scene.camera.data.rack_focus.enabled = True
    assert len(bpy.data.scenes) == 2
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "ticked.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(OUT / "ticked.blend"))
    assert not bpy.context.scene.camera.data.rack_focus.enabled
    assert len(bpy.data.scenes) == 1, list(bpy.data.scenes)


@check
def drivers_that_read_the_active_scene():
    """Our scene evaluates the camera too, and made them invalid for the artist's."""
    scene, data = start()
    curve = data.dof.driver_add("focus_distance")
    curve.driver.type, curve.driver.expression = "SCRIPTED", "x"
    variable = curve.driver.variables.new()
    variable.name = "x"
    if "CONTEXT_PROP" not in variable.bl_rna.properties["type"].enum_items:  # 3.4
        return
    variable.type = "CONTEXT_PROP"
    variable.targets[0].data_path = '["far"]'
    for frame, value in ((1, 2.0), (3, 6.0)):
        scene["far"] = value
        scene.keyframe_insert('["far"]', frame=frame)
    curve.driver.is_valid = True
    scene.frame_set(1)
    engine, seen = addon("engine").RackFocusEngine, []
    kept = engine._render_frame

    def watched(self, frame, *more):
        seen.append(round(frame.camera.data.dof.focus_distance, 3))
        return kept(self, frame, *more)

    engine._render_frame = watched
    try:
        common.set_output(scene, OUT / "driven_####.exr")
        scene.frame_end = 3
        for n in (1, 2):
            data.rack_focus.views = n
            bpy.ops.render.render(animation=True)
            assert not last_message(scene), last_message(scene)
            assert seen == [2, 4, 6] and curve.driver.is_valid, seen
            seen.clear()
    finally:
        engine._render_frame = kept
    variable.targets[0].data_path = '["nowhere"]'
    bpy.ops.render.render()
    assert "driver" in last_message(scene), last_message(scene)


@check
def a_file_whose_filter_fails():
    """For the tests: a panorama cannot be filtered."""
    scene, data = start()
    data.type = "PANO"
    common.set_output(scene, OUT / "fails.exr")
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "fails.blend"), copy=True)
    preferences = bpy.context.preferences.addons[common.MODULE].preferences
    assert not preferences.is_strict and not addon("failures").is_strict()
    preferences.is_strict = True
    assert addon("failures").is_strict()
    preferences.is_strict = False
    bpy.ops.wm.save_userpref()


# ---- libraries --------------------------------------------------------------------


def linked(path, kind):
    """A scene without a camera that links the library's camera or collection."""
    bpy.ops.wm.open_mainfile(filepath=str(BASE))
    scene = bpy.context.scene
    bpy.data.objects.remove(scene.camera)
    with bpy.data.libraries.load(path, link=True) as (_, found):
        if kind == "collection":
            found.collections = ["Set"]
        else:
            found.objects = ["Camera"]
    item = found.collections[0] if kind == "collection" else found.objects[0]
    if kind == "collection":
        scene.collection.children.link(item)
    else:
        scene.collection.objects.link(item)
    return scene, item


@check
def library_overrides():
    """Every property can be overridden, and is there when the file opens again."""
    scene, data = start(method="scatter")
    collection = bpy.data.collections.new("Set")
    scene.collection.children.link(collection)
    collection.objects.link(scene.camera)
    scene.collection.objects.unlink(scene.camera)
    path = str(OUT / "set.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    for kind in ("collection", "camera"):
        scene, item = linked(path, kind)
        if kind == "collection":
            own = item.override_hierarchy_create(scene, scene.view_layers[0])
            camera = next(o for o in own.all_objects if o.type == "CAMERA")
        else:
            camera = item.override_create(remap_local_usages=True)
        data = camera.data
        if data.override_library is None:
            data = camera.data.override_create(remap_local_usages=True)
            camera.data = data
        scene.camera = camera
        values = changed_values(data.rack_focus)
        for name, value in values.items():
            setattr(data.rack_focus, name, value)
        # Of two bits more than a property has, the property's.
        values = {name: getattr(data.rack_focus, name) for name in values}
        data.override_library.operations_update()
        for name in values:
            assert data.rack_focus.is_property_overridable_library(name), name
        reopen(f"override_{kind}")
        scene = bpy.context.scene
        data = scene.camera.data
        assert data.override_library is not None, kind
        found = {name: getattr(data.rack_focus, name) for name in values}
        assert found == values, (kind, found, values)
        data.rack_focus.quality, data.rack_focus.method = "normal", "layered"
        data.rack_focus.views = data.rack_focus.supersample = 1
        data.rack_focus.use_finish = data.rack_focus.use_aperture_image = False
        data.rack_focus.highlight_clamp = 0
        for name in ("highlight_gain", "front_blur", "back_blur"):
            setattr(data.rack_focus, name, 1)
        assert addon("setup").filter_scene_of(scene) is not None
        same(rgba(render(scene, OUT / "override.exr")), expected(scene))


def changed_values(settings):
    """{name: a value that is not the present one} of the plain properties."""
    values = {}
    for about in settings.bl_rna.properties:
        name = about.identifier
        if about.is_readonly or about.is_hidden or name in ("name", "enabled"):
            continue
        if name.startswith("has_"):  # another way to set a number
            continue
        now = getattr(settings, name)
        if about.type == "BOOLEAN":
            values[name] = not now
        elif about.type == "ENUM":
            items = [item.identifier for item in about.enum_items]
            values[name] = items[(items.index(now) + 1) % len(items)]
        elif about.type in ("INT", "FLOAT"):
            step = 1 if about.type == "INT" else 0.25
            low = max(now - step, about.hard_min)
            values[name] = now + step if now + step <= about.hard_max else low
        elif about.type == "STRING":
            values[name] = "//somewhere"
    assert len(values) > 20
    return values


@check
def renders_that_succeed():
    """For the tests: nothing that they print between the marks looks like an error."""
    print("QUIET BEGIN", flush=True)
    for settings in ({}, {"method": "views", "views": 3}, {"supersample": 2}):
        bpy.ops.wm.open_mainfile(filepath=str(BASE))
        scene, data = start(**settings)
        common.set_output(scene, OUT / "quiet_####.exr")
        scene.frame_start, scene.frame_end = 1, 2
        bpy.ops.render.render(animation=True)
        scene.frame_set(2)  # that of the last render: Blender goes back to the first
        bpy.ops.rack_focus.refocus()
        assert not last_message(scene), last_message(scene)
        data.rack_focus.enabled = False
        bpy.context.view_layer.update()
    print("QUIET END", flush=True)


# ---- what is left behind ----------------------------------------------------------


@check
def the_cameras_own_switch_does_not_flip():
    """It is on while the picture is filtered, and the passes are sharp all the same."""
    scene, data = start()
    data.dof.use_dof = True
    engine, seen = addon("engine").RackFocusEngine, []
    kept = engine._render_frame

    def watched(self, *args):
        seen.append(data.dof.use_dof)
        return kept(self, *args)

    engine._render_frame = watched
    try:
        made = rgba(render(scene, OUT / "flip.exr"))
    finally:
        engine._render_frame = kept
    assert seen == [True]
    same(made, expected(scene))


@check
def an_animated_switch():
    """Depth of Field with keyframes: the passes are sharp all the same."""
    scene, data = start()
    data.dof.use_dof = True
    data.dof.keyframe_insert("use_dof", frame=1)
    made = rgba(render(scene, OUT / "flip.exr"))
    data.dof.animation_data_clear() if hasattr(data.dof, "animation_data_clear") else 0
    data.animation_data_clear()
    same(made, expected(scene))


@check
def a_renamed_scene():
    """The filter scene follows; no OLD name is left."""
    scene, _ = start()
    scene.name = "New"
    addon("handlers").on_change()
    assert scene.rack_focus.filter_scene.name == "New Rack Focus"
    scene.name = "N" * 63
    for _ in range(3):
        addon("handlers").on_change()
    name = scene.rack_focus.filter_scene.name
    assert name.startswith("N" * 40), name


@check
def the_new_node_covers_none():
    """An artist's node lies where ours would be."""
    scene = bpy.context.scene
    tree, _ = addon("compat").start_compositor(scene)
    source = addon("setup").layer_nodes(tree, scene)[0]
    x, y = source.location
    for drop in (0, 300, 500, 700):
        node = tree.nodes.new("CompositorNodeBlur")
        node.location = (x + 30, y - 250 - drop)
    start()
    ours = addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]
    box = addon("layout").box_of
    left, right, bottom, top = box(ours)
    for node in tree.nodes:
        if node != ours:
            a, b, c, d = box(node)
            assert a >= right or b <= left or c >= top or d <= bottom, node.name


def users():
    """{kind and name: number of users} of all datablocks, our images aside."""
    found = {}
    for kind in common.KINDS:
        for item in getattr(bpy.data, kind):
            if kind != "images":
                found[kind, item.name] = item.users
    return found


@check
def ticked_and_unticked_leaves_the_users():
    """Every datablock has the users that it had; a render in between or not."""
    for is_rendered in (False, True):
        for views in (1, 3):
            bpy.ops.wm.open_mainfile(filepath=str(BASE))
            scene = bpy.context.scene
            before = users()
            _, data = start(views=views)
            if is_rendered:
                render(scene, OUT / "users.exr")
            data.rack_focus.enabled = False
            bpy.context.view_layer.update()
            after = users()
            other = {k: (before.get(k), after.get(k)) for k in {*before, *after}}
            other = {k: v for k, v in other.items() if v[0] != v[1]}
            if is_rendered and views > 1 and common.V < (4, 5, 0):
                # Blender counts twice what a copied scene uses, until the file opens.
                counted = ("objects", "collections", "worlds")
                other = {k: v for k, v in other.items() if k[0] not in counted}
            assert not other, (is_rendered, views, other)


@check
def copies_and_deletions_leave_nothing():
    """A copied scene and camera, deleted again, and a purge."""
    scene, data = start()
    before = common.counts()
    for _ in range(2):
        copy = scene.copy()
        addon("handlers").on_change()
        assert addon("setup").filter_scene_of(copy) not in (
            None,
            scene.rack_focus.filter_scene,
        )
        addon("compat").remove_scene(copy)
        addon("handlers").on_change()
        addon("setup").remove_orphans()
    camera = scene.camera.copy()
    camera.data = data.copy()
    bpy.data.objects.remove(camera)
    bpy.data.orphans_purge(do_recursive=True)
    assert common.counts() == before, (before, common.counts())
    same(rgba(render(scene, OUT / "copies.exr")), expected(scene))


@check
def an_appended_scene():
    """With its set-up: it renders filtered, and unticking leaves the file as it was."""
    scene, _ = start()
    wanted = expected(scene)
    path = str(OUT / "appended.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.open_mainfile(filepath=str(BASE))
    with bpy.data.libraries.load(path, link=False) as (_, found):
        found.scenes = ["Scene"]
    added = found.scenes[0]
    addon("handlers").on_change()
    made = rgba(render(added, OUT / "appended.exr"))
    assert not last_message(added), last_message(added)
    same(made, wanted)
    added.camera.data.rack_focus.enabled = False
    addon("handlers").on_change()
    names = sorted(s.name for s in bpy.data.scenes)
    assert names == sorted(["Scene", added.name]), names


@check
def folders_of_dead_blenders():
    """What holds its lock stays; unlocked and old ones go."""
    passes, parent = addon("passes"), OUT / "shm"
    shutil.rmtree(parent, ignore_errors=True)
    parent.mkdir()
    old, new, dead, other = (
        parent / f"rack_focus_{name}" for name in ("old", "new", "dead", "x")
    )
    for folder in (old, new, dead):
        folder.mkdir()
        (folder / "passes.exr").write_bytes(b"x")
    (dead / passes.LOCK).touch()
    other.write_bytes(b"a file")
    long_ago = time.time() - 2 * passes.WITHOUT_LOCK_S
    os.utime(old, (long_ago, long_ago))
    with passes.own_folder(parent) as alive:
        # A lock counts for other processes and other open files alike.
        passes.clear_dead_folders(parent)
        assert sorted(parent.iterdir()) == sorted([alive, new, other])
    assert not alive.exists()


class Locks:
    """Stands for Windows's msvcrt: one process at a time holds a file's first byte."""

    LK_NBLCK = 2
    held = {}

    def locking(self, number, how, n_bytes):
        assert (how, n_bytes) == (self.LK_NBLCK, 1)
        inode, owner = os.fstat(number).st_ino, self.held.get(os.fstat(number).st_ino)
        if owner is not None and Path(f"/proc/self/fd/{owner}").exists():
            raise PermissionError
        self.held[inode] = number


@check
def folders_on_windows():
    """Without fcntl and mapped files: locked, cleared, removed all the same."""
    passes, exr, parent = addon("passes"), addon("exr"), OUT / "shm"
    shutil.rmtree(parent, ignore_errors=True)
    parent.mkdir()
    kept = passes.fcntl, exr.CAN_MAP
    passes.fcntl, passes.msvcrt, exr.CAN_MAP = None, Locks(), False
    try:
        with passes.own_folder(parent) as alive:
            passes.clear_dead_folders(parent)
            assert alive.exists()
            path = alive / "a.exr"
            plane = np.arange(6, dtype=np.float32).reshape(2, 3)
            exr.write_exr(path, {"Z": plane}, b"")
            read = next(iter(exr.read_exr(path).values()))
        assert np.array_equal(read, plane) and not alive.exists()
        scene, _ = start()
        made = rgba(render(scene, OUT / "w.exr"))
        assert not last_message(scene), last_message(scene)
    finally:
        passes.fcntl, exr.CAN_MAP = kept
    same(made, expected(scene))


@check
def composited_on_the_gpu():
    """4.5 ends where a node shows a scene that is set to it, as the views' copy was."""
    scene, _ = start(method="views", views=3)
    made = rgba(render(scene, OUT / "cpu.exr"))
    if hasattr(scene.render, "compositor_device"):  # from 4.2 on
        scene.render.compositor_device = "GPU"
        same(rgba(render(scene, OUT / "gpu.exr")), made)
        assert scene.render.compositor_device == "GPU"


checking.run(check, "farm_results.json")
