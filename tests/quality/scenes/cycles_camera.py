# SPDX-License-Identifier: Apache-2.0
"""The camera of a test scene, and places before it (cycles_scenes.py)."""

import math
from dataclasses import asdict, dataclass

from mathutils import Euler, Vector


@dataclass(frozen=True)
class Camera:
    """The camera of a scene: what the renderer is told and what the filter needs."""

    width: int
    height: int
    lens_mm: float
    fstop: float
    focus: float
    sensor_mm: float = 36.0
    blades: int = 0
    rotation_deg: float = 0.0
    ratio: float = 1.0
    ortho_scale: float = 0.0
    height_above_ground: float = 0.0
    pitch_deg: float = 0.0
    bounces: int = 1

    @property
    def longer_px(self):
        """Length of the longer side of the picture, which the sensor width spans."""
        return max(self.width, self.height)

    @property
    def focal_px(self):
        """Focal length in pixels."""
        return self.longer_px * self.lens_mm / self.sensor_mm

    @property
    def lens_radius(self):
        """Radius of the aperture in scene units, as Cycles computes it."""
        if self.ortho_scale:
            return 1.0 / (2.0 * self.fstop)
        return self.lens_mm * 1e-3 / (2.0 * self.fstop)

    def facts(self):
        """Everything in this class as a dictionary, for SCENE.json."""
        derived = {"focal_px": self.focal_px, "lens_radius": self.lens_radius}
        return {**asdict(self), **derived}


# --- small helpers for random things ----------------------------------------------


def random_colour(rng, low=0.1, high=0.8):
    """A random reflectance."""
    return tuple(rng.uniform(low, high) for _ in range(3))


def random_warm(rng):
    """A random colour of a lamp, its largest channel near 1."""
    return rng.choice(
        [
            (1.0, 0.75, 0.4),
            (1.0, 0.9, 0.75),
            (0.6, 0.8, 1.0),
            (1.0, 0.35, 0.2),
            (0.5, 1.0, 0.6),
        ]
    )


def log_uniform(rng, low, high):
    """A random number whose logarithm is uniform."""
    return low * (high / low) ** rng.random()


def place(camera, x_px, y_px, depth):
    """The point at pixel (x, y) from the middle (y up) and planar depth."""
    unit = depth / camera.focal_px
    turn = Euler((math.radians(camera.pitch_deg), 0, 0))
    point = Vector((x_px * unit, depth, y_px * unit))
    point.rotate(turn)
    return point + Vector((0, 0, camera.height_above_ground))
