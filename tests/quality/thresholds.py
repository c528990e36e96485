#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the core's thresholds are worth: scores where one is off by a factor.

    tests/quality/thresholds.py [NAME...]

Copies the tree, puts in one value at a time, builds the command and prints a row of
docs/notebook/thresholds.md for each: tPSNR in dB against references/, less that of the
values as they are. Some five minutes on two cores. NAME: only these thresholds.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
TREE = BUILD / "thresholds"
REFERENCES = ROOT / "tests/quality/references"
SCENES = "foliage macro ortho plane portrait posts".split()

#: File, threshold, a lesser and a greater value, pictures that it may change: of one
#: view, previews, views.
THRESHOLDS = """
surfaces/border.c LARGEST_STEP 0.5f 2 one
surfaces/split.c EDGE_GAP_PX 0.05f 0.2f one
surfaces/split.c PLANE_TOLERANCE 0.15f 0.6f one
surfaces/split.c ALIKE 0.01f 0.04f one
surfaces/split.c THIN_ALIKE 0.15f 0.6f one
surfaces/split.c TEXTURE 0.175f 0.7f one
surfaces/split.c UNSURE 0.16f 0.6f one
surfaces/hidden.c BRIGHTEST 1.1f 3 one
surfaces/hidden.c FLAT_PX 2 8 one
surfaces/hidden.c BLURRED_PX 4 16 one
surfaces/bright_areas.c HIGHLIGHT_LUMINANCE 1 4 one
surfaces/bright_areas.c HIGHLIGHT_OVER_AREA 4 16 one
surfaces/bright_areas.c HIGHLIGHT_RADIUS_PX 0.5f 2 one
surfaces/bright_areas.c LARGE_SHARE 0.1667f 0.6667f one
surfaces/bright_areas.c LARGE_LUMINANCE 0.125f 0.5f one
compose/highlights_add.c NEARER_PX 0.3f 1.2f one,views
compose/highlights_add.c JOIN_PX 0.5f 2 one,views
compose/rims.c WHOLE 0.4f 1 one,views
compose/smooth.c MOST_PX 0.75f 3 one
compose/smooth.c MOST_RANGE_PX 0.25f 1.5f one
compose/smooth.c MOST_BEFORE_PX 0.075f 0.3f one
surfaces/split_fringe.c FRINGE_RATIO 1.5f 4 one
surfaces/split_fringe.c SAME_SURFACE_PX 0.15f 0.6f one
compose/gaps.c MOST 0.8f 0.97f one
compose/gaps.c LEAST 0.5f 0.85f one
compose/gaps.c ENOUGH 0.125f 0.5f one
methods/views/views_lights.c FREE_DEPTH_PX 0.8f 3.2f views
methods/views/views_lights.c SAME_PX 0.125f 0.5f views
methods/views/views_lights.c LIT 0.1f 0.4f views
methods/views/views_cell.c ESTIMATE_WEIGHT 0.05f 0.2f views
methods/views/views_place.c LEAST_COUNT 0.125f 0.5f views
methods/layered/layered_preview.c LEAST_NEAR_PX 0.5f 2 preview
"""


def run(*command):
    done = subprocess.run(
        list(map(str, command)), capture_output=True, text=True, check=False
    )
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr or done.stdout}")
    return done.stdout


def pictures(kinds):
    """(name, scene, arguments of filter) of the pictures of these kinds."""
    for scene in SCENES:
        pinhole = REFERENCES / f"{scene}_pinhole.exr"
        if "one" in kinds:
            yield scene, scene, [pinhole]
        if "preview" in kinds:
            yield f"{scene}-preview", scene, [pinhole, "--quality", "preview"]
        views = sorted(REFERENCES.glob(f"{scene}_view*.exr"))
        if "views" in kinds and views:
            yield f"{scene}-views", scene, views


def scores(kinds):
    """tPSNR of the pictures, dB."""
    command, out, found = TREE / "build/cli/rackfocus", TREE / "out.exr", {}
    run("ninja", "-C", TREE / "build", "cli/rackfocus")
    for name, scene, arguments in pictures(kinds):
        run(command, "filter", *arguments, "-o", out, "--type", "float", "-q")
        text = run(command, "compare", out, REFERENCES / f"{scene}_reference.exr")
        found[name] = float(re.search(r"tPSNR\s+([\d.]+)", text).group(1))
    return found


def changes(now, before):
    rows = [
        f"{name} {score - before[name]:+.2f}"
        for name, score in now.items()
        if abs(score - before[name]) >= 0.005
    ]
    return ", ".join(rows) or "0"


def main():
    shutil.rmtree(TREE, ignore_errors=True)
    for name in run("git", "-C", ROOT, "ls-files").splitlines():
        if (ROOT / name).is_file() and not name.endswith(".exr"):
            (TREE / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, TREE / name)
    off = ("-Dpython=disabled", "-Dview=disabled")
    run("meson", "setup", TREE / "build", TREE, "--buildtype", "release", *off)
    before = scores("one preview views".split())
    print(", ".join(f"{name} {score:.2f}" for name, score in before.items()))
    for line in THRESHOLDS.split("\n")[1:-1]:
        name, threshold, *values, kinds = line.split()
        if sys.argv[1:] and threshold not in sys.argv[1:]:
            continue
        path = TREE / "core" / name
        text = path.read_text()
        (found,) = re.finditer(rf"\b{threshold} = ([^,;]+)(?=[,;])", text)
        row = [f"`{path.name}`", threshold, found.group(1)]
        for value in values:
            path.write_text(text[: found.start(1)] + value + text[found.end(1) :])
            row += [value, changes(scores(kinds.split(",")), before)]
        path.write_text(text)
        print("|", " | ".join(row).replace("f |", " |"), "|", flush=True)


if __name__ == "__main__":
    main()
