# SPDX-License-Identifier: GPL-3.0-or-later
"""Views with Motion Blur that Cycles cannot render.

It takes the matrix of a camera that moves apart into place, turn and size, and puts it
together again for each moment. The view of an orthographic camera from a point of the
lens is a shear, which that loses: ghosts (22 dB in place of 41 of one view).
"""

import math

from . import compat, lens, setup


def may_lose_shear(scene, data):
    """Are views of a camera (its data) sheared in a render that cannot move that?"""
    settings, render = data.rack_focus, scene.render
    is_mean = settings.method == "accumulate"
    is_blurred = render.use_motion_blur and not (is_mean and settings.shutter_spread)
    is_sheared = not (is_mean and settings.camera_move == "look_at")
    is_cycles = render.engine == "CYCLES"
    return is_cycles and data.type == "ORTHO" and is_blurred and is_sheared


def why_one_view(scene, camera):
    """Why a frame of a camera has one view, in the artist's words; "" where it need not.

    Does the camera, or its focus, move while the shutter is open?
    """
    if not may_lose_shear(scene, camera.data):
        return ""
    ours, start = setup.filter_scene_of(scene), compat.shutter_start(scene)
    middle, seen = scene.frame_current + scene.frame_subframe, []
    for part in (0, 0.5, 1, None):  # None: back to the frame
        time = (
            start + part * scene.render.motion_blur_shutter if part is not None else 0
        )
        frame = math.floor(middle + time)
        ours.frame_set(frame, subframe=middle + time - frame)
        now = camera.evaluated_get(ours.view_layers[0].depsgraph)
        lens_now = now.data.dof.aperture_fstop, lens.focus_distance(now)
        seen.append((now.matrix_world.copy().freeze(), *lens_now))
    if len(set(seen[:3])) == 1:
        return ""
    is_mean = camera.data.rack_focus.method == "accumulate"
    return (
        f"the orthographic camera “{camera.name}” or its focus moves, and Cycles cannot "
        "move sheared views with Motion Blur: one view is rendered"
        f"{', and it stays sharp' if is_mean else ''}. Switch Motion Blur off, or take "
        "Accumulate with Look At or Spread over Shutter"
    )
