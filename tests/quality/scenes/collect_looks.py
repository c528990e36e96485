# SPDX-License-Identifier: Apache-2.0
"""Turns a folder of renders by looks_scene.py into the committed references.

    collect_looks.py WORKDIR OUTDIR

Writes pinhole.exr with the camera facts, view00.exr and so on likewise, aperture.exr,
LOOK.exr (the mean over the seeds) and manifest.json with the parameters and the noise of
each look. Colours keep 7 significant bits (an error of 0.004 of a value at the most,
60 dB in all), so that a picture stays below 300 kB. Needs OpenImageIO and numpy
(Debian: python3-openimageio).
"""

import argparse
import ast
import json
from pathlib import Path

import numpy as np
from collect_references import camera_header, read_exr, round_depth, tpsnr, write_exr

SCENE = Path(__file__).with_name("looks_scene.py")


def constants():
    """CAMERA's arguments and LOOKS of looks_scene.py, which needs Blender to import."""
    found = {}
    for node in ast.parse(SCENE.read_text()).body:
        if isinstance(node, ast.Assign) and node.targets[0].id in ("LOOKS", "CAMERA"):
            value = node.value
            if isinstance(value, ast.Call):
                value = ast.Tuple(value.args, ast.Load())
            found[node.targets[0].id] = ast.literal_eval(value)
    return found["CAMERA"], found["LOOKS"]


def header(camera):
    """The camera's facts, as cycles_scenes.Camera has them."""
    width, _, lens_mm, fstop, focus = camera
    facts = {
        "focus": focus,
        "lens_radius": lens_mm * 1e-3 / (2 * fstop),
        "focal_px": width * lens_mm / 36,
        "blades": 0,
        "rotation_deg": 0.0,
        "ratio": 1.0,
        "ortho_scale": 0.0,
    }
    return {**camera_header(facts), "rackfocus:focalLength": float(lens_mm)}


def round_colour(colour):
    """Half floats of 7 significant bits."""
    bits = np.ascontiguousarray(colour, np.float16).view(np.uint16).astype(np.uint32)
    return ((bits + 8) & 0xFFF0).astype(np.uint16).view(np.float16).astype(np.float32)


def collect_look(work, out, name):
    """One look; returns its noise floor in dB, or None where only one seed is there."""
    paths = sorted(work.glob(f"look_{name}_seed*.exr"))
    if not paths:
        return None
    gain = np.loadtxt(work / f"look_{name}.gain")
    seeds = [read_exr(path)[..., :3] * gain for path in paths]
    write_exr(out / f"{name}.exr", round_colour(np.mean(seeds, 0)), "piz")
    if len(seeds) < 2:
        return None
    pairs = [tpsnr(a, b) for i, a in enumerate(seeds) for b in seeds[:i]]
    return round(float(np.mean(pairs) + 10 * np.log10(2 * len(seeds))), 2)


def collect_pinhole(rendered, out, facts):
    """Colour and depth with the camera's facts."""
    pixels = read_exr(rendered)
    pixels[..., :3] = round_colour(pixels[..., :3])
    pixels[..., 3] = round_depth(pixels[..., 3])
    write_exr(out, pixels, "zip", facts)


def collect_views(work, out, facts, focus):
    """The views, each with its place on the lens."""
    for index, offset in enumerate(np.loadtxt(work / "look_views.offsets")):
        facts["rackfocus:lensOffset"] = tuple(map(float, offset))
        facts["rackfocus:shearDistance"] = float(focus)
        name = f"view{index:02d}.exr"
        collect_pinhole(work / f"look_{name}", out / name, facts)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workdir", type=Path)
    parser.add_argument("outdir", type=Path)
    options = parser.parse_args()
    work, out = options.workdir, options.outdir
    camera, looks = constants()
    collect_pinhole(work / "look_pinhole.exr", out / "pinhole.exr", header(camera))
    collect_views(work, out, header(camera), camera[-1])
    write_exr(out / "aperture.exr", read_exr(work / "aperture.exr")[..., :3], "zip")
    manifest = {}
    for name, look in looks.items():
        floor = collect_look(work, out, name)
        manifest[name] = {"parameters": look, "noise_floor_db": floor}
        print(name, floor)
    (out / "manifest.json").write_text(json.dumps(manifest, indent=1) + "\n")


if __name__ == "__main__":
    main()
