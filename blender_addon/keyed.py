# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of a camera that have keyframes: what they may be in the frames of a render.

Our nodes, the cameras of views and parts of pixels, and what passes are rendered, are set up
once, before the first frame: for the frame that wants the most. A render in the background
(-f 10) begins while the settings are still those of the frame in which the file was saved.
"""

from . import compat


def values(settings, field):
    """The values that a field of a camera's settings has now and at its keyframes, a set."""
    now, animation = getattr(settings, field), settings.id_data.animation_data
    if animation is None:
        return {now}
    prop, path = settings.bl_rna.properties[field], f"rack_focus.{field}"
    curves = [c for c in compat.curves_of(animation) if c.data_path == path]
    keys = [key.co[1] for curve in curves for key in curve.keyframe_points]
    if prop.type == "ENUM":
        names = {item.value: item.identifier for item in prop.enum_items}
        keys = [names[round(key)] for key in keys if round(key) in names]
    elif prop.type in ("INT", "BOOLEAN"):
        keys = map(round, keys)
    return {now, *keys}


def most(settings, field):
    """The largest of them; of a tick: is it ever on?"""
    return max(values(settings, field))


def ticked(cameras):
    """The settings of camera objects that are ticked in some frame."""
    found = (camera.data.rack_focus for camera in cameras)
    return [settings for settings in found if most(settings, "enabled")]
