# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of renders that do not begin, go on or end as Blender's handlers say.

handler_checks.py DIST OUT [CHECK ...]    writes OUT/handler_results.json
"""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import (  # noqa: E402
    Checks,
    refocused,
    shot,
    update,
)
from common import addon, last_message, same, start  # noqa: E402

check = Checks()


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


checking.run(check, "handler_results.json")
