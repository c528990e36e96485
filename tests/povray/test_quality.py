# SPDX-License-Identifier: Apache-2.0
"""Scores against POV-Ray's own focal blur (tests/quality/references/povray)."""

import re

import pytest
from conftest import EXAMPLES, HERE

REFERENCES = HERE.parent / "quality" / "references" / "povray"
SHADOWS = ["--aperture", "16", "--focal-point=0,3,-5"]


@pytest.mark.parametrize(
    "scene, options, size, bar_db, gain_db",
    [
        ("camera/focalblur", [], (640, 480), 41, 9),
        ("lights/shadows", SHADOWS, (400, 300), 0, 9),
        ("advanced/chess2", [], (480, 360), 0, 9),
    ],
)
def test_score(rackfocus, tmp_path, scene, options, size, bar_db, gain_db):
    path = EXAMPLES / f"{scene}.pov"
    reference = REFERENCES / f"{path.stem}.exr"

    def score(picture):
        text = rackfocus("compare", picture, reference).stdout
        return float(re.search(r"tPSNR ([0-9.]+) dB", text).group(1))

    out, kept = tmp_path / "out.exr", tmp_path / "kept"
    rackfocus("povray", path.name, "-o", out, "--keep", kept, *options, "--",
              f"+W{size[0]}", f"+H{size[1]}", cwd=path.parent)  # fmt: skip
    ours, pinhole = score(out), score(kept / "passes.exr")
    print(f"{scene}: pinhole {pinhole:.2f} dB, filtered {ours:.2f} dB")
    assert ours >= bar_db and ours >= pinhole + gain_db
