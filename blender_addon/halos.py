# SPDX-License-Identifier: GPL-3.0-or-later
"""Halos of bright things over a transparent film, before a far blur that is large.

What is partly transparent may have no depth; where Film Depth gives it none, its light is
blurred as from infinity. Where that blur is a large part of the picture, much of such
light is seen as a halo far around. The picture's message says what to set.
"""

import numpy as np

from .passes import FAR, NOTHING_HIT

REACH = {"solid": 2, "all": 2}  # px, of rf_film_fill()
EMPTY = 0.02  # alpha of what shows nothing, likewise
LEAST_LIGHT = 0.005  # without depth, as a mean of the picture, in whites
LEAST_RADIUS = 0.08  # of the far blur, of the picture's longer side

RIMS = (
    "rims over the transparent film have no depth, and a halo of the far blur: set Film "
    "Depth to Edges"
)
VEILS = (
    "much that is partly transparent has no depth, and a halo of the far blur: lower "
    "View Layer > Passes > Data > Alpha Threshold; smoke: render it as a layer of its own"
)


def _around(mask, reach):
    """Where a pixel at most `reach` px away in x and y is set."""
    for axis in (0, 1):
        wide = mask.copy()
        for step in range(1, min(reach, mask.shape[axis] - 1) + 1):
            ahead = [slice(None)] * 2
            behind = [slice(None)] * 2
            ahead[axis], behind[axis] = slice(step, None), slice(None, -step)
            wide[tuple(ahead)] |= mask[tuple(behind)]
            wide[tuple(behind)] |= mask[tuple(ahead)]
        mask = wide
    return mask


def _lost(alpha, depth, choice):
    """Pixels that show something and stay without depth."""
    is_missing = depth >= NOTHING_HIT
    is_lost = is_missing & (alpha > 0)
    if choice == "keep":
        return is_lost
    reach = REACH.get(choice, min(max(max(depth.shape) // 30, 8), 64))
    is_given = _around(~is_missing, reach)
    if choice == "solid":
        is_given &= alpha > 0.5
    elif choice == "edges":
        is_given &= _around(is_missing & (alpha < EMPTY), reach)
    return is_lost & ~is_given


def why_wrong(colour, depth, made, params):
    """What the user is told of such a picture; "": nothing.

    colour: (height, width, 4), premultiplied; depth: (height, width); made: the
    rackfocus.Filter of params.
    """
    if abs(made.lens.radius_px(FAR)) < LEAST_RADIUS * max(depth.shape):
        return ""
    choice = params.get("film_depth", "keep")
    is_lost = _lost(colour[..., 3], depth, choice)
    lost = np.minimum(colour[..., :3][is_lost].max(-1), params["white"]).sum()
    if lost <= LEAST_LIGHT * params["white"] * depth.size:
        return ""
    return RIMS if choice in ("keep", "solid") else VEILS
