# SPDX-License-Identifier: GPL-3.0-or-later
"""3D views with a camera of their own (Sidebar > View > Use Local Camera).

F12 with the mouse over such a view renders through that camera, and so does what Blender
calls for no other scene: neither the filter scene nor copies for several views know of it,
and no handler is told. The picture is filtered with the lens of the scene's camera (21.4 dB
where 33 are right), several views are taken from there (14.2). Box and console say so.
"""

import bpy


def describe(scene):
    """Lines for the panel on such a view of a scene."""
    windows = bpy.context.window_manager.windows
    areas = [a for w in windows if w.scene == scene for a in w.screen.areas]
    spaces = [area.spaces.active for area in areas if area.type == "VIEW_3D"]
    cameras = [space.camera for space in spaces if space.use_local_camera]
    others = [c.name for c in cameras if c is not None and c != scene.camera]
    if not others:
        return []
    return [
        f"F12 over the 3D view with the Local Camera “{others[0]}” is not filtered",
        "right: press it elsewhere, or switch View > Use Local Camera off",
    ]
