# SPDX-License-Identifier: GPL-3.0-or-later
"""Looks of lenses as presets of a camera, and the artist's own."""

import math
import warnings

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel
from bpy.props import StringProperty

from . import camera_objects, props, words
from .library import rackfocus

FOLDER = "rack_focus"  # of the artist's presets

# name: (tooltip, values of camera.dof, values of camera.rack_focus)
ROUND = {"aperture_blades": 0, "aperture_rotation": 0.0, "aperture_ratio": 1.0}
PLAIN = {"front_blur": 1.0, "back_blur": 1.0, "use_aperture_image": False}
PLAIN.update(props.plain_look())
LOOKS = {
    "Portrait f/1.4": (
        "A fast lens, wide open: round discs",
        {**ROUND, "aperture_fstop": 1.4},
        PLAIN,
    ),
    "Standard f/2.8": (
        "Seven blades, nearly round",
        {**ROUND, "aperture_fstop": 2.8, "aperture_blades": 7},
        PLAIN,
    ),
    "Landscape f/11": (
        "Much is sharp; highlights have six corners",
        {**ROUND, "aperture_fstop": 11.0, "aperture_blades": 6},
        PLAIN,
    ),
    "Anamorphic f/2": (
        "Upright ovals, as of a lens for wide screens",
        {**ROUND, "aperture_fstop": 2.0, "aperture_ratio": 2.0},
        PLAIN,
    ),
    "Bright Bokeh f/1.8": (
        "Lights stand out as discs",
        {**ROUND, "aperture_fstop": 1.8},
        {**PLAIN, "highlight_gain": 3.0, "highlight_threshold": 1.0},
    ),
    "Calm Bokeh f/1.8": (
        "Fireflies and sparkles are tamed before the blur",
        {**ROUND, "aperture_fstop": 1.8},
        {**PLAIN, "highlight_clamp": 4.0},
    ),
    "Cat's Eyes f/1.4": (
        "Round in the middle, lemons in the corners, which grow darker",
        {**ROUND, "aperture_fstop": 1.4},
        {**PLAIN, "cat_eye": 0.7},
    ),
    "Swirl f/1.9": (
        "Old portrait lenses: what is blurred turns around the middle",
        {**ROUND, "aperture_fstop": 1.9},
        {**PLAIN, "swirl": 0.6, "cat_eye": 0.5, "cat_eye_exposure": "keep"},
    ),
    "Old Hexagon f/2.8": (
        "Six blades with slightly round edges",
        {**ROUND, "aperture_fstop": 2.8, "aperture_blades": 6},
        {**PLAIN, "blade_curvature": 0.3},
    ),
    "Tilted Miniature f/0.5": (
        "The lens is tilted: a band through the middle is sharp",
        {**ROUND, "aperture_fstop": 0.5},
        {**PLAIN, "tilt_y": math.radians(-8)},
    ),
    "Miniature f/0.2": (
        "As if all were small",
        {**ROUND, "aperture_fstop": 0.2},
        PLAIN,
    ),
}


# fields of a look of the library that Blender's camera has itself: camera.dof's
OF_CAMERA = {
    "f_stop": "aperture_fstop",
    "blades": "aperture_blades",
    "aperture_ratio": "aperture_ratio",
    "blade_rotation": "aperture_rotation",
}


def lenses():
    """{name: rackfocus.Look}: the library's and those that `rackfocus looks` keeps; and
    what is wrong with the files of others, which are left out.
    """
    with warnings.catch_warnings(record=True) as wrong:
        warnings.simplefilter("always")
        found = {one.name: one for one in rackfocus.looks()}
    return found, [str(one.message) for one in wrong]


def values_of_lens(look):
    """(values of camera.dof, values of camera.rack_focus) of a rackfocus.Look."""
    angles = {p.field for p in rackfocus.parameters() if props.is_angle(p)}
    of_lens, of_settings = dict(ROUND), dict(PLAIN)
    for field, value in look.parameters.items():
        value = math.radians(value) if field in angles else value
        if field in OF_CAMERA:
            of_lens[OF_CAMERA[field]] = value
        elif hasattr(props.CameraSettings, field) or field in of_settings:
            of_settings[field] = value
    return of_lens, of_settings


class RACK_FOCUS_OT_look(bpy.types.Operator):
    """Set f-stop, blades and highlights of the camera"""

    bl_idname = "rack_focus.look"
    bl_label = "Look"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name")

    @classmethod
    def description(cls, _context, properties):
        """The tooltip of the entry."""
        if properties.name in LOOKS:
            return LOOKS[properties.name][0]
        found = lenses()[0].get(properties.name)
        return f"As {found.about}" if found and not found.is_own else cls.__doc__

    @classmethod
    def poll(cls, context):
        """Needs a camera."""
        return camera_of(context) is not None

    def execute(self, context):
        """Sets the values; the focus stays."""
        data = camera_of(context)
        found, _ = lenses()
        if self.name in LOOKS:
            _, of_lens, of_settings = LOOKS[self.name]
        elif self.name in found:
            of_lens, of_settings = values_of_lens(found[self.name])
        else:
            self.report({"ERROR"}, f"There is no look “{self.name}”")
            return {"CANCELLED"}
        for target, values in ((data.dof, of_lens), (data.rack_focus, of_settings)):
            for name, value in values.items():
                setattr(target, name, value)
        return {"FINISHED"}


def camera_of(context):
    """The camera of the Properties editor, else the scene's."""
    data = getattr(context, "camera", None)
    camera = camera_objects.camera_of(context.scene)
    if data is None and camera is not None:
        data = camera.data
    return data


class RACK_FOCUS_OT_preset_add(AddPresetBase, bpy.types.Operator):
    """Add or remove a preset of the camera's aperture and Rack Focus settings"""

    bl_idname = "rack_focus.preset_add"
    bl_label = "Add Rack Focus Preset"
    preset_menu = "VIEW3D_PT_rack_focus_presets"
    preset_subdir = FOLDER
    preset_defines = [
        "dof = bpy.context.camera.dof",
        "settings = bpy.context.camera.rack_focus",
    ]

    @property
    def preset_values(self):
        """Paths of what is stored."""
        names = [p.identifier for p in bpy.context.camera.rack_focus.bl_rna.properties]
        left_out = ("rna_type", "name", "enabled", "distribution_image")
        left_out += ("passes_folder", "is_dof_hidden")
        names = [n for n in names if n not in left_out and not n.startswith("has_")]
        of_lens = ["aperture_fstop", *ROUND]
        return [f"dof.{n}" for n in of_lens] + [f"settings.{n}" for n in names]


class VIEW3D_PT_rack_focus_presets(PresetPanel, bpy.types.Panel):
    """The popover of looks and of the artist's presets."""

    bl_label = "Rack Focus Looks"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "rack_focus.preset_add"

    def draw(self, context):
        """Ours, then theirs."""
        column = self.layout.column(align=True)
        column.emboss = "NONE"
        for name in LOOKS:
            column.operator("rack_focus.look", text=name).name = name
        column.separator()
        found, wrong = lenses()
        for name in found:
            column.operator("rack_focus.look", text=words.title(name)).name = name
        for error in wrong:
            column.label(text=error, icon="ERROR")
        column.operator("rack_focus.make_assets", icon="ASSET_MANAGER")
        if bpy.utils.preset_paths(FOLDER):
            super().draw(context)
            return
        row = self.layout.row(align=True)  # the first of their own
        row.prop(context.window_manager, "preset_name", text="")
        about = row.operator(self.preset_add_operator, text="", icon="ADD")
        about.name = context.window_manager.preset_name


CLASSES = (
    RACK_FOCUS_OT_look,
    RACK_FOCUS_OT_preset_add,
    VIEW3D_PT_rack_focus_presets,
)


def register():
    """Adds the operators and the popover."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    """Removes them."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
