#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Frustum shift against look-at: the picture and the figures of
docs/notebook/methods.md.

    RACKFOCUS=build/cli/rackfocus tests/methods/camera_moves.py

Renders tests/povray/scenes/plane_in_focus.pov with an aperture of 4 as a pinhole, by
POV-Ray's own focal blur (64 samples), and as the mean of 64 views with both moves of
the camera. Prints how far each is from the pinhole on the plane in focus (root mean
square, gamma 2.2), in the middle of the picture and in its corner. Writes
docs/images/camera_moves.png: the corner, three times enlarged.
"""

import os
import pathlib
import re
import subprocess
import tempfile

import numpy
import OpenImageIO

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "tests" / "povray" / "scenes" / "plane_in_focus.pov"
OUT = ROOT / "docs" / "images" / "camera_moves.png"
SIZE = ["+W640", "+H480"]
AREAS = {
    "middle": (slice(200, 280), slice(280, 340)),
    "corner": (slice(70, 150), slice(110, 190)),
}
CROP = (slice(60, 190), slice(80, 260))
SCALE = 3


def read(path):
    picture = OpenImageIO.ImageBuf(str(path))
    light = picture.get_pixels(OpenImageIO.FLOAT)[..., :3]
    return numpy.clip(light, 0, 1) ** (1 / 2.2)


def povray(folder, text, name, *options):
    (folder / f"{name}.pov").write_text(text)
    out = folder / f"{name}.exr"
    subprocess.run(
        ["povray", f"+I{name}.pov", f"+O{out}", "+FE", "-D", *SIZE, *options],
        cwd=folder, check=True, capture_output=True,
    )  # fmt: skip
    return read(out)


def average(folder, move):
    out = folder / f"{move}.exr"
    subprocess.run(
        [os.path.abspath(os.environ["RACKFOCUS"]), "povray", "lens.pov", "-q",
         "--method", "accumulate", "--views", "64", "--camera-move", move, "-o", out,
         "--", *SIZE],
        cwd=folder, check=True,
    )  # fmt: skip
    return read(out)


def draw(pictures):
    """The corners side by side."""
    crops = [
        numpy.kron(picture[CROP], numpy.ones((SCALE, SCALE, 1)))
        for picture in pictures.values()
    ]
    height, width = crops[0].shape[:2]
    sheet = OpenImageIO.ImageBuf(
        OpenImageIO.ImageSpec(len(crops) * (width + 6) - 6, height, 3, "uint8")
    )
    OpenImageIO.ImageBufAlgo.fill(sheet, (0.1, 0.1, 0.1))
    for i, crop in enumerate(crops):
        x = i * (width + 6)
        part = OpenImageIO.ImageBuf(
            OpenImageIO.ImageSpec(width, height, 3, OpenImageIO.FLOAT)
        )
        part.set_pixels(OpenImageIO.ROI.All, crop.astype(numpy.float32))
        OpenImageIO.ImageBufAlgo.paste(sheet, x, 0, 0, 0, part)
    sheet.write(str(OUT))


def main():
    text = SCENE.read_text().replace("aperture 2 ", "aperture 4 ")
    pinhole = re.sub(r"aperture 4 [^}]*", "", text)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        pictures = {
            "pinhole": povray(folder, pinhole, "pinhole", "+A0.1", "+AM1", "+R2", "-J"),
            "POV-Ray, 64 samples": povray(folder, text, "lens"),
            "64 views, shift": average(folder, "shift"),
            "64 views, look-at": average(folder, "look-at"),
        }
    for label, picture in pictures.items():
        errors = [
            numpy.sqrt(((picture[area] - pictures["pinhole"][area]) ** 2).mean())
            for area in AREAS.values()
        ]
        print(
            f"{label:24}", *(f"{n} {e:.4f}" for n, e in zip(AREAS, errors, strict=True))
        )
    draw(pictures)


if __name__ == "__main__":
    main()
