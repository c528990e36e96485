#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The table of docs/notebook/methods.md and its contact sheets.

    pip install pillow
    RACKFOCUS=build/cli/rackfocus tests/methods/tables.py

Prints a line per method: time, tPSNR, SSIM, energy, leak and FLIP on three scenes, as
`rackfocus compare-methods` measures them. Writes docs/images/methods_SCENE.jpg.
"""

import json
import os
import pathlib
import subprocess
import tempfile

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
REFERENCES = ROOT / "tests" / "quality" / "references"
IMAGES = ROOT / "docs" / "images"
SCENES = ("posts", "portrait", "plane")


def make_sheet(binary, inputs, reference, path):
    """A sheet of one blend at half its size, as JPEG."""
    with tempfile.TemporaryDirectory() as folder:
        whole = pathlib.Path(folder) / "sheet.png"
        subprocess.run(
            [binary, "compare-methods", *inputs, "--reference", reference,
             "--repeats", "9", "-q", "--blend", "coc", "--sheet", whole],
            check=True, capture_output=True,
        )  # fmt: skip
        with Image.open(whole) as sheet:
            size = sheet.width // 2, sheet.height // 2
            sheet.resize(size, Image.LANCZOS).save(path, quality=88, optimize=True)


def measure(binary, scene):
    """Rows of compare-methods by their names."""
    stem = REFERENCES / scene
    reference = f"{stem}_reference.exr"
    inputs = [f"{stem}_pinhole.exr", *sorted(map(str, stem.parent.glob(
        f"{scene}_view0*.exr")))]  # fmt: skip
    done = subprocess.run(
        [binary, "compare-methods", *inputs, "--reference", reference, "--repeats", "9",
         "--json", "-q"],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    make_sheet(binary, inputs, reference, IMAGES / f"methods_{scene}.jpg")
    return {row["name"]: row for row in json.loads(done.stdout)}


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
    tables = [measure(binary, scene) for scene in SCENES]
    head = "| ms | dB | SSIM | energy % | leak % | FLIP "
    print("| method", *(f"| {s}" + " |" * 5 + " " for s in SCENES), "|", sep=" ")
    print("| --- " + "| --: " * 6 * len(SCENES) + "|")
    print("| " + head * len(SCENES) + "|")
    names = list(dict.fromkeys(name for table in tables for name in table))
    for name in names:
        print(f"| {name} " + "".join(cells(t.get(name)) for t in tables) + "|")


if __name__ == "__main__":
    main()
