# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures out of 3D views and back onto them."""

import contextlib
import inspect

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d

HAS_DPI = bpy.app.version < (4, 0, 0)  # blf.size() takes it
FONT_PX = 14
# What is drawn on a view is encoded as sRGB before 5.0 (measured on 3.4 and 5.2; the
# argument that came with the change tells).
VIEW_ENCODES = (
    "is_scene_linear_with_rec709_srgb_target"
    not in inspect.signature(draw_texture_2d).parameters
)


class ViewError(Exception):
    """The view cannot be had; the message is for the user."""


class NotReady(ViewError):
    """The view has nothing to show yet: its shaders are being made."""


def is_foreign(context):
    """Is the view drawn by an engine whose picture Blender keeps from add-ons?"""
    if context.space_data.shading.type != "RENDERED":
        return False
    engine = context.scene.render.engine
    return not engine.startswith(("BLENDER_EEVEE", "BLENDER_WORKBENCH"))


@contextlib.contextmanager
def without_overlays(space):
    """Grid, outlines and gizmos of a 3D view off: they would be blurred with it."""
    overlay = space.overlay
    was_shown = overlay.show_overlays
    if was_shown:
        overlay.show_overlays = False
    try:
        yield
    finally:
        if was_shown:
            overlay.show_overlays = True


class Grabber:
    """Draws a 3D view into memory of its own, at one size."""

    def __init__(self, width, height):
        self.width, self.height = width, height
        self._offscreen = gpu.types.GPUOffScreen(width, height)

    def grab(self, context):
        """(colour, depth buffer) of the context's view, rows downwards.

        colour: (height, width, 4) as it is shown, display-referred; depth: (height,
        width) in [0, 1].
        """
        if is_foreign(context):
            raise ViewError(
                "Blender shows add-ons nothing of this engine's preview: use Material "
                "Preview, or EEVEE"
            )
        view = context.region_data
        with without_overlays(context.space_data):
            self._offscreen.draw_view3d(
                context.scene, context.view_layer, context.space_data, context.region,
                view.view_matrix, view.window_matrix, do_color_management=True,
            )  # fmt: skip
        with self._offscreen.bind():
            frame = gpu.state.active_framebuffer_get()
            place = (0, 0, self.width, self.height)
            colour = frame.read_color(*place, 4, 0, "FLOAT")
            depth = frame.read_depth(*place)
        n = self.width * self.height
        colour.dimensions, depth.dimensions = 4 * n, n  # 3.4 gives them false strides
        colour = np.asarray(colour).reshape(self.height, self.width, 4)
        depth = np.asarray(depth).reshape(self.height, self.width)
        if not depth.any():
            raise NotReady("the view is not ready yet")
        return colour[::-1], depth[::-1]

    def free(self):
        """Gives the memory back."""
        self._offscreen.free()


def _texture_of(pixels):
    """A texture of (height, width, 4) values, rows upwards."""
    height, width = pixels.shape[:2]
    pixels = np.ascontiguousarray(pixels, np.float32)
    data = gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1))
    return gpu.types.GPUTexture((width, height), format="RGBA32F", data=data)


def _draw_texture(texture, width, height):
    gpu.state.blend_set("NONE")
    draw_texture_2d(texture, (0, 0), width, height)


def to_linear(shown):
    """Inverse of the sRGB encoding, of colour values; alpha stays."""
    linear = shown.copy()
    colour = np.clip(shown[..., :3], 0, None)
    low = colour <= 0.04045
    linear[..., :3] = np.where(low, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    return linear


def to_texture(picture):
    """A texture for draw_over() of a (height, width, 4) picture as it is to be shown.

    Rows downwards.
    """
    return _texture_of((to_linear(picture) if VIEW_ENCODES else picture)[::-1])


def draw_over(region, texture):
    """Covers a region with a texture."""
    _draw_texture(texture, region.width, region.height)


def draw_message(text):
    """One line at the lower left."""
    blf.size(0, FONT_PX, *([72] if HAS_DPI else []))
    blf.color(0, 1, 0.75, 0.3, 1)
    blf.position(0, 20, 20, 0)
    blf.draw(0, f"Rack Focus: {text}")
