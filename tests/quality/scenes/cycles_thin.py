# SPDX-License-Identifier: Apache-2.0
"""Scenes of thin things at all depths (cycles_scenes.py): fur, snow, leaves on cards."""

import random

from cycles_camera import log_uniform, place, random_colour, random_warm
from cycles_shapes import (
    add_ball,
    add_box,
    add_lamp,
    add_quad,
    add_rod,
    make_cutout,
    make_material,
    set_light,
)


def _add_hair(thing, n, length, radius, material, seed):
    """Hair on a thing's faces, from root to tip."""
    thing.data.materials.append(material)
    thing.modifiers.new("hair", "PARTICLE_SYSTEM")
    settings = thing.particle_systems[0].settings
    settings.type = "HAIR"
    settings.count, settings.hair_length = n, length
    settings.material = len(thing.data.materials)
    settings.brownian_factor = settings.factor_random = 0.25 * length
    settings.render_step = settings.display_step = 4
    settings.root_radius, settings.tip_radius = 2 * radius, 0.4 * radius
    settings.radius_scale = 1.0
    thing.particle_systems[0].seed = seed


def build_fur(camera):
    """Furry balls before, in and behind the focus, on a checkered table."""
    rng = random.Random(1010)
    set_light((0.6, 0.7, 1.0), 0.7, 2.4, (45, 0, -30))
    table = make_material(((0.6, 0.55, 0.45), (0.2, 0.22, 0.25)), "checker", 9.0)
    add_quad(6, 8, table, (0, 3.2, 0))
    wall = make_material(((0.35, 0.42, 0.3), (0.12, 0.16, 0.14)), "noise", 3.0)
    add_quad(8, 4, wall, (0, 4.6, 1.5), (90, 0, 0))
    for seed, (x, depth, radius) in enumerate(
        ((0.0, 1.2, 0.13), (-0.27, 0.72, 0.07), (0.42, 1.9, 0.17), (-0.62, 2.6, 0.22))
    ):
        skin = make_material(random_colour(rng, 0.1, 0.5))
        hair = make_material(random_colour(rng, 0.15, 0.7), gloss=0.06)
        ball = add_ball(radius, skin, (x, depth, radius + 0.02))
        thick = 0.5 * depth / camera.focal_px  # px there
        _add_hair(ball, 4500, 0.5 * radius, thick, hair, seed)
    for _ in range(5):
        depth = rng.uniform(2.0, 4.0)
        spot = place(camera, rng.uniform(-180, 180), rng.uniform(20, 110), depth)
        radius = rng.uniform(1.0, 1.8) * depth / camera.focal_px
        add_lamp(spot, radius, random_warm(rng), log_uniform(rng, 30, 200))


def build_snow(camera):
    """700 flakes between the lens and a dark house, some of them in focus."""
    rng = random.Random(1111)
    set_light((0.55, 0.65, 0.9), 0.9, 0.8, (60, 0, 20))
    ground = make_material(((0.7, 0.72, 0.76), (0.5, 0.53, 0.6)), "noise", 2.0)
    add_quad(30, 30, ground, (0, 12, -1.2))
    house = make_material(((0.2, 0.1, 0.07), (0.07, 0.06, 0.07)), "checker", 2.5)
    add_box((3.4, 1.5, 2.6), house, (0.8, 7.5, 0.1), 18)
    for x, depth in ((-1.1, 3.0), (-2.2, 5.2), (1.5, 4.2)):
        bark = make_material((0.1, 0.07, 0.05))
        add_rod((x, depth, -1.2), (x + 0.2, depth, 2.4), 0.05, bark)
    figure = make_material(((0.5, 0.12, 0.08), (0.2, 0.05, 0.04)), "checker", 14.0)
    add_box((0.5, 0.3, 1.3), figure, (0.1, 3.0, -0.55), 25)
    flake = make_material((0.85, 0.86, 0.9))
    for _ in range(700):
        depth = 1.0 / rng.uniform(1 / 7.5, 1 / 1.0)
        spot = place(camera, rng.uniform(-215, 215), rng.uniform(-130, 130), depth)
        radius = rng.uniform(0.8, 2.2) * depth / camera.focal_px
        add_ball(radius, flake, spot, detail=8)


def build_cards(camera):
    """Leaves cut out of cards by their alpha, at all depths."""
    rng = random.Random(1212)
    set_light((0.6, 0.75, 1.0), 0.6, 2.2, (45, 0, 25))
    wall = make_material(((0.4, 0.36, 0.3), (0.2, 0.22, 0.2)), "brick", 1.5)
    add_quad(14, 9, wall, (0, 8, 0), (90, 0, 0))
    skins = [
        make_cutout((rng.uniform(0.08, 0.4), rng.uniform(0.25, 0.5), 0.06), 9.0)
        for _ in range(6)
    ]
    for _ in range(60):
        depth = 1.0 / rng.uniform(1 / 6.5, 1 / 1.3)
        spot = place(camera, rng.uniform(-200, 200), rng.uniform(-125, 125), depth)
        side = rng.uniform(30, 80) * depth / camera.focal_px
        turn = [rng.uniform(50, 130), rng.uniform(-40, 40), rng.uniform(-50, 50)]
        card = add_quad(side, side, rng.choice(skins), spot, turn)
        card.scale = (1, rng.uniform(0.6, 1.0), 1)
