#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The table of docs/notebook/methods.md and its contact sheets.

    pip install flip-evaluator OpenEXR
    RACKFOCUS=build/cli/rackfocus tests/methods/tables.py

Prints a line per method: time, tPSNR, SSIM, energy, leak and FLIP on three scenes, as
`rackfocus compare-methods` measures them; FLIP is the mean of flip-evaluator, on
pictures clipped and sRGB encoded, at its standard 67 pixels per degree. Writes
docs/images/methods_SCENE.png.
"""

import json
import os
import pathlib
import subprocess
import tempfile

import flip_evaluator
import numpy
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parents[2]
REFERENCES = ROOT / "tests" / "quality" / "references"
IMAGES = ROOT / "docs" / "images"
SCENES = ("posts", "portrait", "plane")


def encoded(path):
    """Clipped and sRGB encoded, (height, width, 3)."""
    picture = OpenEXR.File(str(path), separate_channels=True).channels()
    light = numpy.stack([picture[c].pixels for c in "RGB"], -1).astype(numpy.float32)
    light = numpy.clip(light, 0, 1)
    return numpy.where(
        light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055
    ).astype(numpy.float32)


def measure(binary, scene, folder):
    """Rows of compare-methods with their FLIP."""
    stem = REFERENCES / scene
    reference = f"{stem}_reference.exr"
    inputs = [f"{stem}_pinhole.exr", *sorted(map(str, stem.parent.glob(
        f"{scene}_view0*.exr")))]  # fmt: skip
    results = pathlib.Path(folder) / scene
    done = subprocess.run(
        [binary, "compare-methods", *inputs, "--reference", reference, "--repeats", "9",
         "--results", results, "--json", "-q"],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    truth = encoded(reference)
    rows = json.loads(done.stdout)
    for row in rows:
        picture = encoded(results / f"{row['name'].replace(' ', '_')}.exr")
        row["flip"] = flip_evaluator.evaluate(truth, picture, "LDR")[1]
    subprocess.run(
        [binary, "compare-methods", *inputs, "--reference", reference, "--repeats", "1",
         "-q", "--blend", "coc", "--sheet", IMAGES / f"methods_{scene}.png"],
        check=True, capture_output=True,
    )  # fmt: skip
    return {row["name"]: row for row in rows}


def cells(row):
    if row is None:
        return "| - " * 6
    time = f"{1000 * row['time_s']:.1f}" if "time_s" in row else "-"
    leak = row["leak_percent"]
    return (
        f"| {time} | {row['tpsnr']:.1f} | {row['ssim']:.3f} "
        f"| {100 * (row['energy_ratio'] - 1):+.1f} "
        f"| {'-' if leak is None else f'{leak:.1f}'} | {row['flip']:.3f} "
    )


def main():
    binary = os.path.abspath(os.environ["RACKFOCUS"])
    with tempfile.TemporaryDirectory() as folder:
        tables = [measure(binary, scene, folder) for scene in SCENES]
    head = "| ms | dB | SSIM | energy % | leak % | FLIP "
    print("| method", *(f"| {s}" + " |" * 5 + " " for s in SCENES), "|", sep=" ")
    print("| --- " + "| --: " * 6 * len(SCENES) + "|")
    print("| " + head * len(SCENES) + "|")
    names = list(dict.fromkeys(name for table in tables for name in table))
    for name in names:
        print(f"| {name} " + "".join(cells(t.get(name)) for t in tables) + "|")


if __name__ == "__main__":
    main()
