# SPDX-License-Identifier: GPL-3.0-or-later
"""The lens of a 3D view: the camera's aperture, the view's own projection.

With the view's window matrix P, rows of OpenGL, and the width w of its picture in px:

    perspective   f_px = P00 w / 2,  near = P23 / (P22 - 1),  far = P23 / (P22 + 1)
    orthographic  p = P00 w / 2 px per unit,  z = (P23 - (2 d - 1)) / P22, d the buffer

Seen freely the view keeps the camera's aperture, in scene units, and what was clicked,
or what the camera is focused on, stays in focus while the view turns around it.
"""

from typing import NamedTuple

import numpy as np
from mathutils import Vector

from . import lens

LEAST_DISTANCE = 1e-6


class Seen(NamedTuple):
    """What a 3D view shows, as the filter takes it."""

    params: dict  # keywords of rackfocus.Filter
    depth: np.ndarray  # (height, width), of the kind that params name


def aperture_radius(params):
    """Radius of the aperture of lens.camera_parameters() in scene units."""
    if params["lens_radius"] > 0:
        return params["lens_radius"]
    if params["projection"] == "orthographic":
        return 1 / (2 * params["f_stop"])
    return params["focal_length"] * 1e-3 / (2 * params["f_stop"])


def focus_point(camera):
    """The point in focus on the axis of a camera object, in the world."""
    return camera.matrix_world.normalized() @ Vector(
        (0, 0, -lens.focus_distance(camera))
    )


def planar_depth(matrix, buffer):
    """Planar distances of a depth buffer in [0, 1]; infinite where nothing was hit.

    matrix: the view's window matrix. Distances from the eye, in orthographic views from
    the view's own plane, which may be negative.
    """
    ndc = 2 * buffer.astype(np.float64) - 1
    if matrix[3][2] == 0:  # orthographic
        planar = (matrix[2][3] - ndc) / matrix[2][2]
    else:
        planar = matrix[2][3] / (ndc + matrix[2][2])
    return np.where(buffer >= 1, np.inf, planar)


def _focus_distance(region_data, camera, point):
    """Distance of the plane in focus from a view's eye, in scene units."""
    if region_data.view_perspective == "CAMERA":
        return lens.focus_distance(camera)
    point = focus_point(camera) if point is None else Vector(point)
    distance = -(region_data.view_matrix @ point).z
    is_behind = region_data.is_perspective and distance <= LEAST_DISTANCE
    return region_data.view_distance if is_behind else distance


def see(region_data, camera, render, buffer, point=None):
    """The Seen of a view.

    region_data: the view; camera: evaluated camera object; render: the scene's render
    settings; buffer: (height, width) float32 depth buffer, rows downwards; point: what
    is in focus when seen freely, in the world, None: what the camera is focused on.
    """
    matrix, width = region_data.window_matrix, buffer.shape[1]
    own = lens.camera_parameters(camera, render)
    distance = _focus_distance(region_data, camera, point)
    radius = aperture_radius(own)
    per_unit = abs(matrix[0][0]) * width / 2
    params = {key: own[key] for key in ("blades", "blade_rotation", "aperture_ratio")}
    if matrix[3][2] != 0:
        near = matrix[2][3] / (matrix[2][2] - 1)
        far = matrix[2][3] / (matrix[2][2] + 1)
        params.update(
            focus_distance=max(distance, LEAST_DISTANCE),
            lens_radius=radius,
            focal_length_px=per_unit,
            depth="buffer",
            depth_near=near,
            depth_far=far,
        )
        return Seen(params, buffer)
    planar = planar_depth(matrix, buffer)
    through_camera = region_data.view_perspective == "CAMERA"
    scale = own["focus_distance"] if through_camera else region_data.view_distance
    # Moved away until all of it is before the lens; the radius in px stays.
    hits = planar[np.isfinite(planar)]
    nearest = min(float(hits.min()) if hits.size else distance, distance)
    away = max(1 - nearest, 0)
    params.update(
        projection="orthographic",
        focus_distance=distance + away,
        lens_radius=radius * (distance + away) / max(scale, LEAST_DISTANCE),
        sensor_fit="horizontal",
        ortho_scale=width / per_unit,
    )
    return Seen(params, (planar + away).astype(np.float32))


def world_point(region_data, x, y, value):
    """The point of the world at fractions (x, y) from the lower left of a view.

    value: of the depth buffer there, in [0, 1).
    """
    ndc = Vector((2 * x - 1, 2 * y - 1, 2 * value - 1, 1))
    whole = region_data.window_matrix @ region_data.view_matrix
    point = whole.inverted() @ ndc
    return point.to_3d() / point.w
