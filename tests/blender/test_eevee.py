# SPDX-License-Identifier: GPL-3.0-or-later
"""EEVEE as the main engine, under Xvfb: see inside/eevee.py."""

import json

import pytest
from conftest import INSIDE, call, get_blender


@pytest.fixture(scope="module", params=("3.4", "newest"))
def found(request, dist):
    """What inside/eevee.py found in one Blender."""
    blender = get_blender(request.param)
    script = ("-P", INSIDE / "eevee.py", "--", dist, blender.out)
    call(
        "xvfb-run", "-a", "-s", "-screen 0 640x480x24",
        *blender.command("-b", "--factory-startup", *map(str, script)),
        env={**blender.environment(), "LIBGL_ALWAYS_SOFTWARE": "1"},
    )  # fmt: skip
    return json.loads((blender.out / "eevee.json").read_text())


def test_the_node_is_the_filter_on_eevees_passes(found):
    """Bit for bit, and not the picture as rendered."""
    assert found["engine"].startswith("BLENDER_EEVEE") and not found["message"]
    assert found["to_filter"] == 0
    assert found["to_pinhole"] > 0.05


def test_eevees_depth_is_planar_distance(found):
    """The front of the nearest cubes, within the precision of half floats."""
    assert found["nearest"] == pytest.approx(1.5 - 0.07 * 1.5 / 2, rel=1e-3)


def test_eevees_views_are_taken_from_points_of_the_lens(found):
    """But for pixels that an edge just grazes."""
    assert found["n_views"] == 2 and not found["views_message"]
    assert max(found["views_off"]) < 0.01


def test_a_sheared_camera_loses_nothing(found):
    """EEVEE shows nothing in half of such views before 4.2: there is one, and that is said."""
    shares = found["sheared_views"]
    is_said = "shears the camera" in found["sheared_message"]
    assert len(shares) == (1 if is_said else 4) and min(shares) > 0.1, shares
    assert is_said or not found["sheared_message"]
