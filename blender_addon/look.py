# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists change of the blur before the filter sees it.

The CoC before and behind the focus is a part of the lens's (nodes.with_mask()).
"""

import numpy as np

from .library import rackfocus

FAR = np.float32(1e8)
# Parameters for which each place of the picture has a focus distance of its own.
MOST_RADIUS = 16384  # px, of the table
FOCUS_BY_PLACE = ("tilt_x", "tilt_y", "field_curvature", "split_diopter")


def of(settings):
    """The parts before and behind the focus, of a camera's settings."""
    return settings.front_blur, settings.back_blur


def focus_of(shape, params):
    """Distance in focus at each pixel, (height, width), or that of the lens.

    params: of rackfocus.Filter. With a tilted lens, a curved field or a split diopter the
    CoC is K (1/s - 1/z) with s of the place: two constant depths tell s. It is negative
    where a tilt focuses beyond infinity: all is nearer than that.
    """
    focus = params["focus_distance"]
    if not any(params.get(name) for name in FOCUS_BY_PLACE):
        return focus
    without_limit = {**params, "max_radius": MOST_RADIUS, "method": "layered"}
    made, radii = rackfocus.Filter(*shape[::-1], **without_limit), []
    for z in (focus, 2 * focus):
        radii.append(np.empty(shape, np.float32))
        made.coc(np.full(shape, z, np.float32), radii[-1])
    near, far = (r.astype(np.float64) for r in radii)
    slope = (far - near) * 2 * focus  # of the CoC in -1/z
    with np.errstate(divide="ignore"):
        return 1 / (1 / focus + near / slope)


def depth(planar, values, focus, is_orthographic):
    """Depth for which the blur before and behind the focus is what the values say."""
    front, back = values
    if front == 1 and back == 1:
        return planar
    is_front = (planar < focus) | (np.asarray(focus) < 0)
    part = np.where(is_front, np.float32(front), np.float32(back))
    return with_mask(planar, part, focus, is_orthographic)


def with_mask(planar, mask, focus, is_orthographic):
    """Depth for which the CoC is `mask` times that of `planar`; same shape.

    The CoC is proportional to 1/focus - 1/depth, in an orthographic view to
    depth - focus. mask: (height, width) or a number, 0 (sharp) to 1.
    """
    if np.isscalar(mask) and mask >= 1:
        return planar
    mask = np.clip(mask, 0, 1)
    if is_orthographic:
        found = focus + mask * (np.minimum(planar, FAR) - focus)
    else:
        with np.errstate(divide="ignore"):
            found = 1 / np.maximum((1 - mask) / focus + mask / planar, 0)
    # What has no depth keeps it so, for Film Depth.
    return np.where(mask >= 1, planar, np.minimum(found, FAR)).astype(np.float32)
