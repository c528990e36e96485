# SPDX-License-Identifier: Apache-2.0
"""Discs before a wall, with mixed pixels whose mean rays are known, as Cycles has them."""

import numpy

WIDTH, HEIGHT, FINE = 120, 80, 8
FOCAL_PX = 150
CLIP = 0.1  # where the camera begins to see
LENS = ["--focus-distance", "4", "--lens-radius", "0.06"]


def scene(n):
    """Colours, distances along the axis and along the rays, n x n samples a pixel."""
    y, x = (numpy.mgrid[0 : n * HEIGHT, 0 : n * WIDTH] + 0.5) / n
    random = numpy.random.default_rng(3)
    z = numpy.full(x.shape, 4.0)
    grey = 0.5 + 0.4 * numpy.sin(x) * numpy.sin(y / 2)
    for _ in range(25):
        at, size = random.uniform(0, 1, 2) * (WIDTH, HEIGHT), random.uniform(3, 9)
        is_inside = numpy.hypot(x - at[0], y - at[1]) < size
        z[is_inside] = random.uniform(1.5, 2.5)
        grey[is_inside] = random.uniform(0.2, 0.8)
    across = numpy.hypot(x - WIDTH / 2, y - HEIGHT / 2) / FOCAL_PX
    return grey, z, (z - CLIP) * numpy.sqrt(1 + across**2)


def mean(plane):
    return plane.reshape(HEIGHT, FINE, WIDTH, FINE).mean((1, 3))


def channels_of(grey, z):
    return dict.fromkeys("RGB", grey.astype("f4")) | {"Z": z.astype("f4")}


def passes():
    """Channels of a pixel's mean colour and one depth sample, and its mean ray."""
    grey, z, ray = scene(FINE)
    at = slice(FINE // 2, None, FINE)
    return channels_of(mean(grey), z[at, at]), mean(ray).astype("f4")
