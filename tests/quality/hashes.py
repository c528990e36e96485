#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Hashes of the pixels that a command makes of all scenes: does a change keep the bits?

    tests/quality/hashes.py OLD/build/cli/rackfocus NEW/build/cli/rackfocus

Prints one line per picture, "same" or "DIFFERENT" behind it, and fails where one
differs. With one command it prints the hashes alone. All methods on the scenes of
references/, in each quality, several views, deep files, windows, lens looks; where POV-Ray is
installed also its example scenes.
"""

import argparse
import hashlib
import pathlib
import subprocess
import sys
import tempfile

import OpenImageIO as oiio

TESTS = pathlib.Path(__file__).resolve().parents[1]
REFERENCES = TESTS / "quality/references"
PREVIEWS = "scatter box lowres mipmap offset mipmap-offset recursive-offset".split()
LOOKS = {
    "cat's eyes": {"cat-eye": 0.6, "swirl": 0.3},
    "doors": {"barn-left": 1, "barn-top": 1.2},
    "spherical": {"spherical": 4, "lateral-chroma": 0.01},
    "axial chroma": {"axial-chroma": 2},
    "tilt": {"tilt-x": 1, "tilt-y": 2.5},
    "split diopter": {"split-diopter": 4, "split-angle": 20},
    "image": {"aperture-image": REFERENCES / "looks/aperture.exr"},
}
POVRAY_EXAMPLES = pathlib.Path("/usr/share/doc/povray/examples")


def cases():
    """(name, arguments of filter) of every picture."""
    for pinhole in sorted(REFERENCES.glob("*_pinhole.exr")):
        name = pinhole.name.removesuffix("_pinhole.exr")
        for method in ["layered", *PREVIEWS]:
            yield f"{name} {method}", [pinhole, "--method", method]
        for quality in ("normal", "preview"):
            yield f"{name} {quality}", [pinhole, "--quality", quality]
        for option in ("split-edges", "fill-hidden", "exact-highlights"):
            yield f"{name} no {option}", [pinhole, f"--{option}", "0"]
        yield f"{name} one cell", [pinhole, "--sub-apertures", "1"]
        for blend in ("region", "slices"):
            rest = ["--method", "box", "--blend", blend, "--leak-control", "product"]
            yield f"{name} box {blend}", [pinhole, *rest]
    for look, values in LOOKS.items():
        options = [f"--{key}={value}" for key, value in values.items()]
        yield f"looks {look}", [REFERENCES / "looks/pinhole.exr", *options]
    for name in ("posts", "portrait"):
        views = sorted(REFERENCES.glob(f"{name}_view*.exr"))
        for n in (2, len(views)):
            yield f"{name} {n} views", views[:n]
        yield f"{name} accumulate", ["accumulate", *views]
    for deep in sorted((TESTS / "deep/files").glob("deep-*.exr")):
        lens = ["--f-stop", "0.5", "--focus-distance", "3"]
        yield f"{deep.stem}", [deep, *lens]
    for name, bound in (("posts", 126), ("macro", 121)):
        yield f"{name} windows", [
            *(REFERENCES / f"{name}_pinhole.exr", "--max-memory", bound)
        ]


def povray_cases(command, folder):
    """The same of passes that POV-Ray renders."""
    for scene in ("camera/focalblur.pov", "advanced/chess2.pov"):
        found = sorted(POVRAY_EXAMPLES.glob(f"**/{scene}"))
        if not found:
            continue
        keep = folder / found[0].stem
        keep.mkdir()
        rest = ["-o", keep / "out.exr", "--keep", keep, "--", "+W240", "+H180"]
        subprocess.run(
            [command, "povray", found[0], *rest], capture_output=True, check=True
        )
        passes = keep / "passes.exr"
        for method in ("layered", "scatter"):
            yield f"povray {keep.name} {method}", [passes, "--method", method]


def pixels_hash(path):
    """A hash of all samples of all parts of a file, whatever its header says."""
    picture = oiio.ImageInput.open(str(path))
    digest = hashlib.sha256()
    part = 0
    while picture.seek_subimage(part, 0):
        digest.update(picture.read_image(part, 0, 0, 100, "float").tobytes())
        part += 1
    return digest.hexdigest()[:16]


def make(command, arguments, out):
    """The hash of one picture, or what the command said."""
    verb = "filter"
    if arguments[0] == "accumulate":
        verb, *arguments = arguments
    line = [command, verb, *arguments, "-o", out]
    if verb == "filter":
        line += ["--type", "float"]
    done = subprocess.run(
        [str(word) for word in line], capture_output=True, text=True, check=False
    )
    return pixels_hash(out) if done.returncode == 0 else done.stderr.strip()


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "commands", nargs="+", help="one rackfocus, or an old and a new"
    )
    commands = parser.parse_args().commands
    n_different = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        rows = [*cases(), *povray_cases(commands[-1], folder)]
        for title, arguments in rows:
            hashes = [make(c, arguments, folder / "out.exr") for c in commands]
            differs = len(set(hashes)) > 1
            n_different += differs
            verdict = "" if len(hashes) == 1 else "DIFFERENT" if differs else "same"
            print(f"{title:32} {' '.join(hashes if differs else hashes[:1])} {verdict}")
    print(f"{len(rows)} pictures, {n_different} different")
    sys.exit(n_different != 0)


if __name__ == "__main__":
    main()
