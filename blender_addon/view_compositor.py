# SPDX-License-Identifier: GPL-3.0-or-later
"""3D views that are composited (Viewport Shading > Compositor, from 3.5 on).

Blender composites them with the nodes of the scene, and knows no other scene there: where
our node leads to the output, such a view is empty. The box says so, and can switch it off.
"""

import bpy

from . import setup

COMPOSITED = ("MATERIAL", "RENDERED")  # shading types
OFF = "DISABLED"
LINES = (
    "Composited 3D views are empty: Blender",
    "shows no other scene's nodes there",
)


def _shadings(scene):
    """The shading of each composited 3D view of a scene."""
    windows = bpy.context.window_manager.windows
    areas = [a for w in windows if w.scene == scene for a in w.screen.areas]
    spaces = [area.spaces.active for area in areas if area.type == "VIEW_3D"]
    shadings = [s.shading for s in spaces if s.shading.type in COMPOSITED]
    return [s for s in shadings if getattr(s, "use_compositor", OFF) != OFF]


def is_empty(scene):
    """Does a 3D view of a scene show nothing, since our node is composited in it?"""
    if not setup.is_filtered(scene) or not _shadings(scene):
        return False
    return any(setup.is_shown(scene, layer.name) for layer in scene.view_layers)


def draw(layout, scene):
    """What is to be said of such views, and the button."""
    if is_empty(scene):
        for text in LINES:
            layout.label(text=text, icon="ERROR")
        layout.operator(RACK_FOCUS_OT_views_uncomposited.bl_idname)


class RACK_FOCUS_OT_views_uncomposited(bpy.types.Operator):
    """Switch Viewport Shading > Compositor off in the 3D views of this scene"""

    bl_idname = "rack_focus.views_uncomposited"
    bl_label = "Switch Compositor Off"

    def execute(self, context):
        """Renders go on as they are."""
        for shading in _shadings(context.scene):
            shading.use_compositor = OFF
        return {"FINISHED"}


def register():
    """Adds the operator."""
    bpy.utils.register_class(RACK_FOCUS_OT_views_uncomposited)


def unregister():
    """Removes it."""
    bpy.utils.unregister_class(RACK_FOCUS_OT_views_uncomposited)
