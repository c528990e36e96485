# SPDX-License-Identifier: GPL-3.0-or-later
"""Grease Pencil stays as sharp as the camera's own depth of field leaves it.

Blender draws the strokes over the finished render, whose depth knows nothing of them: with
it they would be blurred by the distance of what is behind. So a render goes without them,
and a copy of the scene renders the least that they need, once and through the middle of
the lens, with the strokes in a pass of their own, which is laid over the filtered picture.
Blenders before 4.5 have no such pass, and the box says what becomes of the strokes there.
"""

import json

import numpy as np

from . import bodies, compat, failures, freestyle, group, names, passes, sets, setup
from .borrowed import Switch
from .writing import set_if_other

SWITCH = Switch("strokes", lambda layer: layer, "use_grease_pencil", False)
PASS = "use_pass_grease_pencil"
CHANNELS = ("Grease Pencil", "GreasePencil")  # from 5.0 on, in 4.5; measured
TYPES = ("GPENCIL", "GREASEPENCIL")  # up to 4.2, from 4.3 on
MISSING = (
    "Grease Pencil is missing in the picture, as this Blender has its pass under another "
    "name: switch on View Layer > Passes > Data > Grease Pencil, which blurs the strokes "
    "with what is behind them"
)
BLURRED = "Grease Pencil is blurred with what is behind it"

# scene name: (frame, passes.RenderedPasses) of the strokes of its last render
_kept = names.store()


# ---- what a render shows ----------------------------------------------------------


def _are_in(scene):
    """Does a render of a scene, filtered, show strokes?"""
    shown = [
        layer
        for layer in scene.view_layers
        if layer.use
        and getattr(layer, SWITCH.name, True)
        and setup.is_shown(scene, layer.name)
    ]
    behind = [layer for layer in sets.layers_of(scene) if layer.id_data != scene]
    layers = [*shown, *behind] if shown else ()
    return any(_has_strokes(item) for layer in layers for item in layer.objects)


def _has_strokes(item):
    """Is an object Grease Pencil, or a collection that it shows?"""
    if item is None or item.hide_render:  # None: just removed
        return False
    is_instancer = item.instance_type == "COLLECTION" and item.instance_collection
    shown = item.instance_collection.all_objects if is_instancer else ()
    return item.type in TYPES or any(one.type in TYPES for one in shown)


def _why_not(scene):
    """What keeps the strokes in the picture that is filtered, and what to do; ""."""
    if not compat.HAS_STROKES_PASS:
        return "Blender 4.5 and later keep it sharp"
    if any(getattr(layer, PASS) for layer in scene.view_layers):
        return "switch Passes > Data > Grease Pencil off to keep it sharp"
    if scene.render.use_multiview:
        return "without stereo it stays sharp"
    if group.nodes_of(scene):
        return "without Rack Focus nodes on pictures it stays sharp"
    if not setup.can_mute_sources(scene):
        return "it stays sharp where your nodes use no other passes"
    if bodies.why_one_view(scene):
        return "with rigid bodies baked it stays sharp"
    return ""


def are_taken(scene):
    """Do the strokes of a scene come over its filtered picture?"""
    return _are_in(scene) and not _why_not(scene)


def describe(scene):
    """Lines for the panel on strokes that would not be as the renderer's own lens has them."""
    reason = _why_not(scene)
    if not reason or not _are_in(scene):
        return []
    return [f"{BLURRED}:", reason]


# ---- the render -------------------------------------------------------------------


def make_copy(scene, new_copy):
    """A copy of a scene that renders its strokes; made before SWITCH is set.

    new_copy: function of a scene, which makes a copy for a render.
    """
    copy = new_copy(scene)
    copy.name = f"{scene.name} Rack Focus Strokes"
    copy.render.use_freestyle = False
    for owner, name in (("cycles", "samples"), ("eevee", "taa_render_samples")):
        if hasattr(getattr(copy, owner, None), name):
            setattr(getattr(copy, owner), name, 1)
    if scene.render.engine == "CYCLES":
        copy.cycles.use_denoising = False
    # Without a pass Z of the artist's Blender draws strokes before all things.
    ours = json.loads(scene.rack_focus.record or "{}").get("z", ())
    for layer in copy.view_layers:
        setattr(layer, PASS, True)
        layer.use_pass_z = layer.name not in ours
        layer.samples = 0
    return copy


def take_out(copies):
    """Lets copies of a scene render without strokes."""
    for copy in copies:
        for layer in copy.view_layers:
            set_if_other(layer, SWITCH.name, False)


def take(scene, copy):
    """Keeps the strokes of a frame, once the copy is rendered."""
    _kept[scene.name] = scene.frame_current, passes.RenderedPasses(copy)


def forget(scene=None):
    """Lets go of what was rendered, of a scene or of all."""
    if scene is None:
        _kept.clear()
    else:
        _kept.pop(scene.name, None)


# ---- the strokes ------------------------------------------------------------------


def added(found, scene, layer):
    """The views of a view layer, [(passes.Layer, passes.Place)], with strokes as lines.

    They are in the first one, and over the lines that Freestyle has drawn.
    """
    frame, rendered = _kept.get(scene.name, (None, None))
    if frame != passes.frame_of(scene) or rendered is None:
        return found
    channels = next(iter(rendered.files.values()))
    read = (freestyle.lines_of(channels, f"{layer}.{name}") for name in CHANNELS)
    lines = next((one for one in read if one is not None), None)
    if lines is None:
        failures.say(scene, MISSING)
        return found
    (first, place), *more = found
    scale = len(first.colour) // len(lines)  # of a supersampled frame
    lines = np.repeat(np.repeat(lines, scale, 0), scale, 1)
    if first.lines is not None:
        lines = lines + first.lines * (1 - lines[..., 3:])
    return [(first._replace(lines=lines), place), *more]
