#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The comparison that counts: Cycles' own lens with its denoiser, at equal samples.

    ./dev bench --rivals FOLDER [SCENE ...] [--samples 16 64 256]
    tests/quality/rivals.py RACKFOCUS FOLDER [SCENE ...] [--samples 16 64 256]

Renders what is missing in FOLDER (Blender 3.4 or later as `blender`, or --blender) with
denoising data, and prints Markdown tables: tPSNR in dB, SSIM, FLIP, and seconds of what
the command takes after the render, against references/ of

    own           Cycles' own depth of field, N samples
    own dn        the same denoised by albedo and normals: what people use
    1, 2, 4, 8    so many views of N samples in all, raw / with --denoise
    ss 1, 4, 8    the same of twice the size with a quarter of the samples each
    finish 4, 8   so many views of N/2 samples in all and N/2 samples of the own lens
    finish +1 +8  passes of 64 samples that are there anyway, N of the own lens on top;
                  +ss 8: views of twice the size

Scenes held out, on which nothing is tuned: bar, street and night. Fur, snow, cards,
branches and grass are thin things at all depths.
RACKFOCUS_OIDN names the folder of Open Image Denoise.
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "scenes"))

import numpy as np  # noqa: E402
import OpenImageIO as oiio  # noqa: E402
from collect_references import VEC2, camera_header, round_depth  # noqa: E402

SCENES = ("posts", "portrait", "plane", "macro", "foliage")
SCALE = 2  # of supersampled passes
PARTS = {
    "Combined": "RGB",
    "Depth": "Z",
    "Denoising Albedo": "RGB",
    "Denoising Normal": "XYZ",
    "Denoising Depth": "Z",
}


class Bench:
    """The scenes, rendered once, and what commands make of them."""

    def __init__(self, options):
        self.command = options.command
        self.folder = options.folder.resolve()
        self.blender = options.blender

    def render(self, scene, kind, samples, count=1, more=()):
        """Folder of a pass of so many samples per pixel (and view)."""
        marks = "".join(f"_{str(word).lstrip('-')}" for word in more)
        folder = self.folder / f"{scene}_{kind}{count}_{samples}{marks}"
        if not (folder / "done").exists():
            script = HERE / "scenes/cycles_scenes.py"
            words = [self.blender, "-b", "--factory-startup", "-P", script, "--"]
            words += [scene, folder, "--pass", kind, "--samples", samples]
            words += ["--count", count] if kind == "views" else []
            words += ["--denoising-data", *more]
            subprocess.run([*map(str, words)], check=True, capture_output=True)
            (folder / "done").touch()
        return folder

    def passes(self, scene, samples, count, more=(), scale=1):
        """Files for `filter`: a pinhole, or views of samples in all.

        scale: how many times as large the pictures are, whose pixels have fewer samples.
        """
        kind = "pinhole" if count == 1 else "views"
        larger = ("--supersample", scale) if scale > 1 else ()
        each = samples // (count * scale**2)
        folder = self.render(scene, kind, each, count, (*more, *larger))
        about = json.loads((folder / f"{scene}_{kind}.json").read_text())
        facts = camera_header(about["camera"])
        if "rackfocus:focalLengthPx" in facts:  # of an orthographic one: scene units
            facts["rackfocus:focalLengthPx"] *= scale
        if count == 1:
            return [with_facts(folder / f"{scene}_pinhole.exr", facts)]
        plane = about.get("shear_distance", about["camera"]["focus"])
        facts["rackfocus:shearDistance"] = float(plane)
        return [
            with_facts(
                folder / f"{scene}_view{i:02d}.exr",
                facts | {"rackfocus:lensOffset": tuple(map(float, offset))},
            )
            for i, offset in enumerate(about["view_offsets"])
        ]

    def own(self, scene, samples, more=()):
        """Cycles' own depth of field."""
        return self.render(scene, "dof", samples, 1, more) / f"{scene}_dof.exr"

    def score(self, scene, *words):
        """Figures of what a command makes; without words of the file given."""
        out, seconds = self.folder / "out.exr", 0.0
        if len(words) == 1:
            out = words[0]
        else:
            line = [self.command, *words, "-o", out, "--type", "float", "-q"]
            start = time.monotonic()
            subprocess.run([*map(str, line)], check=True)
            seconds = time.monotonic() - start
        reference = HERE / "references" / f"{scene}_reference.exr"
        line = [self.command, "compare", out, reference, "--json"]
        done = subprocess.run([*map(str, line)], check=True, capture_output=True)
        figures = json.loads(done.stdout) | {"seconds": seconds}
        return figures

    def row(self, scene, samples):
        """All figures of a scene at so many samples."""
        own = self.own(scene, samples)
        figures = {"own": self.score(scene, own)}
        figures["own dn"] = self.score(scene, "finish", own)
        for n in (1, 2, 4, 8):
            views = self.passes(scene, samples, n)
            figures[str(n)] = self.score(scene, "filter", *views)
            figures[f"{n} dn"] = self.score(scene, "filter", *views, "--denoise")
        for n in (1, 4, 8):
            if samples >= n * SCALE**2:
                views = self.passes(scene, samples, n, scale=SCALE)
                options = ("--supersample", SCALE)
                figures[f"ss {n}"] = self.score(scene, "filter", *views, *options)
                options += ("--denoise",)
                figures[f"ss {n} dn"] = self.score(scene, "filter", *views, *options)
        half = self.own(scene, samples // 2)
        for n in (4, 8):
            views = self.passes(scene, samples // 2, n)
            figures[f"finish {n}"] = self.score(scene, "finish", half, *views)
        for n in (1, 8):
            views = self.passes(scene, 64, n)
            figures[f"finish +{n}"] = self.score(scene, "finish", own, *views)
        views = self.passes(scene, 64, 8, scale=SCALE)
        words = ("finish", own, *views, "--supersample", SCALE)
        figures["finish +ss 8"] = self.score(scene, *words)
        return figures


def read_rgb(path):
    """Colour of a file, scene-linear, height x width x 3."""
    source = oiio.ImageInput.open(str(path))
    spec = source.spec()
    names = [name.split(".")[-1] for name in spec.channelnames]
    pixels = source.read_image(0, 0, 0, spec.nchannels, "float")
    pixels = np.array(pixels).reshape(spec.height, spec.width, -1)
    return np.ascontiguousarray(pixels[..., [names.index(c) for c in "RGB"]])


def with_facts(path, facts):
    """A copy of a multilayer render that says what its camera was."""
    out = path.with_name(f"facts_{path.name}")
    if out.exists():
        return out
    source = oiio.ImageInput.open(str(path))
    spec = source.spec()
    pixels = source.read_image(0, 0, 0, spec.nchannels, "float")
    pixels = np.array(pixels).reshape(spec.height, spec.width, -1)
    at = {name.split(".", 1)[1]: i for i, name in enumerate(spec.channelnames)}
    names, planes = [], []
    for part, channels in PARTS.items():
        for channel in channels:
            plane = pixels[..., at[f"{part}.{channel}"]]
            names.append(
                channel if part in ("Combined", "Depth") else f"{part}.{channel}"
            )
            planes.append(round_depth(plane) if part == "Depth" else plane)
    written = oiio.ImageSpec(spec.width, spec.height, len(names), "float")
    written.channelnames = tuple(names)
    for name, value in facts.items():
        if isinstance(value, tuple):
            written.attribute(name, VEC2, value)
        else:
            written.attribute(name, value)
    picture = oiio.ImageOutput.create(str(out))
    samples = np.ascontiguousarray(np.dstack(planes), np.float32)
    if not picture.open(str(out), written) or not picture.write_image(samples):
        sys.exit(f"{out}: {picture.geterror()}")
    picture.close()
    return out


MEASURES = {"tpsnr": "tPSNR, dB", "ssim": "SSIM", "flip": "FLIP", "seconds": "s"}


def print_table(rows, samples, measure):
    """One measure of all at one number of samples, and against the denoised lens."""
    names = list(next(iter(rows.values())))
    print(f"\n| {samples} samples, {MEASURES[measure]} | {' | '.join(names)} |")
    print("| --- |" + " --- |" * len(names))
    for scene, row in rows.items():
        print(f"| {scene} | {' | '.join(f'{row[n][measure]:.4g}' for n in names)} |")
    above = [
        [row[n][measure] - row["own dn"][measure] for n in names]
        for row in rows.values()
    ]
    for title, figures in (
        ("least above own dn", np.min(above, 0)),
        ("mean above own dn", np.mean(above, 0)),
    ):
        print(f"| {title} | {' | '.join(f'{v:+.3g}' for v in figures)} |", flush=True)


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", help="the built rackfocus")
    parser.add_argument("folder", type=Path, help="where renders are kept")
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--samples", type=int, nargs="+", default=(16, 64, 256))
    parser.add_argument("--blender", default="blender")
    options = parser.parse_args()
    bench = Bench(options)
    for samples in options.samples:
        rows = {scene: bench.row(scene, samples) for scene in options.scenes}
        for measure in MEASURES:
            print_table(rows, samples, measure)


if __name__ == "__main__":
    main()
