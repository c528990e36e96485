# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of cameras and scenes; those of the filter come from the core's table."""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import compat, pictures, setup, writing
from .library import rackfocus

OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}
LENS_POINTS = ("lens_pattern", "lens_random", "lens_seed")
# What the camera does not have, beside the parameters of the methods.
OF_OTHER_GROUPS = ("coc_limit", "film_depth")
# Fields that count whatever the quality is.
ALWAYS = ("method", "max_radius", *OF_OTHER_GROUPS, *LENS_POINTS)


def _find(field):
    """The line of the table with a field, or None."""
    return next((p for p in rackfocus.parameters() if p.field == field), None)


def _qualities(table):
    """(items of the property, default, {name: keywords of the filter or None}).

    table: the table's line `quality`, whose choices it takes. "custom", without
    keywords of its own, shows every parameter.
    """
    items = [(c.name, c.name.capitalize(), c.help) for c in table.choices]
    presets = {c.name: {"quality": c.name} for c in table.choices}
    custom = ("custom", "Custom", "Set every option by hand")
    return [*items, custom], table.default, {**presets, "custom": None}


QUALITY_ITEMS, DEFAULT_QUALITY, QUALITIES = _qualities(_find("quality"))


def method_table():
    """The parameters that the camera does not have and that are a property here."""
    return [
        p
        for p in rackfocus.parameters()
        if p.field != "quality" and (p.group == "method" or p.field in OF_OTHER_GROUPS)
    ]


def belongs_to(parameter):
    """The method that a parameter is for, by the first word of its help; "" for all."""
    head, colon, _ = parameter.help.partition(":")
    name = head.lower()
    is_method = name in [method.name for method in rackfocus.methods()]
    return name if colon and is_method else ""


def _property(p):
    """A Blender property for one line of the table."""
    label = p.field.replace("_", " ").capitalize().replace("Coc", "CoC")
    about = dict(name=label, description=p.help.rstrip("."), default=p.default)
    about["override"] = OVERRIDABLE
    if p.type == "enum":
        items = [(c.name, c.name.capitalize(), c.help) for c in p.choices]
        return EnumProperty(items=items, **about)
    if p.type == "bool":
        return BoolProperty(**about)
    kind = IntProperty if p.type == "int" else FloatProperty
    if p.unit == "px":
        about["subtype"] = "PIXEL"
    return kind(min=p.min, max=p.max, **about)


class CameraSettings(bpy.types.PropertyGroup):
    """camera.data.rack_focus"""

    enabled: BoolProperty(
        override=OVERRIDABLE,
        name="Rack Focus",
        description="Make this camera's depth of field after the render",
        update=lambda self, context: setup.camera_changed(self.id_data),
    )
    quality: EnumProperty(
        override=OVERRIDABLE,
        name="Quality",
        description="How much the filter looks at",
        items=QUALITY_ITEMS,
        default=DEFAULT_QUALITY,
    )
    views: IntProperty(
        override=OVERRIDABLE,
        name="Views",
        description="Renders from so many points of the lens, the samples shared out "
        "among them; 1 is one pinhole render. Layered and Views merge 64 at most, "
        "Accumulate takes the mean of any number",
        min=1,
        max=1024,
        soft_max=64,
        default=1,
    )
    camera_move: EnumProperty(
        override=OVERRIDABLE,
        name="Camera Move",
        description="How the camera of a view keeps the focus where it is",
        items=[
            ("shift", "Shift", "Sheared: the whole plane in focus stays where it is"),
            ("look_at", "Look At", "Turned: only the middle of the plane is sharp"),
        ],
        default="shift",
    )
    shutter_spread: BoolProperty(
        override=OVERRIDABLE,
        name="Spread over Shutter",
        description="Each view has its own moment of the shutter's time, which gives "
        "motion blur. The views are then rendered one after another",
    )
    distribution_image: PointerProperty(
        override=OVERRIDABLE,
        name="Distribution Image",
        description="Picture of the aperture, as the camera sees it: the method "
        "Scatter spreads light by it where Distribution is Image",
        type=bpy.types.Image,
    )
    passes_folder: StringProperty(
        override=OVERRIDABLE,
        name="Keep Passes",
        description="Folder for the passes of every frame and view as EXR files, for "
        "the command, and for Refocus after the file was closed; empty: none",
        subtype="DIR_PATH",
        options=compat.PATH_OPTIONS,
    )
    is_dof_hidden: BoolProperty(
        description="Earlier versions had the camera's own depth of field off while a "
        "render ran, also in a file saved then",
        options={"HIDDEN"},
    )

    def lens_parameters(self):
        """Where on the lens the views are taken, as keywords of rackfocus."""
        return {name: getattr(self, name) for name in LENS_POINTS}

    def light_keywords(self):
        """Keyword of rackfocus.Filter: the picture that light is spread by; or {}."""
        params = self.method_parameters()
        wanted = params["method"], params.get("distribution")
        if wanted != ("scatter", "image"):
            return {}
        if self.distribution_image is None:
            raise pictures.PictureError(
                "Distribution “Image” needs a picture: choose a Distribution Image"
            )
        return {"distribution_image": pictures.read(self.distribution_image)}

    def method_parameters(self):
        """The fields as keywords of rackfocus.Filter."""
        values = {p.field: getattr(self, p.field) for p in method_table()}
        preset = QUALITIES[self.quality]
        if preset is None:
            return values
        return {**{key: values[key] for key in ALWAYS}, **preset}


for _parameter in method_table():
    CameraSettings.__annotations__[_parameter.field] = _property(_parameter)


class SceneState(bpy.types.PropertyGroup):
    """scene.rack_focus: how a scene and the one that filters it find each other."""

    gate: writing.gate()
    filter_scene: PointerProperty(type=bpy.types.Scene, options={"HIDDEN"})
    source: PointerProperty(type=bpy.types.Scene, options={"HIDDEN"})
    viewed: PointerProperty(type=bpy.types.Scene, options={"HIDDEN"})
    is_views_copy: BoolProperty(
        description="A copy of the scene viewed, which renders its views",
        options={"HIDDEN"},
    )
    is_tap: BoolProperty(
        description="A scene for a moment, in which a node's inputs are computed",
        options={"HIDDEN"},
    )
    record: StringProperty(
        description="What the set-up changed, as JSON", options={"HIDDEN"}
    )
    muted: StringProperty(
        description="Nodes that are muted while a refocus runs, as JSON",
        options={"HIDDEN"},
    )


class NodeSettings(bpy.types.PropertyGroup):
    """node_tree.rack_focus: of the groups that are our nodes."""

    is_node: BoolProperty(options={"HIDDEN"})
    is_filtered: BoolProperty(
        description="The group shows filtered images", options={"HIDDEN"}
    )
    camera: PointerProperty(
        name="Camera",
        description="Whose lens, focus and method the node takes; empty: the camera "
        "that renders",
        type=bpy.types.Object,
        poll=lambda _, item: item.type == "CAMERA",
    )
    layer: StringProperty(
        name="View Layer",
        description="Whose depth is taken where no Depth is linked; empty: the first",
    )


CLASSES = (CameraSettings, SceneState, NodeSettings)


def register():
    """Adds the properties to cameras and scenes."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Camera.rack_focus = PointerProperty(
        type=CameraSettings, override=OVERRIDABLE
    )
    bpy.types.Scene.rack_focus = PointerProperty(type=SceneState)
    bpy.types.NodeTree.rack_focus = PointerProperty(type=NodeSettings)


def unregister():
    """Takes them away."""
    del bpy.types.NodeTree.rack_focus
    del bpy.types.Scene.rack_focus
    del bpy.types.Camera.rack_focus
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
