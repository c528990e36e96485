# SPDX-License-Identifier: GPL-3.0-or-later
"""rack_focus.pick_focus: click what should be sharp."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from . import camera_objects, engine, focusing, lamps, lens, passes, setup, slots
from .click import WaitsForClick
from .operators import scene_of

EEVEE_NOTHING_HIT = 65504.0  # of EEVEE up to 4.1; all others write 1e10


def depth_at(scene, x, y):
    """Planar depth under a point of the last render, or None where nothing was hit.

    x, y: fractions of the rendered picture, from its lower left corner. The nearest
    surface over all view layers, in stereo in the first view.
    """
    found = []
    rendered = passes.rendered(scene)
    view = camera_objects.first_view(scene.render)
    camera = camera_objects.camera_of(scene)
    for layer in scene.view_layers:
        if layer.use:
            first = rendered.views(layer.name, *view)[:1]
            if first[0][0].depth is None:
                raise passes.PassesError(engine.no_depth(scene, layer.name))
            if camera is not None:
                first = lamps.placed(first, scene, layer.name, camera)
            depth = first[0][0].depth
            rows, columns = depth.shape
            row = min(int((1 - y) * rows), rows - 1)
            found.append(float(depth[row, min(int(x * columns), columns - 1)]))
    hits = [z for z in found if 0 < z < EEVEE_NOTHING_HIT]
    return min(hits) if hits else None


def _need_picture(context, scene):
    """PassesError where the artist sees another picture than the one that is known.

    A file of the render's size may be a render that was saved.
    """
    space = context.space_data
    image = getattr(space, "image", None)  # of an Image Editor
    if space is not None and space.type == "IMAGE_EDITOR" and not _may_be(image, scene):
        shown = f"“{image.name}”" if image is not None else "no picture"
        raise passes.PassesError(
            f"this Image Editor shows {shown}: choose Render Result in its header"
        )
    is_result = image is None or image == slots.render_result()
    reason = slots.why_not_last(scene) if is_result else ""
    if reason:
        raise passes.PassesError(reason)


def _may_be(image, scene):
    """May an image, or None, show the render of a scene?"""
    if image is None or image.type in ("RENDER_RESULT", "COMPOSITING"):
        return image is not None
    sizes = lens.picture_size(scene.render), passes.rendered(scene).size()
    return tuple(image.size) in sizes


class RACK_FOCUS_OT_pick_focus(WaitsForClick, bpy.types.Operator):
    """Click a point of the render: the camera focuses on it"""

    bl_idname = "rack_focus.pick_focus"
    bl_label = "Pick Focus"
    bl_options = {"REGISTER", "UNDO"}

    x: FloatProperty(
        name="X", description="From the left, of the picture", min=0, max=1, default=0.5
    )
    y: FloatProperty(
        name="Y",
        description="From the bottom, of the picture",
        min=0,
        max=1,
        default=0.5,
    )
    object: StringProperty(
        name="Object", description="Focus on this object instead of a point"
    )
    keyframe: BoolProperty(
        name="Keyframe",
        description="Insert a keyframe of the focus distance in the present frame",
        default=False,
        options={"SKIP_SAVE"},
    )
    refocus: BoolProperty(
        name="Refocus", description="Filter the picture again", default=True
    )

    @classmethod
    def poll(cls, context):
        """Needs a camera."""
        return camera_objects.camera_of(scene_of(context)) is not None

    def execute(self, context):
        """Focuses on the object, or on what lies at (x, y)."""
        scene = scene_of(context)
        dof = scene.camera.data.dof
        if self.object:
            target = bpy.data.objects.get(self.object)
            if target is None:
                self.report({"ERROR"}, f"There is no object “{self.object}”")
                return {"CANCELLED"}
            dof.focus_object = target
        elif not self._focus_on_point(context, scene):
            return {"CANCELLED"}
        if self.refocus and setup.filter_scene_of(scene) is not None:
            call = "INVOKE_DEFAULT" if context.window else "EXEC_DEFAULT"
            bpy.ops.rack_focus.refocus(call)
        return {"FINISHED"}

    def _focus_on_point(self, context, scene):
        try:
            _need_picture(context, scene)
            distance = depth_at(scene, self.x, self.y)
        except passes.PassesError as error:
            self.report({"ERROR"}, f"Rack Focus: {error}")
            return False
        if distance is None:
            self.report({"WARNING"}, "Nothing was hit there: click on a surface")
            return False
        focusing.focus(self, scene, scene.camera, distance, self.keyframe)
        return True

    def invoke(self, context, _event):
        """Waits for the click in the Image Editor."""
        if context.area is None or context.area.type != "IMAGE_EDITOR":
            return self.execute(context)
        return self.wait(context)

    @staticmethod
    def place(region, x, y):
        """Fractions of the picture that the editor shows."""
        return region.view2d.region_to_view(x, y)


def register():
    """Adds the operator."""
    bpy.utils.register_class(RACK_FOCUS_OT_pick_focus)


def unregister():
    """Removes it."""
    bpy.utils.unregister_class(RACK_FOCUS_OT_pick_focus)
