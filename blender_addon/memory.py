# SPDX-License-Identifier: GPL-3.0-or-later
"""What views take of the computer's memory, for the box."""

from . import denoising

LOUD_BYTES = 4e9  # a computer of 8 GB has no more beside Blender and its system
# Of a pixel of a view, measured as the highest of a whole run, Blender 3.4 and 5.0: 40
# that are kept, 80 while they are merged; with the denoiser 80, and 200 while it runs.
BYTES_PER_PIXEL = 120
BYTES_PER_PIXEL_DENOISED = 280
BYTES_PER_PIXEL_OF_ONE = 250  # with Clean Edges; 190 without


def needed(scene, n, n_pixels):
    """Bytes that n views of so many pixels each take; one is cleaned by Cycles."""
    if n == 1:
        return n_pixels * BYTES_PER_PIXEL_OF_ONE
    is_denoised = denoising.is_asked(scene)
    per_pixel = BYTES_PER_PIXEL_DENOISED if is_denoised else BYTES_PER_PIXEL
    return n * n_pixels * per_pixel


def describe(scene, n, n_pixels):
    """Lines on what n views of so many pixels each take, where that is much."""
    n_bytes = needed(scene, n, n_pixels)
    if n_bytes < LOUD_BYTES:
        return []
    return [f"The views need some {n_bytes / 1e9:.0f} GB of memory"]
