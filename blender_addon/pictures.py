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


def to_shown(linear):
    """The sRGB encoding of colour values, (..., n), which may exceed 1."""
    colour = np.clip(linear, 0, None)
    low = colour <= 0.0031308
    return np.where(low, colour * 12.92, 1.055 * colour ** (1 / 2.4) - 0.055)


def for_view_transform(picture):
    """A premultiplied scene-linear (height, width, 4) picture for Blender's 3D views.

    They encode it without dividing by alpha before, so that half-transparent edges
    would shine: their colour becomes what is encoded as alpha times the whole colour's.
    """
    alpha = picture[..., 3]
    is_soft = (alpha > 0) & (alpha < 1)
    if not is_soft.any():
        return picture
    made = picture.copy()
    share = alpha[is_soft][:, None]
    whole = to_shown(picture[is_soft][:, :3] / share)
    made[is_soft, :3] = to_linear(whole * share)
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
