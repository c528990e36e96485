# SPDX-License-Identifier: Apache-2.0
"""Film Depth against Cycles' own lens: things before transparent film.

    PYTHON_WITH_BPY tests/quality/film.py render FOLDER [SCENE...]
    python3 tests/quality/film.py score FOLDER RACKFOCUS [SCENE...]

The first renders pinhole passes (96 samples) and two references of the lens (768 samples,
two seeds) into FOLDER, some 2 minutes a scene; the second filters the passes with each
--film-depth and prints tPSNR in dB, free of the references' noise, over black and over
white, and over a sky that is seen where alpha is 0, as many renderers write it.
"""

import math
import random
import subprocess
import sys
from pathlib import Path

WIDTH, HEIGHT = 240, 160
F_STOP = 0.1
FOCUS = {"fur": 11, "leaves_far": 3}  # 8 else
SCENES = (
    "cubes",
    "translucent",
    "wide",
    "veils",
    "leaves",
    "leaves_far",
    "large",
    "soft",
    "softglow",
    "smoke",
    "hair",
    "fur",
)
CHOICES = ("keep", "solid", "all", "edges")


# ---- scenes -----------------------------------------------------------------------


def _empty():
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    render = scene.render
    render.engine = "CYCLES"
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    render.film_transparent = True
    render.resolution_x, render.resolution_y = WIDTH, HEIGHT
    if bpy.app.version >= (5, 0):
        render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    scene.view_layers[0].use_pass_z = True
    world = scene.world = bpy.data.worlds.new("World")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs[0].default_value = (0.8, 0.9, 1, 1)
    background.inputs[1].default_value = 0.5
    light = bpy.data.lights.new("Sun", "SUN")
    light.energy = 3
    sun = bpy.data.objects.new("Sun", light)
    sun.rotation_euler = (0.7, 0.3, 0.2)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -8, 0), (math.pi / 2, 0, 0)
    for thing in (sun, camera):
        scene.collection.objects.link(thing)
    scene.camera = camera
    return scene


def _material(colour, alpha=1.0):
    import bpy

    material = bpy.data.materials.new("Material")
    material.use_nodes = True
    surface = material.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*colour, 1)
    surface.inputs["Alpha"].default_value = alpha
    return material


def _fade(material):
    """Alpha falls to 0 over a third of the way to a plane's rim, as a disc."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    place = nodes.new("ShaderNodeTexCoord")
    mapping = nodes.new("ShaderNodeMapping")
    mapping.inputs["Location"].default_value = (-1, -1, 0)
    mapping.inputs["Scale"].default_value = (2, 2, 0)
    sphere = nodes.new("ShaderNodeTexGradient")
    sphere.gradient_type = "SPHERICAL"
    steep = nodes.new("ShaderNodeMapRange")
    steep.inputs["From Max"].default_value = 0.35
    surface = nodes["Principled BSDF"]
    links.new(place.outputs["Generated"], mapping.inputs[0])
    links.new(mapping.outputs[0], sphere.inputs[0])
    links.new(sphere.outputs["Fac"], steep.inputs[0])
    links.new(steep.outputs[0], surface.inputs["Alpha"])


def _cube(place, size, material, turn=(0.3, 0.4, 0.5)):
    import bpy

    bpy.ops.mesh.primitive_cube_add(size=size, location=place, rotation=turn)
    bpy.context.object.data.materials.append(material)
    return bpy.context.object


def _plane(place, size, material, turn=(math.pi / 2, 0, 0)):
    import bpy

    bpy.ops.mesh.primitive_plane_add(size=size, location=place, rotation=turn)
    bpy.context.object.data.materials.append(material)


def _ball(place, radius, material):
    import bpy

    bpy.ops.mesh.primitive_uv_sphere_add(
        radius=radius, location=place, segments=48, ring_count=24
    )
    bpy.context.object.data.materials.append(material)
    return bpy.context.object


def _colour(chance):
    return (chance.random(), chance.random(), chance.random())


def _cubes(chance, name):
    for _ in range(14):
        y = chance.uniform(-4, 14)
        far = (y + 8) / 8
        place = (chance.uniform(-2.5, 2.5) * far, y, chance.uniform(-1.6, 1.6) * far)
        size = chance.uniform(0.4, 1)
        colour = _colour(chance)
        alpha = chance.choice((0.3, 0.7)) if name == "translucent" else 1
        _cube(place, size, _material(colour, alpha), _colour(chance))
    if name == "veils":
        _plane((-1, -3, 0), 2, _material((0.9, 0.4, 0.2), 0.35))
        _plane((1, -2, 0.3), 2, _material((0.2, 0.8, 0.3), 0.6))


def _leaves(chance, name):
    for _ in range(500):
        y = chance.uniform(-4, 8) if name == "leaves" else chance.uniform(0, 3)
        far = (y + 8) / 8
        place = (chance.gauss(0, 1.2) * far, y, chance.gauss(0, 0.8) * far)
        size = chance.uniform(0.1, 0.3)
        green = (chance.uniform(0.1, 0.5), chance.uniform(0.4, 0.9), 0.1)
        turn = [chance.uniform(0, 3) for _ in range(3)]
        _plane(place, size, _material(green), turn)


def _large(chance, name):
    for place, size in (((-1.5, -3, 0), 1.6), ((0.6, 2, 0.5), 2.4), ((3, 9, -1), 4)):
        _ball(place, size / 2, _material(_colour(chance)))


def _soft(chance, name):
    for _ in range(9):
        y = chance.uniform(-4, 12)
        far = (y + 8) / 8
        material = _material(_colour(chance))
        _fade(material)
        place = (chance.uniform(-2, 2) * far, y, chance.uniform(-1.2, 1.2) * far)
        _plane(place, chance.uniform(0.8, 1.6) * max(far, 1), material)
        if name == "softglow":
            surface = material.node_tree.nodes["Principled BSDF"]
            surface.inputs["Emission Color"].default_value = (*_colour(chance), 1)
            surface.inputs["Emission Strength"].default_value = 3


def _smoke(chance, name):
    _cube((0, 0, 0), 1, _material(_colour(chance)))
    smoke = _material((1, 1, 1))
    nodes, links = smoke.node_tree.nodes, smoke.node_tree.links
    volume = nodes.new("ShaderNodeVolumePrincipled")
    volume.inputs["Density"].default_value = 0.6
    nodes.remove(nodes["Principled BSDF"])
    links.new(volume.outputs[0], nodes["Material Output"].inputs["Volume"])
    _cube((0.5, 1, 0.3), 2, smoke)


def _hair(chance, name):
    import bpy

    thickness = 0.004 if name == "hair" else 0.002
    balls = (((-0.6, 0, 0), (0.6, 0.4, 0.2)), ((1.6, 4, 0.4), (0.2, 0.4, 0.6)))
    for place, colour in balls:
        ball = _ball(place, 0.8, _material(colour))
        curve = bpy.data.curves.new("Hair", "CURVE")
        curve.dimensions, curve.bevel_depth = "3D", thickness
        for _ in range(1500):
            up, around = chance.uniform(-1, 1), chance.uniform(0, 2 * math.pi)
            flat = math.sqrt(1 - up * up)
            way = (flat * math.cos(around), flat * math.sin(around), up)
            points = curve.splines.new("POLY").points
            points.add(2)
            for j, point in enumerate(points):
                out = 0.8 + 0.15 * j * chance.uniform(0.7, 1.3)
                at = [
                    p + w * out + chance.gauss(0, 0.03) * j for p, w in zip(place, way)
                ]
                point.co = (at[0], at[1], at[2] - 0.03 * j * j, 1)
        curve.materials.append(ball.data.materials[0])
        bpy.context.scene.collection.objects.link(bpy.data.objects.new("Hair", curve))


BUILDERS = {
    "leaves": _leaves,
    "leaves_far": _leaves,
    "large": _large,
    "soft": _soft,
    "softglow": _soft,
    "smoke": _smoke,
    "hair": _hair,
    "fur": _hair,
}


def render(folder, names):
    import bpy

    for name in names:
        scene = _empty()
        BUILDERS.get(name, _cubes)(random.Random(name), name)
        scene.cycles.filter_width = 5 if name == "wide" else 1.5
        dof = scene.camera.data.dof
        dof.focus_distance, dof.aperture_fstop = FOCUS.get(name, 8), F_STOP
        for kind, samples, seed in (("pin", 96, 0), ("ref", 768, 5), ("ref2", 768, 6)):
            dof.use_dof = kind != "pin"
            scene.cycles.samples, scene.cycles.seed = samples, seed
            scene.render.filepath = str(folder / f"{name}_{kind}.exr")
            bpy.ops.render.render(write_still=True)


# ---- scores -----------------------------------------------------------------------


def _channels(path):
    import OpenImageIO as oiio

    found, part = {}, 0
    source = oiio.ImageInput.open(str(path))
    while source.seek_subimage(part, 0):
        spec = source.spec()
        pixels = source.read_image(part, 0, 0, spec.nchannels, "float")
        for i, channel in enumerate(spec.channelnames):
            found[channel] = pixels[..., i]
        part += 1
    source.close()
    return found


def _rgba(channels):
    import numpy as np

    first = next(n for n in channels if n == "A" or n.endswith("Combined.A"))[:-1]
    return np.stack([channels[first + c] for c in "RGBA"], -1)


def _over(picture, background):
    return picture[..., :3] + background * (1 - picture[..., 3:])


def _shown(light):
    import numpy as np

    light = np.clip(light, 0, 1)
    steep = 1.055 * np.power(np.maximum(light, 1e-9), 1 / 2.4) - 0.055
    return np.where(light <= 0.0031308, 12.92 * light, steep)


def _tpsnr(picture, references):
    import numpy as np

    first, second = (_shown(picture) - _shown(r) for r in references)
    return -10 * np.log10(max((first * second).mean(), 1e-9))


def _filtered(command, path, focus, choice):
    out = path.with_name("filtered.exr")
    lens = ["--focus-distance", focus, "--f-stop", F_STOP, "--focal-length", 50]
    lens += ["--sensor-width", 36, "--film-depth", choice]
    arguments = [command, "filter", path, "-o", out, *lens]
    subprocess.run([str(a) for a in arguments], check=True, capture_output=True)
    return _rgba(_channels(out))


def _write(path, colour, alpha, depth):
    import numpy as np
    import OpenImageIO as oiio

    spec = oiio.ImageSpec(WIDTH, HEIGHT, 5, "float")
    spec.channelnames = ("R", "G", "B", "A", "Z")
    pixels = np.concatenate([colour, alpha[..., None], depth[..., None]], -1)
    out = oiio.ImageOutput.create(str(path))
    out.open(str(path), spec)
    out.write_image(np.ascontiguousarray(pixels, np.float32))
    out.close()


def score(folder, command, names):
    import numpy as np

    sky = np.float32([0.5, 0.7, 1])
    print("over black / white; over a sky of alpha 0, of alpha 1")
    for name in names:
        references = [
            _rgba(_channels(folder / f"{name}_{k}.exr")) for k in ("ref", "ref2")
        ]
        channels = _channels(folder / f"{name}_pin.exr")
        sharp = _rgba(channels)
        depth = next(v for n, v in channels.items() if n.endswith(".Z"))
        focus = FOCUS.get(name, 8)
        row = [f"{name:12}"]
        for choice in CHOICES:
            made = _filtered(command, folder / f"{name}_pin.exr", focus, choice)
            over = [
                _tpsnr(_over(made, b), [_over(r, b) for r in references])
                for b in (0, 1)
            ]
            row.append(f"{choice} {over[0]:.2f} / {over[1]:.2f}")
        for alpha in (sharp[..., 3], np.ones_like(depth)):
            _write(folder / "sky.exr", _over(sharp, sky), alpha, depth)
            made = _filtered(command, folder / "sky.exr", focus, CHOICES[-1])
            row.append(
                f"{_tpsnr(made[..., :3], [_over(r, sky) for r in references]):.2f}"
            )
        print(" | ".join(row), flush=True)


def main(arguments):
    what, folder, *rest = arguments[1:]
    if what == "render":
        render(Path(folder).resolve(), rest or SCENES)
    else:
        score(Path(folder), rest[0], rest[1:] or SCENES)


if __name__ == "__main__":
    main(sys.argv)
