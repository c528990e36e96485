# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of what is around the picture: refocus, picker, comparison, set-up, cost."""

import contextlib
import json
import math
import os
import shutil
from pathlib import Path
from unittest.mock import Mock, patch

import bpy
import common
import numpy as np
import round_trip
from checking import BASE, DIST, OUT, Checks, heard, shot, update
from common import (
    addon,
    filtered,
    pinhole,
    render,
    rgba,
    same,
    snapshot,
    start,
)

check = Checks()
DRAFT = {"quality": "custom", "sub_apertures": 1, "exact_highlights": False}


# ---- refocus, picker, comparison --------------------------------------------------


@check
def refocus_does_not_render():
    """The same picture as rendering again, without rendering again."""
    scene, data = start()
    render(scene, OUT / "r0.exr")
    data.dof.focus_distance = 1.6
    data.dof.aperture_blades = 5
    scene.cycles.seed = 99  # a new render would differ
    for _ in range(2):
        assert bpy.ops.rack_focus.refocus() == {"FINISHED"}
    assert not any(node.mute for node in common.tree_of(scene).nodes)
    bpy.data.images["Render Result"].save_render(str(OUT / "r1.exr"), scene=scene)
    made = rgba(common.read(OUT / "r1.exr"))
    scene.cycles.seed = 0
    same(made, rgba(render(scene, OUT / "r2.exr")))


@check
def pick_focus():
    """A point of the picture, an object, the empty sky."""
    scene, data = start()
    sharp = render(scene, OUT / "k.exr")
    sharp = pinhole(scene, OUT / "k0.exr")
    depth = common.depth_of(sharp)
    render(scene, OUT / "k.exr")
    height, width = depth.shape
    row, column = np.argwhere(depth < 2)[3]
    x, y = (column + 0.5) / width, 1 - (row + 0.5) / height
    bpy.ops.rack_focus.pick_focus(x=x, y=y)
    assert math.isclose(data.dof.focus_distance, depth[row, column], rel_tol=1e-6)
    row, column = np.argwhere(depth > 1e9)[0]
    x, y = (column + 0.5) / width, 1 - (row + 0.5) / height
    assert bpy.ops.rack_focus.pick_focus(x=x, y=y) == {"CANCELLED"}
    cube = next(o for o in scene.objects if o.type == "MESH")
    bpy.ops.rack_focus.pick_focus(object=cube.name)
    assert data.dof.focus_object == cube


@check
def compare_with_physical():
    """Scores and three images; nothing else is left, and no node of ours runs."""
    scene, data = start()
    bpy.ops.rack_focus.add_picture_node()
    render(scene, OUT / "a.exr")
    before, run = counts_without_images(), addon("engine").last_run[scene.name]
    bpy.ops.rack_focus.compare(percentage=100, samples=64)
    assert counts_without_images() == before
    assert addon("engine").last_run[scene.name] is run
    sizes = [tuple(bpy.data.images[n].size) for n in addon("compare").NAMES]
    assert sizes == [(72, 48)] * 3
    read = {}
    for name in addon("compare").NAMES[:2]:
        flat = np.empty(72 * 48 * 4, np.float32)
        bpy.data.images[name].pixels.foreach_get(flat)
        read[name] = flat.reshape(48, 72, 4)
    # Blender's images have their rows upwards.
    pictures = (np.ascontiguousarray(p[::-1]) for p in read.values())
    scores = addon("library").rackfocus.compare(*pictures)
    assert addon("compare").last_scores == scores
    assert 24 < scores["tpsnr"] < 60, scores
    (OUT / "scores.json").write_text(json.dumps(scores))


def counts_without_images():
    """Datablocks but for images."""
    return {k: n for k, n in common.counts().items() if k != "images"}


# ---- set-up and its end -----------------------------------------------------------


@check
def disable_leaves_nothing():
    """Fresh compositor: the same datablocks, nodes, links and switches as before."""
    scene = bpy.context.scene
    before = snapshot(scene)
    start()
    assert snapshot(scene) != before
    render(scene, OUT / "x.exr")
    scene.camera.data.rack_focus.enabled = False
    after = snapshot(scene)
    images = bpy.data.images.get("Render Result") is not None
    after[0]["images"] -= images and before[0]["images"] != after[0]["images"]
    assert after == before, (before, after)


def emptied(scene, is_in_use):
    """An empty compositor tree; 5.0: a node group without nodes."""
    tree, _ = addon("compat").start_compositor(scene)
    tree.nodes.clear()
    if not is_in_use:
        scene.render.use_compositing = False  # 5.0 opens older files so
    if not is_in_use and common.V < (5, 0, 0):
        scene.use_nodes = False
    return tree


@check
def an_empty_tree():
    """In use or not: the picture is filtered, and what was added goes again."""
    for is_in_use in (False, True):
        bpy.ops.wm.open_mainfile(filepath=str(BASE))
        scene = bpy.context.scene
        sharp = pinhole(scene, OUT / "empty_passes.exr")
        emptied(scene, is_in_use)
        before = snapshot(scene)
        _, data = start()
        made = rgba(render(scene, OUT / "empty.exr"))
        assert not common.last_message(scene), common.last_message(scene)
        wanted = filtered(scene, rgba(sharp, "ViewLayer"), common.depth_of(sharp))
        same(made, wanted)
        data.rack_focus.enabled = False
        after = snapshot(scene)
        before[0]["images"] = after[0]["images"]
        assert after == before, (before, after)


FILES = OUT / "asleep"
TWO = "Two"


def with_old_nodes(scene):
    """Nodes of an artist: a flip, a File Output, a Viewer, an output without alpha, another scene."""
    two = scene.copy()
    two.name = TWO
    addon("compat").drop_compositor(two)
    tree, _ = addon("compat").start_compositor(scene)
    source, links = addon("setup").layer_nodes(tree, scene)[0], tree.links
    flip = tree.nodes.new("CompositorNodeFlip")
    if "Flip X" in flip.inputs:  # 4.5 and later
        flip.inputs["Flip X"].default_value = True
    out = addon("compat").output_socket(tree)
    links.new(source.outputs["Image"], flip.inputs[0])
    links.new(flip.outputs[0], out)
    over, below, above = addon("compat").alpha_over(tree)
    other = addon("compat").new_layer_node(tree, scene)
    other.scene = two
    links.new(other.outputs["Image"], below)
    links.new(flip.outputs[0], above)
    links.new(over.outputs[0], tree.nodes.new("CompositorNodeViewer").inputs[0])
    links.new(over.outputs[0], addon("compat").file_output(tree, FILES, "a", ["b"])[0])
    tree.nodes.new("CompositorNodeBlur").mute = True
    if "Alpha" in out.node.inputs:  # up to 4.4
        links.new(source.outputs["Alpha"], out.node.inputs["Alpha"])
        out.node.use_alpha = False
    if common.V < (5, 0, 0):
        more = tree.nodes.new("CompositorNodeComposite")
        links.new(over.outputs[0], more.inputs["Image"])
    return tree


def all_of(scene, tree):
    """What of a scene and its nodes must be the same afterwards.

    Blender hides sockets of passes that are gone when it next uses the nodes.
    """
    nodes, links = round_trip.state_of_tree(tree)
    keys = {node.name: sorted(node.keys()) for node in tree.nodes}
    nodes = [(name, values, keys[name]) for name, values, _ in nodes]
    switches = scene.render.use_compositing, len(bpy.data.node_groups)
    return round_trip.plain_values(scene), nodes, links, switches


def switch(scene, is_by_nodes, is_on):
    """Use Nodes, up to 4.5, or Post Processing > Compositing."""
    if is_by_nodes:
        scene.use_nodes = is_on
    else:
        scene.render.use_compositing = is_on


@check
def nodes_that_are_switched_off():
    """They are not in the picture, write and render nothing, and are as they were."""
    shutil.rmtree(FILES, ignore_errors=True)
    for is_by_nodes in (False, True) if common.V < (5, 0, 0) else (False,):
        for is_opened in (False, True):
            bpy.ops.wm.open_mainfile(filepath=str(BASE))
            scene = bpy.context.scene
            sharp = pinhole(scene, OUT / "asleep_passes.exr")
            name = with_old_nodes(scene).name
            switch(scene, is_by_nodes, False)
            asleep = addon("asleep")
            before = all_of(scene, asleep._tree_of(scene))
            start()
            if is_opened:
                path = str(OUT / "asleep.blend")
                bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
                bpy.ops.wm.open_mainfile(filepath=path)
                scene = bpy.context.scene
            rendered = []
            bpy.app.handlers.frame_change_pre.append(lambda s, *_: rendered.append(s))
            made = rgba(render(scene, OUT / "asleep.exr"))
            assert not common.last_message(scene), common.last_message(scene)
            assert rendered and bpy.data.scenes[TWO] not in rendered, rendered
            assert not FILES.exists(), list(FILES.glob("*"))
            colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
            same(made, filtered(scene, colour, depth))
            assert addon("setup").has_sleepers(scene)
            bpy.ops.rack_focus.refocus()
            same(common.result(scene, OUT / "asleep.exr"), made)
            scene.camera.data.rack_focus.enabled = False
            bpy.context.view_layer.update()
            tree = asleep._tree_of(scene)
            assert tree.name == name, tree.name
            after = all_of(scene, tree)
            assert after == before, round_trip.first_difference(before, after)
            bpy.app.handlers.frame_change_pre.pop()
            switch(scene, is_by_nodes, True)
            render(scene, OUT / "asleep.exr")
            assert list(FILES.glob("*"))  # what it looked for can be there
            shutil.rmtree(FILES)


@check
def nodes_that_are_switched_off_and_views():
    """Several views pass them by too."""
    scene = bpy.context.scene
    with_old_nodes(scene)
    switch(scene, False, False)
    _, data = start(views=3)
    made = rgba(render(scene, OUT / "asleep.exr"))
    assert not common.last_message(scene), common.last_message(scene)
    data.rack_focus.enabled = False
    tree = addon("asleep")._tree_of(scene)
    if common.V < (5, 0, 0):
        tree.nodes.clear()
    else:
        scene.compositing_node_group = None
    start(views=3)
    same(rgba(render(scene, OUT / "asleep.exr")), made)


@check
def a_tree_without_an_output():
    """Nodes of the artist's, but none that shows: ours is shown, and goes again."""
    scene = bpy.context.scene
    sharp = pinhole(scene, OUT / "empty_passes.exr")
    tree = emptied(scene, True)
    source = addon("compat").new_layer_node(tree, scene)
    blur = tree.nodes.new("CompositorNodeBlur")
    tree.links.new(source.outputs["Image"], blur.inputs["Image"])
    before = snapshot(scene)
    _, data = start()
    made = rgba(render(scene, OUT / "empty.exr"))
    assert not common.last_message(scene), common.last_message(scene)
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    same(made, filtered(scene, colour, depth))
    data.rack_focus.enabled = False
    after = snapshot(scene)
    before[0]["images"] = after[0]["images"]
    assert after == before, (before, after)


@check
def scenes_that_share_a_tree():
    """5.x: the other one is not rendered, and its filter has nothing to say."""
    scene = bpy.context.scene
    tree, _ = addon("compat").start_compositor(scene)
    two = scene.copy()
    two.name = "Two"
    _, data = start()
    made = rgba(render(scene, OUT / "share.exr"))
    for one in (scene, two):
        assert not addon("engine").last_run.get(one.name, {}).get("message"), one
    sharp = pinhole(scene, OUT / "share_passes.exr")
    colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
    same(made, filtered(scene, colour, depth))


@check
def view_layers_that_are_not_rendered():
    """Ours shows the first one that is, whenever that changes; the artist's stay."""
    scene = bpy.context.scene
    first, second = scene.view_layers[0], scene.view_layers.new("Second")
    first.use = False
    wanted = rgba(pinhole(scene, OUT / "vl_plain.exr"), "Second")
    _, data = start()
    for _ in range(2):
        for used, other in ((second, first), (first, second)):
            used.use, other.use = True, False
            made = shot(scene, "vl.exr")
            assert np.abs(made - wanted).mean() < 0.1, (used.name, made.mean())
        data.rack_focus.enabled = False
        first.use, second.use = False, True
        data.rack_focus.enabled = True
    tree = common.tree_of(scene)
    node = tree.nodes.new("CompositorNodeExposure")
    sources = [n for n in tree.nodes if n.type == "R_LAYERS"]
    tree.links.new(sources[0].outputs["Image"], node.inputs["Image"])
    shown = [source.layer for source in sources]
    first.use, second.use = True, False
    update()
    assert [source.layer for source in sources] == shown
    bpy.ops.wm.open_mainfile(filepath=str(BASE))
    scene = bpy.context.scene
    names = [scene.view_layers.new(name).name for name in ("Second", "Third")]
    scene.view_layers[0].use, scene.render.film_transparent = False, True
    start()
    ours = addon("setup").layer_nodes(
        common.tree_of(scene), scene.rack_focus.filter_scene
    )
    assert [node.layer for node in ours] == names


@check
def the_users_nodes_stay():
    """A compositor in use: ours goes in between and out again."""
    scene = bpy.context.scene
    tree, _ = addon("compat").start_compositor(scene)
    source = addon("setup").layer_nodes(tree, scene)[0]
    flip = tree.nodes.new("CompositorNodeFlip")
    if "Flip X" in flip.inputs:  # 4.5 and later
        flip.inputs["Flip X"].default_value = True
        flip.inputs["Flip Y"].default_value = False
    out = addon("compat").output_socket(tree)
    tree.links.new(source.outputs["Image"], flip.inputs[0])
    tree.links.new(flip.outputs[0], out)
    before = snapshot(scene)
    _, data = start()
    flipped = rgba(render(scene, OUT / "u.exr"))
    node = addon("setup").layer_nodes(tree, scene.rack_focus.filter_scene)[0]
    assert any(k.from_node == node and k.to_node == flip for k in tree.links)
    tree.links.new(node.outputs["Image"], out)
    plain = rgba(render(scene, OUT / "u.exr"))
    same(flipped, plain[:, ::-1])
    tree.links.new(flip.outputs[0], out)
    data.rack_focus.enabled = False
    after = snapshot(scene)
    assert after[1:] == before[1:], (before, after)


@check
def two_nodes_of_one_layer_get_their_own_links_back():
    """With more than one, and with several views and a file in between."""
    scene = bpy.context.scene
    tree, _ = addon("compat").start_compositor(scene)
    first = addon("setup").layer_nodes(tree, scene)[0]
    second = addon("compat").new_layer_node(tree, scene)
    second.layer = first.layer
    flip, viewer = (tree.nodes.new(f"CompositorNode{n}") for n in ("Flip", "Viewer"))
    tree.links.new(second.outputs["Image"], viewer.inputs[0])
    tree.links.new(second.outputs["Alpha"], flip.inputs[0])
    before = snapshot(scene)
    start(views=2)
    bpy.ops.render.render()
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "two.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(OUT / "two.blend"))
    scene = bpy.context.scene
    scene.camera.data.rack_focus.enabled = False
    after = snapshot(scene)
    assert after[1:] == before[1:], (before, after)


@check
def a_camera_from_a_library():
    """A linked camera, enabled in its own file: read, never changed for good."""
    scene, data = start(method="scatter")
    data.dof.use_dof = True
    library = str(OUT / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=library, copy=True)
    bpy.ops.wm.open_mainfile(filepath=str(BASE))
    scene = bpy.context.scene
    bpy.data.objects.remove(scene.camera)
    with bpy.data.libraries.load(library, link=True) as (_, linked):
        linked.objects = ["Camera"]
    camera = linked.objects[0]
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.context.view_layer.update()
    assert camera.data.library is not None and camera.data.rack_focus.enabled
    assert addon("setup").filter_scene_of(scene) is not None
    made = rgba(render(scene, OUT / "l.exr"))
    assert camera.data.dof.use_dof and not camera.data.rack_focus.is_dof_hidden
    sharp = pinhole(scene, OUT / "l.exr")
    expected = filtered(scene, rgba(sharp, "ViewLayer"), common.depth_of(sharp))
    same(made, expected)


@check
def a_scene_from_a_library():
    """It is not filtered, by itself and as a strip, and that is said; a copy is."""
    scene, data = start()
    made = rgba(render(scene, OUT / "lib1.exr"))
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "linked.blend"), copy=True)
    data.rack_focus.enabled = False
    for is_link in (True, False):
        bpy.ops.wm.open_mainfile(filepath=str(BASE))
        edit = bpy.context.scene
        edit.name, edit.view_settings.view_transform = "Edit", "Raw"
        path = str(OUT / "linked.blend")
        with bpy.data.libraries.load(path, link=is_link) as (_, target):
            target.scenes = ["Scene"]
        found = target.scenes[0]
        edit.sequence_editor_create()
        strips = edit.sequence_editor
        strips = strips.strips if hasattr(strips, "strips") else strips.sequences
        strips.new_scene("Strip", found, 1, 1)
        with heard() as said:
            shot(edit, "lib2.exr")
        words = "linked from “linked.blend” (append it"
        assert (words in said.getvalue()) == is_link, said.getvalue()
        if is_link:
            assert words in addon("setup").why_not(found)
        else:
            same(rgba(render(found, OUT / "lib3.exr")), made)


@check
def a_scene_that_loses_its_camera():
    """The set-up goes with the camera and comes back with it; nothing raises."""
    scene, _ = start()
    camera = scene.camera
    scene.camera = None
    bpy.context.view_layer.update()
    addon("handlers").on_change()
    assert addon("setup").filter_scene_of(scene) is None
    assert len(bpy.data.scenes) == 1
    for name in ("add_node", "refocus", "pick_focus", "compare"):
        assert not getattr(bpy.ops.rack_focus, name).poll(), name
    try:
        bpy.ops.render.render()
        raise AssertionError("rendered without a camera")
    except RuntimeError as error:
        assert "camera" in str(error).lower()
    scene.camera = camera
    addon("handlers").on_change()
    assert addon("setup").filter_scene_of(scene) is not None
    render(scene, OUT / "n.exr")


@check
def undo():
    """Enabling is one step back."""
    scene = bpy.context.scene
    if bpy.app.background and not hasattr(bpy.context, "window"):
        return
    bpy.ops.ed.undo_push(message="before")
    start()
    bpy.ops.ed.undo_push(message="enabled")
    assert len(bpy.data.scenes) == 2
    bpy.ops.ed.undo()
    assert len(bpy.data.scenes) == 1, [s.name for s in bpy.data.scenes]
    scene = bpy.context.scene
    assert not scene.camera.data.rack_focus.enabled
    assert addon("setup").filter_scene_of(scene) is None
    bpy.ops.ed.redo()
    scene = bpy.context.scene
    assert addon("setup").filter_scene_of(scene) is not None
    render(scene, OUT / "undo.exr")


@check
def save_and_reload():
    """The set-up lives in the file."""
    scene, data = start(method="scatter", max_radius=9)
    first = rgba(render(scene, OUT / "v0.exr"))
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "saved.blend"), copy=True)
    bpy.ops.wm.open_mainfile(filepath=str(OUT / "saved.blend"))
    scene = bpy.context.scene
    settings = scene.camera.data.rack_focus
    assert settings.enabled and settings.method == "scatter"
    assert settings.max_radius == 9
    same(rgba(render(scene, OUT / "v1.exr")), first)
    settings.enabled = False
    assert len(bpy.data.scenes) == 1


@check
def properties_come_from_the_table():
    """Every parameter of the methods, with range, default and help."""
    settings, words = bpy.context.scene.camera.data.rack_focus, addon("words")
    for p in addon("props").method_table():
        about = settings.bl_rna.properties[p.field]
        _, text = words.FIELDS.get(p.field, ("", p.help))
        assert about.description == text.rstrip("."), p.field
        value = getattr(settings, p.field)
        if p.type == "float":
            unit = math.pi / 180 if p.unit == "degrees" else 1
            assert math.isclose(value, p.default * unit, rel_tol=1e-6)
            assert math.isclose(about.hard_max, p.max * unit, rel_tol=1e-6)
        else:
            assert value == p.default
        if p.type == "enum":
            names = [item.identifier for item in about.enum_items]
            assert sorted(names) == sorted(choice.name for choice in p.choices)


@check
def ends_of_ranges():
    """Floats of Blender at both ends of each range are within the core's."""
    scene, data = start()
    settings, lens = data.rack_focus, addon("lens")
    table = [p for p in addon("props").method_table() if p.type == "float"]
    library = addon("library").rackfocus
    for end in ("hard_min", "hard_max"):
        for p in table:
            about = settings.bl_rna.properties[p.field]
            before = getattr(settings, p.field)
            setattr(settings, p.field, getattr(about, end))
            params = lens.camera_parameters(scene.camera, scene.render)
            params.update(addon("props").values_of(settings))
            library.Lens(72, 48, **params)
            setattr(settings, p.field, before)


@check
def preferences_show_version_and_cpu_level():
    """What the panel of the preferences draws."""
    drawn = []

    class Column:
        """Takes down what is drawn."""

        def prop(self, _, name):
            drawn.append(name)

        def label(self, text):
            drawn.append(text)

        def operator(self, name, **_):
            drawn.append(name)

    class Shown:
        """Stands for the preferences; Blender lets none be made."""

        class layout:
            column = Column

    addon("ui").Preferences.draw(Shown, bpy.context)
    library = addon("library").rackfocus
    assert library.cpu_level() in ("avx2", "sse4", "generic")
    assert drawn == [
        "threads",
        "denoiser",
        "is_strict",
        "has_notice",
        "rack_focus.make_assets",
        f"Version {library.version()}",
        f"CPU level in use: {library.cpu_level()}",
    ], drawn


@check
def add_node():
    """Once sets up, twice adds another node."""
    scene = bpy.context.scene
    bpy.ops.rack_focus.add_node()
    assert scene.camera.data.rack_focus.enabled
    bpy.ops.rack_focus.add_node()
    ours = scene.rack_focus.filter_scene
    assert len(addon("setup").layer_nodes(common.tree_of(scene), ours)) == 2


# ---- what the box says ------------------------------------------------------------


def hole_in(tree, light):
    """Mixes what a node gives with a Transparent BSDF; returns the Mix Shader."""
    hole = tree.nodes.new("ShaderNodeBsdfTransparent")
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(hole.outputs[0], mix.inputs[1])
    tree.links.new(light.outputs[0], mix.inputs[2])
    return mix


def flame(material):
    """Mixes the Emission of a material with Transparent."""
    tree = material.node_tree
    light = next(node for node in tree.nodes if node.type == "EMISSION")
    end = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(hole_in(tree, light).outputs[0], end.inputs["Surface"])


def flame_in_a_group(material):
    """The same within a node group."""
    inside = bpy.data.node_groups.new("flame", "ShaderNodeTree")
    hole_in(inside, inside.nodes.new("ShaderNodeEmission"))
    material.node_tree.nodes.new("ShaderNodeGroup").node_tree = inside


@check
def flames_want_a_lower_alpha_threshold():
    """The box says so where such a surface is rendered and the threshold is high."""
    for spoil in (flame, flame_in_a_group):
        bpy.ops.wm.open_mainfile(filepath=str(BASE))
        scene, data = start()

        def said(scene=scene, data=data):
            bpy.context.view_layer.update()
            return addon("shining").describe(scene, data.rack_focus)

        layer, cube = scene.view_layers[0], scene.objects["cube"]
        assert layer.pass_alpha_threshold == 0.5 and not said()
        spoil(cube.material_slots[0].material)
        first, second = said()
        assert first.startswith(f"“{cube.material_slots[0].material.name}” mixes")
        assert second.endswith("Alpha Threshold to 0.01"), second
        with heard() as told:
            addon("handlers")._prepare(scene)
        assert f"{first} {second}" in told.getvalue(), told.getvalue()
        cube.hide_render = True
        assert not said()
        cube.hide_render = False
        data.rack_focus.method = "accumulate"
        assert not said()
        data.rack_focus.method = "views"
        assert said()
        layer.pass_alpha_threshold = 0.01
        assert not said()
        layer.pass_alpha_threshold = 0.5
        # A light that throws no shadow: the camera sees no hole in it.
        for tree in addon("setup").with_groups(
            cube.material_slots[0].material.node_tree
        ):
            for mix in [n for n in tree.nodes if n.type == "MIX_SHADER"]:
                path = tree.nodes.new("ShaderNodeLightPath")
                tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
        assert not said()


@check
def another_file_does_not_have_the_last_ones_message():
    """Scenes of both files are called Scene."""
    scene, data = start()
    data.type = "PANO"
    bpy.ops.render.render()
    said = addon("operators").last_message
    assert "perspective" in said(scene), said(scene)
    bpy.ops.wm.open_mainfile(filepath=str(BASE))
    assert not said(bpy.context.scene)


# ---- cost -------------------------------------------------------------------------


@check
def many_renders():
    """Memory does not grow; nothing stays in the memory folder."""
    scene, data = start(**DRAFT)
    scene.cycles.samples = 1
    for count in range(6 if common.IS_BETWEEN else 75):
        bpy.ops.render.render()
        if count == 25:
            before = common.resident_bytes()
    if not common.IS_BETWEEN:
        grown = (common.resident_bytes() - before) / 2**20
        assert grown < 6, f"{grown:.1f} MiB in 50 renders"
    assert not common.own_memory_folders()


def refocus():
    """The operator."""
    bpy.ops.rack_focus.refocus()


@contextlib.contextmanager
def counting():
    """Counts what is costly at each use: {what: calls}."""
    engine, views, passes = addon("engine"), addon("views"), addon("passes")
    places = {
        "filter": (views, "process"),
        "build": (engine.rackfocus, "Filter"),
        "read": (addon("exr"), "read_parts"),
        "save": (passes, "MultilayerExr"),
    }
    kept = {what: getattr(owner, name) for what, (owner, name) in places.items()}
    calls = dict.fromkeys(places, 0)

    def counted(what, function):
        def call(*args, **more):
            calls[what] += 1
            return function(*args, **more)

        return call

    for what, (owner, name) in places.items():
        setattr(owner, name, counted(what, getattr(owner, name)))
    try:
        yield calls
    finally:
        for what, (owner, name) in places.items():
            setattr(owner, name, kept[what])


@check
def costly_steps_of_a_picture():
    """How often the node does what is costly; the counts go to a file."""
    scene, _ = start(**DRAFT)
    counted = {}
    for what, call in (("f12", bpy.ops.render.render), ("refocus", refocus)):
        with counting() as calls:
            call()
        counted[what] = calls
    (OUT / "costly_steps.json").write_text(json.dumps(counted))


@check
def a_folder_without_room_for_passes():
    """Another one is taken; where none has room, that is said, and the black picture."""
    scene, data = start()
    passes, full = addon("passes"), [str(OUT / "full")]
    Path(full[0]).mkdir(exist_ok=True)
    save = passes.RenderedPasses._save

    def save_half(scene, path):  # as Blender does on a full disk, without an error
        save(scene, path)
        for file in path.parent.glob("*.exr") if str(path.parents[1]) in full else ():
            os.truncate(file, file.stat().st_size // 2)

    def room(path):
        if path == gone:
            raise FileNotFoundError(path)
        return Mock(free=1e9 * (path not in full))

    gone = str(OUT / "gone")
    for data.rack_focus.views in (1, 2):
        wanted = shot(scene, "room0.exr")
        with contextlib.ExitStack() as changed:
            for owner, name, value in (
                (passes, "_parents", lambda _: [gone, full[0], passes.SHARED_MEMORY]),
                (passes.RenderedPasses, "_save", save_half),
                (shutil, "disk_usage", room),
            ):
                changed.enter_context(patch.object(owner, name, value))
            same(shot(scene, "room1.exr"), wanted)
            full.append(passes.SHARED_MEMORY)
            with heard() as said, contextlib.suppress(RuntimeError):
                shot(scene, "room2.exr")
            full.pop()
        places = f"“{gone}” and “{full[0]}”"
        assert f"no room for the passes of the render in {places}" in said.getvalue()
        assert "The picture is black" in common.last_message(scene)
    assert not common.own_memory_folders() and not list(Path(full[0]).iterdir())


# ---- installing again -------------------------------------------------------------


@check
def a_library_that_is_not_the_installed_one_leaves_the_picture_sharp():
    """Blender keeps the one that it has loaded until it is started again."""
    scene, data = start()
    data.dof.use_dof = False
    sharp = rgba(pinhole(scene, OUT / "i.exr"), "ViewLayer")
    addon("library").is_stale = True
    made = rgba(render(scene, OUT / "i.exr"))
    assert "restart" in addon("setup").why_not(scene)
    assert "restart" in addon("failures").told[scene.name]
    addon("library").is_stale = False
    same(made, sharp)


@check
def installing_over_the_running_addon():
    """3.4 wrote into the library that ran, and crashed with the next views."""
    scene, _ = start(views=2)
    expected = rgba(render(scene, OUT / "i.exr"))
    old = addon("views")
    common.install(DIST)
    assert not addon("library").is_stale
    bpy.ops.wm.open_mainfile(filepath=str(BASE))
    scene, _ = start(views=2)
    same(rgba(render(scene, OUT / "i.exr")), expected)
    assert addon("views") is not old or common.IS_EXTENSION
