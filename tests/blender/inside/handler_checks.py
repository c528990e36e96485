# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of renders that do not begin, go on or end as Blender's handlers say.

handler_checks.py DIST OUT [CHECK ...]    writes OUT/handler_results.json
"""

import contextlib
import sys
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock, patch

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import (  # noqa: E402
    BASE,
    Checks,
    heard,
    refocused,
    shot,
    update,
    while_it_renders,
)
from common import addon, last_message, same, start  # noqa: E402

check = Checks()


@contextlib.contextmanager
def cleared(*names):
    """A script takes all handlers out of some lists; those of others come back."""
    lists = [getattr(bpy.app.handlers, name) for name in names]
    kept = [list(handlers) for handlers in lists]
    for handlers in lists:
        handlers.clear()
    try:
        yield
    finally:
        for handlers, before in zip(lists, kept, strict=True):
            handlers.extend([one for one in before if one not in handlers])


def names_of_lists():
    """The lists that have handlers of ours."""
    names = [name for name, _ in addon("handlers").HANDLERS]
    return [name for name in names if hasattr(bpy.app.handlers, name)]


@check
def scripts_that_clear_handlers():
    """The lens is made once, though the camera's own is on."""
    scene, data = start()
    data.dof.use_dof = True
    wanted = shot(scene, "a.exr")
    for name in names_of_lists():
        with cleared(name):
            same(shot(scene, "a.exr"), wanted)
        assert not last_message(scene), (name, last_message(scene))
    assert not addon("running").is_any(), addon("running").scenes


@check
def scripts_that_clear_all_handlers():
    """The camera's own lens once, and told; the next render is filtered."""
    for settings in ({"views": 1}, {"method": "views", "views": 3}):
        bpy.ops.wm.open_mainfile(filepath=str(BASE))
        scene, data = start(**settings)
        data.dof.use_dof = True
        wanted = shot(scene, "a.exr")
        data.rack_focus.enabled = False
        own = shot(scene, "a.exr")
        data.rack_focus.enabled = True
        with cleared(*names_of_lists()), heard() as said:
            same(shot(scene, "a.exr"), own)
            assert "a script took the handlers" in said.getvalue(), said.getvalue()
            same(shot(scene, "a.exr"), wanted)
        assert not last_message(scene), last_message(scene)


@check
def a_film_that_cannot_be_opened():
    """Blender tells nobody of its end; ticks and changes are followed all the same."""
    scene, data = start()
    shot(scene, "a.exr")
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "VIDEO"
    scene.render.image_settings.file_format = "FFMPEG"
    scene.render.filepath = str(BASE / "film")  # no folder
    scene.frame_end = 1
    with contextlib.suppress(RuntimeError):  # 5.0 raises none
        bpy.ops.render.render(animation=True)
    data.rack_focus.enabled = False
    update()
    assert len(bpy.data.scenes) == 1, list(bpy.data.scenes)
    assert not addon("running").is_any(), addon("running").scenes


@check
def a_view_layer_that_is_renamed_while_it_renders():
    """What Blender keeps of it is filtered, and that it is lost is told."""

    def rename():
        scene.view_layers[0].name = "Other"

    for views, where in ((1, "render_pre"), (3, "render_stats"), (1, "render_stats")):
        bpy.ops.wm.open_mainfile(filepath=str(BASE))
        scene, _ = start(method="views", views=views)
        wanted = shot(scene, "a.exr")
        with heard() as said:
            made = while_it_renders(scene, rename, where)
        is_lost = views == 1 and where == "render_stats"
        assert is_lost == ("was renamed to “Other”" in said.getvalue()), said.getvalue()
        if is_lost:
            assert made.max() == 0
        else:
            same(made, wanted)
        same(shot(scene, "a.exr"), wanted)
        assert not last_message(scene), last_message(scene)


@check
def a_plain_render_between():
    """Ticked again, Refocus filters that, and no earlier one; what it shows is known."""
    scene, data = start()
    shot(scene, "a.exr")
    bpy.ops.rack_focus.refocus()
    data.rack_focus.enabled = False
    for cube in [item for item in scene.objects if item.type == "MESH"]:
        cube.location.x += 0.2
    scene.view_layers[0].use_pass_z = True
    shot(scene, "a.exr")
    data.rack_focus.enabled = True
    made = refocused(scene, "a.exr")
    assert not last_message(scene), last_message(scene)
    scene.frame_set(2)
    refocused(scene, "a.exr")
    assert "this is the render of frame 1" in last_message(scene), last_message(scene)
    scene.frame_set(1)
    scene.camera.location.x += 1
    update()
    refocused(scene, "a.exr")
    assert "has moved" in last_message(scene), last_message(scene)
    scene.camera.location.x -= 1
    same(shot(scene, "a.exr"), made)


@check
def a_plain_render_without_depth():
    """Ticked, Refocus says what to do, and shows it."""
    scene, data = start()
    shot(scene, "a.exr")
    bpy.ops.rack_focus.refocus()
    data.rack_focus.enabled = False
    plain = shot(scene, "a.exr")
    data.rack_focus.enabled = True
    same(refocused(scene, "a.exr"), plain)
    assert "without its depth: press F12" in last_message(scene), last_message(scene)


@check
def ticked_while_no_view_layer_is_in_use():
    """The one that is used later is filtered; the nodes were off."""
    scene, data = start()
    wanted = shot(scene, "a.exr")
    data.rack_focus.enabled = False
    checking.tree_with_output(scene)
    scene.render.use_compositing = False
    if common.V < (5, 0, 0):
        scene.use_nodes = False
    scene.view_layers[0].use = False
    data.rack_focus.enabled = True
    update()
    scene.view_layers[0].use = True
    update()
    same(shot(scene, "a.exr"), wanted)
    assert not last_message(scene), last_message(scene)


@check
def a_render_result_without_a_chosen_slot():
    """It is no fault of the render that begins."""

    class Slots(list):
        """Two slots, of which none is chosen."""

        active, active_index = None, 0

    scene, _ = start()
    slots = addon("slots")
    image = SimpleNamespace(render_slots=Slots([Mock(), Mock()]))
    with patch.object(slots, "render_result", lambda: image):
        slots.note(scene)
        assert not slots.why_not_last(scene)


@check
def a_tick_that_was_put_off():
    """Once it was followed it is no news of the renders that come."""
    running, done = addon("running"), []
    running.is_tick_late = True
    with patch.object(running, "scenes", {"Scene"}):
        assert running._wait(lambda: done.append(True)) == running.PAUSE_S
        assert running.is_tick_late and not done
    assert running._wait(lambda: done.append(True)) is None
    assert not running.is_tick_late and done


checking.run(check, "handler_results.json")
