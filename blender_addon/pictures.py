# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images as arrays."""

import numpy as np


class PictureError(Exception):
    """An image cannot be read; the message is for the user."""


def to_linear(shown):
    """Inverse of the sRGB encoding, of the colour values; alpha stays."""
    linear = shown.copy()
    colour = np.clip(shown[..., :3], 0, None)
    low = colour <= 0.04045
    linear[..., :3] = np.where(low, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    return linear


def for_view(picture, alpha_before, background):
    """A premultiplied scene-linear (height, width, 4) picture for Blender's 3D views.

    A view shows c + (1 - alpha_before) b, linear light where the view transform is
    sRGB: the background b stands behind what was drawn before. What should be seen is
    c + (1 - alpha) b. Where that is darker than b can be, b stays.

    alpha_before: (height, width); background: linear, for broadcasting with (height,
    width, 3).
    """
    more = alpha_before[..., None] - picture[..., 3:]
    if not more.any():
        return picture
    made = picture.copy()
    made[..., :3] = np.maximum(picture[..., :3] + more * background, 0)
    return made


def read(image):
    """Scene-linear (height, width, 3) float32 of an image, rows downwards."""
    width, height = image.size
    if not width or not height:
        raise PictureError(f"the image “{image.name}” cannot be read: {image.filepath}")
    values = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    pixels = values.reshape(height, width, image.channels)[::-1]
    pixels = pixels[..., :3] if image.channels > 2 else pixels[..., [0, 0, 0]]
    if not image.is_float and image.colorspace_settings.name.startswith("sRGB"):
        pixels = to_linear(pixels)
    return np.ascontiguousarray(pixels)
