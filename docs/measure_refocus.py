# SPDX-License-Identifier: Apache-2.0
"""Measures a refocus at 1920 x 1080 in Blender for docs/notebook/blender.md.

    python3 docs/measure_refocus.py DIST [BLENDER ...]

DIST is the folder that `./dev package` makes; BLENDER: 3.4, 4.2, 4.5, 5.0, newest. Needs what
tests/blender needs. The least of ten times, at real-time priority where the system allows
it, so that other programs count for little; in the background, and for 3.4 and the newest with a
window too.
"""

import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/blender"))
import session  # noqa: E402
from conftest import VERSIONS, get_blender  # noqa: E402

SCRIPT = "refocus_speed.py"


def show(version, where, found, more=""):
    row = [f"{1000 * found[key]:.0f} ms" for key in ("whole", "filter", "beside")]
    print("|", version, "|", where, "|", " | ".join(row), "|", more, "|", flush=True)


def main():
    dist, *versions = sys.argv[1:]
    print(
        "| Blender | | from f-stop to composite | filter | beside it | longest pause | of a redraw | of ours |"
    )
    for version in versions or VERSIONS:
        blender = get_blender(version)
        lines = blender.run(SCRIPT, dist, blender.out).splitlines()
        text = next(x for x in lines if x.startswith("SPEED")).removeprefix("SPEED ")
        found = json.loads(text)
        show(found["version"], "background", found)
        if version in ("3.4", "newest"):
            out = blender.out / "refocus_speed"
            seen = session.run(blender, SCRIPT, dist, out, (1280, 900))
            of = [seen[k][len(seen[k]) // 2] for k in ("pauses", "of_blender")]
            of.append(seen["ours"][-1])
            more = " | ".join(f"{1000 * s:.1f} ms" for s in of)
            show(seen["version"], "window", seen["speed"], more)


main()
