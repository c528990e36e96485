# SPDX-License-Identifier: GPL-3.0-or-later
"""Halos of bright things over a transparent film, before a far blur that is large.

A pixel on their rim that is mostly transparent has no depth; unless Film Depth is All, its
light is blurred as from infinity. Where that blur is a large part of the picture, much
light on rims is seen as a halo far around them. The picture's message says what to set.
"""

import numpy as np

from .passes import FAR, NOTHING_HIT

# Alpha up to which pixels without depth stay so, by Film Depth.
MOST_ALPHA = {"keep": 0.99, "solid": 0.5, "all": 0.0}
LEAST_LIGHT = 0.005  # without depth, as a mean of the picture, in whites
LEAST_RADIUS = 0.08  # of the far blur, of the picture's longer side

MESSAGE = (
    "rims over the transparent film have no depth, and a halo of the far blur: set Film "
    "Depth to All"
)


def why_wrong(colour, depth, made, params):
    """What the user is told of such a picture; "": nothing.

    colour: (height, width, 4), premultiplied; depth: (height, width); made: the
    rackfocus.Filter of params.
    """
    alpha = colour[..., 3]
    is_lost = (depth >= NOTHING_HIT) & (alpha > 0)
    is_lost &= alpha <= MOST_ALPHA[params.get("film_depth", "keep")]
    if abs(made.lens.radius_px(FAR)) < LEAST_RADIUS * max(depth.shape):
        return ""
    lost = np.minimum(colour[..., :3][is_lost].max(-1), params["white"]).sum()
    return MESSAGE if lost > LEAST_LIGHT * params["white"] * depth.size else ""
