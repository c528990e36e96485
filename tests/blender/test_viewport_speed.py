# SPDX-License-Identifier: GPL-3.0-or-later
"""How fast Rack Focus follows a 3D view that turns; run with -s to see the table.

Nothing here asserts a time: docs/blender.md has the figures of one machine.
"""

import pytest
import session
from conftest import get_blender


@pytest.fixture(scope="module", params=("3.4", "newest"))
def found(request, dist):
    """What the session found in one Blender."""
    blender = get_blender(request.param)
    out = blender.out / "viewport_speed"
    return session.run(blender, "viewport_speed.py", dist, out, (960, 640), 1500)


@pytest.mark.parametrize("kind", ("SOLID", "MATERIAL", "RENDERED"))
def test_every_frame_is_filtered(found, kind):
    """And each step of it takes its share."""
    times = found[kind]
    per_frame = times["with"]
    steps = ", ".join(
        f"{k} {100 * s / per_frame:.0f} %" for k, s in times["steps"].items()
    )
    print(
        f"\n{found['version']} {kind} {found['size']}, filtered at "
        f"{found[f'{kind}_size']}: {1 / per_frame:.1f} frames/s with, "
        f"{1 / times['without']:.1f} without; {steps}"
    )
    assert 0 < times["steps"]["filter"] < per_frame
    assert times["without"] > 0
