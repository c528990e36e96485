# SPDX-License-Identifier: GPL-3.0-or-later
"""What views take of the computer's memory, for the box."""

from . import denoising

LOUD_BYTES = 4e9  # a computer of 8 GB has no more beside Blender and its system
# Of a pixel of a view, measured as the highest of a whole run, Blender 3.4 and 5.0: 40
# that are kept, 80 while they are merged; with the denoiser 80, and 200 while it runs.
BYTES_PER_PIXEL = 120
BYTES_PER_PIXEL_DENOISED = 280


def describe(scene, n_pixels):
    """Lines on what views of so many pixels in all take, where that is much."""
    is_denoised = denoising.is_asked(scene)
    n_bytes = n_pixels * (BYTES_PER_PIXEL_DENOISED if is_denoised else BYTES_PER_PIXEL)
    if n_bytes < LOUD_BYTES:
        return []
    return [f"The views need some {n_bytes / 1e9:.0f} GB of memory"]
