# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of cameras and scenes; those of the filter come from the core's table."""

import math

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import compat, lens, parts, pictures, running, setup, walked, words, writing
from .library import rackfocus

OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}
LENS_POINTS = ("lens_pattern", "lens_random", "lens_seed")
# What the camera does not have, beside the parameters of the methods.
FIRST_VIEWS = 8  # of a camera that gets a method of several views
OF_OTHER_GROUPS = ("coc_limit", "film_depth")
OF_THE_SCENE = ("quality", "white")


def _find(field):
    """The line of the table with a field, or None."""
    return next((p for p in rackfocus.parameters() if p.field == field), None)


def _qualities(table):
    """(items of the property, default, {name: keywords of the filter or None}).

    table: the table's line `quality`, whose choices it takes. "custom", without
    keywords of its own, shows every parameter.
    """
    names = [*(c.name for c in table.choices), "custom"]
    items = [(n, n.capitalize(), words.QUALITIES.get(n, "")) for n in names]
    presets = {c.name: {"quality": c.name} for c in table.choices}
    return items, table.default, {**presets, "custom": None}


QUALITY_ITEMS, DEFAULT_QUALITY, QUALITIES = _qualities(_find("quality"))


def look_table():
    """What a lens has and Blender's camera does not: blade curvature and the like.

    The first rows of the table are what a camera and a file say. What came later stands
    after them, whatever its group is.
    """
    table = rackfocus.parameters()
    last = max(i for i, p in enumerate(table) if p.field == "quality")
    return [p for p in table[last + 1 :] if p.group != "method"]


def plain_look():
    """{field: value} of a lens without any look, as properties have it."""
    return {
        p.field: math.radians(p.default) if is_angle(p) else p.default
        for p in look_table()
    }


def has_look(settings):
    """Has the lens a look that its method reads?"""
    if settings.use_aperture_image and settings.takes_aperture_image():
        return True
    plain = plain_look()
    set_here = [f for f, value in plain.items() if getattr(settings, f) != value]
    return any(is_read(settings, field) for field in set_here)


def method_table():
    """The parameters that the camera does not have and that are a property here."""
    looks = {p.field for p in look_table()}
    return [
        p
        for p in rackfocus.parameters()
        if p.field not in OF_THE_SCENE
        and (p.group == "method" or p.field in OF_OTHER_GROUPS or p.field in looks)
    ]


def always():
    """Fields that count whatever the quality is."""
    looks = [p.field for p in look_table()]
    return ("method", "max_radius", *OF_OTHER_GROUPS, *LENS_POINTS, *looks)


def is_angle(p):
    """Is a parameter an angle? Blender has radians, the table degrees."""
    return p.unit == "degrees"


def values_of(settings):
    """{field: value} of the properties that come from the table, in its units.

    Blender's floats have fewer bits: the ends of a range may lie outside of it.
    """
    found = {}
    for p in method_table():
        value = getattr(settings, p.field)
        if p.type == "float":
            value = math.degrees(value) if is_angle(p) else value
            value = min(max(value, p.min), p.max)
        found[p.field] = value
    return found


def is_read(settings, field):
    """Has a field an effect with the camera's other settings?"""
    if field == "method":
        return True
    values = {**lens.aperture_parameters(settings.id_data.dof), **values_of(settings)}
    return not rackfocus.why_not_read(field, **values)


def method_items():
    """The methods as items of a menu, those up front first."""
    names = [method.name for method in rackfocus.methods()]
    order = [*words.METHODS, *(n for n in names if n not in words.METHODS)]
    found = []
    for name in (n for n in order if n in names):
        label, about = words.METHODS.get(name, (words.title(name), ""))
        found.append((name, label, about, names.index(name)))
    return found


def _choices(p):
    """Items of an enum property."""
    if p.field == "method":
        return method_items()
    return [
        (c.name, words.title(c.name), words.CHOICES.get((p.field, c.name), c.help))
        for c in p.choices
    ]


def _property(p):
    """A Blender property for one line of the table."""
    label, about = words.FIELDS.get(p.field, (words.title(p.field), p.help))
    about = dict(name=label, description=about.rstrip("."), default=p.default)
    about["override"] = OVERRIDABLE
    if p.type == "enum":
        update = _method_changed if p.field == "method" else None
        return EnumProperty(items=_choices(p), update=update, **about)
    if p.type == "bool":
        return BoolProperty(**about)
    kind = IntProperty if p.type == "int" else FloatProperty
    low, high = p.min, p.max
    if is_angle(p):
        about["subtype"], about["default"] = "ANGLE", math.radians(p.default)
        low, high = math.radians(low), math.radians(high)
    elif p.unit == "px":
        about["subtype"] = "PIXEL"
    elif p.unit == "scene units":
        about["unit"] = "LENGTH"
    return kind(min=low, max=high, **about)


def _method_changed(settings, _context):
    """Views of one view would be a plain picture."""
    if settings.method in ("views", "accumulate") and settings.views < 2:
        settings.views = FIRST_VIEWS


def _switch(field, start):
    """The tick of a field whose 0 is no value; it is the field itself."""
    label, _ = words.FIELDS[field]
    return BoolProperty(
        name=f"Set {label}",
        description=words.OFF.get(field, f"Off: {label} is chosen by Rack Focus"),
        get=lambda self: getattr(self, field) > 0,
        set=lambda self, value: setattr(self, field, start if value else 0),
    )


def _tick(data):
    """`enabled` of a camera has changed; what a render needs stays until its end."""
    if running.is_any():
        running.put_off_tick(_follow_ticks)
    else:
        setup.camera_changed(data)


def _follow_ticks():
    for scene in setup.user_scenes():
        setup.refresh(scene)


class CameraSettings(bpy.types.PropertyGroup):
    """camera.data.rack_focus"""

    enabled: BoolProperty(
        override=OVERRIDABLE,
        name="Rack Focus",
        description="Make this camera's depth of field after the render",
        update=lambda self, _context: _tick(self.id_data),
    )
    quality: EnumProperty(
        override=OVERRIDABLE,
        name="Quality",
        description=words.FIELDS["quality"][1],
        items=QUALITY_ITEMS,
        default=DEFAULT_QUALITY,
    )
    views: IntProperty(
        override=OVERRIDABLE,
        name="Views",
        description="Renders from so many points of the lens. 1 is a single render. "
        "Final and Views merge 64 at most, Accumulate takes the mean of any number",
        min=1,
        max=1024,
        soft_max=64,
        default=1,
    )
    view_samples: IntProperty(
        override=OVERRIDABLE,
        name="Samples a View",
        description="Of the render engine. 0 shares the scene's samples out among the "
        "views, which takes the time of one render",
        min=0,
        soft_max=1024,
        default=0,
    )
    denoise_together: BoolProperty(
        override=OVERRIDABLE,
        name="Denoise Together",
        description="Where Cycles' denoiser is on, clean views by what the others show "
        "of the same points, with Open Image Denoise on the processor. Off: Cycles "
        "cleans each view by itself",
        default=True,
    )
    supersample: IntProperty(
        override=OVERRIDABLE,
        name=words.FIELDS["supersample"][0],
        description=words.FIELDS["supersample"][1],
        min=0,
        max=parts.MOST,
        default=0,
    )
    overscan: FloatProperty(
        override=OVERRIDABLE,
        name="Overscan",
        description="Beyond each side, in percent of the width and the height: what lies "
        "there is rendered, too, and blurred into the picture as it is. 0: it is guessed "
        "from what is at the border",
        subtype="PERCENTAGE",
        min=0,
        max=25,
        soft_max=10,
        precision=1,
        default=0,
    )
    clean_edges: BoolProperty(
        override=OVERRIDABLE,
        name="Clean Edges",
        description="Render Cycles' denoising data, too, whose depth tells how much of a "
        "pixel each thing at an edge covers. Thin things keep their outlines, for 2 % of "
        "Cycles' time; several views take a quarter more memory",
        default=True,
    )
    mirrors: BoolProperty(
        override=OVERRIDABLE,
        name="Mirrors and Glass",
        description="What flat mirrors and panes show is blurred by its own distance, "
        "not by that of their surface. The next render has Cycles' light passes and "
        "denoising data for that",
    )
    finish_samples: IntProperty(
        override=OVERRIDABLE,
        name="Finish Samples",
        description="Samples for each pixel that Finish renders with the camera's own "
        "lens",
        min=1,
        soft_max=1024,
        default=64,
    )
    use_finish: BoolProperty(
        override=OVERRIDABLE,
        name="Finish Every Render",
        description="Every render is finished, those of animations too",
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
    use_aperture_image: BoolProperty(
        override=OVERRIDABLE,
        name="Aperture Image",
        description="Highlights take the shape of a picture, in its colours",
    )
    distribution_image: PointerProperty(
        override=OVERRIDABLE,
        name="Picture of the Aperture",
        description="As the camera sees it: light passes where it is bright",
        type=bpy.types.Image,
    )
    passes_folder: StringProperty(
        override=OVERRIDABLE,
        name="Keep Passes",
        description="Folder for the passes of every frame and view as EXR files: "
        "Refocus finds them when the file opens again. Empty: none",
        subtype="DIR_PATH",
        options=compat.PATH_OPTIONS,
    )
    front_blur: FloatProperty(
        override=OVERRIDABLE,
        name="Front Blur",
        description="Part of the lens's blur that what is nearer than the focus has",
        subtype="FACTOR",
        min=0,
        max=1,
        default=1,
    )
    back_blur: FloatProperty(
        override=OVERRIDABLE,
        name="Back Blur",
        description="Part of the lens's blur that what is farther than the focus has",
        subtype="FACTOR",
        min=0,
        max=1,
        default=1,
    )
    is_dof_hidden: BoolProperty(
        description="Earlier versions had the camera's own depth of field off while a "
        "render ran, also in a file saved then",
        options={"HIDDEN"},
    )

    def lens_parameters(self):
        """Where on the lens the views are taken, as keywords of rackfocus."""
        return {name: getattr(self, name) for name in LENS_POINTS}

    def takes_aperture_image(self):
        """Has the aperture's picture an effect with the method?"""
        if self.method == "scatter":
            return True
        return not rackfocus.why_not_read(
            "aperture", **{**values_of(self), "aperture": "image"}
        )

    def light_keywords(self):
        """Keywords of rackfocus.Filter: the picture that light is spread by; or {}."""
        params = self.method_parameters()
        spread = params["method"], params.get("distribution")
        is_distribution = spread == ("scatter", "image")
        is_aperture = self.use_aperture_image and self.takes_aperture_image()
        if not is_distribution and not is_aperture:
            return {}
        if self.distribution_image is None:
            what = "Distribution “Image”" if is_distribution else "Aperture Image"
            raise pictures.PictureError(
                f"{what} needs a picture: choose a Picture of the Aperture"
            )
        picture = {"distribution_image": pictures.read(self.distribution_image)}
        is_scatter = self.method == "scatter"
        return picture if is_scatter else {"aperture": "image", **picture}

    def method_parameters(self):
        """The fields as keywords of rackfocus.Filter."""
        values = values_of(self)
        preset = QUALITIES[self.quality]
        if preset is None:
            return values
        return {**{key: values[key] for key in always()}, **preset}


for _parameter in method_table():
    CameraSettings.__annotations__[_parameter.field] = _property(_parameter)
for _field, _start in words.AUTOMATIC.items():
    CameraSettings.__annotations__[f"has_{_field}"] = _switch(_field, _start)


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
    is_own_lens: BoolProperty(
        description="A copy that renders with the camera's own lens",
        options={"HIDDEN"},
    )
    is_automatic: BoolProperty(
        name="Refocus by Itself",
        description="Filter the last render again when the focus, the lens or a "
        "setting of Rack Focus changes",
    )
    is_tap: BoolProperty(
        description="A scene for a moment, in which a node's inputs are computed",
        options={"HIDDEN"},
    )
    nodes_off: PointerProperty(
        description="Compositing nodes that were switched off, from 5.0 on",
        type=bpy.types.NodeTree,
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
    # No group of properties: 5.0 reports errors for those of overridden objects.
    bpy.types.Object.rack_focus_keep_sharp = BoolProperty(
        override=OVERRIDABLE,
        name="Keep Sharp",
        description="Rack Focus does not blur this object, whatever its distance. Takes "
        "effect with the next render",
        update=lambda _self, _context: walked.forget(),  # the depsgraph is told nothing
    )
    bpy.types.Scene.rack_focus = PointerProperty(type=SceneState)
    bpy.types.NodeTree.rack_focus = PointerProperty(type=NodeSettings)


def unregister():
    """Takes them away."""
    del bpy.types.NodeTree.rack_focus
    del bpy.types.Scene.rack_focus
    del bpy.types.Object.rack_focus_keep_sharp
    del bpy.types.Camera.rack_focus
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
