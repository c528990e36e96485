# SPDX-License-Identifier: GPL-3.0-or-later
"""Grease Pencil, under Xvfb: see inside/stroke_checks.py."""

import pytest
from checked import Checked, names_of
from conftest import only_in

pytestmark = only_in("3.4", "4.5", "newest")
CHECKED = Checked("stroke_checks.py", "stroke_results.json", has_display=True)


@pytest.mark.parametrize("name", names_of("stroke_checks.py"))
def test_check(blender, dist, name):
    """One check in one Blender."""
    CHECKED.expect(blender, dist, name)
