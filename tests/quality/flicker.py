#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Flicker of a slow pan: what the grain leaves, against Cycles' own lens denoised.

    tests/quality/flicker.py RACKFOCUS FOLDER [SCENE ...] [--samples 16] [--frames 4]

Renders what is missing in FOLDER (Blender 3.4 or later as `blender`, or --blender):
frames of the scenes of rivals.py, each with seeds of its own, in which a shift of the
camera moves the whole picture by 2 px, blur and all. So motion is compensated exactly,
by these 2 px, and what differs is flicker: the root mean square of
out[t + 1](x) - out[t](x + 2), display values, without 16 px at the border. Columns as
of rivals.py. RACKFOCUS_OIDN names the folder of Open Image Denoise.
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np
import rivals

STEP_PX, BORDER_PX = 2, 16


def make(bench, name, words):
    """Display values of what a command makes."""
    out = bench.folder / f"flicker_{name}.exr"
    line = [bench.command, *words, "-o", out, "--type", "float", "-q"]
    subprocess.run([*map(str, line)], check=True)
    return np.clip(rivals.read_rgb(out), 0, 1) ** (1 / 2.2)


def frame(bench, scene, samples, number):
    """Pictures of one frame, by the names of their columns."""

    def more(n_views):
        return ("--pan", STEP_PX * number, "--seed", 1 + n_views * number)

    def views(n_samples, n):
        return bench.passes(scene, n_samples, n, more(n))

    own = bench.own(scene, samples, more(1))
    half = bench.own(scene, samples // 2, more(1))
    commands = {
        "own dn": ("finish", own),
        "1 dn": ("filter", *views(samples, 1), "--denoise"),
        "8": ("filter", *views(samples, 8)),
        "8 dn": ("filter", *views(samples, 8), "--denoise"),
        "finish 8": ("finish", half, *views(samples // 2, 8)),
        "finish +1": ("finish", own, *views(samples, 1)),
        "finish +8": ("finish", own, *views(samples, 8)),
    }
    return {name: make(bench, scene, words) for name, words in commands.items()}


def flicker(frames):
    """Root mean square of what differs from frame to frame."""
    pairs = zip(frames[:-1], frames[1:])
    moved = [after[:, :-STEP_PX] - before[:, STEP_PX:] for before, after in pairs]
    inner = np.array(moved)[:, BORDER_PX:-BORDER_PX, BORDER_PX:-BORDER_PX]
    return np.sqrt(np.mean(inner**2))


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", help="the built rackfocus")
    parser.add_argument("folder", type=Path, help="where renders are kept")
    parser.add_argument("scenes", nargs="*", default=rivals.SCENES)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--frames", type=int, default=4)
    parser.add_argument("--blender", default="blender")
    options = parser.parse_args()
    bench = rivals.Bench(options)
    for scene in options.scenes:
        made = [frame(bench, scene, options.samples, i) for i in range(options.frames)]
        if scene == options.scenes[0]:
            print(f"| {options.samples} samples | {' | '.join(made[0])} |")
            print("| --- |" + " --- |" * len(made[0]))
        values = [flicker([pictures[name] for pictures in made]) for name in made[0]]
        print(f"| {scene} | {' | '.join(f'{v:.4f}' for v in values)} |", flush=True)


if __name__ == "__main__":
    main()
