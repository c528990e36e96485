# SPDX-License-Identifier: GPL-3.0-or-later
"""What flat mirrors and panes show is blurred by its own distance.

Cycles' light passes say what of each pixel is mirrored or let through, and its Denoising
Depth (shares.py) how long the whole way of the rays is. The scene's view layers get those passes when
a render begins, for as long as a camera of the scene wants them.

    light      (direct + indirect) colour, of Glossy and of Transmission
    distance   that of the way, for the stronger of both lights, where their surface is
               flat and the way goes on behind it (rackfocus.Filter.seen_way());
               of several views that at which they show the same light
"""

import json
import math
import weakref
from typing import NamedTuple

import numpy as np

from . import camera_objects, keyed
from .library import rackfocus

PASSES = tuple(
    f"use_pass_{kind}_{part}"
    for kind in ("glossy", "transmission")
    for part in ("direct", "indirect", "color")
)
WAY_SWITCH = "denoising_store_passes"  # of a view layer's cycles, in old records
WAY, NORMAL, NOISY = "Denoising Depth", "Denoising Normal", "Noisy Image"
RECORD = "mirrors"  # {layer: what it got switched on}, in the scene's record
#: Direct, indirect, colour; Blender 5 writes names in full.
NAMES = (
    (
        ("GlossDir", "GlossInd", "GlossCol"),
        ("Glossy Direct", "Glossy Indirect", "Glossy Color"),
    ),
    (
        ("TransDir", "TransInd", "TransCol"),
        ("Transmission Direct", "Transmission Indirect", "Transmission Color"),
    ),
)


class Seen(NamedTuple):
    """Planes of a view layer, (height, width)."""

    lights: tuple  # of each kind nine: R, G, B of direct, indirect, colour
    noisy: tuple  # R, G, B of the picture before Cycles' denoiser; (): that was off
    way: np.ndarray  # length of the rays' way, scene units
    normal: tuple = ()  # X, Y, Z of what is rough; (): not known

    def part(self, rows_and_columns):
        """The same of a part of the picture."""
        return Seen(
            tuple(
                tuple(plane[rows_and_columns] for plane in light)
                for light in self.lights
            ),
            tuple(plane[rows_and_columns] for plane in self.noisy),
            self.way[rows_and_columns],
            tuple(plane[rows_and_columns] for plane in self.normal),
        )


# ---- the passes -------------------------------------------------------------------


def is_wanted(scene):
    """Does a camera of the scene want them?"""
    used = keyed.ticked(camera_objects.cameras_of(scene))
    return any(keyed.most(one, "mirrors") for one in used)


def why_not(scene, settings):
    """Why a camera's mirrors have the blur of their surface, or ""."""
    if scene.render.engine != "CYCLES":
        return "Mirrors and Glass works with Cycles"
    if settings.method == "accumulate":
        return "Mirrors and Glass is not for Accumulate, which shows them as they are"
    if settings.supersample > 1:
        return "Mirrors and Glass works without Supersample"
    return ""


def need_passes(scene):
    """Switches the passes on where they are wanted, and off where only we wanted them."""
    record = json.loads(scene.rack_focus.record or "{}")
    if not record:
        return
    before = record.get(RECORD, {})
    ours = {name: list(switches) for name, switches in before.items()}
    if is_wanted(scene) and scene.render.engine == "CYCLES":
        for layer in scene.view_layers:
            missing = _switched_off(layer)
            _switch(layer, missing, True)
            if missing:
                ours[layer.name] = [*ours.get(layer.name, []), *missing]
    elif ours:
        drop_passes(scene, record)
        ours = {}
    if ours != before:
        record[RECORD] = ours
        scene.rack_focus.record = json.dumps(record)


def drop_passes(scene, record):
    """Switches off what need_passes() switched on."""
    for layer in scene.view_layers:
        _switch(layer, record.get(RECORD, {}).get(layer.name, []), False)


def _switched_off(layer):
    return [name for name in PASSES if not getattr(layer, name)]


def _switch(layer, names, is_on):
    for name in names:
        owner = getattr(layer, "cycles", None) if name == WAY_SWITCH else layer
        if owner is not None:  # Cycles is an add-on too, and may be off
            setattr(owner, name, is_on)


# ---- light and distance -----------------------------------------------------------


def seen_of(channels, layer, tail=""):
    """The Seen of a view layer among the channels of exr.read_exr(), or None.

    tail: what follows the pass in the names, ".view" in stereo.
    """
    way = channels.get(f"{layer}.{WAY}{tail}.Z")
    lights = []
    for kind in NAMES:
        for names in kind:
            planes = [
                channels.get(f"{layer}.{name}{tail}.{c}")
                for name in names
                for c in "RGB"
            ]
            if all(plane is not None for plane in planes):
                lights.append(tuple(planes))
                break
    if way is None or len(lights) < len(NAMES):
        return None

    def planes_of(name, letters):
        planes = tuple(channels.get(f"{layer}.{name}{tail}.{c}") for c in letters)
        return () if any(plane is None for plane in planes) else planes

    return Seen(tuple(lights), planes_of(NOISY, "RGB"), way, planes_of(NORMAL, "XYZ"))


def _light(planes):
    """(height, width, 3) of the nine planes of a kind."""
    direct, indirect, colour = (np.stack(planes[i : i + 3], -1) for i in (0, 3, 6))
    return np.nan_to_num((direct + indirect) * colour).astype(np.float32)


def lights_of(made, layer, params, near_clip, threads):
    """[(light, distance)] for rackfocus.Filter.process(), by the way of the rays.

    made: the filter, of params; layer: the passes.Layer that it filters, which has seen;
    near_clip: the camera's, scene units, from which on Cycles counts the way.
    """
    seen = layer.seen
    height, width = seen.way.shape
    rays = rackfocus.Filter(
        width, height, threads=threads, **{**params, "depth": "radial"}
    )
    way = np.where(seen.way > 0, seen.way, 0).astype(np.float32)
    planar = np.empty_like(way)
    if way.any():  # not in a frame of nothing but sky
        rays.planar_depth(way, planar)
    planar += near_clip
    planar[way <= 0] = np.nan
    lights = _clean_lights(layer)
    sums = [light.sum(-1) for light in lights]
    ends = _ends_on_no_surface(layer, planar)
    whole = layer.colour[..., :3].sum(-1)
    found = []
    for light, own, other in zip(lights, sums, sums[::-1], strict=True):
        distance = np.where(own < other, np.nan, planar).astype(np.float32)
        distance[ends & (own > whole / 2) & (own >= other)] = np.inf
        made.seen_way(layer.colour, layer.depth, light, distance, distance)
        found.append((light, distance))
    return found


def _ends_on_no_surface(layer, planar):
    """Where rays went from a surface and hit nothing: Cycles counts nothing for them
    (before 5.2), and no rough surface gave a normal. What glows gives none, too."""
    if not layer.seen.normal:
        return np.zeros(planar.shape, bool)
    squares = sum(plane * plane for plane in layer.seen.normal)
    return (squares < 0.25) & (planar < 1.02 * layer.depth)


def _clean_lights(layer):
    """The lights of a passes.Layer, with the grain that its colour has."""
    seen = layer.seen
    lights = [_light(planes) for planes in seen.lights]
    noisy = np.stack(seen.noisy, -1) if seen.noisy else layer.grainy
    if noisy is None:
        return lights
    clean = layer.colour[..., :3]
    part = clean / np.where(noisy[..., :3] > 0, noisy[..., :3], np.inf)
    return [np.minimum(light * part, clean) for light in lights]


# ---- several views ----------------------------------------------------------------

#: From so many views on they tell each other's distances better than the way does:
#: mirrors 38.1 and 36.9 dB with 2, 39.6 and 42.1 with 4, 39.9 and 42.7 with 8.
MATCHED_FROM = 4
#: Others that tell those of a view: 39.1 dB with one, 42.6 with 2, 42.8 with 7.
N_OTHERS = 2

_matched = weakref.WeakKeyDictionary()  # {what was rendered: {key: distances}}


def lights_of_views(made, found, key, report):
    """[(light, distance)] of each view, for rackfocus.Filter.process_views().

    Distances are those at which the views show the same light. They hold for any focus,
    and are kept for as long as what was rendered is.

    made: the filter; found: [(passes.Layer, passes.Place)], which have seen; key: what
    was rendered, and what of it this is; report: as of Filter.process().
    """
    rendered, part = key
    lights = [_clean_lights(layer) for layer, _ in found]
    kept = _matched.setdefault(rendered, {})
    if part not in kept:
        kept[part] = [
            _match(made, found, lights, index, report) for index in range(len(found))
        ]
    return [
        list(zip(*pair, strict=True)) for pair in zip(lights, kept[part], strict=True)
    ]


def _match(made, found, lights, index, report):
    """The distance of each light of a view."""
    if not report(index / len(found)):
        raise rackfocus.CancelledError("cancelled")
    layer = found[index][0]
    places = [place for _, place in found]
    distances = []
    for kind in range(len(NAMES)):
        distance = np.empty(layer.depth.shape, np.float32)
        same = [
            (lights[j][kind], places[j].offset, places[j].shear_distance)
            for j in (index, *_farthest(places, index))
        ]
        made.seen_depth(layer.colour, layer.depth, same, distance)
        distances.append(distance)
    return distances


def _farthest(places, index):
    """N_OTHERS indices, each the farthest on the lens from those before it."""
    taken = [index]
    while len(taken) <= N_OTHERS:
        others = (j for j in range(len(places)) if j not in taken)
        taken.append(
            max(
                others,
                key=lambda j: min(
                    math.dist(places[j].offset, places[i].offset) for i in taken
                ),
            )
        )
    return taken[1:]
