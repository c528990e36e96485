# SPDX-License-Identifier: Apache-2.0
"""Scores against POV-Ray's own focal blur (tests/quality/references/povray)."""

import re

import numpy
import OpenImageIO as oiio
import pytest
from conftest import EXAMPLES, HERE

REFERENCES = HERE.parent / "quality" / "references" / "povray"
SHADOWS = ["--aperture", "16", "--focal-point=0,3,-5"]


def at_size(reference, size, path):
    """The reference, or one of a half or a third of its size, in `path`."""
    picture = oiio.ImageBuf(str(reference))
    n = picture.spec().width // size[0]
    if n == 1:
        return reference
    pixels = picture.get_pixels(oiio.FLOAT)[..., :3]
    means = pixels.reshape(size[1], n, size[0], n, 3).mean((1, 3))
    made = oiio.ImageBuf(oiio.ImageSpec(*size, 3, oiio.FLOAT))
    made.set_pixels(oiio.ROI(), numpy.ascontiguousarray(means))
    assert made.write(str(path))
    return path


@pytest.mark.parametrize(
    "scene, options, size, bar_db, gain_db",
    [
        ("camera/focalblur", [], (640, 480), 41, 9),
        ("lights/shadows", SHADOWS, (200, 150), 0, 9),
        ("advanced/chess2", [], (240, 180), 0, 9),
    ],
)
def test_score(rackfocus, tmp_path, scene, options, size, bar_db, gain_db):
    path = EXAMPLES / f"{scene}.pov"
    reference = REFERENCES / f"{path.stem}.exr"
    reference = at_size(reference, size, tmp_path / "reference.exr")

    def score(picture):
        text = rackfocus("compare", picture, reference).stdout
        return float(re.search(r"tPSNR ([0-9.]+) dB", text).group(1))

    out, kept = tmp_path / "out.exr", tmp_path / "kept"
    rackfocus("povray", path.name, "-o", out, "--keep", kept, *options, "--",
              f"+W{size[0]}", f"+H{size[1]}", cwd=path.parent)  # fmt: skip
    ours, pinhole = score(out), score(kept / "passes.exr")
    print(f"{scene}: pinhole {pinhole:.2f} dB, filtered {ours:.2f} dB")
    assert ours >= bar_db and ours >= pinhole + gain_db
