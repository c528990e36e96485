# SPDX-License-Identifier: GPL-3.0-or-later
"""What views take of the computer's memory, for the box."""

from . import denoising, overscan, shares

LOUD_BYTES = 4e9  # a computer of 8 GB has no more beside Blender and its system
# Of a pixel of a view, measured as the highest of a whole run, Blender 3.4 and 5.0: 40
# that are kept, 80 while they are merged; with the denoiser 80, and 200 while it runs.
BYTES_PER_PIXEL = 120
BYTES_PER_PIXEL_DENOISED = 280
# More of Clean Edges: 28 of Blender's passes, and 4 that are kept; 33 and 35 measured.
BYTES_PER_PIXEL_EDGES = 32
BYTES_PER_PIXEL_OF_ONE = 250  # with Clean Edges; 190 without


def needed(scene, n, n_pixels):
    """Bytes that n views of so many pixels each take; one is cleaned by Cycles, and may have
    the margin of overscan.py."""
    if n == 1:
        return n_pixels * overscan.area(scene) * BYTES_PER_PIXEL_OF_ONE
    each = BYTES_PER_PIXEL
    if denoising.is_asked(scene):
        each = BYTES_PER_PIXEL_DENOISED
    elif shares.is_wanted(scene):
        each += BYTES_PER_PIXEL_EDGES
    return n * n_pixels * each


def describe(scene, n, n_pixels):
    """Lines on what n views of so many pixels each take, where that is much."""
    n_bytes = needed(scene, n, n_pixels)
    if n_bytes < LOUD_BYTES:
        return []
    return [f"The views need some {n_bytes / 1e9:.0f} GB of memory"]
