# SPDX-License-Identifier: Apache-2.0
"""Scenes under the sky: grass, a street at night, twigs (cycles_scenes.py)."""

import math
import random

import bpy
from cycles_camera import log_uniform, place, random_warm
from cycles_shapes import (
    add_ball,
    add_box,
    add_lamp,
    add_leaf,
    add_mesh,
    add_quad,
    add_rod,
    make_emission,
    make_material,
    set_light,
)
from mathutils import Vector


def _add_blades(rng, n, material):
    """Blades of grass in one mesh, as many at each 1 / depth."""
    vertices, faces = [], []
    for _ in range(n):
        depth = 1 / rng.uniform(1 / 9, 1 / 0.45)
        x = rng.uniform(-0.5, 0.5) * depth * 0.9
        tall, width = rng.uniform(0.04, 0.11), rng.uniform(0.0015, 0.003)
        lean, fall = rng.uniform(-0.04, 0.04), rng.uniform(-0.04, 0.04)
        angle = rng.uniform(0, 3.14)
        cx, cy = math.cos(angle) * width, math.sin(angle) * width
        middle_x, middle_y = x + lean * 0.4, depth + fall * 0.4
        i = len(vertices)
        vertices += [
            (x - cx, depth - cy, 0),
            (x + cx, depth + cy, 0),
            (middle_x + cx * 0.7, middle_y + cy * 0.7, tall * 0.6),
            (middle_x - cx * 0.7, middle_y - cy * 0.7, tall * 0.6),
            (x + lean, depth + fall, tall),
        ]
        faces += [(i, i + 1, i + 2, i + 3), (i + 3, i + 2, i + 4)]
    add_mesh(vertices, faces, material)


def _add_flower(rng, stem):
    """Seven petals on a stem."""
    depth = 1 / rng.uniform(1 / 6, 1 / 0.5)
    x, tall = rng.uniform(-0.45, 0.45) * depth, rng.uniform(0.06, 0.13)
    add_rod((x, depth, 0), (x + 0.01, depth, tall), 0.0012, stem)
    colour = (rng.uniform(0.5, 0.9), rng.uniform(0.1, 0.8), rng.uniform(0.1, 0.7))
    petal = make_material(colour)
    for k in range(7):
        angle = k * 2 * math.pi / 7
        out = (0.009 * math.cos(angle), 0.009 * math.sin(angle))
        turn = (rng.uniform(-20, 20), rng.uniform(-20, 20), math.degrees(angle) - 90)
        spot = (x + 0.01 + out[0], depth + out[1], tall)
        add_leaf(0.016, 0.008, petal, spot, turn)
    add_ball(0.004, make_material((0.9, 0.7, 0.1)), (x + 0.01, depth, tall + 0.002), 12)


def build_grass(camera):
    """7200 blades from the lens to the horizon, flowers, a sky."""
    rng = random.Random(1)
    set_light((0.55, 0.7, 1.0), 1.0, 3.0, (55, 0, -60))
    soil = make_material(((0.2, 0.14, 0.08), (0.1, 0.12, 0.04)), "noise", 6.0)
    add_quad(40, 60, soil, (0, 29, 0))
    greens = [
        make_material(
            (rng.uniform(0.1, 0.35), rng.uniform(0.3, 0.55), 0.06), gloss=0.08
        )
        for _ in range(8)
    ]
    for green in greens:
        _add_blades(rng, 900, green)
    for _ in range(60):
        _add_flower(rng, greens[0])


def _add_houses(rng, side):
    """Seven houses along one side of the street, with windows that are lit."""
    for i in range(7):
        tall, depth = rng.uniform(4, 10), 8 + 5 * i
        wall = make_material(((0.12, 0.11, 0.13), (0.03, 0.03, 0.05)), "brick", 1.0)
        add_box((3, 4, tall), wall, (side * 5.5, depth, tall / 2))
        for k in range(14):
            pane = make_emission(random_warm(rng), log_uniform(rng, 0.6, 8))
            spot = (side * 3.98, depth - 1.8 + 0.9 * (k % 5), 1 + 0.9 * (k // 5))
            add_quad(0.35, 0.5, pane, spot, (90, 0, 90 * side))


def build_night(camera):
    """A wet street at night behind a railing: windows, a sign, 140 lamps."""
    rng = random.Random(2)
    set_light((0.05, 0.07, 0.15), 0.6, 0.15, (60, 0, 20))
    stone = ((0.10, 0.10, 0.11), (0.03, 0.03, 0.04))
    add_quad(40, 80, make_material(stone, "noise", 3.0, 0.4, 0.12), (0, 38, 0))
    for side in (-1, 1):
        _add_houses(rng, side)
    tube = make_emission((0.3, 0.6, 1), 6)
    add_quad(0.9, 0.25, make_emission((1, 0.1, 0.25), 5), (-1.1, 4.4, 2.0), (90, 0, 0))
    for k in range(6):
        foot, top = (-1.5 + 0.12 * k, 4.35, 1.7), (-1.45 + 0.12 * k, 4.35, 1.9)
        add_rod(foot, top, 0.012, tube)
    coat = make_material(((0.5, 0.3, 0.2), (0.2, 0.1, 0.1)), "checker", 12.0)
    add_box((0.5, 0.3, 1.3), coat, (0.1, 3.2, 0.65), 20)
    add_ball(0.15, make_material((0.6, 0.4, 0.3)), (0.1, 3.2, 1.47))
    rail = make_material((0.3, 0.3, 0.3), gloss=0.3, roughness=0.1)
    for i in range(13):
        x = -1.2 + 0.2 * i
        add_rod((x, 1.4, 0.3), (x, 1.4, 1.25), 0.008, rail)
    add_rod((-1.5, 1.4, 1.25), (1.5, 1.4, 1.25), 0.014, rail)
    light = bpy.data.lights.new("lantern", "AREA")
    light.energy, light.size = 60, 1
    lantern = bpy.data.objects.new("lantern", light)
    lantern.location, lantern.rotation_euler = (1.5, 1.5, 3.2), (0.6, 0.5, 0)
    bpy.context.scene.collection.objects.link(lantern)
    for _ in range(140):
        depth = rng.uniform(6, 40)
        spot = place(camera, rng.uniform(-190, 190), rng.uniform(-25, 100), depth)
        radius = rng.uniform(0.4, 1.6) * depth / camera.focal_px
        lamp = add_lamp(spot, radius, random_warm(rng), log_uniform(rng, 8, 500))
        lamp.visible_glossy = True


class _Tree:
    """A random tree: each branch has three, the thinnest three leaves."""

    def __init__(self, rng, barks, leaves):
        self.rng, self.barks, self.leaves = rng, barks, leaves

    def _shift(self, most):
        return Vector([self.rng.uniform(-most, most) for _ in range(3)])

    def grow(self, foot, along, length, radius, level=4):
        """A branch from `foot` in the direction `along`."""
        end = foot + along * length
        add_rod(foot, end, radius, self.barks[level % 2], 7)
        for _ in range(3):
            if level == 0:
                leaf, spot = self.rng.choice(self.leaves), end + self._shift(
                    0.3 * length
                )
                turn = [self.rng.uniform(0, 180) for _ in range(3)]
                add_leaf(0.3 * length, 0.108 * length, leaf, spot, turn)
                continue
            turned = (along + self._shift(0.6)).normalized()
            start = foot + along * length * self.rng.uniform(0.5, 1)
            self.grow(start, turned, length * 0.62, radius * 0.6, level - 1)


def build_branches(camera):
    """Twigs before, in and behind the focus, wires and birds, before a bright sky."""
    rng = random.Random(3)
    set_light((0.75, 0.85, 1.0), 1.6, 2.0, (50, 0, 40))
    hill = make_material(((0.12, 0.2, 0.08), (0.25, 0.3, 0.12)), "noise", 0.5)
    add_ball(14, hill, (0, 40, -12.5), 64)
    barks = [
        make_material(((0.14, 0.09, 0.06), (0.06, 0.04, 0.03)), "noise", 20.0)
        for _ in range(2)
    ]
    leaves = [
        make_material((rng.uniform(0.3, 0.7), rng.uniform(0.1, 0.3), 0.04), gloss=0.04)
        for _ in range(6)
    ]
    tree = _Tree(rng, barks, leaves)
    for foot, lean, length, radius in (
        ((-0.7, 0.9, -0.2), 0.9, 0.3, 0.009),
        ((0.9, 1.0, 0.35), -0.8, 0.28, 0.008),
        ((-1.2, 2.6, -0.7), 0.5, 0.8, 0.03),
        ((1.2, 2.6, -0.9), -0.35, 0.9, 0.03),
        ((-3, 7, -2), 0.3, 2.2, 0.07),
        ((2.5, 9, -2.5), -0.2, 2.6, 0.09),
    ):
        along = Vector((lean, 0.05, 0.5)).normalized()
        tree.grow(Vector(foot), along, length, radius)
    dark = make_material((0.05, 0.05, 0.07))
    for k in range(5):
        add_ball(0.03, dark, (-0.3 + 0.14 * k, 2.6, 0.42 + 0.01 * (k % 2)), 16)
    for k in range(3):
        add_rod((-3, 2.6, 0.36 + 0.1 * k), (3, 2.6, 0.40 + 0.1 * k), 0.004, dark)
