#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Temporal stability as docs/reliability.md has it: the pan of test_pan.py, 33 frames;
flicker and tPSNR of what the command makes of it.

    RACKFOCUS=build/cli/rackfocus tests/deep/measure_pan.py
"""

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import test_pan
from deepscene import Camera, deep_samples, read, reference, tpsnr, write_deep

CAMERA = test_pan.CAMERA = Camera(64, 16, 75, 0.28, 6)
N_FRAMES = 33


def filtered(folder, make, *options):
    for i in range(N_FRAMES):
        make(folder / f"in.{i}.exr", i)
    lens = ["--type", "float", "-q", "--anew", *CAMERA.options(), *options]
    names = [folder / "in.#.exr", "-o", folder / "out.#.exr"]
    subprocess.run([os.environ["RACKFOCUS"], "filter", *names, *lens], check=True)
    return [read(folder / f"out.{i}.exr")[0][..., :3] for i in range(N_FRAMES)]


def main():
    step = CAMERA.focus / CAMERA.focal_px / 8
    scenes = [test_pan.scene(i * step) for i in range(N_FRAMES)]
    lens = [reference(CAMERA, one, 256, 8)[..., :3] for one in scenes]
    pinholes = [test_pan.pinhole(one) for one in scenes]

    def show(name, frames):
        ratio = test_pan.flicker(frames) / test_pan.flicker(lens)
        score = tpsnr(np.stack(frames), np.stack(lens))
        print(f"| {name} | {ratio:.1f} | {score:.1f} dB |", flush=True)

    def flat(path, i):
        test_pan.write(path, pinholes[i])

    show("pinhole, not filtered", [one[..., :3] for one in pinholes])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        show("flat frames", filtered(folder, flat))
        off = ["--fill-hidden", "off"]
        show("flat frames, hidden surfaces not filled", filtered(folder, flat, *off))
        off = ["--split-edges", "off"]
        show("flat frames, edges not split", filtered(folder, flat, *off))
        for n in (8, 16, 32):

            def deep(path, i, n=n):
                write_deep(path, CAMERA, deep_samples(CAMERA, scenes[i], n))

            show(f"deep frames, {n} x {n} samples a pixel", filtered(folder, deep))


if __name__ == "__main__":
    main()
