# SPDX-License-Identifier: GPL-3.0-or-later
"""Rack Focus over the 3D view: what the camera's lens makes of it, as one works.

Two draw handlers: one keeps the frame buffer that Blender draws the scene into, the
other reads the colour from it when the scene is drawn, filters it and puts it back, so
that the view transform and the overlays come on top as ever. Its depth is there too, but
for lines of the overlays; where these matter the view is drawn once more into memory,
without them. While something moves it uses a preview method; when nothing has for
REST_S, the layered one. Switched off there is no handler.
"""

import time

import bpy
import gpu
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

from . import focusing, lens, nodes, preferences, viewport_gpu, viewport_lens, words
from .click import WaitsForClick, main_region
from .library import rackfocus

REST_S = 0.3
EARLY_S = 0.2  # until a depth that was not drawn yet is looked for again
REFINING = 4  # a view that only becomes less noisy rests so many times its cost
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
        self.frame = None  # frame buffer that this redraw's scene is drawn into
        self.grabber = None
        self.signature = None  # of what was drawn
        self.changed_at = 0.0  # when it did last
        self.due = None  # when there is something to do, without a change; or None
        self.rest_until = 0.0  # refinements of the same view wait
        self.is_final = False
        self.whole = None  # colour of the scene, (height, width, 4), rows downwards
        self.colour = None  # the same, of the size that is filtered
        self.depth = None  # buffer, rows downwards
        self.is_exact = False  # is that without what overlays left in it?
        self.is_early = False  # had the engine drawn none yet?
        self.params = None  # keywords of the filter
        self.frame_shown = None  # of the scene, in the texture
        self.picture = None  # (height, width, 4), rows downwards: filtered, or a map
        self.texture = None  # of it
        self.is_map = False  # is the texture as shown, or in place of the scene?
        self.message = ""
        self.seconds = {}  # of the steps of the last picture

    def find_depth(self, context, size, is_final):
        """The depth buffer of the view at a size, (width, height).

        Where overlays leave lines in it, thin things are taken out as long as the view
        moves; of the final picture the view is drawn once more, without them.
        """
        space, region = context.space_data, context.region
        has_lines = viewport_gpu.draws_lines(space)
        self.is_exact = is_final or not has_lines
        if not viewport_gpu.leaves_depth(space) or is_final and has_lines:
            self.depth, self.is_exact = self._grab_depth(context, size), True
            return
        depth = viewport_gpu.depth_of(self.frame, region.width, region.height)
        if has_lines:
            depth = viewport_gpu.without_lines(depth)
        self.depth = viewport_gpu.nearest(depth, *size)

    def _grab_depth(self, context, size):
        if self.grabber is None or (self.grabber.width, self.grabber.height) != size:
            self.free()
            self.grabber = viewport_gpu.Grabber(*size)
        return self.grabber.depth(context)

    def free(self):
        """Gives the memory back."""
        if self.grabber is not None:
            self.grabber.free()
        self.grabber = None


_views = {}  # pointer of the region: View
_contexts = {}  # the rackfocus.Context, by its number of threads
_handlers = []
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


def _context():
    """Threads, memory and footprints, kept as long as the switch is on."""
    n_threads = preferences.threads()
    if n_threads not in _contexts:
        _contexts.clear()
        _contexts[n_threads] = rackfocus.Context(threads=n_threads)
    return _contexts[n_threads]


def _picture(context, settings, view, is_final):
    """(what is shown, (height, width, 4), rows downwards; is it a map?).

    From view.colour and view.depth.
    """
    camera = context.scene.camera.evaluated_get(context.evaluated_depsgraph_get())
    seen = viewport_lens.see(
        context.region_data, camera, context.scene.render, view.depth,
        settings.point if settings.has_point else None,
    )  # fmt: skip
    if settings.show == "DEPTH":
        matrix = context.region_data.window_matrix
        return depth_map(viewport_lens.planar_depth(matrix, view.depth)), True
    method = {"method": settings.method}
    if settings.method == "automatic":
        method = AT_REST if is_final else MOVING
    height, width = view.depth.shape
    view.params = {**seen.params, **method}
    made = rackfocus.Filter(width, height, context=_context(), **view.params)
    if settings.show == "PICTURE":
        shown = np.empty_like(view.colour)
        made.process(view.colour, seen.depth, shown)
        return shown, False
    coc = np.empty((height, width), np.float32)
    made.coc(seen.depth, coc)
    if settings.show == "COC":
        return coc_map(coc), True
    limit = made.lens.coc_limit_px
    return nodes.overlay(view.colour, coc[..., None], limit), False


def _make(context, settings, view, has_moved, is_final):
    """The texture of a view, from view.whole; None where it shows nothing."""
    view.is_early = False
    camera = context.scene.camera
    if camera is None or camera.type != "CAMERA":
        raise viewport_gpu.ViewError(
            "the scene has no camera, whose lens this would be"
        )
    if not view.whole.any():  # the first picture of an engine, or an empty scene
        view.depth = None
        return None
    times = [time.perf_counter()]
    rows, columns = view.whole.shape[:2]
    share = settings.percentage / 100
    size = max(int(columns * share), 1), max(int(rows * share), 1)
    view.colour = viewport_gpu.shrunk(view.whole, *size)
    times.append(time.perf_counter())
    if has_moved or view.depth is None or is_final and not view.is_exact:
        view.find_depth(context, size, is_final)
    if not view.depth.any():  # on a busy machine, of Cycles in 3.4
        view.depth, view.is_early = None, True
        return None
    times.append(time.perf_counter())
    if not (view.depth < 1).any():
        return None
    view.picture, view.is_map = _picture(context, settings, view, is_final)
    times.append(time.perf_counter())
    if view.is_map:
        texture = viewport_gpu.to_shown_texture(view.picture)
    else:
        before = view.colour[..., 3]
        texture = viewport_gpu.to_texture(context, view.picture, before)
    times.append(time.perf_counter())
    steps = ("shrink", "depth", "filter", "texture")
    view.seconds.update(zip(steps, np.diff(times).tolist(), strict=True))
    return texture


def _update(context, settings, view):
    """Makes the picture of a view anew if it must be."""
    signature, now = _signature(context, settings), time.monotonic()
    region, started = context.region, time.perf_counter()
    view.message = ""
    try:
        whole = viewport_gpu.colour_of(view.frame, region.width, region.height)
        view.seconds["read"] = time.perf_counter() - started
        has_moved = signature != view.signature
        if has_moved:
            view.changed_at, view.rest_until = now, now
        is_final = now - view.changed_at >= REST_S
        is_refined = not np.array_equal(whole, view.whole)
        if is_refined and not has_moved and now < view.rest_until:
            view.due, view.is_final = view.rest_until, False
        elif has_moved or is_refined or is_final and not view.is_final:
            view.signature, view.whole = signature, whole
            view.texture = _make(context, settings, view, has_moved, is_final)
            is_preview = settings.show == "PICTURE" and settings.method == "automatic"
            view.is_final = is_final or view.is_exact and not is_preview
            view.due = None if view.is_final else view.changed_at + REST_S
            if view.is_early:
                view.is_final, view.due = False, now + EARLY_S
            view.frame_shown = context.scene.frame_current
            spent = time.perf_counter() - started
            view.rest_until = time.monotonic() + REFINING * spent
    except EXPECTED as error:
        view.texture, view.signature = None, signature
        view.message = getattr(error, "message", "") or str(error) or "out of memory"
        view.is_final, view.due = True, None
    if view.due is not None and not bpy.app.timers.is_registered(_look_again):
        bpy.app.timers.register(_look_again, first_interval=max(view.due - now, 0.01))


def _keep_frame():
    """Notes what Blender is about to draw the scene of a view into."""
    context = bpy.context
    if not _is_drawing and context.region_data is not None:
        view = _views.setdefault(context.region.as_pointer(), View())
        view.frame = gpu.state.active_framebuffer_get()


def _draw():
    """Filters the view that was drawn."""
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
        started = time.perf_counter()
        if view.texture is not None and view.is_map:
            viewport_gpu.draw_over(context.region, view.texture)
        elif view.texture is not None:
            viewport_gpu.draw_into(view.frame, context.region, view.texture)
        if view.message:
            viewport_gpu.draw_message(view.message)
        view.seconds["draw"] = time.perf_counter() - started
    finally:
        view.frame = None
        _is_drawing = False


# ---- on and off -------------------------------------------------------------------


def redraw():
    """Asks for all 3D views to be drawn."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _look_again():
    """Draws the views that rested for long enough; how long until the next does."""
    due = [view.due for view in _views.values() if view.due is not None]
    if not due or not _handlers:
        return None
    left = min(due) - time.monotonic()
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
    is_wanted = settings_of(context or bpy.context).enabled
    if is_wanted and not _handlers:
        for function, kind in ((_keep_frame, "PRE_VIEW"), (_draw, "POST_PIXEL")):
            add = bpy.types.SpaceView3D.draw_handler_add
            _handlers.append(add(function, (), "WINDOW", kind))
        for name in CHANGES:
            getattr(bpy.app.handlers, name).append(_on_change)
    elif not is_wanted and _handlers:
        for handler in _handlers:
            bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")
        _handlers.clear()
        for name in CHANGES:
            handlers = getattr(bpy.app.handlers, name)
            if _on_change in handlers:
                handlers.remove(_on_change)
        for view in _views.values():
            view.free()
        _views.clear()
        _contexts.clear()
    redraw()


def _redraw(_settings, _context):
    redraw()


def _methods():
    """Items of the property: automatic, and those of the list for one view."""
    items = [("automatic", "Automatic", "A preview while things move, layered at rest")]
    for method in rackfocus.methods():
        if method.name not in ("views", "accumulate"):
            items.append((method.name, *words.METHODS[method.name]))
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
            focusing.focus(self, context.scene, context.scene.camera, distance)
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
