# SPDX-License-Identifier: Apache-2.0
"""Measures a refocus at 1920 x 1080 in Blender for docs/notebook/blender.md.

    python3 docs/measure_refocus.py DIST [BLENDER ...]

DIST is the folder that `./dev package` makes; BLENDER: 3.4, 4.2, 4.5, 5.0, newest. Needs what
tests/blender needs. The shortest of ten times, at a high priority where the system allows it, so
that other programs count for little; in the background, and for 3.4 and the newest with a window
too. With a window the composite is timed until Blender has it, and until its window has drawn it.
"""

import json
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/blender"))
import session  # noqa: E402
from conftest import VERSIONS, get_blender  # noqa: E402

SCRIPT = "refocus_speed.py"


def show(version, where, found, *more):
    names = ("whole", "filter", "beside")
    row = [f"{1000 * found[name]:.0f} ms" for name in names if name in found]
    row += [f"{1000 * seconds:.0f} ms" for seconds in more]
    print("|", version, "|", where, "|", " | ".join(row), "|", flush=True)


def speed_in_background(blender, dist):
    """What the script printed; an error with its last lines where it has not."""
    lines = blender.run(SCRIPT, dist, blender.out).splitlines()
    for line in lines:
        if line.startswith("SPEED "):
            return json.loads(line.removeprefix("SPEED "))
    sys.exit("\n".join([*lines[-20:], f"Blender {blender.version} measured nothing"]))


def main():
    dist, *versions = sys.argv[1:]
    columns = "from f-stop to composite | filter | beside it | to the window"
    print(
        f"| Blender | | {columns} | longest pause | of a redraw | longest call of ours |"
    )
    for version in versions or VERSIONS:
        blender = get_blender(version)
        found = speed_in_background(blender, dist)
        show(found["version"], "background", found)
        if version in ("3.4", "newest"):
            out = blender.out / "refocus_speed"
            seen = session.run(blender, SCRIPT, dist, out, (1280, 900))
            of = [seen[name][len(seen[name]) // 2] for name in ("pauses", "of_blender")]
            speed = seen["speed"]
            show(
                seen["version"], "window", speed, speed["drawn"], *of, seen["ours"][-1]
            )
    print("Load:", *(f"{load:.1f}" for load in os.getloadavg()))


main()
