# SPDX-License-Identifier: Apache-2.0
"""Builds the Cycles test scenes and renders their passes.

    blender -b --factory-startup -P cycles_scenes.py -- SCENE OUTDIR [--pass NAME] ...

SCENE is one of SCENES below (or "list"). The passes are

    pinhole    colour and depth without depth of field, SCENE_pinhole.exr
    dof        Cycles' own depth of field at the same samples, SCENE_dof.exr
    reference  the same with many samples, SCENE_reference_seedN.exr (choose --seed)
    views      pinhole views from points of the lens, SCENE_view00.exr ...
    defocus    the Defocus node over SCENE_pinhole.exr, SCENE_defocus_F.exr per f-stop

Every picture is a multilayer EXR of 32-bit floats, scene-linear. The camera facts go
to SCENE.json. collect_references.py turns a folder of these into the committed files.

Axes of the scenes: the camera stands at the origin (or above it) and looks along +Y,
x is right, z is up, lengths are scene units (metres).
"""

import argparse
import json
import math
import random
import sys
from dataclasses import replace
from pathlib import Path

import bpy
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parent))
from cycles_camera import (  # noqa: E402
    Camera,
    log_uniform,
    place,
    random_colour,
    random_warm,
)
from cycles_shapes import (  # noqa: E402
    add_ball,
    add_box,
    add_lamp,
    add_leaf,
    add_quad,
    add_rod,
    make_glass,
    make_material,
    make_mirror,
    set_light,
)
from cycles_outdoors import build_branches, build_grass, build_night  # noqa: E402
from cycles_thin import build_cards, build_fur, build_snow  # noqa: E402

GOLDEN_ANGLE_RAD = 2.399963
FEW_SAMPLES = 4  # of a view, which are moved within their pixels
# Radius and angle of the first of 2, 3 and 4 views.
RINGS = {
    2: (0.5, math.pi / 4),
    3: (0.551, math.pi / 12),
    4: (0.6, -math.atan(1 / 3)),
}
DEFOCUS_BOKEH = {0: "CIRCLE", 3: "TRIANGLE", 4: "SQUARE", 5: "PENTAGON", 6: "HEXAGON"}
DEFOCUS_FACTORS = (0.35, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.15, 1.3, 1.6, 2.0, 3.0)


# --- the scenes -------------------------------------------------------------------


def build_posts(camera):
    """Thin posts and wires before everything, lamps, textured things far behind."""
    rng = random.Random(101)
    set_light((0.5, 0.65, 1.0), 0.45, 2.2)
    brick = make_material(((0.5, 0.16, 0.1), (0.32, 0.2, 0.14)), "brick", 2.2)
    add_quad(8, 5, brick, (0, 6, 1.2), (90, 0, 0))
    floor = make_material(((0.6, 0.55, 0.45), (0.12, 0.14, 0.2)), "checker", 7.0)
    add_quad(8, 6, floor, (0, 3.2, -0.17))
    for _ in range(12):
        depth = rng.uniform(2.6, 5.4)
        tall = rng.uniform(0.2, 0.7)
        colours = (random_colour(rng), random_colour(rng, 0.02, 0.3))
        skin = make_material(colours, rng.choice(["noise", "checker"]), 14.0)
        x = rng.uniform(-0.33, 0.33) * depth
        size = (rng.uniform(0.2, 0.5), rng.uniform(0.2, 0.4), tall)
        add_box(size, skin, (x, depth, -0.17 + tall / 2), rng.uniform(0, 90))
    cube = make_material(((0.75, 0.7, 0.6), (0.1, 0.25, 0.35)), "checker", 60.0)
    add_box((0.1, 0.1, 0.13), cube, (-0.14, 1.04, -0.105), 30)
    ball = make_material(((0.8, 0.5, 0.1), (0.25, 0.05, 0.04)), "noise", 45.0, 0.1)
    add_ball(0.07, ball, (0.11, 1.0, -0.1))
    sign = make_material(((0.85, 0.85, 0.8), (0.05, 0.05, 0.1)), "brick", 30.0)
    add_quad(0.16, 0.1, sign, (0.0, 1.06, 0.08), (90, 0, 8))
    for i in range(11):
        depth = rng.uniform(0.53, 0.72)
        radius = log_uniform(rng, 1.5, 5.0) * depth / camera.focal_px
        skin = make_material(random_colour(rng, 0.03, 0.5), gloss=0.08)
        x = -225 + 45 * i + rng.uniform(-14, 14)
        lean = rng.uniform(-12, 12) if i % 3 else rng.uniform(-120, 120)
        top = place(camera, x + lean, 190, depth)
        foot = place(camera, x - lean, -190, depth)
        add_rod(foot, top, radius, skin)
    for y, slope in ((-48, -8), (-74, 9)):
        wire = make_material((0.05, 0.05, 0.06), gloss=0.1)
        left = place(camera, -300, y - slope, 0.56)
        right = place(camera, 300, y + slope, 0.56)
        add_rod(left, right, 0.6 * 0.56 / camera.focal_px, wire)
    for _ in range(16):
        depth = rng.uniform(2.2, 5.8)
        strength = log_uniform(rng, 100, 400)
        radius = rng.uniform(1.6, 2.4) * depth / camera.focal_px
        spot = place(camera, rng.uniform(-230, 230), rng.uniform(-30, 128), depth)
        add_lamp(spot, radius, random_warm(rng), strength)
    spot = place(camera, 96, 104, 5.0)
    add_lamp(spot, 2.0 * 5.0 / camera.focal_px, (1.0, 0.9, 0.75), 1e4)
    for x, y in ((-90, -95), (150, -60)):
        spot = place(camera, x, y, 0.72)
        add_lamp(spot, 1.6 * 0.72 / camera.focal_px, (1.0, 0.8, 0.5), 180)


def build_portrait(camera):
    """A floor receding through focus, leaves and balls before and behind, lamps."""
    rng = random.Random(202)
    set_light((0.6, 0.75, 1.0), 0.5, 2.4, (42, 10, 40))
    floor = make_material(((0.6, 0.3, 0.18), (0.22, 0.13, 0.1)), "brick", 14.0)
    add_quad(6, 9, floor, (0, 4.4, 0))
    wall = make_material(((0.2, 0.3, 0.22), (0.05, 0.09, 0.08)), "noise", 3.0)
    add_quad(8, 6, wall, (0, 6.5, 2), (90, 0, 0))
    slant = make_material(((0.7, 0.68, 0.6), (0.14, 0.2, 0.3)), "checker", 13.0)
    add_quad(2.6, 0.42, slant, (0.36, 2.1, 0.21), (90, 0, 78))
    for x, depth, radius in ((-0.08, 1.2, 0.09), (0.1, 1.75, 0.1), (-0.3, 2.6, 0.16)):
        skin = make_material(
            (random_colour(rng, 0.3), random_colour(rng, 0.02, 0.3)), "noise", 26, 0.1
        )
        add_ball(radius, skin, (x, depth, radius))
    for _ in range(9):
        depth = rng.uniform(0.55, 0.8)
        side = rng.choice((-1, 1))
        spot = place(camera, side * rng.uniform(70, 150), rng.uniform(-210, 225), depth)
        skin = make_material(
            (rng.uniform(0.05, 0.3), rng.uniform(0.25, 0.5), 0.06), gloss=0.06
        )
        turn = [rng.uniform(40, 140), rng.uniform(-30, 30), rng.uniform(-60, 60)]
        add_leaf(rng.uniform(0.05, 0.11), rng.uniform(0.015, 0.04), skin, spot, turn)
    for _ in range(160):
        depth = rng.uniform(1.5, 5.0)
        spot = place(camera, rng.uniform(-170, 170), rng.uniform(40, 230), depth)
        skin = make_material(
            (rng.uniform(0.1, 0.5), rng.uniform(0.2, 0.5), rng.uniform(0.02, 0.1))
        )
        turn = [rng.uniform(0, 180), rng.uniform(0, 180), rng.uniform(0, 180)]
        add_leaf(rng.uniform(0.08, 0.2), rng.uniform(0.04, 0.08), skin, spot, turn)
    for _ in range(11):
        depth = rng.uniform(2.4, 5.8)
        spot = place(camera, rng.uniform(-140, 60), rng.uniform(20, 215), depth)
        radius = rng.uniform(1.6, 2.4) * depth / camera.focal_px
        add_lamp(spot, radius, random_warm(rng), log_uniform(rng, 100, 600))


def build_plane(camera):
    """A textured ground through focus under an open sky, and a few boxes."""
    rng = random.Random(303)
    set_light((0.45, 0.65, 1.0), 0.6, 2.4, (48, 0, 30))
    ground = make_material(((0.65, 0.6, 0.5), (0.15, 0.17, 0.16)), "checker", 22.0)
    add_quad(30, 30, ground, (0, 14.5, 0))
    for x, depth in ((-0.55, 1.15), (0.5, 1.5), (-0.25, 2.2), (0.9, 3.2), (-1.8, 5.0)):
        size = rng.uniform(0.1, 0.16) * depth
        colours = (random_colour(rng, 0.3), random_colour(rng, 0.02, 0.25))
        skin = make_material(colours, rng.choice(["brick", "noise"]), 12.0)
        turn_deg = rng.uniform(0, 90)
        add_box((size, size, 1.4 * size), skin, (x, depth, 0.7 * size), turn_deg)


def build_macro(camera):
    """Large blur: stems close to the lens, a slanted sheet and a ball at the focus."""
    rng = random.Random(404)
    set_light((0.6, 0.7, 1.0), 0.5, 2.4, (45, 0, -30))
    wall = make_material(((0.12, 0.3, 0.2), (0.5, 0.42, 0.25)), "noise", 40.0)
    add_quad(0.6, 0.5, wall, (0, 0.62, 0), (90, 0, 0))
    sheet = make_material(((0.7, 0.68, 0.62), (0.2, 0.1, 0.12)), "brick", 110.0)
    add_quad(0.16, 0.2, sheet, (0, 0.31, -0.024), (8, 0, 0))
    ball = make_material(((0.75, 0.3, 0.08), (0.2, 0.04, 0.1)), "noise", 260.0, 0.1)
    add_ball(0.016, ball, (0.016, 0.302, 0.0))
    add_ball(0.009, ball, (-0.026, 0.318, 0.004))
    for x, lean, depth, radius in ((-95, 60, 0.2, 13), (105, -25, 0.22, 8)):
        stem = make_material((0.1, 0.32, 0.06), gloss=0.06)
        foot = place(camera, x - lean, -220, depth)
        top = place(camera, x + lean, 220, depth)
        add_rod(foot, top, radius * depth / camera.focal_px, stem, sides=20)
    for _ in range(14):
        depth = rng.uniform(0.36, 0.55)
        petal = make_material(random_colour(rng, 0.1, 0.7))
        spot = place(camera, rng.uniform(-170, 170), rng.uniform(10, 110), depth)
        turn = [rng.uniform(0, 180) for _ in range(3)]
        add_leaf(rng.uniform(0.02, 0.05), 0.012, petal, spot, turn)
    for x, y, depth, strength in (
        (70, 75, 0.55, 1500),
        (-10, 55, 0.5, 800),
        (148, 62, 0.45, 2500),
    ):
        spot = place(camera, x, y, depth)
        add_lamp(spot, 4.0 * depth / camera.focal_px, random_warm(rng), strength)


def build_foliage(camera):
    """Many small leaves at all depths, with glints."""
    rng = random.Random(505)
    set_light((0.6, 0.75, 1.0), 0.55, 2.6, (40, 0, 25))
    wall = make_material(((0.16, 0.22, 0.12), (0.4, 0.45, 0.5)), "noise", 2.5)
    add_quad(12, 9, wall, (0, 9, 0), (90, 0, 0))
    greens = [
        make_material((rng.uniform(0.06, 0.4), rng.uniform(0.2, 0.5), 0.05), gloss=0.05)
        for _ in range(24)
    ]
    for _ in range(1700):
        depth = 1.0 / rng.uniform(1 / 8, 1 / 1.6)
        spot = place(camera, rng.uniform(-215, 215), rng.uniform(-135, 135), depth)
        turn = [rng.uniform(0, 180) for _ in range(3)]
        length = rng.uniform(7, 20) * depth / camera.focal_px
        add_leaf(length, length * 0.45, rng.choice(greens), spot, turn)
    for _ in range(9):
        depth = rng.uniform(1.7, 5)
        bark = make_material((0.12, 0.08, 0.05))
        x, lean = rng.uniform(-200, 200), rng.uniform(-60, 60)
        foot, top = place(camera, x, -150, depth), place(camera, x + lean, 150, depth)
        add_rod(foot, top, rng.uniform(0.8, 2) * depth / camera.focal_px, bark)
    for _ in range(45):
        depth = 1.0 / rng.uniform(1 / 8, 1 / 1.7)
        spot = place(camera, rng.uniform(-195, 195), rng.uniform(-115, 115), depth)
        radius = rng.uniform(0.6, 1.2) * depth / camera.focal_px
        add_lamp(spot, radius, (1.0, 0.95, 0.85), log_uniform(rng, 60, 600))


def build_ortho(camera):
    """Boxes on a textured floor, seen by an orthographic camera."""
    rng = random.Random(606)
    set_light((0.55, 0.7, 1.0), 0.5, 2.4, (40, 0, 50))
    floor = make_material(((0.6, 0.56, 0.5), (0.16, 0.2, 0.26)), "checker", 6.0)
    add_quad(30, 30, floor, (0, 8, 0))
    for _ in range(26):
        tall = rng.uniform(0.15, 1.0)
        colours = (random_colour(rng, 0.25), random_colour(rng, 0.02, 0.3))
        skin = make_material(colours, rng.choice(["noise", "brick", "checker"]), 9.0)
        spot = (rng.uniform(-2, 2), rng.uniform(2.0, 8.0), tall / 2)
        size = (rng.uniform(0.12, 0.4), rng.uniform(0.12, 0.4), tall)
        add_box(size, skin, spot, rng.uniform(0, 90))


def build_bar(camera):
    """Glasses, a mirror and chrome: what one depth per pixel cannot say."""
    rng = random.Random(707)
    set_light((0.7, 0.75, 1.0), 0.55, 1.8, (55, 0, 25))
    wood = make_material(((0.45, 0.24, 0.12), (0.2, 0.1, 0.05)), "noise", 9.0, 0.15)
    add_quad(3, 4, wood, (0, 1.8, 0))
    wall = make_material(((0.5, 0.48, 0.42), (0.15, 0.22, 0.25)), "brick", 5.0)
    add_quad(6, 3, wall, (0, 3.6, 1.2), (90, 0, 0))
    add_quad(1.1, 0.7, make_mirror((0.9, 0.9, 0.92)), (-0.55, 2.4, 0.4), (90, 0, 24))
    for i in range(7):
        x, depth = -0.42 + 0.14 * i, 0.75 + 0.22 * (i % 4)
        tint = rng.choice([(1, 1, 1), (0.7, 0.95, 0.8), (1.0, 0.8, 0.5)])
        low, high = (x, depth, 0.005), (x, depth, rng.uniform(0.12, 0.2))
        add_rod(low, high, 0.035, make_glass(tint), 32)
    for x, depth, size in ((0.16, 0.85, 0.05), (-0.25, 1.25, 0.07), (0.5, 1.9, 0.1)):
        add_ball(size, make_mirror((0.95, 0.93, 0.9), 0.05), (x, depth, size))
    add_ball(0.045, make_glass((1, 1, 1)), (0.02, 0.62, 0.045))
    for _ in range(10):
        depth = rng.uniform(1.4, 3.2)
        skin = make_material(
            (random_colour(rng), random_colour(rng, 0.02, 0.3)), "checker", 22.0, 0.1
        )
        size = (rng.uniform(0.06, 0.16), 0.08, rng.uniform(0.1, 0.4))
        spot = (rng.uniform(-0.4, 0.4) * depth, depth, size[2] / 2)
        add_box(size, skin, spot, rng.uniform(0, 90))
    for _ in range(14):
        depth = rng.uniform(2.2, 3.5)
        spot = place(camera, rng.uniform(-190, 190), rng.uniform(20, 120), depth)
        strength = log_uniform(rng, 30, 300)
        add_lamp(spot, 1.5 * depth / camera.focal_px, random_warm(rng), strength)


def build_street(camera):
    """A wet street at dusk behind a fence: lamps, glossy ground, thin things near."""
    rng = random.Random(808)
    set_light((0.25, 0.3, 0.5), 0.5, 0.5, (70, 0, 10))
    stone = ((0.14, 0.13, 0.13), (0.05, 0.05, 0.06))
    wet = make_material(stone, "noise", 1.5, 0.35, 0.15)
    add_quad(30, 60, wet, (0, 28, 0))
    for side in (-1, 1):
        for i in range(8):
            tall, depth = rng.uniform(3, 7), 5 + 4.0 * i
            colours = (random_colour(rng, 0.2, 0.6), random_colour(rng, 0.03, 0.2))
            skin = make_material(colours, "brick", 1.4)
            add_box((2.5, 3.6, tall), skin, (side * 4.6, depth, tall / 2))
    for i in range(9):
        depth, x = rng.uniform(3.0, 20.0), rng.uniform(-2.6, 2.6)
        coat = make_material(random_colour(rng), gloss=0.05)
        add_box((0.45, 0.3, 1.3), coat, (x, depth, 0.65), rng.uniform(0, 90))
        face = make_material((random_colour(rng, 0.3), (0.2, 0.1, 0.08)), "noise", 20.0)
        add_ball(0.14, face, (x, depth, 1.46))
    fence = make_material((0.3, 0.32, 0.33), gloss=0.2)
    for i in range(15):
        for slope in (-1, 1):
            x = -280 + 40 * i
            foot = place(camera, x - 130 * slope, -150, 0.9)
            top = place(camera, x + 130 * slope, 150, 0.9)
            add_rod(foot, top, 1.3 * 0.9 / camera.focal_px, fence)
    for i in range(40):
        depth = rng.uniform(4.0, 34.0)
        spot = place(camera, rng.uniform(-200, 200), rng.uniform(-12, 120), depth)
        strength = log_uniform(rng, 20, 600)
        radius = rng.uniform(0.8, 2.2) * depth / camera.focal_px
        add_lamp(spot, radius, random_warm(rng), strength)


def build_mirrors(camera):
    """A flat mirror, a pane and a ball of chrome, in focus; what they show is not."""
    rng = random.Random(909)
    set_light((0.6, 0.7, 1.0), 0.7, 1.6, (50, 0, 40))
    floor = make_material(((0.55, 0.5, 0.42), (0.14, 0.15, 0.2)), "checker", 5.0)
    add_quad(12, 12, floor, (0, 0, 0))
    brick = make_material(((0.5, 0.2, 0.13), (0.3, 0.22, 0.17)), "brick", 3.0)
    add_quad(8, 3, brick, (0, 4.2, 1.2), (90, 0, 0))
    plaster = make_material(((0.75, 0.7, 0.55), (0.1, 0.2, 0.25)), "noise", 4.0)
    add_quad(5, 3, plaster, (1.6, -1.2, 1.2), (90, 0, 35))
    mirror = make_mirror((0.92, 0.92, 0.92))
    add_quad(0.62, 0.46, mirror, (-0.33, 1.5, 0.3), (90, 0, 24))
    add_box((0.5, 0.012, 0.42), make_glass((1, 1, 1)), (0.3, 1.22, 0.28), -12)
    add_ball(0.085, make_mirror((0.95, 0.93, 0.9)), (-0.015, 1.2, 0.085))
    for x, y, tall in (  # seen in the mirror alone, behind the pane, beside it
        (0.36, 0.62, 0.34), (0.56, 0.3, 0.42), (0.95, -0.15, 0.5),
        (0.3, 2.1, 0.36), (0.62, 2.6, 0.5), (0.42, 3.3, 0.44), (-0.2, 2.7, 0.6),
    ):  # fmt: skip
        colours = (random_colour(rng), random_colour(rng, 0.02, 0.3))
        skin = make_material(colours, rng.choice(["noise", "checker"]), 16.0)
        add_box((0.12, 0.12, tall), skin, (x, y, tall / 2), rng.uniform(0, 90))
    post = make_material((0.4, 0.12, 0.08))
    add_rod((-0.2, 0.85, 0), (-0.23, 0.85, 0.7), 0.012, post)
    for x, y, z in ((0.9, -0.6, 0.5), (0.74, 0.15, 0.6), (0.36, 3.6, 0.55)):
        lamp = add_lamp((x, y, z), 0.012, random_warm(rng), 60)
        lamp.visible_glossy = lamp.visible_transmission = True


SCENES = {
    "posts": (Camera(480, 270, 50, 0.8, 1.0), build_posts),
    "portrait": (
        Camera(
            288,
            448,
            60,
            0.95,
            1.2,
            blades=6,
            rotation_deg=10,
            height_above_ground=0.34,
            pitch_deg=-10,
        ),
        build_portrait,
    ),
    "plane": (
        Camera(360, 240, 35, 0.4, 1.5, height_above_ground=0.22, pitch_deg=-6),
        build_plane,
    ),
    "macro": (
        Camera(320, 200, 100, 1.25, 0.3, blades=5, rotation_deg=20, ratio=1.5),
        build_macro,
    ),
    "foliage": (Camera(400, 240, 50, 0.58, 3.0), build_foliage),
    "ortho": (
        Camera(
            320,
            240,
            50,
            1.5,
            6.0,
            ortho_scale=4.0,
            height_above_ground=4.2,
            pitch_deg=-36,
        ),
        build_ortho,
    ),
    "bar": (
        Camera(
            400, 260, 50, 0.7, 1.1, height_above_ground=0.2, pitch_deg=-4, bounces=4
        ),
        build_bar,
    ),
    "street": (
        Camera(
            420, 260, 40, 0.3, 5.0, height_above_ground=1.5, pitch_deg=-2, bounces=2
        ),
        build_street,
    ),
    "mirrors": (
        Camera(
            480, 270, 50, 0.55, 1.3, height_above_ground=0.3, pitch_deg=-2, bounces=4
        ),
        build_mirrors,
    ),
    "fur": (
        Camera(
            400, 240, 50, 0.45, 1.2, height_above_ground=0.24, pitch_deg=-5, bounces=2
        ),
        build_fur,
    ),
    "snow": (Camera(400, 240, 50, 0.55, 3.0, bounces=2), build_snow),
    "cards": (Camera(400, 240, 50, 0.6, 2.6, bounces=2), build_cards),
    "grass": (
        Camera(400, 240, 50, 0.5, 1.3, height_above_ground=0.16, pitch_deg=-4),
        build_grass,
    ),
    "night": (
        Camera(
            400, 240, 40, 0.4, 3.2, height_above_ground=1.15, pitch_deg=2, bounces=2
        ),
        build_night,
    ),
    "branches": (
        Camera(400, 240, 50, 0.6, 2.6, height_above_ground=0.25, pitch_deg=4),
        build_branches,
    ),
}


# --- rendering --------------------------------------------------------------------


def add_camera(facts):
    """Puts the camera into the scene, its depth of field set but switched off."""
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "AUTO"
    data.sensor_width = facts.sensor_mm
    data.lens = facts.lens_mm
    data.clip_start, data.clip_end = 0.01, 1000.0
    if facts.ortho_scale:
        data.type = "ORTHO"
        data.ortho_scale = facts.ortho_scale
    data.dof.use_dof = False
    data.dof.focus_distance = facts.focus
    data.dof.aperture_fstop = facts.fstop
    data.dof.aperture_blades = facts.blades
    data.dof.aperture_rotation = math.radians(facts.rotation_deg)
    data.dof.aperture_ratio = facts.ratio
    camera = bpy.data.objects.new("camera", data)
    camera.location = (0, 0, facts.height_above_ground)
    camera.rotation_euler = (math.radians(90 + facts.pitch_deg), 0, 0)
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    return camera


def set_up_render(facts):
    """Cycles on the CPU, no denoising, no adaptive sampling, few bounces, EXR."""
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = facts.width, facts.height
    render.resolution_percentage = 100
    render.film_transparent = False
    render.use_file_extension = False
    if hasattr(render.image_settings, "media_type"):  # Blender 5.0 and later
        render.image_settings.media_type = "MULTI_LAYER_IMAGE"
        render.image_settings.use_exr_interleave = True  # one part
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "ZIP"
    cycles.device = "CPU"
    cycles.use_denoising = False
    cycles.use_adaptive_sampling = False
    cycles.max_bounces = facts.bounces + 1
    cycles.diffuse_bounces = 1
    cycles.glossy_bounces = facts.bounces
    cycles.transmission_bounces = facts.bounces + 1
    cycles.caustics_reflective = cycles.caustics_refractive = False
    scene.view_settings.view_transform = "Raw"
    scene.view_layers[0].use_pass_z = True


def render_only(facts, window):
    """Limits the render to a window (x, y, width, height) in px from the top left."""
    x, y, width, height = window
    render = bpy.context.scene.render
    render.use_border = render.use_crop_to_border = True
    inside = 0.25  # px: Blender cuts the fraction off, whatever its rounding
    render.border_min_x = (x + inside) / facts.width
    render.border_max_x = (x + width + inside) / facts.width
    render.border_min_y = (facts.height - y - height + inside) / facts.height
    render.border_max_y = (facts.height - y + inside) / facts.height


def build(name, focus=None):
    """Makes the named scene from nothing; returns (camera facts, camera object)."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    facts, build_scene = SCENES[name]
    if focus:
        facts = replace(facts, focus=focus)
    set_up_render(facts)
    camera = add_camera(facts)
    build_scene(facts)
    return facts, camera


def render_to(path, samples, seed):
    """Renders the current scene into one multilayer EXR."""
    scene = bpy.context.scene
    scene.cycles.samples = samples
    scene.cycles.seed = seed
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def lens_offset(facts, index, count):
    """Point of the lens of one view: (right, up) in scene units, as rf_lens_points()."""
    rho = math.sqrt((index + 0.5) / count) * facts.lens_radius
    angle = index * GOLDEN_ANGLE_RAD
    if count in RINGS:
        rho, angle = RINGS[count]
        rho *= facts.lens_radius
        angle += 2 * math.pi * index / count
    return rho * math.cos(angle) / facts.ratio, rho * math.sin(angle)


def plane_in_place(facts, samples, scale):
    """Distance of the plane that stays put in views of so many samples.

    That in focus, or one 1.5 px of blur beyond, of a picture `scale` times as large:
    blender_addon/sampling.py says why.
    """
    if samples > FEW_SAMPLES:
        return facts.focus
    off = 1.5 / (scale * facts.lens_radius * facts.focal_px)
    in_focus = 1 / facts.focus
    return 1 / (in_focus - off if in_focus > 2 * off else in_focus + off)


def open_tiny_lens(camera, facts):
    """Spreads all samples over a disc of 0.5 px in place of the pixel filter."""
    bpy.context.scene.cycles.filter_width = 0.01
    close, dof = 0.01 * facts.focus, camera.data.dof
    radius = 0.5 / facts.focal_px * close / 0.99
    dof.use_dof, dof.focus_distance = True, close
    dof.aperture_fstop = facts.lens_mm * 1e-3 / (2 * radius)
    dof.aperture_blades, dof.aperture_ratio = 0, 1


def move_to_lens_point(camera, facts, right, up, plane, pan_px):
    """Moves the camera within the lens and shears it: a plane stays put."""
    turn = camera.rotation_euler.to_matrix()
    base = Vector((0, 0, facts.height_above_ground))
    camera.location = base + turn @ Vector((right, up, 0))
    to_shift = -facts.focal_px / (plane * facts.longer_px)
    camera.data.shift_x = right * to_shift + pan_px / facts.longer_px
    camera.data.shift_y = up * to_shift


def render_views(facts, camera, prefix, options):
    """Renders the pinhole views, each with a seed of its own; returns their offsets."""
    if facts.ortho_scale:
        sys.exit("Blender's orthographic camera cannot be sheared: no views")
    plane = plane_in_place(facts, options.samples, options.supersample)
    if options.samples <= FEW_SAMPLES:
        open_tiny_lens(camera, facts)
    offsets = []
    for index in range(options.count):
        right, up = lens_offset(facts, index, options.count)
        move_to_lens_point(camera, facts, right, up, plane, options.pan)
        render_to(
            f"{prefix}_view{index:02d}.exr", options.samples, options.seed + index
        )
        offsets.append((right, up))
    return offsets


def defocus_tree(facts, pinhole):
    """Compositor nodes: a rendered EXR through the Defocus node; returns that node."""
    scene = bpy.context.scene
    scene.use_nodes = True
    scene.render.use_compositing = True
    tree = scene.node_tree
    tree.nodes.clear()
    source = tree.nodes.new("CompositorNodeImage")
    source.image = bpy.data.images.load(str(pinhole))
    defocus = tree.nodes.new("CompositorNodeDefocus")
    defocus.scene = scene
    defocus.use_zbuffer = True
    defocus.use_preview = False
    defocus.blur_max = 128.0
    defocus.bokeh = DEFOCUS_BOKEH.get(facts.blades, "OCTAGON")
    defocus.angle = math.radians(facts.rotation_deg)
    composite = tree.nodes.new("CompositorNodeComposite")
    tree.links.new(source.outputs["Combined"], defocus.inputs["Image"])
    tree.links.new(source.outputs["Depth"], defocus.inputs["Z"])
    tree.links.new(defocus.outputs["Image"], composite.inputs["Image"])
    return defocus


def render_defocus(facts, prefix):
    """Runs the Defocus node over the pinhole picture at a range of f-stops.

    Blender 3.x blurs about 1000 / sensor_mm times too much, so the useful f-stops lie
    around that multiple of the camera's own; collect_references.py keeps the best one.
    For an orthographic camera (measured) the camera's own f-stop is the best.
    """
    pinhole = Path(f"{prefix}_pinhole.exr")
    if not pinhole.exists():
        sys.exit(f"{pinhole} is missing: render the pinhole pass first")
    defocus = defocus_tree(facts, pinhole)
    centre = facts.fstop
    if bpy.app.version < (4, 2, 0) and not facts.ortho_scale:
        centre *= 1000.0 / facts.sensor_mm
    for factor in DEFOCUS_FACTORS:
        defocus.f_stop = min(centre * factor, 128.0)
        render_to(f"{prefix}_defocus_{defocus.f_stop:.3f}.exr", 1, 0)


def parse_options():
    """Reads what stands after "--" on Blender's command line."""
    argv = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else ["--help"]
    parser = argparse.ArgumentParser(prog="cycles_scenes.py", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("scene", choices=[*SCENES, "list"])
    parser.add_argument("outdir", type=Path)
    passes = ("pinhole", "dof", "reference", "views", "defocus")
    parser.add_argument("--pass", dest="passes", action="append", choices=passes)
    parser.add_argument("--samples", type=int, help="per pixel; default by pass")
    parser.add_argument("--seed", type=int, default=1, help="views: of the first view")
    parser.add_argument("--count", type=int, default=8, help="number of views")
    parser.add_argument(
        "--supersample", type=int, default=1, metavar="N",
        help="pinhole, views: pictures of N times the size, with --samples in a pixel",
    )  # fmt: skip
    parser.add_argument("--focus", type=float, help="focus distance, not the scene's")
    parser.add_argument(
        "--window", type=int, nargs=4, metavar=("X", "Y", "WIDTH", "HEIGHT"),
        help="render this part alone, px from the top left",
    )  # fmt: skip
    parser.add_argument(
        "--pan", type=float, default=0.0, help="px that the picture moves to the left"
    )
    parser.add_argument(
        "--denoising-data", action="store_true", help="also albedo and normals"
    )
    parser.add_argument(
        "--light-passes", action="store_true", help="also glossy and transmitted light"
    )
    return parser.parse_args(argv)


def render_pass(name, scene_name, options):
    """Builds the scene afresh and renders one pass of it."""
    facts, camera = build(scene_name, options.focus)
    layer = bpy.context.scene.view_layers[0]
    layer.cycles.denoising_store_passes = options.denoising_data
    for light in ("glossy", "transmission") if options.light_passes else ():
        for part in ("direct", "indirect", "color"):
            setattr(layer, f"use_pass_{light}_{part}", True)
    camera.data.shift_x = options.pan / facts.longer_px
    if options.window:
        render_only(facts, options.window)
    bpy.context.scene.render.resolution_percentage = 100 * options.supersample
    prefix = options.outdir / scene_name
    defaults = {"pinhole": 64, "dof": 64, "reference": 2048, "views": 8, "defocus": 1}
    options.samples = options.samples or defaults[name]
    about = {"camera": facts.facts(), "blender": bpy.app.version_string}
    if name == "views":
        about["view_offsets"] = render_views(facts, camera, prefix, options)
        about["shear_distance"] = plane_in_place(
            facts, options.samples, options.supersample
        )
    elif name == "defocus":
        render_defocus(facts, prefix)
    else:
        camera.data.dof.use_dof = name != "pinhole"
        suffix = f"_seed{options.seed}" if name == "reference" else ""
        render_to(f"{prefix}_{name}{suffix}.exr", options.samples, options.seed)
    about.update(
        samples=options.samples, seed=options.seed, supersample=options.supersample
    )
    Path(f"{prefix}_{name}.json").write_text(json.dumps(about, indent=1) + "\n")


def main():
    """Renders the passes asked for (the pinhole pass if none is)."""
    options = parse_options()
    if options.scene == "list":
        print("\n".join(SCENES))
        return
    options.outdir.mkdir(parents=True, exist_ok=True)
    samples = options.samples
    for name in options.passes or ["pinhole"]:
        options.samples = samples
        render_pass(name, options.scene, options)


if __name__ == "__main__":
    main()
