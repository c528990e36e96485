# SPDX-License-Identifier: GPL-3.0-or-later
"""What scenes and scripts of others do: see inside/scene_checks.py, inside/handler_checks.py."""

import pytest
from checked import Checked, names_of
from conftest import only_in

pytestmark = only_in("3.4", "5.0", "newest")
CHECKED = Checked("scene_checks.py", "scene_results.json")
HANDLERS = Checked("handler_checks.py", "handler_results.json")


@pytest.mark.parametrize("name", names_of("scene_checks.py"))
def test_check(blender, dist, name):
    """One check in one Blender."""
    CHECKED.expect(blender, dist, name)


@pytest.mark.parametrize("name", names_of("handler_checks.py"))
def test_handlers(blender, dist, name):
    """One check of inside/handler_checks.py in one Blender."""
    HANDLERS.expect(blender, dist, name)
