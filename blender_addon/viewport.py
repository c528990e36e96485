# SPDX-License-Identifier: GPL-3.0-or-later
"""Rack Focus over the 3D view: what the camera's lens makes of it, as one works.

A draw handler of Blender's draws the view once more into memory, filters colour and
depth, and covers the view with the result. While something moves it uses a preview
method; when nothing has changed for REST_S, the layered one. Switched off there is no
handler.
"""

import time

import bpy
import numpy as np
from bpy.app.handlers import persistent
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
)

from . import engine, lens, viewport_gpu, viewport_lens
from .click import WaitsForClick, main_region
from .library import rackfocus

REST_S = 0.3
MOVING = {"method": "box", "box_repeats": 2}
AT_REST = {"method": "layered", "quality": "normal"}
EXPECTED = (viewport_gpu.ViewError, lens.CameraError, rackfocus.Error, MemoryError)
# What is drawn anew when it changes, beside the view, the scene and the settings.
SHADING = (
    "type light color_type studio_light show_shadows show_cavity show_xray "
    "background_type use_scene_lights use_scene_world render_pass"
).split()
BEHIND, BEFORE = np.float32([0.15, 0.45, 1]), np.float32([1, 0.35, 0.1])


class View:
    """What is kept of one region that shows a 3D view."""

    def __init__(self):
        self.grabber = None
        self.signature = None  # of what was drawn
        self.changed_at = 0.0
        self.is_final = False
        self.texture = None
        self.depth = None  # buffer, rows downwards
        self.message = ""
        self.seconds = {}  # of the steps of the last picture

    def grab(self, context, scale):
        """Colour and depth of the view, `scale` times its size."""
        region = context.region
        size = tuple(max(int(n * scale), 1) for n in (region.width, region.height))
        if self.grabber is None or (self.grabber.width, self.grabber.height) != size:
            self.free()
            self.grabber = viewport_gpu.Grabber(*size)
        return self.grabber.grab(context)

    def free(self):
        """Gives the memory back."""
        if self.grabber is not None:
            self.grabber.free()
        self.grabber = None


_views = {}  # pointer of the region: View
_handler = None
_n_changes = 0  # of the scene, counted by a handler
_is_drawing = False


def settings_of(context):
    """The settings; one set for all 3D views."""
    return context.window_manager.rack_focus_view


def view_of(region):
    """The View of a region, for scripts and tests; None before its first picture."""
    return _views.get(region.as_pointer())


# ---- one picture ------------------------------------------------------------------


def _signature(context, settings):
    """Everything that the picture depends on."""
    view, region = context.region_data, context.region
    shading = context.space_data.shading
    return (
        tuple(tuple(row) for row in view.view_matrix),
        tuple(tuple(row) for row in view.window_matrix),
        (region.width, region.height, context.scene.name, context.scene.frame_current),
        tuple(str(getattr(shading, name, None)) for name in SHADING),
        context.space_data.overlay.show_overlays,
        (settings.show, settings.method, settings.percentage),
        tuple(settings.point) if settings.has_point else None,
        _n_changes,
    )


def depth_map(planar):
    """(height, width, 4) in grey, lighter is farther; white where nothing was hit."""
    hits = planar[np.isfinite(planar)]
    near, far = (hits.min(), hits.max()) if hits.size else (0.0, 1.0)
    grey = np.clip((planar - near) / max(far - near, 1e-9), 0, 1) * 0.9
    grey[~np.isfinite(planar)] = 1
    shown = np.ones((*grey.shape, 4), np.float32)
    shown[..., :3] = grey[..., None]
    return shown


def coc_map(coc):
    """(height, width, 4): blue behind the focus, orange before it, black in focus."""
    most = max(float(np.abs(coc).max()), 1e-6)
    shown = np.ones((*coc.shape, 4), np.float32)
    share = np.abs(coc)[..., None] / most
    shown[..., :3] = np.where(coc[..., None] > 0, BEHIND, BEFORE) * share
    return shown


def _filtered(made, colour, depth):
    """The filter on a picture as shown; opaque."""
    out = np.ones_like(colour)
    made.process(colour[..., :3], depth, out[..., :3])
    return out


def _picture(context, settings, view, is_final):
    """What covers the view, (height, width, 4), rows downwards."""
    camera = context.scene.camera
    if camera is None or camera.type != "CAMERA":
        raise viewport_gpu.ViewError(
            "the scene has no camera, whose lens this would be"
        )
    times = [time.perf_counter()]
    colour, view.depth = view.grab(context, settings.percentage / 100)
    times.append(time.perf_counter())
    if not (view.depth < 1).any():
        return colour  # empty
    camera = camera.evaluated_get(context.evaluated_depsgraph_get())
    seen = viewport_lens.see(
        context.region_data, camera, context.scene.render, view.depth,
        settings.point if settings.has_point else None,
    )  # fmt: skip
    if settings.show == "DEPTH":
        planar = viewport_lens.planar_depth(
            context.region_data.window_matrix, view.depth
        )
        return depth_map(planar)
    method = {"method": settings.method}
    if settings.method == "automatic":
        method = AT_REST if is_final else MOVING
    height, width = view.depth.shape
    made = rackfocus.Filter(
        width, height, threads=engine.threads(), **{**seen.params, **method}
    )
    if settings.show == "PICTURE":
        shown = _filtered(made, colour, seen.depth)
    else:
        coc = np.empty((height, width), np.float32)
        made.coc(seen.depth, coc)
        shown = coc_map(coc)
        if settings.show == "FOCUS":
            limit = made.lens.coc_limit_px
            shown = engine.overlay(np.array(colour), coc[..., None], limit)
    times.append(time.perf_counter())
    view.seconds = {"draw": times[1] - times[0], "filter": times[2] - times[1]}
    return shown


def _update(context, settings, view):
    """Makes the picture of a view anew if it must be."""
    signature, now = _signature(context, settings), time.monotonic()
    if signature != view.signature:
        view.changed_at = now
        is_final = False
    elif view.is_final or now - view.changed_at < REST_S:
        return
    else:
        is_final = True
    view.signature = signature
    view.is_final = is_final or settings.method != "automatic"
    if settings.show != "PICTURE":
        view.is_final = True
    view.message = ""
    try:
        view.texture = viewport_gpu.to_texture(
            _picture(context, settings, view, is_final)
        )
    except viewport_gpu.NotReady as error:
        view.texture, view.message = None, str(error)
        view.changed_at, view.is_final = now, False
    except EXPECTED as error:
        view.texture = None
        view.message = getattr(error, "message", "") or str(error) or "out of memory"
        view.is_final = True
    if not view.is_final and not bpy.app.timers.is_registered(_look_again):
        bpy.app.timers.register(_look_again, first_interval=REST_S)


def _draw():
    """Covers the view that is being drawn."""
    global _is_drawing
    context = bpy.context
    if _is_drawing or context.region_data is None:
        return
    settings = settings_of(context)
    if not settings.enabled:
        return
    view = _views.setdefault(context.region.as_pointer(), View())
    _is_drawing = True
    try:
        _update(context, settings, view)
        if view.texture is not None:
            viewport_gpu.draw_over(context.region, view.texture)
        if view.message:
            viewport_gpu.draw_message(view.message)
    finally:
        _is_drawing = False


# ---- on and off -------------------------------------------------------------------


def redraw():
    """Asks for all 3D views to be drawn."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _look_again():
    """Nothing moved for a while: time for the better picture."""
    resting = [view for view in _views.values() if not view.is_final]
    if not resting or _handler is None:
        return None
    left = max(v.changed_at for v in resting) + REST_S - time.monotonic()
    if left > 0:
        return left + 0.01
    redraw()
    return None


@persistent
def _on_change(*_):
    """The scene changed, or another frame is shown."""
    global _n_changes
    _n_changes += 1


@persistent
def _on_load(*_):
    """A file that opens has a view switch of its own: off."""
    refresh()


CHANGES = ("depsgraph_update_post", "frame_change_post")


def refresh(_settings=None, context=None):
    """Puts the handlers in while the switch is on, and only then."""
    global _handler
    is_wanted = settings_of(context or bpy.context).enabled
    if is_wanted and _handler is None:
        _handler = bpy.types.SpaceView3D.draw_handler_add(
            _draw, (), "WINDOW", "POST_PIXEL"
        )
        for name in CHANGES:
            getattr(bpy.app.handlers, name).append(_on_change)
    elif not is_wanted and _handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handler, "WINDOW")
        _handler = None
        for name in CHANGES:
            handlers = getattr(bpy.app.handlers, name)
            if _on_change in handlers:
                handlers.remove(_on_change)
        for view in _views.values():
            view.free()
        _views.clear()
    redraw()


def _redraw(_settings, _context):
    redraw()


def _methods():
    """Items of the property: automatic, and those of the list for one view."""
    items = [("automatic", "Automatic", "A preview while things move, layered at rest")]
    for method in rackfocus.methods():
        if method.name not in ("views", "accumulate"):
            items.append((method.name, method.name.capitalize(), method.help))
    return items


class ViewSettings(bpy.types.PropertyGroup):
    """window_manager.rack_focus_view"""

    enabled: BoolProperty(
        name="Rack Focus",
        description="Show the 3D views with the depth of field of the scene's camera",
        update=refresh,
        options={"SKIP_SAVE"},
    )
    show: EnumProperty(
        name="Show",
        items=[
            ("PICTURE", "Picture", "The view through the lens"),
            ("DEPTH", "Depth", "The depth map, lighter is farther"),
            ("COC", "CoC", "Radius of the blur: blue behind the focus, orange before"),
            ("FOCUS", "Focus", "What is in focus, in green"),
        ],
        update=_redraw,
    )
    method: EnumProperty(
        name="Method",
        description="How the blur is made",
        items=_methods(),
        default="automatic",
        update=_redraw,
    )
    percentage: IntProperty(
        name="Size",
        description="Of the picture that is filtered, of the view's own",
        subtype="PERCENTAGE",
        min=5,
        max=100,
        default=50,
        update=_redraw,
    )
    point: FloatVectorProperty(
        name="Focus Point",
        description="What is sharp when the scene is seen freely",
        subtype="XYZ",
        update=_redraw,
    )
    has_point: BoolProperty(
        name="Use Focus Point",
        description="Else what the camera is focused on is sharp when seen freely",
        update=_redraw,
    )


# ---- click to focus ---------------------------------------------------------------


class RACK_FOCUS_OT_view_focus(WaitsForClick, bpy.types.Operator):
    """Click what should be sharp in a 3D view that shows Rack Focus"""

    bl_idname = "rack_focus.view_focus"
    bl_label = "Click to Focus"
    bl_options = {"REGISTER", "UNDO"}

    x: FloatProperty(
        name="X", description="From the left, of the view", min=0, max=1, default=0.5
    )
    y: FloatProperty(
        name="Y", description="From the bottom, of the view", min=0, max=1, default=0.5
    )

    @classmethod
    def poll(cls, context):
        """In a 3D view with the switch on."""
        area = context.area
        return area and area.type == "VIEW_3D" and settings_of(context).enabled

    def invoke(self, context, _event):
        """Waits for the click."""
        return self.wait(context)

    @staticmethod
    def place(region, x, y):
        """Fractions of the view."""
        return min(max(x / region.width, 0), 1), min(max(y / region.height, 0), 1)

    def execute(self, context):
        """Focuses on what lies at (x, y)."""
        view = view_of(main_region(context.area))
        if view is None or view.depth is None:
            self.report({"ERROR"}, "Rack Focus has not drawn this view yet")
            return {"CANCELLED"}
        rows, columns = view.depth.shape
        row = min(int((1 - self.y) * rows), rows - 1)
        value = float(view.depth[row, min(int(self.x * columns), columns - 1)])
        if value >= 1:
            self.report({"WARNING"}, "Nothing was hit there: click on a surface")
            return {"CANCELLED"}
        data = context.space_data.region_3d
        point = viewport_lens.world_point(data, self.x, self.y, value)
        if data.view_perspective == "CAMERA":
            distance = -(data.view_matrix @ point).z
            dof = context.scene.camera.data.dof
            dof.focus_object, dof.focus_distance = None, distance
            self.report({"INFO"}, f"Focus at {distance:.4g}")
        else:
            settings = settings_of(context)
            settings.point, settings.has_point = point, True
        redraw()
        return {"FINISHED"}


# ---- the menu ---------------------------------------------------------------------


def draw_menu(self, context):
    """In the popover of the overlays."""
    settings, layout = settings_of(context), self.layout
    layout.separator()
    layout.prop(settings, "enabled")
    if not settings.enabled:
        return
    column = layout.column()
    column.row().prop(settings, "show", expand=True)
    column.prop(settings, "method")
    column.prop(settings, "percentage", slider=True)
    column.operator("rack_focus.view_focus", icon="EYEDROPPER")
    row = column.row()
    row.active = settings.has_point
    row.prop(settings, "has_point")
    camera = context.scene.camera
    if camera is not None and camera.type == "CAMERA" and camera.data.dof.use_dof:
        column.label(text="The camera's own blur comes on top", icon="INFO")


CLASSES = (ViewSettings, RACK_FOCUS_OT_view_focus)


def register():
    """Adds settings, operator and menu."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.WindowManager.rack_focus_view = PointerProperty(type=ViewSettings)
    bpy.types.VIEW3D_PT_overlay.append(draw_menu)
    bpy.app.handlers.load_post.append(_on_load)


def unregister():
    """Removes them."""
    for window_manager in bpy.data.window_managers:
        window_manager.rack_focus_view.enabled = False
    bpy.app.handlers.load_post.remove(_on_load)
    bpy.types.VIEW3D_PT_overlay.remove(draw_menu)
    del bpy.types.WindowManager.rack_focus_view
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
