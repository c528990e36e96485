# SPDX-License-Identifier: Apache-2.0
"""Scores beside lamps: a thousandth of a lamp's light is white, and decides the rest."""

import numpy
import OpenImageIO


def display(path):
    """R, G and B of a picture as compared: clipped, gamma 2.2.

    Straight from the file: an ImageBuf may show what a file of that name held before, if
    both were written within a second.
    """
    file = OpenImageIO.ImageInput.open(str(path))
    assert file, OpenImageIO.geterror()
    pixels = file.read_image(format="float")[..., :3]
    file.close()
    return numpy.clip(pixels, 0, 1) ** (1 / 2.2)


def grow(mask, n):
    """The pixels within n steps of those of the mask."""
    for _ in range(n):
        wide = numpy.pad(mask, 1)
        mask = wide[1:-1, 1:-1] | wide[:-2, 1:-1] | wide[2:, 1:-1]
        mask |= wide[1:-1, :-2] | wide[1:-1, 2:]
    return mask


def score(picture, reference):
    """tPSNR, dB, of files, without the pixels within 3 px of the reference's white."""
    wanted = display(reference)
    rest = ~grow(wanted.max(axis=-1) >= 1, 3)
    error = ((display(picture) - wanted) ** 2).mean(axis=-1)
    return -10 * numpy.log10(error[rest].mean())
