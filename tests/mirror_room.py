# SPDX-License-Identifier: Apache-2.0
"""A mirror before a wall, and the room that it shows: what cli and plugin tests see."""

import numpy

WIDTH, HEIGHT = 96, 64
#: r = 16 - 1600 / z px: 0 at 100, 2 of the mirror, 11 of the room that it shows.
MIRROR, WALL, ROOM = 1600 / 14, 1600 / 10, 1600 / 5


def pattern(x, y):
    """Noise of cells of 3 px, the same wherever it is looked at."""
    cells = numpy.random.default_rng(5).random((80, 120))
    x, y = x / 3 + 40, y / 3 + 20
    a, b = x.astype(int), y.astype(int)
    u, v = x - a, y - b
    up = cells[b, a] * (1 - u) + cells[b, a + 1] * u
    down = cells[b + 1, a] * (1 - u) + cells[b + 1, a + 1] * u
    return up * (1 - v) + down * v


def room(moved=0.0):
    """(is it the mirror?, the light that it shows), a camera `moved` lens radii right."""
    y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    at = x - moved * 2
    mirror = (at >= 16) & (at < 80) & (y >= 8) & (y < 56)
    return mirror, numpy.where(mirror, 0.1 + 0.8 * pattern(x - moved * 11, y), 0)
