# SPDX-License-Identifier: GPL-3.0-or-later
"""Drivers of cameras that read the scene they are evaluated in (Context Property, 4.x).

The filter scene evaluates the cameras too, and has none of the artist's properties: a
driver that finds nothing there is invalid from then on, in the artist's scene too.
"""

import contextlib
import re

from .writing import set_if_other

OWN = re.compile(
    r'\["((?:[^"\\]|\\.)+)"\]$'
)  # of a path that ends in a custom property

TIME = ("frame_current", "frame_float", "frame_subframe")  # Blender's to set


def _drivers_of(camera):
    """The drivers of a camera object and its data."""
    for owner in (camera, camera.data):
        if owner.animation_data is not None:
            yield from (curve.driver for curve in owner.animation_data.drivers)


def _targets_of(driver):
    """What a driver reads of the scene or the view layer that is evaluated."""
    for variable in driver.variables:
        if variable.type == "CONTEXT_PROP":
            yield from variable.targets


def _copy(path, source, target):
    """Lets a property of a scene or view layer be that of another; was it not?"""
    value, is_there = source.path_resolve(path), True
    try:
        is_there = target.path_resolve(path) == value
    except ValueError:
        is_there = False
    if is_there:
        return False
    own = OWN.search(path)
    if own is not None:
        owner = path[: own.start()]
        (target.path_resolve(owner) if owner else target)[own[1]] = value
        return True
    owner, _, name = path.rpartition(".")
    if name in TIME:
        return False
    set_if_other(target.path_resolve(owner) if owner else target, name, value)
    return True


def follow(cameras, scene, ours):
    """Lets the filter scene have what drivers of the cameras read of their scene.

    scene: the artist's, or an evaluated copy of it.
    """
    for camera in cameras:
        for driver in _drivers_of(camera):
            is_changed = False
            for target in _targets_of(driver):
                is_layer = target.context_property == "ACTIVE_VIEW_LAYER"
                pairs = [(scene, ours)]
                if is_layer:
                    pairs = zip(scene.view_layers, ours.view_layers, strict=False)
                for pair in pairs:
                    # What is not in the artist's scene either is the artist's matter.
                    with contextlib.suppress(ValueError, TypeError, AttributeError):
                        is_changed |= _copy(target.data_path, *pair)
            if is_changed and not driver.is_valid:
                driver.is_valid = True


def why_invalid(camera):
    """What the artist should know of a driver of the focus distance that fails, or ""."""
    animation = camera.original.data.animation_data
    for curve in animation.drivers if animation is not None else ():
        if curve.data_path == "dof.focus_distance" and not curve.driver.is_valid:
            return (
                f"the driver of the focus distance of “{camera.name}” fails: mend it in "
                "the Drivers Editor"
            )
    return ""
