# SPDX-License-Identifier: GPL-3.0-or-later
"""Setting the focus distance of a camera by a click, in a picture or a 3D view.

A driver or keyframes would give it back its value before the picture is made, and what
is written to a linked camera is gone when the file opens again: that is said.
"""

from . import compat

PATH = "dof.focus_distance"


def focus(operator, scene, camera, distance, has_keyframe=False):
    """Focuses a camera object on a distance, and reports it.

    operator: reports; distance: scene units; has_keyframe: insert one in the present
    frame. Auto Keying does so too, as in Blender's fields, where there are some.
    """
    data, dof = camera.data, camera.data.dof
    dof.focus_object, dof.focus_distance = None, distance
    animation = data.animation_data
    curves = [c for c in compat.curves_of(animation) if c.data_path == PATH]
    is_keyed = any(not curve.mute for curve in curves)
    if has_keyframe or (is_keyed and scene.tool_settings.use_keyframe_insert_auto):
        dof.keyframe_insert("focus_distance", frame=scene.frame_current)
        is_keyed = False
    drivers = animation.drivers if animation is not None else ()
    if any(curve.data_path == PATH for curve in drivers):
        reason = "its focus distance has a driver"
    elif is_keyed:
        reason = (
            "its focus distance has keyframes; set one with the diamond beside Pick "
            "Focus, or switch Auto Keying on"
        )
    else:
        operator.report({"INFO"}, f"Focus at {distance:.4g}")
        reason = (
            "it is linked, and its focus is not saved; make a library override of it"
        )
        reason = reason if data.library is not None else ""
    if reason:
        operator.report({"WARNING"}, f"Camera “{camera.name}”: {reason}")
