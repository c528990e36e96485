#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Renders POV-Ray's own focal blur of three shipped scenes with many samples.

    tests/povray/make_references.py [NAME...]

`blur_samples n, n` with variance 0 keeps POV-Ray from stopping early, which would drop
small highlights. The pictures are half floats, as POV-Ray writes them.
"""

import pathlib
import subprocess
import sys
import tempfile
import time

#: Where focalblur.pov's camera stands, and which way it looks.
CAMERA, AHEAD = (50, 10, 30), (-50 / 3400**0.5, 0, -30 / 3400**0.5)

EXAMPLES = pathlib.Path("/usr/share/doc/povray/examples")
REFERENCES = pathlib.Path(__file__).parents[1] / "quality" / "references" / "povray"


def focused_at(distance):
    """focalblur.pov, small, with its focus elsewhere."""
    point = (c + distance * a for c, a in zip(CAMERA, AHEAD, strict=True))
    return (
        "camera/focalblur.pov",
        (320, 240),
        [
            ("blur_samples 120", "blur_samples 300, 300"),
            (
                "focal_point <5,10,5>",
                "focal_point <{:.5f},{:.5f},{:.5f}>".format(*point),
            ),
        ],
    )


#: scene, size, what to replace in it
SCENES = {
    "focalblur": (
        "camera/focalblur.pov",
        (640, 480),
        [("blur_samples 120", "blur_samples 600, 600")],
    ),
    "chess2": (
        "advanced/chess2.pov",
        (480, 360),
        [
            ("blur_samples 37", "blur_samples 300, 300"),
            ("confidence 0.975 ", "confidence 0.9999 "),
            ("variance 1/255 ", "variance 0 "),
        ],
    ),
    "shadows": (
        "lights/shadows.pov",
        (400, 300),
        [
            (
                "look_at <0, 0, 0>",
                "look_at <0, 0, 0> aperture 16 focal_point <0, 3, -5> "
                "blur_samples 300, 300 variance 0 confidence 0.9999",
            )
        ],
    ),
    "focalblur_focus_40": focused_at(40),
    "focalblur_focus_46": focused_at(46),
    "focalblur_focus_51": focused_at(51.449),
    "focalblur_focus_58": focused_at(58),
}


def render(name):
    scene, (width, height), changes = SCENES[name]
    text = (EXAMPLES / scene).read_text(errors="surrogateescape")
    for old, new in changes:
        assert old in text, f"{scene} has no {old!r}"
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / f"{name}.pov"
        copy.write_text(text, errors="surrogateescape")
        picture = REFERENCES / f"{name}.exr"
        began = time.monotonic()
        subprocess.run(
            ["povray", f"+I{copy}", f"+O{picture}", f"+W{width}", f"+H{height}",
             "+FE", "-D", "-A"],
            cwd=(EXAMPLES / scene).parent, check=True, capture_output=True,
        )  # fmt: skip
        print(f"{name}: {time.monotonic() - began:.0f} s")


if __name__ == "__main__":
    REFERENCES.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[1:] or SCENES:
        render(name)
