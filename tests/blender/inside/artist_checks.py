# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of what an artist sees and sets, run inside Blender.

artist_checks.py DIST OUT [CHECK ...]    writes OUT/artist_results.json
"""

import contextlib
import importlib.util
import io
import math
import os
import re
import shutil
import sys
import types
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import (  # noqa: E402
    BASE,
    OUT,
    Checks,
    key_focus,
    show_slot,
    update,
    while_it_renders,
)
from common import (  # noqa: E402
    addon,
    filtered,
    pinhole,
    render,
    rgba,
    same,
    start,
)

check = Checks()
NOTHING = 1e9  # depth, from which on nothing was hit
NOT_BLENDERS = re.compile(r"--|POV|command|option -|\bYu\b|thesis|paper|\d{4}\)")


def passes_of(scene):
    """(colour, depth) of the scene's render through a pinhole."""
    channels = pinhole(scene, OUT / "a_passes.exr")
    return rgba(channels, "ViewLayer"), common.depth_of(channels)


def result(scene):
    """The picture as it stands."""
    return common.result(scene, OUT / "a_result.exr")


# ---- words ------------------------------------------------------------------------


@check
def tooltips_are_blenders_own():
    """No word of the command line, of other programs or of papers, and none missing."""
    words, props = addon("words"), addon("props")
    library = addon("library").rackfocus
    assert {m.name for m in library.methods()} == set(words.METHODS)
    # A look that the core has just got may still have the table's words.
    fields = {p.field for p in props.method_table()}
    fields -= {p.field for p in props.look_table()}
    assert fields <= set(words.FIELDS), fields - set(words.FIELDS)
    for p in props.method_table():
        if p.type == "enum" and p.field in fields - {"method"}:
            missing = {(p.field, c.name) for c in p.choices} - set(words.CHOICES)
            assert not missing, missing
    texts = []
    camera = bpy.context.scene.camera.data.rack_focus
    for owner in (camera, bpy.context.scene.rack_focus):
        for about in owner.bl_rna.properties:
            texts.append((about.identifier, about.name, about.description))
            if about.type == "ENUM":
                texts += [
                    (i.identifier, i.name, i.description) for i in about.enum_items
                ]
    for name in dir(bpy.ops.rack_focus):
        about = getattr(bpy.ops.rack_focus, name).get_rna_type()
        texts.append((name, about.name, about.description))
    assert len(texts) > 60
    wrong = [t for t in texts if NOT_BLENDERS.search(" ".join(t[1:]))]
    assert not wrong, wrong


@check
def the_methods_up_front():
    """They are there, and stored numbers of older files mean the same methods."""
    words, props = addon("words"), addon("props")
    names = [m.name for m in addon("library").rackfocus.methods()]
    assert set(words.UP_FRONT) <= set(names)
    items = props.method_items()
    assert [item[0] for item in items[:3]] == list(words.UP_FRONT)
    assert all(names[number] == name for name, _, _, number in items)


@check
def only_what_the_method_reads():
    """Under Custom; and what is shown changes with the other options."""
    ui, library = addon("ui"), addon("library").rackfocus
    settings = bpy.context.scene.camera.data.rack_focus
    table = {p.field for p in addon("props").method_table()}
    counts = {}
    for method in (m.name for m in library.methods()):
        settings.method = method
        shown = ui.custom_fields(settings)
        values = {field: getattr(settings, field) for field in table}
        assert all(not library.why_not_read(field, **values) for field in shown)
        counts[method] = len(shown)
    assert counts["scatter"] <= 3 < counts["layered"] < len(table) - 8, counts
    settings.method, settings.blend = "box", "coc"
    assert "region_size" not in ui.custom_fields(settings)
    settings.blend = "region"
    assert "region_size" in ui.custom_fields(settings)


@check
def automatic_is_a_tick():
    """It is the field itself: 0 is automatic, and files keep their value."""
    settings = bpy.context.scene.camera.data.rack_focus
    for field, first in addon("words").AUTOMATIC.items():
        assert getattr(settings, field) == 0 and not getattr(settings, f"has_{field}")
        setattr(settings, f"has_{field}", True)
        assert getattr(settings, field) == first
        setattr(settings, field, 3)
        assert getattr(settings, f"has_{field}")
        setattr(settings, f"has_{field}", False)
        assert getattr(settings, field) == 0


@check
def lengths_have_the_scenes_unit():
    """Metres, feet or none."""
    scene, data = start()
    ui, unit = addon("ui"), scene.unit_settings
    unit.system, unit.scale_length = "METRIC", 0.01
    assert re.search(r"Sharp from [\d.]+ (c|m)m to [\d.]+ cm", text_of(scene)), text_of(
        scene
    )
    unit.system, unit.scale_length = "IMPERIAL", 1
    assert re.search(r"(ft|'|in|\")", ui.describe_focus(scene.camera, scene))
    unit.system = "NONE"
    assert re.fullmatch(r"Sharp from [\d.]+ to [\d.]+", text_of(scene)), text_of(scene)


def text_of(scene):
    """The line of the box."""
    return addon("ui").describe_focus(scene.camera, scene)


# ---- the box ----------------------------------------------------------------------


@check
def objects_are_walked_over_once():
    """The box asks for holdouts and the like in each drawing; moves change nothing."""
    scene, data = start()
    cube = next(o for o in scene.objects if o.type == "MESH")
    walked, walks = addon("walked"), []

    def n_walks(change, *values):
        change(*values)
        update()
        walked.once(walks.append, scene)
        return len(walks)

    assert n_walks(update) == 1
    assert n_walks(setattr, cube.location, "x", 2) == 1
    assert n_walks(setattr, data.dof, "focus_distance", 2) == 1
    assert n_walks(setattr, scene.camera.location, "x", 0.1) == 1
    assert n_walks(setattr, cube, "hide_render", True) == 2
    assert n_walks(setattr, cube, "is_holdout", True) == 3
    assert n_walks(setattr, cube, "rack_focus_keep_sharp", True) == 4
    assert n_walks(cube.data.materials[0].node_tree.nodes.clear) == 5
    assert n_walks(setattr, scene.view_layers[0], "use", False) == 6


# ---- look -------------------------------------------------------------------------


@check
def highlights_are_changed_before_the_blur():
    """Clamp, threshold and gain by their formulas; alpha and hue stay."""
    scene, data = start()
    colour, depth = passes_of(scene)
    settings = data.rack_focus
    settings.highlight_clamp = 0.6
    settings.highlight_threshold, settings.highlight_gain = 0.3, 2.5
    wanted = colour.copy()
    light = colour[..., :3].max(-1, keepdims=True)
    new = np.minimum(light, np.float32(0.6))
    new = np.where(new > 0.3, 0.3 + (new - 0.3) * 2.5, new)
    wanted[..., :3] *= np.where(light > 0, new / np.maximum(light, 1e-9), 1)
    made = rgba(render(scene, OUT / "a.exr"))
    same(made, filtered(scene, colour, depth))
    assert settings.has_highlight_clamp
    settings.has_highlight_clamp, settings.highlight_gain = False, 1
    assert settings.highlight_clamp == 0
    # A last bit decides here and there what is an edge or a highlight.
    off = np.abs(made - filtered(scene, wanted, depth))
    usual = np.quantile(off, 0.999)
    assert off.mean() < 1e-5 and usual < 0.005, (off.mean(), usual, off.max())
    assert np.abs(made - filtered(scene, colour, depth)).max() > 0.05


@check
def front_and_back_blur():
    """0: no CoC on that side; a part: that part of the lens's."""
    scene, data = start()
    colour, depth = passes_of(scene)
    look, focus = addon("look"), data.dof.focus_distance
    params = addon("lens").frame_parameters(
        scene.camera, data.rack_focus, scene.render, depth.shape[::-1]
    )
    made = addon("library").rackfocus.Filter(*depth.shape[::-1], **params)
    full, part = np.empty_like(depth), np.empty_like(depth)
    depth = np.minimum(depth, np.float32(1e8))
    made.coc(depth, full)
    new = look.depth(depth, (0.5, 0.25), focus, False)
    made.coc(np.ascontiguousarray(new), part)
    near, far = depth < focus - 0.01, depth > focus + 0.01
    assert near.any() and far.any()
    assert np.allclose(part[near], 0.5 * full[near], rtol=1e-3)
    assert np.allclose(part[far], 0.25 * full[far], rtol=1e-3)
    data.rack_focus.front_blur = data.rack_focus.back_blur = 0
    assert np.abs(rgba(render(scene, OUT / "a.exr")) - colour).max() < 1e-5


@check
def the_lenss_own_look():
    """Fields of the table are shown where they are read, and count in the picture."""
    scene, data = start()
    colour, depth = passes_of(scene)
    ui, settings = addon("ui"), data.rack_focus
    looks = addon("props").look_table()
    assert "blade_curvature" in [p.field for p in looks]
    data.dof.aperture_blades = 0
    assert "blade_curvature" not in ui.look_fields(settings)
    data.dof.aperture_blades = 5
    assert "blade_curvature" in ui.look_fields(settings)
    assert "blade_curvature" not in ui.custom_fields(settings)
    straight = rgba(render(scene, OUT / "a.exr"))
    for quality in ("best", "custom"):
        settings.quality, settings.blade_curvature = quality, 1
        made = rgba(render(scene, OUT / "a.exr"))
        same(made, filtered(scene, colour, depth))
        assert np.abs(made - straight).max() > 0.01
    for field in ("cat_eye", "swirl"):
        before = rgba(render(scene, OUT / "a.exr"))
        setattr(settings, field, 0.8)
        made = rgba(render(scene, OUT / "a.exr"))
        same(made, filtered(scene, colour, depth))
        assert np.abs(made - before).max() > 0.01, field
    settings.method = "box"
    assert "blade_curvature" not in ui.look_fields(settings)
    bpy.ops.rack_focus.look(name="Portrait f/1.4")
    assert settings.cat_eye == settings.swirl == settings.blade_curvature == 0
    data.dof.aperture_fstop = 1.7
    own = OUT / "rackfocus" / "looks"
    own.mkdir(parents=True, exist_ok=True)
    (own / "odd.params").write_text("swirl = 0.3\n")
    os.environ["XDG_CONFIG_HOME"] = str(OUT)
    found, wrong = addon("presets").lenses()
    del os.environ["XDG_CONFIG_HOME"]
    assert "vintage" in found and "look odd, line 1" in wrong[0]
    for name, one in addon("presets").lenses()[0].items():
        bpy.ops.rack_focus.look(name=name)
        made = {
            **settings.method_parameters(),
            "aperture_ratio": data.dof.aperture_ratio,
        }
        off = {
            f: made[f]
            for f in one.parameters
            if abs(made[f] - one.parameters[f]) > 1e-5
        }
        assert not off, (name, off)
        assert abs(data.dof.aperture_fstop - 1.7) < 1e-6
    assert {"vintage", "mirror"} <= set(addon("presets").lenses()[0])
    bpy.ops.rack_focus.look(name="Portrait f/1.4")
    assert settings.obstruction == 0
    for p in looks:
        about = settings.bl_rna.properties[p.field]
        assert (about.subtype == "ANGLE") == (p.unit == "degrees"), p.field


@check
def the_focus_of_a_tilted_lens():
    """Front and back blur are parts of the lens's blur at each place."""
    scene, data = start(tilt_y=math.radians(-2), field_curvature=0.05)
    _, depth = passes_of(scene)
    shape, look = depth.shape, addon("look")
    params = addon("lens").frame_parameters(
        scene.camera, data.rack_focus, scene.render, shape[::-1]
    )
    assert np.isclose(params["tilt_y"], -2)
    made = addon("library").rackfocus.Filter(*shape[::-1], **params)
    focus = look.focus_of(shape, params)
    assert np.ptp(focus) > 0.5
    full, part = np.empty_like(depth), np.empty_like(depth)
    depth = np.minimum(depth, np.float32(1e8))
    made.coc(depth, full)
    new = look.depth(depth, (0.5, 0.25), focus, False)
    made.coc(np.ascontiguousarray(new), part)
    wanted = np.where(full > 0, 0.25, 0.5) * full
    limit = 0.9 * made.lens.max_radius_px
    is_free = np.abs(full) < limit
    assert is_free.mean() > 0.5 and (full > 1).any() and (full < -1).any()
    assert np.allclose(part[is_free], wanted[is_free], rtol=2e-2, atol=2e-2)
    sharp = passes_of(scene)[0]
    data.rack_focus.front_blur = data.rack_focus.back_blur = 0
    assert np.abs(rgba(render(scene, OUT / "a.exr")) - sharp).max() < 1e-3


@check
def looks_and_presets():
    """Every look can be set; a preset stores what there is."""
    scene, data = start()
    presets = addon("presets")
    for name, (_, of_lens, of_settings) in presets.LOOKS.items():
        assert bpy.ops.rack_focus.look(name=name) == {"FINISHED"}
        for target, values in ((data.dof, of_lens), (data.rack_focus, of_settings)):
            for field, value in values.items():
                found = getattr(target, field)
                is_same = found == value or np.isclose(found, value)
                assert is_same, (name, field)
    try:
        assert bpy.ops.rack_focus.look(name="no such look") == {"CANCELLED"}
    except RuntimeError as error:
        assert "no look" in str(error)
    with bpy.context.temp_override(camera=data):
        paths = presets.RACK_FOCUS_OT_preset_add.preset_values.fget(None)
    named = {"dof": data.dof, "settings": data.rack_focus}
    for path in paths:
        owner, field = path.split(".")
        assert hasattr(named[owner], field), path
    assert "settings.method" in paths and "dof.aperture_fstop" in paths


@check
def an_asset_library():
    """Cameras with looks and the node, marked; used in a scene; the file is as before."""
    scene = bpy.context.scene
    folder, assets = OUT / "assets", addon("assets")
    shutil.rmtree(folder, ignore_errors=True)
    before = common.counts()
    assert bpy.ops.rack_focus.make_assets(directory=str(folder)) == {"FINISHED"}
    assert bpy.ops.rack_focus.make_assets(directory=str(folder)) == {"FINISHED"}
    assert common.counts() == before
    libraries = bpy.context.preferences.filepaths.asset_libraries
    found = [one.path for one in libraries if one.name == assets.LIBRARY]
    assert [Path(path) for path in found] == [folder], found
    catalogs = (folder / assets.CATALOGS).read_text().splitlines()[2:]
    ids = {line.split(":")[0] for line in catalogs}
    path = str(folder / assets.FILE)
    with bpy.data.libraries.load(path, assets_only=True) as (listed, got):
        assert sorted(listed.objects) == sorted(addon("presets").LOOKS), listed.objects
        assert list(listed.node_groups) == ["Rack Focus"]
        got.objects = ["Bright Bokeh f/1.8", "Landscape f/11"]
    bright, landscape = got.objects
    assert bright.asset_data.catalog_id in ids and bright.asset_data.description
    assert bright.preview is not None and tuple(bright.preview.image_size) == (128, 128)
    assert bright.data.rack_focus.highlight_gain == 3
    assert landscape.data.dof.aperture_blades == 6
    discs = assets.bokeh(bright.data), assets.bokeh(landscape.data)
    assert all(0.02 < (disc[..., 0] > 0.3).mean() < 0.9 for disc in discs)
    assert np.abs(discs[0] - discs[1]).max() > 0.3  # a disc, and six corners
    camera = scene.camera
    bright.matrix_world = camera.matrix_world
    bright.data.dof.focus_distance = camera.data.dof.focus_distance
    bright.data.rack_focus.clean_edges = False  # what filtered() makes
    bright.data.rack_focus.supersample = 1
    scene.collection.objects.link(bright)
    scene.camera = bright
    addon("handlers").on_change()
    wanted = passes_of(scene)
    made = rgba(render(scene, OUT / "a.exr"))
    assert not common.last_message(scene), common.last_message(scene)
    same(made, filtered(scene, *wanted))
    try:
        done = bpy.ops.rack_focus.make_assets(directory=str(checking.BASE))
        assert done == {"CANCELLED"}
    except RuntimeError as error:
        assert "cannot be written" in str(error)


@check
def the_focus_in_the_3d_view():
    """The cross lies on the axis in the focus plane, the frame around what is seen."""
    scene = bpy.context.scene
    camera, gizmo = scene.camera, addon("gizmo")
    data = camera.data
    camera.scale = (2, 2, 2)
    for kind in ("PERSP", "ORTHO"):
        data.type, data.shift_x, data.dof.focus_distance = kind, 0.1, 4
        bpy.context.view_layer.update()
        axis, cross, frame = gizmo.matrices(camera, scene)
        base = gizmo.without_scale(camera.matrix_world)
        assert np.allclose(cross.to_translation(), base @ axis_point(4), atol=1e-5)
        assert np.allclose(axis @ axis_point(-4), base @ axis_point(4), atol=1e-5)
        seen = [camera_view(scene, camera, frame @ corner(x)) for x in (-1, 1)]
        assert np.allclose([s[0] for s in seen], [0, 1], atol=1e-3), seen
        assert np.allclose([s[1] for s in seen], [0, 1], atol=1e-3), seen


def axis_point(distance):
    """On the camera's axis."""
    return Vector((0, 0, -distance))


def corner(side):
    """Of the unit frame."""
    return Vector((side, side, 0))


def camera_view(scene, camera, place):
    """Fractions of the picture; Blender's own function counts the scale."""
    kept = camera.scale.copy()
    camera.scale = (1, 1, 1)
    bpy.context.view_layer.update()
    found = world_to_camera_view(scene, camera, place)
    camera.scale = kept
    bpy.context.view_layer.update()
    return found


# ---- refocusing -------------------------------------------------------------------


@check
def out_of_date():
    """After a change of the lens or a setting, until it is refocused or rendered."""
    scene, data = start()
    is_old = addon("refocusing").is_out_of_date
    assert not is_old(scene)  # there is no picture
    render(scene, OUT / "a.exr")
    assert not is_old(scene)
    changes = (
        (data.dof, "focus_distance", 2),
        (data.dof, "aperture_fstop", 0.5),
        (data.rack_focus, "front_blur", 0.5),
        (data.rack_focus, "method", "box"),
    )
    for owner, name, value in changes:
        before = getattr(owner, name)
        setattr(owner, name, value)
        assert is_old(scene), name
        setattr(owner, name, before)
        assert not is_old(scene), name
        setattr(owner, name, value)
        bpy.ops.rack_focus.refocus()
        assert not is_old(scene), name


@check
def progress_is_drawn_now_and_then():
    """Not at each step of a filter, whose cores the drawing takes; Esc at each."""
    engine, drawn, asked = addon("engine"), [], []
    about = types.SimpleNamespace(
        doing="",
        next_update_s=engine.UPDATE_S,
        update_stats=lambda *_: None,
        update_progress=drawn.append,
        _is_stopped=lambda: asked.append(1),
    )
    steps = range(1, 1001)  # a millisecond each
    kept, now = engine.time, iter([step / 1000 for step in steps])
    engine.time = types.SimpleNamespace(perf_counter=lambda: next(now))
    try:
        for step in steps:
            engine.RackFocusEngine._report(about, step / 1000)
    finally:
        engine.time = kept
    assert drawn == [0.5, 1.0] and len(asked) == 1000, (drawn, len(asked))


@check
def a_refocus_that_is_late_shows_the_sharp_picture():
    """A window waits for it, as the box is ticked: not for longer than is allowed."""
    scene, _ = start()
    blurred = rgba(render(scene, OUT / "a.exr"))
    engine, refocusing = addon("engine"), addon("refocusing")
    with refocusing.within(0):
        bpy.ops.rack_focus.refocus()
    assert engine.last_run[scene.name]["message"] == engine.LATE
    assert np.abs(result(scene) - blurred).max() > 0.1
    bpy.ops.rack_focus.refocus()
    assert not engine.last_run[scene.name]["message"]
    same(result(scene), blurred)


@check
def overlays_are_shown_by_a_refocus_only():
    """Focus and CoC in the picture's place; a render is the picture again."""
    scene, data = start()
    picture = rgba(render(scene, OUT / "a.exr"))
    seen = {}
    for show in ("focus", "coc", "picture"):
        assert bpy.ops.rack_focus.show(show=show) == {"FINISHED"}
        seen[show] = result(scene)
    same(seen["picture"], picture)
    assert np.abs(seen["focus"] - picture).max() > 0.1
    assert np.abs(seen["coc"] - seen["focus"]).max() > 0.1
    bpy.ops.rack_focus.show(show="coc")
    same(rgba(render(scene, OUT / "a.exr")), picture)


def look_back(*_):
    """An artist looks at an earlier picture while a render runs."""
    show_slot(0)


@check
def another_slot_is_shown():
    """During a render and before a refocus: what was rendered last is filtered."""
    scene, data = start()
    cubes = [item for item in scene.objects if item.type == "MESH"]
    for settings in ({"views": 1}, {"method": "views", "views": 3}):
        for name, value in settings.items():
            setattr(data.rack_focus, name, value)
        wanted = rgba(render(scene, OUT / "a.exr"))
        show_slot(0)
        for cube in cubes:
            cube.hide_render = True
        earlier = rgba(render(scene, OUT / "a.exr"))
        for cube in cubes:
            cube.hide_render = False
        show_slot(1)
        bpy.app.handlers.render_pre.append(look_back)
        try:
            same(rgba(render(scene, OUT / "a.exr")), wanted)
        finally:
            bpy.app.handlers.render_pre.remove(look_back)
        slots = show_slot(2)
        bpy.ops.rack_focus.refocus()
        assert slots.active_index == 2
        same(result(scene), wanted)
        for number, picture in enumerate((earlier, wanted)):
            show_slot(number)
            same(result(scene), picture)


@check
def another_slot_is_shown_with_a_node_on_an_image():
    """The slot that is shown keeps its picture while nodes are run by themselves."""
    scene = bpy.context.scene
    tree, layers, _ = checking.tree_with_output(scene)
    tree.nodes.active = layers
    bpy.ops.rack_focus.add_picture_node()
    earlier = rgba(render(scene, OUT / "a.exr"))
    show_slot(1)
    scene.camera.data.dof.focus_distance = 2
    bpy.app.handlers.render_pre.append(look_back)
    try:
        later = rgba(render(scene, OUT / "a.exr"))
    finally:
        bpy.app.handlers.render_pre.remove(look_back)
    assert np.abs(later - earlier).max() > 0.1
    for number, picture in enumerate((earlier, later)):
        show_slot(number)
        same(result(scene), picture)


@check
def a_comparison_leaves_the_slots():
    """Its two renders take the picture of no slot."""
    scene, data = start()
    pictures = []
    for number in (0, 1):
        data.dof.focus_distance = 2 + number
        pictures.append(rgba(render(scene, OUT / "a.exr")))
        show_slot(1)
    show_slot(0)
    bpy.ops.rack_focus.compare(percentage=50, samples=1)
    for number, picture in enumerate(pictures):
        show_slot(number)
        same(result(scene), picture)


@check
def picks_in_an_earlier_slot():
    """Told, since its depth is not known; a refocus has that of its render in any slot."""
    scene, data = start()
    render(scene, OUT / "a.exr")
    show_slot(1)
    for cube in [item for item in scene.objects if item.type == "MESH"]:
        cube.location.y += 3
    render(scene, OUT / "a.exr")
    depth = addon("passes").rendered(scene).layer("ViewLayer").depth
    row, column = np.argwhere(depth < NOTHING)[0]
    place = {"x": (column + 0.5) / 72, "y": 1 - (row + 0.5) / 48, "refocus": False}
    show_slot(2)
    bpy.ops.rack_focus.refocus()
    bpy.ops.rack_focus.compare(percentage=50, samples=1)
    for number, is_last in enumerate((False, True, True, False)):
        show_slot(number)
        data.dof.focus_distance, told = 100, ""
        try:
            bpy.ops.rack_focus.pick_focus(**place)
        except RuntimeError as error:
            told = str(error)
        wanted = depth[row, column] if is_last else 100
        assert abs(data.dof.focus_distance - wanted) < 1e-3, (number, told)
        assert is_last or "show “Slot " in told, (number, told)
    render(scene, OUT / "a.exr")
    assert bpy.ops.rack_focus.pick_focus(**place) == {"FINISHED"}


@check
def unticked_while_it_renders():
    """What the render needs stays until its end; what became of the picture is told."""
    scene, data = start(method="views")
    for views in (1, 3):
        data.rack_focus.views = views
        wanted = rgba(render(scene, OUT / "a.exr"))
        with checking.heard() as said:
            while_it_renders(scene, lambda: setattr(data.rack_focus, "enabled", False))
        assert "unticked during this render" in said.getvalue(), said.getvalue()
        addon("handlers").on_change()
        assert len(bpy.data.scenes) == 1, list(bpy.data.scenes)
        data.rack_focus.enabled = True
        same(rgba(render(scene, OUT / "a.exr")), wanted)
        assert not common.last_message(scene), common.last_message(scene)


@check
def a_scene_that_is_renamed_while_it_renders():
    """Its picture is that of before, and nothing of the render stays behind."""
    if bpy.app.version < (4, 5, 0):
        return  # Blender finds its own render by the name of the scene
    scene, _ = start(method="views", views=3)
    wanted = rgba(render(scene, OUT / "a.exr"))
    same(while_it_renders(scene, lambda: setattr(scene, "name", "Other")), wanted)
    assert not common.last_message(scene), common.last_message(scene)
    assert len(bpy.data.scenes) == 2, list(bpy.data.scenes)
    assert not addon("running").is_any(), addon("running").scenes
    same(rgba(render(scene, OUT / "a.exr")), wanted)


@check
def picks_set_keyframes():
    """A focus pull from two picks."""
    scene, data = start()
    _, depth = passes_of(scene)
    render(scene, OUT / "a.exr")
    height, width = depth.shape
    wanted = []
    for frame, near in ((1, True), (5, False)):
        scene.frame_set(frame)
        row, column = np.argwhere(depth < 2 if near else (depth > 5) & (depth < 99))[0]
        x, y = (column + 0.5) / width, 1 - (row + 0.5) / height
        bpy.ops.rack_focus.pick_focus(x=x, y=y, keyframe=True, refocus=False)
        wanted.append((frame, float(depth[row, column])))
    curve = next(iter(common.curves_of(data)))
    assert curve.data_path == "dof.focus_distance"
    found = [tuple(point.co) for point in curve.keyframe_points]
    assert np.allclose(found, wanted), (found, wanted)


def drive_focus(data):
    """A driver of a camera's focus distance."""
    data.driver_add("dof.focus_distance").driver.expression = "3.0"


@check
def picks_that_do_not_stay_are_told():
    """Keyframes and drivers count, and what is linked is not saved."""
    for spoil, words in (
        (lambda data: None, ""),
        (lambda data: key_focus(data, {1: 3, 9: 3}), "has keyframes"),
        (drive_focus, "has a driver"),
    ):
        for is_auto in (False, True):
            bpy.ops.wm.open_mainfile(filepath=str(BASE))
            scene, data = start()
            spoil(data)
            render(scene, OUT / "a.exr")
            depth = addon("passes").rendered(scene).layer("ViewLayer").depth
            row, column = np.argwhere((depth > 5) & (depth < 99))[0]
            scene.tool_settings.use_keyframe_insert_auto = is_auto
            told = io.StringIO()
            with contextlib.redirect_stdout(told):
                bpy.ops.rack_focus.pick_focus(
                    x=(column + 0.5) / 72, y=1 - (row + 0.5) / 48
                )
            stays = abs(data.dof.focus_distance - depth[row, column]) < 1e-3
            is_keyed = is_auto and words == "has keyframes"
            assert stays == (not words or is_keyed), (words, data.dof.focus_distance)
            assert ("Focus at" in told.getvalue()) == stays, told.getvalue()
            assert stays or words in told.getvalue(), told.getvalue()


@check
def views_are_chosen_with_the_method():
    """Views of one view would be no views; what was set stays."""
    settings = bpy.context.scene.camera.data.rack_focus
    settings.method = "views"
    assert settings.views == addon("props").FIRST_VIEWS
    settings.views = 3
    settings.method = "accumulate"
    assert settings.views == 3


@check
def drivers_and_keyframes_of_settings():
    """They count in the frame that is rendered, as those of the camera do."""
    scene, data = start()
    colour, _ = passes_of(scene)
    curve = data.driver_add("rack_focus.back_blur")
    curve.driver.expression = "0.0 if frame > 5 else 1.0"
    data.rack_focus.front_blur = 1
    data.rack_focus.keyframe_insert("front_blur", frame=1)
    data.rack_focus.front_blur = 0
    data.rack_focus.keyframe_insert("front_blur", frame=10)
    blurred = {}
    for frame in (1, 10):
        scene.frame_set(frame)
        made = rgba(render(scene, OUT / "a.exr"))
        blurred[frame] = float(np.abs(made - colour).max())
    assert blurred[10] < 1e-5 < 0.1 < blurred[1], blurred


@check
def folders_beside_the_file():
    """// is the folder of the file, for the kept passes."""
    scene, data = start(passes_folder="//beside")
    folder = OUT / "relative"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "file.blend"))
    render(scene, OUT / "a.exr")
    assert [p.name for p in (folder / "beside").iterdir()] == ["passes0001.exr"]
    bpy.ops.wm.open_mainfile(filepath=str(folder / "file.blend"))
    scene = bpy.context.scene
    scene.camera.data.dof.focus_distance = 1.6
    assert bpy.ops.rack_focus.refocus() == {"FINISHED"}
    assert not common.last_message(scene)


@check
def a_folder_beside_a_file_that_is_not_saved():
    """The picture is filtered, nothing is kept where Blender runs, and that is told."""
    bpy.ops.wm.read_homefile()
    common.set_up_cycles(bpy.context.scene)
    bpy.context.scene.render.resolution_percentage = 2
    scene, _ = start(passes_folder="//beside")
    with contextlib.suppress(RuntimeError):  # a render that has something to say
        bpy.ops.render.render()
    said = common.last_message(scene)
    assert "not saved yet: save it" in said and "not filtered" not in said, said
    assert not Path("beside").exists()


@check
def the_tutorial():
    """The steps of docs/blender.md with the file that its script makes."""
    path = Path(__file__).parents[3] / "docs" / "make_blender_sample.py"
    spec = importlib.util.spec_from_file_location("make_blender_sample", path)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    script.main(os.path.relpath(OUT / "rack_focus_sample.blend"))  # as it is pasted
    bpy.ops.wm.open_mainfile(filepath=str(OUT / "rack_focus_sample.blend"))
    scene = bpy.context.scene
    assert len([o for o in scene.objects if o.type == "MESH"]) == 28
    scene.render.resolution_x, scene.render.resolution_y = 96, 54
    common.set_up_cycles(scene, 4)
    scene, data = start()
    first = rgba(render(scene, OUT / "a.exr"))
    bpy.ops.rack_focus.pick_focus(object="near")
    assert data.dof.focus_object.name == "near"
    second = result(scene)
    assert np.abs(first - second).max() > 0.05
    bpy.ops.rack_focus.look(name="Bright Bokeh f/1.8")
    data.dof.aperture_fstop = 0.2
    bpy.ops.rack_focus.refocus()
    assert np.abs(result(scene) - second).max() > 0.05
    bpy.context.scene.camera.data.rack_focus.method = "views"
    render(scene, OUT / "a.exr")
    assert len(addon("passes").rendered(scene).views("ViewLayer")) == 8


checking.run(check, "artist_results.json")
