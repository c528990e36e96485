# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sees and sets: see inside/artist_checks.py."""

import pytest
from checked import Checked, names_of
from conftest import only_in

pytestmark = only_in("3.4", "newest")
SCRIPT = "artist_checks.py"
CHECKED = Checked(SCRIPT, "artist_results.json")


@pytest.mark.parametrize("name", names_of(SCRIPT))
def test_check(blender, dist, name):
    """One check in one Blender."""
    CHECKED.expect(blender, dist, name)
