#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads an EXR file with colour (R G B) and depth (Z), filters it, writes the result.

    filter_file.py IN.exr OUT.exr FOCUS_DISTANCE LENS_RADIUS FOCAL_LENGTH_PX

Needs NumPy and OpenImageIO (Debian: python3-numpy, python3-openimageio).
"""

import sys

import numpy
import OpenImageIO
import rackfocus


def read(name):
    """Colour and depth of a file as float32 arrays, and the file's description."""
    file = OpenImageIO.ImageInput.open(name)
    if not file:
        sys.exit(f"{name}: {OpenImageIO.geterror()}")
    spec = file.spec()
    pixels = file.read_image(OpenImageIO.FLOAT)
    file.close()
    where = {channel: i for i, channel in enumerate(spec.channelnames)}
    missing = [c for c in "RGBZ" if c not in where]
    if missing:
        sys.exit(f"{name}: no channel {' '.join(missing)}")
    colour = pixels[:, :, [where[c] for c in "RGB"]]
    depth = pixels[:, :, where["Z"]]
    return numpy.ascontiguousarray(colour), numpy.ascontiguousarray(depth)


def write(name, colour):
    """Writes an array of height x width x 3 as half floats."""
    height, width, channels = colour.shape
    spec = OpenImageIO.ImageSpec(width, height, channels, OpenImageIO.HALF)
    file = OpenImageIO.ImageOutput.create(name)
    if not file or not file.open(name, spec) or not file.write_image(colour):
        sys.exit(f"{name}: {OpenImageIO.geterror()}")
    file.close()


def main():
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    source, target, focus_distance, lens_radius, focal_length_px = sys.argv[1:]
    colour, depth = read(source)
    try:
        out = rackfocus.apply(
            colour,
            depth,
            focus_distance=float(focus_distance),
            lens_radius=float(lens_radius),
            focal_length_px=float(focal_length_px),
        )
    except rackfocus.Error as error:
        sys.exit(f"{source}: {error.field}: {error.message}")
    write(target, out)


if __name__ == "__main__":
    main()
