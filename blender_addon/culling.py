# SPDX-License-Identifier: GPL-3.0-or-later
"""What Simplify > Culling leaves out of a render.

Cycles asks how far things are from the camera, and whether it sees them, with one camera
alone: in multi-view it leaves nothing out, and what the artist's own render does not show,
light too, would be in the views. They are rendered one after another then, each by a
multi-view render of one view, which Cycles is told is none.
"""

import bpy

from .writing import set_if_other


def is_on(scene):
    """Does Cycles leave things out of a scene by where the camera is?"""
    render = scene.render
    if render.engine != "CYCLES" or not render.use_simplify:
        return False
    switches = [
        name
        for name in ("use_camera_cull", "use_distance_cull")
        if getattr(scene.cycles, name)
    ]
    things = [thing.cycles for thing in bpy.data.objects if hasattr(thing, "cycles")]
    return any(getattr(one, name) for one in things for name in switches)


def let(seen):
    """Lets Cycles leave things out of one view of a scene (its evaluated copy)."""
    set_if_other(seen.render, "use_multiview", False)
