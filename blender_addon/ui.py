# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels and preferences."""

import itertools

import bpy
from bpy.props import BoolProperty, IntProperty, StringProperty

from . import (
    blended,
    camera_objects,
    denoising,
    finishing,
    group,
    holdouts,
    lamps,
    lens,
    local_cameras,
    memory,
    mirrors,
    outputs,
    overscan,
    parts,
    persistent,
    refocusing,
    regions,
    sampling,
    setup,
    shares,
    shining,
    strips,
    strokes,
    unblurred,
    view_compositor,
    views,
    words,
)
from .library import rackfocus
from .operators import last_message, scene_of
from .props import LENS_POINTS, is_read, look_table, method_table

PARENTS = ("DATA_PT_camera_dof", "CYCLES_CAMERA_PT_dof")


SEEN = {"MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "POINTCLOUD", "VOLUME"}
# Shown in the box itself, not among the options of the method.
IN_BOX = ("method", "max_radius", "film_depth", "coc_limit", *LENS_POINTS)


def draw_field(layout, settings, field):
    """A field; those that may be automatic have a tick and say so."""
    if field not in words.AUTOMATIC:
        layout.prop(settings, field)
        return
    row = layout.row(heading=words.FIELDS[field][0])
    row.prop(settings, f"has_{field}", text="")
    if getattr(settings, f"has_{field}"):
        row.prop(settings, field, text="")
    else:
        row.label(text="None" if field in words.OFF else "Automatic")


def draw_method(layout, settings):
    """The methods up front as buttons; another one by its name."""
    row = layout.row(align=True)
    row.use_property_split = False
    for name in words.UP_FRONT:
        row.prop_enum(settings, "method", name)
    if settings.method not in words.UP_FRONT:
        layout.label(text=f"Method: {words.METHODS[settings.method][0]}")


class InCamera:
    """Where the box and its parts are."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"


class CameraPanel(InCamera):
    """The Rack Focus box of a camera's depth of field."""

    bl_label = "Rack Focus"

    @classmethod
    def poll(cls, context):
        """Cameras only."""
        return context.camera is not None

    def draw_header(self, context):
        """The tick."""
        self.layout.prop(context.camera.rack_focus, "enabled", text="")

    def draw_header_preset(self, _context):
        """The menu of looks."""
        self.layout.popover("VIEW3D_PT_rack_focus_presets", text="", icon="PRESET")

    def draw(self, context):
        """Fields, hints, buttons."""
        layout = self.layout
        layout.use_property_split = True
        settings, scene = context.camera.rack_focus, scene_of(context)
        if context.camera.library is not None:
            layout.label(text="Linked: make a library override to edit", icon="LINKED")
        column = layout.column()
        column.active = settings.enabled
        draw_method(column, settings)
        column.prop(settings, "quality")
        draw_field(column, settings, "supersample")
        if settings.enabled and settings.supersample != 1:
            for text in describe_supersample(settings, scene):
                column.label(text=text, icon="INFO")
        column.prop(settings, "overscan")
        if settings.enabled:
            for text in overscan.describe(scene, settings, views.view_count(settings)):
                column.label(text=text, icon="INFO")
        if shares.is_offered(scene, settings):
            column.prop(settings, "clean_edges")
        column.prop(settings, "mirrors")
        reason = mirrors.why_not(scene, settings)
        if settings.enabled and settings.mirrors and reason:
            column.label(text=reason, icon="INFO")
        if is_read(settings, "max_radius"):
            draw_field(column, settings, "max_radius")
        if scene.render.film_transparent and is_read(settings, "film_depth"):
            column.prop(settings, "film_depth")
        if settings.enabled:
            for text in (
                *shining.describe(scene, settings),
                *regions.describe(scene, settings),
                *blended.describe(scene, scene.camera),
                *holdouts.describe(scene, scene.camera),
                *lamps.describe(scene, scene.camera),
                *strokes.describe(scene),
                *outputs.describe(scene),
                *unblurred.describe(scene),
                *local_cameras.describe(scene),
                *persistent.describe(scene),
            ):
                column.label(text=text, icon="INFO")
        if settings.method in views.METHODS:
            self._draw_views(column, settings, scene)
        if settings.enabled:
            self._draw_state(context, layout, scene)

    @staticmethod
    def _draw_views(column, settings, scene):
        """Number of views, their samples, and what they will cost."""
        column.prop(settings, "views")
        if settings.views < 2:
            return
        column.prop(settings, "view_samples")
        if settings.method == "accumulate":
            column.prop(settings, "camera_move")
            column.prop(settings, "shutter_spread")
        elif scene.render.engine == "CYCLES" and scene.cycles.use_denoising:
            column.prop(settings, "denoise_together")
            reason = denoising.why_not(scene)
            if settings.enabled and reason:
                column.label(text=reason, icon="INFO")
        n = views.view_count(settings)
        for text in views.describe(settings, scene, n) if settings.enabled else ():
            column.label(text=text, icon="INFO")

    def _draw_state(self, context, layout, scene):
        """What is in focus, what is wrong, and the buttons."""
        camera, settings = scene.camera, context.camera.rack_focus
        if camera is None or camera.data != context.camera:
            layout.label(text="Not the scene's active camera", icon="INFO")
            return
        column = layout.column(align=True)
        try:
            column.label(text=describe_focus(camera, scene))
        except (lens.CameraError, rackfocus.Error) as error:
            column.label(text=str(error), icon="ERROR")
        draw_messages(column, scene)
        view_compositor.draw(column, scene)
        draw_refocus(layout, scene)
        draw_finish(layout, scene, settings)
        layout.operator("rack_focus.compare", icon="IMAGE_REFERENCE")
        view = context.window_manager.rack_focus_view
        layout.prop(view, "enabled", text="Show in 3D Views")


def draw_messages(layout, scene):
    """What is wrong with the last run and with the set-up."""
    message = last_message(scene)
    if message:
        layout.label(text=message, icon="ERROR")
    if setup.filter_scene_of(scene) is None:
        return
    if setup.has_sleepers(scene):
        layout.label(
            text="Compositing: your nodes, which were off, stay off", icon="INFO"
        )
    reason = strips.why_shown(scene) or setup.why_not(scene)
    if reason:
        layout.label(text=reason[0].upper() + reason[1:], icon="ERROR")


def draw_refocus(layout, scene):
    """The button, whether the picture is out of date, and the toggle."""
    row = layout.row(align=True)
    is_old = refocusing.is_out_of_date(scene)
    text = "Out of Date" if is_old else "Refocus"
    row.alert = is_old
    row.operator("rack_focus.refocus", text=text, icon="FILE_REFRESH")
    row = row.row(align=True)
    row.alert = row.use_property_split = False
    row.ui_units_x = 3
    row.prop(scene.rack_focus, "is_automatic", text="Auto", toggle=True)


def draw_finish(layout, scene, settings):
    """The button with its samples; why it cannot be, where it cannot."""
    row = layout.row(align=True)
    row.use_property_split = False
    reason = finishing.why_not(scene)
    row.enabled = not reason
    row.operator("rack_focus.finish", icon="SHADERFX")
    row.prop(settings, "finish_samples", text="Samples")
    row.prop(settings, "use_finish", text="", icon="RENDER_ANIMATION")
    reason = reason or finishing.why_little(scene)
    if reason:
        layout.label(text=reason, icon="INFO")


def describe_supersample(settings, scene):
    """Lines on the size and the samples of a supersampled render, or why it is none.

    With 0, Automatic, other engines than Cycles are no news.
    """
    if settings.supersample == 0 and scene.render.engine != "CYCLES":
        return []
    reason = parts.why_not(scene)
    if not reason and views.is_unfiltered(settings, scene):
        reason = "The picture is not filtered: without Supersample"
    if not reason and settings.supersample == 0 and parts.factor(scene) == 1:
        reason = parts.why_not_automatic(scene)
    if reason:
        return [reason]
    scale, n = parts.factor(scene), views.view_count(settings)
    width, height = lens.picture_size(scene.render)
    whole, each = sampling.samples_of(scene), settings.view_samples
    samples = sampling.samples_of_view(whole, n, each, scale)
    what = "sample" if samples == 1 else "samples"
    lines = [f"{scale * width} × {scale * height} px, {samples} {what} each"]
    if scene.render.use_motion_blur:
        lines.append("With Motion Blur, what moves comes out better without")
    if n == 1:  # views say it
        lines += memory.describe(scene, 1, width * height * scale**2)
    return lines


class LookPanel(InCamera):
    """The lens's own look, highlights, and blur before and behind the focus."""

    bl_label = "Look"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        """Fields."""
        layout = self.layout
        layout.use_property_split = True
        settings = context.camera.rack_focus
        layout.active = settings.enabled
        if settings.takes_aperture_image():
            layout.prop(settings, "use_aperture_image")
            if settings.use_aperture_image:
                layout.template_ID(settings, "distribution_image", open="image.open")
        # Fields of one thing, tilt_x and tilt_y, stand together.
        for _, fields in itertools.groupby(look_fields(settings), first_word):
            column = layout.column(align=True)
            for field in fields:
                draw_field(column, settings, field)
        column = layout.column(align=True)
        column.prop(settings, "front_blur", slider=True)
        column.prop(settings, "back_blur", slider=True)


class AdvancedPanel(InCamera):
    """All methods, and the options that the chosen one reads."""

    bl_label = "Advanced"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        """Fields."""
        layout = self.layout
        layout.use_property_split = True
        settings = context.camera.rack_focus
        layout.active = settings.enabled
        layout.prop(settings, "method")
        if settings.quality == "custom":
            for field in custom_fields(settings):
                draw_field(layout, settings, field)
            if (settings.method, settings.distribution) == ("scatter", "image"):
                layout.template_ID(settings, "distribution_image", open="image.open")
        else:
            layout.label(text="Quality Custom shows the method's options", icon="INFO")
        if settings.method in views.METHODS and settings.views > 1:
            layout.prop(settings, "lens_pattern")
            layout.prop(settings, "lens_random")
            if settings.lens_random or settings.lens_pattern == "grid":
                layout.prop(settings, "lens_seed")
        layout.prop(settings, "coc_limit")
        layout.prop(settings, "passes_folder")


def first_word(field):
    """Of the name of a field."""
    return field.split("_")[0]


def look_fields(settings):
    """What the camera's method reads of the lens's look."""
    return [p.field for p in look_table() if is_read(settings, p.field)]


def custom_fields(settings):
    """The options that count for the camera's method, under Custom."""
    shown = {*IN_BOX, *(p.field for p in look_table())}
    fields = [p.field for p in method_table() if p.field not in shown]
    return [field for field in fields if is_read(settings, field)]


def describe_focus(camera, scene):
    """One line on the depth of field of a camera object, in the scene's units."""
    size = lens.picture_size(scene.render)
    params = lens.frame_parameters(camera, camera.data.rack_focus, scene.render, size)
    made = rackfocus.Lens(*size, **params)
    near, far = made.depth_of_field()
    far_text = "infinity" if far == float("inf") else length(scene, far)
    return f"Sharp from {length(scene, near)} to {far_text}"


def length(scene, value):
    """A length in scene units as the scene shows lengths."""
    unit = scene.unit_settings
    if unit.system == "NONE":
        return f"{value:.4g}"
    metres = value * unit.scale_length
    return bpy.utils.units.to_string(unit.system, "LENGTH", metres, precision=4)


class ObjectPanel(bpy.types.Panel):
    """What an object has of Rack Focus."""

    bl_idname = "OBJECT_PT_rack_focus"
    bl_label = "Rack Focus"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        """What can be seen, in a scene that is filtered."""
        is_seen = context.object is not None and context.object.type in SEEN
        return is_seen and setup.filter_scene_of(scene_of(context)) is not None

    def draw(self, context):
        """The tick, and where it has no effect."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(context.object, "rack_focus_keep_sharp")
        scene = scene_of(context)
        camera = camera_objects.camera_of(scene)
        if camera is not None and views.view_count(camera.data.rack_focus) > 1:
            layout.label(text="With one view only", icon="INFO")


class ImagePanel(bpy.types.Panel):
    """Refocus and the picker beside the picture."""

    bl_idname = "IMAGE_PT_rack_focus"
    bl_label = "Rack Focus"
    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Rack Focus"

    @classmethod
    def poll(cls, context):
        """Only where a render is filtered."""
        return setup.filter_scene_of(scene_of(context)) is not None

    def draw(self, context):
        """The camera's focus and the buttons."""
        layout = self.layout
        layout.use_property_split = True
        scene = scene_of(context)
        if camera_objects.camera_of(scene) is None:
            layout.label(text="The scene has no camera", icon="ERROR")
            return
        draw_focus(layout, scene.camera.data.dof)
        row = layout.row(align=True)
        row.operator("rack_focus.pick_focus", icon="EYEDROPPER")
        about = row.operator("rack_focus.pick_focus", text="", icon="KEYFRAME_HLT")
        about.keyframe = True
        draw_refocus(layout, scene)
        row = layout.row(align=True)
        for show, text in refocusing.SHOWN:
            row.operator("rack_focus.show", text=text).show = show
        draw_messages(layout, scene)


class NodePanel(bpy.types.Panel):
    """What a node with sockets has beside them."""

    bl_idname = "NODE_PT_rack_focus"
    bl_label = "Rack Focus"
    bl_space_type = "NODE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Rack Focus"

    @classmethod
    def poll(cls, context):
        """Only where the active node is one of ours."""
        tree = context.space_data.edit_tree
        node = tree.nodes.active if tree is not None else None
        return node is not None and group.is_ours(node)

    def draw(self, context):
        """Camera, layer and the lens."""
        layout = self.layout
        layout.use_property_split = True
        scene = scene_of(context)
        node = context.space_data.edit_tree.nodes.active
        settings = node.node_tree.rack_focus
        layout.prop(settings, "camera")
        if not node.inputs["Depth"].is_linked:
            layout.prop_search(settings, "layer", scene, "view_layers")
        camera = group.camera_of(scene, node)
        if camera is None:
            layout.label(text="The scene has no camera", icon="ERROR")
            return
        draw_focus(layout, camera.data.dof)
        draw_method(layout, camera.data.rack_focus)
        draw_refocus(layout, scene)


def draw_focus(layout, dof):
    """The camera's own focus and aperture."""
    layout.prop(dof, "focus_object", text="Focus on Object")
    row = layout.row()
    row.active = dof.focus_object is None
    row.prop(dof, "focus_distance", text="Focus Distance")
    layout.prop(dof, "aperture_fstop", text="F-Stop")
    layout.prop(dof, "aperture_blades", text="Blades")


class Preferences(bpy.types.AddonPreferences):
    """Edit > Preferences > Add-ons > Rack Focus."""

    bl_idname = __package__

    threads: IntProperty(
        name="Threads",
        description="Threads that the filter uses; 0 takes all processors",
        min=0,
        max=1024,
        default=0,
    )

    is_strict: BoolProperty(
        name="Fail Renders",
        description="A Blender in the background leaves with exit code 1 if a picture "
        "could not be filtered. The environment variable RACKFOCUS_STRICT=1 does the "
        "same",
    )
    has_notice: BoolProperty(
        name="Notice in Files",
        description="Files carry a script that says so in the console where the "
        "add-on is missing. Blender asks before it runs scripts of a file",
    )

    denoiser: StringProperty(
        name="Denoiser",
        description="File or folder of Open Image Denoise, for Finish. Empty: "
        "Blender's own, else that of the system",
        subtype="FILE_PATH",
    )

    def draw(self, _context):
        """Threads, farms, version, instruction set."""
        column = self.layout.column()
        column.prop(self, "threads")
        column.prop(self, "denoiser")
        column.prop(self, "is_strict")
        column.prop(self, "has_notice")
        column.operator("rack_focus.make_assets", icon="ASSET_MANAGER")
        column.label(text=f"Version {rackfocus.version()}")
        column.label(text=f"CPU level in use: {rackfocus.cpu_level()}")


def _make_panels():
    """A box for each of Blender's depth of field panels that exist, and its parts."""
    for parent in PARENTS:
        if hasattr(bpy.types, parent):
            name = parent.replace("_PT_camera_dof", "_PT_rack_focus")
            name = name.replace("_PT_dof", "_PT_rack_focus")
            about = {"bl_idname": name, "bl_parent_id": parent}
            yield type(name, (CameraPanel, bpy.types.Panel), about)
            for base in (LookPanel, AdvancedPanel):
                part = f"{name}_{base.bl_label.lower()}"
                about = {"bl_idname": part, "bl_parent_id": name}
                yield type(part, (base, bpy.types.Panel), about)


_registered = []


def register():
    """Adds panels and preferences."""
    for cls in (Preferences, ObjectPanel, ImagePanel, NodePanel, *_make_panels()):
        bpy.utils.register_class(cls)
        _registered.append(cls)


def unregister():
    """Removes them."""
    while _registered:
        bpy.utils.unregister_class(_registered.pop())
