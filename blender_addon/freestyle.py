# SPDX-License-Identifier: GPL-3.0-or-later
"""Freestyle's lines stay as sharp as the camera's own depth of field leaves them.

Blender draws them over the finished render, whose depth knows nothing of them. While the
scene is filtered they are a pass of their own (Freestyle > As Render Pass), which is laid
over the filtered picture. Views from other places of the lens would show them elsewhere:
with lines, one view is rendered.
"""

import json

import numpy as np

RECORD = (
    "freestyle"  # names of layers whose lines we made a pass, in the scene's record
)
NAME = "Freestyle"


def is_drawn(scene):
    """Does Freestyle draw in a render of a scene?"""
    layers = (layer for layer in scene.view_layers if layer.use)
    return scene.render.use_freestyle and any(la.use_freestyle for la in layers)


# ---- the pass ---------------------------------------------------------------------


def need_pass(scene):
    """Takes the lines out of the pictures of layers that have them there.

    Where Freestyle is off now, they get them back.
    """
    record = json.loads(scene.rack_focus.record or "{}")
    if not record:
        return
    ours = record.get(RECORD, [])
    if is_drawn(scene):
        missing = [la for la in scene.view_layers if not _settings(la).as_render_pass]
        _switch(missing, True)
        ours = [*ours, *(layer.name for layer in missing)]
    elif ours:
        drop_pass(scene, record)
        ours = []
    if ours != record.get(RECORD, []):
        record[RECORD] = ours
        scene.rack_focus.record = json.dumps(record)


def drop_pass(scene, record):
    """Undoes need_pass()."""
    names = record.get(RECORD, [])
    _switch([la for la in scene.view_layers if la.name in names], False)


def _settings(layer):
    return layer.freestyle_settings


def _switch(layers, is_on):
    for layer in layers:
        _settings(layer).as_render_pass = is_on


# ---- the lines --------------------------------------------------------------------


def lines_of(channels, layer, tail=""):
    """Planes R, G, B, A of a view layer's lines, premultiplied; None without.

    channels: of exr.read_exr(); tail: what follows the pass in the names.
    """
    names = [f"{layer}.{NAME}{tail}.{c}" for c in "RGBA"]
    if any(name not in channels for name in names):
        return None
    return np.stack([channels[name] for name in names], -1)


def draw(scene, layer, lines, picture):
    """Lays lines over a picture, in place, where we took them out of it.

    layer: name of the view layer; lines, picture: (height, width, 4), premultiplied, rows
    in the same order; lines may be None.
    """
    record = json.loads(scene.rack_focus.record or "{}")
    if lines is None or layer not in record.get(RECORD, []):
        return
    picture *= 1 - lines[..., 3:]
    picture += lines
