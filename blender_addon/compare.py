# SPDX-License-Identifier: GPL-3.0-or-later
"""rack_focus.compare: our picture beside that of the camera's own lens."""

import bpy
import numpy as np
from bpy.props import FloatProperty, IntProperty

from . import compat, engine, lens, passes, preferences, sampling, slots
from .library import rackfocus
from .operators import scene_of

NAMES = ("Rack Focus", "Rack Focus physical", "Rack Focus difference")
# Black, blue, red, yellow, white at equal steps.
HEAT = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [1, 1, 0], [1, 1, 1]], np.float32)
FULL_HEAT = 0.25  # difference of display values shown as white

last_scores = {}  # of the last comparison, as from rackfocus.compare()


def to_display(picture):
    """Clipped to [0, 1] and to the power of 1/2.2: what tPSNR compares."""
    return np.clip(picture[..., :3], 0, 1) ** (1 / 2.2)


def describe(scores):
    """The figures of rackfocus.compare() in words, those of the command."""
    ratio, place = scores["energy_ratio"], scores["max_error_pixel"]
    return [
        f"tPSNR {scores['tpsnr']:.2f} dB",
        f"PSNR {scores['psnr']:.2f} dB",
        f"SSIM {scores['ssim']:.6f}",
        f"RMSE {scores['rmse']:.6g}",
        "energy ratio " + ("none" if ratio is None else f"{ratio:.6f}"),
        f"maximum error {scores['max_error']:.6g} at pixel {place}",
    ]


def heat_map(a, b):
    """The largest difference of the channels in false colour, (height, width, 4)."""
    difference = np.abs(to_display(a) - to_display(b)).max(-1)
    place = np.clip(difference / FULL_HEAT, 0, 1) * (len(HEAT) - 1)
    low = np.minimum(place.astype(int), len(HEAT) - 2)
    part = (place - low)[..., None]
    colour = HEAT[low] * (1 - part) + HEAT[low + 1] * part
    return np.concatenate([colour, np.ones_like(part)], -1).astype(np.float32)


def show(name, picture):
    """Puts a picture, rows downwards, into an image of Blender's; returns it."""
    height, width = picture.shape[:2]
    image = bpy.data.images.get(name)
    if image is not None and tuple(image.size) != (width, height):
        bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(
            name, width, height, alpha=True, float_buffer=True, is_data=False
        )
    image.pixels.foreach_set(np.ascontiguousarray(picture[::-1]).reshape(-1))
    image.update()
    return image


class Renderer:
    """Renders a small copy of a scene with a camera of its own; leaves no trace."""

    def __init__(self, scene, percentage, samples):
        self.scene = scene.copy()
        self.scene.rack_focus.filter_scene = None
        self.camera = scene.camera.copy()
        self.camera.data = scene.camera.data.copy()
        self.camera.data.rack_focus.enabled = False
        self.scene.camera = self.camera
        self.scene.timeline_markers.clear()
        render = self.scene.render
        render.use_compositing = render.use_sequencer = False
        # Blender renders the scenes that nodes show all the same, of ours the whole frame.
        compat.drop_compositor(self.scene)
        render.use_border = render.use_multiview = False
        render.resolution_percentage = percentage
        if render.engine == "CYCLES":
            sampling.drop_offset(self.scene)
        for owner, name in (("cycles", "samples"), ("eevee", "taa_render_samples")):
            if hasattr(self.scene, owner):
                setattr(getattr(self.scene, owner), name, samples)
        for layer in self.scene.view_layers:
            layer.use_pass_z = True

    def picture(self, use_dof):
        """(colour, depth) of the first view layer that is in use, rows downwards."""
        self.camera.data.dof.use_dof = use_dof
        with slots.last_shown():
            bpy.ops.render.render(scene=self.scene.name)
        layer = next(layer for layer in self.scene.view_layers if layer.use)
        found = passes.rendered(self.scene).layer(layer.name)
        return np.array(found.colour), np.array(found.depth)

    def close(self):
        """Removes what was made."""
        data = self.camera.data
        compat.remove_scene(self.scene)
        bpy.data.objects.remove(self.camera)
        bpy.data.cameras.remove(data)


class RACK_FOCUS_OT_compare(bpy.types.Operator):
    """Render the camera's own depth of field too, and show how far ours is from it"""

    bl_idname = "rack_focus.compare"
    bl_label = "Compare with Physical DoF"

    percentage: IntProperty(
        name="Size", description="Of the picture", subtype="PERCENTAGE",
        min=1, max=100, default=25,
    )  # fmt: skip
    samples: IntProperty(
        name="Samples", description="Per pixel, for both renders", min=1, default=256
    )
    tpsnr: FloatProperty(name="tPSNR", options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        """Needs a camera."""
        return scene_of(context).camera is not None

    def invoke(self, context, _event):
        """Asks for size and samples."""
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        """Renders twice, filters one, shows three images and prints the scores."""
        scene = scene_of(context)
        try:
            pinhole, ours, physical = self._make(scene)
            scores = rackfocus.compare(ours, physical)
            without = rackfocus.compare(pinhole, physical)
        except engine.EXPECTED as error:
            self.report({"ERROR"}, f"Rack Focus: {error}")
            return {"CANCELLED"}
        pictures = (ours, physical, heat_map(ours, physical))
        images = [show(name, p) for name, p in zip(NAMES, pictures, strict=True)]
        self._show_in_editor(context, images[-1])
        self.tpsnr = scores["tpsnr"]
        last_scores.update(scores)
        for name, found in (("Rack Focus", scores), ("No depth of field", without)):
            message = (
                f"{name} against the camera's own depth of field, {self.samples} "
                f"samples: {', '.join(describe(found))}"
            )
            print(message)
            if found is scores:
                self.report({"INFO"}, message)
        return {"FINISHED"}

    def _make(self, scene):
        """Colour of the pinhole, of our filter and of the physical lens."""
        settings = scene.camera.data.rack_focus
        renderer = Renderer(scene, self.percentage, self.samples)
        try:
            colour, depth = renderer.picture(False)
            height, width = depth.shape
            params = lens.frame_parameters(
                renderer.camera, settings, renderer.scene.render, (width, height)
            )
            params.update(settings.light_keywords(), threads=preferences.threads())
            ours = rackfocus.apply(colour, depth, **params)
            physical, _ = renderer.picture(True)
        finally:
            renderer.close()
        return colour, ours, physical

    @staticmethod
    def _show_in_editor(context, image):
        screen = context.screen
        for area in screen.areas if screen else ():
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
                return


def register():
    """Adds the operator."""
    bpy.utils.register_class(RACK_FOCUS_OT_compare)


def unregister():
    """Removes it."""
    bpy.utils.unregister_class(RACK_FOCUS_OT_compare)
