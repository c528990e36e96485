#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How fast the mean of views comes to POV-Ray's own lens: the table of
docs/notebook/methods.md.

    RACKFOCUS=build/cli/rackfocus tests/methods/convergence.py [SCENE...] [-- OPTIONS]

Prints a row per scene and setting: tPSNR for N = 8, 16, 32, 64, 128 against the stored
references (tests/povray/make_references.py). What follows -- goes to the command
instead of the settings listed here.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

EXAMPLES = pathlib.Path("/usr/share/doc/povray/examples")
REFERENCES = pathlib.Path(__file__).parents[1] / "quality" / "references" / "povray"
NUMBERS = (8, 16, 32, 64, 128)
#: scene, its options, size
SCENES = {
    "focalblur": ("camera/focalblur", [], (640, 480)),
    "shadows": (
        "lights/shadows",
        ["--aperture", "16", "--focal-point=0,3,-5"],
        (400, 300),
    ),
}
SETTINGS = (["--subpixel"], ["--subpixel", "--camera-move", "look-at"], [])


def score(binary, name, n, settings, out):
    """tPSNR of the mean of n views, and the seconds it took."""
    scene, options, size = SCENES[name]
    path = EXAMPLES / f"{scene}.pov"
    began = time.monotonic()
    subprocess.run(
        [binary, "povray", path.name, "--method", "accumulate", "--views", str(n),
         "-q", "-o", out, *options, *settings, "--", f"+W{size[0]}", f"+H{size[1]}"],
        cwd=path.parent, check=True,
    )  # fmt: skip
    seconds = time.monotonic() - began
    text = subprocess.run(
        [binary, "compare", out, REFERENCES / f"{name}.exr", "--json"],
        check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    return json.loads(text)["tpsnr"], seconds


def main():
    arguments, extra = sys.argv[1:], None
    if "--" in arguments:
        at = arguments.index("--")
        arguments, extra = arguments[:at], arguments[at + 1 :]
    binary = os.path.abspath(os.environ["RACKFOCUS"])
    print("| scene | settings |", *(f"N = {n} |" for n in NUMBERS))
    print("| --- | --- |", "--: |" * len(NUMBERS))
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.exr"
        for name in arguments or SCENES:
            for settings in SETTINGS if extra is None else (extra,):
                print(f"| {name} | `{' '.join(settings)}` |", end="", flush=True)
                for n in NUMBERS:
                    tpsnr, seconds = score(binary, name, n, settings, out)
                    print(f" {tpsnr:.1f} |", end="", flush=True)
                    print(f" ({n}: {seconds:.0f} s)", end="", file=sys.stderr)
                print(flush=True)


if __name__ == "__main__":
    main()
