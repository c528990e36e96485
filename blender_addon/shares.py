# SPDX-License-Identifier: GPL-3.0-or-later
"""Shares of mixed pixels: Cycles' Denoising Depth tells them where colours cannot.

The scene's view layers get that pass when a render begins, for as long as a camera of the
scene wants it, and for mirrors (mirrors.py); it is given back with the tick. Views that are
cleaned together have it anyway (denoising.py). 64 samples in all, with 1, 4 and 8 views:
twigs before the sky 30.9 to 32.7 dB, 35.7 to 37.6, 36.6 to 38.0; leaves on cards 35.9 to
36.8, 41.6 to 43.4, 43.5 to 45.4; posts 35.6 to 36.2, 38.6 to 39.3, 38.3 to 39.4; a ball
before large lamps (macro) - 0.2, - 0.15, + 0.9, night up to - 0.1, others gain. For 2 %
of Cycles' time.
"""

from . import camera_objects, keyed, mirrors
from .borrowed import Switch

METHODS = ("layered", "views")  # those that look at it
SWITCH = Switch(
    "shares", lambda layer: getattr(layer, "cycles", None), "denoising_store_passes"
)


def is_offered(scene, settings):
    """Can a camera's settings have clean edges by the pass alone?"""
    return scene.render.engine == "CYCLES" and settings.method in METHODS


def is_wanted(scene):
    """Does a camera of the scene want the pass, for its edges or its mirrors?"""
    used = keyed.ticked(camera_objects.cameras_of(scene))
    used = [one for one in used if keyed.most(one, "clean_edges")]
    is_asked = any(not keyed.values(one, "method").isdisjoint(METHODS) for one in used)
    return scene.render.engine == "CYCLES" and (is_asked or mirrors.is_wanted(scene))


def need_pass(scene):
    """Switches the pass on where it is wanted, and off where only we wanted it."""
    SWITCH.need(scene, is_wanted(scene))
