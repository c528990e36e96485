# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists change of the light and the blur before the filter sees them.

Highlights: the light of a pixel is its largest channel, L.
    clamp      L = min(L, clamp): a firefly is one bright disc less
    gain       L = t + (L - t) gain above the threshold t: brighter or softer bokeh
Blur: the CoC before and behind the focus is a part of the lens's (nodes.with_mask()).
"""

import numpy as np

FAR = np.float32(1e8)


def of(settings):
    """The values as a tuple, of a camera's settings."""
    return (
        settings.highlight_clamp if settings.use_highlight_clamp else 0.0,
        settings.highlight_threshold,
        settings.highlight_gain,
        settings.front_blur,
        settings.back_blur,
    )


def colour(picture, values):
    """A (height, width, 4) picture with tamed or raised highlights; may be the same."""
    clamp, threshold, gain = values[:3]
    if not clamp and gain == 1:
        return picture
    light = picture[..., :3].max(-1)
    new = np.minimum(light, np.float32(clamp)) if clamp else light.copy()
    above = new > threshold
    new[above] = threshold + (new[above] - threshold) * np.float32(gain)
    factor = np.ones_like(light)
    np.divide(new, light, out=factor, where=light > 0)
    made = picture.copy()
    made[..., :3] *= factor[..., None]
    return made


def depth(planar, values, focus, is_orthographic):
    """Depth for which the blur before and behind the focus is what the values say."""
    front, back = values[3:5]
    if front == 1 and back == 1:
        return planar
    part = np.where(planar < focus, np.float32(front), np.float32(back))
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
            found = 1 / ((1 - mask) / focus + mask / planar)
    return np.minimum(found, FAR).astype(np.float32)
