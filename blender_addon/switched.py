# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras that scripts choose in handlers of their own while a frame begins.

Blender renders through what the scene's camera is once the handlers of the frame were
called. The filter scene then takes that of its source. Where copies render views, the
handlers are called with a copy: the cameras of its views become children of the chosen
one. Cameras that are bound to markers come from these.
"""

from . import camera_objects


def _has_markers(scene):
    return any(marker.camera for marker in scene.timeline_markers)


def other_camera(ours, camera):
    """The camera that a filter scene lacks when its source was rendered, else None.

    camera: of the frame, where copies rendered its views, else None.
    """
    source = ours.rack_focus.source.original
    shown = camera_objects.camera_of_strip(source)
    camera = shown or camera or source.camera
    is_bound = shown is None and _has_markers(source)
    return None if is_bound or camera == ours.camera else camera


def chosen(source, copy, expected, noted):
    """The camera that a script chose for a copy of a scene; None: it chose none.

    expected: what the copy renders through; noted: the source's camera when the frame
    was prepared.
    """
    if _has_markers(source):
        return None
    if copy.camera != expected:
        return copy.camera
    return source.camera if source.camera != noted else None
