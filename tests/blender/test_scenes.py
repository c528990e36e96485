# SPDX-License-Identifier: GPL-3.0-or-later
"""What scenes of others do: see inside/scene_checks.py."""

import pytest
from checked import Checked, names_of
from conftest import only_in

pytestmark = only_in("3.4", "5.0", "newest")
CHECKED = Checked("scene_checks.py", "scene_results.json")


@pytest.mark.parametrize("name", names_of("scene_checks.py"))
def test_check(blender, dist, name):
    """One check in one Blender."""
    CHECKED.expect(blender, dist, name)
