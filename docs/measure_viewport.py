# SPDX-License-Identifier: Apache-2.0
"""Measures Rack Focus over Blender's 3D view for the table of docs/blender-view3d.md.

    python3 docs/measure_viewport.py DIST [BLENDER ...]

DIST is the folder that `./dev package` makes; BLENDER: 3.4, newest. Needs what tests/blender needs. Frames are drawn at real-time priority where the
system allows it, so that other programs count for little.
"""

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/blender"))
import session  # noqa: E402
from conftest import get_blender  # noqa: E402

KINDS = {
    "SOLID": "Solid",
    "MATERIAL": "Material Preview",
    "RENDERED": "Rendered, Cycles, 1 sample",
}
SIZE = (960, 640)  # of the display


def main():
    dist, *versions = sys.argv[1:]
    for version in versions or ("3.4", "newest"):
        blender = get_blender(version)
        out = blender.out / "viewport_speed"
        found = session.run(blender, "viewport_speed.py", dist, out, SIZE, 3000)
        for kind, name in KINDS.items():
            times = found[kind]
            whole = times["with"]
            steps = ", ".join(
                f"{step} {1000 * s:.0f} ms" for step, s in times["steps"].items()
            )
            width, height = found["size"]
            print(
                f"| {found['version']} | {name} | {width} x {height} | "
                f"{1 / times['without']:.1f} | {1 / whole:.1f} | {steps} |"
            )


main()
