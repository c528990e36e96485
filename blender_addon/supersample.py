# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes at N times the size with an N^2-th of the samples, filtered, and shrunk.

A pixel on an edge holds two surfaces and one depth. N^2 pixels in its place are nearly
all of one surface, at the same cost for the renderer. Blender renders the scenes of a
compositor at one size; so N^2 views are rendered whose cameras are shifted by parts of
a pixel, through a pixel filter as narrow as these parts, and put together like the
pixels of a larger picture. What the filter makes of that is brought to the asked size
through the pixel filter of the scene: the lens and the pixel filter are both sums of
light, so that their order does not matter.

    weight of the offset x, in px of the asked size: f(x k), k < 1/width such that the
    variance of f and of what the passes have are together that of the scene's filter

The passes have that of a box of 1/N px; where sampling.py moves the views within these
parts, that of its disc and of placing them between parts.
"""

import numpy as np

from . import lens

PLACING = 1 / 6  # variance of placing anywhere between two pixels by both, px^2
# Of what moved views have, so much is made up for: eight denoised views of 64 samples of
# fine textures in focus like less (plane +0.5 dB, foliage +0.7), rims of lamps more (posts
# -0.1), measured by the command (app/filter/filter_shrink.c, docs/notebook/rivals.md).
MADE_UP_FOR = 0.85


# ---- rendering ------------------------------------------------------------------


def prepare(copy, scale):
    """Lets a copy of a scene render parts of pixels; 1: whole ones, as sampling.py says."""
    if scale < 2:
        return
    copy.cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    spread = _variance(_blackman_harris)
    copy.cycles.filter_width = np.sqrt(1 / (12 * scale**2) / spread)


def shift_of(camera, render, scale, part):
    """(x, y) that a camera's shift needs for one of the N^2 parts of its pixels.

    camera: its data; part: number of the part, row by row from the upper left.
    """
    width, height = lens.picture_size(render)
    aspect = render.pixel_aspect_y / render.pixel_aspect_x
    is_wide = width >= height * aspect
    if camera.sensor_fit != "AUTO":
        is_wide = camera.sensor_fit == "HORIZONTAL"
    side = width if is_wide else height * aspect  # px, of the fitted side
    row, column = divmod(part, scale)
    right = (column + 0.5) / scale - 0.5
    down = (row + 0.5) / scale - 0.5
    return right / side, -down * aspect / side


def together(planes, scale):
    """One (N height, N width, ...) array of the N^2 parts' (height, width, ...)."""
    height, width = planes[0].shape[:2]
    rest = planes[0].shape[2:]
    made = np.empty((height * scale, width * scale, *rest), np.float32)
    for part, plane in enumerate(planes):
        row, column = divmod(part, scale)
        made[row::scale, column::scale] = plane
    return made


def scale_of(size, render):
    """N of passes of a size (width, height) for the frame of render settings."""
    whole = lens.picture_size(render)
    scale = size[0] // whole[0]
    is_exact = scale > 1 and size == (scale * whole[0], scale * whole[1])
    return scale if is_exact else 1


# ---- shrinking --------------------------------------------------------------------


def _blackman_harris(x):
    """Of x from -1 to 1; Cycles' width is half of the whole."""
    a = np.pi * (x + 1)
    return (
        0.35875
        - 0.48829 * np.cos(a)
        + 0.14128 * np.cos(2 * a)
        - 0.01168 * np.cos(3 * a)
    )


def _gaussian(x):
    """Cycles cuts at three of its half widths."""
    return np.exp(-18 * x * x)


def _variance(function):
    """Of a function over -1 to 1."""
    x = np.linspace(-1, 1, 2001)
    f = function(x)
    return float((f * x * x).sum() / f.sum())


# name: (function, its reach in widths)
FILTERS = {"BLACKMAN_HARRIS": (_blackman_harris, 1.0), "GAUSSIAN": (_gaussian, 1.5)}


def _variance_of_passes(scale, spread_px):
    """On each axis, px^2 of the asked size."""
    if not spread_px:
        return 1 / (12 * scale**2)
    return spread_px**2 / 4 + PLACING / scale**2


def leaves_room(scene, scale, spread_px):
    """Is the pixel filter of a scene wider than moved views and the narrowest way to
    shrink them are together?"""
    kind, width = scene.cycles.pixel_filter_type, scene.cycles.filter_width
    if kind not in FILTERS:
        return False
    function, reach = FILTERS[kind]
    narrowest = 0 if scale % 2 else (0.5 / scale) ** 2
    least = _variance_of_passes(scale, spread_px) + narrowest
    return (reach * width) ** 2 * _variance(function) >= least


def weights(scale, kind, width, spread_px=0.0):
    """Weights of the pixels of a side, from the leftmost, which sum to 1.

    kind, width: Cycles' pixel_filter_type and filter_width; spread_px: of views that are
    moved within the parts of their pixels, 0: they are not.
    """
    if kind not in FILTERS:
        return np.full(scale, 1 / scale, np.float32)
    function, reach = FILTERS[kind][0], FILTERS[kind][1] * width
    variance = reach**2 * _variance(function)
    share = MADE_UP_FOR if spread_px else 1
    left = 1 - share * _variance_of_passes(scale, spread_px) / variance
    reach *= np.sqrt(max(left, 0.1))
    half = max(int(np.ceil(reach * scale)), 1)
    # Pixels lie half a step off the middle of an even block.
    steps = (
        np.arange(-half, half) + 0.5 if scale % 2 == 0 else np.arange(-half, half + 1)
    )
    at = steps / scale
    found = np.where(np.abs(at) < reach, function(np.clip(at / reach, -1, 1)), 0)
    if not found.any():  # a filter that is narrower than the parts
        found = (np.abs(steps) == 0.5).astype(float)
    return (found / found.sum()).astype(np.float32)


def shrink(picture, scale, taps):
    """A (height, width, n) picture at an N-th of its size; edges are repeated."""
    for axis in (0, 1):
        picture = _shrink_side(picture, scale, taps, axis)
    return picture


def _shrink_side(picture, scale, taps, axis):
    picture = np.moveaxis(picture, axis, 0)
    more = (len(taps) - scale) // 2  # before the first pixel of the block
    n = len(picture) // scale
    made = np.zeros((n, *picture.shape[1:]), np.float32)
    for index, weight in enumerate(taps):
        rows = np.clip(np.arange(n) * scale + index - more, 0, len(picture) - 1)
        made += weight * picture[rows]
    return np.moveaxis(made, 0, axis)


def taps_of(scene, scale, spread_px=0.0):
    """weights() for the pixel filter of a scene."""
    cycles = scene.cycles
    return weights(scale, cycles.pixel_filter_type, cycles.filter_width, spread_px)


def middle(plane, scale):
    """Every N-th value, next to the middle of its block."""
    return plane[scale // 2 :: scale, scale // 2 :: scale]


def to_size(scene, scale, picture, coc, spread_px=0.0):
    """A filtered picture and its CoC at the asked size; rows upwards as they come.

    spread_px: of the places of the views.
    """
    small = shrink(picture[::-1], scale, taps_of(scene, scale, spread_px))[::-1]
    coc = middle(coc[::-1], scale)[::-1] / scale
    return np.ascontiguousarray(small), np.ascontiguousarray(coc)
