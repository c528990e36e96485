#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Other renderers' files against their own lenses: Mitsuba and LuxCore, from PyPI.

    pip install mitsuba pyluxcore numpy OpenImageIO
    tests/quality/renderers.py RACKFOCUS FOLDER [mitsuba] [luxcore]

Renders what is missing in FOLDER, minutes on two cores, and prints tPSNR in dB. Mitsuba:
by its two common pixel filters, the own lens, one view and 8 views, raw and denoised.
LuxCore: its depth as it is and as the command mends it. RACKFOCUS_OIDN names the folder
of Open Image Denoise.
"""

import argparse
import json
import math
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

SIZE = (480, 270)
FOV, FOCUS, RADIUS = 40, 6.0, 0.1
LENS = ["--focus-distance", FOCUS, "--lens-radius", RADIUS, "--depth", "radial"]
LENS += ["--focal-length-px", SIZE[0] / 2 / math.tan(math.radians(FOV / 2))]
EYE, TARGET = np.array([0, 1.5, -6]), np.array([0, 0.6, 0])
AOVS = "depth:depth,albedo:albedo,normal:sh_normal"
VEC2 = oiio.TypeDesc(oiio.FLOAT, oiio.VEC2)


def lens_points(n):
    """Points of the lens: a sunflower of n, right and up."""
    turn = math.pi * (3 - math.sqrt(5))
    at = [(RADIUS * math.sqrt((i + 0.5) / n), i * turn) for i in range(n)]
    return [(r * math.cos(a), r * math.sin(a)) for r, a in at]


# ---- Mitsuba ---------------------------------------------------------------------


def mitsuba_things():
    """A checkered floor, a mirror in focus, balls at all distances, lamps behind."""
    import mitsuba as mi

    move = mi.ScalarTransform4f
    rng = np.random.default_rng(0)

    def rgb(*v):
        return {"type": "rgb", "value": [float(x) for x in v]}

    def ball(x, y, z, radius, **what):
        return {"type": "sphere", "center": [x, y, z], "radius": radius, **what}

    checks = {"type": "checkerboard", "to_uv": move().scale([60, 60, 1])}
    mirror = {"type": "roughconductor", "alpha": 0.1}
    things = {
        "sky": {"type": "constant", "radiance": rgb(0.4, 0.5, 0.7)},
        "floor": {
            "type": "rectangle",
            "to_world": move().rotate([1, 0, 0], -90).scale(20),
            "bsdf": {"type": "diffuse", "reflectance": checks},
        },
        "light": ball(
            3, 6, -3, 0.7, emitter={"type": "area", "radiance": rgb(30, 30, 30)}
        ),
        "mirror": ball(0, 0.6, 0, 0.6, bsdf=mirror),
    }
    for i in range(14):
        z, side, radius = rng.uniform(-3, 12), rng.uniform(-3, 3), rng.uniform(0.2, 0.5)
        colour = rgb(*rng.uniform(0.1, 0.9, 3))
        bsdf = {"type": "plastic", "diffuse_reflectance": colour}
        things[f"ball{i}"] = ball(
            side * (1 + (z + 3) / 8), radius, z, radius, bsdf=bsdf
        )
    for i in range(5):
        z, x = rng.uniform(4, 12), rng.uniform(-5, 5)
        lamp = {"type": "area", "radiance": rgb(200, 120, 60)}
        things[f"lamp{i}"] = ball(x, 1.5 + 0.3 * i, z, 0.05, emitter=lamp)
    return things


def mitsuba(path, sensor, samples, seed, pixel_filter, point=(0, 0)):
    """Renders `path`; `point` of the lens, sheared so that what is in focus stays."""
    if path.exists():
        return path
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    ahead = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(ahead, [0, 1, 0])
    right /= np.linalg.norm(right)
    eye = EYE + right * point[0] + np.cross(right, ahead) * point[1]
    width = 2 * FOCUS * math.tan(math.radians(FOV / 2))
    shift = {
        "principal_point_offset_x": -point[0] / width,
        "principal_point_offset_y": point[1] / width * SIZE[0] / SIZE[1],
    }
    look = mi.ScalarTransform4f().look_at(
        origin=eye.tolist(), target=(eye + ahead).tolist(), up=[0, 1, 0]
    )
    film = {
        "type": "hdrfilm",
        "width": SIZE[0],
        "height": SIZE[1],
        "pixel_format": "rgb",
    }
    film["rfilter"] = {"type": pixel_filter}
    camera = {"fov": FOV, "fov_axis": "x", "to_world": look, "film": film}
    camera["sampler"] = {"type": "independent", "sample_count": samples}
    way = {"type": "path", "max_depth": 6}
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "aov", "aovs": AOVS, "img": way},
            "sensor": {**camera, **sensor, **(shift if any(point) else {})},
            **mitsuba_things(),
        }
    )
    mi.render(scene, seed=seed)
    scene.sensors()[0].film().bitmap().write(str(path))
    return path


def say_point(path, point):
    """Writes where the eye of a view was into its header."""
    source = oiio.ImageInput.open(str(path))
    spec, pixels = source.spec(), source.read_image(
        0, 0, 0, source.spec().nchannels, "float"
    )
    source.close()
    spec.attribute("rackfocus:lensOffset", VEC2, tuple(map(float, point)))
    spec.attribute("rackfocus:shearDistance", FOCUS)
    out = oiio.ImageOutput.create(str(path))
    spec.tile_width = spec.tile_height = 0
    assert out.open(str(path), spec), out.geterror()
    assert out.write_image(np.ascontiguousarray(pixels)), out.geterror()
    out.close()


def run_mitsuba(tool, folder):
    thin = {"type": "thinlens", "aperture_radius": RADIUS, "focus_distance": FOCUS}
    pinhole = {"type": "perspective"}
    points = lens_points(8)
    print("| Mitsuba, dB | own | own dn | 1 | 1 dn | 8 | 8 dn | finish 8 on top |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for kind in ("gaussian", "box"):
        reference = mitsuba(folder / f"{kind}_reference.exr", thin, 1024, 9999, kind)
        for n in (16, 64):
            own = mitsuba(folder / f"{kind}_own_{n}.exr", thin, n, 7777, kind)
            one = mitsuba(folder / f"{kind}_one_{n}.exr", pinhole, n, 5555, kind)
            views = []
            for i, point in enumerate(points):
                path = folder / f"{kind}_view_{n}_{i}.exr"
                if not path.exists():
                    mitsuba(path, pinhole, n // 8, 1000 * (i + 1), kind, point)
                    say_point(path, point)
                views.append(path)
            figures = [
                tool.compare(own, reference),
                tool.score(reference, "finish", own),
                tool.score(reference, "filter", one, *LENS),
                tool.score(reference, "filter", one, *LENS, "--denoise"),
                tool.score(reference, "filter", *views, *LENS),
                tool.score(reference, "filter", *views, *LENS, "--denoise"),
                tool.score(reference, "finish", own, *views, *LENS),
            ]
            words = " | ".join(f"{v:.2f}" for v in figures)
            print(f"| {kind}, {n} samples | {words} |", flush=True)


# ---- LuxCore ---------------------------------------------------------------------

LUX_SCENE = """
scene.camera.type = perspective
scene.camera.lookat.orig = 0 -6 1.5
scene.camera.lookat.target = 0 0 0.6
scene.camera.fieldofview = {fov}
scene.camera.lensradius = {radius}
scene.camera.focaldistance = {focus}
scene.camera.autofocus.enable = 0
scene.lights.sky.type = constantinfinite
scene.lights.sky.gain = 0.4 0.5 0.7
scene.textures.check.type = checkerboard3d
scene.textures.check.texture1 = 0.8
scene.textures.check.texture2 = 0.1
scene.textures.check.mapping.type = globalmapping3d
scene.textures.check.mapping.transformation = 2 0 0 0 0 2 0 0 0 0 2 0 0 0 0.5 1
scene.materials.floor.type = matte
scene.materials.floor.kd = check
scene.materials.box.type = matte
scene.materials.box.kd = 0.8 0.2 0.1
"""

LUX_CONFIG = """
renderengine.type = PATHCPU
sampler.type = SOBOL
film.width = {width}
film.height = {height}
batch.haltspp = {samples}
film.filter.type = BLACKMANHARRIS
film.outputs.0.type = RGB
film.outputs.0.filename = {path}_rgb.exr
film.outputs.1.type = DEPTH
film.outputs.1.filename = {path}_depth.exr
film.imagepipelines.0.0.type = NOP
"""


def luxcore(path, radius, samples):
    """Renders path_rgb.exr and path_depth.exr: boxes on a checkered floor."""
    if Path(f"{path}_rgb.exr").exists():
        return
    import pyluxcore as lux

    lux.Init(lambda message: None)
    scene, words = lux.Scene(), lux.Properties()
    words.SetFromString(LUX_SCENE.format(fov=FOV, radius=radius, focus=FOCUS))
    scene.Parse(words)

    def add(name, corners, triangles, material):
        scene.DefineMesh(f"mesh_{name}", corners, triangles, None, None, None, None)
        text = f"scene.objects.{name}.shape = mesh_{name}\n"
        words = lux.Properties()
        words.SetFromString(text + f"scene.objects.{name}.material = {material}\n")
        scene.Parse(words)

    floor = [(-40, -10, 0), (40, -10, 0), (40, 60, 0), (-40, 60, 0)]
    add("floor", floor, [(0, 1, 2), (0, 2, 3)], "floor")
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4)]
    sides += [(1, 5, 7, 3)]
    faces = [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]
    rng = np.random.default_rng(1)
    places = [(0.0, 0.0, 0.4)]
    for _ in range(10):
        y, x, s = rng.uniform(-3, 14), rng.uniform(-3, 3), rng.uniform(0.15, 0.5)
        places.append((x * (1 + (y + 3) / 8), y, s))
    ends = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    for i, (x, y, s) in enumerate(places):
        corners = [(x + s * a, y + s * b, s + s * c) for a, b, c in ends]
        add(f"box{i}", corners, faces, "box")
    words = lux.Properties()
    size = {"width": SIZE[0], "height": SIZE[1], "samples": samples, "path": path}
    words.SetFromString(LUX_CONFIG.format(**size))
    session = lux.RenderSession(lux.RenderConfig(words, scene))
    session.Start()
    while not session.HasDone():
        time.sleep(0.2)
        session.UpdateStats()
    session.Stop()
    session.GetFilm().Save()


def run_luxcore(tool, folder):
    luxcore(folder / "lux_pinhole", 0, 64)
    luxcore(folder / "lux_lens", RADIUS, 512)
    reference = folder / "lux_lens_rgb.exr"
    passes = [folder / "lux_pinhole_rgb.exr", "--depth-channel", "R", *LENS]
    passes += ["--depth-file", folder / "lux_pinhole_depth.exr"]
    print("\n| LuxCore, dB | depth as it is | mended |\n| --- | --- | --- |")
    raw = tool.score(reference, "filter", *passes, "--depth-repair", "off")
    print(
        f"| 64 samples | {raw:.2f} | {tool.score(reference, 'filter', *passes):.2f} |"
    )


class Tool:
    """The command."""

    def __init__(self, command, folder):
        self.command, self.out = command, folder / "out.exr"

    def run(self, *words):
        line = [*map(str, (self.command, *words))]
        return subprocess.run(line, check=True, capture_output=True, text=True).stdout

    def compare(self, picture, reference):
        return json.loads(self.run("compare", picture, reference, "--json"))["tpsnr"]

    def score(self, reference, *words):
        self.run(*words, "-o", self.out, "--type", "float", "-q")
        return self.compare(self.out, reference)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("command", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("which", nargs="*", default=["mitsuba", "luxcore"])
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    tool = Tool(options.command.resolve(), options.folder.resolve())
    for name in options.which:
        {"mitsuba": run_mitsuba, "luxcore": run_luxcore}[name](
            tool, options.folder.resolve()
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
