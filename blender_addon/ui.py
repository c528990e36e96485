# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels and preferences."""

import bpy
from bpy.props import BoolProperty, IntProperty

from . import group, lens, setup, views
from .library import rackfocus
from .operators import last_message, scene_of
from .props import LENS_POINTS, belongs_to, method_table

PARENTS = ("DATA_PT_camera_dof", "CYCLES_CAMERA_PT_dof")


def _is_main(p):
    return p.field in ("method", "max_radius", "film_depth", *LENS_POINTS)


class CameraPanel:
    """The Rack Focus box of a camera's depth of field."""

    bl_label = "Rack Focus"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        """Cameras only."""
        return context.camera is not None

    def draw_header(self, context):
        """The tick."""
        self.layout.prop(context.camera.rack_focus, "enabled", text="")

    def draw(self, context):
        """Fields, hints, buttons."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings, scene = context.camera.rack_focus, scene_of(context)
        column = layout.column()
        column.active = settings.enabled
        column.prop(settings, "method")
        column.prop(settings, "quality")
        column.prop(settings, "max_radius")
        if scene.render.film_transparent:
            column.prop(settings, "film_depth")
        if settings.quality == "custom":
            for p in method_table():
                if not _is_main(p) and belongs_to(p) in ("", settings.method):
                    column.prop(settings, p.field)
            if (settings.method, settings.distribution) == ("scatter", "image"):
                column.template_ID(settings, "distribution_image", open="image.open")
        if settings.method in views.METHODS:
            self._draw_views(column, settings, scene)
        column.prop(settings, "passes_folder")
        if settings.enabled:
            self._draw_state(context, layout, scene)

    @staticmethod
    def _draw_views(column, settings, scene):
        """Number of views, where on the lens, and what they will cost."""
        column.prop(settings, "views")
        n = views.view_count(settings)
        if settings.views < 2:
            return
        column.prop(settings, "lens_pattern")
        column.prop(settings, "lens_random")
        if settings.lens_random or settings.lens_pattern == "grid":
            column.prop(settings, "lens_seed")
        if settings.method == "accumulate":
            column.prop(settings, "camera_move")
            column.prop(settings, "shutter_spread")
        if settings.enabled:
            for text in views.describe(settings, scene, n):
                column.label(text=text, icon="INFO")

    def _draw_state(self, context, layout, scene):
        """What is in focus, what is wrong, and the buttons."""
        camera = scene.camera
        if camera is None or camera.data != context.camera:
            layout.label(text="Not the scene's active camera", icon="INFO")
            return
        column = layout.column(align=True)
        try:
            column.label(text=describe_focus(camera, scene.render))
        except (lens.CameraError, rackfocus.Error) as error:
            column.label(text=str(error), icon="ERROR")
        message = last_message(scene)
        if message:
            column.label(text=message, icon="ERROR")
        if not scene.render.use_compositing or setup.filter_scene_of(scene) is None:
            column.label(text="Post Processing > Compositing is off", icon="ERROR")
        row = layout.row(align=True)
        row.operator("rack_focus.refocus", icon="FILE_REFRESH")
        layout.operator("rack_focus.compare", icon="IMAGE_REFERENCE")
        settings = context.window_manager.rack_focus_view
        layout.prop(settings, "enabled", text="Show in 3D Views")


def describe_focus(camera, render):
    """One line on the depth of field of a camera object, for the panel."""
    params = lens.frame_parameters(
        camera, camera.data.rack_focus, render, lens.picture_size(render)
    )
    made = rackfocus.Lens(*lens.picture_size(render), **params)
    near, far = made.depth_of_field()
    far_text = "infinity" if far == float("inf") else f"{far:.4g}"
    return f"Sharp from {near:.4g} to {far_text}"


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
        layout.use_property_decorate = False
        scene = scene_of(context)
        if scene.camera is None:
            layout.label(text="The scene has no camera", icon="ERROR")
            return
        draw_focus(layout, scene.camera.data.dof)
        layout.operator("rack_focus.pick_focus", icon="EYEDROPPER")
        layout.operator("rack_focus.refocus", icon="FILE_REFRESH")
        message = last_message(scene)
        if message:
            layout.label(text=message, icon="ERROR")


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
        layout.prop(camera.data.rack_focus, "method")
        layout.operator("rack_focus.refocus", icon="FILE_REFRESH")


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

    def draw(self, _context):
        """Threads, farms, version, instruction set."""
        column = self.layout.column()
        column.prop(self, "threads")
        column.prop(self, "is_strict")
        column.prop(self, "has_notice")
        column.label(text=f"Version {rackfocus.version()}")
        column.label(text=f"CPU level in use: {rackfocus.cpu_level()}")


def _make_panels():
    """A box for each of Blender's depth of field panels that exist."""
    for parent in PARENTS:
        if hasattr(bpy.types, parent):
            name = parent.replace("_PT_camera_dof", "_PT_rack_focus")
            name = name.replace("_PT_dof", "_PT_rack_focus")
            about = {"bl_idname": name, "bl_parent_id": parent}
            yield type(name, (CameraPanel, bpy.types.Panel), about)


_registered = []


def register():
    """Adds panels and preferences."""
    for cls in (Preferences, ImagePanel, NodePanel, *_make_panels()):
        bpy.utils.register_class(cls)
        _registered.append(cls)


def unregister():
    """Removes them."""
    while _registered:
        bpy.utils.unregister_class(_registered.pop())
