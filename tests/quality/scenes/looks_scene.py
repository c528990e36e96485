# SPDX-License-Identifier: Apache-2.0
"""Renders the scene of the lens looks through a lens written ray by ray.

    python3.11 looks_scene.py OUTDIR [--samples N] [--seed N] [LOOK ...]

LOOK is one of LOOKS below; without any, all of them, the pinhole and 8 views. Each look
becomes OUTDIR/look_LOOK_seedN.exr, the pinhole's colour and depth
OUTDIR/look_pinhole.exr, views from points of the lens OUTDIR/look_view00.exr and so on,
all of them multilayer EXR of 32-bit floats; collect_looks.py makes the committed files.

Needs bpy 5.0.1 or later (pip install bpy==5.0.1, Python 3.11): Cycles takes cameras
written in OSL since Blender 5.0, and lens_camera.osl is the lens. Lamps lie over the
whole field, behind the focus and before it.
"""

import argparse
import math
import os
import random
import sys
from pathlib import Path

import bpy
import cycles_scenes as scenes
import numpy as np

HERE = Path(__file__).parent
CAMERA = scenes.Camera(480, 270, 50, 0.8, 1.0)
PICTURE_PX = 64
CLEAR_PX = 10
N_VIEWS = 8
FLOOR = -0.65  # below the camera: what is seen at the lower edge is behind the focus

#: Parameters of the filter by look. An aperture's picture is collected beside them.
LOOKS = {
    "plain": {},
    "cat_eye": {"cat_eye": 0.9},
    "tilt": {"tilt_x": 1.0, "tilt_y": 2.5},
    "spherical": {"spherical": 4.0},
    "swirl": {"swirl": 0.5, "astigmatism": -0.3, "cat_eye": 0.5},
    "field_curvature": {"field_curvature": 0.3},
    "blades": {"blades": 5, "blade_rotation": 10.0, "blade_curvature": 0.5},
    "image": {"picture": "aperture.exr"},
    "axial_chroma": {"axial_chroma": 2.0},
    "lateral_chroma": {"lateral_chroma": 0.01},
    "split_diopter": {"split_diopter": 4.0, "split_offset": 0.2, "split_angle": 20.0},
    "doors": {"barn_left": 1.0, "barn_top": 1.2, "barn_bottom": 0.5},
    "cat_eye_tilt": {"cat_eye": 0.9, "tilt_x": 1.0, "tilt_y": 2.5},
    "spherical_below": {"spherical": -4.0},
}


def is_clear(camera, x_px, y_px, depth):
    """Is a place seen, and all within CLEAR_PX of it? One view cannot know the rest."""
    graph = bpy.context.evaluated_depsgraph_get()
    for i in range(9):
        turn = i * math.pi / 4
        reach = CLEAR_PX if i else 0
        to = scenes.place(
            camera,
            x_px + reach * math.cos(turn),
            y_px + reach * math.sin(turn),
            depth,
        )
        far = to.length
        if bpy.context.scene.ray_cast(graph, (0, 0, 0), to / far, distance=far)[0]:
            return False
    return True


def add_lamps(rng, camera, count, depths, strengths, size):
    """Lamps in a loose grid over the whole picture; count is columns and rows."""
    for i in range(count[0] * count[1]):
        x = (i % count[0] + rng.uniform(0.25, 0.75)) / count[0] - 0.5
        y = (i // count[0] + rng.uniform(0.25, 0.75)) / count[1] - 0.5
        depth = rng.uniform(*depths)
        at = (x * camera.width, y * camera.height)
        radius = rng.uniform(*size) * depth / camera.focal_px
        strength = scenes.log_uniform(rng, *strengths)
        colour = scenes.random_warm(rng)
        if is_clear(camera, *at, depth):
            scenes.add_lamp(scenes.place(camera, *at, depth), radius, colour, strength)


def make_glowing():
    """Surfaces glow by themselves: what is left to sample is the lens."""
    for material in bpy.data.materials:
        tree = material.node_tree
        diffuse = tree.nodes.get("Diffuse BSDF")
        if not diffuse:
            continue
        glow = tree.nodes.new("ShaderNodeEmission")
        glow.inputs["Strength"].default_value = 0.8
        colour = diffuse.inputs["Color"]
        glow.inputs["Color"].default_value = colour.default_value
        if colour.is_linked:
            tree.links.new(colour.links[0].from_socket, glow.inputs["Color"])
        output = tree.nodes["Material Output"]
        tree.links.new(glow.outputs[0], output.inputs["Surface"])
        material.cycles.emission_sampling = "NONE"


def build_street(camera):
    """A wall and a floor, boxes at all depths, posts before everything, lamps."""
    rng = random.Random(707)
    scenes.set_light((0.5, 0.65, 1.0), 0.4, 1.6)
    colours = ((0.42, 0.14, 0.1), (0.26, 0.18, 0.14))
    scenes.add_quad(
        9, 6, scenes.make_material(colours, "brick", 2.0), (0, 6, 1), (90, 0, 0)
    )
    colours = ((0.5, 0.46, 0.4), (0.1, 0.12, 0.18))
    scenes.add_quad(
        9, 6, scenes.make_material(colours, "checker", 6.0), (0, 3.3, FLOOR)
    )
    for i in range(8):
        depth = 3.2 + 0.3 * i
        tall = rng.uniform(0.1, 0.24) * depth
        pair = (scenes.random_colour(rng), scenes.random_colour(rng, 0.02, 0.3))
        skin = scenes.make_material(pair, rng.choice(["noise", "checker"]), 8.0)
        x = (-0.34 if i % 2 else 0.34) * rng.uniform(0.2, 1) * depth
        size = (0.09 * depth, 0.06 * depth, tall)
        scenes.add_box(size, skin, (x, depth, FLOOR + tall / 2), rng.uniform(0, 90))
    skin = scenes.make_material(((0.8, 0.5, 0.1), (0.25, 0.05, 0.04)), "noise", 45, 0.1)
    scenes.add_ball(0.07, skin, (0.1, 1.0, -0.08))
    skin = scenes.make_material(((0.85, 0.85, 0.8), (0.05, 0.05, 0.1)), "brick", 30.0)
    scenes.add_quad(0.2, 0.12, skin, (-0.13, 1.02, 0.03), (90, 0, 12))
    for x in (-200, -60, 120, 215):
        depth = rng.uniform(0.55, 0.68)
        skin = scenes.make_material(scenes.random_colour(rng, 0.03, 0.5), gloss=0.05)
        ends = [
            scenes.place(camera, x + lean, y, depth)
            for lean, y in ((rng.uniform(-20, 20), -190), (rng.uniform(-20, 20), 190))
        ]
        scenes.add_rod(*ends, rng.uniform(1.5, 4) * depth / camera.focal_px, skin)
    add_lamps(rng, camera, (8, 4), (2.0, 3.0), (40, 100), (2.5, 3.5))
    add_lamps(rng, camera, (5, 2), (0.6, 0.75), (40, 100), (2.5, 3.0))
    make_glowing()


def aperture_picture():
    """A ring in colour with a notch at the right: what tells left, top and colour."""
    at = (np.arange(PICTURE_PX) + 0.5) / (PICTURE_PX / 2) - 1
    u, v = np.meshgrid(at, -at)
    rho = np.hypot(u, v)
    ring = (rho < 1) * (0.25 + 0.75 * (rho > 0.6)) * (1 - 0.9 * ((u > 0) & (v > 0)))
    return np.stack([ring, ring * (0.7 + 0.3 * v), ring * (0.6 - 0.4 * u)], -1)


def write_picture(path):
    """Blender's own writer: a plain EXR of half floats."""
    pixels = aperture_picture()
    image = bpy.data.images.new(
        "aperture", PICTURE_PX, PICTURE_PX, float_buffer=True, is_data=True
    )
    full = np.ones((PICTURE_PX, PICTURE_PX, 4), np.float32)
    full[..., :3] = pixels[::-1]
    image.pixels.foreach_set(full.ravel())
    image.filepath_raw, image.file_format = str(path), "OPEN_EXR"
    image.save()


def light_of(look):
    """What the square around the lens is multiplied by, so that what is open counts 1.

    Of a picture of the aperture, by colour; the same for all where it is grey.
    """
    if "picture" in look:
        return 1 / aperture_picture().mean((0, 1))
    at = (np.arange(4000) + 0.5) / 2000 - 1
    u, v = np.meshgrid(at, at)
    rho, n = np.hypot(u, v), look.get("blades", 0)
    if n == 0:
        return np.full(3, 4 / math.pi)
    half = math.pi / n
    turn = np.arctan2(v, u) - math.radians(look["blade_rotation"]) + half
    turn = np.mod(turn, 2 * half) - half
    sagitta = look["blade_curvature"] * (1 - math.cos(half))
    arc = (math.sin(half) ** 2 + sagitta**2) / (2 * sagitta)
    middle = math.cos(half) + sagitta - arc
    is_open = np.hypot(rho * np.cos(turn) - middle, rho * np.sin(turn)) <= arc
    return np.full(3, 1 / is_open.mean())


def use_lens(camera, folder, look):
    """Gives the camera the lens with a look."""
    sys.path.append(
        str(
            Path(bpy.utils.resource_path("LOCAL"))
            / "python/lib/python3.11/site-packages"
        )
    )
    from cycles import osl

    text = bpy.data.texts.new("lens_camera")
    text.write((HERE / "lens_camera.osl").read_text())
    data = camera.data
    data.type, data.custom_mode, data.custom_shader = "CUSTOM", "INTERNAL", text
    said = []
    if not osl.update_custom_camera_shader(data, lambda kind, what: said.append(what)):
        sys.exit(f"lens_camera.osl: {said}")
    facts = CAMERA.facts()
    values = {
        "focal_px": facts["focal_px"],
        "lens_radius": facts["lens_radius"],
        "focus": CAMERA.focus,
        "focal_length": CAMERA.lens_mm * 1e-3,
        "half_px": math.hypot(CAMERA.width, CAMERA.height) / 2,
        "width_px": float(CAMERA.width),
        "height_px": float(CAMERA.height),
        **look,
    }
    if "picture" in look:
        write_picture(folder / look["picture"])
        values["picture"] = str(folder / look["picture"])
    light = light_of(look)
    values["light"] = float(light[0])
    for key, value in values.items():
        data.cycles_custom[key] = value
    data.update_tag()
    return light / light[0]


def render_look(name, folder, options):
    """One look, or the pinhole; notes beside a look what its colours count."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    scenes.set_up_render(CAMERA)
    scene = bpy.context.scene
    scene.cycles.shading_system = True
    scene.cycles.max_bounces = 0
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    camera = scenes.add_camera(CAMERA)
    build_street(CAMERA)
    if name == "views":
        views = argparse.Namespace(count=N_VIEWS, samples=64, seed=1)
        offsets = scenes.render_views(CAMERA, camera, folder / "look", views)
        np.savetxt(folder / "look_views.offsets", offsets)
        return
    samples = 64 if name == "pinhole" else options.samples
    if name != "pinhole":
        gain = use_lens(camera, folder, LOOKS[name])
        np.savetxt(folder / f"look_{name}.gain", gain)
        samples *= 3 if "chroma" in name else 1  # each ray has one colour
    suffix = "" if name == "pinhole" else f"_seed{options.seed}"
    scenes.render_to(folder / f"look_{name}{suffix}.exr", samples, options.seed)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("outdir", type=Path)
    parser.add_argument("looks", nargs="*", choices=["pinhole", "views", *LOOKS, []])
    parser.add_argument("--samples", type=int, default=512)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.outdir.mkdir(parents=True, exist_ok=True)
    for name in options.looks or ["pinhole", "views", *LOOKS]:
        render_look(name, options.outdir.resolve(), options)
        print("rendered", name, flush=True)
    os._exit(0)  # bpy's own end may crash


if __name__ == "__main__":
    main()
