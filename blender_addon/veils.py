# SPDX-License-Identifier: GPL-3.0-or-later
"""Panes, plastics and veils before a plain sky.

Cycles' depth leaves a surface out where its alpha lies below the view layer's Passes > Data >
Alpha Threshold (0.5). Before the sky such a surface is then blurred like that: cubes of which
half had an alpha of 0.3 scored 34.3 dB (own lens 43.1), with a threshold of 0.01 40.4. Before
other things nothing is lost (alphas of 0.05 to 0.9 before a checker 33.4 to 35.0, opaque cubes
33.1, and 30.5 to 33.4 with that threshold), so that materials alone do not tell. The picture
does by Cycles' Denoising Depth, which has something where the depth has nothing; but so it
is with hair that covers little of its pixels. Both together are told. What a volume leaves
without depth is told by fog.py, and what a transparent film shows by halos.py. In Blender 5.2
rays that hit nothing are endless, not 0, as are the means of pixels with one of them: there
Denoising Normal tells, whose mean is 0 in the sky alone. Before, it is 0 in a veil too, as
Cycles waits for the next bounce where an alpha is low.

Where an alpha lies around the threshold (a picture on a plane) single pixels are holes: a
stranger's file scored 30.0 dB, its sharp picture 33.9, with a threshold of 0.01 36.9. In
Blender 5.2, whose normals do not tell these from hair, they are not told.
"""

import numpy as np

from . import compat, fog, sets, setup, shining, walked
from .passes import NOTHING_HIT

LEAST = 0.002  # of the picture; 25 scenes without veils had at most 0.0003
TOLD = (
    "something partly transparent before the sky has no depth, and is blurred like the sky: "
    "set View Layer > Passes > Data > Alpha Threshold to 0.01"
)
# Holes: of the eight pixels around, those with a depth, and the length of rays over theirs.
# Of 30 scenes without veils or volumes at most 0.00001 of the picture, of that file 0.002.
LEAST_AROUND, LEAST_RAYS, LEAST_HOLES = 6, 0.95, 0.0005


def why_wrong(layer, scene):
    """What the user is told of a passes.Layer of a scene; "": nothing."""
    if layer.rays is None:
        return ""
    if share_left_out(layer) <= LEAST and share_of_holes(layer) <= LEAST_HOLES:
        return ""
    return TOLD if walked.once(_has_veils, scene) and not fog.has_volume(scene) else ""


def share_left_out(layer):
    """Of a picture, pixels that show something without depth, as all eight around do."""
    is_hit = _has_length(layer.rays)
    if layer.facing is not None:
        is_hit |= layer.facing != 0
    is_left_out = np.pad((layer.depth >= NOTHING_HIT) & is_hit, 1)
    height, width = layer.depth.shape
    inside = np.ones((height, width), bool)
    for y, x in np.ndindex(3, 3):
        inside &= is_left_out[y : y + height, x : x + width]
    return inside.mean()


def _has_length(rays):
    """Which means of rays are of such that hit something?"""
    return (rays > 0) & (rays < NOTHING_HIT)


def share_of_holes(layer):
    """Of a picture, pixels without depth in the middle of a surface that their rays hit."""
    is_hit = layer.depth < NOTHING_HIT
    n_hit, rays = _sum_around(is_hit), _sum_around(np.where(is_hit, layer.rays, 0))
    is_hole = ~is_hit & (n_hit >= LEAST_AROUND) & _has_length(layer.rays)
    return (is_hole & (layer.rays * n_hit > LEAST_RAYS * rays)).mean()


def _sum_around(plane):
    """Sums over the eight pixels around each."""
    wide = np.pad(plane, 1).astype(np.float32)
    rows = wide[:-2] + wide[1:-1] + wide[2:]
    return rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:] - wide[1:-1, 1:-1]


def _has_veils(scene):
    """Does a render of a scene show a material that may be partly transparent?"""
    items = [item for layer in sets.layers_of(scene) for item in layer.objects]
    materials = set().union(*map(shining.materials_of, items))
    return any(map(_is_veil, materials))


def _is_veil(material):
    """Do the nodes of a material, or groups in them, let light through, and hide some?"""
    is_used = compat.HAS_NODE_GROUPS or material.use_nodes  # always, from 5.0 on
    if not is_used or material.node_tree is None:
        return False
    nodes = [n for tree in setup.with_groups(material.node_tree) for n in tree.nodes]
    nodes = [node for node in nodes if not node.mute]
    alphas = [n.inputs["Alpha"] for n in nodes if n.type == "BSDF_PRINCIPLED"]
    has_alpha = any(a.is_linked or 0 < a.default_value < 1 for a in alphas)
    has_hole = any(node.type == shining.HOLE for node in nodes)
    return has_alpha or (has_hole and any(node.type == "MIX_SHADER" for node in nodes))
