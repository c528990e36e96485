# SPDX-License-Identifier: GPL-3.0-or-later
"""The focus in the 3D view: an arrow to drag, a cross and the frame in the focus plane.

Shown for the active object where it is a camera with Rack Focus, seen from outside.
"""

import bpy
from mathutils import Matrix, Vector

from . import lens, operators

COLOUR, BRIGHT = (0.95, 0.6, 0.15), (1.0, 0.85, 0.5)
# Corners of line segments: the frame is scaled to its half sides, the cross to a tenth.
FRAME = [(x, y, 0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))]
FRAME = [corner for pair in zip(FRAME[:-1], FRAME[1:], strict=True) for corner in pair]
CROSS = [(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)]
CROSS_SIZE = 0.1  # of the frame's shorter side


def without_scale(matrix):
    """A camera's place and rotation: its scale counts for nothing."""
    place, rotation, _ = matrix.decompose()
    return Matrix.Translation(place) @ rotation.to_matrix().to_4x4()


def matrices(camera, scene):
    """(of the axis, of the cross, of the frame) at the focus of a camera object."""
    base, distance = without_scale(camera.matrix_world), lens.focus_distance(camera)
    corners = [Vector(corner) for corner in camera.data.view_frame(scene=scene)]
    if camera.data.type != "ORTHO":
        corners = [corner * (distance / max(-corner.z, 1e-9)) for corner in corners]
    xs, ys = [c.x for c in corners], [c.y for c in corners]
    half = (max(xs) - min(xs)) / 2, (max(ys) - min(ys)) / 2
    middle = (max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2, -distance
    size = CROSS_SIZE * 2 * min(half)
    return (
        base @ Matrix.Rotation(3.141592653589793, 4, "X"),
        base @ Matrix.Translation((0, 0, -distance)) @ Matrix.Scale(size, 4),
        base @ Matrix.Translation(middle) @ Matrix.Diagonal((*half, 1, 1)),
    )


class Lines:
    """A gizmo of line segments, which cannot be clicked."""

    corners = ()

    def setup(self):
        """Makes the shape once."""
        if not hasattr(self, "shape"):
            self.shape = self.new_custom_shape("LINES", self.corners)

    def draw(self, _context):
        """Draws it."""
        self.draw_custom_shape(self.shape)


class RACK_FOCUS_GT_frame(Lines, bpy.types.Gizmo):
    """The camera's frame in the focus plane."""

    bl_idname = "RACK_FOCUS_GT_frame"
    __slots__ = ("shape",)
    corners = FRAME


class RACK_FOCUS_GT_cross(Lines, bpy.types.Gizmo):
    """A cross where the axis meets it."""

    bl_idname = "RACK_FOCUS_GT_cross"
    __slots__ = ("shape",)
    corners = CROSS


class RACK_FOCUS_GGT_focus(bpy.types.GizmoGroup):
    """Drag the focus distance of the camera."""

    bl_idname = "RACK_FOCUS_GGT_focus"
    bl_label = "Focus Distance"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context):
        """Where the camera is active, and not what is looked through."""
        camera, space = context.object, context.space_data
        if camera is None or camera.type != "CAMERA" or camera.hide_get():
            return False
        is_inside = context.region_data.view_perspective == "CAMERA"
        is_shown = space.show_gizmo and not (is_inside and space.camera == camera)
        return is_shown and camera.data.rack_focus.enabled

    def setup(self, _context):
        """Makes the three."""
        self.arrow = self.gizmos.new("GIZMO_GT_arrow_3d")
        self.arrow.use_draw_modal = True
        self.cross = self.gizmos.new(RACK_FOCUS_GT_cross.bl_idname)
        self.frame = self.gizmos.new(RACK_FOCUS_GT_frame.bl_idname)
        for one in (self.arrow, self.cross, self.frame):
            one.color, one.alpha = COLOUR, 0.8
            one.color_highlight, one.alpha_highlight = BRIGHT, 1.0
        for one in (self.cross, self.frame):
            one.use_draw_scale = False
            one.hide_select = True

    def refresh(self, context):
        """Another camera may be active."""
        self.arrow.target_set_prop("offset", context.object.data.dof, "focus_distance")

    def draw_prepare(self, context):
        """Follows the camera, its animation and its focus object."""
        camera, scene = context.object, operators.scene_of(context)
        axis, cross, frame = matrices(camera, scene)
        self.arrow.matrix_basis = axis
        self.arrow.hide = camera.data.dof.focus_object is not None
        self.cross.matrix_basis, self.frame.matrix_basis = cross, frame


CLASSES = (RACK_FOCUS_GT_frame, RACK_FOCUS_GT_cross, RACK_FOCUS_GGT_focus)


def register():
    """Adds the gizmos."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    """Removes them."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
