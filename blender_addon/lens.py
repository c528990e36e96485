# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's camera to the parameters of the filter.

Cycles' conventions (measured): the radius of the aperture is the focal length in mm
times 1e-3 / (2 f-stop) in scene units, whatever the unit scale; for orthographic
cameras it is 1 / (2 f-stop), and before 4.2 the lens stands in the near clipping plane,
from which the focus distance counts. The scale of the camera object counts for nothing.
"""

import contextlib
import math

import numpy as np

from . import driven, keyed
from .camera_objects import FILTERED
from .compat import ORTHO_LENS_IS_AT_CLIP
from .library import rackfocus

LEAST_F_STOP = 1e-5  # Cycles' own (blender_camera_init(), intern/cycles/blender)
# The filter's least; below, which scenes in large units need, the radius is spelt out.
LEAST_OF_FILTER = 1e-3
# Below, a focus was never set: files of 2.7x have 0. Cycles takes 1e-5 for it.
NO_DISTANCE = 1e-5


class CameraError(Exception):
    """The camera cannot be filtered; the message is for the user."""


_known = {}  # full name of a camera object: distance of its focus object


@contextlib.contextmanager
def known(distances):
    """Focus objects are that far meanwhile, wherever an evaluated scene has them.

    distances: {full name of a camera object: scene units}.
    """
    _known.update(distances)
    try:
        yield
    finally:
        _known.clear()


def focus_distance(camera):
    """Distance of the plane in focus along the axis, in scene units.

    camera: evaluated camera object. With a focus object, its planar distance.
    """
    dof = camera.data.dof
    target = dof.focus_object
    if target is None:
        return dof.focus_distance
    if camera.is_evaluated and camera.name_full in _known:
        return _known[camera.name_full]
    place = target.matrix_world
    if target.type == "ARMATURE" and dof.focus_subtarget:
        bone = target.pose.bones.get(dof.focus_subtarget)
        if bone is not None:
            place = place @ bone.matrix
    matrix = camera.matrix_world
    axis = matrix.to_3x3().col[2].normalized()
    return abs(axis.dot(place.translation - matrix.translation))


def picture_size(render):
    """(width, height) in px of the whole frame, the percentage applied."""
    sides = render.resolution_x, render.resolution_y
    width, height = (side * render.resolution_percentage // 100 for side in sides)
    return max(width, 1), max(height, 1)


def aspect_of(render):
    """Width of a pixel over its height."""
    return render.pixel_aspect_x / render.pixel_aspect_y


def region_of(render, width, height):
    """((left, right), (low, high)) in px of the render region, rows upwards.

    Blender multiplies in single precision and cuts: 0.7 of 1000 px is 700, though the
    0.7 of single precision is less than 0.7. width, height: of the whole frame.
    """
    borders = (
        (width, render.border_min_x, render.border_max_x),
        (height, render.border_min_y, render.border_max_y),
    )
    return tuple(
        tuple(int(np.float32(border) * np.float32(size)) for border in (least, most))
        for size, least, most in borders
    )


def aperture_parameters(dof):
    """Parameters of the aperture's shape."""
    return {
        "blades": dof.aperture_blades if dof.aperture_blades >= 3 else 0,
        "blade_rotation": math.degrees(dof.aperture_rotation),
        "aperture_ratio": dof.aperture_ratio,
    }


def why_not(camera):
    """Why a camera object cannot be filtered, in the artist's words; "" if it can."""
    if camera.type != "CAMERA" or camera.data.type not in FILTERED:
        return (
            "Rack Focus needs a perspective or orthographic camera; "
            f"“{camera.name}” is of another type, and keeps the renderer's own lens"
        )
    if focus_distance(camera) < NO_DISTANCE:
        return driven.why_invalid(camera) or (
            f"“{camera.name}” is focused on itself: set its focus distance, which is 0, "
            "or another focus object"
        )
    return ""


def stereo_shift(data, view):
    """What Blender adds to a camera's Shift X in a view of stereo, "left" or "right".

    0 where `view` is "": without stereo, or through a camera of the view's own.
    """
    stereo = data.stereo
    if not view or stereo.convergence_mode != "OFFAXIS":
        return 0.0
    share = {"CENTER": 0.5, view.upper(): 0.0}.get(stereo.pivot, 1.0)
    apart = stereo.interocular_distance * (share if view == "left" else -share)
    return apart / stereo.convergence_distance * data.lens / data.sensor_width


def camera_parameters(camera, render):
    """Parameters of the lens for the whole frame, as keywords of rackfocus.Lens.

    camera: evaluated camera object; render: the scene's render settings.
    """
    data = camera.data
    dof = data.dof
    reason = why_not(camera)
    if reason:
        raise CameraError(reason)
    distance = focus_distance(camera)
    f_stop = max(dof.aperture_fstop, LEAST_F_STOP)
    radius = 0.0  # from focal length and f-stop
    if f_stop < LEAST_OF_FILTER:
        focal = 1 if data.type == "ORTHO" else data.lens * 1e-3
        radius = focal / (2 * f_stop)
    if data.type == "ORTHO" and ORTHO_LENS_IS_AT_CLIP:
        # The same line r = R (z - clip - s) / s, with distances from the camera.
        radius = (distance + data.clip_start) / distance / (2 * f_stop)
        distance += data.clip_start
    return {
        "focus_distance": distance,
        "f_stop": max(f_stop, LEAST_OF_FILTER),
        "lens_radius": radius,
        "focal_length": data.lens,
        "sensor_width": data.sensor_width,
        "sensor_height": data.sensor_height,
        "sensor_fit": data.sensor_fit.lower(),
        "projection": "orthographic" if data.type == "ORTHO" else "perspective",
        "ortho_scale": data.ortho_scale,
        "shift_x": data.shift_x,
        "shift_y": data.shift_y,
        "pixel_aspect": aspect_of(render),
        **aperture_parameters(dof),
    }


def crop_parameters(params, whole_size, size, middle=(0.0, 0.0)):
    """The same lens for a part of the frame, or for more than it; what depends on the frame is
    spelt out.

    params: of camera_parameters() and the method; whole_size, size: (width, height) px; middle:
    of the part, px right and up from that of the frame.
    """
    if tuple(whole_size) == tuple(size):
        return params
    lens, aspect = rackfocus.Lens(*whole_size, **params), params["pixel_aspect"]
    width, height = whole_size[0], whole_size[1] / aspect  # in widths of a pixel
    is_wide = width >= height
    if params["sensor_fit"] != "auto":
        is_wide = params["sensor_fit"] == "horizontal"
    side = width if is_wide else height  # the fitted one
    part = dict(params, sensor_fit="horizontal", max_radius=lens.max_radius_px)
    part["shift_x"] = (params["shift_x"] * side + middle[0]) / size[0]
    part["shift_y"] = (params["shift_y"] * side + middle[1] / aspect) / size[0]
    if lens.px_per_unit > 0:
        part["ortho_scale"] = size[0] / lens.px_per_unit
    else:
        part["focal_length_px"] = lens.focal_length_px
    return part


# Looks that count places in halves of the picture's diagonal, with the power of the place in
# their formulas (core/lens/look.c; app/sources/settings.c has the same table).
OF_PLACES = {
    "cat_eye": 1, "barn_left": 1, "barn_right": 1, "barn_top": 1, "barn_bottom": 1,
    "astigmatism": 2, "swirl": 2, "field_curvature": 2,
    "split_offset": -1, "split_softness": -1,
}  # fmt: skip


def padded_parameters(params, size, whole):
    """The same lens for a picture with a margin, as wide on opposite sides.

    params: of frame_parameters(), for pictures of `size`; size, whole: (width, height) px,
    without the margin and with it.
    """
    padded, aspect = crop_parameters(params, size, whole), params["pixel_aspect"]
    ratio = math.hypot(whole[0], whole[1] / aspect) / math.hypot(
        size[0], size[1] / aspect
    )
    for field, power in OF_PLACES.items():
        if field in params:
            padded[field] = params[field] * ratio**power
    return padded


def looks_beyond(settings, ratio):
    """Names of a camera's looks that are too strong for a picture so many times as wide."""
    return [
        settings.bl_rna.properties[p.field].name
        for p in rackfocus.parameters()
        if p.field in OF_PLACES
        and not all(
            p.min <= value * ratio ** OF_PLACES[p.field] <= p.max
            for value in keyed.values(settings, p.field)
        )
    ]


def white_of(scene):
    """Luminance that a scene shows as white: its exposure is in stops.

    scene: the user's, or the one that filters it.
    """
    scene = scene.rack_focus.source or scene
    white = next(p for p in rackfocus.parameters() if p.field == "white")
    shown = 2.0 ** -round(scene.view_settings.exposure)
    return min(max(shown, white.min), white.max)


def frame_parameters(camera, settings, render, size, scale=1, view=""):
    """All parameters for a picture of `size` px that shows the frame or a part of it.

    settings: the camera's rack_focus properties; scale: of a supersampled frame, whose
    lengths in px are those of the settings times it; view: as of stereo_shift().
    """
    params = camera_parameters(camera, render)
    params["shift_x"] += stereo_shift(camera.data, view)
    params.update(settings.method_parameters(), white=white_of(render.id_data))
    for p in rackfocus.parameters() if scale > 1 else ():
        if p.unit == "px" and p.field in params:
            params[p.field] = min(params[p.field] * scale, p.max)
    width, height = picture_size(render)
    whole, middle = (scale * width, scale * height), (0.0, 0.0)
    if render.use_border:
        ends = zip(region_of(render, width, height), (width, height), strict=True)
        middle = [sum(borders) / 2 - side / 2 for borders, side in ends]
    return crop_parameters(params, whole, size, middle)
