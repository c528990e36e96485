# SPDX-License-Identifier: Apache-2.0
"""What the tests of the command share: running it, and small scenes."""

import pathlib
import sys

import numpy
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import plainexr  # noqa: E402


@pytest.fixture
def scene(tmp_path):
    """Makes passes.exr: stripes, a near disc before a far wall."""

    def make(name="passes.exr", size=(48, 32), attributes=None, change=None, **options):
        width, height = size
        y, x = numpy.mgrid[0:height, 0:width].astype(numpy.float32)
        near = (x - width / 2) ** 2 + (y - height / 2) ** 2 < (height / 4) ** 2
        stripes = ((x // 3 + y // 5) % 2).astype(numpy.float32)
        channels = {
            "R": numpy.where(near, 0.8, 0.2 + 0.5 * stripes).astype(numpy.float32),
            "G": numpy.where(near, 0.4, 0.6 * stripes).astype(numpy.float32),
            "B": numpy.where(near, 0.1, 0.9 - 0.5 * stripes).astype(numpy.float32),
            "Z": numpy.where(near, 3, 12).astype(numpy.float32),
        }
        if change:
            change(channels)
        return plainexr.write(tmp_path / name, channels, attributes, **options)

    return make
