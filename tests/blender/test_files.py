# SPDX-License-Identifier: GPL-3.0-or-later
"""What files of others hold: see inside/file_checks.py."""

import pytest
from checked import Checked, names_of
from conftest import only_in

pytestmark = only_in("3.4", "5.0", "newest")
CHECKED = Checked("file_checks.py", "file_results.json")


@pytest.mark.parametrize("name", names_of("file_checks.py"))
def test_check(blender, dist, name):
    """One check in one Blender."""
    CHECKED.expect(blender, dist, name)


def test_a_comparison_prints_no_error(blender, dist):
    """Blender 3.4 counts the users of copied scenes wrongly, and says so."""
    _, log = CHECKED.run(blender, dist)
    assert "CHECK a_comparison ok" in log
    assert "lib_id_delete" not in log
