# SPDX-License-Identifier: GPL-3.0-or-later
"""Fog and other volumes: what they leave without depth.

Cycles takes the depth of a pixel's first sample. Where a volume scatters that sample,
the pixel has none, although something lies behind it, and would be blurred like the sky.
Scenes with volumes have such holes filled from what is around them, as `rackfocus filter`
does; others are left alone, whatever they look like.
"""

import numpy as np

from . import sets, shining
from .library import rackfocus
from .passes import NOTHING_HIT

# Of the pixels with depth, those that have at most one neighbour with depth. After filling
# a floor in fog has 0.1 % where half of it had depth, 0.6 % of a quarter, 2.8 % of an
# eighth, and then much is left without.
MOST_LONE = 0.015


def has_volume(scene):
    """Does a render of a scene show a volume?"""
    if scene.render.engine != "CYCLES":
        return False
    if _has_link(scene.world, "OUTPUT_WORLD"):
        return True
    seen = set()
    for layer in sets.layers_of(scene):
        for item in layer.objects:
            if item is None or item.hide_render:  # None: just removed
                continue
            if item.type == "VOLUME":
                return True
            seen |= shining.materials_of(item)
    return any(_has_link(material, "OUTPUT_MATERIAL") for material in seen)


def _has_link(owner, output):
    """Does a world or material lead to the socket Volume?"""
    tree = owner.node_tree if owner is not None else None
    nodes = tree.nodes if tree is not None else ()
    return any(n.type == output and n.inputs["Volume"].is_linked for n in nodes)


def filled(found, scene):
    """The views of a view layer, [(passes.Layer, passes.Place)], with holes filled."""
    if not has_volume(scene):
        return found
    return [(_filled(layer), place) for layer, place in found]


def _filled(layer):
    if layer.depth is None:
        return layer
    depth = np.array(layer.depth, np.float32)
    rackfocus.fill_depth(depth, layer.colour, infinity=NOTHING_HIT, always=True)
    return layer._replace(depth=depth)


def why_wrong(found, scene):
    """What the user is told of fog that hides what lies in it; "": nothing."""
    depths = [layer.depth for layer, _ in found if layer.depth is not None]
    if not depths or not has_volume(scene):
        return ""
    share = max(lone_share(depth) for depth in depths)
    if share < MOST_LONE:
        return ""
    return (
        "a volume hides the depth of what lies deep in it, which is blurred like the "
        "sky: take the method Accumulate, or render the volume in a view layer of its "
        "own"
    )


def lone_share(depth):
    """Of the pixels with depth, those that stand alone or as two."""
    has = np.pad(depth < NOTHING_HIT, 1).astype(np.uint8)
    if not has.any():
        return 0.0
    height, width = depth.shape
    n_around = sum(
        has[1 + dy : 1 + dy + height, 1 + dx : 1 + dx + width]
        for dy in (-1, 0, 1)
        for dx in (-1, 0, 1)
    )
    return float((n_around <= 2)[has[1:-1, 1:-1] == 1].mean())
