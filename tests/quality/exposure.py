#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What brightness changes: the scenes of rivals.py, darker and brighter.

    tests/quality/exposure.py RACKFOCUS FOLDER [SCENE ...] [--times 1 0.0078125 128]

FOLDER is that of rivals.py, which renders what is missing. Prints a Markdown row for each
scene and factor: tPSNR in dB of what the command makes of light times the factor, divided
by it again; one view and 8 of 64 samples in all, each also with --denoise, and finish of
64 samples on one view. RACKFOCUS_OIDN names the folder of Open Image Denoise.
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from rivals import HERE, SCENES, Bench, read_rgb

SAMPLES = 64
KINDS = ("one", "one dn", "8", "8 dn", "finish")


def is_light(name):
    """Is a channel a colour of the picture, not albedo or normals?"""
    return name.split(".")[-1] in "RGB" and "Denoising" not in name


def brighter(path, factor, out):
    """A copy of a file whose light is multiplied."""
    source = oiio.ImageInput.open(str(path))
    spec = oiio.ImageSpec(source.spec())
    names = spec.channelnames
    pixels = source.read_image(0, 0, 0, spec.nchannels, "float")
    pixels = np.array(pixels).reshape(spec.height, spec.width, -1)
    pixels[..., [i for i, name in enumerate(names) if is_light(name)]] *= factor
    spec.set_format("float")
    spec.channelformats = ()
    made = oiio.ImageOutput.create(str(out))
    assert made.open(str(out), spec) and made.write_image(pixels)
    made.close()
    return out


def tpsnr(made, factor, scene):
    """Of a file, its light divided by the factor."""
    reference = read_rgb(HERE / "references" / f"{scene}_reference.exr")
    shown = [
        np.clip(x, 0, 1) ** (1 / 2.2) for x in (read_rgb(made) / factor, reference)
    ]
    return -10 * np.log10(np.mean((shown[0] - shown[1]) ** 2))


def row(bench, scene, factor):
    """A score for each of KINDS."""
    folder = bench.folder / "exposure"
    folder.mkdir(exist_ok=True)

    def copy(path, name):
        return brighter(path, factor, folder / f"{name}.exr")

    one = [copy(path, "one") for path in bench.passes(scene, SAMPLES, 1)]
    views = bench.passes(scene, SAMPLES, 8)
    eight = [copy(path, f"view{i}") for i, path in enumerate(views)]
    own = copy(bench.own(scene, SAMPLES), "own")
    scores = []
    for words in (
        ["filter", *one],
        ["filter", *one, "--denoise"],
        ["filter", *eight],
        ["filter", *eight, "--denoise"],
        ["finish", own, *one],
    ):
        out = folder / "out.exr"
        line = [bench.command, *words, "-o", out, "--type", "float", "-q"]
        subprocess.run([*map(str, line)], check=True)
        scores.append(tpsnr(out, factor, scene))
    return scores


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", help="the built rackfocus")
    parser.add_argument("folder", type=Path, help="where renders are kept")
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--times", type=float, nargs="+", default=(1, 1 / 128, 128))
    parser.add_argument("--blender", default="blender")
    options = parser.parse_args()
    bench = Bench(options)
    print(f"| scene | times | {' | '.join(KINDS)} |")
    print("| --- | ---" + " | --:" * len(KINDS) + " |")
    for scene in options.scenes:
        for factor in options.times:
            scores = " | ".join(f"{x:.2f}" for x in row(bench, scene, factor))
            print(f"| {scene} | {factor:g} | {scores} |", flush=True)


if __name__ == "__main__":
    main()
