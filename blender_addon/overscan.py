# SPDX-License-Identifier: GPL-3.0-or-later
"""Overscan: what lies beyond the border is rendered, and blurred into the picture as it is.

Without, the filter guesses it from what is at the border. Blender renders the scenes of a
compositor at one size, so that a picture cannot have a margin. A copy of the scene renders
`wide` times the frame at that size, with a part of the samples: all that is taken of it is
blurred. Around the passes of the frame it is laid as their margin, which is cut off after the
filter.

    wide = 1 + 2 x overscan (of the width and height, beyond each side)

Several views need none: what lands in the picture through a point of the lens is in the view from
there (lamps beyond all borders: one view 25.7 dB, with Overscan 32.4, four views 39.2).
"""

from typing import NamedTuple

import numpy as np

from . import (
    camera_objects,
    copied,
    fog,
    keyed,
    lamps,
    lens,
    names,
    passes,
    sampling,
    setup,
    view_cameras,
)
from .library import rackfocus

# Of the scene's samples, at the least LEAST_SAMPLES: the margin is seen blurred alone.
SHARE, LEAST_SAMPLES = 8, 4
OTHER_SEED = 3571  # its noise is not that of the picture's samples
VIEWS = "Overscan is for one view: several see beyond the border"
MISSING = "the margin of Overscan was not rendered, and is guessed: press F12"


class Kept(NamedTuple):
    """Of the last render of a scene."""

    frame: int
    wide: float
    found: tuple  # (passes.RenderedPasses, suffix, view)


_kept = names.store()  # Kept


# ---- what is asked for ------------------------------------------------------------


def percent(scene):
    """What the cameras of a scene ask for, beyond each side; the most of all frames."""
    used = keyed.ticked(camera_objects.cameras_of(scene))
    return max((keyed.most(one, "overscan") for one in used), default=0.0)


def why_not(scene):
    """Why the margin of a scene is guessed though it is asked for, or "": for the box."""
    reason = copied.why_not(scene, "Overscan")
    if reason:
        return reason
    if not setup.can_mute_sources(scene):
        return "Overscan does not work where your nodes use other passes too"
    used = keyed.ticked(camera_objects.cameras_of(scene))
    if any(keyed.most(one, "mirrors") for one in used):
        return "Overscan does not work with Mirrors and Glass"
    looks = [name for one in used for name in lens.looks_beyond(one, _wide(scene))]
    return (
        f"Overscan is too wide for so much {looks[0]}: set less of one" if looks else ""
    )


def _wide(scene):
    return 1 + percent(scene) / 50


def is_rendered(scene):
    """Does a render of a scene have a margin?"""
    return percent(scene) > 0 and not why_not(scene)


def area(scene):
    """How many times the pixels of the frame one view of a scene is filtered with."""
    return _wide(scene) ** 2 if is_rendered(scene) else 1.0


def samples_of(scene):
    """Samples of the margin; 0: its engine has none."""
    whole = sampling.samples_of(scene)
    return min(whole, max(whole // SHARE, LEAST_SAMPLES))


def describe(scene, settings, n_views):
    """Lines for the panel on a camera's overscan; none where it asks for none."""
    if not settings.overscan > 0:
        return []
    reason = why_not(scene) or (VIEWS if n_views > 1 else "")
    if reason:
        return [reason]
    width, height = lens.picture_size(scene.render)
    across, down = (round(side * settings.overscan / 100) for side in (width, height))
    n = samples_of(scene)
    what = f" of {n} sample{'s' if n > 1 else ''}" if n else ""
    return [
        f"{across} px beyond left and right, {down} above and below,",
        f"in one more render{what}",
    ]


# ---- the render -------------------------------------------------------------------


def make_copy(scene, new_copy):
    """(a copy of a scene that renders its margin too, suffix of its camera, `wide`).

    new_copy: function of a scene, which makes a copy for a render.
    """
    copy = new_copy(scene)
    copy.name = f"{scene.name} Rack Focus Overscan"
    copy.render.use_freestyle = False
    owner, name = sampling.samples_at(copy)
    n = samples_of(scene)
    if owner is not None:
        setattr(owner, name, n)
    if scene.render.engine == "CYCLES":
        copy.cycles.seed = (copy.cycles.seed + OTHER_SEED) % 2**31
        copy.cycles.adaptive_min_samples = min(copy.cycles.adaptive_min_samples, n)
        copy.cycles.time_limit /= SHARE
    for layer in copy.view_layers:
        if layer.samples:
            layer.samples = min(
                layer.samples, max(layer.samples // SHARE, LEAST_SAMPLES)
            )
    return copy, view_cameras.add(scene, copy, [0])[0], _wide(scene)


def look_through(copy, camera, suffix):
    """Prepares the copy for a frame that a camera object sees."""
    copy.render.use_multiview = True
    view_cameras.look_through(copy, camera, [suffix])


def follow(copy, seen, suffix, wide):
    """Puts its camera in its place, once the copy is evaluated for a frame.

    seen: the user's camera, evaluated.
    """
    render = copy.rack_focus.viewed.render
    try:
        params = lens.camera_parameters(seen, render)
    except lens.CameraError:
        return  # is said where the frame is filtered
    made = rackfocus.Lens(*lens.picture_size(render), **params)
    point = 0.0, 0.0, 0.5, 0.0, 0.0
    camera = view_cameras.find(copy, suffix)
    view_cameras.put(camera, seen, made, made.focus_distance, point, wide)


def take(scene, wide, found):
    """Keeps what was rendered for a frame; see Kept."""
    _kept[scene.name] = Kept(scene.frame_current, wide, found)


def forget(scene=None):
    """Lets go of what was rendered, of a scene or of all."""
    if scene is None:
        _kept.clear()
    else:
        _kept.pop(scene.name, None)


# ---- the margin -------------------------------------------------------------------


class Margin:
    """What is laid around the passes of a frame of one view layer.

    layer: the passes.Layer of `wide` times the frame; size: (width, height) px of the frame's
    passes.
    """

    def __init__(self, layer, wide, size):
        self.layer, self.wide = layer, wide
        width, height = size
        across, down = (int((wide - 1) / 2 * side) for side in size)
        self.whole = width + 2 * across, height + 2 * down
        self.inside = np.s_[down : down + height, across : across + width]
        rows, _ = self.inside
        self._strips = [
            np.s_[:down, :],
            np.s_[down + height :, :],
            np.s_[rows, :across],
            np.s_[rows, across + width :],
        ]
        self._sides = [
            self._seen(*about)
            for about in zip(
                size[::-1], self.whole[::-1], layer.depth.shape, strict=True
            )
        ]

    def _seen(self, n_frame, n_whole, n_layer):
        """(nearest, first, last, share of the last) of the layer's pixels on a side, for each
        of the whole; a pixel of the whole is no larger than one of the layer."""
        step = n_layer / (self.wide * n_frame)
        middles = n_layer / 2 + (np.arange(n_whole) + 0.5 - n_whole / 2) * step
        first, last = middles - step / 2, middles + step / 2
        share = np.clip((last - np.floor(last)) / step, 0, 1).astype(np.float32)
        whole = (np.clip(x, 0, n_layer - 1).astype(int) for x in (middles, first, last))
        return *whole, share

    def around(self, layer):
        """A passes.Layer with the margin."""
        both = zip(layer.mattes, self.layer.mattes, strict=False)
        return passes.Layer(
            self._around(layer.colour, self.layer.colour, self._mean),
            self._around(layer.depth, self.layer.depth, self._nearest),
            tuple(
                tuple(
                    self._around(*planes, self._nearest)
                    for planes in zip(*pair, strict=True)
                )
                for pair in both
            ),
            rays=self._around(layer.rays, self.layer.rays, self._nearest),
            facing=self._around(layer.facing, self.layer.facing, self._nearest),
        )

    def _around(self, plane, beyond, look):
        """An array of the frame with what `look` finds in one of the layer."""
        if plane is None or beyond is None:
            return None
        made = np.empty((*self.whole[::-1], *plane.shape[2:]), np.float32)
        made[self.inside] = plane
        for strip in self._strips:
            sides = [
                [values[part] for values in side]
                for part, side in zip(strip, self._sides, strict=True)
            ]
            made[strip] = look(beyond, *sides)
        return made

    @staticmethod
    def _nearest(beyond, rows, columns):
        return beyond[rows[0]][:, columns[0]]

    @staticmethod
    def _mean(beyond, rows, columns):
        """What pixels cover of those of the layer, so that no light is lost."""
        _, top, low, down = rows
        _, left, right, across = columns
        down, across = down[:, None, None], across[None, :, None]
        both = [
            (1 - across) * beyond[at][:, left] + across * beyond[at][:, right]
            for at in (top, low)
        ]
        return (1 - down) * both[0] + down * both[1]


def margin_of(scene, frame, size):
    """(the Margin of a frame of one view, or None; what the artist should know, or "").

    scene: the user's; frame: engine.Frame; size: (width, height) px of the frame's passes.
    """
    if not is_rendered(scene):
        return None, ""
    kept = _kept.get(scene.name)
    if kept is None or kept.frame != passes.frame_of(scene):
        return None, MISSING
    rendered, suffix, view = kept.found
    found = [(rendered.layer(frame.layer, suffix, view), passes.MIDDLE)]
    found = fog.filled(found, scene)
    found = lamps.placed(found, scene, frame.layer, frame.camera, kept.wide)
    return Margin(found[0][0], kept.wide, size), ""
