# SPDX-License-Identifier: GPL-3.0-or-later
"""Freestyle's lines stay as sharp as the camera's own depth of field leaves them.

Blender draws them over the finished render, whose depth knows nothing of them. While the
scene is filtered they are a pass of their own (Freestyle > As Render Pass), which is laid
over the filtered picture. Views from other places of the lens would show them elsewhere:
with lines, one view is rendered.
"""

import json

import numpy as np

from .borrowed import Switch

NAME = "Freestyle"
SWITCH = Switch("freestyle", lambda layer: layer.freestyle_settings, "as_render_pass")


def is_drawn(scene):
    """Does Freestyle draw in a render of a scene?"""
    layers = (layer for layer in scene.view_layers if layer.use)
    return scene.render.use_freestyle and any(la.use_freestyle for la in layers)


# ---- the pass ---------------------------------------------------------------------


def need_pass(scene):
    """Takes the lines out of the pictures that have them; without lines, back in."""
    SWITCH.need(scene, is_drawn(scene))


# ---- the lines --------------------------------------------------------------------


def lines_of(channels, stem=NAME):
    """(height, width, 4) of lines, premultiplied; None without.

    channels: {name: plane}; stem: of the names, before .R and so on.
    """
    names = [f"{stem}.{c}" for c in "RGBA"]
    if any(name not in channels for name in names):
        return None
    return np.stack([channels[name] for name in names], -1)


def taken(found, scene, layer):
    """The views of a view layer, [(passes.Layer, passes.Place)], with our lines alone.

    Where the pass is the artist's own, the lines stay in it.
    """
    record = json.loads(scene.rack_focus.record or "{}")
    if layer in record.get(SWITCH.key, []):
        return found
    return [(one._replace(lines=None), place) for one, place in found]


def draw(lines, picture):
    """Lays lines over a picture, in place, from which they were taken.

    (height, width, 4), premultiplied, rows in the same order; lines may be None, or have
    each pixel several times, as those of a supersampled frame.
    """
    if lines is None:
        return
    scale = len(lines) // len(picture)
    lines = lines[::scale, ::scale]
    picture *= 1 - lines[..., 3:]
    picture += lines
