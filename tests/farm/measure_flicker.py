#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Flicker of a shot: a camera that passes thin things, with lamps behind them.

    tests/farm/measure_flicker.py build/cli/rackfocus FOLDER [--frames 24] [--samples 300]

Renders scenes/passing.pov with POV-Ray (passes, eight views, its own focal blur as the
reference, twice where --noise asks for it) into FOLDER, where what is there is not
rendered again; filters it frame by frame, with --temporal 1 to 3, and with views. For
each it prints

  tPSNR     mean and least of the frames, dB
  flicker   what changes from frame to frame and not in the reference: the root mean
            square of (out[t + 1] - out[t]) - (ref[t + 1] - ref[t]), display values
  quiet     the same, but for 3 px around lamps and 16 px at the border, where the lens
            sees what no frame shows
  jitter    of out[t + 1] - 2 out[t] + out[t - 1], and of the references
"""

import argparse
import pathlib
import subprocess
import sys

import numpy
import OpenImageIO

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "quality"))
from beside_lamps import display, grow  # noqa: E402

SCENE = HERE / "scenes/passing.pov"
BORDER = 16


def rms(values):
    return float(numpy.sqrt(numpy.mean(numpy.square(values))))


def render(options, name, *arguments):
    """Frames of the scene; not those that are there."""
    folder = options.folder
    missing = [
        i
        for i in range(1, options.frames + 1)
        if not (folder / f"{name}.{i:04d}.exr").exists()
    ]
    for i in missing:
        subprocess.run(
            [options.rackfocus, "povray", SCENE.resolve(), "-q", "--supersample", "1"]
            + ["-o", f"{name}.####.exr", "--frames", f"{i}-{i}", *arguments]
            + ["--", "+W320", "+H180", "+KFI1", "+KFF24"],
            cwd=folder,
            check=True,
        )


def filter_shot(options, name, inputs, *arguments):
    subprocess.run(
        [options.rackfocus, "filter", *inputs, "-o", f"{name}.####.exr", "-q"]
        + ["--frames", f"1-{options.frames}", *arguments],
        cwd=options.folder,
        check=True,
    )


def read(options, name):
    paths = [options.folder / f"{name}.{i + 1:04d}.exr" for i in range(options.frames)]
    return numpy.stack([display(path) for path in paths])


def beside_lamps(frames):
    lamps = frames.max(axis=-1) >= 1
    return numpy.stack([grow(a | b, 3) for a, b in zip(lamps[:-1], lamps[1:])])


def score(frames, reference):
    """tPSNR of each frame, dB."""
    error = numpy.square(frames - reference).mean(axis=(1, 2, 3))
    return -10 * numpy.log10(error)


def table_row(name, frames, reference):
    psnr = score(frames, reference)
    flicker = numpy.diff(frames, axis=0) - numpy.diff(reference, axis=0)
    inner = numpy.s_[:, BORDER:-BORDER, BORDER:-BORDER]
    quiet = flicker[inner][~beside_lamps(reference)[inner]]
    jitter = rms(numpy.diff(frames, 2, axis=0))
    return (
        f"| {name} | {psnr.mean():.2f} | {psnr.min():.2f} | {rms(flicker):.4f} "
        f"| {rms(quiet):.4f} | {jitter:.4f} |"
    )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("rackfocus", type=lambda path: pathlib.Path(path).resolve())
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--samples", type=int, default=300)
    parser.add_argument("--noise", action="store_true")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    OpenImageIO.attribute("threads", 1)
    samples = options.samples
    kept = ["--reference", str(samples), "--reference-output", "reference.####.exr"]
    render(options, "rendered", "--keep", "one", *kept)
    render(options, "eight", "--keep", "views", "--views", "8")
    one = ["one/passes####.exr"]
    views = [f"views/passes####_v{i:02d}.exr" for i in range(8)]
    filter_shot(options, "alone", one)
    filter_shot(options, "temporal1", one, "--temporal", "1")
    filter_shot(options, "temporal2", one, "--temporal", "2")
    filter_shot(options, "temporal3", one, "--temporal", "3")
    filter_shot(options, "views2", views, "--temporal", "2")
    reference = read(options, "reference")
    print(f"jitter of the references {rms(numpy.diff(reference, 2, axis=0)):.4f}")
    if options.noise:
        other = ["--reference", str(samples + 10), "--reference-output"]
        render(options, "again", *other, "noise.####.exr")
        print(table_row("the reference again", read(options, "noise"), reference))
    for name in ("alone", "temporal1", "temporal2", "temporal3", "eight", "views2"):
        print(table_row(name, read(options, name), reference))
    gain = score(read(options, "temporal3"), reference)
    gain -= score(read(options, "alone"), reference)
    print(f"--temporal 3 gains {gain.min():.2f} dB at least, of each frame")


if __name__ == "__main__":
    main()
